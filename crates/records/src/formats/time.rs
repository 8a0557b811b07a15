//! The sampling period from time stamps.
//!
//! ```text
//! steps        d[k] = t[k] - t[k-1], every one within 1 % of their median
//! Ts           (t[n-1] - t[0]) / (n - 1), or the decimal number that the stamps mean by it
//! ```
//! Stamps are decimal numbers that are read as binary ones: multiples of 0.0005 give a quotient of
//! 5.000000000000001e-4. The period is the shortest decimal number that fits the stamps as well as the quotient does.
//! Nothing is resampled here.

use libm::{log10, pow};
use piezoid_numerics::error::Error;
use piezoid_numerics::series::quantile;
use serde_json::Value;

/// Allowed deviation from the median step, relative to it.
const UNEVEN: f64 = 0.01;
/// Longest step that may be bridged by interpolation, in median steps.
pub(super) const GAP: f64 = 10.0;
/// Relative difference of sampling periods that is rounding, as of a period beside its rate.
const AGREED: f64 = 1e-3;

/// The sampling period of the stamps `t`, in their unit; `line` is the line of a row.
pub(super) fn period(t: &[f64], name: &str, line: &dyn Fn(usize) -> u64) -> Result<f64, Error> {
    let refused = |row: usize, (problem, ts): (String, Option<Value>)| {
        let error = Error::Line { line: line(row), column: Some(name.to_owned()), problem };
        Err(if let Some(ts) = ts { error.advised(vec![("ts", ts)]) } else { error })
    };
    if t.len() < 2 {
        return refused(0, ("one row is not enough to find the sampling period: ".into(), Some(Value::Null)));
    }
    if let Some(row) = (1..t.len()).find(|&k| t[k] <= t[k - 1]) {
        return refused(row, not_increasing(t[row - 1], t[row]));
    }
    let steps: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let median = quantile(steps.clone(), 0.5);
    let mean = mean(t);
    match steps.iter().position(|d| off(*d, median)) {
        None => Ok(meant(t, mean)),
        Some(k) => refused(k + 1, uneven(&steps, k, median, mean)),
    }
}

/// The median step of times that increase, however unevenly.
pub(super) fn step(t: &[f64]) -> Option<f64> {
    let steps: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let increases = !steps.is_empty() && steps.iter().all(|step| *step > 0.0);
    increases.then(|| quantile(steps, 0.5))
}

/// The first of these periods, unless another differs by more than rounding.
pub(super) fn agreed(periods: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut periods = periods.into_iter();
    let first = periods.next()?;
    periods.all(|ts| (ts / first - 1.0).abs() < AGREED).then_some(first)
}

/// The mean step.
pub(super) fn mean(t: &[f64]) -> f64 {
    match t {
        [first, .., last] => (last - first) / (t.len() - 1) as f64,
        _ => f64::NAN,
    }
}

/// True if the stamps are those of this period, but for their rounding.
pub(super) fn rounds(t: &[f64], period: f64) -> bool {
    let steps = || t.windows(2).map(|pair| pair[1] - pair[0]);
    let resolution = steps().filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    // Fine stamps deviate by less than half a period; coarse ones by their resolution.
    let allowed = if resolution > 0.9 * period && resolution < 1.5 * period { 0.5 * period } else { 1.01 * resolution };
    let deviates = |(k, stamp): (usize, &f64)| (stamp - t[0] - k as f64 * period).abs() > allowed;
    resolution.is_finite() && steps().all(|step| step >= 0.0) && !t.iter().enumerate().any(deviates)
}

/// A period in a unit of so many seconds, in seconds: the nearest number to the decimal product.
pub(super) fn times(period: f64, seconds: f64) -> f64 {
    let power = log10(seconds).round();
    let tens = power < 0.0 && (pow(10.0, power) / seconds - 1.0).abs() < 1e-9;
    let decimal = || {
        format!("{period:e}")
            .split_once('e')
            .and_then(|(digits, own)| format!("{digits}e{}", own.parse::<i32>().ok()? + power as i32).parse().ok())
    };
    if tens { decimal().unwrap_or(period * seconds) } else { period * seconds }
}

/// The problem of time that stands still (perhaps because of rounding, then `ts` helps) or goes back (then it does
/// not).
fn not_increasing(before: f64, here: f64) -> (String, Option<Value>) {
    if here == before {
        let problem = format!(
            "two rows have the time {here} s, but time must increase: delete the row if it is a duplicate; if the \
             time stamps have too few digits, do without the time column: "
        );
        (problem, Some(Value::Null))
    } else {
        let problem = format!(
            "time goes back from {before} s to {here} s but must increase: if a second record starts here, split the \
             file"
        );
        (problem, None)
    }
}

