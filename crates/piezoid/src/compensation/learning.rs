//! Iterative learning: a periodic reference tried on the actuator itself, each trial corrected by the one before.
//!
//! ```text
//! z_{j+1} = z_0 + Q (z_j - z_0 + k F (r - y_j)),    u_j = H^-1 z_j,    z_0 = F r
//! ```
//! What is corrected is z, not u: through the inverse hysteresis an error is answered with the slope it meets. F is the
//! inverse of the linear block that looks ahead; Q is 1, or when asked a low-pass without phase, 1 / (1 + (f / f_q)^8), above
//! which the feed-forward z_0 stays as it is. All go harmonic by harmonic. Where |1 - k G_true F| < 1 errors shrink from trial
//! to trial, whatever their cause, creep and a wrong operator included. Harmonics disturb each other through the
//! hysteresis, so a trial may be worse than the one before and the way still right. But one twice as bad as the best is taken
//! back, and where three in a row are no better than it F is wrong somewhere, near a resonance that lies elsewhere than the
//! model has it: harmonics whose error has grown are from then on answered by the change of z over the change of error
//! that they showed. What is returned is the best trial.
//!
//! Reference: D. A. Bristow, M. Tharayil & A. G. Alleyne, IEEE Control Syst. Mag. 26, 96 (2006), DOI
//! 10.1109/MCS.2006.1636313; K. K. Leang & S. Devasia, Mechatronics 16, 141 (2006), DOI 10.1016/j.mechatronics.2005.11.006
//! (hysteresis). It does not do: references that do not repeat, and what does not repeat with them.

use super::{FeedForward, FeedForwardSettings};
use crate::creep::Creep;
use crate::error::{Error, finite, positive};
use crate::fourier::forward;
use crate::system::System;
use nalgebra::Complex;

/// How many times as bad as the best a trial must be to be taken back.
const LOST: f64 = 2.0;

/// Trials in a row that are no better than the best, after which harmonics are answered by what they did.
const STUCK: usize = 3;

/// Trials in a row over which the error of such a harmonic has then grown.
const GROWS: usize = 2;

/// Its least share of the sum of squares: below, noise grows and shrinks.
const MATTERS: f64 = 1e-3;

/// How many times as far as by the model it may then be answered.
const FURTHER: f64 = 3.0;

/// How trials are corrected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Learning {
    /// Trials in all.
    pub trials: usize,
    /// Gain k of the correction, above 0 up to 1 [-].
    pub gain: f64,
    /// Corner f_q of Q [Hz]; if not given, all that is sampled is learnt.
    pub cutoff_hz: Option<f64>,
}

impl Default for Learning {
    /// Eleven trials: the first is the feed-forward.
    fn default() -> Self {
        Learning { trials: 11, gain: 0.8, cutoff_hz: None }
    }
}

/// What was learnt.
#[derive(Debug, Clone, PartialEq)]
pub struct Learned {
    /// One period of the best voltage [input unit].
    pub u: Vec<f64>,
    /// What the actuator answered to it [output unit].
    pub y: Vec<f64>,
    /// Rms of what each trial left of the reference [output unit].
    pub rms: Vec<f64>,
}

