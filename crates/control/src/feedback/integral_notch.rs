//! Integral with notches: an integrator whose output does not excite the modes.
//!
//! ```text
//! I_t = I_{t-1} + k_i Ts e_t,    w_t = N_1(q) N_2(q) ... I_t,    u_t = feed_t + w_t within the limits
//! N(s) = (s^2 + 2 d w s + w^2) / (s^2 + 2 D w s + w^2),    D > d, by matched poles
//! ```
//! A notch removes the peak of its mode from the loop, so that the integral gain can be larger by that factor. D sets
//! how far the mode may be from its identified frequency. The integral is frozen while u is at a limit and e drives it
//! further beyond.
//!
//! Reference: D. Y. Abramovitch, S. Hoen, R. Workman, Proc. American Control Conference 2008, 2684, DOI
//! 10.1109/ACC.2008.4586898 (integral, PI and notches on positioners). It does not do: damping of the mode, which still
//! rings when something else excites it.

use super::filters::{notch, ratio, times};
use super::tune::{modes, spread, strongest};
use super::{Controller, ControllerInput, ControllerKind, check, integrating, program};
use piezoid_models::linear::Arx;
use piezoid_models::program::Block;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::system::System;
use std::sync::Arc;

/// The controller. State: the integral [V], then the states of the notches.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct IntegralNotch {
    ts: f64,
    ki: f64,
    notches: Vec<Arx>,
    limits: (f64, f64),
}

impl IntegralNotch {
    /// `ki` [V / (output unit s)]; frequency [Hz] and damping ratios d and D (up to 1) of each notch; lowest and
    /// highest voltage [V].
    ///
    /// # Errors
    /// Returns an error for values that are not positive or finite, a damping ratio above 1, and limits in the wrong
    /// order.
    pub(super) fn new(ts: f64, ki: f64, notches: &[(f64, f64, f64)], limits: (f64, f64)) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        check(&[("ki", ki)], limits)?;
        let notch = |&(hz, depth, width): &(f64, f64, f64)| {
            positive("notch frequency", hz, "Hz")?;
            for d in [depth, width] {
                if !(0.0..=1.0).contains(&d) {
                    return Err(Error::parameter("notch damping", d, "must be from 0 to 1"));
                }
            }
            notch(ts, hz, depth, width)
        };
        Ok(IntegralNotch { ts, ki, notches: notches.iter().map(notch).collect::<Result<_, _>>()?, limits })
    }
}

impl Controller for IntegralNotch {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        1 + self.notches.iter().map(|n| n.order()).sum::<usize>()
    }

    fn step(&self, x: &mut [f64], input: &ControllerInput) -> f64 {
        let gain = self.ki * self.ts * input.error();
        let (integral, mut rest) = x.split_at_mut(1);
        let mut w = integral[0] + gain;
        for notch in &self.notches {
            let (own, others) = rest.split_at_mut(notch.order());
            w = notch.step(own, w);
            rest = others;
        }
        integrating(self.limits, input, w, &mut integral[0], gain)
    }

    fn blocks(&self) -> Option<Vec<Block>> {
        let block = program::block("integral with notches at the modes", self.limits).number("integral", 0.0);
        let names: Vec<String> = (1..=self.notches.len()).map(|k| format!("notch_{k}")).collect();
        let block = names.iter().fold(block, |block, name| block.part(name, name));
        let through: String = names.iter().map(|name| format!("    w = {name}(s.{name}, w);\n")).collect();
        let step = format!(
            "
fn control_step(s: control_state, r, y, feed_forward) {{
    let gain = ki_ts * missing(r, y);
    let w = s.integral + gain;
{through}    return integrating(s, feed_forward, w, gain);
}}
"
        );
        let mut blocks: Vec<Block> = self
            .notches
            .iter()
            .zip(&names)
            .map(|(notch, name)| notch.block(name, "a notch at a mode of the actuator"))
            .collect();
        blocks.push(block.constant("ki_ts", self.ki * self.ts).text(program::INTEGRATING).text(&step));
        Some(blocks)
    }

    fn law(&self) -> Option<Arx> {
        let start = (vec![self.ki * self.ts], vec![1.0, -1.0]);
        let (b, a) = self.notches.iter().fold(start, |(b, a), n| (times(&b, n.b()), times(&a, &n.denominator())));
        ratio(self.ts, &b, &a).ok()
    }
}

pub(super) const ROW: ControllerKind = ControllerKind {
    name: "integral-notch",
    summary: "integral control with a notch at each mode that needs one",
    reference: "Abramovitch, Hoen & Workman 2008, DOI 10.1109/ACC.2008.4586898",
    uses_feed_forward: true,
    tune: |path, target| {
        let ts = path.linear().ts();
        let modes = modes(path.linear());
        // Number of modes, width, depth, and offset from the mode: a detuned mode can be below or above it.
        let shapes = (0..=modes.len().min(3)).flat_map(|n| spread(0.1, 1.0, 8).map(move |wide| (n, wide)));
        let shapes = shapes.flat_map(|(n, wide)| [0.1, 0.3, 0.6].map(|deep| (n, wide, deep)));
        let shapes = shapes.flat_map(|(n, wide, deep)| [0.85, 0.92, 1.0, 1.08].map(|off| (n, wide, deep, off)));
        let build = |(n, wide, deep, off): (usize, f64, f64, f64), k: f64| {
            let notches: Vec<_> = modes[..n].iter().map(|&(hz, d)| (off * hz, (deep * wide).max(d), wide)).collect();
            IntegralNotch::new(ts, k, &notches, path.limits)
        };
        strongest(path, target, shapes, build).map(|c| Arc::new(c) as Arc<dyn Controller>)
    },
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feedback::tests::assert_follows_its_law;

    #[test]
    fn its_steps_follow_its_law() {
        let notches = [(160.0, 0.03, 0.5), (900.0, 0.02, 0.3)];
        assert_follows_its_law(&IntegralNotch::new(5e-4, 10.0, &notches, (-1e6, 1e6)).unwrap(), 0.0);
    }

    #[test]
    fn the_integral_is_frozen_at_a_limit() {
        let c = IntegralNotch::new(5e-4, 10.0, &[(160.0, 0.03, 0.5)], (-1.0, 1.0)).unwrap();
        let mut x = c.initial();
        (0..10_000).for_each(|_| assert!(c.step(&mut x, &ControllerInput { r: 1.0, ..Default::default() }) <= 1.0));
        assert!(x[0] < 1.1, "{}", x[0]);
    }

    #[test]
    fn a_notch_removes_its_frequency() {
        let c = IntegralNotch::new(5e-4, 10.0, &[(160.0, 0.03, 0.5)], (-30.0, 30.0)).unwrap();
        let law = c.law().unwrap();
        assert!(law.response(160.0).gain < 0.1 * law.response(80.0).gain);
    }
}
