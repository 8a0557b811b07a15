//! The variables of an FMU, in the order of their value references.

use crate::ExportRequest;
use crate::exported::Entry;
use crate::template::{Value, context};
use piezoid::{System, Units};
use piezoid_models::program::{Field, FieldValue, Program};

/// `causality`, `variability` and `initial`, in both versions of the standard.
type Attributes = [&'static str; 3];

const TIME: Attributes = ["independent", "continuous", ""];
/// Continuous although it is held between samples: otherwise nothing continuous could be connected to it.
const INPUT: Attributes = ["input", "continuous", ""];
const PARAMETER: Attributes = ["parameter", "tunable", "exact"];
const OUTPUT: Attributes = ["output", "discrete", "calculated"];
const CONSTANT: Attributes = ["local", "constant", "exact"];
/// Can be set before the first step.
const STATE: Attributes = ["local", "discrete", "exact"];

/// A part of a state: the numbers of one field.
struct Part {
    /// The path of fields, in C notation.
    path: String,
    /// Description of its block.
    about: String,
    at_rest: Vec<f64>,
    /// True for an array, even of one number.
    array: bool,
}

/// The parts of the state of a block, with those of inner blocks.
fn parts(program: &Program, block: &str, prefix: &str) -> Vec<Part> {
    let Some(block) = program.block(block) else { return Vec::new() };
    let part = |name: &str, at_rest: &[f64], array| {
        vec![Part { path: format!("{prefix}{name}"), about: block.about.clone(), at_rest: at_rest.to_vec(), array }]
    };
    let parts = |field: &Field| match &field.holds {
        FieldValue::Number(value) => part(&field.name, &[*value], false),
        FieldValue::Numbers(values) => part(&field.name, values, true),
        FieldValue::Block(inner) => parts(program, inner, &format!("{prefix}{}.", field.name)),
    };
    block.fields.iter().flat_map(parts).collect()
}

/// The template context of an entry: its variables (time, inputs, their gains, their offsets, output, sampling period),
/// the numbers and parts of its state, and all units.
pub(super) fn template_context(request: &ExportRequest, program: &Program, entry: &Entry) -> Value {
    let mut count = 0;
    let mut variable = |role: Attributes, name: &str, about: &str, unit: &str, start: Option<f64>| {
        let [causality, variability, initial] = role;
        count += 1;
        context! { reference => count - 1, name, about, unit, start, causality, variability, initial }
    };
    let mut variables = vec![variable(TIME, "time", "time of the last communication point", "s", None)];
    variables.extend(entry.inputs.iter().map(|i| variable(INPUT, i.name, i.about, &i.unit, Some(0.0))));
    variables.extend(entry.inputs.iter().map(|i| {
        let about = format!("gain applied to {}", i.name);
        variable(PARAMETER, &format!("{}_gain", i.name), &about, "", Some(1.0))
    }));
    variables.extend(entry.inputs.iter().map(|i| {
        let about = format!("offset added to {} after the gain", i.name);
        variable(PARAMETER, &format!("{}_offset", i.name), &about, &i.unit, Some(0.0))
    }));
    let output = &entry.output;
    variables.push(variable(OUTPUT, output.name, output.about, &output.unit, None));
    variables.push(variable(CONSTANT, "ts", "sampling period", "s", Some(request.model.ts())));
    let (mut states, mut places, mut first) = (Vec::new(), Vec::new(), 0);
    for Part { path, about, at_rest, array } in parts(program, entry.state, "") {
        for (k, at_rest) in at_rest.iter().enumerate() {
            let index = if array { format!("[{}]", k + 1) } else { String::new() };
            let start = if request.options.float { f64::from(*at_rest as f32) } else { *at_rest };
            let (name, about) = (format!("state.{path}{index}"), format!("state of {about}"));
            states.push(variable(STATE, &name, &about, "", Some(start)));
        }
        let end = first + at_rest.len();
        places.push(context! { first, end, path, array });
        first = end;
    }
    let mut units: Vec<&str> = entry.inputs.iter().chain([output]).map(|signal| &*signal.unit).collect();
    units.push("s");
    units.retain(|unit| !unit.is_empty());
    units.sort_unstable();
    units.dedup();
    let unit = |name: &str| context! { name, metres => Units::factor(name, "m") };
    context! { variables, states, places, units => units.into_iter().map(unit).collect::<Value>() }
}
