//! Controllers in the network.

use super::{named, role};
use crate::{Answer, Call, Given};
use piezoid::progress::Progress;
use piezoid::{Error, File, Options};
use piezoid_gcs::{AcquireOptions, ConnectOptions};

pub(super) const CALLS: &[Call] = &[
    Call {
        name: "controller",
        summary: "what a controller is, and the limits that it tells; nothing moves",
        roles: &[],
        rows: ConnectOptions::rows,
        run: |given, _| {
            let result = given.options::<ConnectOptions>()?.connect()?.to_json();
            Ok(Answer { result, ..Answer::default() })
        },
    },
    Call {
        name: "acquire",
        summary: "a drive played and recorded by a controller",
        roles: &[role("drive", 1, 1)],
        rows: AcquireOptions::rows,
        run: acquire,
    },
];

fn acquire(given: &Given, progress: &mut Progress) -> Result<Answer, Error> {
    let options = given.options::<AcquireOptions>()?;
    let made = options.run(&given.one("drive")?, &given.columns()?, progress)?;
    let record = &made.record;
    let file = File::new("record.csv", record.written("record.csv")?);
    Ok(Answer { result: made.to_json(), series: named([("u", record.u()), ("y", record.y())]), files: vec![file] })
}
