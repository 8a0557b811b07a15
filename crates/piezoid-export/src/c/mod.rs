//! C99: a header and a source file without heap, libraries, or recursion.
//!
//! All functions except the interface are static. States are structs owned by the caller. Tables are constant. The
//! arithmetic is that of the model, in the same order, so results in double precision without contraction are
//! bit-identical.

mod body;
mod saved;

use super::exported::{Entry, ExportedProgram, state_of};
use super::fixed::{Fixed, PLAIN};
use super::language::{Language, Printer};
use super::template::{Value, blocks, context, render, template, template_context};
use super::{CODE, ExportRequest, ExportTarget, Exported, File, named};
use piezoid::{Error, System};
use piezoid_models::program::{Argument, Block, Constant, Field, FieldValue, Function, Limit, ValueType};
use std::collections::BTreeMap;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "c",
    summary: "a header and a source file in C99, in double or single precision, with a self-test",
    reference: "ISO/IEC 9899:1999; MISRA C:2012",
    takes: &["float", "preview", "controller", "online", "delay_samples", "gain_margin", "phase_margin"],
    make: |request| {
        let whole = checked(request)?;
        let mut notes = whole.notes.clone();
        let rule = format!("C99 guarantees only 31 significant characters in names: use a name of at most {LONGEST}");
        notes.extend((request.name().len() > LONGEST).then_some(rule));
        let c = C::of(&whole, request);
        let bytes = if request.options.float { 4 } else { 8 };
        let tables = whole.program.blocks.iter().flat_map(|b| &b.constants).map(|c| c.values.len());
        let constants = tables.sum::<usize>() * bytes;
        let bytes =
            whole.entries.iter().map(|e| (e.state, whole.program.order(e.state) * bytes)).collect::<BTreeMap<_, _>>();
        let page = context! { bytes, constants, ..c.template_context() };
        let files = c.files(render(template!("c/readme.md.j2"), page)?)?;
        Ok(Exported { files, functions: whole.functions(), notes })
    },
    ..CODE
};

/// The longest name for which function names differ within the characters that C99 guarantees.
const LONGEST: usize = 31 - "_control_restore".len();

/// Reserved names: keywords, and names that would clash with those of the program.
const RESERVED: &str = "auto break case char const continue default do double else enum extern float for goto if \
    inline int long register restrict return short signed sizeof static struct switch typedef union unsigned void \
    volatile while main stdio math";

/// Stands for the checksum of a set of files until all are printed.
const SET: &str = "0xCHECKSUMu";

/// The files with their common checksum, by which the compiler refuses those of two exports.
fn sealed<const N: usize>(files: [String; N]) -> [String; N] {
    let mut sum = crc32fast::Hasher::new();
    files.iter().for_each(|file| sum.update(file.as_bytes()));
    let sum = format!("0x{:08X}u", sum.finalize());
    files.map(|file| file.replace(SET, &sum))
}

/// The exported program, under a name that is free in C.
pub(super) fn checked(request: &ExportRequest) -> Result<ExportedProgram, Error> {
    free(request)?;
    ExportedProgram::new(request)
}

/// Returns an error for a name that is taken in C.
pub(super) fn free(request: &ExportRequest) -> Result<(), Error> {
    named(request.name(), RESERVED)
}

/// The printer.
pub(super) struct C<'c> {
    pub(super) whole: &'c ExportedProgram,
    pub(super) request: &'c ExportRequest<'c>,
    /// The fixed-point formats, if any.
    pub(super) counts: Option<&'c Fixed>,
}

impl<'c> C<'c> {
    pub(super) fn of(whole: &'c ExportedProgram, request: &'c ExportRequest) -> Self {
        C { whole, request, counts: None }
    }

    /// Header, source, self-test and page.
    pub(super) fn files(&self, readme: String) -> Result<Vec<File>, Error> {
        let name = self.request.name();
        let test = render(template!("c/test.c.j2"), self.template_context())?;
        let [header, source, test] = sealed([self.header()?, self.source()?, test]);
        Ok(vec![
            File::new(format!("{name}.h"), header),
            File::new(format!("{name}.c"), source),
            File::new(format!("{name}_test.c"), test),
            File::new(format!("{name}.md"), readme),
        ])
    }

