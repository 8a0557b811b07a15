//! The mechanics of the bender: a cantilever under a uniform piezo moment, measured at its tip.
//!
//! ```text
//! cos x cosh x = -1,   f_i = x_i^2 / (2 pi L^2) sqrt(E I / (rho A)),   I / A = t^2 / 12
//! share_i = 8 sigma_i / x_i^3,   sigma = (sinh x - sin x) / (cosh x + cos x)
//! p_i'' + 2 zeta_i w_i p_i' + w_i^2 p_i = w_i^2 share_i L,    y = sum_i p_i + (1 - sum_i share_i) L
//! ```
//! L is the static displacement of the tip. The shares of all modes add up to 1; the share of omitted modes follows L
//! directly. Each mode is advanced exactly for an L held over the step. A mode that softens has the restoring force
//! w^2 e / (1 + s |e|), e = p - share L; what it lacks to w^2 e acts at the start and at the end of the step.
//!
//! Reference: R. G. Ballas, "Piezoelectric Multilayer Beam Bending Actuators", Springer (2007), DOI
//! 10.1007/978-3-540-32642-7. Not modelled: shear, rotary inertia, torsion, a payload, air.
//!
//! State: for each mode, p [m] and p' / w [m].

use super::spec::{BeamMode, Cantilever, non_negative, require};
use libm::{cos, cosh, exp, sin, sincos, tanh};
use piezoid_numerics::error::{Error, positive};
use std::f64::consts::{PI, TAU};

/// The modes, for a fixed time step.
#[derive(Debug, Clone)]
pub(super) struct Beam {
    steps: Vec<ModeStep>,
    /// Share of the displacement without dynamics.
    pub(super) residual: f64,
}

/// One mode's exact step: (p - share L, p' / w) is multiplied by a matrix.
#[derive(Debug, Clone)]
struct ModeStep {
    share: f64,
    /// s [1/m], and w h / 2: half of what changes p' / w.
    softening: f64,
    half: f64,
    matrix: [[f64; 2]; 2],
}

impl Beam {
    /// The beam advanced in steps of `h` [s].
    pub(crate) fn new(modes: &[BeamMode], h: f64) -> Result<Self, Error> {
        let steps = modes.iter().enumerate().map(|(i, mode)| ModeStep::new(mode, i, h)).collect::<Result<_, _>>()?;
        Ok(Beam { steps, residual: 1.0 - modes.iter().map(|mode| mode.share).sum::<f64>() })
    }

    pub(super) fn order(&self) -> usize {
        2 * self.steps.len()
    }

    /// Tip displacement [m] for the static displacement `l` [m].
    #[inline]
    pub(super) fn tip(&self, x: &[f64], l: f64) -> f64 {
        x.iter().step_by(2).sum::<f64>() + self.residual * l
    }

    /// The settled state for the static displacement `l` [m].
    pub(super) fn settle(&self, x: &mut [f64], l: f64) {
        for (x, step) in x.chunks_exact_mut(2).zip(&self.steps) {
            x.copy_from_slice(&[step.share * l, 0.0]);
        }
    }

    /// Advances one step under the held static displacement `l` [m].
    #[inline]
    pub(crate) fn advance(&self, x: &mut [f64], l: f64) {
        for (x, step) in x.chunks_exact_mut(2).zip(&self.steps) {
            let [[a, b], [c, d]] = step.matrix;
            let (p, mut q) = (x[0] - step.share * l, x[1]);
            q += step.lacking(p);
            (x[0], q) = (a * p + b * q, c * p + d * q);
            x[1] = q + step.lacking(x[0]);
            x[0] += step.share * l;
        }
    }
}

impl ModeStep {
    fn new(mode: &BeamMode, i: usize, h: f64) -> Result<Self, Error> {
        let &BeamMode { frequency_hz, damping, share, softening_per_m: softening } = mode;
        positive(&format!("beam.modes[{i}].frequency_hz"), frequency_hz, "hertz")?;
        let rule = "must lie between 0 and 1";
        require(damping > 0.0 && damping < 1.0, &format!("beam.modes[{i}].damping"), damping, rule)?;
        require(share.is_finite(), &format!("beam.modes[{i}].share"), share, "must be a finite number")?;
        non_negative(&format!("beam.modes[{i}].softening_per_m"), softening, "1/m")?;

        let root = (1.0 - damping * damping).sqrt();
        let (w, keep) = (TAU * frequency_hz, exp(-damping * TAU * frequency_hz * h));
        let (sin, cos) = sincos(w * root * h);
        let (turn, lag) = (keep * sin / root, keep * damping * sin / root);
        let matrix = [[keep * cos + lag, turn], [-turn, keep * cos - lag]];
        Ok(ModeStep { share, softening, half: 0.5 * w * h, matrix })
    }

