//! The ARX difference equation, the paper's equation (1).
//!
//! ```text
//! y_t = a1 y_{t-1} + ... + a_na y_{t-na} + b0 u_t + b1 u_{t-1} + ... + b_nb u_{t-nb} + e_t
//! ```
//!
//! Signs are those of the regression: the denominator of the transfer function is 1 - a1 q^-1 - a2 q^-2 - ..., so `a`
//! is minus the `a` of filters in scipy and MATLAB. A delay of d samples is d leading zeros in `b`.

use crate::program::Block;
use piezoid_numerics::error::{Error, finite, positive};
use piezoid_numerics::system::System;
use serde::{Deserialize, Serialize};

/// The linear block: coefficients with the signs of equation (1), in output units per input unit.
///
/// State: the last outputs, newest first, then the last inputs, newest first.
///
/// ```
/// use piezoid::{System, linear::Arx};
/// let table2 = Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0012, -0.0004, -0.0003])?;
/// let pole = &table2.poles()[0];
/// assert!((pole.hz - 146.7).abs() < 0.1 && (pole.damping - 0.061).abs() < 0.001);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "ArxDocument")]
pub struct Arx {
    ts: f64,
    a: Vec<f64>,
    b: Vec<f64>,
}

/// Maximum length of `a` and of `b`: finding the poles takes the cube of it.
const LONGEST: usize = 512;

/// The JSON form of an [`Arx`], before its numbers are checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ArxDocument {
    ts: f64,
    a: Vec<f64>,
    b: Vec<f64>,
}

impl TryFrom<ArxDocument> for Arx {
    type Error = Error;
    fn try_from(c: ArxDocument) -> Result<Self, Error> {
        Arx::new(c.ts, c.a, c.b)
    }
}

impl Arx {
    /// `ts` [s]; `a` = a1, a2, ... and `b` = b0, b1, ... as in equation (1).
    ///
    /// # Errors
    /// Returns an error unless `ts` is positive, all coefficients are finite, at least one b is not zero, and there are
    /// at most 512 of each.
    pub fn new(ts: f64, a: Vec<f64>, b: Vec<f64>) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        finite("a", &a)?;
        finite("b", &b)?;
        for (name, c) in [("a", &a), ("b", &b)] {
            if c.len() > LONGEST {
                let rule = format!("must have at most {LONGEST} coefficients; lower the order or the delay");
                return Err(Error::parameter(name, format!("{} coefficients", c.len()), rule));
            }
        }
        if b.iter().all(|&b| b == 0.0) {
            return Err(Error::parameter("b", format!("{b:?}"), "must contain a number that is not zero"));
        }
        Ok(Arx { ts, a, b })
    }

    /// The block that multiplies by `k`, without dynamics.
    ///
    /// # Errors
    /// As [`Arx::new`].
    pub fn gain(ts: f64, k: f64) -> Result<Self, Error> {
        Arx::new(ts, Vec::new(), vec![k])
    }

    /// a1, a2, ...
    pub fn a(&self) -> &[f64] {
        &self.a
    }

    /// The coefficients of 1 - a1 q^-1 - a2 q^-2 - ...
    pub fn denominator(&self) -> Vec<f64> {
        std::iter::once(1.0).chain(self.a.iter().map(|a| -a)).collect()
    }

    /// b0, b1, ...
    pub fn b(&self) -> &[f64] {
        &self.b
    }

    /// One-step prediction from measured outputs: `y[t]` from `u` up to t and `y` up to t-1. Everything before the
    /// first sample is zero. Of series of different lengths the common part is used.
    pub fn predict(&self, u: &[f64], y: &[f64]) -> Vec<f64> {
        let mut x = self.initial();
        u.iter()
            .zip(y)
            .map(|(&u, &measured)| {
                let predicted = self.step(&mut x, u);
                if !self.a.is_empty() {
                    x[0] = measured;
                }
                predicted
            })
            .collect()
    }
}

impl System for Arx {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        self.a.len() + self.b.len() - 1
    }

    /// All outputs at the DC gain times `u`; rest if there is no DC gain (a pole at 1).
    fn settled(&self, u: f64) -> Vec<f64> {
        let y = self.dc_gain() * u;
        let mut x = vec![if y.is_finite() { y } else { 0.0 }; self.a.len()];
        x.resize(self.order(), u);
        x
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        let mut signal = [u];
        self.respond(x, &mut signal);
        signal[0]
    }

    fn respond(&self, x: &mut [f64], signal: &mut [f64]) {
        let (outputs, inputs) = x.split_at_mut(self.a.len());
        filter(self.b[0], &self.b[1..], inputs, signal, |u, _| u);
        filter(1.0, &self.a, outputs, signal, |_, y| y);
    }
}

