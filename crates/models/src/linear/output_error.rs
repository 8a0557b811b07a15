//! Output error: the block with the smallest free-run error.
//!
//! ```text
//! min over a, b, and for each record its past c and offset k, of  sum over records of weight sum_t e_t^2
//! y_t = B(q) / A(q) u_t + C(q) / A(q) d_t + k + e_t
//! ```
//! With white noise in y it has no bias and minimum variance; least squares on (1) has neither. The past of a record is
//! free: a record that starts at rest with a step is not assumed settled at its first input. `free_run.rs` has the
//! elimination of past and offset, and the exact derivatives. The search is Levenberg-Marquardt and rejects unstable
//! blocks.
//!
//! Ljung 1998, System Identification: Theory for the User. The error has several minima: [`OutputError::fit`] starts
//! from instrumental variables, initialised by least squares and by fixed filters, and keeps the best. The u of a
//! record may also be a hidden variable z.
//!
//! Why: docs/decisions/linear-block.md, "Output error estimates the initial state of every record".
//! Why: docs/decisions/linear-block.md, "Output error starts from instrumental variables".

use super::fit::least_squares;
use super::free_run::FreeRunError;
use super::instrumental::{ROUGH, rounds};
use super::inverse::monic;
use super::regression::{Orders, Regression};
use super::uncertainty;
use super::{Arx, Root};
use piezoid_numerics::error::{Error, positive};
pub(super) use piezoid_numerics::optimize::levenberg_marquardt::{self, SumOfSquares};
use piezoid_numerics::optimize::{Minimum, Reason};
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_records::record::Record;

/// Options of the refinement.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Refinement {
    /// Weight of each record's squared errors, in proportion to 1 / (variance of its noise); empty for equal weights.
    pub weights: Vec<f64>,
    /// The search.
    pub search: levenberg_marquardt::SearchSettings,
}

/// A block by output error.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputError {
    /// The block.
    pub arx: Arx,
    /// Its orders: the free coefficients of `arx`.
    pub orders: Orders,
    /// Output offset of each record [output unit].
    pub offsets: Vec<f64>,
    /// Rms residual of the free run for each record [output unit].
    pub rms: Vec<f64>,
    /// Degrees of freedom: samples less the fitted parameters, initial states and offsets.
    pub freedom: usize,
    /// Covariance of theta = [a, b after the delay], row by row, also valid for coloured residuals. Infinite where the
    /// records do not determine theta.
    pub covariance: Vec<f64>,
    /// The search: theta, the weighted sum of squares by iteration, and why it ended.
    pub minimum: Minimum,
}

impl OutputError {
    /// The block of `orders` by output error, with automatic starting values.
    ///
    /// ```
    /// use piezoid::{Record, System, linear::{Arx, Orders, OutputError, Refinement}};
    /// let truth = Arx::new(5e-4, vec![1.7, -0.9], vec![0.0, 3.0, 2.5])?;
    /// let u: Vec<f64> = (0..600).map(|t| f64::from((t * t % 13) as u8) - 6.0).collect();
    /// let noise = |t: usize| (t * 7919 % 31) as f64 / 31.0 - 0.5;
    /// let y = truth.simulate(&u).iter().enumerate().map(|(t, y)| y + 7.0 + noise(t)).collect();
    /// let record = Record::new(5e-4, u, y)?;
    /// let orders = Orders { na: 2, nb: 2, delay: 1 };
    /// let found = OutputError::fit(&[record], orders, &Refinement::default(), &mut piezoid::progress::Stage::ignore)?;
    /// assert!((found.arx.a()[0] - 1.7).abs() < 1e-3 && (found.offsets[0] - 7.0).abs() < 0.05);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Regression::new`]; weights that are not one positive number per record; too few samples for
    /// pasts and offsets; [`Error::Cancelled`].
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

/// The block with minimum output error near `start`. The leading zeros of `start.b()` stay.
///
/// # Errors
/// The errors of [`OutputError::fit`]; an unstable start.
pub fn refine(
    records: &[Record],
    start: &Arx,
    settings: &Refinement,
    progress: &mut Progress,
) -> Result<OutputError, Error> {
    let (na, delay) = (start.a().len(), start.delay());
    let orders = Orders { na, nb: start.b().len() - delay, delay };
    let weights = checked(records, orders, settings)?;
    if !start.is_stable() {
        let rule = "must be stable: otherwise its free run grows without bound";
        return Err(Error::parameter("start", format!("a = {:?}", start.a()), rule));
    }
    let problem = FreeRunError { records, weights: &weights, orders };
    search(&problem, &[start.a(), &start.b()[delay..]].concat(), settings, progress)
}

/// One weight per record, after checking records, orders and weights.
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

/// Maximum number of samples used for starting values.
const MAX_START_SAMPLES: usize = 8192;

/// Poles of initial filters that do not depend on the data: a fast one, and a slow one for high sampling rates.
const INITIAL_POLES: [f64; 2] = [0.5, 0.8];

/// The first parts of the records, limited to [`MAX_START_SAMPLES`] samples together.
pub(super) struct StartRecords(Vec<Record>);

impl StartRecords {
    /// For blocks of up to `orders`.
    pub(super) fn new(records: &[Record], orders: Orders) -> Result<Self, Error> {
        let samples: usize = records.iter().map(Record::len).sum();
        let share = (MAX_START_SAMPLES as f64 / samples as f64).min(1.0);
        let least = 8 * (orders.history() + orders.parameters());
        let first_part = |r: &Record| match ((share * r.len() as f64).ceil() as usize).max(least) {
            n if n < r.len() => r.slice(0..n),
            _ => Ok(r.clone()),
        };
        Ok(StartRecords(records.iter().map(first_part).collect::<Result<_, _>>()?))
    }

