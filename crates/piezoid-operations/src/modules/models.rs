//! Models, their identification and their validation.

use super::shape::{shape, spectra};
use super::{DATA, MODEL, NAME, STAND_IN, named, one, optional, several, simulated};
use crate::{Inputs, Operation, Output};
use piezoid::progress::Progress;
use piezoid::validation::ValidateOptions;
use piezoid::{Error, IdentifyOptions, StatedVerdict, Verdict};
use piezoid_models::hammerstein::HiddenLoop;
use piezoid_models::hysteresis::LoopOptions;
use piezoid_numerics::options::{OptionRow, Options, options};
use piezoid_records::waveform::{MIN_REVERSAL_SHARE, reversals};
use piezoid_verbs::{File, SimulateOptions, Subject, ValidateRecords, stand_in_from};
use serde_json::json;

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
];

options! {
    /// Options of `simulate`.
    pub(crate) struct SimulateCall {
        /// The plant to simulate, unless a model or a stand-in is given.
        plant: String = "pl140".into(), OptionRow::new(NAME).list("plants");
    } with simulation: SimulateOptions
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
