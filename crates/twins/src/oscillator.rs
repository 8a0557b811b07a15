//! A mass on a spring, with hysteresis that its displacement drives: the Bouc-Wen benchmark of system identification.
//!
//! ```text
//! m y'' + c y' + k y + z = f,    z' = alpha y' - beta (gamma |y'| |z|^(nu-1) z + delta y' |z|^nu)
//! ```
//! The force f holds the static displacement L of the ceramic at small amplitudes: f = (k + alpha) L. One step is that
//! of Newmark with constant mean acceleration, and f at its end:
//! ```text
//! y+ = y + h y' + h^2/4 (y'' + y''+),    y'+ = y' + h/2 (y'' + y''+),    z+ = z + h/2 (z' + z'+)
//! ```
//! The implicit equations are solved by Newton's method with the slopes at z = 0. The benchmark is integrated at 15
//! kHz, then decimated to 750 Hz: sample the plant at 15 kHz with one inner step, then decimate the record by 20.
//!
//! Reference: J. P. Noel, M. Schoukens, "Hysteretic benchmark with a dynamic nonlinearity", Workshop on Nonlinear
//! System Identification Benchmarks (2016), DOI 10.4121/12967592; N. M. Newmark, J. Eng. Mech. Div. 85(3) (1959).
//!
//! State: y [m], y' [m/s], y'' [m/s^2], z [N].

use super::spec::{Oscillator, non_negative, require};
use libm::pow;
use piezoid_numerics::error::{Error, positive};

/// Newton's steps at most, and the relative change of y'' that ends them.
const MAX_STEPS: usize = 50;
const CLOSE: f64 = 1e-14;

/// Step of a static path, over the distance 1 / beta in which z bends.
const STATIC_STEP: f64 = 1e-3;

/// The oscillator, for a fixed time step.
#[derive(Debug, Clone)]
pub(super) struct OscillatorStage {
    spec: Oscillator,
    /// Time step [s].
    h: f64,
}

impl OscillatorStage {
    pub(super) const ORDER: usize = 4;

    pub(crate) fn new(spec: &Oscillator, h: f64) -> Result<Self, Error> {
        positive("beam.oscillator.mass_kg", spec.mass_kg, "kilograms")?;
        non_negative("beam.oscillator.damping_kg_per_s", spec.damping_kg_per_s, "kg/s")?;
        positive("beam.oscillator.stiffness_n_per_m", spec.stiffness_n_per_m, "N/m")?;
        non_negative("beam.oscillator.alpha_n_per_m", spec.alpha_n_per_m, "N/m")?;
        for (name, value) in [("beta", spec.beta), ("gamma", spec.gamma)] {
            let rule = "must be a positive number, otherwise the hysteresis is unbounded";
            require(value > 0.0 && value.is_finite(), &format!("beam.oscillator.{name}"), value, rule)?;
        }
        require(spec.delta.is_finite(), "beam.oscillator.delta", spec.delta, "must be a finite number")?;
        let rule = "must be from 1 to 10";
        require((1.0..=10.0).contains(&spec.exponent), "beam.oscillator.exponent", spec.exponent, rule)?;
        Ok(OscillatorStage { spec: spec.clone(), h })
    }

    /// z' at the velocity `v`.
    fn rate(&self, v: f64, z: f64) -> f64 {
        let Oscillator { alpha_n_per_m: alpha, beta, gamma, delta, exponent: nu, .. } = self.spec;
        let before = if nu == 1.0 { 1.0 } else { pow(z.abs(), nu - 1.0) };
        alpha * v - beta * before * (gamma * v.abs() * z + delta * v * z.abs())
    }

    /// The force for the static displacement `l` [m].
    fn force(&self, l: f64) -> f64 {
        (self.spec.stiffness_n_per_m + self.spec.alpha_n_per_m) * l
    }

