//! What goes with structured text: a program that tests it, and a page.

use super::{St, comment, section};
use crate::Wanted;
use crate::c::shortest;
use crate::readme::{moved, opening};
use crate::vectors::SAMPLES;
use piezoid::system::System;

impl St<'_> {
    /// A program that runs the vectors, a sample a cycle.
    pub(super) fn test(&self) -> String {
        let (name, n) = (self.globals.get("!test"), SAMPLES);
        let about = [
            format!(
                "Runs {} on recorded inputs, a sample a cycle, and counts the samples that differ by a bit from",
                self.name
            ),
            format!("what piezoid computes: all is well where `differs` is 0 when `sample` has come to {n}."),
        ];
        let mut tables = String::new();
        let mut own = "    sample : DINT;\n    differs : DINT;\n".to_owned();
        let mut body = String::new();
        for entry in &self.whole.entries {
            let vectors = &entry.vectors;
            let block = self.block_of(entry);
            let unit = format!("the_{}", block.strip_prefix(&format!("{}_", self.name)).unwrap_or("model"));
            let mut given = Vec::new();
            for (k, input) in entry.inputs.iter().enumerate() {
                let values = self.values(&mut vectors.inputs.iter().map(|row| row[k]));
                tables += &format!("    {}_{} : {};\n", unit, input.name, self.filled(&values, "    "));
                given.push(format!("{} := {unit}_{}[sample]", input.name, input.name));
            }
            let values = self.values(&mut vectors.outputs.iter().copied());
            tables += &format!("    {unit}_gives : {};\n", self.filled(&values, "    "));
            own += &format!("    {unit} : {block};\n");
            body += &format!(
                "    {unit}({}, reset := sample = 0);\n    IF {unit}.{} <> {unit}_gives[sample] THEN\n        differs := differs + 1;\n    END_IF;\n",
                given.join(", "),
                entry.output.name,
            );
        }
        let mut out = comment(&about);
        out += &format!("PROGRAM {name}\n");
        out += &section("VAR CONSTANT", &tables);
        out += &section("VAR", &own);
        out + &format!("IF sample < {n} THEN\n{body}    sample := sample + 1;\nEND_IF;\nEND_PROGRAM\n")
    }
}

/// The page that goes with it.
pub(super) fn page(wanted: &Wanted, st: &St) -> String {
    let name = wanted.name;
    let mut out = opening(wanted, st.whole, "function blocks in structured text", st.number());
    out += &format!(
        "## Use\n\nCall a function block once every {} s, in a task of that period.\n\n",
        shortest(wanted.model.ts(), false)
    );
    out += "```text\nVAR\n";
    let mut calls = String::new();
    for entry in &st.whole.entries {
        let own = entry.called();
        let given: Vec<String> = entry.inputs.iter().map(|i| format!("{} := {}", i.name, i.name)).collect();
        out += &format!("    {own} : {};\n", st.block_of(entry));
        calls += &format!(
            "{own}({}, reset := FALSE, {} => {}); {}",
            given.join(", "),
            entry.output.name,
            entry.output.name,
            comment(std::slice::from_ref(&entry.about)),
        );
    }
    out += &format!("END_VAR\n{calls}```\n\n");
    out += &format!(
        "`{name}.st` holds types, functions and function blocks in the order of use. Where a tool imports text, import it whole; in CODESYS 3 and \
         TwinCAT 3 each `TYPE`, `FUNCTION` and `FUNCTION_BLOCK` goes into an object of its name, declarations above and statements below. \
         An instance begins at rest, and again where `reset` is TRUE. Inputs have to be finite numbers: many controllers stop at others.\n\n"
    );
    out += "## How it is written\n\n\
            For IEC 61131-3, second and third edition, as CODESYS 3 and TwinCAT 3 have it: no methods, references, pointers or globals. States are \
            structures, which functions take as `VAR_IN_OUT` and change; a second result is a `VAR_OUTPUT`. Tables are fields with initial values of a \
            structure of their own, one in each instance, since functions see no globals and would lay out tables among their own constants anew \
            in every call. Names that the language has taken, or that differ in capitals alone, end in a number. `AND` and `OR` may look at both \
            sides; whole numbers are `DINT`; `TRUNC` gives one. Not for SCL of Siemens, which wants `#` before local names.\n\n";
    out += "## Proof\n\n";
    out += &format!(
        "`{name}_test.st` is a program that feeds {SAMPLES} samples, one a cycle, and counts in `differs` those that are not what piezoid computes, bit by \
         bit: 0 where the machine computes as IEEE 754 has it and keeps no longer numbers between. "
    );
    out += &moved(wanted, st.whole, |entry| st.block_of(entry));
    out + "No vendor's compiler has seen it: the grammar of TwinCAT in blark takes the library, and a strict reader in \
     piezoid's tests runs both files and finds the same bits.\n"
}