impl Arx {
    /// The block as a program, from rest: a block called `name`, with a function of the same name for the step.
    pub fn block(&self, name: &str, about: &str) -> Block {
        self.block_from(name, about, &self.initial())
    }

    /// The same from the state `x`.
    pub fn block_from(&self, name: &str, about: &str, x: &[f64]) -> Block {
        let (outputs, inputs) = (self.a.len(), self.b.len() - 1);
        let (last_outputs, last_inputs) = x.split_at(outputs);
        let takes = if self.order() == 0 { String::new() } else { format!("x: {name}, ") };
        Block::new(name, about)
            .numbers("outputs", last_outputs.to_vec())
            .numbers("inputs", last_inputs.to_vec())
            .table("a", &self.a)
            .table("b", &self.b)
            .text(&format!("fn {name}({takes}u) {{\n    // The oldest first.\n    let sum = b[0] * u;\n"))
            .text(&shift_register("inputs", inputs, "b", 1, "u"))
            .text(&shift_register("outputs", outputs, "a", 0, "sum"))
            .text("    return sum;\n}\n")
    }
}

/// Text that adds the `n` past values `past`, times the coefficients from index `from`, and then stores `newest`.
fn shift_register(past: &str, n: usize, coefficients: &str, from: usize, newest: &str) -> String {
    if n == 0 {
        return String::new();
    }
    let mut text = String::new();
    if n <= SHORT {
        for k in (0..n).rev() {
            text += &format!("    sum += {coefficients}[{}] * x.{past}[{k}];\n", k + from);
        }
        for k in (1..n).rev() {
            text += &format!("    x.{past}[{k}] = x.{past}[{}];\n", k - 1);
        }
    } else {
        text += &format!("    for k in 0..{n} down {{ sum += {coefficients}[k + {from}] * x.{past}[k]; }}\n");
        text += &format!("    for k in 1..{n} down {{ x.{past}[k] = x.{past}[k - 1]; }}\n");
    }
    text + &format!("    x.{past}[0] = {newest};\n")
}

/// Maximum number of past values whose text is unrolled.
const SHORT: usize = 4;

/// Replaces v by gain v + c_1 p_1 + c_2 p_2 + ... along the signal. `newest` selects the next p_1 from the old v and
/// the new v.
fn filter(gain: f64, c: &[f64], past: &mut [f64], signal: &mut [f64], newest: impl Fn(f64, f64) -> f64) {
    match c.len() {
        0 => short::<0>(gain, c, past, signal, newest),
        1 => short::<1>(gain, c, past, signal, newest),
        2 => short::<2>(gain, c, past, signal, newest),
        3 => short::<3>(gain, c, past, signal, newest),
        4 => short::<4>(gain, c, past, signal, newest),
        5 => short::<5>(gain, c, past, signal, newest),
        6 => short::<6>(gain, c, past, signal, newest),
        7 => short::<7>(gain, c, past, signal, newest),
        8 => short::<8>(gain, c, past, signal, newest),
        _ => long(gain, c, past, signal, newest),
    }
}

/// [`filter`] with `N` coefficients, its past in registers.
fn short<const N: usize>(gain: f64, c: &[f64], past: &mut [f64], signal: &mut [f64], newest: impl Fn(f64, f64) -> f64) {
    let (Ok(c), Ok(past)) = (<&[f64; N]>::try_from(c), <&mut [f64; N]>::try_from(past)) else { return };
    let mut p = *past;
    for v in signal {
        let new = sum(gain * *v, c, p.iter().rev());
        p = std::array::from_fn(|k| if k == 0 { newest(*v, new) } else { p[k - 1] });
        *v = new;
    }
    *past = p;
}

/// [`filter`] with many coefficients: the past is not shifted but read where it was written.
fn long(gain: f64, c: &[f64], past: &mut [f64], signal: &mut [f64], newest: impl Fn(f64, f64) -> f64) {
    let mut p = Vec::with_capacity(past.len() + signal.len());
    p.extend(past.iter().rev());
    for (t, v) in signal.iter_mut().enumerate() {
        let new = sum(gain * *v, c, p[t..].iter());
        p.push(newest(*v, new));
        *v = new;
    }
    past.iter_mut().zip(p.iter().rev()).for_each(|(past, p)| *past = *p);
}

