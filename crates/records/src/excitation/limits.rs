//! Limits of a driver: range, slew and current.
//!
//! A piezo is a capacitor: the current is `i = C du/dt`. A sine of peak-to-peak voltage `Vpp` and frequency f therefore
//! draws a peak current of `I = pi f Vpp C`, and a driver that gives at most I cannot exceed the slew `I / C`. Slew and
//! current are computed from consecutive samples, `(u[t] - u[t-1]) / ts`. This is the mean over the sampling period; a
//! driver that jumps and holds exceeds it for a moment. The driver is assumed settled at the first sample: to check the
//! change from an earlier voltage too, prepend this voltage. Average current and heat are not considered.
//!
//! Reference: Fleming, Techniques and Considerations for Driving Piezoelectric Actuators at High-Speed, University of
//! Newcastle; PiezoDrive PD200X4 manual, section Power Bandwidth.

use piezoid_numerics::error::{Error, finite, positive};
use piezoid_numerics::options::{OptionRow, options};
use serde::Serialize;

/// Shares of a limit up to this much above 1 are rounding.
const ROUNDING: f64 = 1e-6;

options! {
    /// The limits of a driver and its load; `None` for no limit.
    ///
    /// ```
    /// use piezoid::excitation::{Limits, Sine};
    /// let limits = Limits { current: Some(0.06), capacitance: Some(8.2e-6), ..Limits::default() };
    /// let u = Sine { amplitude: 30.0, frequency: 40.0, ..Sine::default() }.samples(1e-4, 1000)?;
    /// let error = limits.refuse(&u, 1e-4).unwrap_err().to_string();
    /// assert!(error.starts_with("the drive exceeds its limits: current 0.06182 A"), "{error}");
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    #[derive(Copy)]
    pub struct Limits {
        /// Capacitance of the load, for the current limit.
        capacitance: Option<f64> = None, OptionRow::positive("F").group(GROUP);
        /// Lowest voltage.
        low: Option<f64> = None, OptionRow::number("V").group(GROUP);
        /// Highest voltage.
        high: Option<f64> = None, OptionRow::number("V").group(GROUP);
        /// Largest slew rate of the voltage.
        slew: Option<f64> = None, OptionRow::positive("V/s").group(GROUP);
        /// Largest current, in both directions; needs {capacitance}.
        current: Option<f64> = None, OptionRow::positive("A").group(GROUP);
    }
}

/// Heading of the options that limit a voltage.
pub(super) const GROUP: &str = "Driver";

/// The extreme value of one quantity of a drive, with its limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Peak {
    /// Name of the quantity.
    pub quantity: &'static str,
    /// Its unit in SI.
    pub unit: &'static str,
    /// The extreme value, in this unit.
    pub value: f64,
    /// The first sample with this value, from 0; for slew and current the sample after the change.
    pub sample: usize,
    /// The limit.
    pub limit: Option<f64>,
    /// Used share of the limit, 1 at the limit. Voltages are measured from the middle of the range, or from 0 V if one
    /// end is open.
    pub share: Option<f64>,
}

/// Use of the limits by a drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Usage {
    /// The lowest voltage.
    pub lowest: Peak,
    /// The highest voltage.
    pub highest: Peak,
    /// The fastest change, in either direction.
    pub slew: Peak,
    /// The highest current, in either direction; `None` without a capacitance.
    pub current: Option<Peak>,
}

impl Usage {
    /// All extreme values in order, for a table.
    pub fn peaks(&self) -> impl Iterator<Item = &Peak> {
        [&self.lowest, &self.highest, &self.slew].into_iter().chain(&self.current)
    }
}

impl Peak {
    /// True if the value exceeds the limit.
    pub fn exceeds(&self) -> bool {
        self.share.is_some_and(|share| share > 1.0 + ROUNDING)
    }

    /// The value, its place and its limit as text.
    fn tell(&self, ts: f64) -> String {
        let Peak { quantity, unit, sample, .. } = self;
        let (value, at) = (rounded(self.value), rounded(*sample as f64 * ts));
        let (limit, percent) = (self.limit.unwrap_or(f64::NAN), 100.0 * self.share.unwrap_or(f64::NAN));
        format!("{quantity} {value} {unit} at sample {sample} ({at} s), limit {limit} {unit} ({percent:.0} %)")
    }
}

