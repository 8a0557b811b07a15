//! Model predictive control: in every sample, the z over the horizon that minimises the error of y. The first z is
//! converted to a voltage by the inverse of the hysteresis.
//!
//! ```text
//! min over z_t, ..., z_{t+N-1} of  sum |r_{t+d+i} - y_{t+d+i}|^2 / G^2 + move_cost sum |z_{t+i} - z_{t+i-1}|^2
//! y_{t+d+i} = offset + C A^(d+i) s_t + h_d z_{t+i} + ... + h_{d+i} z_t      i = 0, ..., N - 1
//! z_t within the response of the operator to the voltages that limits and slew allow in the next sample
//! z_{t+i} within the major loop; its steps within the slew limit; y within its limits (soft)
//! u_t: operator(u_t) = z_t
//! ```
//! d is the delay of the linear block, h the impulse response of creep and linear block, G their gain. s_t is the
//! estimate of a steady-state observer, with delayed measurements propagated to t. It includes a constant disturbance
//! of z, so that constant errors leave no offset.
//!
//! If the program is not solved in time, the z found so far is clipped to the limits of the next sample, which can
//! always be met. The steps of z after the first are limited by the slopes of the operator at its present state, up and
//! down. With a driver in the model, operator means both: one voltage in and one z out per sample.
//!
//! Reference: G. Pannocchia, J. B. Rawlings, AIChE J. 49, 426 (2003), DOI 10.1002/aic.690490213; U. Maeder, F.
//! Borrelli, M. Morari, Automatica 45, 2214 (2009), DOI 10.1016/j.automatica.2009.05.023. It does not do: operators
//! that fall with their input, a horizon of voltages (not a quadratic program), dead zones that take longer to cross
//! than the horizon. It has no linear law; its robustness is tested with a [`Tolerance`](super::Tolerance).

mod condensed;
mod horizon;
#[cfg(feature = "clarabel")]
mod interior;
mod kalman;
mod limits;
mod realisation;
mod settings;
mod state;
#[cfg(test)]
mod tests;

pub use settings::{PredictiveSettings, Solver};

use super::{Controller, ControllerInput, ControllerKind};
use condensed::SolveResult;
use horizon::Horizon;
use kalman::Observer;
use nalgebra::{DVectorView, DVectorViewMut};
use piezoid_models::hammerstein::Model;
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::series::dot;
use piezoid_numerics::system::System;
use realisation::Realisation;
use state::Parts;
use std::sync::Arc;

/// Distance from a limit that counts as reached, and the smallest move for which a dead zone is crossed, relative to
/// the range of z.
const REACHED_SHARE: f64 = 1e-6;

/// Largest innovation, relative to the range of y; larger ones are clipped.
const MAX_INNOVATION_RATIO: f64 = 10.0;

/// Sensor delay at which the assumed noise has grown by a factor of sqrt(2) [samples]. Of 600 plants of +-20 % around
/// `pl140`, none is unstable with sensor delays up to 20 samples; with 8 instead of 6, some are at 12 and 13.
const NOISE_DELAY_SAMPLES: f64 = 6.0;

/// The controller of a model.
///
/// State, in this order: the estimated state; the predicted measurements that have not arrived; the last z and u; the
/// state of the model; buffers, with the multipliers for the next warm start.
///
/// ```
/// use piezoid::control::{Controller, ControllerInput};
/// use piezoid::{Model, System, hysteresis::Proportional, linear::Arx};
/// use piezoid_control::feedback::predictive::{Predictive, PredictiveSettings};
/// use std::sync::Arc;
/// let linear = Arx::new(5e-4, vec![1.6, -0.8], vec![0.0, 3.0, 3.0])?;
/// let model = Model::new(Arc::new(Proportional::new(5e-4, 1.0)?), linear, 2.0)?;
/// let mpc = Predictive::new(&model, PredictiveSettings::default())?;
/// let (mut x, mut plant) = (mpc.settled(0.0), model.settled(0.0));
/// let mut y = 2.0;
/// for _ in 0..100 {
///     let u = mpc.step(&mut x, &ControllerInput { y, ahead: &[500.0], ..ControllerInput::default() });
///     y = model.step(&mut plant, u);
/// }
/// assert!((y - 500.0).abs() < 1e-6);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Predictive {
    model: Model,
    settings: PredictiveSettings,
    plant: Realisation,
    observer: Observer,
    horizon: Horizon,
    /// z at the ends of the major loop.
    major: (f64, f64),
}

/// The plan of one sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// z of this sample and the next N - 1 [z's unit].
    pub z: Vec<f64>,
    /// The predicted displacement, from the first sample that they act on [output unit].
    pub y: Vec<f64>,
    /// The voltage of this sample [V].
    pub u: f64,
    /// True if the whole plan keeps all hard limits; this sample always does.
    pub solved: bool,
    /// Number of active-set changes.
    pub changes: usize,
}

