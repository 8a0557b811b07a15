//! What a model is for: the voltage of a path, the times of moves, and parameters that follow the actuator.

use super::{MODEL, NAME, STAND_IN, named, one, optional, some_simulated};
use crate::packet::Marks;
use crate::{Inputs, Operation, Output};
use piezoid::Error;
use piezoid::progress::Progress;
use piezoid_numerics::options::{OptionRow, Options, options};
use piezoid_verbs::{CompensateOptions, DataFile, File, OnPlant, OnlineOptions, OnlineRow, Timing, TimingOptions};
use serde_json::{Value, json};

pub(super) const OPERATIONS: &[Operation] = &[
    Operation {
        name: "compensate",
        summary: "Compute the voltage for a requested displacement",
        module: "compensation",
        roles: &[MODEL, one("reference"), STAND_IN],
        options: CompensateCall::rows,
        run: |inputs, _| compensate(inputs),
    },
    Operation {
        name: "timing",
        summary: "Time moves along a path: settling, overshoot, scan lag; find the fastest step and flyback",
        module: "compensation",
        roles: &[MODEL, optional("path"), optional("measured"), STAND_IN],
        options: TimingCall::rows,
        run: timing,
    },
    Operation {
        name: "online",
        summary: "Follow gain, hysteresis weights and linear block of a model along a stream or a record",
        module: "compensation",
        roles: &[MODEL, one("data")],
        options: OnlineOptions::rows,
        run: online,
    },
];

options! {
    /// Options of `compensate`.
    pub(crate) struct CompensateCall {
        /// Also play the path on this plant, with and without compensation.
        plant: Option<String> = None, OptionRow::new(NAME).list("plants");
    } with compensation: CompensateOptions
}

options! {
    /// Options of `timing`.
    pub(crate) struct TimingCall {
        /// Also play the path on this plant.
        plant: Option<String> = None, OptionRow::new(NAME).list("plants");
    } with timing: TimingOptions
}

fn timing(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let TimingCall { plant, timing } = inputs.options()?;
    let plant = some_simulated(inputs, plant.as_deref())?;
    let [path, measured] = ["path", "measured"].map(|role| Ok(inputs.some(role)?.map(DataFile::from)));
    let (path, measured): (Option<DataFile>, Option<DataFile>) = (path?, measured?);
    let plant = plant.as_ref().map(|(name, actuator)| (&**name, actuator));
    let data = (path.as_ref(), measured.as_ref());
    let outcome = timing.run(&inputs.one("model")?, data, plant, &inputs.columns()?, progress)?;
    let document = outcome.to_json();
    timed(&outcome, document)
}

/// The timing of moves with its document, for the page.
pub(super) fn timed(outcome: &Timing, mut result: Value) -> Result<Output, Error> {
    result["sentence"] = outcome.proven().into();
    result["units"] = json!(outcome.units);
    let mut series = named([("r", &outcome.path[..]), ("u", &outcome.u)]);
    series.extend(outcome.displacements.iter().enumerate().map(|(k, y)| (format!("y/{k}"), y.clone())));
    Ok(Output { result, series, files: vec![File::new("timing.csv", outcome.written("timing.csv")?)] })
}

fn online(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let (options, data) = (inputs.options::<OnlineOptions>()?, inputs.data("data")?);
    let none = &mut |_: &OnlineRow| Ok(());
    let outcome = options.replay(&inputs.one("model")?, &data, &inputs.columns()?, none, progress)?;
    let of = |number: fn(&OnlineRow) -> f64| outcome.rows.iter().map(number).collect::<Vec<f64>>();
    let (t, gain, offset) = (of(|row| row.t), of(|row| row.parameters.gain), of(|row| row.parameters.offset));
    let series = named([("t", &t[..]), ("gain", &gain), ("offset", &offset)]);
    let files = vec![File::new("model.json", outcome.model.to_json())];
    Ok(Output { result: outcome.to_json(), series, files })
}

fn compensate(inputs: &Inputs) -> Result<Output, Error> {
    let CompensateCall { plant, compensation } = inputs.options()?;
    let plant = some_simulated(inputs, plant.as_deref())?;
    let plant = plant.as_ref().map(|(name, actuator)| (&**name, actuator));
    let (model, reference) = (inputs.one("model")?, inputs.data("reference")?);
    let outcome = compensation.run(&model, &reference, &inputs.columns()?, plant)?;
    let mut result = outcome.to_json();
    let notes = outcome.compensated.notes.iter().cloned().chain(outcome.smoothing.iter().map(|s| s.note(&Marks)));
    result["notes"] = notes.collect();
    result["sentence"] = outcome.proven().into();
    result["ts"] = outcome.ts.into();
    result["units"] = json!(outcome.units);
    let mut series = named([
        ("requested", &*outcome.requested),
        ("shaped", &outcome.shaped),
        ("u", &outcome.compensated.u),
        ("y", &outcome.compensated.reached),
    ]);
    if let Some(OnPlant { displacements: [gain, compensated], .. }) = &outcome.on_plant {
        series.extend(named([("y/gain", gain), ("y/compensated", compensated)]));
    }
    Ok(Output { result, series, files: vec![File::new("voltage.csv", outcome.written("voltage.csv")?)] })
}
