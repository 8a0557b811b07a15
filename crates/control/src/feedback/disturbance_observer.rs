//! Disturbance observer: the disturbance voltage is estimated with the nominal plant, low-pass filtered and subtracted.
//!
//! ```text
//! w_t = Q(q) (g F(q) e_t + w_{t-d}),    u_t = feed_t + w_t within the limits
//! F(q) = A(q) / (k B(1)),    q^-d k B(1) / A(q) for the loop's k B(q) q^-(1+l) / A(q)
//! ```
//! F e is the voltage that corresponds to the error by the nominal plant; w_{t-d} is the correction applied at that
//! time. Where Q is 1 their difference is the disturbance, and w cancels it. A(q) acts as a notch at every pole of the
//! model. d is the sum of the static delay of the numerator, the sample of the loop and the sensor delay l. Q is a
//! critically damped low-pass of second order. It needs no anti-windup, because w is the voltage after the limits.
//!
//! Reference: K. Ohnishi, M. Shibata, T. Murakami, IEEE/ASME Trans. Mechatron. 1, 56 (1996), DOI 10.1109/3516.491410.
//! It does not do: an inverse of the numerator, whose zeros may lie outside the unit circle.

use super::filters::{lag, plus, ratio, times};
use super::tune::{spread, strongest};
use super::{ControlLoop, Controller, ControllerInput, ControllerKind, check, program};
use piezoid_models::linear::Arx;
use piezoid_models::program::Block;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::series::shift_in;
use piezoid_numerics::system::System;
use std::sync::Arc;

/// The controller. State: that of g F, that of Q, and the last values of w, newest first [V].
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DisturbanceObserver {
    inverse: Arx,
    q: Arx,
    delay: usize,
    limits: (f64, f64),
}

impl DisturbanceObserver {
    /// The observer of a loop, with the corner frequency of Q [Hz] and the share g of the full correction [-].
    ///
    /// # Errors
    /// Returns an error for a corner that is not positive, a share that is not finite, and a loop without static gain.
    pub(super) fn new(path: &ControlLoop, corner_hz: f64, share: f64) -> Result<Self, Error> {
        positive("corner_hz", corner_hz, "Hz")?;
        check(&[("share", share)], path.limits)?;
        let (ts, b) = (path.linear().ts(), path.linear().b());
        let rest: f64 = b.iter().sum();
        let gain = positive("static gain", path.slope.1 * rest, "output units per volt")?;
        let mean = b.iter().enumerate().map(|(k, b)| k as f64 * b).sum::<f64>() / rest;
        let delay = 1 + path.delay_samples + mean.round().clamp(0.0, 100.0) as usize;
        let f: Vec<f64> = path.linear().denominator().iter().map(|a| share * a / gain).collect();
        let q = lag(ts, corner_hz, 1.0)?;
        Ok(DisturbanceObserver { inverse: Arx::new(ts, Vec::new(), f)?, q, delay, limits: path.limits })
    }
}

impl Controller for DisturbanceObserver {
    fn ts(&self) -> f64 {
        self.q.ts()
    }

    fn order(&self) -> usize {
        self.inverse.order() + self.q.order() + self.delay
    }

    fn step(&self, x: &mut [f64], input: &ControllerInput) -> f64 {
        let (low, high) = self.limits;
        let (inverse, rest) = x.split_at_mut(self.inverse.order());
        let (q, past) = rest.split_at_mut(self.q.order());
        let feed_forward = input.limited_feed_forward(self.limits);
        let unexplained = self.inverse.step(inverse, input.error()) + past[self.delay - 1];
        let u = (feed_forward + self.q.step(q, unexplained)).clamp(low, high);
        shift_in(past, u - feed_forward);
        u
    }

