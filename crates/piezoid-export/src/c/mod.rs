//! C99: a header and a source file without a heap, a library, or recursion.
//!
//! Every function is static but those of the interface; states are structs, which the caller owns; tables are constant. Arithmetic is
//! that of the model here, in the same order, so that in double precision and without contraction the bits are the same.

mod inside;

use super::fixed::{Fixed, PLAIN, helpers};
use super::language::{Language, Words};
use super::readme::readme;
use super::whole::{Entry, Whole, state_of};
use super::{CODE, File, Made, Target, Wanted, named};
use piezoid::error::Error;
use piezoid::program::{Block, Constant, Field, Function, Holds, Kind, Program};
use piezoid::system::System;

pub(super) const TARGET: Target = Target {
    name: "c",
    summary: "a header and a source file in C99, in double or single precision, with a self-test",
    reference: "ISO/IEC 9899:1999; MISRA C:2012",
    heeds: CODE,
    make: |wanted| {
        let whole = checked(wanted)?;
        let c = C::of(&whole, wanted);
        let name = wanted.name;
        let files = vec![
            File::text(format!("{name}.h"), c.header(&whole, wanted)),
            File::text(format!("{name}.c"), c.source(&whole)),
            File::text(format!("{name}_test.c"), c.test(&whole)),
            File::text(format!("{}.md", wanted.name), readme(wanted, &whole)),
        ];
        let mut notes = whole.notes.clone();
        if name.len() > TOLD_APART {
            notes.push(format!("C99 promises to tell names apart by 31 letters, which one of more than {TOLD_APART} may leave too few of"));
        }
        Ok(Made { files, notes })
    },
};

/// The longest name after which functions still differ within what C99 promises to look at.
const TOLD_APART: usize = 31 - "_control_reset".len();

/// What may not be a name: the words of the language, and what its functions would clash with.
const RESERVED: &[&str] = &[
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern", "float",
    "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short", "signed", "sizeof",
    "static", "struct", "switch", "typedef", "union", "unsigned", "void", "volatile", "while", "main", "stdio", "math",
];

/// What is exported, under a name that C has not taken.
pub(super) fn checked(wanted: &Wanted) -> Result<Whole, Error> {
    named(wanted.name, RESERVED)?;
    Whole::new(wanted)
}

/// The language.
pub(super) struct C<'c> {
    pub(super) program: &'c Program,
    pub(super) name: &'c str,
    pub(super) single: bool,
    /// How numbers are counted, where they are not floating.
    pub(super) counts: Option<&'c Fixed>,
}

impl<'c> C<'c> {
    pub(super) fn of(whole: &'c Whole, wanted: &'c Wanted) -> Self {
        C { program: &whole.program, name: wanted.name, single: wanted.single, counts: None }
    }
}

