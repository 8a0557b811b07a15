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
//! observer of steady gain makes of the readings, a constant disturbance of z among it: errors that last leave no offset.
//!
//! Where the program has no answer in time, the z found so far is brought within the limits of the next sample, which always
//! can be kept. Steps of z after the first are limited by the mean slope of the operator where it stands.
//!
//! Reference: G. Pannocchia, J. B. Rawlings, AIChE J. 49, 426 (2003), DOI 10.1002/aic.690490213; U. Maeder, F. Borrelli, M.
//! Morari, Automatica 45, 2214 (2009), DOI 10.1016/j.automatica.2009.05.023. It does not do: models behind a driver of their
//! own, operators that fall with their input, a horizon of voltages (which would be no quadratic program). It has no law: what
//! tolerances do to it is asked of [`trials`](super::trials).

mod condensed;
mod interior;
mod kalman;
mod realisation;

use super::{Controller, Law, Now};
use crate::error::{Error, finite, positive};
use crate::hammerstein::Model;
use crate::hysteresis::falls;
use crate::linear::Arx;
use crate::system::System;
use condensed::{Condensed, Ended};
use nalgebra::{Cholesky, DMatrix, DVector, DVectorView, DVectorViewMut};
use realisation::Realisation;
use std::sync::Arc;

/// The longest horizon.
const LONGEST: usize = 200;

/// How much dearer the square of a displacement beyond its limit is than that of an error.
const STIFFNESS: f64 = 1e3;

/// What solves the quadratic program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solver {
    /// A dual active-set method on the condensed program, without allocation.
    ActiveSet,
    /// Clarabel's interior-point method: the yardstick.
    InteriorPoint,
}

/// What the controller is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Samples planned ahead, N.
    pub horizon: usize,
    /// Voltages allowed, lowest and highest [V].
    pub voltage: (f64, f64),
    /// The fastest change of voltage [V/s]; `None` where there is no limit.
    pub slew: Option<f64>,
    /// Displacements allowed, lowest and highest [output unit], kept as far as possible; `None` where there is no limit.
    pub displacement: Option<(f64, f64)>,
    /// What the square of a step of z costs, over that of an error of the same size [-].
    pub move_cost: f64,
    /// How much the disturbance changes in a sample, rms over the range of z [-].
    pub drift: f64,
    /// What of z the model does not explain from sample to sample, rms over the range of z [-].
    pub unexplained: f64,
    /// Noise of a reading, rms over the range of y [-]. Far above what the sensor has where the plant may differ from the
    /// model: the observer then leaves alone what its resonance answers.
    pub noise: f64,
    /// What solves the quadratic program.
    pub solver: Solver,
    /// Multiplications that the machine does in a second, by which horizons are refused that cannot run at Ts.
    pub multiplications_per_second: f64,
}

impl Default for Settings {
    /// 20 samples, +-30 V, no other limit.
    fn default() -> Self {
        Settings {
            horizon: 20,
            voltage: (-30.0, 30.0),
            slew: None,
            displacement: None,
            move_cost: 1e-2,
            drift: 1e-3,
            unexplained: 1e-3,
            noise: 1e-2,
            solver: Solver::ActiveSet,
            multiplications_per_second: 1e9,
        }
    }
}

