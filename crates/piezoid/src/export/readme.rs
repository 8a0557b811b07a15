//! The page that goes with exported code: what is there, how to use it, what it takes, how it was proved.

use super::Wanted;
use super::whole::Whole;
use crate::number::{round, short};
use crate::program::{Counts, Expr};

/// Bytes of a number.
fn bytes(single: bool) -> usize {
    if single { 4 } else { 8 }
}

/// What stands first: what was identified, in which language and numbers, and what is not here.
pub(super) fn opening(wanted: &Wanted, whole: &Whole, language: &str, number: &str) -> String {
    let model = wanted.model;
    let mut out = format!(
        "# {}\n\nA piezo actuator as {language}, identified by piezoid: hysteresis `{}`, {} lags of creep, a linear block of order {}, sampled every {} s. \
         Numbers are `{number}`.\n\n",
        wanted.name,
        model.hysteresis().operator().name,
        model.creep().lags().len(),
        model.linear().a().len(),
        round(crate::System::ts(model)),
    );
    for note in &whole.notes {
        out += &format!("**Not here**: {note}\n\n");
    }
    out
}

pub(super) fn readme(wanted: &Wanted, whole: &Whole) -> String {
    let name = wanted.name;
    let number = if wanted.single { "float" } else { "double" };
    let upper = name.to_uppercase();
    let mut out = opening(wanted, whole, "C99", number);
    out += "## Use\n\n```c\n";
    out += &format!("#include \"{name}.h\"\n\n");
    for entry in &whole.entries {
        let s = entry.step.trim_end_matches("step").trim_end_matches('_');
        let s = if s.is_empty() { "model" } else { s };
        let inputs: Vec<&str> = entry.inputs.iter().map(|i| i.name).collect();
        out += &format!(
            "{name}_{} {s};{pad}/* yours to keep */\n{name}_{}(&{s});\n{} = {name}_{}(&{s}, {}); /* every {upper}_TS seconds: {} */\n",
            entry.state,
            entry.reset,
            entry.output.name,
            entry.step,
            inputs.join(", "),
            entry.about,
            pad = " ",
        );
    }
    out += "```\n\nNo heap, no globals that change, no recursion, no library: functions may be called from several tasks, each with a state of \
            its own. Inputs of the model have to be finite numbers. The feed-forward takes one that is not for the one before, the controller a reading that is not for no error.\n\n";
    out += "## What it takes\n\n| function | state | sums | products | quotients | comparisons | all, most seen |\n|---|--:|--:|--:|--:|--:|--:|\n";
    for entry in &whole.entries {
        let vectors = &entry.vectors;
        let Counts { sums, products, quotients, comparisons } = vectors.mean;
        out += &format!(
            "| `{name}_{}` | {} bytes | {sums} | {products} | {quotients} | {comparisons} | {} |\n",
            entry.step,
            whole.program.order(entry.state) * bytes(wanted.single),
            vectors.most,
        );
    }
    let machine = match wanted.single {
        true => "On a Cortex-M4F count two to four instructions to an operation.",
        false => {
            "A Cortex-M4F has no unit for doubles: every operation is a call of a library there, and `--float` many times faster."
        }
    };
    out += &format!(
        "\nOperations on `{number}` a sample, on average along the vectors of the self-test and the most that one of these samples took, which is no bound: searches \
         that go backwards through hysteresis take more steps now and then. Constants take {} bytes. {machine}\n\n",
        constants(whole) * bytes(wanted.single),
    );
    for missed in whole.entries.iter().filter_map(|entry| entry.vectors.missed) {
        let preview = wanted.preview;
        out += &format!(
            "Behind the feed-forward, given r {preview} samples ahead of time, the model misses r by {} of its height, rms, along these vectors, which move \
             fast. `--preview` with more samples comes closer.\n\n",
            short(missed),
        );
    }
    out += "## Proof\n\n";
    out += &format!(
        "```sh\ncc -std=c99 -O2 -ffp-contract=off {name}.c {name}_test.c -o {name}_test && ./{name}_test\n```\n\n"
    );
    out += "The self-test compares with what piezoid computes, bit by bit. ";
    if wanted.single {
        for entry in &whole.entries {
            let vectors = &entry.vectors;
            out += &format!(
                "Single precision moves `{name}_{}` by {} of its stroke at most. ",
                entry.step,
                short(vectors.off)
            );
        }
    }
    out += "Products and sums that a compiler contracts into one instruction (`-ffp-contract=fast`, the default of GCC without `-std=c99`) give other last digits: \
            harmless, but the self-test then counts them; so does `-ffast-math`, which is not: do without it.\n\n";
    out += "## Rules\n\nWritten with MISRA C:2012 in mind; no checker has certified it. Kept: no dynamic memory (21.3), no recursion (17.2), one return to a \
            function (15.5), braces everywhere (15.6), `else` after `else if` (15.7), no jumps (15.1), no name hides another (5.3), parameters stay as they \
            were given (17.8), results of functions used or cast to void (17.7); loops end for every input. Not kept: `int`, `float` and `double` \
            instead of names with sizes (directive 4.6), brackets only where precedence needs them (12.1), more than 31 letters in names inside the file. Numbers are compared \
            for equality where that is what is meant.\n";
    out
}

/// Constants that are read.
fn constants(whole: &Whole) -> usize {
    let mut read = Vec::new();
    for function in &whole.program.functions {
        function.expressions(&mut |expr| {
            if let Expr::Constant(block, name, _) = expr {
                read.push((*block, name.clone()));
            }
        });
    }
    let blocks = whole.program.blocks.iter().enumerate();
    blocks
        .flat_map(|(number, block)| block.constants.iter().map(move |constant| (number, constant)))
        .filter(|(number, constant)| read.contains(&(*number, constant.name.clone())))
        .map(|(_, constant)| constant.values.len())
        .sum()
}
