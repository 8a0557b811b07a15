//! Equations for the tests of this module.

use super::estimate::Estimate;
use super::layout::ColumnLayout;
use super::products::Segment;
use crate::hysteresis::{BasisDesign, Operator};
use crate::linear::Arx;
use nalgebra::DMatrix;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// An estimate of an operator with this number of elements, with a block of first order; of `proportional`, with a
/// gain.
pub(super) fn estimate(name: &str, elements: usize) -> Estimate {
    let design = BasisDesign { ts: 5e-4, range: (-30.0, 30.0), elements: Some(elements), frequencies: Vec::new() };
    let a = if name == "proportional" { Vec::new() } else { vec![0.6] };
    let linear = Arx::new(5e-4, a, vec![1.3]).unwrap();
    Estimate::new(None, (Operator::find(name).unwrap().basis)(&design).unwrap(), Vec::new(), linear)
}

/// A block with one pair of poles, of this frequency [Hz] and damping.
pub(super) fn pair(ts: f64, hz: f64, damping: f64) -> Arx {
    let (radius, angle) = ((-damping * TAU * hz * ts).exp(), TAU * hz * ts * (1.0 - damping * damping).sqrt());
    Arx::new(ts, vec![2.0 * radius * angle.cos(), -radius * radius], vec![0.1]).unwrap()
}

/// Products of columns of noise.
pub(super) fn segment(layout: &ColumnLayout, run: usize, fold: Option<usize>, seed: u64) -> Segment {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let rows = DMatrix::<f64>::from_fn(200, layout.columns() + 1, |_, _| StandardNormal.sample(&mut random));
    Segment { run, fold, judged: true, drifts: false, gram: rows.tr_mul(&rows), samples: 200.0 }
}
