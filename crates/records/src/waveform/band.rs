//! The frequency band of an input.

use piezoid_numerics::fourier::plain_power;

/// Share of the power below and above the band.
const TAIL: f64 = 0.01;

/// Number of bins over which a line may leak this share.
const LEAK: usize = 20;

/// The frequency band [Hz] of `x`, with sampling period `ts` [s], without 1 % of the power below and 1 % above. For a
/// single line both limits are equal. `None` if `x` is constant.
pub fn band(x: &[f64], ts: f64) -> Option<(f64, f64)> {
    let power = plain_power(x);
    let all: f64 = power.iter().sum();
    if all.is_nan() || all <= 0.0 {
        return None;
    }
    let below = |share: f64| {
        let mut sum = 0.0;
        let reached = power.iter().position(|p| {
            sum += p;
            sum >= share * all
        });
        reached.unwrap_or(power.len() - 1)
    };
    let (low, high) = (below(TAIL), below(1.0 - TAIL));
    let hz = |bin: f64| bin / (x.len() as f64 * ts);
    if high - low > LEAK {
        return Some((hz(low as f64), hz(high as f64)));
    }
    let moment: f64 = power.iter().enumerate().map(|(k, p)| k as f64 * p).sum();
    Some((hz(moment / all), hz(moment / all)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{Multisine, Sine};

    #[test]
    fn a_sine_is_a_line_and_a_multisine_its_band() {
        let sine = Sine { amplitude: 5.0, frequency: 20.0, ..Sine::default() }.samples(5e-4, 4000).unwrap();
        let (low, high) = band(&sine, 5e-4).unwrap();
        assert!(low == high && (low - 20.0).abs() < 0.05, "{low} {high}");
        let wide = Multisine { frequency_low: 5.0, frequency_high: 300.0, ..Multisine::default() };
        let (low, high) = band(&wide.samples(5e-4, 4000).unwrap(), 5e-4).unwrap();
        assert!((4.0..9.0).contains(&low) && (290.0..302.0).contains(&high), "{low} {high}");
        assert_eq!(band(&[3.0; 100], 5e-4), None);
    }
}