impl Limits {
    /// The use of the limits by the voltages `u` [V], every `ts` [s].
    ///
    /// # Errors
    /// Returns an error for inconsistent limits, voltages that are not finite, and an empty drive.
    pub fn check(&self, u: &[f64], ts: f64) -> Result<Usage, Error> {
        self.sensible()?;
        positive("ts", ts, "seconds")?;
        finite("u", u)?;
        let Some(&first) = u.first() else {
            let remedy = "it must not be empty".into();
            return Err(Error::TooShort { what: "the drive".into(), have: 0, need: 1, remedy });
        };
        let larger = |best: (usize, f64), next: (usize, f64)| if next.1 > best.1 { next } else { best };
        let values = || u.iter().copied().enumerate();
        let highest = values().fold((0, first), larger);
        let lowest = values().map(|(t, v)| (t, -v)).fold((0, -first), larger);
        let steps = u.windows(2).enumerate().map(|(t, w)| (t + 1, (w[1] - w[0]).abs() / ts));
        let slew = steps.fold((0, 0.0), larger);

        let middle = self.low.zip(self.high).map_or(0.0, |(low, high)| 0.5 * low + 0.5 * high);
        let peak = |quantity, unit, (sample, value): (usize, f64), limit: Option<f64>, from: f64| {
            let share = limit.map(|limit| (value - from) / (limit - from));
            Peak { quantity, unit, value, sample, limit, share }
        };
        Ok(Usage {
            lowest: peak("lowest voltage", "V", (lowest.0, -lowest.1), self.low, middle),
            highest: peak("highest voltage", "V", highest, self.high, middle),
            slew: peak("slew", "V/s", slew, self.slew, 0.0),
            current: self.capacitance.map(|c| peak("current", "A", (slew.0, c * slew.1), self.current, 0.0)),
        })
    }

    /// Returns an error if the voltages `u` [V], every `ts` [s], exceed a limit; otherwise the use of the limits.
    ///
    /// # Errors
    /// [`Error::Limits`] names every exceeded limit, the value and the sample. The errors of [`Limits::check`].
    pub fn refuse(&self, u: &[f64], ts: f64) -> Result<Usage, Error> {
        let usage = self.check(u, ts)?;
        let over: Vec<String> = usage.peaks().filter(|p| p.exceeds()).map(|p| p.tell(ts)).collect();
        if over.is_empty() {
            return Ok(usage);
        }
        Err(Error::Limits(format!("{}; lower the amplitude or the frequency, or clip", over.join("; "))))
    }

    /// The voltages `u` [V], every `ts` [s], as this driver would follow them: clipped to the range, and changed from
    /// sample to sample by at most what slew and current allow. The first sample is only clipped to the range.
    ///
    /// # Errors
    /// The errors of [`Limits::check`], except for an empty drive.
    pub fn clip(&self, u: &[f64], ts: f64) -> Result<Vec<f64>, Error> {
        self.sensible()?;
        positive("ts", ts, "seconds")?;
        finite("u", u)?;
        let step = ts * self.fastest();
        let (low, high) = (self.low.unwrap_or(f64::NEG_INFINITY), self.high.unwrap_or(f64::INFINITY));
        let mut before: Option<f64> = None;
        let follow = |expected: &f64| {
            let inside = expected.clamp(low, high);
            let reached = before.map_or(inside, |before| inside.clamp(before - step, before + step));
            before = Some(reached);
            reached
        };
        Ok(u.iter().map(follow).collect())
    }

    /// The fastest change of the voltage that slew and current allow [V/s]; infinite without such limits.
    pub fn fastest(&self) -> f64 {
        let charging = self.current.zip(self.capacitance).map_or(f64::INFINITY, |(i, c)| i / c);
        self.slew.unwrap_or(f64::INFINITY).min(charging)
    }

    /// Checks that the limits are consistent and complete.
    ///
    /// # Errors
    /// Returns an error that names the wrong limit.
    pub fn sensible(&self) -> Result<(), Error> {
        for (name, value, unit) in [
            ("slew", self.slew, "volts per second"),
            ("current", self.current, "amperes"),
            ("capacitance", self.capacitance, "farads"),
        ] {
            value.map_or(Ok(0.0), |value| positive(name, value, unit))?;
        }
        for (name, value) in [("low", self.low), ("high", self.high)] {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                let rule = "must be a finite number of volts; leave it out for no limit";
                return Err(Error::parameter(name, value, rule));
            }
        }
        if self.current.is_some() && self.capacitance.is_none() {
            let rule = "a current limit needs the capacitance of the load [F]";
            return Err(Error::parameter("capacitance", "(not given)", rule));
        }
        let rule = "low must be below high; if only low is given it must be negative, if only high is given it must \
                    be positive";
        let (low, high) = (self.low.unwrap_or(f64::NEG_INFINITY), self.high.unwrap_or(f64::INFINITY));
        let sensible = match (self.low, self.high) {
            (None, None) => true,
            (Some(_), Some(_)) => low < high && (high - low).is_finite(),
            _ => low < 0.0 && high > 0.0,
        };
        if sensible { Ok(()) } else { Err(Error::parameter("low, high", format!("{low} V, {high} V"), rule)) }
    }
}

