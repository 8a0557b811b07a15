//! Fixed point: a header and a source file in C99 that count in whole numbers, for cores without a floating-point unit and as what
//! a circuit is checked against.
//!
//! ```text
//! v = n 2^e        n: int32_t, e fixed for every number with a name
//! ```
//! The program is run in double precision along inputs that wander, jump and sweep over everything the model knows and a tenth
//! more; the largest size of each number gives its e ([`formats`]). It is then written anew in counts ([`lower`]), and that is what is
//! printed, run here for the vectors, and held against double precision. What it is off by more than 1e-4 of the stroke is refused.
//!
//! It does not do: Newton's method, so that there is a feed-forward only where the inverse of the hysteresis is closed.

mod formats;
mod lower;

pub(super) use formats::{Formats, PLAIN};

use super::c::{C, checked, comment, wrapped};
use super::readme::opening;
use super::whole::{Entry, Vectors, Whole, wander};
use super::{File, Made, Target, Wanted};
use crate::error::Error;
use crate::number::short;
use crate::program::{Expr, Machine, Program};
use crate::series::ends;
use crate::system::System;
use formats::Key;
use lower::{counts, lowered};

pub(super) const TARGET: Target = Target {
    name: "fixed",
    summary: "a header and a source file in C99 that count in whole numbers, with a self-test and the error",
    reference: "ISO/IEC 9899:1999; ISO/IEC TR 18037",
    make: |wanted| {
        let fixed = Fixed::new(checked(wanted)?, wanted)?;
        let (c, name) = (fixed.c(wanted), wanted.name);
        let files = vec![
            File::text(format!("{name}.h"), c.header(&fixed.whole, wanted)),
            File::text(format!("{name}.c"), c.source(&fixed.whole)),
            File::text(format!("{name}_test.c"), fixed.test(&c)),
            File::text("README.md", fixed.readme(wanted)),
        ];
        Ok(Made { files, notes: fixed.whole.notes })
    },
};

/// The largest error there may be, over the stroke.
const MOST: f64 = 1e-4;

/// What is exported, in counts.
struct Fixed {
    whole: Whole,
    formats: Formats,
    proofs: Vec<Proof>,
}

/// What an entry answers in counts, and how far off that is.
struct Proof {
    vectors: Vectors,
    /// Root of the mean square of the difference to double precision, over the stroke.
    rms: f64,
    /// The largest difference, over the stroke.
    most: f64,
}

impl Fixed {
    fn new(mut whole: Whole, wanted: &Wanted) -> Result<Self, Error> {
        closed_alone(&mut whole);
        loop {
            let fixed = Fixed::of(&whole, wanted)?;
            let off = fixed.proofs.iter().position(|proof| !(proof.most <= MOST));
            let Some(k) = off else { return Ok(fixed) };
            let (name, most) = (whole.entries[k].step, short(fixed.proofs[k].most));
            let because = format!("counts of 32 bits move `{name}` by {most} of its stroke, more than {}", short(MOST));
            if whole.entries[k].step != "ff_step" {
                let because = format!("{because}; take target c, with --float where doubles are slow");
                return Err(Error::Unsuited { what: "export in fixed point".into(), because });
            }
            whole.notes.push(format!("there is no feed-forward: {because}"));
            leave_out(&mut whole, k);
        }
    }

