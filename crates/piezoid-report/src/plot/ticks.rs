//! Ticks and their labels: steps of 1, 2 or 5 times a power of ten.

use super::text::{number, power_of_ten};
use piezoid_numerics::number::power;

/// A tick of an axis; minor ticks have no label.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) at: f64,
    pub(super) label: String,
}

impl Tick {
    /// A tick at a value, labelled with as few decimals as possible.
    pub(super) fn plain(at: f64) -> Self {
        let decimals = (0..=6).find(|&d| (at - rounded(at, d)).abs() <= 1e-9 * at.abs()).unwrap_or(6);
        let plain = at == 0.0 || (1e-5..1e7).contains(&at.abs());
        let label = match plain {
            true => number(at, decimals as usize),
            false => scientific(at, at.abs().log10().floor() as i32, 0),
        };
        Tick { at, label }
    }
}

fn ten_to(exponent: i32) -> f64 {
    power(10.0, exponent)
}

fn rounded(v: f64, decimals: i32) -> f64 {
    (v * ten_to(decimals)).round() / ten_to(decimals)
}

/// A step `mantissa` times ten to the `exponent`, the mantissa 1, 2 or 5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TickStep {
    mantissa: f64,
    exponent: i32,
}

impl TickStep {
    /// The smallest such step of at least `least`.
    pub(super) fn nice(least: f64) -> Self {
        let least = if least.is_finite() { least.max(1e-300) } else { 1e307 };
        let exponent = least.log10().floor() as i32;
        let share = least / ten_to(exponent) * (1.0 - 1e-9);
        match [1.0, 2.0, 5.0].into_iter().find(|m| *m >= share) {
            Some(mantissa) => TickStep { mantissa, exponent },
            None => TickStep { mantissa: 1.0, exponent: exponent + 1 },
        }
    }

    /// `n` steps from zero. Division by a power of ten keeps decimals exact.
    fn times(self, n: f64) -> f64 {
        let n = n * self.mantissa;
        if self.exponent < 0 { n / ten_to(-self.exponent) } else { n * ten_to(self.exponent) }
    }

    fn count(self, v: f64) -> f64 {
        v / self.times(1.0)
    }

    /// The step for about `count` ticks between two ends, finer if fewer than three would be inside.
    pub(super) fn within(low: f64, high: f64, count: usize) -> Self {
        let mut step = TickStep::nice((high - low) / count.max(1) as f64);
        // 5, 2 and 1 are the steps to the next finer power of ten.
        for _ in 0..3 {
            if step.inside(low, high).1 - step.inside(low, high).0 >= 2.0 {
                break;
            }
            step = TickStep::nice(0.4 * step.times(1.0));
        }
        step
    }

    /// Numbers of the first and the last multiple between two ends.
    fn inside(self, low: f64, high: f64) -> (f64, f64) {
        ((self.count(low) - 1e-9).ceil(), (self.count(high) + 1e-9).floor())
    }

    /// `high`, or the next multiple of the step if that is within half a percent of the range.
    pub(super) fn complete(self, low: f64, high: f64) -> f64 {
        let whole = self.times((self.count(high) - 1e-9).ceil());
        if whole - high < 0.005 * (high - low) { whole } else { high }
    }
}

/// The multiples of `step` between two ends, inclusive.
pub(super) fn linear(low: f64, high: f64, step: TickStep) -> Vec<Tick> {
    let (first, last) = step.inside(low, high);
    let at: Vec<f64> = (0..=(last - first).clamp(0.0, 50.0) as usize).map(|i| step.times(first + i as f64)).collect();
    let largest = at.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let power = largest.max(1e-300).log10().floor() as i32;
    let scientific_wanted = power >= 6 || step.exponent < -5 || power < -3;
    let label = |&v: &f64| match () {
        () if v == 0.0 => "0".to_owned(),
        () if scientific_wanted => scientific(v, power, (power - step.exponent).clamp(0, 12) as usize),
        () => number(v, (-step.exponent).max(0) as usize),
    };
    at.iter().map(|v| Tick { at: *v, label: label(v) }).collect()
}

