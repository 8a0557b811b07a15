//! The free-run error, linearised in all parameters, and the products of its columns.
//!
//! With zc the hidden variable after creep, L_i the lags of creep and G = B/A:
//!
//! ```text
//! y = G zc + response to the past + c
//! dy/dw_k = G C phi_k   dy/dg_i = G L_i z   dy/dp_j = G C dz/dp_j   dy/da_i = q^-i y/A   dy/db_j = q^-j zc/A
//! ```
//! All are exact. The response to a record's past is linear as well: q^-i/A for the state of G, G exp(-t/tau_i) for
//! that of creep. Columns are computed sample by sample and multiplied in blocks, so records may have any length.

use super::estimate::{Estimate, Responses};
use super::layout::ColumnLayout;
use super::runs::TrainingRecord;
use super::signals::{AllPole, Ladder, LinearFilter};
use crate::driver::DriverModel;
use crate::series::dot;
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Rows per block.
const BLOCK: usize = 256;

/// Maximum number of large-signal rows kept of all runs: neighbouring rows have similar information.
const ROWS: usize = 40_000;

/// Products of the columns with each other and with y, over a segment of a run.
#[derive(Debug, Clone)]
pub(super) struct Segment {
    /// Index of the run.
    pub(super) run: usize,
    /// The fold it is held out in; `None` is never held out.
    pub(super) fold: Option<usize>,
    /// True if its held-out error counts, as for large-signal records.
    pub(super) judged: bool,
    /// All columns, then y.
    pub(super) gram: DMatrix<f64>,
    /// Number of usable samples, kept or not.
    pub(super) samples: f64,
}

/// The products of each segment of each run. `own` are the last own coefficients of the runs; empty at first.
pub(super) fn products(estimate: &Estimate, runs: &[TrainingRecord], own: &[Vec<f64>]) -> Vec<Segment> {
    let large_signal: usize = runs.iter().filter(|r| r.large_signal).map(|r| r.record.len()).sum();
    let thin = large_signal.div_ceil(ROWS).max(1);
    let of = |(k, run): (usize, &TrainingRecord)| {
        let own = own.get(k).map_or(&[] as &[f64], Vec::as_slice);
        of_run(estimate, k, run, own, if run.large_signal { thin } else { 1 })
    };
    runs.par_iter().enumerate().flat_map_iter(of).collect()
}

fn of_run(estimate: &Estimate, index: usize, run: &TrainingRecord, own: &[f64], thin: usize) -> Vec<Segment> {
    let layout = ColumnLayout::of(estimate);
    let (u, y) = (run.record.u(), run.record.y());
    let mut columns = RunColumns::new(estimate, run, &layout, own);
    let size = layout.columns() + 1;
    let weight = run.scale * run.heavier * (thin as f64).sqrt();
    let mut block = DMatrix::zeros(size, BLOCK);
    let mut start = 0;
    let segment = |&(end, fold): &(usize, Option<usize>)| {
        let mut gram = DMatrix::zeros(size, size);
        let (mut filled, mut samples) = (0, 0.0);
        for t in std::mem::replace(&mut start, end)..end {
            let counts = run.usable[t];
            samples += f64::from(u8::from(counts));
            let mut column = block.column_mut(filled);
            let row = column.as_mut_slice();
            columns.step(t, u[t], row);
            if counts && kept(t, thin) {
                // Relative to the level, to avoid cancellation.
                row[size - 1] = y[t] - run.level;
                row.iter_mut().for_each(|v| *v *= weight);
                filled += 1;
            }
            if filled == BLOCK || t + 1 == end {
                let rows = block.columns(0, filled);
                gram.gemm(1.0, &rows, &rows.transpose(), 1.0);
                filled = 0;
            }
        }
        Segment { run: index, fold, judged: run.large_signal, gram, samples }
    };
    run.segments.iter().map(segment).collect()
}

/// True if row `t` is kept: one of every `thin` rows, at non-periodic places.
fn kept(t: usize, thin: usize) -> bool {
    let golden = ((t / thin) as f64 * 0.618_033_988_749_895).fract();
    t % thin == (golden * thin as f64) as usize
}

