//! Few signals in place of the responses of all weights, for the fits of a structure search.
//!
//! ```text
//! z = sum_k w_k phi_k  ~  sum_j c_j psi_j,   psi_j = sum_k d_kj phi_k
//! ```
//! Another linear block moves the weights mostly where they move the output most. These directions d are the first
//! eigenvectors of the products of the weights' columns, by subspace iteration; one more is what the present weights
//! have outside them. The sensitivities to shape and driver are signals too. All are computed once, in windows of long
//! records behind creep, and a fit of a few columns takes the place of one of hundreds.
//!
//! G. H. Golub, C. F. Van Loan, Matrix Computations (2013), section 8.2.4.

use super::columns::{FILTERED_SAMPLES, creep, slopes};
use super::estimate::{Estimate, Responses};
use super::hidden::Hidden;
use super::layout::ColumnLayout;
use super::runs::TrainingRecord;
use super::signals::Filters;
use super::windows::{Window, windows};
use multiversion::multiversion;
use nalgebra::{DMatrix, DVector};
use piezoid_models::hysteresis::{Basis, Hysteresis};
use piezoid_numerics::error::Error;
use piezoid_records::record::Record;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;
use tracing::trace_span;

/// Number of signals in place of more weights, and of those that are computed together.
const SIGNALS: usize = 30;
const LANES: usize = 32;

/// Number of subspace iterations: the directions need not be exact.
const ITERATIONS: usize = 8;

/// Share of the weights outside the directions that is rounding.
const ROUNDING: f64 = 1e-9;

/// A fit with few signals, in windows of long records.
pub(crate) struct Reduced {
    windows: Vec<(Window, Hidden)>,
    /// The estimate in the coefficients of the signals.
    pub(crate) estimate: Estimate,
    /// d: for each weight, its share of each signal.
    directions: DMatrix<f64>,
    /// True if the gains of creep are held.
    pub(crate) holds_creep: bool,
    /// True if each weight has its own signal; then signs and smoothness are those of the weights.
    is_exact: bool,
}

impl Reduced {
    /// The signals of an estimate. `own` are the last own coefficients of the runs, and `products` those of the columns
    /// of the weights with each other.
    pub(crate) fn of(
        estimate: &Estimate,
        own: &[Vec<f64>],
        products: &DMatrix<f64>,
        runs: &[TrainingRecord],
    ) -> Result<Self, Error> {
        let _span = trace_span!("few signals").entered();
        let (directions, mut coefficients) = directions(products, &estimate.weights);
        let windows = windows(runs);
        // A window does not show the slow lags of creep, which are held then.
        let is_whole = windows.iter().all(|window| window.samples.len() == runs[window.run].record.len());
        let (lags, free_lags) = match is_whole {
            true => (Vec::new(), estimate.lags.clone()),
            false => (creep(estimate), Vec::new()),
        };
        let of_run = |(k, run): (usize, &TrainingRecord)| {
            let windows: Vec<&Window> = windows.iter().filter(|window| window.run == k).collect();
            signals(estimate, run, (&lags, &own[k][..lags.len()]), &directions, &windows)
        };
        let signals: Vec<Vec<f64>> = runs.par_iter().enumerate().map(of_run).collect();
        coefficients.resize(directions.ncols() + ColumnLayout::of(estimate).shape.len(), 0.0);
        coefficients.extend((!lags.is_empty()).then_some(1.0));
        let n = coefficients.len();
        // Row 0 is rest.
        let rows: Vec<f64> = std::iter::repeat_n(0.0, n).chain(signals.into_iter().flatten()).collect();
        let mut row = 1.0;
        let mut next = |count: usize| -> Vec<f64> {
            row += count as f64;
            (1..=count).map(|k| row - k as f64).rev().collect()
        };
        let signals_of = |window: Window| {
            let (before, inputs) = (next(window.moving), next(window.samples.len()));
            let y = runs[window.run].record.y()[window.samples.clone()].to_vec();
            Ok((window, Hidden { record: Record::new(estimate.ts(), inputs, y)?, before }))
        };
        let windows = windows.iter().cloned().map(signals_of).collect::<Result<_, Error>>()?;
        let is_exact = estimate.weights.len() <= LANES;
        let (mut signed, roughness) = match is_exact {
            true => (estimate.basis.non_negative(), estimate.basis.roughness()),
            false => (Vec::new(), Vec::new()),
        };
        signed.resize(n, false);
        let basis: Box<dyn Basis> = Box::new(Recorded { rows: rows.into(), signed, roughness });
        let few = Estimate::new(None, basis, free_lags, estimate.linear.clone());
        let holds_creep = !lags.is_empty();
        Ok(Reduced { windows, estimate: Estimate { weights: coefficients, ..few }, directions, holds_creep, is_exact })
    }