/// The controller of a model.
///
/// State, in this order: what the observer makes of the model; the last z and u; the operator's; then the buffers of
/// its steps, among them the multipliers that it begins with next time.
///
/// ```
/// use piezoid::control::{Controller, Now, predictive::{Predictive, Settings}};
/// use piezoid::{Model, System, hysteresis::Proportional, linear::Arx};
/// use std::sync::Arc;
/// let linear = Arx::new(5e-4, vec![1.6, -0.8], vec![0.0, 3.0, 3.0])?;
/// let model = Model::new(Arc::new(Proportional::new(5e-4, 1.0)?), linear, 2.0)?;
/// let mpc = Predictive::new(&model, Settings::default())?;
/// let (mut x, mut plant) = (mpc.settled(0.0), model.settled(0.0));
/// let mut y = 2.0;
/// for _ in 0..100 {
///     let u = mpc.step(&mut x, &Now { y, ahead: &[500.0], ..Now::default() });
///     y = model.step(&mut plant, u);
/// }
/// assert!((y - 500.0).abs() < 1e-6);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Predictive {
    model: Model,
    settings: Settings,
    plant: Realisation,
    /// L of the observer.
    observer: DVector<f64>,
    /// C A^(d+i), and h over G.
    free: DMatrix<f64>,
    phi: DMatrix<f64>,
    /// From the errors of the free response, and from the last z, to the moves without limits.
    from_errors: DMatrix<f64>,
    from_last: DVector<f64>,
    /// 1 / |G|.
    scale: f64,
    /// z at the ends of the major loop.
    major: (f64, f64),
    program: Condensed,
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

/// The parts of a state.
struct Parts<'x> {
    s: &'x mut [f64],
    next: &'x mut [f64],
    last: &'x mut [f64],
    operator: &'x mut [f64],
    trial: &'x mut [f64],
    errors: &'x mut [f64],
    z: &'x mut [f64],
    low: &'x mut [f64],
    high: &'x mut [f64],
    scratch: &'x mut [f64],
}

impl Predictive {
    /// The controller of `model`.
    ///
    /// # Errors
    /// Refuses settings outside their domain; a horizon that cannot run at Ts on the machine described; a model behind a
    /// driver, or with an operator that falls with its input, by the voltage where it does; and, as
    /// [`Error::Unidentifiable`], a model whose readings cannot tell a constant disturbance.
    pub fn new(model: &Model, settings: Settings) -> Result<Self, Error> {
        let (n, (bottom, top)) = (settings.horizon, settings.voltage);
        check(&settings)?;
        if model.driver().is_some() {
            let because = "predictive control does not look through a driver: identify the model without one".into();
            return Err(Error::NoInverse { kind: "sampled", because });
        }
        if let Some(u) = falls(model.hysteresis(), bottom, top) {
            let because = format!("its operator falls with its input at {u} V: choose an operator that rises");
            return Err(Error::NoInverse { kind: "unique", because });
        }
        let plant = Realisation::new(model.creep(), model.linear());
        let rows = 2 * n - 1 + if settings.displacement.is_some() { n } else { 0 };
        let affordable = |n: usize, rows: usize| {
            let once = plant.order() * (plant.order() + n) + n * n + condensed::operations(n, rows);
            once as f64 <= settings.multiplications_per_second * model.ts()
        };
        if !affordable(n, rows) {
            let longest = (1..n).rev().find(|&shorter| affordable(shorter, rows * shorter / n)).unwrap_or(0);
            let rule = format!(
                "takes longer than a sample of {} s at {} multiplications a second in the worst case; the longest that does not \
                 is {longest}",
                model.ts(),
                settings.multiplications_per_second
            );
            return Err(Error::parameter("horizon", n, rule));
        }

        let end = |u: f64| model.hysteresis().step(&mut model.hysteresis().settled(u), u);
        let major = (end(bottom), end(top));
        let h = plant.impulse(plant.delay + n);
        let h = &h[plant.delay..];
        let steady = model.linear().dc_gain().abs();
        let gain = if steady > 0.0 && steady.is_finite() { steady } else { h.iter().fold(0.0, |m, h| h.abs().max(m)) };
        let phi = DMatrix::from_fn(n, n, |i, j| if i >= j { h[i - j] / gain } else { 0.0 });

        let steps = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - f64::from(u8::from(i == j + 1)));
        let curvature = phi.transpose() * &phi + settings.move_cost * steps.transpose() * &steps;
        let stiff = || Error::parameter("move_cost", settings.move_cost, "leaves the moves undetermined: raise it");
        let factor = Cholesky::new(curvature.clone()).ok_or_else(stiff)?;
        let mut rows = DMatrix::zeros(rows, n);
        rows.rows_mut(0, n).fill_with_identity();
        rows.rows_mut(n, n - 1).copy_from(&steps.rows(1, n - 1));
        let mut sigma = vec![f64::INFINITY; 2 * n - 1];
        if settings.displacement.is_some() {
            rows.rows_mut(2 * n - 1, n).copy_from(&phi);
            sigma.resize(3 * n - 1, STIFFNESS);
        }

