//! Uncertainty of the parameters of a block, and of quantities computed from them.
//!
//! ```text
//! cov theta = H^-1 (sum w^2 J' R J) H^-1,   H = sum w J'J                                  the sandwich
//! R_ts = r(t - s) (1 - |t - s| / (L + 1)),  r the autocovariance of e,  L = 2 n^(1/3)
//! dz / da_i = z^(n-i) / p'(z),  p(z) = z^n - a1 z^(n-1) - ...;   s = ln z / Ts             the delta method
//! ```
//! With white residuals R is their variance and the middle is H: the textbook's inverse of J'J. Coloured residuals, as
//! of a block of too low order, have fewer independent samples; the taper (Bartlett's, as in Newey & West 1987,
//! doi:10.2307/1913610) keeps the sandwich positive. J is the part of the derivatives that no change of past and offset
//! can compensate. The derivatives are those of simple roots.
//!
//! [`OutputError::bootstrap`] gives the same without a formula: overlapping blocks of residuals are resampled and added
//! to the free run, and the block is fitted again (Künsch 1989, doi:10.1214/aos/1176347265). Neither covers errors
//! unlike noise: drift, or hysteresis that remains in small signals.

use super::free_run::{FreeRunError, dot};
use super::output_error::{OutputError, Refinement, checked, search};
use super::{Arx, Pole};
use libm::cbrt;
use nalgebra::{Cholesky, Complex, DMatrix};
use piezoid_numerics::complex::{self, modulus};
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_numerics::series::{mean, scatter};
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;

/// A number and its standard error, in one unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Uncertain {
    /// The estimate.
    pub value: f64,
    /// Its standard error: the true value is within two of them 19 times in 20.
    pub error: f64,
}

impl OutputError {
    /// Natural frequency [Hz] and damping ratio of the poles of the block, as [`Arx::poles`] lists them.
    pub fn poles(&self) -> Vec<[Uncertain; 2]> {
        let a = self.arx.a();
        let known = |pole: Pole| {
            let z = Complex::new(pole.z.re, pole.z.im);
            let power = |k: usize| z.powu(k as u32);
            let n = a.len();
            // p'(z) = n z^(n-1) - (n-1) a1 z^(n-2) - ...
            let slope =
                (1..n).fold(power(n - 1) * n as f64, |sum, i| sum - power(n - i - 1) * (a[i - 1] * (n - i) as f64));
            let s = complex::log(z) / self.arx.ts();
            let by_a: Vec<Complex<f64>> = (1..=n).map(|i| power(n - i) / slope / z / self.arx.ts()).collect();
            let size = modulus(s);
            let by_size = |ds: &Complex<f64>| (s.conj() * ds).re / size;
            let hz: Vec<f64> = by_a.iter().map(|ds| by_size(ds) / TAU).collect();
            let damping: Vec<f64> = by_a.iter().map(|ds| (-ds.re + s.re * by_size(ds) / size) / size).collect();
            [self.uncertain(pole.hz, &hz), self.uncertain(pole.damping, &damping)]
        };
        self.arx.poles().into_iter().map(known).collect()
    }

    /// Output for a constant input of 1.
    pub fn dc_gain(&self) -> Uncertain {
        let (gain, still) = (self.arx.dc_gain(), 1.0 - self.arx.a().iter().sum::<f64>());
        let by_theta = [vec![gain / still; self.orders.na], vec![1.0 / still; self.orders.nb]].concat();
        self.uncertain(gain, &by_theta)
    }

    /// A function of theta = [a, b after the delay] with its standard error, from its `value` here and its derivatives
    /// `slopes` by the first entries of theta.
    pub fn uncertain(&self, value: f64, slopes: &[f64]) -> Uncertain {
        spread(value, slopes, &self.covariance, self.orders.parameters())
    }
}

/// `value` with its standard error, from its `slopes` and the d by d `covariance`.
pub(super) fn spread(value: f64, slopes: &[f64], covariance: &[f64], d: usize) -> Uncertain {
    let rows = slopes.iter().zip(covariance.chunks_exact(d));
    let variance: f64 = rows.map(|(slope, row)| slope * row.iter().zip(slopes).map(|(c, s)| c * s).sum::<f64>()).sum();
    Uncertain { value, error: variance.max(0.0).sqrt() }
}

/// Residuals of one record and their derivatives.
pub(super) struct RecordScores {
    pub(super) weight: f64,
    /// Residuals.
    pub(super) e: Vec<f64>,
    /// Their derivatives by each parameter, pasts and offsets projected out.
    pub(super) jacobian: Vec<Vec<f64>>,
}

