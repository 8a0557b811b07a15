//! The variables of an FMU: what can be seen and set from outside, in the order of their value references.

use super::super::Wanted;
use super::super::whole::Entry;
use super::xml::Element;
use piezoid::program::{Holds, Program};
use piezoid::record::factor;
use piezoid::system::System;

/// A variable; its value reference is its place in the list.
pub(super) struct Variable {
    /// As tools show it.
    pub(super) name: String,
    /// What it is.
    pub(super) about: String,
    /// Its unit, empty if it has none that is known.
    pub(super) unit: String,
    /// Which role it has.
    pub(super) role: Role,
    /// What it begins with, unless it is calculated.
    pub(super) start: Option<f64>,
}

/// What the importer may do with a variable.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// Read it: the time.
    Time,
    /// Set it before every step.
    Input,
    /// Set it at any communication point.
    Parameter,
    /// Read it.
    Output,
    /// Read it: it never changes.
    Constant,
    /// Set it before the first step.
    State,
}

impl Role {
    /// `causality`, `variability` and `initial` in the words of both versions of the standard.
    pub(super) fn words(self) -> (&'static str, &'static str, Option<&'static str>) {
        match self {
            Role::Time => ("independent", "continuous", None),
            // Continuous, though it is held between samples: nothing continuous could be connected to it otherwise.
            Role::Input => ("input", "continuous", None),
            Role::Parameter => ("parameter", "tunable", Some("exact")),
            Role::Output => ("output", "discrete", Some("calculated")),
            Role::Constant => ("local", "constant", Some("exact")),
            Role::State => ("local", "discrete", Some("exact")),
        }
    }
}

/// A part of a state: several numbers of one field.
pub(super) struct Part {
    /// The fields that lead to it, as C writes them.
    pub(super) path: String,
    /// What it is a state of.
    pub(super) about: String,
    /// Its numbers at rest.
    pub(super) at_rest: Vec<f64>,
    /// Whether it is an array, even of one.
    pub(super) array: bool,
}

/// The parts of the state of a block, those of inner blocks included.
pub(super) fn parts(program: &Program, block: &str, prefix: &str) -> Vec<Part> {
    let Some(block) = program.block(block) else { return Vec::new() };
    let part = |name: &str, at_rest: &[f64], array| {
        vec![Part { path: format!("{prefix}{name}"), about: block.about.clone(), at_rest: at_rest.to_vec(), array }]
    };
    let parts = |field: &piezoid::program::Field| match &field.holds {
        Holds::Number(value) => part(&field.name, &[*value], false),
        Holds::Numbers(values) => part(&field.name, values, true),
        Holds::Block(inner) => parts(program, inner, &format!("{prefix}{}.", field.name)),
    };
    block.fields.iter().flat_map(parts).collect()
}

/// The variables of an entry: time, inputs, their gains, their offsets, the output, the sampling period, the state.
pub(super) fn of(wanted: &Wanted, program: &Program, entry: &Entry) -> Vec<Variable> {
    let variable =
        |role, name: String, about: String, unit: &str, start| Variable { name, about, unit: unit.into(), role, start };
    let mut all = vec![variable(Role::Time, "time".into(), "time of the last communication point".into(), "s", None)];
    for input in &entry.inputs {
        all.push(variable(Role::Input, input.name.into(), input.about.into(), &input.unit, Some(0.0)));
    }
    for input in &entry.inputs {
        let about = format!("what {} is multiplied by before it enters, as by an amplifier", input.name);
        all.push(variable(Role::Parameter, format!("{}_gain", input.name), about, "", Some(1.0)));
    }
    for input in &entry.inputs {
        let about = format!("what is added to {} then, as a bias", input.name);
        all.push(variable(Role::Parameter, format!("{}_offset", input.name), about, &input.unit, Some(0.0)));
    }
    let output = &entry.output;
    all.push(variable(Role::Output, output.name.into(), output.about.into(), &output.unit, None));
    all.push(variable(Role::Constant, "ts".into(), "sampling period".into(), "s", Some(wanted.model.ts())));
    for part in parts(program, entry.state, "") {
        for (k, at_rest) in part.at_rest.iter().enumerate() {
            let index = if part.array { format!("[{}]", k + 1) } else { String::new() };
            let name = format!("state.{}{index}", part.path);
            let start = if wanted.single { f64::from(*at_rest as f32) } else { *at_rest };
            all.push(variable(Role::State, name, format!("state of {}", part.about), "", Some(start)));
        }
    }
    all
}

/// The units of these variables, each once.
pub(super) fn units(variables: &[Variable]) -> Vec<Element> {
    let mut names: Vec<&str> = variables.iter().map(|v| v.unit.as_str()).filter(|unit| !unit.is_empty()).collect();
    names.sort_unstable();
    names.dedup();
    let unit = |name: &&str| Element::new("Unit").with("name", name).hold(base(name));
    names.iter().map(unit).collect()
}

/// A unit in those of the SI, if it is known.
fn base(unit: &str) -> Option<Element> {
    let base = Element::new("BaseUnit");
    match unit {
        "V" => Some(base.with("kg", 1).with("m", 2).with("s", -3).with("A", -1)),
        "s" => Some(base.with("s", 1)),
        "m" => Some(base.with("m", 1)),
        length => factor(length, "m").map(|metres| base.with("m", 1).with("factor", format!("{metres:?}"))),
    }
}