/// Oldest first: only one product and one sum wait for the newest output, which is known last.
#[inline(always)]
fn sum<'a>(v: f64, c: &[f64], oldest_first: impl Iterator<Item = &'a f64>) -> f64 {
    c.iter().rev().zip(oldest_first).fold(v, |sum, (c, p)| sum + c * p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    fn table2() -> Arx {
        Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0012, -0.0004, -0.0003]).unwrap()
    }

    #[test]
    fn the_step_response_ends_at_the_dc_gain() {
        let y = table2().simulate(&[1.0; 4000]);
        assert_close(&y[3999..], &[0.0005 / 0.2029], 1e-9, 0.0);
    }

    #[test]
    fn runs_of_any_order_are_equation_1_and_bit_identical_to_repeated_steps() {
        let u: Vec<f64> = (0..300).map(|t| f64::from(t * t % 17)).collect();
        for (na, nb) in (0..12).flat_map(|na| (0..12).map(move |nb| (na, nb))) {
            let a: Vec<f64> = (1..=na).map(|k| 0.6 * (-0.5f64).powi(k)).collect();
            let b: Vec<f64> = (0..=nb).map(|k| (1.3 * f64::from(k)).cos()).collect();
            let arx = Arx::new(1.0, a.clone(), b.clone()).unwrap();
            let y = arx.simulate(&u);
            let mut x = arx.initial();
            assert_eq!(u.iter().map(|&u| arx.step(&mut x, u)).collect::<Vec<_>>(), y);
            let mut parts = arx.initial();
            assert_eq!([arx.resume(&mut parts, &u[..5]), arx.resume(&mut parts, &u[5..])].concat(), y);
            assert_eq!(parts, x);

            let past = |s: &[f64], t: usize, c: &[f64], lag: usize| -> f64 {
                c.iter().enumerate().filter_map(|(k, c)| Some(c * s[t.checked_sub(k + lag)?])).sum()
            };
            let defined: Vec<f64> = (0..u.len()).map(|t| past(&y, t, &a, 1) + past(&u, t, &b, 0)).collect();
            assert_close(&y, &defined, 1e-12, 1e-12);
        }
    }

    #[test]
    fn a_settled_block_stays_settled() {
        let (arx, u) = (table2(), [7.0; 50]);
        let y = arx.resume(&mut arx.settled(7.0), &u);
        assert_close(&y, &[7.0 * arx.dc_gain(); 50], 1e-12, 0.0);
    }

    #[test]
    fn predicting_its_own_simulation_changes_nothing() {
        let u: Vec<f64> = (0..200).map(|t| f64::from(t * t % 17)).collect();
        let arx = table2();
        let y = arx.simulate(&u);
        assert_eq!(arx.predict(&u, &y), y);
    }

    #[test]
    fn a_prediction_uses_the_measured_outputs() {
        let arx = Arx::new(1.0, vec![0.5, -0.25], vec![2.0, 1.0]).unwrap();
        assert_eq!(arx.predict(&[1.0, 0.0, 0.0, 0.0], &[8.0, 4.0, 16.0, 9.0]), [2.0, 5.0, 0.0, 7.0]);
        assert_eq!(Arx::gain(1.0, 3.0).unwrap().predict(&[1.0, 2.0], &[9.0, 9.0]), [3.0, 6.0]);
    }

    #[test]
    fn a_block_has_at_most_512_coefficients_of_each_kind() {
        let block = |na, nb| Arx::new(1.0, vec![0.0; na], vec![1.0; nb]).map_err(|e| e.to_string());
        assert!(block(512, 512).is_ok());
        for (na, nb, expected) in [(513, 1, "a = 513 coefficients"), (1, 513, "b = 513 coefficients")] {
            let message = block(na, nb).unwrap_err();
            assert!(message.starts_with(expected), "{message}");
        }
    }

    #[test]
    fn a_document_with_bad_coefficients_is_an_error() {
        let load = |text: &str| serde_json::from_str::<Arx>(text).map_err(|e| e.to_string());
        assert!(load(r#"{"ts": 1, "a": [], "b": [0]}"#).unwrap_err().contains("a number that is not zero"));
        assert!(load(r#"{"ts": 1, "a": [], "b": []}"#).is_err());
        assert_eq!(load(&serde_json::to_string(&table2()).unwrap()), Ok(table2()));
    }
}
