//! Rust: a module for any crate, also without `std`.
//!
//! States are plain structs with `new`, `reset` and `step`; nothing is allocated, nothing unsafe, nothing of `std` or `libm` is called.
//! Tables are arrays of known length and counted off within them, so that no index can fail. The module has its vectors as tests.
//! Lines that `rustfmt` would break are left as they are and say so.

mod inside;

use super::c::{shortest, titled, wrapped};
use super::language::Words;
use super::readme::{moved, opening};
use super::vectors::SAMPLES;
use super::whole::{Entry, Whole};
use super::{CODE, File, Made, Target, Wanted, named};
use inside::Inside;
use piezoid::error::Error;
use piezoid::program::{Block, Constant, Field, Function, Holds, Kind, Step};
use piezoid::system::System;

pub(super) const TARGET: Target = Target {
    name: "rust",
    summary: "a module in Rust for crates with and without std, in double or single precision, with its tests",
    reference: "The Rust Reference, editions 2021 and 2024; core alone",
    heeds: CODE,
    make: |wanted| {
        named(wanted.name, RESERVED)?;
        if wanted.name.chars().any(|c| c.is_ascii_uppercase()) {
            let name = format!("`{}`", wanted.name);
            return Err(Error::parameter("name", name, "must be in lower case for Rust: it is that of a module"));
        }
        let whole = Whole::new(wanted)?;
        let rust = Rust { whole: &whole, single: wanted.single };
        let files = vec![
            File::text(format!("{}.rs", wanted.name), rust.module(wanted)),
            File::text(format!("{}.md", wanted.name), page(wanted, &whole)),
        ];
        Ok(Made { files, notes: whole.notes })
    },
};

/// What may not be a name: the words of the language, and crates that are always there.
#[rustfmt::skip]
const RESERVED: &[&str] = &[
    "abstract", "alloc", "as", "async", "await", "become", "box", "break", "const", "continue", "core", "crate", "do",
    "dyn", "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop", "macro",
    "match", "mod", "move", "mut", "override", "priv", "proc_macro", "pub", "ref", "return", "self", "static", "std",
    "struct", "super", "test", "trait", "true", "try", "type", "typeof", "union", "unsafe", "unsized", "use",
    "virtual", "where", "while", "yield",
];

/// What lints would have otherwise, and why it is not.
const ALLOWED: &str = "\
// Who uses the model need not use all of it; what a branch may leave as it is has a value first.
#![allow(dead_code, unused_assignments)]
// Loops, choices and functions are those of the other languages.
#![allow(clippy::needless_range_loop, clippy::manual_memcpy)]
#![allow(clippy::manual_range_contains, clippy::collapsible_if)]
#![allow(clippy::let_and_return, clippy::too_many_arguments)]
// A number may come near a famous one by chance.
#![allow(clippy::approx_constant)]
";

/// As wide as `rustfmt` has lines, and what stands between brackets.
const WIDE: usize = 100;
const BETWEEN: usize = 60;
/// And what of a struct it keeps in a line.
const FIELDS: usize = 18;

/// The language.
struct Rust<'r> {
    whole: &'r Whole,
    single: bool,
}