impl Predictive {
    /// The controller of `model`.
    ///
    /// # Errors
    /// Returns an error for settings outside their range; a horizon that takes too long on the given machine;
    /// displacements out of reach; [`Error::Unsuited`] for an operator that falls with its input (with the voltage) or
    /// is constant; [`Error::Unidentifiable`] for a model in which a constant disturbance is not observable.
    pub fn new(model: &Model, settings: PredictiveSettings) -> Result<Self, Error> {
        settings.check()?;
        // It predicts by the blocks in series.
        let model = &model.without_feedback();
        let (bottom, top) = settings.voltage;
        let unsuited = |because: String| Error::Unsuited { what: "predictive control".into(), because };
        if let Some(u) = model.hysteresis().falling_input(bottom, top) {
            return Err(unsuited(format!(
                "its operator is not monotonic (it falls at {u} V): choose another operator"
            )));
        }
        let major = (model.settled_hidden(bottom), model.settled_hidden(top));
        let range = major.1 - major.0;
        if !(range > 0.0 && range.is_finite()) {
            return Err(unsuited(format!("its hysteresis block gives a constant output between {bottom} and {top} V")));
        }
        let plant = Realisation::new(model.creep(), model.linear());
        settings.check_computing_time(plant.order(), model.ts())?;

        let steady = model.linear().dc_gain().abs();
        let h = plant.impulse(plant.delay + settings.horizon);
        let gain = if steady > 0.0 && steady.is_finite() { steady } else { h.iter().fold(0.0, |m, h| h.abs().max(m)) };
        let p = plant.order() - 1;
        let mut disturbed = &plant.b * plant.b.transpose() * (settings.unexplained * range).powi(2);
        disturbed[(p, p)] += (settings.drift * range).powi(2);
        let trusted = kalman::gain(&plant.a, &plant.c, &disturbed, (settings.noise * range * gain).powi(2))?;
        let result = Predictive {
            observer: Observer::new(&plant.a, &plant.c, trusted, settings.delay_samples),
            horizon: Horizon::new(&plant, gain, &settings)?,
            model: model.clone(),
            settings,
            plant,
            major,
        };
        let (low, high) = result.reachable();
        match result.settings.displacement {
            Some((least, most)) if !(least < high && low < most) => {
                let rule = format!("must overlap with {low} to {high}, the range within the voltage limits");
                Err(Error::parameter("displacement", format!("{least} to {most}"), rule))
            }
            _ => Ok(result),
        }
    }

    /// The lowest and the highest static displacement within the voltage limits [output unit].
    fn reachable(&self) -> (f64, f64) {
        let crept = 1.0 + self.model.creep().lags().iter().map(|lag| lag.gain).sum::<f64>();
        let gain = self.model.linear().dc_gain() * crept;
        if !gain.is_finite() {
            return (f64::NEG_INFINITY, f64::INFINITY);
        }
        let (a, b) = (self.model.offset() + gain * self.major.0, self.model.offset() + gain * self.major.1);
        (a.min(b), a.max(b))
    }

    /// The same as [`Controller::step`], with the whole plan. `r` is the reference from this sample on, `y` the last
    /// measurement [output unit].
    pub fn plan(&self, x: &mut [f64], r: &[f64], y: f64) -> Plan {
        let (u, ended) = self.advance(x, r, y);
        let parts = self.parts(x);
        let y = self.horizon.response(parts.s, parts.z).add_scalar(self.model.offset());
        Plan { z: parts.z.to_vec(), y: y.as_slice().to_vec(), u, solved: ended.solved, changes: ended.changes }
    }

    fn advance(&self, x: &mut [f64], r: &[f64], y: f64) -> (f64, SolveResult) {
        let mut parts = self.parts(x);
        self.observe(&mut parts, y);
        self.without_limits(&mut parts, r);
        let free = parts.z[0];
        let ends = self.ends(parts.last[1]);
        self.limit(&mut parts, ends);
        let ended = match self.settings.solver {
            Solver::ActiveSet => self.horizon.program.solve(parts.z, parts.low, parts.high, parts.scratch),
            #[cfg(feature = "clarabel")]
            Solver::InteriorPoint => self.interior(&mut parts),
        };
        let u = self.voltage(&parts, free, ends);
        parts.last[0] = self.model.step_hidden(parts.model, u);
        parts.last[1] = u;
        (u, ended)
    }

    /// The voltage between `ends` for the first z of the plan; `free` is the optimal z without limits.
    fn voltage(&self, parts: &Parts<'_>, free: f64, ends: (f64, f64)) -> f64 {
        let (low, high) = (parts.low[0], parts.high[0]);
        let z = parts.z[0].clamp(low, high);
        let tiny = REACHED_SHARE * (self.major.1 - self.major.0);
        // In a dead zone z does not change; at its limit the voltage must still cross the zone.
        if z <= low + tiny && free < low - tiny {
            ends.0
        } else if z >= high - tiny && free > high + tiny {
            ends.1
        } else {
            self.model.invert_hidden(parts.model, z, ends)
        }
    }

    /// The predicted measurement, without offset.
    fn predicted(&self, s: &[f64], z: f64) -> f64 {
        dot(self.plant.c.as_slice(), s) + self.plant.d * z
    }

