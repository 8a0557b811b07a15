//! Fixed point: a header and a source file in C99 with integer arithmetic, for cores without a floating-point unit, and
//! as a reference for circuits.
//!
//! ```text
//! v = n 2^e        n: int32_t, e fixed for every named number
//! ```
//! The program runs in double precision along inputs that wander, jump and sweep over the input range of the model and
//! a tenth more. The largest absolute value of each number gives its e ([`formats`]). The program is then rewritten
//! with integers ([`lower`]). That program is printed, run for the vectors, and compared with double precision. An
//! error above 1e-4 of the stroke is refused. An inverse without a closed form is found by [`bisection`]; its error is
//! that against the library's own inverse.

mod bisection;
mod excursion;
mod formats;
mod lower;
mod number;

pub(super) use formats::PLAIN;

use super::c::{C, free};
use super::exported::{Entry, ExportedProgram, Port};
use super::template::{Value, context, render, template};
use super::vectors::{Vectors, counted};
use super::{CODE, ExportRequest, ExportTarget, Exported};
use bisection::bisected;
use excursion::{PART, TestInputs, test_inputs};
use formats::{Formats, Key, fields};
use lower::lowered;
use number::{counts, power};
use piezoid::{Error, System};
use piezoid_models::program::{FieldValue, Machine, Program};
use piezoid_numerics::number::short;
use piezoid_numerics::series::ends;
use std::collections::BTreeMap;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "fixed",
    summary: "fixed-point C99: header, source file and self-test, and the rounding error against double precision",
    reference: "ISO/IEC 9899:1999; ISO/IEC TR 18037",
    takes: &["preview", "controller", "delay_samples", "gain_margin", "phase_margin"],
    make: |request| {
        free(request)?;
        let fixed = Fixed::new(ExportedProgram::unguarded(request)?, request)?;
        let c = C { counts: Some(&fixed), ..C::of(&fixed.whole, request) };
        let bytes: BTreeMap<_, _> = fixed.whole.entries.iter().map(|e| (e.state, fixed.bytes(e.state))).collect();
        let page = context! { bytes, every => format!("{} s", request.model.ts()), ..c.template_context() };
        let files = c.files(render(template!("fixed/readme.md.j2"), page)?)?;
        Ok(Exported { files, functions: fixed.whole.functions(), notes: fixed.whole.notes })
    },
    ..CODE
};

/// Largest allowed error, over the stroke.
const MAX_ERROR_SHARE: f64 = 1e-4;

/// Largest number of operations of a test run on real numbers, and largest one with those on integers: a run then takes
/// seconds.
const OPERATIONS: usize = 200_000_000;
const ALL_OPERATIONS: usize = 5 * OPERATIONS;

/// The exported program with integers.
pub(super) struct Fixed {
    whole: ExportedProgram,
    formats: Formats,
    errors: Vec<CountingError>,
}

/// Error of the fixed-point program.
struct CountingError {
    /// Rms difference to double precision, over the stroke.
    rms: f64,
    /// The largest difference, over the stroke.
    most: f64,
}

impl Fixed {
    fn new(mut whole: ExportedProgram, request: &ExportRequest) -> Result<Self, Error> {
        let exact = whole.program.clone();
        bisected(&mut whole.program)?;
        keep(&mut whole, CLAMP);
        loop {
            let (k, because) = match Fixed::of(&whole, &exact, request) {
                Ok(fixed) => match fixed.errors.iter().position(|p| p.rms.is_nan() || p.most > MAX_ERROR_SHARE) {
                    None => return Ok(fixed),
                    Some(k) => {
                        let (step, off) = (whole.entries[k].step, short(fixed.errors[k].most));
                        let changes = format!("32-bit rounding changes the result of `{step}` by {off} of its stroke");
                        (k, format!("{changes}, more than {MAX_ERROR_SHARE:e}"))
                    }
                },
                Err(Error::Unsuited { because, .. }) => {
                    (whole.entries.iter().position(|entry| entry.step == FEED_FORWARD).unwrap_or(0), because)
                }
                Err(error) => return Err(error),
            };
            if whole.entries[k].step != FEED_FORWARD {
                let because = format!("{because}; use the target `c`");
                return Err(Error::Unsuited { what: "export in fixed point".into(), because });
            }
            whole.notes.push(format!("there is no feed-forward: {because}"));
            whole.entries.remove(k);
            keep(&mut whole, CLAMP);
        }
    }

