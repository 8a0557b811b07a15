//! What a user states for a certificate: uncertainties that records do not show, and who certifies what for whom.

use super::super::timing::length;
use piezoid_numerics::error::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_validation::ValidateOptions;
use serde::{Deserialize, Serialize};

/// What the noise of the records is taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NoiseOrigin {
    /// Perhaps motion, such as by noise of the driver: it counts.
    #[default]
    Unknown,
    /// Noise of the sensor alone: the displacement does not have it.
    Sensor,
}

/// What happens to the mean error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MeanError {
    /// It is a part of the uncertainty.
    #[default]
    Included,
    /// The user adds it to every prediction.
    Corrected,
}

const ORIGINS: OptionKind = OptionKind::Choice(&[
    ("unknown", "it may be motion of the actuator, and counts"),
    ("sensor", "it is noise of the sensor alone, and does not count"),
]);

const MEAN_ERRORS: OptionKind = OptionKind::Choice(&[
    ("included", "it is part of the uncertainty of predictions as they are"),
    ("corrected", "the user adds the stated correction to predictions"),
]);

const LENGTH: OptionKind = OptionKind::Text("LENGTH");
const COEFFICIENT: OptionKind = OptionKind::Text("LENGTH|PERCENT");
const DATE: OptionKind = OptionKind::Text("DATE");
const TEXT: OptionKind = OptionKind::Text("TEXT");
const BUDGET: &str = "Uncertainties as stated";
const NAMES: &str = "Certificate";

/// A share of the probability [%].
const COVERAGE: OptionRow =
    OptionRow { unit: "%", ..OptionRow::new(OptionKind::Number { least: 0.0, open: true, below: 100.0 }) };

/// A temperature [degC].
const TEMPERATURE: OptionRow = OptionRow {
    unit: "degC",
    ..OptionRow::new(OptionKind::Number { least: -273.15, open: false, below: f64::INFINITY })
};

options! {
    /// Options of a certificate.
    pub struct CertificateOptions {
        /// Coverage probability of the expanded uncertainty.
        coverage: f64 = 95.45, COVERAGE;
        /// What the noise of the records is taken for.
        noise: NoiseOrigin = NoiseOrigin::Unknown, OptionRow::new(ORIGINS);
        /// What happens to the mean error of the predictions.
        mean_error: MeanError = MeanError::Included, OptionRow::new(MEAN_ERRORS);
        /// Expanded uncertainty of the scale of the sensor, relative to the displacement, from its certificate.
        sensor_calibration: Option<f64> = None, OptionRow::not_negative("%").group(BUDGET);
        /// Coverage factor of {sensor_calibration}.
        sensor_k: f64 = 2.0, OptionRow::positive("").group(BUDGET);
        /// Largest deviation of the sensor from its straight line: a number in the output unit, or with a unit (50nm).
        sensor_linearity: Option<String> = None, OptionRow::new(LENGTH).group(BUDGET);
        /// Smallest step of the reading, written like {sensor_linearity}.
        resolution: Option<String> = None, OptionRow::new(LENGTH).group(BUDGET);
        /// Largest drift of sensor and actuator from the records to the use, written like {sensor_linearity}.
        drift: Option<String> = None, OptionRow::new(LENGTH).group(BUDGET);
        /// Change of the displacement per kelvin: a length such as 20nm, or a share of the displacement such as 0.1%.
        temperature_coefficient: Option<String> = None, OptionRow::new(COEFFICIENT).group(BUDGET);
        /// Largest difference of the temperature from that of the records.
        temperature_half_width: Option<f64> = None, OptionRow::not_negative("K").group(BUDGET);
        /// Expanded uncertainty of the gain of driver and voltmeter, relative to the voltage.
        voltage_gain: Option<f64> = None, OptionRow::not_negative("%").group(BUDGET);
        /// Coverage factor of {voltage_gain}.
        voltage_k: f64 = 2.0, OptionRow::positive("").group(BUDGET);
        /// Largest offset of the voltage, in the unit of the input.
        voltage_offset: Option<f64> = None, OptionRow::not_negative("V").group(BUDGET);
        /// Temperature of the records.
        temperature: Option<f64> = None, TEMPERATURE.group(NAMES);
        /// Date of issue, such as 2026-11-30: a certificate does not read the clock.
        date: Option<String> = None, OptionRow::new(DATE).group(NAMES);
        /// Date on which the records were measured.
        measured: Option<String> = None, OptionRow::new(DATE).absent("the date of issue").group(NAMES);
        /// Number of the certificate.
        number: Option<String> = None, OptionRow::new(TEXT).absent("one from the hashes of all files").group(NAMES);
        /// Who states it.
        issuer: Option<String> = None, OptionRow::new(TEXT).group(NAMES);
        /// The person responsible.
        person: Option<String> = None, OptionRow::new(TEXT).absent("the issuer").group(NAMES);
        /// Who it is for.
        customer: Option<String> = None, OptionRow::new(TEXT).group(NAMES);
        /// Country of the issuer: two letters (ISO 3166-1).
        country: Option<String> = None, OptionRow::new(TEXT).group(NAMES);
        /// The actuator: manufacturer and type.
        item: Option<String> = None, OptionRow::new(TEXT).group(NAMES);
        /// Serial number of the actuator.
        serial: Option<String> = None, OptionRow::new(TEXT).group(NAMES);
        /// The sensor of the records, with the number of its certificate.
        sensor: Option<String> = None, OptionRow::new(TEXT).group(NAMES);
    } with validation: ValidateOptions
}

