//! How an operator is fitted without inverting anything: z as a weighted sum of known responses.
//!
//! ```text
//! z = sum_k w_k phi_k[u; p]
//! ```
//! Every operator here but Tellinen's is linear in weights w once a few shape parameters p stand, and an LTI block G
//! keeps that: G z = sum_k w_k (G phi_k). So the weights come from a convex least squares on filtered responses, and
//! only p, where there is any, needs a search (Golub & Pereyra 2003, DOI 10.1088/0266-5611/19/2/201).

use super::Hysteresis;
use crate::error::Error;
use std::fmt::Debug;
use std::sync::Arc;

/// What is known before an operator is fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// Sampling period [s].
    pub ts: f64,
    /// The lowest and the highest input [input unit].
    pub range: (f64, f64),
    /// Thresholds, levels or knots; none takes the operator's own number.
    pub elements: Option<usize>,
    /// Frequencies of the records [Hz], rising; empty where they have none.
    pub frequencies: Vec<f64>,
}

/// The responses phi_k of an operator, and the way back from weights to the operator.
pub trait Basis: Debug + Send + Sync {
    /// Number of weights.
    #[allow(clippy::len_without_is_empty)] // never empty
    fn len(&self) -> usize;

    /// Length of the state.
    fn order(&self) -> usize;

    /// The state at rest: every phi is 0 there.
    fn initial(&self) -> Vec<f64>;

    /// One sample: takes `u`, advances the state `x`, writes the responses to `phi`.
    fn step(&self, x: &mut [f64], u: f64, phi: &mut [f64]);

    /// Which weights physics forbids to be negative.
    fn non_negative(&self) -> Vec<bool>;

    /// Combinations of weights, as (weight, factor) each, that are small when the operator is smooth.
    fn roughness(&self) -> Vec<Vec<(usize, f64)>>;

    /// The shape parameters p: name, value, and the lowest and highest that make sense. Searched by ratio where the
    /// lowest is positive.
    fn shape(&self) -> Vec<Shape> {
        Vec::new()
    }

    /// The same basis with other shape parameters.
    ///
    /// # Errors
    /// What the operator refuses.
    fn reshaped(&self, shape: &[f64]) -> Result<Box<dyn Basis>, Error>;

    /// How z would change with shape parameter `j`, sample by sample: dz/dp_j along `u` from rest.
    fn slope(&self, j: usize, weights: &[f64], u: &[f64]) -> Vec<f64>;

    /// The operator with these weights.
    ///
    /// # Errors
    /// What the operator refuses.
    fn operator(&self, weights: &[f64]) -> Result<Arc<dyn Hysteresis>, Error>;
}

/// A shape parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// As files write it.
    pub name: &'static str,
    /// Where it stands.
    pub value: f64,
    /// The lowest that makes sense.
    pub low: f64,
    /// The highest.
    pub high: f64,
}

/// Second differences of neighbours, `from` up to `to`: what a smooth row of weights makes small.
pub(super) fn curvature(from: usize, to: usize) -> Vec<Vec<(usize, f64)>> {
    (from + 1..to.saturating_sub(1)).map(|k| vec![(k - 1, 1.0), (k, -2.0), (k + 1, 1.0)]).collect()
}
