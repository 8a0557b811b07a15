//! Creep: slow displacement, as a ladder of first-order lags in parallel with the direct path.
//!
//! ```text
//! y_t = z_t + g_1 x_1 + ... + g_n x_n,    x_k <- x_k + (1 - exp(-Ts / tau_k)) (z_t - x_k)
//! ```
//! Equal gains g at time constants one decade apart give logarithmic creep: it grows by g per decade of time. Unequal
//! gains give a general ladder; gains that are a power of the time constants give creep of fractional order.
//!
//! Reference: H. Jung, D.-G. Gweon, Rev. Sci. Instrum. 71, 1896 (2000), DOI 10.1063/1.1150559 (logarithmic law); K.
//! Kuhnen & P. Krejci, IEEE Trans. Autom. Control 54 (2009), DOI 10.1109/TAC.2009.2012984 (ladder). Creep that depends
//! on amplitude or direction is not described.

mod fractional;

use crate::program::Block;
use libm::{expm1, log10};
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::number::power;
use piezoid_numerics::system::System;
use serde::{Deserialize, Serialize};

/// The ladder of lags.
///
/// State: the lags x_k [unit of z].
///
/// ```
/// use piezoid::{System, creep::Creep};
/// let creep = Creep::logarithmic(1e-3, 0.015, 0.01, 10.0)?; // 1.5 % per decade from 10 ms to 10 s
/// let y = creep.simulate(&[1.0; 2000]);
/// assert!((y[999] - y[99] - 0.015).abs() < 0.003);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Creep {
    ts: f64,
    lags: Vec<Lag>,
    /// 1 - exp(-Ts / tau_k).
    rates: Vec<f64>,
}

/// A first-order lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lag {
    /// Time constant [s].
    pub tau_s: f64,
    /// Final contribution, relative to z [-].
    pub gain: f64,
}

impl Creep {
    /// The ladder of these lags, with sampling period `ts` [s].
    ///
    /// # Errors
    /// Returns an error if `ts` or a time constant is not positive, if a gain is not finite, or if there are more than
    /// 64 lags.
    pub fn new(ts: f64, lags: Vec<Lag>) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        if lags.len() > 64 {
            return Err(Error::parameter("creep", format!("{} lags", lags.len()), "must be at most 64 lags"));
        }
        for (k, lag) in lags.iter().enumerate() {
            positive(&format!("creep[{k}].tau_s"), lag.tau_s, "seconds")?;
            piezoid_numerics::error::finite("creep gain", &[lag.gain])?;
        }
        let rates = lags.iter().map(|lag| -expm1(-ts / lag.tau_s)).collect();
        Ok(Creep { ts, lags, rates })
    }

    /// Logarithmic creep of `per_decade` [-], by lags one decade apart from `from` to `to` [s].
    ///
    /// # Errors
    /// The errors of [`Creep::new`], and an error if `from` is after `to`.
    pub fn logarithmic(ts: f64, per_decade: f64, from: f64, to: f64) -> Result<Self, Error> {
        positive("from", from, "seconds")?;
        positive("to", to, "seconds")?;
        if from > to {
            return Err(Error::parameter("from", from, format!("must not be after `to`, which is {to} s")));
        }
        let rungs = log10(to / from).round() as i32;
        Creep::new(ts, (0..=rungs).map(|k| Lag { tau_s: from * power(10.0, k), gain: per_decade }).collect())
    }

    /// The lags.
    pub fn lags(&self) -> &[Lag] {
        &self.lags
    }

    /// What each lag moves in a sample, as a share of its distance: 1 - exp(-Ts / tau).
    pub fn rates(&self) -> &[f64] {
        &self.rates
    }

    /// Creep at time `t` [s] after a step of z, relative to the step [-].
    pub fn after(&self, t: f64) -> f64 {
        self.lags.iter().map(|lag| -lag.gain * expm1(-t / lag.tau_s)).sum()
    }

    /// Returns the z for which the next step from the state `x` gives `y`. The step is linear in z, so this is exact.
    ///
    /// ```
    /// use piezoid::{System, creep::Creep};
    /// let creep = Creep::logarithmic(1e-3, 0.015, 0.01, 10.0)?;
    /// let mut x = creep.settled(3.0);
    /// let z = creep.invert(&x, 4.0);
    /// assert!((creep.step(&mut x, z) - 4.0).abs() < 1e-12);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub fn invert(&self, x: &[f64], y: f64) -> f64 {
        let (mut held, mut share) = (0.0, 1.0);
        for ((x, rate), lag) in x.iter().zip(&self.rates).zip(&self.lags) {
            held += lag.gain * (1.0 - rate) * x;
            share += lag.gain * rate;
        }
        (y - held) / share
    }

    /// The program of the creep: a block `creep` with functions for the step and its inverse.
    pub fn block(&self) -> Block {
        let gains: Vec<f64> = self.lags.iter().map(|lag| lag.gain).collect();
        let held: Vec<f64> = gains.iter().zip(&self.rates).map(|(gain, rate)| gain * (1.0 - rate)).collect();
        let share = gains.iter().zip(&self.rates).fold(1.0, |share, (gain, rate)| share + gain * rate);
        Block::new("creep", "creep: first-order lags in parallel with the direct path")
            .numbers("lag", vec![0.0; gains.len()])
            .table("rate", &self.rates)
            .table("gain", &gains)
            .table("held", &held)
            .constant("share", share)
            .count("rungs", gains.len())
            .text(PROGRAM)
    }
}