/// What is stated, in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Stated {
    /// Half-widths [output unit].
    pub(super) linearity: Option<f64>,
    pub(super) drift: Option<f64>,
    /// The step of the reading [output unit].
    pub(super) resolution: Option<f64>,
    /// Per kelvin, and how far the temperature goes [K].
    pub(super) temperature: Option<(Coefficient, f64)>,
}

/// A change with the temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Coefficient {
    /// [output unit / K]
    Length(f64),
    /// [% / K] of the displacement.
    Percent(f64),
}

impl CertificateOptions {
    /// What is stated, for an output in `unit`.
    ///
    /// # Errors
    /// Returns an error for a text that is no length, a date or a country that is none, and a temperature of which only
    /// the coefficient or only the half-width is stated.
    pub(super) fn stated(&self, unit: &str) -> Result<Stated, Error> {
        let of = |name: &str, text: &Option<String>| text.as_deref().map(|text| length(name, text, unit)).transpose();
        for (name, date) in [("date", &self.date), ("measured", &self.measured)] {
            if let Some(date) = date.as_deref().filter(|date| !is_date(date)) {
                return Err(Error::parameter(name, date, "must be a day of the calendar, such as 2026-11-30"));
            }
        }
        if let (Some(date), Some(measured)) = (&self.date, &self.measured)
            && measured > date
        {
            let rule = format!("must not be after the date of issue, {date}");
            return Err(Error::parameter("measured", measured, rule));
        }
        let two_letters = |text: &&str| text.len() == 2 && text.bytes().all(|c| c.is_ascii_uppercase());
        if let Some(country) = self.country.as_deref().filter(|text| !two_letters(text)) {
            return Err(Error::parameter("country", country, "must be two capital letters, such as CZ (ISO 3166-1)"));
        }
        let temperature = match (&self.temperature_coefficient, self.temperature_half_width) {
            (None, None) => None,
            (Some(text), Some(half_width)) => Some((coefficient(text, unit)?, half_width)),
            (Some(text), None) => {
                let rule = "needs how far the temperature goes: ";
                let error = Error::parameter("temperature_coefficient", text, rule);
                return Err(error.advised(vec![("temperature_half_width", serde_json::Value::Null)]));
            }
            (None, Some(half_width)) => {
                let error = Error::parameter("temperature_half_width", half_width, "needs what a kelvin changes: ");
                return Err(error.advised(vec![("temperature_coefficient", serde_json::Value::Null)]));
            }
        };
        Ok(Stated {
            linearity: of("sensor_linearity", &self.sensor_linearity)?,
            drift: of("drift", &self.drift)?,
            resolution: of("resolution", &self.resolution)?,
            temperature,
        })
    }
}

