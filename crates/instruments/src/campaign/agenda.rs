//! What a campaign is going to measure and to move, to which its user agrees before anything moves.

use super::{CampaignOptions, Journal};
use crate::bench::{drive_of, to_move};
use crate::instrument::measuring;
use crate::{Instrument, Rest, Setup};
use piezoid::Error;
use piezoid::formats::ColumnSelection;
use piezoid::progress::Progress;
use piezoid_verbs::{DataFile, File, Plan, PlanOptions, PlannedDrive};
use serde_json::{Value, json};

/// What a campaign is going to do.
#[derive(Debug, Clone, PartialEq)]
pub struct Agenda {
    /// The instrument.
    pub setup: Setup,
    /// The drives.
    pub plan: Plan,
    /// Where the axis goes at the end.
    pub rest: Rest,
    /// Names of the records that an earlier campaign has measured.
    pub resumed: Vec<String>,
    /// The time that everything takes that moves, without what is sent and read in between [s].
    pub seconds: f64,
}

impl CampaignOptions {
    /// Connects to the controller, and plans. Nothing moves.
    ///
    /// # Errors
    /// Returns the errors of [`InstrumentOptions::open`](crate::InstrumentOptions::open) and [`PlanOptions::run`], and
    /// one for a drive that the controller cannot play within the limits.
    pub fn agenda(&self, journal: &dyn Journal, progress: &mut Progress) -> Result<Agenda, Error> {
        self.agenda_on(&*self.instrument.open(progress)?, journal)
    }

    /// The same on an instrument that is open.
    pub(super) fn agenda_on(&self, instrument: &dyn Instrument, journal: &dyn Journal) -> Result<Agenda, Error> {
        let setup = instrument.setup().clone();
        let plan = self.plan(&setup)?;
        for drive in plan.drives.iter().chain([&plan.demagnetisation]) {
            let drive_now = drive_of(("", &drive.u), (drive.ts, plan.ts), self.instrument.ramp);
            setup.check(&drive_now).map_err(|error| error.of(&drive.file()))?;
        }
        let mut resumed = Vec::new();
        for drive in &plan.drives {
            if kept(drive, journal, &setup.identity)?.is_some() {
                resumed.push(drive.name.to_string());
            }
        }
        let seconds = self.duration(&plan, &resumed);
        Ok(Agenda { setup, plan, rest: self.instrument.rest, resumed, seconds })
    }

    /// The drives, within what the instrument can play.
    fn plan(&self, setup: &Setup) -> Result<Plan, Error> {
        let range = self.range.or((self.actuator.is_none()).then_some(setup.range));
        let defaults = PlanOptions::default();
        PlanOptions {
            range,
            bandwidth: self.bandwidth,
            actuator: self.actuator.clone(),
            ts: self.period,
            points: setup.most_samples().unwrap_or(defaults.points).min(defaults.points),
            cycle: Some(setup.cycle),
            joins: setup.joins,
            limits: self.instrument.limits.clone(),
        }
        .run(None)
    }

    /// The time that everything takes that moves, without these records [s].
    fn duration(&self, plan: &Plan, resumed: &[String]) -> f64 {
        let missing = plan.drives.iter().filter(|drive| !resumed.iter().any(|name| name == drive.name));
        let records: Vec<f64> = missing.map(|drive| plan.duration(drive)).collect();
        let path = plan.drives.last().map_or(0.0, |path| plan.duration(path));
        // Both paths follow; a slow move comes before each drive, each demagnetisation and each wait at rest.
        let (demagnetisations, moves) = ((records.len() + 2) as f64, (2 * records.len() + 6) as f64);
        records.iter().sum::<f64>()
            + 2.0 * path
            + demagnetisations * (plan.duration(&plan.demagnetisation) + self.wait)
            + moves * self.instrument.ramp
    }
}

/// The record of a drive that was kept earlier, if the drive is still the same.
///
/// # Errors
/// Returns an error for the record of an instrument with another identity: a rehearsal is no measurement.
pub(super) fn kept(drive: &PlannedDrive, journal: &dyn Journal, identity: &str) -> Result<Option<File>, Error> {
    let [played, record] = [drive.file(), format!("{}.csv", drive.name)].map(|name| journal.earlier(&name));
    let same = played.is_some_and(|played| drive.written().is_ok_and(|file| file.bytes == played.bytes));
    let Some(file) = record.filter(|_| same) else { return Ok(None) };
    let Ok(record) = DataFile::from(file.clone()).record(&ColumnSelection::default()) else { return Ok(None) };
    match measuring(&record) {
        Some(other) if other != identity.trim() => Err(Error::Content(format!(
            "{} was measured by `{other}`, not by `{identity}`: take another folder for this campaign",
            file.name
        ))),
        _ => Ok(Some(file)),
    }
}

impl Agenda {
    /// Lowest and highest voltage of all that moves [V].
    pub fn range(&self) -> (f64, f64) {
        let all = || self.plan.drives.iter().chain([&self.plan.demagnetisation]);
        let low = all().map(|drive| drive.usage.lowest.value).fold(f64::INFINITY, f64::min);
        let high = all().map(|drive| drive.usage.highest.value).fold(f64::NEG_INFINITY, f64::max);
        self.rest.with((low, high))
    }

    /// What is to move, as text.
    pub fn text(&self) -> String {
        let ((low, high), setup) = (self.range(), &self.setup);
        let text = to_move(setup, (low, high), self.seconds);
        if self.resumed.is_empty() {
            return text;
        }
        format!("{text} Measured earlier, and not again: {}.", self.resumed.join(", "))
    }

    /// The same as a document.
    pub fn to_json(&self) -> Value {
        let Setup { identity, axis, servo, .. } = &self.setup;
        json!({
            "identity": identity, "axis": axis, "servo": servo, "range": self.range(), "seconds": self.seconds,
            "text": self.text(), "resumed": self.resumed, "plan": self.plan.to_json(),
        })
    }
}
