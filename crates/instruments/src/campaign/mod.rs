//! A campaign: from an instrument to a model, and to a path that is measured with and without compensation.
//!
//! ```text
//! for each record:   demagnetisation, wait, record        small, rise1 to rise3, creep, path
//! identification from all records but path, validation on path
//! for each drive:    demagnetisation, wait, rest, path    straight line, compensated
//! ```
//! The hysteresis is in the middle of its loop before each drive, creep has decayed, and the inverse begins in that
//! state. The displacement at rest is measured right before a path is played: the offset of the model is corrected by
//! it, so that an error is one of the path, not one of the zero of the sensor.
//!
//! It does not do: mechanics with hysteresis in feedback, several axes, closed loop.

mod agenda;
mod page;
mod path;
#[cfg(test)]
mod tests;

pub use agenda::Agenda;
pub use path::Track;

use crate::acquire::{SECONDS, at_rest, servo_remark, stopped};
use crate::bench::Bench;
use crate::watch::shared;
use crate::{Function, Instrument, InstrumentOptions, Left, Setup};
use agenda::kept;
use path::Path;
use piezoid::control::SimulatedActuator;
use piezoid::formats::ColumnSelection;
use piezoid::progress::Progress;
use piezoid::validation::{Offset, ValidateOptions};
use piezoid::{Error, Identification, IdentifyOptions};
use piezoid_numerics::options::{OptionKind, OptionRow, Options, options};
use piezoid_verbs::{DataFile, File, Plan, PlannedDrive, Source, ValidateRecords, Validated};
use serde_json::{Value, json};

options! {
    /// How to measure, identify and straighten an actuator.
    pub struct CampaignOptions {
        /// Highest frequency of the application.
        bandwidth: f64 = 50.0, OptionRow::positive("Hz").required();
        /// Lowest and highest voltage of the application.
        range: Option<(f64, f64)> = None, OptionRow { unit: "V", ..OptionRow::new(OptionKind::Pair) }.absent("those of \
            the actuator, or of the controller");
        /// The actuator, for its range, capacitance and resonance (see {list}).
        actuator: Option<String> = None, OptionRow::new(OptionKind::Text("NAME")).list("actuators");
        /// Sampling period of the model.
        period: Option<f64> = None, OptionRow::positive("s").absent("from bandwidth and resonance");
        /// Wait after each demagnetisation, until creep has decayed.
        wait: f64 = 10.0, SECONDS;
        /// Hysteresis operators to identify: auto, names separated by commas, or auto,-NAME.
        operator: String = "auto".into(), OptionRow::new(OptionKind::Text("NAME")).list("operators");
    } with instrument: InstrumentOptions
}

/// Who runs a campaign: agrees to it, and keeps its files.
pub trait Journal {
    /// Agrees to what will move, before anything does.
    ///
    /// # Errors
    /// Its own, which ends the campaign.
    fn agree(&mut self, agenda: &Agenda) -> Result<(), Error>;

    /// A file that an earlier campaign has kept under this name.
    fn earlier(&self, name: &str) -> Option<File>;

    /// Keeps files, all of them or none.
    ///
    /// # Errors
    /// Its own, which ends the campaign.
    fn keep(&mut self, files: Vec<File>) -> Result<(), Error>;
}

/// What a campaign found.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// The instrument.
    pub setup: Setup,
    /// What was planned.
    pub plan: Plan,
    /// Names of the records that an earlier campaign had measured.
    pub resumed: Vec<String>,
    /// The model.
    pub identification: Identification,
    /// The model on the record `path`, which took no part in its identification.
    pub validated: Validated,
    /// The path with the voltages of a straight line.
    pub straight: Track,
    /// The path with the voltages of the inverse.
    pub compensated: Track,
    /// Where the axis is at the end.
    pub left: Left,
    /// Why the axis is not at its rest; `None` if it is.
    pub unfinished: Option<String>,
    /// What the user should know.
    pub notes: Vec<String>,
}

