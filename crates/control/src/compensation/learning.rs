//! Iterative learning control: a periodic reference is tried on the actuator, and each trial is corrected by the one
//! before.
//!
//! ```text
//! z_{j+1} = z_0 + Q (z_j - z_0 + k F (r - y_j)),    u_j = H^-1 z_j,    z_0 = F r
//! ```
//! The correction applies to z, not to u: the inverse hysteresis then uses the local slope. F is the inverse of the
//! linear block with preview. Q is 1, or a zero-phase low-pass 1 / (1 + (f / f_q)^8) if requested; above its corner the
//! feed-forward z_0 does not change. All computations are per harmonic. Where |1 - k G_true F| < 1, errors fall from
//! trial to trial for every cause, also for creep and a wrong operator. Harmonics are coupled by the hysteresis, so a
//! single trial may be worse than the one before. A trial with twice the error of the best one is discarded. After
//! three trials in a row without improvement F must be wrong at some frequency, usually near a resonance that differs
//! from the model. The harmonics whose error has grown then use the measured ratio of the change of z to the change of
//! error. The result is the best trial.
//!
//! Reference: D. A. Bristow, M. Tharayil & A. G. Alleyne, IEEE Control Syst. Mag. 26, 96 (2006), DOI
//! 10.1109/MCS.2006.1636313; K. K. Leang & S. Devasia, Mechatronics 16, 141 (2006), DOI
//! 10.1016/j.mechatronics.2005.11.006 (hysteresis). It does not do: references that are not periodic, disturbances that
//! are not periodic with them.
//!
//! Why: docs/decisions/compensation.md, "Learning corrects z, from the latest trial".

use super::{FeedForward, FeedForwardSettings};
use nalgebra::Complex;
use piezoid_models::creep::Creep;
use piezoid_models::hammerstein::InitialCondition;
use piezoid_numerics::complex::modulus;
use piezoid_numerics::error::{Error, finite, positive};
use piezoid_numerics::fourier::Transform;
use piezoid_numerics::system::System;

/// A trial is discarded above this many times the error of the best one.
const MAX_ERROR_RATIO: f64 = 2.0;

/// Number of trials in a row without improvement after which measured responses are used.
const MAX_TRIALS_WITHOUT_GAIN: usize = 3;

/// Number of trials in a row over which the error of such a harmonic has grown.
const GROWTH_TRIALS: usize = 2;

/// Smallest share of such a harmonic in the sum of squares; smaller ones are noise.
const MIN_HARMONIC_SHARE: f64 = 1e-3;

/// Largest measured response, relative to that of the model.
const MAX_RESPONSE_RATIO: f64 = 3.0;

/// Settings of the learning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Learning {
    /// Number of trials.
    pub trials: usize,
    /// Gain k of the correction, above 0 up to 1 [-].
    pub gain: f64,
    /// Corner f_q of Q [Hz]; if not given, Q is 1.
    pub cutoff_hz: Option<f64>,
}

impl Default for Learning {
    /// Eleven trials; the first is the feed-forward.
    fn default() -> Self {
        Learning { trials: 11, gain: 0.8, cutoff_hz: None }
    }
}

/// Result of the learning.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned {
    /// One period of the best voltage [input unit].
    pub u: Vec<f64>,
    /// The response of the actuator to it [output unit].
    pub y: Vec<f64>,
    /// Rms error of each trial [output unit].
    pub rms: Vec<f64>,
}

