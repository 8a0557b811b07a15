//! Positive position feedback with an integrator: a resonator parallel to the integral damps the first mode.
//!
//! ```text
//! I_t = I_{t-1} + k_i Ts e_t,    p_t = H(q) e_t,    H(s) = W^2 / (s^2 + 2 D W s + W^2) by matched poles
//! u_t = feed_t + I_t - g p_t within the limits
//! ```
//! The minus sign on e is a plus sign on y, hence the name. Fed back through the resonator, y at resonance returns a
//! quarter of a period later, as a force against the velocity. H falls off above W, so that higher modes are not
//! affected. The law acts on y - r and thus does not act against the feed-forward. The integral is frozen while u is at
//! a limit and e drives it further beyond.
//!
//! Reference: J. L. Fanson, T. K. Caughey, AIAA Journal 28, 717 (1990), DOI 10.2514/3.10451. It does not do: several
//! modes.

use super::filters::{lag, plus, ratio, times};
use super::tune::{modes, spread, strongest};
use super::{Controller, ControllerInput, ControllerKind, check, integrating, program};
use piezoid_models::linear::Arx;
use piezoid_models::program::Block;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::system::System;
use std::sync::Arc;

/// The controller. State: the integral [V], then the state of the resonator.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PositivePosition {
    ts: f64,
    ki: f64,
    gain: f64,
    resonator: Arx,
    limits: (f64, f64),
}

impl PositivePosition {
    /// `ki` [V / (output unit s)], `gain` g [V / output unit], W / 2 pi [Hz] and D (up to 1) of the resonator, lowest
    /// and highest voltage [V].
    ///
    /// # Errors
    /// Returns an error for values that are not positive or finite, a damping ratio above 1, and limits in the wrong
    /// order.
    pub(super) fn new(
        ts: f64,
        ki: f64,
        gain: f64,
        (hz, damping): (f64, f64),
        limits: (f64, f64),
    ) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        positive("resonator frequency", hz, "Hz")?;
        check(&[("ki", ki), ("gain", gain)], limits)?;
        if !(damping > 0.0 && damping <= 1.0) {
            return Err(Error::parameter("resonator damping", damping, "must be above 0 and up to 1"));
        }
        Ok(PositivePosition { ts, ki, gain, resonator: lag(ts, hz, damping)?, limits })
    }
}

impl Controller for PositivePosition {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        1 + self.resonator.order()
    }

    fn step(&self, x: &mut [f64], input: &ControllerInput) -> f64 {
        let e = input.error();
        let gain = self.ki * self.ts * e;
        let p = self.resonator.step(&mut x[1..], e);
        let w = x[0] + gain - self.gain * p;
        integrating(self.limits, input, w, &mut x[0], gain)
    }

    fn blocks(&self) -> Option<Vec<Block>> {
        let block = program::block("integral and positive position feedback", self.limits);
        let block = block.number("integral", 0.0).part("resonator", "resonator");
        let block = block.constant("ki_ts", self.ki * self.ts).constant("damping", self.gain);
        let step = "
fn control_step(s: control_state, r, y, feed_forward) {
    let e = missing(r, y);
    let gain = ki_ts * e;
    let p = resonator(s.resonator, e);
    let w = s.integral + gain - damping * p;
    return integrating(s, feed_forward, w, gain);
}
";
        let resonator =
            self.resonator.block("resonator", "the resonator of positive position feedback, which damps the mode");
        Some(vec![resonator, block.text(program::INTEGRATING).text(step)])
    }

    fn law(&self) -> Option<Arx> {
        let (poles, sum) = (self.resonator.denominator(), [1.0, -1.0]);
        let numerator = plus(&times(&[self.ki * self.ts], &poles), -self.gain, &times(self.resonator.b(), &sum));
        ratio(self.ts, &numerator, &times(&sum, &poles)).ok()
    }
}

pub(super) const ROW: ControllerKind = ControllerKind {
    name: "positive-position",
    summary: "integral control in parallel with positive position feedback, which damps the first mode",
    reference: "Fanson & Caughey 1990, DOI 10.2514/3.10451",
    uses_feed_forward: true,
    tune: |path, target| {
        let ts = path.linear().ts();
        let low = modes(path.linear()).into_iter().map(|m| m.0).fold(f64::INFINITY, f64::min);
        let hz = if low.is_finite() { low } else { 0.05 / ts };
        // W over the frequency of the mode, D, and g W / k_i, the ratio of damping to integral action.
        let shapes = spread(0.4, 2.0, 12).flat_map(|over| spread(0.1, 1.0, 6).map(move |d| (over, d)));
        let shapes = shapes.flat_map(|(over, d)| spread(0.05, 20.0, 14).map(move |share| (over, d, share)));
        let build = |(over, d, share): (f64, f64, f64), k: f64| {
            let w = over * hz;
            PositivePosition::new(ts, k, k * share / (std::f64::consts::TAU * w), (w.min(0.45 / ts), d), path.limits)
        };
        strongest(path, target, shapes, build).map(|c| Arc::new(c) as Arc<dyn Controller>)
    },
};

#[cfg(test)]
mod tests {
    use super::super::margins::tests::path_of;
    use super::*;
    use crate::feedback::tests::assert_follows_its_law;

    #[test]
    fn its_steps_follow_its_law() {
        assert_follows_its_law(&PositivePosition::new(5e-4, 3.0, 0.01, (180.0, 0.3), (-1e6, 1e6)).unwrap(), 0.0);
    }

    #[test]
    fn it_damps_its_mode() {
        // Without an integral, the mode of the closed loop is far better damped than that of the plant.
        let plant = lag(5e-4, 100.0, 0.02).unwrap();
        let path = path_of(plant, (1.0, 1.0));
        let c = PositivePosition::new(5e-4, 0.0, 0.15, (120.0, 0.3), (-1.0, 1.0)).unwrap();
        let poles = path.closed(&c.law().unwrap(), 1.0).unwrap().poles();
        let least = poles.iter().filter(|p| p.z.im > 0.0).map(|p| p.damping).fold(1.0, f64::min);
        assert!(least > 0.05, "{least}");
    }
}