        let range = major.1 - major.0;
        let p = plant.order() - 1;
        let mut disturbed = &plant.b * plant.b.transpose() * (settings.unexplained * range).powi(2);
        disturbed[(p, p)] += (settings.drift * range).powi(2);
        Ok(Predictive {
            observer: kalman::gain(&plant.a, &plant.c, &disturbed, (settings.noise * range * gain).powi(2))?,
            free: plant.free(n),
            from_errors: factor.solve(&phi.transpose()) / gain,
            from_last: factor.solve(&DVector::from_fn(n, |i, _| if i == 0 { settings.move_cost } else { 0.0 })),
            scale: 1.0 / gain,
            program: Condensed::new(curvature, rows, sigma).ok_or_else(stiff)?,
            phi,
            model: model.clone(),
            settings,
            plant,
            major,
        })
    }

    /// What it was asked for.
    pub fn settings(&self) -> &Settings {
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
        let crept = 1.0 + self.model.creep().lags().iter().map(|lag| lag.gain).sum::<f64>();
        let at = |z: f64| self.model.offset() + self.model.linear().dc_gain() * crept * z;
        let (a, b) = (at(self.major.0), at(self.major.1));
        let (mut low, mut high) = (a.min(b), a.max(b));
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

    /// The state after the voltage `u` has stood for a long time.
    pub fn settled(&self, u: f64) -> Vec<f64> {
        let hysteresis = self.model.hysteresis();
        let operator = hysteresis.settled(u);
        let z = hysteresis.step(&mut operator.clone(), u);
        let mut x = vec![0.0; self.order()];
        let parts = self.parts(&mut x);
        parts.s.copy_from_slice(&self.plant.settled(self.model.creep(), self.model.linear(), z));
        parts.last.copy_from_slice(&[z, u]);
        parts.operator.copy_from_slice(&operator);
        x
    }

    fn parts<'x>(&self, x: &'x mut [f64]) -> Parts<'x> {
        let (n, rows) = (self.settings.horizon, self.program.sigma.len());
        let (operator, m) = (self.model.hysteresis().order(), self.plant.order());
        let mut rest = x;
        let mut cut = |length: usize| {
            let (part, left) = std::mem::take(&mut rest).split_at_mut(length);
            rest = left;
            part
        };
        Parts {
            s: cut(m),
            last: cut(2),
            operator: cut(operator),
            trial: cut(operator),
            next: cut(m),
            errors: cut(n),
            z: cut(n),
            low: cut(rows),
            high: cut(rows),
            scratch: cut(self.program.scratch()),
        }
    }

    /// As [`Controller::step`], with the whole plan: `r` is the reference from this sample on, `y` the last reading [output unit].
    pub fn plan(&self, x: &mut [f64], r: &[f64], y: f64) -> Plan {
        let (u, ended) = self.advance(x, r, y);
        let parts = self.parts(x);
        let (s, z) = (DVector::from_column_slice(parts.s), DVector::from_column_slice(parts.z));
        let y = (&self.free * s + &self.phi * z / self.scale).add_scalar(self.model.offset());
        Plan { z: parts.z.to_vec(), y: y.as_slice().to_vec(), u, solved: ended.solved, changes: ended.changes }
    }

    fn advance(&self, x: &mut [f64], r: &[f64], y: f64) -> (f64, Ended) {
        let mut parts = self.parts(x);
        self.observe(&mut parts, y);
        self.without_limits(&mut parts, r);
        let ends = self.ends(parts.last[1]);
        self.limit(&mut parts, ends);
        let ended = match self.settings.solver {
            Solver::ActiveSet => self.program.solve(parts.z, parts.low, parts.high, parts.scratch),
            Solver::InteriorPoint => self.interior(&mut parts),
        };
        let wanted = parts.z[0].clamp(parts.low[0], parts.high[0]);
        let u = self.model.hysteresis().invert(parts.operator, wanted, ends).u;
        parts.last[0] = self.model.hysteresis().step(parts.operator, u);
        parts.last[1] = u;
        (u, ended)
    }

    /// s of this sample, from the last one, the z given then and its reading.
    fn observe(&self, parts: &mut Parts<'_>, y: f64) {
        let z = parts.last[0];
        let predicted = self.model.offset() + dot(self.plant.c.as_slice(), parts.s) + self.plant.d * z;
        let innovation = Some(y - predicted).filter(|e| e.is_finite()).unwrap_or(0.0);
        let m = parts.s.len();
        let mut next = DVectorViewMut::from_slice(parts.next, m);
        next.gemv(1.0, &self.plant.a, &DVectorView::from_slice(parts.s, m), 0.0);
        next.axpy(z, &self.plant.b, 1.0);
        next.axpy(innovation, &self.observer, 1.0);
        parts.s.copy_from_slice(parts.next);
    }

    /// The moves that would be best without limits.
    fn without_limits(&self, parts: &mut Parts<'_>, r: &[f64]) {
        let n = parts.z.len();
        let mut errors = DVectorViewMut::from_slice(parts.errors, n);
        errors.gemv(-1.0, &self.free, &DVectorView::from_slice(parts.s, parts.s.len()), 0.0);
        let wanted = |i: usize| r.get(self.plant.delay + i).or(r.last());
        (0..n).for_each(|i| errors[i] = wanted(i).map_or(0.0, |r| errors[i] + r - self.model.offset()));
        let mut z = DVectorViewMut::from_slice(parts.z, n);
        z.gemv(1.0, &self.from_errors, &errors, 0.0);
        z.axpy(parts.last[0], &self.from_last, 1.0);
    }

    /// The voltages that limits and slew allow after `u`.
    fn ends(&self, u: f64) -> (f64, f64) {
        let (bottom, top) = self.settings.voltage;
        let reach = self.settings.slew.map_or(f64::INFINITY, |slew| slew * self.model.ts());
        ((u - reach).clamp(bottom, top), (u + reach).clamp(bottom, top))
    }

    /// The limits of the rows.
    fn limit(&self, parts: &mut Parts<'_>, ends: (f64, f64)) {
        let mut reached = |u: f64| {
            parts.trial.copy_from_slice(parts.operator);
            self.model.hysteresis().step(parts.trial, u)
        };
        let (low, high) = (reached(ends.0), reached(ends.1));
        let high = high.max(low);
        let n = parts.z.len();
        // Standing still after this sample is always allowed.
        parts.low[..n].fill(self.major.0.min(high));
        parts.high[..n].fill(self.major.1.max(low));
        (parts.low[0], parts.high[0]) = (low, high);
        let slope = if ends.1 > ends.0 { (high - low) / (ends.1 - ends.0) } else { 0.0 };
        let step = self.settings.slew.map_or(f64::INFINITY, |slew| slope * slew * self.model.ts());
        parts.low[n..2 * n - 1].fill(-step);
        parts.high[n..2 * n - 1].fill(step);
        if let Some(allowed) = self.settings.displacement {
            let s = DVectorView::from_slice(parts.s, parts.s.len());
            let mut free = DVectorViewMut::from_slice(parts.errors, n);
            free.gemv(1.0, &self.free, &s, 0.0);
            for (i, free) in free.iter().enumerate() {
                parts.low[2 * n - 1 + i] = (allowed.0 - self.model.offset() - free) * self.scale;
                parts.high[2 * n - 1 + i] = (allowed.1 - self.model.offset() - free) * self.scale;
            }
        }
    }

    /// [`Condensed::solve`] by the interior-point method.
    fn interior(&self, parts: &mut Parts<'_>) -> Ended {
        let g = &self.program.h * DVector::from_column_slice(parts.z);
        let found = interior::solve(&self.program, g.as_slice(), parts.low, parts.high);
        found.iter().for_each(|z| parts.z.copy_from_slice(z));
        Ended { changes: 0, solved: found.is_some() }
    }
}

