//! Which of the two signals moves first: swapped columns, and channels shifted against each other.
//!
//! An actuator answers after its input, and its loops turn as those of a lag. Slow drives show it at their turning
//! points ([`plays`]), sharp ones in their increments ([`Increments`]). A shift is not found if the output then lags
//! the input by no more than amplifier, mechanics and sensor can.

use super::detector::{Consequence, Detector};
use super::increments::{Increments, MAX_LAGS, MAX_LEAD_LAGS};
use super::plays;
use super::runs::standardised;
use super::tone::Tone;
use crate::record::Record;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::series::{dot_wide, ends, range};
use std::ops::Range;

/// Samples that are looked at.
const MAX_SAMPLES: usize = 40_000;

/// The largest shift that is tried [samples], and the largest phase of the usual motion over it [rad]: at more, a delay
/// looks like a lead of the next half period.
const MAX_SHIFT_SAMPLES: usize = 40;
const MAX_SHIFT_PHASE: f64 = 0.6;

/// The ends of a full stroke, relative to the range of the input.
const END_SHARE: f64 = 0.02;

/// A fit by plays that leaves more, relative to the rms, means nothing: dynamics dominate.
const MAX_PLAY_RESIDUAL: f64 = 0.15;

/// Without a lead the residual must be larger by this factor. In sound records it is by less than 1.015.
const MIN_RESIDUAL_RATIO: f64 = 1.06;

/// Later inputs must explain this share of what earlier ones leave, and this many times as much as with the columns
/// exchanged. Sound records with that share stay below 1.2 times.
const MIN_LATER_SHARE: f64 = 0.05;
const MIN_LATER_RATIO: f64 = 5.0;

/// They must also explain this share of all, because noise of a measured input has the same effect, but a small one;
/// and the larger one if turning points show an uncertain lead.
const MIN_LATER_GAIN: f64 = 0.02;
const MIN_LATER_GAIN_WITH_LEAD: f64 = 0.2;

/// The smallest lead of an output that is reported as early [samples]: the monitor of an amplifier lags by less.
const MIN_LEAD_SAMPLES: isize = 2;

/// Without later inputs, less than this share of what all explain must remain. In sound records it is above 0.96; where
/// all explain less than `MIN_EXPLAINED_SHARE`, the share means nothing.
const MAX_EARLIER_SHARE: f64 = 0.9;
const MIN_EXPLAINED_SHARE: f64 = 0.1;

/// The longest delay without a finding [samples]. Inputs up to it may not explain more than `MAX_DEAD_TIME_SHARE` of
/// what all explain, and those of the next `ONSET_SAMPLES` samples must explain more than `MIN_ONSET_SHARE`: lags begin
/// to answer earlier, and smooth drives do not date their answer.
const MAX_DELAY_SAMPLES: isize = 12;
const MAX_DEAD_TIME_SHARE: f64 = 0.01;
const ONSET_SAMPLES: isize = 8;
const MIN_ONSET_SHARE: f64 = 0.15;

/// The last lag at which an answer may begin.
const LAST_ONSET_LAG: isize = 32;

/// The fits by plays, which depend on the turning points.
struct Turns {
    /// Delay of the best fit [samples], negative if the output leads; its residual; the least without a lead.
    delay: isize,
    best: f64,
    causal: f64,
    /// With the columns exchanged: delay, and least residual without a lead.
    exchanged_delay: isize,
    exchanged: f64,
}

pub(super) static SWAPPED: Detector = Detector {
    name: "swapped",
    criterion: "loops turn the wrong way, or later inputs explain the output better than earlier ones",
    consequence: Consequence::Error,
    loop_remedy: None,
    run: |context| match context.order()? {
        Order::Swapped(text) => Some(text.clone().into()),
        Order::Shifted(_) => None,
    },
};

pub(super) static SHIFTED: Detector = Detector {
    name: "shifted",
    criterion: "the output turns, or responds to sharp changes, before the input or more than 12 samples after it",
    consequence: Consequence::Reported,
    loop_remedy: None,
    run: |context| match context.order()? {
        Order::Shifted(text) => Some(text.clone().into()),
        Order::Swapped(_) => None,
    },
};

/// The wrong order of the two signals, in words.
pub(super) enum Order {
    Swapped(String),
    Shifted(String),
}

