//! The first candidate: a linear block and initial conditions, with a coarse hysteresis.
//!
//! Small-signal records determine order and delay directly. With large-signal records alone, a coarse Preisach grid
//! represents the hysteresis, its z replaces the input, and each structure, from a pure gain on, is refined together
//! with it. Records with few frequencies determine few coefficients: a block of order n needs n + 1 frequencies. The
//! simplest structure is selected that predicts held-out data as well as the best.
//!
//! Why: docs/decisions/structure-and-operator-selection.md, "A grown block has limits, a specified order has none".

use super::candidate::SelectedStructure;
use super::fit::{
    Estimate, FreeParameters, Hidden, MIN_MODE_DAMPING, StepCallback, creep_pole, is_lag, refine, slowest_observable,
    slowest_pole, with_slow_lags_limited, without_factor,
};
use super::initial_conditions::fit_with_initial_conditions;
use super::structure::{Selected, Structure, rescaled, select};
use super::{Candidate, JointOptions, LINEAR_BLOCK, POLICY, Search};
use crate::large_signal::{affine, lines, proportional, require_excitation};
use crate::side_by_side::side_by_side;
use piezoid_models::creep::Lag;
use piezoid_models::driver::DriverModel;
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::{BasisDesign, Operator, Proportional};
use piezoid_models::linear::{
    Arx, Estimator, OrderSearch, Orders, OutputError, Refinement, Root, refine as refine_alone, select_beside_tones,
};
use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::swarm;
use piezoid_numerics::progress::Stage;
use piezoid_numerics::series::explained;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use piezoid_records::waveform::dominant_frequency;
use std::cmp::Reverse;
use std::sync::Arc;

/// The operator that represents the hysteresis until the operators are compared.
const COARSE: &str = "preisach";

/// The first candidate.
///
/// # Errors
/// Returns an error if the records do not excite the linear block; [`Error::Cancelled`].
pub(super) fn first_candidate(search: &mut Search) -> Result<Candidate, Error> {
    if search.records.is_large_signal_alone() { from_large_signal(search) } else { from_small_signal(search) }
}

/// An estimate with a coarse hysteresis and this linear block.
fn coarse(linear: Arx, settings: &JointOptions, design: &BasisDesign, lags: &[Lag]) -> Result<Estimate, Error> {
    let design = BasisDesign { elements: Some(POLICY.coarse_rows), ..design.clone() };
    let basis = (Operator::find(COARSE)?.basis)(&design)?;
    Ok(Estimate::new(settings.driver, basis, lags.to_vec(), linear))
}

/// The linear block from small-signal records. Its gain has the sign of the large-signal records: hysteresis with jumps
/// at reversals may invert small signals.
fn from_small_signal(search: &mut Search) -> Result<Candidate, Error> {
    let (linear, reason) = select_on_small_signal(search)?;
    let Search { settings, records, runs, bridged, lags, design, reporter, .. } = search;
    let (small, large_signal) = (&bridged[..records.small.len()], &bridged[records.beside().len()..]);
    let linear = with_slow_lags_limited(linear, slowest_observable(small.iter().chain(large_signal)))?;
    let inverted = proportional(&linear, 0.0, large_signal)?.0 < 0.0;
    let linear = if inverted { rescaled(&linear, -linear.dc_gain())? } else { linear };
    let start = || coarse(linear.clone(), settings, design, lags);
    let watch = &mut reporter.stage(LINEAR_BLOCK, 0);
    let fitted = fit_with_initial_conditions(&start, runs, design.range, watch)?;
    let structure = SelectedStructure { reason, simpler: Vec::new() };
    Ok(Candidate { structure, operator: Operator::find(COARSE)?, fitted })
}

