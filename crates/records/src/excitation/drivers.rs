//! Drivers by name: the limits of known amplifiers, from data sheets.
//!
//! The current limit of an amplifier limits the slew only together with a load. If the row has no capacitance, set that
//! of the [`Actuator`](super::Actuator): `Limits { capacitance: actuator.capacitance, ..driver.limits }`. The current
//! limits are peak values, which many amplifiers give for some milliseconds only; `continuous` has no such limit of
//! time. A figure that is not known is `None`, not an estimate. Voltages are those of the amplifier; an actuator may
//! allow less.

use super::Limits;
use super::limits::GROUP;
use piezoid_numerics::error::{Error, row};
use piezoid_numerics::number::{quantity, round};
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use serde::ser::Error as _;
use serde::{Serialize, Serializer};
use serde_json::Value;

/// A driver by name.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(remote = "Self")]
pub struct Amplifier {
    /// Name in every front end.
    pub name: &'static str,
    /// What it is, in words.
    pub summary: &'static str,
    /// Source of the numbers.
    pub reference: &'static str,
    /// Limits of its output.
    #[serde(flatten)]
    pub limits: Limits,
    /// Current that it gives continuously, rms or average as the data sheet states it [A].
    pub continuous: Option<f64>,
    /// Output voltage over input voltage [-].
    pub gain: Option<f64>,
    /// Bandwidth at small signals, without load [Hz].
    pub bandwidth: Option<f64>,
}

/// A row without figures, for those that follow.
const NONE: Amplifier = Amplifier {
    name: "",
    summary: "",
    reference: "",
    limits: Limits { low: None, high: None, slew: None, current: None, capacitance: None },
    continuous: None,
    gain: None,
    bandwidth: None,
};

/// The range [V] and the peak current [A].
const fn output(low: f64, high: f64, current: f64) -> Limits {
    Limits { low: Some(low), high: Some(high), current: Some(current), ..NONE.limits }
}

