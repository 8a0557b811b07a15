//! Choice of order and delay: the simplest block that predicts held-out data as well as the best, or nearly.
//!
//! Orders from 1 on, until two in sequence gain less than 2 %, are fitted with every delay from 0 by output error to
//! the first part of each record and simulated over the last part. Single samples are never held out, because
//! neighbours are correlated. With s the mean square of a block's held-out error and s0 that of the best block, blocks
//! of time give several values of d = s - s0 and the standard error of their mean. (Both errors contain the same noise,
//! so their difference is known much better than either.) A block is as good as the best if d is within one standard
//! error of zero, if its rms is larger by less than a higher order must gain, or if its rms is below a ten-thousandth
//! of the peak-to-peak output, which is negligible. Of those blocks the lowest order is chosen, and for this order the
//! longest delay, because a first coefficient near zero makes the inverse ill-conditioned.
//!
//! A sweep shows each frequency once, so its end cannot be predicted from its beginning. If the last parts have input
//! power where the first parts have none, the blocks are fitted to and judged by all samples. Akaike's final prediction
//! error then stands for the held-out error, s = (n + p) / (n - p) sum e^2 / n, and the only criterion is the gain that
//! a higher order must have.
//!
//! Hastie, Tibshirani & Friedman 2009, The Elements of Statistical Learning, 7.10 (doi:10.1007/978-0-387-84858-7);
//! Akaike 1974 (doi:10.1109/TAC.1974.1100705).
//!
//! Why: docs/decisions/linear-block.md, "A higher order must reduce the held-out rms by 2 %".
//! Why: docs/decisions/linear-block.md, "A sweep is fitted and judged as a whole".

use super::free_run::{FreeRun, FreeRunError};
use super::output_error::{OutputError, Refinement, StartRecords, checked, search};
use super::{Arx, Orders};
use piezoid_numerics::error::Error;
use piezoid_numerics::fourier::plain_power;
use piezoid_numerics::number::short;
pub use piezoid_numerics::optimize::levenberg_marquardt::{self, SumOfSquares};
use piezoid_numerics::progress::Stage;
use piezoid_numerics::series::{ends, mean, scatter};
use piezoid_records::record::Record;
use rayon::prelude::*;

/// Candidates of the choice.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderSearch {
    /// Highest order that may be tried.
    pub order: usize,
    /// Longest delay [samples].
    pub delay: usize,
    /// Fits candidates on the threads of the current rayon pool; the result is the same.
    pub parallel: bool,
}

impl Default for OrderSearch {
    /// Orders to 8, delays to 3.
    fn default() -> Self {
        OrderSearch { order: 8, delay: 3, parallel: false }
    }
}

/// One row of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Orders; n poles have n + 1 coefficients of b after the delay.
    pub orders: Orders,
    /// The block fitted to the first parts.
    pub arx: Arx,
    /// Rms error of the free run over the held-out parts [output unit].
    pub held_out: f64,
    /// Held-out mean square less that of the best candidate [output unit squared].
    pub excess: f64,
    /// Standard error of `excess`, from its means over intervals of time.
    pub excess_error: f64,
    /// True if it predicts held-out data as well as the best.
    pub as_good: bool,
}

/// The choice.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderSelection {
    /// All fitted candidates, by order, then delay.
    pub candidates: Vec<Candidate>,
    /// Index of the chosen candidate.
    pub chosen: usize,
    /// The reason of the choice.
    pub reason: String,
    /// The chosen orders fitted to all samples.
    pub fit: OutputError,
}

/// Share of each record that is held out, at its end.
const HELD_OUT: f64 = 0.25;

/// Share by which a higher order must lower the held-out rms to be accepted.
const WORTH: f64 = 0.02;

/// After this number of orders in sequence without such a gain, higher ones are not tried: a mode needs two.
const ORDERS_WITHOUT_GAIN: usize = 2;

