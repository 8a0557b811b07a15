//! Rust: a module for any crate, also without `std`.
//!
//! States are plain structs with `new`, `reset` and `step`. Nothing is allocated, nothing is unsafe, and nothing of
//! `std` or `libm` is called. Tables are arrays of known length with loops within it, so that no index can fail. The
//! test vectors are tests of the module. Lines that `rustfmt` would break are marked to be skipped.

mod body;

use super::c::{shortest, wrapped};
use super::exported::{Entry, ExportedProgram};
use super::language::Printer;
use super::template::{Value, context, render, template, template_context, titled};
use super::{CODE, ExportRequest, ExportTarget, Exported, File, named};
use body::RustBody;
use piezoid::{Error, System};
use piezoid_models::program::{Block, Constant, Field, FieldValue, Function, Statement, ValueType};
use std::collections::BTreeMap;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "rust",
    summary: "a module in Rust for crates with and without std, in double or single precision, with its tests",
    reference: "The Rust Reference, editions 2021 and 2024; core alone",
    make: |request| {
        named(request.name(), RESERVED)?;
        if request.name().chars().any(|c| c.is_ascii_uppercase()) {
            let rule = "must be in lower case, because it becomes the name of a Rust module";
            return Err(Error::parameter("name", format!("`{}`", request.name()), rule));
        }
        let whole = ExportedProgram::new(request)?;
        let page = Rust { whole: &whole, single: request.options.float }.template_context(request);
        let files = vec![
            File::new(format!("{}.rs", request.name()), render(template!("rust/module.rs.j2"), page.clone())?),
            File::new(format!("{}.md", request.name()), render(template!("rust/readme.md.j2"), page)?),
        ];
        Ok(Exported { files, functions: whole.functions(), notes: whole.notes })
    },
    ..CODE
};

/// Reserved names: keywords, and crates that are always present.
const RESERVED: &str = "abstract alloc as async await become box break const continue core crate do dyn else enum \
    extern false final fn for gen if impl in let loop macro match mod move mut override priv proc_macro pub ref return \
    self static std struct super test trait true try type typeof union unsafe unsized use virtual where while yield";

/// Line width of `rustfmt`, and its width of arguments.
const WIDE: usize = 100;
const BETWEEN: usize = 60;
/// Its width of a struct literal in one line.
const FIELDS: usize = 18;

/// The printer.
struct Rust<'r> {
    whole: &'r ExportedProgram,
    single: bool,
}

