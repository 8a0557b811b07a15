//! Records of one set: the same sign and nearly the same gain, else a channel was changed between them, or a record is
//! of another actuator.
//!
//! The gain of a record is the slope of y over u. It is that of the means over periods of the drive if they vary,
//! otherwise that of all samples. It counts if y is nearly proportional to u. A resonance changes gain and sign; for
//! this reason records are only compared if their rates are similar. Records that excite a resonance, such as PRBS,
//! have no gain here.

use super::scale::{MAX_GAIN_RATIO, scales};
use crate::record::Record;
use crate::waveform::dominant_frequency;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::series::{mean, quantile, scatter};

/// A gain counts if the correlation of y with u is larger.
const MIN_CORRELATION: f64 = 0.95;

/// Means over periods count if their rms is this share of that of the input, over this number of periods.
const MIN_SLOW_RMS_SHARE: f64 = 0.05;
const MIN_PERIODS: usize = 8;

/// Ratio of rates up to which an opposite sign is certain.
const MAX_SURE_RATE_RATIO: f64 = 2.0;

/// Ratio of rates up to which records are compared at all. A resonance between them that turns the sign also changes
/// the gain, by more than `MAX_OPPOSITE_GAIN_RATIO`, unless it is at 0.6 to 0.8 times the faster rate.
const MAX_RATE_RATIO: f64 = 10.0;
const MAX_OPPOSITE_GAIN_RATIO: f64 = 1.5;

/// Hysteresis and frequency change the gain by less: from small signals to the full range by up to 2.5 times.
const MIN_OTHER_GAIN_RATIO: f64 = 5.0;

/// The static gain of a record.
struct Gain {
    /// Slope [output unit / input unit].
    slope: f64,
    /// Rate of the signals that give it [1/s].
    rate: f64,
}

/// Compares the named records of a set; adds what is doubtful to `notes`.
///
/// # Errors
/// [`Error::Unidentifiable`] if a record certainly has the opposite sign.
pub fn compare(records: &[(&str, &Record)], notes: &mut Vec<String>) -> Result<(), Error> {
    let gains: Vec<Option<Gain>> = records.iter().map(|(_, record)| gain(record)).collect();
    for (k, (name, record)) in records.iter().enumerate() {
        let Some(gain) = &gains[k] else { continue };
        let others = |factor: f64| -> Vec<f64> {
            let others = gains.iter().enumerate().filter(|(other, _)| *other != k).filter_map(|(_, g)| g.as_ref());
            others.filter(|g| (gain.rate / g.rate).max(g.rate / gain.rate) <= factor).map(|g| g.slope).collect()
        };
        // Most records of similar rate differ, and most of all: of a pair, the one that others contradict is named.
        let odd = |factor: f64, differs: &dyn Fn(f64) -> bool| {
            let most = |slopes: Vec<f64>| {
                2 * slopes.iter().filter(|slope| differs(gain.slope / **slope)).count() > slopes.len()
            };
            most(others(factor)) && most(others(f64::INFINITY))
        };
        let both = |factor: f64| {
            let (usual, units) = (quantile(others(factor), 0.5), record.units());
            format!("other records (y over u: {} and {} {}/{})", short(gain.slope), short(usual), units.y, units.u)
        };
        let remedy = "invert its input or its output, or leave it out";
        if odd(MAX_SURE_RATE_RATIO, &|ratio| ratio < 0.0) {
            let because = format!("{name}: it has the opposite sign of {}: {remedy}", both(MAX_SURE_RATE_RATIO));
            return Err(Error::Unidentifiable { what: "a model".into(), because });
        }
        if odd(MAX_RATE_RATIO, &|ratio| (-MAX_OPPOSITE_GAIN_RATIO..=-1.0 / MAX_OPPOSITE_GAIN_RATIO).contains(&ratio)) {
            let remedy = format!("unless it is driven above a resonance, {remedy}");
            notes.push(format!("{name}: it has the opposite sign of {}: {remedy}", both(MAX_RATE_RATIO)));
        } else if odd(MAX_RATE_RATIO, &|ratio| {
            (MIN_OTHER_GAIN_RATIO..MAX_GAIN_RATIO).contains(&ratio)
                || (1.0 / MAX_GAIN_RATIO..1.0 / MIN_OTHER_GAIN_RATIO).contains(&ratio)
        }) {
            let remedy = "check units and amplifier, and that it is of the same actuator";
            notes.push(format!("{name}: it has another gain than {}: {remedy}", both(MAX_RATE_RATIO)));
        }
    }
    notes.extend(scales(records));
    Ok(())
}

