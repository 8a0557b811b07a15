//! PID: proportional, integral and a filtered derivative, with anti-windup by conditional integration.
//!
//! ```text
//! v_t = feed_t + k_p e_t + I_t + D_t,    I_t = I_{t-1} + k_i Ts e_t,    u_t = v_t within the limits
//! D_t = (T_f D_{t-1} + k_d (e_t - e_{t-1})) / (T_f + Ts)
//! ```
//! The integral is frozen while v is beyond a limit and e drives it further beyond.
//!
//! Reference: K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, ISBN 978-1-55617-942-6, sections 3.3 and 3.5.
//! It does not do: setpoint weights (the feed-forward replaces them), bumpless changes of gains.

use super::filters::{plus, ratio, times};
use super::tune::{spread, strongest};
use super::{Controller, ControllerInput, ControllerKind, check, integrating, program};
use piezoid_models::linear::Arx;
use piezoid_models::program::Block;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::system::System;
use std::sync::Arc;

/// The gains of a [`Pid`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gains {
    /// Proportional [V / output unit].
    pub kp: f64,
    /// Integral [V / (output unit s)].
    pub ki: f64,
    /// Derivative [V s / output unit].
    pub kd: f64,
    /// Time constant of the derivative's filter [s].
    pub filter_s: f64,
}

/// The controller. State: the integral [V], the derivative [V], the last error [output unit].
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pid {
    ts: f64,
    gains: Gains,
    limits: (f64, f64),
}

impl Pid {
    /// A controller with these gains, between the lowest and the highest voltage [V].
    ///
    /// # Errors
    /// Returns an error for a `ts` that is not positive, gains that are not finite, a negative filter, and limits in
    /// the wrong order.
    pub(super) fn new(ts: f64, gains: Gains, limits: (f64, f64)) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        let Gains { kp, ki, kd, filter_s } = gains;
        check(&[("kp", kp), ("ki", ki), ("kd", kd), ("filter_s", filter_s)], limits)?;
        if filter_s < 0.0 {
            return Err(Error::parameter("filter_s", filter_s, "must be 0 or a positive number of seconds"));
        }
        Ok(Pid { ts, gains, limits })
    }

    /// Factors of the derivative: on its last value, and on the change of e [V / output unit].
    fn derivative(&self) -> (f64, f64) {
        let whole = self.gains.filter_s + self.ts;
        (self.gains.filter_s / whole, self.gains.kd / whole)
    }
}

impl Controller for Pid {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        3
    }

    fn step(&self, x: &mut [f64], input: &ControllerInput) -> f64 {
        let (keeps, takes) = self.derivative();
        let e = input.error();
        x[1] = keeps * x[1] + takes * (e - x[2]);
        x[2] = e;
        let gain = self.gains.ki * self.ts * e;
        let w = self.gains.kp * e + (x[0] + gain) + x[1];
        integrating(self.limits, input, w, &mut x[0], gain)
    }

    fn blocks(&self) -> Option<Vec<Block>> {
        let (keeps, takes) = self.derivative();
        let block = program::block("PID with a filtered derivative", self.limits);
        let block = block.number("integral", 0.0).number("derivative", 0.0).number("before", 0.0);
        let block = block.constant("kp", self.gains.kp).constant("ki_ts", self.gains.ki * self.ts);
        Some(vec![block.constant("keeps", keeps).constant("takes", takes).text(program::INTEGRATING).text(
            "
fn control_step(s: control_state, r, y, feed_forward) {
    let e = missing(r, y);
    s.derivative = keeps * s.derivative + takes * (e - s.before);
    s.before = e;
    let gain = ki_ts * e;
    let w = kp * e + (s.integral + gain) + s.derivative;
    return integrating(s, feed_forward, w, gain);
}
",
        )])
    }

    fn law(&self) -> Option<Arx> {
        let (keeps, takes) = self.derivative();
        let (sum, lag) = ([1.0, -1.0], [1.0, -keeps]);
        let pi = [self.gains.kp + self.gains.ki * self.ts, -self.gains.kp];
        ratio(self.ts, &plus(&times(&pi, &lag), takes, &times(&sum, &sum)), &times(&sum, &lag)).ok()
    }
}

pub(super) const ROW: ControllerKind = ControllerKind {
    name: "pid",
    summary: "proportional, integral and filtered derivative, with anti-windup by conditional integration",
    reference: "Astrom & Hagglund 2006, ISBN 978-1-55617-942-6",
    uses_feed_forward: true,
    tune: |path, target| {
        let ts = path.linear().ts();
        let times = || std::iter::once(0.0).chain(spread(0.1 * ts, 30.0 * ts, 12));
        // k_p / k_i and k_d / k_p. With a filter of a few samples the derivative can also act as a low-pass against a
        // resonance.
        let shapes = times().flat_map(|ti| spread(0.1 * ts, 10.0 * ts, 8).map(move |td| (ti, td)));
        let shapes = shapes.flat_map(|(ti, td)| [1.0, 4.0].map(|tf| (ti, td, tf * ts)));
        let build = |(ti, td, filter_s): (f64, f64, f64), k: f64| {
            Pid::new(ts, Gains { kp: k * ti, ki: k, kd: k * ti * td, filter_s }, path.limits)
        };
        strongest(path, target, shapes, build).map(|c| Arc::new(c) as Arc<dyn Controller>)
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feedback::ClosedLoop;

    #[test]
    fn it_recovers_from_a_limit_without_windup() {
        let plant = Arx::new(1e-3, vec![0.9], vec![0.0, 0.1]).unwrap();
        let r: Vec<f64> = [[5.0; 2000], [0.5; 2000]].concat();
        let pid = Pid::new(1e-3, Gains { kp: 0.3, ki: 20.0, kd: 1e-4, filter_s: 1e-3 }, (-1.0, 1.0)).unwrap();
        let y = ClosedLoop::new(&r, &[0.0; 4000], (-1.0, 1.0)).run(&plant, &pid).unwrap().y;
        let settled_at = y[2000..].iter().position(|y| (y - 0.5).abs() < 0.05).unwrap();
        assert!(settled_at < 250 && (y[3999] - 0.5).abs() < 1e-6, "{settled_at}");
    }

    #[test]
    fn without_a_derivative_it_is_a_pi() {
        let gains = Gains { kp: 0.3, ki: 20.0, kd: 0.0, filter_s: 1e-3 };
        let law = Pid::new(1e-3, gains, (-1.0, 1.0)).unwrap().law().unwrap();
        let pi = super::super::pi::Pi::new(1e-3, 0.3, 20.0, (-1.0, 1.0)).unwrap().law().unwrap();
        let e: Vec<f64> = (0..50).map(|t| f64::from(t * t % 7)).collect();
        piezoid_testing::assert_close(&law.simulate(&e), &pi.simulate(&e), 1e-9, 1e-12);
    }

    #[test]
    fn the_first_step_is_the_sum_of_its_terms() {
        let pid = Pid::new(1e-3, Gains { kp: 0.5, ki: 100.0, kd: 1e-3, filter_s: 1e-3 }, (-30.0, 30.0)).unwrap();
        let mut x = pid.initial();
        assert_eq!(pid.step(&mut x, &ControllerInput { r: 1.0, ..Default::default() }), 0.5 + 0.1 + 0.5);
    }
}
