//! The noise floor: the error that no model can undercut, and what a better model could gain.
//!
//! With three or more periods of the input it is the scatter of the error of the free run between them,
//!
//! ```text
//! sigma^2 = sum over periods k and phases j of (e_kj - drift_kj - mean over k)^2 / (p (K - 1))
//! ```
//! with p samples in each of K periods, and the drift a line between the means of consecutive periods. Effects that
//! repeat with the input (hum locked to it, a systematic sensor error) are not noise here. With any other input it is
//! the noise in the part of the spectrum that is not driven (`undriven.rs`).
//!
//! The noise is at least the rounding of y, its step / sqrt(12), and at most the error without its linear drift. Noise
//! and the rest of the error are uncorrelated: error^2 = noise^2 + drift^2 + what a better model could gain^2.
//!
//! Reference: Pintelon & Schoukens 2012, System Identification: A Frequency Domain Approach, doi:10.1002/9781118287422.

use super::drift::Drift;
use super::undriven::Noise;
use super::{ComparedRun, Metrics};
use piezoid_numerics::number::{join, round};
use piezoid_numerics::series::{mean, range};
use serde::Serialize;

/// Minimum number of samples per period.
const MIN_PERIOD_SAMPLES: usize = 8;

/// Smaller differences of y, relative to its range, are rounding errors and not the step of a converter.
const ROUNDING_SHARE: f64 = 1e-9;

/// Error over noise up to which what a better model could gain is not distinguished from the uncertainty of the noise.
const MIN_REDUCIBLE_RATIO: f64 = 0.3;

/// Share of an error up to which its drift is not named beside others without drift.
const MIN_DRIFT_SHARE: f64 = 0.1;

/// The noise floor of a record.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Floor {
    /// Its origin: `periods` of the input, or the `spectrum`; for several records together also `both`.
    pub source: &'static str,
    /// Period of the input [samples].
    pub period: Option<usize>,
    /// Number of periods compared.
    pub periods: Option<usize>,
    /// Frequency of the mains, if hum is part of the noise [Hz].
    pub hum_hz: Option<f64>,
    /// Standard deviation of the noise [output unit].
    pub rms: f64,
    /// 100 rms / peak-to-peak of y.
    pub rms_pp_percent: f64,
    /// 100 rms / standard deviation of y.
    pub nrmse_percent: f64,
    /// Rms error of the model / rms.
    pub error_over_floor: f64,
    /// Error that a better model could avoid: 100 times its rms / standard deviation of y. It is the error without
    /// noise and without a drift of which the remarks speak.
    pub reducible_nrmse_percent: f64,
}

impl Floor {
    /// The noise floor of a record whose input may have a period [samples], of a model's free run with these errors;
    /// `None` if it is unknown.
    pub(crate) fn of(
        run: &ComparedRun,
        period: Option<usize>,
        errors: &[f64],
        metrics: &Metrics,
        drift: &Drift,
    ) -> Option<Self> {
        Floor::above(&SectionNoise::of(run, period, errors)?, metrics, drift)
    }

    /// The noise floor of a record with this noise; `None` if it is 0.
    pub(super) fn above(noise: &SectionNoise, metrics: &Metrics, drift: &Drift) -> Option<Self> {
        let SectionNoise { period, periods, hum_hz, source, .. } = *noise;
        let scatter = (metrics.mse - drift.mean.powi(2) - drift.rms.powi(2)).max(0.0).sqrt();
        let rms = noise.rms.max(noise.step / 12f64.sqrt()).min(scatter);
        let named = if drift.is_named { drift.rms } else { 0.0 };
        let reducible = (metrics.mse - named.powi(2) - rms.powi(2)).max(0.0).sqrt();
        let floor = Floor::new(source, rms, reducible, metrics);
        (rms > 0.0).then_some(Floor { period, periods, hum_hz, ..floor })
    }

