//! A level-2 S-function around an entry.
//!
//! The state stands where Simulink keeps it (DWork), so that a block may be in a model many times, and in a simulation that is saved
//! and taken up again. `mdlOutputs` steps a copy, as Simulink may ask for the output of a sample several times, in an algebraic
//! loop; only `mdlUpdate` takes the state on. What a linear block without a direct path (b0 = 0) is given shows in the next sample
//! first: its S-function says so, and closes no algebraic loop.

use super::{direct, line, sfun};
use crate::Wanted;
use crate::c::shortest;
use crate::whole::Entry;
use piezoid::system::System;

/// The S-function of an entry.
pub(super) fn block(wanted: &Wanted, entry: &Entry) -> String {
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