impl Rust<'_> {
    fn template_context(&self, request: &ExportRequest) -> Value {
        let (program, entries) = (&self.whole.program, &self.whole.entries);
        let held = self.whole.states();
        let within = |b: &&Block| held.contains(b) && entries.iter().all(|entry| entry.state != b.name);
        let block = |(number, block): (usize, &Block)| {
            let inside = |f: &&Function| f.block == number && self.stepped(&f.name).is_none();
            let functions = program.functions.iter().filter(inside).map(|f| self.function(f, "fn", ""));
            let parts: Vec<String> = self.constants(block).into_iter().chain(functions).collect();
            let state = Some(block).filter(within).map(|block| self.state(block));
            let empty = state.is_none() && parts.is_empty();
            (!empty).then(|| context! { about => &block.about, state, parts })
        };
        let state = |e: &Entry| Some((e.state, self.state(program.block(e.state)?)));
        let step = |e: &Entry| {
            let step = Function { about: Vec::new(), name: "step".into(), ..program.function(e.step)?.clone() };
            Some((e.step, self.function(&step, "pub fn", "    ")))
        };
        let own = context! {
            number => self.number(), period => shortest(request.model.ts(), self.single),
            states => entries.iter().filter_map(state).collect::<BTreeMap<_, _>>(),
            steps => entries.iter().filter_map(step).collect::<BTreeMap<_, _>>(),
            blocks => program.blocks.iter().enumerate().filter_map(block).collect::<Value>(),
        };
        let table = |values: &[f64]| wrapped(&values.iter().map(|v| shortest(*v, self.single)).collect::<Vec<_>>());
        let table = |values: &[f64]| table(values).lines().map(|line| format!("    {line}\n")).collect();
        context! { ..own, ..template_context(request, self.whole, &table) }
    }

    /// The entry whose step this function is.
    fn stepped(&self, function: &str) -> Option<&Entry> {
        self.whole.entries.iter().find(|entry| entry.step == function)
    }

    /// A struct and its values at rest.
    fn state(&self, block: &Block) -> Value {
        let number = self.number();
        let field = |field: &Field| match &field.holds {
            FieldValue::Number(_) => format!("{}: {number}", field.name),
            FieldValue::Numbers(values) => format!("{}: [{number}; {}]", field.name, values.len()),
            FieldValue::Block(inner) => format!("{}: {}", field.name, type_of(inner)),
        };
        context! {
            type => type_of(&block.name), about => &block.about, at_rest => self.literal(block, false, 2),
            fields => block.fields.iter().map(field).collect::<Value>(), rest => self.rest(block, false),
            zero => self.zeroed(&block.name).then(|| self.rest(block, true)),
        }
    }

    /// The constant `REST` or `ZERO` of a struct.
    fn rest(&self, block: &Block, zero: bool) -> String {
        let (name, about) = if zero { ("ZERO", "Zeros") } else { ("REST", "At rest") };
        let value = format!("    const {name}: Self = {};\n", self.literal(block, zero, 1));
        format!("    /// {about}.\n{}", left(&value, "    "))
    }

    /// A struct literal at rest or of zeros, indented by `depth` levels.
    fn literal(&self, block: &Block, zero: bool, depth: usize) -> String {
        let value = |v: &f64| shortest(if zero { 0.0 } else { *v }, self.single);
        let field = |field: &Field| {
            let value = match &field.holds {
                FieldValue::Number(v) => value(v),
                FieldValue::Numbers(values) if zero || values.iter().all(|v| v.to_bits() == values[0].to_bits()) => {
                    format!("[{}; {}]", value(&values[0]), values.len())
                }
                FieldValue::Numbers(values) => format!("[{}]", values.iter().map(value).collect::<Vec<_>>().join(", ")),
                FieldValue::Block(inner) => format!("{}::{}", type_of(inner), if zero { "ZERO" } else { "REST" }),
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

    /// True if a state of this block is ever initialised with zeros.
    fn zeroed(&self, block: &str) -> bool {
        let program = &self.whole.program;
        let mut zeroed = false;
        for function in &program.functions {
            let mut look = |step: &Statement| {
                zeroed |= matches!(step, Statement::Copy { block: of, zero: true, .. } if of == block)
            };
            function.steps.iter().for_each(|step| step.all(&mut look));
        }
        let outer = |b: &&Block| b.fields.iter().any(|f| f.holds == FieldValue::Block(block.into()));
        zeroed || program.blocks.iter().filter(outer).any(|b| self.zeroed(&b.name))
    }

    fn constants(&self, block: &Block) -> Option<String> {
        let line = |c: &Constant| {
            let values: Vec<String> = c.values.iter().map(|v| shortest(*v, self.single)).collect();
            match c.table {
                false => format!("const {}: {} = {};\n", constant_of(block, &c.name), self.number(), values[0]),
                true => self.table(&constant_of(block, &c.name), &values),
            }
        };
        let lines: String = block.constants.iter().map(line).collect();
        (!lines.is_empty()).then_some(lines)
    }

    fn table(&self, name: &str, values: &[String]) -> String {
        let begin = format!("const {name}: [{}; {}] = [", self.number(), values.len());
        let line = format!("{begin}{}];\n", values.join(", "));
        if broken(&line) { format!("#[rustfmt::skip]\n{begin}\n{}];\n", wrapped(values)) } else { line }
    }

    /// A function, or the step of an entry.
    fn function(&self, function: &Function, begin: &str, indent: &str) -> String {
        let number = self.number();
        let inside = RustBody { rust: self, function, own: !indent.is_empty() };
        let takes = function.takes.iter().enumerate().map(|(k, p)| match &p.kind {
            ValueType::Part(_) if k == 0 && inside.own => "&mut self".into(),
            ValueType::Part(block) => {
                format!("{}: &{}{}", inside.local(&p.name), if p.changed { "mut " } else { "" }, type_of(block))
            }
            ValueType::Integer => format!("{}: usize", inside.local(&p.name)),
            _ => format!("{}: {number}", inside.local(&p.name)),
        });
        let gives = match function.returns.len() {
            0 => String::new(),
            1 => format!(" -> {number}"),
            n => format!(" -> ({})", vec![number; n].join(", ")),
        };
        let printer = Printer { program: &self.whole.program, function, language: &inside, single: self.single };
        let depth = 1 + usize::from(inside.own);
        let takes: Vec<String> = takes.collect();
        let mut out = format!("{indent}{begin} {}({}){gives} {{\n", function.name, takes.join(", "));
        out += &printer.steps(&function.steps, depth);
        let returns: Vec<String> = function.returns.iter().map(|expr| printer.expr(expr)).collect();
        out += &match &returns[..] {
            [] => String::new(),
            [one] => format!("{}{one}\n", "    ".repeat(depth)),
            more => format!("{}({})\n", "    ".repeat(depth), more.join(", ")),
        };
        let about: String = function.about.iter().map(|line| format!("{indent}/// {line}\n")).collect();
        about + &left(&format!("{out}{indent}}}\n"), indent)
    }

    fn number(&self) -> &'static str {
        if self.single { "f32" } else { "f64" }
    }
}

/// The struct of the state of a block.
fn type_of(block: &str) -> String {
    let printer = block.strip_suffix("state").unwrap_or(block);
    printer.split('_').map(titled).chain(["State".into()]).collect()
}

fn constant_of(block: &Block, name: &str) -> String {
    format!("{}_{name}", block.name).to_uppercase()
}

/// An item, marked to be skipped if `rustfmt` would break one of its lines.
fn left(item: &str, indent: &str) -> String {
    if item.lines().any(broken) { format!("{indent}#[rustfmt::skip]\n{item}") } else { item.into() }
}

/// True if `rustfmt` would break this line.
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
                // Brackets around the whole line are a tuple.
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
    fn lines_that_rustfmt_would_break_are_detected() {
        let long = "a".repeat(61);
        assert!(!broken("    let y = f(a, b);") && !broken(&format!("// {long} {long}")));
        assert!(broken(&format!("    let y = f({long});")) && broken(&format!("    let y = {long} + {long};")));
        assert!(!broken(&format!("    let y = 2.0 * ({long});")));
    }

    #[test]
    fn types_are_named_after_blocks() {
        assert_eq!(["state", "ff_state", "hysteresis"].map(type_of), ["State", "FfState", "HysteresisState"]);
    }
}
