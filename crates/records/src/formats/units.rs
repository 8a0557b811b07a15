//! Units in files: the spelling of each in a record, and the quantity that it measures.
//!
//! A file says `Volt`, `[V]`, `µm` or `Mikrometer`; a record says `V` and `um`. A unit that is not known is kept as it
//! stands.
//!
//! Why: docs/decisions/data-and-records.md, "Records keep the units of their files".

use super::quote::shortened;
use piezoid_numerics::number::ascii_unit;
use std::collections::HashMap;
use std::sync::LazyLock;

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Quantity {
    /// Time; so many seconds.
    Time(f64),
    Voltage,
    /// A length, angle or strain: what an actuator gives.
    Displacement,
    /// Anything else that is known: a current, a temperature, a sample number.
    Other,
}

/// Prefixes of ten, with their names.
const PREFIXES: &[(&str, &str, f64)] = &[
    ("k", "kilo", 1e3),
    ("m", "milli", 1e-3),
    ("u", "micro", 1e-6),
    ("n", "nano", 1e-9),
    ("p", "pico", 1e-12),
    ("", "", 1.0),
];
/// Units that take these prefixes, with their names, in the languages of common instruments.
const BASES: &[(&str, &[&str], Quantity)] = &[
    ("s", &["second", "sekunde", "seconde", "sec", "sek"], Quantity::Time(1.0)),
    ("V", &["volt"], Quantity::Voltage),
    ("m", &["meter", "metre"], Quantity::Displacement),
    ("rad", &["radian", "radiant"], Quantity::Displacement),
    ("A", &["ampere", "amp"], Quantity::Other),
    ("Hz", &["hertz"], Quantity::Other),
];
/// Units without prefixes, with other spellings.
const SINGLE: &[(&str, &[&str], Quantity)] = &[
    ("min", &["minute", "minutes"], Quantity::Time(60.0)),
    ("h", &["hour", "hours"], Quantity::Time(3600.0)),
    ("d", &["day", "days"], Quantity::Time(86_400.0)),
    ("cm", &["centimeter", "centimetre"], Quantity::Displacement),
    ("um", &["micron", "microns"], Quantity::Displacement),
    ("deg", &["degree", "degrees", "\u{b0}"], Quantity::Displacement),
    ("arcsec", &["asec"], Quantity::Displacement),
    ("ppm", &[], Quantity::Displacement),
    ("ustrain", &["ue", "u\u{3b5}", "microstrain"], Quantity::Displacement),
    ("N", &["newton"], Quantity::Other),
    ("degC", &["\u{b0}c", "celsius", "c"], Quantity::Other),
    ("K", &["kelvin"], Quantity::Other),
    ("%", &["percent"], Quantity::Other),
    ("counts", &["count", "cts", "lsb", "digits"], Quantity::Other),
    ("m/s", &[], Quantity::Other),
    ("mm/s", &[], Quantity::Other),
    ("um/s", &[], Quantity::Other),
    ("m/s2", &["m/s^2", "m/s\u{b2}"], Quantity::Other),
    ("dB", &[], Quantity::Other),
    ("samples", &["sample", "sequence", "index"], Quantity::Other),
];

/// Every spelling in lower case, with its unit as it is written here, its quantity, and whether an `M` at its beginning
/// may be mega.
static SPELLINGS: LazyLock<HashMap<String, (String, Quantity, bool)>> = LazyLock::new(|| {
    let mut all = HashMap::new();
    let mut add = |spelling: String, unit: &str, quantity: Quantity, doubtful: bool| {
        all.entry(spelling.to_lowercase()).or_insert((unit.into(), quantity, doubtful));
    };
    for &(unit, names, quantity) in SINGLE {
        [unit].iter().chain(names).for_each(|name| add((*name).into(), unit, quantity, false));
    }
    for &(base, names, quantity) in BASES {
        for &(prefix, prefix_name, factor) in PREFIXES {
            let unit = format!("{prefix}{base}");
            let quantity = if base == "s" { Quantity::Time(factor) } else { quantity };
            let short: &[&str] = if base == "s" { &["sec"] } else { &[] };
            let long = names.iter().map(|name| format!("{prefix_name}{name}"));
            for name in long.chain(short.iter().map(|name| format!("{prefix}{name}"))) {
                ["", "s", "e", "n"].iter().for_each(|end| add(format!("{name}{end}"), &unit, quantity, false));
            }
            // Only the case of a unit without this doubt is corrected.
            add(unit.clone(), &unit, quantity, prefix == "m" && base != "m");
        }
    }
    all
});

