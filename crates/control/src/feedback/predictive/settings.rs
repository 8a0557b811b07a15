//! Settings of the predictive controller, and checks of its computing time.

use super::super::margins::check_delay;
use super::condensed;
use piezoid_numerics::error::{Error, positive};

/// The longest horizon.
const LONGEST: usize = 200;

/// Method for the quadratic program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solver {
    /// A dual active-set method on the condensed program, without allocation.
    ActiveSet,
    /// Clarabel's interior-point method, as the reference solution.
    #[cfg(feature = "clarabel")]
    InteriorPoint,
}

/// Settings of the predictive controller.
#[derive(Debug, Clone, PartialEq)]
pub struct PredictiveSettings {
    /// Horizon N [samples]. If less of the reference is known, its last known value is used. Example: a sine of 40 Hz
    /// over 80 % of the stroke of the twin `pl140` is tracked to 0.03 % of stroke rms with a preview of 20 samples, to
    /// 0.2 % with 4, to 5 % with none (`bench/src/control.rs`).
    pub horizon: usize,
    /// Lowest and highest voltage [V].
    pub voltage: (f64, f64),
    /// Largest rate of the voltage [V/s]; `None` for no limit.
    pub slew: Option<f64>,
    /// Lowest and highest displacement [output unit], a soft limit; `None` for no limit.
    pub displacement: Option<(f64, f64)>,
    /// Cost of a squared step of z, relative to a squared error [-]. A smaller value gives sharper corners and relies
    /// on a model that is right up to half the sampling rate.
    pub move_cost: f64,
    /// Change of the disturbance per sample, rms over the range of z [-].
    pub drift: f64,
    /// Unexplained change of z per sample, rms over the range of z [-].
    pub unexplained: f64,
    /// Noise of a measurement, rms over the range of y [-]. Far larger than the sensor's if the plant may differ from
    /// the model: the observer then ignores the residual at its resonance.
    pub noise: f64,
    /// Sensor delay [samples], at most 20.
    pub delay_samples: usize,
    /// Method for the quadratic program.
    pub solver: Solver,
    /// Multiplications per second of the machine. A horizon that takes longer than Ts is an error. The steps of the
    /// operator are not counted.
    pub multiplications_per_second: f64,
}

impl Default for PredictiveSettings {
    /// 20 samples, +-30 V, no other limit, no sensor delay.
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
            delay_samples: 0,
            solver: Solver::ActiveSet,
            multiplications_per_second: 1e9,
        }
    }
}

impl PredictiveSettings {
    /// Checks everything that does not depend on the model.
    pub fn check(&self) -> Result<(), Error> {
        let PredictiveSettings { horizon, voltage, slew, displacement, move_cost, drift, unexplained, noise, .. } =
            self;
        if !(1..=LONGEST).contains(horizon) {
            return Err(Error::parameter("horizon", horizon, format!("must be from 1 to {LONGEST} samples")));
        }
        check_delay(self.delay_samples)?;
        for (name, ends) in [("voltage", Some(voltage)), ("displacement", displacement.as_ref())] {
            if let Some((low, high)) = ends.filter(|(low, high)| !(low < high && low.is_finite() && high.is_finite())) {
                let rule = "must go from low to high, both finite";
                return Err(Error::parameter(name, format!("{low} to {high}"), rule));
            }
        }
        if let Some(slew) = slew {
            positive("slew", *slew, "volts per second")?;
        }
        for (name, share) in
            [("move_cost", move_cost), ("drift", drift), ("unexplained", unexplained), ("noise", noise)]
        {
            positive(name, *share, "no unit")?;
        }
        positive("multiplications_per_second", self.multiplications_per_second, "multiplications per second")?;
        Ok(())
    }

    /// Checks that the horizon can be computed every `ts` [s] with `order` states.
    pub fn check_computing_time(&self, order: usize, ts: f64) -> Result<(), Error> {
        let fits = |n: usize| {
            let soft = self.rows(n) + 1 - 2 * n;
            let once = order * (order + n) + n * n + condensed::operations(n, self.rows(n), n + soft);
            once as f64 <= self.multiplications_per_second * ts
        };
        let n = self.horizon;
        if fits(n) {
            return Ok(());
        }
        let longest = (1..n).rev().find(|&shorter| fits(shorter)).unwrap_or(0);
        let rule = format!(
            "needs more than one sample of {ts} s in the worst case, at {} multiplications per second; the longest \
             horizon that fits is {longest} samples",
            self.multiplications_per_second
        );
        Err(Error::parameter("horizon", n, rule))
    }

    /// Number of limits for a horizon of `n`: each z, each step except the first, and each y if it is limited.
    pub(super) fn rows(&self, n: usize) -> usize {
        2 * n - 1 + if self.displacement.is_some() { n } else { 0 }
    }
}