impl Learning {
    /// Learns the voltage for one period of a reference `r` [output unit], starting with the feed-forward `inverse`.
    /// `plant` gets one period of the voltage and returns one period of the displacement in steady state. Trials after
    /// the first are clipped to the limits.
    ///
    /// ```
    /// use piezoid::compensation::{FeedForward, FeedForwardSettings, Learning};
    /// use piezoid::{Model, System, hysteresis::Operator, linear::Arx};
    /// use std::sync::Arc;
    /// let plays = (Operator::find("prandtl-ishlinskii")?.example)(1e-3)?;
    /// let with_gain = |k: f64| Model::new(plays.clone(), Arx::new(1e-3, vec![0.5], vec![k])?, 0.0);
    /// let (model, actuator) = (with_gain(10.0)?, with_gain(13.0)?);
    /// let r: Vec<f64> = (0..50).map(|t| 300.0 * (std::f64::consts::TAU * 0.02 * f64::from(t)).sin()).collect();
    /// let mut plant = |u: &[f64]| actuator.simulate(&[u, u, u].concat())[100..].to_vec();
    /// let inverse = FeedForward::new(&model, FeedForwardSettings::default())?;
    /// let learned = Learning::default().run(&mut plant, &inverse, &r)?;
    /// assert!(learned.rms[0] > 50.0 && learned.rms[10] < 0.01);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`FeedForward::whole`]; errors for invalid settings, and for responses of another length or that
    /// are not finite.
    pub fn run(
        &self,
        plant: &mut dyn FnMut(&[f64]) -> Vec<f64>,
        inverse: &FeedForward,
        r: &[f64],
    ) -> Result<Learned, Error> {
        finite("reference", r)?;
        if r.is_empty() || self.trials == 0 {
            return Err(Error::parameter("trials", self.trials, "must be at least 1, for a non-empty reference"));
        }
        if !(self.gain > 0.0 && self.gain <= 1.0) {
            return Err(Error::parameter("gain", self.gain, "must be above 0, and 1 at most"));
        }
        // Creep is periodic too, so its contribution is learnt.
        let model = inverse.model.clone().with_creep(Creep::new(inverse.model.ts(), Vec::new())?)?;
        let mut inverse = FeedForward::new(&model, FeedForwardSettings { iterations: 0, ..inverse.settings })?;
        let target: Vec<f64> = r.iter().map(|r| r - model.offset()).collect();
        let mut harmonics = Harmonics::new(&inverse, &target, *self)?;
        let mut best: Option<(f64, Vec<f64>, Vec<f64>)> = None;
        let mut rms: Vec<f64> = Vec::new();
        for _ in 0..self.trials {
            let u = inverse.period(&harmonics.whole(), r)?;
            inverse.settings.clip = true;
            let y = plant(&u);
            if y.len() != r.len() {
                let (left, right) = ("the answer of the plant".into(), "the reference".into());
                return Err(Error::Lengths { left, left_len: y.len(), right, right_len: r.len() });
            }
            finite("the answer of the plant", &y)?;
            let error = super::rms_error(r, &y);
            rms.push(error);
            harmonics.correct(&r.iter().zip(&y).map(|(r, y)| r - y).collect::<Vec<_>>());
            best = best.filter(|best| best.0 <= error).or(Some((error, u, y)));
        }
        let (_, u, y) = best.unwrap_or_default();
        Ok(Learned { u, y, rms })
    }
}

impl FeedForward {
    /// One period of the input for the periodic `z` of the reference `r`.
    fn period(&self, z: &[f64], r: &[f64]) -> Result<Vec<f64>, Error> {
        let start = self.model.static_input_before_linear(z[0], self.ends);
        let twice = self.invert_path(&[z, z].concat(), InitialCondition::Settled, start.u);
        match twice.missed.filter(|_| !self.settings.clip) {
            Some(sample) => Err(self.unreachable(r, sample % r.len())),
            None => {
                let u = &twice.u[r.len()..];
                if !self.settings.clip {
                    self.settings.limits.refuse(u, self.model.ts())?;
                }
                Ok(u.to_vec())
            }
        }
    }
}

/// z by its harmonics, up to half the sampling rate.
struct Harmonics {
    /// Samples of a period.
    n: usize,
    /// F, and the present estimate of k F.
    inverse: Vec<Complex<f64>>,
    answer: Vec<Complex<f64>>,
    /// Q.
    kept: Vec<f64>,
    /// z of the feed-forward and of the next trial.
    first: Vec<Complex<f64>>,
    z: Vec<Complex<f64>>,
    /// z and error of the trials since which the error has grown.
    growing: Vec<Vec<[Complex<f64>; 2]>>,
    /// z and error of the best trial, and the trials since.
    best: (Vec<Complex<f64>>, Vec<Complex<f64>>),
    since: usize,
    gain: f64,
}

impl Harmonics {
    fn new(inverse: &FeedForward, target: &[f64], settings: Learning) -> Result<Self, Error> {
        let period = target.len() as f64 * inverse.model.ts();
        let cutoff = positive("cutoff", settings.cutoff_hz.unwrap_or(f64::MAX), "hertz")?;
        let hz = |k: usize| k as f64 / period;
        let inverse: Vec<_> = (0..=target.len() / 2).map(|k| inverse.preview().response(hz(k))).collect();
        let z: Vec<_> = lines(target).iter().zip(&inverse).map(|(r, f)| r * f).collect();
        Ok(Harmonics {
            n: target.len(),
            answer: inverse.iter().map(|f| f * settings.gain).collect(),
            kept: (0..z.len()).map(|k| 1.0 / (1.0 + (hz(k) / cutoff).powi(8))).collect(),
            inverse,
            first: z.clone(),
            growing: vec![Vec::new(); z.len()],
            z,
            best: Default::default(),
            since: 0,
            gain: settings.gain,
        })
    }

    /// One period of z.
    fn whole(&self) -> Vec<f64> {
        let fft = Transform::new(self.n);
        // The inverse transform by the forward transform of the conjugate.
        let line = |k: usize| if k < self.z.len() { self.z[k].conj() } else { self.z[self.n - k] };
        let mut all: Vec<_> = (0..self.n).map(line).collect();
        fft.process(&mut all);
        all.iter().map(|x| x.re / self.n as f64).collect()
    }