    /// The noise floor of all records together, with their total figures; `None` if that of one is unknown.
    pub fn total(records: &[(Metrics, Option<Floor>)], total: &Metrics) -> Option<Self> {
        let known: Vec<(Metrics, Floor)> = records.iter().map(|(m, f)| Some((*m, (*f)?))).collect::<Option<_>>()?;
        let (_, first) = known.first()?;
        let pooled = |of: &dyn Fn(&Metrics, &Floor) -> f64| {
            (known.iter().map(|(m, f)| m.n as f64 * of(m, f).powi(2)).sum::<f64>() / total.n as f64).sqrt()
        };
        let source = if known.iter().all(|(_, f)| f.source == first.source) { first.source } else { "both" };
        let reducible = pooled(&|m, f| f.reducible_nrmse_percent * m.std / 100.0);
        let hum_hz = known.iter().find_map(|(_, f)| f.hum_hz);
        Some(Floor { hum_hz, ..Floor::new(source, pooled(&|_, f| f.rms), reducible, total) })
    }

    fn new(source: &'static str, rms: f64, reducible: f64, metrics: &Metrics) -> Self {
        Floor {
            source,
            period: None,
            periods: None,
            hum_hz: None,
            rms,
            rms_pp_percent: 100.0 * rms / metrics.peak_to_peak,
            nrmse_percent: 100.0 * rms / metrics.std,
            error_over_floor: metrics.rmse / rms,
            reducible_nrmse_percent: 100.0 * reducible / metrics.std,
        }
    }
}

/// The noise of a record, or of sections of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct SectionNoise {
    source: &'static str,
    period: Option<usize>,
    periods: Option<usize>,
    hum_hz: Option<f64>,
    /// Number of samples.
    n: usize,
    /// Standard deviation of the noise [output unit].
    rms: f64,
    /// Step of the output [output unit].
    step: f64,
}

impl SectionNoise {
    /// The noise of a record whose input may have a period [samples], of a free run with these errors; `None` if it is
    /// unknown.
    pub(super) fn of(run: &ComparedRun, period: Option<usize>, errors: &[f64]) -> Option<Self> {
        let record = run.record;
        // The free run takes most of a transient away, but two periods would still contain it.
        let repeated = period.and_then(|p| Repeated::of(record.u(), errors, p)).filter(|r| record.len() / r.period > 2);
        let (rms, hum_hz) = match &repeated {
            Some(r) => (r.noise, None),
            None => Noise::of(record, errors, run.simulated).map(|n| (n.rms, n.hum_hz))?,
        };
        let source = if repeated.is_some() { "periods" } else { "spectrum" };
        let (period, periods) = (repeated.as_ref().map(|r| r.period), repeated.map(|r| r.periods));
        Some(SectionNoise { source, period, periods, hum_hz, n: record.len(), rms, step: step(record.y()) })
    }

    /// The noise of both together: mean squares are averaged over samples.
    pub(super) fn and(self, next: Self) -> Self {
        let (a, b) = (self.n as f64, next.n as f64);
        let is_same = self.period == next.period;
        SectionNoise {
            source: if self.source == next.source { self.source } else { "both" },
            period: self.period.filter(|_| is_same),
            periods: self.periods.zip(next.periods).map(|(a, b)| a + b).filter(|_| is_same),
            hum_hz: self.hum_hz.or(next.hum_hz),
            n: self.n + next.n,
            rms: ((a * self.rms.powi(2) + b * next.rms.powi(2)) / (a + b)).sqrt(),
            step: if self.step > 0.0 && next.step > 0.0 { self.step.min(next.step) } else { self.step.max(next.step) },
        }
    }
}

