//! The amplifier: a clamp, then a lag with limited slope due to its current limit.
//!
//! ```text
//! v' = sat((u - v) / tau, I / C),   u clamped to [min, max]
//! ```
//! The current into a capacitance C is C v', so the current limit I is a slew limit I / C. For a held u the solution is
//! exact: a ramp while the lag exceeds the limit, then an exponential. Without lag the ramp ends at u; without limit
//! too, v is u.
//!
//! Reference: PI, datasheet and tutorial: peak current pi f Vpp C. Not modelled: ripple, dead time, a moving load.
//!
//! State: one number, the voltage v [V].

use super::spec::{DriverSpec, non_negative, require};
use libm::exp;
use piezoid_numerics::error::{Error, positive};

/// The amplifier, for a fixed time step.
#[derive(Debug, Clone)]
pub(super) struct DriverStage {
    min: f64,
    max: f64,
    /// Time constant [s].
    lag: f64,
    /// Greatest slope [V/s].
    slew: f64,
    /// Distance from u below which the slew limit is inactive [V].
    knee: f64,
    /// Time step [s].
    h: f64,
    /// Remaining share of the distance from u after a step of pure lag [-].
    keep: f64,
}

impl DriverStage {
    /// The amplifier advanced in steps of `h` [s].
    pub(crate) fn new(spec: &DriverSpec, h: f64) -> Result<Self, Error> {
        let (min, max) = (spec.min_v, spec.max_v);
        require(min.is_finite() && min <= 0.0, "driver.min_v", min, "must be a number of volts, at most 0")?;
        require(max.is_finite() && max >= 0.0, "driver.max_v", max, "must be a number of volts, at least 0")?;
        let lag = non_negative("driver.lag_s", spec.lag_s, "seconds")?;
        let slew = match spec.current_a {
            None => f64::INFINITY,
            Some(current) => {
                positive("driver.current_a", current, "amperes, or null for no limit")?
                    / positive("driver.capacitance_f", spec.capacitance_f, "farads where the current is limited")?
            }
        };
        let knee = if slew.is_infinite() { f64::INFINITY } else { slew * lag };
        Ok(DriverStage { min, max, lag, slew, knee, h, keep: decay(h, lag) })
    }

    /// The clamped input [V], and true if the clamp was active.
    pub(super) fn clamp(&self, u: f64) -> (f64, bool) {
        (u.clamp(self.min, self.max), u < self.min || u > self.max)
    }

    /// Advances the voltage `v` one step towards the held `u`; true if the current was at its limit.
    pub(crate) fn advance(&self, v: &mut f64, u: f64) -> bool {
        let distance = u - *v;
        if distance.abs() <= self.knee {
            *v = u - distance * self.keep;
            return false;
        }
        let ramp = (distance.abs() - self.knee) / self.slew;
        if ramp >= self.h {
            *v += (self.slew * self.h).copysign(distance);
        } else {
            *v = u - (self.knee * decay(self.h - ramp, self.lag)).copysign(distance);
        }
        true
    }
}

/// exp(-t / lag), which is 0 without a lag.
fn decay(t: f64, lag: f64) -> f64 {
    if lag > 0.0 { exp(-t / lag) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    fn driver(lag_s: f64, current_a: Option<f64>, h: f64) -> DriverStage {
        DriverStage::new(&DriverSpec { lag_s, current_a, capacitance_f: 8.2e-6, ..DriverSpec::default() }, h).unwrap()
    }

    #[test]
    fn an_ideal_driver_has_the_input_as_output() {
        let mut v = 3.0;
        assert!(!driver(0.0, None, 1e-5).advance(&mut v, -30.0));
        assert_eq!(v, -30.0);
    }

    #[test]
    fn sixty_milliamperes_take_8_2_ms_for_60_volts() {
        // 60 V x 8.2 uF / 60 mA.
        let (driver, mut v, mut steps) = (driver(0.0, Some(0.06), 1e-5), -30.0, 0);
        while driver.advance(&mut v, 30.0) {
            steps += 1;
        }
        assert_eq!((v, steps), (30.0, 820));
    }

    #[test]
    fn one_long_step_equals_many_short_ones_through_ramp_and_lag() {
        let run = |steps: u32| {
            let (driver, mut v) = (driver(1e-4, Some(0.5), 1e-3 / f64::from(steps)), -30.0);
            (0..steps).for_each(|_| {
                driver.advance(&mut v, 25.0);
            });
            v
        };
        assert_close(&[run(1)], &[run(997)], 1e-12, 0.0);
        assert!(run(1) < 25.0 && run(1) > 24.0);
    }

    #[test]
    fn an_active_clamp_is_reported() {
        let driver = driver(0.0, None, 1e-5);
        assert_eq!((driver.clamp(31.0), driver.clamp(-30.0)), ((30.0, true), (-30.0, false)));
        assert!(!driver.clamp(f64::NAN).1);
    }

    #[test]
    fn a_limited_current_needs_the_capacitance() {
        let spec = DriverSpec { current_a: Some(0.1), ..DriverSpec::default() };
        let message = DriverStage::new(&spec, 1e-5).unwrap_err().to_string();
        assert!(message.starts_with("driver.capacitance_f = 0"), "{message}");
    }
}
