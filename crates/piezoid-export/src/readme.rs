//! The page that goes with exported code: what is there, how to use it, what it takes, how it was proved.

use super::Wanted;
use super::whole::{Entry, Whole};
use piezoid::number::{round, short};
use piezoid::program::Counts;
use piezoid::system::System;

/// Bytes of a number.
fn bytes(single: bool) -> usize {
    if single { 4 } else { 8 }
}

/// What stands first: what was identified, in which language and numbers, and what is not here.
pub(super) fn opening(wanted: &Wanted, whole: &Whole, language: &str, number: &str) -> String {
    let model = wanted.model;
    let out = format!(
        "# {}\n\nA piezo actuator as {language}, identified by piezoid: hysteresis `{}`, creep of order {}, a linear block of order {}, sampled every {} s. \
         Numbers are `{number}`.\n\n",
        wanted.name,
        model.hysteresis().operator().name,
        model.creep().order(),
        model.linear().a().len(),
        round(model.ts()),
    );
    out + &noted(whole)
}

/// What is not here, and what is worth knowing.
pub(super) fn noted(whole: &Whole) -> String {
    whole.notes.iter().map(|note| format!("**Note**: {note}\n\n")).collect()
}

/// How each entry is called in C: `every` is the time between two calls.
pub(super) fn calls(name: &str, whole: &Whole, every: &str) -> String {
    let mut out = format!("## Use\n\n```c\n#include \"{name}.h\"\n\n");
    for entry in &whole.entries {
        let s = entry.called();
        let inputs: String = entry.inputs.iter().map(|i| format!(", {}", i.name)).collect();
        out += &format!("{name}_{} {s}; /* yours to keep */\n{name}_{}(&{s});\n", entry.state, entry.reset);
        let (output, step, about) = (entry.output.name, entry.step, &entry.about);
        out += &format!("{output} = {name}_{step}(&{s}{inputs}); /* every {every}: {about} */\n");
    }
    out + "```\n\n"
}

/// What a sample of each entry takes, its state in bytes as `bytes` says.
pub(super) fn taken(name: &str, whole: &Whole, bytes: impl Fn(&str) -> usize) -> String {
    let mut out =
        "## What it takes\n\n| function | state | sums | products | quotients | comparisons | all, most seen |\n\
                   |---|--:|--:|--:|--:|--:|--:|\n"
            .to_owned();
    for entry in &whole.entries {
        let Counts { sums, products, quotients, comparisons } = entry.vectors.mean;
        let (step, state, most) = (entry.step, bytes(entry.state), entry.vectors.most);
        out += &format!(
            "| `{name}_{step}` | {state} bytes | {sums} | {products} | {quotients} | {comparisons} | {most} |\n"
        );
    }
    out + "\n"
}

/// What single precision moves, if it is that of the entries, which users call as `called` says.
pub(super) fn moved(wanted: &Wanted, whole: &Whole, called: impl Fn(&Entry) -> String) -> String {
    let each = whole.entries.iter().filter(|_| wanted.single);
    each.map(|entry| {
        let off = short(entry.vectors.off);
        format!("Single precision moves `{}` by {off} of its stroke at most. ", called(entry))
    })
    .collect()
}

pub(super) fn readme(wanted: &Wanted, whole: &Whole) -> String {
    let name = wanted.name;
    let number = if wanted.single { "float" } else { "double" };
    let mut out = opening(wanted, whole, "C99", number);
    out += &calls(name, whole, &format!("{}_TS seconds", name.to_uppercase()));
    out += "No heap, no globals that change, no recursion, no library: functions may be called from several tasks, each with a state of \
            its own. Inputs of the model have to be finite numbers. The feed-forward takes one that is not for the one before, the controller a reading that is not for no error.\n\n";
    out += &taken(name, whole, |state| whole.program.order(state) * bytes(wanted.single));
    let machine = match wanted.single {
        true => "On a Cortex-M4F count two to four instructions to an operation.",
        false => {
            "A Cortex-M4F has no unit for doubles: every operation is a call of a library there, and `--float` many times faster."
        }
    };
    out += &format!(
        "Operations on `{number}` a sample, on average along the vectors of the self-test and the most that one of these samples took, which is no bound: searches \
         that go backwards through hysteresis take more steps now and then. Constants take {} bytes. {machine}\n\n",
        whole.program.blocks.iter().flat_map(|b| &b.constants).map(|c| c.values.len()).sum::<usize>()
            * bytes(wanted.single),
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
    out += &moved(wanted, whole, |entry| format!("{name}_{}", entry.step));
    out += "Products and sums that a compiler contracts into one instruction (`-ffp-contract=fast`, the default of GCC without `-std=c99`) give other last digits: \
            harmless, but the self-test then counts them; so does `-ffast-math`, which is not: do without it.\n\n";
    out += "## Rules\n\nWritten with MISRA C:2012 in mind; no checker has certified it. Kept: no dynamic memory (21.3), no recursion (17.2), one return to a \
            function (15.5), braces everywhere (15.6), `else` after `else if` (15.7), no jumps (15.1), no name hides another (5.3), parameters stay as they \
            were given (17.8), results of functions used or cast to void (17.7); loops end for every input. Not kept: `int`, `float` and `double` \
            instead of names with sizes (directive 4.6), brackets only where precedence needs them (12.1), more than 31 letters in names inside the file. Numbers are compared \
            for equality where that is what is meant.\n";
    out
}
