//! The driver as a known block: an amplifier with a lag and a slew limit between the requested voltage and the
//! actuator.
//!
//! ```text
//! v' = (u - v) / tau, but |v'| <= slew,    u held over a sampling period, v = 0 before the first
//! z = (z_0 / 2 + z_1 + z_2 + z_3 + z_4 / 2) / 4          z_i for v after i quarters of the period
//! ```
//! The equation is solved exactly. The hysteresis block gets v at [`DriverModel::SUBSTEPS`] instants per sample; the
//! linear block gets the mean of the resulting z by the trapezoidal rule, in which z_0 is the z_4 of the sample before.
//! The reason: a slewing voltage acts later than a voltage step. This is visible above a quarter of the sampling rate,
//! and no block after the hysteresis could correct it. A current limit I with a capacitance C is a slew limit of I / C.
//!
//! Overshoot, and limits of energy or power, are not described.
//!
//! Why: docs/decisions/identification.md, "A slew limit is modelled only if it is given".

use crate::elementary::exp;
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use serde::{Deserialize, Serialize};

/// Lag and slew limit of an amplifier.
///
/// ```
/// let driver = piezoid::driver::DriverModel::new(1e-4, Some(0.5 / 8.2e-6))?; // 0.5 A into 8.2 uF
/// assert!((driver.slew.unwrap() - 61e3).abs() < 1e3);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriverModel {
    /// Time constant; 0 for no lag [s].
    pub lag_s: f64,
    /// Largest |v'|; `None` for no limit [input unit / s].
    #[serde(default)]
    pub slew: Option<f64>,
}

impl DriverModel {
    /// Number of voltages per sample for the hysteresis block.
    pub const SUBSTEPS: usize = 4;

    /// A driver with this lag [s] and slew limit [input unit / s].
    ///
    /// # Errors
    /// Returns an error if the lag is negative or the slew limit is not positive.
    pub fn new(lag_s: f64, slew: Option<f64>) -> Result<Self, Error> {
        if !(lag_s >= 0.0 && lag_s.is_finite()) {
            return Err(Error::parameter("driver.lag_s", lag_s, "must be 0 or a positive number of seconds"));
        }
        if let Some(slew) = slew {
            positive("driver.slew", slew, "input units per second")?;
        }
        Ok(DriverModel { lag_s, slew })
    }

    /// The voltage after the time `h` [s] at input `u`, starting from `v`.
    pub fn advance(&self, v: f64, u: f64, h: f64) -> f64 {
        let away = u - v;
        // Closer to u than this, the lag is slower than the slew limit.
        let near = self.slew.map_or(f64::INFINITY, |slew| slew * self.lag_s);
        let Some(slew) = self.slew.filter(|_| away.abs() > near) else { return self.approach(v, u, h) };
        let limited = (away.abs() - near) / slew;
        if limited >= h {
            return v + away.signum() * slew * h;
        }
        self.approach(u - away.signum() * near, u, h - limited)
    }

    /// The program of the driver: a block `driver` with a function `hidden` that steps the hysteresis block through a
    /// sample of `ts` [s]. `remembers` is false if the hysteresis block has no state.
    pub fn block(&self, ts: f64, remembers: bool) -> Block {
        let block = Block::new("driver", "the driver: an amplifier with a lag and a slew limit");
        let block = block.number("v", 0.0).number("z", 0.0);
        let block = block.constant("twice_substeps", (2 * DriverModel::SUBSTEPS) as f64);
        let (block, limited) = self.stepped(block, ts / DriverModel::SUBSTEPS as f64, "d.v");
        let text = HIDDEN.replace("DRIVEN", &limited);
        let text = if remembers { text } else { text.replace("x: hysteresis, ", "").replace("(x, ", "(") };
        block.count("substeps", DriverModel::SUBSTEPS).text(&text)
    }

    /// `block` with what gives the voltage after a step of `h` [s] of u from the voltage `v`, and the call of this.
    pub(crate) fn stepped(&self, block: Block, h: f64, v: &str) -> (Block, String) {
        let block = block.constant("h", h).constant("lag", self.lag_s);
        let lags = self.lag_s > 0.0;
        let block = if lags { block.text(LAGGING) } else { block };
        // Without a lag the voltage is u immediately.
        let after = |from: &str, s: &str| if lags { format!("lagging({from}, u, {s})") } else { "u".into() };
        let Some(slew) = self.slew else { return (block, after(v, "h")) };
        let text = SLEWING.replace("NEAR", &after("u - points * near", "h - limited"));
        let text = text.replace("AFTER", &after("v", "h"));
        let block = block.constant("slew", slew).constant("near", slew * self.lag_s).text(&text);
        (block, format!("driven({v}, u)"))
    }

    fn approach(&self, v: f64, u: f64, h: f64) -> f64 {
        if self.lag_s == 0.0 { u } else { u - (u - v) * exp(-h / self.lag_s) }
    }
}

const LAGGING: &str = "
// The voltage after s seconds of u, from v.
fn lagging(v, u, s) {
    return u - (u - v) * exponential(-s / lag);
}
";

/// [`DriverModel::advance`] with a slew limit.
const SLEWING: &str = "
// The voltage after a substep of u, from v.
fn driven(v, u) {
    let away = u - v;
    let points = way(away);
    let after = 0.0;
    // Closer to u than `near`, the lag needs less than the slew limit.
    if magnitude(away) > near {
        let limited = (magnitude(away) - near) / slew;
        if limited >= h {
            after = v + points * slew * h;
        } else {
            after = NEAR;
        }
    } else {
        after = AFTER;
    }
    return after;
}
";

const HIDDEN: &str = "
// z in the sample of u: the mean over its substeps.
fn hidden(x: hysteresis, d: driver, u) {
    let twice = 0.0;
    for k in 0..substeps {
        d.v = DRIVEN;
        let after = hysteresis(x, d.v);
        twice += d.z + after;
        d.z = after;
    }
    return twice / twice_substeps;
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_division_of_a_path_has_no_effect_and_the_equation_is_solved() {
        let driver = DriverModel::new(1e-4, Some(6e4)).unwrap();
        let run = |n: usize| {
            let h = 5e-4 / n as f64;
            (0..n).fold(-3.0, |v, _| driver.advance(v, 20.0, h))
        };
        assert_close(&[run(7)], &[run(1)], 1e-13, 0.0);
        let euler = (0..500_000).fold(-3.0, |v: f64, _| v + 1e-9 * ((20.0 - v) / 1e-4).clamp(-6e4, 6e4));
        assert_close(&[run(1)], &[euler], 1e-5, 0.0);
    }

    #[test]
    fn without_a_lag_and_a_limit_the_voltage_is_reached_immediately() {
        assert_eq!(DriverModel::new(0.0, None).unwrap().advance(1.0, 5.0, 1e-9), 5.0);
        assert_eq!(DriverModel::new(0.0, Some(1e3)).unwrap().advance(1.0, 5.0, 1e-3), 2.0);
        assert!(DriverModel::new(-1.0, None).is_err() && DriverModel::new(0.0, Some(0.0)).is_err());
    }
}
