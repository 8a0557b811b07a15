//! A mass on a spring, with hysteresis that its displacement drives: the Bouc-Wen benchmark of system identification.
//!
//! ```text
//! m y'' + c y' + k y + z = f,    z' = alpha y' - beta (gamma |y'| z + delta y' |z|)
//! ```
//! The force f holds the static displacement L of the ceramic at small amplitudes: f = (k + alpha) L. One step is that
//! of Newmark with constant mean acceleration, and f at its end:
//! ```text
//! y+ = y + h y' + h^2/4 (y'' + y''+),    y'+ = y' + h/2 (y'' + y''+),    z+ = z + h/2 (z' + z'+)
//! ```
//! z+ is a linear equation for a known y'+, and y''+ follows by iteration with the slope at z = 0. The benchmark is
//! integrated at 15 kHz, then decimated to 750 Hz: sample the plant at 15 kHz, then decimate the record by 20. Longer
//! periods are divided, so that a step turns a small vibration by at most a tenth.
//!
//! Reference: J. P. Noel, M. Schoukens, "Hysteretic benchmark with a dynamic nonlinearity", Workshop on Nonlinear
//! System Identification Benchmarks (2016), DOI 10.4121/12967592; N. M. Newmark, J. Eng. Mech. Div. 85(3) (1959). The
//! exponent nu of the benchmark is 1.
//!
//! State: y [m], y' [m/s], y'' [m/s^2], z [N].

use super::spec::{Oscillator, non_negative, require};
use libm::expm1;
use piezoid_numerics::error::{Error, positive};

/// Largest angle of a small vibration in a step [rad], and largest number of steps in a period.
const ANGLE: f64 = 0.1;
const MOST_STEPS: f64 = 1e4;

/// Iterations of a step at most, and the share of the forces that ends them.
const MOST_ITERATIONS: usize = 50;
const CLOSE: f64 = 1e-15;

/// Bisections of a settled state: all digits.
const BISECTIONS: usize = 100;

/// The oscillator, for a fixed time step.
#[derive(Debug, Clone)]
pub(super) struct OscillatorStage {
    spec: Oscillator,
    /// Time step [s], and their number in a period.
    h: f64,
    steps: usize,
}

impl OscillatorStage {
    pub(super) const ORDER: usize = 4;

    pub(crate) fn new(spec: &Oscillator, period: f64) -> Result<Self, Error> {
        positive("beam.oscillator.mass_kg", spec.mass_kg, "kilograms")?;
        non_negative("beam.oscillator.damping_kg_per_s", spec.damping_kg_per_s, "kg/s")?;
        positive("beam.oscillator.stiffness_n_per_m", spec.stiffness_n_per_m, "N/m")?;
        non_negative("beam.oscillator.alpha_n_per_m", spec.alpha_n_per_m, "N/m")?;
        for (name, value, unit) in [("beta", spec.beta, "1/m"), ("gamma", spec.gamma, "1")] {
            positive(&format!("beam.oscillator.{name}"), value, unit)?;
        }
        require(spec.delta.is_finite(), "beam.oscillator.delta", spec.delta, "must be a finite number")?;
        let frequency = ((spec.stiffness_n_per_m + spec.alpha_n_per_m) / spec.mass_kg).sqrt();
        let steps = (frequency * period / ANGLE).ceil().max(1.0);
        let rule = format!("must be at most {} s for this oscillator", MOST_STEPS * ANGLE / frequency);
        require(steps <= MOST_STEPS, "the sampling period", period, &rule)?;
        Ok(OscillatorStage { spec: spec.clone(), h: period / steps, steps: steps as usize })
    }

    /// The force for the static displacement `l` [m].
    fn force(&self, l: f64) -> f64 {
        (self.spec.stiffness_n_per_m + self.spec.alpha_n_per_m) * l
    }

