//! Feed-forward sample by sample: reference in, voltage out, with a given delay.
//!
//! ```text
//! u_t = H^-1 (C^-1 (F (r - offset)))        the displacement follows r_{t-d}
//! ```
//! It uses the same inverses as [`super::FeedForward`]: for the blocks in series a filter that gets its preview of d
//! samples from the delay, for mechanics with hysteresis in feedback their own (`flat`), which needs at least five.
//! There are no iterations, voltages are clipped to the limits, and a reference that is not finite is replaced by the
//! previous one. A step does not allocate for states of up to 256 numbers. It takes the same number of operations in
//! every sample, except for the search of the hysteresis inverse (at most 120 trials).

use super::flat::Flat;
use super::{FeedForward, FeedForwardSettings, FirDesign, Preview};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::is_measurable;
use piezoid_numerics::system::System;
use std::ops::RangeInclusive;

/// Reference [output unit] to voltage [input unit].
///
/// State: the last input; then, for blocks in series, that of the filter and that of the model;
/// for mechanics with hysteresis in feedback the state of their inverse.
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
    pub(super) law: Law,
}

/// What it inverts.
#[derive(Debug, Clone)]
pub(super) enum Law {
    Series,
    Feedback(Box<Flat>),
}

/// Length of the state before that of the law.
const BEFORE: usize = 1;

impl Causal {
    /// Largest delay of blocks in series [samples]: the filter then has the largest number of taps.
    const MAX_DELAY_SAMPLES: usize = 488;

    /// The delays that the inverse of `model` can have [samples]. Blocks in series have an inverse without delay, which
    /// a delay makes better; mechanics with hysteresis in feedback need a preview of five samples, and the delay of
    /// their sensor.
    pub fn delays(model: &Model) -> RangeInclusive<usize> {
        let least = model.feedback().map_or(0, Flat::least_delay);
        least..=least.max(Causal::MAX_DELAY_SAMPLES)
    }

    /// The inverse of `model` with a delay of `delay_samples` samples. The settings for whole records are ignored.
    ///
    /// # Errors
    /// An error for a delay that is none of [`Causal::delays`]; the errors of [`FeedForward::new`];
    /// [`Error::Unsuited`] for mechanics with hysteresis in feedback that have no inverse, because the input acts on
    /// modes and hysteresis.
    pub fn new(model: &Model, settings: FeedForwardSettings, delay_samples: usize) -> Result<Self, Error> {
        Causal::delayed(model, settings, ("delay_samples", delay_samples))
    }

    /// The same with the delay that the option of this name states.
    ///
    /// # Errors
    /// Those of [`Causal::new`]; for the delay it names the option.
    pub fn delayed(
        model: &Model,
        settings: FeedForwardSettings,
        (option, delay_samples): (&str, usize),
    ) -> Result<Self, Error> {
        let delays = Causal::delays(model);
        let (least, most) = (delays.start(), delays.end());
        if delay_samples > *most {
            return Err(Error::parameter(option, delay_samples, format!("must be at most {most} samples")));
        }
        if delay_samples < *least {
            let rule = format!(
                "must be at least {least} samples: the inverse of mechanics with hysteresis in feedback needs the \
                 reference so far in advance"
            );
            return Err(Error::parameter(option, delay_samples, rule));
        }
        let settings = FeedForwardSettings { clip: true, ..settings };
        let Some(feedback) = model.feedback() else {
            let inverse = FeedForward::with(model, settings, FirDesign::delayed(delay_samples))?;
            return Ok(Causal { inverse, law: Law::Series });
        };
        let inverse = FeedForward::with(model, settings, FirDesign::delayed(0))?;
        let none = || {
            let because = "its hysteresis is in feedback, and its input acts on modes and hysteresis, or on neither: \
                           compensate whole references, or identify hysteresis first, mechanics after"
                .into();
            Error::Unsuited { what: "inverse sample by sample".into(), because }
        };
        let flat = Flat::new(feedback, inverse.ends, delay_samples).ok_or_else(none)?;
        Ok(Causal { inverse, law: Law::Feedback(Box::new(flat)) })
    }