/// `None` if the order is right, or unknown. In closed loop (`is_closed_loop`) the noise of the output is before the
/// input: only turning points count.
pub(super) fn order(record: &Record, tone: Option<&Tone>, is_closed_loop: bool) -> Option<Order> {
    let n = record.len().min(MAX_SAMPLES);
    let (u, y) = (&record.u()[..n], &record.y()[..n]);
    let (there, back) = (Increments::of(u, y)?, Increments::of(y, u)?);
    let loops = after_first_stroke(u);
    let turns = turns(&u[loops.clone()], &y[loops], tone).filter(|t| t.best.min(t.exchanged) < MAX_PLAY_RESIDUAL);
    let leads = turns.as_ref().filter(|t| t.delay < 0 && t.causal > MIN_RESIDUAL_RATIO * t.best);
    let (later, exchanged) = (there.by_later(), back.by_later());
    let loops = leads.filter(|t| t.exchanged_delay >= 0 && t.exchanged < t.best && later > exchanged);
    let (earlier, all) = (there.explained(0..MAX_LAGS), there.explained(-MAX_LEAD_LAGS..MAX_LAGS));
    let least = match &turns {
        None => MIN_LATER_GAIN,
        Some(turns) if turns.delay < 0 => MIN_LATER_GAIN_WITH_LEAD,
        Some(_) => 1.0,
    };
    let sharp = later > MIN_LATER_SHARE && later > MIN_LATER_RATIO * exchanged && all - earlier > least;
    let leads = leads.filter(|t| -t.delay >= MIN_LEAD_SAMPLES);
    let early = all > MIN_EXPLAINED_SHARE && earlier < MAX_EARLIER_SHARE * all;
    if let Some(t) = loops {
        let [own, exchanged] = [t.causal, t.exchanged].map(|residual| round(100.0 * residual));
        Some(Order::Swapped(format!(
            "input and output seem to be swapped: a model of hysteresis leaves a residual of {own} % of the output's \
             rms, and {exchanged} % with the columns exchanged: exchange them"
        )))
    } else if is_closed_loop {
        None
    } else if sharp {
        let later = round(100.0 * later);
        Some(Order::Swapped(format!(
            "the output moves before the input: later inputs explain {later} % of those output increments that earlier \
             inputs do not explain. If the columns are swapped, exchange them; if the output is shifted, align the \
             channels"
        )))
    } else if let Some(t) = leads {
        Some(Order::Shifted(leading(-t.delay, record.ts())))
    } else if early {
        Some(Order::Shifted(leading(first(&there, -MAX_LEAD_LAGS, all).abs(), record.ts())))
    } else {
        delayed(&there, all, record.ts()).map(Order::Shifted)
    }
}

/// The samples after the first full stroke: the first stroke is on no loop. All samples if it takes most of them.
fn after_first_stroke(u: &[f64]) -> Range<usize> {
    let ((low, high), margin) = (ends(u.iter().copied()), END_SHARE * range(u));
    let first = |at_end: &dyn Fn(f64) -> bool| u.iter().position(|u| at_end(*u)).unwrap_or(0);
    let start = first(&|u| u >= high - margin).max(first(&|u| u <= low + margin));
    if 2 * start < u.len() { start..u.len() } else { 0..u.len() }
}

/// The text for an output that leads.
fn leading(samples: isize, ts: f64) -> String {
    let seconds = short(samples as f64 * ts);
    format!(
        "the output moves before the input, by about {samples} samples ({seconds} s): align the channels; if they are \
         aligned, input and output may be swapped"
    )
}

/// The text for an output that answers after a long time in which nothing happens.
fn delayed(there: &Increments, all: f64, ts: f64) -> Option<String> {
    let samples = if all > MIN_EXPLAINED_SHARE { first(there, 0, all) } else { 0 };
    let dated = there.explained(samples + ONSET_SAMPLES..MAX_LAGS) < (1.0 - MIN_ONSET_SHARE) * all;
    ((MAX_DELAY_SAMPLES + 1..LAST_ONSET_LAG).contains(&samples) && dated).then(|| {
        format!(
            "the output answers {samples} samples ({} s) after the input, and nothing happens earlier: unless the \
             sensor has this delay, the channels are shifted: align them",
            short(samples as f64 * ts)
        )
    })
}

/// The last lag, from `start` on, whose earlier inputs explain nothing.
fn first(there: &Increments, start: isize, all: f64) -> isize {
    (start..LAST_ONSET_LAG)
        .take_while(|lag| there.explained(lag + 1..MAX_LAGS) > (1.0 - MAX_DEAD_TIME_SHARE) * all)
        .last()
        .map_or(start, |lag| lag + 1)
}

/// `None` if the drive is too fast, or the sign is unknown.
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
    let reach = MAX_SHIFT_SAMPLES.min((MAX_SHIFT_PHASE / speed) as usize);
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
