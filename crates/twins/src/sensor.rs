//! The displacement sensor: a lag, a curve, noise, and a converter with a range.
//!
//! ```text
//! s' = (y - s) / tau,   v = s + c s^2 / range,   reading = zero + q clamp(round((v + rms n) / q)),
//! q = 2 range / 2^bits
//! ```
//! The codes are from -2^(bits-1) to 2^(bits-1) - 1, so the highest reading is one q below +range (from the
//! zero). The noise n depends
//! only on the seed and the number of the sample, so a copied state has the same future.
//!
//! Reference: J. K. Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC'11, DOI 10.1145/2063384.2063405
//! (counter-based generators; here ChaCha with 8 rounds). Not modelled: drift, coloured noise.
//!
//! State: one number, the lagged displacement s [m].

use super::spec::{SensorSpec, non_negative, require};
use libm::exp;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::noise::Noise;
use piezoid_numerics::number::power;

/// The sensor, for a fixed time step.
#[derive(Debug, Clone)]
pub(super) struct Sensor {
    /// Remaining share of y - s after a step [-].
    keep: f64,
    /// c / range [1/m].
    bend: f64,
    rms: f64,
    /// Lowest and highest reading [m].
    min: f64,
    max: f64,
    /// One code [m]; 0 without a converter.
    code: f64,
    /// Reading at rest [m].
    zero: f64,
    noise: Noise,
}

impl Sensor {
    /// The sensor advanced in steps of `h` [s], with noise of `seed`.
    pub(crate) fn new(spec: &SensorSpec, h: f64, seed: u64) -> Result<Self, Error> {
        let lag = non_negative("sensor.lag_s", spec.lag_s, "seconds")?;
        let rms = non_negative("sensor.noise_rms_m", spec.noise_rms_m, "metres")?;
        let rule = "must be a number from -0.5 to 0.5 and needs range_m; or 0";
        let is_possible = spec.curvature.abs() <= 0.5 && (spec.curvature == 0.0 || spec.range_m.is_some());
        require(is_possible, "sensor.curvature", spec.curvature, rule)?;
        let range = match spec.range_m {
            None => f64::INFINITY,
            Some(range) => positive("sensor.range_m", range, "metres, or null for no limit")?,
        };
        let code = match spec.bits {
            None => 0.0,
            Some(bits @ 1..=32) if range.is_finite() => range * power(2.0, 1 - bits as i32),
            Some(bits) => {
                let rule = "must be from 1 to 32 and needs range_m; or null for no quantisation";
                return Err(Error::parameter("sensor.bits", bits, rule));
            }
        };
        let rule = "must be a number of metres, 0 for a sensor that was zeroed";
        let zero = require(spec.zero_m.is_finite(), "sensor.zero_m", spec.zero_m, rule)?;
        let keep = if lag > 0.0 { exp(-h / lag) } else { 0.0 };
        let noise = Noise::new(seed);
        Ok(Sensor { keep, bend: spec.curvature / range, rms, min: -range, max: range - code, code, zero, noise })
    }

    /// The same sensor with other noise.
    pub(super) fn with_seed(self, seed: u64) -> Self {
        Sensor { noise: Noise::new(seed), ..self }
    }

    /// Advances the lagged displacement one step; the mean displacement of the tip over it is `y` [m].
    pub(crate) fn advance(&self, s: &mut f64, y: f64) {
        *s = y + (*s - y) * self.keep;
    }

    /// The input of the converter: the lagged displacement, or the tip itself without lag [m].
    pub(super) fn sees(&self, tip: f64, lagged: f64) -> f64 {
        if self.keep > 0.0 { lagged } else { tip }
    }

    /// Reads `s` [m] as sample number `n`; true if the range clipped it.
    pub(super) fn read(&self, s: f64, n: u64) -> (f64, bool) {
        let s = s + self.bend * s * s;
        let noisy = if self.rms > 0.0 { s + self.rms * self.noise.at(n) } else { s };
        let coded = if self.code > 0.0 { (noisy / self.code).round() * self.code } else { noisy };
        (self.zero + coded.clamp(self.min, self.max), coded < self.min || coded > self.max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    fn sensor(spec: &SensorSpec) -> Sensor {
        Sensor::new(spec, 25e-6, 7).unwrap()
    }

    #[test]
    fn an_ideal_sensor_reads_the_displacement() {
        assert_eq!(sensor(&SensorSpec::default()).read(1.234_567e-3, 0), (1.234_567e-3, false));
    }

    #[test]
    fn noise_is_white_and_normal_with_the_specified_rms() {
        let sensor = sensor(&SensorSpec { noise_rms_m: 2e-7, ..SensorSpec::default() });
        let n: Vec<f64> = (0..100_000).map(|i| sensor.read(0.0, i).0 / 2e-7).collect();
        let mean = |f: &dyn Fn(usize) -> f64| (0..n.len() - 1).map(f).sum::<f64>() / (n.len() - 1) as f64;
        assert_close(&[mean(&|i| n[i]), mean(&|i| n[i] * n[i + 1])], &[0.0, 0.0], 0.0, 0.015);
        assert_close(&[mean(&|i| n[i] * n[i]), mean(&|i| n[i].powi(4))], &[1.0, 3.0], 0.03, 0.0);
    }

    #[test]
    fn the_converter_rounds_to_codes_and_ends_one_code_early() {
        let sensor = sensor(&SensorSpec { range_m: Some(2e-3), bits: Some(16), ..SensorSpec::default() });
        let code = 4e-3 / 65536.0;
        assert_close(&[sensor.read(10.4 * code, 0).0], &[10.0 * code], 1e-12, 0.0);
        assert_eq!(sensor.read(1.0, 0), (2e-3 - code, true));
        assert_eq!(sensor.read(-1.0, 0), (-2e-3, true));
        assert_eq!(sensor.read(-2e-3, 0), (-2e-3, false));
        assert!(!sensor.read(2e-3 - code, 0).1);
    }

    #[test]
    fn the_curve_is_quadratic() {
        let sensor = sensor(&SensorSpec { curvature: 0.02, range_m: Some(2e-3), ..SensorSpec::default() });
        assert_close(&[sensor.read(1e-3, 0).0, sensor.read(-1e-3, 0).0], &[1.01e-3, -0.99e-3], 1e-12, 0.0);
    }

    #[test]
    fn the_lag_is_of_first_order() {
        let (sensor, mut s) = (sensor(&SensorSpec { lag_s: 1e-3, ..SensorSpec::default() }), 0.0);
        (0..40).for_each(|_| sensor.advance(&mut s, 1.0));
        assert_close(&[s], &[1.0 - (-1.0f64).exp()], 1e-12, 0.0);
    }

    #[test]
    fn bits_need_a_range() {
        let refused =
            |range_m, bits| Sensor::new(&SensorSpec { range_m, bits, ..SensorSpec::default() }, 1e-5, 0).is_err();
        let bent = SensorSpec { curvature: 0.01, ..SensorSpec::default() };
        assert!(Sensor::new(&bent, 1e-5, 0).is_err());
        assert!(refused(None, Some(16)) && refused(Some(1e-3), Some(0)) && refused(Some(-1.0), None));
    }
}
