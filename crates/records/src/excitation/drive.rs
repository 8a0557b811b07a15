//! Code that all excitations share: `u = offset + amplitude s`, with a shape `s` between -1 and 1.

use piezoid_numerics::error::{Error, positive};

/// Amplitude and offset, checked.
#[derive(Clone, Copy)]
pub(super) struct Drive {
    amplitude: f64,
    offset: f64,
    ts: f64,
}

impl Drive {
    /// `amplitude` [V], `offset` [V], sampling period `ts` [s].
    pub(super) fn new(amplitude: f64, offset: f64, ts: f64) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        positive("amplitude", amplitude, "volts")?;
        if !(offset.abs() + amplitude).is_finite() {
            return Err(Error::parameter("offset", offset, "must be a finite number of volts"));
        }
        Ok(Drive { amplitude, offset, ts })
    }

    /// The frequency, if samples every `ts` can represent it.
    pub(super) fn shows(&self, name: &str, frequency: f64) -> Result<f64, Error> {
        positive(name, frequency, "hertz")?;
        let (nyquist, ts) = (0.5 / self.ts, self.ts);
        if frequency < nyquist {
            return Ok(frequency);
        }
        let rule =
            format!("must be below {nyquist} Hz, half the sampling rate (ts = {ts} s); lower it or sample faster");
        Err(Error::parameter(name, format!("{frequency} Hz"), rule))
    }

    /// The voltage for the value `s` of the shape.
    pub(super) fn voltage(&self, s: f64) -> f64 {
        self.offset + self.amplitude * s.clamp(-1.0, 1.0)
    }

    /// `n` samples of the shape `s`, a function of the elapsed part of the period, from 0 up to 1.
    pub(super) fn periodic(&self, frequency: f64, n: usize, s: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..n).map(|t| self.voltage(s(self.passed(frequency, t)))).collect()
    }

    /// The elapsed part of the period at sample `t`, from 0 up to 1.
    pub(super) fn passed(&self, frequency: f64, t: usize) -> f64 {
        (frequency * self.ts * t as f64).fract()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_without_sense_is_refused_with_its_numbers() {
        assert!(Drive::new(0.0, 0.0, 1e-3).is_err() && Drive::new(1.0, f64::INFINITY, 1e-3).is_err());
        let drive = Drive::new(1.0, 0.0, 5e-4).unwrap();
        assert_eq!(drive.shows("frequency", 999.0), Ok(999.0));
        assert_eq!(
            drive.shows("frequency", 1000.0).unwrap_err().to_string(),
            "frequency = 1000 Hz: must be below 1000 Hz, half the sampling rate (ts = 0.0005 s); lower it or sample faster"
        );
    }
}
