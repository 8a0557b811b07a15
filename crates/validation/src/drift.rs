//! The linear trend of the error of a record: a drift of its sensor or of its temperature, which is not the model's.

/// Share of the rms error about its mean, and of all of it, from which a drift is named.
const NAMED: [f64; 2] = [0.5, 0.25];

/// A drift goes on: over the whole record and over either half of it, the slope that the free run does not explain lies
/// between these shares of the slope of the line. Creep that the model lacks slows down more.
const STEADY_SLOPE_RATIO: std::ops::RangeInclusive<f64> = 0.6..=1.6;

/// Fastest drift that is named, over the peak-to-peak of the free run [1 / s]. Sensors and temperatures drift more
/// slowly.
const MAX_DRIFT_RATE: f64 = 0.01;

/// The straight line through the error of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Drift {
    /// Mean error.
    pub mean: f64,
    /// Slope per sample.
    pub(super) slope: f64,
    /// Rms of the line about its mean.
    pub(super) rms: f64,
    /// True if the line makes much of the error, in both halves of the record.
    pub(super) is_named: bool,
}

impl Drift {
    /// Of the errors of a free run, with sampling period `ts` [s].
    pub(crate) fn of(errors: &[f64], simulated: &[f64], ts: f64) -> Self {
        let mut sums = DriftSums::new(errors.len());
        errors.iter().zip(simulated).for_each(|(e, s)| sums.add(*e, *s));
        sums.drift(ts)
    }
}

/// The sums of the errors of a free run of which a [`Drift`] is made, sample by sample.
#[derive(Debug)]
pub(super) struct DriftSums {
    /// Number of samples in all, and so far.
    n: usize,
    taken: usize,
    /// Of the whole record and of both halves.
    parts: [Sums; 3],
    /// The smallest and the largest simulated sample.
    pub(super) ends: (f64, f64),
}

/// Sums of time t, simulated output s, error e, and their products.
#[derive(Debug, Default)]
struct Sums {
    n: f64,
    t: f64,
    s: f64,
    e: f64,
    tt: f64,
    ts: f64,
    ss: f64,
    te: f64,
    se: f64,
    ee: f64,
}

impl DriftSums {
    /// For so many samples.
    pub(super) fn new(n: usize) -> Self {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        DriftSums { n, taken: 0, parts: Default::default(), ends }
    }

    pub(super) fn add(&mut self, e: f64, s: f64) {
        let t = self.taken as f64 - 0.5 * (self.n as f64 - 1.0);
        let [whole, halves @ ..] = &mut self.parts;
        whole.add(t, s, e);
        halves[usize::from(self.taken >= self.n / 2)].add(t, s, e);
        self.ends = (self.ends.0.min(s), self.ends.1.max(s));
        self.taken += 1;
    }

    pub(super) fn mean_simulated(&self) -> f64 {
        self.parts[0].s / self.parts[0].n
    }

    /// The drift, with sampling period `ts` [s].
    pub(super) fn drift(&self, ts: f64) -> Drift {
        let [Sums { n, e, tt, te, ee, .. }, _, _] = self.parts;
        let slope = te / tt.max(1.0);
        let rms = slope.abs() * ((n * n - 1.0) / 12.0).sqrt();
        let (mean, square) = (e / n, ee / n);
        let is_named = self.is_named(slope, rms, (square - mean * mean).max(0.0), square, ts);
        Drift { mean, slope, rms, is_named }
    }

    /// The drift once the mean error, and perhaps a line, are removed.
    pub(super) fn remaining(&self, line: bool, ts: f64) -> Drift {
        let found = self.drift(ts);
        let square = (self.parts[0].ee / self.parts[0].n - found.mean * found.mean).max(0.0);
        match line {
            true => Drift { mean: 0.0, slope: 0.0, rms: 0.0, is_named: false },
            false => Drift { mean: 0.0, is_named: self.is_named(found.slope, found.rms, square, square, ts), ..found },
        }
    }

    /// True if a line of this slope and rms is named, beside errors of this variance and mean square.
    fn is_named(&self, slope: f64, rms: f64, variance: f64, square: f64, ts: f64) -> bool {
        let large = rms > NAMED[0] * variance.sqrt() && rms > NAMED[1] * square.sqrt();
        let is_slow = slope.abs() < MAX_DRIFT_RATE * (self.ends.1 - self.ends.0) * ts;
        large && is_slow && self.parts.iter().all(|part| STEADY_SLOPE_RATIO.contains(&(part.beside() / slope)))
    }
}

