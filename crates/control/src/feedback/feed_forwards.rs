//! Feed-forwards: voltages for a reference, computed before or during the run.
//!
//! ```text
//! gain           u_t = k (r_{t+s} - r_mean) + u_0     k, u_0 and s of least error in the model's response
//! feed-forward   u = model^-1 (r)                     all of r known, or a given number of samples of preview
//! learning       u_{j+1} from r - y_j                 trials on the plant, for periodic references
//! ```
//! `gain` is the best straight line for the given reference, shifted by up to as many samples as there are of preview.
//! Thus it is a fair baseline: the improvement by the others is not due to a badly chosen line.
//!
//! Reference: see the rows. It does not do: references that are generated during the run.
//!
//! Why: docs/decisions/control.md, "A scheme is a feed-forward with a controller".

use crate::compensation::{Causal, FeedForward, FeedForwardSettings, FirDesign, Learning};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::{Error, row};
use piezoid_numerics::series::{mean, scatter};
use piezoid_numerics::system::System;
use piezoid_records::waveform::period;
use serde::Serialize;

/// Time for which a trial settles, and then for which it is averaged, both rounded up to whole periods [s].
const SETTLES: f64 = 0.25;

/// Number of corrections of the straight line: its gain depends on the height of the loop.
const LINE_CORRECTIONS: usize = 4;

/// Largest preview of the straight line [samples].
const SHIFT: usize = 8;

/// Preview that counts as the whole reference [samples]: the one of the inverse for whole references.
pub(super) const ALL: usize = FirDesign::WHOLE.ahead;

/// The input of a feed-forward.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FeedForwardRequest<'a> {
    /// The model.
    pub model: &'a Model,
    /// Limits and clipping.
    pub settings: FeedForwardSettings,
    /// The reference [output unit].
    pub r: &'a [f64],
    /// Preview [samples].
    pub ahead: usize,
    /// The plant, for learning trials.
    pub plant: &'a dyn System,
}

/// A constant gain: `u = gain r + offset`, with the reference so much ahead.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Line {
    /// Its slope [input unit per output unit].
    pub gain: f64,
    /// The input for the displacement 0 [input unit].
    pub offset: f64,
    /// Time by which the input is ahead of the reference [s].
    pub lead: f64,
}

/// The output of a feed-forward.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FeedForwardResult {
    /// The voltages, one per sample of the reference [V].
    pub u: Vec<f64>,
    /// Rms error of each learning trial [output unit].
    pub trials: Vec<f64>,
    /// The constant gain, if it is one.
    pub line: Option<Line>,
    /// State of the plant after the trials.
    pub after: Option<Vec<f64>>,
    /// Remarks, one sentence each.
    pub notes: Vec<String>,
}

/// One kind of feed-forward: a row of [`FEED_FORWARDS`].
#[derive(Debug, Clone, Copy, Serialize)]
pub struct FeedForwardKind {
    /// Name in options and files.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Publication.
    pub reference: &'static str,
    /// Computes the feed-forward, or returns an error if the reference cannot be reached, or has to be periodic and is
    /// not.
    #[serde(skip)]
    pub(crate) make: fn(&FeedForwardRequest) -> Result<FeedForwardResult, Error>,
}

/// All feed-forwards; the first is the default.
pub static FEED_FORWARDS: &[FeedForwardKind] = &[
    FeedForwardKind {
        name: "gain",
        summary: "a constant gain from displacement to voltage: no compensation",
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
        summary: "the inverse, corrected by ten learning trials on the plant; for periodic references",
        reference: "Bristow, Tharayil & Alleyne 2006, DOI 10.1109/MCS.2006.1636313",
        make: learnt,
    },
];

