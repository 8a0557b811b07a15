//! Two records, or a record and a model, whose scales differ by a large factor: a unit, an amplifier gain or a sensor
//! gain is wrong.

use crate::record::Record;
use libm::log10;
use piezoid_numerics::number::short;
use piezoid_numerics::series::{quantile, scatter};

/// Units, each 1000 times the one before.
const UNIT_LADDERS: [&[&str]; 2] = [&["nm", "um", "mm", "m"], &["uV", "mV", "V", "kV"]];

/// Largest deviation from a power of 1000, as a factor.
const MAX_UNIT_DEVIATION: f64 = 3.0;

/// Factor between the gains of records that no resonance explains.
pub(super) const MAX_GAIN_RATIO: f64 = 100.0;

/// The likely cause why a signal in `unit` is too large by this factor, and the remedy.
pub fn likely_cause(factor: f64, unit: &str) -> String {
    let steps = -(log10(factor.abs()) / 3.0).round();
    let meant = UNIT_LADDERS.iter().find_map(|ladder| {
        let own = ladder.iter().position(|name| *name == unit)?;
        ladder.get(usize::try_from((own as i64).saturating_add(steps as i64)).ok()?)
    });
    match meant {
        Some(meant) if steps != 0.0 && (log10(factor.abs()) + 3.0 * steps).abs() < log10(MAX_UNIT_DEVIATION) => {
            format!("its values seem to be in {meant}, not in {unit}: correct the unit in its header, or state it")
        }
        _ => "check its units, the gain of the amplifier and the scale of the sensor: state them if the file does not"
            .into(),
    }
}

/// Notes on records whose output over input, rms, differs from that of most others by more than any resonance explains.
pub(super) fn scales(records: &[(&str, &Record)]) -> Vec<String> {
    let ratio = |record: &Record| (scatter(record.y()) / scatter(record.u())).sqrt();
    let ratios: Vec<f64> = records.iter().map(|(_, record)| ratio(record)).collect();
    let note = |(k, (name, record)): (usize, &(&str, &Record))| {
        // Of a pair, the second is named.
        if records.len() == 2 && k == 0 {
            return None;
        }
        let others = || ratios.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, ratio)| *ratio);
        let differs = |other: f64| !(1.0 / MAX_GAIN_RATIO..=MAX_GAIN_RATIO).contains(&(ratios[k] / other));
        let odd = 2 * others().filter(|other| differs(*other)).count() > others().count();
        let (usual, units) = (quantile(others().collect(), 0.5), record.units());
        odd.then(|| {
            let (cause, [own, usual]) = (likely_cause(ratios[k] / usual, &units.y), [ratios[k], usual].map(short));
            let both = format!("{own} and {usual} {}/{}", units.y, units.u);
            format!("{name}: it has another gain than other records (y over u, rms: {both}): {cause}")
        })
    };
    records.iter().enumerate().filter_map(note).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_of_a_thousand_is_a_unit_and_others_are_amplifiers_or_sensors() {
        assert!(likely_cause(1.1e-3, "um").starts_with("its values seem to be in mm, not in um"));
        assert!(likely_cause(-980.0, "um").starts_with("its values seem to be in nm, not in um"));
        assert!(likely_cause(2e3, "V").starts_with("its values seem to be in mV, not in V"));
        assert!(likely_cause(1e-6, "nm").starts_with("its values seem to be in mm"));
        for (factor, unit) in [(20.0, "um"), (1e-3, "mrad"), (1e-9, "mm"), (1e3, "nm"), (f64::INFINITY, "um")] {
            assert!(likely_cause(factor, unit).starts_with("check its units"), "{factor} {unit}");
        }
    }

    #[test]
    fn the_record_that_most_others_contradict_is_named() {
        let record = |gain: f64| Record::new(1e-3, vec![0.0, 1.0, -1.0], vec![0.0, gain, -gain]).unwrap();
        let notes_of = |gains: &[f64]| {
            let all: Vec<Record> = gains.iter().map(|gain| record(*gain)).collect();
            let names = ["first", "second", "third"];
            scales(&names.into_iter().zip(&all).collect::<Vec<_>>())
        };
        assert!(notes_of(&[20.0, 0.5, 30.0]).is_empty());
        let notes = notes_of(&[0.02, 20.0, 30.0]);
        assert!(notes.len() == 1 && notes[0].starts_with("first: it has another gain"), "{notes:?}");
        assert!(notes[0].contains("0.02000 and 30.00 um/V") && notes[0].contains("in mm, not in um"), "{notes:?}");
        let notes = notes_of(&[20.0, 20e3]);
        assert!(notes.len() == 1 && notes[0].starts_with("second: ") && notes[0].contains("in nm"), "{notes:?}");
    }
}