    fn of(whole: &Whole, wanted: &Wanted) -> Result<Self, Error> {
        let journeys = journeys(whole, wanted);
        let mut machines = Vec::new();
        let mut exact = Vec::new();
        for (entry, inputs) in whole.entries.iter().zip(&journeys) {
            let mut machine = Machine::new(&whole.program, entry.state, false).watched();
            let outputs = inputs.iter().map(|row| Ok(machine.call(entry.step, row)?[0]));
            exact.push(outputs.collect::<Result<Vec<f64>, Error>>()?);
            machines.push(machine);
        }
        let mut formats = Formats::of(&whole.program, &machines);
        formats.join(whole, &journeys);
        let mut counted = Whole { program: lowered(&whole.program, &formats)?, ..whole.clone() };
        let mut proofs = Vec::new();
        let vectors = whole.vectors(&Wanted { single: false, ..wanted.clone() })?;
        for (k, entry) in whole.entries.iter().enumerate() {
            let stroke = ends(vectors[k].outputs.iter().copied());
            let stroke = stroke.1 - stroke.0;
            let scales: Vec<i32> = entry.inputs.iter().map(|i| formats.exponent(&outside(entry, i.name))).collect();
            let gives = formats.exponent(&Key::Gives(entry.step.into(), 0));
            let run = |rows: &[Vec<f64>]| {
                let rows = rows.iter().map(|row| row.iter().zip(&scales).map(|(v, e)| counts(*v, *e)).collect());
                let rows: Vec<Vec<f64>> = rows.collect();
                let mut machine = Machine::new(&counted.program, entry.state, false);
                let outputs = rows.iter().map(|row| Ok(machine.call(entry.step, row)?[0]));
                Ok::<_, Error>((outputs.collect::<Result<Vec<f64>, Error>>()?, rows))
            };
            let (there, _) = run(&journeys[k])?;
            let off = there.iter().zip(&exact[k]).map(|(n, v)| (n * 2f64.powi(gives) - v) / stroke);
            let (squares, most) = off.fold((0.0, 0.0f64), |(s, most), e| (s + e * e, most.max(e.abs())));
            let (outputs, inputs) = run(&vectors[k].inputs)?;
            let rms = (squares / exact[k].len() as f64).sqrt();
            proofs.push(Proof { vectors: Vectors { inputs, outputs, ..vectors[k].clone() }, rms, most });
        }
        for entry in &mut counted.entries {
            let worth = |key: &Key, unit: &str| format!("2^{} {unit}", formats.exponent(key));
            for k in 0..entry.inputs.len() {
                entry.inputs[k].unit = worth(&outside(entry, entry.inputs[k].name), &entry.inputs[k].unit);
            }
            entry.output.unit = worth(&Key::Gives(entry.step.into(), 0), &entry.output.unit);
        }
        Ok(Fixed { whole: counted, formats, proofs })
    }

    fn c<'c>(&'c self, wanted: &'c Wanted) -> C<'c> {
        C { counts: Some(&self.formats), ..C::of(&self.whole, wanted) }
    }

    /// A program that runs the vectors and says how many differ.
    fn test(&self, c: &C) -> String {
        let name = c.name;
        let about = [
            format!("Runs {name} on recorded inputs and compares with what piezoid counts."),
            "Ends with status 0 where all are equal, else with 1.".into(),
        ];
        let mut out = comment(&about, "") + &format!("#include \"{name}.h\"\n#include <stdio.h>\n\n");
        let mut main = String::new();
        for (entry, Proof { vectors, .. }) in self.whole.entries.iter().zip(&self.proofs) {
            let (step, n) = (entry.step, vectors.outputs.len());
            let table = |name: &str, values: Vec<f64>| {
                let values: Vec<String> = values.iter().map(|v| (*v as i64).to_string()).collect();
                format!("static const int32_t {step}_{name}[{n}] = {{\n{}}};\n", wrapped(&values))
            };
            for (k, input) in entry.inputs.iter().enumerate() {
                out += &table(input.name, vectors.inputs.iter().map(|row| row[k]).collect());
            }
            out += &table("gives", vectors.outputs.clone());
            let inputs: String = entry.inputs.iter().map(|i| format!(", {step}_{}[k]", i.name)).collect();
            out += &format!(
                "\nstatic int {step}_differs(void)\n{{\n    {} s;\n    int differs = 0;\n    {}(&s);\n    \
                 for (int k = 0; k < {n}; k++) {{\n        if ({}(&s{inputs}) != {step}_gives[k]) {{\n            \
                 differs++;\n        }}\n    }}\n    \
                 printf(\"{name}_{step}: %d of {n} differ\\n\", differs);\n    return differs;\n}}\n\n",
                c.state(entry.state),
                c.own(entry.reset),
                c.own(step),
            );
            main += &format!("    differs += {step}_differs();\n");
        }
        out + &format!("int main(void)\n{{\n    int differs = 0;\n{main}    return (differs == 0) ? 0 : 1;\n}}\n")
    }

    fn readme(&self, wanted: &Wanted) -> String {
        let mut out = opening(wanted, &self.whole, "C99 in fixed point", "int32_t");
        for (entry, proof) in self.whole.entries.iter().zip(&self.proofs) {
            out += &format!("| `{}_{}` | {} | {} |\n", wanted.name, entry.step, short(proof.rms), short(proof.most));
        }
        out
    }
}