/// The linear block of the small-signal records, without creep, and the reason for its order.
fn select_on_small_signal(search: &mut Search) -> Result<(Arx, String), Error> {
    let Search { settings, records, bridged, lags, .. } = &*search;
    let (small, slowest) = (&bridged[..records.small.len()], slowest_pole(lags));
    require_excitation(small, 1)?;
    let with_driver: Vec<Record> =
        small.iter().map(|record| behind_driver(record, settings)).collect::<Result<_, _>>()?;
    let max_order = lines(small).len().saturating_sub(1).clamp(1, settings.effort.breadth().max_order);
    if let Some(n) = settings.order {
        require_excitation(small, n)?;
        return of_order(&with_driver, n);
    }
    let limits = OrderSearch { order: max_order, delay: POLICY.max_delay, parallel: true };
    let creeps = |arx: &Arx| creep_pole(arx, slowest).is_some();
    let select_order = |records: &[Record]| select_beside_tones(records, &limits, MIN_MODE_DAMPING);
    let found = select_order(&with_driver)?;
    if !creeps(&found.fit.arx) {
        return Ok((found.fit.arx, found.reason));
    }
    // A slow lag of the linear block is creep, which has its own block.
    let behind = behind_creep(search, without_creep(&found.fit.arx, slowest)?);
    let behind = behind.and_then(|records| Ok((select_order(&records)?, records)));
    let (found, records) = match behind {
        Ok((found, _)) if !creeps(&found.fit.arx) => {
            return Ok((found.fit.arx, format!("{}, behind creep", found.reason)));
        }
        Ok(behind) => behind,
        Err(cancelled @ Error::Cancelled { .. }) => return Err(cancelled),
        Err(_) => (found, with_driver),
    };
    let most = POLICY.block_without_creep_ratio * found.candidates[found.chosen].held_out;
    let near = found.candidates.iter().filter(|c| !creeps(&c.arx) && c.held_out <= most);
    let start = match near.min_by_key(|c| (c.orders.na, Reverse(c.orders.delay))) {
        Some(near) => near.arx.clone(),
        None => without_creep(&found.fit.arx, slowest)?,
    };
    let fit = refine_alone(&records, &start, &Refinement::default(), &mut Stage::ignore)?;
    let (n, delay) = (start.a().len(), start.delay());
    let reason =
        format!("order {n} with delay {delay}, because the better block has a lag as slow as creep ({})", found.reason);
    Ok((Some(fit.arx).filter(|arx| !creeps(arx)).unwrap_or(start), reason))
}

/// The small-signal records with their input behind creep, whose gains are fitted before this linear block.
fn behind_creep(search: &mut Search, linear: Arx) -> Result<Vec<Record>, Error> {
    let Search { settings, whole, lags, design, reporter, .. } = search;
    let basis = (Operator::find("proportional")?.basis)(design)?;
    let start = Estimate::new(settings.driver, basis, lags.clone(), linear);
    let mut runs: Vec<_> = whole.iter().filter(|run| !run.large_signal).cloned().collect();
    let fit = refine(start, &mut runs, FreeParameters::Creep, &mut reporter.stage(LINEAR_BLOCK, 0))?;
    Ok(Hidden::crept(&fit, &runs)?.into_iter().map(|z| z.record).collect())
}

/// The block without its lags below the frequency `slowest` [Hz], and without the zeros next to them, with the same
/// response at high frequencies.
fn without_creep(arx: &Arx, slowest: f64) -> Result<Arx, Error> {
    let (mut a, mut b, mut zeros) = (arx.denominator(), arx.b().to_vec(), arx.zeros());
    for pole in arx.poles().into_iter().filter(|pole| is_lag(pole) && pole.hz < slowest) {
        a = without_factor(&a, pole.z.re);
        let distance = |zero: &Root| (zero.re - pole.z.re).abs();
        let real = (0..zeros.len()).filter(|&k| zeros[k].im == 0.0);
        if let Some(nearest) = real.min_by(|&j, &k| distance(&zeros[j]).total_cmp(&distance(&zeros[k]))) {
            b = without_factor(&b, zeros.swap_remove(nearest).re);
        }
    }
    Arx::new(arx.ts(), a[1..].iter().map(|a| -a).collect(), b)
}

/// The block of order `n`, with the best delay.
fn of_order(records: &[Record], n: usize) -> Result<(Arx, String), Error> {
    let of = |delay| {
        OutputError::fit(records, Orders { delay, ..Orders::of(n) }, &Refinement::default(), &mut Stage::ignore)
    };
    let tried: Vec<_> = (0..=POLICY.max_delay).map(of).collect::<Result<_, _>>()?;
    let least = tried.iter().map(|fit| fit.minimum.cost).fold(f64::INFINITY, f64::min);
    // The longest delay at the same cost.
    let chosen = tried.into_iter().rfind(|fit| fit.minimum.cost <= POLICY.longer_delay_ratio * least);
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
    let alone = Model::from_blocks(settings.driver, unit, Arx::gain(ts, 1.0)?, 0.0)?;
    let u = alone.resume(&mut alone.settled(record.u()[0]), record.u());
    Ok(Record::new(ts, u, record.y().to_vec())?.with_units(record.units().clone()))
}

