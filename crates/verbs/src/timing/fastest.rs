//! The shortest moves that an actuator can make, and those with the least overshoot, by the model with compensation.
//!
//! ```text
//! r(t) = a + (b - a) (10 s^3 - 15 s^4 + 6 s^5),  s = t / D from 0 to 1        minimum jerk, and other shapes
//! D* = least D for which the voltage of r is within the limits of the driver, and
//!      |y(t) - b| <= tolerance from the end of the move on
//! ```
//! A jump, a jump through the ZVD shaper of the first mode, minimum jerk, and minimum jerk through that shaper are
//! compensated with the whole reference known. D grows by a seventh until the move settles at once; bisection finds D*
//! within the last interval. A shorter D that settles by chance, between two of these, is not found. The voltage begins
//! before the reference by the preview of the inverse. A flyback is such a move from rest to rest: the velocity of the
//! line before it and after it is not in it.
//!
//! Reference: T. Flash & N. Hogan, J. Neurosci. 5, 1688 (1985), DOI 10.1523/JNEUROSCI.05-07-01688.1985.

use super::run::{overshoot, settled_after};
use crate::Faster;
use libm::log;
use piezoid_control::compensation::FeedForward;
use piezoid_control::compensation::shaping::Shaping;
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use serde::Serialize;
use std::f64::consts::TAU;

/// Samples before a move, in which the voltage can begin.
const BEFORE: usize = 600;

/// Samples after it: until the first mode has decayed by this factor, within these numbers.
const DECAY: f64 = 1000.0;
const AFTER: (f64, f64) = (200.0, 8000.0);

/// Half of the longest move, and half of that from which a longer one leaves no smaller error at rest [samples].
const LONGEST: usize = 4000;
const SLOW: usize = 64;

/// The fastest move of one shape.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FastestMove {
    /// `step` or `flyback`.
    pub purpose: &'static str,
    /// `jump`, `zvd`, `minimum jerk` or `minimum jerk, zvd`.
    pub shape: &'static str,
    /// Where it begins [output unit].
    pub from: f64,
    /// Where it ends [output unit].
    pub to: f64,
    /// Duration of the reference [s]; `None` if no move of this shape is possible.
    pub move_s: Option<f64>,
    /// Time until the model stays within the tolerance [s]; `None` if it does not.
    pub settling_s: Option<f64>,
    /// Its largest error beyond the goal [output unit].
    pub overshoot: Option<f64>,
    /// The same on the plant, if there is one.
    pub on_plant: Option<Landing>,
    /// Set if its voltage changes faster than that of the training data: the actuator may settle later.
    pub faster: Option<Faster>,
    /// Why there is no such move; empty if there is.
    pub because: String,
}

/// How a move ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Landing {
    /// Time until the error stays within the tolerance [s]; `None` if it does not.
    pub settling_s: Option<f64>,
    /// Largest error beyond the goal [output unit].
    pub overshoot: f64,
}

/// A move that was tried.
struct Trial {
    u: Vec<f64>,
    /// The first sample of the reference at another value, and the first at the last value.
    begin: usize,
    end: usize,
    on_model: Landing,
    /// True if it settles as soon as the reference has arrived.
    at_once: bool,
}

/// The displacement of a plant with a voltage, from the settled state at its first value.
pub(super) type Player<'a> = &'a dyn Fn(&[f64]) -> Vec<f64>;

/// What moves.
pub(super) struct Mover<'a> {
    pub(super) model: &'a Model,
    pub(super) inverse: &'a FeedForward,
    pub(super) tolerance: f64,
    pub(super) plant: Option<Player<'a>>,
}

