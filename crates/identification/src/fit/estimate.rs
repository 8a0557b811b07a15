//! The current estimate of the joint method: every parameter of a model.

use super::layout::ColumnLayout;
use super::runs::TrainingRecord;
use super::signals::add;
use libm::pow;
use piezoid_models::creep::{Creep, Lag};
use piezoid_models::driver::DriverModel;
use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_models::hysteresis::Basis;
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use std::ops::Range;
use std::sync::Arc;

/// Gain up to which a lag of creep is left out of the model.
const NEGLIGIBLE_CREEP_GAIN: f64 = 1e-7;

/// Least lag of a driver that is sought [samples].
const MIN_DRIVER_LAG: f64 = 0.05;

/// y = G C sum_k w_k phi_k: the parameters of each part.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    pub driver: Option<DriverModel>,
    /// True if the lag of the driver is a parameter.
    pub(crate) seeks_lag: bool,
    pub(crate) basis: Arc<dyn Basis>,
    pub(crate) weights: Vec<f64>,
    pub(crate) lags: Vec<Lag>,
    /// The order of creep, if the gains of its lags are that power of their time constants.
    pub(crate) creep_order: Option<CreepOrder>,
    pub(crate) linear: Arx,
}

/// The order of creep that is a power of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CreepOrder {
    pub(crate) value: f64,
    /// Its standard error.
    pub(crate) error: f64,
}

impl Estimate {
    /// An estimate with unknown weights.
    pub(crate) fn new(driver: Option<DriverModel>, basis: Box<dyn Basis>, lags: Vec<Lag>, linear: Arx) -> Self {
        let weights = vec![0.0; basis.len()];
        Estimate { driver, seeks_lag: false, weights, basis: basis.into(), lags, creep_order: None, linear }
    }

    /// The same driver, creep and linear block behind another hysteresis, with unknown weights.
    pub(crate) fn with_basis(&self, basis: Box<dyn Basis>) -> Self {
        Estimate { weights: vec![0.0; basis.len()], basis: basis.into(), ..self.clone() }
    }

    /// The same estimate with another linear block.
    pub(crate) fn with_linear(&self, linear: Arx) -> Self {
        Estimate { linear, ..self.clone() }
    }

    /// The shape parameters of the hysteresis.
    pub(crate) fn shape(&self) -> Vec<f64> {
        self.basis.shape().iter().map(|shape| shape.value).collect()
    }

    /// The limits of the shape parameters, then those of the lag of a driver that is sought.
    pub(super) fn shape_limits(&self) -> impl Iterator<Item = (f64, f64)> {
        let of_lag = self.seeks_lag.then(|| (MIN_DRIVER_LAG * self.ts(), f64::INFINITY));
        self.basis.shape().into_iter().map(|shape| (shape.low, shape.high)).chain(of_lag)
    }

    /// The ratio of the gain of a lag of creep to that of the next faster one, if creep has one order.
    pub(super) fn gain_ratio(&self) -> Option<f64> {
        let (order, [faster, lag]) = (self.creep_order?, self.lags.first_chunk()?);
        Some(pow(lag.tau_s / faster.tau_s, order.value))
    }

    pub(crate) fn ts(&self) -> f64 {
        self.linear.ts()
    }

    /// The estimate with the parameters `x`, in the order of [`ColumnLayout`]; `None` if G is unstable or they are not
    /// valid.
    pub(crate) fn moved(&self, x: &[f64]) -> Option<Self> {
        self.moved_within(x, &Some)
    }

