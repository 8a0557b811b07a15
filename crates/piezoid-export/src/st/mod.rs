//! Structured text: function blocks for programmable logic controllers.
//!
//! The code runs on CODESYS 3 and TwinCAT 3 and uses only what the second and third edition of the standard have: no
//! methods, references, pointers, or globals. States are structures, passed as `VAR_IN_OUT`; a second result is a
//! `VAR_OUTPUT`. Tables are a structure with initial values, and each function block has one: functions see no globals,
//! and a constant table in a function would be initialised in every call. `AND` and `OR` evaluate both sides. Names are
//! case-insensitive and must not have two underscores in a row; clashing names get a number. The Siemens dialect is not
//! supported, because it requires `#` before every local name.

mod body;
mod names;

use super::c::{shortest, wrapped};
use super::exported::{Entry, ExportedProgram};
use super::language::Printer;
use super::template::{Value, blocks, context, quiet, render, template, template_context};
use super::{CODE, ExportRequest, ExportTarget, Exported, File, named};
use body::StBody;
use names::{Names, RESERVED};
use piezoid_models::program::{Block, Constant, Expr, Field, FieldValue, Function, ValueType};
use std::collections::BTreeMap;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "st",
    summary: "function blocks in structured text, in LREAL or REAL, with a test program",
    reference: "IEC 61131-3:2003 and 2013",
    make: |request| {
        named(request.name(), RESERVED)?;
        let whole = ExportedProgram::new(request)?;
        let page = St::new(&whole, request)?.template_context(request);
        let files = vec![
            File::new(format!("{}.st", request.name()), render(template!("st/library.st.j2"), page.clone())?),
            File::new(format!("{}_test.st", request.name()), render(template!("st/test.st.j2"), page.clone())?),
            File::new(format!("{}.md", request.name()), render(template!("st/readme.md.j2"), page)?),
        ];
        Ok(Exported { files, functions: whole.functions(), notes: whole.notes })
    },
    ..CODE
};

/// Keys of names that are not in the program: tables, a counter, unused results.
const TABLES: &str = "!tables";
const COUNTER: &str = "!k";
const DONE: &str = "!done";
const UNUSED: &str = "!unused";

/// The key of a further result of a function.
fn also(k: usize) -> String {
    format!("!also {k}")
}

/// The key of a constant of a block.
fn constant(block: &str, name: &str) -> String {
    format!("!{block} {name}")
}

/// A variable of a function: its key and its type.
type Variable = (String, String);

/// The printer.
struct St<'s> {
    whole: &'s ExportedProgram,
    single: bool,
    /// Names of types, function blocks and functions.
    globals: Names,
    /// Names of fields of states and tables.
    fields: Names,
    /// For each function: its names, and the variables that it needs besides its parameters.
    inner: Vec<(Names, Vec<Variable>)>,
    /// Functions that read a table, directly or in a call.
    reading: Vec<String>,
}

