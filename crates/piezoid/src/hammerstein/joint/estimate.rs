//! The current estimate of the joint method: every parameter of a model.

use super::layout::ColumnLayout;
use super::runs::TrainingRecord;
use crate::creep::{Creep, Lag};
use crate::driver::DriverModel;
use crate::error::Error;
use crate::hammerstein::Model;
use crate::hysteresis::{Basis, ShapeParameter};
use crate::linear::Arx;
use crate::system::System;

/// y = G C sum_k w_k phi_k: the parameters of each part.
#[derive(Debug)]
pub(super) struct Estimate {
    pub(super) driver: Option<DriverModel>,
    pub(super) basis: Box<dyn Basis>,
    pub(super) weights: Vec<f64>,
    pub(super) lags: Vec<Lag>,
    pub(super) linear: Arx,
}

impl Estimate {
    /// An estimate with unknown weights.
    pub(super) fn new(driver: Option<DriverModel>, basis: Box<dyn Basis>, lags: Vec<Lag>, linear: Arx) -> Self {
        Estimate { driver, weights: vec![0.0; basis.len()], basis, lags, linear }
    }

    pub(super) fn ts(&self) -> f64 {
        self.linear.ts()
    }

    /// The estimate with the parameters `x`, in the order of [`ColumnLayout`]; `None` if G is unstable or they are not
    /// valid.
    pub(super) fn moved(&self, x: &[f64]) -> Option<Self> {
        let layout = ColumnLayout::of(self);
        let lags = self.lags.iter().zip(&x[layout.gains]).map(|(lag, &gain)| Lag { gain, ..*lag }).collect();
        let within = |(shape, &p): (ShapeParameter, &f64)| p.clamp(shape.low, shape.high);
        let shape: Vec<f64> = self.basis.shape().into_iter().zip(&x[layout.shape]).map(within).collect();
        let delay = std::iter::repeat_n(0.0, self.linear.delay());
        let linear =
            Arx::new(self.ts(), x[layout.a].to_vec(), delay.chain(x[layout.b].iter().copied()).collect()).ok()?;
        if !linear.is_stable() {
            return None;
        }
        let basis = self.basis.reshaped(&shape).ok()?;
        Some(Estimate { driver: self.driver, basis, weights: x[layout.weights].to_vec(), lags, linear })
    }

    /// The model, with this output offset.
    pub(super) fn model(&self, offset: f64) -> Result<Model, Error> {
        let hysteresis = self.basis.operator(&self.weights)?;
        // Lags without gain are left out.
        let lags = self.lags.iter().copied().filter(|lag| lag.gain != 0.0).collect();
        Model::driven(self.driver, hysteresis, self.linear.clone(), offset)?.with_creep(Creep::new(self.ts(), lags)?)
    }
}

/// The responses phi of a basis behind a driver, sample by sample.
pub(super) struct Responses<'a> {
    basis: &'a dyn Basis,
    driver: Option<DriverModel>,
    ts: f64,
    x: Vec<f64>,
    v: f64,
    phi: Vec<f64>,
    before: Vec<f64>,
    mean: Vec<f64>,
}

impl<'a> Responses<'a> {
    /// The responses before the first sample of a run, after its past.
    pub(super) fn before(estimate: &'a Estimate, run: &TrainingRecord) -> Self {
        let u = run.record.u();
        let mut responses = Responses::settled(estimate, u[0]);
        if !run.past.is_empty() {
            run.past.iter().chain(&u[..1]).for_each(|&u| _ = responses.next(u));
        }
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
            before: Vec::new(),
            mean: vec![0.0; basis.len()],
        };
        basis.step(&mut responses.x, u, &mut responses.phi);
        responses
    }

    /// The current responses.
    pub(super) fn current(&self) -> &[f64] {
        &self.phi
    }

    /// Advances by one sample.
    pub(super) fn next(&mut self, u: f64) -> &[f64] {
        let Some(driver) = self.driver else {
            self.basis.step(&mut self.x, u, &mut self.phi);
            return &self.phi;
        };
        self.mean.fill(0.0);
        let share = 0.5 / DriverModel::SUBSTEPS as f64;
        for _ in 0..DriverModel::SUBSTEPS {
            self.v = driver.advance(self.v, u, self.ts / DriverModel::SUBSTEPS as f64);
            self.before.clone_from(&self.phi);
            self.basis.step(&mut self.x, self.v, &mut self.phi);
            for ((mean, before), phi) in self.mean.iter_mut().zip(&self.before).zip(&self.phi) {
                *mean += share * (before + phi);
            }
        }
        &self.mean
    }
}
