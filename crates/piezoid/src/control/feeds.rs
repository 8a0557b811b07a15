//! Feed-forwards: voltages for a reference, made before the run or in it.
//!
//! ```text
//! gain           u_t = k (r_{t+s} - r_mean) + u_0     k, u_0 and s of least error over the model's own answer to it
//! feed-forward   u = model^-1 (r)                     all of r known, or as many samples ahead as are told
//! learning       u_{j+1} from r - y_j                 tried on the plant itself, of references that repeat
//! ```
//! `gain` is as good as a straight line can be for this very reference, shifted by as many samples as are known ahead and help: what
//! others gain over it is not owed to a poor line.
//!
//! Reference: as the rows. It does not do: references that are made up on the way.

use crate::compensation::{Causal, FeedForward, FeedForwardSettings, FirDesign, Learning};
use crate::error::{Error, row};
use crate::hammerstein::Model;
use crate::series::{mean, scatter};
use crate::system::System;
use crate::waveform::period;

/// How long a trial is repeated before it is looked at, and how long it is then averaged, both in whole periods [s].
const SETTLES: f64 = 0.25;

/// How often the straight line is corrected: its gain depends on the height of the loop.
const STRAIGHTENED: usize = 4;

/// How many samples the straight line may look ahead.
const SHIFT: usize = 8;

/// How far ahead is as good as all [samples]: what the inverse for whole references looks ahead.
pub(super) const ALL: usize = FirDesign::WHOLE.ahead;

/// What a feed-forward is made for.
#[derive(Debug, Clone, Copy)]
pub struct FeedRequest<'a> {
    /// The model.
    pub model: &'a Model,
    /// Limits and whether to clip.
    pub settings: FeedForwardSettings,
    /// What is wanted [output unit].
    pub r: &'a [f64],
    /// Samples of it known beyond the present one.
    pub ahead: usize,
    /// The plant, for those that try.
    pub plant: &'a dyn System,
}

/// A feed-forward, and how it came about.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FeedResult {
    /// The voltages, one a sample of the reference [V].
    pub u: Vec<f64>,
    /// Rms error of each trial, if there were any [output unit].
    pub trials: Vec<f64>,
    /// State of the plant after them.
    pub after: Option<Vec<f64>>,
    /// What is worth knowing, one sentence each.
    pub notes: Vec<String>,
}

/// One kind of feed-forward: a row of [`FEED_FORWARDS`].
#[derive(Clone, Copy)]
pub struct FeedForwardKind {
    /// As users write it.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Where it comes from.
    pub reference: &'static str,
    /// Makes it. Refused where the reference cannot be reached, or where it does not repeat and has to.
    pub make: fn(&FeedRequest) -> Result<FeedResult, Error>,
}

impl std::fmt::Debug for FeedForwardKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Feed").field(&self.name).finish()
    }
}

/// The feed-forwards there are; the first is taken where none is named.
pub static FEED_FORWARDS: &[FeedForwardKind] = &[
    FeedForwardKind {
        name: "gain",
        summary: "a straight line from displacement to voltage: no compensation",
        reference: "least squares",
        make: line,
    },
    FeedForwardKind {
        name: "feed-forward",
        summary: "the inverse of the model",
        reference: "Kuhnen 2003, DOI 10.3166/ejc.9.407-418",
        make: inverse,
    },
    FeedForwardKind {
        name: "learning",
        summary: "the inverse, corrected by ten trials on the plant; for references that repeat",
        reference: "Bristow, Tharayil & Alleyne 2006, DOI 10.1109/MCS.2006.1636313",
        make: learnt,
    },
];

