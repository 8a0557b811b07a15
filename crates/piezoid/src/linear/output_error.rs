//! Output error: the block whose free run comes closest to the records.
//!
//! ```text
//! min over a, b, and for each record its past c and offset k, of  sum over records of weight sum_t e_t^2
//! y_t = B(q) / A(q) u_t + C(q) / A(q) d_t + k + e_t
//! ```
//! With white noise in y it has no bias and the least variance there is; least squares on (1) has neither. The past of a
//! record is free: one that begins at rest with a step is not taken to have stood at its first input. How past and offset
//! are taken out, and the exact slopes: `free_run.rs`. Searched by Levenberg-Marquardt, which refuses unstable blocks.
//!
//! Ljung 1998, System Identification: Theory for the User. The error has more than one minimum: [`OutputError::fit`] starts
//! from instrumental variables, begun at least squares and at filters that know nothing, and keeps the best. A Record whose u is a hidden variable z fits as well as one of a voltage.

use super::fit::least_squares;
use super::free_run::FreeRunError;
use super::instrumental::{ROUGH, rounds};
use super::inverse::monic;
use super::regression::{Orders, Regression};
use super::uncertainty;
use super::{Arx, Root};
use crate::error::{Error, positive};
use crate::optimize::levenberg_marquardt::{self, SumOfSquares};
use crate::optimize::{Minimum, Reason};
use crate::progress::{Progress, Stage};
use crate::record::Record;

/// How to refine.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Refinement {
    /// What each record's squared errors count, in the ratio of 1 / (variance of its noise); empty counts all alike.
    pub weights: Vec<f64>,
    /// The search.
    pub(crate) search: levenberg_marquardt::SearchSettings,
}

/// A block by output error.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputError {
    /// The block.
    pub arx: Arx,
    /// Its orders: what of `arx` was free.
    pub orders: Orders,
    /// For each record, the constant in its output [output unit].
    pub offsets: Vec<f64>,
    /// For each record, the rms of what the free run leaves [output unit].
    pub rms: Vec<f64>,
    /// Samples, less the parameters and the pasts and offsets that were fitted to them.
    pub freedom: usize,
    /// Covariance of theta = [a, b after the delay], row by row; it allows for residuals that are not white. Infinite
    /// where the records cannot tell.
    pub covariance: Vec<f64>,
    /// The search: theta, the weighted sum of squares and its course, and why it ended.
    pub minimum: Minimum,
}

impl OutputError {
    /// The block of `orders` by output error, from starts of its own.
    ///
    /// ```
    /// use piezoid::{Record, System, linear::{Arx, Orders, OutputError, Refinement}};
    /// let truth = Arx::new(5e-4, vec![1.7, -0.9], vec![0.0, 3.0, 2.5])?;
    /// let u: Vec<f64> = (0..600).map(|t| f64::from((t * t % 13) as u8) - 6.0).collect();
    /// let noise = |t: usize| (t * 7919 % 31) as f64 / 31.0 - 0.5;
    /// let y = truth.simulate(&u).iter().enumerate().map(|(t, y)| y + 7.0 + noise(t)).collect();
    /// let record = Record::new(5e-4, u, y)?;
    /// let orders = Orders { na: 2, nb: 2, delay: 1 };
    /// let found = OutputError::fit(&[record], orders, &Refinement::default(), &mut piezoid::progress::silent)?;
    /// assert!((found.arx.a()[0] - 1.7).abs() < 1e-3 && (found.offsets[0] - 7.0).abs() < 0.05);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Regression::new`]; weights that are not one positive number a record; too few samples for the pasts and offsets;
    /// [`Error::Cancelled`].
    pub fn fit(
        records: &[Record],
        orders: Orders,
        settings: &Refinement,
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        let weights = checked(records, orders, settings)?;
        let problem = FreeRunError { records, weights: &weights, orders };
        let start = StartRecords::new(records, orders)?.start(orders, &weights)?;
        search(&problem, &start, settings, progress)
    }
}

/// The block of least output error that `start` leads to. The zeros that `start.b()` begins with stay.
///
/// # Errors
/// As [`OutputError::fit`]; and a start that is unstable.
pub(crate) fn refine(
    records: &[Record],
    start: &Arx,
    settings: &Refinement,
    progress: &mut Progress,
) -> Result<OutputError, Error> {
    let (na, delay) = (start.a().len(), start.delay());
    let orders = Orders { na, nb: start.b().len() - delay, delay };
    let weights = checked(records, orders, settings)?;
    if !start.is_stable() {
        let rule = "must be stable, or its free run grows without bound";
        return Err(Error::parameter("start", format!("a = {:?}", start.a()), rule));
    }
    let problem = FreeRunError { records, weights: &weights, orders };
    search(&problem, &[start.a(), &start.b()[delay..]].concat(), settings, progress)
}