/// The columns of a run, sample by sample.
struct RunColumns<'a> {
    estimate: &'a Estimate,
    layout: &'a ColumnLayout,
    own: &'a [f64],
    responses: Responses<'a>,
    /// The responses before the first sample, the origin of z.
    first: Vec<f64>,
    slopes: Vec<Vec<f64>>,
    rates: Vec<f64>,
    lags: Vec<f64>,
    decaying: Vec<f64>,
    ladder: Ladder,
    filter: LinearFilter<'a>,
    /// Inputs of the filter: responses and derivatives after creep, lags, decaying lags.
    entering: Vec<f64>,
    y_by_a: AllPole<'a>,
    zc_by_a: AllPole<'a>,
    impulse_by_a: AllPole<'a>,
    /// Slope of the trend per sample.
    trend: f64,
}

impl<'a> RunColumns<'a> {
    fn new(estimate: &'a Estimate, run: &TrainingRecord, layout: &'a ColumnLayout, own: &'a [f64]) -> Self {
        let (a, b) = (estimate.linear.a(), estimate.linear.b());
        let rates: Vec<f64> = estimate.lags.iter().map(|lag| -(-estimate.ts() / lag.tau_s).exp_m1()).collect();
        let gains: Vec<f64> = estimate.lags.iter().map(|lag| lag.gain).collect();
        let responses = Responses::before(estimate, run);
        let slopes = slopes(estimate, run);
        let behind_creep = layout.weights.len() + slopes.len();
        let width = behind_creep + 2 * rates.len();
        RunColumns {
            first: responses.current().to_vec(),
            ladder: Ladder::new(&rates, &gains, behind_creep),
            filter: LinearFilter::new(a, b, width),
            entering: vec![0.0; width],
            y_by_a: AllPole::new(a, layout.state.len()),
            zc_by_a: AllPole::new(a, b.len()),
            impulse_by_a: AllPole::new(a, layout.state.len()),
            trend: if run.drifts { (run.record.len() as f64).recip() } else { 0.0 },
            lags: vec![0.0; rates.len()],
            decaying: vec![1.0; rates.len()],
            estimate,
            layout,
            own,
            responses,
            slopes,
            rates,
        }
    }

    fn step(&mut self, t: usize, u: f64, row: &mut [f64]) {
        let (layout, n) = (self.layout, self.rates.len());
        let phi = if t == 0 { self.responses.current() } else { self.responses.next(u) };
        let (behind_creep, lagging) = self.entering.split_at_mut(layout.weights.len() + self.slopes.len());
        let (responses, sloped) = behind_creep.split_at_mut(layout.weights.len());
        for ((v, phi), first) in responses.iter_mut().zip(phi).zip(&self.first) {
            *v = phi - first;
        }
        for (v, slope) in sloped.iter_mut().zip(&self.slopes) {
            *v = slope[t];
        }
        let z = dot(responses, &self.estimate.weights);
        for ((lag, decaying), rate) in self.lags.iter_mut().zip(&mut self.decaying).zip(&self.rates) {
            *lag += rate * (z - *lag);
            *decaying *= 1.0 - rate;
        }
        self.ladder.step(behind_creep);
        lagging[..n].copy_from_slice(&self.lags);
        lagging[n..].copy_from_slice(&self.decaying);
        // The state of creep comes first in a run's own coefficients.
        let from_creep = dot(&self.decaying, self.own);
        let zc = dot(&self.entering[layout.weights.clone()], &self.estimate.weights) + from_creep;
        self.zc_by_a.step(zc);
        self.impulse_by_a.step(f64::from(u8::from(t == 0)));

        let out = self.filter.step(&self.entering);
        let (out_creep, out_lags) = out.split_at(layout.weights.len() + self.slopes.len());
        let (out_responses, out_slopes) = out_creep.split_at(layout.weights.len());
        row[layout.weights.clone()].copy_from_slice(out_responses);
        row[layout.shape.clone()].copy_from_slice(out_slopes);
        row[layout.gains.clone()].copy_from_slice(&out_lags[..n]);
        row[layout.crept.clone()].copy_from_slice(&out_lags[n..]);
        row[layout.a.clone()].copy_from_slice(&self.y_by_a.past()[..layout.a.len()]);
        let delay = self.estimate.linear.delay();
        row[layout.b.clone()].copy_from_slice(&self.zc_by_a.past()[delay..delay + layout.b.len()]);
        row[layout.state.clone()].copy_from_slice(&self.impulse_by_a.past()[..layout.state.len()]);
        row[layout.constant] = 1.0;
        row[layout.trend] = self.trend * t as f64;
        // q^-1 y/A: entered now, read at the next sample.
        let from_past = dot(&row[layout.crept.start..layout.constant], self.own);
        self.y_by_a.step(dot(out_responses, &self.estimate.weights) + from_past);
    }
}