const PROGRAM: &str = "
fn creep(x: creep, z) {
    let y = z;
    for k in 0..rungs {
        x.lag[k] += rate[k] * (z - x.lag[k]);
        y += gain[k] * x.lag[k];
    }
    return y;
}

// The z for which the next step returns y.
fn creep_inverse(x: creep, y) {
    let sum = 0.0;
    for k in 0..rungs {
        sum += held[k] * x.lag[k];
    }
    return (y - sum) / share;
}
";

impl System for Creep {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        self.lags.len()
    }

    fn settled(&self, z: f64) -> Vec<f64> {
        vec![z; self.lags.len()]
    }

    fn step(&self, x: &mut [f64], z: f64) -> f64 {
        rungs(x, &self.rates, &self.lags, z)
    }

    fn respond(&self, x: &mut [f64], signal: &mut [f64]) {
        match x.len() {
            0 => {}
            1 => self.few::<1>(x, signal),
            2 => self.few::<2>(x, signal),
            3 => self.few::<3>(x, signal),
            4 => self.few::<4>(x, signal),
            5 => self.few::<5>(x, signal),
            _ => signal.iter_mut().for_each(|v| *v = self.step(x, *v)),
        }
    }
}

impl Creep {
    /// [`System::respond`] for `N` lags, which fit into registers.
    fn few<const N: usize>(&self, x: &mut [f64], signal: &mut [f64]) {
        let (Ok(past), Ok(rates)) = (<&mut [f64; N]>::try_from(x), <&[f64; N]>::try_from(&self.rates[..])) else {
            return;
        };
        let Ok(lags) = <&[Lag; N]>::try_from(&self.lags[..]) else { return };
        let mut x = *past;
        signal.iter_mut().for_each(|v| *v = rungs(&mut x, rates, lags, *v));
        *past = x;
    }
}

/// One sample of the ladder.
#[inline(always)]
fn rungs(x: &mut [f64], rates: &[f64], lags: &[Lag], z: f64) -> f64 {
    let mut y = z;
    for ((x, rate), lag) in x.iter_mut().zip(rates).zip(lags) {
        *x += rate * (z - *x);
        y += lag.gain * *x;
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_step_response_of_a_lag_is_exponential() {
        let creep = Creep::new(0.01, vec![Lag { tau_s: 0.5, gain: 0.2 }]).unwrap();
        let y = creep.simulate(&[3.0; 300]);
        let known: Vec<f64> = (1..=300).map(|t| 3.0 + 0.6 * (1.0 - (-f64::from(t) * 0.02).exp())).collect();
        assert_close(&y, &known, 1e-12, 0.0);
        let after: Vec<f64> = (1..=300).map(|t| 3.0 + 3.0 * creep.after(0.01 * f64::from(t))).collect();
        assert_close(&after, &known, 1e-12, 0.0);
    }

    #[test]
    fn a_settled_ladder_has_a_constant_output() {
        let creep = Creep::logarithmic(1e-3, 0.02, 0.1, 100.0).unwrap();
        assert_eq!(creep.lags().len(), 4);
        assert_close(&creep.resume(&mut creep.settled(5.0), &[5.0; 100]), &[5.4; 100], 1e-12, 0.0);
    }

    #[test]
    fn a_run_is_bit_identical_to_its_steps_for_any_number_of_lags() {
        let z: Vec<f64> = (0..300).map(|t| (0.1 * f64::from(t)).sin()).collect();
        for n in 0..9 {
            let lags = (0..n).map(|k| Lag { tau_s: 0.003 * 1.7f64.powi(k), gain: 0.1 + 0.02 * f64::from(k) });
            let creep = Creep::new(1e-3, lags.collect()).unwrap();
            let mut x = creep.initial();
            let stepped: Vec<f64> = z.iter().map(|&z| creep.step(&mut x, z)).collect();
            assert_eq!(creep.simulate(&z), stepped);
        }
    }

    #[test]
    fn invalid_lags_are_errors() {
        let message = |tau_s, gain| Creep::new(1e-3, vec![Lag { tau_s, gain }]).unwrap_err().to_string();
        assert!(message(0.0, 0.1).starts_with("creep[0].tau_s = 0"));
        assert!(message(1.0, f64::NAN).contains("creep gain[0] is NaN"));
        assert!(Creep::logarithmic(1e-3, 0.01, 1.0, 0.1).is_err());
    }
}
