//! Models, their validation and their inverses.

use super::shape::{shape, spectra};
use super::{DATA, MODEL, NAME, STAND_IN, named, one, optional, several, simulated, some_simulated};
use crate::packet::Marks;
use crate::{Inputs, Operation, Output};
use piezoid::progress::Progress;
use piezoid::validation::ValidateOptions;
use piezoid::{Error, IdentifyOptions, StatedVerdict, Verdict};
use piezoid_models::hammerstein::HiddenLoop;
use piezoid_models::hysteresis::LoopOptions;
use piezoid_numerics::options::{OptionRow, Options, options};
use piezoid_records::waveform::{MIN_REVERSAL_SHARE, reversals};
use piezoid_verbs::{
    CompensateOptions, DataFile, File, OnPlant, OnlineOptions, OnlineRow, SimulateOptions, Subject, Timing,
    TimingOptions, ValidateRecords, stand_in_from,
};
use serde_json::{Value, json};

pub(super) const OPERATIONS: &[Operation] = &[
    Operation {
        name: "simulate",
        summary: "Run a plant or a model on a drive signal",
        module: "models",
        roles: &[one("input"), optional("model"), STAND_IN],
        options: SimulateCall::rows,
        run: |inputs, _| simulate(inputs),
    },
    Operation {
        name: "loops",
        summary: "Show the hysteresis loop of a record: its reversals, separating line and branches",
        module: "models",
        roles: &[one("data"), optional("model")],
        options: LoopOptions::rows,
        run: |inputs, _| loops(inputs),
    },
    Operation {
        name: "identify",
        summary: "Identify a model from measured records",
        module: "models",
        roles: &[several("small_signal", 0), several("large_signal", 0)],
        options: IdentifyOptions::rows,
        run: identify,
    },
    Operation {
        name: "stand-in",
        summary: "Make a stand-in for an actuator: a second model of its records, to try voltages and controllers on",
        module: "models",
        roles: &[MODEL, several("records", 1)],
        options: Vec::new,
        run: stand_in,
    },
    Operation {
        name: "validate",
        summary: "Validate a model on records that were not used to identify it",
        module: "models",
        roles: &[MODEL, DATA],
        options: ValidateOptions::rows,
        run: |inputs, _| validate(inputs),
    },
    Operation {
        name: "compensate",
        summary: "Compute the voltage for a requested displacement",
        module: "models",
        roles: &[MODEL, one("reference"), STAND_IN],
        options: CompensateCall::rows,
        run: |inputs, _| compensate(inputs),
    },
    Operation {
        name: "timing",
        summary: "Time moves along a path: settling, overshoot, scan lag; find the fastest step and flyback",
        module: "models",
        roles: &[MODEL, optional("path"), optional("measured"), STAND_IN],
        options: TimingCall::rows,
        run: timing,
    },
    Operation {
        name: "online",
        summary: "Follow gain, hysteresis weights and linear block of a model along a stream or a record",
        module: "models",
        roles: &[MODEL, one("data")],
        options: OnlineOptions::rows,
        run: online,
    },
];

options! {
    /// Options of `simulate`.
    pub(crate) struct SimulateCall {
        /// The plant to simulate, unless a model or a stand-in is given.
        plant: String = "pl140".into(), OptionRow::new(NAME).list("plants");
    } with simulation: SimulateOptions
}

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

fn simulate(inputs: &Inputs) -> Result<Output, Error> {
    let (options, input, columns) = (inputs.options::<SimulateCall>()?, inputs.data("input")?, inputs.columns()?);
    let subject = match inputs.some("model")? {
        Some(model) => Subject::Model(Box::new(model.model()?)),
        None => Subject::Plant(simulated(inputs, &options.plant)?.1),
    };
    let outcome = options.simulation.run(&subject, &input, &columns)?;
    let result = json!({"ts": outcome.ts, "units": outcome.units, "reached": outcome.reached});
    let file = File::new("simulated.csv", outcome.written("simulated.csv")?);
    let series = [("u", &outcome.u[..]), ("y", &outcome.y), ("deviation", &outcome.deviation)];
    Ok(Output { result, series: named(series), files: vec![file] })
}