impl Learning {
    /// Learns the voltage for one period of a reference `r` [output unit], beginning with the feed-forward `inverse`. `plant` is
    /// given one period of the voltage and answers with one period of the displacement, both repeated until they repeat. Trials
    /// after the first are clipped to the limits.
    ///
    /// ```
    /// use piezoid::compensation::{FeedForward, FeedForwardSettings, Learning};
    /// use piezoid::{Model, System, hysteresis::Operator, linear::Arx};
    /// use std::sync::Arc;
    /// let with_gain = |k: f64| Model::new((Operator::find("prandtl-ishlinskii")?.example)(1e-3)?, Arx::new(1e-3, vec![0.5], vec![k])?, 0.0);
    /// let (model, actuator) = (with_gain(10.0)?, with_gain(13.0)?);
    /// let r: Vec<f64> = (0..50).map(|t| 300.0 * (std::f64::consts::TAU * 0.02 * f64::from(t)).sin()).collect();
    /// let mut plant = |u: &[f64]| actuator.simulate(&[u, u, u].concat())[100..].to_vec();
    /// let learned = Learning::default().run(&mut plant, &FeedForward::new(&model, FeedForwardSettings::default())?, &r)?;
    /// assert!(learned.rms[0] > 50.0 && learned.rms[10] < 0.01);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`FeedForward::whole`]; settings that make no sense; answers of another length or that are not finite.
    pub fn run(
        &self,
        plant: &mut dyn FnMut(&[f64]) -> Vec<f64>,
        inverse: &FeedForward,
        r: &[f64],
    ) -> Result<Learned, Error> {
        finite("reference", r)?;
        if r.is_empty() || self.trials == 0 {
            return Err(Error::parameter("trials", self.trials, "must be at least 1, of a reference with samples"));
        }
        if !(self.gain > 0.0 && self.gain <= 1.0) {
            return Err(Error::parameter("gain", self.gain, "must be above 0, and 1 at most"));
        }
        // Creep repeats with the rest: what it adds is learnt.
        let model = inverse.model.clone().with_creep(Creep::new(inverse.model.ts(), Vec::new())?)?;
        let mut inverse = FeedForward::new(&model, FeedForwardSettings { sweeps: 0, ..inverse.settings })?;
        let wanted: Vec<f64> = r.iter().map(|r| r - model.offset()).collect();
        let mut harmonics = Harmonics::new(&inverse, &wanted, *self)?;
        let mut best: Option<LearningTrial> = None;
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
            let left = super::off(r, &y);
            rms.push(left);
            harmonics.correct(&r.iter().zip(&y).map(|(r, y)| r - y).collect::<Vec<_>>());
            best = best.filter(|best| best.left <= left).or(Some(LearningTrial { u, y, left }));
        }
        let (u, y) = best.map(|best| (best.u, best.y)).unwrap_or_default();
        Ok(Learned { u, y, rms })
    }
}

/// One period of a trial, and the rms of what it left.
struct LearningTrial {
    u: Vec<f64>,
    y: Vec<f64>,
    left: f64,
}

impl FeedForward {
    /// The input that repeats with `z`, which the reference `r` asks for.
    fn period(&self, z: &[f64], r: &[f64]) -> Result<Vec<f64>, Error> {
        let start = self.model.static_input_before_linear(z[0], self.ends);
        let twice = self.invert_path(&[z, z].concat(), start.u);
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
    /// F, and what now stands for k F.
    inverse: Vec<Complex<f64>>,
    answer: Vec<Complex<f64>>,
    /// Q.
    kept: Vec<f64>,
    /// z of the feed-forward and of the next trial.
    first: Vec<Complex<f64>>,
    z: Vec<Complex<f64>>,
    /// z and error of the trials since which an error grows.
    growing: Vec<Vec<[Complex<f64>; 2]>>,
    /// z and error of the best trial, and the trials since.
    best: (Vec<Complex<f64>>, Vec<Complex<f64>>),
    since: usize,
    gain: f64,
}

impl Harmonics {
    fn new(inverse: &FeedForward, wanted: &[f64], settings: Learning) -> Result<Self, Error> {
        let period = wanted.len() as f64 * inverse.model.ts();
        let cutoff = positive("cutoff", settings.cutoff_hz.unwrap_or(f64::MAX), "hertz")?;
        let hz = |k: usize| k as f64 / period;
        let response = |k: usize| {
            let f = inverse.preview().fir().response(hz(k));
            Complex::from_polar(f.gain, f.phase)
        };
        let inverse: Vec<_> = (0..=wanted.len() / 2).map(response).collect();
        let z: Vec<_> = lines(wanted).iter().zip(&inverse).map(|(r, f)| r * f).collect();
        Ok(Harmonics {
            n: wanted.len(),
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
        let fft = forward(self.n);
        // The forward transform of the conjugate is the way back.
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
        let lost = all > LOST * LOST * least && self.since > 0;
        for (k, e) in error.into_iter().enumerate() {
            let (z, growing) = (self.z[k], &mut self.growing[k]);
            let best = [self.best.0[k], self.best.1[k]];
            if lost || growing.last().is_some_and(|[_, before]| e.norm() <= before.norm()) {
                growing.clear();
            }
            growing.push(if lost { best } else { [z, e] });
            let stuck = self.since >= STUCK && growing.len() > GROWS;
            let [z_then, e_then] = growing[0];
            if (lost || stuck) && e.norm() > e_then.norm() && e.norm_sqr() > MATTERS * all {
                let measured = self.gain * (z - z_then) / (e_then - e);
                let most = FURTHER * self.gain * self.inverse[k].norm();
                if measured.is_finite() {
                    self.answer[k] = measured * (most / measured.norm()).min(1.0);
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
    forward(x.len()).process(&mut lines);
    lines.truncate(x.len() / 2 + 1);
    lines
}
