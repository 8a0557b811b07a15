//! Controllers in the network.

use super::{named, one};
use crate::{Inputs, Operation, Output};
use piezoid::Error;
use piezoid::progress::Progress;
use piezoid_instruments::{AcquireOptions, ConnectOptions};
use piezoid_numerics::options::Options;
use piezoid_verbs::File;

pub(super) const OPERATIONS: &[Operation] = &[
    Operation {
        name: "controller",
        summary: "Show the identity of a controller, and the limits it reports; nothing moves",
        module: "instruments",
        roles: &[],
        options: ConnectOptions::rows,
        run: |inputs, progress| {
            let result = inputs.options::<ConnectOptions>()?.connect(progress)?.to_json();
            Ok(Output { result, ..Output::default() })
        },
    },
    Operation {
        name: "acquire",
        summary: "Play a drive on a controller with PI's GCS 2.0, and record what the actuator does",
        module: "instruments",
        roles: &[one("drive")],
        options: AcquireOptions::rows,
        run: acquire,
    },
];

fn acquire(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let options = inputs.options::<AcquireOptions>()?;
    let (drive, columns, mut notes) = (inputs.data("drive")?, inputs.columns()?, Vec::new());
    let outcome = options.run(&drive, &columns, &mut notes, &mut |_| Ok(()), progress);
    let outcome = outcome.map_err(|error| match error {
        // A cancelled measurement has to say where the axis is.
        Error::Cancelled { .. } => Error::Content(format!("{error}; {}", notes.join("; "))),
        other => other,
    })?;
    let record = &outcome.record;
    let file = File::new("record.csv", record.written("record.csv")?);
    Ok(Output { result: outcome.to_json(), series: named([("u", record.u()), ("y", record.y())]), files: vec![file] })
}