    /// The settled state for the static displacement `l` [m] of the ceramic, after a monotonic movement from rest.
    pub(super) fn settle(&self, x: &mut [f64], l: f64) {
        let (k, force, way) = (self.spec.stiffness_n_per_m, self.force(l), l.signum());
        let mut step = way * STATIC_STEP / self.spec.beta;
        let (mut y, mut z) = (0.0f64, 0.0);
        while step.abs() > f64::EPSILON * y.abs() && l != 0.0 {
            // The midpoint rule along y.
            let middle = z + 0.5 * step.abs() * self.rate(way, z);
            let next = z + step.abs() * self.rate(way, middle);
            let is_short = way * (k * (y + step) + next) <= way * force;
            (y, z) = if is_short { (y + step, next) } else { (y, z) };
            step *= if is_short { 1.0 } else { 0.5 };
        }
        x.copy_from_slice(&[y, 0.0, 0.0, force - k * y]);
    }

    /// Advances one step, with the static displacement `l` [m] of the ceramic at its end.
    pub(super) fn advance(&self, x: &mut [f64], l: f64) {
        let &mut [y, v, a, z] = x else { return };
        let Oscillator { mass_kg: m, damping_kg_per_s: c, stiffness_n_per_m: k, alpha_n_per_m: alpha, .. } = self.spec;
        let (h, force, before) = (self.h, self.force(l), self.rate(v, z));
        let slope = m + 0.5 * h * c + 0.25 * h * h * (k + alpha);
        let (mut next, mut hysteretic) = (a, z + h * before);
        for _ in 0..MAX_STEPS {
            let (to, velocity) = (y + h * v + 0.25 * h * h * (a + next), v + 0.5 * h * (a + next));
            hysteretic = z + 0.5 * h * (before + self.rate(velocity, hysteretic));
            let step = (force - m * next - c * velocity - k * to - hysteretic) / slope;
            next += step;
            if step.abs() <= CLOSE * next.abs() {
                break;
            }
        }
        x.copy_from_slice(&[y + h * v + 0.25 * h * h * (a + next), v + 0.5 * h * (a + next), next, hysteretic]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Preset;
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    const TS: f64 = 1.0 / 15_000.0;

    fn oscillator() -> OscillatorStage {
        let crate::BeamSpec::Oscillator(spec) = Preset::find("bouc-wen-benchmark").unwrap().spec().beam else {
            panic!()
        };
        OscillatorStage::new(&spec, TS).unwrap()
    }

    /// Small vibrations have the stiffness k + alpha: sqrt((k + alpha) / m) / 2 pi = 35.59 Hz, and c / 2 sqrt((k +
    /// alpha) m) = 0.0112.
    #[test]
    fn small_vibrations_have_the_frequency_and_the_damping_of_the_linear_oscillator() {
        let (stage, mut x) = (oscillator(), [1e-9, 0.0, 0.0, 1e-9 * 5e4]);
        x[2] = -1e-9 * 1e5 / 2.0;
        let mut highest = Vec::new();
        for t in 0..15_000 {
            let before = x[1];
            stage.advance(&mut x, 0.0);
            if before > 0.0 && x[1] <= 0.0 {
                highest.push((f64::from(t) + before / (before - x[1]), x[0]));
            }
        }
        let (&[(first, high), .., (last, low)], n) = (&highest[..], highest.len() as f64 - 1.0) else { panic!() };
        let (hertz, decrement) = (n / (last - first) / TS, (high / low).ln() / n);
        assert_close(&[hertz], &[(1e5f64 / 2.0).sqrt() / TAU], 1e-4, 0.0);
        assert_close(&[decrement / TAU], &[10.0 / (2.0 * 2e5f64.sqrt())], 1e-2, 0.0);
    }

    /// z' = alpha y' - beta (gamma + delta) y' z on a rising path from rest: z = alpha (1 - exp(-r y)) / r.
    #[test]
    fn settled_states_are_on_the_analytical_curve() {
        let stage = oscillator();
        for l in [1e-3, -1e-3, 5e-3] {
            let mut x = [0.0; OscillatorStage::ORDER];
            stage.settle(&mut x, l);
            let r = 1e3 * (0.8 - 1.1);
            let z = x[0].signum() * 5e4 * (1.0 - (-r * x[0].abs()).exp()) / r;
            assert_close(&[x[3]], &[z], 1e-6, 0.0);
            assert_close(&[5e4 * x[0] + x[3]], &[1e5 * l], 1e-12, 0.0);
        }
    }
}
