//! What the controller is asked for, and whether it can run.

use super::super::margins::check_late;
use super::condensed;
use crate::error::{Error, positive};

/// The longest horizon.
const LONGEST: usize = 200;

/// What solves the quadratic program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solver {
    /// A dual active-set method on the condensed program, without allocation.
    ActiveSet,
    /// Clarabel's interior-point method: the yardstick.
    #[cfg(feature = "clarabel")]
    InteriorPoint,
}

/// What the controller is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictiveSettings {
    /// Samples planned ahead, N. Where less of the reference is known, the last value told stands for what is not: a sine of
    /// 40 Hz over 80 % of the stroke of the twin `pl140` is followed to 0.03 % of stroke rms with 20 samples told ahead, to 0.2 %
    /// with 4, to 5 % with none (`examples/tracking.rs`).
    pub horizon: usize,
    /// Voltages allowed, lowest and highest [V].
    pub voltage: (f64, f64),
    /// The fastest change of voltage [V/s]; `None` where there is no limit.
    pub slew: Option<f64>,
    /// Displacements allowed, lowest and highest [output unit], kept as far as possible; `None` where there is no limit.
    pub displacement: Option<(f64, f64)>,
    /// What the square of a step of z costs, over that of an error of the same size [-]. Less of it cuts the corners of a
    /// reference less, and leaves more to a model that must be right up to half the sampling rate.
    pub move_cost: f64,
    /// How much the disturbance changes in a sample, rms over the range of z [-].
    pub drift: f64,
    /// What of z the model does not explain from sample to sample, rms over the range of z [-].
    pub unexplained: f64,
    /// Noise of a reading, rms over the range of y [-]. Far above what the sensor has where the plant may differ from the
    /// model: the observer then leaves alone what its resonance answers.
    pub noise: f64,
    /// Samples by which readings come late, at most [`LATEST`](crate::control::ControlLoop::LATEST).
    pub late: usize,
    /// What solves the quadratic program.
    pub solver: Solver,
    /// Multiplications that the machine does in a second, by which horizons are refused that cannot run at Ts. The operator's
    /// steps are not counted.
    pub multiplications_per_second: f64,
}

impl Default for PredictiveSettings {
    /// 20 samples, +-30 V, no other limit, readings in time.
    fn default() -> Self {
        PredictiveSettings {
            horizon: 20,
            voltage: (-30.0, 30.0),
            slew: None,
            displacement: None,
            move_cost: 1e-3,
            drift: 1e-3,
            unexplained: 1e-3,
            noise: 1e-2,
            late: 0,
            solver: Solver::ActiveSet,
            multiplications_per_second: 1e9,
        }
    }
}

impl PredictiveSettings {
    /// Refuses what makes no sense, whatever the model.
    pub(super) fn check(&self) -> Result<(), Error> {
        let PredictiveSettings { horizon, voltage, slew, displacement, move_cost, drift, unexplained, noise, .. } =
            self;
        if !(1..=LONGEST).contains(horizon) {
            return Err(Error::parameter("horizon", horizon, format!("must be from 1 to {LONGEST} samples")));
        }
        check_late(self.late)?;
        for (name, ends) in [("voltage", Some(voltage)), ("displacement", displacement.as_ref())] {
            if let Some((low, high)) = ends.filter(|(low, high)| !(low < high && low.is_finite() && high.is_finite())) {
                return Err(Error::parameter(
                    name,
                    format!("{low} to {high}"),
                    "must go from low to high, both finite",
                ));
            }
        }
        if let Some(slew) = slew {
            positive("slew", *slew, "volts a second")?;
        }
        for (name, share) in
            [("move_cost", move_cost), ("drift", drift), ("unexplained", unexplained), ("noise", noise)]
        {
            positive(name, *share, "no unit")?;
        }
        positive("multiplications_per_second", self.multiplications_per_second, "multiplications a second")?;
        Ok(())
    }

    /// Refuses a horizon that cannot run every `ts` [s] on states of length `order`.
    pub(super) fn check_computing_time(&self, order: usize, ts: f64) -> Result<(), Error> {
        let check_computing_time = |n: usize| {
            let soft = self.rows(n) + 1 - 2 * n;
            let once = order * (order + n) + n * n + condensed::operations(n, self.rows(n), n + soft);
            once as f64 <= self.multiplications_per_second * ts
        };
        let n = self.horizon;
        if check_computing_time(n) {
            return Ok(());
        }
        let longest = (1..n).rev().find(|&shorter| check_computing_time(shorter)).unwrap_or(0);
        let rule = format!(
            "takes longer than a sample of {ts} s at {} multiplications a second in the worst case; the longest that does \
             not is {longest}",
            self.multiplications_per_second
        );
        Err(Error::parameter("horizon", n, rule))
    }

    /// Limits of a horizon of `n`: each z, each step but the first, and each y where it is limited.
    pub(super) fn rows(&self, n: usize) -> usize {
        2 * n - 1 + if self.displacement.is_some() { n } else { 0 }
    }
}