impl Controller for Predictive {
    fn ts(&self) -> f64 {
        self.model.ts()
    }

    fn order(&self) -> usize {
        let (n, rows) = (self.settings.horizon, self.program.sigma.len());
        2 * self.plant.order() + 2 + 2 * self.model.hysteresis().order() + 2 * n + 2 * rows + self.program.scratch()
    }

    fn initial(&self) -> Vec<f64> {
        self.settled(0.0)
    }

    /// Looks at [`Predictive::preview`] samples of the reference, as far as they are known; after the last its value stands. A
    /// reading that is not finite is left out. The feed-forward is not asked for.
    fn step(&self, x: &mut [f64], now: &Now) -> f64 {
        self.advance(x, now.ahead, now.y).0
    }

    fn law(&self) -> Option<Arx> {
        None
    }
}

pub(super) const ROW: Law = Law {
    name: "predictive",
    summary: "plans 20 samples ahead on the whole model, within its limits; needs no feed-forward",
    reference: "Pannocchia & Rawlings 2003, DOI 10.1002/aic.690490213",
    tune: |path, _| {
        let settings = Settings { voltage: path.limits, ..Settings::default() };
        Predictive::new(&path.model, settings).map(|c| Arc::new(c) as Arc<dyn Controller>)
    },
};

