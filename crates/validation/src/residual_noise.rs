//! Test whether the residuals of a linear block are noise, for records without periodic input.
//!
//! They are noise if
//! - at least half of them is white: sigma^2 = mean of (e_t - 2 e_{t-1} + e_{t-2})^2 / 6, to which smooth signals add
//!   nothing, and
//! - they correlate neither with the input nor with the residuals of nonlinear blocks: square and cube of the free run,
//!   and plays of two widths (`hysteresis/play.rs`), without their part that is linear in the free run and its slope.
//!
//! Hum and drift of a sensor without white noise are not distinguished from distortion. Coloured noise has fewer
//! independent samples than white noise: n / (1 + 2 sum r_k^2) for a mean square (Bartlett 1946, doi:10.2307/2983611).

use super::Whiteness;
use piezoid_numerics::number::power;
use piezoid_numerics::series::{centred, largest, mean};

/// Share of the rms that must be white.
const MIN_WHITE_SHARE: f64 = 0.5;

/// Correlation up to which residuals count as uncorrelated with a signal: a hundredth of its power.
const MAX_CORRELATION: f64 = 0.1;

/// Half widths of the plays, over half of the peak-to-peak.
const PLAY_HALF_WIDTHS: [f64; 2] = [0.1, 0.3];

/// Number of independent samples in `errors`, if they are noise; `u` is the input and `simulated` the free run.
pub(super) fn independent(u: &[f64], simulated: &[f64], errors: &[f64]) -> Option<f64> {
    let own = Whiteness::of(u, errors)?;
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    let rough = errors.windows(3).map(|e| (e[0] - 2.0 * e[1] + e[2]).powi(2)).sum::<f64>() / 6.0;
    let uncorrelated =
        |w: &Whiteness| w.cross_correlation.iter().all(|c| c.abs() <= w.cross_correlation_bound.max(MAX_CORRELATION));
    let linear = |nonlinear: &Vec<f64>| Whiteness::of(nonlinear, errors).is_some_and(|w| uncorrelated(&w));
    let is_noise = rough >= MIN_WHITE_SHARE * MIN_WHITE_SHARE * squares
        && uncorrelated(&own)
        && nonlinear(simulated).iter().all(linear);
    let colour = 1.0 + 2.0 * own.autocorrelation.iter().map(|r| r * r).sum::<f64>();
    is_noise.then_some(errors.len() as f64 / colour)
}

/// Residuals that nonlinear blocks would have.
fn nonlinear(simulated: &[f64]) -> Vec<Vec<f64>> {
    let s = centred(simulated);
    let reach = largest(&s);
    let slope: Vec<f64> = (0..s.len()).map(|t| s[(t + 1).min(s.len() - 1)] - s[t.saturating_sub(1)]).collect();
    let powers = [2, 3].map(|n| s.iter().map(|s| power(*s, n)).collect());
    let plays = PLAY_HALF_WIDTHS.map(|share| {
        let play = |z: &mut f64, s: &f64| {
            *z = z.clamp(s - share * reach, s + share * reach);
            Some(*z)
        };
        s.iter().scan(s[0], play).collect()
    });
    let remainder = |x: Vec<f64>| without(&without(&x, &s), &slope);
    powers.into_iter().chain(plays).map(remainder).collect()
}

/// The part of `x` uncorrelated with `s`.
fn without(x: &[f64], s: &[f64]) -> Vec<f64> {
    let (level, middle) = (mean(x), mean(s));
    let both: f64 = x.iter().zip(s).map(|(x, s)| (x - level) * (s - middle)).sum();
    let own: f64 = s.iter().map(|s| (s - middle).powi(2)).sum();
    let gain = if own > 0.0 { both / own } else { 0.0 };
    x.iter().zip(s).map(|(x, s)| x - level - gain * (s - middle)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::noise;

    /// A low-passed PRBS, and noise.
    fn signals() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let u = Prbs { order: 13, ..Prbs::default() }.samples(1.0, 4000).unwrap();
        let low_pass = |s: &mut f64, u: &f64| {
            *s += 0.2 * (u - *s);
            Some(*s)
        };
        let s = u.iter().scan(0.0, low_pass).collect();
        (u, s, noise(5, 4000))
    }

    #[test]
    fn all_samples_of_white_noise_are_independent_and_fewer_with_hum() {
        let (u, s, noise) = signals();
        let n = independent(&u, &s, &noise).unwrap();
        assert!((3600.0..=4000.0).contains(&n), "{n}");
        let hum: Vec<f64> = noise.iter().enumerate().map(|(t, e)| e + (0.02 * t as f64).sin()).collect();
        let n = independent(&u, &s, &hum).unwrap();
        assert!((200.0..800.0).contains(&n), "{n}");
    }

    #[test]
    fn nonlinear_residuals_and_a_missing_delay_are_not_noise() {
        let (u, s, noise) = signals();
        let delayed = std::iter::repeat_n(0.0, 9).chain(u.iter().copied()).take(4000).collect();
        for structure in nonlinear(&s).into_iter().chain([delayed]) {
            let size = (structure.iter().map(|x| x * x).sum::<f64>() / 4000.0).sqrt();
            let e: Vec<f64> = noise.iter().zip(&structure).map(|(e, x)| e + 0.5 * x / size).collect();
            assert_eq!(independent(&u, &s, &e), None);
        }
        let hum: Vec<f64> = (0..4000).map(|t| (0.02 * f64::from(t)).sin()).collect();
        assert_eq!(independent(&u, &s, &hum), None, "hum without white noise");
    }
}