impl Rust<'_> {
    /// The file.
    fn module(&self, wanted: &Wanted) -> String {
        let (name, ts) = (wanted.name, wanted.model.ts());
        let mut about = vec![
            format!("{name}: a piezo actuator and what drives it, as identified by piezoid."),
            String::new(),
            format!("One call of `step` is one sample of {} s.", shortest(ts, false)),
        ];
        about.extend(self.whole.notes.iter().map(|note| format!("{}.", titled(note.trim_end_matches('.')))));
        let mut out = said(&about, "//!");
        out += "\n#![forbid(unsafe_code)]\n";
        out += ALLOWED;
        out += &format!(
            "\n/// Sampling period, in s.\npub const TS: {} = {};\n",
            self.number(),
            shortest(ts, self.single)
        );
        for entry in &self.whole.entries {
            out += "\n";
            out += &self.entry(entry);
        }
        let (program, states) = (&self.whole.program, self.whole.states());
        for (number, block) in program.blocks.iter().enumerate() {
            let within = states.contains(&block) && self.whole.entries.iter().all(|entry| entry.state != block.name);
            let state = within.then(|| self.state(block));
            let constants = self.constants(block);
            let inside = |f: &&Function| f.block == number && self.stepped(&f.name).is_none();
            let functions = program.functions.iter().filter(inside).map(|f| self.function(f, "fn", ""));
            let parts: Vec<String> = state.into_iter().chain(constants).chain(functions).collect();
            if !parts.is_empty() {
                out += &format!("\n// {}\n\n{}", titled(&block.about), parts.join("\n"));
            }
        }
        out + &self.converted() + &self.tests()
    }

    /// The state of an entry and what it does.
    fn entry(&self, entry: &Entry) -> String {
        let (Some(block), Some(step)) =
            (self.whole.program.block(entry.state), self.whole.program.function(entry.step))
        else {
            return String::new();
        };
        let name = type_of(&block.name);
        let given = entry.inputs.iter().map(|i| format!("`{}`: {}, in {}.", i.name, i.about, i.unit));
        let gives = format!("Returns `{}`: {}, in {}.", entry.output.name, entry.output.about, entry.output.unit);
        let about: Vec<String> = [format!("One sample of {}.", entry.about), String::new()]
            .into_iter()
            .chain([given.chain([gives]).collect::<Vec<_>>().join(" ")])
            .collect();
        let mut own = format!(
            "    /// At rest.\n    pub const fn new() -> Self {{\n        {}\n    }}\n\n    \
             /// Begins anew: all that went before is forgotten.\n    pub fn reset(&mut self) {{\n        *self = Self::new();\n    }}\n\n",
            self.literal(block, false, 2)
        );
        let step = Function { about, name: "step".into(), ..step.clone() };
        own += &self.function(&step, "pub fn", "    ");
        let held =
            if self.zeroed(&block.name) { format!("\n{}", self.rest(block, true, "    ")) } else { String::new() };
        format!(
            "{}\nimpl {name} {{\n{own}{held}}}\n\nimpl Default for {name} {{\n    fn default() -> Self {{\n        Self::new()\n    }}\n}}\n",
            self.shape(block),
        )
    }

    /// The entry whose step this function is.
    fn stepped(&self, function: &str) -> Option<&Entry> {
        self.whole.entries.iter().find(|entry| entry.step == function)
    }

    /// A struct.
    fn shape(&self, block: &Block) -> String {
        let number = self.number();
        let field = |field: &Field| match &field.holds {
            Holds::Number(_) => format!("    pub {}: {number},\n", field.name),
            Holds::Numbers(values) => format!("    pub {}: [{number}; {}],\n", field.name, values.len()),
            Holds::Block(inner) => format!("    pub {}: {},\n", field.name, type_of(inner)),
        };
        let fields: String = block.fields.iter().map(field).collect();
        let about = said(&[format!("State of {}.", block.about)], "///");
        format!("{about}#[derive(Debug, Clone, Copy, PartialEq)]\npub struct {} {{\n{fields}}}\n", type_of(&block.name))
    }

    /// A struct within another, with what it is at rest.
    fn state(&self, block: &Block) -> String {
        let zero =
            if self.zeroed(&block.name) { format!("\n{}", self.rest(block, true, "    ")) } else { String::new() };
        let rest = self.rest(block, false, "    ");
        format!("{}\nimpl {} {{\n{rest}{zero}}}\n", self.shape(block), type_of(&block.name))
    }

    /// A state at rest, or zeros, as a constant of its struct.
    fn rest(&self, block: &Block, zero: bool, indent: &str) -> String {
        let (name, about) = if zero { ("ZERO", "Zeros") } else { ("REST", "At rest") };
        let value = format!("{indent}const {name}: Self = {};\n", self.literal(block, zero, 1));
        format!("{indent}/// {about}.\n{}", left(&value, indent))
    }

    /// A state at rest, or zeros, `depth` levels deep.
    fn literal(&self, block: &Block, zero: bool, depth: usize) -> String {
        let value = |v: &f64| shortest(if zero { 0.0 } else { *v }, self.single);
        let field = |field: &Field| {
            let value = match &field.holds {
                Holds::Number(v) => value(v),
                Holds::Numbers(values) if zero || values.iter().all(|v| v.to_bits() == values[0].to_bits()) => {
                    format!("[{}; {}]", value(&values[0]), values.len())
                }
                Holds::Numbers(values) => format!("[{}]", values.iter().map(value).collect::<Vec<_>>().join(", ")),
                Holds::Block(inner) => format!("{}::{}", type_of(inner), if zero { "ZERO" } else { "REST" }),
            };
            format!("{}: {value}", field.name)
        };
        let fields: Vec<String> = block.fields.iter().map(field).collect();
        if fields.join(", ").len() <= FIELDS {
            return format!("Self {{ {} }}", fields.join(", "));
        }
        let indent = "    ".repeat(depth);
        let lines: String = fields.iter().map(|field| format!("{indent}    {field},\n")).collect();
        format!("Self {{\n{lines}{indent}}}")
    }

    /// Whether a state of this block begins as zeros somewhere.
    fn zeroed(&self, block: &str) -> bool {
        let program = &self.whole.program;
        let mut zeroed = false;
        for function in &program.functions {
            let mut look =
                |step: &Step| zeroed |= matches!(step, Step::Copy { block: of, zero: true, .. } if of == block);
            function.steps.iter().for_each(|step| step.all(&mut look));
        }
        let outer = |b: &&Block| b.fields.iter().any(|f| f.holds == Holds::Block(block.into()));
        zeroed || program.blocks.iter().filter(outer).any(|b| self.zeroed(&b.name))
    }

    /// The constants of a block.
    fn constants(&self, block: &Block) -> Option<String> {
        let line = |c: &Constant| {
            let values: Vec<String> = c.values.iter().map(|v| shortest(*v, self.single)).collect();
            match c.table {
                false => format!("const {}: {} = {};\n", constant_of(block, &c.name), self.number(), values[0]),
                true => self.table(&constant_of(block, &c.name), &values, ""),
            }
        };
        let lines: String = block.constants.iter().map(line).collect();
        (!lines.is_empty()).then_some(lines)
    }

    fn table(&self, name: &str, values: &[String], indent: &str) -> String {
        let begin = format!("{indent}const {name}: [{}; {}] = [", self.number(), values.len());
        let line = format!("{begin}{}];\n", values.join(", "));
        if !broken(&line) {
            return line;
        }
        let lines: String = wrapped(values).lines().map(|line| format!("{indent}{line}\n")).collect();
        format!("{indent}#[rustfmt::skip]\n{begin}\n{lines}{indent}];\n")
    }

    /// A function, or the step of an entry.
    fn function(&self, function: &Function, begin: &str, indent: &str) -> String {
        let number = self.number();
        let inside = Inside { rust: self, function, own: !indent.is_empty() };
        let takes = function.takes.iter().enumerate().map(|(k, p)| match &p.kind {
            Kind::Part(_) if k == 0 && inside.own => "&mut self".into(),
            Kind::Part(block) => {
                format!("{}: &{}{}", inside.local(&p.name), if p.changed { "mut " } else { "" }, type_of(block))
            }
            Kind::Whole => format!("{}: usize", inside.local(&p.name)),
            _ => format!("{}: {number}", inside.local(&p.name)),
        });
        let gives = match function.returns.len() {
            0 => String::new(),
            1 => format!(" -> {number}"),
            n => format!(" -> ({})", vec![number; n].join(", ")),
        };
        let words = Words { program: &self.whole.program, function, language: &inside };
        let depth = 1 + usize::from(inside.own);
        let takes: Vec<String> = takes.collect();
        let mut out = format!("{indent}{begin} {}({}){gives} {{\n", function.name, takes.join(", "));
        out += &words.steps(&function.steps, depth);
        let returns: Vec<String> = function.returns.iter().map(|expr| words.expr(expr)).collect();
        out += &match &returns[..] {
            [] => String::new(),
            [one] => format!("{}{one}\n", "    ".repeat(depth)),
            more => format!("{}({})\n", "    ".repeat(depth), more.join(", ")),
        };
        let about: String = said(&function.about, "///").lines().map(|line| format!("{indent}{line}\n")).collect();
        about + &left(&format!("{out}{indent}}}\n"), indent)
    }

    /// From one kind of number to the other, where that is done.
    fn converted(&self) -> String {
        let (number, mut names) = (self.number(), Vec::new());
        for function in &self.whole.program.functions {
            function.calls(&mut |name| names.push(name.to_owned()));
        }
        let has = |name: &str| names.iter().any(|known| known == name);
        let real = format!("\n/// n as a real number.\nfn real(n: usize) -> {number} {{\n    n as {number}\n}}\n");
        let whole = format!(
            "\n/// v towards zero; 0 of what is no number.\nfn whole(v: {number}) -> usize {{\n    v as usize\n}}\n"
        );
        match (has("real"), has("whole")) {
            (false, false) => String::new(),
            (a, b) => format!("\n// Numbers\n{}{}", if a { &real } else { "" }, if b { &whole } else { "" }),
        }
    }

    /// What proves it.
    fn tests(&self) -> String {
        let mut out = "\n#[cfg(test)]\nmod tests {\n    use super::*;\n".to_owned();
        for entry in &self.whole.entries {
            let vectors = &entry.vectors;
            let (step, n, state) = (entry.step, vectors.outputs.len(), type_of(entry.state));
            let values = |values: &mut dyn Iterator<Item = f64>| -> Vec<String> {
                values.map(|v| shortest(v, self.single)).collect()
            };
            let table = |name: &str, values: Vec<String>| {
                self.table(&format!("{}_{}", step.to_uppercase(), name.to_uppercase()), &values, "    ")
            };
            for (k, input) in entry.inputs.iter().enumerate() {
                out += &format!("\n{}", table(input.name, values(&mut vectors.inputs.iter().map(|row| row[k]))));
            }
            out += &format!("\n{}", table("gives", values(&mut vectors.outputs.iter().copied())));
            let upper = step.to_uppercase();
            let inputs: Vec<String> =
                entry.inputs.iter().map(|i| format!("{upper}_{}[k]", i.name.to_uppercase())).collect();
            out += &format!(
                "\n    #[test]\n    fn {step}_gives_what_piezoid_computes_bit_by_bit() {{\n        let mut state = {state}::new();\n        \
                 for k in 0..{n} {{\n            let {y} = state.step({inputs});\n            \
                 assert_eq!({y}.to_bits(), {upper}_GIVES[k].to_bits(), \"sample {{k}}: {{{y}}}\");\n        }}\n        \
                 state.reset();\n        assert_eq!(state, {state}::default());\n    }}\n",
                y = entry.output.name,
                inputs = inputs.join(", "),
            );
        }
        out + "}\n"
    }

    fn number(&self) -> &'static str {
        if self.single { "f32" } else { "f64" }
    }
}

