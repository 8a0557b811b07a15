//! Structured text: function blocks for programmable logic controllers.
//!
//! What runs on CODESYS 3 and TwinCAT 3 and stands in the second edition of the standard as in the third: no methods, no references, no
//! pointers, no globals. States are structures, handed on as `VAR_IN_OUT`; a second result is a `VAR_OUTPUT`. Tables are a structure
//! too, with initial values, of which each function block has one: functions see no globals, and a table among the constants of a function would
//! be laid out anew in every call. `AND` and `OR` look at both sides. Names are not told apart by capitals, nor may they have
//! underscores in a row: what clashes gets a number. Not for the dialect of Siemens, which wants `#` before every local name.

mod inside;
mod names;
mod proof;

use super::c::{shortest, titled, wrapped};
use super::language::Words;
use super::whole::{Entry, Whole};
use super::{CODE, File, Made, Target, Wanted, named};
use inside::Inside;
use names::{Names, RESERVED};
use piezoid::program::{Block, Expr, Field, Function, Holds, Kind};
use piezoid::system::System;
use proof::page;

pub(super) const TARGET: Target = Target {
    name: "st",
    summary: "function blocks in structured text, in LREAL or REAL, with a program that proves them",
    reference: "IEC 61131-3:2003 and 2013",
    heeds: CODE,
    make: |wanted| {
        named(wanted.name, RESERVED)?;
        let whole = Whole::new(wanted)?;
        let st = St::new(&whole, wanted)?;
        let files = vec![
            File::text(format!("{}.st", wanted.name), st.library(wanted)),
            File::text(format!("{}_test.st", wanted.name), st.test()),
            File::text(format!("{}.md", wanted.name), page(wanted, &st)),
        ];
        Ok(Made { files, notes: whole.notes })
    },
};

/// Keys of names that a program has not: of the tables, of a number that counts, of results that nobody wants.
const TABLES: &str = "!tables";
const COUNTER: &str = "!k";
const DONE: &str = "!done";
const UNUSED: &str = "!unused";

/// The key of another result of a function.
fn also(k: usize) -> String {
    format!("!also {k}")
}

/// The key of a constant of a block.
fn constant(block: &str, name: &str) -> String {
    format!("!{block} {name}")
}

/// A variable of a function: its key and its type.
type Variable = (String, String);

/// The language.
struct St<'s> {
    whole: &'s Whole,
    name: &'s str,
    single: bool,
    /// Of types, function blocks and functions.
    globals: Names,
    /// Of fields of states and tables.
    fields: Names,
    /// Of each function: what it names, and which variables those are that it needs beside its parameters.
    inner: Vec<(Names, Vec<Variable>)>,
    /// Functions that read a table, or call one that does.
    reading: Vec<String>,
}

