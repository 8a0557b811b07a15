//! Units: strokes and voltages that no piezo actuator has.
//!
//! Single layers move by 0.1 nm/V to 1 nm/V, stacks by up to 2 um/V, benders by up to 70 um/V. An amplifier in front of
//! them, or a resonance, makes these up to 100 times larger. Only what is beyond is reported: a stack in a unit that is
//! 1000 times too small moves like a single layer.

use super::Detection;
use super::detector::{Consequence, Detector};
use crate::record::{Record, Units};
use piezoid_numerics::number::short;
use piezoid_numerics::series::range;

/// The largest stroke [m].
const MAX_STROKE_M: f64 = 0.02;

/// The largest and the smallest stroke over range of the input [m/V].
const MAX_GAIN_M_PER_V: f64 = 1e-3;
const MIN_GAIN_M_PER_V: f64 = 1e-11;

/// The largest range of the input [V].
const MAX_INPUT_RANGE_V: f64 = 5000.0;

pub(super) static UNITS: Detector = Detector {
    name: "units",
    criterion: "stroke, voltage or stroke per volt of no piezo actuator",
    consequence: Consequence::Reported,
    loop_remedy: None,
    run: |context| units(context.record()),
};

/// Outputs that are not lengths, and inputs that are not volts, are not judged.
fn units(record: &Record) -> Option<Detection> {
    let units = record.units();
    if Units::factor(&units.u, "m").is_some() && ["V", "mV", "kV"].contains(&&*units.y) {
        let both = format!("the input is in {} and the output in {}", units.u, units.y);
        return Some(format!("{both}: input and output seem to be exchanged; choose the other columns").into());
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
    let what = if metres > MAX_STROKE_M {
        format!("the output has a range of {} {}, more than any piezo actuator moves", short(stroke), units.y)
    } else if voltage > MAX_INPUT_RANGE_V {
        format!("the input has a range of {} V, more than any piezo actuator takes", short(voltage))
    } else if !(MIN_GAIN_M_PER_V..=MAX_GAIN_M_PER_V).contains(&gain) {
        let than = if gain > MAX_GAIN_M_PER_V { "more" } else { "less" };
        format!("the output moves by {} {}/V, {than} than any piezo actuator", short(stroke / voltage), units.y)
    } else {
        return None;
    };
    Some(format!("{what}: check the units of the columns, and that they are not swapped").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_strokes_and_voltages_of_no_actuator_are_reported() {
        let text = |input: f64, unit: &str, stroke: f64, of: &str| {
            let record = Record::new(1.0, vec![0.0, input], vec![0.0, stroke]).unwrap();
            let found = units(&record.with_units(Units { u: unit.into(), y: of.into() }));
            found.map_or(String::new(), |found| found.text)
        };
        let in_volts = |volts: f64, stroke: f64, unit: &str| text(volts, "V", stroke, unit);
        // A stack, a bender, a single layer, a mirror in metres, a resonance, a stack driven through an amplifier.
        for (volts, stroke, unit) in
            [(120.0, 18.0, "um"), (60.0, 4.0, "mm"), (100.0, 30.0, "nm"), (0.6, 3e-5, "m"), (2.0, 600.0, "um")]
        {
            assert_eq!(in_volts(volts, stroke, unit), "");
        }
        assert_eq!((in_volts(3.6, 70.0, "um"), in_volts(100.0, 5e6, "counts")), (String::new(), String::new()));
        assert!(in_volts(120.0, 28.0, "mm").contains("a range of 28.00 mm, more than any piezo actuator moves"));
        assert!(in_volts(120e3, 18.0, "um").contains("a range of 1.200e5 V, more than"));
        assert!(in_volts(0.12, 180.0, "um").contains("moves by 1500 um/V, more than any"));
        assert!(in_volts(100.0, 5e-4, "nm").contains("less than any piezo actuator"));
        assert!(text(18.0, "kV", 18.0, "um").contains("a range of 18000 V") && text(18e3, "mV", 18.0, "um").is_empty());
        assert!(text(18.0, "um", 120.0, "V").contains("the input is in um and the output in V"));
    }
}
