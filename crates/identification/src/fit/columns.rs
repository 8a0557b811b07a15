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

use super::estimate::{Estimate, Responses, of_differences};
use super::gram::Rows;
use super::hidden::Inputs;
use super::layout::ColumnLayout;
use super::runs::TrainingRecord;
use super::signals::{AllPole, CreepStates, Filters};
use super::solve::FreeParameters;
use libm::expm1;
use piezoid_models::driver::DriverModel;
use piezoid_numerics::series::dot_wide;
use std::ops::Range;
use tracing::trace_span;

/// Samples that are filtered at a time.
pub(super) const FILTERED_SAMPLES: usize = 64;

/// Step of the difference quotient for the lag of the driver, over the lag.
const RELATIVE_LAG_STEP: f64 = 1e-3;

/// The columns of a run, block by block.
pub(super) struct RunColumns<'a> {
    estimate: &'a Estimate,
    pub(super) run: &'a TrainingRecord<'a>,
    pub(super) layout: &'a ColumnLayout,
    /// The initial state of G as the coefficients of single samples.
    state: Vec<f64>,
    responses: Responses<'a>,
    /// The origin of the responses.
    level: Vec<f64>,
    /// dz/dp of each shape parameter.
    slopes: Vec<std::vec::IntoIter<f64>>,
    creep: CreepStates,
    /// What creep and G filter: responses, then slopes.
    through_creep: Filters,
    /// What G alone filters: lags, then decaying lags.
    through_g: Filters,
    /// The rows of what is filtered.
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
        own: &[f64],
        free: FreeParameters,
    ) -> Self {
        let (a, b) = (estimate.linear.a(), estimate.linear.b());
        let creep = creep(estimate);
        let level = Responses::level(estimate, run);
        let responses = Responses::before_moving(estimate, run);
        let slopes = match free {
            FreeParameters::All | FreeParameters::Shape => slopes(estimate, run),
            _ => vec![Vec::new(); layout.shape.len()],
        };
        let slopes: Vec<_> = slopes.into_iter().map(Vec::into_iter).collect();
        let through_creep = Filters::new(layout.weights.len() + slopes.len(), &creep, a, b);
        let through_g = Filters::new(2 * creep.len(), &[], a, b);
        let past = layout.state.len();
        let (crept, state) = match own {
            [] => (vec![0.0; creep.len()], vec![0.0; past]),
            _ => (own[..creep.len()].to_vec(), of_differences(&own[creep.len()..creep.len() + past])),
        };
        RunColumns {
            creep: CreepStates::new(&creep, &crept),
            state,
            level,
            entering: vec![0.0; FILTERED_SAMPLES * (through_creep.len() + through_g.len())],
            through_creep,
            through_g,
            y_by_a: AllPole::new(a, a.len()),
            zc_by_a: AllPole::new(a, b.len()),
            impulse_by_a: AllPole::new(a, past),
            estimate,
            run,
            layout,
            responses,
            slopes,
        }
    }

    /// Advances over the inputs before the record that pass creep and linear block.
    pub(super) fn pass_earlier_inputs(&mut self) {
        let moving = &self.run.before[self.run.before.len() - self.run.moving..];
        moving.chunks(FILTERED_SAMPLES).for_each(|inputs| self.filter(inputs, false));
        self.creep.begin();
    }

    /// Advances over at most [`FILTERED_SAMPLES`] samples, and appends those `selected`, in ascending order, to `rows`,
    /// y last, each multiplied by `weight`.
    pub(super) fn advance(&mut self, samples: Range<usize>, selected: &[usize], weight: f64, rows: &mut Rows) {
        let (run, layout) = (self.run, self.layout);
        self.filter(&run.record.u()[samples.clone()], samples.start == 0);
        let within = |end: usize| selected.partition_point(|t| *t < end);
        let selected = &selected[within(samples.start)..within(samples.end)];
        let selected: Vec<usize> = selected.iter().map(|t| t - samples.start).collect();
        let (width, behind_creep) = (self.through_creep.len() + self.through_g.len(), self.through_creep.len());
        let (first, last) = (rows.extend(selected.len()), layout.columns());
        for (row, &k) in (first..).zip(&selected) {
            let (through_creep, through_g) = self.entering[k * width..][..width].split_at(behind_creep);
            for (range, signals) in [
                (&layout.weights, through_creep),
                (&layout.shape, &through_creep[layout.weights.len()..]),
                (&layout.gains, through_g),
                (&layout.crept, &through_g[layout.gains.len()..]),
            ] {
                rows.set_scaled(row, range.start, &signals[..range.len()], weight);
            }
        }
        rows.set_column(first, layout.constant, selected.iter().map(|_| weight));
        // About the middle, so that the constant is that of the whole record.
        let part = |k: &usize| weight * ((samples.start + k) as f64 / run.record.len() as f64 - 0.5);
        rows.set_column(first, layout.trend, selected.iter().map(part));
        // Relative to the level, to avoid cancellation.
        let y = &run.record.y()[samples.clone()];
        rows.set_column(first, last, selected.iter().map(|&k| weight * (y[k] - run.level)));
        for (signal, delay, columns) in [
            (&self.y_by_a, 1, &layout.a),
            (&self.zc_by_a, self.estimate.linear.delay(), &layout.b),
            (&self.impulse_by_a, 0, &layout.state),
        ] {
            signal.differences(delay, columns.len(), |order, values| {
                rows.set_column(first, columns.start + order, selected.iter().map(|&k| weight * values[k]));
            });
        }
    }

    /// Passes these inputs through the blocks; `is_first` if they begin the record.
    fn filter(&mut self, inputs: &[f64], is_first: bool) {
        let _span = trace_span!("columns", weights = self.layout.weights.len()).entered();
        let behind_creep = self.through_creep.len();
        let (width, weights) = (behind_creep + self.through_g.len(), self.layout.weights.len());
        let entering = &mut self.entering[..inputs.len() * width];
        let mut z = Vec::with_capacity(FILTERED_SAMPLES);
        for (row, &u) in entering.chunks_exact_mut(width).zip(inputs) {
            let (responses, sloped) = row.split_at_mut(weights);
            for ((v, phi), level) in responses.iter_mut().zip(self.responses.next(u)).zip(&self.level) {
                *v = phi - level;
            }
            for (v, slope) in sloped.iter_mut().zip(&mut self.slopes) {
                *v = slope.next().unwrap_or_default();
            }
            z.push(dot_wide::<8>(responses, &self.estimate.weights));
        }
        let zc = self.creep.pass(&z, entering, width, behind_creep);
        self.zc_by_a.pass(&zc);
        let mut impulse = vec![0.0; inputs.len()];
        impulse.iter_mut().take(usize::from(is_first)).for_each(|v| *v = 1.0);
        self.impulse_by_a.pass(&impulse);
        let mut y = vec![0.0; inputs.len()];
        self.zc_by_a.add_to(&mut y, self.estimate.linear.b());
        self.impulse_by_a.add_to(&mut y, &self.state);
        self.y_by_a.pass(&y);
        self.through_creep.pass(entering, width, 0);
        self.through_g.pass(entering, width, behind_creep);
    }
}