impl C<'_> {
    /// The header: types and functions that are called from outside.
    pub(super) fn header(&self, whole: &Whole, wanted: &Wanted) -> String {
        let (name, guard) = (self.name, self.name.to_uppercase());
        let mut out = String::new();
        let mut about = vec![format!("{name}.h: a piezo actuator and what drives it, as identified by piezoid.")];
        about.push(format!("One call of a step function is one sample of {} s.", shortest(wanted.model.ts(), false)));
        about.extend(whole.notes.iter().cloned());
        out += &comment(&about, "");
        out += &format!("#ifndef {guard}_H\n#define {guard}_H\n\n");
        out += &match self.counts {
            None => format!("#define {guard}_TS {} /* sampling period [s] */\n\n", self.real(wanted.model.ts())),
            Some(fixed) => fixed.scales(&guard),
        };
        out += "#ifdef __cplusplus\nextern \"C\" {\n#endif\n\n";
        for block in whole.states() {
            out += &comment(&[format!("State of {}.", block.about)], "");
            out += "typedef struct {\n";
            for field in &block.fields {
                let number = self.held(block, field);
                out += &match &field.holds {
                    Holds::Number(_) => format!("    {number} {};\n", field.name),
                    Holds::Numbers(values) => format!("    {number} {}[{}];\n", field.name, values.len()),
                    Holds::Block(inner) => format!("    {} {};\n", self.state(inner), field.name),
                };
            }
            out += &format!("}} {};\n\n", self.state(&block.name));
        }
        for entry in &whole.entries {
            let inputs = entry.inputs.iter().map(|i| format!("{} [{}]: {}", i.name, i.unit, i.about));
            let mut about = vec![format!("One sample of {}.", entry.about)];
            about.extend(inputs);
            about.push(format!("Returns {} [{}]: {}.", entry.output.name, entry.output.unit, entry.output.about));
            out += &comment(&["Begins anew: all that went before is forgotten.".into()], "");
            out += &format!("void {}({} *s);\n\n", self.own(entry.reset), self.state(entry.state));
            out += &comment(&about, "");
            out += &format!("{};\n\n", self.prototype(entry));
        }
        out + "#ifdef __cplusplus\n}\n#endif\n\n#endif\n"
    }

    fn prototype(&self, entry: &Entry) -> String {
        let inputs: String = entry.inputs.iter().map(|i| format!(", {} {}", self.number(), i.name)).collect();
        format!("{} {}({} *s{inputs})", self.number(), self.own(entry.step), self.state(entry.state))
    }

    /// The source: constants and functions.
    pub(super) fn source(&self, whole: &Whole) -> String {
        let mut out = comment(&[format!("{}.c: see {}.h", self.name, self.name)], "");
        out += &format!("#include \"{}.h\"\n\n", self.name);
        out += &match self.counts {
            None => {
                "#ifdef __clang__\n#pragma STDC FP_CONTRACT OFF /* the same bits on every machine */\n#endif\n\n".into()
            }
            Some(_) => helpers(self.name, self.program),
        };
        for (number, block) in self.program.blocks.iter().enumerate() {
            let functions: Vec<&Function> = self.program.functions.iter().filter(|f| f.block == number).collect();
            if functions.is_empty() {
                continue;
            }
            out += &format!("{}\n{}", comment(&[titled(&block.about)], ""), self.constants(block));
            out += if block.constants.is_empty() { "" } else { "\n" };
            for function in functions {
                out += &self.function(function, whole);
            }
        }
        for entry in &whole.entries {
            out += &format!(
                "void {}({} *s)\n{{\n{}}}\n\n",
                self.own(entry.reset),
                self.state(entry.state),
                self.rest(entry.state, "s->")
            );
        }
        out.trim_end().lines().map(broken).collect()
    }

    /// The constants of a block.
    fn constants(&self, block: &Block) -> String {
        let line = |c: &Constant| {
            let (name, number) = (self.own(&format!("{}_{}", block.name, c.name)), self.number());
            let values: Vec<String> = c.values.iter().map(|v| self.real(*v)).collect();
            match c.table {
                false => format!("static const {number} {name} = {};\n", values[0]),
                true => format!("static const {number} {name}[{}] = {{\n{}}};\n", values.len(), wrapped(&values)),
            }
        };
        block.constants.iter().map(line).collect()
    }

    fn function(&self, function: &Function, whole: &Whole) -> String {
        let number = self.number_in(function);
        let outside = whole.entries.iter().any(|entry| entry.step == function.name);
        let gives = if function.returns.is_empty() { "void" } else { number };
        let mut takes: Vec<String> = function
            .takes
            .iter()
            .map(|p| match &p.kind {
                Kind::Whole => format!("int {}", p.name),
                Kind::Part(block) => {
                    format!("{}{} *{}", if p.changed || outside { "" } else { "const " }, self.state(block), p.name)
                }
                _ => format!("{number} {}", p.name),
            })
            .collect();
        let also = function.returns.iter().skip(1);
        takes.extend(also.clone().map(|_| format!("{number} *also")));
        let words = Words { program: self.program, function, language: self };
        let mut out = if function.about.is_empty() { String::new() } else { comment(&function.about, "") };
        let visible = if outside { "" } else { "static " };
        out += &format!("{visible}{gives} {}({})\n{{\n", self.own(&function.name), takes.join(", "));
        out += &words.steps(&function.steps, 1);
        for expr in also {
            out += &format!("    *also = {};\n", words.expr(expr));
        }
        if let Some(first) = function.returns.first() {
            out += &format!("    return {};\n", words.expr(first));
        }
        out + "}\n\n"
    }

    /// What puts the state of a block at rest, field by field after `prefix`.
    fn rest(&self, block: &str, prefix: &str) -> String {
        let mut out = String::new();
        for field in self.program.block(block).map_or(&[][..], |b| &b.fields) {
            let name = format!("{prefix}{}", field.name);
            match &field.holds {
                Holds::Number(value) => out += &format!("    {name} = {};\n", self.real(*value)),
                Holds::Block(inner) => out += &self.rest(inner, &format!("{name}.")),
                // All alike are set in a loop.
                Holds::Numbers(values) if values.iter().all(|v| v.to_bits() == values[0].to_bits()) => {
                    let (n, value) = (values.len(), self.real(values[0]));
                    out += &format!("    for (int k = 0; k < {n}; k++) {{\n        {name}[k] = {value};\n    }}\n");
                }
                Holds::Numbers(values) => {
                    for (k, value) in values.iter().enumerate() {
                        out += &format!("    {name}[{k}] = {};\n", self.real(*value));
                    }
                }
            }
        }
        out
    }

    /// What makes the state of a block zero, line by line.
    fn cleared(&self, block: &str, prefix: &str) -> Vec<String> {
        let zero = self.real(0.0);
        let fields = self.program.block(block).map_or(&[][..], |b| &b.fields);
        let clear = |field: &Field| match (&field.holds, format!("{prefix}{}", field.name)) {
            (Holds::Number(_), name) => vec![format!("{name} = {zero};")],
            (Holds::Numbers(values), name) => vec![
                format!("for (int k = 0; k < {}; k++) {{", values.len()),
                format!("    {name}[k] = {zero};"),
                "}".into(),
            ],
            (Holds::Block(inner), name) => self.cleared(inner, &format!("{name}.")),
        };
        fields.iter().flat_map(clear).collect()
    }

    /// A program that runs the vectors and says how many differ.
    pub(super) fn test(&self, whole: &Whole) -> String {
        let (name, number) = (self.name, self.number());
        let about = [
            format!("Runs {name} on recorded inputs and compares bit by bit with what piezoid computes."),
            "Ends with status 0 where all are equal, else with 1.".into(),
        ];
        let mut out = comment(&about, "");
        out += &format!("#include \"{name}.h\"\n#include <stdio.h>\n\n");
        let mut main = String::new();
        for entry in &whole.entries {
            let vectors = &entry.vectors;
            let (step, n) = (entry.step, vectors.outputs.len());
            for (k, input) in entry.inputs.iter().enumerate() {
                let values: Vec<String> = vectors.inputs.iter().map(|row| self.real(row[k])).collect();
                out += &format!("static const {number} {step}_{}[{n}] = {{\n{}}};\n", input.name, wrapped(&values));
            }
            let values: Vec<String> = vectors.outputs.iter().map(|v| self.real(*v)).collect();
            out += &format!("static const {number} {step}_gives[{n}] = {{\n{}}};\n\n", wrapped(&values));
            let inputs: String = entry.inputs.iter().map(|i| format!(", {step}_{}[k]", i.name)).collect();
            let given = format!("{}(&s{inputs})", self.own(step));
            let (most, compare, by) = match self.counts {
                // Counts are equal or not, and a core that has no other numbers runs this too.
                Some(_) => (
                    "",
                    format!("        if ({given} != {step}_gives[k]) {{\n            differs++;\n        }}\n"),
                    String::new(),
                ),
                None => (
                    "    double most = 0.0;\n",
                    format!(
                        "        const {number} off = {given} - {step}_gives[k];\n        \
                         const double size = (off < {zero}) ? -(double)off : (double)off;\n        if (!(size == 0.0)) {{\n            \
                         differs++;\n        }}\n        if (size > most) {{\n            most = size;\n        }}\n",
                        zero = self.real(0.0),
                    ),
                    format!(", by %g {} at most", entry.output.unit.replace(['%', '\\', '"', '?'], "")),
                ),
            };
            out += &format!(
                "static int {step}_differs(void)\n{{\n    {} s;\n    int differs = 0;\n{most}    {}(&s);\n    \
                 for (int k = 0; k < {n}; k++) {{\n{compare}    }}\n    \
                 printf(\"{name}_{step}: %d of {n} differ{by}\\n\", differs{});\n    return differs;\n}}\n\n",
                self.state(entry.state),
                self.own(entry.reset),
                if most.is_empty() { "" } else { ", most" },
            );
            main += &format!("    differs += {step}_differs();\n");
        }
        out + &format!("int main(void)\n{{\n    int differs = 0;\n{main}    return (differs == 0) ? 0 : 1;\n}}\n")
    }

    fn number(&self) -> &'static str {
        match (self.counts, self.single) {
            (Some(_), _) => "int32_t",
            (None, true) => "float",
            (None, false) => "double",
        }
    }

    /// Numbers with a name in a function.
    fn number_in(&self, function: &Function) -> &'static str {
        let passes_on = self.counts.is_some() && PLAIN.contains(&function.name.as_str());
        if passes_on { "int64_t" } else { self.number() }
    }

    /// Numbers in a field.
    fn held(&self, block: &Block, field: &Field) -> &'static str {
        let long = self.counts.is_some_and(|fixed| fixed.is_long(&block.name, &field.name));
        if long { "int64_t" } else { self.number() }
    }

    /// A name of this file, which no other file has.
    pub(super) fn own(&self, name: &str) -> String {
        format!("{}_{name}", self.name)
    }

    /// The type of the state of a block.
    pub(super) fn state(&self, block: &str) -> String {
        self.own(&state_of(block))
    }
}

