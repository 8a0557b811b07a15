//! What a channel of an oscilloscope recorded, at the times of a drive.
//!
//! ```text
//! y_k = mean of the trace within ts/8 of t_k,   t_k = t_0 + k ts
//! ```
//! The trace is joined by straight lines between its samples. The mean has no phase; it lowers a sine of frequency f by
//! sinc(f ts/4): 0.16 % at an eighth of the sampling rate of the drive, 2.6 % at half of it. A voltage that is held is
//! read in the middle of its period, one that is joined by lines, and a displacement, at its beginning.

use piezoid::Error;

/// Width of the mean, as a share of the sampling period of the drive.
const WIDTH: f64 = 0.25;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Trace {
    /// Time of the first sample after the trigger, and between samples [s].
    pub(crate) start: f64,
    pub(crate) step: f64,
    pub(crate) values: Vec<f64>,
}

impl Trace {
    /// So many values, one every `ts` from the time `first` on.
    pub(crate) fn every(&self, ts: f64, first: f64, count: usize) -> Result<Vec<f64>, Error> {
        let Trace { start, step, .. } = *self;
        let half = 0.5 * WIDTH * ts;
        let (from, to) = (first - half, first + (count as f64 - 1.0) * ts + half);
        let end = start + (self.values.len() as f64 - 1.0) * step;
        if step > 0.5 * ts * 1.001 {
            return Err(Error::Content(format!(
                "the oscilloscope has a sample every {step:.3e} s, but the drive one every {ts:.3e} s: make the drive \
                 shorter or sample it less often, so that the memory of the oscilloscope holds two for each"
            )));
        }
        // A sample more at both ends is the error of a time.
        if self.values.len() < 2 || from < start - step || to > end + step {
            return Err(Error::Content(format!(
                "the oscilloscope recorded {start:.6} to {end:.6} s after its trigger, not {from:.6} to {to:.6} s"
            )));
        }
        let points = 2 * (2.0 * half / step).ceil().min(1e6) as usize + 1;
        let mean = |time: f64| {
            let at = |j: usize| self.at(time - half + 2.0 * half * j as f64 / (points - 1).max(1) as f64);
            (0..points).map(at).sum::<f64>() / points as f64
        };
        Ok((0..count).map(|k| mean(first + k as f64 * ts)).collect())
    }

    /// The trace at a time, on straight lines between its samples.
    fn at(&self, time: f64) -> f64 {
        let place = ((time - self.start) / self.step).max(0.0).min((self.values.len() - 1) as f64);
        let k = (place as usize).min(self.values.len() - 2);
        self.values[k] + (place - k as f64) * (self.values[k + 1] - self.values[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(step: f64, frequency: f64) -> Trace {
        let values = (0..4000).map(|k| libm::sin(std::f64::consts::TAU * frequency * (k as f64 * step - 0.01)));
        Trace { start: -0.01, step, values: values.collect() }
    }

    #[test]
    fn a_sine_keeps_its_phase_and_loses_what_the_mean_takes() {
        let (ts, frequency) = (1e-3, 125.0);
        for step in [1e-4, 1.3e-5] {
            let y = sine(step, frequency).every(ts, 0.0, 30).unwrap();
            let x = 0.25 * ts * frequency * std::f64::consts::PI;
            let expected = |k: usize| libm::sin(std::f64::consts::TAU * frequency * ts * k as f64) * libm::sin(x) / x;
            let error = y.iter().enumerate().map(|(k, y)| (y - expected(k)).abs()).fold(0.0, f64::max);
            assert!(error < 2e-3, "{step}: {error}");
        }
    }

    #[test]
    fn a_line_is_exact_and_too_few_samples_are_refused() {
        let line = Trace { start: -0.1, step: 0.03, values: (0..50).map(f64::from).collect() };
        let y = line.every(0.1, 0.05, 5).unwrap();
        assert!(y.iter().enumerate().all(|(k, y)| (y - (0.15 + 0.1 * k as f64) / 0.03).abs() < 1e-9), "{y:?}");
        let message = line.every(0.05, 0.0, 5).unwrap_err().to_string();
        assert!(message.contains("the memory of the oscilloscope holds two for each"), "{message}");
        let message = line.every(0.1, 0.0, 50).unwrap_err().to_string();
        assert!(message.contains("recorded -0.100000 to 1.370000 s after its trigger"), "{message}");
    }
}