impl St<'_> {
    fn number(&self) -> &'static str {
        if self.single { "REAL" } else { "LREAL" }
    }

    fn array(&self, n: usize) -> String {
        format!("ARRAY [0..{}] OF {}", n.saturating_sub(1), self.number())
    }

    /// The type of the state of a block.
    fn state(&self, block: &str) -> &str {
        self.globals.get(&format!("!!{block}"))
    }

    /// A number where its type is known.
    fn plain(&self, value: f64) -> String {
        let text = shortest(value, self.single);
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, ""));
        let point = if digits.contains('.') { "" } else { ".0" };
        format!("{digits}{point}{}{exponent}", if exponent.is_empty() { "" } else { "E" })
    }

    fn template_context(&self, request: &ExportRequest) -> Value {
        let program = &self.whole.program;
        let state = |block: &&Block| {
            let fields: Value = block.fields.iter().map(|field| self.field(field)).collect();
            context! { type => self.state(&block.name), about => &block.about, fields }
        };
        let tables = program.blocks.iter().flat_map(|block| {
            let name = |c: &Constant| self.fields.get(&constant(&block.name, &c.name));
            let tables = block.constants.iter().filter(|c| c.table);
            tables.map(move |c| format!("{} : {}", name(c), self.filled(&c.values)))
        });
        let block = |(block, functions): (&Block, Vec<(usize, &Function)>)| {
            let functions: Value = functions.into_iter().map(|(k, f)| self.function(f, k)).collect();
            context! { about => &block.about, functions }
        };
        let own = context! {
            number => self.number(), program => self.globals.get("!test"),
            states => self.whole.states().iter().map(state).collect::<Value>(),
            tables => context! { type => self.globals.get(TABLES), fields => tables.collect::<Value>() },
            blocks => blocks(program).map(block).collect::<Value>(),
            blocks_of => self.whole.entries.iter().filter_map(|e| self.entry(e)).collect::<BTreeMap<_, _>>(),
        };
        context! { ..own, ..template_context(request, self.whole, &|values| self.filled(values)) }
    }

    /// A field of a state, at rest.
    fn field(&self, field: &Field) -> String {
        let kind = match &field.holds {
            FieldValue::Number(0.0) => self.number().into(),
            FieldValue::Number(value) => format!("{} := {}", self.number(), self.plain(*value)),
            FieldValue::Numbers(values) if values.iter().all(|v| *v == 0.0) => self.array(values.len()),
            FieldValue::Numbers(values) => self.filled(values),
            FieldValue::Block(inner) => self.state(inner).into(),
        };
        format!("{} : {kind}", self.fields.get(&field.name))
    }

    /// The type of a table and its values.
    fn filled(&self, values: &[f64]) -> String {
        let (array, values) = (self.array(values.len()), values.iter().map(|v| self.plain(*v)).collect::<Vec<_>>());
        let line = format!("{array} := [{}]", values.join(", "));
        if line.len() <= 100 {
            return line;
        }
        let lines: Vec<String> = wrapped(&values).lines().map(|line| format!("    {line}")).collect();
        format!("{array} := [\n{}\n    ]", lines.join("\n").trim_end_matches(','))
    }

    /// Function number `k`.
    fn function(&self, function: &Function, k: usize) -> Value {
        let program = &self.whole.program;
        let (names, inner) = &self.inner[k];
        let inside = StBody { st: self, names };
        let printer = Printer { program, function, language: &inside, single: self.single };
        let declared = |key: &str, kind: &str| format!("{} : {kind}", names.get(key));
        let (mut arguments, mut changed, mut constants) = (Vec::new(), Vec::new(), Vec::new());
        for p in &function.takes {
            match &p.kind {
                ValueType::Part(block) => changed.push(declared(&p.name, self.state(block))),
                ValueType::Integer => arguments.push(declared(&p.name, "DINT")),
                _ => arguments.push(declared(&p.name, self.number())),
            }
        }
        if self.reading.contains(&function.name) {
            changed.push(declared(TABLES, self.globals.get(TABLES)));
        }
        let results: Vec<String> = (1..function.returns.len()).map(|k| declared(&also(k), self.number())).collect();
        let own: Vec<String> = inner.iter().map(|(key, kind)| declared(key, kind)).collect();
        for (number, block) in program.blocks.iter().enumerate() {
            for c in block.constants.iter().filter(|c| !c.table) {
                let mut read = false;
                function.expressions(&mut |expr| {
                    read |= matches!(expr, Expr::Constant(of, known, None) if *of == number && *known == c.name)
                });
                if read {
                    let value = format!("{} := {}", self.number(), self.plain(c.values[0]));
                    constants.push(declared(&constant(&block.name, &c.name), &value));
                }
            }
        }
        let sections = [
            ("VAR_INPUT", arguments),
            ("VAR_IN_OUT", changed),
            ("VAR_OUTPUT", results),
            ("VAR", own),
            ("VAR CONSTANT", constants),
        ];
        let section = |(kind, variables): (&'static str, Vec<String>)| context! { kind, variables };
        let result = |(k, expr): (usize, &Expr)| format!("{} := {}", names.get(&also(k)), printer.expr(expr));
        context! {
            name => self.globals.get(&function.name),
            gives => if function.returns.is_empty() { "BOOL" } else { self.number() },
            about => if function.about.is_empty() { String::new() } else { comment(&function.about) },
            sections => sections.into_iter().map(section).collect::<Value>(),
            steps => printer.steps(&function.steps, 0),
            results => function.returns.iter().enumerate().skip(1).map(result).collect::<Value>(),
            value => function.returns.first().map_or("TRUE".into(), |expr| printer.expr(expr)),
        }
    }

    /// The function block of an entry: its names, and the call of its step.
    fn entry(&self, entry: &Entry) -> Option<(&'static str, Value)> {
        let mut functions = self.whole.program.functions.iter().enumerate();
        let (k, step) = functions.find(|(_, f)| f.name == entry.step)?;
        let mut names = Names::without(&self.globals.taken);
        entry.inputs.iter().for_each(|input| names.add(input.name, input.name));
        names.add("!output", entry.output.name);
        for (key, wish) in [("!reset", "reset"), ("!state", "state"), ("!rest", "rest"), (TABLES, "tables")] {
            names.add(key, wish);
        }
        // Parameter names inside the function, and their arguments here.
        let inner = &self.inner[k].0;
        let outer = step.takes.iter().map(|p| match p.kind {
            ValueType::Part(_) => (inner.get(&p.name), names.get("!state")),
            _ => (inner.get(&p.name), names.get(&p.name)),
        });
        let reads = self.reading.contains(&step.name);
        let tables = reads.then(|| (inner.get(TABLES), names.get(TABLES)));
        let arguments: Vec<String> = outer.chain(tables).map(|(inner, outer)| format!("{inner} := {outer}")).collect();
        let context = context! {
            inputs => entry.inputs.iter().map(|i| names.get(i.name)).collect::<Value>(), output => names.get("!output"),
            reset => names.get("!reset"), state => names.get("!state"), rest => names.get("!rest"),
            type => self.state(entry.state), tables => names.get(TABLES), reads,
            call => format!("{}({})", self.globals.get(&step.name), arguments.join(", ")),
        };
        Some((entry.step, context))
    }

    /// Lines that set the state of a block to zero.
    fn cleared(&self, block: &str, prefix: &str, counter: &str) -> Vec<String> {
        let fields = self.whole.program.block(block).map_or(&[][..], |b| &b.fields);
        let clear = |field: &Field| match (&field.holds, format!("{prefix}.{}", self.fields.get(&field.name))) {
            (FieldValue::Number(_), name) => vec![format!("{name} := 0.0;")],
            (FieldValue::Numbers(values), name) => zeros(&name, values.len(), counter),
            (FieldValue::Block(inner), name) => self.cleared(inner, &name, counter),
        };
        fields.iter().flat_map(clear).collect()
    }
}

/// Lines that set `n` numbers to zero.
fn zeros(name: &str, n: usize, counter: &str) -> Vec<String> {
    let last = n.saturating_sub(1);
    vec![format!("FOR {counter} := 0 TO {last} DO"), format!("    {name}[{counter}] := 0.0;"), "END_FOR;".into()]
}

fn comment(lines: &[String]) -> String {
    format!("(* {} *)\n", quiet(&lines.join("\n   ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_end_where_they_should() {
        assert_eq!(comment(&["a*(b*)c".into()]), "(* a*(b* )c *)\n");
        assert_eq!(comment(&["f(*x".into()]), "(* f( *x *)\n");
    }
}