/// `v` as a multiple of a power of ten.
fn scientific(v: f64, power: i32, decimals: usize) -> String {
    // In two factors, because the power alone may overflow.
    let v = v / ten_to(power / 2) / ten_to(power - power / 2);
    format!("{}×{}", number(v, decimals), power_of_ten(power))
}

/// Decades with minor ticks; 1-2-5 for few decades; linear steps within one decade.
pub(super) fn log(low: f64, high: f64, count: usize) -> Vec<Tick> {
    let decades = (high / low).log10();
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let within = |v: f64| v >= low * (1.0 - 1e-9) && v <= high * (1.0 + 1e-9);
    let stride = ((f64::from(last - first) / count.max(1) as f64).ceil() as i32).max(1);
    let dense = 3.0 * decades <= count as f64 + 2.5;
    let mut ticks = Vec::new();
    for decade in first..=last {
        for digit in 1..=9 {
            let at = TickStep { mantissa: 1.0, exponent: decade }.times(f64::from(digit));
            let labelled = (digit == 1 && decade.rem_euclid(stride) == 0) || (dense && matches!(digit, 2 | 5));
            let crowded = if digit == 1 { last - first > 30 } else { last - first > 8 };
            if within(at) && (labelled || !crowded) {
                ticks.push(Tick { at, label: if labelled { log_label(at, decade, digit) } else { String::new() } });
            }
        }
    }
    let labelled = ticks.iter().filter(|t| !t.label.is_empty()).count();
    if labelled >= 2 { ticks } else { linear(low, high, TickStep::within(low, high, count)) }
}

/// The label of `at`, which is `digit` times ten to the `decade`.
fn log_label(at: f64, decade: i32, digit: i32) -> String {
    match (decade, digit) {
        (-3..=4, _) => number(at, (-decade).max(0) as usize),
        (_, 1) => power_of_ten(decade),
        _ => format!("{digit}×{}", power_of_ten(decade)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|t| t.label.as_str()).filter(|l| !l.is_empty()).collect()
    }

    #[test]
    fn labels_have_the_decimals_of_their_step() {
        assert_eq!(labels(&linear(-0.1, 0.1, TickStep::nice(0.05))), ["−0.10", "−0.05", "0", "0.05", "0.10"]);
        assert_eq!(labels(&linear(0.0, 3e-6, TickStep::nice(1e-6))), ["0", "1×10⁻⁶", "2×10⁻⁶", "3×10⁻⁶"]);
        assert_eq!(labels(&linear(0.0, 20_000.0, TickStep::nice(1e4))), ["0", "10\u{2009}000", "20\u{2009}000"]);
    }

    #[test]
    fn a_log_axis_has_decades_or_one_two_five_or_linear_steps() {
        let decades = ["10⁻⁶", "10⁻⁵", "10⁻⁴", "0.001", "0.01", "0.1", "1", "10", "100"];
        assert_eq!(labels(&log(1e-6, 1e2, 9)), decades);
        assert_eq!(labels(&log(5.0, 200.0, 6)), ["5", "10", "20", "50", "100", "200"]);
        assert_eq!(labels(&log(2.1, 2.9, 4)), ["2.2", "2.4", "2.6", "2.8"]);
        assert!(log(1.0, 1e3, 3).iter().any(|t| t.at == 20.0 && t.label.is_empty()), "minor ticks");
    }

    proptest! {
        #[test]
        fn at_least_three_ticks_step_by_one_two_or_five_inside_the_range(
            low in -1e6..1e6f64,
            span in 1e-3..1e6f64,
            count in 3..9usize,
        ) {
            let high = low + span;
            let step = TickStep::within(low, high, count);
            prop_assert!([1.0, 2.0, 5.0].contains(&step.mantissa));
            let ticks = linear(low, high, step);
            prop_assert!((3..=count.max(7) + 2).contains(&ticks.len()), "{}", ticks.len());
            let slack = 1e-8 * step.times(1.0);
            prop_assert!(ticks[0].at >= low - slack && ticks[ticks.len() - 1].at <= high + slack);
            prop_assert!(ticks[0].at - step.times(1.0) < low && ticks[ticks.len() - 1].at + step.times(1.0) > high);
            for pair in ticks.windows(2) {
                prop_assert!((step.count(pair[1].at - pair[0].at) - 1.0).abs() < 1e-6);
            }
        }
    }
}