    /// The program with integers, its errors against the program `exact`.
    fn of(whole: &ExportedProgram, exact: &Program, request: &ExportRequest) -> Result<Self, Error> {
        let test_inputs = test_inputs(whole, request);
        let (mut machines, mut outputs) = (Vec::new(), Vec::new());
        for (entry, TestInputs { starts, inputs }) in whole.entries.iter().zip(&test_inputs) {
            let runs = |mut machine: Machine<'_>| {
                let runs = starts.iter().map(|start| run(&mut machine, entry, start, inputs));
                runs.collect::<Result<Vec<_>, _>>()
            };
            outputs.push(runs(Machine::new(exact, entry.state, false))?);
            let mut machine = Machine::new(&whole.program, entry.state, false).watched();
            starts.iter().try_for_each(|start| run(&mut machine, entry, start, inputs).map(drop))?;
            machines.push(machine);
        }
        let mut formats = Formats::of(&whole.program, &machines);
        formats.join(whole, &test_inputs);
        let mut with_counts = ExportedProgram { program: lowered(&whole.program, &formats)?, ..whole.clone() };
        // Integers need no checks for finite numbers, nor what these call.
        keep(&mut with_counts, &[]);
        let mut errors = Vec::new();
        for (k, (TestInputs { starts, inputs }, exact)) in test_inputs.iter().zip(outputs).enumerate() {
            let entry = &whole.entries[k];
            let mut machine = Machine::new(&with_counts.program, entry.state, false);
            let fields = fields(&whole.program, entry.state).into_iter();
            let state: Vec<i32> = fields.map(|(block, field)| formats.exponent(&Key::Field(block, field))).collect();
            let arguments: Vec<i32> = entry.inputs.iter().map(|i| formats.exponent(&outside(entry, i.name))).collect();
            let row =
                |row: &[f64], worth: &[i32]| row.iter().zip(worth).map(|(v, e)| counts(*v, *e)).collect::<Vec<_>>();
            let rows = |rows: &[Vec<f64>]| rows.iter().map(|values| row(values, &arguments)).collect::<Vec<_>>();
            let unit = power(formats.exponent(&gives(entry)));
            // Of two voltages for the same displacement, either is right.
            let judged = |outputs: &[f64]| match entry.step {
                FEED_FORWARD => request.model.simulate(outputs),
                _ => outputs.to_vec(),
            };
            let exact: Vec<Vec<f64>> = exact.iter().map(|outputs| judged(outputs)).collect();
            let (low, high) = ends(exact[0][..PART].iter().copied());
            // With slow models the inputs leave the ends before the outputs arrive there.
            let stroke = (high - low).max(exact[2][0] - exact[1][0]);
            let (mut squares, mut largest, excursion) = (0.0, 0.0f64, rows(inputs));
            for (start, exact) in starts.iter().zip(&exact) {
                let counts = run(&mut machine, entry, &row(start, &state), &excursion)?;
                let outputs: Vec<f64> = counts.iter().map(|n| n * unit).collect();
                for (found, v) in judged(&outputs).iter().zip(exact) {
                    let off = (found - v) / stroke;
                    squares += off * off;
                    largest = largest.max(off.abs());
                }
            }
            let rms = (squares / (exact.len() * inputs.len()) as f64).sqrt();
            let Vectors { mean, most, bound, bounds, .. } =
                counted(&whole.program, entry, &entry.vectors.inputs, false)?;
            let inputs = rows(&entry.vectors.inputs);
            let at_rest = row(&starts[0], &state);
            let outputs = run(&mut machine, entry, &at_rest, &inputs)?;
            with_counts.entries[k].vectors =
                Vectors { inputs, outputs, mean, most, bound, bounds, ..entry.vectors.clone() };
            errors.push(CountingError { rms, most: largest });
        }
        for entry in &mut with_counts.entries {
            let worth = |key: &Key, unit: &str| format!("2^{} {unit}", formats.exponent(key));
            for k in 0..entry.inputs.len() {
                entry.inputs[k].unit = worth(&outside(entry, entry.inputs[k].name), &entry.inputs[k].unit);
            }
            entry.output.unit = worth(&gives(entry), &entry.output.unit);
        }
        Ok(Fixed { whole: with_counts, formats, errors })
    }

    /// True if a field has 64 bits.
    pub(super) fn is_long(&self, block: &str, field: &str) -> bool {
        self.formats.is_long(block, field)
    }

    /// Names of signals, their fractional bits, and the value of a count.
    fn ports(&self) -> Vec<(&'static str, i32, String)> {
        let mut ports = Vec::new();
        for entry in &self.whole.entries {
            let input = |i: &Port| (i.name, -self.formats.exponent(&outside(entry, i.name)), i.unit.clone());
            ports.extend(entry.inputs.iter().map(input));
            ports.push((entry.output.name, -self.formats.exponent(&gives(entry)), entry.output.unit.clone()));
        }
        ports.sort_unstable();
        ports.dedup();
        ports
    }

    /// The template context: the value of a count of each signal, and the errors.
    pub(super) fn template_context(&self) -> Value {
        let error = |(entry, error): (&Entry, &CountingError)| {
            context! { step => entry.step, rms => error.rms, most => error.most }
        };
        let port = |(name, bits, worth): (&'static str, i32, String)| {
            context! { name, bits, worth, end => power(31 - bits) }
        };
        context! {
            errors => self.whole.entries.iter().zip(&self.errors).map(error).collect::<Value>(),
            ports => self.ports().into_iter().map(port).collect::<Value>(), most => format!("{MAX_ERROR_SHARE:e}"),
        }
    }

    /// Bytes of the state of a block.
    fn bytes(&self, block: &str) -> usize {
        let fields = self.whole.program.block(block).map_or(&[][..], |b| &b.fields);
        let size = |field: &str| if self.formats.is_long(block, field) { 8 } else { 4 };
        let held = fields.iter().map(|f| match &f.holds {
            FieldValue::Number(_) => size(&f.name),
            FieldValue::Numbers(values) => size(&f.name) * values.len(),
            FieldValue::Block(inner) => self.bytes(inner),
        });
        held.sum()
    }
}

