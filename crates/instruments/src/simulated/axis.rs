//! The axis: a plant, its voltage, a velocity, and a servo. With the target r, the position y that a low-pass filter
//! passes as w, and the slope s of the voltage over the position,
//!
//! ```text
//! u' = s r' + 2 pi B s (r - w),    w' = 2 pi F (y - w)
//! ```
//! r approaches the commanded position with the velocity of `VEL`; in open loop u approaches the commanded voltage with
//! the slew rate. Where nothing moves, long times pass in coarse steps, in which only creep and servo matter. It does
//! not do: notch filters, limits of acceleration.

use super::clocked::plants;
use super::{COARSE, CYCLE};
use crate::rest::at_rest;
use piezoid::control::SimulatedActuator;
use piezoid::{Error, System};
use piezoid_numerics::number::short;
use std::f64::consts::TAU;

/// Bandwidth B of the servo, and that of its filter, F: far below the resonances [Hz].
const BANDWIDTH: f64 = 3.0;
const FILTER: f64 = 6.0;

/// Time of the whole voltage range, and of the whole travel, at the usual speeds [s].
const SLEW_TIME: f64 = 0.02;
const TRAVEL_TIME: f64 = 0.5;

/// Share of the displacement at either end that is kept for hysteresis and creep.
const MARGIN: f64 = 0.08;

/// Readings for the mean at an end.
const READINGS: usize = 200;

/// On-target tolerance as a share of the travel, and the time within it [s].
const TOLERANCE: f64 = 1e-3;
const SETTLING: f64 = 0.01;

/// Share of its error that the servo corrects in a time of [`COARSE`] cycles.
const COARSE_GAIN: f64 = 0.2;

#[derive(Debug)]
pub(crate) struct Axis {
    pub(crate) name: String,
    plant: Box<dyn System>,
    /// The same plant in coarse steps.
    coarse: Box<dyn System>,
    /// State of both.
    x: Vec<f64>,
    /// Lowest and highest voltage [V].
    pub(crate) range: (f64, f64),
    /// Voltage of an open-loop value of 1 [V].
    pub(crate) gain: f64,
    /// Voltage of the output [V].
    pub(crate) voltage: f64,
    /// Last reading of the sensor, and what the filter passes [um].
    pub(crate) position: f64,
    filtered: f64,
    pub(crate) servo: bool,
    /// What is commanded: a position [um] in closed loop, a voltage [V] in open loop.
    pub(crate) goal: f64,
    /// Target of the servo at this moment [um].
    pub(crate) target: f64,
    /// Lowest and highest position [um].
    pub(crate) travel: (f64, f64),
    /// Volts per micrometre.
    slope: f64,
    /// Velocity in closed loop [um/s], slew rate in open loop [V/s].
    pub(crate) velocity: f64,
    pub(crate) slew: f64,
    /// Bandwidth of the servo [Hz].
    pub(crate) bandwidth: f64,
    /// On-target tolerance [um], and the time within it [s].
    pub(crate) tolerance: f64,
    pub(crate) settling: f64,
    /// Servo cycles within the tolerance.
    within: u64,
    /// True once the last move has ended on target.
    has_arrived: bool,
    /// Servo cycles until an impulse ends, and where it began.
    impulse: Option<(u64, f64)>,
    /// True after an automatic zero.
    pub(crate) is_zeroed: bool,
}

impl Axis {
    /// An axis at rest, at 0 V or at the end of its range that is nearest to it.
    ///
    /// # Errors
    /// Returns an error for a plant that does not move, or whose output is no length, and the errors of
    /// [`SimulatedActuator::voltages`] and [`SimulatedActuator::played`].
    pub(crate) fn new(name: &str, actuator: &SimulatedActuator, gain: f64, seed: u64) -> Result<Self, Error> {
        let (range, [plant, coarse]) = (actuator.voltages()?, plants(actuator, seed)?);
        let [bottom, top] = [range.0, range.1].map(|volts| {
            let mut x = plant.settled(volts);
            plant.resume(&mut x, &[volts; READINGS]).iter().sum::<f64>() / READINGS as f64
        });
        let span = top - bottom;
        let ends = [bottom + MARGIN * span, top - MARGIN * span];
        if !(span.is_finite() && span != 0.0) {
            let [low, high] = [range.0, range.1].map(short);
            return Err(Error::Content(format!("the plant does not move between {low} and {high} V: take another")));
        }
        let travel = inner(ends[0].min(ends[1]), ends[0].max(ends[1]));
        let (start, x) = at_rest(&*plant, range);
        let width = travel.1 - travel.0;
        Ok(Axis {
            name: name.into(),
            plant,
            coarse,
            x,
            range,
            gain,
            voltage: start,
            position: 0.0,
            filtered: 0.0,
            servo: false,
            goal: start,
            target: 0.0,
            travel,
            slope: (range.1 - range.0) / span,
            velocity: width / TRAVEL_TIME,
            slew: (range.1 - range.0) / SLEW_TIME,
            bandwidth: BANDWIDTH,
            tolerance: TOLERANCE * width,
            settling: SETTLING,
            within: 0,
            has_arrived: true,
            impulse: None,
            is_zeroed: false,
        })
    }