/// Share of the peak-to-peak output below which errors are negligible.
const NEGLIGIBLE: f64 = 1e-4;

/// Number of blocks of time in the held-out parts.
const BLOCKS: usize = 20;

/// Number of bands of input power.
const BANDS: usize = 10;

/// Least power of a band that the first parts show, over the mean of all bands.
const MIN_BAND_POWER_RATIO: f64 = 0.1;

/// Share of the power of the last parts in other bands, above which they are not held out.
const MAX_NEW_POWER_SHARE: f64 = 0.2;

/// Steps and tolerance sufficient to compare candidates.
const ROUGH: levenberg_marquardt::SearchSettings =
    levenberg_marquardt::SearchSettings { iterations: 20, tolerance: 1e-6, damping: 1e-3 };

/// Chooses order and delay of the linear block of `records`.
///
/// # Errors
/// Returns an error for order 0, records too short for the highest order, if no candidate can be
/// fitted (see [`OutputError::fit`]).
pub fn select(records: &[Record], settings: &OrderSearch) -> Result<OrderSelection, Error> {
    let highest = Orders { delay: settings.delay, ..Orders::of(settings.order) };
    if settings.order == 0 {
        return Err(Error::parameter("order", 0, "must be at least 1"));
    }
    let refinement = Refinement::default();
    let weights = checked(records, highest, &refinement)?;
    let (training, held_out) = cut(records)?;
    let is_swept = is_a_sweep(&training, &held_out);
    let (training, held_out) = if is_swept { (records.to_vec(), records.to_vec()) } else { (training, held_out) };
    checked(&training, highest, &refinement)?;
    checked(&held_out, highest, &refinement).map_err(|error| match error {
        Error::TooShort { what, have, need, remedy } => {
            Error::TooShort { what: format!("the part of {what} that is held out"), have, need, remedy }
        }
        other => other,
    })?;
    let start_records = StartRecords::new(&training, highest)?;

    let (mut fitted, mut refused) = (Vec::<Fitted>::new(), None::<Error>);
    let (mut least, mut without_gain) = (f64::INFINITY, 0);
    for n in 1..=settings.order {
        let fit = |delay| {
            let orders = Orders { delay, ..Orders::of(n) };
            let problem = FreeRunError { records: &training, weights: &weights, orders };
            let one_lower = Orders { delay, ..Orders::of(n - 1) };
            let lower = fitted.iter().map(|fitted| &fitted.fit).rfind(|fit| fit.orders == one_lower);
            let start = start_records.start(orders, &weights).map(|start| match lower {
                // A higher order can be at least as good as the lower one.
                Some(lower) if lower.minimum.cost < problem.cost(&start) => with_idle_pole(lower),
                _ => start,
            });
            let rough = Refinement { search: ROUGH, ..Refinement::default() };
            let fit = start.and_then(|start| search(&problem, &start, &rough, &mut Stage::ignore))?;
            Ok(Fitted::of(fit, &held_out, &weights, is_swept))
        };
        let all: Vec<_> = if settings.parallel {
            (0..=settings.delay).into_par_iter().map(fit).collect()
        } else {
            (0..=settings.delay).map(fit).collect()
        };
        for fit in all {
            match fit {
                Ok(fit) => fitted.push(fit),
                Err(why) => drop(refused.get_or_insert(why)),
            }
        }
        let now = fitted.iter().map(|fitted| fitted.predicted.sqrt()).fold(f64::INFINITY, f64::min);
        if now < (1.0 - WORTH) * least {
            (least, without_gain) = (now, 0);
        } else if fitted.last().is_some_and(|last| last.fit.orders.na == n) {
            without_gain += 1;
        }
        if without_gain == ORDERS_WITHOUT_GAIN {
            break;
        }
    }
    let Some((candidates, chosen, reason)) = choose(&fitted, &held_out, is_swept) else {
        let because = refused.map_or_else(String::new, |why| why.to_string());
        return Err(Error::Unidentifiable { what: "a linear block of any order".into(), because });
    };
    let start = &fitted[chosen].fit;
    let problem = FreeRunError { records, weights: &weights, orders: start.orders };
    let fit = search(&problem, &start.minimum.x, &refinement, &mut Stage::ignore)?;
    Ok(OrderSelection { candidates, chosen, reason, fit })
}

