//! What the error of free runs says of the next one.
//!
//! The measured error e of a record contains the noise of the sensor. Its mean square about the mean, without a drift
//! that has a row of its own, is that of the model and of the noise:
//!
//! ```text
//! u_model^2 = s^2 - u_noise^2,   nu_model = u_model^4 / (s^4 / nu + u_noise^4 / nu_noise)
//! ```
//! Successive errors are not independent. The mean square of correlated Gaussian errors scatters like that of nu
//! independent ones,
//!
//! ```text
//! nu = (sum P_k)^2 / sum P_k^2 = n / sum rho_j^2
//! ```
//! with their power P_k in both halves of the spectrum, and their correlation rho_j at all lags: 2 for an error that is
//! one sine, half of the samples for a white one.
//!
//! Reference: JCGM 100:2008, 4.2 and G.4; Bartlett 1946, doi:10.2307/2983611 (variance of estimated covariances).

use piezoid_numerics::fourier::plain_power;
use piezoid_numerics::series::{line, mean};
use piezoid_validation::{Bin, Floor, Offset, Validation};

/// Degrees of freedom of a noise that is read from a spectrum: its standard deviation is known to a tenth (G.4.2).
const SPECTRUM_DEGREES: f64 = 50.0;

/// What the errors of a record, or of a band, show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Evidence {
    /// Rms of the model's error without noise, mean and drift; with the noise, if that is unknown [output unit].
    pub(super) model: f64,
    pub(super) model_nu: f64,
    /// Standard deviation of the noise [output unit].
    pub(super) noise: Option<(f64, f64)>,
    /// Rms of the drift within the record, if that is steady and makes much of the error [output unit].
    pub(super) drift: Option<f64>,
    /// Mean error, and its standard uncertainty [output unit].
    pub(super) mean: f64,
    pub(super) mean_uncertainty: f64,
    /// Number of independent errors.
    pub(super) nu: f64,
}

impl Evidence {
    /// Of the errors of a validation that count.
    pub(super) fn of(errors: &[f64], validation: &Validation) -> Self {
        let t: Vec<f64> = (0..errors.len()).map(|t| t as f64).collect();
        let drift = validation.named_drift;
        let slope = drift.and_then(|_| line(&t, errors)).map_or(0.0, |(slope, _)| slope);
        let rest: Vec<f64> = errors.iter().zip(&t).map(|(e, t)| e - slope * t).collect();
        let (square, nu) = independent(&rest);
        let noise = validation.floor.as_ref().map(|floor| (floor.rms.min(square.sqrt()), noise_degrees(floor)));
        let mean_uncertainty = (square / nu).sqrt();
        // What was subtracted leaves nothing but rounding.
        let mean = if validation.offset == Offset::Kept { mean(errors) } else { 0.0 };
        Evidence { drift, mean, mean_uncertainty, ..Evidence::without_mean(square, nu, noise) }
    }

    /// Of a band, in whose errors mean and drift are contained; `nu` is the number of independent errors.
    pub(super) fn of_band(band: &Bin, nu: f64) -> Self {
        Evidence::without_mean(band.rmse * band.rmse, nu, band.noise.map(|noise| (noise, SPECTRUM_DEGREES)))
    }

    fn without_mean(square: f64, nu: f64, noise: Option<(f64, f64)>) -> Self {
        let (of_noise, noise_nu) = noise.unwrap_or((0.0, f64::INFINITY));
        let model = (square - of_noise * of_noise).max(0.0).sqrt();
        let scatter = square * square / nu + of_noise.powi(4) / noise_nu;
        // A difference of two numbers that are nearly equal is not known, but never less than one degree of freedom.
        let model_nu = if model > 0.0 { (model.powi(4) / scatter).max(1.0) } else { 1.0 };
        Evidence { model, model_nu, noise, drift: None, mean: 0.0, mean_uncertainty: 0.0, nu }
    }
}

/// The mean square of these errors about their mean, and the number of independent ones among them.
fn independent(errors: &[f64]) -> (f64, f64) {
    let power = plain_power(errors);
    let n = errors.len();
    let total: f64 = power.iter().sum();
    // A bin also counts for its mirror image, with half of its power each, but for the last one of an even number.
    let squares: f64 = power.iter().enumerate().map(|(k, p)| if 2 * k == n { p * p } else { 0.5 * p * p }).sum();
    (total, if squares > 0.0 { (total * total / squares).max(1.0) } else { n as f64 })
}

fn noise_degrees(floor: &Floor) -> f64 {
    match floor.period.zip(floor.periods) {
        Some((period, periods)) => (period * periods.saturating_sub(1)).max(1) as f64,
        None => SPECTRUM_DEGREES,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::{assert_close, noise};

    const N: usize = 4000;

    #[test]
    fn one_sine_has_two_independent_errors_and_white_noise_half_of_its_samples() {
        let sine: Vec<f64> = (0..N).map(|t| 3.0 + 0.2 * (std::f64::consts::TAU * t as f64 / 100.0).sin()).collect();
        let (square, nu) = independent(&sine);
        assert_close(&[square, nu], &[0.02, 2.0], 1e-9, 0.0);
        let (square, nu) = independent(&noise(1, N));
        assert_close(&[square, nu], &[1.0, 0.5 * N as f64], 0.06, 0.0);
        assert_eq!(independent(&[1.0; 10]), (0.0, 10.0));
    }

    #[test]
    fn the_number_of_independent_errors_predicts_how_a_mean_square_scatters() {
        // A first-order process with correlation 0.9^j has n (1 - 0.81) / (1 + 0.81) independent errors.
        let squares = |seed: u64| {
            let mut x = 0.0;
            let e: Vec<f64> = noise(seed, N)
                .into_iter()
                .map(|w| {
                    x = 0.9 * x + w;
                    x
                })
                .collect();
            independent(&e)
        };
        let all: Vec<(f64, f64)> = (1..=200).map(squares).collect();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        let (level, nu) = (mean(&|s| s.0), mean(&|s| s.1));
        let scatter = mean(&|s| (s.0 - level).powi(2));
        let observed = 2.0 * level * level / scatter;
        assert_close(&[observed], &[N as f64 * 0.19 / 1.81], 0.3, 0.0);
        // Estimated from one record, it is half of that, as for white noise: never too many.
        assert_close(&[nu], &[0.5 * N as f64 * 0.19 / 1.81], 0.2, 0.0);
    }

    #[test]
    fn the_noise_counts_once() {
        let known = Evidence::without_mean(0.25, 40.0, Some((0.3, 100.0)));
        assert_close(&[known.model.hypot(0.3)], &[0.5], 1e-12, 0.0);
        assert_close(&[known.model_nu], &[0.0256 * 16.0 / (6.25e-2 * 16.0 / 40.0 + 0.0081 * 16.0 / 100.0)], 1e-9, 0.0);
        let unknown = Evidence::without_mean(0.25, 40.0, None);
        assert_eq!((unknown.model, unknown.noise), (0.5, None));
        let all = Evidence::without_mean(0.25, 40.0, Some((0.5, 100.0)));
        assert_eq!((all.model, all.model_nu), (0.0, 1.0));
    }
}
