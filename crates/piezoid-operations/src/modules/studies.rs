//! Pages with figures about many models.

use super::project::ProjectOptions;
use super::several;
use crate::{Inputs, Operation, Output};
use piezoid::Error;
use piezoid::progress::Progress;
use piezoid_numerics::options::{Options, options};
use piezoid_report::report::{comparison, leaderboard};
use piezoid_report::study::{Study, StudyOptions};
use piezoid_verbs::{CompareOptions, File};

pub(super) const OPERATIONS: &[Operation] = &[
    Operation {
        name: "compare",
        summary: "Compare models, operators and structures on the same records",
        module: "studies",
        roles: &[several("model", 0), several("training", 0), several("small_signal", 0), several("data", 0)],
        options: CompareCall::rows,
        run: compare,
    },
    Operation {
        name: "study",
        summary: "Repeat the paper's experiment from end to end, as tables and a report",
        module: "studies",
        roles: &[],
        options: StudyOptions::rows,
        run: study,
    },
];

options! {
    /// Options of `compare`.
    pub(crate) struct CompareCall {
    } with project: ProjectOptions with comparison: CompareOptions
}

fn compare(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let CompareCall { project, comparison: options } = inputs.options()?;
    let project = project.address()?;
    let [training, small_signal, data] = ["training", "small_signal", "data"].map(|role| inputs.sources(role));
    let outcome = options.run_all((inputs.all("model")?, [training?, small_signal?, data?]), None, progress)?;
    let mut files = vec![File::new("compare.html", comparison(&outcome).of_project(project).html())];
    if outcome.split.is_some() {
        files.extend(leaderboard(&outcome).map(|figure| File::new("compare.svg", figure.svg())));
    }
    Ok(Output { result: outcome.to_json(), series: Vec::new(), files })
}

fn study(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let studies = inputs.options::<StudyOptions>()?.run(progress)?;
    Ok(Output { result: Study::to_json(&studies), series: Vec::new(), files: Study::files(&studies) })
}