/// The theta of the same block with one more pole and a zero that cancels it.
fn with_idle_pole(fit: &OutputError) -> Vec<f64> {
    const POLE: f64 = 0.5;
    let (a, b) = fit.minimum.x.split_at(fit.orders.na);
    let times = |c: &[f64], first: f64| {
        let before = std::iter::once(first).chain(c.iter().copied());
        c.iter().copied().chain([0.0]).zip(before).map(|(c, before)| c - POLE * before).collect::<Vec<f64>>()
    };
    // The coefficient before a1 is -1; before b0 there is none.
    [times(a, -1.0), times(b, 0.0)].concat()
}

/// The first part of each record, and the held-out one at its end.
fn cut(records: &[Record]) -> Result<(Vec<Record>, Vec<Record>), Error> {
    let parts = records.iter().map(|r| {
        let at = ((1.0 - HELD_OUT) * r.len() as f64).round() as usize;
        Ok::<_, Error>((r.slice(0..at)?, r.slice(at..r.len())?))
    });
    Ok(parts.collect::<Result<Vec<_>, _>>()?.into_iter().unzip())
}

/// True if the last parts have input power at frequencies where the first parts have next to none.
fn is_a_sweep(first: &[Record], last: &[Record]) -> bool {
    let lines = |records: &[Record]| -> Vec<(f64, f64)> {
        let of = |r: &Record| {
            let power = plain_power(r.u()).into_iter().enumerate().skip(1);
            power.map(|(k, power)| (k as f64 / r.duration(), power)).collect::<Vec<_>>()
        };
        records.iter().flat_map(of).collect()
    };
    let sum = |lines: &[(f64, f64)]| lines.iter().map(|(_, power)| power).sum::<f64>();
    let (shown, mut unseen) = (lines(first), lines(last));
    unseen.sort_by(|p, q| p.0.total_cmp(&q.0));
    let (total, last_total) = (sum(&shown), sum(&unseen));
    // A line of a short part is as wide as one over its duration.
    let width = last.iter().map(|r| 1.0 / r.duration()).fold(0.0, f64::max);
    let mut below = 0.0;
    let band = |&(_, power): &(f64, f64)| {
        below += power;
        ((below - 0.5 * power) / last_total * BANDS as f64) as usize
    };
    let bands: Vec<usize> = unseen.iter().map(band).collect();
    let is_hidden = |lines: &[(f64, f64)]| {
        let (low, high) = (lines[0].0 - width, lines[lines.len() - 1].0 + width);
        let within = shown.iter().filter(|(hz, _)| (low..=high).contains(hz));
        within.map(|(_, power)| power).sum::<f64>() < MIN_BAND_POWER_RATIO / BANDS as f64 * total
    };
    let mut start = 0;
    let hidden = bands.chunk_by(|p, q| p == q).map(|band| {
        let lines = &unseen[start..start + band.len()];
        start += band.len();
        if is_hidden(lines) { sum(lines) } else { 0.0 }
    });
    hidden.sum::<f64>() > MAX_NEW_POWER_SHARE * last_total
}

/// A block with its held-out errors.
struct Fitted {
    fit: OutputError,
    squares: Vec<f64>,
    /// The held-out mean square, or what stands for it.
    predicted: f64,
}

impl Fitted {
    fn of(fit: OutputError, held_out: &[Record], weights: &[f64], is_swept: bool) -> Self {
        let squares = held_out_errors(&fit, held_out, weights);
        let (n, p) = (squares.len() as f64, 2.0 * fit.orders.na as f64 + 1.0);
        let predicted = mean(&squares) * if is_swept { (n + p) / (n - p) } else { 1.0 };
        Fitted { fit, squares, predicted }
    }
}

