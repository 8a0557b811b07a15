//! Feed-forward: from a wanted displacement back through the whole model to a voltage.
//!
//! ```text
//! r -> - offset -> inverse of the linear block -> of creep -> of the hysteresis -> u
//! ```
//! The linear block is inverted by a filter that looks ahead ([`preview`](Preview)), creep in closed form, the hysteresis
//! sample by sample between the inputs that are allowed ([`crate::hysteresis::Hysteresis::invert`]). When asked, what the
//! model's free run then leaves of the reference goes back through the same inverse, as often as that helps: this makes up for
//! what the filter gives up.
//!
//! Reference: K. Kuhnen, Eur. J. Control 9, 407 (2003), DOI 10.3166/ejc.9.407-418 (inverse operators in series); S. Devasia,
//! E. Eleftheriou & S. O. R. Moheimani, IEEE Trans. Control Syst. Technol. 15, 802 (2007), DOI 10.1109/TCST.2007.903345. It
//! does not do: feedback. What the model does not know stays.

mod fir;
mod learning;
mod preview;
mod program;
mod sample;
pub mod shaping;

pub use fir::Fir;
pub use learning::{Learned, Learning};
pub use preview::FirDesign;
pub(crate) use preview::Preview;
pub use sample::Causal;

use crate::error::{Error, finite};
use crate::excitation::{Limits, Usage};
use crate::hammerstein::{Domain, Model};
use crate::number::{round, short};
use crate::series::ends;
use crate::system::System;

/// Part of the identified inputs by which a voltage may go beyond them, to either side: so far operators extrapolate well.
const BEYOND: f64 = 0.05;

/// Part of the range of an operator that counts as reached.
const REACHED: f64 = 1e-9;

/// What compensation may use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedForwardSettings {
    /// Limits of the driver; where no voltage is given, the model's own inputs limit it.
    pub limits: Limits,
    /// Whether to come as close as the limits allow instead of refusing.
    pub clip: bool,
    /// How often, at most, what the model's free run leaves of the reference is corrected. This brings the free run closer; the
    /// actuator only where the model is right at high frequencies too, since that is where corrections go.
    pub sweeps: usize,
    /// How the linear block is inverted; if not given, for whole records, looking further ahead by as much as the block is late.
    pub preview: Option<FirDesign>,
}

impl FeedForwardSettings {
    /// The lowest and highest input that both the limits and what is known of `model` allow: where it was identified, and a
    /// twentieth of that beyond.
    ///
    /// # Errors
    /// Limits that make no sense, leave nothing of that, or are not given where nothing is known.
    pub fn ends(&self, model: &Model) -> Result<(f64, f64), Error> {
        let limits = &self.limits;
        limits.check(&[0.5 * (limits.low.unwrap_or(0.0) + limits.high.unwrap_or(0.0))], model.ts())?;
        let known = model.known_inputs();
        let beyond = known.map(|(low, high)| (low - BEYOND * (high - low), high + BEYOND * (high - low)));
        let low = limits.low.into_iter().chain(beyond.map(|b| b.0)).reduce(f64::max);
        let high = limits.high.into_iter().chain(beyond.map(|b| b.1)).reduce(f64::min);
        match low.zip(high) {
            Some((low, high)) if low < high => Ok((low, high)),
            Some((low, high)) => {
                let rule = "must leave some of the inputs that the model was identified on";
                Err(Error::parameter("limits", format!("{} to {}", round(low), round(high)), rule))
            }
            None => {
                let rule =
                    "must be given, or low and high, as the model does not say which inputs it was identified on";
                Err(Error::parameter("driver", "none", rule))
            }
        }
    }
}

impl Default for FeedForwardSettings {
    /// No limits but the model's own, nothing clipped, no sweeps.
    fn default() -> Self {
        FeedForwardSettings { limits: Limits::default(), clip: false, sweeps: 0, preview: None }
    }
}