/// The struct of the state of a block.
fn type_of(block: &str) -> String {
    let words = block.strip_suffix("state").unwrap_or(block);
    words.split('_').map(titled).chain(["State".into()]).collect()
}

/// A constant of a block.
fn constant_of(block: &Block, name: &str) -> String {
    format!("{}_{name}", block.name).to_uppercase()
}

/// The page that goes with it.
fn page(wanted: &Wanted, whole: &Whole) -> String {
    let name = wanted.name;
    let number = if wanted.single { "f32" } else { "f64" };
    let mut out = opening(wanted, whole, "a module in Rust", number);
    out += &format!("## Use\n\nPut `{name}.rs` beside `main.rs` or `lib.rs`.\n\n```rust\nmod {name};\n\n");
    for entry in &whole.entries {
        let own = entry.called();
        let inputs: Vec<&str> = entry.inputs.iter().map(|i| i.name).collect();
        out += &format!("let mut {own} = {name}::{}::new();\n", type_of(entry.state));
        let (output, given) = (entry.output.name, inputs.join(", "));
        out += &format!("let {output} = {own}.step({given}); // every TS seconds: {}\n", entry.about);
    }
    out += "```\n\nNo `std`, no allocation, no `unsafe`, no crate: `core` alone, and no function of it but conversions. States are plain data: \
            copy one to try a step, compare two, keep one for later. Indices are written to stay within their tables for every input. \
            Inputs have to be finite numbers; the feed-forward takes one that is not for the one before. Editions 2018 to 2024.\n\n";
    out += "## Proof\n\n";
    out += &format!("```sh\nrustc --edition 2021 --test {name}.rs -o {name}_test && ./{name}_test\n```\n\n");
    out += &format!(
        "`cargo test` runs the same, as tests of your crate: {SAMPLES} samples of each state against what piezoid computes, bit by bit. "
    );
    out += &moved(wanted, whole, |entry| format!("{}::step", type_of(entry.state)));
    out += "Rust contracts no products and sums, so that bits are the same on every machine with IEEE 754 arithmetic, optimised or not.\n\n";
    out + "Warnings of `rustc` and `clippy` are denied where it was tried, and `rustfmt` leaves it as it is.\n"
}

