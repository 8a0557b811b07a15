//! The table of verbs, and what each does with a request.

use crate::{Answer, Call, Given, Role};
use piezoid::excitation::Excitation;
use piezoid::formats::{ColumnSelection, Table};
use piezoid::hammerstein::{HiddenLoop, Model};
use piezoid::hysteresis::LoopOptions;
use piezoid::plant::Preset;
use piezoid::progress::Progress;
use piezoid::validation::ValidateOptions;
use piezoid::waveform::reversals;
use piezoid::{
    CompareOptions, CompensateOptions, ControlOptions, Error, ExciteOptions, File, IdentifyOptions, OptionKind,
    OptionRow, Options, PlanOptions, PrepareOptions, SimulateOptions, options,
};
use piezoid_export::ExportOptions;
use piezoid_report::report::{comparison, identification, report, tracking};
use piezoid_report::study::{Study, StudyOptions};
use serde_json::{Value, json};

const NAME: OptionKind = OptionKind::Text("NAME");

options! {
    /// Options of `simulate`.
    pub(crate) struct SimulateCall {
        /// The plant to simulate, unless a model is given.
        plant: String = "pl140".into(), OptionRow::new(NAME);
    } with simulation: SimulateOptions
}

options! {
    /// Options of `control`.
    pub(crate) struct ControlCall {
        /// The plant that is controlled.
        plant: String = "pl140".into(), OptionRow::new(NAME);
    } with control: ControlOptions
}

options! {
    /// Options of `export`.
    pub(crate) struct ExportCall {
        /// The target language or format.
        target: String = "c".into(), OptionRow::new(NAME);
    } with export: ExportOptions
}

options! {
    /// Options of `excite`, besides those of the signal.
    pub(crate) struct ExciteCall {
        /// The kind of signal.
        kind: String = "sine".into(), OptionRow::new(NAME);
    } with common: ExciteOptions
}

const fn role(name: &'static str, least: usize, most: usize) -> Role {
    Role { name, least, most }
}

const MANY: usize = usize::MAX;
const DATA: Role = role("data", 1, MANY);
const MODEL: Role = role("model", 1, 1);

/// The verbs.
pub const CALLS: &[Call] = &[
    Call {
        name: "inspect",
        summary: "what a file holds, how it is read, and what seems wrong with it",
        roles: &[role("data", 1, 1)],
        rows: Vec::new,
        run: |given, _| inspect(given),
    },
    Call {
        name: "prepare",
        summary: "a record as it is to be identified, from one as it was measured",
        roles: &[role("data", 1, 1)],
        rows: PrepareOptions::rows,
        run: |given, _| prepare(given),
    },
    Call {
        name: "loops",
        summary: "the loop of a record, its separating line, and the branches of the paper",
        roles: &[role("data", 1, 1), role("model", 0, 1)],
        rows: LoopOptions::rows,
        run: |given, _| loops(given),
    },
    Call {
        name: "excite",
        summary: "a drive signal within the limits of a driver",
        roles: &[],
        rows: ExciteCall::rows,
        run: |given, _| excite(given),
    },
    Call {
        name: "plan",
        summary: "the drives of an identification, within the limits of a driver",
        roles: &[role("model", 0, 1)],
        rows: PlanOptions::rows,
        run: |given, _| plan(given),
    },
    Call {
        name: "simulate",
        summary: "the response of a plant or a model to an input",
        roles: &[role("input", 1, 1), role("model", 0, 1)],
        rows: SimulateCall::rows,
        run: |given, _| simulate(given),
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
        name: "compare",
        summary: "free runs of several models against the same records",
        roles: &[role("model", 1, MANY), DATA],
        rows: CompareOptions::rows,
        run: |given, _| compare(given),
    },
    Call {
        name: "compensate",
        summary: "the voltage for a requested displacement",
        roles: &[MODEL, role("reference", 1, 1)],
        rows: CompensateOptions::rows,
        run: |given, _| compensate(given),
    },
    Call {
        name: "control",
        summary: "controllers along references, on a simulated plant",
        roles: &[MODEL, role("reference", 0, MANY)],
        rows: ControlCall::rows,
        run: control,
    },
    Call {
        name: "export",
        summary: "the model, its inverse and its controller for another machine",
        roles: &[MODEL, role("reference", 0, 1)],
        rows: ExportCall::rows,
        run: |given, _| export(given),
    },
    Call {
        name: "report",
        summary: "a page on a model and how well it predicts records",
        roles: &[MODEL, DATA],
        rows: ValidateOptions::rows,
        run: |given, _| page(given),
    },
    Call {
        name: "study",
        summary: "the comparison of the paper, on a simulated actuator",
        roles: &[],
        rows: StudyOptions::rows,
        run: study,
    },
];

/// Series by their names.
fn named<const N: usize>(series: [(&str, &[f64]); N]) -> Vec<(String, Vec<f64>)> {
    series.map(|(name, samples)| (name.to_string(), samples.to_vec())).into()
}

fn inspect(given: &Given) -> Result<Answer, Error> {
    let (file, columns) = (given.one("data")?, given.columns()?);
    let (result, record) = file.inspect(&columns)?;
    let Ok(record) = record else { return Ok(Answer { result, ..Answer::default() }) };
    let profile = File::new("profile.toml", file.profile(&columns)?.to_toml());
    Ok(Answer { result, series: named([("u", record.u()), ("y", record.y())]), files: vec![profile] })
}