/// `text` as the beginning of a page has it.
pub(super) fn titled(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Lines of a comment.
pub(super) fn comment(lines: &[String], indent: &str) -> String {
    let lines: Vec<String> = lines.iter().map(|line| line.replace("*/", "* /")).collect();
    format!("{indent}/* {} */\n", lines.join(&format!("\n{indent}   ")))
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

/// As wide as lines of code are.
const WIDE: usize = 120;

/// A line of code, in several where it is too long: before an operator, or after a comma.
fn broken(line: &str) -> String {
    let indent = line.len() - line.trim_start().len();
    // What a comment goes on with stands under its first word.
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

/// Before which a line may be broken.
const OPERATORS: &[&str] = &["+", "-", "*", "/", "<", "<=", ">", ">=", "==", "!=", "&&", "||", "?", ":"];

/// The shortest text that is read back as this number.
pub(super) fn shortest(value: f64, single: bool) -> String {
    if single { format!("{:?}", value as f32) } else { format!("{value:?}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_of_code_are_broken_where_nothing_changes_and_comments_are_not() {
        let sum = format!("    x = f({}, {});", "a".repeat(80), "b".repeat(40));
        let [first, second] = [0, 1].map(|n| broken(&sum).lines().nth(n).unwrap().to_owned());
        assert!(first.ends_with("a,") && second == format!("        {});", "b".repeat(40)), "{first}\n{second}");
        let comment = format!("/* {} + {} */", "a".repeat(80), "b".repeat(40));
        assert_eq!(broken(&comment), format!("{comment}\n"));
    }
}
