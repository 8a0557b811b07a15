//! Tones in the output that the input does not drive, as pickup of the mains.
//!
//! A free run has a free initial state in each record. A mode without damping would explain a tone by it, whatever the
//! input is, and stand in the model as a resonance that the actuator does not have. A tone is therefore removed from
//! the records, by least squares on the error of the best block whose modes are damped, and the order is selected
//! again. A mode that is still there is driven, and stays.

use super::free_run::FreeRun;
use super::select::{Candidate, OrderSearch, OrderSelection, select};
use super::{Arx, Pole};
use libm::fabs;
use nalgebra::{Matrix2, Vector2};
use piezoid_numerics::complex::polar;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_records::record::Record;
use std::f64::consts::TAU;

/// Pickup has harmonics: so many multiples of a tone are removed with it.
const MULTIPLES: u32 = 8;

/// After so many selections, the tones that are left stay.
const MAX_SELECTIONS: usize = 6;

/// Chooses order and delay as [`select`], in the records without the tones that would be modes of less damping than
/// `min_damping`.
///
/// # Errors
/// The errors of [`select`].
pub fn select_beside_tones(
    records: &[Record],
    settings: &OrderSearch,
    min_damping: f64,
) -> Result<OrderSelection, Error> {
    let width = 1.0 / records.iter().map(Record::duration).fold(f64::MIN_POSITIVE, f64::max);
    let mut found = select(records, settings)?;
    let (mut cleaned, mut removed) = (records.to_vec(), Vec::<f64>::new());
    for _ in 1..MAX_SELECTIONS {
        let tones: Vec<f64> = undamped(&found.fit.arx, min_damping).map(|pole| pole.hz).collect();
        let damped = found.candidates.iter().filter(|c| undamped(&c.arx, min_damping).next().is_none());
        let best = damped.min_by(|p, q| p.held_out.total_cmp(&q.held_out));
        let Some(best) = best.filter(|_| !tones.is_empty()) else { break };
        let without = cleaned.iter().map(|record| without(record, best, &tones)).collect::<Result<Vec<_>, _>>()?;
        let again = select(&without, settings)?;
        if undamped(&again.fit.arx, min_damping).any(|pole| tones.iter().any(|hz| fabs(hz - pole.hz) < width)) {
            break;
        }
        (found, cleaned) = (again, without);
        removed.extend(tones);
    }
    if !removed.is_empty() {
        removed.sort_by(f64::total_cmp);
        let listed: Vec<String> = removed.iter().map(|hz| short(*hz)).collect();
        found.reason += &format!("; without tones of {} Hz, and multiples, in the output", listed.join(", "));
    }
    Ok(found)
}

/// The modes with less damping.
fn undamped(arx: &Arx, min_damping: f64) -> impl Iterator<Item = Pole> {
    arx.poles().into_iter().filter(move |pole| pole.z.im > 0.0 && pole.damping < min_damping)
}

/// The record without the tones of these frequencies [Hz], and without their multiples, in the error of a block.
fn without(record: &Record, block: &Candidate, tones: &[f64]) -> Result<Record, Error> {
    let delay = block.orders.delay;
    let theta = [block.arx.a(), &block.arx.b()[delay..]].concat();
    let mut y = record.y().to_vec();
    let mut e = FreeRun::new(record, block.orders, &theta).e;
    let multiples = tones.iter().flat_map(|hz| (1..=MULTIPLES).map(move |k| f64::from(k) * hz));
    for hz in multiples.filter(|hz| *hz < 0.5 / record.ts()) {
        let wave = |t: usize| {
            let wave = polar(1.0, TAU * hz * record.ts() * t as f64);
            Vector2::new(wave.re, wave.im)
        };
        let (mut products, mut sums) = (Matrix2::zeros(), Vector2::zeros());
        for (t, e) in e.iter().enumerate() {
            let wave = wave(t);
            products += wave * wave.transpose();
            sums += wave * *e;
        }
        let Some(inverse) = products.try_inverse() else { continue };
        let sizes = inverse * sums;
        for t in 0..y.len() {
            let tone = sizes.dot(&wave(t));
            y[t] -= tone;
            e[t] -= tone;
        }
    }
    record.with_samples(record.ts(), record.u().to_vec(), y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::noise;

    const TS: f64 = 1e-3;
    const MIN_DAMPING: f64 = 2e-3;

    /// The response of a pair of poles to a PRBS, with noise and what is added at each time [s].
    fn record(hz: f64, damping: f64, added: impl Fn(f64) -> f64) -> Record {
        let z = polar((-TAU * hz * damping * TS).exp(), TAU * hz * TS);
        let truth = Arx::new(TS, vec![2.0 * z.re, -z.norm_sqr()], vec![0.0, 0.02]).unwrap();
        let u = Prbs::default().samples(TS, 4094).unwrap();
        let noise = noise(4, u.len());
        let y = truth.simulate(&u).into_iter().enumerate();
        let y = y.map(|(t, y)| y + 0.01 * noise[t] + added(t as f64 * TS)).collect();
        Record::new(TS, u, y).unwrap()
    }

    const SETTINGS: OrderSearch = OrderSearch { order: 8, delay: 1, parallel: false };

    fn found(records: &[Record]) -> OrderSelection {
        select_beside_tones(records, &SETTINGS, MIN_DAMPING).unwrap()
    }

    #[test]
    fn pickup_of_the_mains_is_no_mode() {
        let pickup = |t: f64| 0.2 * (TAU * 49.98 * t + 1.0).sin() + 0.1 * (TAU * 149.94 * t).sin();
        let with = [record(180.0, 0.02, pickup)];
        let alone = select(&with, &SETTINGS).unwrap();
        assert!(undamped(&alone.fit.arx, MIN_DAMPING).next().is_some(), "{}", alone.reason);
        let found = found(&with);
        let poles = found.fit.arx.poles();
        assert_eq!(poles.len(), 1, "{poles:?}: {}", found.reason);
        assert!((poles[0].hz - 180.0).abs() < 0.1 && (poles[0].damping - 0.02).abs() < 5e-4, "{poles:?}");
        assert!(found.reason.contains("without tones of 49.98 Hz, and multiples"), "{}", found.reason);
    }

    #[test]
    fn a_driven_mode_stays_however_small_its_damping() {
        let found = found(&[record(50.0, 5e-4, |_| 0.0)]);
        let poles = found.fit.arx.poles();
        assert!((poles[0].hz - 50.0).abs() < 0.01 && (poles[0].damping - 5e-4).abs() < 1e-4, "{poles:?}");
        assert!(!found.reason.contains("tones"), "{}", found.reason);
    }
}