fn prepare(given: &Given) -> Result<Answer, Error> {
    let file = given.one("data")?;
    let made =
        given.options::<PrepareOptions>()?.run(&file.record(&given.columns()?)?).map_err(|e| e.of(&file.name))?;
    let name = "record.csv";
    let written = File::new(name, made.written(name)?);
    let (result, _) = Table::read(name, &written.bytes)?.inspect(name, "csv", &ColumnSelection::default());
    Ok(Answer { result, series: named([("u", made.u()), ("y", made.y())]), files: vec![written] })
}

/// Number of points on which a branch is drawn, less one.
const DRAWN: usize = 200;

/// The share of the range by which the input moves back at a reversal.
const REVERSAL: f64 = 0.02;

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

fn excite(given: &Given) -> Result<Answer, Error> {
    let known = |name: &str| ExciteCall::rows().iter().any(|row| row.name == name);
    let all = given.request.options.iter().map(|(name, value)| (name.clone(), value.clone()));
    let (common, own): (serde_json::Map<_, _>, serde_json::Map<_, _>) = all.partition(|(name, _)| known(name));
    let ExciteCall { kind, common } = ExciteCall::from_json(Value::Object(common))?;
    let made = common.run(Excitation::find(&kind)?, Value::Object(own))?;
    let result = json!({"ts": made.ts, "unit": made.unit, "usage": made.usage, "clipped": made.clipped});
    let file = File::new("signal.csv", made.written("signal.csv")?);
    Ok(Answer { result, series: named([("u", &made.u)]), files: vec![file] })
}

fn plan(given: &Given) -> Result<Answer, Error> {
    let model = given.some("model")?.map(|file| file.model()).transpose()?;
    let plan = given.options::<PlanOptions>()?.run(model.as_ref())?;
    let series = plan.drives.iter().map(|drive| (drive.name.to_string(), drive.u.clone())).collect();
    Ok(Answer { result: plan.to_json(), series, files: plan.files()? })
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

fn identify(given: &Given, progress: &mut Progress) -> Result<Answer, Error> {
    let (small, large) = (given.all("small_signal")?, given.all("large_signal")?);
    let options = given.options::<IdentifyOptions>()?;
    let made = options.run((&small, &large), &given.columns()?, "piezoid's page: identify", progress)?;
    let result = json!({
        "model": made.model.to_string(), "verdict": made.model.verdict(), "told": told(&made.model),
        "notes": made.found.notes, "reasons": made.found.reasons, "found": made.to_json(),
    });
    let page = File::new("report.html", identification(&made).html());
    let files = vec![File::new("model.json", made.model.to_json()), page];
    Ok(Answer { result, files, ..Answer::default() })
}

/// The verdict on a model in words.
fn told(model: &Model) -> Option<String> {
    model.verdict().map(|verdict| verdict.to_string())
}

fn validate(given: &Given) -> Result<Answer, Error> {
    let model = given.one("model")?.model()?;
    let made = given.options::<ValidateOptions>()?.run(&model, &given.all("data")?, &given.columns()?)?;
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

fn compare(given: &Given) -> Result<Answer, Error> {
    let options = given.options::<CompareOptions>()?;
    let made = options.run(&given.all("model")?, &given.all("data")?, &given.columns()?)?;
    let files = vec![File::new("compare.html", comparison(&made).html())];
    Ok(Answer { result: made.to_json(), series: Vec::new(), files })
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

fn control(given: &Given, progress: &mut Progress) -> Result<Answer, Error> {
    let ControlCall { plant, mut control } = given.options()?;
    let files = given.all("reference")?;
    control.reference.extend(files.iter().map(|file| file.name.clone()));
    let spec = (Preset::find(&plant)?.spec)();
    let made = control.run((&plant, &spec), &given.one("model")?, &files, &given.columns()?, progress)?;
    let mut series = Vec::new();
    for (k, driven) in made.driven.iter().enumerate() {
        for (j, attempt) in driven.attempts.iter().enumerate() {
            let Ok(attempt) = attempt else { continue };
            let all = [("r", &attempt.run.r), ("u", &attempt.run.u), ("y", &attempt.run.y)];
            series.extend(all.map(|(name, samples)| (format!("{name}/{k}/{j}"), samples.clone())));
        }
    }
    let mut result = made.to_json();
    result["remarks"] = json!(made.remarks());
    Ok(Answer { result, series, files: vec![File::new("control.html", tracking(&made).html())] })
}

fn export(given: &Given) -> Result<Answer, Error> {
    let (ExportCall { target, export }, columns) = (given.options()?, given.columns()?);
    let reference = given.some("reference")?;
    let along = reference.as_ref().map(|file| (file, &columns));
    let made = export.run(&target, &given.one("model")?, along, None)?;
    Ok(Answer { result: made.to_json(), series: Vec::new(), files: made.files })
}

fn page(given: &Given) -> Result<Answer, Error> {
    let model = given.one("model")?.model()?;
    let made = given.options::<ValidateOptions>()?.run(&model, &given.all("data")?, &given.columns()?)?;
    let result = json!({"told": made.verdict(&model).map(|verdict| verdict.to_string())});
    Ok(Answer { result, series: Vec::new(), files: vec![File::new("report.html", report(&model, &made).html())] })
}

fn study(given: &Given, progress: &mut Progress) -> Result<Answer, Error> {
    let studies = given.options::<StudyOptions>()?.run(progress)?;
    Ok(Answer { result: Study::to_json(&studies), series: Vec::new(), files: Study::files(&studies) })
}
