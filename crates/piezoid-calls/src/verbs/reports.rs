//! What ends in pages with figures.

use super::{DATA, MANY, MODEL, NAME, role};
use crate::{Answer, Call, Given};
use piezoid::plant::Preset;
use piezoid::progress::Progress;
use piezoid::validation::ValidateOptions;
use piezoid::{CompareOptions, ControlOptions, Error, File, OptionRow, Options, options};
use piezoid_report::report::{comparison, report, tracking};
use piezoid_report::study::{Study, StudyOptions};
use serde_json::json;

pub(super) const CALLS: &[Call] = &[
    Call {
        name: "control",
        summary: "controllers along references, on a simulated plant",
        roles: &[MODEL, role("reference", 0, MANY)],
        rows: ControlCall::rows,
        run: control,
    },
    Call {
        name: "report",
        summary: "a page on a model and how well it predicts records",
        roles: &[MODEL, DATA],
        rows: ValidateOptions::rows,
        run: |given, _| page(given),
    },
    Call {
        name: "compare",
        summary: "free runs of several models against the same records",
        roles: &[role("model", 1, MANY), DATA],
        rows: CompareOptions::rows,
        run: |given, _| compare(given),
    },
    Call {
        name: "study",
        summary: "the comparison of the paper, on a simulated actuator",
        roles: &[],
        rows: StudyOptions::rows,
        run: study,
    },
];

options! {
    /// Options of `control`.
    pub(crate) struct ControlCall {
        /// The plant that is controlled.
        plant: String = "pl140".into(), OptionRow::new(NAME);
    } with control: ControlOptions
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

fn page(given: &Given) -> Result<Answer, Error> {
    let model = given.one("model")?.model()?;
    let made = given.options::<ValidateOptions>()?.run(&model, &given.sources("data")?)?;
    let result = json!({"told": made.verdict(&model).map(|verdict| verdict.to_string())});
    Ok(Answer { result, series: Vec::new(), files: vec![File::new("report.html", report(&model, &made).html())] })
}

fn compare(given: &Given) -> Result<Answer, Error> {
    let options = given.options::<CompareOptions>()?;
    let made = options.run(&given.all("model")?, &given.sources("data")?)?;
    let files = vec![File::new("compare.html", comparison(&made).html())];
    Ok(Answer { result: made.to_json(), series: Vec::new(), files })
}

fn study(given: &Given, progress: &mut Progress) -> Result<Answer, Error> {
    let studies = given.options::<StudyOptions>()?.run(progress)?;
    Ok(Answer { result: Study::to_json(&studies), series: Vec::new(), files: Study::files(&studies) })
}