    /// The settled state for the static displacement `l` [m] of the ceramic, after a monotonic movement from rest,
    /// along which |z| = alpha (1 - e^(-r |y|)) / r with r = beta (gamma + delta).
    pub(super) fn settle(&self, x: &mut [f64], l: f64) {
        let Oscillator { stiffness_n_per_m: k, alpha_n_per_m: alpha, beta, gamma, delta, .. } = self.spec;
        let (force, r) = (self.force(l), beta * (gamma + delta));
        let z = |y: f64| if r == 0.0 { alpha * y } else { -alpha * expm1(-r * y) / r };
        let (mut low, mut high) = (0.0, force.abs() / k);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            *if k * middle + z(middle) < force.abs() { &mut low } else { &mut high } = middle;
        }
        let y = low * force.signum();
        x.copy_from_slice(&[y, 0.0, 0.0, force - k * y]);
    }

    /// Advances one sampling period, with the static displacement `l` [m] of the ceramic at its end.
    pub(super) fn advance(&self, x: &mut [f64], l: f64) {
        for _ in 0..self.steps {
            self.step(x, self.force(l));
        }
    }

    fn step(&self, x: &mut [f64], force: f64) {
        let &mut [y, v, a, z] = x else { return };
        let Oscillator { mass_kg: m, damping_kg_per_s: c, stiffness_n_per_m: k, .. } = self.spec;
        let Oscillator { alpha_n_per_m: alpha, beta, gamma, delta, .. } = self.spec;
        let h = self.h;
        // z' = alpha v - lost z
        let lost = |v: f64, z: f64| beta * (gamma * v.abs() + delta * v * z.signum());
        let rate = alpha * v - lost(v, z) * z;
        let slope = m + 0.5 * h * c + 0.25 * h * h * (k + alpha);
        let (mut next, mut end) = (a, [y, v, a, z]);
        for _ in 0..MOST_ITERATIONS {
            let (to, velocity) = (y + h * v + 0.25 * h * h * (a + next), v + 0.5 * h * (a + next));
            let hysteretic = (z + 0.5 * h * (rate + alpha * velocity)) / (1.0 + 0.5 * h * lost(velocity, end[3]));
            end = [to, velocity, next, hysteretic];
            let left = force - m * next - c * velocity - k * to - hysteretic;
            if left.abs() <= CLOSE * (force.abs() + (m * next).abs() + (k * to).abs() + hysteretic.abs()) {
                break;
            }
            next += left / slope;
        }
        x.copy_from_slice(&end);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BeamSpec, Plant, Preset};
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    const TS: f64 = 1.0 / 15_000.0;

    fn oscillator() -> OscillatorStage {
        let BeamSpec::Oscillator(spec) = Preset::find("bouc-wen-benchmark").unwrap().spec().beam else { panic!() };
        OscillatorStage::new(&spec, TS).unwrap()
    }

    /// Small vibrations have the stiffness k + alpha: sqrt((k + alpha) / m) / 2 pi = 35.59 Hz, and c / 2 sqrt((k +
    /// alpha) m) = 0.0112.
    #[test]
    fn small_vibrations_have_the_frequency_and_the_damping_of_the_linear_oscillator() {
        let (stage, mut x) = (oscillator(), [1e-9, 0.0, -1e-9 * 1e5 / 2.0, 1e-9 * 5e4]);
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

    #[test]
    fn long_periods_and_large_forces_stay_finite_and_odd_plants_are_errors() {
        for ts in [1.0 / 750.0, 2e-3, 5e-3, 0.1] {
            let plant = Plant::named("bouc-wen-benchmark", ts).unwrap();
            let u: Vec<f64> = (0..400).map(|t| 1000.0 * (TAU * 36.0 * f64::from(t) * ts).sin()).collect();
            assert!(plant.run(&u).y.iter().all(|y| y.abs() < 1e6), "{ts}");
        }
        let mut spec = Preset::find("bouc-wen-benchmark").unwrap().spec();
        let BeamSpec::Oscillator(oscillator) = &mut spec.beam else { panic!() };
        oscillator.beta = 1e308;
        let settled = Plant::new(&spec, TS).unwrap().settled(1000.0);
        assert!(settled.iter().all(|x| x.is_finite()), "{settled:?}");
        let BeamSpec::Oscillator(oscillator) = &mut spec.beam else { panic!() };
        oscillator.mass_kg = 1e-300;
        let message = Plant::new(&spec, TS).unwrap_err().to_string();
        assert!(message.contains("must be at most"), "{message}");
    }
}