/// All drivers.
#[rustfmt::skip]
pub static DRIVERS: &[Amplifier] = &[
    Amplifier { name: "ideal", summary: "no limits", reference: "by definition", ..NONE },
    Amplifier { name: "pl140", summary: "the driver of the PL140 twin, relative to mid-supply",
        reference: "range and capacitance: PI data sheet PL112-PL140, 2020; current: assumed for the twin",
        limits: Limits { capacitance: Some(8.2e-6), ..output(-30.0, 30.0, 0.5) }, ..NONE },
    Amplifier { name: "e-503", summary: "PI E-503.00, module with three channels",
        reference: "PI, data sheet E-503 (E-500 system)",
        limits: output(-30.0, 130.0, 0.14), continuous: Some(0.06), gain: Some(10.0), ..NONE },
    Amplifier { name: "e-610", summary: "PI E-610.00, module with one channel",
        reference: "PI, data sheet E-610",
        limits: output(-30.0, 130.0, 0.18), continuous: Some(0.1), gain: Some(10.0), ..NONE },
    Amplifier { name: "e-617", summary: "PI E-617.001, module with energy recovery",
        reference: "PI, data sheet and manual PZ201E of the E-617: the peak lasts 5 ms",
        limits: output(-30.0, 130.0, 2.0), continuous: Some(1.0), gain: Some(10.0), ..NONE },
    Amplifier { name: "e-663", summary: "PI E-663.00, bench-top amplifier with three channels",
        reference: "PI, data sheet E-663",
        limits: output(-20.0, 120.0, 0.14), continuous: Some(0.06), gain: Some(10.0), ..NONE },
    Amplifier { name: "mdt693b", summary: "Thorlabs MDT693B, three channels without feedback",
        reference: "Thorlabs, manual of the MDT693B and MDT694B",
        limits: output(0.0, 150.0, 0.06), gain: Some(15.0), ..NONE },
    Amplifier { name: "bpc303", summary: "Thorlabs BPC303, bench-top controller with three channels",
        reference: "Thorlabs, manual of the BPC300 series: 500 mA continuously",
        limits: output(0.0, 150.0, 0.5), continuous: Some(0.5), ..NONE },
    Amplifier { name: "kpz101", summary: "Thorlabs KPZ101, K-Cube with one channel",
        reference: "Thorlabs, manual of the KPZ101",
        limits: output(0.0, 150.0, 0.0075), continuous: Some(0.0075), ..NONE },
    Amplifier { name: "bd150", summary: "PiezoDrive BD150, differential, for benders", reference: BD,
        limits: output(-150.0, 150.0, 0.095), continuous: Some(0.021), gain: Some(51.0), ..NONE },
    Amplifier { name: "bd300", summary: "PiezoDrive BD300, differential, for benders", reference: BD,
        limits: output(-300.0, 300.0, 0.05), continuous: Some(0.011), gain: Some(101.0), ..NONE },
    Amplifier { name: "pdu100b", summary: "PiezoDrive PDu100B, bipolar module",
        reference: "PiezoDrive PDu100B data sheet, specifications, studylib.net/doc/18096109",
        limits: output(-100.0, 100.0, 0.1), continuous: Some(0.033), gain: Some(27.5), bandwidth: Some(60e3) },
    Amplifier { name: "pdu150", summary: "PiezoDrive PDu150, module with three channels",
        reference: "PiezoDrive PDu150 data sheet: power bandwidth 80 kHz",
        limits: output(-30.0, 150.0, 0.1), gain: Some(20.0), ..NONE },
    Amplifier { name: "pdu150cl", summary: "PiezoDrive PDu150CL, module with an input for strain gauges",
        reference: "PiezoDrive PDu150CL, specifications, mmech.com/piezodrive-amplifiers/pdu150cl",
        limits: Limits { slew: Some(38e6), ..output(-30.0, 150.0, 0.3) },
        continuous: Some(0.235), gain: Some(20.0), bandwidth: Some(180e3) },
    Amplifier { name: "pdm200", summary: "PiezoDrive PDm200, module, its widest range",
        reference: "PiezoDrive PDm200 data sheet: power bandwidth 63 kHz at 100 V peak-to-peak",
        limits: output(-200.0, 200.0, 0.3), bandwidth: Some(200e3), ..NONE },
    Amplifier { name: "pd200", summary: "PiezoDrive PD200, 60 W, range from -50 V; peak current in pulses only",
        reference: "PiezoDrive PD200 manual V7, as in T. Dehaeze, Voltage Amplifier PD200 - Test Bench, 2021",
        limits: Limits { slew: Some(150e6), ..output(-50.0, 150.0, 10.0) },
        continuous: Some(0.9), gain: Some(20.0), ..NONE },
    Amplifier { name: "wma-300", summary: "Falco Systems WMA-300, fast, for small loads",
        reference: "Falco Systems, data sheet WMA-300",
        limits: Limits { slew: Some(2e9), ..output(-150.0, 150.0, 0.3) },
        gain: Some(50.0), bandwidth: Some(5e6), ..NONE },
    Amplifier { name: "trek-2220", summary: "Trek 2220, high voltage, for tubes and plates",
        reference: "Trek, data sheet Model 2220",
        limits: Limits { slew: Some(100e6), ..output(-2000.0, 2000.0, 0.02) },
        continuous: Some(0.01), gain: Some(200.0), ..NONE },
];

const BD: &str = "PiezoDrive BD series, table of voltage ranges, mmech.com/piezodrive-amplifiers/bd-series";

