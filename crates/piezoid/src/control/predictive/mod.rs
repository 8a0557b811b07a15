//! Model predictive control: at every sample the z of the whole horizon that brings y nearest to the reference, of which the
//! first is turned into a voltage through the inverse of the hysteresis.
//!
//! ```text
//! min over z_t, ..., z_{t+N-1} of  sum |r_{t+d+i} - y_{t+d+i}|^2 / G^2 + move_cost sum |z_{t+i} - z_{t+i-1}|^2
//! y_{t+d+i} = offset + C A^(d+i) s_t + h_d z_{t+i} + ... + h_{d+i} z_t      i = 0, ..., N - 1
//! z_t within what the operator answers to the voltages that limits and slew leave for the next sample
//! z_{t+i} within the major loop; its steps within what the slew moves; y within its limits, softly
//! u_t: operator(u_t) = z_t
//! ```
//! d is the delay of the linear block, h what creep and linear block answer to an impulse, G their gain. s_t is what an
//! observer of steady gain makes of the readings, late ones carried on to t, a constant disturbance of z among it: errors that
//! last leave no offset.
//!
//! Where the program has no answer in time, the z found so far is brought within the limits of the next sample, which always
//! can be kept. Steps of z after the first are limited by the slopes of the operator where it stands, up and down. Where the
//! model has a driver, operator means both: a voltage a sample in, a z a sample out.
//!
//! Reference: G. Pannocchia, J. B. Rawlings, AIChE J. 49, 426 (2003), DOI 10.1002/aic.690490213; U. Maeder, F.
//! Borrelli, M. Morari, Automatica 45, 2214 (2009), DOI 10.1016/j.automatica.2009.05.023. It does not do: operators
//! that fall with their input, a horizon of voltages (which would be no quadratic program), dead zones that take longer
//! to cross than the horizon. It has no law: what tolerances do to it is asked of [`trials`](super::trials).

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
use crate::error::{Error, finite};
use crate::hammerstein::Model;
use crate::linear::Arx;
use crate::number::short;
use crate::series::dot;
use crate::system::System;
use condensed::SolveResult;
use horizon::Horizon;
use kalman::Observer;
use nalgebra::{DVectorView, DVectorViewMut};
use realisation::Realisation;
use state::{Parts, StateLayout};
use std::sync::Arc;

/// How near to a limit z counts as there, and what is not worth crossing a dead zone for, over the range of z.
const CLOSE: f64 = 1e-6;

/// A reading further off what is expected counts as no further than this, over the range of y.
const WILD: f64 = 10.0;

/// Samples over which the model carries a reading on with as much error as is allowed for in one that comes in time: of 600
/// plants of +-20 % about `pl140`, none is unstable by readings up to 20 samples late; with 8, some are by 12 and 13.
const CARRIED: f64 = 6.0;

/// The controller of a model.
///
/// State, in this order: what the observer makes of the model, and of the readings that have not come yet; the last z and u;
/// the model's; then the buffers of its steps, among them the multipliers that it begins with next time.
///
/// ```
/// use piezoid::control::{Controller, ControllerInput, predictive::{Predictive, PredictiveSettings}};
/// use piezoid::{Model, System, hysteresis::Proportional, linear::Arx};
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

/// What is planned at one sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// z of this sample and the next N - 1 [z's unit].
    pub z: Vec<f64>,
    /// The displacement they lead to, from the first that they act on [output unit].
    pub y: Vec<f64>,
    /// The voltage of this sample [V].
    pub u: f64,
    /// Whether all hard limits are kept by the whole plan; those of this sample always are.
    pub solved: bool,
    /// Limits taken in and let go on the way.
    pub changes: usize,
}