    /// Starting values for a block of `orders`: the best free run of instrumental variables from the poles of least
    /// squares and from fixed filters, which are robust to noise and high sampling rates.
    pub(super) fn start(&self, orders: Orders, weights: &[f64]) -> Result<Vec<f64>, Error> {
        let problem = FreeRunError { records: &self.0, weights, orders };
        let (theta, _) = least_squares(&Regression::new(&self.0, orders)?)?;
        let initial =
            |pole| monic(&vec![Root { re: pole, im: 0.0 }; orders.na]).iter().map(|c| -c).collect::<Vec<f64>>();
        let mut best = rounds(&problem, &theta[..orders.na], ROUGH);
        for other in INITIAL_POLES.map(|pole| rounds(&problem, &initial(pole), ROUGH)) {
            if other.cost < best.cost {
                best = other;
            }
        }
        Ok(best.theta)
    }
}

/// Searches the minimum from `start`.
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
pub(super) mod tests {
    use super::*;
    use piezoid_numerics::progress::Stage;
    use piezoid_numerics::system::System;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::assert_close;
    use piezoid_twins::Plant;
    use std::ops::ControlFlow;

    const TS: f64 = 5e-4;

    fn found(records: &[Record], orders: Orders) -> OutputError {
        OutputError::fit(records, orders, &Refinement::default(), &mut Stage::ignore).unwrap()
    }

    /// The twin from rest, with a PRBS that starts with a step.
    pub(in crate::linear) fn pl140(seed: u64, n: usize) -> Record {
        let u = Prbs::default().samples(TS, n).unwrap();
        let plant = Plant::named("pl140", TS).unwrap().with_seed(seed);
        let y = plant.run(&u).y;
        Record::new(TS, u, y).unwrap()
    }

    #[test]
    fn the_residual_of_a_record_from_rest_with_a_step_is_its_noise() {
        let fit = found(&[pl140(1, 4094)], Orders { delay: 1, ..Orders::of(5) });
        assert!((0.19..0.21).contains(&fit.rms[0]), "{} um", fit.rms[0]);
        // If it were assumed settled at u[0]:
        let (record, arx) = (pl140(1, 4094), &fit.arx);
        let settled = arx.resume(&mut arx.settled(record.u()[0]), record.u());
        let squares = record.y().iter().zip(&settled).map(|(y, s)| (y - s - fit.offsets[0]).powi(2)).sum::<f64>();
        assert!((squares / record.len() as f64).sqrt() > 0.8, "the start should matter");
    }

    #[test]
    fn the_minimum_does_not_depend_on_the_noise_seed() {
        for (n, most) in [(3, 1.40), (4, 0.225), (5, 0.212), (6, 0.210), (7, 0.210)] {
            for seed in 1..=4 {
                let fit = found(&[pl140(seed, 4094)], Orders { delay: 1, ..Orders::of(n) });
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
            (found(&parts, orders), OutputError::fit(&parts, orders, &weighted, &mut Stage::ignore).unwrap());
        assert_close(doubled.arx.a(), plain.arx.a(), 1e-8, 0.0);
        assert_close(&doubled.covariance, &plain.covariance, 1e-4, 0.0);
        // A repeated record is a record with twice the weight.
        let repeated = found(&[parts[0].clone(), parts[1].clone(), parts[1].clone()], orders);
        let weighted = Refinement { weights: vec![1.0, 2.0], ..Refinement::default() };
        let weighted = OutputError::fit(&parts, orders, &weighted, &mut Stage::ignore).unwrap();
        assert_close(weighted.arx.b(), repeated.arx.b(), 1e-8, 0.0);
    }

    #[test]
    fn refining_keeps_the_delay_and_finds_the_same_minimum_from_elsewhere() {
        let record = [pl140(2, 4094)];
        let own = found(&record, Orders { na: 2, nb: 2, delay: 1 });
        let start = Arx::new(TS, vec![1.6, -0.8], vec![0.0, 3.0, 3.0]).unwrap();
        let refined = refine(&record, &start, &Refinement::default(), &mut Stage::ignore).unwrap();
        assert_close(refined.arx.a(), own.arx.a(), 1e-6, 0.0);
        assert_eq!((refined.arx.delay(), refined.minimum.reason), (1, Reason::Converged));
    }

    #[test]
    fn bad_starts_records_and_weights_are_errors() {
        let record = pl140(1, 4094);
        let message = |records: &[Record], start: &Arx, settings: &Refinement| {
            refine(records, start, settings, &mut Stage::ignore).unwrap_err().to_string()
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