impl Amplifier {
    /// The driver called `name`.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the known names.
    pub fn find(name: &str) -> Result<&'static Amplifier, Error> {
        row("driver", DRIVERS.iter(), |row| row.name, name)
    }

    /// What it is, and its figures, in one line.
    ///
    /// ```
    /// use piezoid::excitation::Amplifier;
    /// let description = "Thorlabs KPZ101, K-Cube with one channel: 0 to 150 V, 7.5 mA peak, 7.5 mA continuous";
    /// assert_eq!(Amplifier::find("kpz101")?.description(), description);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub fn description(&self) -> String {
        let Limits { low, high, slew, current, capacitance } = self.limits;
        let figures = [
            low.zip(high).map(|(low, high)| format!("{} to {} V", round(low), round(high))),
            current.map(|i| format!("{} peak", quantity(i, "A"))),
            self.continuous.map(|i| format!("{} continuous", quantity(i, "A"))),
            slew.map(|s| format!("{} V/us", round(1e-6 * s))),
            self.gain.map(|gain| format!("gain {}", round(gain))),
            self.bandwidth.map(|f| quantity(f, "Hz")),
            capacitance.map(|c| format!("into {}", quantity(c, "F"))),
        ];
        let figures: Vec<String> = figures.into_iter().flatten().collect();
        if figures.is_empty() { self.summary.into() } else { format!("{}: {}", self.summary, figures.join(", ")) }
    }

    /// Its limits with a load of this capacitance [F]; if it is `None`, with the capacitance of the row.
    ///
    /// # Errors
    /// Returns an error if there is a current limit but no capacitance.
    pub fn loaded(&self, capacitance: Option<f64>) -> Result<Limits, Error> {
        let limits = Limits { capacitance: capacitance.or(self.limits.capacitance), ..self.limits };
        if limits.current.is_some() && limits.capacitance.is_none() {
            let remedy = "which depends on the load: give its capacitance, such as 8.2e-6 F";
            let rule = format!("driver `{}` limits the current, {remedy}", self.name);
            return Err(Error::parameter("capacitance", "none", rule));
        }
        Ok(limits)
    }
}

/// Its figures by name; the summary is the description.
impl Serialize for Amplifier {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut row = Amplifier::serialize(self, serde_json::value::Serializer).map_err(S::Error::custom)?;
        row["summary"] = self.description().into();
        row.serialize(to)
    }
}

options! {
    /// Limits of a voltage: those of a driver by name, and single ones that replace them.
    pub struct LimitOptions {
        /// The driver whose limits the voltage must keep (see {list}).
        driver: Option<String> = None, OptionRow::new(OptionKind::Text("NAME")).list("drivers").group(GROUP);
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
    use piezoid_numerics::options::Options;

    #[test]
    fn every_driver_says_what_it_is_and_gives_zero_volts() {
        for driver in DRIVERS {
            assert!(!driver.summary.is_empty() && !driver.reference.is_empty(), "{}", driver.name);
            let limits = Limits { capacitance: driver.limits.capacitance.or(Some(1e-6)), ..driver.limits };
            assert!(limits.refuse(&[0.0, 0.0], 1e-3).is_ok(), "{}", driver.name);
            assert_eq!(Amplifier::find(driver.name).unwrap().name, driver.name);
            assert!(DRIVERS.iter().filter(|other| other.name == driver.name).count() == 1, "{} twice", driver.name);
            assert!(driver.continuous <= driver.limits.current.or(driver.continuous), "{}", driver.name);
        }
    }

    #[test]
    fn an_unknown_driver_is_answered_with_those_there_are() {
        assert!(Amplifier::find("pl149").unwrap_err().to_string().ends_with("did you mean `pl140`?"));
    }

    #[test]
    fn limits_that_are_given_go_before_those_of_the_driver() {
        let of = |arguments: serde_json::Value| LimitOptions::from_json(arguments).and_then(|options| options.limits());
        let limits = of(serde_json::json!({"driver": "pl140", "high": 20})).unwrap().unwrap();
        assert_eq!((limits.low, limits.high, limits.current), (Some(-30.0), Some(20.0), Some(0.5)));
        assert_eq!(of(serde_json::json!({})), Ok(None));
        let refusal = of(serde_json::json!({"capacitance": 1e-6})).unwrap_err().to_string();
        assert!(refusal.ends_with("leave it out, or give `driver` or `current`"), "{refusal}");
    }
}