    /// The change of p' / w over half a step by the force that a mode lacks at the distance `e` [m].
    #[inline]
    fn lacking(&self, e: f64) -> f64 {
        let soft = self.softening * e.abs();
        self.half * e * soft / (1.0 + soft)
    }
}

impl Cantilever {
    /// The modes by rising frequency, one per damping ratio.
    ///
    /// # Errors
    /// Returns an error unless dimensions and material constants are positive.
    pub fn modes(&self) -> Result<Vec<BeamMode>, Error> {
        let length = positive("beam.cantilever.length_m", self.length_m, "metres")?;
        let thickness = positive("beam.cantilever.thickness_m", self.thickness_m, "metres")?;
        let modulus = positive("beam.cantilever.youngs_modulus_pa", self.youngs_modulus_pa, "pascals")?;
        let density = positive("beam.cantilever.density_kg_per_m3", self.density_kg_per_m3, "kg/m^3")?;
        let hertz = (modulus / (12.0 * density)).sqrt() * thickness / (TAU * length * length);
        let mode = |(i, &damping): (usize, &f64)| {
            let x = eigenvalue(i);
            BeamMode { frequency_hz: x * x * hertz, damping, share: 8.0 * sigma(x) / x.powi(3), softening_per_m: 0.0 }
        };
        Ok(self.damping.iter().enumerate().map(mode).collect())
    }
}

/// The i-th root of cos x + 1 / cosh x = 0, by Newton's method from its asymptote (i + 1/2) pi.
fn eigenvalue(i: usize) -> f64 {
    let mut x = (i as f64 + 0.5) * PI;
    for _ in 0..20 {
        x -= (cos(x) + 1.0 / cosh(x)) / (-sin(x) - tanh(x) / cosh(x));
    }
    x
}

/// (sinh x - sin x) / (cosh x + cos x), divided by cosh x to avoid overflow.
fn sigma(x: f64) -> f64 {
    (tanh(x) - sin(x) / cosh(x)) / (1.0 + cos(x) / cosh(x))
}

#[cfg(test)]
mod tests {
    use super::super::catalogue::{BENDERS, Bender, DENSITY, PL140};
    use super::*;
    use piezoid_testing::assert_close;

    fn cantilever(bender: &Bender, modes: usize) -> Cantilever {
        Cantilever {
            length_m: bender.free_length,
            thickness_m: bender.thickness,
            youngs_modulus_pa: bender.youngs_modulus(),
            density_kg_per_m3: DENSITY,
            damping: vec![0.03; modes],
        }
    }

    #[test]
    fn the_modes_of_the_pl140_are_those_of_numpy() {
        let modes = cantilever(&PL140, 5).modes().unwrap();
        let numbers = |f: fn(&BeamMode) -> f64| modes.iter().map(f).collect::<Vec<_>>();
        // Computed with numpy from the same datasheet; the soft one has 1 / s11E of PIC255.
        assert_close(&numbers(|m| m.share), &[0.891, 0.0788, 0.0165, 0.0060, 0.0028], 0.015, 0.0);
        assert_close(&numbers(|m| m.frequency_hz)[..3], &[166.3, 1042.0, 2918.0], 1e-3, 0.0);
        let soft = Cantilever { youngs_modulus_pa: 62.1e9, ..cantilever(&PL140, 3) }.modes().unwrap();
        let ratio = |i: usize| soft[i].frequency_hz / soft[0].frequency_hz;
        assert_close(&[soft[0].frequency_hz, ratio(1), ratio(2)], &[156.7, 6.267, 17.55], 1e-3, 0.0);
    }

