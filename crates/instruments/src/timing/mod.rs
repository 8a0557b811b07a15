//! The timing of moves on a controller: the voltages of a path are played, and the displacement is measured.
//!
//! ```text
//! for each voltage:   demagnetisation, wait, rest y_0, path        compensated, straight line
//! y = y_measured + y_rest - y_0                                    y_rest: the model at rest, in the same state
//! ```
//! The zero of the sensor is thus no error of a path. All that needs only the model is computed before anything moves,
//! so that the axis does not wait for it away from its rest.
//!
//! It does not do: several axes, closed loop.

use crate::acquire::{SECONDS, at_rest, servo_remark, stopped};
use crate::bench::{Bench, drive_of, still, to_move};
use crate::watch::shared;
use crate::{Instrument, InstrumentOptions, Left, Setup};
use piezoid::excitation::LimitOptions;
use piezoid::progress::Progress;
use piezoid::{Error, Model, System, Units};
use piezoid_numerics::options::options;
use piezoid_numerics::series::ends;
use piezoid_verbs::{MoveOptions, PlanOptions, PlannedDrive, PlannedMoves, Players, Start, Timing};
use serde_json::{Value, json};

options! {
    /// How to time moves on a controller.
    pub struct MeasuredTimingOptions {
        /// Wait after each demagnetisation, until creep has decayed.
        wait: f64 = 10.0, SECONDS;
    } with moves: MoveOptions with instrument: InstrumentOptions
}

/// The timing of moves, on a controller too.
#[derive(Debug, Clone)]
pub struct MeasuredTiming {
    /// The instrument.
    pub setup: Setup,
    /// The timing; its last two runs are those of the controller.
    pub timing: Timing,
    /// Where the axis is at the end.
    pub left: Left,
    /// Why the axis is not at its rest; `None` if it is.
    pub unfinished: Option<String>,
}

/// Agrees to what is to move, before anything does.
pub type Agree<'a> = dyn FnMut(&str) -> Result<(), Error> + 'a;

/// Bandwidth of the demagnetisation [Hz], and its largest shares of the sampling rate and of the first mode.
const BANDWIDTH: f64 = 50.0;
const OF_RATE: f64 = 0.05;
const OF_MODE: f64 = 0.3;

impl MeasuredTimingOptions {
    /// Connects to the controller, and times the path `r` [output unit], or a step up and down, with `model`, with
    /// `players`, and on the controller.
    ///
    /// After an error, and if `progress` cancels, nothing moves any more; where the axis is stands in the error or in
    /// `notes`.
    ///
    /// # Errors
    /// Returns the errors of [`MoveOptions::planned`], [`PlannedMoves::timed`] and [`InstrumentOptions::open`], one for
    /// a voltage that the controller cannot play within the limits, and that of `agree`.
    pub fn run(
        &self,
        (model, r): (&Model, Option<Vec<f64>>),
        players: &Players,
        agree: &mut Agree,
        notes: &mut Vec<String>,
        progress: &mut Progress,
    ) -> Result<MeasuredTiming, Error> {
        // What is wrong with the path is found before anything is connected, whose limits may be narrower.
        self.moves.planned(&self.instrument.limits, model, r.clone(), Start::Demagnetised)?;
        shared(progress, |of_line, own| {
            let mut instrument = self.instrument.open(of_line)?;
            self.on(&mut *instrument, (model, r), players, agree, notes, own)
        })
    }

    /// The same on an instrument that is open. Its progress is its own.
    ///
    /// # Errors
    /// Those of [`MeasuredTimingOptions::run`].
    pub fn on(
        &self,
        instrument: &mut dyn Instrument,
        (model, r): (&Model, Option<Vec<f64>>),
        players: &Players,
        agree: &mut Agree,
        notes: &mut Vec<String>,
        progress: &mut Progress,
    ) -> Result<MeasuredTiming, Error> {
        let setup = instrument.setup().clone();
        let moves = self.moves.planned(&within(&self.instrument.limits, &setup), model, r, Start::Demagnetised)?;
        let demagnetisation = self.demagnetisation(&moves, model, &setup)?;
        let mut timing = moves.timed(players, progress)?;
        agree(&self.agenda(&moves, &demagnetisation, model.ts(), &setup)?)?;
        let bench = Bench {
            instrument,
            demagnetisation: &demagnetisation,
            middle: moves.rest().0,
            ts: model.ts(),
            ramp: self.instrument.ramp,
            wait: self.wait,
            part: String::new(),
        };
        let mut work = Work { bench, moves: &moves, unit: &model.units().y };
        let found = work.measured();
        let found = found.map_err(|error| stopped(work.bench.instrument, error, notes))?;
        let (left, unfinished) = at_rest(work.bench.instrument, self.instrument.rest);
        for (name, y) in found {
            timing.add(name, y)?;
        }
        timing.notes.extend(notes.iter().cloned().chain(servo_remark(setup.servo, left, &setup.axis)));
        Ok(MeasuredTiming { setup, timing, left, unfinished })
    }