/// `None` if y is not proportional to u.
fn gain(record: &Record) -> Option<Gain> {
    let (u, y, ts) = (record.u(), record.y(), record.ts());
    let period = (1.0 / (dominant_frequency(u, ts)? * ts)).round().max(1.0) as usize;
    let means = |x: &[f64]| x.chunks_exact(period).map(mean).collect::<Vec<f64>>();
    let (slow_u, slow_y) = (means(u), means(y));
    let rms = |x: &[f64]| (scatter(x) / x.len() as f64).sqrt();
    let varies = slow_u.len() >= MIN_PERIODS && rms(&slow_u) > MIN_SLOW_RMS_SHARE * rms(u);
    let slow = varies.then(|| slope(&slow_u, &slow_y, period as f64 * ts)).flatten();
    slow.or_else(|| slope(u, y, ts))
}

/// The gain by least squares; `None` if the two are not nearly proportional.
fn slope(u: &[f64], y: &[f64], ts: f64) -> Option<Gain> {
    let (mu, my) = (mean(u), mean(y));
    let product: f64 = u.iter().zip(y).map(|(u, y)| (u - mu) * (y - my)).sum();
    let steps: f64 = u.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
    let (power, correlation) = (scatter(u), product / (scatter(u) * scatter(y)).sqrt());
    (correlation.abs() > MIN_CORRELATION).then(|| Gain { slope: product / power, rate: (steps / power).sqrt() / ts })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine through a gain; its amplitude rises if `rising`.
    fn record(hz: f64, gain: f64, rising: bool) -> Record {
        let sine = |t: usize| (std::f64::consts::TAU * hz * t as f64 * 1e-3).sin();
        let u: Vec<f64> = (0..4000).map(|t| if rising { (1.0 + sine(t)) * t as f64 } else { sine(t) }).collect();
        let y = u.iter().map(|u| gain * u).collect();
        Record::new(1e-3, u, y).unwrap()
    }

    /// The notes, or the error.
    fn notes_of(records: &[Record]) -> Result<Vec<String>, String> {
        let names: Vec<String> = (1..=records.len()).map(|k| format!("record {k}")).collect();
        let mut notes = Vec::new();
        let named: Vec<(&str, &Record)> = names.iter().map(|name| &**name).zip(records).collect();
        compare(&named, &mut notes).map_err(|error| error.to_string()).map(|()| notes)
    }

    #[test]
    fn an_opposite_sign_is_refused_at_like_rates_and_doubtful_at_others() {
        let because =
            notes_of(&[record(5.0, 0.3, false), record(20.0, 0.3, false), record(7.0, -0.3, false)]).unwrap_err();
        assert!(because.contains("record 3: "), "{because}");
        let because =
            notes_of(&[record(5.0, 0.3, false), record(7.0, -0.3, false), record(6.0, 0.31, false)]).unwrap_err();
        assert!(because.contains("record 2: it has the opposite sign of other records (y over u: -0.3"), "{because}");
        let slow = [record(5.0, 0.3, true), record(9.0, -0.3, true)];
        assert!(notes_of(&slow).is_err());
        let notes = notes_of(&[record(5.0, 0.3, false), record(6.0, 0.3, false), record(40.0, -0.3, false)]).unwrap();
        assert!(notes.len() == 1 && notes[0].contains("record 3: it has the opposite sign"), "{notes:?}");
        assert!(notes[0].contains("unless it is driven above a resonance"), "{notes:?}");
        // Above a resonance both change; far above, nothing is compared.
        assert_eq!(notes_of(&[record(5.0, 0.3, false), record(40.0, -0.1, false)]), Ok(vec![]));
        assert_eq!(notes_of(&[record(5.0, 0.3, false), record(90.0, -0.3, false)]), Ok(vec![]));
    }

    #[test]
    fn another_gain_is_noted_and_that_of_small_signals_is_not() {
        assert_eq!(notes_of(&[record(5.0, 0.3, false), record(6.0, 0.14, false), record(7.0, 0.3, false)]), Ok(vec![]));
        let notes = notes_of(&[record(5.0, 0.3, false), record(6.0, 3e-2, false), record(7.0, 0.3, false)]).unwrap();
        assert!(notes.len() == 1 && notes[0].contains("record 2: it has another gain"), "{notes:?}");
        assert!(notes[0].contains("(y over u: 0.03000 and 0.3000 um/V): check units"), "{notes:?}");
        let notes = notes_of(&[record(5.0, 0.3, false), record(6.0, 3e-4, false), record(7.0, 0.3, false)]).unwrap();
        assert!(notes.len() == 1 && notes[0].contains("(y over u, rms: 3.000e-4 and 0.3000 um/V)"), "{notes:?}");
    }
}