impl St<'_> {
    /// The function block of an entry.
    fn block_of(&self, entry: &Entry) -> String {
        entry.named(self.name)
    }

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

    fn values(&self, values: &mut dyn Iterator<Item = f64>) -> Vec<String> {
        values.map(|v| self.plain(v)).collect()
    }

    /// The library: types, functions, function blocks.
    fn library(&self, wanted: &Wanted) -> String {
        let mut about = vec![
            format!("{}.st: a piezo actuator and what drives it, as identified by piezoid.", self.name),
            format!("One call of a function block is one sample of {} s.", shortest(wanted.model.ts(), false)),
        ];
        about.extend(self.whole.notes.iter().cloned());
        let mut out = comment(&about);
        for block in self.whole.states() {
            out += &self.shape(block);
        }
        out += &self.tables();
        for (number, block) in self.whole.program.blocks.iter().enumerate() {
            let functions = self.whole.program.functions.iter().enumerate().filter(|(_, f)| f.block == number);
            let functions: String = functions.map(|(k, f)| self.function(f, k)).collect();
            if !functions.is_empty() {
                out += &format!("\n{}{functions}", comment(&[titled(&block.about)]));
            }
        }
        let blocks: String = self.whole.entries.iter().map(|entry| self.entry(entry)).collect();
        out + &format!("\n{}{blocks}", comment(&["What is called from outside".into()]))
    }

    /// The type of a state, at rest.
    fn shape(&self, block: &Block) -> String {
        let mut out = format!("\n{}", comment(&[format!("State of {}.", block.about)]));
        out += &format!("TYPE {} :\nSTRUCT\n", self.state(&block.name));
        for field in &block.fields {
            let kind = match &field.holds {
                Holds::Number(0.0) => self.number().into(),
                Holds::Number(value) => format!("{} := {}", self.number(), self.plain(*value)),
                Holds::Numbers(values) if values.iter().all(|v| *v == 0.0) => self.array(values.len()),
                Holds::Numbers(values) => self.filled(&self.values(&mut values.iter().copied()), "    "),
                Holds::Block(inner) => self.state(inner).into(),
            };
            out += &format!("    {} : {kind};\n", self.fields.get(&field.name));
        }
        out + "END_STRUCT;\nEND_TYPE\n"
    }

    /// The type of a table and its values.
    fn filled(&self, values: &[String], indent: &str) -> String {
        let array = self.array(values.len());
        let line = format!("{array} := [{}]", values.join(", "));
        if line.len() <= 100 {
            return line;
        }
        let lines: Vec<String> = wrapped(values).lines().map(|line| format!("{indent}{line}")).collect();
        format!("{array} := [\n{}\n{indent}]", lines.join("\n").trim_end_matches(','))
    }

    /// The tables.
    fn tables(&self) -> String {
        let mut lines = String::new();
        for block in &self.whole.program.blocks {
            for c in block.constants.iter().filter(|c| c.table) {
                let name = self.fields.get(&constant(&block.name, &c.name));
                lines +=
                    &format!("    {name} : {};\n", self.filled(&self.values(&mut c.values.iter().copied()), "    "));
            }
        }
        if lines.is_empty() {
            return lines;
        }
        let about = comment(&["Tables of constants, which nothing changes.".into()]);
        format!("\n{about}TYPE {} :\nSTRUCT\n{lines}END_STRUCT;\nEND_TYPE\n", self.globals.get(TABLES))
    }

    /// A function, the `k`-th.
    fn function(&self, function: &Function, k: usize) -> String {
        let program = &self.whole.program;
        let inside = Inside { st: self, names: &self.inner[k].0 };
        let words = Words { program, function, language: &inside };
        let name = self.globals.get(&function.name);
        let mut out =
            if function.about.is_empty() { "\n".to_owned() } else { format!("\n{}", comment(&function.about)) };
        let gives = if function.returns.is_empty() { "BOOL" } else { self.number() };
        out += &format!("FUNCTION {name} : {gives}\n");
        let line = |(key, kind): &Variable| format!("    {} : {kind};\n", inside.names.get(key));
        let (mut given, mut changed) = (Vec::new(), Vec::new());
        for p in &function.takes {
            match &p.kind {
                Kind::Part(block) => changed.push((p.name.clone(), self.state(block).to_owned())),
                Kind::Whole => given.push((p.name.clone(), "DINT".to_owned())),
                _ => given.push((p.name.clone(), self.number().to_owned())),
            }
        }
        if self.reading.contains(&function.name) {
            changed.push((TABLES.into(), self.globals.get(TABLES).into()));
        }
        let results: Vec<Variable> = (1..function.returns.len()).map(|k| (also(k), self.number().into())).collect();
        for (kind, variables) in
            [("VAR_INPUT", &given), ("VAR_IN_OUT", &changed), ("VAR_OUTPUT", &results), ("VAR", &self.inner[k].1)]
        {
            out += &section(kind, &variables.iter().map(line).collect::<String>());
        }
        let mut constants = String::new();
        for (number, block) in program.blocks.iter().enumerate() {
            for c in block.constants.iter().filter(|c| !c.table) {
                let mut read = false;
                function.expressions(&mut |expr| {
                    read |= matches!(expr, Expr::Constant(of, known, None) if *of == number && *known == c.name)
                });
                if read {
                    let own = inside.names.get(&constant(&block.name, &c.name));
                    constants += &format!("    {own} : {} := {};\n", self.number(), self.plain(c.values[0]));
                }
            }
        }
        out += &section("VAR CONSTANT", &constants);
        out += &words.steps(&function.steps, 0);
        for (k, expr) in function.returns.iter().enumerate().skip(1) {
            out += &format!("{} := {};\n", inside.names.get(&also(k)), words.expr(expr));
        }
        let first = function.returns.first().map_or("TRUE".into(), |expr| words.expr(expr));
        out + &format!("{name} := {first};\nEND_FUNCTION\n")
    }

    /// The function block of an entry.
    fn entry(&self, entry: &Entry) -> String {
        let program = &self.whole.program;
        let Some((k, step)) = program.functions.iter().enumerate().find(|(_, f)| f.name == entry.step) else {
            return String::new();
        };
        let mut names = Names::without(&self.globals.taken);
        for input in &entry.inputs {
            names.add(input.name, input.name);
        }
        for (key, wish) in [
            ("!output", entry.output.name),
            ("!reset", "reset"),
            ("!state", "state"),
            ("!rest", "rest"),
            (TABLES, "tables"),
        ] {
            names.add(key, wish);
        }
        let number = self.number();
        let mut inputs = String::new();
        for i in &entry.inputs {
            inputs +=
                &format!("    {} : {number}; {}", names.get(i.name), comment(&[format!("{} [{}]", i.about, i.unit)]));
        }
        inputs += &format!("    {} : BOOL; (* begins anew, with this sample *)\n", names.get("!reset"));
        let about = comment(&[format!("{} [{}]", entry.output.about, entry.output.unit)]);
        let output = format!("    {} : {number}; {about}", names.get("!output"));
        let state = self.state(entry.state);
        let mut own = format!("    {} : {state};\n    {} : {state};\n", names.get("!state"), names.get("!rest"));
        // What the function calls what it is given, and what that is called here.
        let inner = &self.inner[k].0;
        let outer = step.takes.iter().map(|p| match p.kind {
            Kind::Part(_) => (inner.get(&p.name), names.get("!state")),
            _ => (inner.get(&p.name), names.get(&p.name)),
        });
        let mut given: Vec<String> = outer.map(|(inner, outer)| format!("{inner} := {outer}")).collect();
        if self.reading.contains(&step.name) {
            own += &format!("    {} : {};\n", names.get(TABLES), self.globals.get(TABLES));
            given.push(format!("{} := {}", inner.get(TABLES), names.get(TABLES)));
        }
        let mut out = format!(
            "\n{}FUNCTION_BLOCK {}\n",
            comment(&[format!("One sample of {}.", entry.about)]),
            self.block_of(entry)
        );
        out += &section("VAR_INPUT", &inputs);
        out += &section("VAR_OUTPUT", &output);
        out += &section("VAR", &own);
        out += &format!(
            "IF {} THEN\n    {} := {};\nEND_IF;\n",
            names.get("!reset"),
            names.get("!state"),
            names.get("!rest")
        );
        let call = format!("{}({})", self.globals.get(&step.name), given.join(", "));
        out + &format!("{} := {call};\nEND_FUNCTION_BLOCK\n", names.get("!output"))
    }

    /// What makes the state of a block zero, line by line.
    fn cleared(&self, block: &str, prefix: &str, counter: &str) -> Vec<String> {
        let fields = self.whole.program.block(block).map_or(&[][..], |b| &b.fields);
        let clear = |field: &Field| match (&field.holds, format!("{prefix}.{}", self.fields.get(&field.name))) {
            (Holds::Number(_), name) => vec![format!("{name} := 0.0;")],
            (Holds::Numbers(values), name) => zeros(&name, values.len(), counter),
            (Holds::Block(inner), name) => self.cleared(inner, &name, counter),
        };
        fields.iter().flat_map(clear).collect()
    }
}

/// What makes `n` numbers zero.
fn zeros(name: &str, n: usize, counter: &str) -> Vec<String> {
    let last = n.saturating_sub(1);
    vec![format!("FOR {counter} := 0 TO {last} DO"), format!("    {name}[{counter}] := 0.0;"), "END_FOR;".into()]
}

/// Declarations of a kind, if there are any.
fn section(kind: &str, lines: &str) -> String {
    if lines.is_empty() { String::new() } else { format!("{kind}\n{lines}END_VAR\n") }
}

/// Lines of a comment.
fn comment(lines: &[String]) -> String {
    let lines: Vec<String> = lines.iter().map(|line| line.replace("*)", "* )").replace("(*", "( *")).collect();
    format!("(* {} *)\n", lines.join("\n   "))
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
