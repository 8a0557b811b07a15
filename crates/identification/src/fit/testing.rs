//! Equations for the tests of this module.

use super::estimate::Estimate;
use super::layout::ColumnLayout;
use super::products::Segment;
use nalgebra::DMatrix;
use piezoid_models::creep::Lag;
use piezoid_models::driver::DriverModel;
use piezoid_models::hysteresis::{BasisDesign, Operator, ShapeParameter};
use piezoid_models::linear::Arx;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// Sampling period of [`full_estimate`] [s].
pub(crate) const TS: f64 = 5e-4;

/// A full estimate: weights, shapes off their kinks, creep, dynamics with a delay.
pub(super) fn full_estimate(row: &Operator, driver: Option<DriverModel>) -> Estimate {
    let ts = if driver.is_some() { TS / DriverModel::SUBSTEPS as f64 } else { TS };
    let design = BasisDesign { ts, range: (-30.0, 30.0), elements: Some(4), frequencies: vec![5.0, 20.0] };
    let basis = (row.basis)(&design).unwrap();
    let off = |s: &ShapeParameter| s.value + 0.07 * s.value.abs() + 0.003 * (s.high - s.low);
    let basis = basis.reshaped(&basis.shape().iter().map(off).collect::<Vec<_>>()).unwrap();
    let lags = vec![Lag { tau_s: 5e-3, gain: 0.08 }, Lag { tau_s: 5e-2, gain: 0.03 }];
    let linear = Arx::new(TS, vec![1.1, -0.5], vec![0.0, 0.3, 0.2]).unwrap();
    let weights = (0..basis.len()).map(|k| 1.0 + 0.5 * (1.7 * k as f64).sin()).collect();
    Estimate { weights, seeks_lag: driver.is_some(), ..Estimate::new(driver, basis, lags, linear) }
}

/// An estimate of an operator with this number of elements, with a block of first order; of `proportional`, with a
/// gain.
pub(crate) fn estimate(name: &str, elements: usize) -> Estimate {
    let design = BasisDesign { ts: 5e-4, range: (-30.0, 30.0), elements: Some(elements), frequencies: Vec::new() };
    let a = if name == "proportional" { Vec::new() } else { vec![0.6] };
    let linear = Arx::new(5e-4, a, vec![1.3]).unwrap();
    Estimate::new(None, (Operator::find(name).unwrap().basis)(&design).unwrap(), Vec::new(), linear)
}

/// A block with one pair of poles, of this frequency [Hz] and damping.
pub(crate) fn pair(ts: f64, hz: f64, damping: f64) -> Arx {
    let (radius, angle) = ((-damping * TAU * hz * ts).exp(), TAU * hz * ts * (1.0 - damping * damping).sqrt());
    Arx::new(ts, vec![2.0 * radius * angle.cos(), -radius * radius], vec![0.1]).unwrap()
}

/// Products of columns of noise.
pub(crate) fn segment(layout: &ColumnLayout, run: usize, fold: Option<usize>, seed: u64) -> Segment {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let rows = DMatrix::<f64>::from_fn(200, layout.columns() + 1, |_, _| StandardNormal.sample(&mut random));
    Segment { run, fold, judged: true, drifts: false, is_first: true, gram: rows.tr_mul(&rows), samples: 200.0 }
}
