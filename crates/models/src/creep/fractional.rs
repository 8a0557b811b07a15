//! Creep of fractional order: it grows as a power of time.
//!
//! ```text
//! C(s) = 1 + g s^-alpha,    0 < alpha < 1         after a step of z:  g t^alpha / Gamma(1 + alpha)
//! s^-alpha = sin(pi alpha) / pi  int_0^inf tau^alpha / (1 + tau s) dtau / tau
//! ```
//! The integral as a sum over time constants that are half a decade apart: a ladder with gains proportional to
//! tau^alpha. Within the range of the time constants the response to a step is the power of time to 0.02 %. The poles
//! are in geometric order, as those of A. Oustaloup et al., IEEE Trans. Circuits Syst. I 47 (2000), DOI
//! 10.1109/81.817385. alpha = 0 is the logarithmic law.
//!
//! It does not do: a sum over the past of the input (Gruenwald & Letnikov, "short memory"). This takes hundreds of
//! products a sample for what a dozen of lags do, and forgets what is older than the memory.

use super::{Creep, Lag};
use libm::{log, pow, tgamma};
use piezoid_numerics::error::{Error, positive};

impl Creep {
    /// Creep that is `gain` [-] one second after a step of z and grows with time to the power `order` (above 0, below
    /// 1), by lags half a decade apart from `from` to at most `to` [s].
    ///
    /// ```
    /// use piezoid::creep::Creep;
    /// let creep = Creep::fractional(1e-3, 0.02, 0.25, (1e-9, 1e9))?;
    /// let grown = |t: f64| creep.after(16.0 * t) - creep.after(t);
    /// assert!((grown(1.0) - 0.02).abs() < 1e-4); // 0.02 (16^0.25 - 1)
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error for an order out of its range, and the errors of [`Creep::new`].
    pub fn fractional(ts: f64, gain: f64, order: f64, (from, to): (f64, f64)) -> Result<Self, Error> {
        positive("from", from, "seconds")?;
        if to.is_nan() || to < from {
            return Err(Error::parameter("to", to, format!("must be at least {from}, the shortest time constant [s]")));
        }
        if !(order > 0.0 && order < 1.0) {
            return Err(Error::parameter("order", order, "must be above 0 and below 1"));
        }
        let step = 10f64.sqrt();
        // sin(pi alpha) / pi * Gamma(1 + alpha)
        let density = gain * order / tgamma(1.0 - order) * log(step);
        let taus = std::iter::successors(Some(from), |tau| Some(step * tau)).take_while(|tau| *tau <= to);
        Creep::new(ts, taus.take(65).map(|tau_s| Lag { tau_s, gain: density * pow(tau_s, order) }).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::PI;

    #[test]
    fn after_a_step_it_is_a_power_of_time() {
        for order in [0.05, 0.2, 0.5, 0.8] {
            let creep = Creep::fractional(1e-3, 0.03, order, (1e-9, 1e18)).unwrap();
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
        let creep = Creep::fractional(1e-3, 0.02, order, (1e-12, 1e16)).unwrap();
        let (re, im) = creep.lags().iter().fold((0.0, 0.0), |(re, im), lag| {
            let square = 1.0 + (w * lag.tau_s).powi(2);
            (re + lag.gain / square, im - lag.gain * w * lag.tau_s / square)
        });
        let g = 0.02 * tgamma(1.0 + order) * pow(w, -order);
        assert_close(&[re, im], &[g * (0.5 * PI * order).cos(), -g * (0.5 * PI * order).sin()], 1e-3, 0.0);
    }

    #[test]
    fn an_order_out_of_its_range_is_an_error() {
        for order in [0.0, 1.0, f64::NAN] {
            let message = Creep::fractional(1e-3, 0.02, order, (1e-3, 1e3)).unwrap_err().to_string();
            assert!(message.starts_with("order = ") && message.contains("above 0 and below 1"), "{message}");
        }
        for to in [1e-4, f64::NAN] {
            assert!(Creep::fractional(1e-3, 0.02, 0.5, (1e-3, to)).unwrap_err().to_string().starts_with("to = "));
        }
        assert!(Creep::fractional(1e-3, 0.02, 0.5, (1e-30, 1e30)).unwrap_err().to_string().contains("64 lags"));
    }
}
