//! The timing of one run: a requested displacement, and the one that was played or measured.
//!
//! ```text
//! step       the reference moves from a, held, to b, held: begins at k_0, held from there on
//! settling   t_s = (k_s - k_0) T,  k_s the first sample from which |y_k - b| <= tolerance, up to the last tenth of
//!            the hold: there the voltage of the next step may begin
//! overshoot  max over the same samples of (y_k - b) sgn(b - a), 0 or more; also over |b - a|
//! scan lag   the delay d with the least rms of y(t) - r(t - d); what that leaves
//! within     share of the samples with |y_k - r_k| <= tolerance
//! ```
//! Times have the resolution of a sample. A step counts if it is larger than the tolerance and the reference is held
//! for at least [`HELD`] samples after it. It does not filter: noise of a sensor above the tolerance never settles.

use piezoid_records::waveform::period;
use serde::Serialize;

/// Samples for which a reference must be held after a step.
const HELD: usize = 4;

/// The last share of a hold, in which the voltage of the next step may begin, is one in so many.
const TAIL: usize = 10;

/// Change from sample to sample of a held reference, over its height.
const SAME: f64 = 1e-9;

/// Largest number of samples, and of delays, that the search for a lag takes.
const LAG_SAMPLES: usize = 20_000;
const LAGS: usize = 200;

/// Bisections of the interval around the best delay, by the golden ratio.
const REFINEMENTS: usize = 40;

/// Time that does not count at the start of a periodic reference [s].
const SETTLING: f64 = 0.25;

/// The timing of one run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunTiming {
    /// What was played: `model, compensated`, for instance.
    pub name: String,
    /// Share of the samples within the tolerance [%].
    pub within_percent: f64,
    /// The steps of the reference, in their order.
    pub steps: Vec<StepTiming>,
    /// The lag, if the reference is periodic.
    pub scan: Option<ScanLag>,
}

/// The timing of one step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepTiming {
    /// When the reference begins to move [s].
    pub at_s: f64,
    /// Where it comes from [output unit].
    pub from: f64,
    /// Where it goes to [output unit].
    pub to: f64,
    /// How long it moves [s]; 0 for a jump.
    pub move_s: f64,
    /// Time until the error stays within the tolerance [s]; `None` if it does not before the next step.
    pub settling_s: Option<f64>,
    /// Largest error beyond the goal [output unit].
    pub overshoot: f64,
    /// The same, over the height of the step [%].
    pub overshoot_percent: f64,
}

/// The lag of a periodic run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ScanLag {
    /// Period of the reference [s].
    pub period_s: f64,
    /// The delay with the least error [s]; negative if the displacement is ahead.
    pub lag_s: f64,
    /// Rms error against the reference as it is [output unit].
    pub rms: f64,
    /// Rms error against the reference with this delay [output unit].
    pub rms_without_lag: f64,
}

/// A move of a reference.
struct Move {
    /// The first sample at another value.
    begin: usize,
    /// The first sample at the last value.
    end: usize,
    /// The next move, or the length of the reference.
    until: usize,
}

impl RunTiming {
    /// The timing of the displacement `y` along the reference `r` [output unit], both every `ts` [s]; the longer one is
    /// cut. Any displacement along a path can be timed, such as what a controller measured:
    ///
    /// ```
    /// use piezoid_verbs::RunTiming;
    /// let r = [vec![0.0; 20], vec![10.0; 80]].concat();
    /// let y: Vec<f64> = (0..100).map(|k| if k < 20 { 0.0 } else { 10.0 - 10.0 * 0.5f64.powi(k - 19) }).collect();
    /// let timing = RunTiming::of("measured", 1e-3, (&r, &y), 0.1);
    /// // 10 0.5^7 < 0.1, from the seventh sample of the step on.
    /// assert_eq!((timing.steps[0].settling_s, timing.steps[0].overshoot), (Some(0.006), 0.0));
    /// ```
    pub fn of(name: impl Into<String>, ts: f64, (r, y): (&[f64], &[f64]), tolerance: f64) -> Self {
        let n = r.len().min(y.len());
        let (r, y) = (&r[..n], &y[..n]);
        let within = r.iter().zip(y).filter(|(r, y)| (*y - *r).abs() <= tolerance).count();
        let steps = moves(r).into_iter().filter(|m| (r[m.end] - r[m.begin - 1]).abs() > tolerance);
        let steps = steps.map(|m| StepTiming::of(&m, ts, (r, y), tolerance)).collect();
        let within_percent = 100.0 * within as f64 / r.len().max(1) as f64;
        RunTiming { name: name.into(), within_percent, steps, scan: ScanLag::of(ts, r, y) }
    }

