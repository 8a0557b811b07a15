//! Drivers by name: the limits of some amplifiers, with the sources of the numbers.
//!
//! The current limit of an amplifier limits the slew only together with a load. If the row has no capacitance, set that
//! of the actuator: `Limits { capacitance: Some(8.2e-6), ..driver.limits }`. The numbers are peak values from data
//! sheets; continuous operation may allow less.

use super::Limits;
use super::limits::GROUP;
use crate::error::{Error, row};
use crate::options::{OptionKind, OptionRow, options};
use serde_json::Value;

/// A driver by name.
#[derive(Debug, Clone, Copy)]
pub struct Amplifier {
    /// Name in every front end.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// Source of the numbers.
    pub reference: &'static str,
    /// Limits of its output.
    pub limits: Limits,
}

const NONE: Limits = Limits { low: None, high: None, slew: None, current: None, capacitance: None };

/// All drivers.
pub static DRIVERS: &[Amplifier] = &[
    Amplifier { name: "ideal", summary: "no limits", reference: "by definition", limits: NONE },
    Amplifier {
        name: "pl140",
        summary: "the driver of the PL140 twin: +-30 V about mid-voltage, 500 mA into 8.2 uF",
        reference: "range and capacitance: PI data sheet PL112-PL140, 2020; current: assumed for the twin",
        limits: Limits { low: Some(-30.0), high: Some(30.0), current: Some(0.5), capacitance: Some(8.2e-6), ..NONE },
    },
    Amplifier {
        name: "bd300",
        summary: "PiezoDrive BD300, differential: +-300 V, 50 mA peak, for benders",
        reference: "PiezoDrive BD series, table of voltage ranges, mmech.com/piezodrive-amplifiers/bd-series",
        limits: Limits { low: Some(-300.0), high: Some(300.0), current: Some(0.05), ..NONE },
    },
    Amplifier {
        name: "pdu100b",
        summary: "PiezoDrive PDu100B, bipolar: +-100 V, 100 mA peak",
        reference: "PiezoDrive PDu100B data sheet, specifications, studylib.net/doc/18096109",
        limits: Limits { low: Some(-100.0), high: Some(100.0), current: Some(0.1), ..NONE },
    },
];

impl Amplifier {
    /// The driver called `name`.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the known names.
    pub fn find(name: &str) -> Result<&'static Amplifier, Error> {
        row("driver", DRIVERS.iter(), |row| row.name, name)
    }

    /// Its limits with a load of this capacitance [F]; if it is `None`, with the capacitance of the row.
    ///
    /// # Errors
    /// Returns an error if there is a current limit but no capacitance.
    pub fn loaded(&self, capacitance: Option<f64>) -> Result<Limits, Error> {
        let limits = Limits { capacitance: capacitance.or(self.limits.capacitance), ..self.limits };
        if limits.current.is_some() && limits.capacitance.is_none() {
            let name = self.name;
            let rule = format!(
                "driver `{name}` limits the current, which depends on the load: give it in farad, such as 8.2e-6"
            );
            return Err(Error::parameter("capacitance", "none", rule));
        }
        Ok(limits)
    }
}

options! {
    /// What limits a voltage: a driver by name, and what is given beside it.
    pub struct LimitOptions {
        /// The driver whose limits the voltage must keep (see `piezoid drivers`).
        driver: Option<String> = None, OptionRow::new(OptionKind::Text("NAME")).group(GROUP);
    } with own: Limits
}

impl LimitOptions {
    /// The limits, if there are any. Limits that are given replace those of the driver.
    ///
    /// # Errors
    /// Returns an error for an unknown driver, a current limit without a capacitance, and inconsistent limits.
    pub fn limits(&self) -> Result<Option<Limits>, Error> {
        let own = self.own;
        let known = match &self.driver {
            Some(name) => Amplifier::find(name)?.loaded(own.capacitance)?,
            None if own == Limits::default() => return Ok(None),
            None if own == (Limits { capacitance: own.capacitance, ..Limits::default() }) => {
                let rule = "is used only with a current limit: leave it out, or ";
                let error = Error::parameter("capacitance", own.capacitance.unwrap_or_default(), rule);
                return Err(error.advised(vec![("driver", Value::Null), ("current", Value::Null)]));
            }
            None => Limits::default(),
        };
        let limits = Limits {
            low: own.low.or(known.low),
            high: own.high.or(known.high),
            slew: own.slew.or(known.slew),
            current: own.current.or(known.current),
            capacitance: own.capacitance.or(known.capacitance),
        };
        limits.sensible()?;
        Ok(Some(limits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;

    #[test]
    fn every_driver_says_what_it_is_and_holds_its_own_middle() {
        for driver in DRIVERS {
            assert!(!driver.summary.is_empty() && !driver.reference.is_empty(), "{}", driver.name);
            let limits = Limits { capacitance: driver.limits.capacitance.or(Some(1e-6)), ..driver.limits };
            assert!(limits.refuse(&[0.0, 0.0], 1e-3).is_ok(), "{}", driver.name);
            assert_eq!(Amplifier::find(driver.name).unwrap().name, driver.name);
        }
    }

    #[test]
    fn an_unknown_driver_is_answered_with_those_there_are() {
        assert!(Amplifier::find("pl149").unwrap_err().to_string().ends_with("did you mean `pl140`?"));
    }

    #[test]
    fn limits_that_are_given_go_before_those_of_the_driver() {
        let of = |given: serde_json::Value| LimitOptions::from_json(given).and_then(|options| options.limits());
        let limits = of(serde_json::json!({"driver": "pl140", "high": 20})).unwrap().unwrap();
        assert_eq!((limits.low, limits.high, limits.current), (Some(-30.0), Some(20.0), Some(0.5)));
        assert_eq!(of(serde_json::json!({})), Ok(None));
        let refusal = of(serde_json::json!({"capacitance": 1e-6})).unwrap_err().to_string();
        assert!(refusal.ends_with("leave it out, or give `driver` or `current`"), "{refusal}");
    }
}