/// One weight a record, once all fits together.
pub(super) fn checked(records: &[Record], orders: Orders, settings: &Refinement) -> Result<Vec<f64>, Error> {
    orders.check(records)?;
    for (k, record) in records.iter().enumerate() {
        let need = 2 * (orders.history() + 1) + orders.parameters().div_ceil(records.len());
        if record.len() < need {
            let remedy = "record longer, leave it out, or choose a lower order or delay".into();
            return Err(Error::TooShort { what: format!("record {}", k + 1), have: record.len(), need, remedy });
        }
    }
    if settings.weights.is_empty() {
        return Ok(vec![1.0; records.len()]);
    }
    if settings.weights.len() != records.len() {
        return Err(Error::Lengths {
            left: "the list of weights".into(),
            left_len: settings.weights.len(),
            right: "the list of records".into(),
            right_len: records.len(),
        });
    }
    settings.weights.iter().try_for_each(|&w| positive("weight", w, "squared errors").map(drop))?;
    Ok(settings.weights.clone())
}

/// Samples that are enough to start from.
const ENOUGH: usize = 8192;

/// Poles of filters that know nothing of the block: of a fast one, and of a slow one for records that are sampled often.
const BLANK: [f64; 2] = [0.5, 0.8];

/// The beginnings of the records, as long together as is enough to start from.
pub(super) struct StartRecords(Vec<Record>);

impl StartRecords {
    /// For blocks of up to `orders`.
    pub(super) fn new(records: &[Record], orders: Orders) -> Result<Self, Error> {
        let samples: usize = records.iter().map(Record::len).sum();
        let share = (ENOUGH as f64 / samples as f64).min(1.0);
        let least = 8 * (orders.history() + orders.parameters());
        let beginning = |r: &Record| match ((share * r.len() as f64).ceil() as usize).max(least) {
            n if n < r.len() => Record::new(r.ts(), r.u()[..n].to_vec(), r.y()[..n].to_vec()),
            _ => Ok(r.clone()),
        };
        Ok(StartRecords(records.iter().map(beginning).collect::<Result<_, _>>()?))
    }

    /// Where a search for a block of `orders` starts: the best free run of instrumental variables begun at the poles of
    /// least squares, and at those of blank filters, which noise and often sampled records do not mislead.
    pub(super) fn start(&self, orders: Orders, weights: &[f64]) -> Result<Vec<f64>, Error> {
        let problem = FreeRunError { records: &self.0, weights, orders };
        let (theta, _) = least_squares(&Regression::new(&self.0, orders)?)?;
        let blank = |pole| monic(&vec![Root { re: pole, im: 0.0 }; orders.na]).iter().map(|c| -c).collect::<Vec<f64>>();
        let mut best = rounds(&problem, &theta[..orders.na], ROUGH);
        for other in BLANK.map(|pole| rounds(&problem, &blank(pole), ROUGH)) {
            if other.cost < best.cost {
                best = other;
            }
        }
        Ok(best.theta)
    }
}

