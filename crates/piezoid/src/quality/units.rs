//! Units: strokes and voltages of no piezo actuator.
//!
//! Single layers move by 0.1 nm/V to 1 nm/V, stacks by up to 2 um/V, benders by up to 70 um/V. An amplifier in front of
//! them, or a resonance, makes these up to 100 times larger. Only what is beyond is reported: a stack in a unit that is
//! 1000 times too small moves like a single layer.

use super::{Defect, Finding};
use crate::number::short;
use crate::record::{Record, Units};
use crate::series::ends;

/// The largest stroke [m].
const STROKE: f64 = 0.02;

/// The largest and the smallest stroke over range of the input [m/V].
const LARGEST: f64 = 1e-3;
const SMALLEST: f64 = 1e-11;

/// The largest range of the input [V].
const VOLTAGE: f64 = 5000.0;

/// A finding if a unit cannot be right. Outputs that are not lengths, and inputs that are not volts, are not judged.
pub(super) fn units(record: &Record) -> Option<Finding> {
    let range = |x: &[f64]| {
        let (low, high) = ends(x.iter().copied());
        high - low
    };
    let units = record.units();
    let told = |text| Some(Finding { defect: Defect::Units, samples: Vec::new(), text });
    if Units::factor(&units.u, "m").is_some() && ["V", "mV", "kV"].contains(&&*units.y) {
        return told(format!(
            "the input is in {} and the output in {}: input and output seem to be exchanged; choose the other columns",
            units.u, units.y
        ));
    }
    let volts = match &*units.u {
        "V" => 1.0,
        "mV" => 1e-3,
        "kV" => 1e3,
        _ => return None,
    };
    let (voltage, stroke) = (volts * range(record.u()), range(record.y()));
    let metres = stroke * Units::factor(&units.y, "m")?;
    let gain = metres / voltage;
    let what = if metres > STROKE {
        format!("the output has a range of {} {}, more than any piezo actuator moves", short(stroke), units.y)
    } else if voltage > VOLTAGE {
        format!("the input has a range of {} V, more than any piezo actuator takes", short(voltage))
    } else if !(SMALLEST..=LARGEST).contains(&gain) {
        let than = if gain > LARGEST { "more" } else { "less" };
        format!("the output moves by {} {}/V, {than} than any piezo actuator", short(stroke / voltage), units.y)
    } else {
        return None;
    };
    told(format!("{what}: check the units of the columns, and that they are not swapped"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_strokes_and_voltages_of_no_actuator_are_reported() {
        let told = |input: f64, unit: &str, stroke: f64, of: &str| {
            let record = Record::new(1.0, vec![0.0, input], vec![0.0, stroke]).unwrap();
            let finding = units(&record.with_units(Units { u: unit.into(), y: of.into() }));
            finding.map_or(String::new(), |finding| finding.text)
        };
        let said = |volts: f64, stroke: f64, unit: &str| told(volts, "V", stroke, unit);
        // A stack, a bender, a single layer, a mirror in metres, a resonance, a stack driven through an amplifier.
        for (volts, stroke, unit) in
            [(120.0, 18.0, "um"), (60.0, 4.0, "mm"), (100.0, 30.0, "nm"), (0.6, 3e-5, "m"), (2.0, 600.0, "um")]
        {
            assert_eq!(said(volts, stroke, unit), "");
        }
        assert_eq!((said(3.6, 70.0, "um"), said(100.0, 5e6, "counts")), (String::new(), String::new()));
        assert!(said(120.0, 28.0, "mm").contains("a range of 28.00 mm, more than any piezo actuator moves"));
        assert!(said(120e3, 18.0, "um").contains("a range of 1.200e5 V, more than"));
        assert!(said(0.12, 180.0, "um").contains("moves by 1500 um/V, more than any"));
        assert!(said(100.0, 5e-4, "nm").contains("less than any piezo actuator"));
        assert!(told(18.0, "kV", 18.0, "um").contains("a range of 18000 V") && told(18e3, "mV", 18.0, "um").is_empty());
        assert!(told(18.0, "um", 120.0, "V").contains("the input is in um and the output in V"));
    }
}