impl CampaignOptions {
    /// Connects to the controller and runs the campaign. `reference` is the path to follow [unit of the sensor];
    /// without it, the campaign has one of its own.
    ///
    /// After an error, and if `progress` cancels, nothing moves any more; where the axis is stands in the error or in
    /// `notes`. Records that were kept are not measured again by the next campaign with the same options.
    ///
    /// # Errors
    /// Returns the errors of [`InstrumentOptions::open`], [`PlanOptions::run`], [`IdentifyOptions::run`], those of the
    /// inverse for a path that cannot be reached, and those of the journal.
    pub fn run(
        &self,
        reference: Option<(&DataFile, &ColumnSelection)>,
        journal: &mut dyn Journal,
        notes: &mut Vec<String>,
        progress: &mut Progress,
    ) -> Result<Campaign, Error> {
        shared(progress, |of_line, own| {
            let mut instrument = self.instrument.open(of_line)?;
            self.on(&mut *instrument, reference, journal, notes, own)
        })
    }

    /// The same on a simulated actuator and its name, a rehearsal: without a controller, and without its waits.
    ///
    /// # Errors
    /// Those of [`Function::simulated`] and [`CampaignOptions::run`], and one for options of a controller.
    pub fn rehearse(
        &self,
        plant: (&str, &SimulatedActuator),
        reference: Option<(&DataFile, &ColumnSelection)>,
        journal: &mut dyn Journal,
        notes: &mut Vec<String>,
        progress: &mut Progress,
    ) -> Result<Campaign, Error> {
        let InstrumentOptions { ramp, rest, .. } = InstrumentOptions::default();
        let of_controller = InstrumentOptions { ramp, rest, limits: Default::default(), ..self.instrument.clone() };
        if let Some((row, value)) = of_controller.changed().first() {
            let rule = "has no effect on a simulated plant, which has no controller";
            return Err(Error::parameter(row.name, value, rule));
        }
        let limits = self.instrument.limits.limits()?.unwrap_or_default();
        shared(progress, |of_plant, own| {
            let mut function = Function::simulated(plant, limits, of_plant)?;
            self.on(&mut function, reference, journal, notes, own)
        })
    }

    /// The same on an instrument that is open. Its progress is its own.
    ///
    /// # Errors
    /// Those of [`CampaignOptions::run`].
    pub fn on(
        &self,
        instrument: &mut dyn Instrument,
        reference: Option<(&DataFile, &ColumnSelection)>,
        journal: &mut dyn Journal,
        notes: &mut Vec<String>,
        progress: &mut Progress,
    ) -> Result<Campaign, Error> {
        let agenda = self.agenda_on(instrument, journal)?;
        notes.extend(agenda.plan.notes.iter().cloned());
        journal.agree(&agenda)?;
        let Agenda { setup, plan, .. } = agenda;
        let bench = Bench {
            instrument,
            demagnetisation: &plan.demagnetisation,
            middle: plan.middle(),
            ts: plan.ts,
            ramp: self.instrument.ramp,
            wait: self.wait,
            part: String::new(),
        };
        let mut work = Work { options: self, plan: &plan, bench };
        let found = work.found(reference, journal, notes, progress);
        let found = found.map_err(|error| stopped(work.bench.instrument, error, notes))?;
        let (left, unfinished) = at_rest(work.bench.instrument, self.instrument.rest);
        notes.extend(servo_remark(setup.servo, left, &setup.axis));
        let Found { resumed, identification, validated, straight, compensated } = found;
        let notes = notes.clone();
        let campaign = Campaign {
            setup,
            plan,
            resumed,
            identification,
            validated,
            straight,
            compensated,
            left,
            unfinished,
            notes,
        };
        journal.keep(campaign.files()?)?;
        Ok(campaign)
    }
}