/// Four significant digits, for messages.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{Amplifier, Prbs, Sine};
    use piezoid_testing::assert_close;
    use proptest::prelude::*;

    #[test]
    fn a_sine_draws_pi_f_vpp_c() {
        // 60 V peak-to-peak with the 8.2 uF of a PL140.
        let limits = Amplifier::find("pl140").unwrap().limits;
        for (frequency, milliamperes) in [(5.0, 7.7), (20.0, 31.0), (40.0, 62.0), (80.0, 124.0), (160.0, 247.0)] {
            let u = Sine { amplitude: 30.0, frequency, offset: 0.0 }.samples(1e-5, 20_000).unwrap();
            let usage = limits.refuse(&u, 1e-5).unwrap();
            let current = usage.current.unwrap();
            assert_close(&[1e3 * current.value], &[milliamperes], 5e-3, 0.0);
            assert_close(&[current.share.unwrap()], &[current.value / 0.5], 1e-12, 0.0);
            assert_close(&[usage.highest.share.unwrap(), usage.lowest.share.unwrap()], &[1.0, 1.0], 1e-4, 0.0);
        }
    }

    #[test]
    fn every_limit_exceeded_is_named_with_its_numbers() {
        let limits = Limits { low: Some(0.0), high: Some(60.0), slew: Some(1000.0), ..Limits::default() };
        let error = limits.refuse(&[0.0, 1.0, 66.0, 66.0, 65.0], 0.01).unwrap_err();
        assert_eq!(
            error.to_string(),
            "the drive exceeds its limits: highest voltage 66 V at sample 2 (0.02 s), limit 60 V (120 %); slew 6500 V/s at sample 2 (0.02 s), limit 1000 V/s (650 %); lower the amplitude or the frequency, or clip"
        );
    }

    #[test]
    fn a_limit_that_is_absent_does_not_limit() {
        let usage = Limits::default().refuse(&[1e6, -1e6], 1e-6).unwrap();
        assert_eq!((usage.slew.value, usage.slew.share, usage.current), (2e12, None, None));
        assert_eq!(usage.peaks().count(), 3);
        assert_eq!(Limits::default().clip(&[1e6, -1e6], 1e-6).unwrap(), [1e6, -1e6]);
    }

    #[test]
    fn the_way_to_the_first_sample_counts_only_when_it_is_given() {
        let limits = Limits { slew: Some(1000.0), ..Limits::default() };
        assert!(limits.refuse(&[30.0, 30.0], 1e-3).is_ok());
        assert!(limits.refuse(&[0.0, 30.0, 30.0], 1e-3).is_err());
        assert_eq!(limits.clip(&[30.0, 30.0], 1e-3).unwrap(), [30.0, 30.0]);
        assert_eq!(limits.clip(&[0.0, 30.0, 30.0], 1e-3).unwrap(), [0.0, 1.0, 2.0]);
    }

    #[test]
    fn limits_without_sense_are_refused() {
        let refused = |limits: Limits| limits.check(&[0.0], 1.0).is_err() && limits.clip(&[0.0], 1.0).is_err();
        assert!(refused(Limits { low: Some(1.0), high: Some(1.0), ..Limits::default() }));
        assert!(refused(Limits { low: Some(f64::NAN), high: Some(1.0), ..Limits::default() }));
        assert!(refused(Limits { high: Some(-1.0), ..Limits::default() }));
        assert!(refused(Limits { slew: Some(0.0), ..Limits::default() }));
        assert!(refused(Limits { current: Some(0.5), ..Limits::default() }));
        assert!(Limits::default().check(&[], 1.0).is_err() && Limits::default().check(&[0.0], 0.0).is_err());
    }

    proptest! {
        #[test]
        fn what_is_clipped_is_within_the_limits_and_clipping_twice_changes_nothing(
            amplitude in 1.0..100.0, slew in 1e3..1e6f64, current in 1e-3..1.0f64,
        ) {
            let limits = Limits { low: Some(-30.0), high: Some(20.0), slew: Some(slew), current: Some(current),
                capacitance: Some(8.2e-6) };
            let u = Prbs { amplitude, ..Prbs::default() }.samples(5e-4, 500).unwrap();
            let clipped = limits.clip(&u, 5e-4).unwrap();
            prop_assert!(limits.refuse(&clipped, 5e-4).is_ok());
            prop_assert_eq!(&limits.clip(&clipped, 5e-4).unwrap(), &clipped);
            if limits.refuse(&u, 5e-4).is_ok() {
                prop_assert_eq!(clipped, u);
            }
        }
    }
}