/// Runs a machine from a state.
///
/// # Errors
/// Returns an error after the sample at which that has taken too many operations.
fn run(machine: &mut Machine, entry: &Entry, start: &[f64], inputs: &[Vec<f64>]) -> Result<Vec<f64>, Error> {
    machine.state().copy_from_slice(start);
    let (before, all_before) = (machine.counts.total(), machine.operations);
    let output = |row: &Vec<f64>| {
        let output = machine.call(entry.step, row)?[0];
        if machine.counts.total() - before > OPERATIONS || machine.operations - all_before > ALL_OPERATIONS {
            let because = format!(
                "`{}` takes more than {OPERATIONS:e} operations for the {} samples on which range and error are computed",
                entry.step,
                inputs.len()
            );
            return Err(Error::Unsuited { what: "export in fixed point".into(), because });
        }
        Ok(output)
    };
    inputs.iter().map(output).collect()
}

/// The output of an entry.
fn gives(entry: &Entry) -> Key {
    Key::Gives(entry.step.into(), 0)
}

/// An input of an entry.
fn outside(entry: &Entry, input: &str) -> Key {
    Key::Local(entry.step.into(), input.into())
}

const FEED_FORWARD: &str = "ff_step";

/// The program with integers calls it.
const CLAMP: &[&str] = &["clamp"];

/// Keeps what the entries call, and these functions.
fn keep(whole: &mut ExportedProgram, more: &[&'static str]) {
    let kept: Vec<&str> = whole.entries.iter().map(|entry| entry.step).chain(more.iter().copied()).collect();
    whole.program.keep(&kept);
}

impl Formats {
    /// Gives one format to all signals with the unit of the input, and one to all with that of the output.
    fn join(&mut self, whole: &ExportedProgram, test_inputs: &[TestInputs]) {
        let mut ports: Vec<(&str, Key, f64)> = Vec::new();
        for (entry, TestInputs { inputs, .. }) in whole.entries.iter().zip(test_inputs) {
            for (k, input) in entry.inputs.iter().enumerate() {
                let most = inputs.iter().fold(0.0, |most: f64, row| most.max(row[k].abs()));
                ports.push((&input.unit, outside(entry, input.name), most));
            }
            let key = gives(entry);
            ports.push((&entry.output.unit, key.clone(), self.most(&key)));
        }
        for (unit, key, _) in &ports {
            let alike = ports.iter().filter(|(other, _, _)| other == unit).map(|(_, _, most)| *most);
            self.raise(key.clone(), alike.fold(0.0, f64::max));
        }
    }
}
