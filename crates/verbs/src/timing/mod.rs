//! Moves in time: settling, overshoot and scan lag along a path, and the fastest moves of the actuator.
//!
//! A path, perhaps shaped, is compensated with the model, known as a whole and clipped to the limits, and played on the
//! model and, if named, on a simulated plant, each beside a straight line from displacement to voltage.
//!
//! [`RunTiming::of`] takes any displacement along a requested one, such as a record of a controller. The reading of a
//! plant is without the noise of its sensor, which is no motion. It does not simulate feedback: `control` does.

mod fastest;
mod planned;
mod run;

pub use fastest::{FastestMove, Landing};
pub use planned::{PlannedMoves, Start};
pub use run::{RunTiming, ScanLag, StepTiming};

use super::on_plant::played;
use super::same_actuator::matched;
use super::verdict::proven;
use super::{DataFile, Faster, File, Verdict, blamed};
use piezoid_control::compensation::FeedForwardSettings;
use piezoid_control::compensation::shaping::Shaping;
use piezoid_control::feedback::SimulatedActuator;
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::ascii_unit;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_numerics::system::System;
use piezoid_records::excitation::LimitOptions;
use piezoid_records::formats::{ColumnSelection, Table};
use piezoid_records::record::{Record, Units};
use piezoid_twins::Plant;
use piezoid_validation::rough;
use serde_json::{Value, json};

options! {
    /// How to time moves, within limits that are stated elsewhere.
    pub struct MoveOptions {
        /// Largest error of a settled displacement: a number in the model's output unit, or with a unit, such as 0.1um.
        tolerance: Option<String> = None, OptionRow::new(LENGTH).absent("1 % of the height of the path");
        /// Height of the step up and down that is the path if none is given, written like {tolerance}.
        step: Option<String> = None, OptionRow::new(LENGTH).absent("a tenth of the stroke");
        /// Largest number of iterations that correct the error left in the model's free run.
        iterations: usize = 0, OptionRow::new(OptionKind::Integer(0, u64::MAX));
    } with shape: Shaping
}

options! {
    /// How to time moves.
    pub struct TimingOptions {
    } with moves: MoveOptions with limits: LimitOptions
}

const LENGTH: OptionKind = OptionKind::Text("LENGTH");

/// What plays a path beside the model.
#[derive(Debug, Default)]
pub struct Players<'a> {
    /// A plant by name.
    pub plant: Option<(&'a str, &'a SimulatedActuator)>,
    /// The displacement that was measured along the path [output unit].
    pub measured: Option<Vec<f64>>,
}

/// The timing of moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Timing {
    /// Sampling period [s].
    pub ts: f64,
    /// Units of voltage and displacement.
    pub units: Units,
    /// Largest error of a settled displacement [output unit].
    pub tolerance: f64,
    /// The path after shaping [output unit].
    pub path: Vec<f64>,
    /// The compensated voltage [input unit].
    pub u: Vec<f64>,
    /// Set if it changes faster than that of the training data: the timing is then that of the model alone.
    pub faster: Option<Faster>,
    /// The timing of each run.
    pub runs: Vec<RunTiming>,
    /// The displacement of each run [output unit].
    pub displacements: Vec<Vec<f64>>,
    /// The fastest moves of each shape: steps, then flybacks.
    pub fastest: Vec<FastestMove>,
    /// Remarks, one sentence each.
    pub notes: Vec<String>,
    /// How good the model was at its identification, if its file says so.
    pub verdict: Option<Verdict>,
}

impl TimingOptions {
    /// Times the path `r` [output unit], or a step up and down, with `model`.
    ///
    /// # Errors
    /// Those of [`MoveOptions::planned`] and [`PlannedMoves::timed`].
    pub fn of(
        &self,
        model: &Model,
        r: Option<Vec<f64>>,
        players: &Players,
        progress: &mut Progress,
    ) -> Result<Timing, Error> {
        self.moves.planned(&self.limits, model, r, Start::Settled)?.timed(players, progress)
    }