    #[test]
    fn the_shares_of_all_modes_add_up_to_one() {
        let sum: f64 = cantilever(&PL140, 400).modes().unwrap().iter().map(|m| m.share).sum();
        assert_close(&[sum], &[1.0], 0.0, 1e-6);
    }

    #[test]
    fn geometry_gives_the_resonance_of_the_datasheet() {
        for bender in &BENDERS {
            let first = cantilever(bender, 1).modes().unwrap()[0].frequency_hz;
            assert_close(&[first], &[bender.resonance], 0.2, 0.0);
        }
    }

    /// A held input is a sum of its aliases, w_k = w + 2 pi k / h:
    /// H(w) = 1/h sum_k G(w_k) (1 - exp(-j w_k h)) / (j w_k)
    #[test]
    fn the_response_to_a_held_sine_is_the_analytic_one() {
        let h = 5e-4;
        let modes = cantilever(&PL140, 3).modes().unwrap();
        let beam = Beam::new(&modes, h).unwrap();
        for frequency in [1.0, 50.0, 166.3, 400.0, 900.0] {
            let w = TAU * frequency;
            let (mut re, mut im) = (0.0, 0.0);
            for k in -20_000..=20_000 {
                let wk = w + TAU * f64::from(k) / h;
                let (sin, cos) = (w * h).sin_cos();
                // (1 - exp(-j w h)) / (j w_k h) = (sin - j (1 - cos)) / (w_k h)
                let (hold_re, hold_im) = (sin / (wk * h), -(1.0 - cos) / (wk * h));
                for BeamMode { frequency_hz, damping, share, .. } in &modes {
                    let r = wk / (TAU * frequency_hz);
                    let (a, b) = (1.0 - r * r, 2.0 * damping * r);
                    let (g_re, g_im) = (share * a / (a * a + b * b), -share * b / (a * a + b * b));
                    re += g_re * hold_re - g_im * hold_im;
                    im += g_re * hold_im + g_im * hold_re;
                }
            }
            let mut x = vec![0.0; beam.order()];
            for i in 0..8000 {
                let t = f64::from(i) * h;
                if i >= 7900 {
                    let (sin, cos) = (w * t).sin_cos();
                    assert_close(&[beam.tip(&x, 0.0)], &[re * sin + im * cos], 0.0, 1e-6);
                }
                beam.advance(&mut x, (w * t).sin());
            }
        }
    }

    #[test]
    fn the_settled_tip_is_at_the_static_displacement() {
        let beam = Beam::new(&cantilever(&PL140, 2).modes().unwrap(), 1e-4).unwrap();
        let mut x = vec![0.0; beam.order()];
        (0..20_000).for_each(|_| beam.advance(&mut x, 1e-3));
        assert_close(&[beam.tip(&x, 1e-3)], &[1e-3], 1e-12, 0.0);
    }

    #[test]
    fn a_mode_that_softens_rings_more_slowly_when_it_rings_widely() {
        let (h, s) = (1e-5, 140.0);
        let mode = BeamMode { frequency_hz: 160.0, damping: 1e-4, share: 1.0, softening_per_m: s };
        let beam = Beam::new(&[mode], h).unwrap();
        for amplitude in [1e-5, 0.5e-3] {
            let mut x = vec![amplitude, 0.0];
            let mut falls = Vec::new();
            for t in 0..20_000 {
                let before = x[0];
                beam.advance(&mut x, 0.0);
                if before > 0.0 && x[0] <= 0.0 {
                    falls.push((f64::from(t) + before / (before - x[0])) * h);
                }
            }
            let hertz = 4.0 / (falls[4] - falls[0]);
            // Of first order in s: the force w^2 (e - s |e| e) has the frequency w (1 - 4 s amplitude / 3 pi).
            let fall = 4.0 * s * amplitude / (3.0 * PI);
            assert_close(&[1.0 - hertz / 160.0], &[fall], 0.12, 1e-5);
        }
    }

    #[test]
    fn a_mode_without_damping_is_an_error() {
        let mode = BeamMode { frequency_hz: 160.0, damping: 0.0, share: 1.0, softening_per_m: 0.0 };
        let message = Beam::new(&[mode], 1e-4).unwrap_err().to_string();
        assert!(message.starts_with("beam.modes[0].damping = 0"), "{message}");
    }
}
