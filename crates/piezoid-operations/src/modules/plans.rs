//! Which records to measure, and how those of a real actuator become evidence for all.

use super::{STAND_IN, optional, several, some_simulated};
use crate::{Inputs, Operation, Output};
use piezoid::Error;
use piezoid_numerics::options::Options;
use piezoid_records::waveform::spectrum;
use piezoid_verbs::{ContributeOptions, Contributed, File, PlanOptions};

pub(super) const OPERATIONS: &[Operation] = &[
    Operation {
        name: "plan",
        summary: "Plan the records of an identification: the drives within a driver's limits, and what each is for",
        module: "plans",
        roles: &[optional("model"), STAND_IN],
        options: PlanOptions::rows,
        run: |inputs, _| plan(inputs),
    },
    Operation {
        name: "contribute",
        summary: "Check records of a real actuator and pack them as evidence for all, or check such an archive",
        module: "plans",
        roles: &[several("data", 0), optional("check")],
        options: ContributeOptions::rows,
        run: |inputs, _| contribute(inputs),
    },
];

fn plan(inputs: &Inputs) -> Result<Output, Error> {
    let model = inputs.some("model")?.map(|file| file.model()).transpose()?;
    let (options, plant) = (inputs.options::<PlanOptions>()?, some_simulated(inputs, None)?);
    let plan = match &plant {
        Some((name, plant)) => options.rehearsed(model.as_ref(), (name, plant))?,
        None => options.run(model.as_ref())?,
    };
    let mut series = Vec::new();
    for drive in &plan.drives {
        let (hz, amplitude) = spectrum(&drive.u, plan.ts);
        series.push((drive.name.to_string(), drive.u.clone()));
        series.extend([(format!("{}/hz", drive.name), hz), (format!("{}/amplitude", drive.name), amplitude)]);
    }
    Ok(Output { result: plan.to_json(), series, files: plan.files()? })
}

/// Records as an archive, or the archive that is to be checked.
fn contribute(inputs: &Inputs) -> Result<Output, Error> {
    if let Some(archive) = inputs.some("check")? {
        return Ok(Output { result: Contributed::check(&archive)?.to_json(), ..Output::default() });
    }
    let found = inputs.options::<ContributeOptions>()?.run(inputs.sources("data")?)?;
    let files = vec![File::new("contribution.zip", found.archive()?)];
    Ok(Output { result: found.to_json(), series: Vec::new(), files })
}
