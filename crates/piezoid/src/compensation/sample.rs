//! Feed-forward sample by sample: reference in, voltage out, a stated number of samples late.
//!
//! ```text
//! u_t = H^-1 (C^-1 (sum over k of f_k (r_{t-k} - offset)))        the displacement then follows r_{t-d}
//! ```
//! The same inverses as [`super::FeedForward`], but the filter sees d samples ahead only because it is that late, nothing is
//! corrected afterwards, what the limits do not allow is clipped, and a reference that is not finite counts as the one
//! before. A step allocates nothing for states of up to 256 numbers and takes as many operations every time, but for the
//! trials of the hysteresis, of which there are 120 at most.

use super::{FeedForward, FeedForwardSettings, FirDesign, Preview};
use crate::error::Error;
use crate::hammerstein::Model;
use crate::system::System;

/// Reference [output unit] to voltage [input unit].
///
/// State: the input before; the last references, newest first; then the state of the model.
///
/// ```
/// use piezoid::compensation::{Causal, FeedForwardSettings};
/// use piezoid::{Model, System, hysteresis::Operator, linear::Arx};
/// let block = Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8])?;
/// let model = Model::new((Operator::find("prandtl-ishlinskii")?.example)(5e-4)?, block, 2.0)?;
/// let late = Causal::new(&model, FeedForwardSettings::default(), 4)?;
/// let r: Vec<f64> = (0..2000).map(|t| 300.0 * (0.03 * f64::from(t)).sin()).collect();
/// let u = late.resume(&mut late.settled(0.0), &r);
/// let y = model.resume(&mut model.settled(u[0]), &u);
/// let worst = y[4..].iter().zip(&r).skip(100).map(|(y, r)| (y - r).abs()).fold(0.0, f64::max);
/// assert!(worst < 2.0, "{worst}");
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Causal {
    pub(super) inverse: FeedForward,
}

/// Numbers of the state before the references.
const BEFORE: usize = 1;

impl Causal {
    /// The latest: with it the filter has as many taps as can be solved for.
    pub const LATEST: usize = 488;

    /// The inverse of `model` that is `late` samples late; settings of `settings` for whole records do not count.
    ///
    /// # Errors
    /// As [`FeedForward::new`].
    pub fn new(model: &Model, settings: FeedForwardSettings, late: usize) -> Result<Self, Error> {
        if late > Causal::LATEST {
            return Err(Error::parameter("late", late, format!("must be at most {} samples", Causal::LATEST)));
        }
        let settings = FeedForwardSettings { clip: true, preview: Some(FirDesign::late(late)), ..settings };
        Ok(Causal { inverse: FeedForward::new(model, settings)? })
    }

    /// Samples by which the displacement follows the reference late.
    pub fn late(&self) -> usize {
        self.inverse.preview().fir().ahead()
    }

    /// The inverse of the linear block.
    pub fn preview(&self) -> &Preview {
        self.inverse.preview()
    }

    /// The reference that the model answers at rest [output unit].
    pub(super) fn resting(&self) -> f64 {
        let model = self.inverse.model();
        model.offset() + model.linear().dc_gain() * model.step_before_linear(&mut model.initial(), 0.0)
    }

    /// The state after `r` has stood for long, where `known`, of which `r` is the first if there is any, is told beforehand: a
    /// step then takes the reference that follows. So known as many samples ahead as it is late, a reference is met in time.
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

    /// The state after the reference `r` [output unit], or the nearest within reach, has stood for long.
    fn settled(&self, r: f64) -> Vec<f64> {
        let model = self.inverse.model();
        let u = model.static_input(r, self.inverse.ends);
        self.state(u, r, model.settled(u))
    }

    fn step(&self, x: &mut [f64], r: f64) -> f64 {
        let fir = self.preview().fir();
        let (before, x) = x.split_at_mut(BEFORE);
        let (past, model) = x.split_at_mut(fir.order());
        // The filter keeps what is constant by 1 / G(0): so does the offset.
        let block = self.inverse.model();
        let r = if r.is_finite() { r } else { past.first().copied().unwrap_or_default() };
        let wanted = fir.step(past, r) - block.offset() / block.linear().dc_gain();
        before[0] = block.invert_before_linear(model, wanted, self.inverse.from(before[0])).u;
        before[0]
    }
}