/// The sandwich for `d` parameters, row by row; infinite where the records do not determine them. `share` is the number
/// of samples over the degrees of freedom.
pub(super) fn sandwich(scores: impl Iterator<Item = RecordScores>, d: usize, share: f64) -> Vec<f64> {
    let (mut outer, mut middle) = (DMatrix::zeros(d, d), DMatrix::zeros(d, d));
    for RecordScores { weight, e, jacobian } in scores {
        let kernel = tapered(&e);
        let smoothed: Vec<Vec<f64>> = jacobian.iter().map(|column| banded(&kernel, column)).collect();
        outer += weight * DMatrix::from_fn(d, d, |i, j| dot(&jacobian[i], &jacobian[j]));
        middle += weight * weight * share * DMatrix::from_fn(d, d, |i, j| dot(&jacobian[i], &smoothed[j]));
    }
    let size: Vec<f64> = outer.diagonal().iter().map(|d: &f64| d.sqrt()).collect();
    let scaled = |m: &DMatrix<f64>| DMatrix::from_fn(d, d, |i, j| m[(i, j)] / (size[i] * size[j]));
    let Some(root) = Cholesky::new(scaled(&outer)) else { return vec![f64::INFINITY; d * d] };
    let half = root.solve(&scaled(&middle));
    let covariance = root.solve(&half.transpose());
    (0..d * d).map(|k| covariance[(k / d, k % d)] / (size[k / d] * size[k % d])).collect()
}

/// The covariance of theta.
pub(super) fn covariance(problem: &FreeRunError, theta: &[f64], freedom: usize) -> Vec<f64> {
    let samples: usize = problem.records.iter().map(Record::len).sum();
    let scores = problem.runs(theta).map(|(run, weight)| RecordScores { weight, jacobian: run.jacobian(), e: run.e });
    sandwich(scores, theta.len(), samples as f64 / freedom as f64)
}

/// r(0), r(1), ..., r(L), tapered.
fn tapered(e: &[f64]) -> Vec<f64> {
    let n = e.len();
    let lags = block_length(n).min(n - 1);
    let r = |l: usize| dot(&e[l..], &e[..n - l]) / n as f64;
    (0..=lags).map(|l| r(l) * (1.0 - l as f64 / (lags + 1) as f64)).collect()
}

/// 2 n^(1/3): number of lags, and length of a resampled block.
fn block_length(n: usize) -> usize {
    (2.0 * cbrt(n as f64)).ceil() as usize
}

/// R x, for the symmetric band matrix R with `kernel` on its diagonals.
fn banded(kernel: &[f64], x: &[f64]) -> Vec<f64> {
    let mut sum: Vec<f64> = x.iter().map(|x| kernel[0] * x).collect();
    for (l, r) in kernel.iter().enumerate().skip(1) {
        sum[l..].iter_mut().zip(x).for_each(|(sum, x)| *sum += r * x);
        sum.iter_mut().zip(&x[l..]).for_each(|(sum, x)| *sum += r * x);
    }
    sum
}

/// Options of the bootstrap.
#[derive(Debug, Clone, PartialEq)]
pub struct Bootstrap {
    /// Number of fits to resampled residuals.
    pub replicates: usize,
    /// Samples per block; `None` is 2 n^(1/3) for each record.
    pub block: Option<usize>,
    /// Seed; each replicate has its own random stream.
    pub seed: u64,
    /// Fits on the threads of the current rayon pool; the result is the same.
    pub parallel: bool,
}

impl Default for Bootstrap {
    /// 100 replicates, seed 1.
    fn default() -> Self {
        Bootstrap { replicates: 100, block: None, seed: 1, parallel: false }
    }
}

impl Uncertain {
    /// Mean and standard deviation of a number over blocks that were fitted to resampled noise
    /// ([`OutputError::bootstrap`]).
    pub fn over(blocks: &[Arx], number: impl Fn(&Arx) -> f64) -> Self {
        let values: Vec<f64> = blocks.iter().map(number).collect();
        let error = (scatter(&values) / (values.len() as f64 - 1.0).max(1.0)).sqrt();
        Uncertain { value: mean(&values), error }
    }
}

