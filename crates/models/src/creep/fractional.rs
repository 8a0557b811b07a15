//! Creep of fractional order: it grows as a power of time.
//!
//! ```text
//! C(s) = 1 + g s^-alpha,    0 < alpha < 1         after a step of z:  g t^alpha / Gamma(1 + alpha)
//! s^-alpha = sin(pi alpha) / pi  int_0^inf tau^alpha / (1 + tau s) dtau / tau
//! ```
//! The integral as a sum over time constants that are half a decade apart: a ladder with gains proportional to
//! tau^alpha. Within the range of the time constants the response to a step is the power of time to 0.02 %. The poles are
//! in geometric order, as those of A. Oustaloup et al., IEEE Trans. Circuits Syst. I 47 (2000), DOI 10.1109/81.817385.
//! alpha = 0 is the logarithmic law.
//!
//! It does not do: a sum over the past of the input (Gruenwald & Letnikov, "short memory"). This takes hundreds of
//! products a sample for what a dozen of lags do, and forgets what is older than the memory.

use super::Lag;
use libm::{log, pow, tgamma};

/// Lags of creep that is `gain` [-] one second after a step of z and grows with time to the power `order` (0 to 1,
/// exclusive), with time constants from `from` to at most `to` [s], half a decade apart.
///
/// ```
/// use piezoid::creep::Creep;
/// use piezoid_models::creep::power_law;
/// let creep = Creep::new(1e-3, power_law(0.02, 0.25, 1e-3, 1e4))?;
/// assert!((creep.after(16.0) / creep.after(1.0) - 2.0).abs() < 0.02);
/// # Ok::<(), piezoid::Error>(())
/// ```
pub fn power_law(gain: f64, order: f64, from: f64, to: f64) -> Vec<Lag> {
    let step = 10f64.sqrt();
    // sin(pi alpha) / pi * Gamma(1 + alpha), without 0 times infinity: alpha / Gamma(1 - alpha).
    let density = gain * order / tgamma(1.0 - order) * log(step);
    let taus = std::iter::successors(Some(from), |tau| Some(step * tau)).take_while(|tau| *tau <= to);
    taus.map(|tau_s| Lag { tau_s, gain: density * pow(tau_s, order) }).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Creep;
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::PI;

    #[test]
    fn after_a_step_it_is_a_power_of_time() {
        for order in [0.05, 0.2, 0.5, 0.8] {
            let creep = Creep::new(1e-3, power_law(0.03, order, 1e-9, 1e18)).unwrap();
            // What lags faster than these add is constant.
            for t in [0.01, 0.3, 1.0, 20.0] {
                let grown = creep.after(2.0 * t) - creep.after(t);
                assert_close(&[grown], &[0.03 * (pow(2.0 * t, order) - pow(t, order))], 1e-3, 0.0);
            }
        }
    }

    #[test]
    fn the_response_to_a_sine_is_that_of_the_fractional_integral() {
        // |g (i w)^-alpha| and its phase, -90 degrees times alpha.
        let (order, w) = (0.3, 5.0);
        let lags = power_law(0.02, order, 1e-12, 1e16);
        let (re, im) = lags.iter().fold((0.0, 0.0), |(re, im), lag| {
            let square = 1.0 + (w * lag.tau_s).powi(2);
            (re + lag.gain / square, im - lag.gain * w * lag.tau_s / square)
        });
        let g = 0.02 * tgamma(1.0 + order) * pow(w, -order);
        assert_close(&[re, im], &[g * (0.5 * PI * order).cos(), -g * (0.5 * PI * order).sin()], 1e-3, 0.0);
    }
}
