//! The voltages of a path before anything plays them: compensated, and along a straight line.
//!
//! ```text
//! u = u_low + (r - y_low) (u_high - u_low) / (y_high - y_low)        straight line, through the ends of the stroke
//! ```
//! Both are clipped to the limits of voltage, slew and current. An actuator with a past needs a known state:
//! [`Start::Demagnetised`] begins at the middle of the range after a decaying sine, where the displacement can be
//! compared with the model's, and a slow move leads from there to the first value of the path.
//!
//! It does not do: this state for mechanics with hysteresis in feedback, which begin settled at the middle.

use super::fastest::{Mover, Player};
use super::{MoveOptions, Players, RunTiming, Timing, Twin, cancelled, length};
use crate::{Compensation, Faster};
use piezoid_control::compensation::{FeedForward, FeedForwardSettings};
use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_numerics::error::{Error, finite};
use piezoid_numerics::number::short;
use piezoid_numerics::progress::Progress;
use piezoid_numerics::series::ends;
use piezoid_numerics::system::System;
use piezoid_records::excitation::{LimitOptions, minimum_jerk};

/// The default tolerance, over the height of the path.
const TOLERANCE: f64 = 0.01;

/// Height of the default step, and of the default flyback, over the stroke.
const STEP: f64 = 0.1;
const FLYBACK: f64 = 0.8;

/// Time for which the default step is held [s], and its smallest number of samples.
const HELD: f64 = 0.25;
const HELD_SAMPLES: usize = 600;

/// Time at rest before and after the move to the path, and its smallest number of samples [s].
const REST: f64 = 0.1;
const REST_SAMPLES: usize = 100;

/// Least time of the move to the path [s], and its mean slew over the largest.
const MOVE: f64 = 0.2;
const MOVE_SLEW: f64 = 0.25;
const MOVE_SAMPLES: f64 = 1e6;

/// The state before a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// Settled at its first value.
    Settled,
    /// At the middle of the range, after a decaying sine about it; a slow move leads to the path.
    Demagnetised,
}

/// A path and its voltages.
#[derive(Debug)]
pub struct PlannedMoves<'m> {
    model: &'m Model,
    settings: FeedForwardSettings,
    inverse: FeedForward,
    tolerance: f64,
    is_path: bool,
    compensation: Compensation,
    /// Voltages with the samples before the path.
    compensated: Vec<f64>,
    line: Vec<f64>,
    /// The displacement of the model with the second one.
    on_line: Vec<f64>,
    /// Samples before the path.
    before: usize,
    lead: Lead,
}

/// Where the samples before a path begin.
#[derive(Debug)]
struct Lead {
    condition: InitialCondition,
    /// Lowest and highest voltage, and the middle [input unit].
    range: (f64, f64),
    middle: f64,
    /// Displacement there, as the model has it [output unit].
    rest: f64,
}