/// From `start` to the minimum it leads to.
pub(super) fn search(
    problem: &FreeRunError,
    start: &[f64],
    settings: &Refinement,
    progress: &mut Progress,
) -> Result<OutputError, Error> {
    let named = &mut |stage: Stage| progress(Stage { what: "output error", ..stage });
    let minimum = levenberg_marquardt::minimise(problem, start, &settings.search, named)?;
    if minimum.reason == Reason::Cancelled {
        let (done, total) = (minimum.history.len() - 1, settings.search.iterations);
        return Err(Error::Cancelled { what: "the output-error search".into(), done, total });
    }
    let Orders { na, delay, .. } = problem.orders;
    let (a, b) = minimum.x.split_at(na);
    let b = std::iter::repeat_n(0.0, delay).chain(b.iter().copied()).collect();
    let arx = Arx::new(problem.records[0].ts(), a.to_vec(), b)?;
    let runs: Vec<_> = problem.runs(&minimum.x).map(|(run, _)| run).collect();
    let rms = |e: &[f64]| (e.iter().map(|e| e * e).sum::<f64>() / e.len() as f64).sqrt();
    let samples: usize = problem.records.iter().map(Record::len).sum();
    let freedom = samples - problem.records.len() * (problem.orders.history() + 1) - problem.dimension();
    Ok(OutputError {
        arx,
        orders: problem.orders,
        offsets: runs.iter().map(|run| run.offset).collect(),
        rms: runs.iter().map(|run| rms(&run.e)).collect(),
        freedom,
        covariance: uncertainty::covariance(problem, &minimum.x, freedom),
        minimum,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::Prbs;
    use crate::plant::Plant;
    use crate::progress::silent;
    use crate::system::System;
    use crate::testing::assert_close;
    use std::ops::ControlFlow;

    const TS: f64 = 5e-4;

    fn found(records: &[Record], orders: Orders) -> OutputError {
        OutputError::fit(records, orders, &Refinement::default(), &mut silent).unwrap()
    }

    /// The twin from rest, under a PRBS that begins with a step.
    fn pl140(seed: u64) -> Record {
        let u = Prbs::default().samples(TS, 2 * 2047).unwrap();
        let plant = Plant::named("pl140", TS).unwrap().with_seed(seed);
        let y = plant.run(&u).y.iter().map(|y| 1e6 * y).collect();
        Record::new(TS, u, y).unwrap()
    }

    #[test]
    fn a_record_that_begins_at_rest_with_a_step_leaves_no_more_than_its_noise() {
        let fit = found(&[pl140(1)], Orders { delay: 1, ..Orders::of(5) });
        assert!((0.19..0.21).contains(&fit.rms[0]), "{} um", fit.rms[0]);
        // Had it been taken to have stood at u[0]:
        let (record, arx) = (pl140(1), &fit.arx);
        let settled = arx.resume(&mut arx.settled(record.u()[0]), record.u());
        let left = record.y().iter().zip(&settled).map(|(y, s)| (y - s - fit.offsets[0]).powi(2)).sum::<f64>();
        assert!((left / record.len() as f64).sqrt() > 0.8, "the start should matter");
    }

    #[test]
    fn the_start_does_not_depend_on_luck() {
        for (n, most) in [(3, 1.40), (4, 0.225), (5, 0.212), (6, 0.210), (7, 0.210)] {
            for seed in 1..=4 {
                let fit = found(&[pl140(seed)], Orders { delay: 1, ..Orders::of(n) });
                assert!(fit.rms[0] < most, "order {n}, seed {seed}: {} um", fit.rms[0]);
            }
        }
    }

    #[test]
    fn several_records_with_weights_are_one_problem() {
        let truth = Arx::new(TS, vec![1.7, -0.9], vec![3.0, 2.5]).unwrap();
        let u: Vec<f64> = (0..900).map(|t| f64::from((t * t % 103 % 17) as u8) - 8.0).collect();
        let y: Vec<f64> = truth.simulate(&u).iter().enumerate().map(|(t, y)| y + (t as f64 * 1.3).sin()).collect();
        let whole = Record::new(TS, u, y).unwrap();
        let parts = [whole.part(0.0, 0.2).unwrap(), whole.part(0.2, 0.45).unwrap()];
        let orders = Orders { na: 2, nb: 2, delay: 0 };
        let weighted = Refinement { weights: vec![2.0, 2.0], ..Refinement::default() };
        let (plain, doubled) =
            (found(&parts, orders), OutputError::fit(&parts, orders, &weighted, &mut silent).unwrap());
        assert_close(doubled.arx.a(), plain.arx.a(), 1e-8, 0.0);
        assert_close(&doubled.covariance, &plain.covariance, 1e-4, 0.0);
        // A record repeated is a record of twice the weight.
        let repeated = found(&[parts[0].clone(), parts[1].clone(), parts[1].clone()], orders);
        let weighted = Refinement { weights: vec![1.0, 2.0], ..Refinement::default() };
        let weighted = OutputError::fit(&parts, orders, &weighted, &mut silent).unwrap();
        assert_close(weighted.arx.b(), repeated.arx.b(), 1e-8, 0.0);
    }

    #[test]
    fn refining_keeps_the_delay_and_finds_the_same_minimum_from_elsewhere() {
        let record = [pl140(2)];
        let own = found(&record, Orders { na: 2, nb: 2, delay: 1 });
        let start = Arx::new(TS, vec![1.6, -0.8], vec![0.0, 3.0, 3.0]).unwrap();
        let refined = refine(&record, &start, &Refinement::default(), &mut silent).unwrap();
        assert_close(refined.arx.a(), own.arx.a(), 1e-6, 0.0);
        assert_eq!((refined.arx.delay(), refined.minimum.reason), (1, Reason::Converged));
    }

    #[test]
    fn what_cannot_be_refined_is_refused() {
        let record = pl140(1);
        let message = |records: &[Record], start: &Arx, settings: &Refinement| {
            refine(records, start, settings, &mut silent).unwrap_err().to_string()
        };
        let (plain, stable) = (Refinement::default(), Arx::new(TS, vec![0.5], vec![1.0]).unwrap());
        let unstable = Arx::new(TS, vec![1.5], vec![1.0]).unwrap();
        assert!(message(std::slice::from_ref(&record), &unstable, &plain).contains("must be stable"));
        let short = record.part(0.0, 0.001).unwrap();
        assert!(message(&[record.clone(), short], &stable, &plain).starts_with("record 2 has 2 samples"));
        let weights = Refinement { weights: vec![1.0, 2.0], ..Refinement::default() };
        assert!(message(std::slice::from_ref(&record), &stable, &weights).contains("list of weights has 2"));
        let mut stop = |_: Stage| ControlFlow::Break(());
        let cancelled = refine(&[record], &stable, &plain, &mut stop).unwrap_err();
        assert!(matches!(cancelled, Error::Cancelled { .. }), "{cancelled}");
    }
}
