//! The step of a mode, as a function of frequency and damping: exact without a force.
//!
//! ```text
//! p'' + 2 zeta w p' + w^2 p = w^2 F
//! F = 0:  (p, h p')+ = e^(-a) | C + a S    S       | (p, h p'),   a = zeta w h,  D = (w h)^2 - a^2
//!                             | -(w h)^2 S  C - a S |              C = cos sqrt D,  S = sin sqrt D / sqrt D
//! ```
//! C and S are entire functions of D: an overdamped mode (D < 0) needs no other formula. F acts on h p' alone, at the
//! start and at the end of a step: hysteresis that p drives then needs no equation to be solved. Its factor is the one
//! for which a constant F ends at p = F:
//! ```text
//! 2 kick = (1 - m22) (1 - m11) / m12 - m21
//! ```
//! The step is of second order in h, and symmetric (G. Strang, SIAM J. Numer. Anal. 5 (1968), DOI 10.1137/0705041).

use crate::hysteresis::Real;

/// D up to which C and S are series.
const SMALL: f64 = 1e-3;

/// The step of a mode: (p, h p') is multiplied by a matrix.
#[derive(Debug, Clone, Copy)]
pub(super) struct ModeStep<R> {
    pub(super) matrix: [[R; 2]; 2],
    /// What a force of 1 adds to h p' at either end of a step.
    pub(super) kick: R,
}

impl<R: Real> ModeStep<R> {
    /// The step of `h` [s] of a mode of the angular frequency `w` [1/s].
    pub(super) fn new(w: R, damping: R, h: f64) -> Self {
        let angle = w * R::from(h);
        let (decay, square) = (damping * angle, angle * angle);
        let (c, s) = functions(square - decay * decay);
        let keep = (-decay).exp();
        let [m11, m12] = [keep * (c + decay * s), keep * s];
        let [m21, m22] = [-keep * square * s, keep * (c - decay * s)];
        let one = R::from(1.0);
        let kick = ((one - m22) * (one - m11) / m12 - m21) * R::from(0.5);
        ModeStep { matrix: [[m11, m12], [m21, m22]], kick }
    }

    /// The force acts at one end of a step.
    #[inline]
    pub(super) fn push(&self, [p, q]: [R; 2], force: R) -> [R; 2] {
        [p, q + self.kick * force]
    }

    /// At rest at `p`, where a constant force holds it. Between the two pushes of that force h p' is not 0.
    pub(super) fn resting(&self, p: R) -> [R; 2] {
        let [[m11, m12], _] = self.matrix;
        [p, p * ((R::from(1.0) - m11) / m12 - self.kick)]
    }

    /// The step without a force.
    #[inline]
    pub(super) fn turn(&self, [p, q]: [R; 2]) -> [R; 2] {
        self.matrix.map(|[a, b]| a * p + b * q)
    }
}

/// C(D) and S(D).
fn functions<R: Real>(d: R) -> (R, R) {
    let x = d.value();
    let root = x.abs().sqrt();
    let (c, s) = match x {
        _ if x.abs() < SMALL => (
            1.0 - x / 2.0 * (1.0 - x / 12.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0))),
            1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0))),
        ),
        _ if x > 0.0 => (libm::cos(root), libm::sin(root) / root),
        _ => (libm::cosh(root), libm::sinh(root) / root),
    };
    let slope = || match x.abs() < SMALL {
        true => -1.0 / 6.0 + x / 60.0 * (1.0 - x / 28.0 * (1.0 - x / 54.0)),
        false => (c - s) / (2.0 * x),
    };
    (d.map(c, || -0.5 * s), d.map(s, slope))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::{Sensitive, Several};
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    /// A step of a mode at rest under a constant force: 1 - e^(-zeta w t) (cos w_d t + zeta w / w_d sin w_d t).
    #[test]
    fn a_mode_answers_a_constant_force_as_the_differential_equation_does() {
        let (h, w) = (5e-5, TAU * 160.0);
        for damping in [0.01, 0.3, 0.999_999, 1.000_001, 3.0] {
            let step = ModeStep::new(w, damping, h);
            let (mut x, mut y, mut known) = ([0.0; 2], Vec::new(), Vec::new());
            for t in 1..2000 {
                x = step.push(step.turn(step.push(x, 1.0)), 1.0);
                y.push(x[0]);
                let (a, d) = (damping * w, w * w - (damping * w).powi(2));
                let (t, root) = (f64::from(t) * h, d.abs().sqrt());
                let (c, s) = if d > 0.0 {
                    ((root * t).cos(), (root * t).sin() / root)
                } else {
                    ((root * t).cosh(), (root * t).sinh() / root)
                };
                known.push(1.0 - (-a * t).exp() * (c + a * s));
            }
            assert_close(&y, &known, 0.0, 5e-4);
            assert_close(&y[1990..], &known[1990..], 0.0, 1e-4 + (-damping * w * 0.1).exp());
        }
    }

    #[test]
    fn the_slopes_of_a_step_are_those_of_differences() {
        let at = |w: f64, damping: f64| {
            let ModeStep { matrix: [[a, b], [c, d]], kick } = ModeStep::new(w, damping, 1e-4);
            [a, b, c, d, kick]
        };
        for (w, damping) in [(100.0, 0.1), (1e3, 0.02), (5e3, 0.9), (5e3, 1.5)] {
            let seeded = |value: f64, k: usize| {
                let mut slopes = [0.0; 8];
                slopes[k] = 1.0;
                Sensitive { value, slope: Several(slopes) }
            };
            let ModeStep { matrix: [[a, b], [c, d]], kick } = ModeStep::new(seeded(w, 0), seeded(damping, 1), 1e-4);
            let h = 1e-6;
            let by_w = (h * w, at(w + h * w, damping), at(w - h * w, damping));
            let by_damping = (h, at(w, damping + h), at(w, damping - h));
            for (k, (h, p, q)) in [by_w, by_damping].into_iter().enumerate() {
                let differences: Vec<f64> = p.iter().zip(q).map(|(p, q)| (p - q) / (2.0 * h)).collect();
                let slopes = [a, b, c, d, kick].map(|v| v.slope.0[k]);
                let size = slopes.iter().fold(0.0f64, |m, s| m.max(s.abs()));
                assert_close(&slopes, &differences, 1e-6, 1e-6 * size);
            }
        }
    }
}