/// A unit as it is written here, and its quantity; `None` if it is not known.
pub(super) fn known(text: &str) -> Option<(&'static str, Quantity)> {
    // NetCDF counts from a date: `milliseconds since 2024-01-01`.
    let text = text.split(" since ").next().unwrap_or_default();
    // Origin writes Greek letters so.
    let text = ascii_unit(text.trim()).replace("\\g(m)", "u");
    let (unit, quantity, doubtful) = SPELLINGS.get(&text.to_lowercase())?;
    (!doubtful || text.starts_with('m')).then_some((unit, *quantity))
}

/// True for a unit of what an actuator gives: a length, an angle or a strain.
pub fn is_displacement(unit: &str) -> bool {
    known(unit).is_some_and(|(_, quantity)| quantity == Quantity::Displacement)
}

/// True for a unit of voltage.
pub fn is_voltage(unit: &str) -> bool {
    known(unit).is_some_and(|(_, quantity)| quantity == Quantity::Voltage)
}

/// The seconds of a unit of time.
pub(super) fn seconds(text: &str) -> Option<f64> {
    match known(text)?.1 {
        Quantity::Time(seconds) => Some(seconds),
        _ => None,
    }
}

/// True if this may be a unit: it is known, or made of words of letters (`furlong`, `um/V`, `kg m^2`, `a.u.`).
pub(super) fn is_word(text: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || "./^*- \u{b0}\u{b2}\u{b3}\u{b7}".contains(c);
    known(text).is_some() || text.starts_with(char::is_alphabetic) && text.chars().all(part)
}

/// A unit as it is written here; one that is not known stays as it is.
pub(super) fn written(text: &str) -> String {
    known(text).map_or_else(|| ascii_unit(&shortened(text.trim())), |(unit, _)| unit.into())
}

/// The name of a channel and the unit that stands in it: `Weg [µm]`, `Weg (µm)`, `x/µm`, `Weg in µm`, `Weg, µm`,
/// `weg_um`.
pub(super) fn split(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
        if let Some((head, unit)) = name.strip_suffix(close).and_then(|head| head.rsplit_once(open)) {
            // Brackets may hold a number (`Y[0]`) or a word (`position (measured)`).
            let is_unit = known(unit).is_some() || (open == '[' && !unit.trim().is_empty() && !numbered(unit));
            return if is_unit { (head.trim_end_matches([' ', ',', '_']), Some(unit.trim())) } else { (name, None) };
        }
    }
    if let Some(unit) = name.strip_prefix("in ").filter(|unit| known(unit).is_some()) {
        return ("", Some(unit.trim()));
    }
    for mark in [" in ", "_", " ", "/", ","] {
        if let Some((head, unit)) = name.rsplit_once(mark)
            && let Some((symbol, _)) = known(unit)
        {
            // `Channel A`, `y_min` and `x_c` hold no unit.
            let doubtful =
                ["A", "N", "K", "degC", "h", "d", "min", "samples"].contains(&symbol) || mark == " " && symbol == "m";
            let timed = ["t", "time", "zeit", "temps"].contains(&&*head.to_lowercase());
            if timed || !(doubtful && ["_", " "].contains(&mark)) {
                return (head.trim_end_matches([' ', ',', '_']), Some(unit.trim()));
            }
        }
    }
    (name, None)
}

