//! Feed-forward: from a requested displacement through the inverse of the whole model to a voltage.
//!
//! ```text
//! r -> - offset -> inverse of the linear block -> of creep -> of the hysteresis -> u
//! ```
//! The linear block is inverted by a finite filter with preview, creep in closed form, and the hysteresis
//! sample by sample within the allowed inputs ([`Hysteresis::invert`](piezoid_models::hysteresis::Hysteresis::invert)).
//! Optional iterations send the residual of the model's free run through the same inverse, as long as the error falls.
//! They correct the approximation of the filter. Mechanics with hysteresis in feedback have an inverse of their own
//! (`flat`).
//!
//! Reference: K. Kuhnen, Eur. J. Control 9, 407 (2003), DOI 10.3166/ejc.9.407-418 (inverse operators in series); S.
//! Devasia, E. Eleftheriou & S. O. R. Moheimani, IEEE Trans. Control Syst. Technol. 15, 802 (2007), DOI
//! 10.1109/TCST.2007.903345. It does not do: feedback. Errors of the model remain.
//!
//! Why: docs/decisions/compensation.md, "Corrections by the free run are off by default".

mod fir;
mod flat;
mod learning;
mod preview;
mod program;
mod remarks;
mod sample;
mod settings;
pub mod shaping;

#[doc(hidden)]
pub use fir::Fir;
pub use learning::{Learned, Learning};
pub(crate) use preview::{FirDesign, Preview};
pub use sample::Causal;
pub use settings::FeedForwardSettings;

use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_models::hysteresis::Real;
use piezoid_numerics::error::{Error, finite};
use piezoid_numerics::number::{round, short};
use piezoid_numerics::system::System;
use piezoid_records::excitation::{Limits, Usage};

/// Share of the range of an operator below which an error counts as zero.
const REACHED: f64 = 1e-9;

/// A voltage for a reference, with the response of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Compensated {
    /// The voltage [input unit].
    pub u: Vec<f64>,
    /// Free run of the model, from the settled state at the first value of the reference [output unit].
    pub reached: Vec<f64>,
    /// Usage of the limits.
    pub usage: Usage,
    /// Number of samples clipped to a limit.
    pub clipped: usize,
    /// Remarks, one sentence each.
    pub notes: Vec<String>,
}

/// The inverse of a model, for a whole reference.
pub trait Compensate {
    /// The voltage for a reference `r` [output unit] that is known as a whole, within the range of the identification
    /// data.
    ///
    /// # Errors
    /// The errors of [`FeedForward::new`] and [`FeedForward::whole`].
    fn compensate(&self, r: &[f64]) -> Result<Compensated, Error>;
}

impl Compensate for Model {
    fn compensate(&self, r: &[f64]) -> Result<Compensated, Error> {
        FeedForward::new(self, FeedForwardSettings::default())?.whole(r)
    }
}

/// The inverse of a model.
///
/// ```
/// use piezoid::compensation::{FeedForward, FeedForwardSettings};
/// use piezoid::{Model, System, hysteresis::Operator, linear::Arx};
/// let block = Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8])?;
/// let model = Model::new((Operator::find("prandtl-ishlinskii")?.example)(5e-4)?, block, 2.0)?;
/// let r: Vec<f64> = (0..2000).map(|t| 300.0 * (0.03 * f64::from(t)).sin()).collect();
/// let result = FeedForward::new(&model, FeedForwardSettings::default())?.whole(&r)?;
/// let y = model.resume(&mut model.settled(result.u[0]), &result.u);
/// // A corner at the start excites the resonance.
/// let worst = (300..2000).map(|t| (y[t] - r[t]).abs()).fold(0.0, f64::max);
/// assert!(worst < 0.01, "{worst}");
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct FeedForward {
    /// The blocks in series, which are inverted.
    model: Model,
    /// The model whose response is corrected.
    whole: Model,
    settings: FeedForwardSettings,
    preview: Preview,
    /// Lowest and highest input allowed.
    ends: (f64, f64),
    /// Largest change of the input per sample.
    step: f64,
    /// Settled output of creep at these ends.
    crept: (f64, f64),
    notes: Vec<String>,
}

impl FeedForward {
    /// The inverse of `model` within the limits.
    ///
    /// # Errors
    /// [`Error::NoInverse`] if the linear block has none, [`Error::Unsuited`] if the hysteresis does not rise; an error
    /// for invalid limits, and for limits in volts if the input of the model has another unit.
    pub fn new(model: &Model, settings: FeedForwardSettings) -> Result<Self, Error> {
        let (whole, delay_samples) = (FirDesign::WHOLE, model.linear().delay());
        let design = FirDesign { ahead: whole.ahead + delay_samples, taps: whole.taps + delay_samples };
        FeedForward::with(model, settings, design)
    }

