//! Simulink and MATLAB: the C of target `c`, a level-2 S-function around each of its entries, and a class that needs neither.
//!
//! An S-function keeps its state where Simulink does (DWork), so that a block may stand in a model many times, and in a simulation that is
//! saved and taken up again. `mdlOutputs` steps a copy: Simulink may ask for the output of a sample several times, as in an algebraic loop.
//! Only `mdlUpdate` takes the state on. What a linear block without a direct path (b0 = 0) is given shows in the next sample first; its
//! S-function says so, and closes no algebraic loop.
//!
//! There is no TLC file: Simulink Coder calls the S-function as it is. Nothing here was run in Simulink, which is not free: the tests have
//! a stand-in for its headers. The class is run in GNU Octave.

use super::c::{C, checked, shortest};
use super::matlab::{Matlab, line, sfun};
use super::whole::{Entry, Whole};
use super::{File, Made, Target, Wanted};
use crate::number::round;
use crate::system::System;

pub(super) const TARGET: Target = Target {
    name: "simulink",
    summary: "S-functions in C for Simulink, and a class for MATLAB and GNU Octave, in double or single precision",
    reference: "MathWorks, Writing S-Functions: level-2 C MEX S-functions",
    make: |wanted| {
        let whole = checked(wanted)?;
        let matlab = Matlab::of(&whole, wanted)?;
        let vectors = whole.vectors(wanted)?;
        let (c, name) = (C::of(&whole, wanted), wanted.name);
        let mut files = vec![
            File::text(format!("{name}.h"), c.header(&whole, wanted)),
            File::text(format!("{name}.c"), c.source(&whole)),
            File::text(format!("{name}.m"), matlab.class(&whole, wanted, &vectors)),
            File::text(format!("{name}_test.m"), matlab.test(&whole, &vectors)),
            File::text(format!("{name}_build.m"), build(name, &whole)),
            File::text("README.md", readme(wanted, &whole)),
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
fn block(wanted: &Wanted, entry: &Entry) -> String {
    let (name, sfun, direct) = (wanted.name, sfun(wanted.name, entry), direct(wanted, entry));
    let (state, step, reset) =
        (format!("{name}_{}", entry.state), format!("{name}_{}", entry.step), format!("{name}_{}", entry.reset));
    let (number, kind, zero) =
        if wanted.single { ("float", "SS_SINGLE", "0.0f") } else { ("double", "SS_DOUBLE", "0.0") };
    let comment = |text: &str| line(text).replace("*/", "* /");
    let inputs: String =
        entry.inputs.iter().map(|i| format!("   Input: {} [{}], {}.\n", i.name, comment(&i.unit), i.about)).collect();
    let read: String = (0..entry.inputs.len())
        .zip(&entry.inputs)
        .map(|(k, i)| format!("    const real_T *{} = ssGetInputPortRealSignal(S, {k});\n", i.name))
        .collect();
    let given: String = entry
        .inputs
        .iter()
        .map(|i| if wanted.single { format!(", ({number}){}[0]", i.name) } else { format!(", {}[0]", i.name) })
        .collect();
    let none: String = entry.inputs.iter().map(|_| format!(", {zero}")).collect();
    let (reads, asked, why) = match direct {
        true => {
            (read.clone(), given.clone(), "A copy goes on: the output may be asked for again in an algebraic loop.")
        }
        false => (String::new(), none, "A copy goes on, and whatever its input is, it shows in the next sample first."),
    };
    let (n, feedthrough, output) = (entry.inputs.len(), i32::from(direct), entry.output.name);
    format!(
        "/* {sfun}.c: Simulink block of {about}.
   One step is one sample of {ts} s; arithmetic is that of {name}.c, in {precision} precision.
{inputs}   Output: {output} [{unit}], {what}.
   {name}_build.m compiles it. */
#define S_FUNCTION_NAME {sfun}
#define S_FUNCTION_LEVEL 2

#include \"simstruc.h\"
#include \"{name}.h\"

#define INPUTS {n}

static void mdlInitializeSizes(SimStruct *S)
{{
    ssSetNumSFcnParams(S, 0);
    if (ssGetNumSFcnParams(S) != ssGetSFcnParamsCount(S)) {{
        return; /* Simulink tells */
    }}
    if (!ssSetNumInputPorts(S, INPUTS) || !ssSetNumOutputPorts(S, 1) || !ssSetNumDWork(S, 1)) {{
        return;
    }}
    for (int_T k = 0; k < INPUTS; k++) {{
        ssSetInputPortWidth(S, k, 1);
        ssSetInputPortDataType(S, k, SS_DOUBLE);
        ssSetInputPortComplexSignal(S, k, COMPLEX_NO);
        ssSetInputPortRequiredContiguous(S, k, 1);
        ssSetInputPortDirectFeedThrough(S, k, {feedthrough});
    }}
    ssSetOutputPortWidth(S, 0, 1);
    ssSetOutputPortDataType(S, 0, SS_DOUBLE);
    ssSetOutputPortComplexSignal(S, 0, COMPLEX_NO);

    /* The state is numbers of one type alone, which Simulink keeps for each block, saves and restores. */
    ssSetDWorkName(S, 0, \"state\");
    ssSetDWorkWidth(S, 0, (int_T)(sizeof({state}) / sizeof({number})));
    ssSetDWorkDataType(S, 0, {kind});
    ssSetDWorkComplexSignal(S, 0, COMPLEX_NO);
    ssSetDWorkUsageType(S, 0, SS_DWORK_USED_AS_DSTATE);
    ssSetSimStateCompliance(S, USE_DEFAULT_SIM_STATE);

    ssSetNumSampleTimes(S, 1);
    ssSetOptions(S, SS_OPTION_EXCEPTION_FREE_CODE | SS_OPTION_WORKS_WITH_CODE_REUSE);
}}

static void mdlInitializeSampleTimes(SimStruct *S)
{{
    ssSetSampleTime(S, 0, {ts});
    ssSetOffsetTime(S, 0, 0.0);
}}

/* At the start, and wherever a subsystem around the block resets it. */
#define MDL_INITIALIZE_CONDITIONS
static void mdlInitializeConditions(SimStruct *S)
{{
    {reset}(({state} *)ssGetDWork(S, 0));
}}

static void mdlOutputs(SimStruct *S, int_T tid)
{{
{reads}    real_T *{output} = ssGetOutputPortRealSignal(S, 0);
    {state} next = *(const {state} *)ssGetDWork(S, 0);

    UNUSED_ARG(tid);
    /* {why} */
    {output}[0] = {step}(&next{asked});
}}

#define MDL_UPDATE
static void mdlUpdate(SimStruct *S, int_T tid)
{{
{read}
    UNUSED_ARG(tid);
    (void){step}(({state} *)ssGetDWork(S, 0){given});
}}

static void mdlTerminate(SimStruct *S)
{{
    UNUSED_ARG(S);
}}

#ifdef MATLAB_MEX_FILE
#include \"simulink.c\"
#else
#include \"cg_sfun.h\"
#endif
",
        about = comment(&entry.about),
        ts = shortest(wanted.model.ts(), false),
        precision = if wanted.single { "single" } else { "double" },
        unit = comment(&entry.output.unit),
        what = entry.output.about,
    )
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
    let (name, model) = (wanted.name, wanted.model);
    let mut out = format!("# {name}\n\n");
    out += &format!(
        "A piezo actuator for MATLAB, Simulink and GNU Octave, identified by piezoid: hysteresis `{}`, {} lags of creep, a linear block of \
         order {}, sampled every {} s. Arithmetic is of {} precision.\n\n",
        model.hysteresis().operator().name,
        model.creep().lags().len(),
        model.linear().a().len(),
        round(model.ts()),
        if wanted.single { "single" } else { "double" },
    );
    for note in &whole.notes {
        out += &format!("**Not here**: {note}\n\n");
    }
    out += &format!("## MATLAB and Octave\n\n```matlab\nmodel = {name}();\n");
    for entry in &whole.entries {
        let inputs: Vec<&str> = entry.inputs.iter().map(|i| i.name).collect();
        let call = format!("{} = model.{}({});", entry.output.name, entry.step, inputs.join(", "));
        out += &format!("{call} % every {name}.Ts seconds: {}\n", line(&entry.about));
    }
    out += &format!("y = model.simulate(u); % a row or column, from rest\nhelp {name}\n```\n\n");
    out += "No toolbox is needed. ";
    out += &format!(
        "`{name}_test` runs the class on recorded inputs and compares with what piezoid computes, bit by bit.\n\n"
    );
    out += "## Simulink\n\n";
    out += &format!(
        "```matlab\nmex -setup C % once\n{name}_build\n```\n\n| S-function | input | output | direct feedthrough |\n|---|---|---|---|\n"
    );
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
        "\nPut an *S-Function* block into a model and give it one of these names. Ports are scalar and `double`, the sample time is fixed: put \
         *Rate Transition* blocks around what runs at another. Each block has a state of its own, which saved simulations hold and which a \
         subsystem that resets its states resets. Once compiled, `{name}_test` runs the S-functions in a model too.\n\n"
    );
    out += &format!(
        "Simulink Coder takes the block as it is: enter `{name}` under *S-function modules* of the block, so that `{name}.c` is compiled with the \
         model, and allow noninlined S-functions where the target asks. To have the step inlined, a TLC file would include `{name}.h`, and call \
         the reset and step functions on the block's DWork `state`.\n\n"
    );
    out += "The S-functions were compiled and run behind a stand-in for Simulink's headers, not in Simulink; the class was run in GNU Octave 7.\n";
    out
}
