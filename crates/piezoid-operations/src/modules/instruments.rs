//! Controllers in the network.

use super::compensation::timed;
use super::{MODEL, NAME, STAND_IN, named, one, optional, some_simulated};
use crate::{Inputs, Operation, Output, Role};
use piezoid::progress::Progress;
use piezoid::{Error, Verdict};
use piezoid_instruments::{AcquireOptions, Agenda, CampaignOptions, ConnectOptions, Journal, MeasuredTimingOptions};
use piezoid_numerics::options::{OptionRow, Options, options};
use piezoid_verbs::{DataFile, File, Players};
use serde_json::json;

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
        summary: "Play a drive on a controller, and record what the actuator does",
        module: "instruments",
        roles: &[one("drive")],
        options: AcquireOptions::rows,
        run: acquire,
    },
    Operation {
        name: "campaign",
        summary: "Measure, identify and straighten an actuator on a controller, and measure how well it follows a path",
        module: "instruments",
        roles: &[optional("reference"), EARLIER, STAND_IN],
        options: CampaignOptions::rows,
        run: campaign,
    },
    Operation {
        name: "agenda",
        summary: "Show what a campaign is going to measure, and what will move; nothing moves",
        module: "instruments",
        roles: &[EARLIER],
        options: CampaignOptions::rows,
        run: |inputs, progress| {
            let kept = Kept { earlier: inputs.all("earlier")?, files: Vec::new() };
            let result = inputs.options::<CampaignOptions>()?.agenda(&kept, progress)?.to_json();
            Ok(Output { result, ..Output::default() })
        },
    },
    Operation {
        name: "moves",
        summary: "Time moves along a path on a controller: settling, overshoot, scan lag",
        module: "instruments",
        roles: &[MODEL, optional("path"), STAND_IN],
        options: MovesCall::rows,
        run: moves,
    },
];

options! {
    /// Options of `moves`.
    pub(crate) struct MovesCall {
        /// Also play the path on this plant.
        plant: Option<String> = None, OptionRow::new(NAME).list("plants");
    } with timing: MeasuredTimingOptions
}

/// Times moves; the caller has agreed to them.
fn moves(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let MovesCall { plant, timing } = inputs.options()?;
    let plant = some_simulated(inputs, plant.as_deref())?;
    let players = Players { plant: plant.as_ref().map(|(name, plant)| (&**name, plant)), measured: None };
    let (model, mut notes) = (inputs.one("model")?.model()?, Vec::new());
    let path =
        inputs.some("path")?.map(|file| DataFile::from(file).reference(&inputs.columns()?, &model)).transpose()?;
    let outcome = timing.run((&model, path), &players, &mut |_| Ok(()), &mut notes, progress);
    let outcome = outcome.map_err(|error| placed(error, &notes))?;
    timed(&outcome.timing, outcome.to_json())
}

/// What an earlier campaign has kept, which is then not measured again.
const EARLIER: Role = Role { name: "earlier", least: 0, many: true };

/// The files of a campaign; the caller has agreed to it.
struct Kept {
    earlier: Vec<File>,
    files: Vec<File>,
}

impl Journal for Kept {
    fn agree(&mut self, _: &Agenda) -> Result<(), Error> {
        Ok(())
    }

    fn earlier(&self, name: &str) -> Option<File> {
        let same = |file: &&File| file.name.rsplit('/').next() == Some(name);
        self.earlier.iter().find(same).map(|file| File::new(name, file.bytes.clone()))
    }

    fn keep(&mut self, files: Vec<File>) -> Result<(), Error> {
        self.files.retain(|kept| files.iter().all(|file| file.name != kept.name));
        self.files.extend(files);
        Ok(())
    }
}

fn acquire(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let options = inputs.options::<AcquireOptions>()?;
    let (drive, columns, mut notes) = (inputs.data("drive")?, inputs.columns()?, Vec::new());
    let outcome = options.run(&drive, &columns, &mut notes, &mut |_| Ok(()), progress);
    let outcome = outcome.map_err(|error| placed(error, &notes))?;
    let record = &outcome.record;
    let file = File::new("record.csv", record.written("record.csv")?);
    Ok(Output { result: outcome.to_json(), series: named([("u", record.u()), ("y", record.y())]), files: vec![file] })
}

/// The error of a measurement. One that was cancelled has to say where the axis is, which is the last note.
fn placed(error: Error, notes: &[String]) -> Error {
    match (&error, notes.last()) {
        (Error::Cancelled { .. }, Some(place)) => Error::Content(format!("{error}; {place}")),
        _ => error,
    }
}

/// A campaign that ended early returns what it has kept, with the reason as `failed`.
fn campaign(inputs: &Inputs, progress: &mut Progress) -> Result<Output, Error> {
    let options = inputs.options::<CampaignOptions>()?;
    let (reference, columns, mut notes) =
        (inputs.some("reference")?.map(DataFile::from), inputs.columns()?, Vec::new());
    let mut kept = Kept { earlier: inputs.all("earlier")?, files: Vec::new() };
    let path = reference.as_ref().map(|file| (file, &columns));
    // A rehearsal, if there is a stand-in.
    let outcome = match some_simulated(inputs, None)? {
        Some((name, plant)) => options.rehearse((&name, &plant), path, &mut kept, &mut notes, progress),
        None => options.run(path, &mut kept, &mut notes, progress),
    };
    let files = kept.files;
    match outcome {
        Err(error) if files.is_empty() => Err(placed(error, &notes)),
        Err(error) => {
            let result = json!({"failed": placed(error, &notes).to_string(), "notes": notes});
            Ok(Output { result, files, ..Output::default() })
        }
        Ok(found) => {
            let (straight, compensated) = (&found.straight, &found.compensated);
            let series = named([
                ("r_straight", &straight.r),
                ("straight", straight.record.y()),
                ("r", &compensated.r),
                ("compensated", compensated.record.y()),
            ]);
            let (mut result, model) = (found.to_json(), &found.identification.found.model);
            result["model"] = json!(model.to_string());
            result["sentence"] = json!(found.validated.verdict(model).as_ref().map(Verdict::to_string));
            result["ts"] = json!(compensated.ts);
            result["state"] = json!(found.unfinished.is_none().then(|| found.left.text(&found.setup.axis)));
            Ok(Output { result, series, files })
        }
    }
}
