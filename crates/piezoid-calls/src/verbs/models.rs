//! Models, their proof and their inverses.

use super::{DATA, MANY, MODEL, NAME, named, role};
use crate::{Answer, Call, Given};
use piezoid::hammerstein::{HiddenLoop, Model};
use piezoid::hysteresis::LoopOptions;
use piezoid::plant::Preset;
use piezoid::progress::Progress;
use piezoid::validation::ValidateOptions;
use piezoid::waveform::{REVERSAL, reversals};
use piezoid::{CompensateOptions, Error, File, IdentifyOptions, OptionRow, Options, SimulateOptions, options};
use serde_json::json;

pub(super) const CALLS: &[Call] = &[
    Call {
        name: "simulate",
        summary: "the response of a plant or a model to an input",
        roles: &[role("input", 1, 1), role("model", 0, 1)],
        rows: SimulateCall::rows,
        run: |given, _| simulate(given),
    },
    Call {
        name: "loops",
        summary: "the loop of a record, its separating line, and the branches of the paper",
        roles: &[role("data", 1, 1), role("model", 0, 1)],
        rows: LoopOptions::rows,
        run: |given, _| loops(given),
    },
    Call {
        name: "identify",
        summary: "a model from measured records",
        roles: &[role("small_signal", 0, MANY), role("large_signal", 0, MANY)],
        rows: IdentifyOptions::rows,
        run: identify,
    },
    Call {
        name: "validate",
        summary: "free runs of a model against records",
        roles: &[MODEL, DATA],
        rows: ValidateOptions::rows,
        run: |given, _| validate(given),
    },
    Call {
        name: "compensate",
        summary: "the voltage for a requested displacement",
        roles: &[MODEL, role("reference", 1, 1)],
        rows: CompensateOptions::rows,
        run: |given, _| compensate(given),
    },
];

options! {
    /// Options of `simulate`.
    pub(crate) struct SimulateCall {
        /// The plant to simulate, unless a model is given.
        plant: String = "pl140".into(), OptionRow::new(NAME);
    } with simulation: SimulateOptions
}

fn simulate(given: &Given) -> Result<Answer, Error> {
    let (options, input, columns) = (given.options::<SimulateCall>()?, given.one("input")?, given.columns()?);
    let made = match given.some("model")? {
        Some(model) => options.simulation.model(&model, &input, &columns),
        None => options.simulation.plant(&(Preset::find(&options.plant)?.spec)(), &input, &columns),
    }?;
    let result = json!({"ts": made.ts, "units": made.units, "reached": made.reached});
    let file = File::new("simulated.csv", made.written("simulated.csv")?);
    Ok(Answer { result, series: named([("u", &made.u), ("y", &made.y)]), files: vec![file] })
}

/// Number of points on which a branch is drawn, less one.
const DRAWN: usize = 200;

fn loops(given: &Given) -> Result<Answer, Error> {
    let record = given.one("data")?.record(&given.columns()?)?;
    let model = given.some("model")?.map(|file| file.model()).transpose()?;
    let (made, note) = given.options::<LoopOptions>()?.run(&record, model.as_ref())?;
    let HiddenLoop { u, z, found, .. } = &made;
    let (low, high) = found.branches.range();
    let at: Vec<f64> = (0..=DRAWN).map(|k| low + (high - low) * k as f64 / DRAWN as f64).collect();
    let rising: Vec<f64> = at.iter().map(|u| found.branches.ascending(*u)).collect();
    let falling: Vec<f64> = at.iter().map(|u| found.branches.descending(*u)).collect();
    let result = json!({
        "loop": made.to_json(), "note": note, "units": record.units(), "ts": record.ts(),
        "reversals": reversals(u, REVERSAL),
    });
    let series = [("u", &u[..]), ("z", z), ("at", &at), ("ascending", &rising), ("descending", &falling)];
    Ok(Answer { result, series: named(series), files: Vec::new() })
}

/// The name of the front end in the files of models.
const FRONT_END: &str = if cfg!(target_family = "wasm") { "piezoid page" } else { "piezoid serve" };

fn identify(given: &Given, progress: &mut Progress) -> Result<Answer, Error> {
    let (small, large) = (given.sources("small_signal")?, given.sources("large_signal")?);
    let made = given.options::<IdentifyOptions>()?.run((&small, &large), FRONT_END, progress)?;
    let result = json!({
        "model": made.model.to_string(), "verdict": made.model.verdict(), "told": told(&made.model),
        "notes": made.found.notes, "reasons": made.found.reasons, "found": made.to_json(),
    });
    Ok(Answer { result, files: vec![File::new("model.json", made.model.to_json())], ..Answer::default() })
}

/// The verdict on a model in words.
fn told(model: &Model) -> Option<String> {
    model.verdict().map(|verdict| verdict.to_string())
}

fn validate(given: &Given) -> Result<Answer, Error> {
    let model = given.one("model")?.model()?;
    let made = given.options::<ValidateOptions>()?.run(&model, &given.sources("data")?)?;
    let verdict = made.verdict(&model);
    let mut result = made.to_json();
    result["told"] = json!(verdict.as_ref().map(ToString::to_string));
    result["verdict"] = json!(verdict);
    let mut series = Vec::new();
    for (k, compared) in made.files.iter().enumerate() {
        let record = &compared.record;
        result["files"][k]["ts"] = json!(record.ts());
        result["files"][k]["units"] = json!(record.units());
        let all = [("u", record.u()), ("y", record.y()), ("simulated", &compared.validation.simulated)];
        series.extend(all.map(|(name, samples)| (format!("{name}/{k}"), samples.to_vec())));
    }
    Ok(Answer { result, series, files: Vec::new() })
}

fn compensate(given: &Given) -> Result<Answer, Error> {
    let options = given.options::<CompensateOptions>()?;
    let made = options.run(&given.one("model")?, &given.one("reference")?, &given.columns()?)?;
    let mut result = made.to_json();
    result["told"] = made.proven().into();
    result["ts"] = made.ts.into();
    result["units"] = json!(made.units);
    let series =
        [("requested", &*made.requested), ("shaped", &made.shaped), ("u", &made.made.u), ("y", &made.made.reached)];
    Ok(Answer { result, series: named(series), files: vec![File::new("voltage.csv", made.written("voltage.csv")?)] })
}