/// dz/dp_j along a run, relative to its first sample.
fn slopes(estimate: &Estimate, run: &TrainingRecord) -> Vec<Vec<f64>> {
    let u = run.record.u();
    let steps = if estimate.driver.is_some() { DriverModel::SUBSTEPS } else { 1 };
    // The inputs of the hysteresis block; the first one is the path from rest.
    let (mut v, mut seen) = (u[0], vec![u[0]]);
    for &u in run.past.iter().chain(u) {
        for _ in 0..steps {
            v = estimate.driver.map_or(u, |d| d.advance(v, u, estimate.ts() / steps as f64));
            seen.push(v);
        }
    }
    let of = |j: usize| {
        let slope = estimate.basis.slope(j, &estimate.weights, &seen);
        let at = |t: usize| {
            let last = (run.past.len() + t + 1) * steps;
            let mean = |k: usize| 0.5 * (slope[k - 1] + slope[k]) / steps as f64;
            if steps == 1 { slope[last] } else { (last + 1 - steps..=last).map(mean).sum() }
        };
        // z is relative to its value before the first sample, not to a mean.
        let first = slope[(run.past.len() + 1) * steps];
        (0..u.len()).map(|t| if t == 0 { 0.0 } else { at(t) - first }).collect()
    };
    (0..estimate.basis.shape().len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creep::Lag;
    use crate::driver::DriverModel;
    use crate::hysteresis::{BasisDesign, OPERATORS, Operator};
    use crate::linear::Arx;
    use crate::record::Record;

    const TS: f64 = 5e-4;

    /// A full estimate: weights, shapes off their kinks, creep, dynamics with a delay.
    fn estimate(row: &Operator, driver: Option<DriverModel>) -> Estimate {
        let ts = if driver.is_some() { TS / DriverModel::SUBSTEPS as f64 } else { TS };
        let design = BasisDesign { ts, range: (-30.0, 30.0), elements: Some(4), frequencies: vec![5.0, 20.0] };
        let basis = (row.basis)(&design).unwrap();
        let off = |s: &crate::hysteresis::ShapeParameter| s.value + 0.07 * s.value.abs() + 0.003 * (s.high - s.low);
        let basis = basis.reshaped(&basis.shape().iter().map(off).collect::<Vec<_>>()).unwrap();
        let lags = vec![Lag { tau_s: 5e-3, gain: 0.08 }, Lag { tau_s: 5e-2, gain: 0.03 }];
        let linear = Arx::new(TS, vec![1.1, -0.5], vec![0.0, 0.3, 0.2]).unwrap();
        let weights = (0..basis.len()).map(|k| 1.0 + 0.5 * (1.7 * k as f64).sin()).collect();
        Estimate { weights, ..Estimate::new(driver, basis, lags, linear) }
    }

    /// The free run by the law, sample by sample.
    fn free_run(estimate: &Estimate, run: &TrainingRecord, own: &[f64]) -> Vec<f64> {
        let layout = ColumnLayout::of(estimate);
        let own_of = |column: usize| own[column - layout.parameters()];
        let (a, b) = (estimate.linear.a(), estimate.linear.b());
        let mut responses = Responses::before(estimate, run);
        let first = dot(responses.current(), &estimate.weights);
        let mut lags: Vec<f64> = vec![0.0; estimate.lags.len()];
        let mut began: Vec<f64> = layout.crept.clone().map(own_of).collect();
        let (mut zc, mut y): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for (t, &u) in run.record.u().iter().enumerate() {
            let z = if t == 0 { 0.0 } else { dot(responses.next(u), &estimate.weights) - first };
            let mut crept = z;
            for ((lag, began), of) in lags.iter_mut().zip(&mut began).zip(&estimate.lags) {
                let stays = (-TS / of.tau_s).exp();
                *lag = stays * *lag + (1.0 - stays) * z;
                *began *= stays;
                crept += of.gain * *lag + *began;
            }
            zc.push(crept);
            let past = |x: &[f64], back: usize| if back <= t { x[t - back] } else { 0.0 };
            let fed_back: f64 = a.iter().enumerate().map(|(i, a)| a * if t > i { y[t - 1 - i] } else { 0.0 }).sum();
            let fed_forward: f64 = b.iter().enumerate().map(|(j, b)| b * past(&zc, j)).sum();
            let state = layout.state.clone().nth(t).map_or(0.0, own_of);
            y.push(fed_back + fed_forward + state);
        }
        let slope = if run.drifts { own_of(layout.trend) / y.len() as f64 } else { 0.0 };
        y.iter().enumerate().map(|(t, y)| y + own_of(layout.constant) + slope * t as f64).collect()
    }

    #[test]
    fn every_column_is_the_derivative_of_the_free_run() {
        let wander = |t: usize| 17.0 * (0.05 * t as f64).sin() + 11.0 * (0.173 * t as f64).sin();
        // One record from rest, and one in motion.
        let records = [0, 20].map(|from| {
            let u: Vec<f64> = (from..from + 250).map(wander).collect();
            Record::new(TS, u.clone(), u).unwrap()
        });
        let driver = DriverModel::new(3e-4, Some(4e3)).unwrap();
        for (row, driver) in OPERATORS.iter().flat_map(|row| [(row, None), (row, Some(driver))]) {
            let estimate = estimate(row, driver);
            let layout = ColumnLayout::of(&estimate);
            let x = super::super::solve::Prior::of(&estimate).current().as_slice().to_vec();
            let own: Vec<f64> = (0..layout.own()).map(|k| 3.0 + k as f64).collect();
            for (record, moving) in records.iter().zip([false, true]) {
                let run = TrainingRecord::new(record, "record", true, vec![true; record.len()]).unwrap();
                assert_eq!(!run.past.is_empty(), moving);
                let run = TrainingRecord { drifts: true, ..run };
                let mut columns = RunColumns::new(&estimate, &run, &layout, &own);
                let mut rows = DMatrix::zeros(layout.columns() + 1, record.len());
                for (t, &u) in record.u().iter().enumerate() {
                    columns.step(t, u, rows.column_mut(t).as_mut_slice());
                }
                for k in 0..layout.columns() {
                    let own_index = k.checked_sub(layout.parameters());
                    let value = own_index.map_or_else(|| x[k], |k| own[k]);
                    let h = 1e-5 * (value.abs() + 0.01);
                    let moved = |by: f64| {
                        let (mut x, mut own) = (x.clone(), own.clone());
                        *own_index.map_or_else(|| &mut x[k], |k| &mut own[k]) += by;
                        free_run(&estimate.moved(&x).unwrap(), &run, &own)
                    };
                    let slope: Vec<f64> = moved(h).iter().zip(moved(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect();
                    let column: Vec<f64> = rows.row(k).iter().copied().collect();
                    let peak = slope.iter().fold(0.0f64, |m, s| m.max(s.abs()));
                    let off = column.iter().zip(&slope).fold(0.0f64, |m, (c, s)| m.max((c - s).abs()));
                    assert!(
                        off <= 2e-5 * peak + 1e-7,
                        "{} {driver:?} moving {moving}: column {k} of {layout:?} is off by {off:e} of {peak}",
                        row.name
                    );
                }
            }
        }
    }

    #[test]
    fn products_are_relative_to_the_level_and_exclude_unusable_samples() {
        let estimate = estimate(OPERATORS[0], None);
        let u: Vec<f64> = (0..600).map(|t| 20.0 * (0.1 * f64::from(t)).sin()).collect();
        let sums = |offset: f64, spike: f64| {
            let y = u.iter().enumerate().map(|(t, u)| u + offset + if t == 300 { spike } else { 0.0 }).collect();
            let record = Record::new(TS, u.clone(), y).unwrap();
            let usable = (0..600).map(|t| t != 300).collect();
            let run = TrainingRecord::new(&record, "record", true, usable).unwrap();
            products(&estimate, &[run], &[])[0].gram.clone()
        };
        let plain = sums(0.0, 0.0);
        assert_eq!(plain, sums(0.0, 1e9));
        assert!((&plain - sums(1e6, 0.0)).amax() < 1e-9 * plain.amax());
    }
}