    /// The smoothness of a fit with these signals, from that of the weights.
    pub(crate) fn smoothness(&self, lambda: f64) -> f64 {
        if self.is_exact { lambda } else { 0.0 }
    }

    /// The windows as runs, with the signals in place of u.
    pub(crate) fn runs<'a>(&'a self, runs: &[TrainingRecord]) -> Vec<TrainingRecord<'a>> {
        self.windows.iter().map(|(window, signals)| window.run(signals, &runs[window.run])).collect()
    }

    /// The estimate with all weights that stands behind `few`, with the other blocks of `whole`.
    pub(crate) fn whole(&self, few: &Estimate, whole: &Estimate) -> Estimate {
        let coefficients = DVector::from_column_slice(&few.weights[..self.directions.ncols()]);
        let weights = &self.directions * coefficients;
        let signed = whole.basis.non_negative();
        let allowed = weights.iter().zip(signed).map(|(w, signed)| if signed { w.max(0.0) } else { *w });
        let lags = if few.lags.is_empty() { whole.lags.clone() } else { few.lags.clone() };
        Estimate { weights: allowed.collect(), lags, linear: few.linear.clone(), ..whole.clone() }
    }
}

/// The directions, and the coefficients of `weights`.
fn directions(products: &DMatrix<f64>, weights: &[f64]) -> (DMatrix<f64>, Vec<f64>) {
    let n = weights.len();
    if n <= LANES {
        return (DMatrix::identity(n, n), weights.to_vec());
    }
    let start = |k: usize, j: usize| libm::cos(PI * j as f64 * (k as f64 + 0.5) / n as f64);
    let mut main = DMatrix::from_fn(n, SIGNALS - 1, start);
    for _ in 0..ITERATIONS {
        main = (products * &main).qr().q();
    }
    let weights = DVector::from_column_slice(weights);
    let coefficients = main.tr_mul(&weights);
    let rest = &weights - &main * &coefficients;
    if rest.norm() <= ROUNDING * weights.norm() {
        return (main, coefficients.iter().copied().collect());
    }
    let last = main.ncols();
    let mut all = main.insert_column(last, 0.0);
    all.set_column(last, &rest);
    (all, coefficients.iter().copied().chain([1.0]).collect())
}

/// The signals behind creep that is held in the windows of a run, row by row: those in place of the weights, the
/// sensitivities to shape and driver, and what the initial states of the held lags add. Each window begins with the
/// samples before it that pass the linear block.
fn signals(
    estimate: &Estimate,
    run: &TrainingRecord,
    (lags, crept): (&[(f64, f64)], &[f64]),
    directions: &DMatrix<f64>,
    windows: &[&Window],
) -> Vec<f64> {
    let n = directions.ncols();
    let of_weight = |k: usize| {
        let mut shares = [0.0; LANES];
        shares.iter_mut().zip(&directions.row(k)).for_each(|(share, d)| *share = *d);
        shares
    };
    let shares: Vec<[f64; LANES]> = (0..directions.nrows()).map(of_weight).collect();
    let (level, mut responses) = (Responses::level(estimate, run), Responses::before_moving(estimate, run));
    let (moving, later) = (run.moving, &run.before[run.before.len() - run.moving..]);
    let slopes = slopes(estimate, run);
    let mut filters = Filters::new(n + slopes.len(), lags, &[], &[1.0]);
    let width = filters.len();
    let inputs: Vec<f64> = later.iter().chain(run.record.u()).copied().collect();
    let mut block = vec![0.0; FILTERED_SAMPLES * width];
    let mut decaying: Vec<(f64, f64)> = crept.iter().zip(lags).map(|(crept, lag)| (*crept, 1.0 - lag.0)).collect();
    let mut rows: Vec<Vec<f64>> = vec![Vec::new(); windows.len()];
    for (k, inputs) in inputs.chunks(FILTERED_SAMPLES).enumerate() {
        let times = k * FILTERED_SAMPLES..;
        let block = &mut block[..inputs.len() * width];
        for ((row, &u), t) in block.chunks_exact_mut(width).zip(inputs).zip(times.clone()) {
            row[..n].copy_from_slice(&combined(responses.next(u), &level, &shares)[..n]);
            row[n..].iter_mut().zip(&slopes).for_each(|(v, slope)| *v = slope.get(t).copied().unwrap_or_default());
        }
        filters.pass(block, width, 0);
        for (row, t) in block.chunks_exact(width).zip(times) {
            if t >= moving {
                decaying.iter_mut().for_each(|(crept, stays)| *crept *= *stays);
            }
            let crept = decaying.iter().map(|(crept, _)| crept).sum();
            for (window, rows) in windows.iter().zip(&mut rows) {
                let (start, end) = (moving + window.samples.start - window.moving, moving + window.samples.end);
                if (start..end).contains(&t) {
                    rows.extend(&row[..n + slopes.len()]);
                    rows.extend((!lags.is_empty()).then_some(if t < moving { 0.0 } else { crept }));
                }
            }
        }
    }
    rows.concat()
}