impl OutputError {
    /// Fits the block repeatedly to its free run with resampled residuals. `records` and `settings` are those of this
    /// fit.
    ///
    /// ```
    /// use piezoid::{Record, System, linear::{Arx, Bootstrap, Orders, OutputError, Refinement, Uncertain}};
    /// let truth = Arx::new(5e-4, vec![1.7, -0.9], vec![3.0, 2.5])?;
    /// let u: Vec<f64> = (0..600).map(|t| f64::from((t * t % 13) as u8) - 6.0).collect();
    /// let noise = |t: usize| (t * 7919 % 31) as f64 / 31.0 - 0.5;
    /// let y = truth.simulate(&u).iter().enumerate().map(|(t, y)| y + noise(t)).collect();
    /// let records = [Record::new(5e-4, u, y)?];
    /// let (settings, orders) = (Refinement::default(), Orders { na: 2, nb: 2, delay: 0 });
    /// let fit = OutputError::fit(&records, orders, &settings, &mut piezoid::progress::Stage::ignore)?;
    /// let draws = Bootstrap { replicates: 20, ..Bootstrap::default() };
    /// let blocks = fit.bootstrap(&records, &settings, &draws, &mut piezoid::progress::Stage::ignore)?;
    /// let resonance = Uncertain::over(&blocks, |arx| arx.poles()[0].hz);
    /// assert!((resonance.value - truth.poles()[0].hz).abs() < 0.1);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error for fewer than two replicates, blocks without samples, and the errors of [`OutputError::fit`];
    /// [`Error::Cancelled`].
    pub fn bootstrap(
        &self,
        records: &[Record],
        settings: &Refinement,
        draws: &Bootstrap,
        progress: &mut Progress,
    ) -> Result<Vec<Arx>, Error> {
        if draws.replicates < 2 {
            return Err(Error::parameter("replicates", draws.replicates, "must be at least 2"));
        }
        if draws.block == Some(0) {
            return Err(Error::parameter("block", 0, "must be at least 1 sample"));
        }
        let weights = checked(records, self.orders, settings)?;
        let problem = FreeRunError { records, weights: &weights, orders: self.orders };
        let samples: usize = records.iter().map(Record::len).sum();
        // Residuals are smaller than the noise, because the block was fitted to them.
        let grow = (samples as f64 / self.freedom as f64).sqrt();
        let parts: Vec<(Vec<f64>, Vec<f64>)> = problem
            .runs(&self.minimum.x)
            .map(|(run, _)| {
                (run.model.iter().map(|y| y + run.level).collect(), run.e.iter().map(|e| grow * e).collect())
            })
            .collect();
        let replicate = |m: usize| {
            let mut random = ChaCha8Rng::seed_from_u64(draws.seed);
            random.set_stream(m as u64);
            let drawn = records.iter().zip(&parts).map(|(record, (free, e))| {
                let block = draws.block.unwrap_or_else(|| block_length(e.len())).min(e.len());
                let mut y = free.clone();
                for y in y.chunks_mut(block) {
                    let from = random.random_range(0..=e.len() - block);
                    y.iter_mut().zip(&e[from..]).for_each(|(y, e)| *y += e);
                }
                Record::new(record.ts(), record.u().to_vec(), y)
            });
            let drawn: Vec<Record> = drawn.collect::<Result<_, _>>()?;
            let problem = FreeRunError { records: &drawn, ..problem };
            Ok(search(&problem, &self.minimum.x, settings, &mut Stage::ignore)?.arx)
        };
        let mut fitted = Vec::new();
        let batch = if draws.parallel { rayon::current_num_threads() } else { 1 };
        while fitted.len() < draws.replicates {
            let (done, total) = (fitted.len(), draws.replicates);
            if progress(Stage::new("bootstrap", done, total)).is_break() {
                return Err(Error::Cancelled { what: "the bootstrap".into(), done, total });
            }
            let next = done..(done + batch).min(total);
            let arx: Vec<Arx> = if draws.parallel {
                next.into_par_iter().map(replicate).collect::<Result<_, Error>>()?
            } else {
                next.map(replicate).collect::<Result<_, Error>>()?
            };
            fitted.extend(arx);
        }
        Ok(fitted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::{Orders, OutputError};
    use piezoid_testing::{assert_close, noise};
    use std::ops::ControlFlow::{Break, Continue};

    const ORDERS: Orders = Orders { na: 2, nb: 2, delay: 1 };

    fn truth() -> Arx {
        Arx::new(5e-4, vec![1.7, -0.9], vec![0.0, 3.0, 2.5]).unwrap()
    }

    /// A record of the true block with noise n_t = `colour` n_{t-1} + w_t in y.
    fn record(seed: u64, colour: f64) -> Record {
        let u: Vec<f64> = (0..800).map(|t| f64::from((t * t * t % 997 % 2) as u8) - 0.5).collect();
        let mut n = 0.0;
        let noisy = |(y, w): (f64, f64)| {
            n = colour * n + w;
            y + n
        };
        let y = truth().simulate(&u).into_iter().zip(noise(seed, 800)).map(noisy).collect();
        Record::new(5e-4, u, y).unwrap()
    }

    fn fitted(seed: u64, colour: f64) -> OutputError {
        OutputError::fit(&[record(seed, colour)], ORDERS, &Refinement::default(), &mut Stage::ignore).unwrap()
    }

    /// Frequency, damping, gain.
    fn numbers(fit: &OutputError) -> [Uncertain; 3] {
        let [hz, damping] = fit.poles()[0];
        [hz, damping, fit.dc_gain()]
    }

    #[test]
    fn standard_errors_are_those_of_many_records_for_white_and_coloured_noise() {
        for colour in [0.0, 0.8] {
            let fits: Vec<[Uncertain; 3]> = (0..150).map(|seed| numbers(&fitted(seed, colour))).collect();
            let pole = truth().poles()[0];
            for (k, truth) in [pole.hz, pole.damping, truth().dc_gain()].into_iter().enumerate() {
                let values: Vec<f64> = fits.iter().map(|f| f[k].value).collect();
                let estimated: Vec<f64> = fits.iter().map(|f| f[k].error).collect();
                let observed = (scatter(&values) / 149.0).sqrt();
                // The standard deviation of 150 values is known to 6 %.
                assert_close(&[mean(&estimated)], &[observed], 0.2, 0.0);
                let covered = fits.iter().filter(|f| (f[k].value - truth).abs() < 1.96 * f[k].error).count();
                assert!((132..=149).contains(&covered), "colour {colour}, number {k}: {covered} of 150");
            }
        }
    }

    #[test]
    fn low_frequency_noise_makes_the_gain_less_certain_than_white_noise() {
        // The same variance: 1 / (1 - 0.8^2) = 2.8.
        let (white, coloured) = (fitted(1, 0.0).dc_gain().error * 2.8f64.sqrt(), fitted(1, 0.8).dc_gain().error);
        assert!(coloured > 1.5 * white, "{coloured} against {white}");
    }

    #[test]
    fn derivatives_of_roots_are_those_of_differences() {
        // A mode alone, and with a lag and a second mode.
        for a in [vec![1.7, -0.9], vec![2.1, -1.75, 0.97, -0.62, 0.15]] {
            let n = a.len();
            let block = |theta: &[f64]| Arx::new(5e-4, theta[..n].to_vec(), [&[0.0], &theta[n..]].concat()).unwrap();
            let theta = [&a[..], &[3.0, 2.5]].concat();
            let by = |arx: &Arx| {
                let poles = arx.poles().into_iter().flat_map(|pole| [pole.hz, pole.damping]);
                poles.chain([arx.dc_gain()]).collect::<Vec<_>>()
            };
            let moved = |k: usize, h: f64| {
                let mut theta = theta.clone();
                theta[k] += h;
                by(&block(&theta))
            };
            // With a single entry of the covariance, the error is the size of one derivative.
            for k in 0..n + 2 {
                let mut covariance = vec![0.0; (n + 2) * (n + 2)];
                covariance[(n + 3) * k] = 1.0;
                let orders = Orders { na: n, ..ORDERS };
                let alone = OutputError { arx: block(&theta), orders, covariance, ..fitted(1, 0.0) };
                let known = alone.poles().into_iter().flatten().chain([alone.dc_gain()]);
                let slopes: Vec<f64> = known.map(|known| known.error).collect();
                let by_differences: Vec<f64> =
                    moved(k, 1e-7).iter().zip(moved(k, -1e-7)).map(|(p, m)| ((p - m) / 2e-7).abs()).collect();
                assert_close(&slopes, &by_differences, 1e-5, 1e-5);
            }
        }
    }

    #[test]
    fn the_sandwich_is_its_formula_over_records_with_weights() {
        let weights = [0.5, 3.0];
        let scores = |k: usize| {
            let (seed, n) = (10 * k as u64, 40 + 30 * k);
            let coloured: Vec<f64> = noise(seed, n).windows(2).map(|w| w[1] + 0.7 * w[0]).collect();
            let column = |c: u64| noise(seed + c, n - 1).to_vec();
            RecordScores { weight: weights[k], e: coloured, jacobian: vec![column(1), column(2)] }
        };
        let (mut outer, mut middle) = (DMatrix::<f64>::zeros(2, 2), DMatrix::<f64>::zeros(2, 2));
        for RecordScores { weight, e, jacobian } in [scores(0), scores(1)] {
            let (n, lags) = (e.len(), (2.0 * (e.len() as f64).powf(1.0 / 3.0)).ceil());
            let r = |t: usize, s: usize| {
                let l = t.abs_diff(s);
                let lagged: f64 = (l..n).map(|t| e[t] * e[t - l]).sum();
                lagged / n as f64 * (1.0 - l as f64 / (lags + 1.0)).max(0.0)
            };
            let (covariance, j) = (DMatrix::from_fn(n, n, r), DMatrix::from_fn(n, 2, |t, k| jacobian[k][t]));
            outer += weight * j.transpose() * &j;
            middle += weight.powi(2) * j.transpose() * covariance * &j;
        }
        let inverse = outer.try_inverse().unwrap();
        let expected = &inverse * middle * &inverse * 1.25;
        assert_close(&sandwich([scores(0), scores(1)].into_iter(), 2, 1.25), expected.as_slice(), 1e-9, 0.0);
    }

    #[test]
    fn the_spread_over_blocks_is_their_standard_deviation() {
        let blocks = [1.0, 2.0, 6.0].map(|b| Arx::new(1.0, vec![], vec![b]).unwrap());
        let gain = Uncertain::over(&blocks, Arx::dc_gain);
        assert_close(&[gain.value, gain.error], &[3.0, 7f64.sqrt()], 1e-12, 0.0);
        assert_eq!(Uncertain::over(&blocks[..1], Arx::dc_gain).error, 0.0);
    }

    #[test]
    fn a_bootstrap_needs_two_replicates_and_a_block() {
        let (records, fit) = ([record(1, 0.0)], fitted(1, 0.0));
        let drawn = |replicates, block, stage: &mut Progress| {
            let draws = Bootstrap { replicates, block, ..Bootstrap::default() };
            fit.bootstrap(&records, &Refinement::default(), &draws, stage).map(|blocks| blocks.len())
        };
        assert_eq!(drawn(2, Some(1), &mut Stage::ignore), Ok(2));
        for (replicates, block, expected) in [(1, None, "replicates = 1"), (2, Some(0), "block = 0")] {
            let message = drawn(replicates, block, &mut Stage::ignore).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}");
        }
        let mut second = |stage: Stage| if stage.done < 1 { Continue(()) } else { Break(()) };
        assert!(matches!(drawn(3, None, &mut second), Err(Error::Cancelled { done: 1, total: 3, .. })));
    }

    #[test]
    fn the_bootstrap_agrees_with_the_formula() {
        for colour in [0.0, 0.8] {
            let (records, fit) = ([record(5, colour)], fitted(5, colour));
            let draws = Bootstrap { replicates: 200, parallel: true, ..Bootstrap::default() };
            let again = fit.bootstrap(&records, &Refinement::default(), &draws, &mut Stage::ignore).unwrap();
            let [hz, damping, gain] = numbers(&fit);
            let drawn: [fn(&Arx) -> f64; 3] = [|a| a.poles()[0].hz, |a| a.poles()[0].damping, Arx::dc_gain];
            for (known, number) in [hz, damping, gain].iter().zip(drawn) {
                assert_close(&[Uncertain::over(&again, number).error], &[known.error], 0.25, 0.0);
            }
        }
    }

    #[test]
    fn threads_do_not_change_the_bootstrap() {
        let (records, fit) = ([record(2, 0.3)], fitted(2, 0.3));
        let of = |parallel, seed| {
            let draws = Bootstrap { replicates: 5, parallel, seed, ..Bootstrap::default() };
            fit.bootstrap(&records, &Refinement::default(), &draws, &mut Stage::ignore).unwrap()
        };
        assert_eq!(of(false, 1), of(true, 1));
        assert_ne!(of(false, 1), of(false, 2));
    }

    #[test]
    fn undetermined_parameters_have_infinite_uncertainty() {
        let scores = RecordScores { weight: 1.0, e: vec![0.1; 50], jacobian: vec![vec![1.0; 50], vec![2.0; 50]] };
        assert_eq!(sandwich(std::iter::once(scores), 2, 1.0), [f64::INFINITY; 4]);
    }
}
