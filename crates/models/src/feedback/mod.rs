//! Mechanics with hysteresis in feedback: linear dynamics and an operator in linear fractional form, in continuous
//! time.
//!
//! ```text
//! F_i = b_i u + e_i z
//! p_i'' + 2 zeta_i w_i p_i' + w_i^2 (p_i - N_i(p_i - F_i)) = w_i^2 F_i          modes
//! s = d_s u + sum_i k_i p_i,   z = H(s) + sum_j g_j x_j,   tau_j x_j' = H(s) - x_j    hysteresis and creep
//! q = sum_i p_i + d u + f z,   y = q + c q^2 + offset                             displacement and sensor
//! N(e) = e m / (1 + m), m = softening |e|; N(e) = -e |m| of a mode that stiffens (softening < 0)
//! ```
//! With k_i = 0 and b_i = d = 0 hysteresis comes first and mechanics after: the Hammerstein model. With d_s = 0 the
//! displacement drives the hysteresis, which acts as a force on the mode: m y'' + c y' + k y + z = u, in a scale in
//! which the static stiffness is 1. p has the unit of y.
//!
//! Of a model that [senses vibration](FeedbackModel::sensing_vibration) s has p_i - F_i in place of p_i: the strain of
//! a vibration changes the voltage at a ceramic.
//!
//! A mode that softens has the restoring force w^2 e / (1 + m) at the distance e from its static displacement.
//!
//! u, z and N act at the ends of each step of the modes (`modes.rs`), so that no equation is solved within a step; the
//! error is of second order in the step. u is held over a sample, or what a known driver makes of it, or band-limited:
//! then it is interpolated. H must not depend on the rate of s. Before the first sample hysteresis and creep were at
//! rest.
//!
//! Only what records can show is a parameter. A coefficient that is 0 stays 0. The first e that is not 0, and the first
//! of d_s and the k, are fixed, because weights and shape of H can have the same effect. If s is the displacement of
//! one mode, a weight of s itself has the effect of the stiffness: let it be 0.
//!
//! References: K. Zhou, J. C. Doyle, Essentials of Robust Control (1998), chapter 9 (linear fractional forms); J. P.
//! Noel, M. Schoukens 2016, DOI 10.4121/12967592.

mod document;
mod input;
mod modes;
mod parameters;
mod program;
mod run;
mod state;

pub(crate) use document::FeedbackDocument;
pub use input::Intersample;
pub use parameters::{FeedbackParameter, Unknown};
pub use run::{FeedbackRun, Observer};

use crate::creep::{Creep, Lag};
use crate::driver::DriverModel;
use crate::hysteresis::{Basis, Hysteresis};
use input::Path;
use piezoid_numerics::error::{Error, positive};
use run::{Coefficients, run};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Usual number of steps per sample: at 12 samples a period the error of a step is 1e-5 of the vibration.
const SUBSTEPS: usize = 20;

/// Most steps per sample, and samples of a delay.
const MAX_SUBSTEPS: usize = 1000;
const MAX_DELAY: usize = 1000;

/// A mode of the mechanics.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeedbackMode {
    /// Undamped natural frequency [Hz].
    pub hz: f64,
    /// Damping ratio zeta [-].
    pub damping: f64,
    /// b: static displacement per input [output unit/input unit].
    pub input: f64,
    /// e: share of z in its static displacement [-].
    pub hysteretic: f64,
    /// k: what it adds to the input of the hysteresis [unit of s/output unit].
    pub sensed: f64,
    /// The share by which its stiffness falls, per distance from its static displacement [1/output unit].
    pub softening: f64,
}

/// What surrounds the hysteresis of a feedback model. The default has no modes, and the input drives the hysteresis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeedbackDynamics {
    /// Steps in each sample, from 1 to 1000.
    pub substeps: usize,
    /// How the input moves between its samples.
    pub intersample: Intersample,
    /// Samples after which y is read.
    pub delay: usize,
    /// The modes.
    pub modes: Vec<FeedbackMode>,
    /// d_s: what the input adds to the input of the hysteresis [unit of s/input unit].
    pub sensed: f64,
    /// True if the vibration of the modes, their distance from the static displacement, drives the hysteresis in place
    /// of their displacement.
    pub senses_vibration: bool,
    /// d [output unit/input unit] and f [-]: how the displacement follows the input and z directly.
    pub direct: [f64; 2],
    /// Creep between the hysteresis and the modes.
    pub creep: Vec<Lag>,
    /// c: the sensor reads q + c q^2 [1/output unit].
    pub curve: f64,
    /// Offset of the output [output unit].
    pub offset: f64,
}