/// True if a step is uneven.
fn off(step: f64, median: f64) -> bool {
    (step - median).abs() > UNEVEN * median
}

/// The problem of step `k`: missing rows, if few steps are uneven (`ts` would only hide them), or rounded stamps.
fn uneven(steps: &[f64], k: usize, median: f64, mean: f64) -> (String, Option<Value>) {
    let (count, all) = (steps.iter().filter(|d| off(**d, median)).count(), steps.len());
    let [step, usual] = [steps[k], median].map(|step| rounded(step, 6));
    let found = format!(
        "the step to this row is {step} s, not {usual} s (the median) within 1 % (uneven steps: {count} of {all}): "
    );
    let missing = (steps[k] / median).round() - 1.0;
    if missing >= 1.0 && 4 * count <= all {
        let rows = if missing == 1.0 { "1 row seems".into() } else { format!("{missing} rows seem") };
        let bridge = || format!(", or, to bridge the gap by a straight line, {}", resampling(median));
        let bridge = (missing < GAP).then(bridge).unwrap_or_default();
        (found + &format!("{rows} to be missing; cut the record or split the file here{bridge}"), None)
    } else {
        let problem = format!(
            "to interpolate the record evenly, {}; if the samples are evenly spaced and only the time stamps are \
             rounded, ",
            resampling(mean)
        );
        (found + &problem, Some(rounded(mean, 6).into()))
    }
}

/// What makes times with about this step even.
fn resampling(step: f64) -> String {
    format!("use `prepare` with the option resample = {}", rounded(step, 3))
}

/// The period that the stamps represent, from their mean step.
fn meant(t: &[f64], mean: f64) -> f64 {
    if (0..).zip(t).all(|(k, stamp)| is_multiple(*stamp, k, t[1])) {
        return t[1];
    }
    let roughness = (0..).zip(t).map(|(k, stamp)| off_line(*stamp, k, t[0], mean)).fold(0.0, f64::max);
    shortest([t[0], t[t.len() - 1]], t.len() - 1, roughness)
}

/// True if a stamp is a multiple of a period, correctly rounded, as piezoid writes them.
fn is_multiple(stamp: f64, k: usize, ts: f64) -> bool {
    (stamp - k as f64 * ts).abs() <= 2.0 * f64::EPSILON * stamp
}

/// The deviation of a stamp from even steps after the first.
fn off_line(stamp: f64, k: usize, first: f64, mean: f64) -> f64 {
    (stamp - (first + k as f64 * mean)).abs()
}

/// The shortest decimal number that fits the first and the last stamp, which are so many steps apart, as well as their
/// mean step does; the stamps between them deviate from even steps by up to `roughness`.
fn shortest([first, last]: [f64; 2], steps: usize, roughness: f64) -> f64 {
    let mean = (last - first) / steps as f64;
    let rounding = 4.0 * f64::EPSILON * first.abs().max(last.abs());
    let fits = |ts: &f64| (ts - mean).abs() * steps as f64 <= roughness + rounding;
    (1..=15).map(|digits| rounded(mean, digits)).find(fits).unwrap_or(mean)
}

/// What one pass over stamps shows, of which only a few are held.
#[derive(Debug)]
pub(super) struct EvenStamps {
    first: f64,
    second: f64,
    last: f64,
    /// Number of steps.
    steps: usize,
    least: f64,
    most: f64,
    are_multiples: bool,
}

impl EvenStamps {
    /// The first two stamps.
    pub(super) fn new(first: f64, second: f64) -> Self {
        let step = second - first;
        let are_multiples = is_multiple(first, 0, second);
        EvenStamps { first, second, last: second, steps: 1, least: step, most: step, are_multiples }
    }

    /// The next stamp.
    pub(super) fn add(&mut self, stamp: f64) {
        let step = stamp - self.last;
        self.steps += 1;
        (self.least, self.most) = (self.least.min(step), self.most.max(step));
        self.are_multiples &= is_multiple(stamp, self.steps, self.second);
        self.last = stamp;
    }

    /// True if every step certainly is within 1 % of the median, which only held stamps show.
    pub(super) fn are_even(&self) -> bool {
        self.least > 0.0 && self.most - self.least <= UNEVEN * self.least
    }

    /// The period that [`period`] finds; `None` if this needs another pass, which gives the deviations.
    pub(super) fn period(&self) -> Option<f64> {
        self.are_multiples.then_some(self.second)
    }