impl Sums {
    fn add(&mut self, t: f64, s: f64, e: f64) {
        self.n += 1.0;
        (self.t, self.s, self.e) = (self.t + t, self.s + s, self.e + e);
        (self.tt, self.ts, self.ss) = (self.tt + t * t, self.ts + t * s, self.ss + s * s);
        (self.te, self.se, self.ee) = (self.te + t * e, self.se + s * e, self.ee + e * e);
    }

    /// The coefficient of `t` in the regression of `e` on a constant, `t` and `s`. A slow input under a wrong gain
    /// looks like a drift.
    fn beside(&self) -> f64 {
        let product = |sum: f64, a: f64, b: f64| sum - self.n * (a / self.n) * (b / self.n);
        let Sums { t, s, e, .. } = *self;
        let (tt, ts, ss) = (product(self.tt, t, t), product(self.ts, t, s), product(self.ss, s, s));
        let (te, se) = (product(self.te, t, e), product(self.se, s, e));
        let determinant = tt * ss - ts * ts;
        // Without a response, the error alone has the slope.
        if determinant > 1e-9 * tt * ss { (te * ss - ts * se) / determinant } else { te / tt }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::{assert_close, noise};

    const TS: f64 = 1e-3;
    const N: usize = 4000;

    fn of(error: impl Fn(f64) -> f64, run: impl Fn(f64) -> f64) -> Drift {
        let errors: Vec<f64> = noise(1, N).iter().enumerate().map(|(t, e)| error(t as f64 * TS) + 0.002 * e).collect();
        Drift::of(&errors, &(0..N).map(|t| run(t as f64 * TS)).collect::<Vec<_>>(), TS)
    }

    fn sine(t: f64) -> f64 {
        10.0 * (18.0 * t).sin()
    }

    #[test]
    fn the_line_through_an_error_is_found_and_named_if_it_makes_half_of_it() {
        let drift = of(|t| 0.5 + 0.04 * t, sine);
        assert_close(&[drift.slope / TS, drift.rms], &[0.04, 0.04 * 4.0 / 12f64.sqrt()], 0.01, 0.0);
        assert_close(&[drift.mean], &[0.58], 0.01, 0.0);
        assert!(!drift.is_named, "the offset is larger");
        assert!(of(|t| 0.04 * (t - 2.0), sine).is_named);
        assert!(!of(|t| 0.04 * (t - 2.0) + 0.02 * sine(t), sine).is_named, "the error of the gain is larger");
    }

    #[test]
    fn the_slope_beside_a_response_is_that_of_the_regression() {
        let mut sums = Sums::default();
        let (mut alone, run) = (Sums::default(), noise(2, 50));
        for (t, s) in run.iter().enumerate() {
            let t = t as f64 - 10.0;
            sums.add(t, *s, 2.0 + 0.3 * t + 0.7 * s);
            alone.add(t, 5.0, 2.0 + 0.3 * t);
        }
        assert_close(&[sums.beside(), alone.beside()], &[0.3, 0.3], 1e-9, 0.0);
    }

    #[test]
    fn of_errors_without_their_mean_or_line_a_drift_remains_or_not() {
        let mut sums = DriftSums::new(N);
        (0..N).map(|t| t as f64 * TS).for_each(|t| sums.add(0.5 + 0.04 * t, sine(t)));
        let (with_mean, without) = (sums.remaining(false, TS), sums.remaining(true, TS));
        assert!(!sums.drift(TS).is_named && with_mean.is_named, "{with_mean:?}");
        assert_eq!((with_mean.mean, with_mean.slope), (0.0, sums.drift(TS).slope));
        assert_eq!(without, Drift { mean: 0.0, slope: 0.0, rms: 0.0, is_named: false });
        assert_close(
            &[sums.mean_simulated()],
            &[(0..N).map(|t| sine(t as f64 * TS)).sum::<f64>() / N as f64],
            1e-9,
            0.0,
        );
    }

    #[test]
    fn a_wrong_gain_missing_creep_and_what_is_too_fast_for_a_sensor_are_not_named_drift() {
        let scan = |t: f64| 10.0 * t + sine(t);
        assert!(!of(|t| 0.01 * (scan(t) - 20.0), scan).is_named, "the gain of a slow scan");
        assert!(!of(|t| 0.1 * ((t + 0.05).ln() - 0.4), sine).is_named, "creep");
        assert!(!of(|t| 0.3 * (t - 2.0), sine).is_named, "1.5 % of stroke per second");
    }
}
