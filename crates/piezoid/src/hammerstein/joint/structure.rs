//! The initial linear block and its number of parameters.
//!
//! Small-signal records determine order and delay directly. With large-signal records alone, a coarse Preisach grid
//! represents the hysteresis, its z replaces the input, and each structure, from a pure gain on, is refined together
//! with it. Records with few frequencies determine few coefficients: a block of order n needs n + 1 frequencies. The
//! simplest structure is selected that predicts held-out data as well as the best.

use super::JointOptions;
use super::dynamics::{
    SAME_COST, creep_pole, is_lag, without_factor, slowest_observable, slowest_pole, with_slow_lags_limited,
};
use super::estimate::{Estimate, Responses};
use super::extend::{Extension, extensions};
use super::held_out::HeldOut;
use super::refine::{Fitted, StepCallback, refine, refine_from};
use super::runs::TrainingRecord;
use super::solve::FreeParameters;
use crate::creep::{Creep, Lag};
use crate::driver::DriverModel;
use crate::error::Error;
use crate::fourier::plain_power;
use crate::hammerstein::{Domain, InitialCondition, Model};
use crate::hammerstein::large_signal::{affine, lines, require_excitation};
use crate::hysteresis::{Basis, BasisDesign, Operator, Proportional};
use crate::linear::{Arx, Estimator, OrderSearch, Orders, OutputError, Pole, Refinement, free_decay_modes, refine as refine_alone, select};
use crate::number::short;
use crate::optimize::swarm;
use crate::progress::Stage;
use crate::record::Record;
use crate::series::{dot, scatter};
use crate::system::System;
use crate::waveform::dominant_frequency;
use std::cmp::Ordering;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Highest order tried, and longest delay of small-signal records [samples].
const ORDER: usize = 8;
const DELAY: usize = 3;

/// Ratio of delayed to direct gain from which the output counts as delayed.
const CLEARLY: f64 = 1.5;

/// Extensions without gain before the search ends, and the ratio of held-out errors that is a gain.
const VAIN: usize = 1;
const GAIN: f64 = 0.95;

/// Ratio of held-out errors with a coarse hysteresis, from which a structure is not tried with another operator.
const HOPELESS: f64 = 2.0;

/// Number of frequencies of the inputs from which modes between them show; otherwise the least ratio of the frequency
/// of a mode to theirs.
const FEW: usize = 6;
const ABOVE: f64 = 2.0;

/// Distance of power from the dominant frequency of an input, as a ratio, and its share from which the input is broad.
const AWAY: f64 = 1.3;
const BROAD: f64 = 0.1;

/// Difference of ln(frequency) up to which two modes are the same. A pair of poles with more damping is not a mode.
const NEAR: f64 = 0.2;
const RINGS: f64 = 0.5;

/// Rows of the grid that represents the hysteresis.
const COARSE: usize = 12;

/// The linear block from small-signal records, and the reason. Its gain has the sign of the large-signal records:
/// hysteresis with jumps at reversals may invert small signals.
pub(super) fn from_small_signal(
    small: &[Record],
    large_signal: &[Record],
    settings: &JointOptions,
    lags: &[Lag],
) -> Result<(Arx, String), Error> {
    let (linear, reason) = select_on_small_signal(small, settings, lags)?;
    let linear = with_slow_lags_limited(linear, slowest_observable(small.iter().chain(large_signal)))?;
    let inverted = linear.proportional(0.0, large_signal)?.0 < 0.0;
    Ok((if inverted { rescaled(&linear, -linear.dc_gain())? } else { linear }, reason))
}