    /// With this design of the inverse of the linear block.
    fn with(whole: &Model, settings: FeedForwardSettings, design: FirDesign) -> Result<Self, Error> {
        let model = &whole.without_feedback();
        let found = &model.units().u;
        if settings.limits != Limits::default() && found != "V" {
            let what = "the model's input".into();
            return Err(Error::Units { what, found: found.clone(), expected: "V, the unit of limits,".into() });
        }
        let preview = Preview::new(model.linear(), design)?;
        let ends = settings.ends(model)?;
        let [low, high] = [ends.0, ends.1].map(|u| model.settled_before_linear(u));
        if !(low < high && high.is_finite() && low.is_finite()) {
            let [from, to] = [ends.0, ends.1].map(round);
            let because = format!(
                "z must rise with the input, but goes from {} to {} for inputs from {from} to {to}",
                short(low),
                short(high)
            );
            return Err(Error::Unsuited { what: "inverse of its hysteresis".into(), because });
        }
        let step = settings.limits.fastest() * model.ts();
        let notes = model.hysteresis().falling_input(ends.0, ends.1).map(|u| {
            let u = round(u);
            format!(
                "the output of the hysteresis block falls with rising input near {u} {found}: the inverse is not \
                     unique there"
            )
        });
        let notes = notes.into_iter().collect();
        Ok(FeedForward {
            model: model.clone(),
            whole: whole.clone(),
            settings,
            preview,
            ends,
            step,
            crept: (low, high),
            notes,
        })
    }

    /// The blocks in series of the model, which are inverted.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The inverse of its linear block.
    pub fn preview(&self) -> &Preview {
        &self.preview
    }

    /// The lowest and highest displacement that can be held [output unit].
    pub fn reach(&self) -> (f64, f64) {
        let [a, b] = [self.crept.0, self.crept.1].map(|z| self.model.offset() + self.model.linear().dc_gain() * z);
        (a.min(b), a.max(b))
    }

    /// Checks that every value of `r` [output unit] can be held. [`FeedForward::whole`] checks its speed.
    ///
    /// # Errors
    /// [`Error::Unreachable`] with the first value that cannot be held.
    pub fn holds(&self, r: &[f64]) -> Result<(), Error> {
        finite("reference", r)?;
        let (low, high) = self.reach();
        r.iter().position(|r| !(low..=high).contains(r)).map_or(Ok(()), |t| Err(self.unreachable(r, t)))
    }

    /// The voltage for the reference `r` [output unit]. Before it the model is settled at its first value; after it the
    /// motion is extrapolated. The voltage cannot start before the record: if the reference must be met from its start,
    /// begin it with some milliseconds at a constant value.
    ///
    /// # Errors
    /// [`Error::Unreachable`] if no allowed voltage gives the reference, [`Error::Limits`] if slew or current exceed
    /// their limits (neither of them with clipping), and errors for a reference that is empty or not finite.
    pub fn whole(&self, r: &[f64]) -> Result<Compensated, Error> {
        let first = first_of(r)?;
        if let Some(flat) = self.flat() {
            return self.in_feedback(&flat, r);
        }
        let held = (first - self.model.offset()) / self.model.linear().dc_gain();
        let start = self.model.static_input_before_linear(held, self.ends);
        if !self.within(start.z - held) && (start.u <= self.ends.0 || start.u >= self.ends.1) && !self.settings.clip {
            return Err(self.unreachable(r, 0));
        }
        self.whole_from(InitialCondition::Settled, start.u, r)
    }

    /// The same from an initial condition in which the input is `start` [input unit]. Let the reference begin with the
    /// displacement there, because nothing corrects a jump to it.
    ///
    /// # Errors
    /// The same; and an error with mechanics in feedback.
    pub fn whole_from(&self, initial_condition: InitialCondition, start: f64, r: &[f64]) -> Result<Compensated, Error> {
        first_of(r)?;
        if self.flat().is_some() {
            let because = "its hysteresis is inside the mechanics: take the inverse from the settled state".into();
            return Err(Error::Unsuited { what: "inverse from a given state".into(), because });
        }
        let mut target = self.preview.whole(&self.extended_past_end(r));
        target.truncate(r.len());
        let invert = |target: &[f64]| self.invert_path(target, initial_condition, start);
        let more = |residual: &[f64]| self.preview.whole(residual);
        let (best, iterations, first_rms) = self.corrected(r, target, self.settings.iterations, invert, more)?;
        let mut notes = self.notes.clone();
        if iterations > 0 {
            let (from, to, unit) = (short(first_rms), short(best.rms), &self.model.units().y);
            notes.push(format!(
                "{iterations} correction iterations: rms error of the free run from {from} to {to} {unit}"
            ));
        }
        self.compensated(best, notes)
    }

