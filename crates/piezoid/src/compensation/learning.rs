//! Iterative learning: a periodic reference tried on the actuator itself, each trial corrected by the one before.
//!
//! ```text
//! z_{j+1} = z_0 + Q (z_j - z_0 + k F (r - y_j)),    u_j = H^-1 z_j,    z_0 = F r
//! ```
//! What is corrected is z, not u: through the inverse hysteresis an error is answered with the slope it meets. F is the
//! inverse of the linear block that looks ahead, and around the end of the period to its beginning; Q is 1, or when asked a
//! low-pass without phase, 1 / (1 + (f / f_q)^8), above which the feed-forward z_0 stays as it is. Where |1 - k G_true F| < 1
//! errors shrink from trial to trial, whatever their cause, creep and a wrong operator included. Harmonics disturb each
//! other through the hysteresis, so a trial may be worse than the one before and the way still right; one twice as bad as
//! the best is taken back, and k halved. Near a zero of the beam, where F is no inverse, errors may grow after some tens of
//! trials: the best is kept.
//!
//! Reference: D. A. Bristow, M. Tharayil & A. G. Alleyne, IEEE Control Syst. Mag. 26, 96 (2006), DOI
//! 10.1109/MCS.2006.1636313; K. K. Leang & S. Devasia, Mechatronics 16, 141 (2006), DOI 10.1016/j.mechatronics.2005.11.006
//! (hysteresis). It does not do: references that do not repeat, and what does not repeat with them.

use super::{FeedForward, How};
use crate::creep::Creep;
use crate::error::{Error, finite};
use crate::fourier::forward;
use crate::system::System;
use nalgebra::Complex;

/// How many times as bad as the best a trial may be.
const WORSE: f64 = 2.0;

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

/// Learns the voltage for one period of a reference `r` [output unit], beginning with the feed-forward `inverse`. `plant` is
/// given one period of the voltage and answers with one period of the displacement, both repeated until they repeat. Trials
/// after the first are clipped to the limits.
///
/// ```
/// use piezoid::compensation::{FeedForward, How, Learning, learn};
/// use piezoid::{Model, System, hysteresis::operator, linear::Arx};
/// use std::sync::Arc;
/// let with_gain = |k: f64| Model::new((operator("prandtl-ishlinskii")?.example)(1e-3)?, Arx::new(1e-3, vec![0.5], vec![k])?, 0.0);
/// let (model, actuator) = (with_gain(10.0)?, with_gain(13.0)?);
/// let r: Vec<f64> = (0..50).map(|t| 300.0 * (std::f64::consts::TAU * 0.02 * f64::from(t)).sin()).collect();
/// let mut plant = |u: &[f64]| actuator.simulate(&[u, u, u].concat())[100..].to_vec();
/// let learned = learn(&mut plant, &FeedForward::new(&model, How::default())?, &r, Learning::default())?;
/// assert!(learned.rms[0] > 50.0 && learned.rms[10] < 0.01);
/// # Ok::<(), piezoid::Error>(())
/// ```
///
/// # Errors
/// As [`FeedForward::whole`]; settings that make no sense; answers of another length or that are not finite.
pub fn learn(
    plant: &mut dyn FnMut(&[f64]) -> Vec<f64>,
    inverse: &FeedForward,
    r: &[f64],
    how: Learning,
) -> Result<Learned, Error> {
    finite("reference", r)?;
    if r.is_empty() || how.trials == 0 {
        return Err(Error::parameter("trials", how.trials, "must be at least 1, of a reference with samples"));
    }
    if !(how.gain > 0.0 && how.gain <= 1.0) {
        return Err(Error::parameter("gain", how.gain, "must be above 0, and 1 at most"));
    }
    // Creep repeats with the rest: what it adds is learnt.
    let model = inverse.model.clone().with_creep(Creep::new(inverse.model.ts(), Vec::new())?)?;
    let mut inverse = FeedForward::new(&model, How { sweeps: 0, ..inverse.how })?;
    let low_pass = LowPass::new(r.len(), model.ts(), how.cutoff_hz.unwrap_or(f64::MAX))?;
    let fir = inverse.preview().fir().clone();
    let offset = model.offset();

    let mut gain = how.gain;
    let feed_forward = fir.periodic(&r.iter().map(|r| r - offset).collect::<Vec<_>>());
    let mut z = feed_forward.clone();
    let mut best: Option<Trial> = None;
    let mut rms: Vec<f64> = Vec::new();
    for _ in 0..how.trials {
        let u = inverse.period(&z, r)?;
        inverse.how.clip = true;
        let y = plant(&u);
        if y.len() != r.len() {
            let (left, right) = ("the answer of the plant".into(), "the reference".into());
            return Err(Error::Lengths { left, left_len: y.len(), right, right_len: r.len() });
        }
        finite("the answer of the plant", &y)?;
        let left = super::off(r, &y);
        rms.push(left);
        let trial = Trial { z, u, y, left };
        let from = match best {
            Some(ref best) if left > WORSE * best.left => {
                gain *= 0.5;
                best
            }
            _ => &trial,
        };
        let error: Vec<f64> = r.iter().zip(&from.y).map(|(r, y)| r - y).collect();
        let more = fir.periodic(&error);
        let learnt = from.z.iter().zip(&feed_forward).zip(&more).map(|((z, z_0), more)| z - z_0 + gain * more);
        z = low_pass.filtered(learnt).iter().zip(&feed_forward).map(|(learnt, z_0)| z_0 + learnt).collect();
        best = best.filter(|best| best.left <= left).or(Some(trial));
    }
    let (u, y) = best.map(|best| (best.u, best.y)).unwrap_or_default();
    Ok(Learned { u, y, rms })
}

/// One period of a trial, and the rms of what it left.
struct Trial {
    z: Vec<f64>,
    u: Vec<f64>,
    y: Vec<f64>,
    left: f64,
}

impl FeedForward {
    /// The input that repeats with `z`, which the reference `r` asks for.
    fn period(&self, z: &[f64], r: &[f64]) -> Result<Vec<f64>, Error> {
        let start = crate::hysteresis::between(self.ends, z[0], |u| self.model.settled_crept(u));
        let twice = self.back(&[z, z].concat(), start.u);
        match twice.missed.filter(|_| !self.how.clip) {
            Some(sample) => Err(self.unreachable(r, sample % r.len())),
            None => {
                let u = &twice.u[r.len()..];
                if !self.how.clip {
                    self.how.limits.refuse(u, self.model.ts())?;
                }
                Ok(u.to_vec())
            }
        }
    }
}

/// Q over one period.
struct LowPass {
    gains: Vec<f64>,
}

impl LowPass {
    fn new(n: usize, ts: f64, cutoff: f64) -> Result<Self, Error> {
        crate::error::positive("cutoff", cutoff, "hertz")?;
        let gain = |k: usize| 1.0 / (1.0 + (k.min(n - k) as f64 / (n as f64 * ts) / cutoff).powi(8));
        Ok(LowPass { gains: (0..n).map(gain).collect() })
    }

    fn filtered(&self, x: impl Iterator<Item = f64>) -> Vec<f64> {
        let n = self.gains.len();
        let fft = forward(n);
        let mut lines: Vec<Complex<f64>> = x.map(Complex::from).collect();
        fft.process(&mut lines);
        // The forward transform of the conjugate is the way back.
        lines.iter_mut().zip(&self.gains).for_each(|(line, gain)| *line = line.conj() * *gain / n as f64);
        fft.process(&mut lines);
        lines.iter().map(|c| c.re).collect()
    }
}