impl Default for FeedbackDynamics {
    fn default() -> Self {
        FeedbackDynamics {
            substeps: SUBSTEPS,
            intersample: Intersample::Held,
            delay: 0,
            modes: Vec::new(),
            sensed: 1.0,
            senses_vibration: false,
            direct: [0.0; 2],
            creep: Vec::new(),
            curve: 0.0,
            offset: 0.0,
        }
    }
}

/// Linear dynamics with hysteresis in feedback: see docs/feedback.md.
#[derive(Debug, Clone)]
pub struct FeedbackModel {
    ts: f64,
    dynamics: FeedbackDynamics,
    hysteresis: Arc<dyn Hysteresis>,
    /// The basis of the hysteresis and its weights; `None` if they are unknown.
    weighted: Option<(Arc<dyn Basis>, Vec<f64>)>,
    /// For each of the coefficients of the dynamics, weights and shape, true if it is a parameter.
    free: Vec<bool>,
    coefficients: Coefficients<f64>,
}

impl FeedbackModel {
    /// The dynamics about an operator, sampled every `ts` [s]. Its weights are no parameters.
    ///
    /// # Errors
    /// Returns an error for a coefficient out of its range, an operator that depends on the rate, or a wrong number of
    /// steps.
    pub fn new(ts: f64, dynamics: FeedbackDynamics, hysteresis: Arc<dyn Hysteresis>) -> Result<Self, Error> {
        FeedbackModel::from_parts(ts, dynamics, hysteresis, None)
    }

    /// The dynamics about the operator of a basis with these weights, which are parameters.
    ///
    /// # Errors
    /// The errors of [`FeedbackModel::new`]; weights that the operator does not allow.
    pub fn weighted(
        ts: f64,
        dynamics: FeedbackDynamics,
        basis: Arc<dyn Basis>,
        weights: Vec<f64>,
    ) -> Result<Self, Error> {
        FeedbackModel::from_parts(ts, dynamics, basis.operator(&weights)?, Some((basis, weights)))
    }

