//! The columns of the free-run error, linearised in all parameters.
//!
//! With zc the hidden variable after creep, L_i the lags of creep and G = B/A:
//!
//! ```text
//! y = G zc + response to the initial states + c
//! dy/dw_k = G C phi_k   dy/dg_i = G L_i z   dy/dp_j = G C dz/dp_j   dy/da_i = q^-i y/A   dy/db_j = q^-j zc/A
//! ```
//! All are exact. The response to a record's initial states is linear as well: q^-i/A for the state of G, G
//! exp(-t/tau_i) for that of creep. Columns are computed in blocks of samples, so records may have any length.

use super::estimate::{Estimate, Responses, differences, of_differences};
use super::hidden::Inputs;
use super::layout::ColumnLayout;
use super::runs::TrainingRecord;
use super::signals::{AllPole, DECAYED_SIGNAL, Filter, LANES};
use super::solve::FreeParameters;
use libm::expm1;
use piezoid_models::creep::Lag;
use piezoid_models::driver::DriverModel;
use piezoid_numerics::series::{dot, dot_wide};
use std::ops::Range;

/// Samples that are filtered at a time.
pub(super) const FILTERED_SAMPLES: usize = 64;

/// Step of the difference quotient for the lag of the driver, over the lag.
const RELATIVE_LAG_STEP: f64 = 1e-3;

/// The columns of a run, block by block.
pub(super) struct RunColumns<'a> {
    estimate: &'a Estimate,
    pub(super) run: &'a TrainingRecord<'a>,
    pub(super) layout: &'a ColumnLayout,
    /// The initial state of creep, and that of G as the coefficients of single samples.
    crept: &'a [f64],
    state: Vec<f64>,
    responses: Responses<'a>,
    /// The origin of the responses.
    level: Vec<f64>,
    /// dz/dp of each shape parameter.
    slopes: Vec<std::vec::IntoIter<f64>>,
    rates: Vec<f64>,
    lags: Vec<f64>,
    decaying: Vec<f64>,
    /// What G filters, [`LANES`] signals by each filter: responses and slopes, through creep; lags and decaying lags.
    filters: Vec<Filter>,
    behind_creep: usize,
    entering: Vec<f64>,
    y_by_a: AllPole<'a>,
    zc_by_a: AllPole<'a>,
    impulse_by_a: AllPole<'a>,
}

impl<'a> RunColumns<'a> {
    pub(super) fn new(
        estimate: &'a Estimate,
        run: &'a TrainingRecord<'a>,
        layout: &'a ColumnLayout,
        own: &'a [f64],
        free: FreeParameters,
    ) -> Self {
        let (a, b) = (estimate.linear.a(), estimate.linear.b());
        let rates: Vec<f64> = estimate.lags.iter().map(|lag| -expm1(-estimate.ts() / lag.tau_s)).collect();
        let creep: Vec<_> = rates.iter().copied().zip(estimate.lags.iter().map(|lag| lag.gain)).collect();
        let level = Responses::level(estimate, run);
        let mut responses = Responses::from_rest(estimate, run);
        run.before[1..run.before.len() - run.moving()].iter().for_each(|&u| _ = responses.next(u));
        let slopes = match free {
            FreeParameters::All => slopes(estimate, run),
            _ => vec![Vec::new(); layout.shape.len()],
        };
        let slopes: Vec<_> = slopes.into_iter().map(Vec::into_iter).collect();
        let through = |lags: &[(f64, f64)], signals: usize| {
            let filters = (0..signals.div_ceil(LANES)).map(|_| Filter::new(lags, a, b));
            filters.collect::<Vec<_>>()
        };
        let mut filters = through(&creep, layout.weights.len() + slopes.len());
        let behind_creep = filters.len() * LANES;
        filters.extend(through(&[], 2 * rates.len()));
        let past = layout.state.len();
        let (crept, state) = match own {
            [] => (own, vec![0.0; past]),
            _ => (&own[..rates.len()], of_differences(&own[rates.len()..rates.len() + past])),
        };
        RunColumns {
            crept,
            state,
            level,
            entering: vec![0.0; FILTERED_SAMPLES * filters.len() * LANES],
            filters,
            behind_creep,
            y_by_a: AllPole::new(a, past),
            zc_by_a: AllPole::new(a, b.len()),
            impulse_by_a: AllPole::new(a, past),
            lags: vec![0.0; rates.len()],
            decaying: vec![0.0; rates.len()],
            estimate,
            run,
            layout,
            responses,
            slopes,
            rates,
        }
    }

    /// Advances over the inputs before the record that pass creep and linear block.
    pub(super) fn pass_earlier_inputs(&mut self) {
        let moving = &self.run.before[self.run.before.len() - self.run.moving()..];
        for inputs in moving.chunks(FILTERED_SAMPLES) {
            inputs.iter().enumerate().for_each(|(k, &u)| self.enter(k, u, false));
            self.filter(inputs.len());
        }
        self.decaying.fill(1.0);
    }