impl Predictive {
    /// The controller of `model`.
    ///
    /// # Errors
    /// Refuses settings outside their domain; a horizon that cannot run at Ts on the machine described; displacements that no
    /// voltage leads to; as [`Error::Unsuited`], an operator that falls with its input, by the voltage where it does, or that does
    /// not move; and, as [`Error::Unidentifiable`], a model whose readings cannot tell a constant disturbance.
    pub fn new(model: &Model, settings: PredictiveSettings) -> Result<Self, Error> {
        settings.check()?;
        let (bottom, top) = settings.voltage;
        let unsuited = |because: String| Error::Unsuited { what: "predictive control".into(), because };
        if let Some(u) = model.hysteresis().falling_input(bottom, top) {
            return Err(unsuited(format!("its operator falls with its input at {u} V: choose an operator that rises")));
        }
        let major = (model.settled_hidden(bottom), model.settled_hidden(top));
        let range = major.1 - major.0;
        if !(range > 0.0 && range.is_finite()) {
            return Err(unsuited(format!("its hysteresis does not move between {bottom} and {top} V")));
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
        let made = Predictive {
            observer: Observer::new(&plant.a, &plant.c, trusted, settings.late),
            horizon: Horizon::new(&plant, gain, &settings)?,
            model: model.clone(),
            settings,
            plant,
            major,
        };
        let (low, high) = made.reachable();
        match made.settings.displacement {
            Some((least, most)) if !(least < high && low < most) => {
                let rule = format!("must overlap with {low} to {high}, which the voltages leave to the model");
                Err(Error::parameter("displacement", format!("{least} to {most}"), rule))
            }
            _ => Ok(made),
        }
    }

    /// What it was asked for.
    pub fn settings(&self) -> &PredictiveSettings {
        &self.settings
    }

    /// Samples of the reference that a step looks at, the present one among them.
    pub fn preview(&self) -> usize {
        self.plant.delay + self.settings.horizon
    }

    /// Whether the model can follow `reference` [output unit] at rest, sample by sample; how fast it can is left to the plan.
    ///
    /// # Errors
    /// Names the first sample that is not finite, or that lies beyond what voltage and displacement allow.
    pub fn check(&self, reference: &[f64]) -> Result<(), Error> {
        finite("reference", reference)?;
        let (mut low, mut high) = self.reachable();
        if let Some(allowed) = self.settings.displacement {
            (low, high) = (low.max(allowed.0), high.min(allowed.1));
        }
        match reference.iter().position(|r| !(low..=high).contains(r)) {
            None => Ok(()),
            Some(t) => {
                let rule =
                    format!("must lie from {low} to {high}, what voltage and displacement limits leave to the model");
                Err(Error::parameter(format!("reference[{t}]"), reference[t], rule))
            }
        }
    }

    /// The lowest and the highest displacement that voltages which stand lead to [output unit].
    fn reachable(&self) -> (f64, f64) {
        let crept = 1.0 + self.model.creep().lags().iter().map(|lag| lag.gain).sum::<f64>();
        let gain = self.model.linear().dc_gain() * crept;
        if !gain.is_finite() {
            return (f64::NEG_INFINITY, f64::INFINITY);
        }
        let (a, b) = (self.model.offset() + gain * self.major.0, self.model.offset() + gain * self.major.1);
        (a.min(b), a.max(b))
    }

    fn layout(&self) -> StateLayout {
        let program = &self.horizon.program;
        StateLayout {
            observer: self.plant.order(),
            late: self.settings.late,
            model: self.model.order(),
            horizon: self.settings.horizon,
            rows: program.sigma.len(),
            scratch: program.scratch(),
        }
    }

    /// As [`Controller::step`], with the whole plan: `r` is the reference from this sample on, `y` the last reading [output unit].
    pub fn plan(&self, x: &mut [f64], r: &[f64], y: f64) -> Plan {
        let (u, ended) = self.advance(x, r, y);
        let parts = self.layout().parts(x);
        let y = self.horizon.response(parts.s, parts.z).add_scalar(self.model.offset());
        Plan { z: parts.z.to_vec(), y: y.as_slice().to_vec(), u, solved: ended.solved, changes: ended.changes }
    }

    fn advance(&self, x: &mut [f64], r: &[f64], y: f64) -> (f64, SolveResult) {
        let mut parts = self.layout().parts(x);
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

    /// The voltage between `ends` for the first z that was found, where without limits it would be `free`.
    fn voltage(&self, parts: &Parts<'_>, free: f64, ends: (f64, f64)) -> f64 {
        let (low, high) = (parts.low[0], parts.high[0]);
        let z = parts.z[0].clamp(low, high);
        let tiny = CLOSE * (self.major.1 - self.major.0);
        // At its limit z may stand still on the way through a dead zone, which has to be crossed.
        if z <= low + tiny && free < low - tiny {
            ends.0
        } else if z >= high - tiny && free > high + tiny {
            ends.1
        } else {
            self.model.invert_hidden(parts.model, z, ends)
        }
    }

    /// The reading of a sample, less its offset.
    fn predicted(&self, s: &[f64], z: f64) -> f64 {
        dot(self.plant.c.as_slice(), s) + self.plant.d * z
    }

    /// s of this sample, from the last one, the z given then, and the reading that came, of that sample or of a late one.
    fn observe(&self, parts: &mut Parts<'_>, y: f64) {
        let z = parts.last[0];
        let mut predicted = self.predicted(parts.s, z);
        if let Some(oldest) = parts.unread.first_mut() {
            std::mem::swap(oldest, &mut predicted);
            parts.unread.rotate_left(1);
        }
        let predicted = self.model.offset() + predicted;
        let most = WILD * (self.major.1 - self.major.0) * self.horizon.gain;
        let innovation = Some(y).filter(|y| y.is_finite()).map_or(0.0, |y| (y - predicted).clamp(-most, most));
        let m = parts.s.len();
        let mut next = DVectorViewMut::from_slice(parts.next, m);
        next.gemv(1.0, &self.plant.a, &DVectorView::from_slice(parts.s, m), 0.0);
        next.axpy(z, &self.plant.b, 1.0);
        next.axpy(innovation, &self.observer.state, 1.0);
        parts.unread.iter_mut().zip(&self.observer.unread).for_each(|(unread, gain)| *unread += gain * innovation);
        parts.s.copy_from_slice(parts.next);
    }

    /// The moves that would be best without limits.
    fn without_limits(&self, parts: &mut Parts<'_>, r: &[f64]) {
        self.horizon.free(parts.s, parts.errors);
        // What is no number is not known: the value before it stands.
        let told = |r: &&f64| r.is_finite();
        let Some(mut wanted) = r.iter().find(told) else { return parts.z.fill(parts.last[0]) };
        let (before, r) = r.split_at(self.plant.delay.min(r.len()));
        wanted = before.iter().rev().find(told).unwrap_or(wanted);
        for (i, error) in parts.errors.iter_mut().enumerate() {
            wanted = r.get(i).filter(told).unwrap_or(wanted);
            *error = wanted - self.model.offset() - *error;
        }
        self.horizon.without_limits(parts.errors, parts.last[0], parts.z);
    }

    /// The program by the interior-point method.
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
        self.layout().length()
    }

    fn initial(&self) -> Vec<f64> {
        self.settled(0.0)
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        let z = self.model.settled_hidden(u);
        let mut x = vec![0.0; self.order()];
        let parts = self.layout().parts(&mut x);
        parts.s.copy_from_slice(&self.plant.settled(self.model.creep(), self.model.linear(), z));
        parts.unread.fill(self.predicted(parts.s, z));
        parts.last.copy_from_slice(&[z, u]);
        parts.model.copy_from_slice(&self.model.settled(u));
        x
    }

    /// Looks at [`Predictive::preview`] samples of the reference, as far as they are known; after the last its value stands, and
    /// without any z. A reading that is not finite is left out, and so is such a sample of the reference; one that is wildly off
    /// counts as ten strokes off. The feed-forward is not asked for.
    fn step(&self, x: &mut [f64], input: &ControllerInput) -> f64 {
        self.advance(x, input.ahead, input.y).0
    }

    fn law(&self) -> Option<Arx> {
        None
    }
}

/// Share of the sampling rate up to which a model must be known to be planned on.
const KNOWN: f64 = 0.05;

pub(super) const ROW: ControllerKind = ControllerKind {
    name: "predictive",
    summary: "plans 20 samples ahead on the whole model, within its limits; needs no feed-forward",
    reference: "Pannocchia & Rawlings 2003, DOI 10.1002/aic.690490213",
    uses_feed_forward: false,
    tune: |path, _| {
        if let Some(known) = path.known_hz().filter(|known| *known < KNOWN / path.linear().ts()) {
            let because = format!(
                "it was identified up to {} Hz and knows nothing of a resonance beyond, which a plan would set off: identify it on a \
                 PRBS too",
                short(known)
            );
            return Err(Error::Unsuited { what: "predictive control".into(), because });
        }
        let slew = Some(path.slew).filter(|slew| slew.is_finite());
        let usual = PredictiveSettings::default();
        // A late reading is carried on by a model that errs: it counts for less.
        let noise = usual.noise * (path.late as f64 / CARRIED).hypot(1.0);
        let settings = PredictiveSettings { voltage: path.limits, slew, late: path.late, noise, ..usual };
        Predictive::new(&path.model, settings).map(|c| Arc::new(c) as Arc<dyn Controller>)
    },
};