    /// Corrects z by the error of its trial.
    fn correct(&mut self, error: &[f64]) {
        let error = lines(error);
        let squares = |error: &[Complex<f64>]| error.iter().map(|e| e.norm_sqr()).sum::<f64>();
        let (all, least) = (squares(&error), squares(&self.best.1));
        self.since += 1;
        if self.best.1.is_empty() || all < least {
            (self.best, self.since) = ((self.z.clone(), error.clone()), 0);
        }
        let lost = all > MAX_ERROR_RATIO * MAX_ERROR_RATIO * least && self.since > 0;
        for (k, e) in error.into_iter().enumerate() {
            let (z, growing) = (self.z[k], &mut self.growing[k]);
            let best = [self.best.0[k], self.best.1[k]];
            if lost || growing.last().is_some_and(|[_, before]| modulus(e) <= modulus(*before)) {
                growing.clear();
            }
            growing.push(if lost { best } else { [z, e] });
            let stuck = self.since >= MAX_TRIALS_WITHOUT_GAIN && growing.len() > GROWTH_TRIALS;
            let [z_then, e_then] = growing[0];
            if (lost || stuck) && modulus(e) > modulus(e_then) && e.norm_sqr() > MIN_HARMONIC_SHARE * all {
                let measured = self.gain * (z - z_then) / (e_then - e);
                let most = MAX_RESPONSE_RATIO * self.gain * modulus(self.inverse[k]);
                if measured.is_finite() {
                    self.answer[k] = measured * (most / modulus(measured)).min(1.0);
                }
                growing.clear();
            }
            let [z, e] = if lost { best } else { [z, e] };
            self.z[k] = self.first[k] + self.kept[k] * (z - self.first[k] + self.answer[k] * e);
        }
    }
}

/// The lines of a period up to half the sampling rate.
fn lines(x: &[f64]) -> Vec<Complex<f64>> {
    let mut lines: Vec<Complex<f64>> = x.iter().map(|x| Complex::from(*x)).collect();
    Transform::new(x.len()).process(&mut lines);
    lines.truncate(x.len() / 2 + 1);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    /// Two harmonics with z of 4 and 1, F of 2, k of a half; Q is 1 and a half.
    fn harmonics() -> Harmonics {
        let z = [4.0, 1.0].map(Complex::from).to_vec();
        Harmonics {
            n: 2,
            inverse: vec![Complex::from(2.0); 2],
            answer: vec![Complex::from(1.0); 2],
            kept: vec![1.0, 0.5],
            first: z.clone(),
            z,
            growing: vec![Vec::new(); 2],
            best: Default::default(),
            since: 0,
            gain: 0.5,
        }
    }

    /// Asserts z and the response of both harmonics after a trial with these errors.
    #[track_caller]
    fn assert_corrected(harmonics: &mut Harmonics, [a, b]: [f64; 2], z: [f64; 2], answer: [f64; 2]) {
        harmonics.correct(&[0.5 * (a + b), 0.5 * (a - b)]);
        let real = |lines: &[Complex<f64>]| lines.iter().map(|line| line.re).collect::<Vec<_>>();
        assert_close(&real(&harmonics.z), &z, 1e-12, 0.0);
        assert_close(&real(&harmonics.answer), &answer, 1e-12, 0.0);
    }

    #[test]
    fn after_three_trials_without_gain_a_growing_error_is_corrected_by_the_measured_response() {
        let h = &mut harmonics();
        assert_corrected(h, [2.0, 0.05], [6.0, 1.025], [1.0; 2]);
        assert_corrected(h, [3.0, 0.06], [9.0, 1.0425], [1.0; 2]);
        assert_corrected(h, [3.5, 0.07], [12.5, 1.05625], [1.0; 2]);
        // z has grown by 8.5 and the error by 1.9. The second harmonic is too small to count.
        let measured = 0.5 * 8.5 / -1.9;
        assert_corrected(h, [3.9, 0.08], [12.5 + 3.9 * measured, 1.068125], [measured, 1.0]);
        // More than twice the error of the first trial, which is taken up again.
        let again = 0.5 * (8.5 + 3.9 * measured) / -2.2;
        assert_corrected(h, [4.2, 0.09], [4.0 + 2.0 * again, 1.025], [again, 1.0]);
    }

    #[test]
    fn an_error_that_falls_once_begins_to_grow_anew_and_measured_responses_have_a_limit() {
        let h = &mut harmonics();
        assert_corrected(h, [2.0, 0.05], [6.0, 1.025], [1.0; 2]);
        assert_corrected(h, [3.0, 0.055], [9.0, 1.04], [1.0; 2]);
        assert_corrected(h, [2.5, 0.06], [11.5, 1.05], [1.0; 2]);
        assert_corrected(h, [2.6, 0.065], [14.1, 1.0575], [1.0; 2]);
        // z has grown by 5.1 and the error by 0.2, which is a response of -12.75: three times that of the model counts.
        assert_corrected(h, [2.7, 0.07], [14.1 - 3.0 * 2.7, 1.06375], [-3.0, 1.0]);
    }
}