/// The simplest structure of the linear block that large-signal records alone show, and that is as good as the best.
fn from_large_signal(search: &mut Search) -> Result<Candidate, Error> {
    let Search { settings, runs, bridged, lags, design, structures, reporter, .. } = search;
    let large_signal = &bridged[..];
    let ts = large_signal[0].ts();
    let start = |linear: Arx| coarse(linear, settings, design, lags);
    let (gain, first) = start_gain(large_signal)?;
    let delayed_gain = |d: usize, next: f64| {
        let b = [vec![0.0; d], vec![(1.0 - next) * gain], vec![next * gain; usize::from(next > 0.0)]].concat();
        Arx::new(ts, Vec::new(), b)
    };
    let plain = || start(delayed_gain(first, 0.0)?);
    let plain = fit_with_initial_conditions(&plain, runs, design.range, &mut reporter.stage(LINEAR_BLOCK, 0))?;
    let operator = Operator::find(COARSE)?;
    let candidate = |selected: Selected| {
        let structure = SelectedStructure { reason: selected.reason, simpler: selected.simpler };
        Candidate { structure, operator, fitted: selected.fitted }
    };
    reporter.keep(candidate(select(vec![Structure::new(String::new(), plain.clone())], None)), runs)?;
    let watch = &mut reporter.stage(LINEAR_BLOCK, 0);
    let hidden: Vec<Record> = Hidden::crept(&plain, runs)?.into_iter().map(|z| z.record).collect();
    let best_delay = delay(&hidden);
    let mut tried = vec![Structure::new(String::new(), plain)];
    if settings.order.unwrap_or(0) == 0 {
        let from = best_delay.saturating_sub(1);
        let whole = (String::new(), delayed_gain(best_delay, 0.0)?, FreeParameters::Creep);
        let between = ("a delay between two samples".to_string(), delayed_gain(from, 0.5)?, FreeParameters::All);
        let starts = (best_delay > first).then_some(whole).into_iter().chain([between]).collect();
        let fit = |(name, linear, free): (String, Arx, FreeParameters), watch: StepCallback| -> Result<_, Error> {
            Ok((name, refine(start(linear)?, &mut runs.to_vec(), free, watch)?))
        };
        for found in side_by_side(starts, fit, |_, _| watch(0))? {
            let (name, fit) = found?;
            // Of the delay between two samples: a share outside 0 to 1 is not a delay.
            if fit.estimate.linear.b()[from..].iter().all(|b| b * gain >= 0.0) {
                tried.push(Structure::new(name, fit));
            }
        }
    }
    // The best of these is the last.
    let best = tried.iter().enumerate().min_by(|p, q| Structure::by_error(&p.1, &q.1)).map_or(0, |(k, _)| k);
    tried.truncate(best + 1);
    let basis = |ts: f64| (operator.basis)(&BasisDesign { ts, elements: Some(POLICY.coarse_rows), ..design.clone() });
    structures.extend(&mut tried, &basis, runs, watch)?;
    Ok(candidate(select(tried, settings.order)))
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
    let delayed = (1..=POLICY.max_delay.min(slowest.len() / 4))
        .map(|d| Ok((lagged(d)?, d)))
        .collect::<Result<Vec<_>, Error>>()?;
    let strongest = delayed.into_iter().max_by(|p, q| p.0.abs().total_cmp(&q.0.abs()));
    match strongest.filter(|(gain, _)| gain.abs() > POLICY.delayed_gain_ratio * direct.abs()) {
        Some(delayed) => Ok(delayed),
        None => Ok((affine(large_signal)?.0.copysign(direct), 0)),
    }
}