fn select_on_small_signal(small: &[Record], settings: &JointOptions, lags: &[Lag]) -> Result<(Arx, String), Error> {
    let slowest = slowest_pole(settings, lags);
    require_excitation(small, 1)?;
    let driven: Vec<Record> = small.iter().map(|record| behind_driver(record, settings)).collect::<Result<_, _>>()?;
    let most = lines(small).len().saturating_sub(1).clamp(1, ORDER);
    if let Some(n) = settings.order {
        require_excitation(small, n)?;
        return of_order(&driven, n);
    }
    let found = select(
        &driven,
        &OrderSearch { order: most, delay: DELAY, parallel: true, ..OrderSearch::default() },
        &mut Stage::ignore,
    )?;
    let creeps = |arx: &Arx| creep_pole(arx, slowest).is_some();
    if !creeps(&found.fit.arx) {
        return Ok((found.fit.arx, found.reason));
    }
    // A slow lag of the linear block is creep, which has its own block.
    let chosen = &found.candidates[found.chosen];
    let near = found.candidates.iter().filter(|c| !creeps(&c.arx) && c.held_out <= 1.1 * chosen.held_out);
    match near.min_by_key(|c| (c.orders.na, std::cmp::Reverse(c.orders.delay))) {
        None => Ok((found.fit.arx, found.reason)),
        Some(near) => {
            let fit = refine_alone(&driven, &near.arx, &Refinement::default(), &mut Stage::ignore)?;
            let (n, delay) = (near.orders.na, near.orders.delay);
            Ok((
                fit.arx,
                format!(
                    "order {n} with delay {delay}, because the better block has a lag as slow as creep ({})",
                    found.reason
                ),
            ))
        }
    }
}

/// The block of order `n`, with the best delay.
fn of_order(records: &[Record], n: usize) -> Result<(Arx, String), Error> {
    let of = |delay| {
        OutputError::fit(records, Orders { delay, ..Orders::of(n) }, &Refinement::default(), &mut Stage::ignore)
    };
    let tried: Vec<_> = (0..=DELAY).map(of).collect::<Result<_, _>>()?;
    let least = tried.iter().map(|fit| fit.minimum.cost).fold(f64::INFINITY, f64::min);
    // The longest delay at the same cost.
    let chosen = tried.into_iter().rfind(|fit| fit.minimum.cost <= SAME_COST * least);
    let chosen = chosen.ok_or_else(|| Error::Content("no delay was tried".into()))?;
    let delay = chosen.orders.delay;
    let reason = format!("order {n} as specified, with delay {delay}, which gives the smallest residual");
    let predicted = Estimator::find("least-squares")?.fit(
        records,
        Orders::of(n),
        &swarm::SwarmSettings::default(),
        &mut Stage::ignore,
    );
    let doubt = predicted.ok().and_then(|fit| fit.order_too_low(records)).unwrap_or_default();
    Ok((chosen.arx, reason + &doubt))
}

/// The record with the driver's output as its input.
fn behind_driver(record: &Record, settings: &JointOptions) -> Result<Record, Error> {
    if settings.driver.is_none() {
        return Ok(record.clone());
    }
    let ts = record.ts();
    let unit = Arc::new(Proportional::new(ts / DriverModel::SUBSTEPS as f64, 1.0)?);
    let alone = Model::driven(settings.driver, unit, Arx::gain(ts, 1.0)?, 0.0)?;
    let u = alone.resume(&mut alone.settled(record.u()[0]), record.u());
    Ok(Record::new(ts, u, record.y().to_vec())?.with_units(record.units().clone()))
}

/// A linear block, how it came about, and the fit with it.
#[derive(Debug)]
pub(super) struct Structure {
    name: String,
    pub(super) fitted: Fitted,
}

impl Structure {
    /// The structure of a fit.
    pub(super) fn new(name: String, fitted: Fitted) -> Self {
        Structure { name, fitted }
    }

    fn held_out(&self) -> &HeldOut {
        &self.fitted.held_out
    }

    fn better(p: &&Structure, q: &&Structure) -> Ordering {
        p.held_out().rms_pp().total_cmp(&q.held_out().rms_pp())
    }
}

/// Makes the basis of an operator for a sampling period [s].
type MakeBasis<'a> = &'a dyn Fn(f64) -> Result<Box<dyn Basis>, Error>;

/// The search for the structure of the linear block, one extension after the other.
pub(super) struct Growth {
    /// Modes seen in free decays.
    modes: Vec<Pole>,
    /// True if the driver is known.
    has_driver: bool,
    /// Frequency of the slowest lag that is not creep [Hz].
    slowest: f64,
    /// The lowest frequency of a mode that only shows in the response to the inputs [Hz].
    lowest: f64,
    /// The specified order, and the highest order.
    order: Option<usize>,
    most: usize,
    /// How a basis is made.
    design: BasisDesign,
}