    /// The longest settling time [s]; `None` without steps, or if one of them does not settle.
    pub fn slowest_s(&self) -> Option<f64> {
        let all: Option<Vec<f64>> = self.steps.iter().map(|step| step.settling_s).collect();
        all?.into_iter().reduce(f64::max)
    }

    /// The largest overshoot [%]; `None` without steps.
    pub fn overshoot_percent(&self) -> Option<f64> {
        self.steps.iter().map(|step| step.overshoot_percent).reduce(f64::max)
    }
}

impl StepTiming {
    fn of(m: &Move, ts: f64, (r, y): (&[f64], &[f64]), tolerance: f64) -> Self {
        let judged = m.until - (m.until - m.end) / TAIL;
        let (from, to, played) = (r[m.begin - 1], r[m.end], &y[m.begin..judged]);
        let settled = settled_after(played, to, tolerance);
        let (overshoot, height) = (overshoot(played, from, to), (to - from).abs());
        StepTiming {
            at_s: m.begin as f64 * ts,
            from,
            to,
            move_s: (m.end - m.begin) as f64 * ts,
            settling_s: settled.map(|k| k as f64 * ts),
            overshoot,
            overshoot_percent: 100.0 * overshoot / height,
        }
    }
}

/// The first sample from which all of `y` are within the tolerance of `to`.
pub(super) fn settled_after(y: &[f64], to: f64, tolerance: f64) -> Option<usize> {
    let outside = y.iter().rposition(|y| (y - to).abs() > tolerance || y.is_nan());
    let first = outside.map_or(0, |k| k + 1);
    (first < y.len()).then_some(first)
}

/// Largest error beyond the goal `to` of a step from `from`, 0 or more.
pub(super) fn overshoot(y: &[f64], from: f64, to: f64) -> f64 {
    y.iter().map(|y| (y - to) * (to - from).signum()).fold(0.0, f64::max)
}

/// The moves of a reference between values at which it is held.
fn moves(r: &[f64]) -> Vec<Move> {
    let (low, high) = piezoid_numerics::series::ends(r.iter().copied());
    let moves = |k: &usize| (r[*k] - r[*k - 1]).abs() > SAME * (high - low);
    let (mut found, mut k) = (Vec::<Move>::new(), 1);
    while let Some(begin) = (k..r.len()).find(moves) {
        // It is held as soon as it rests for some samples.
        let mut end = begin;
        while let Some(next) = (end + 1..r.len().min(end + 1 + HELD)).find(moves) {
            end = next;
        }
        found.push(Move { begin, end, until: r.len() });
        k = end + 1;
    }
    for k in 1..found.len() {
        found[k - 1].until = found[k].begin;
    }
    found.retain(|m| m.until - m.end > HELD);
    found
}

impl ScanLag {
    /// The lag of `y` along a periodic `r`; `None` if that is not periodic.
    fn of(ts: f64, r: &[f64], y: &[f64]) -> Option<Self> {
        let period = period(r)?;
        // Whole periods after the first quarter of a second, but at least one.
        let begun = ((SETTLING / ts / period as f64).ceil() as usize * period).max(period);
        let from = begun.min((r.len() / period - 1) * period);
        let until = r.len().min(from + (LAG_SAMPLES / period).max(1) * period);
        let one = &r[from..from + period];
        let rms = |lag: f64| {
            let square = |k: usize| {
                let at = ((k - from) as f64 - lag).rem_euclid(period as f64);
                let (low, share) = (at as usize, at.fract());
                let delayed = (1.0 - share) * one[low % period] + share * one[(low + 1) % period];
                (y[k] - delayed) * (y[k] - delayed)
            };
            ((from..until).map(square).sum::<f64>() / (until - from) as f64).sqrt()
        };
        let quarter = (period / 4).max(1) as f64;
        let by = (2.0 * quarter / LAGS as f64).max(1.0);
        let lags = (0..=LAGS).map(|k| -quarter + k as f64 * by).take_while(|lag| *lag <= quarter);
        let best = lags.min_by(|a, b| rms(*a).total_cmp(&rms(*b))).unwrap_or(0.0);
        let lag = golden((best - by, best + by), rms);
        Some(ScanLag { period_s: period as f64 * ts, lag_s: lag * ts, rms: rms(0.0), rms_without_lag: rms(lag) })
    }
}