/// The table, the index of the choice and its reason; `None` without candidates.
fn choose(fitted: &[Fitted], held_out: &[Record], is_swept: bool) -> Option<(Vec<Candidate>, usize, String)> {
    let means: Vec<f64> = fitted.iter().map(|fitted| fitted.predicted).collect();
    let best = (0..fitted.len()).min_by(|&p, &q| means[p].total_cmp(&means[q]))?;
    let (low, high) = ends(held_out.iter().flat_map(|r| r.y()).copied());
    let candidate = |k: usize| {
        let fit = &fitted[k].fit;
        let differences = fitted[k].squares.iter().zip(&fitted[best].squares);
        let differences: Vec<f64> = differences.map(|(s, s0)| s - s0).collect();
        let (excess, excess_error) = (mean(&differences), standard_error(&differences));
        Candidate {
            orders: fit.orders,
            arx: fit.arx.clone(),
            held_out: means[k].sqrt(),
            excess,
            excess_error,
            as_good: (!is_swept && excess <= excess_error)
                || means[k].sqrt() <= ((1.0 + WORTH) * means[best].sqrt()).max(NEGLIGIBLE * (high - low)),
        }
    };
    let candidates: Vec<Candidate> = (0..fitted.len()).map(candidate).collect();
    let order = candidates.iter().filter(|c| c.as_good).map(|c| c.orders.na).min()?;
    let chosen = candidates.iter().rposition(|c| c.orders.na == order && c.as_good)?;
    let reason = reason(&candidates, chosen, best, is_swept, held_out.first()?.units().y.as_str());
    Some((candidates, chosen, reason))
}

/// The weighted squared errors of the free run over the held-out parts, as one series. Past and offset are fitted to
/// each part, because sensors drift.
fn held_out_errors(fit: &OutputError, held_out: &[Record], weights: &[f64]) -> Vec<f64> {
    let run = |(record, weight): (&Record, &f64)| {
        let e = FreeRun::new(record, fit.orders, &fit.minimum.x).e;
        let fitted = (fit.orders.history() + 1) as f64;
        let share = weight * e.len() as f64 / (e.len() as f64 - fitted);
        e.into_iter().map(move |e| share * e * e).collect::<Vec<_>>()
    };
    held_out.iter().zip(weights).flat_map(run).collect()
}

/// The standard error of the mean of a correlated series, from the means of blocks.
fn standard_error(x: &[f64]) -> f64 {
    let means: Vec<f64> = x.chunks_exact(x.len().div_ceil(BLOCKS).max(1)).map(mean).collect();
    let k = means.len() as f64;
    (scatter(&means) / (k * (k - 1.0).max(1.0))).sqrt()
}