    /// The result of this inversion.
    fn compensated(&self, best: InverseRun, mut notes: Vec<String>) -> Result<Compensated, Error> {
        let (limits, ts) = (&self.settings.limits, self.model.ts());
        let usage = if self.settings.clip { limits.check(&best.u, ts) } else { limits.refuse(&best.u, ts) }?;
        notes.extend(self.notes_on(&best));
        Ok(Compensated { u: best.u, reached: best.reached, usage, clipped: best.clipped, notes })
    }

    /// The inversion of `target`, corrected at most so often and as long as the error falls by what its response leaves
    /// of `r`, sent through `more`: the best run, the number of corrections, and the error of the first run.
    fn corrected(
        &self,
        r: &[f64],
        mut target: Vec<f64>,
        most: usize,
        invert: impl Fn(&[f64]) -> InverseRun,
        more: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Result<(InverseRun, usize, f64), Error> {
        let run = |target: &[f64]| {
            let run = invert(target);
            InverseRun { rms: rms_error(r, &run.reached), ..run }
        };
        let mut best = run(&target);
        if let Some(sample) = best.missed.filter(|_| !self.settings.clip) {
            return Err(self.unreachable(r, sample));
        }
        let first_rms = best.rms;
        for done in 0..most {
            let residual: Vec<f64> = r.iter().zip(&best.reached).map(|(r, y)| r - y).collect();
            more(&residual).iter().zip(&mut target).for_each(|(more, target)| *target += more);
            let next = run(&target);
            let allowed = self.settings.clip
                || (next.missed.is_none() && self.settings.limits.refuse(&next.u, self.model.ts()).is_ok());
            if !(allowed && next.rms < 0.98 * best.rms) {
                return Ok((best, done, first_rms));
            }
            best = next;
        }
        Ok((best, most, first_rms))
    }

    /// The reference without offset, extrapolated beyond its end: mirrored through its last point.
    fn extended_past_end(&self, r: &[f64]) -> Vec<f64> {
        let ahead = self.preview.ahead();
        let last = r.last().copied().unwrap_or_default();
        let after = r.iter().rev().skip(1).map(|r| 2.0 * last - r).take(ahead);
        r.iter().copied().chain(after).map(|r| r - self.model.offset()).collect()
    }

    /// Inverts a series of creep outputs to inputs, from this initial condition at the input `start`.
    fn invert_path(&self, target: &[f64], initial_condition: InitialCondition, start: f64) -> InverseRun {
        let mut x = self.model.before(&[start], initial_condition);
        let mut run = InverseRun { u: Vec::with_capacity(target.len()), ..Default::default() };
        let mut before = start;
        for (t, z) in target.iter().enumerate() {
            let found = self.model.invert_before_linear(&mut x, *z, self.from(before));
            if !self.within(found.z - z) {
                if self.at_end(found.u, before) {
                    run.clipped += 1;
                    run.missed = run.missed.or(Some(t));
                } else {
                    run.jumped += 1;
                }
            }
            before = found.u;
            run.u.push(before);
        }
        run.reached = self.whole.follow(&mut self.whole.before(&[start], initial_condition), &run.u);
        run
    }

    /// The inputs allowed after `before`.
    fn from(&self, before: f64) -> (f64, f64) {
        let step = if self.settings.clip { self.step } else { f64::INFINITY };
        let (low, high) = self.ends;
        ((before - step).clamp(low, high), (before + step).clamp(low, high))
    }

    /// The nearest of these inputs to `u`, or to `before` if `u` is not finite.
    fn nearest(&self, u: f64, (low, high): (f64, f64), before: f64) -> f64 {
        Real::clamp(if u.is_finite() { u } else { before }, low, high)
    }

    /// True if this input is at a limit of those allowed after `before`.
    fn at_end(&self, u: f64, before: f64) -> bool {
        let (low, high) = self.from(before);
        u <= low || u >= high
    }

    /// True if the error counts as zero.
    fn within(&self, error: f64) -> bool {
        error.abs() <= REACHED * (self.crept.1 - self.crept.0)
    }
}

/// The first value of a reference, whose values must be finite.
fn first_of(r: &[f64]) -> Result<f64, Error> {
    finite("reference", r)?;
    let (what, remedy) = ("the reference".into(), "it must not be empty".into());
    r.first().copied().ok_or(Error::TooShort { what, have: 0, need: 1, remedy })
}

/// Result of one inversion.
#[derive(Default)]
struct InverseRun {
    u: Vec<f64>,
    reached: Vec<f64>,
    /// Rms error of the free run.
    rms: f64,
    clipped: usize,
    /// Samples without a matching input, because z jumps there.
    jumped: usize,
    /// The first sample that is limited.
    missed: Option<usize>,
}

/// Root of the mean squared difference.
fn rms_error(r: &[f64], y: &[f64]) -> f64 {
    (r.iter().zip(y).map(|(r, y)| (r - y) * (r - y)).sum::<f64>() / r.len() as f64).sqrt()
}

#[cfg(test)]
mod tests;