    fn blocks(&self) -> Option<Vec<Block>> {
        let block = program::block("a disturbance observer", self.limits);
        let block = if self.inverse.order() > 0 { block.part("inverse", "inverse") } else { block };
        let block =
            block.part("low_pass", "low_pass").numbers("past", vec![0.0; self.delay]).count("delay", self.delay);
        let stands_for = if self.inverse.order() > 0 { "inverse(s.inverse, e)" } else { "inverse(e)" };
        let step = format!(
            "
fn control_step(s: control_state, r, y, feed_forward) {{
    let applied = fed(feed_forward);
    let e = missing(r, y);
    // What the nominal plant does not explain.
    let unexplained = {stands_for} + s.past[delay - 1];
    let u = clamp(applied + low_pass(s.low_pass, unexplained), low, high);
    for k in 1..delay down {{ s.past[k] = s.past[k - 1]; }}
    s.past[0] = u - applied;
    return u;
}}
"
        );
        let inverse = self.inverse.block("inverse", "the inverse of the nominal plant, but for its delay");
        Some(vec![
            inverse,
            self.q.block("low_pass", "the low-pass filter of the estimated disturbance"),
            block.text(&step),
        ])
    }

    fn law(&self) -> Option<Arx> {
        let (poles, delayed) = (self.q.denominator(), [vec![0.0; self.delay], self.q.b().to_vec()].concat());
        ratio(self.ts(), &times(self.q.b(), self.inverse.b()), &plus(&poles, -1.0, &delayed)).ok()
    }
}

pub(super) const ROW: ControllerKind = ControllerKind {
    name: "disturbance-observer",
    summary: "subtracts the low-pass filtered disturbance voltage, estimated with the nominal plant",
    reference: "Ohnishi, Shibata & Murakami 1996, DOI 10.1109/3516.491410",
    uses_feed_forward: true,
    tune: |path, target| {
        let ts = path.linear().ts();
        let build = |corner: f64, k: f64| DisturbanceObserver::new(path, corner, k);
        strongest(path, target, spread(1e-3 / ts, 0.25 / ts, 60), build).map(|c| Arc::new(c) as Arc<dyn Controller>)
    },
};

#[cfg(test)]
mod tests {
    use super::super::margins::tests::path_of;
    use super::*;
    use crate::feedback::ClosedLoop;
    use crate::feedback::tests::assert_follows_its_law;
    use piezoid_models::program::{Machine, Program};
    use piezoid_testing::assert_close;

    fn path() -> ControlLoop {
        ControlLoop { limits: (-1e6, 1e6), ..path_of(lag(5e-4, 160.0, 0.03).unwrap(), (1.0, 1.0)) }
    }

    #[test]
    fn its_steps_follow_its_law() {
        assert_follows_its_law(&DisturbanceObserver::new(&path(), 20.0, 0.8).unwrap(), 0.0);
    }

    #[test]
    fn a_constant_disturbance_is_removed() {
        let path = path();
        let c = DisturbanceObserver::new(&path, 10.0, 1.0).unwrap();
        // The feed-forward has an error of 0.3 V.
        let y = ClosedLoop::new(&[1.0; 4000], &[0.7; 4000], path.limits).run(path.linear(), &c).unwrap().y;
        assert_close(&y[3999..], &[1.0], 0.0, 1e-6);
    }

    #[test]
    fn for_a_plant_without_dynamics_the_program_is_bit_identical_too() {
        let path = path_of(Arx::gain(5e-4, 1.0).unwrap(), (30.0, 40.0));
        let c = DisturbanceObserver::new(&path, 20.0, 0.8).unwrap();
        assert_eq!(c.inverse.order(), 0);
        let program = Program::new([vec![Block::elementary()], c.blocks().unwrap()].concat()).unwrap();
        let (mut machine, mut x) = (Machine::new(&program, "control_state", false), c.initial());
        for t in 0..100 {
            let (r, y) = (900.0 * (0.03 * f64::from(t)).sin(), f64::from(t % 11));
            let u = c.step(&mut x, &ControllerInput { y, r, ..Default::default() });
            let found = machine.call("control_step", &[r, y, 0.0]).unwrap()[0];
            assert_eq!(found.to_bits(), u.to_bits(), "at {t}");
        }
    }
}