    /// Advances over at most [`FILTERED_SAMPLES`] samples, and writes the rows of those selected, y last. Returns their
    /// number.
    pub(super) fn advance(
        &mut self,
        samples: Range<usize>,
        selected: impl Fn(usize) -> bool,
        rows: &mut [f64],
    ) -> usize {
        let (layout, size) = (self.layout, self.layout.columns() + 1);
        let delay = self.estimate.linear.delay();
        let mut added = Vec::with_capacity(FILTERED_SAMPLES);
        for (k, t) in samples.clone().enumerate() {
            self.enter(k, self.run.record.u()[t], t == 0);
            if selected(t) {
                let row = &mut rows[added.len() * size..][..size];
                row[layout.b.clone()].copy_from_slice(&self.zc_by_a.past()[delay..delay + layout.b.len()]);
                row[layout.state.clone()].copy_from_slice(&self.impulse_by_a.past()[..layout.state.len()]);
                row[layout.a.clone()].copy_from_slice(&self.y_by_a.past()[..layout.a.len()]);
                for range in [&layout.a, &layout.b, &layout.state] {
                    differences(&mut row[range.clone()]);
                }
                row[layout.constant] = 1.0;
                // About the middle, so that the constant is that of the whole record.
                row[layout.trend] = t as f64 / self.run.record.len() as f64 - 0.5;
                // Relative to the level, to avoid cancellation.
                row[size - 1] = self.run.record.y()[t] - self.run.level;
                added.push(k);
            }
        }
        self.filter(samples.len());
        let width = self.filters.len() * LANES;
        for (&k, row) in added.iter().zip(rows.chunks_exact_mut(size)) {
            let (through, lags) = self.entering[k * width..][..width].split_at(self.behind_creep);
            for (range, signals) in [
                (&layout.weights, through),
                (&layout.shape, &through[layout.weights.len()..]),
                (&layout.gains, lags),
                (&layout.crept, &lags[layout.gains.len()..]),
            ] {
                row[range.clone()].copy_from_slice(&signals[..range.len()]);
            }
        }
        added.len()
    }

    /// Enters the input `u` as row `k` of what is filtered.
    fn enter(&mut self, k: usize, u: f64, is_first: bool) {
        // The y of the sample before: the column of a_1 is q^-1 y/A.
        let y = dot(self.estimate.linear.b(), self.zc_by_a.past()) + dot(&self.state, self.impulse_by_a.past());
        self.y_by_a.step(y);
        let width = self.filters.len() * LANES;
        let (through, lagging) = self.entering[k * width..][..width].split_at_mut(self.behind_creep);
        let (responses, sloped) = through.split_at_mut(self.layout.weights.len());
        for ((v, phi), level) in responses.iter_mut().zip(self.responses.next(u)).zip(&self.level) {
            *v = phi - level;
        }
        for (v, slope) in sloped.iter_mut().zip(&mut self.slopes) {
            *v = slope.next().unwrap_or_default();
        }
        let z = dot_wide::<8>(responses, &self.estimate.weights);
        let mut zc = z;
        let lags = self.lags.iter_mut().zip(&mut self.decaying).zip(&self.rates).zip(&self.estimate.lags);
        for (((lag, decaying), rate), Lag { gain, .. }) in lags {
            *lag += rate * (z - *lag);
            *decaying *= if *decaying < DECAYED_SIGNAL { 0.0 } else { 1.0 - rate };
            zc += gain * *lag;
        }
        let n = self.rates.len();
        lagging[..n].copy_from_slice(&self.lags);
        lagging[n..2 * n].copy_from_slice(&self.decaying);
        self.zc_by_a.step(zc + dot(&self.decaying, self.crept));
        self.impulse_by_a.step(f64::from(u8::from(is_first)));
    }

    /// Filters the first `n` rows that entered.
    fn filter(&mut self, n: usize) {
        let width = self.filters.len() * LANES;
        for (k, filter) in self.filters.iter_mut().enumerate() {
            filter.pass(&mut self.entering[..n * width], width, k * LANES);
        }
    }
}

/// dz/dp_j along a run and the inputs before it that pass the linear block, relative to the origin of z; then
/// dz/d(lag) of a driver whose lag is sought.
fn slopes(estimate: &Estimate, run: &TrainingRecord) -> Vec<Vec<f64>> {
    let shape = |j: usize| {
        let inputs = Inputs::of(run, estimate.driver);
        inputs.by_sample(&estimate.basis.slope(j, &estimate.weights, &inputs.v), run)
    };
    let lag = estimate.driver.filter(|_| estimate.seeks_lag).map(|driver| {
        let Ok(block) = estimate.basis.operator(&estimate.weights) else { return Vec::new() };
        let step = RELATIVE_LAG_STEP * driver.lag_s;
        let z = |lag_s: f64| {
            let inputs = Inputs::of(run, Some(DriverModel { lag_s, ..driver }));
            inputs.by_sample(&block.simulate(&inputs.v), run)
        };
        let (more, less) = (z(driver.lag_s + step), z(driver.lag_s - step));
        more.iter().zip(&less).map(|(more, less)| (more - less) / (2.0 * step)).collect()
    });
    (0..estimate.basis.shape().len()).map(shape).chain(lag).collect()
}

