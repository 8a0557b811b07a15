//! PI: proportional and integral, with anti-windup by back-calculation.
//!
//! ```text
//! v_t = feed_t + k_p e_t + I_t,    I_t = I_{t-1} + k_i Ts e_t,    u_t = v_t within the limits
//! I_t <- I_t + min(1, k_i Ts / k_p) (u_t - v_t)
//! ```
//! At a limit the integral follows the limited voltage, with the time constant k_p / k_i.
//!
//! Reference: K. J. Astrom, L. Rundqwist, Integrator windup and how to avoid it, Proc. American Control Conference
//! 1989, 1693, DOI 10.23919/ACC.1989.4790464. It does not do: damping of a resonance, which therefore limits its gain.

use super::tune::{spread, strongest};
use super::{Controller, ControllerInput, ControllerKind, check, program};
use piezoid_models::linear::Arx;
use piezoid_models::program::Block;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::system::System;
use std::sync::Arc;

/// The controller. State: the integral [V].
#[derive(Debug, Clone, PartialEq)]
pub struct Pi {
    ts: f64,
    kp: f64,
    ki: f64,
    limits: (f64, f64),
}

impl Pi {
    /// `kp` [V / output unit], `ki` [V / (output unit s)], lowest and highest voltage [V].
    ///
    /// # Errors
    /// Returns an error for a `ts` that is not positive, gains that are not finite, and limits in the wrong order.
    pub fn new(ts: f64, kp: f64, ki: f64, limits: (f64, f64)) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        check(&[("kp", kp), ("ki", ki)], limits)?;
        Ok(Pi { ts, kp, ki, limits })
    }
}

impl Controller for Pi {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        1
    }

    fn step(&self, x: &mut [f64], input: &ControllerInput) -> f64 {
        let (low, high) = self.limits;
        let (e, ki) = (input.error(), self.ki * self.ts);
        x[0] += ki * e;
        let v = input.limited_feed_forward(self.limits) + self.kp * e + x[0];
        let u = v.clamp(low, high);
        let share = if ki < self.kp { ki / self.kp } else { 1.0 };
        x[0] += share * (u - v);
        u
    }

    fn blocks(&self) -> Option<Vec<Block>> {
        let ki = self.ki * self.ts;
        let share = if ki < self.kp { ki / self.kp } else { 1.0 };
        let block = program::block("PI, with anti-windup by back-calculation", self.limits).number("integral", 0.0);
        let block = block.constant("kp", self.kp).constant("ki_ts", ki).constant("share", share);
        Some(vec![block.text(
            "
fn control_step(s: control_state, r, y, feed_forward) {
    let e = missing(r, y);
    s.integral += ki_ts * e;
    let v = fed(feed_forward) + kp * e + s.integral;
    let u = clamp(v, low, high);
    // While a limit is met the integral tracks what it lets through.
    s.integral += share * (u - v);
    return u;
}
",
        )])
    }

    fn law(&self) -> Option<Arx> {
        Arx::new(self.ts, vec![1.0], vec![self.kp + self.ki * self.ts, -self.kp]).ok()
    }
}

pub(super) const ROW: ControllerKind = ControllerKind {
    name: "pi",
    summary: "proportional and integral, with anti-windup by back-calculation",
    reference: "Astrom & Rundqwist 1989, DOI 10.23919/ACC.1989.4790464",
    uses_feed_forward: true,
    tune: |path, target| {
        let ts = path.linear().ts();
        // k_p / k_i, from 0 to a twentieth of a second.
        let shapes = std::iter::once(0.0).chain(spread(0.1 * ts, 100.0 * ts, 40));
        let build = |ti: f64, k: f64| Pi::new(ts, k * ti, k, path.limits);
        strongest(path, target, shapes, build).map(|c| Arc::new(c) as Arc<dyn Controller>)
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feedback::ClosedLoop;
    use piezoid_testing::assert_close;

    #[test]
    fn the_loop_on_a_first_order_plant_matches_its_formula() {
        // y_t = a y_{t-1} + b u_{t-1}, measured and answered one sample later.
        let (ts, a, b, kp, ki) = (1e-3, 0.9, 0.2, 0.3, 40.0);
        let plant = Arx::new(ts, vec![a], vec![0.0, b]).unwrap();
        let pi = Pi::new(ts, kp, ki, (-1e6, 1e6)).unwrap();
        let got = ClosedLoop::new(&[1.0; 300], &[0.0; 300], (-1e6, 1e6)).run(&plant, &pi).unwrap();
        let (mut y, mut u, mut i) = (vec![0.0; 300], vec![0.0; 300], 0.0);
        for t in 0..300 {
            if t > 0 {
                y[t] = a * y[t - 1] + b * u[t - 1];
                let e = 1.0 - y[t - 1];
                i += ki * ts * e;
                u[t] = kp * e + i;
            }
        }
        assert_close(&got.y, &y, 0.0, 1e-12);
        assert_close(&got.y[299..], &[1.0], 0.0, 1e-4);
    }

    #[test]
    fn it_recovers_from_a_limit_without_the_windup_of_a_plain_integral() {
        let plant = Arx::new(1e-3, vec![0.9], vec![0.0, 0.1]).unwrap();
        let r: Vec<f64> = [[5.0; 2000], [0.5; 2000]].concat();
        let settled_at = |limits| {
            let pi = Pi::new(1e-3, 0.3, 20.0, limits).unwrap();
            let y = ClosedLoop::new(&r, &[0.0; 4000], (-1.0, 1.0)).run(&plant, &pi).unwrap().y;
            y[2000..].iter().position(|y| (y - 0.5).abs() < 0.05).unwrap_or(2000)
        };
        assert!(settled_at((-1.0, 1.0)) < 250, "{}", settled_at((-1.0, 1.0)));
        assert!(settled_at((-1e9, 1e9)) > 500, "{}", settled_at((-1e9, 1e9)));
    }

    #[test]
    fn invalid_gains_and_limits_are_errors() {
        let message = |kp, limits| Pi::new(1e-3, kp, 1.0, limits).unwrap_err().to_string();
        assert!(message(f64::NAN, (-1.0, 1.0)).starts_with("kp = NaN"));
        assert!(message(1.0, (1.0, -1.0)).starts_with("limits = (1.0, -1.0)"));
    }
}