impl MoveOptions {
    /// The voltages for the path `r` [output unit], or for a step up and down.
    ///
    /// # Errors
    /// Returns an error for a tolerance or a step that is no positive length, inconsistent limits, a model without an
    /// inverse, and a path that cannot be held or shaped.
    pub fn planned<'m>(
        &self,
        limits: &LimitOptions,
        model: &'m Model,
        r: Option<Vec<f64>>,
        start: Start,
    ) -> Result<PlannedMoves<'m>, Error> {
        let settings =
            FeedForwardSettings { iterations: self.iterations, ..FeedForwardSettings::within(limits, false)? };
        let inverse = FeedForward::new(model, settings)?;
        let (ts, units, reach) = (model.ts(), model.units().clone(), inverse.reach());
        let is_path = r.is_some();
        if let (true, Some(step)) = (is_path, &self.step) {
            return Err(Error::parameter("step", step, "has no effect beside a path: leave it out"));
        }
        let requested = r.map_or_else(|| self.step_along(model, reach), Ok)?;
        finite("path", &requested)?;
        inverse.holds(&requested)?;
        let (low, high) = ends(requested.iter().copied());
        let tolerance = match &self.tolerance {
            Some(text) => length("tolerance", text, &units.y)?,
            None => TOLERANCE * (high - low),
        };
        if tolerance <= 0.0 || tolerance.is_nan() {
            let rule = "must be a positive length, because the path stays where it is";
            return Err(Error::parameter("tolerance", short(tolerance), rule));
        }
        let clipping = FeedForward::new(model, FeedForwardSettings { clip: true, ..settings })?;
        let shaped = self.shape.of(model, requested.clone())?;
        let lead = Lead::new(model, settings.ends(model)?);
        let whole = match start {
            Start::Settled => shaped.clone(),
            Start::Demagnetised => lead.to(&shaped, (ts, model.linear().delay(), settings.limits.fastest())),
        };
        let before = whole.len() - shaped.len();
        let mut found = match lead.condition {
            condition if start == Start::Demagnetised && condition != InitialCondition::Settled => {
                clipping.whole_from(condition, lead.middle, &whole)?
            }
            _ => clipping.whole(&whole)?,
        };
        let line = settings.limits.clip(&straight(model, settings.ends(model)?, reach, &whole), ts)?;
        let mut x = match start {
            Start::Settled => model.settled(line.first().copied().unwrap_or(0.0)),
            Start::Demagnetised => model.before(&[lead.middle], lead.condition),
        };
        let on_line = after(before, model.follow(&mut x, &line));
        let compensated = found.u.clone();
        (found.u, found.reached) = (after(before, found.u), after(before, found.reached));
        let compensation = Compensation::new(model, requested, shaped, (found, reach));
        Ok(PlannedMoves {
            model,
            settings,
            inverse,
            tolerance,
            is_path,
            compensation,
            compensated,
            line,
            on_line,
            before,
            lead,
        })
    }

    /// The default path: a step up and down about the middle of the stroke.
    fn step_along(&self, model: &Model, reach: (f64, f64)) -> Result<Vec<f64>, Error> {
        let height = match &self.step {
            Some(text) => length("step", text, &model.units().y)?,
            None => STEP * (reach.1 - reach.0),
        };
        let middle = 0.5 * (reach.0 + reach.1);
        let (low, high) = (middle - 0.5 * height, middle + 0.5 * height);
        let held = ((HELD / model.ts()).min(1e6) as usize).max(HELD_SAMPLES);
        Ok([vec![low; HELD_SAMPLES], vec![high; held], vec![low; held]].concat())
    }
}

impl Lead {
    fn new(model: &Model, (low, high): (f64, f64)) -> Self {
        let (least, most) = model.known_inputs().unwrap_or((low, high));
        let range = (low.max(least), high.min(most));
        let middle = 0.5 * range.0 + 0.5 * range.1;
        let is_in_feedback = model.feedback().is_some();
        let condition = if is_in_feedback { InitialCondition::Settled } else { InitialCondition::Demagnetised };
        let rest = model.resume(&mut model.before(&[middle], condition), &[middle])[0];
        Lead { condition, range, middle, rest }
    }

    /// A path with what leads to it: rest, a slow move within the slew `fastest` [V/s], rest.
    fn to(&self, path: &[f64], (ts, delay, fastest): (f64, usize, f64)) -> Vec<f64> {
        let first = path.first().copied().unwrap_or(self.rest);
        let hold = ((REST / ts).ceil().min(MOVE_SAMPLES) as usize).max(REST_SAMPLES + delay);
        let time = MOVE.max((self.range.1 - self.range.0) / (MOVE_SLEW * fastest));
        let n = (time / ts).ceil().clamp(1.0, MOVE_SAMPLES) as usize;
        let moved = |k: usize| self.rest + (first - self.rest) * minimum_jerk(k as f64 / n as f64);
        let hold = |at: f64| std::iter::repeat_n(at, hold);
        hold(self.rest).chain((0..n).map(moved)).chain(hold(first)).chain(path.iter().copied()).collect()
    }
}