    fn from_parts(
        ts: f64,
        dynamics: FeedbackDynamics,
        hysteresis: Arc<dyn Hysteresis>,
        weighted: Option<(Arc<dyn Basis>, Vec<f64>)>,
    ) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        if !(1..=MAX_SUBSTEPS).contains(&dynamics.substeps) {
            let rule = format!("must be from 1 to {MAX_SUBSTEPS}");
            return Err(Error::parameter("substeps", dynamics.substeps, rule));
        }
        if !hysteresis.operator().rate_independent {
            let rule = "must not depend on the rate of its input, because this differs within a sample";
            return Err(Error::parameter("hysteresis", hysteresis.operator().name, rule));
        }
        if dynamics.modes.is_empty() {
            return Err(Error::parameter("modes", 0, "must be at least one"));
        }
        if dynamics.delay > MAX_DELAY {
            return Err(Error::parameter("delay", dynamics.delay, format!("must be at most {MAX_DELAY} samples")));
        }
        if let Intersample::Driven(driver) = dynamics.intersample {
            DriverModel::new(driver.lag_s, driver.slew)?;
        }
        Creep::new(ts, dynamics.creep.clone())?;
        let rows = parameters::rows(ts, &dynamics, hysteresis.operator().name, weighted.as_ref(), Unknown::default());
        let values = rows.iter().map(|row| row.checked(row.value)).collect::<Result<Vec<_>, _>>()?;
        let coefficients = Coefficients::of(ts, &dynamics, &values);
        let free = rows.iter().map(|row| row.is_free).collect();
        Ok(FeedbackModel { ts, dynamics, hysteresis, weighted, free, coefficients })
    }

    /// The same model about other dynamics.
    ///
    /// # Errors
    /// The errors of [`FeedbackModel::new`].
    pub fn with_dynamics(self, dynamics: FeedbackDynamics) -> Result<Self, Error> {
        FeedbackModel::from_parts(self.ts, dynamics, self.hysteresis, self.weighted)
    }

    /// What surrounds the hysteresis.
    pub fn dynamics(&self) -> &FeedbackDynamics {
        &self.dynamics
    }

    /// The operator.
    pub fn hysteresis(&self) -> &dyn Hysteresis {
        &*self.hysteresis
    }

    /// The basis of the operator and its weights, if they are known.
    pub fn weights(&self) -> Option<(Arc<dyn Basis>, Vec<f64>)> {
        self.weighted.clone()
    }

    /// The modes at rest.
    pub fn at_rest(&self) -> Vec<[f64; 2]> {
        vec![[0.0; 2]; self.dynamics.modes.len()]
    }

    /// The response to `u` from this start of a [run](FeedbackRun).
    pub fn simulate_from(&self, start: &[[f64; 2]], u: &[f64]) -> Vec<f64> {
        self.follow_run(FeedbackRun { start, u, observer: None })
    }

    /// The response along a run. The hysteresis begins at rest and follows the modes.
    pub fn follow_run(&self, of: FeedbackRun) -> Vec<f64> {
        let mut x = self.hysteresis.initial();
        let mut hysteresis = |s| self.hysteresis.step(&mut x, s);
        run(&self.coefficients, &mut hysteresis, of.start.to_vec(), Path::of(self, of.u), of.observer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::{BasisDesign, OPERATORS, Operator};
    use piezoid_numerics::system::System;
    use piezoid_records::preparation::PrepareOptions;
    use piezoid_records::record::Record;
    use piezoid_testing::assert_close;
    use piezoid_twins::{HysteresisSpec, Logged, Plant, Preset, Spec};
    use std::f64::consts::TAU;

    fn operator(name: &str, half: f64) -> Arc<dyn Basis> {
        let design = BasisDesign { ts: 5e-4, range: (-half, half), elements: Some(5), frequencies: vec![5.0] };
        (Operator::find(name).unwrap().basis)(&design).unwrap().into()
    }

    fn wave(n: usize) -> Vec<f64> {
        (0..n).map(|t| 20.0 * (0.05 * t as f64).sin() + 12.0 * (0.173 * t as f64).sin()).collect()
    }

    #[test]
    fn without_a_path_back_the_mode_follows_z() {
        let basis = operator("prandtl-ishlinskii", 30.0);
        let weights: Vec<f64> = (0..basis.len()).map(|k| 1.0 / (1.0 + k as f64)).collect();
        let mode = FeedbackMode { hz: 900.0, damping: 1.0, input: 0.0, hysteretic: 1.0, sensed: 0.0, softening: 0.0 };
        let z = basis.operator(&weights).unwrap().simulate(&wave(400));
        let dynamics = FeedbackDynamics { substeps: 40, modes: vec![mode], ..FeedbackDynamics::default() };
        let model = FeedbackModel::weighted(5e-4, dynamics, basis, weights).unwrap();
        // By the equation: a lag of second order on a staircase.
        let (mut p, mut v, n) = (0.0, 0.0, 20_000);
        let (w, h) = (TAU * 900.0, 5e-4 / n as f64);
        let known = z.iter().map(|z| {
            for _ in 0..n {
                v += h * (w * w * (z - p) - 2.0 * w * v);
                p += h * v;
            }
            p
        });
        assert_close(&model.simulate_from(&[], &wave(400)), &known.collect::<Vec<_>>(), 0.0, 5e-3);
    }

    #[test]
    fn sensitivities_are_the_differences_of_free_runs() {
        let without = ["proportional", "two-branch", "rate-scheduled", "tellinen"];
        for row in OPERATORS.iter().filter(|row| row.rate_independent) {
            let basis = operator(row.name, 40.0);
            let weights: Vec<f64> = (0..basis.len()).map(|k| 0.1 + 0.05 * (1.7 * k as f64).sin()).collect();
            let first =
                FeedbackMode { hz: 160.0, damping: 0.03, input: 0.5, hysteretic: 0.9, sensed: -0.2, softening: 0.004 };
            let second =
                FeedbackMode { hz: 400.0, damping: 0.3, input: 0.1, hysteretic: 0.05, sensed: 0.1, softening: -0.003 };
            for (sensed, senses_vibration) in [(0.0, false), (0.7, false), (0.7, true)] {
                let lag = |tau_s, gain| Lag { tau_s, gain };
                let dynamics = FeedbackDynamics {
                    substeps: 5,
                    intersample: Intersample::BandLimited,
                    delay: 1,
                    modes: vec![first, second],
                    sensed,
                    senses_vibration,
                    direct: [0.1, 0.2],
                    creep: vec![lag(0.01, 0.05), lag(0.1, 0.03)],
                    curve: 1e-3,
                    offset: 3.0,
                };
                let model = FeedbackModel::weighted(5e-4, dynamics, basis.clone(), weights.clone()).unwrap();
                let start = vec![[2.0, 0.3], [-1.0, 0.1]];
                let u = wave(500);
                let measured: Vec<f64> = u.iter().map(|u| 0.9 * u).collect();
                let observer = senses_vibration.then_some(Observer { measured: &measured, gain: 0.3 });
                let of = FeedbackRun { start: &start, u: &u, observer };
                let found = model.sensitivities(of, 0..model.parameters().len() + 4);
                assert_eq!(found.is_err(), without.contains(&row.name), "{}", row.name);
                let Ok((y, slopes)) = found else { continue };
                assert_close(&y, &model.follow_run(of), 1e-9, 1e-9);
                let parameters = model.parameters();
                let x: Vec<f64> = parameters.iter().map(|p| p.value).chain(start.as_flattened().to_vec()).collect();
                assert_eq!(slopes.len(), x.len());
                for (k, slope) in slopes.iter().enumerate() {
                    let h = 1e-6 * (x[k].abs() + 0.01);
                    let moved = |by: f64| {
                        let mut x = x.clone();
                        x[k] += by;
                        let (x, start) = x.split_at(parameters.len());
                        let start: Vec<[f64; 2]> = start.chunks(2).map(|x| [x[0], x[1]]).collect();
                        model.with_parameters(x).unwrap().follow_run(FeedbackRun { start: &start, ..of })
                    };
                    let difference: Vec<f64> =
                        moved(h).iter().zip(moved(-h)).map(|(p, q)| (p - q) / (2.0 * h)).collect();
                    let off: f64 = difference.iter().zip(slope).map(|(d, s)| (d - s).powi(2)).sum();
                    let size: f64 = difference.iter().map(|d| d * d).sum();
                    // Where a play or a rate that depends on the direction reverses, a difference is no derivative.
                    let most = match row.name {
                        "dahl" => 1e-8,
                        name if name.contains("bouc") => 1e-8,
                        "narx" => 1e-3,
                        _ => 1e-4,
                    };
                    assert!(off <= most * size + 1e-12, "{} {k} of {parameters:?}: {off:e} of {size:e}", row.name);
                }
            }
        }
    }

    /// The bender `pl140-nonlinear` without hysteresis: its driver, creep, softening mode, curved sensor, and
    /// the vibration that acts on the voltage.
    #[test]
    fn the_true_parameters_of_a_nonlinear_bender_leave_less_than_a_thousandth() {
        let ts = 5e-4;
        let spec = Preset::find("pl140-nonlinear").unwrap().spec();
        let hysteresis = HysteresisSpec::Linear { range_v: 30.0, displacement_m: 1e-3 };
        let mut plant = Spec { hysteresis, logged: Logged::After, ..spec };
        plant.sensor.noise_rms_m = 0.0;
        // The strain acts one inner step later.
        plant.inner_steps = 500;
        // 1.5 V about the resonance, up to half the stroke.
        let u: Vec<f64> = (0..2000).map(|t| 1.5 * (TAU * (120.0 + 0.02 * t as f64) * ts * t as f64).sin()).collect();
        let y = Plant::new(&plant, ts).unwrap().run(&u).y;

        let driver = DriverModel::new(1e-4, Some(0.5 / 8.2e-6)).unwrap();
        let gain = 1000.0 / 30.0;
        let lags = [0.1, 1.0, 10.0, 100.0];
        let direct = 1.0 - 0.015 * lags.iter().map(|tau| 1.0 - (-0.1f64 / tau).exp()).sum::<f64>();
        let lags = lags.map(|tau_s| Lag { tau_s, gain: 0.015 / direct });
        let rms = |[softening, curve, coupling]: [f64; 3]| {
            let (damping, input, sensed) = (0.03, 0.0, -coupling / gain);
            let mode = |hz, hysteretic, softening| FeedbackMode { hz, damping, input, hysteretic, sensed, softening };
            let modes = vec![mode(166.3, 0.891, softening), mode(1042.0, 0.0788, 0.0), mode(2918.0, 0.0165, 0.0)];
            let basis = operator("prandtl-ishlinskii", 30.0);
            let mut weights = vec![0.0; basis.len()];
            weights[0] = gain * direct;
            let dynamics = FeedbackDynamics {
                intersample: Intersample::Driven(driver),
                modes,
                senses_vibration: true,
                direct: [0.0, 0.0137],
                creep: lags.to_vec(),
                curve,
                ..FeedbackDynamics::default()
            };
            let run = FeedbackModel::weighted(ts, dynamics, basis, weights).unwrap().simulate_from(&[], &u);
            (y.iter().zip(run).map(|(y, m)| (y - m).powi(2)).sum::<f64>() / y.len() as f64).sqrt()
        };
        let high = y.iter().fold(0.0f64, |high, y| high.max(y.abs()));
        let full = rms([140e-6, 1e-5, 0.1]);
        let without = [[0.0, 1e-5, 0.1], [140e-6, 0.0, 0.1], [140e-6, 1e-5, 0.0]].map(rms);
        assert!(high > 400.0 && full < 1e-3 * high, "{full} of {high} um");
        assert!(without.iter().all(|rms| *rms > 2.0 * full), "{full}, without each part {without:?} um");
    }

    /// The benchmark: Newmark's integration at 15 kHz and decimation share nothing with the step of the modes.
    #[test]
    fn the_true_parameters_of_the_benchmark_leave_less_than_its_floor() {
        const RATE: usize = 20;
        let n = 2048 * RATE;
        let at = |t: usize| -> f64 {
            let phase = |k: usize| TAU * (k * t % n) as f64 / n as f64 + (k * k) as f64;
            // Lines from 5 to 150 Hz.
            (14..410).map(|k| 3.55 * phase(k).sin()).sum()
        };
        let u: Vec<f64> = (0..n).map(at).collect();
        let y = Plant::named("bouc-wen-benchmark", 1.0 / 15_000.0).unwrap().run(&u).y;
        let options = PrepareOptions { decimate: Some(RATE), ..PrepareOptions::default() };
        let record = options.run(&Record::new(1.0 / 15_000.0, u, y).unwrap()).unwrap();
        let (u, y) = (record.u(), record.y());
        let basis = operator("bouc-wen", 1000.0).reshaped(&[8e-4, -1.375]).unwrap();
        // Newmark's step makes the period longer, by (w h)^2 / 12 of the frequency of small vibrations.
        let longer = 5e4 / 15_000f64.powi(2) / 12.0;
        let mode = FeedbackMode {
            hz: 2.5e4f64.sqrt() / TAU * (1.0 - longer),
            damping: 10.0 / (4.0 * 2.5e4f64.sqrt()),
            input: 20.0,
            hysteretic: 1.0,
            sensed: 1.0,
            softening: 0.0,
        };
        let (intersample, modes) = (Intersample::BandLimited, vec![mode]);
        let dynamics = FeedbackDynamics { intersample, modes, sensed: 0.0, ..FeedbackDynamics::default() };
        let model = FeedbackModel::weighted(1.0 / 750.0, dynamics, basis.into(), vec![0.0, 1.0]).unwrap();
        let modelled = model.follow(&mut model.initial(), u);
        let rms = |x: &mut dyn Iterator<Item = f64>| {
            let squares: Vec<f64> = x.map(|v| v * v).collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        };
        // After the vibration that the jump to the first sample leaves.
        let inside = 600..u.len() - 100;
        let (size, error) = (rms(&mut y[inside.clone()].iter().copied()), rms(&mut inside.map(|t| y[t] - modelled[t])));
        // The true parameters leave 0.18 um on the published multisine.
        assert!(size > 400.0 && error < 0.18, "{error} of {size} um");
    }
}
