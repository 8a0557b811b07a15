//! The period of an input.

use piezoid_numerics::fourier::autocorrelation;
use piezoid_numerics::series::{mean, scatter};

/// Largest rms difference between repetitions, relative to the rms of the input.
const SAME: f64 = 1e-3;

/// A period is searched only after a lag with a larger relative rms difference, because a slow input resembles itself
/// at small lags.
const OTHER: f64 = 0.5;

/// The period of `u` [samples], if the whole input repeats at least once.
pub fn period(u: &[f64]) -> Option<usize> {
    let n = u.len();
    let variance = scatter(u) / n as f64;
    if variance.is_nan() || variance <= 0.0 {
        return None;
    }
    let middle = mean(u);
    let products = autocorrelation(n, |t| u[t] - middle);
    // Cumulative sums of squares.
    let mut squares = vec![0.0];
    squares.extend(u.iter().scan(0.0, |sum, u| {
        *sum += (u - middle) * (u - middle);
        Some(*sum)
    }));
    // The mean square difference at a lag, relative to that of uncorrelated inputs.
    let differs = |p: usize| {
        let energy = squares[n - p] + squares[n] - squares[p] - 2.0 * products[p];
        energy / ((n - p) as f64 * 2.0 * variance)
    };
    let start = (1..=n / 2).find(|&p| differs(p) > OTHER * OTHER)?;
    let exact = |p: usize| {
        let energy: f64 = u[p..].iter().zip(u).map(|(a, b)| (a - b) * (a - b)).sum();
        energy / ((n - p) as f64 * variance)
    };
    // The transform has rounding errors: candidates are checked exactly.
    (start..=n / 2)
        .filter(|&p| differs(p) < 4.0 * SAME * SAME && differs(p) <= differs(p - 1))
        .find(|&p| exact(p) < SAME * SAME && (p + 1 > n / 2 || exact(p) <= exact(p + 1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{Chirp, Multisine, Prbs, RisingSine, Sine};

    #[test]
    fn the_period_is_exact() {
        let prbs = Prbs { order: 8, ..Prbs::default() };
        assert_eq!(period(&prbs.samples(5e-4, 1000).unwrap()), Some(255));
        let sine = Sine { amplitude: 3.0, frequency: 5.0, ..Sine::default() };
        assert_eq!(period(&sine.samples(5e-4, 2000).unwrap()), Some(400));
        let thirds = Sine { amplitude: 3.0, frequency: 3.0, ..Sine::default() };
        assert_eq!(period(&thirds.samples(5e-4, 8000).unwrap()), Some(2000));
        let wide = Multisine { period: 0.5, frequency_low: 2.0, ..Multisine::default() };
        assert_eq!(period(&wide.samples(5e-4, 3500).unwrap()), Some(1000));
    }

    #[test]
    fn inputs_that_do_not_repeat_have_no_period() {
        let once = Prbs { order: 11, ..Prbs::default() }.samples(5e-4, 2047).unwrap();
        let rising =
            RisingSine { amplitude: 3.0, frequency: 5.0, ..RisingSine::default() }.samples(5e-4, 2000).unwrap();
        let sweep = Chirp { frequency_start: 1.0, frequency_end: 9.0, ..Chirp::default() }.samples(5e-4, 4000).unwrap();
        let ramp: Vec<f64> = (0..500).map(f64::from).collect();
        for u in [once, rising, sweep, ramp, vec![1.0; 300], vec![1.0]] {
            assert_eq!(period(&u), None);
        }
    }
}