/// 1 - exp(-Ts / tau), and gain, of each lag of creep.
pub(super) fn creep(estimate: &Estimate) -> Vec<(f64, f64)> {
    estimate.lags.iter().map(|lag| (-expm1(-estimate.ts() / lag.tau_s), lag.gain)).collect()
}

/// dz/dp_j along a run and the inputs before it that pass the linear block, relative to the origin of z; then
/// dz/d(lag) of a driver whose lag is sought.
pub(super) fn slopes(estimate: &Estimate, run: &TrainingRecord) -> Vec<Vec<f64>> {
    let inputs = Inputs::of(run, estimate.driver);
    let of_shape = estimate.basis.slopes(&estimate.weights, &inputs.v);
    let of_shape = of_shape.iter().map(|slope| inputs.by_sample(slope, run));
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
    of_shape.chain(lag).collect()
}

#[cfg(test)]
mod tests {
    use super::super::solve::{Prior, Scales};
    use super::super::testing::{TS, full_estimate};
    use super::*;
    use piezoid_models::hysteresis::OPERATORS;
    use piezoid_numerics::series::dot;
    use piezoid_records::record::Record;

    /// The free run by the law, sample by sample.
    fn free_run(estimate: &Estimate, run: &TrainingRecord, own: &[f64]) -> Vec<f64> {
        let layout = ColumnLayout::of(estimate);
        let own_of = |column: usize| own[column - layout.parameters()];
        let (a, b) = (estimate.linear.a(), estimate.linear.b());
        let level = Responses::level(estimate, run);
        let level = dot(&level, &estimate.weights);
        let mut responses = Responses::from_rest(estimate, run);
        let moving = run.moving;
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
            let x = Prior::of(&estimate, Scales::default()).current().as_slice().to_vec();
            let own: Vec<f64> = (0..layout.own()).map(|k| 3.0 + k as f64).collect();
            for (record, moving) in records.iter().zip([false, true]) {
                let run = TrainingRecord::new(record, "record", true, vec![true; record.len()]).unwrap();
                assert_eq!(run.moving > 0, moving);
                let run = TrainingRecord { drifts: true, ..run };
                let mut columns = RunColumns::new(&estimate, &run, &layout, &own, FreeParameters::All);
                let all: Vec<usize> = (0..record.len()).collect();
                let mut rows = Rows::new(layout.columns() + 1, record.len());
                columns.pass_earlier_inputs();
                for from in (0..record.len()).step_by(FILTERED_SAMPLES) {
                    let to = record.len().min(from + FILTERED_SAMPLES);
                    columns.advance(from..to, &all, 2.0, &mut rows);
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
                    let column: Vec<f64> = (0..record.len()).map(|t| 0.5 * rows.get(t, k)).collect();
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