fn coefficient(text: &str, unit: &str) -> Result<Coefficient, Error> {
    match text.trim().strip_suffix('%') {
        Some(percent) => {
            let value = percent.trim().parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0);
            let rule = "must be a positive share of the displacement per kelvin, such as 0.1%";
            value.map(Coefficient::Percent).ok_or_else(|| Error::parameter("temperature_coefficient", text, rule))
        }
        None => length("temperature_coefficient", text, unit).map(Coefficient::Length),
    }
}

/// True for a day of the Gregorian calendar, as ISO 8601 writes it.
fn is_date(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let [year, month, day] = parts[..] else { return false };
    let number = |part: &str, length: usize| {
        let digits = part.len() == length && part.bytes().all(|c| c.is_ascii_digit());
        part.parse::<u32>().ok().filter(|_| digits)
    };
    let (Some(year), Some(month), Some(day)) = (number(year, 4), number(month, 2), number(day, 2)) else {
        return false;
    };
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let days = match month {
        2 => 28 + u32::from(is_leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => 0,
    };
    year > 0 && (1..=days).contains(&day)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(options: CertificateOptions) -> String {
        options.stated("um").unwrap_err().to_string()
    }

    fn text(text: &str) -> Option<String> {
        Some(text.into())
    }

    #[test]
    fn lengths_are_converted_to_the_output_unit() {
        let options = CertificateOptions {
            sensor_linearity: text("50nm"),
            resolution: text("0.001"),
            temperature_coefficient: text("0.1 %"),
            temperature_half_width: Some(2.0),
            ..CertificateOptions::default()
        };
        let stated = options.stated("um").unwrap();
        assert!((stated.linearity.unwrap() - 0.05).abs() < 1e-15);
        assert_eq!((stated.resolution, stated.drift), (Some(0.001), None));
        assert_eq!(stated.temperature, Some((Coefficient::Percent(0.1), 2.0)));
    }

    #[test]
    fn what_is_no_uncertainty_is_refused_with_its_rule() {
        let options = CertificateOptions::default;
        let volts = refused(CertificateOptions { sensor_linearity: text("5mV"), ..options() });
        assert!(volts.starts_with("sensor_linearity = 5mV: must be a positive length, in um"), "{volts}");
        let negative = refused(CertificateOptions { drift: text("-3nm"), ..options() });
        assert!(negative.starts_with("drift = -3nm: must be a positive length"), "{negative}");
        let half = refused(CertificateOptions { temperature_half_width: Some(2.0), ..options() });
        assert!(half.contains("give `temperature_coefficient`"), "{half}");
        let other = refused(CertificateOptions { temperature_coefficient: text("1nm"), ..options() });
        assert!(other.contains("give `temperature_half_width`"), "{other}");
        let country = refused(CertificateOptions { country: text("Cz"), ..options() });
        assert!(country.contains("two capital letters"), "{country}");
        for rows in [("sensor_calibration", -1.0), ("coverage", 0.0), ("coverage", 100.0)] {
            use piezoid_numerics::options::Options;
            let error = CertificateOptions::from_json(serde_json::json!({(rows.0): rows.1})).unwrap_err().to_string();
            assert!(error.starts_with(rows.0) && error.contains("must be a number"), "{error}");
        }
    }

    #[test]
    fn dates_are_days_of_the_calendar() {
        for day in ["2026-11-30", "2024-02-29", "2000-02-29"] {
            assert!(is_date(day), "{day}");
        }
        for other in ["2026-11-31", "2026-02-29", "1900-02-29", "2026-13-01", "26-11-30", "30.11.2026", "2026-1-1", ""]
        {
            assert!(!is_date(other), "{other}");
        }
        let early = CertificateOptions { date: text("2026-01-01"), measured: text("2026-01-02"), ..Default::default() };
        assert!(refused(early).contains("must not be after the date of issue, 2026-01-01"));
    }
}