    /// One servo cycle, with the value of a wave generator if that runs.
    pub(crate) fn cycle(&mut self, wave: Option<f64>) {
        let before = self.target;
        match wave {
            Some(value) => self.jump(if self.servo { value } else { value * self.gain }),
            None => self.approach(),
        }
        if self.servo {
            let share = TAU * self.bandwidth * CYCLE;
            self.steer(self.target - before + share * (self.target - self.filtered));
        }
        self.position = self.plant.step(&mut self.x, self.voltage);
        self.filtered += TAU * FILTER * CYCLE * (self.position - self.filtered);
        self.watch(1);
    }

    /// A time of [`COARSE`] cycles in which nothing moves.
    pub(crate) fn hold(&mut self) {
        if self.servo {
            self.steer(COARSE_GAIN * (self.target - self.position));
        }
        self.position = self.coarse.step(&mut self.x, self.voltage);
        self.filtered = self.position;
        self.watch(COARSE);
    }

    /// Changes the voltage by so many micrometres.
    fn steer(&mut self, change: f64) {
        self.voltage = (self.voltage + self.slope * change).max(self.range.0).min(self.range.1);
    }

    fn approach(&mut self) {
        if let Some((left, back)) = self.impulse {
            self.impulse = (left > 1).then_some((left - 1, back));
            if left == 1 {
                self.jump(back);
            }
        }
        let goal = self.goal;
        let near =
            |from: f64, step: f64| if (goal - from).abs() <= step { goal } else { from + step.copysign(goal - from) };
        if self.servo {
            self.target = near(self.target, self.velocity * CYCLE);
        } else {
            self.voltage = near(self.voltage, self.slew * CYCLE);
        }
    }

    /// Counts the time on target.
    fn watch(&mut self, cycles: u64) {
        let is_within = (self.goal - self.position).abs() <= self.tolerance;
        self.within = if is_within { self.within.saturating_add(cycles) } else { 0 };
        self.has_arrived |= !self.servo || self.is_on_target();
    }

    /// Goes to a position [um] or voltage [V] with the velocity or slew rate.
    pub(crate) fn go(&mut self, goal: f64) {
        (self.goal, self.impulse, self.within, self.has_arrived) = (goal, None, 0, !self.servo);
    }

    /// Goes there at once.
    pub(crate) fn jump(&mut self, goal: f64) {
        let (low, high) = if self.servo { self.travel } else { self.range };
        self.goal = goal.max(low).min(high);
        *(if self.servo { &mut self.target } else { &mut self.voltage }) = self.goal;
        self.has_arrived = !self.servo;
    }

    /// Steps to the goal at once; with a number of cycles, it comes back after them.
    pub(crate) fn kick(&mut self, goal: f64, cycles: Option<u64>) {
        let back = self.goal;
        self.go(goal);
        self.jump(goal);
        self.impulse = cycles.map(|cycles| (cycles, back));
    }

    /// Stays where it is.
    pub(crate) fn stop(&mut self) {
        if self.servo {
            self.target = self.position.max(self.travel.0).min(self.travel.1);
        }
        self.go(if self.servo { self.target } else { self.voltage });
    }

    /// Opens or closes the loop, without a move.
    pub(crate) fn close(&mut self, servo: bool) {
        if servo != self.servo {
            self.servo = servo;
            self.filtered = self.position;
            (self.target, self.impulse) = (self.position, None);
            self.go(if servo { self.position } else { self.voltage });
        }
    }

    pub(crate) fn is_on_target(&self) -> bool {
        self.servo && self.target == self.goal && self.within as f64 * CYCLE >= self.settling
    }

    pub(crate) fn is_moving(&self) -> bool {
        let now = if self.servo { self.target } else { self.voltage };
        now != self.goal || !self.has_arrived || self.impulse.is_some()
    }

    /// True if the servo has no voltage left for its target.
    pub(crate) fn is_overflowing(&self) -> bool {
        let is_at_end = self.voltage <= self.range.0 || self.voltage >= self.range.1;
        self.servo && is_at_end && (self.target - self.position).abs() > self.tolerance
    }

    /// The commanded voltage [V].
    pub(crate) fn demand(&self) -> f64 {
        if self.servo { self.voltage } else { self.goal }
    }

    /// Lowest and highest value that a command or a wave may have in this mode.
    pub(crate) fn limits(&self) -> (f64, f64) {
        if self.servo { self.travel } else { self.values() }
    }

    /// Lowest and highest open-loop value.
    pub(crate) fn values(&self) -> (f64, f64) {
        (self.range.0 / self.gain, self.range.1 / self.gain)
    }
}

/// Round limits within these, exactly as they are printed.
fn inner(low: f64, high: f64) -> (f64, f64) {
    let grid = libm::pow(10.0, libm::floor(libm::log10(high - low)) - 2.0);
    let printed = |value: f64| format!("{value:.6}").parse().unwrap_or(value);
    (printed(libm::ceil(low / grid) * grid), printed(libm::floor(high / grid) * grid))
}