#[cfg(test)]
mod tests {
    use super::super::solve::Prior;
    use super::super::testing::{TS, full_estimate};
    use super::*;
    use nalgebra::DMatrix;
    use piezoid_models::hysteresis::OPERATORS;
    use piezoid_records::record::Record;

    /// The free run by the law, sample by sample.
    fn free_run(estimate: &Estimate, run: &TrainingRecord, own: &[f64]) -> Vec<f64> {
        let layout = ColumnLayout::of(estimate);
        let own_of = |column: usize| own[column - layout.parameters()];
        let (a, b) = (estimate.linear.a(), estimate.linear.b());
        let level = Responses::level(estimate, run);
        let level = dot(&level, &estimate.weights);
        let mut responses = Responses::from_rest(estimate, run);
        let moving = run.moving();
        let (earlier, later) = run.before[1..].split_at(run.before.len() - 1 - moving);
        earlier.iter().for_each(|&u| _ = responses.next(u));
        let mut lags: Vec<f64> = vec![0.0; estimate.lags.len()];
        let mut initial: Vec<f64> = layout.crept.clone().map(own_of).collect();
        let state = of_differences(&layout.state.clone().map(own_of).collect::<Vec<_>>());
        let (mut zc, mut y): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        for (t, &u) in later.iter().chain(run.record.u()).enumerate() {
            let z = dot(responses.next(u), &estimate.weights) - level;
            let mut crept = z;
            for (lag, of) in lags.iter_mut().zip(&estimate.lags) {
                let stays = (-TS / of.tau_s).exp();
                *lag = stays * *lag + (1.0 - stays) * z;
                crept += of.gain * *lag;
            }
            if t >= moving {
                for (initial, of) in initial.iter_mut().zip(&estimate.lags) {
                    *initial *= (-TS / of.tau_s).exp();
                    crept += *initial;
                }
            }
            zc.push(crept);
            let past = |x: &[f64], back: usize| if back <= t { x[t - back] } else { 0.0 };
            let fed_back: f64 = a.iter().enumerate().map(|(i, a)| a * if t > i { y[t - 1 - i] } else { 0.0 }).sum();
            let fed_forward: f64 = b.iter().enumerate().map(|(j, b)| b * past(&zc, j)).sum();
            let state = t.checked_sub(moving).and_then(|t| state.get(t)).unwrap_or(&0.0);
            y.push(fed_back + fed_forward + state);
        }
        let y = y.split_off(moving);
        let slope = own_of(layout.trend) / y.len() as f64;
        let line = |t: usize| own_of(layout.constant) + slope * t as f64 - 0.5 * own_of(layout.trend);
        y.iter().enumerate().map(|(t, y)| y + line(t)).collect()
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
            let estimate = full_estimate(row, driver);
            let layout = ColumnLayout::of(&estimate);
            let x = Prior::of(&estimate).current().as_slice().to_vec();
            let own: Vec<f64> = (0..layout.own()).map(|k| 3.0 + k as f64).collect();
            for (record, moving) in records.iter().zip([false, true]) {
                let run = TrainingRecord::new(record, "record", true, vec![true; record.len()]).unwrap();
                assert_eq!(run.moving() > 0, moving);
                let run = TrainingRecord { drifts: true, ..run };
                let mut columns = RunColumns::new(&estimate, &run, &layout, &own, FreeParameters::All);
                let size = layout.columns() + 1;
                let mut rows = DMatrix::zeros(size, record.len());
                columns.pass_earlier_inputs();
                for from in (0..record.len()).step_by(FILTERED_SAMPLES) {
                    let to = record.len().min(from + FILTERED_SAMPLES);
                    columns.advance(from..to, |_| true, &mut rows.as_mut_slice()[from * size..]);
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
                    let off: Vec<f64> = column.iter().zip(&slope).map(|(c, s)| c - s).collect();
                    let most = |x: &[f64]| x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
                    // The column of the lag is a difference quotient: it differs where a play reverses.
                    let is_close = match driver.is_some() && k + 1 == layout.shape.end {
                        true => dot(&off, &off) < 0.01 * dot(&slope, &slope),
                        false => most(&off) <= 2e-5 * most(&slope) + 1e-7,
                    };
                    assert!(
                        is_close,
                        "{} {driver:?} moving {moving}: column {k} of {layout:?} is off by {:e} of {}",
                        row.name,
                        most(&off),
                        most(&slope)
                    );
                }
            }
        }
    }
}
