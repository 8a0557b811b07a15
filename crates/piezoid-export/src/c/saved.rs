//! States that are planned, saved and restored in C.
//!
//! A saved state is an array of numbers: two halves of a checksum of the exported program, exact in every precision,
//! then the numbers of the state in the order of its struct. `NAME_restore` takes only an array of this length, with
//! this checksum, of finite numbers (in fixed-point: of numbers that the fields can hold). It is no protection against
//! damaged memory: that needs a checksum of the array itself.

use super::C;
use crate::exported::Entry;
use crate::language::Language;
use crate::template::{Value, context};
use piezoid_models::program::{Block, FieldValue};

/// Numbers before those of the state.
const CHECKSUM_NUMBERS: usize = 2;

/// The numbers of one field of a state.
struct Part {
    /// Path of the field, in C notation.
    path: String,
    /// Position of its first number in the array.
    first: usize,
    /// The length of an array; `None` for a number.
    length: Option<usize>,
    /// Type of the field.
    held: &'static str,
}

impl C<'_> {
    /// The template context of the saved states, one for each entry.
    pub(super) fn saved(&self) -> Value {
        let number = if self.counts.is_some() { "int64_t" } else { self.number() };
        let states = self.whole.entries.iter().map(|entry| {
            let (mut parts, mut n) = (Vec::new(), CHECKSUM_NUMBERS);
            self.parts(entry.state, "", &mut n, &mut parts);
            let part = |part: Part| {
                let Part { path, first, length, held } = part;
                context! { path, first, length, held, long => held == "int64_t" }
            };
            let checksum = self.checksum(entry);
            let halves = [checksum >> 16, checksum & 0xFFFF].map(|half| self.real(f64::from(half)));
            (entry.step, context! { length => n, halves, parts => parts.into_iter().map(part).collect::<Value>() })
        });
        context! { number, states => states.collect::<std::collections::BTreeMap<_, _>>() }
    }

    /// Adds the parts of the state of a block, whose numbers begin at `n`.
    fn parts(&self, block: &str, prefix: &str, n: &mut usize, parts: &mut Vec<Part>) {
        let Some(block) = self.whole.program.block(block) else { return };
        for field in &block.fields {
            let (path, held) = (format!("{prefix}{}", field.name), self.held(block, field));
            let length = match &field.holds {
                FieldValue::Number(_) => None,
                FieldValue::Numbers(values) => Some(values.len()),
                FieldValue::Block(inner) => {
                    self.parts(inner, &format!("{path}."), n, parts);
                    continue;
                }
            };
            parts.push(Part { path, first: *n, length, held });
            *n += length.unwrap_or(1);
        }
    }

    /// A checksum of all that an entry computes with: functions, constants, precision, value of a count.
    fn checksum(&self, entry: &Entry) -> u32 {
        let mut program = self.whole.program.clone();
        program.keep(&[entry.step]);
        let constants: Vec<_> = program.blocks.iter().filter(|b| !b.constants.is_empty()).map(Block::clone).collect();
        let ports: Vec<&str> = entry.inputs.iter().chain([&entry.output]).map(|port| &*port.unit).collect();
        let text = format!("{} {} {ports:?} {:?} {constants:?}", entry.state, self.number(), program.functions);
        crc32fast::hash(text.as_bytes())
    }
}