    /// The same from files; `measured` is the record of a controller along the path, whose column y counts.
    ///
    /// # Errors
    /// The errors of [`TimingOptions::of`], and errors for files without a model, a path or a displacement.
    pub fn run(
        &self,
        file: &File,
        (path, measured): (Option<&DataFile>, Option<&DataFile>),
        plant: Option<(&str, &SimulatedActuator)>,
        columns: &ColumnSelection,
        progress: &mut Progress,
    ) -> Result<Timing, Error> {
        let model = file.model()?;
        let r = path.map(|path| path.reference(columns, &model)).transpose()?;
        if let (Some(_), None) = (measured, path) {
            let rule = "must come with the path along which it was measured";
            return Err(Error::parameter("measured", "a file", rule));
        }
        let measured = measured.map(|file| displacement(file, columns, &model)).transpose()?;
        let result = self.of(&model, r, &Players { plant, measured }, progress);
        result.map_err(|e| path.map_or(e.clone(), |path| blamed(e, file).about(&path.name)))
    }
}

/// Returns an error if the work is cancelled after `done` of its steps.
fn cancelled(progress: &mut Progress, done: usize) -> Result<(), Error> {
    let (what, total) = ("timing of moves", 3);
    match progress(Stage::new(what, done, total)).is_break() {
        true => Err(Error::Cancelled { what: what.into(), done, total }),
        false => Ok(()),
    }
}

/// The positive length in a text, with a unit or in the output unit.
pub(super) fn length(name: &str, text: &str, unit: &str) -> Result<f64, Error> {
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit() && c != '.');
    let own = ascii_unit(text[digits.len()..].trim());
    let factor = if own.is_empty() { Some(1.0) } else { Units::factor(&own, unit) };
    let value = digits.trim().parse::<f64>().ok().zip(factor).map(|(value, factor)| value * factor);
    value.filter(|v| v.is_finite() && *v > 0.0).ok_or_else(|| {
        let rule = format!("must be a positive length, in {unit} or with a unit that can be converted to it");
        Error::parameter(name, text, rule)
    })
}

/// The displacement in a record along a path, in the output unit of the model.
fn displacement(file: &DataFile, columns: &ColumnSelection, model: &Model) -> Result<Vec<f64>, Error> {
    let of = |table: Table| {
        let own = |name: &&str| name.starts_with("y_");
        let output_col = columns.output_col.clone().or_else(|| table.names().find(own).map(Into::into));
        // A column that is named is taken even beside one of a reference.
        let signal = table.reference(&ColumnSelection { output_col, ..columns.clone() })?;
        Record::same_sampling("the model", model.ts(), "the measured displacement", signal.ts)?;
        signal.samples_in(&model.units().y, "the measured displacement")
    };
    file.read(of)
}

/// A simulated plant, in the units of the model.
struct Twin {
    name: String,
    plant: Box<dyn System>,
    /// The plant that states which limits it reached; `None` for one without limits.
    limited: Option<Plant>,
}

impl Twin {
    fn new(
        (name, actuator): (&str, &SimulatedActuator),
        model: &Model,
        settings: &FeedForwardSettings,
        notes: &mut Vec<String>,
    ) -> Result<Self, Error> {
        let (actuator, note) = matched((name, actuator), model, settings)?;
        notes.extend(note);
        let quiet = actuator.without_noise();
        let limited = match &quiet {
            SimulatedActuator::Twin(spec) => Some(Plant::new(spec, model.ts())?),
            SimulatedActuator::StandIn(_) => None,
        };
        Ok(Twin { name: name.into(), plant: quiet.plant(model, 0)?, limited })
    }

    /// The displacement with the voltage `u`, from the settled state at its first value.
    fn play(&self, u: &[f64]) -> Vec<f64> {
        played(&*self.plant, u)
    }