/// The minimum of `cost` in an interval.
fn golden((mut low, mut high): (f64, f64), cost: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    for _ in 0..REFINEMENTS {
        let (a, b) = (high - RATIO * (high - low), low + RATIO * (high - low));
        if cost(a) <= cost(b) { high = b } else { low = a }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    /// The step response of a second-order system, from theory: K. Ogata, Modern Control Engineering, eq. 5-12.
    fn second_order(hz: f64, damping: f64, t: f64) -> f64 {
        let (w, root) = (TAU * hz, (1.0 - damping * damping).sqrt());
        let angle = w * root * t;
        1.0 - (-damping * w * t).exp() * (angle.cos() + damping / root * angle.sin())
    }

    #[test]
    fn settling_and_overshoot_of_a_second_order_system_are_those_of_theory() {
        let (ts, hz) = (1e-5, 160.0);
        for damping in [0.03, 0.2, 0.7f64] {
            let r: Vec<f64> = (0..60_000).map(|k| if k < 100 { 2.0 } else { -3.0 }).collect();
            let at = |k: usize| if k < 100 { 0.0 } else { second_order(hz, damping, (k - 100) as f64 * ts) };
            let y: Vec<f64> = (0..60_000).map(|k| 2.0 - 5.0 * at(k)).collect();
            let tolerance = 0.05;
            let timing = RunTiming::of("theory", ts, (&r, &y), tolerance);
            let [step] = timing.steps[..] else { panic!("{:?}", timing.steps) };
            assert_eq!((step.from, step.to, step.move_s), (2.0, -3.0, 0.0));
            // exp(-pi zeta / sqrt(1 - zeta^2)), and the last time at which the error crosses the tolerance.
            let root = (1.0 - damping * damping).sqrt();
            let percent = 100.0 * (-std::f64::consts::PI * damping / root).exp();
            assert_close(&[step.overshoot_percent], &[percent], 1e-3, 0.01);
            let outside = |t: &f64| (second_order(hz, damping, *t) - 1.0).abs() > tolerance / 5.0;
            let last = (0..5_000_000).map(|k| 1e-7 * f64::from(k)).rfind(outside).unwrap();
            assert_close(&[step.settling_s.unwrap()], &[last], 0.0, 1.01 * ts);
            // The envelope bounds it: exp(-zeta w t) / sqrt(1 - zeta^2) = tolerance.
            let bound = -(tolerance / 5.0 * root).ln() / (damping * TAU * hz);
            assert!(last <= bound && last > 0.5 * bound, "{last} {bound}");
        }
    }

    #[test]
    fn the_lag_of_a_delayed_sine_and_triangle_is_found_between_the_samples() {
        let wave = |shape: usize, t: f64| match shape {
            0 => 30.0 * (TAU * t).sin(),
            _ => 30.0 * (4.0 * ((t + 0.25).rem_euclid(1.0) - 0.5).abs() - 1.0),
        };
        for shape in [0, 1] {
            for lag in [-2.25, 0.0, 7.4] {
                let run = |lag: f64| (0..4000).map(|k| wave(shape, (f64::from(k) - lag) / 400.0)).collect::<Vec<_>>();
                let found = RunTiming::of("delayed", 1e-3, (&run(0.0), &run(lag)), 0.01).scan.unwrap();
                assert_close(&[found.period_s, found.lag_s], &[0.4, 1e-3 * lag], 1e-12, 2e-5);
                assert!(found.rms_without_lag < 0.02 && (lag == 0.0 || found.rms > 0.5), "{found:?}");
            }
        }
    }

    #[test]
    fn steps_are_moves_between_held_values_that_exceed_the_tolerance() {
        let held = |v: f64, n| vec![v; n];
        let ramp: Vec<f64> = (1..20).map(|k| 5.0 + f64::from(k)).collect();
        let r = [held(0.0, 30), held(5.0, 30), ramp, held(25.0, 30), held(25.01, 30), held(0.0, 2)].concat();
        let y: Vec<f64> = r.iter().map(|r| r + 0.02).collect();
        let timing = RunTiming::of("near", 1e-3, (&r, &y), 0.05);
        let found: Vec<_> = timing.steps.iter().map(|s| (s.from, s.to, s.settling_s)).collect();
        // The ramp settles when it arrives; the last value is not held.
        assert_eq!(found, [(0.0, 5.0, Some(0.0)), (5.0, 25.0, Some(0.019))]);
        assert_close(&[timing.steps[1].move_s, timing.steps[1].overshoot], &[0.019, 0.02], 1e-9, 0.0);
        assert_eq!((timing.within_percent, timing.scan), (100.0, None));
        let far = RunTiming::of("far", 1e-3, (&r, &vec![f64::NAN; r.len()]), 0.05);
        assert!(far.within_percent == 0.0 && far.slowest_s().is_none() && far.overshoot_percent() == Some(0.0));
        assert!(RunTiming::of("none", 1e-3, (&[], &[]), 0.05).steps.is_empty());
        // A triangle has no steps.
        let triangle: Vec<f64> = (0..400).map(|k| f64::from((k % 100 - 50i32).abs())).collect();
        assert!(RunTiming::of("triangle", 1e-3, (&triangle, &triangle), 0.05).steps.is_empty());
    }
}