/// The parts of an error in words: drift, noise, and what a better model could gain. `drift` is the part of a drift,
/// if it is named [%]; `None` if the relative error is undefined.
pub fn summary(metrics: &Metrics, floor: Option<&Floor>, drift: Option<f64>) -> Option<String> {
    let percent = |x: f64| format!("{} %", rough(x));
    let all = Some(metrics.nrmse_percent).filter(|all| all.is_finite())?;
    if all == 0.0 {
        return Some("0 % NRMSE: the model reproduces every sample".into());
    }
    let Some(floor) = floor else {
        let part = drift.map_or(String::new(), |drift| format!(", of which drift {}", percent(drift)));
        let unknown = "how much of it is noise is unknown: a record is too short, or its input drives all frequencies";
        return Some(format!("{} NRMSE{part}; {unknown}", percent(all)));
    };
    let (noise, reducible) = (floor.nrmse_percent, floor.reducible_nrmse_percent);
    let drift = (all.powi(2) - noise.powi(2) - reducible.powi(2)).max(0.0).sqrt();
    let drift = (drift > MIN_DRIFT_SHARE * all).then(|| format!("drift {}", percent(drift)));
    let hum = floor.hum_hz.map_or(String::new(), |hz| format!(" (with hum at {} Hz)", round(hz)));
    let parts: Vec<String> = drift.into_iter().chain([format!("noise {}{hum}", percent(noise))]).collect();
    let besides = if parts.len() > 1 { "besides the drift, " } else { "" };
    let left = match reducible > MIN_REDUCIBLE_RATIO * noise {
        true => format!("{besides}a better model could gain up to {}", percent(reducible)),
        false => format!("{besides}no model could be clearly better"),
    };
    Some(format!("{} NRMSE, of which {}: {left}", percent(all), join(&parts)))
}

/// A number with two digits.
pub fn rough(x: f64) -> String {
    round(format!("{x:.1e}").parse().unwrap_or(x))
}

/// The smallest difference between two values of `y`: the step of a converter, or next to nothing.
fn step(y: &[f64]) -> f64 {
    let mut sorted = y.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let rounding = ROUNDING_SHARE * range(y);
    let differences = sorted.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > rounding);
    let smallest = differences.fold(f64::INFINITY, f64::min);
    if smallest.is_finite() { smallest } else { 0.0 }
}

/// The mean period of a record with periodic input.
#[derive(Debug)]
pub(super) struct Repeated {
    /// Samples in a period.
    pub(super) period: usize,
    /// Number of periods compared.
    pub(super) periods: usize,
    /// The last period of the input.
    pub(super) u: Vec<f64>,
    /// The mean period of the output without drift.
    pub(super) y: Vec<f64>,
    /// Standard deviation about the mean period [output unit].
    pub(super) noise: f64,
}