/// What is found before the axis returns to its rest.
struct Found {
    resumed: Vec<String>,
    identification: Identification,
    validated: Validated,
    straight: Track,
    compensated: Track,
}

/// A campaign at work on an instrument.
struct Work<'b> {
    options: &'b CampaignOptions,
    plan: &'b Plan,
    bench: Bench<'b>,
}

impl Work<'_> {
    fn found(
        &mut self,
        reference: Option<(&DataFile, &ColumnSelection)>,
        journal: &mut dyn Journal,
        notes: &mut Vec<String>,
        progress: &mut Progress,
    ) -> Result<Found, Error> {
        let (mut files, mut resumed) = (Vec::new(), Vec::new());
        for drive in &self.plan.drives {
            let identity = &self.bench.instrument.setup().identity;
            files.push(match kept(drive, journal, identity)? {
                Some(file) => {
                    resumed.push(drive.name.into());
                    file
                }
                None => self.record(drive, journal)?,
            });
        }
        let mut sources = Source::all(files, &ColumnSelection::default());
        let (path, small) = (sources.pop(), sources.remove(0));
        let options = IdentifyOptions { operator: self.options.operator.clone(), ..IdentifyOptions::default() };
        let identification = options.run((vec![small], sources), "campaign", progress)?;
        let model = &identification.found.model;
        journal.keep(vec![File::new("model.json", model.to_json())])?;
        // The zero of the sensor is measured before each path.
        let options = ValidateOptions { offset: Offset::Free, ..ValidateOptions::default() };
        let validated = options.run(model, path.into_iter().collect())?;
        let path = Path::new(self.options, self.plan, model, reference)?;
        let gain = path::gain(&validated.files);
        self.bench.part = "straight line".into();
        let straight = path.on(&mut self.bench, |r, rest| path.straight(r, rest, gain), notes)?;
        self.bench.part = "compensated path".into();
        let compensated = path.on(&mut self.bench, |r, rest| path.inverse(r, rest), notes)?;
        Ok(Found { resumed, identification, validated, straight, compensated })
    }

    /// Measures the record of a drive, and keeps both.
    fn record(&mut self, drive: &PlannedDrive, journal: &mut dyn Journal) -> Result<File, Error> {
        self.bench.part = format!("record {}", drive.name);
        self.bench.demagnetise()?;
        let record = self.bench.play("", &drive.u, drive.ts, self.options.wait)?;
        let name = format!("{}.csv", drive.name);
        let file = File::new(name.clone(), record.written(&name)?);
        journal.keep(vec![drive.written()?, file.clone()])?;
        Ok(file)
    }
}

impl Campaign {
    /// How many times better the compensated path is than that of a straight line.
    pub fn better(&self) -> f64 {
        self.straight.metrics.rmse / self.compensated.metrics.rmse
    }

    /// The results as a document.
    pub fn to_json(&self) -> Value {
        let (verdict, found) = (self.validated.verdict(&self.identification.found.model), &self.identification.found);
        json!({
            "identity": self.setup.identity, "axis": self.setup.axis, "plan": self.plan.to_json(),
            "resumed": self.resumed, "operator": found.model.hysteresis().operator().name, "verdict": verdict,
            "path": self.validated.to_json(), "straight": self.straight.to_json(),
            "compensated": self.compensated.to_json(), "better": self.better(),
            "voltage": self.left.voltage, "servo": self.left.servo, "unfinished": self.unfinished, "notes": self.notes,
        })
    }

    /// Both paths, the results, and the page; the model is kept once it is identified.
    fn files(&self) -> Result<Vec<File>, Error> {
        let track = |name: &str, track: &Track| Ok(File::new(name, track.written(name)?));
        Ok(vec![
            track("straight.csv", &self.straight)?,
            track("compensated.csv", &self.compensated)?,
            File::new("campaign.json", format!("{:#}\n", self.to_json())),
            File::new("campaign.html", self.page().html()),
        ])
    }
}
