//! A system is a difference equation: one sample in, one sample out, and a state that is a plain vector.
//!
//! Why: docs/decisions/numerics-and-determinism.md, "A model runs block by block".

use std::fmt::Debug;

/// A discrete-time system `y = step(x, u)`: immutable data; the caller owns the state.
///
/// States are plain vectors: a clone allows a trial step, a numeric inverse, or a prediction. A run in parts that
/// carries its state is bit-identical to the whole run.
///
/// ```
/// use piezoid::System;
///
/// #[derive(Debug)]
/// struct Delay(f64);
/// impl System for Delay {
///     fn ts(&self) -> f64 { self.0 }
///     fn order(&self) -> usize { 1 }
///     fn step(&self, x: &mut [f64], u: f64) -> f64 { std::mem::replace(&mut x[0], u) }
/// }
/// assert_eq!(Delay(5e-4).simulate(&[1.0, 2.0, 3.0]), [0.0, 1.0, 2.0]);
/// ```
pub trait System: Debug + Send + Sync {
    /// Sampling period [s].
    fn ts(&self) -> f64;

    /// Length of the state.
    fn order(&self) -> usize;

    /// The state at rest.
    fn initial(&self) -> Vec<f64> {
        vec![0.0; self.order()]
    }

    /// The state after a long time at the constant input `u`. The default is the state after one step from rest, which
    /// is exact for systems without dynamics.
    fn settled(&self, u: f64) -> Vec<f64> {
        let mut x = self.initial();
        self.step(&mut x, u);
        x
    }

    /// A checksum of all its numbers, by which a saved state finds its system again. The default is that of its debug
    /// text.
    fn fingerprint(&self) -> u32 {
        crc32fast::hash(format!("{self:?}").as_bytes())
    }

    /// One sample: advances the state `x` (of length [`order`](System::order)) by the input `u` and returns the output.
    fn step(&self, x: &mut [f64], u: f64) -> f64;

    /// Replaces the inputs in `signal` by the outputs and advances the state `x`. Overridden where that is measurably
    /// faster; the result must be bit-identical to repeated steps.
    fn respond(&self, x: &mut [f64], signal: &mut [f64]) {
        signal.iter_mut().for_each(|v| *v = self.step(x, *v));
    }

    /// The response from the state `x`, which is advanced to the end of the run.
    fn resume(&self, x: &mut [f64], u: &[f64]) -> Vec<f64> {
        let mut y = u.to_vec();
        self.respond(x, &mut y);
        y
    }

    /// The response from rest.
    fn simulate(&self, u: &[f64]) -> Vec<f64> {
        self.resume(&mut self.initial(), u)
    }
}