    /// Header and source without a self-test in C.
    pub(super) fn pair(&self) -> Result<[String; 2], Error> {
        Ok(sealed([self.header()?, self.source()?]))
    }

    pub(super) fn template_context(&self) -> Value {
        let all = template_context(self.request, self.whole, &|values| self.numbers(values));
        let counts = self.counts.map_or(context!(), Fixed::template_context);
        let own = context! { number => self.number(), zero => self.real(0.0), largest => self.real(Limit::Most.value(self.request.options.float)), one => self.real(1.0), set => SET, counts => self.counts.is_some(),
        saved => self.saved() };
        context! { ..own, ..counts, ..all }
    }

    /// The header: types and functions of the interface.
    fn header(&self) -> Result<String, Error> {
        let declared = |block: &Block, field: &Field| match (&field.holds, self.held(block, field)) {
            (FieldValue::Number(_), number) => format!("{number} {}", field.name),
            (FieldValue::Numbers(values), number) => format!("{number} {}[{}]", field.name, values.len()),
            (FieldValue::Block(inner), _) => format!("{} {}", self.state(inner), field.name),
        };
        let state = |block: &&Block| {
            let fields: Value = block.fields.iter().map(|field| declared(block, field)).collect();
            context! { about => &block.about, type => self.state(&block.name), fields }
        };
        let states: Value = self.whole.states().iter().map(state).collect();
        let period = self.real(self.request.model.ts());
        render(template!("c/header.h.j2"), context! { period, states, ..self.template_context() })
    }

    /// The source: constants and functions.
    fn source(&self) -> Result<String, Error> {
        let block = |(block, functions): (&Block, Vec<(usize, &Function)>)| {
            let constants: Value = block.constants.iter().map(|c| self.constant_of(block, c)).collect();
            let functions: Value = functions.into_iter().map(|(_, f)| self.function(f)).collect();
            context! { about => &block.about, constants, functions }
        };
        let rest = |e: &Entry| (e.state, self.rest(e.state, "s->", false));
        let context = context! {
            blocks => blocks(&self.whole.program).map(block).collect::<Value>(),
            rest => self.whole.entries.iter().map(rest).collect::<BTreeMap<_, _>>(),
            ..self.template_context()
        };
        Ok(render(template!("c/source.c.j2"), context)?.trim_end().lines().map(broken).collect())
    }

    fn constant_of(&self, block: &Block, c: &Constant) -> Value {
        let values = if c.table { self.numbers(&c.values) } else { self.real(c.values[0]) };
        let name = self.own(&format!("{}_{}", block.name, c.name));
        context! { name, table => c.table, length => c.values.len(), values }
    }

    fn function(&self, function: &Function) -> Value {
        let number = self.number_in(function);
        let outside = self.whole.entries.iter().any(|entry| entry.step == function.name);
        let takes = |p: &Argument| match &p.kind {
            ValueType::Integer => format!("int {}", p.name),
            ValueType::Part(block) => {
                format!("{}{} *{}", if p.changed || outside { "" } else { "const " }, self.state(block), p.name)
            }
            _ => format!("{number} {}", p.name),
        };
        let (program, single) = (&self.whole.program, self.request.options.float);
        let printer = Printer { program, function, language: self, single };
        let mut returns = function.returns.iter().map(|expr| printer.expr(expr));
        let first = returns.next();
        let also: Vec<String> = returns.collect();
        let takes = function.takes.iter().map(takes).chain(also.iter().map(|_| format!("{number} *also")));
        context! {
            name => &function.name, static => !outside, gives => if first.is_some() { number } else { "void" },
            about => if function.about.is_empty() { String::new() } else { comment(&function.about) },
            takes => takes.collect::<Vec<_>>().join(", "), steps => printer.steps(&function.steps, 1),
            also, returns => first.into_iter().collect::<Value>(),
        }
    }