/// Lines of documentation.
fn said(lines: &[String], mark: &str) -> String {
    lines.iter().map(|line| format!("{}\n", format!("{mark} {line}").trim_end())).collect()
}

/// An item, with word that it is to be left as it is if `rustfmt` would not.
fn left(item: &str, indent: &str) -> String {
    if item.lines().any(broken) { format!("{indent}#[rustfmt::skip]\n{item}") } else { item.into() }
}

/// Whether `rustfmt` would break this line.
fn broken(line: &str) -> bool {
    let code = line.trim();
    if code.starts_with("//") {
        return false;
    }
    let letters: Vec<char> = code.chars().collect();
    let (mut open, mut wide) = (Vec::new(), line.trim_end().chars().count() > WIDE);
    for (k, letter) in letters.iter().enumerate() {
        match letter {
            '(' | '[' => open.push(k),
            ')' | ']' => {
                let from = open.pop().unwrap_or(k);
                let called = from > 0 && (letters[from - 1].is_alphanumeric() || letters[from - 1] == '_');
                // Of the brackets that begin and end a line, a tuple is between.
                let tuple = from == 0 && k + 1 == letters.len();
                let counts = *letter == ']' || tuple || called && !code.contains("fn ");
                wide |= counts && k - from > BETWEEN + 1;
            }
            _ => {}
        }
    }
    wide
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_rustfmt_would_break_are_known() {
        let long = "a".repeat(61);
        assert!(!broken("    let y = f(a, b);") && !broken(&format!("// {long} {long}")));
        assert!(broken(&format!("    let y = f({long});")) && broken(&format!("    let y = {long} + {long};")));
        assert!(!broken(&format!("    let y = 2.0 * ({long});")));
    }

    #[test]
    fn types_are_called_after_blocks() {
        assert_eq!(
            [type_of("state"), type_of("ff_state"), type_of("hysteresis")],
            ["State", "FfState", "HysteresisState"]
        );
    }
}
