//! Feed-forward sample by sample: reference in, voltage out, with a given delay.
//!
//! ```text
//! u_t = H^-1 (C^-1 (sum over k of f_k (r_{t-k} - offset)))        the displacement follows r_{t-d}
//! ```
//! It uses the same inverses as [`super::FeedForward`]. The filter gets its preview of d samples from the delay.
//! There are no iterations, voltages are clipped to the limits, and a reference that is not finite is replaced by the
//! previous one. A step does not allocate for states of up to 256 numbers. It takes the same number of operations in
//! every sample, except for the search of the hysteresis inverse (at most 120 trials).

use super::{FeedForward, FeedForwardSettings, FirDesign, Preview};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;

/// Reference [output unit] to voltage [input unit].
///
/// State: the last input; the last references, newest first; the state of the model.
///
/// ```
/// use piezoid::compensation::{Causal, FeedForwardSettings};
/// use piezoid::{Model, System, hysteresis::Operator, linear::Arx};
/// let block = Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8])?;
/// let model = Model::new((Operator::find("prandtl-ishlinskii")?.example)(5e-4)?, block, 2.0)?;
/// let inverse = Causal::new(&model, FeedForwardSettings::default(), 4)?;
/// let r: Vec<f64> = (0..2000).map(|t| 300.0 * (0.03 * f64::from(t)).sin()).collect();
/// let u = inverse.resume(&mut inverse.settled(0.0), &r);
/// let y = model.resume(&mut model.settled(u[0]), &u);
/// let worst = y[4..].iter().zip(&r).skip(100).map(|(y, r)| (y - r).abs()).fold(0.0, f64::max);
/// assert!(worst < 2.0, "{worst}");
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Causal {
    pub(super) inverse: FeedForward,
}

/// Length of the state before the references.
const BEFORE: usize = 1;

impl Causal {
    /// Largest delay [samples]: the filter then has the largest number of taps.
    pub const MAX_DELAY_SAMPLES: usize = 488;

    /// The inverse of `model` with a delay of `delay_samples` samples. The settings for whole records are ignored.
    ///
    /// # Errors
    /// The errors of [`FeedForward::new`]; [`Error::Unsuited`] for mechanics with hysteresis in feedback.
    pub fn new(model: &Model, settings: FeedForwardSettings, delay_samples: usize) -> Result<Self, Error> {
        if delay_samples > Causal::MAX_DELAY_SAMPLES {
            let rule = format!("must be at most {} samples", Causal::MAX_DELAY_SAMPLES);
            return Err(Error::parameter("delay_samples", delay_samples, rule));
        }
        if model.feedback().is_some() {
            let because =
                "its hysteresis is in feedback, and only whole references have an inverse: compensate them, or \
                           identify hysteresis first, mechanics after"
                    .into();
            return Err(Error::Unsuited { what: "inverse sample by sample".into(), because });
        }
        let settings = FeedForwardSettings { clip: true, ..settings };
        Ok(Causal { inverse: FeedForward::with(model, settings, FirDesign::delayed(delay_samples))? })
    }

    /// Delay from the reference to the displacement [samples].
    pub fn delay_samples(&self) -> usize {
        self.inverse.preview().fir().ahead()
    }

    /// The inverse of the linear block.
    pub fn preview(&self) -> &Preview {
        self.inverse.preview()
    }

    /// The output of the model at rest [output unit].
    pub(super) fn resting(&self) -> f64 {
        let model = self.inverse.model();
        model.offset() + model.linear().dc_gain() * model.step_before_linear(&mut model.initial(), 0.0)
    }

    /// The settled state at `r`, with the references `known` (the first of them `r`) already in the filter: the next
    /// step takes the reference after them. With a preview as long as the delay, the reference is followed without
    /// delay.
    pub fn settled_with_preview(&self, r: f64, known: &[f64]) -> Vec<f64> {
        let mut x = self.settled(r);
        let past = &mut x[BEFORE..BEFORE + self.preview().fir().order()];
        past.iter_mut().zip(known.iter().rev()).for_each(|(past, r)| *past = *r);
        x
    }

    fn state(&self, u: f64, r: f64, model: Vec<f64>) -> Vec<f64> {
        let mut x = vec![r; BEFORE + self.preview().fir().order()];
        x[0] = u;
        x.extend(model);
        x
    }
}

impl System for Causal {
    fn ts(&self) -> f64 {
        self.inverse.model().ts()
    }

    fn order(&self) -> usize {
        BEFORE + self.preview().fir().order() + self.inverse.model().order()
    }

    fn initial(&self) -> Vec<f64> {
        self.state(0.0, self.resting(), self.inverse.model().initial())
    }

    /// The settled state at the reference `r` [output unit], or at the nearest value within reach.
    fn settled(&self, r: f64) -> Vec<f64> {
        let model = self.inverse.model();
        let u = model.static_input(r, self.inverse.ends);
        self.state(u, r, model.settled(u))
    }

    fn step(&self, x: &mut [f64], r: f64) -> f64 {
        let fir = self.preview().fir();
        let (before, x) = x.split_at_mut(BEFORE);
        let (past, model) = x.split_at_mut(fir.order());
        // The static gain of the filter is 1 / G(0), which therefore also applies to the offset.
        let block = self.inverse.model();
        let r = if r.is_finite() { r } else { past.first().copied().unwrap_or_default() };
        let z = fir.step(past, r) - block.offset() / block.linear().dc_gain();
        before[0] = block.invert_before_linear(model, z, self.inverse.from(before[0])).u;
        before[0]
    }
}
