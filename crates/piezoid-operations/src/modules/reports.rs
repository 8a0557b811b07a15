//! Pages with figures about one model.

use super::project::ProjectOptions;
use super::{DATA, MODEL, NAME, STAND_IN, several, simulated};
use crate::{Inputs, Operation, Output};
use piezoid::Error;
use piezoid::progress::Progress;
use piezoid::validation::ValidateOptions;
use piezoid_numerics::options::{OptionRow, Options, options};
use piezoid_report::dcc;
use piezoid_report::report::{certificate, report, tracking};
use piezoid_verbs::{CertificateOptions, ComparisonReport, ControlOptions, DataFile, File, ValidateRecords};
use serde_json::json;

pub(super) const OPERATIONS: &[Operation] = &[
    Operation {
        name: "control",
        summary: "Close the loop on a simulated actuator and compare controllers",
        module: "reports",
        roles: &[MODEL, several("reference", 0), STAND_IN],
        options: ControlCall::rows,
        run: control,
    },
    Operation {
        name: "report",
        summary: "Write a self-contained HTML report on a model and its free-run errors on records",
        module: "reports",
        roles: &[MODEL, DATA],
        options: ReportCall::rows,
        run: |inputs, _| page(inputs),
    },
    Operation {
        name: "certificate",
        summary: "Certify the displacement that a model predicts: its expanded uncertainty, after the GUM",
        module: "reports",
        roles: &[MODEL, DATA],
        options: CertificateOptions::rows,
        run: |inputs, _| certify(inputs),
    },
];

options! {
    /// Options of `control`.
    pub(crate) struct ControlCall {
        /// The plant that is controlled, unless a stand-in is given.
        plant: String = "pl140".into(), OptionRow::new(NAME).list("plants");
    } with control: ControlOptions
}

options! {
    /// Options of `report`.
    pub(crate) struct ReportCall {
    } with project: ProjectOptions with validation: ValidateOptions
}

fn control(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let ControlCall { plant, mut control } = inputs.options()?;
    let files: Vec<DataFile> = inputs.all("reference")?.into_iter().map(DataFile::from).collect();
    control.reference.extend(files.iter().map(|file| file.name.clone()));
    let (plant, actuator) = simulated(inputs, &plant)?;
    let outcome = control.run((&plant, &actuator), &inputs.one("model")?, &files, &inputs.columns()?, progress)?;
    let mut series = Vec::new();
    for (k, with_driver) in outcome.results.iter().enumerate() {
        for (j, attempt) in with_driver.attempts.iter().enumerate() {
            let Ok(attempt) = attempt else { continue };
            let all = [("r", &attempt.run.r), ("u", &attempt.run.u), ("y", &attempt.run.y)];
            series.extend(all.map(|(name, samples)| (format!("{name}/{k}/{j}"), samples.clone())));
        }
    }
    let mut result = outcome.to_json();
    result["remarks"] = json!(outcome.remarks());
    Ok(Output { result, series, files: vec![File::new("control.html", tracking(&outcome).html())] })
}

fn page(inputs: &Inputs) -> Result<Output, Error> {
    let model = inputs.one("model")?.model()?;
    let ReportCall { project, validation } = inputs.options()?;
    let project = project.address()?;
    let outcome = validation.run(&model, inputs.sources("data")?)?;
    let result = json!({"sentence": outcome.verdict(&model).map(|verdict| verdict.to_string())});
    let page = report(&model, &outcome).of_project(project);
    Ok(Output { result, series: Vec::new(), files: vec![File::new("report.html", page.html())] })
}

fn certify(inputs: &Inputs) -> Result<Output, Error> {
    let found = inputs.options::<CertificateOptions>()?.run(&inputs.one("model")?, inputs.sources("data")?)?;
    let mut files = vec![File::new("certificate.html", certificate(&found).html())];
    // The XML needs names that the page does not.
    if let (Some(_), Some(_)) = (&found.options.date, &found.options.country) {
        files.push(File::new("certificate.xml", dcc(&found)?));
    }
    Ok(Output { result: found.to_json(), series: Vec::new(), files })
}
