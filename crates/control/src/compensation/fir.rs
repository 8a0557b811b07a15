//! A filter of finite impulse response with preview.
//!
//! ```text
//! y_t = f_0 x_{t+p} + f_1 x_{t+p-1} + ... + f_n x_{t+p-n}
//! ```
//! On a whole record it has a preview of p samples; as a system, sample by sample, it has a delay of p samples.

use nalgebra::Complex;
use piezoid_models::linear::Response;
use piezoid_models::program::Block;
use piezoid_numerics::complex::{argument, modulus, polar};
use piezoid_numerics::error::{Error, finite, positive};
use piezoid_numerics::series::shift_in;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use std::f64::consts::TAU;

/// The taps and their preview.
///
/// State: the last inputs, newest first.
///
/// ```
/// use piezoid::System;
/// use piezoid_control::compensation::Fir;
/// let mean = Fir::new(1e-3, vec![1.0 / 3.0; 3], 1)?;
/// assert_eq!(mean.whole(&[0.0, 3.0, 6.0]), [1.0, 3.0, 5.0]); // beyond its ends a record is constant
/// assert_eq!(mean.simulate(&[0.0, 3.0, 6.0]), [0.0, 1.0, 3.0]); // the same, a sample later, from rest
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Fir {
    ts: f64,
    pub(super) taps: Vec<f64>,
    ahead: usize,
}

impl Fir {
    /// The filter with these `taps`, sampled every `ts` [s], with a preview of `ahead` samples.
    ///
    /// # Errors
    /// Returns an error for a `ts` that is not positive, no taps, and taps that are not finite.
    pub fn new(ts: f64, taps: Vec<f64>, ahead: usize) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        finite("taps", &taps)?;
        if taps.is_empty() {
            return Err(Error::parameter("taps", "none", "must be at least one number"));
        }
        Ok(Fir { ts, taps, ahead })
    }

    /// Preview on a whole record, which is the delay as a system [samples].
    pub fn ahead(&self) -> usize {
        self.ahead
    }

    /// The response to a whole record, which is constant before its first sample and after its last.
    pub fn whole(&self, x: &[f64]) -> Vec<f64> {
        let last = x.len() as isize - 1;
        let at = |t: usize, k: usize| x[((t + self.ahead) as isize - k as isize).clamp(0, last) as usize];
        (0..x.len()).map(|t| self.taps.iter().enumerate().map(|(k, f)| f * at(t, k)).sum()).collect()
    }

    /// The two filters in series: first this one, then `next`.
    ///
    /// # Errors
    /// Returns an error if the sampling periods differ.
    pub fn then(&self, next: &Fir) -> Result<Fir, Error> {
        Record::same_sampling("the first filter", self.ts, "the next", next.ts)?;
        let mut taps = vec![0.0; self.taps.len() + next.taps.len() - 1];
        for (i, f) in self.taps.iter().enumerate() {
            next.taps.iter().zip(&mut taps[i..]).for_each(|(g, tap)| *tap += f * g);
        }
        Fir::new(self.ts, taps, self.ahead + next.ahead)
    }

    /// Frequency response at `hz` [Hz] over a whole record.
    pub fn response(&self, hz: f64) -> Response {
        let angle = TAU * hz * self.ts;
        let sum: Complex<f64> = self.taps.iter().enumerate().map(|(k, f)| f * polar(1.0, -angle * k as f64)).sum();
        let sum = sum * polar(1.0, angle * self.ahead as f64);
        Response { hz, gain: modulus(sum), phase: argument(sum) }
    }
    /// The filter as a program, sample by sample: a block `preview` with a function of that name, initially settled at
    /// `at_rest`.
    pub fn block(&self, at_rest: f64) -> Block {
        let block = Block::new("preview", "the inverse of the linear block: an FIR filter");
        let block = block.numbers("past", vec![at_rest; self.order()]).table("taps", &self.taps);
        match self.order() {
            0 => block.text("fn preview(u) { return taps[0] * u; }"),
            n => block
                .count("pairs", n / 2)
                .count("kept", n)
                .text(PROGRAM)
                .text(if n % 2 == 1 { ODD } else { "" })
                .text(END),
        }
    }
}

/// Two taps per iteration, which halves the cost of counting.
const PROGRAM: &str = "
fn preview(x: preview, u) {
    let sum = -0.0;
    let newer = u;
    for k in 0..pairs {
        let old = x.past[2 * k];
        let older = x.past[2 * k + 1];
        sum += taps[2 * k + 1] * old;
        sum += taps[2 * k + 2] * older;
        x.past[2 * k] = newer;
        x.past[2 * k + 1] = old;
        newer = older;
    }
";

const ODD: &str = "
    sum += taps[kept] * x.past[kept - 1];
    x.past[kept - 1] = newer;
";

const END: &str = "
    return taps[0] * u + sum;
}
";

impl System for Fir {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        self.taps.len() - 1
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        vec![u; self.order()]
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        let y = self.taps[0] * u + self.taps[1..].iter().zip(&*x).map(|(f, x)| f * x).sum::<f64>();
        shift_in(x, u);
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn sample_by_sample_is_the_whole_record_delayed() {
        let fir = Fir::new(1e-3, vec![0.5, -1.0, 2.0, 0.25], 2).unwrap();
        let x: Vec<f64> = (0..60).map(|t| f64::from(t * t % 17)).collect();
        let delayed = fir.resume(&mut fir.settled(x[0]), &x);
        assert_close(&delayed[2..], &fir.whole(&x)[..58], 0.0, 1e-12);
    }

    #[test]
    fn the_response_is_that_of_a_sine_and_filters_in_series_multiply() {
        let (a, b) = (Fir::new(1e-3, vec![0.2, 0.7, 0.4], 1).unwrap(), Fir::new(1e-3, vec![1.0, -0.5], 0).unwrap());
        let both = a.then(&b).unwrap();
        let [ra, rb, r] = [&a, &b, &both].map(|f| f.response(40.0));
        assert_close(&[r.gain, r.phase], &[ra.gain * rb.gain, ra.phase + rb.phase], 1e-12, 0.0);
        let sine = |gain: f64, phase: f64| -> Vec<f64> {
            (0..200).map(|t| gain * (TAU * 0.04 * f64::from(t) + phase).sin()).collect()
        };
        assert_close(&both.whole(&sine(1.0, 0.0))[2..199], &sine(r.gain, r.phase)[2..199], 0.0, 1e-12);
        assert!(Fir::new(1e-3, vec![], 0).is_err() && a.then(&Fir::new(2e-3, vec![1.0], 0).unwrap()).is_err());
    }
}