/// What is given from outside.
fn outside(entry: &Entry, input: &str) -> Key {
    Key::Local(entry.step.into(), input.into())
}

/// Leaves the closed inverse alone, or the feed-forward out if there is none: Newton's method needs floating point.
fn closed_alone(whole: &mut Whole) {
    let closed = whole.program.function("hysteresis_closed").is_some();
    let inverse = whole.program.functions.iter_mut().find(|f| f.name == "hysteresis_inverse");
    if let (true, Some(inverse)) = (closed, inverse) {
        inverse.steps.truncate(1);
    }
    keep(whole);
    let sought = whole.program.functions.iter().any(|f| f.name.ends_with("_by_trials"));
    if let (true, Some(k)) = (sought, whole.entries.iter().position(|entry| entry.step == "ff_step")) {
        whole.notes.push("there is no feed-forward: the inverse of this model is sought in floating point".into());
        leave_out(whole, k);
    }
}

fn leave_out(whole: &mut Whole, k: usize) {
    whole.entries.remove(k);
    keep(whole);
}

fn keep(whole: &mut Whole) {
    let kept: Vec<&str> = whole.entries.iter().map(|entry| entry.step).chain(["clamp"]).collect();
    whole.program.keep(&kept);
}

/// Samples of each part of a journey.
const PART: usize = 1000;

/// Inputs of each entry over all that the model knows and a tenth more: they wander, jump, and sweep from slow to fast.
fn journeys(whole: &Whole, wanted: &Wanted) -> Vec<Vec<Vec<f64>>> {
    let model = wanted.model;
    let known = model.identified().map(|known| (known.u[0], known.u[1])).or(model.hysteresis().range());
    let (low, high) = known.unwrap_or((-1.0, 1.0));
    let more = 0.05 * (high - low);
    let (slow, quick) = (wander((low - more, high + more), PART), jumping((low - more, high + more), PART));
    let u = [&slow[..], &quick, &sweep((low - more, high + more), PART)].concat();
    let still = model.simulate(&slow);
    let (least, most) = ends(still.iter().copied());
    let r = [&still[..], &jumping((least, most), PART)].concat();
    let inputs = |entry: &Entry| match entry.step {
        "step" => u.iter().map(|u| vec![*u]).collect::<Vec<_>>(),
        "ff_step" => r.iter().map(|r| vec![*r]).collect(),
        _ => r.iter().zip(&u).map(|(r, u)| vec![*r, 1.2 * r, *u]).collect(),
    };
    whole.entries.iter().map(inputs).collect()
}

/// Jumps to anywhere, and to the ends, each kept for up to 16 samples.
fn jumping((low, high): (f64, f64), n: usize) -> Vec<f64> {
    let (mut state, mut level, mut left) = (1u64, low, 0);
    (0..n)
        .map(|_| {
            if left == 0 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let share = (state >> 40) as f64 / (1u64 << 24) as f64;
                level = low + (high - low) * (1.5 * share - 0.25).clamp(0.0, 1.0);
                left = (state >> 20) % 16 + 1;
            }
            left -= 1;
            level
        })
        .collect()
}

/// A sine that goes from standing still to half the sampling rate: sums and products alone, for the same bits on every machine.
fn sweep((low, high): (f64, f64), n: usize) -> Vec<f64> {
    let turned = |(c, s): (f64, f64), (x, y): (f64, f64)| (c * x - s * y, s * x + c * y);
    // Of pi / 1000 more in each sample.
    let faster = (0.9999950652018582, 0.0031415874858795635);
    let (mut turn, mut at) = ((1.0, 0.0), (1.0, 0.0));
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    (0..n)
        .map(|_| {
            turn = turned(faster, turn);
            at = turned(turn, at);
            middle + half * at.1
        })
        .collect()
}