    /// What brings the hysteresis to the middle of its loop.
    fn demagnetisation(&self, moves: &PlannedMoves, model: &Model, setup: &Setup) -> Result<PlannedDrive, Error> {
        let (ts, points) = (model.ts(), PlanOptions::default().points);
        let mode = model.linear().resonance().map_or(f64::INFINITY, |mode| mode.hz);
        PlanOptions {
            range: Some(moves.range()),
            bandwidth: BANDWIDTH.min(OF_RATE / ts).min(OF_MODE * mode),
            ts: Some(ts),
            points: setup.most_samples().unwrap_or(points).min(points),
            cycle: Some(setup.cycle),
            joins: setup.joins,
            limits: self.instrument.limits.clone(),
            ..PlanOptions::default()
        }
        .demagnetisation()
    }

    /// Checks all drives; what is to move, as text.
    fn agenda(
        &self,
        moves: &PlannedMoves,
        demagnetisation: &PlannedDrive,
        ts: f64,
        setup: &Setup,
    ) -> Result<String, Error> {
        let (ramp, still) = (self.instrument.ramp, still(moves.rest().0, ts));
        let mut seconds = 0.0;
        let (mut low, mut high) = ends(demagnetisation.u.iter().copied());
        for (what, u) in moves.voltages() {
            let drives =
                [("demagnetisation", &*demagnetisation.u, demagnetisation.ts), ("rest", &still, ts), (what, u, ts)];
            for (what, u, period) in drives {
                setup.check(&drive_of((what, u), (period, ts), ramp)).map_err(|error| error.of(what))?;
                seconds += ramp + u.len() as f64 * period;
            }
            let (least, most) = ends(u.iter().copied());
            (low, high, seconds) = (low.min(least), high.max(most), seconds + self.wait);
        }
        Ok(to_move(setup, self.instrument.rest.with((low, high)), seconds))
    }
}

/// The limits within the voltages of the instrument.
fn within(limits: &LimitOptions, setup: &Setup) -> LimitOptions {
    let mut limits = limits.clone();
    (limits.own.low, limits.own.high) = (Some(setup.range.0), Some(setup.range.1));
    limits
}

/// Moves at work on an instrument.
struct Work<'b> {
    bench: Bench<'b>,
    moves: &'b PlannedMoves<'b>,
    /// The unit of the model.
    unit: &'b str,
}

impl Work<'_> {
    /// The displacements along the path, with the names of their runs [output unit of the model].
    fn measured(&mut self) -> Result<Vec<(String, Vec<f64>)>, Error> {
        let (_, modelled) = self.moves.rest();
        let run = |(what, u): (&str, &[f64])| {
            self.bench.part = what.into();
            let rest = self.bench.at_rest()?;
            let record = self.bench.play("", u, self.bench.ts, 0.0)?;
            let unit = &record.units().y;
            let unlike = || Error::units("the sensor of the controller", unit, self.unit);
            let factor = Units::factor(unit, self.unit).ok_or_else(unlike)?;
            let y = record.y().iter().map(|y| modelled + factor * (y - rest)).collect();
            Ok((format!("controller, {what}"), self.moves.along_path(y)))
        };
        self.moves.voltages().into_iter().map(run).collect()
    }
}

impl MeasuredTiming {
    /// Where the axis is, as text.
    pub fn state(&self) -> String {
        self.left.text(&self.setup.axis)
    }

    /// The figures as a document: those of the timing, and where the axis is.
    pub fn to_json(&self) -> Value {
        let mut document = self.timing.to_json();
        let Left { voltage, servo } = self.left;
        document["controller"] = json!({
            "identity": self.setup.identity, "axis": self.setup.axis, "voltage": voltage, "servo": servo,
            "unfinished": self.unfinished, "state": self.unfinished.is_none().then(|| self.state()),
        });
        document
    }
}

#[cfg(test)]
mod tests;