/// First through the ends of the loop, then by what the model answers.
fn line(request: &FeedRequest) -> Result<FeedResult, Error> {
    let FeedRequest { model, r, ahead, .. } = *request;
    let (low, high) = request.settings.ends(model)?;
    let gain = model.linear().dc_gain() * (model.settled_before_linear(high) - model.settled_before_linear(low))
        / (high - low);
    if !(gain.is_finite() && gain != 0.0) {
        let because = format!("its gain from end to end is {gain}");
        return Err(Error::Unsuited { what: "straight line".into(), because });
    }
    crate::error::finite("reference", r)?;
    let (middle, last) = (mean(r), r.last().copied().unwrap_or(0.0));
    let along = |k: f64, u_0: f64, shift: usize| {
        let later = r.iter().skip(shift).copied().chain(std::iter::repeat_n(last, shift.min(r.len())));
        later.map(|r| k * (r - middle) + u_0).collect::<Vec<f64>>()
    };
    let left = |y: &[f64]| y.iter().zip(r).map(|(y, r)| (r - y) * (r - y)).sum::<f64>();
    let fitted = |shift: usize| {
        let (mut k, mut u_0) = (1.0 / gain, 0.5 * (low + high));
        let answer = |u: &[f64]| model.resume(&mut model.settled(u.first().copied().unwrap_or(0.0)), u);
        for _ in 0..STRAIGHTENED {
            let y = answer(&along(k, u_0, shift));
            let (centre, moved) = (mean(&y), scatter(&y));
            let together: f64 = y.iter().zip(r).map(|(y, r)| (y - centre) * (r - middle)).sum();
            if moved > 0.0 && together > 0.0 {
                k *= together / moved;
            }
            u_0 += (middle - centre) / gain;
        }
        let u = along(k, u_0, shift);
        (left(&answer(&u)), u)
    };
    let shifts = (0..=ahead.min(SHIFT)).map(fitted);
    let best = shifts.min_by(|a, b| a.0.total_cmp(&b.0));
    Ok(FeedResult { u: best.map(|(_, u)| u).unwrap_or_default(), ..FeedResult::default() })
}

fn inverse(request: &FeedRequest) -> Result<FeedResult, Error> {
    let FeedRequest { model, settings, r, ahead, .. } = *request;
    if ahead >= ALL {
        let made = FeedForward::new(model, settings)?.whole(r)?;
        return Ok(FeedResult { u: made.u, notes: made.notes, ..FeedResult::default() });
    }
    crate::error::finite("reference", r)?;
    let (Some(&first), Some(&last)) = (r.first(), r.last()) else { return Ok(FeedResult::default()) };
    let causal = Causal::new(model, settings, ahead)?;
    let (known, rest) = r.split_at(ahead.min(r.len()));
    let mut x = causal.settled_with_preview(first, known);
    let told = rest.iter().copied().chain(std::iter::repeat_n(last, known.len()));
    Ok(FeedResult { u: told.map(|r| causal.step(&mut x, r)).collect(), ..FeedResult::default() })
}

fn learnt(request: &FeedRequest) -> Result<FeedResult, Error> {
    let FeedRequest { model, settings, r, plant, .. } = *request;
    let Some(n) = period(r) else {
        return Err(Error::parameter("reference", "a path that never repeats", "must repeat to be learnt"));
    };
    let mut x = plant.initial();
    let periods = (SETTLES / (n as f64 * model.ts())).ceil() as usize;
    let mut tried = |u: &[f64]| {
        (0..periods).for_each(|_| drop(plant.resume(&mut x, u)));
        let mut sum = vec![0.0; n];
        for _ in 0..periods {
            sum.iter_mut().zip(plant.resume(&mut x, u)).for_each(|(sum, y)| *sum += y / periods as f64);
        }
        sum
    };
    let learnt = Learning::default().run(&mut tried, &FeedForward::new(model, settings)?, &r[..n])?;
    Ok(FeedResult {
        u: learnt.u.iter().copied().cycle().take(r.len()).collect(),
        trials: learnt.rms,
        after: Some(x),
        ..FeedResult::default()
    })
}

impl FeedForwardKind {
    /// The feed-forward called `name`.    ///
    /// # Errors
    /// [`Error::Unknown`] with the names there are.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        row("feed-forward", FEED_FORWARDS.iter(), |row| row.name, name)
    }
}