impl Growth {
    pub(super) fn new(large_signal: &[Record], settings: &JointOptions, lags: &[Lag], design: &BasisDesign) -> Self {
        let hz = |record: &Record| dominant_frequency(record.u(), record.ts());
        let driven: Vec<f64> = large_signal.iter().filter_map(hz).collect();
        // Between a few frequencies of the inputs, a mode could be anywhere.
        let lowest = if driven.len() < FEW && !large_signal.iter().any(is_broadband) {
            ABOVE * driven.iter().copied().fold(0.0, f64::max)
        } else {
            driven.iter().copied().reduce(f64::min).unwrap_or(0.0)
        };
        Growth {
            modes: free_decay_modes(large_signal),
            has_driver: settings.driver.is_some(),
            slowest: slowest_pole(settings, lags),
            lowest,
            order: settings.order,
            most: settings.order.unwrap_or(ORDER),
            design: design.clone(),
        }
    }

    /// Extends the last structure of `tried` until that gains nothing.
    pub(super) fn grow(
        &self,
        tried: &mut Vec<Structure>,
        patience: usize,
        basis: MakeBasis,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<(), Error> {
        let (mut vain, mut behind_lag) = (0, self.has_driver);
        while let Some(from) = tried.last().map(|last| &last.fitted).filter(|_| vain < patience) {
            let mut longer: Vec<Structure> = Vec::new();
            for Extension { name, linear } in
                extensions(from, runs, &self.modes, self.slowest, self.lowest, self.most, watch)?
            {
                let Some(richer) = from.estimate.with_linear(linear) else { continue };
                let fit = refine_from(richer, Some(from.held_out.lambda), runs, FreeParameters::All, watch)?;
                if std::env::var_os("PZ_DEBUG").is_some() {
                    eprintln!("{name}: held out {:.4} {:?} {:?} {:?}", 100.0 * fit.held_out.rms_pp(), fit.estimate.linear.poles().iter().map(|p| (p.hz, p.damping)).collect::<Vec<_>>(),
                    fit.residuals.iter().map(|r| 100.0 * r.sqrt()).collect::<Vec<_>>(), fit.estimate.lags);
                }
                if creep_pole(&fit.estimate.linear, self.slowest).is_none() && self.shows(&fit.estimate.linear) {
                    longer.push(Structure::new(name, fit));
                }
            }
            let least = tried.iter().map(|t| t.held_out().rms_pp()).fold(f64::INFINITY, f64::min);
            let gains = |longer: &[Structure]| longer.iter().any(|t| t.held_out().rms_pp() < GAIN * least);
            if !gains(&longer) && !behind_lag {
                behind_lag = true;
                longer.extend(self.behind_lag(tried, basis, runs, watch)?);
            }
            let Some(mut next) = longer.into_iter().min_by(|p, q| Structure::better(&p, &q)) else { break };
            vain = if next.held_out().rms_pp() < GAIN * least { 0 } else { vain + 1 };
            if begin(&next.fitted, runs, self.design.range)? {
                let fitted = &next.fitted;
                if let Some(same) = fitted.estimate.with_linear(fitted.estimate.linear.clone()) {
                    next.fitted = refine_from(same, Some(fitted.held_out.lambda), runs, FreeParameters::All, watch)?;
                }
            }
            tried.push(next);
        }
        Ok(())
    }

    /// The best structures so far with a lag before the hysteresis: a new one, or one of those behind it.
    fn behind_lag(
        &self,
        tried: &[Structure],
        basis: MakeBasis,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<Vec<Structure>, Error> {
        let Some(best) = tried.iter().min_by(Structure::better).map(|best| &best.fitted) else { return Ok(Vec::new()) };
        let (linear, shape) = (&best.estimate.linear, best.estimate.basis.shape());
        let shape: Vec<f64> = shape.iter().map(|shape| shape.value).collect();
        let ts = linear.ts();
        let moved = linear.poles().into_iter().filter(is_lag).map(|pole| {
            let a = without_factor(&linear.denominator(), pole.z.re);
            let b = linear.b().iter().map(|b| b / (1.0 - pole.z.re)).collect();
            (1.0 / (TAU * pole.hz), Arx::new(ts, a[1..].iter().map(|a| -a).collect(), b))
        });
        let delay = linear.delay();
        let instead = (delay > 0).then(|| {
            (delay as f64 * ts, Arx::new(ts, linear.a().to_vec(), linear.b()[delay..].to_vec()))
        });
        let mut found = Vec::new();
        for (lag_s, linear) in moved.chain([(0.2 * ts, Ok(linear.clone()))]).chain(instead) {
            let driver = DriverModel::new(lag_s, None)?;
            let made = basis(ts / DriverModel::SUBSTEPS as f64)?.reshaped(&shape)?;
            let Some(like) = best.estimate.with_linear(linear?) else { continue };
            let start = Estimate { driver: Some(driver), seeks_lag: true, basis: made, ..like };
            let fit = refine_from(start, Some(best.held_out.lambda), runs, FreeParameters::All, watch)?;
            if std::env::var_os("PZ_DEBUG").is_some() {
                eprintln!("  lag before the hysteresis {lag_s}: held out {:.4} {:?} {:?} {:?}", 100.0 * fit.held_out.rms_pp(), fit.estimate.driver, fit.estimate.linear.poles().iter().map(|p| (p.hz, p.damping)).collect::<Vec<_>>(),
                fit.residuals.iter().map(|r| 100.0 * r.sqrt()).collect::<Vec<_>>());
            }
            found.push(Structure::new("a lag before the hysteresis".into(), fit));
        }
        Ok(found)
    }

    /// True if each mode of a linear block shows in the records.
    fn shows(&self, linear: &Arx) -> bool {
        let seen = |hz: f64| self.modes.iter().any(|mode| (mode.hz / hz).ln().abs() < NEAR);
        let rings = |pole: &&Pole| pole.z.im > 0.0 && pole.damping < RINGS;
        linear.poles().iter().filter(rings).all(|pole| pole.hz >= self.lowest || seen(pole.hz))
    }

    /// The simplest structure that is as good as the best, and the reason.
    pub(super) fn choose(&self, tried: &[Structure]) -> (usize, String) {
        let best = tried.iter().map(|t| t.held_out().rms_pp()).fold(f64::INFINITY, f64::min);
        let as_good = |t: &Structure| GAIN * t.held_out().rms_pp() <= best;
        let (chosen, why) = match self.order {
            Some(n) if n > 0 => {
                let of_order = |t: &Structure| t.fitted.estimate.linear.a().len() == n;
                (tried.iter().rposition(of_order), "the specified order is used")
            }
            _ => (tried.iter().position(as_good), "the simplest that is as good as the best is selected"),
        };
        let chosen = chosen.unwrap_or(tried.len().saturating_sub(1));
        let error = |t: &Structure| format!("{} {} %", t.name, short(100.0 * t.held_out().rms_pp()));
        let listed: Vec<String> = tried.iter().map(error).collect();
        let name = tried.get(chosen).map_or("", |t| &t.name);
        (chosen, format!("{name}: held-out error, rms/pp: {}; {why}", listed.join(", ")))
    }

    /// The simplest structure for the operator of a fit: those simpler than its own, its own, and extensions.
    pub(super) fn settle(
        &self,
        fitted: Fitted,
        simpler: &[Structure],
        row: &Operator,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<(Fitted, String), Error> {
        let mut tried = Vec::new();
        let least = simpler.iter().map(|t| t.held_out().rms_pp()).fold(f64::INFINITY, f64::min);
        let near = |t: &&Structure| t.held_out().rms_pp() < HOPELESS * least;
        for Structure { name, fitted: coarse } in simpler.iter().filter(near) {
            let Some(mut start) = fitted.estimate.with_linear(coarse.estimate.linear.clone()) else { continue };
            start.lags.clone_from(&coarse.estimate.lags);
            let fit = refine_from(start, Some(fitted.held_out.lambda), runs, FreeParameters::All, watch)?;
            tried.push(Structure::new(name.clone(), fit));
        }
        tried.push(Structure::new("that of the search".into(), fitted));
        let basis = |ts: f64| (row.basis)(&BasisDesign { ts, ..self.design.clone() });
        self.grow(&mut tried, 1, &basis, runs, watch)?;
        let (chosen, reason) = self.choose(&tried);
        Ok((tried.swap_remove(chosen).fitted, reason))
    }
}

/// The structures of the linear block that large-signal records alone show, from the simplest on, with a coarse
/// hysteresis.
pub(super) fn from_large_signal(
    large_signal: &[Record],
    runs: &mut [TrainingRecord],
    settings: &JointOptions,
    design: &BasisDesign,
    lags: &[Lag],
    growth: &Growth,
    watch: StepCallback,
) -> Result<Vec<Structure>, Error> {
    let ts = large_signal[0].ts();
    let coarse = BasisDesign { elements: Some(COARSE), ..design.clone() };
    let start = |linear: Arx| -> Result<Estimate, Error> {
        Ok(Estimate::new(settings.driver, (Operator::find("preisach")?.basis)(&coarse)?, lags.to_vec(), linear))
    };
    let (gain, first) = start_gain(large_signal)?;
    let delayed_gain = |d: usize, next: f64| {
        let b = [vec![0.0; d], vec![(1.0 - next) * gain], vec![next * gain; usize::from(next > 0.0)]].concat();
        Arx::new(ts, Vec::new(), b)
    };
    let plain = begin_all(&|| start(delayed_gain(first, 0.0)?), runs, design.range, watch)?;
    let best_delay = delay(&hidden(&plain, runs)?);
    let delayed = |d: usize| if d == 0 { "a gain".into() } else { format!("a gain with a delay of {d} samples") };
    let mut tried = vec![Structure::new(delayed(first), plain)];
    if settings.order.unwrap_or(0) == 0 {
        if best_delay > first {
            let fit = refine(start(delayed_gain(best_delay, 0.0)?)?, runs, FreeParameters::Creep, watch)?;
            tried.push(Structure::new(delayed(best_delay), fit));
        }
        let from = best_delay.saturating_sub(1);
        let fit = refine(start(delayed_gain(from, 0.5)?)?, runs, FreeParameters::All, watch)?;
        // A share outside 0 to 1 is not a delay.
        if fit.estimate.linear.b()[from..].iter().all(|b| b * gain >= 0.0) {
            tried.push(Structure::new(format!("a gain with a delay between {from} and {} samples", from + 1), fit));
        }
    }
    // The best of these is the last.
    let best = tried.iter().enumerate().min_by(|p, q| Structure::better(&p.1, &q.1)).map_or(0, |(k, _)| k);
    tried.truncate(best + 1);
    growth.grow(&mut tried, VAIN, &|ts| (Operator::find("preisach")?.basis)(&BasisDesign { ts, ..coarse.clone() }), runs, watch)?;
    Ok(tried)
}

/// True if the input has much power away from its dominant frequency, and above it.
fn is_broadband(record: &Record) -> bool {
    let Some(dominant) = dominant_frequency(record.u(), record.ts()) else { return false };
    let bin = dominant * record.len() as f64 * record.ts();
    let power = plain_power(record.u());
    let (line, above) = power.iter().enumerate().fold((0.0, 0.0), |(line, above), (k, power)| match k as f64 / bin {
        share if share > AWAY => (line, above + power),
        share if share > 1.0 / AWAY => (line + power, above),
        _ => (line, above),
    });
    above > BROAD * line
}

/// A fit with the initial conditions of the large-signal records that it shows. Hysteresis without a past and after
/// cycles over the whole range explain the same records by different weights, so both are fitted.
fn begin_all(
    start: &dyn Fn() -> Result<Estimate, Error>,
    runs: &mut [TrainingRecord],
    range: (f64, f64),
    watch: StepCallback,
) -> Result<Fitted, Error> {
    let mut likely = refine(start()?, runs, FreeParameters::Creep, watch)?;
    let large_signal = |runs: &[TrainingRecord]| -> Vec<InitialCondition> { runs.iter().map(|run| run.initial).collect() };
    let before = large_signal(runs);
    runs.iter_mut().filter(|run| run.large_signal).for_each(|run| run.begin_from(InitialCondition::FromBelow, range));
    let cycled = refine(start()?, runs, FreeParameters::Creep, watch)?;
    if cycled.cost() < likely.cost() {
        likely = cycled;
    } else {
        runs.iter_mut().zip(before).for_each(|(run, initial)| run.begin_from(initial, range));
    }
    while begin(&likely, runs, range)? {
        likely = refine(start()?, runs, FreeParameters::Creep, watch)?;
    }
    Ok(likely)
}

/// The creep that a coarse fit shows behind this linear block, with the initial conditions of the records.
pub(super) fn creep_behind(
    linear: &Arx,
    runs: &mut [TrainingRecord],
    settings: &JointOptions,
    design: &BasisDesign,
    lags: &[Lag],
    watch: StepCallback,
) -> Result<Vec<Lag>, Error> {
    let coarse = BasisDesign { elements: Some(COARSE), ..design.clone() };
    let start = || {
        let basis = (Operator::find("preisach")?.basis)(&coarse)?;
        Ok(Estimate::new(settings.driver, basis, lags.to_vec(), linear.clone()))
    };
    Ok(begin_all(&start, runs, design.range, watch)?.estimate.lags)
}

/// Selects the initial conditions of the large-signal records; true if one changed to another than before.
fn begin(fitted: &Fitted, runs: &mut [TrainingRecord], range: (f64, f64)) -> Result<bool, Error> {
    let model = fitted.estimate.model(0.0)?.with_identified(Domain { u: range.into(), hz: None, slew: 0.0, mean: range.into() });
    let mut changed = false;
    for run in runs.iter_mut().filter(|run| run.large_signal) {
        changed |= run.begin(&model, range);
    }
    Ok(changed)
}

/// The initial gain and its delay [samples]. The sign is that of the slowest record, because near a resonance the
/// output opposes the input. The delay is the one at which the output clearly correlates with the input.
fn start_gain(large_signal: &[Record]) -> Result<(f64, usize), Error> {
    let hz = |record: &&Record| dominant_frequency(record.u(), record.ts()).unwrap_or(0.0);
    let slowest = large_signal.iter().min_by(|p, q| hz(p).total_cmp(&hz(q))).unwrap_or(&large_signal[0]);
    let lagged = |d: usize| -> Result<f64, Error> {
        let (u, y) = (&slowest.u()[..slowest.len() - d], &slowest.y()[d..]);
        Ok(affine(&[Record::new(slowest.ts(), u.to_vec(), y.to_vec())?])?.0)
    };
    let direct = lagged(0)?;
    let later = (1..=DELAY.min(slowest.len() / 4)).map(|d| Ok((lagged(d)?, d))).collect::<Result<Vec<_>, Error>>()?;
    let strongest = later.into_iter().max_by(|p, q| p.0.abs().total_cmp(&q.0.abs()));
    match strongest.filter(|(gain, _)| gain.abs() > CLEARLY * direct.abs()) {
        Some(late) => Ok(late),
        None => Ok((affine(large_signal)?.0.copysign(direct), 0)),
    }
}

/// The runs with z after creep, relative to the first sample, in place of u, and without their drift.
fn hidden(fitted: &Fitted, runs: &[TrainingRecord]) -> Result<Vec<Record>, Error> {
    let estimate = &fitted.estimate;
    let creep = Creep::new(estimate.ts(), estimate.lags.clone())?;
    let of = |(run, own): (&TrainingRecord, &Vec<f64>)| {
        let (mut responses, level) = Responses::before(estimate, run);
        let level = dot(&level, &estimate.weights);
        let z: Vec<f64> =
            run.record.u().iter().map(|&u| dot(responses.next(u), &estimate.weights) - level).collect();
        let rise = own.last().filter(|_| run.drifts).map_or(0.0, |trend| trend / z.len() as f64);
        let y = run.bridged().iter().enumerate().map(|(t, y)| y - rise * t as f64).collect();
        Record::new(estimate.ts(), creep.simulate(&z), y)
    };
    runs.iter().zip(&fitted.own).map(of).collect()
}

/// The delay [samples] with the smallest residual of a gain, up to a tenth of the shortest record.
fn delay(hidden: &[Record]) -> usize {
    let longest = hidden.iter().map(|r| r.len() / 10).min().unwrap_or(0).min(256);
    let residual = |d: usize| -> f64 {
        let of = |r: &Record| {
            let (z, y) = (&r.u()[..r.len() - d], &r.y()[d..]);
            let (mz, my) = (crate::series::mean(z), crate::series::mean(y));
            let crossed: f64 = z.iter().zip(y).map(|(z, y)| (z - mz) * (y - my)).sum();
            1.0 - crossed * crossed / (scatter(z) * scatter(y))
        };
        hidden.iter().map(of).sum()
    };
    let (mut best, mut least) = (0, residual(0));
    // Only up to the first minimum: after it comes the next period.
    while best < longest && residual(best + 1) < least {
        best += 1;
        least = residual(best);
    }
    best
}

/// The block with another static gain.
fn rescaled(arx: &Arx, gain: f64) -> Result<Arx, Error> {
    let k = gain / arx.dc_gain();
    Arx::new(arx.ts(), arx.a().to_vec(), arx.b().iter().map(|b| b * k).collect())
}