    /// Estimates s of this sample from the last s, the last z, and the measurement `y`, which may be delayed.
    fn observe(&self, parts: &mut Parts<'_>, y: f64) {
        let z = parts.last[0];
        let mut predicted = self.predicted(parts.s, z);
        if let Some(oldest) = parts.unread.first_mut() {
            std::mem::swap(oldest, &mut predicted);
            parts.unread.rotate_left(1);
        }
        let predicted = self.model.offset() + predicted;
        let most = MAX_INNOVATION_RATIO * (self.major.1 - self.major.0) * self.horizon.gain;
        let innovation = Some(y).filter(|y| y.is_finite()).map_or(0.0, |y| (y - predicted).clamp(-most, most));
        let m = parts.s.len();
        let mut next = DVectorViewMut::from_slice(parts.next, m);
        next.gemv(1.0, &self.plant.a, &DVectorView::from_slice(parts.s, m), 0.0);
        next.axpy(z, &self.plant.b, 1.0);
        next.axpy(innovation, &self.observer.state, 1.0);
        parts.unread.iter_mut().zip(&self.observer.unread).for_each(|(unread, gain)| *unread += gain * innovation);
        parts.s.copy_from_slice(parts.next);
    }

    /// The optimal moves without limits.
    fn without_limits(&self, parts: &mut Parts<'_>, r: &[f64]) {
        self.horizon.free(parts.s, parts.errors);
        // A value that is not finite counts as unknown: the previous one is used.
        let known = |r: &&f64| r.is_finite();
        let Some(mut target) = r.iter().find(known) else { return parts.z.fill(parts.last[0]) };
        let (before, r) = r.split_at(self.plant.delay.min(r.len()));
        target = before.iter().rev().find(known).unwrap_or(target);
        for (i, error) in parts.errors.iter_mut().enumerate() {
            target = r.get(i).filter(known).unwrap_or(target);
            *error = target - self.model.offset() - *error;
        }
        self.horizon.without_limits(parts.errors, parts.last[0], parts.z);
    }

    /// Solves the program with the interior-point method.
    #[cfg(feature = "clarabel")]
    fn interior(&self, parts: &mut Parts<'_>) -> SolveResult {
        let g = &self.horizon.program.h * nalgebra::DVector::from_column_slice(parts.z);
        let found = interior::solve(&self.horizon.program, g.as_slice(), parts.low, parts.high);
        found.iter().for_each(|z| parts.z.copy_from_slice(z));
        SolveResult { changes: 0, solved: found.is_some() }
    }
}

impl Controller for Predictive {
    fn ts(&self) -> f64 {
        self.model.ts()
    }

    fn order(&self) -> usize {
        self.lengths().iter().sum()
    }

    fn initial(&self) -> Vec<f64> {
        self.settled(0.0)
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        let z = self.model.settled_hidden(u);
        let mut x = vec![0.0; self.order()];
        let parts = self.parts(&mut x);
        parts.s.copy_from_slice(&self.plant.settled(self.model.creep(), self.model.linear(), z));
        parts.unread.fill(self.predicted(parts.s, z));
        parts.last.copy_from_slice(&[z, u]);
        parts.model.copy_from_slice(&self.model.settled(u));
        x
    }

    /// Uses the reference up to its delay and horizon; after the last known sample it counts as constant.
    /// Without any, z stays constant. Values of the reference and measurements that are not finite are ignored;
    /// innovations are clipped to ten strokes. The feed-forward is ignored.
    fn step(&self, x: &mut [f64], input: &ControllerInput) -> f64 {
        self.advance(x, input.ahead, input.y).0
    }

    fn law(&self) -> Option<Arx> {
        None
    }
}

/// Smallest frequency up to which a model must be identified, as a share of the sampling rate.
const MIN_BAND_RATE_SHARE: f64 = 0.05;

pub(super) const ROW: ControllerKind = ControllerKind {
    name: "predictive",
    summary: "model predictive control with a horizon of 20 samples and limits; needs no feed-forward",
    reference: "Pannocchia & Rawlings 2003, DOI 10.1002/aic.690490213",
    uses_feed_forward: false,
    tune: |path, _| {
        if let Some(known) = path.known_hz().filter(|known| *known < MIN_BAND_RATE_SHARE / path.linear().ts()) {
            let because = format!(
                "it was identified up to {} Hz only, and predictive control could excite a resonance above that: \
                identify with a PRBS as well",
                short(known)
            );
            return Err(Error::Unsuited { what: "predictive control".into(), because });
        }
        let slew = Some(path.slew).filter(|slew| slew.is_finite());
        let usual = PredictiveSettings::default();
        // A delayed measurement is propagated with model errors, so its noise counts as larger.
        let noise = usual.noise * libm::hypot(path.delay_samples as f64 / NOISE_DELAY_SAMPLES, 1.0);
        let settings =
            PredictiveSettings { voltage: path.limits, slew, delay_samples: path.delay_samples, noise, ..usual };
        Predictive::new(&path.model, settings).map(|c| Arc::new(c) as Arc<dyn Controller>)
    },
};