impl Formats {
    /// One format for all that has the unit of the input, and one for all that has that of the output.
    fn join(&mut self, whole: &Whole, journeys: &[Vec<Vec<f64>>]) {
        let mut ports: Vec<(&str, Key, f64)> = Vec::new();
        for (entry, inputs) in whole.entries.iter().zip(journeys) {
            for (k, input) in entry.inputs.iter().enumerate() {
                let most = inputs.iter().fold(0.0, |most: f64, row| most.max(row[k].abs()));
                ports.push((&input.unit, outside(entry, input.name), most));
            }
            let key = Key::Gives(entry.step.into(), 0);
            ports.push((&entry.output.unit, key.clone(), self.most(&key)));
        }
        for (unit, key, _) in &ports {
            let alike = ports.iter().filter(|(other, _, _)| other == unit).map(|(_, _, most)| *most);
            self.raise(key.clone(), alike.fold(0.0, f64::max));
        }
    }

    /// What a count is worth, for the header.
    pub(super) fn scales(&self, guard: &str, whole: &Whole) -> String {
        let mut out = String::new();
        let mut told = Vec::new();
        for entry in &whole.entries {
            let inputs = entry.inputs.iter().map(|i| (i, self.exponent(&outside(entry, i.name))));
            let output = (&entry.output, self.exponent(&Key::Gives(entry.step.into(), 0)));
            for (signal, exponent) in inputs.chain([output]) {
                if !told.contains(&signal.name) {
                    told.push(signal.name);
                    let name = signal.name.to_uppercase();
                    out += &format!("#define {guard}_{name}_BITS {} /* {} = 2^{} counts */\n", -exponent, signal.name, -exponent);
                }
            }
        }
        out + "\n"
    }
}

/// What C has no operators for.
pub(super) fn helpers(name: &str, program: &Program) -> String {
    let mut called: Vec<String> = Vec::new();
    for function in &program.functions {
        function.expressions(&mut |expr| {
            if let Expr::Call(name, _) = expr {
                called.push(name.clone());
            }
        });
    }
    if called.iter().any(|c| c == "product") {
        called.push("shift".into());
    }
    let needed = HELPERS.iter().filter(|(helper, _)| called.iter().any(|c| c == helper));
    needed.map(|(_, text)| text.replace("NAME", name)).collect()
}

const HELPERS: &[(&str, &str)] = &[
    (
        "narrow",
        "/* v in 32 bits, held at the ends. */
static int32_t NAME_narrow(int64_t v)
{
    int64_t held = v;
    if (held > INT32_MAX) {
        held = INT32_MAX;
    }
    if (held < -INT32_MAX) {
        held = -INT32_MAX;
    }
    return (int32_t)held;
}

",
    ),
    (
        "keep",
        "/* v in 52 bits, held at the ends, which leaves room for a sum. */
static int64_t NAME_keep(int64_t v)
{
    const int64_t end = (int64_t)1 << 51;
    int64_t held = v;
    if (held > end) {
        held = end;
    }
    if (held < -end) {
        held = -end;
    }
    return held;
}

",
    ),
    (
        "shift",
        "/* v / 2^n to the nearest, halves away from zero. C99 leaves open what shifts do to negative numbers: none is shifted here. */
static int64_t NAME_shift(int64_t v, int n)
{
    const uint64_t size = (uint64_t)((v < 0) ? -v : v);
    const int64_t nearest = (int64_t)((size + ((uint64_t)1 << (n - 1))) >> n);
    return (v < 0) ? -nearest : nearest;
}

",
    ),
    (
        "product",
        "/* a b / 2^n to the nearest. */
static int64_t NAME_product(int32_t a, int32_t b, int n)
{
    return NAME_shift((int64_t)a * b, n);
}

",
    ),
    (
        "quotient",
        "/* 2^n a / b to the nearest, n < 32, in 32 bits; what is divided by nothing is as far as can be. */
static int32_t NAME_quotient(int32_t a, int32_t b, int n)
{
    const uint64_t size = (uint64_t)((a < 0) ? -(int64_t)a : (int64_t)a) << n;
    const uint64_t by = (uint64_t)((b < 0) ? -(int64_t)b : (int64_t)b);
    uint64_t nearest = (size == 0U) ? 0U : (uint64_t)INT32_MAX;
    if (by > 0U) {
        nearest = (size + (by / 2U)) / by;
        if (nearest > (uint64_t)INT32_MAX) {
            nearest = (uint64_t)INT32_MAX;
        }
    }
    return ((a < 0) == (b < 0)) ? (int32_t)nearest : -(int32_t)nearest;
}

",
    ),
];
