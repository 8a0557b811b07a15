//! The C around the model: what is particular to it, then what every FMU has in common, then the functions of the version.

use super::Fmu;
use super::variables::parts;
use piezoid::system::System;

/// What every FMU has in common.
const COMMON: [&str; 2] = [include_str!("instance.c"), include_str!("kept.c")];

pub(super) fn source(fmu: &Fmu, token: &str) -> String {
    let (entry, name, single) = (fmu.entry(), fmu.wanted.name, fmu.wanted.single);
    let (number, largest) = if single { ("float", "FLT_MAX") } else { ("double", "DBL_MAX") };
    let n = entry.inputs.len();
    let inputs: String = (0..n).map(|k| format!(", (number)input[{k}]")).collect();
    let (mut places, mut first) = (String::new(), 0);
    for part in parts(&fmu.whole.program, entry.state, "") {
        let (so_far, path) = (first, &part.path);
        first += part.at_rest.len();
        let index = match (part.array, so_far) {
            (false, _) => String::new(),
            (true, 0) => "[k]".into(),
            (true, so_far) => format!("[k - {so_far}u]"),
        };
        let or = if so_far == 0 { "" } else { "} else " };
        places += &format!("    {or}if (k < {first}u) {{\n        at = &s->{path}{index};\n");
    }
    let head = format!(
        "\
/* {fmu_name}_fmu.c: {about}, for co-simulation by FMI {version}.

   A step from t to t + n TS runs n samples, the input held: the output after it is the sample that belongs to the last
   of them. Any other step is refused, and so are values that are not finite, variables that there are none of, and
   calls out of turn; the logger is told why, and what was refused changes nothing. Instances share nothing. */
#include \"{name}.h\"
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What is particular to this FMU */

#define TOKEN \"{token}\"
#define TS {ts:?} /* sampling period [s] */
#define LARGEST {largest}

typedef {number} number;
typedef {name}_{state} State;

/* Value references: the first of each kind, as modelDescription.xml counts them. */
enum {{
    TIME = 0,
    INPUT = 1,
    GAIN = {gain},
    OFFSET = {offset},
    OUTPUT = {output},
    PERIOD = {period},
    STATE = {states},
    VARIABLES = {variables},
    INPUTS = {n}
}};

static void rest(State *s)
{{
    {name}_{reset}(s);
}}

static double sample(State *s, const double input[INPUTS])
{{
    return (double){name}_{step}(s{inputs});
}}

/* The number that stands at k in the state, counted from 0. */
static number *place(State *s, unsigned int k)
{{
    number *at = NULL;
{places}    }}
    return at;
}}
",
        fmu_name = fmu.name,
        about = entry.about,
        version = fmu.version.number,
        ts = fmu.wanted.model.ts(),
        state = entry.state,
        gain = 1 + n,
        offset = 1 + 2 * n,
        output = 1 + 3 * n,
        period = 2 + 3 * n,
        states = 3 + 3 * n,
        variables = fmu.variables.len(),
        reset = entry.reset,
        step = entry.step,
    );
    [&head, COMMON[0], COMMON[1], fmu.version.functions].join("\n")
}