    fn saturated(&self, u: &[f64]) -> Option<String> {
        let plant = self.limited.as_ref()?;
        let mut x = plant.settled(u.first().copied().unwrap_or(0.0));
        plant.resume(&mut x, u);
        let found = plant.saturation(&x);
        found.any().then(|| format!("{}: along the path, {found}", self.name))
    }
}

impl Timing {
    /// Adds a run with this displacement along the path [output unit].
    ///
    /// # Errors
    /// Returns an error for a displacement of another length.
    pub fn add(&mut self, name: impl Into<String>, y: Vec<f64>) -> Result<(), Error> {
        let (name, r) = (name.into(), &self.path);
        if y.len() != r.len() {
            let (left, right) = ("the path".into(), format!("the displacement `{name}`"));
            return Err(Error::Lengths { left, left_len: r.len(), right, right_len: y.len() });
        }
        self.runs.push(RunTiming::of(name, self.ts, (r, &y), self.tolerance));
        self.displacements.push(y);
        Ok(())
    }

    /// How good the model is, in words.
    pub fn proven(&self) -> String {
        proven(self.verdict.as_ref())
    }

    /// The fastest move of this purpose on the model, `step` or `flyback`.
    pub fn shortest(&self, purpose: &str) -> Option<&FastestMove> {
        let all = self.fastest.iter().filter(|m| m.purpose == purpose && m.settling_s.is_some());
        all.min_by(|a, b| a.settling_s.partial_cmp(&b.settling_s).unwrap_or(std::cmp::Ordering::Equal))
    }

    /// That with the least overshoot on the model.
    pub fn smoothest(&self, purpose: &str) -> Option<&FastestMove> {
        let all = self.fastest.iter().filter(|m| m.purpose == purpose && m.settling_s.is_some());
        all.min_by(|a, b| a.overshoot.partial_cmp(&b.overshoot).unwrap_or(std::cmp::Ordering::Equal))
    }

    /// Notes on the shortest moves whose voltage changes faster than the training data.
    fn beyond(&self) -> Vec<String> {
        let shortest = ["step", "flyback"].into_iter().filter_map(|purpose| self.shortest(purpose));
        let note = |m: &FastestMove| {
            let Faster { slew, identified_slew } = m.faster?;
            let (purpose, ratio) = (m.purpose, rough(slew / identified_slew));
            Some(format!(
                "the shortest {purpose} changes the voltage {ratio} times as fast as the training data: on the actuator it \
                 may settle later; identify on a record that is as fast, or take a slower move"
            ))
        };
        shortest.filter_map(note).collect()
    }

    /// The figures as a document.
    pub fn to_json(&self) -> Value {
        let best = |purpose| json!({"shortest": self.shortest(purpose), "least_overshoot": self.smoothest(purpose)});
        json!({
            "unit": self.units.y, "ts": self.ts, "tolerance": self.tolerance, "faster": self.faster, "runs": self.runs,
            "fastest": self.fastest, "step": best("step"), "flyback": best("flyback"), "notes": self.notes,
            "verdict": self.verdict,
        })
    }

    /// Path, voltage and the displacement of each run as a file of this name.
    ///
    /// # Errors
    /// The errors of [`Table::write`].
    pub fn written(&self, name: &str) -> Result<Vec<u8>, Error> {
        let (u, y) = (&self.units.u, &self.units.y);
        let mut columns = vec![(format!("u_{u}"), &self.u), (format!("r_{y}"), &self.path)];
        for (run, found) in self.runs.iter().zip(&self.displacements) {
            let plain: String = run.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
            columns.push((format!("{}_{y}", plain.replace("__", "_")), found));
        }
        let columns: Vec<(&str, &[f64])> = columns.iter().map(|(name, v)| (&**name, &v[..])).collect();
        Table::write(name, self.ts, &columns)
    }
}

#[cfg(test)]
mod tests;