/// Number of points on which a branch is drawn, less one.
const DRAWN: usize = 200;

fn loops(inputs: &Inputs) -> Result<Output, Error> {
    let record = inputs.data("data")?.record(&inputs.columns()?)?;
    let model = inputs.some("model")?.map(|file| file.model()).transpose()?;
    let (outcome, note) = inputs.options::<LoopOptions>()?.run(&record, model.as_ref())?;
    let HiddenLoop { u, z, found, .. } = &outcome;
    let (low, high) = found.branches.range();
    let at: Vec<f64> = (0..=DRAWN).map(|k| low + (high - low) * k as f64 / DRAWN as f64).collect();
    let rising: Vec<f64> = at.iter().map(|u| found.branches.ascending(*u)).collect();
    let falling: Vec<f64> = at.iter().map(|u| found.branches.descending(*u)).collect();
    let result = json!({
        "loop": outcome.to_json(), "note": note, "units": record.units(), "ts": record.ts(),
        "reversals": reversals(u, MIN_REVERSAL_SHARE),
    });
    let series = [("u", &u[..]), ("z", z), ("at", &at), ("ascending", &rising), ("descending", &falling)];
    Ok(Output { result, series: named(series), files: Vec::new() })
}

/// The name of the front end in the files of models.
const FRONT_END: &str = if cfg!(target_family = "wasm") { "piezoid page" } else { "piezoid serve" };

fn identify(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let (small, large) = (inputs.sources("small_signal")?, inputs.sources("large_signal")?);
    let outcome = inputs.options::<IdentifyOptions>()?.run((small, large), FRONT_END, progress)?;
    let (found, verdict) = (&outcome.found, outcome.found.model.verdict());
    let result = json!({
        "model": found.model.to_string(), "verdict": verdict, "sentence": verdict.as_ref().map(Verdict::to_string),
        "notes": found.notes, "reasons": found.reasons, "found": outcome.to_json(),
    });
    Ok(Output { result, files: vec![File::new("model.json", found.model.to_json())], ..Output::default() })
}

fn stand_in(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let found = stand_in_from(&inputs.one("model")?.model()?, &inputs.sources("records")?, progress)?;
    let result = json!({
        "sentence": found.to_string(), "operator": found.other().hysteresis().operator().name,
        "share": found.share(), "error": found.error(), "noise": found.noise(), "units": found.units(),
    });
    Ok(Output { result, files: vec![File::new("stand-in.json", found.to_json())], ..Output::default() })
}

fn validate(inputs: &Inputs) -> Result<Output, Error> {
    let model = inputs.one("model")?.model()?;
    let outcome = inputs.options::<ValidateOptions>()?.run(&model, inputs.sources("data")?)?;
    let verdict = outcome.verdict(&model);
    let mut result = outcome.to_json();
    result["sentence"] = json!(verdict.as_ref().map(Verdict::to_string));
    result["verdict"] = json!(verdict);
    let mut series = Vec::new();
    for (k, compared) in outcome.files.iter().enumerate() {
        let record = &compared.record;
        result["files"][k]["ts"] = json!(record.ts());
        result["files"][k]["units"] = json!(record.units());
        let all = [("u", record.u()), ("y", record.y()), ("simulated", &compared.validation.simulated)];
        series.extend(all.map(|(name, samples)| (format!("{name}/{k}"), samples.to_vec())));
        result["files"][k]["shape"] = shape(record);
        let spectra = spectra(record, Some(&compared.validation.simulated));
        series.extend(spectra.into_iter().map(|(name, values)| (format!("{name}/{k}"), values)));
    }
    Ok(Output { result, series, files: Vec::new() })
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
