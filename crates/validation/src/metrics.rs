//! Error figures of a free run over one or several records.

use piezoid_numerics::series::mean;
use serde::Serialize;

/// Errors of a model on a record, in the record's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Metrics {
    /// Number of samples compared.
    pub n: usize,
    /// Mean squared error [unit^2].
    pub mse: f64,
    /// Root mean squared error [unit].
    pub rmse: f64,
    /// 100 rms error / standard deviation of y.
    pub nrmse_percent: f64,
    /// 100 rms error / peak-to-peak of y.
    pub rms_pp_percent: f64,
    /// Largest absolute error [unit].
    pub max_abs: f64,
    /// 100 - nrmse_percent.
    pub fit_percent: f64,
    /// Standard deviation of y [unit].
    pub std: f64,
    /// Peak-to-peak of y [unit].
    pub peak_to_peak: f64,
}

impl Metrics {
    /// The errors of `simulated` against `y`, of the same length and not empty.
    ///
    /// ```
    /// let m = piezoid::validation::Metrics::of(&[0.0, 2.0], &[0.0, 1.0]);
    /// assert_eq!((m.mse, m.rms_pp_percent, m.max_abs), (0.5, 50.0 * 0.5f64.sqrt(), 1.0));
    /// ```
    pub fn of(y: &[f64], simulated: &[f64]) -> Self {
        let mut sums = ErrorSums::new(mean(y));
        y.iter().zip(simulated).for_each(|(y, s)| sums.add(*y, *s));
        sums.metrics()
    }

    /// All records together. Squared errors and variances are pooled; the variances are about each record's own mean,
    /// because offsets between records would improve the relative errors. Peak-to-peak and largest error are the
    /// maximum of all records.
    pub fn total(records: &[Metrics]) -> Self {
        let n: usize = records.iter().map(|m| m.n).sum();
        let pooled = |f: &dyn Fn(&Metrics) -> f64| records.iter().map(|m| m.n as f64 * f(m)).sum::<f64>() / n as f64;
        let widest = |f: &dyn Fn(&Metrics) -> f64| records.iter().map(f).fold(0.0, larger);
        let (mse, variance) = (pooled(&|m| m.mse), pooled(&|m| m.std.powi(2)));
        Metrics::from_parts(n, mse, variance.sqrt(), widest(&|m| m.peak_to_peak), widest(&|m| m.max_abs))
    }

    fn from_parts(n: usize, mse: f64, std: f64, peak_to_peak: f64, max_abs: f64) -> Self {
        let rmse = mse.sqrt();
        let nrmse_percent = 100.0 * rmse / std;
        Metrics {
            n,
            mse,
            rmse,
            nrmse_percent,
            rms_pp_percent: 100.0 * rmse / peak_to_peak,
            max_abs,
            fit_percent: 100.0 - nrmse_percent,
            std,
            peak_to_peak,
        }
    }
}

/// The sums of which [`Metrics`] are made, sample by sample.
#[derive(Debug)]
pub(super) struct ErrorSums {
    /// Mean of y.
    mean: f64,
    n: usize,
    squares: f64,
    scatter: f64,
    ends: (f64, f64),
    max_abs: f64,
}

impl ErrorSums {
    /// For an output of this mean.
    pub(super) fn new(mean: f64) -> Self {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        ErrorSums { mean, n: 0, squares: 0.0, scatter: 0.0, ends, max_abs: 0.0 }
    }

    pub(super) fn add(&mut self, y: f64, simulated: f64) {
        self.n += 1;
        self.squares += (y - simulated).powi(2);
        self.scatter += (y - self.mean) * (y - self.mean);
        self.ends = (self.ends.0.min(y), self.ends.1.max(y));
        self.max_abs = larger(self.max_abs, (y - simulated).abs());
    }

    pub(super) fn metrics(&self) -> Metrics {
        let n = self.n as f64;
        let (std, height) = ((self.scatter / n).sqrt(), self.ends.1 - self.ends.0);
        Metrics::from_parts(self.n, self.squares / n, std, height, self.max_abs)
    }
}

/// The larger of two, or NaN if one is NaN: an undefined error must not look small.
fn larger(m: f64, e: f64) -> f64 {
    if e > m || e.is_nan() { e } else { m }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::random::config;
    use piezoid_testing::{assert_close, assert_named_close};
    use proptest::prelude::*;

    #[test]
    fn offsets_between_records_do_not_improve_the_total() {
        let y: Vec<f64> = (0..100).map(|t| f64::from(t % 10)).collect();
        let shifted: Vec<f64> = y.iter().map(|y| y + 1000.0).collect();
        let off = |y: &[f64]| y.iter().map(|y| y + 0.5).collect::<Vec<_>>();
        let one = Metrics::of(&y, &off(&y));
        let total = Metrics::total(&[one, Metrics::of(&shifted, &off(&shifted))]);
        assert_close(&[total.nrmse_percent, total.rms_pp_percent], &[one.nrmse_percent, one.rms_pp_percent], 1e-9, 0.0);
        assert_eq!(total.n, 200);
    }

    #[test]
    fn a_record_counts_by_its_samples_in_the_total() {
        let long = Metrics::of(&[0.0, 2.0, 0.0, 2.0, 0.0, 2.0], &[0.0, 2.0, 0.0, 2.0, 0.0, 2.0]);
        let short = Metrics::of(&[0.0, 6.0], &[2.0, 6.0]);
        let total = Metrics::total(&[long, short]);
        assert_close(&[total.mse, total.std], &[0.5, 3f64.sqrt()], 1e-12, 0.0);
        assert_eq!((total.n, total.max_abs, total.peak_to_peak), (8, 2.0, 6.0));
    }

    proptest! {
        #![proptest_config(config(128))]

        #[test]
        fn figures_of_merit_do_not_depend_on_offset_and_unit(
            samples in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 3..60),
            offset in -10.0..10.0f64, k in 1e-6..1e6f64,
        ) {
            let (y, simulated): (Vec<f64>, Vec<f64>) = samples.into_iter().map(|(y, e)| (y, y + 0.1 * e)).unzip();
            let of = |change: &dyn Fn(f64) -> f64| {
                let all = |of: &[f64]| of.iter().map(|v| change(*v)).collect::<Vec<f64>>();
                Metrics::of(&all(&y), &all(&simulated))
            };
            let spread = y.iter().fold(f64::MIN, |m, v| m.max(*v)) - y.iter().fold(f64::MAX, |m, v| m.min(*v));
            prop_assume!(spread > 0.1);
            let plain = of(&|v| v);
            let numbers = |m: &Metrics, unit: f64| {
                let lengths = [m.rmse / unit, m.max_abs / unit, (m.mse / unit).sqrt() / unit.sqrt()];
                [lengths.as_slice(), &[m.nrmse_percent, m.rms_pp_percent, 100.0 - m.fit_percent]].concat()
            };
            assert_named_close("shifted", &numbers(&of(&|v| v + offset), 1.0), &numbers(&plain, 1.0), 1e-9, 1e-12);
            assert_named_close("scaled", &numbers(&of(&|v| -k * v), k), &numbers(&plain, 1.0), 1e-9, 0.0);
            prop_assert!(plain.rmse <= plain.max_abs * (1.0 + 1e-15) && plain.rms_pp_percent <= plain.nrmse_percent);
            prop_assert_eq!(Metrics::of(&y, &y).mse, 0.0);
        }
    }
}