impl Repeated {
    /// From the last complete periods of so many samples; with three or more, without the first, which may contain a
    /// transient.
    pub(crate) fn of(u: &[f64], y: &[f64], period: usize) -> Option<Self> {
        let p = Some(period).filter(|p| *p >= MIN_PERIOD_SAMPLES)?;
        let all = u.len() / p;
        let periods = if all >= 3 { all - 1 } else { all };
        let part = &y[u.len() - periods * p..];
        let means: Vec<f64> = part.chunks_exact(p).map(mean).collect();
        let drift = |t: usize| {
            let at = (t as f64 + 0.5) / p as f64 - 0.5;
            let k = (at.max(0.0) as usize).min(periods - 2);
            means[k] + (means[k + 1] - means[k]) * (at - k as f64)
        };
        let level: Vec<f64> = part.iter().enumerate().map(|(t, y)| y - drift(t)).collect();
        let phase = |j: usize| level[j..].iter().step_by(p);
        let y: Vec<f64> = (0..p).map(|j| phase(j).sum::<f64>() / periods as f64).collect();
        let squares: f64 = (0..p).map(|j| phase(j).map(|v| (v - y[j]).powi(2)).sum::<f64>()).sum();
        let noise = (squares / (p * (periods - 1)) as f64).sqrt();
        Some(Repeated { period: p, periods, u: u[u.len() - p..].to_vec(), y, noise })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_records::excitation::{Prbs, RisingSine, Sine};
    use piezoid_records::record::Record;
    use piezoid_records::waveform::period;
    use piezoid_testing::assert_close;
    use piezoid_twins::{Plant, Preset};

    const TS: f64 = 5e-4;

    /// The floor of a record for a model with these outputs.
    fn floor(u: Vec<f64>, y: Vec<f64>, simulated: &[f64]) -> Option<Floor> {
        let errors: Vec<f64> = y.iter().zip(simulated).map(|(y, s)| y - s).collect();
        let metrics = Metrics::of(&y, simulated);
        let drift = Drift::of(&errors, simulated, TS);
        let record = Record::new(TS, u, y).unwrap();
        Floor::of(&ComparedRun { record: &record, simulated }, period(record.u()), &errors, &metrics, &drift)
    }

    #[test]
    fn the_noise_floor_of_a_twin_is_its_sensor_noise_with_or_without_periods_and_drift() {
        let spec = Preset::find("pl140").unwrap().spec();
        let sine = Sine { amplitude: 28.0, frequency: 5.0, ..Sine::default() }.samples(TS, 8000).unwrap();
        let periodic = Prbs { order: 9, ..Prbs::default() }.samples(TS, 511 * 5).unwrap();
        let once = Prbs { order: 12, ..Prbs::default() }.samples(TS, 4095).unwrap();
        let rising = RisingSine { amplitude: 28.0, frequency: 5.0, ..RisingSine::default() }.samples(TS, 8000).unwrap();
        for (u, source) in [(sine, "periods"), (periodic, "periods"), (once, "spectrum"), (rising, "spectrum")] {
            let y = Plant::new(&spec, TS).unwrap().run(&u).y;
            let mut quiet = spec.clone();
            quiet.sensor.noise_rms_m = 0.0;
            // A model with a wrong gain, and an offset.
            let model: Vec<f64> = Plant::new(&quiet, TS).unwrap().run(&u).y.iter().map(|y| 1.03 * y + 10.0).collect();
            let drifting: Vec<f64> = y.iter().enumerate().map(|(t, y)| y + 3e-3 * t as f64).collect();
            for y in [y, drifting] {
                let floor = floor(u.clone(), y, &model).unwrap();
                assert_eq!(floor.source, source);
                assert_close(&[floor.rms], &[1e6 * spec.sensor.noise_rms_m], 0.12, 0.0);
            }
        }
    }

    #[test]
    fn the_parts_of_an_error_add_up_and_are_told() {
        let u = RisingSine { amplitude: 28.0, frequency: 5.0, ..RisingSine::default() }.samples(TS, 8000).unwrap();
        let noise = piezoid_testing::noise(1, 8000);
        let y: Vec<f64> = u.iter().zip(&noise).map(|(u, e)| 3.0 * u + 0.03 * e).collect();
        let short_of: Vec<f64> = u.iter().map(|u| 2.99 * u).collect();
        let metrics = Metrics::of(&y, &short_of);
        let found = floor(u.clone(), y.clone(), &short_of).unwrap();
        let whole = found.nrmse_percent.hypot(found.reducible_nrmse_percent);
        assert_close(&[whole, found.error_over_floor * found.rms], &[metrics.nrmse_percent, metrics.rmse], 1e-9, 0.0);
        assert_close(&[found.rms], &[0.03], 0.05, 0.0);
        let sentence = summary(&metrics, Some(&found), None).unwrap();
        assert_eq!(sentence, "0.34 % NRMSE, of which noise 0.088 %: a better model could gain up to 0.33 %");
        let hum = Floor { hum_hz: Some(50.0), ..found };
        assert!(summary(&metrics, Some(&hum), None).unwrap().contains("noise 0.088 % (with hum at 50 Hz): "));
        let drifting = Floor { reducible_nrmse_percent: 0.2, ..found };
        let sentence = summary(&metrics, Some(&drifting), None).unwrap();
        assert!(
            sentence
                .ends_with("drift 0.27 % and noise 0.088 %: besides the drift, a better model could gain up to 0.2 %")
        );
        let true_model: Vec<f64> = u.iter().map(|u| 3.0 * u).collect();
        let (metrics, found) = (Metrics::of(&y, &true_model), floor(u, y, &true_model).unwrap());
        assert!(summary(&metrics, Some(&found), None).unwrap().ends_with("no model could be clearly better"));
        let unknown = summary(&metrics, None, Some(0.5)).unwrap();
        assert!(
            unknown.starts_with("0.083 % NRMSE, of which drift 0.5 %; how much of it is noise is unknown"),
            "{unknown}"
        );
    }

    #[test]
    fn all_records_together_have_the_noise_of_all_unless_that_of_one_is_unknown() {
        let m = Metrics { n: 100, mse: 4.0, rmse: 2.0, ..Metrics::of(&[0.0, 20.0], &[0.0, 20.0]) };
        let (one, other) = (Floor::new("periods", 1.0, 3f64.sqrt(), &m), Floor::new("spectrum", 1.5, 0.5, &m));
        let (longer, total) = (Metrics { n: 300, ..m }, Metrics { n: 400, ..m });
        let both = Floor::total(&[(m, Some(one)), (longer, Some(other))], &total).unwrap();
        assert_eq!(both.source, "both");
        // A record counts by its samples: (1 + 3 x 2.25) / 4, and (3 + 3 x 0.25) / 4.
        let expected = [1.9375f64.sqrt(), 10.0 * 0.9375f64.sqrt()];
        assert_close(&[both.rms, both.reducible_nrmse_percent], &expected, 1e-9, 0.0);
        assert_eq!(Floor::total(&[(m, Some(one)), (m, None)], &total), None);
    }

    #[test]
    fn sections_count_by_their_samples() {
        let (source, period, periods) = ("periods", Some(9), Some(3));
        let one = SectionNoise { source, period, periods, hum_hz: None, n: 100, rms: 1.0, step: 0.0 };
        let both = one.and(SectionNoise { n: 300, rms: 2.0, hum_hz: Some(50.0), ..one });
        assert_close(&[both.rms], &[3.25f64.sqrt()], 1e-12, 0.0);
        assert_eq!((both.n, both.period, both.periods, both.hum_hz), (400, Some(9), Some(6), Some(50.0)));
    }

    #[test]
    fn the_noise_of_few_periods_is_not_too_small_by_what_their_mean_takes() {
        let u: Vec<f64> = (0..8000).map(|t| (0.001 * std::f64::consts::PI * f64::from(t)).sin()).collect();
        let y: Vec<f64> = u.iter().zip(piezoid_testing::noise(3, 8000)).map(|(u, e)| u + 0.1 * e).collect();
        let repeated = Repeated::of(&u, &y, 2000).unwrap();
        assert_eq!((repeated.periods, repeated.y.len()), (3, 2000));
        assert_close(&[repeated.noise], &[0.1], 0.05, 0.0);
    }

    #[test]
    fn the_noise_is_at_least_the_rounding_of_the_output() {
        // A slow output crosses a step once in 20 samples: its rounding is not white.
        let u: Vec<f64> =
            (0..4000).map(|t| (0.001 * f64::from(t)).sin() + 0.3 * (0.00037 * f64::from(t)).sin()).collect();
        let y: Vec<f64> = u.iter().map(|u| (u / 0.02).round() * 0.02).collect();
        let model: Vec<f64> = u.iter().map(|u| 0.9 * u).collect();
        assert_close(&[floor(u, y, &model).unwrap().rms], &[0.02 / 12f64.sqrt()], 0.2, 0.0);
    }

    #[test]
    fn two_periods_are_not_compared_because_the_first_contains_the_transient() {
        let u = Prbs { order: 9, ..Prbs::default() }.samples(TS, 1022).unwrap();
        let noise = piezoid_testing::noise(1, 1022);
        let y = u.iter().zip(&noise).enumerate().map(|(t, (u, e))| u + (-0.02 * t as f64).exp() + 0.01 * e).collect();
        let floor = floor(u.clone(), y, &u).unwrap();
        assert_eq!((floor.source, floor.period), ("spectrum", None));
        assert_close(&[floor.rms], &[0.01], 0.2, 0.0);
    }

    #[test]
    fn the_mean_period_and_the_scatter_about_it_are_without_drift() {
        let pattern = [3.0, -1.0, 4.0, 1.0, -5.0, -2.0, 6.0, -6.0];
        let u: Vec<f64> = (0..35).map(f64::from).collect();
        // Three samples and four periods, on a line.
        let mut y: Vec<f64> = (0..35).map(|t| pattern[(t + 5) % 8] + 0.25 * t as f64 + 7.0).collect();
        let two = Repeated::of(&u[..19], &y[..19], 8).unwrap();
        assert_eq!((two.period, two.periods, &two.u[..]), (8, 2, &u[11..19]));
        assert_close(&two.y, &pattern, 1e-12, 1e-12);
        assert_close(&[two.noise], &[0.0], 0.0, 1e-12);
        // A transient in the first period, and errors whose mean is zero in each period and each phase.
        y[5] += 100.0;
        for (t, error) in [(13, 0.6), (16, -0.6), (29, -0.6), (32, 0.6)] {
            y[t] += error;
        }
        let four = Repeated::of(&u, &y, 8).unwrap();
        assert_eq!((four.period, four.periods, &four.u[..]), (8, 3, &u[27..]));
        assert_close(&four.y, &pattern, 1e-12, 1e-12);
        // The root of 4 x 0.36 over 8 samples and 3 - 1 periods.
        assert_close(&[four.noise], &[0.3], 1e-12, 0.0);
        assert!(Repeated::of(&u, &y, 7).is_none());
    }

    #[test]
    fn the_step_of_an_output_is_its_smallest_difference_beyond_rounding() {
        assert_eq!(step(&[1.0, 0.0, 1.5, 1.0, 0.5, 1.5 + 1e-12]), 0.5);
        assert_eq!(step(&[2.0; 3]), 0.0);
    }

    #[test]
    fn sections_of_unlike_noise_have_both_sources_no_period_and_the_smaller_step() {
        let one = SectionNoise {
            source: "periods",
            period: Some(9),
            periods: Some(3),
            hum_hz: None,
            n: 1,
            rms: 1.0,
            step: 0.2,
        };
        let other = SectionNoise { source: "spectrum", period: None, periods: None, step: 0.1, ..one };
        let both = one.and(other);
        assert_eq!((both.source, both.period, both.periods, both.step), ("both", None, None, 0.1));
        let still = SectionNoise { step: 0.0, ..one };
        assert_eq!([one.and(still).step, still.and(one).step], [0.2; 2]);
        let faster = one.and(SectionNoise { period: Some(8), ..one });
        assert_eq!((faster.source, faster.period, faster.periods), ("periods", None, None));
    }

    #[test]
    fn small_parts_of_an_error_are_not_named() {
        let m = Metrics::of(&[0.0, 20.0], &[0.0, 20.0]);
        let text = |drift: f64, reducible: f64| {
            let floor = Floor {
                reducible_nrmse_percent: reducible,
                nrmse_percent: 1.0,
                ..Floor::new("spectrum", 1.0, 0.0, &m)
            };
            let all = (1.0 + drift * drift + reducible * reducible).sqrt();
            summary(&Metrics { nrmse_percent: all, ..m }, Some(&floor), None).unwrap()
        };
        assert_eq!(text(0.0, 0.29), "1 % NRMSE, of which noise 1 %: no model could be clearly better");
        assert_eq!(text(0.0, 0.31), "1 % NRMSE, of which noise 1 %: a better model could gain up to 0.31 %");
        assert_eq!(text(0.09, 0.0), "1 % NRMSE, of which noise 1 %: no model could be clearly better");
        let drifts =
            "1 % NRMSE, of which drift 0.12 % and noise 1 %: besides the drift, no model could be clearly better";
        assert_eq!(text(0.12, 0.0), drifts);
        assert_eq!(summary(&m, None, None).as_deref(), Some("0 % NRMSE: the model reproduces every sample"));
        assert_eq!(summary(&Metrics { nrmse_percent: f64::NAN, ..m }, None, None), None);
    }
}