impl Mover<'_> {
    /// The fastest moves from `from` to `to`, one of each shape.
    pub(super) fn fastest(&self, purpose: &'static str, (from, to): (f64, f64)) -> Vec<FastestMove> {
        let has_mode = self.model.linear().resonance().is_some();
        let shapes = [
            ("jump", false, false),
            ("zvd", false, true),
            ("minimum jerk", true, false),
            ("minimum jerk, zvd", true, true),
        ];
        let shapes = shapes.into_iter().filter(|(_, _, zvd)| has_mode || !zvd);
        let of = |(shape, is_smooth, zvd): (&'static str, bool, bool)| {
            let found = if is_smooth { self.shortest((from, to), zvd) } else { self.trial((from, to), 0, zvd) };
            let none = FastestMove {
                purpose,
                shape,
                from,
                to,
                move_s: None,
                settling_s: None,
                overshoot: None,
                on_plant: None,
                faster: None,
                because: String::new(),
            };
            match found {
                Err(error) => FastestMove { because: error.to_string(), ..none },
                Ok(trial) => FastestMove {
                    move_s: Some((trial.end - trial.begin) as f64 * self.model.ts()),
                    settling_s: trial.on_model.settling_s,
                    overshoot: Some(trial.on_model.overshoot),
                    faster: Faster::of(self.model, &trial.u),
                    on_plant: self.plant.map(|plant| self.landing(&plant(&trial.u)[trial.begin..], (from, to))),
                    ..none
                },
            }
        };
        shapes.map(of).collect()
    }

    /// The shortest minimum-jerk move that settles at once.
    fn shortest(&self, ends: (f64, f64), zvd: bool) -> Result<Trial, Error> {
        self.inverse.holds(&[ends.0, ends.1])?;
        let (mut too_short, mut half) = (0, 1);
        let mut found = loop {
            match self.trial(ends, half, zvd) {
                Ok(trial) if trial.at_once => break trial,
                Ok(trial) if half > SLOW && trial.on_model.settling_s.is_none() => {
                    let what = "the model does not come to rest within the tolerance, however slow the move is";
                    return Err(Error::Content(what.into()));
                }
                // A longer move may be possible.
                Ok(_) | Err(Error::Limits { .. } | Error::Unreachable { .. }) => {}
                Err(error) => return Err(error),
            }
            if half >= LONGEST {
                let longest = 2.0 * LONGEST as f64 * self.model.ts();
                let what = format!("no move of up to {longest} s settles within the tolerance at once");
                return Err(Error::Content(what));
            }
            (too_short, half) = (half, (half + half / 7 + 1).min(LONGEST));
        };
        while half - too_short > 1 {
            let middle = too_short + (half - too_short) / 2;
            match self.trial(ends, middle, zvd) {
                Ok(trial) if trial.at_once => (found, half) = (trial, middle),
                _ => too_short = middle,
            }
        }
        Ok(found)
    }

    /// A move of 2 `half` samples, 0 for a jump, perhaps through a shaper of the first mode.
    fn trial(&self, (from, to): (f64, f64), half: usize, zvd: bool) -> Result<Trial, Error> {
        let (ts, mode) = (self.model.ts(), self.model.linear().resonance());
        let period = mode.map_or(0.0, |mode| 1.0 / (mode.hz * ts));
        let decay = mode.map_or(0.0, |mode| log(DECAY) / (TAU * mode.hz * mode.damping * ts));
        let margin = half + if zvd { period.clamp(0.0, AFTER.1) as usize + 4 } else { 0 };
        let after = decay.clamp(AFTER.0, AFTER.1) as usize + margin;
        let r = [vec![from; BEFORE + margin], vec![to; after + BEFORE]].concat();
        let smooth = (half > 0).then_some(2.0 * half as f64 * ts);
        let r = Shaping { smooth, zvd, ..Shaping::default() }.of(self.model, r)?;
        let u = self.inverse.whole(&r)?;
        let near = |r: &f64, v: f64| (r - v).abs() <= 1e-9 * (to - from).abs();
        let begin = r.iter().position(|r| !near(r, from)).unwrap_or(0);
        let end = r.iter().rposition(|r| !near(r, to)).map_or(begin, |k| (k + 1).max(begin));
        // The voltage of the last samples assumes a motion beyond the end.
        let played = &u.reached[begin..r.len() - BEFORE];
        let on_model = self.landing(played, (from, to));
        let at_once = on_model.settling_s.is_some_and(|s| s <= (end - begin) as f64 * ts * (1.0 + 1e-12));
        let u = u.u[..r.len() - BEFORE].to_vec();
        Ok(Trial { u, begin, end, on_model, at_once })
    }

    fn landing(&self, y: &[f64], (from, to): (f64, f64)) -> Landing {
        let settling_s = settled_after(y, to, self.tolerance).map(|k| k as f64 * self.model.ts());
        Landing { settling_s, overshoot: overshoot(y, from, to) }
    }
}
