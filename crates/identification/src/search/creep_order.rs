//! The order of creep that is a power of time: the gains of the lags are a power of their time constants (see
//! [`Creep::fractional`]).
//!
//! For a fixed order the fit is that of any creep, with one gain. The order is where the minimum of this fit is least:
//! by parabolas through three of them, after a coarse search. Their curvature gives its standard error,
//! ```text
//! error^2 = 2 S / (n S''),    n = samples / 100
//! ```
//! because the errors of a model are alike from sample to sample.

use super::fit::{
    CreepOrder, Estimate, Fitted, FreeParameters, SAMPLES_PER_ERROR, Smoothness, refine_from, refine_to_minimum,
};
use super::{Candidate, Search, creep_lags};
use libm::{fabs, pow, sqrt};
use piezoid_models::creep::{Creep, Lag};
use piezoid_numerics::error::Error;

/// The orders of the coarse search, and the number of parabolas after it.
const ORDERS: [f64; 7] = [0.01, 0.15, 0.3, 0.45, 0.6, 0.8, 0.95];
const PARABOLAS: usize = 4;

/// Distance of two orders that are the same.
const SAME: f64 = 1e-4;

/// Slower lags than those of other creep [decades]: they add to the drift within a record.
const SLOWER_DECADES: f64 = 1.0;

/// The move: the same candidate with creep of one order.
pub(super) fn fit_order(candidate: &Candidate, search: &mut Search) -> Result<Option<Candidate>, Error> {
    let lags = creep_lags(&search.runs);
    let (Some(first), Some(last)) = (lags.first(), lags.last()) else { return Ok(None) };
    let (from, to) = (first.tau_s, last.tau_s * pow(10.0, SLOWER_DECADES));
    let estimate = &candidate.fitted.estimate;
    // The creep of the candidate over the longest record.
    let duration = search.runs.iter().map(|run| run.record.duration()).fold(0.0, f64::max);
    let crept = Creep::new(estimate.ts(), estimate.lags.clone())?.after(duration).max(f64::MIN_POSITIVE);
    let mut fits: Vec<(f64, Fitted)> = Vec::new();
    let fit = |order: f64, from_fit: &Fitted, search: &mut Search| -> Result<(f64, Fitted), Error> {
        let watch = &mut search.reporter.last_stage(candidate.operator.name);
        let relative = Creep::fractional(estimate.ts(), 1.0, order, (from, to))?;
        let scale = crept / relative.after(duration);
        let lags = relative.lags().iter().map(|lag| Lag { gain: scale * lag.gain, ..*lag }).collect();
        let creep_order = Some(CreepOrder { value: order, error: f64::NAN });
        let start = Estimate { lags, creep_order, ..from_fit.estimate.clone() };
        let smoothness = Smoothness::Fixed(from_fit.held_out.lambda);
        let fitted = refine_from(start, smoothness, &mut search.runs, FreeParameters::All, watch)?;
        Ok((order, refine_to_minimum(&fitted, &mut search.runs, watch)?))
    };
    for order in ORDERS {
        let near = fits.last().map_or(&candidate.fitted, |(_, fitted)| fitted).clone();
        fits.push(fit(order, &near, search)?);
    }
    for _ in 0..PARABOLAS {
        let best = least(&fits);
        let order = match vertex(&fits, best) {
            Some((order, _)) if fits.iter().all(|(other, _)| fabs(order - other) > SAME) => order,
            _ => break,
        };
        let near = fits[best].1.clone();
        let next = fit(order, &near, search)?;
        let at = fits.partition_point(|(other, _)| *other < order);
        fits.insert(at, next);
    }
    let best = least(&fits);
    let samples: usize = search.runs.iter().map(|run| run.record.len()).sum();
    let error = vertex(&fits, best).map_or(f64::NAN, |(_, bend)| {
        sqrt(2.0 * fits[best].1.minimum / (bend * (samples as f64 / SAMPLES_PER_ERROR).max(1.0)))
    });
    if best == 0 || best + 1 == fits.len() {
        let (low, high) = (ORDERS[0], ORDERS[ORDERS.len() - 1]);
        search.notes.push(format!(
            "the order of creep is at an end of the range that is tried, {low} to {high}: creep may be logarithmic (order \
             0), or no power of time; leave --fractional-creep out"
        ));
    }
    let (order, mut fitted) = fits.swap_remove(best);
    fitted.estimate.creep_order = Some(CreepOrder { value: order, error });
    Ok(Some(candidate.with_fit(fitted)))
}

/// The number of the fit with the least minimum.
fn least(fits: &[(f64, Fitted)]) -> usize {
    (0..fits.len()).min_by(|&i, &j| fits[i].1.minimum.total_cmp(&fits[j].1.minimum)).unwrap_or_default()
}

/// The lowest point of the parabola through a fit and its neighbours, and its second derivative; `None` at the ends, or
/// if it has no lowest point.
fn vertex(fits: &[(f64, Fitted)], k: usize) -> Option<(f64, f64)> {
    let [(x, a), (y, b), (z, c)] = fits.get(k.checked_sub(1)?..k + 2)? else { return None };
    let (first, second) = ((b.minimum - a.minimum) / (y - x), (c.minimum - b.minimum) / (z - y));
    let bend = 2.0 * (second - first) / (z - x);
    (bend > 0.0).then(|| (0.5 * (x + y) - first / bend, bend))
}