    /// Lines that set the state of a block to rest, or to zero, for fields after `prefix`.
    fn rest(&self, block: &str, prefix: &str, zero: bool) -> Vec<String> {
        let real = |value: f64| self.real(if zero { 0.0 } else { value });
        let line = |field: &Field| match (&field.holds, format!("{prefix}{}", field.name)) {
            (FieldValue::Block(inner), name) => self.rest(inner, &format!("{name}."), zero),
            (FieldValue::Number(value), name) => vec![format!("{name} = {};", real(*value))],
            // Equal values are set in a loop.
            (FieldValue::Numbers(v), name) if zero || v.iter().all(|w| w.to_bits() == v[0].to_bits()) => {
                let set = format!("    {name}[k] = {};", real(v[0]));
                vec![format!("for (int k = 0; k < {}; k++) {{", v.len()), set, "}".into()]
            }
            (FieldValue::Numbers(values), name) => {
                values.iter().enumerate().map(|(k, v)| format!("{name}[{k}] = {};", real(*v))).collect()
            }
        };
        self.whole.program.block(block).map_or(&[][..], |b| &b.fields).iter().flat_map(line).collect()
    }

    fn number(&self) -> &'static str {
        match (self.counts, self.request.options.float) {
            (Some(_), _) => "int32_t",
            (None, true) => "float",
            (None, false) => "double",
        }
    }

    /// The values of a table, in lines.
    fn numbers(&self, values: &[f64]) -> String {
        wrapped(&values.iter().map(|v| self.real(*v)).collect::<Vec<_>>())
    }

    /// The type of local numbers.
    fn number_in(&self, function: &Function) -> &'static str {
        let passes_on = self.counts.is_some() && PLAIN.contains(&function.name.as_str());
        if passes_on { "int64_t" } else { self.number() }
    }

    /// The type of a field.
    fn held(&self, block: &Block, field: &Field) -> &'static str {
        let long = self.counts.is_some_and(|fixed| fixed.is_long(&block.name, &field.name));
        if long { "int64_t" } else { self.number() }
    }

    /// A name with the prefix of the export.
    pub(super) fn own(&self, name: &str) -> String {
        format!("{}_{name}", self.request.name())
    }

    /// The type of the state of a block.
    pub(super) fn state(&self, block: &str) -> String {
        self.own(&state_of(block))
    }
}

fn comment(lines: &[String]) -> String {
    format!("/* {} */\n", lines.join("\n   ").replace("*/", "* /"))
}

/// Numbers in lines of a readable length.
pub(super) fn wrapped(values: &[String]) -> String {
    let mut out = String::new();
    let mut line = String::from("   ");
    for value in values {
        if line.len() + value.len() > 115 {
            out += &format!("{line}\n");
            line = "   ".into();
        }
        line += &format!(" {value},");
    }
    out + &line + "\n"
}

/// Line width.
const WIDE: usize = 120;

/// A line of code, broken before an operator or after a comma if it is too long.
fn broken(line: &str) -> String {
    let indent = line.len() - line.trim_start().len();
    // Continued comments are not indented by a multiple of 4.
    let code = indent.is_multiple_of(4) && !line.trim_start().starts_with(['/', '#']);
    let (mut out, mut left) = (String::new(), line.to_owned());
    while code && left.len() > WIDE {
        let may = |(at, _): &(usize, &str)| {
            let next = left[at + 1..].split(' ').next().unwrap_or_default();
            *at >= indent + 8 && (left[..*at].ends_with(',') || OPERATORS.contains(&next))
        };
        let places = || left.match_indices(' ').filter(may);
        let Some((at, _)) = places().take_while(|(at, _)| *at <= WIDE).last().or_else(|| places().next()) else {
            break;
        };
        out += &format!("{}\n", &left[..at]);
        left = format!("{:1$}{2}", "", indent + 4, &left[at + 1..]);
    }
    format!("{out}{left}\n")
}

/// Operators before which a line may be broken.
const OPERATORS: &[&str] = &["+", "-", "*", "/", "<", "<=", ">", ">=", "==", "!=", "&&", "||", "?", ":"];

/// The shortest text that is parsed as this number.
pub(super) fn shortest(value: f64, single: bool) -> String {
    if single { format!("{:?}", value as f32) } else { format!("{value:?}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_of_code_are_broken_and_comments_are_not() {
        let sum = format!("    x = f({}, {});", "a".repeat(80), "b".repeat(40));
        let [first, second] = [0, 1].map(|n| broken(&sum).lines().nth(n).unwrap().to_owned());
        assert!(first.ends_with("a,") && second == format!("        {});", "b".repeat(40)), "{first}\n{second}");
        let comment = format!("/* {} + {} */", "a".repeat(80), "b".repeat(40));
        assert_eq!(broken(&comment), format!("{comment}\n"));
    }
}