/// The delay [samples] with the smallest residual of a gain, within limits.
fn delay(hidden: &[Record]) -> usize {
    let longest = hidden.iter().map(|r| r.len() / POLICY.hidden_delays_in_record).min();
    let longest = longest.unwrap_or(0).min(POLICY.max_hidden_delay);
    let residual = |d: usize| -> f64 {
        let of = |r: &Record| 1.0 - explained(&r.u()[..r.len() - d], &r.y()[d..]);
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

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::assert_close;

    const TS: f64 = 5e-4;

    fn record(u: &[f64], y: Vec<f64>) -> Record {
        Record::new(TS, u.to_vec(), y).unwrap()
    }

    /// An input that comes `d` samples late, with a gain of 4.
    fn delayed(u: &[f64], d: usize) -> Record {
        record(u, (0..u.len()).map(|t| 4.0 * u[t.saturating_sub(d)]).collect())
    }

    fn sine(hz: f64) -> Vec<f64> {
        (0..2000).map(|t| (std::f64::consts::TAU * hz * TS * f64::from(t)).sin()).collect()
    }

    #[test]
    fn a_lag_as_slow_as_creep_is_removed_with_the_zero_next_to_it() {
        // Poles 0.9999 (0.03 Hz) and 0.5, zeros 0.9998 and 0.2.
        let arx = Arx::new(TS, vec![1.4999, -0.49995], vec![2.0, -2.3996, 0.39992]).unwrap();
        let left = without_creep(&arx, 1.0).unwrap();
        assert_close(left.a(), &[0.5], 1e-8, 0.0);
        assert_close(left.b(), &[2.0, -0.4], 1e-8, 0.0);
        let all = without_creep(&arx, 0.01).unwrap();
        assert_close(&[all.a(), all.b()].concat(), &[arx.a(), arx.b()].concat(), 0.0, 0.0);
    }

    #[test]
    fn a_driver_smooths_the_input_from_its_settled_state() {
        let settings =
            |lag| JointOptions { driver: Some(DriverModel::new(lag, None).unwrap()), ..JointOptions::default() };
        let u: Vec<f64> = (0..100).map(|t| if t < 50 { 3.0 } else { 5.0 }).collect();
        let step = record(&u, vec![1.0; 100]);
        assert_eq!(behind_driver(&step, &JointOptions::default()).unwrap(), step);
        let behind = behind_driver(&step, &settings(4.0 * TS)).unwrap();
        assert_eq!((behind.y(), behind.ts()), (step.y(), TS));
        assert_close(&behind.u()[..50], &[3.0; 50], 1e-12, 0.0);
        // A lag of four samples: 1 - e^-k/4 after k of them.
        let rises: Vec<f64> = (50..100).map(|t| 5.0 - 2.0 * (-f64::from(t - 50) / 4.0).exp()).collect();
        assert_close(&behind.u()[50..], &rises, 0.0, 0.35);
        assert!(behind.u()[50..].windows(2).all(|pair| pair[1] >= pair[0]));
    }

    #[test]
    fn the_first_gain_is_at_the_delay_at_which_the_output_correlates_with_the_input() {
        let prbs = Prbs { order: 11, ..Prbs::default() }.samples(TS, 2000).unwrap();
        for d in [0, 1, 2, 3] {
            let (gain, delay) = start_gain(&[delayed(&prbs, d)]).unwrap();
            assert_eq!(delay, d);
            assert_close(&[gain], &[4.0], 0.01, 0.0);
        }
        // Without a clear delay: the gain over all records, with the sign of the slowest.
        let (slow, fast) = (sine(5.0), sine(200.0));
        let resonant = record(&fast, fast.iter().map(|u| -9.0 * u).collect());
        let (gain, delay) = start_gain(&[resonant, delayed(&slow, 0)]).unwrap();
        assert_eq!(delay, 0);
        assert_close(&[gain], &[2.5], 1e-3, 0.0);
    }

    #[test]
    fn a_long_delay_of_a_smooth_input_is_found_up_to_a_tenth_of_the_record() {
        let u = sine(6.0);
        for d in [0, 1, 7, 60] {
            assert_eq!(delay(&[delayed(&u, d), delayed(&u, d)]), d);
        }
        assert_eq!(delay(&[delayed(&u[..400], 60)]), 400 / POLICY.hidden_delays_in_record);
        assert_eq!(delay(&[]), 0);
    }
}