/// Starts with the line through the ends of the loop, then corrects it by the response of the model.
fn line(request: &FeedForwardRequest) -> Result<FeedForwardResult, Error> {
    let FeedForwardRequest { model, r, ahead, .. } = *request;
    let (low, high) = request.settings.ends(model)?;
    let gain = model.linear().dc_gain() * (model.settled_before_linear(high) - model.settled_before_linear(low))
        / (high - low);
    if !(gain.is_finite() && gain != 0.0) {
        let because = format!("the gain between the ends of its input range is {gain}");
        return Err(Error::Unsuited { what: "feed-forward `gain`".into(), because });
    }
    piezoid_numerics::error::finite("reference", r)?;
    let (middle, last) = (mean(r), r.last().copied().unwrap_or(0.0));
    let along = |k: f64, u_0: f64, shift: usize| {
        let later = r.iter().skip(shift).copied().chain(std::iter::repeat_n(last, shift.min(r.len())));
        later.map(|r| k * (r - middle) + u_0).collect::<Vec<f64>>()
    };
    let squares = |y: &[f64]| y.iter().zip(r).map(|(y, r)| (r - y) * (r - y)).sum::<f64>();
    let fitted = |shift: usize| {
        let (mut k, mut u_0) = (1.0 / gain, 0.5 * (low + high));
        let answer = |u: &[f64]| model.resume(&mut model.settled(u.first().copied().unwrap_or(0.0)), u);
        for _ in 0..LINE_CORRECTIONS {
            let y = answer(&along(k, u_0, shift));
            let (centre, moved) = (mean(&y), scatter(&y));
            let together: f64 = y.iter().zip(r).map(|(y, r)| (y - centre) * (r - middle)).sum();
            if moved > 0.0 && together > 0.0 {
                k *= together / moved;
            }
            u_0 += (middle - centre) / gain;
        }
        let u = along(k, u_0, shift);
        (squares(&answer(&u)), u, Line { gain: k, offset: u_0 - k * middle, lead: shift as f64 * model.ts() })
    };
    let shifts = (0..=ahead.min(SHIFT)).map(fitted);
    let best = shifts.min_by(|a, b| a.0.total_cmp(&b.0));
    let (u, line) = best.map(|(_, u, line)| (u, line)).unzip();
    Ok(FeedForwardResult { u: u.unwrap_or_default(), line, ..Default::default() })
}

fn inverse(request: &FeedForwardRequest) -> Result<FeedForwardResult, Error> {
    let FeedForwardRequest { model, settings, r, ahead, .. } = *request;
    if ahead >= ALL {
        let result = FeedForward::new(model, settings)?.whole(r)?;
        return Ok(FeedForwardResult { u: result.u, notes: result.notes, ..Default::default() });
    }
    piezoid_numerics::error::finite("reference", r)?;
    let (Some(&first), Some(&last)) = (r.first(), r.last()) else { return Ok(FeedForwardResult::default()) };
    let causal = Causal::delayed(model, settings, ("preview", ahead))?;
    let (known, rest) = r.split_at(ahead.min(r.len()));
    let mut x = causal.settled_with_preview(first, known);
    let previewed = rest.iter().copied().chain(std::iter::repeat_n(last, known.len()));
    Ok(FeedForwardResult { u: previewed.map(|r| causal.step(&mut x, r)).collect(), ..Default::default() })
}

fn learnt(request: &FeedForwardRequest) -> Result<FeedForwardResult, Error> {
    let FeedForwardRequest { model, settings, r, plant, .. } = *request;
    let Some(n) = period(r) else {
        return Err(Error::Content(
            "the reference is not periodic, but learning needs a periodic one: leave learning out for it".into(),
        ));
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
    Ok(FeedForwardResult {
        u: learnt.u.iter().copied().cycle().take(r.len()).collect(),
        trials: learnt.rms,
        after: Some(x),
        ..Default::default()
    })
}

impl FeedForwardKind {
    /// The feed-forward called `name`.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the known names.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        row("feed-forward", FEED_FORWARDS.iter(), |row| row.name, name)
    }
}