    /// The same, with the largest deviation of the stamps.
    pub(super) fn period_of(&self, roughness: f64) -> f64 {
        shortest([self.first, self.last], self.steps, roughness)
    }

    /// The deviation of stamp k from even steps.
    pub(super) fn deviation(&self, stamp: f64, k: usize) -> f64 {
        off_line(stamp, k, self.first, (self.last - self.first) / self.steps as f64)
    }
}

/// The nearest number with this many significant digits, at least one.
pub(super) fn rounded(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits - 1).parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn below(row: usize) -> u64 {
        row as u64 + 2
    }

    fn refusal(t: &[f64]) -> String {
        period(t, "t_s", &below).unwrap_err().to_string()
    }

    #[test]
    fn the_period_is_the_decimal_number_that_was_meant() {
        for ts in [5e-4, 0.005, 0.1, 0.3, 1.0, 2.5e-5, 1.0 / 8192.0, 7e-3, 60.0] {
            for start in [0.0, 0.3, 12.345, 1e4] {
                // What a logger prints: rounded to a fixed number of decimals.
                let printed = |k: u32| format!("{:.13}", start + f64::from(k) * ts).parse::<f64>().unwrap();
                let t: Vec<f64> = (0..3001).map(printed).collect();
                assert_eq!(period(&t, "t_s", &below).unwrap(), ts, "start {start}");
            }
        }
    }

    #[test]
    fn a_sum_of_steps_still_means_the_step() {
        let t: Vec<f64> = (0..20_000).scan(0.0, |t, _| Some(std::mem::replace(t, *t + 5e-4))).collect();
        assert_eq!(period(&t, "t_s", &below).unwrap(), 5e-4);
    }

    #[test]
    fn jitter_below_one_percent_does_not_reach_the_period() {
        let t: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.005 + f64::from(k * 7919 % 13 - 6) * 3e-6).collect();
        assert_eq!(period(&t, "t_s", &below).unwrap(), 0.005);
    }

    #[test]
    fn a_clock_that_runs_fast_is_believed() {
        let t: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.005_001_3).collect();
        assert_eq!(period(&t, "t_s", &below).unwrap(), 0.005_001_3);
    }

    #[test]
    fn missing_rows_are_counted_and_not_hidden_by_ts() {
        assert_eq!(
            refusal(&[0.0, 0.005, 0.01, 0.025, 0.03]),
            "line 5, column t_s: the step to this row is 0.015 s, not 0.005 s (the median) within 1 % (uneven steps: 1 \
             of 4): 2 rows seem to be missing; cut the record or split the file here, or, to bridge the gap by a \
             straight line, use `prepare` with the option resample = 0.005"
        );
        assert!(refusal(&[0.0, 0.005, 0.01, 0.02, 0.025]).contains("1 row seems to be missing"));
    }

    #[test]
    fn rough_stamps_are_told_about_ts() {
        assert_eq!(
            refusal(&[0.0, 0.0003, 0.0007, 0.001]),
            "line 4, column t_s: the step to this row is 0.0004 s, not 0.0003 s (the median) within 1 % (uneven steps: 1 of 3): to interpolate the record evenly, use `prepare` with the option resample = 0.000333; if the samples are evenly spaced and only the time stamps are rounded, give `ts` = 0.000333333"
        );
        assert!(refusal(&[0.0, 0.001, 0.003, 0.004, 0.006, 0.007]).ends_with("give `ts` = 0.0014"));
    }

    #[test]
    fn time_that_does_not_increase_is_refused_with_the_fitting_advice() {
        assert_eq!(
            refusal(&[0.0, 0.01, 0.01]),
            "line 4, column t_s: two rows have the time 0.01 s, but time must increase: delete the row if it is a duplicate; if the time stamps have too few digits, do without the time column: give `ts`"
        );
        assert_eq!(
            refusal(&[0.0, 0.01, 0.02, 0.0, 0.01]),
            "line 5, column t_s: time goes back from 0.02 s to 0 s but must increase: if a second record starts here, \
             split the file"
        );
    }

    #[test]
    fn stamps_that_are_rounded_are_not_stamps_with_gaps() {
        let stamps =
            |digits: f64| (0..300).map(|k| (f64::from(k) * 5e-4 * digits).floor() / digits).collect::<Vec<_>>();
        assert!(rounds(&stamps(1e3), 5e-4) && rounds(&stamps(1e4), 5e-4) && !rounds(&stamps(1e4), 6e-4));
        let gap: Vec<f64> = (0..300).map(|k| f64::from(k + i32::from(k > 150)) * 1e-3).collect();
        assert!(!rounds(&gap, 1e-3));
        let mut back = stamps(1e4);
        back.swap(100, 101);
        assert!(!rounds(&back, 5e-4));
    }

    #[test]
    fn one_row_does_not_tell_a_period() {
        assert_eq!(refusal(&[0.0]), "line 2, column t_s: one row is not enough to find the sampling period: give `ts`");
    }

    #[test]
    fn stamps_at_the_ends_of_the_range_do_not_panic() {
        assert!(period(&[-f64::MAX, 0.0, f64::MAX], "t_s", &below).is_ok());
        assert!(period(&[-f64::MAX, f64::MAX], "t_s", &below).is_ok_and(f64::is_infinite));
        assert!(period(&[0.0, 5e-324, 1e-323], "t_s", &below).is_ok());
    }

    #[test]
    fn a_step_that_is_off_by_exactly_one_percent_is_even() {
        assert_eq!([99.0, 101.0, 98.5, 101.5].map(|step| off(step, 100.0)), [false, false, true, true]);
        let are_even = |[first, second, third]: [f64; 3]| {
            let mut stamps = EvenStamps::new(first, second);
            stamps.add(third);
            stamps.are_even()
        };
        assert_eq!([[0.0, 100.0, 201.0], [0.0, 100.0, 202.0], [1.0; 3]].map(are_even), [true, false, false]);
    }

    #[test]
    fn a_gap_of_ten_rows_is_not_bridged() {
        let after = |last: f64| refusal(&[0.0, 1.0, 2.0, 3.0, last]);
        let bridged = "9 rows seem to be missing; cut the record or split the file here, or, to bridge the gap by a \
                       straight line, use `prepare` with the option resample = 1";
        assert!(after(13.0).ends_with(bridged));
        assert!(after(14.0).ends_with("10 rows seem to be missing; cut the record or split the file here"));
    }

    #[test]
    fn coarse_stamps_deviate_by_their_resolution_and_fine_ones_by_half_a_period() {
        for (t, expected) in [
            // Steps of 0.9 to 1.5 periods of 2: by 1 at most.
            (&[0.0, 2.0, 4.8, 6.8][..], true),
            (&[0.0, 2.0, 5.2, 7.2], false),
            (&[10.0, 12.0, 15.0, 17.0], true),
            // Others: by the least step.
            (&[0.0, 1.8, 5.5], true),
            (&[0.0, 2.7, 3.3], false),
            (&[0.0, 0.0, 3.0], true),
            (&[0.0, 0.0, 3.2], true),
            (&[1.0, 1.0], false),
        ] {
            assert_eq!(rounds(t, 2.0), expected, "{t:?}");
        }
    }

    #[test]
    fn a_period_in_another_unit_is_the_nearest_number_to_the_decimal_product() {
        // The products of the numbers are 2.4999999999999998e-6 and 7.000000000000001e-9.
        assert_eq!([times(2.5, 1e-6), times(7.0, 1e-9), times(0.5, 1e-3)], [2.5e-6, 7e-9, 5e-4]);
        assert_eq!([times(2.0, 60.0), times(0.5, 1e3), times(2.0, 0.05), times(3.0, 1.0)], [120.0, 500.0, 0.1, 3.0]);
    }

    #[test]
    fn the_shortest_period_deviates_by_no_more_than_the_stamps() {
        // Without jitter, the first and the last stamp are still rounded.
        assert_eq!(shortest([12.345, 12.645], 3, 0.0), 0.1);
        // 0.3 is off by 0.099 after three steps of 0.333.
        assert_eq!([0.1, 0.05].map(|roughness| shortest([0.0, 0.999], 3, roughness)), [0.3, 0.33]);
        assert!(is_multiple(0.3, 3, 0.1) && !is_multiple(0.3 + 1e-15, 3, 0.1));
    }

    #[test]
    fn a_step_is_that_of_increasing_times_and_periods_agree_but_for_rounding() {
        assert_eq!((step(&[1.0, 3.0, 4.0, 9.0]), mean(&[1.0, 2.0, 6.0])), (Some(2.0), 2.5));
        assert_eq!([step(&[0.0, 1.0, 1.0]), step(&[0.0, 2.0, 1.0]), step(&[1.0]), step(&[])], [None; 4]);
        assert!(mean(&[1.0]).is_nan());
        assert_eq!((agreed([2.0, 2.001, 1.999]), agreed([2.0, 2.0, 2.1]), agreed([])), (Some(2.0), None, None));
    }
}