    /// Delay from the reference to the displacement [samples].
    pub fn delay_samples(&self) -> usize {
        match &self.law {
            Law::Series => self.preview().ahead(),
            Law::Feedback(flat) => flat.delay_samples(),
        }
    }

    /// The inverse of the linear block.
    pub(super) fn preview(&self) -> &Preview {
        self.inverse.preview()
    }

    /// The output of the blocks in series at rest [output unit].
    pub(super) fn resting(&self) -> f64 {
        let model = self.inverse.model();
        model.offset() + model.linear().dc_gain() * model.step_before_linear(&mut model.initial(), 0.0)
    }

    /// The settled state at `r`, with the references `known` (the first of them `r`) already in the inverse: the next
    /// step takes the reference after them. With a preview as long as the delay, the reference is followed without
    /// delay.
    pub fn settled_with_preview(&self, r: f64, known: &[f64]) -> Vec<f64> {
        let mut x = self.settled(r);
        match &self.law {
            Law::Series => {
                let x = &mut x[BEFORE..BEFORE + self.preview().order()];
                known.iter().for_each(|r| {
                    self.preview().step(x, *r);
                });
            }
            // The voltages before the first sample are not applied.
            Law::Feedback(flat) => known.iter().for_each(|r| {
                flat.step(&mut x[BEFORE..], *r);
            }),
        }
        x
    }

    /// The state of the blocks in series.
    fn in_series(&self, u: f64, r: f64, model: Vec<f64>) -> Vec<f64> {
        [vec![u], self.preview().settled(r), model].concat()
    }
}

impl System for Causal {
    fn ts(&self) -> f64 {
        self.inverse.model().ts()
    }

    fn order(&self) -> usize {
        let of_law = match &self.law {
            Law::Series => self.preview().order() + self.inverse.model().order(),
            Law::Feedback(flat) => flat.order(),
        };
        BEFORE + of_law
    }

    fn initial(&self) -> Vec<f64> {
        match &self.law {
            Law::Series => self.in_series(0.0, self.resting(), self.inverse.model().initial()),
            Law::Feedback(flat) => [vec![0.0], flat.initial()].concat(),
        }
    }

    /// The settled state at the reference `r` [output unit], or at the nearest value within reach.
    fn settled(&self, r: f64) -> Vec<f64> {
        match &self.law {
            Law::Series => {
                let model = self.inverse.model();
                let u = model.static_input(r, self.inverse.ends);
                self.in_series(u, r, model.settled(u))
            }
            Law::Feedback(flat) => {
                let (u, x) = flat.settled(r);
                [vec![self.inverse.nearest(u, self.inverse.ends, 0.0)], x].concat()
            }
        }
    }

    /// That of the model, and the delay. The limits may change: a state continues within others.
    fn fingerprint(&self) -> u32 {
        self.inverse.model().fingerprint() ^ (self.delay_samples() as u32 + 1).wrapping_mul(0x9E37_79B9)
    }

    fn step(&self, x: &mut [f64], r: f64) -> f64 {
        let (before, x) = x.split_at_mut(BEFORE);
        let allowed = self.inverse.from(before[0]);
        before[0] = match &self.law {
            Law::Series => {
                let (preview, model) = x.split_at_mut(self.preview().order());
                // The static gain of the filter is 1 / G(0), which therefore also applies to the offset.
                let block = self.inverse.model();
                let r = if is_measurable(r) { r } else { preview.first().copied().unwrap_or_default() };
                let z = self.preview().step(preview, r) - block.offset() / block.linear().dc_gain();
                block.invert_before_linear(model, z, allowed).u
            }
            Law::Feedback(flat) => self.inverse.nearest(flat.step(x, r), allowed, before[0]),
        };
        before[0]
    }
}