/// A voltage for a reference, and what the model says it gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Compensated {
    /// The voltage [input unit].
    pub u: Vec<f64>,
    /// The model's free run, settled before it at the voltage that holds the first value of the reference [output unit].
    pub reached: Vec<f64>,
    /// What it uses of the limits.
    pub usage: Usage,
    /// Samples at which a limit was in the way.
    pub clipped: usize,
    /// What is worth knowing, one sentence each.
    pub notes: Vec<String>,
}

impl Model {
    /// The voltage for a path `r` [output unit] that is known as a whole, within what the model was identified on.
    ///
    /// # Errors
    /// As [`FeedForward::new`] and [`FeedForward::whole`].
    pub fn compensate(&self, r: &[f64]) -> Result<Compensated, Error> {
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
/// let made = FeedForward::new(&model, FeedForwardSettings::default())?.whole(&r)?;
/// let y = model.resume(&mut model.settled(made.u[0]), &made.u);
/// // A corner at the start rings for a while.
/// let worst = (300..2000).map(|t| (y[t] - r[t]).abs()).fold(0.0, f64::max);
/// assert!(worst < 0.01, "{worst}");
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct FeedForward {
    model: Model,
    settings: FeedForwardSettings,
    preview: Preview,
    /// Lowest and highest input allowed.
    ends: (f64, f64),
    /// Largest change of the input in a sample.
    step: f64,
    /// What creep puts out where these ends have stood for long.
    crept: (f64, f64),
    notes: Vec<String>,
}

impl FeedForward {
    /// The inverse of `model` within the limits.
    ///
    /// # Errors
    /// [`Error::NoInverse`] where the linear block has none, [`Error::Unsuited`] where the hysteresis does not rise;
    /// limits in volts of a model whose input is in another unit; limits that make no sense.
    pub fn new(model: &Model, settings: FeedForwardSettings) -> Result<Self, Error> {
        let found = &model.units().u;
        if settings.limits != Limits::default() && found != "V" {
            let what = "the model's input".into();
            return Err(Error::Units { what, found: found.clone(), wanted: "V, the unit of limits,".into() });
        }
        let late = model.linear().delay();
        let whole =
            FirDesign { ahead: FirDesign::WHOLE.ahead + late, taps: FirDesign::WHOLE.taps + late, ..FirDesign::WHOLE };
        let preview = Preview::new(model.linear(), settings.preview.unwrap_or(whole))?;
        let ends = settings.ends(model)?;
        let [low, high] = [ends.0, ends.1].map(|u| model.settled_before_linear(u));
        if !(low < high && high.is_finite() && low.is_finite()) {
            let [from, to] = [ends.0, ends.1].map(round);
            let because = format!(
                "from an input of {from} to one of {to} its z goes from {} to {}; it has to rise",
                short(low),
                short(high)
            );
            return Err(Error::Unsuited { what: "inverse of its hysteresis".into(), because });
        }
        let step = settings.limits.fastest() * model.ts();
        let notes = model.hysteresis().falling_input(ends.0, ends.1).map(|u| {
            let u = round(u);
            format!("the hysteresis block falls with its input near {u}: of several inputs one is taken")
        });
        let notes = notes.into_iter().collect();
        Ok(FeedForward { model: model.clone(), settings, preview, ends, step, crept: (low, high), notes })
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The inverse of its linear block.
    pub fn preview(&self) -> &Preview {
        &self.preview
    }

    /// The lowest and highest displacement that can be held for long [output unit].
    pub fn reach(&self) -> (f64, f64) {
        let [a, b] = [self.crept.0, self.crept.1].map(|z| self.model.offset() + self.model.linear().dc_gain() * z);
        (a.min(b), a.max(b))
    }

    /// Whether the displacements of `r` [output unit] can be held for long; how fast they can be reached is left to [`FeedForward::whole`].
    ///
    /// # Errors
    /// [`Error::Unreachable`] with the first that cannot.
    pub fn holds(&self, r: &[f64]) -> Result<(), Error> {
        finite("reference", r)?;
        let (low, high) = self.reach();
        r.iter().position(|r| !(low..=high).contains(r)).map_or(Ok(()), |t| Err(self.unreachable(r, t)))
    }

    /// The voltage for the reference `r` [output unit], which had stood at its first value for long and goes on after its last
    /// as it moved before. The answer cannot begin before the record does: let a reference that has to be met from its start
    /// stand for some milliseconds first.
    ///
    /// # Errors
    /// [`Error::Unreachable`] where no allowed voltage gives the reference, [`Error::Limits`] where slew or current would have
    /// to exceed theirs, neither when clipping; a reference that is empty or not finite.
    pub fn whole(&self, r: &[f64]) -> Result<Compensated, Error> {
        finite("reference", r)?;
        let Some(&first) = r.first() else {
            let (what, remedy) = ("the reference".into(), "give it samples".into());
            return Err(Error::TooShort { what, have: 0, need: 1, remedy });
        };
        let offset = self.model.offset();
        let mut wanted = self.preview.fir().whole(&self.extended_past_end(r));
        wanted.truncate(r.len());
        let held = (first - offset) / self.model.linear().dc_gain();
        let start = self.model.static_input_before_linear(held, self.ends);
        let mut best = self.invert_path(&wanted, start.u);
        if !self.within(start.z - held) && (start.u <= self.ends.0 || start.u >= self.ends.1) && !self.settings.clip {
            return Err(self.unreachable(r, 0));
        }
        if let Some(sample) = best.missed.filter(|_| !self.settings.clip) {
            return Err(self.unreachable(r, sample));
        }
        best.left = off(r, &best.reached);
        let first_left = best.left;
        let mut sweeps = 0;
        for _ in 0..self.settings.sweeps {
            let left: Vec<f64> = r.iter().zip(&best.reached).map(|(r, y)| r - y).collect();
            self.preview.fir().whole(&left).iter().zip(&mut wanted).for_each(|(more, wanted)| *wanted += more);
            let mut next = self.invert_path(&wanted, start.u);
            next.left = off(r, &next.reached);
            let allowed = self.settings.clip
                || (next.missed.is_none() && self.settings.limits.refuse(&next.u, self.model.ts()).is_ok());
            if !(allowed && next.left < 0.98 * best.left) {
                break;
            }
            (best, sweeps) = (next, sweeps + 1);
        }
        let usage = if self.settings.clip {
            self.settings.limits.check(&best.u, self.model.ts())
        } else {
            self.settings.limits.refuse(&best.u, self.model.ts())
        }?;
        let mut notes = self.notes.clone();
        if sweeps > 0 {
            let (from, to, unit) = (short(first_left), short(best.left), &self.model.units().y);
            notes.push(format!(
                "{sweeps} sweeps of correction by the model's free run: rms error {from} to {to} {unit}"
            ));
        }
        notes.extend(self.told(&best));
        Ok(Compensated { u: best.u, reached: best.reached, usage, clipped: best.clipped, notes })
    }

    /// The reference without offset, going on beyond its end as it moves there: mirrored through its last point.
    fn extended_past_end(&self, r: &[f64]) -> Vec<f64> {
        let ahead = self.preview.fir().ahead();
        let last = r.last().copied().unwrap_or_default();
        let after = r.iter().rev().skip(1).map(|r| 2.0 * last - r).take(ahead);
        r.iter().copied().chain(after).map(|r| r - self.model.offset()).collect()
    }

    /// Back from what creep is to put out to the input, from the model settled at `start`.
    fn invert_path(&self, wanted: &[f64], start: f64) -> InverseRun {
        let mut x = self.model.settled(start);
        let mut run = InverseRun {
            u: Vec::with_capacity(wanted.len()),
            reached: Vec::new(),
            left: 0.0,
            clipped: 0,
            jumped: 0,
            missed: None,
        };
        let mut before = start;
        for (t, wanted) in wanted.iter().enumerate() {
            let found = self.model.invert_before_linear(&mut x, *wanted, self.from(before));
            if !self.within(found.z - wanted) {
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
        run.reached = self.model.resume(&mut self.model.settled(start), &run.u);
        run
    }

    /// The inputs allowed after `before`.
    fn from(&self, before: f64) -> (f64, f64) {
        let step = if self.settings.clip { self.step } else { f64::INFINITY };
        let (low, high) = self.ends;
        ((before - step).clamp(low, high), (before + step).clamp(low, high))
    }

    /// Whether this input lies at an end of those allowed after `before`.
    fn at_end(&self, u: f64, before: f64) -> bool {
        let (low, high) = self.from(before);
        u <= low || u >= high
    }

    /// Whether this is no difference worth the name.
    fn within(&self, off: f64) -> bool {
        off.abs() <= REACHED * (self.crept.1 - self.crept.0)
    }

    fn unreachable(&self, r: &[f64], sample: usize) -> Error {
        let unit = &self.model.units().y;
        let [low, high] = [self.ends.0, self.ends.1].map(round);
        let (bottom, top) = self.reach();
        let [value, at, bottom, top] = [r[sample], sample as f64 * self.model.ts(), bottom, top].map(round);
        let (lowest, highest) = ends(r.iter().copied());
        let still = self.reach().0 <= lowest && highest <= self.reach().1;
        let instead = match still {
            true if sample < self.preview.fir().ahead() => {
                "let it stand for some milliseconds before it moves, or smooth it"
            }
            true => "move slower or smooth it",
            false => "lower it",
        };
        let input = &self.model.units().u;
        Error::Unreachable(format!(
            "{value} {unit} at sample {sample} ({at} s) takes more than the inputs of {low} to {high} {input} give, which for long \
             hold {bottom} to {top} {unit}; {instead}, or ask to clip"
        ))
    }

    /// What the voltages of a run have that the model was not identified on, and what was clipped.
    fn told(&self, run: &InverseRun) -> Vec<String> {
        let (n, clipped) = (run.u.len(), run.clipped);
        let mut notes = Vec::new();
        if clipped > 0 {
            notes.push(format!("{clipped} of {n} samples are clipped to the limits"));
        }
        if run.jumped > 0 {
            let jumped = run.jumped;
            notes.push(format!(
                "at {jumped} of {n} samples the hysteresis block jumps past what is wanted: the nearest is taken"
            ));
        }
        notes.extend(self.beyond(&run.u));
        notes
    }

    /// What the voltages `u` have that the model was not identified on.
    pub fn beyond(&self, u: &[f64]) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(known) = self.model.identified() {
            let used = Domain::of_input(u, self.model.ts());
            let input = &self.model.units().u;
            let [low, high, known_low, known_high] = [used.u[0], used.u[1], known.u[0], known.u[1]].map(round);
            if used.u[0] < known.u[0] || used.u[1] > known.u[1] {
                notes.push(format!(
                    "inputs from {low} to {high} {input} are used, but the model was identified from {known_low} to {known_high}"
                ));
            }
            if used.slew > known.slew {
                let [slew, known] = [used.slew, known.slew].map(round);
                notes.push(format!("the input changes by {slew} {input}/s, but the model has seen {known} at most"));
            }
        }
        notes
    }
}

/// What one way back found.
struct InverseRun {
    u: Vec<f64>,
    reached: Vec<f64>,
    /// Rms of what it leaves of the reference.
    left: f64,
    clipped: usize,
    /// Samples that no input meets, since z jumps there.
    jumped: usize,
    /// The first sample at which an end of the inputs was in the way.
    missed: Option<usize>,
}

/// Root of the mean square of the difference.
fn off(r: &[f64], y: &[f64]) -> f64 {
    (r.iter().zip(y).map(|(r, y)| (r - y) * (r - y)).sum::<f64>() / r.len() as f64).sqrt()
}

#[cfg(test)]
mod tests;
