//! Which of the two signals moves first: swapped columns, and channels shifted against each other.
//!
//! An actuator answers after its input, and its loops turn as those of a lag. Slow drives show it at their turning
//! points ([`plays`]), sharp ones in their increments ([`Increments`]). A shift that leaves the output behind the input
//! by less than amplifier, mechanics and sensor may lag cannot be found.

use super::increments::{AHEAD, BEHIND, Increments};
use super::plays;
use super::runs::standardised;
use super::tone::Tone;
use super::{Defect, Finding};
use crate::number::{round, short};
use crate::record::Record;
use crate::series::dot_wide;

/// Samples that are looked at.
const LONGEST: usize = 40_000;

/// The largest shift that is tried [samples], and the largest phase of the usual motion over it [rad]: at more, a delay
/// looks like a lead of the next half period.
const REACH: usize = 40;
const PHASE: f64 = 0.6;

/// A fit by plays that leaves more, relative to the rms, means nothing: dynamics dominate.
const UNFIT: f64 = 0.15;

/// Without a lead the residual must be larger by this factor. In sound records it is by less than 1.015.
const WORSE: f64 = 1.06;

/// Later inputs must explain this share of what earlier ones leave, and this many times as much as with the columns
/// exchanged. Sound records with that share stay below 1.2 times.
const FUTURE: f64 = 0.05;
const RATHER: f64 = 5.0;

/// They must also explain this share of all, because noise of a measured input has the same effect, but a small one;
/// and the larger one if turning points tell an uncertain lead.
const SHARP: f64 = 0.02;
const SHARPER: f64 = 0.2;

/// The smallest lead of an output that is reported as early [samples]: the monitor of an amplifier lags by less.
const LEAD: isize = 2;

/// Without later inputs, less than this share of what all explain must remain. In sound records it is above 0.96; where
/// all explain less than `LITTLE`, the share means nothing.
const EARLIER: f64 = 0.9;
const LITTLE: f64 = 0.1;

/// The longest delay without a finding [samples]. Inputs up to it may not explain more than `NOTHING` of what all
/// explain, and those of the next `ONSET` samples must explain more than `MUCH`: lags begin to answer earlier, and
/// smooth drives do not date their answer.
const DELAY: isize = 12;
const NOTHING: f64 = 0.01;
const ONSET: isize = 8;
const MUCH: f64 = 0.15;

/// The last lag at which an answer may begin.
const LAST: isize = 32;

/// What the turning points tell.
struct Turns {
    /// Delay of the best fit [samples], negative if the output leads; its residual; the least without a lead.
    delay: isize,
    best: f64,
    causal: f64,
    /// With the columns exchanged: delay, and least residual without a lead.
    exchanged_delay: isize,
    exchanged: f64,
}

/// A finding if input and output are swapped or shifted. In closed loop (`closed`) the noise of the output is before
/// the input: only turning points count.
pub(super) fn order(record: &Record, tone: Option<&Tone>, closed: bool) -> Option<Finding> {
    let n = record.len().min(LONGEST);
    let (u, y) = (&record.u()[..n], &record.y()[..n]);
    let (there, back) = (Increments::of(u, y)?, Increments::of(y, u)?);
    let turns = turns(u, y, tone).filter(|t| t.best.min(t.exchanged) < UNFIT);
    let leads = turns.as_ref().filter(|t| t.delay < 0 && t.causal > WORSE * t.best);
    let (later, exchanged) = (there.by_later(), back.by_later());
    let loops = leads.filter(|t| t.exchanged_delay >= 0 && t.exchanged < t.best && later > exchanged);
    let (earlier, all) = (there.explained(0..BEHIND), there.explained(-AHEAD..BEHIND));
    let least = match &turns {
        None => SHARP,
        Some(turns) if turns.delay < 0 => SHARPER,
        Some(_) => 1.0,
    };
    let sharp = later > FUTURE && later > RATHER * exchanged && all - earlier > least;
    let leads = leads.filter(|t| -t.delay >= LEAD);
    let early = all > LITTLE && earlier < EARLIER * all;
    let (defect, text) = if let Some(t) = loops {
        let text = format!(
            "input and output seem to be swapped: hysteresis leaves {} % of the output's rms, and {} % with the \
             columns exchanged: exchange them",
            round(100.0 * t.causal),
            round(100.0 * t.exchanged)
        );
        (Defect::Swapped, text)
    } else if closed {
        return None;
    } else if sharp {
        let text = format!(
            "the output moves before the input: later inputs explain {} % of what earlier ones leave of its \
             increments: the columns are swapped, or the output is shifted to too early times: exchange the columns, \
             or align the channels",
            round(100.0 * later)
        );
        (Defect::Swapped, text)
    } else if let Some(t) = leads {
        (Defect::Shifted, early_by(-t.delay, record.ts()))
    } else if early {
        (Defect::Shifted, early_by(first(&there, -AHEAD, all).abs(), record.ts()))
    } else {
        (Defect::Shifted, late(&there, all, record.ts())?)
    };
    Some(Finding { defect, samples: Vec::new(), text })
}

/// The text for an output that leads.
fn early_by(samples: isize, ts: f64) -> String {
    format!(
        "the output moves before the input, by about {samples} samples ({} s): align the channels; if they are \
         aligned, input and output may be swapped",
        short(samples as f64 * ts)
    )
}

/// The text for an output that answers after a long time in which nothing happens.
fn late(there: &Increments, all: f64, ts: f64) -> Option<String> {
    let samples = if all > LITTLE { first(there, 0, all) } else { 0 };
    let dated = there.explained(samples + ONSET..BEHIND) < (1.0 - MUCH) * all;
    ((DELAY + 1..LAST).contains(&samples) && dated).then(|| {
        format!(
            "the output answers {samples} samples ({} s) after the input, and nothing happens earlier: unless the \
             sensor has this delay, the channels are shifted: align them",
            short(samples as f64 * ts)
        )
    })
}

/// The last lag, from `start` on, whose earlier inputs explain nothing.
fn first(there: &Increments, start: isize, all: f64) -> isize {
    (start..LAST)
        .take_while(|lag| there.explained(lag + 1..BEHIND) > (1.0 - NOTHING) * all)
        .last()
        .map_or(start, |lag| lag + 1)
}

/// `None` if the drive is too fast, or the sign cannot be told.
fn turns(u: &[f64], y: &[f64], tone: Option<&Tone>) -> Option<Turns> {
    let (u, mut y) = (standardised(u)?, standardised(y)?);
    if dot_wide::<8>(&u, &y) < 0.0 {
        // A sine above a resonance also has the opposite sign, and may lead.
        if tone.is_some() {
            return None;
        }
        y.iter_mut().for_each(|y| *y = -*y);
    }
    let speed = (u.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / u.len() as f64).sqrt();
    let reach = REACH.min((PHASE / speed) as usize);
    if reach == 0 || u.len() < 4 * reach + 50 {
        return None;
    }
    let (there, back) = (plays::residuals(&u, &y, reach)?, plays::residuals(&y, &u, reach)?);
    let least = |x: &[f64]| x.iter().copied().fold(f64::INFINITY, f64::min);
    let delay = |x: &[f64]| x.iter().position(|r| *r == least(x)).map_or(0, |k| k as isize - reach as isize);
    Some(Turns {
        delay: delay(&there),
        best: least(&there),
        causal: least(&there[reach..]),
        exchanged_delay: delay(&back),
        exchanged: least(&back[reach..]),
    })
}
