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

mod input;
mod modes;
mod parameters;
mod run;

pub use input::Intersample;
pub use parameters::FeedbackParameter;

use crate::creep::{Creep, Lag};
use crate::hysteresis::{Basis, Hysteresis};
use input::Path;
use piezoid_numerics::error::{Error, finite, positive};
use run::{Coefficients, run};
use std::sync::Arc;

/// Most steps per sample.
const MAX_SUBSTEPS: usize = 1000;

/// A mode of the mechanics.
#[derive(Debug, Clone, Copy, PartialEq)]
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

/// Linear dynamics with hysteresis in feedback: see docs/feedback.md.
#[derive(Debug, Clone)]
pub struct FeedbackModel {
    ts: f64,
    substeps: usize,
    intersample: Intersample,
    modes: Vec<FeedbackMode>,
    /// d_s.
    sensed: f64,
    senses_vibration: bool,
    /// d and f.
    direct: [f64; 2],
    creep: Vec<Lag>,
    /// c [1/output unit].
    curve: f64,
    basis: Arc<dyn Basis>,
    weights: Vec<f64>,
    operator: Arc<dyn Hysteresis>,
    offset: f64,
}

impl FeedbackModel {
    /// The modes and the operator, with `substeps` steps in each sample of `ts` [s]. Its hysteresis is driven by the
    /// input, times `sensed`, and by the modes as far as they have a coefficient for it.
    ///
    /// # Errors
    /// Returns an error for a coefficient out of its range, an operator that depends on the rate, weights that it does
    /// not allow, or more than 1000 steps.
    pub fn new(
        ts: f64,
        (substeps, intersample): (usize, Intersample),
        modes: Vec<FeedbackMode>,
        sensed: f64,
        (basis, weights): (Arc<dyn Basis>, Vec<f64>),
    ) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        if !(1..=MAX_SUBSTEPS).contains(&substeps) {
            return Err(Error::parameter("substeps", substeps, format!("must be from 1 to {MAX_SUBSTEPS}")));
        }
        let operator = basis.operator(&weights)?;
        if !operator.operator().rate_independent {
            let rule = "must not depend on the rate of its input, because this differs within a sample";
            return Err(Error::parameter("hysteresis", operator.operator().name, rule));
        }
        let model = FeedbackModel {
            ts,
            substeps,
            intersample,
            modes,
            sensed,
            senses_vibration: false,
            direct: [0.0; 2],
            creep: Vec::new(),
            curve: 0.0,
            basis,
            weights,
            operator,
            offset: 0.0,
        };
        for row in model.rows() {
            row.checked(row.value)?;
        }
        Ok(model)
    }

    /// The same model whose displacement follows the input (d) and z (f) directly too, with an offset [output unit].
    ///
    /// # Errors
    /// Returns an error unless all are finite.
    pub fn with_direct(self, direct: [f64; 2], offset: f64) -> Result<Self, Error> {
        finite("direct", &direct)?;
        finite("offset", &[offset])?;
        Ok(FeedbackModel { direct, offset, ..self })
    }

    /// The same model whose hysteresis is driven by the vibration of the modes, their distance from the static
    /// displacement, in place of their displacement.
    pub fn sensing_vibration(self) -> Self {
        FeedbackModel { senses_vibration: true, ..self }
    }

    /// The same model with creep between the hysteresis and the modes.
    ///
    /// # Errors
    /// The errors of [`Creep::new`].
    pub fn with_creep(self, lags: Vec<Lag>) -> Result<Self, Error> {
        let creep = Creep::new(self.ts, lags)?.lags().to_vec();
        Ok(FeedbackModel { creep, ..self })
    }

    /// The same model with a sensor that reads q + c q^2, `curve` = c [1/output unit].
    ///
    /// # Errors
    /// Returns an error unless it is finite.
    pub fn with_curve(self, curve: f64) -> Result<Self, Error> {
        finite("curve", &[curve])?;
        Ok(FeedbackModel { curve, ..self })
    }

    /// Sampling period [s].
    pub fn ts(&self) -> f64 {
        self.ts
    }

    /// The modes.
    pub fn modes(&self) -> &[FeedbackMode] {
        &self.modes
    }

    /// The operator.
    pub fn hysteresis(&self) -> &dyn Hysteresis {
        &*self.operator
    }

    /// Offset of the output [output unit].
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// The response to `u`, from rest.
    pub fn simulate(&self, u: &[f64]) -> Vec<f64> {
        self.simulate_from(&self.at_rest(), u)
    }

    /// The modes at rest.
    pub fn at_rest(&self) -> Vec<[f64; 2]> {
        vec![[0.0; 2]; self.modes.len()]
    }

    /// The response to `u` if each mode begins with this p and step times p', in the unit of y; modes without them are
    /// at rest. The hysteresis begins at rest and follows them.
    pub fn simulate_from(&self, start: &[[f64; 2]], u: &[f64]) -> Vec<f64> {
        let coefficients = Coefficients::of(self, &self.expanded(&self.values()));
        let mut x = self.operator.initial();
        let mut y = Vec::with_capacity(u.len());
        let mut hysteresis = |s| self.operator.step(&mut x, s);
        run(&coefficients, &mut hysteresis, start.to_vec(), Path::new(self, u), |v| y.push(v));
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::driver::DriverModel;
    use crate::hysteresis::{BasisDesign, OPERATORS, Operator};
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
        let model = FeedbackModel::new(5e-4, (40, Intersample::Held), vec![mode], 1.0, (basis, weights)).unwrap();
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
        assert_close(&model.simulate(&wave(400)), &known.collect::<Vec<_>>(), 0.0, 5e-3);
    }

    #[test]
    fn sensitivities_are_the_differences_of_free_runs() {
        let without = ["proportional", "two-branch", "rate-scheduled", "preisach", "tellinen"];
        for row in OPERATORS.iter().filter(|row| row.rate_independent) {
            let basis = operator(row.name, 40.0);
            let weights: Vec<f64> = (0..basis.len()).map(|k| 0.1 + 0.05 * (1.7 * k as f64).sin()).collect();
            let first =
                FeedbackMode { hz: 160.0, damping: 0.03, input: 0.5, hysteretic: 0.9, sensed: -0.2, softening: 0.004 };
            let second =
                FeedbackMode { hz: 400.0, damping: 0.3, input: 0.1, hysteretic: 0.05, sensed: 0.1, softening: -0.003 };
            for (sensed, vibration) in [(0.0, false), (0.7, false), (0.7, true)] {
                let modes = vec![first, second];
                let steps = (5, Intersample::BandLimited);
                let model = FeedbackModel::new(5e-4, steps, modes, sensed, (basis.clone(), weights.clone())).unwrap();
                let lag = |tau_s, gain| Lag { tau_s, gain };
                let model = model.with_direct([0.1, 0.2], 3.0).unwrap().with_curve(1e-3).unwrap();
                let model = model.with_creep(vec![lag(0.01, 0.05), lag(0.1, 0.03)]).unwrap();
                let model = if vibration { model.sensing_vibration() } else { model };
                let start = vec![[2.0, 0.3], [-1.0, 0.1]];
                let found = model.sensitivities(&start, &wave(500));
                assert_eq!(found.is_err(), without.contains(&row.name), "{}", row.name);
                let Ok((y, slopes)) = found else { continue };
                assert_close(&y, &model.simulate_from(&start, &wave(500)), 1e-9, 1e-9);
                let parameters = model.parameters();
                let x: Vec<f64> = parameters.iter().map(|p| p.value).chain(start.into_flattened()).collect();
                assert_eq!(slopes.len(), x.len());
                for (k, slope) in slopes.iter().enumerate() {
                    let h = 1e-6 * (x[k].abs() + 0.01);
                    let moved = |by: f64| {
                        let mut x = x.clone();
                        x[k] += by;
                        let (x, start) = x.split_at(parameters.len());
                        let start: Vec<[f64; 2]> = start.chunks(2).map(|x| [x[0], x[1]]).collect();
                        model.with_parameters(x).unwrap().simulate_from(&start, &wave(500))
                    };
                    let difference: Vec<f64> =
                        moved(h).iter().zip(moved(-h)).map(|(p, q)| (p - q) / (2.0 * h)).collect();
                    let off: f64 = difference.iter().zip(slope).map(|(d, s)| (d - s).powi(2)).sum();
                    let size: f64 = difference.iter().map(|d| d * d).sum();
                    // Where a play reverses, a difference is no derivative.
                    let most = if row.name.contains("bouc") || row.name == "dahl" { 1e-8 } else { 1e-4 };
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
            let (basis, steps) = (operator("prandtl-ishlinskii", 30.0), (20, Intersample::Driven(driver)));
            let mut weights = vec![0.0; basis.len()];
            weights[0] = gain * direct;
            let model = FeedbackModel::new(ts, steps, modes, 1.0, (basis, weights)).unwrap();
            let model = model.with_direct([0.0, 0.0137], 0.0).unwrap().with_curve(curve).unwrap();
            let run = model.with_creep(lags.to_vec()).unwrap().sensing_vibration().simulate(&u);
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
        let steps = (20, Intersample::BandLimited);
        let model = FeedbackModel::new(1.0 / 750.0, steps, vec![mode], 0.0, (basis.into(), vec![0.0, 1.0])).unwrap();
        let modelled = model.simulate(u);
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