    /// The same with the linear block that `limited` gives.
    pub(super) fn moved_within(&self, x: &[f64], limited: &dyn Fn(Arx) -> Option<Arx>) -> Option<Self> {
        let layout = ColumnLayout::of(self);
        let coefficients = |range: Range<usize>| of_differences(&x[range]);
        let lags = self.lags.iter().zip(&x[layout.gains]).map(|(lag, &gain)| Lag { gain, ..*lag }).collect();
        let within = |((low, high), p): ((f64, f64), &f64)| p.clamp(low, high);
        let mut shape: Vec<f64> = self.shape_limits().zip(&x[layout.shape]).map(within).collect();
        let delay = std::iter::repeat_n(0.0, self.linear.delay());
        let linear = Arx::new(self.ts(), coefficients(layout.a), delay.chain(coefficients(layout.b)).collect()).ok()?;
        let linear = limited(linear).filter(Arx::is_stable)?;
        let driver = match shape.pop_if(|_| self.seeks_lag) {
            Some(lag_s) => Some(DriverModel { lag_s, ..self.driver? }),
            None => self.driver,
        };
        let basis = self.basis.reshaped(&shape).ok()?.into();
        let weights = x[layout.weights].to_vec();
        let Estimate { seeks_lag, creep_order, .. } = *self;
        Some(Estimate { driver, seeks_lag, basis, weights, lags, creep_order, linear })
    }

    /// The model, with this output offset.
    pub(crate) fn model(&self, offset: f64) -> Result<Model, Error> {
        let hysteresis = self.basis.operator(&self.weights)?;
        let lags = self.lags.iter().copied().filter(|lag| lag.gain > NEGLIGIBLE_CREEP_GAIN).collect();
        Model::from_blocks(self.driver, hysteresis, self.linear.clone(), offset)?
            .with_creep(Creep::new(self.ts(), lags)?)
    }
}

/// The coefficients of the elements from those of their differences of order 0, 1, 2 ... at the first element (v_0,
/// v_0 - v_1, v_0 - 2 v_1 + v_2 ...), and the reverse: the matrix is its own inverse.
/// Slow inputs determine the coefficients of the differences, but not those of single elements, which are nearly equal.
pub(crate) fn of_differences(c: &[f64]) -> Vec<f64> {
    let mut c = c.to_vec();
    for order in (1..c.len()).rev() {
        for k in order..c.len() {
            c[k - 1] += c[k];
            c[k] = -c[k];
        }
    }
    c
}

/// The responses phi of a basis behind a driver, sample by sample.
pub(crate) struct Responses<'a> {
    basis: &'a dyn Basis,
    driver: Option<DriverModel>,
    ts: f64,
    x: Vec<f64>,
    v: f64,
    phi: Vec<f64>,
    mean: Vec<f64>,
    /// True if the first sample is the one at which they are settled: it is not a step.
    is_first: bool,
}

impl<'a> Responses<'a> {
    /// The responses about which creep and linear block are settled before a run: zero at rest, the mean over the
    /// inputs that pass them before the record, or the last responses.
    pub(crate) fn level(estimate: &'a Estimate, run: &TrainingRecord) -> Vec<f64> {
        let mut responses = Responses::from_rest(estimate, run);
        let mut mean = vec![0.0; estimate.basis.len()];
        let moving = run.moving;
        for (k, &u) in run.before.iter().enumerate().skip(1) {
            let phi = responses.next(u);
            if k + moving >= run.before.len() {
                add(&mut mean, 1.0 / moving as f64, phi);
            }
        }
        match run.initial {
            InitialCondition::Motion => mean,
            // It jumps to the first input.
            InitialCondition::Rest => vec![0.0; estimate.basis.len()],
            _ => responses.phi,
        }
    }

    /// The responses at the first of the inputs before a run.
    pub(crate) fn from_rest(estimate: &'a Estimate, run: &TrainingRecord) -> Self {
        let is_first = run.initial == InitialCondition::Settled;
        Responses { is_first, ..Responses::settled(estimate, run.before[0]) }
    }

    /// The responses before the first input that passes creep and linear block.
    pub(crate) fn before_moving(estimate: &'a Estimate, run: &TrainingRecord) -> Self {
        let mut responses = Responses::from_rest(estimate, run);
        run.before[1..run.before.len() - run.moving].iter().for_each(|&u| _ = responses.next(u));
        responses
    }