/// sum_k (phi_k - level_k) shares_k.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn combined(phi: &[f64], level: &[f64], shares: &[[f64; LANES]]) -> [f64; LANES] {
    let mut row = [0.0; LANES];
    for ((phi, level), shares) in phi.iter().zip(level).zip(shares) {
        let v = phi - level;
        for j in 0..LANES {
            row[j] += v * shares[j];
        }
    }
    row
}

/// Signals that were computed before: the input is the number of a row.
#[derive(Debug, Clone)]
struct Recorded {
    rows: Arc<[f64]>,
    /// For each signal, true if its coefficient must not be negative.
    signed: Vec<bool>,
    roughness: Vec<Vec<(usize, f64)>>,
}

impl Basis for Recorded {
    fn len(&self) -> usize {
        self.signed.len()
    }

    fn order(&self) -> usize {
        0
    }

    fn step(&self, _x: &mut [f64], u: f64, phi: &mut [f64]) {
        phi.copy_from_slice(&self.rows[u as usize * self.len()..][..self.len()]);
    }

    fn non_negative(&self) -> Vec<bool> {
        self.signed.clone()
    }

    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        self.roughness.clone()
    }

    fn reshaped(&self, _shape: &[f64]) -> Result<Box<dyn Basis>, Error> {
        Ok(Box::new(self.clone()))
    }

    fn output(&self, weights: &[f64], u: &[f64]) -> Result<Vec<f64>, Error> {
        let mut phi = vec![0.0; self.len()];
        let z = u.iter().map(|&u| {
            self.step(&mut [], u, &mut phi);
            phi.iter().zip(weights).map(|(phi, w)| phi * w).sum()
        });
        Ok(z.collect())
    }

    fn operator(&self, _weights: &[f64]) -> Result<Arc<dyn Hysteresis>, Error> {
        Err(Error::Content("recorded signals are no operator: use the estimate with all weights".into()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::fitted::Fitted;
    use super::super::held_out::Smoothness;
    use super::super::iterate::Iterate;
    use super::super::refine::{refine, refine_from};
    use super::super::solve::FreeParameters;
    use super::super::{runs::training_records, testing::estimate};
    use super::*;
    use piezoid_models::creep::Lag;
    use piezoid_models::hammerstein::InitialCondition;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;

    #[test]
    fn a_fit_with_few_signals_follows_the_linear_block_as_one_with_all_weights_does() {
        let block = Arx::new(5e-4, vec![0.8], vec![0.3]).unwrap();
        let u: Vec<f64> = (0..3000).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let rough = |(t, u): (usize, &f64)| u + 0.01 * u * u + 0.02 * ((t * t) as f64 * 0.618_034).fract();
        let y = block.simulate(&u.iter().enumerate().map(rough).collect::<Vec<_>>());
        let records = [Record::new(5e-4, u.clone(), y).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        for initial in InitialCondition::of(&u) {
            runs[0].start_from(initial, (-28.0, 28.0));
            let start = estimate("preisach", 12);
            assert!(start.weights.len() > SIGNALS);
            let from = refine(start, &mut runs, FreeParameters::Creep, &mut |_| Ok(())).unwrap();
            let reduced = Reduced::of(&from.estimate, &from.own, &from.products, &runs).unwrap();
            let mut few = reduced.runs(&runs);
            let fixed = |estimate: Estimate, runs: &mut [TrainingRecord], lambda: f64| {
                refine_from(estimate, Smoothness::Fixed(lambda), runs, FreeParameters::All, &mut |_| Ok(())).unwrap()
            };
            // The same free run before the fit.
            let same = Iterate::at(reduced.estimate.clone(), &few, &[], FreeParameters::All);
            let residual = same.residuals(&few)[0];
            assert!(
                (residual / from.residuals[0] - 1.0).abs() < 0.2,
                "{initial:?} {residual:e} {:e}",
                from.residuals[0]
            );
            let fit = fixed(reduced.estimate.clone(), &mut few, 0.0);
            let whole = fixed(reduced.whole(&fit.estimate, &from.estimate), &mut runs, from.held_out.lambda);
            let direct = fixed(from.estimate.clone(), &mut runs, from.held_out.lambda);
            let pole = |fit: &Fitted| fit.estimate.linear.a()[0];
            assert!((pole(&fit) - pole(&direct)).abs() < 0.02, "{} {}", pole(&fit), pole(&direct));
            assert!((whole.minimum / direct.minimum - 1.0).abs() < 0.02, "{} {}", whole.minimum, direct.minimum);
        }
    }

    #[test]
    fn a_run_without_usable_samples_keeps_the_own_coefficients_with_their_runs() {
        let block = Arx::new(5e-4, vec![0.8], vec![0.3]).unwrap();
        let u: Vec<f64> = (0..3000).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let y: Vec<f64> = block.simulate(&u).iter().map(|y| y + 7.0).collect();
        let records = [Record::new(5e-4, u, y).unwrap()];
        let fit = |at: &[usize]| {
            let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
            for &k in at {
                let mut empty = runs[0].clone();
                empty.usable.fill(false);
                runs.insert(k, empty);
            }
            let from = refine(estimate("preisach", 12), &mut runs, FreeParameters::All, &mut |_| Ok(())).unwrap();
            let reduced = Reduced::of(&from.estimate, &from.own, &from.products, &runs).unwrap();
            assert!(from.own.len() == runs.len() && !reduced.runs(&runs).is_empty());
            (from.own, from.residuals)
        };
        let (alone, residuals) = fit(&[]);
        let (own, all) = fit(&[0, 2]);
        assert_close(&own[1], &alone[0], 1e-6, 1e-9);
        assert_close(&all[1..2], &residuals, 1e-6, 1e-12);
        assert!(own[0].iter().chain(&own[2]).all(|x| *x == 0.0) && all[0].is_nan() && all[2].is_nan());
    }

    #[test]
    fn windows_of_a_long_record_have_the_free_run_of_the_whole_with_creep_and_without() {
        let u: Vec<f64> =
            (0..24_000).map(|t| 28.0 * (1e-3 * f64::from(t)).sin() * (0.013 * f64::from(t)).sin()).collect();
        for lags in [Vec::new(), vec![Lag { tau_s: 0.02, gain: 0.05 }, Lag { tau_s: 3.0, gain: 0.03 }]] {
            let start = Estimate { lags, ..estimate("prandtl-ishlinskii", 6) };
            let weights: Vec<f64> = (0..start.weights.len()).map(|k| 1.0 + 0.5 * (1.7 * k as f64).sin()).collect();
            let model = Estimate { weights: weights.clone(), ..start.clone() }.model(0.0).unwrap();
            let records = [Record::new(5e-4, u.clone(), model.simulate(&u)).unwrap()];
            let runs = training_records(&[], &records, &mut Vec::new()).unwrap();
            let exact = Estimate { weights, ..start };
            let own = [vec![0.0; ColumnLayout::of(&exact).own()]];
            let n = exact.weights.len();
            let reduced = Reduced::of(&exact, &own, &DMatrix::identity(n, n), &runs).unwrap();
            let few = reduced.runs(&runs);
            assert!(few.len() > 1);
            let point = Iterate::at(reduced.estimate.clone(), &few, &[], FreeParameters::All);
            let worst = point.residuals(&few).into_iter().fold(0.0, f64::max);
            assert!(worst < 1e-8, "{worst:e}");
        }
    }
}