fn reason(candidates: &[Candidate], chosen: usize, best: usize, is_swept: bool, unit: &str) -> String {
    let (c, b, all) = (&candidates[chosen], &candidates[best], candidates.len());
    let name = |c: &Candidate| format!("order {} with delay {}", c.orders.na, c.orders.delay);
    let what =
        if is_swept { "rms error over all samples (a sweep: no part was held out)" } else { "held-out rms error" };
    let held_out = format!("{}: {what} {} {unit}", name(c), short(c.held_out));
    if chosen == best {
        return format!("{held_out}, the smallest of {all} blocks; no simpler block is as good");
    }
    let error = short(c.excess_error);
    let significance = if is_swept {
        "too little to justify more coefficients".into()
    } else if c.excess <= c.excess_error {
        format!("not significant (standard error {error})")
    } else {
        format!("significant (standard error {error}), but too small to justify more coefficients")
    };
    let (least, difference, best) = (short(b.held_out), short(c.excess), name(b));
    format!(
        "{held_out}; of {all} blocks, {best} has the smallest, {least} {unit}: its mean squared error is {difference} \
         {unit}^2 less, {significance}; no simpler block is as good"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::output_error::tests::pl140;
    use piezoid_numerics::system::System;
    use piezoid_records::excitation::{Chirp, Prbs};
    use piezoid_testing::{assert_close, noise};

    const TS: f64 = 5e-4;

    #[test]
    fn the_pl140_has_order_5_or_6_for_any_noise() {
        for seed in 1..=5 {
            let settings = OrderSearch { delay: 2, ..OrderSearch::default() };
            let found = select(&[pl140(seed, 4094)], &settings).unwrap();
            let Orders { na, delay, .. } = found.fit.orders;
            assert!((5..=6).contains(&na) && delay <= 1, "seed {seed}: {}", found.reason);
            assert!((0.19..0.212).contains(&found.fit.rms[0]), "{:?}", found.fit.rms);
            let resonance = found.fit.arx.resonance().unwrap();
            assert_close(&[resonance.hz, resonance.damping], &[166.3, 0.03], 2e-3, 3e-4);
        }
    }

    /// A block of order 3 with a delay of 2 samples.
    fn delayed_block() -> Arx {
        Arx::new(TS, vec![1.2, -0.9, 0.2], vec![0.0, 0.0, 1.0, 0.4, -0.3, 0.2]).unwrap()
    }

    /// A record of it with white output noise of 2 %.
    fn delayed(seed: u64) -> Record {
        let u = Prbs::default().samples(TS, 2047).unwrap();
        let y = delayed_block().simulate(&u).iter().zip(noise(seed, 2047)).map(|(y, e)| y + 0.03 * e).collect();
        Record::new(TS, u, y).unwrap()
    }

    #[test]
    fn the_true_order_and_delay_are_chosen() {
        for seed in 0..10 {
            let found = select(&[delayed(seed)], &OrderSearch::default()).unwrap();
            assert_eq!((found.fit.orders.na, found.fit.orders.delay), (3, 2), "seed {seed}: {}", found.reason);
            assert_eq!(found.candidates.last().unwrap().orders.na, 5, "two orders without a gain are enough");
        }
    }

    #[test]
    fn a_mode_at_the_end_of_a_sweep_is_found() {
        let mode = Arx::new(TS, vec![1.9, -0.99], vec![0.09]).unwrap();
        let sweep = Chirp { frequency_start: 1.0, frequency_end: 120.0, logarithmic: true, ..Chirp::default() };
        let u = sweep.samples(TS, 6000).unwrap();
        let y = mode.simulate(&u).iter().zip(noise(3, 6000)).map(|(y, e)| y + 0.05 * e).collect();
        let found = select(&[Record::new(TS, u, y).unwrap()], &OrderSearch::default()).unwrap();
        assert_eq!(found.fit.orders.na, 2, "{}", found.reason);
        assert_close(found.fit.arx.a(), mode.a(), 1e-3, 0.0);
        assert!(found.reason.contains("a sweep"), "{}", found.reason);
    }

    #[test]
    fn steady_inputs_are_no_sweeps() {
        let sine = |hz: f64| (0..2000).map(|t| (hz * 0.0031416 * f64::from(t)).sin()).collect::<Vec<_>>();
        let two: Vec<f64> = sine(10.7).iter().zip(sine(31.3)).map(|(p, q)| p + q).collect();
        let square = sine(7.3).iter().map(|u| u.signum()).collect();
        let prbs = Prbs::default().samples(TS, 2047).unwrap();
        for u in [sine(10.67), two, square, prbs, noise(1, 2000)] {
            let records = [Record::new(TS, u.clone(), u).unwrap()];
            let (first, last) = cut(&records).unwrap();
            assert!(!is_a_sweep(&first, &last));
        }
    }

    #[test]
    fn a_lower_order_within_one_standard_error_is_chosen_but_not_on_a_sweep() {
        let records = [delayed(1)];
        let best = OutputError::fit(&records, Orders::of(2), &Refinement::default(), &mut Stage::ignore).unwrap();
        let lower = OutputError { orders: Orders::of(1), ..best.clone() };
        // 5 % worse in the mean of blocks that differ by 30 %: by less than the standard error, and by more than 2 % rms.
        let worse = (0..2000).map(|t| 1.05 + 0.3 * (f64::from(t / 100 % 4) - 1.5)).collect();
        let fitted = |squares: Vec<f64>, fit| Fitted { fit, predicted: mean(&squares), squares };
        let both = [fitted(worse, lower), fitted(vec![1.0; 2000], best)];
        let chosen = |is_swept| choose(&both, &records, is_swept).unwrap().1;
        assert_eq!([false, true].map(chosen), [0, 1]);
    }

    #[test]
    fn threads_do_not_change_the_choice_for_several_records() {
        let records = [delayed(1).part(0.0, 0.5).unwrap(), delayed(2).part(0.5, 1.0).unwrap()];
        let few = OrderSearch { order: 4, delay: 3, ..OrderSearch::default() };
        let one = select(&records, &few).unwrap();
        assert_eq!((one.fit.orders.na, one.fit.orders.delay), (3, 2), "{}", one.reason);
        assert_eq!(select(&records, &OrderSearch { parallel: true, ..few }).unwrap(), one);
    }

    #[test]
    fn a_cancelled_pole_does_not_change_the_cost() {
        let records = [delayed(1)];
        let orders = Orders { na: 2, nb: 3, delay: 1 };
        let fit = OutputError::fit(&records, orders, &Refinement::default(), &mut Stage::ignore).unwrap();
        let higher = FreeRunError { records: &records, weights: &[1.0], orders: Orders { na: 3, nb: 4, delay: 1 } };
        assert_close(&[higher.cost(&with_idle_pole(&fit))], &[fit.minimum.cost], 1e-2, 0.0);
    }

    #[test]
    fn the_true_order_is_chosen_without_noise() {
        let truth = delayed_block();
        let u = Prbs::default().samples(TS, 2047).unwrap();
        let record = Record::new(TS, u.clone(), truth.simulate(&u)).unwrap();
        let found = select(&[record], &OrderSearch::default()).unwrap();
        assert_eq!((found.fit.orders.na, found.fit.orders.delay), (3, 2), "{}", found.reason);
    }

    #[test]
    fn bad_settings_and_constant_records_are_errors() {
        let message = |settings: OrderSearch| select(&[delayed(1)], &settings).unwrap_err().to_string();
        assert!(message(OrderSearch { order: 0, ..OrderSearch::default() }).starts_with("order = 0"));
        assert!(message(OrderSearch { order: 200, ..OrderSearch::default() }).contains("at least"));
        let still = Record::new(TS, vec![1.0; 900], vec![2.0; 900]).unwrap();
        assert!(select(&[still], &OrderSearch::default()).unwrap_err().to_string().contains("any order"));
    }

    #[test]
    fn order_and_delay_of_a_known_block_are_found() {
        let truth = Arx::new(5e-4, vec![1.7, -0.9], vec![0.0, 3.0, 2.5]).unwrap();
        let u: Vec<f64> = (0..1200).map(|t| f64::from((t * t % 101 % 13) as u8) - 6.0).collect();
        let noise = |t: usize| (t * t * 7919 % 1031) as f64 / 1031.0 - 0.5;
        let y = truth.simulate(&u).iter().enumerate().map(|(t, y)| y + noise(t)).collect();
        let few = OrderSearch { order: 3, delay: 1, ..OrderSearch::default() };
        let chosen = select(&[Record::new(5e-4, u, y).unwrap()], &few).unwrap();
        assert_eq!((chosen.fit.orders.na, chosen.fit.orders.delay), (2, 1));
    }
}