    /// The responses from rest, settled at `u`.
    fn settled(estimate: &'a Estimate, u: f64) -> Self {
        let basis = &*estimate.basis;
        let mut responses = Responses {
            basis,
            driver: estimate.driver,
            ts: estimate.ts(),
            x: basis.initial(),
            v: u,
            phi: vec![0.0; basis.len()],
            mean: vec![0.0; basis.len()],
            is_first: false,
        };
        basis.step(&mut responses.x, u, &mut responses.phi);
        responses
    }

    /// Advances by one sample.
    pub(crate) fn next(&mut self, u: f64) -> &[f64] {
        if std::mem::take(&mut self.is_first) {
            return &self.phi;
        }
        let Some(driver) = self.driver else {
            self.basis.step(&mut self.x, u, &mut self.phi);
            return &self.phi;
        };
        // The mean of a sample, by the trapezoidal rule.
        let share = 1.0 / DriverModel::SUBSTEPS as f64;
        self.mean.iter_mut().zip(&self.phi).for_each(|(mean, phi)| *mean = 0.5 * share * phi);
        for substep in 1..=DriverModel::SUBSTEPS {
            self.v = driver.advance(self.v, u, self.ts / DriverModel::SUBSTEPS as f64);
            self.basis.step(&mut self.x, self.v, &mut self.phi);
            add(&mut self.mean, if substep == DriverModel::SUBSTEPS { 0.5 * share } else { share }, &self.phi);
        }
        &self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hysteresis::{BasisDesign, OPERATORS};
    use piezoid_numerics::series::dot;
    use piezoid_testing::assert_close;

    /// The differences of `v` of order 0, 1, 2 ... at its first element: v_0, v_0 - v_1, v_0 - 2 v_1 + v_2 ...
    fn differences(v: &mut [f64]) {
        for order in 1..v.len() {
            for k in (order..v.len()).rev() {
                v[k] = v[k - 1] - v[k];
            }
        }
    }

    #[test]
    fn coefficients_of_differences_are_those_of_the_elements() {
        let (c, v) = ([0.7, -1.3, 0.4, 2.0], [3.0, -1.0, 0.5, 7.0]);
        let mut d = v;
        differences(&mut d);
        assert_close(&[dot(&c, &d)], &[dot(&of_differences(&c), &v)], 1e-12, 0.0);
        assert_close(&of_differences(&of_differences(&c)), &c, 1e-12, 0.0);
        // A constant has no differences, a line no second ones.
        let mut line = [1.0, 2.0, 3.0, 4.0];
        differences(&mut line);
        assert_eq!(line[2..], [0.0, 0.0]);
    }

    #[test]
    fn a_basis_of_its_own_shape_is_the_same_to_the_bit() {
        for row in OPERATORS {
            let design = BasisDesign { ts: 5e-4, range: (-8.0, 32.0), elements: Some(5), frequencies: vec![5.0, 16.0] };
            let basis = (row.basis)(&design).unwrap();
            let shape: Vec<f64> = basis.shape().iter().map(|shape| shape.value).collect();
            let same = basis.reshaped(&shape).unwrap();
            let weights: Vec<f64> = (0..basis.len()).map(|k| 1.0 + 0.5 * (1.7 * k as f64).sin()).collect();
            let u: Vec<f64> = (0..300).map(|t| 12.0 + 20.0 * (0.05 * f64::from(t)).sin()).collect();
            let [z, again] = [&basis, &same].map(|basis| basis.operator(&weights).unwrap().simulate(&u));
            assert_eq!(z, again, "{}", row.name);
            let (mut x, mut phi, mut other) = (basis.initial(), vec![0.0; basis.len()], vec![0.0; basis.len()]);
            let mut y = x.clone();
            for u in u {
                basis.step(&mut x, u, &mut phi);
                same.step(&mut y, u, &mut other);
                assert_eq!(phi, other, "{}", row.name);
            }
        }
    }
}