impl PlannedMoves<'_> {
    /// The voltages with their names, with the samples before the path [input unit].
    pub fn voltages(&self) -> [(&'static str, &[f64]); 2] {
        [("compensated", &self.compensated), ("straight line", &self.line)]
    }

    /// What follows the samples before the path.
    pub fn along_path(&self, y: Vec<f64>) -> Vec<f64> {
        after(self.before, y)
    }

    /// Lowest and highest voltage of a decaying sine that demagnetises [input unit].
    pub fn range(&self) -> (f64, f64) {
        self.lead.range
    }

    /// Voltage at the middle of the range, and the displacement there as the model has it.
    pub fn rest(&self) -> (f64, f64) {
        (self.lead.middle, self.lead.rest)
    }

    /// The same path on the model, and on what else plays it, with the fastest moves.
    ///
    /// # Errors
    /// Returns an error for a plant that does not match, a measured displacement of another length, and cancellation.
    pub fn timed(&self, players: &Players, progress: &mut Progress) -> Result<Timing, Error> {
        let (compensation, tolerance) = (&self.compensation, self.tolerance);
        let mut timing = Timing {
            ts: compensation.ts,
            units: compensation.units.clone(),
            tolerance,
            path: compensation.shaped.clone(),
            u: compensation.compensated.u.clone(),
            faster: Faster::of(self.model, &compensation.compensated.u),
            runs: Vec::new(),
            displacements: Vec::new(),
            fastest: Vec::new(),
            notes: compensation.compensated.notes.clone(),
            verdict: compensation.verdict.clone(),
        };
        timing.add("model, compensated", compensation.compensated.reached.clone())?;
        timing.add("model, straight line", self.on_line.clone())?;
        let plant = players.plant.map(|plant| Twin::new(plant, self.model, &self.settings, &mut timing.notes));
        let plant = plant.transpose()?;
        if let Some(twin) = &plant {
            for (what, u) in self.voltages() {
                timing.add(format!("{}, {what}", twin.name), self.along_path(twin.play(u)))?;
            }
            timing.notes.extend(twin.saturated(&self.compensated));
        }
        if let Some(y) = &players.measured {
            timing.add("measured", y.clone())?;
        }
        cancelled(progress, 1)?;
        let play = plant.as_ref().map(|twin| |u: &[f64]| twin.play(u));
        let play = play.as_ref().map(|play| play as Player);
        let mover = Mover { model: self.model, inverse: &self.inverse, tolerance, plant: play };
        let (step, flyback) = self.goals();
        timing.fastest = mover.fastest("step", step);
        cancelled(progress, 2)?;
        timing.fastest.extend(mover.fastest("flyback", flyback));
        cancelled(progress, 3)?;
        timing.notes.extend(timing.beyond());
        timing.notes.extend(self.remarks());
        Ok(timing)
    }

    /// The ends of the step and of the flyback whose fastest moves are searched: the largest step of the path, or a
    /// tenth of its height, and from its top to its bottom. Without a path, the flyback is over 0.8 of the stroke.
    fn goals(&self) -> ((f64, f64), (f64, f64)) {
        let (r, reach) = (&self.compensation.shaped, self.compensation.reach);
        let (low, high) = ends(r.iter().copied());
        let steps = RunTiming::of("path", 1.0, (r, r), 0.0).steps;
        let largest = steps.iter().rev().max_by(|a, b| (a.to - a.from).abs().total_cmp(&(b.to - b.from).abs()));
        let middle = 0.5 * (low + high);
        let step = largest.map_or((middle, middle + STEP * (high - low)), |step| (step.from, step.to));
        let (centre, half) = (0.5 * (reach.0 + reach.1), 0.5 * FLYBACK * (reach.1 - reach.0));
        (step, if self.is_path { (high, low) } else { (centre + half, centre - half) })
    }

    /// Notes on the tolerance and on the limits.
    fn remarks(&self) -> Vec<String> {
        let (compensation, tolerance) = (&self.compensation, self.tolerance);
        let (unit, mut notes) = (&compensation.units.y, Vec::new());
        if let Some(expected) = compensation.expected_rms().filter(|expected| tolerance < 2.0 * expected) {
            notes.push(format!(
                "the tolerance of {} {unit} is below twice the rms error to expect of this model along the path, {} \
                 {unit}: on the actuator moves may settle later, or not at all; identify a better model, or allow more",
                short(tolerance),
                short(expected)
            ));
        }
        if self.settings.limits.fastest().is_infinite() {
            notes.push(
                "the limits of the driver are not known, so that moves may be shorter here than on the actuator: name \
                 the driver"
                    .into(),
            );
        }
        notes
    }
}

/// What follows the first samples.
fn after(samples: usize, mut values: Vec<f64>) -> Vec<f64> {
    values.split_off(samples.min(values.len()))
}

/// The straight line from displacement to voltage through the ends of the stroke, within these ends.
fn straight(model: &Model, (low, high): (f64, f64), reach: (f64, f64), r: &[f64]) -> Vec<f64> {
    // A model may fall with its input.
    let falls = model.linear().dc_gain() < 0.0;
    let (from, to) = if falls { (reach.1, reach.0) } else { reach };
    r.iter().map(|r| (low + (r - from) * (high - low) / (to - from)).max(low).min(high)).collect()
}