/// Refuses settings outside their domain.
fn check(settings: &Settings) -> Result<(), Error> {
    let Settings { horizon, voltage, slew, displacement, move_cost, drift, unexplained, noise, .. } = settings;
    if !(1..=LONGEST).contains(horizon) {
        return Err(Error::parameter("horizon", horizon, format!("must be from 1 to {LONGEST} samples")));
    }
    for (name, ends) in [("voltage", Some(voltage)), ("displacement", displacement.as_ref())] {
        if let Some((low, high)) = ends.filter(|(low, high)| !(low < high && low.is_finite() && high.is_finite())) {
            return Err(Error::parameter(name, format!("{low} to {high}"), "must go from low to high, both finite"));
        }
    }
    if let Some(slew) = slew {
        positive("slew", *slew, "volts a second")?;
    }
    for (name, share) in [("move_cost", move_cost), ("drift", drift), ("unexplained", unexplained), ("noise", noise)] {
        positive(name, *share, "no unit")?;
    }
    positive("multiplications_per_second", settings.multiplications_per_second, "multiplications a second")?;
    Ok(())
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::realisation::tests::blocks;
    use super::*;
    use crate::hysteresis::operator;
    use crate::testing::assert_close;

    const TS: f64 = 5e-4;

    /// Plays before a creeping resonance; with twice the gain and other loops where it is `off`.
    fn model(off: f64) -> Model {
        let plays = (operator("prandtl-ishlinskii").unwrap().example)(TS).unwrap();
        let (creep, linear) = blocks(1);
        let linear = Arx::new(TS, linear.a().to_vec(), linear.b().iter().map(|b| b * off).collect());
        Model::new(plays, linear.unwrap(), 1.5).unwrap().with_creep(creep).unwrap()
    }

    fn sine(amplitude: f64, n: usize) -> Vec<f64> {
        (0..n).map(|t| amplitude * (t as f64 * 0.06).sin()).collect()
    }

    /// Plans on the way along `r`, with a disturbance of the reading.
    fn follow(mpc: &Predictive, plant: &Model, r: &[f64], disturbance: f64) -> (Vec<f64>, Vec<Plan>) {
        let (mut x, mut truth) = (mpc.settled(0.0), plant.settled(0.0));
        let mut y = plant.step(&mut truth.clone(), 0.0);
        let step = |t: usize| {
            let plan = mpc.plan(&mut x, &r[t..], y);
            y = plant.step(&mut truth, plan.u) + disturbance;
            (y, plan)
        };
        (0..r.len()).map(step).unzip()
    }

    fn rms(a: &[f64], b: &[f64]) -> f64 {
        (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
    }

    #[test]
    fn without_limits_the_moves_are_the_least_squares_of_their_cost() {
        let model = model(1.0);
        let mpc = Predictive::new(&model, Settings { voltage: (-60.0, 60.0), ..Settings::default() }).unwrap();
        let r: Vec<f64> = sine(3.0, 21).iter().map(|r| 1.5 + r).collect();
        let plan = mpc.plan(&mut mpc.settled(0.0), &r, model.offset());
        // One column a move, each the answer of the blocks to it; below, the steps.
        let n = 20;
        let scale = 1.0 / model.linear().dc_gain();
        let mut columns = DMatrix::zeros(2 * n, n);
        for k in 0..n {
            let z: Vec<f64> = (0..n + 1).map(|t| f64::from(u8::from(t == k))).collect();
            let y = model.linear().simulate(&model.creep().simulate(&z));
            (0..n).for_each(|t| columns[(t, k)] = y[t + 1] * scale);
            columns[(n + k, k)] = 0.1;
            if k + 1 < n {
                columns[(n + k + 1, k)] = -0.1;
            }
        }
        let wanted = DVector::from_fn(2 * n, |t, _| if t < n { (r[t + 1] - 1.5) * scale } else { 0.0 });
        let known = columns.svd(true, true).solve(&wanted, 1e-14).unwrap();
        assert!(plan.solved && plan.changes == 0);
        assert_close(&plan.z, known.as_slice(), 0.0, 1e-9);
        assert_close(&[plan.y[0]], &[1.5 + known[0] * mpc.phi[(0, 0)] / scale], 1e-9, 0.0);
    }

    #[test]
    fn a_model_of_itself_is_followed_and_a_wrong_one_nearer_than_without_readings() {
        let r: Vec<f64> = sine(15.0, 800);
        let mpc = Predictive::new(&model(1.0), Settings::default()).unwrap();
        let missed = |off: f64| rms(&follow(&mpc, &model(off), &r, 0.0).0[200..], &r[200..]);
        assert!(missed(1.0) < 0.05, "{}", missed(1.0));
        // Without readings a tenth more gain would miss by a tenth of the rms of r.
        assert!(missed(1.1) < 0.075 * rms(&r[200..], &[0.0; 600]), "{}", missed(1.1));
    }

    #[test]
    fn a_disturbance_that_lasts_leaves_no_offset() {
        let mpc = Predictive::new(&model(1.0), Settings::default()).unwrap();
        for (off, disturbance) in [(1.0, 0.7), (0.85, -0.4)] {
            let (y, _) = follow(&mpc, &model(off), &[6.0; 3000], disturbance);
            assert_close(&y[2900..], &[6.0; 100], 0.0, 1e-3);
        }
    }

    #[test]
    fn voltage_slew_and_displacement_are_kept() {
        let (top, fastest) = (12.0, 1500.0);
        let limits = Settings { voltage: (-top, top), slew: Some(fastest), ..Settings::default() };
        let square: Vec<f64> = (0..600).map(|t| if t % 200 < 100 { 30.0 } else { -30.0 }).collect();
        let mpc = Predictive::new(&model(1.0), limits).unwrap();
        let (_, plans) = follow(&mpc, &model(1.0), &square, 0.0);
        assert!(plans.iter().all(|p| p.solved && p.u.abs() <= top));
        assert!(plans.windows(2).all(|w| (w[1].u - w[0].u).abs() <= fastest * TS * (1.0 + 1e-9)));
        assert!(plans.iter().any(|p| p.u.abs() == top) && plans.iter().any(|p| p.changes > 5));

        let limits = Settings { displacement: Some((-5.0, 6.0)), ..Settings::default() };
        let (y, plans) = follow(&Predictive::new(&model(1.0), limits).unwrap(), &model(1.0), &square, 0.0);
        let (low, high) = crate::series::ends(y);
        assert!(
            plans.iter().all(|p| p.solved) && (-5.1..-4.5).contains(&low) && (5.5..6.1).contains(&high),
            "{low} {high}"
        );
    }

    #[test]
    fn the_interior_point_method_gives_the_same_voltages() {
        let limits = Settings {
            voltage: (-12.0, 12.0),
            slew: Some(1500.0),
            displacement: Some((-9.0, 9.0)),
            ..Settings::default()
        };
        let other = Settings { solver: Solver::InteriorPoint, ..limits.clone() };
        let square: Vec<f64> = (0..150).map(|t| if t % 60 < 30 { 10.0 } else { -10.0 }).collect();
        let voltages = |settings| {
            let mpc = Predictive::new(&model(1.0), settings).unwrap();
            let (y, plans) = follow(&mpc, &model(0.9), &square, 0.0);
            (y, plans.iter().map(|p| p.u).collect::<Vec<f64>>(), plans)
        };
        let (active, interior) = (voltages(limits), voltages(other));
        assert_close(&active.1, &interior.1, 0.0, 1e-6);
        assert!(active.2.iter().any(|p| p.changes > 0) && interior.2.iter().all(|p| p.solved));
    }

    #[test]
    fn readings_that_are_lost_are_bridged_and_runs_repeat_to_the_bit() {
        let mpc = Predictive::new(&model(1.0), Settings::default()).unwrap();
        let r = sine(10.0, 300);
        let run = |lost: bool| {
            let (mut x, plant) = (mpc.settled(0.0), model(1.0));
            let (mut truth, mut y) = (plant.settled(0.0), 1.5);
            let mut ys = Vec::new();
            for t in 0..r.len() {
                let y_read = if lost && t % 7 == 3 { f64::NAN } else { y };
                let u = mpc.step(&mut x, &Now { y: y_read, ahead: &r[t..], ..Now::default() });
                y = plant.step(&mut truth, u);
                ys.push(y);
            }
            ys
        };
        assert_eq!(run(false), run(false));
        assert!(rms(&run(true)[100..], &r[100..]) < 0.05);
    }

    #[test]
    fn what_cannot_be_followed_or_run_is_refused_with_numbers() {
        let limits = Settings { displacement: Some((-5.0, 6.0)), ..Settings::default() };
        let mpc = Predictive::new(&model(1.0), limits).unwrap();
        assert!(mpc.check(&[0.0, 5.9]).is_ok());
        assert!(mpc.check(&[0.0, f64::NAN]).unwrap_err().to_string().starts_with("reference[1] is NaN"));
        assert!(mpc.check(&[0.0, 6.5]).unwrap_err().to_string().contains("reference[1] = 6.5: must lie from -5 to 6"));
        let refused = |settings| Predictive::new(&model(1.0), settings).unwrap_err().to_string();
        assert!(refused(Settings { horizon: 0, ..Settings::default() }).contains("from 1 to 200"));
        assert!(refused(Settings { voltage: (30.0, -30.0), ..Settings::default() }).contains("30 to -30"));
        assert!(refused(Settings { move_cost: f64::NAN, ..Settings::default() }).starts_with("move_cost = NaN"));
        let slow = refused(Settings { multiplications_per_second: 1e7, ..Settings::default() });
        assert!(slow.contains("horizon = 20") && slow.contains("the longest that does not is "), "{slow}");
        let longest = slow.rsplit(' ').next().unwrap().parse().unwrap();
        let at = |horizon| Settings { horizon, multiplications_per_second: 1e7, ..Settings::default() };
        assert!(Predictive::new(&model(1.0), at(longest)).is_ok());
        assert!(Predictive::new(&model(1.0), at(longest + 1)).is_err());
    }
}
