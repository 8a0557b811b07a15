//! How an oscilloscope measures beside a generator.

use piezoid::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use serde_json::Value;

const GROUP: &str = "Oscilloscope";

/// TCP port of an instrument with SCPI.
const PORT: u16 = 5025;

const CHANNELS: OptionRow = OptionRow::new(OptionKind::Integer(1, 8)).group(GROUP);

options! {
    /// How an oscilloscope measures beside a SCPI generator.
    pub struct ScpiOptions {
        /// Address of the oscilloscope, as HOST or HOST:PORT.
        oscilloscope: Option<String> = None, OptionRow::new(OptionKind::Text("HOST")).absent("that of the generator, port 5025").group(GROUP);
        /// Channel of the oscilloscope at the voltage monitor of the amplifier.
        monitor_channel: Option<usize> = None, CHANNELS.absent("none: the record has the drive as its voltage");
        /// Voltage at the actuator for 1 V at the monitor.
        monitor_gain: Option<f64> = None, OptionRow::positive("V").absent("the gain of the amplifier").group(GROUP);
        /// Channel of the oscilloscope at the sensor.
        sensor_channel: usize = 2, CHANNELS;
        /// Displacement for 1 V of the sensor.
        sensitivity: Option<f64> = None, OptionRow::positive("um").absent("an error, with SCPI").group(GROUP);
        /// Lowest and highest voltage of the sensor.
        sensor_range: Option<(f64, f64)> = None, OptionRow { unit: "V", ..OptionRow::new(OptionKind::Pair) }.absent("-10 to 10 V").group(GROUP);
    }
}

impl ScpiOptions {
    /// Host and port of the oscilloscope.
    pub(crate) fn address(&self, generator: &str) -> Result<(String, u16), Error> {
        let Some(text) = &self.oscilloscope else { return Ok((generator.into(), PORT)) };
        // An address of IPv6 has colons of its own: its port is after a bracket.
        let (host, port) = match text.rsplit_once(':') {
            Some((host, port)) if !host.contains(':') || host.ends_with(']') => (host, Some(port)),
            _ => (&**text, None),
        };
        let port = port.map_or(Ok(PORT), str::parse);
        let port = port.map_err(|_| Error::parameter("oscilloscope", text, "must be HOST or HOST:PORT"))?;
        Ok((host.trim_matches(['[', ']']).into(), port))
    }

    /// Displacement for 1 V [um].
    pub(crate) fn scale(&self) -> Result<f64, Error> {
        self.sensitivity.ok_or_else(|| {
            Error::Content("an oscilloscope does not know the sensor: ".into())
                .needing(vec![("sensitivity", Value::Null)])
        })
    }

    /// Lowest and highest voltage of the sensor [V].
    pub(crate) fn span(&self) -> Result<(f64, f64), Error> {
        match self.sensor_range.unwrap_or((-10.0, 10.0)) {
            (low, high) if low < high && (high - low).is_finite() => Ok((low, high)),
            (low, high) => {
                let rule = "must go from the lowest to the highest voltage";
                Err(Error::parameter("sensor_range", format!("{low} {high}"), rule))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oscilloscope_has_an_address_of_its_own_or_that_of_the_generator() {
        let of = |text: Option<&str>| {
            ScpiOptions { oscilloscope: text.map(String::from), ..ScpiOptions::default() }.address("generator")
        };
        for (text, host, port) in [
            (None, "generator", 5025),
            (Some("scope"), "scope", 5025),
            (Some("10.0.0.3:5555"), "10.0.0.3", 5555),
            (Some("[::1]:7"), "::1", 7),
            (Some("fe80::1"), "fe80::1", 5025),
        ] {
            assert_eq!(of(text).unwrap(), (host.into(), port));
        }
        assert!(of(Some("scope:x")).unwrap_err().to_string().contains("must be HOST or HOST:PORT"));
    }
}
