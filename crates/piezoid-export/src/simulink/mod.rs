//! Simulink and MATLAB: the C of target `c`, a level-2 S-function around each of its entries, and a class that needs no
//! compiler.
//!
//! There is no TLC file: Simulink Coder calls the S-function as it is. Nothing here was run in Simulink, which is not free: the
//! tests have a stand-in for its headers. The class is run in GNU Octave.

mod alone;
mod class;
mod matlab;
mod sfunction;

use self::matlab::Matlab;
use self::sfunction::block;
use super::c::{C, checked};
use super::readme::{moved, opening};
use super::whole::{Entry, Whole};
use super::{CODE, File, Made, Target, Wanted};

pub(super) const TARGET: Target = Target {
    name: "simulink",
    summary: "S-functions in C for Simulink, and a class for MATLAB and GNU Octave, in double or single precision",
    reference: "MathWorks, Writing S-Functions: level-2 C MEX S-functions",
    heeds: CODE,
    make: |wanted| {
        let whole = checked(wanted)?;
        let matlab = Matlab::of(&whole, wanted)?;
        let (c, name) = (C::of(&whole, wanted), wanted.name);
        let mut files = vec![
            File::text(format!("{name}.h"), c.header(&whole, wanted)),
            File::text(format!("{name}.c"), c.source(&whole)),
            File::text(format!("{name}.m"), matlab.class(&whole, wanted)),
            File::text(format!("{name}_test.m"), matlab.test(&whole)),
            File::text(format!("{name}_build.m"), build(name, &whole)),
            File::text(format!("{}.md", wanted.name), readme(wanted, &whole)),
        ];
        files.extend(
            whole.entries.iter().map(|entry| File::text(format!("{}.c", sfun(name, entry)), block(wanted, entry))),
        );
        Ok(Made { files, notes: whole.notes })
    },
};

/// Whether what `entry` gives depends on what it is given in the same sample.
fn direct(wanted: &Wanted, entry: &Entry) -> bool {
    entry.step != "step" || wanted.model.linear().b().first().is_some_and(|b0| *b0 != 0.0)
}

/// The S-function of an entry.
fn sfun(name: &str, entry: &Entry) -> String {
    format!("{}_sfun", entry.named(name))
}

/// Its inputs, as a call has them.
fn inputs(entry: &Entry) -> String {
    entry.inputs.iter().map(|i| i.name).collect::<Vec<_>>().join(", ")
}

/// `text` in one line.
fn line(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ")
}

/// What compiles the S-functions.
fn build(name: &str, whole: &Whole) -> String {
    let blocks: Vec<String> = whole.entries.iter().map(|entry| format!("'{}'", sfun(name, entry))).collect();
    format!(
        "function {name}_build(system)
%{upper}_BUILD  Compiles the S-functions of {name} for Simulink.
%   {name}_build() compiles them, with the compiler that mex -setup C has chosen.
%   {name}_build(system) also puts their blocks into this model, which must be open.
    here = fileparts(mfilename('fullpath'));
    blocks = {{{list}}};
    for k = 1:numel(blocks)
        mex('-outdir', here, fullfile(here, [blocks{{k}} '.c']), fullfile(here, '{name}.c'));
        if nargin > 0
            place = sprintf('%s/%s', system, blocks{{k}});
            add_block('simulink/User-Defined Functions/S-Function', place, 'FunctionName', blocks{{k}});
        end
    end
    fprintf('Compiled: %s.\\n', strjoin(blocks, ', '));
    if nargin == 0
        fprintf('Now put an S-Function block (User-Defined Functions) into a model and give it one of these names,\\n');
        fprintf('or let {name}_build(''model'') do it. {name}_test proves them.\\n');
    end
end
",
        upper = name.to_uppercase(),
        list = blocks.join(", "),
    )
}

/// The page that goes with it.
fn readme(wanted: &Wanted, whole: &Whole) -> String {
    let name = wanted.name;
    let number = if wanted.single { "single" } else { "double" };
    let mut out = opening(wanted, whole, "S-functions and a class", number);
    out += &format!("## MATLAB and Octave\n\n```matlab\nmodel = {name}();\n");
    for entry in &whole.entries {
        let call = format!("{} = model.{}({});", entry.output.name, entry.step, inputs(entry));
        out += &format!("{call} % every {name}.Ts seconds: {}\n", line(&entry.about));
    }
    out += &format!("y = model.simulate(u); % a row or column, from rest\nhelp {name}\n```\n\n");
    out += "No toolbox is needed. ";
    out += &format!(
        "`{name}_test` runs the class on recorded inputs and compares with what piezoid computes, bit by bit. "
    );
    out += &moved(wanted, whole, |entry| entry.step.into());
    out += "\n\n## Simulink\n\n";
    out += &format!("```matlab\nmex -setup C % once\n{name}_build\n```\n\n");
    out += "| S-function | input | output | direct feedthrough |\n|---|---|---|---|\n";
    for entry in &whole.entries {
        let cell = |text: &str| line(text).replace('|', "\\|");
        let inputs: Vec<String> = entry.inputs.iter().map(|i| format!("{} [{}]", i.name, cell(&i.unit))).collect();
        out += &format!(
            "| `{}` | {} | {} [{}] | {} |\n",
            sfun(name, entry),
            inputs.join(", "),
            entry.output.name,
            cell(&entry.output.unit),
            if direct(wanted, entry) { "yes" } else { "no: what comes in shows in the next sample first" },
        );
    }
    out += &format!(
        "\nPut an *S-Function* block into a model and give it one of these names. Ports are scalar and `double`, the sample \
         time is fixed: put *Rate Transition* blocks around what runs at another. Each block has a state of its own, which \
         saved simulations hold and which a subsystem that resets its states resets. Once compiled, `{name}_test` runs the \
         S-functions in a model too.\n\n\
         Simulink Coder takes the block as it is: enter `{name}` under *S-function modules* of the block, so that \
         `{name}.c` is compiled with the model, and allow noninlined S-functions where the target asks. To have the step \
         inlined, a TLC file would include `{name}.h`, and call the reset and step functions on the block's DWork `state`.\n\n\
         The S-functions were compiled and run behind a stand-in for Simulink's headers, not in Simulink; the class was run \
         in GNU Octave 7.\n"
    );
    out
}