fn numbered(text: &str) -> bool {
    text.chars().all(|c| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_is_known_however_it_is_spelled() {
        for (spelled, expected) in [
            ("Volts", "V"),
            ("volt", "V"),
            ("v", "V"),
            ("mV", "mV"),
            ("KV", "kV"),
            ("\u{b5}m", "um"),
            ("\u{3bc}m", "um"),
            ("UM", "um"),
            ("MM", "mm"),
            ("Mikrometer", "Mikrometer"),
            ("micrometers", "um"),
            ("Nanometer", "nm"),
            ("microns", "um"),
            ("Sekunden", "s"),
            ("msec", "ms"),
            ("Millisekunden", "ms"),
            ("seconds", "s"),
            ("milliseconds", "ms"),
            ("\u{b0}C", "degC"),
            ("MV", "MV"),
            ("furlong", "furlong"),
        ] {
            assert_eq!(written(spelled), expected, "{spelled}");
        }
        assert_eq!(known("ms"), Some(("ms", Quantity::Time(1e-3))));
        for (unit, expected) in [("s", 1.0), ("ks", 1e3), ("us", 1e-6), ("ns", 1e-9), ("ps", 1e-12), ("min", 60.0)] {
            assert_eq!(seconds(unit), Some(expected), "{unit}");
        }
        assert_eq!((seconds("Mikrosekunden"), seconds("microseconds"), seconds("V")), (None, Some(1e-6), None));
        assert_eq!(known("urad").map(|(_, quantity)| quantity), Some(Quantity::Displacement));
        assert_eq!(known("furlong"), None);
    }

    #[test]
    fn a_unit_measures_one_quantity() {
        for unit in ["m", "um", "deg", "arcsec", "ppm", "ustrain", "urad"] {
            assert_eq!((is_displacement(unit), is_voltage(unit)), (true, false), "{unit}");
        }
        for unit in ["V", "mV", "volts"] {
            assert_eq!((is_displacement(unit), is_voltage(unit)), (false, true), "{unit}");
        }
        for unit in ["s", "A", "um/s", "counts", "furlong", ""] {
            assert_eq!((is_displacement(unit), is_voltage(unit)), (false, false), "{unit}");
        }
    }

    #[test]
    fn a_unit_is_a_word_of_letters() {
        for unit in ["furlong", "%", "counts", "a.u.", "um/V", "m/s^2", "\u{b0}"] {
            assert!(is_word(unit), "{unit}");
        }
        for unit in ["", "5", "-", "12um", "#", "u,m", "\u{7}"] {
            assert!(!is_word(unit), "{unit}");
        }
    }

    #[test]
    fn the_unit_in_a_name_is_found_however_it_is_set_off() {
        for (name, expected) in [
            ("Weg [\u{b5}m]", ("Weg", Some("\u{b5}m"))),
            ("Position (mm)", ("Position", Some("mm"))),
            ("[ s ]", ("", Some("s"))),
            ("U/V", ("U", Some("V"))),
            ("Voltage, V", ("Voltage", Some("V"))),
            ("Weg in um", ("Weg", Some("um"))),
            ("in s", ("", Some("s"))),
            ("sensor_um", ("sensor", Some("um"))),
            ("Model Root/Piezo/u_piezo[V]", ("Model Root/Piezo/u_piezo", Some("V"))),
            ("channel_2", ("channel_2", None)),
            ("Y[0]", ("Y[0]", None)),
            ("Position (measured)", ("Position (measured)", None)),
            ("Position [counts]", ("Position", Some("counts"))),
            ("x_cap", ("x_cap", None)),
            ("time_min", ("time", Some("min"))),
            ("y_min", ("y_min", None)),
            ("Channel A", ("Channel A", None)),
            ("velocity_m/s", ("velocity", Some("m/s"))),
        ] {
            assert_eq!(split(name), expected, "{name}");
        }
    }
}
