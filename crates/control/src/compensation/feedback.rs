//! The inverse of mechanics with hysteresis in feedback, for a whole reference.
//!
//! The displacement of a mode and its derivatives give the force on it, and this the input, without a differential
//! equation (the system is flat):
//! ```text
//! a = p''/w^2 + 2 zeta p'/w,     F = p + a / (1 - softening |a|)
//! displacement drives the hysteresis:  z = H(k p) + creep,     u = (F - e z) / b
//! input and vibration drive it:        z = F / e,              d_s u = H^-1(z - creep) - k (p - F)
//! input and displacement drive it:     z = F / e,              d_s u = H^-1(z - creep) - k p
//! ```
//! Further modes and direct paths count by their static shares; what this leaves, and the hold of the input, the
//! iterations correct: r_{j+1} = r_j + (r - y_j).
//!
//! Reference: M. Fliess, J. Levine, P. Martin, P. Rouchon, Int. J. Control 61 (1995), DOI 10.1080/00207179508921959
//! (flatness).

use super::{Compensated, FeedForward, InverseRun};
use piezoid_models::creep::Creep;
use piezoid_models::feedback::{FeedbackDynamics, FeedbackMode, FeedbackModel, Intersample};
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use std::f64::consts::TAU;

/// Iterations of the inverse of mechanics in feedback, if no more are requested: it is exact only for infinitely many
/// samples.
const LEAST_ITERATIONS: usize = 10;

/// The inverse of a feedback model.
#[derive(Debug)]
pub(super) struct Flat<'a> {
    model: &'a FeedbackModel,
    mode: FeedbackMode,
    /// Share of the mode in the static displacement.
    share: f64,
    creep: Creep,
}

impl<'a> Flat<'a> {
    /// `None` if the model has no such inverse: without a mode, or if neither input nor displacement drives the
    /// hysteresis in such a way.
    pub(super) fn of(model: &'a FeedbackModel) -> Option<Self> {
        let FeedbackDynamics { modes, sensed, senses_vibration, direct, creep, .. } = model.dynamics();
        let mode = *modes.first()?;
        let all = |of: fn(&FeedbackMode) -> f64| modes.iter().map(of).sum::<f64>();
        let by_displacement = mode.sensed != 0.0 && !senses_vibration && *sensed == 0.0 && mode.input != 0.0;
        let by_input = *sensed != 0.0 && mode.hysteretic != 0.0;
        let has_input = modes.iter().any(|mode| mode.input != 0.0) || direct[0] != 0.0;
        let share = match (by_displacement, by_input && !has_input) {
            (true, _) => mode.input / (all(|mode| mode.input) + direct[0]),
            (_, true) => mode.hysteretic / (all(|mode| mode.hysteretic) + direct[1]),
            _ => return None,
        };
        let creep = Creep::new(model.ts(), creep.clone()).ok()?;
        share.is_finite().then_some(Flat { model, mode, share, creep })
    }

    /// The input for the readings `r`, from rest, then settled at the first of them; `ends` are the lowest and the
    /// highest input.
    pub(super) fn input(&self, r: &[f64], ends: (f64, f64)) -> Vec<f64> {
        let FeedbackDynamics { intersample, delay, curve, offset, .. } = self.model.dynamics();
        // The displacement at the end of each sample.
        let at = |t: usize| straight(sample(r, t, *delay as isize) - offset, *curve);
        let p: Vec<f64> = (0..r.len()).map(|t| self.share * at(t)).collect();
        let voltage = self.voltages(&p, ends);
        let lag = match intersample {
            Intersample::Driven(driver) => driver.lag_s,
            _ => 0.0,
        };
        let before = |t: usize| voltage[t.saturating_sub(1)];
        let of = |t: usize| match intersample {
            Intersample::BandLimited => voltage[t],
            // Held from the end of the sample before.
            _ => 0.5 * (voltage[t] + before(t)) + lag * (voltage[t] - before(t)) / self.model.ts(),
        };
        (0..r.len()).map(of).collect()
    }

    /// The input behind the driver at the end of each sample, for the displacement `p` of the mode.
    fn voltages(&self, p: &[f64], ends: (f64, f64)) -> Vec<f64> {
        let FeedbackMode { hz, damping, input, hysteretic, sensed, softening } = self.mode;
        let FeedbackDynamics { modes, sensed: by_input, senses_vibration, .. } = self.model.dynamics();
        let (w, h) = (TAU * hz, self.model.ts());
        let hysteresis = self.model.hysteresis();
        let mut x = hysteresis.initial();
        // Creep is settled at the first sample.
        let (creep, mut crept) = (&self.creep, None::<Vec<f64>>);
        let settled = creep.step(&mut creep.settled(1.0), 1.0);
        // An input at a limit of this search is beyond those that are allowed.
        let beyond = ends.1 - ends.0;
        let limits = [ends.0 - beyond, ends.1 + beyond].map(|u| u * by_input);
        let moved = p.iter().fold(0.0f64, |most, p| most.max((sensed * p).abs()));
        let limits = (limits[0].min(limits[1]) - moved, limits[0].max(limits[1]) + moved);
        let all: f64 = modes.iter().map(|mode| mode.sensed * mode.hysteretic).sum::<f64>() / hysteretic;
        let mut of = |t: usize| {
            let [speed, acceleration] = derivatives(p, t, h);
            let a = acceleration / (w * w) + 2.0 * damping * speed / w;
            let force = p[t] + a / (1.0 - softening * a.abs()).max(0.1);
            if *by_input == 0.0 {
                let inner = hysteresis.step(&mut x, sensed * p[t]);
                let z = creep.step(crept.get_or_insert_with(|| creep.settled(inner)), inner);
                return (force - hysteretic * z) / input;
            }
            let z = force / hysteretic;
            let before_creep = crept.as_ref().map_or(z / settled, |crept| creep.invert(crept, z));
            let s = hysteresis.invert(&x, before_creep, limits).u;
            let inner = hysteresis.step(&mut x, s);
            creep.step(crept.get_or_insert_with(|| creep.settled(inner)), inner);
            let back = match senses_vibration {
                // The vibration of the other modes is taken for that of the first one.
                true => all * (p[t] - force),
                // The other modes follow the force.
                false => sensed * p[t] + (all - sensed) * force,
            };
            (s - back) / by_input
        };
        (0..p.len()).map(&mut of).collect()
    }
}

impl FeedForward {
    /// The voltage for the reference `r` by the inverse of mechanics in feedback; iterations correct what it leaves.
    pub(super) fn in_feedback(&self, flat: &Flat, r: &[f64]) -> Result<Compensated, Error> {
        let invert = |target: &[f64]| self.limited(flat.input(target, self.ends));
        let most = self.settings.iterations.max(LEAST_ITERATIONS);
        let (best, ..) = self.corrected(r, r.to_vec(), most, invert, smooth)?;
        self.compensated(best, Vec::new())
    }

    /// The response to the inputs `u`, within the limits.
    fn limited(&self, mut u: Vec<f64>) -> InverseRun {
        let mut run = InverseRun::default();
        let mut before = u.first().copied().unwrap_or_default().clamp(self.ends.0, self.ends.1);
        for (t, u) in u.iter_mut().enumerate() {
            let (low, high) = self.from(before);
            if !(low..=high).contains(u) {
                run.clipped += 1;
                run.missed = run.missed.or(Some(t));
            }
            *u = u.clamp(low, high);
            before = *u;
        }
        let start = u.first().copied().unwrap_or_default();
        InverseRun { reached: self.whole.follow(&mut self.whole.settled(start), &u), u, ..run }
    }
}

/// q of q + c q^2 = y.
fn straight(y: f64, c: f64) -> f64 {
    2.0 * y / (1.0 + (1.0 + 4.0 * c * y).max(0.0).sqrt())
}

/// `x` without what is near half the sampling rate, where the inverse lacks the other modes: cos^4(pi f / fs) remains.
fn smooth(x: &[f64]) -> Vec<f64> {
    let mean = |t: usize| {
        let [a, b, c, d, e] = [-2, -1, 0, 1, 2].map(|k| sample(x, t, k));
        (a + 4.0 * b + 6.0 * c + 4.0 * d + e) / 16.0
    };
    (0..x.len()).map(mean).collect()
}

/// The sample `k` after sample `t`: the first one before the record, and after it the record turned about its end.
fn sample(x: &[f64], t: usize, k: isize) -> f64 {
    let (at, last) = ((t as isize + k).max(0) as usize, x.len() - 1);
    if at > last { 2.0 * x[last] - x[(2 * last).saturating_sub(at)] } else { x[at] }
}

/// First and second derivative at sample `t`, of fourth order.
fn derivatives(p: &[f64], t: usize, h: f64) -> [f64; 2] {
    let [a, b, c, d, e] = [-2, -1, 0, 1, 2].map(|k| sample(p, t, k));
    [(a - 8.0 * b + 8.0 * d - e) / (12.0 * h), (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / (12.0 * h * h)]
}

#[cfg(test)]
mod tests {
    use super::super::FeedForwardSettings;
    use super::*;
    use piezoid_models::creep::Lag;
    use piezoid_models::driver::DriverModel;
    use piezoid_models::hammerstein::Model;
    use piezoid_models::hysteresis::Operator;
    use piezoid_models::linear::Arx;
    use piezoid_records::excitation::Limits;

    const TS: f64 = 5e-4;

    fn mode() -> FeedbackMode {
        FeedbackMode { hz: 160.0, damping: 0.03, input: 0.0, hysteretic: 0.9, sensed: -0.02, softening: 1e-3 }
    }

    /// A bender whose vibration, or displacement, acts on the voltage, and an oscillator whose displacement drives the
    /// hysteresis.
    fn models() -> [FeedbackModel; 3] {
        let driver = DriverModel::new(1e-4, Some(1e5)).unwrap();
        let other = FeedbackMode { hz: 900.0, hysteretic: 0.07, softening: 0.0, ..mode() };
        let bender = FeedbackDynamics {
            intersample: Intersample::Driven(driver),
            delay: 1,
            modes: vec![mode(), other],
            senses_vibration: true,
            direct: [0.0, 0.03],
            creep: vec![Lag { tau_s: 0.02, gain: 0.05 }, Lag { tau_s: 1.0, gain: 0.04 }],
            curve: 1e-4,
            offset: 3.0,
            ..FeedbackDynamics::default()
        };
        let of_mode = FeedbackMode { input: 1.5, hysteretic: -0.4, sensed: 1.0, softening: 0.0, ..mode() };
        let oscillator = FeedbackDynamics { modes: vec![of_mode], sensed: 0.0, ..FeedbackDynamics::default() };
        let of = |dynamics, name: &str| {
            FeedbackModel::new(TS, dynamics, (Operator::find(name).unwrap().example)(TS / 20.0).unwrap()).unwrap()
        };
        let moved = FeedbackDynamics { senses_vibration: false, ..bender.clone() };
        [of(bender, "prandtl-ishlinskii"), of(moved, "prandtl-ishlinskii"), of(oscillator, "bouc-wen")]
    }

    /// With a gain as blocks in series.
    fn whole(feedback: FeedbackModel) -> Model {
        let line = (Operator::find("proportional").unwrap().example)(TS).unwrap();
        Model::new(line, Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap().with_feedback(feedback).unwrap()
    }

    fn within(volts: f64) -> FeedForwardSettings {
        let limits = Limits { low: Some(-volts), high: Some(volts), ..Limits::default() };
        FeedForwardSettings { limits, ..FeedForwardSettings::default() }
    }

    #[test]
    fn a_reference_at_the_resonance_is_followed() {
        for feedback in models() {
            let offset = feedback.dynamics().offset;
            // 18 um of 150 Hz that rise smoothly, about a slow movement.
            let at = |t: usize| {
                let (time, rise) = (t as f64 * TS, (t as f64 / 500.0).min(1.0));
                let rise = rise * rise * rise * (10.0 - 15.0 * rise + 6.0 * rise * rise);
                offset + rise * (18.0 * (TAU * 150.0 * time).sin() + 5.0 * (TAU * 8.0 * time).sin())
            };
            let r: Vec<f64> = (0..2000).map(at).collect();
            let model = whole(feedback);
            let found = FeedForward::new(&model, within(100.0)).unwrap().whole(&r).unwrap();
            // Beyond the end of the record the motion is a guess.
            let most = |y: &[f64]| y.iter().zip(&r[..1995]).fold(0.0f64, |most, (y, r)| most.max((y - r).abs()));
            let (error, moved) = (most(&found.reached), most(&vec![offset; r.len()]));
            assert!(moved > 20.0 && error < 0.01 * moved, "{error} of {moved} um, {:?}", found.notes);
            // The voltage of the blocks in series, a line, is far off.
            let line: Vec<f64> = r.iter().map(|r| r - offset).collect();
            assert!(most(&model.follow(&mut model.settled(0.0), &line)) > 0.5 * moved);
        }
    }

    #[test]
    fn a_reference_beyond_the_limits_is_refused_or_clipped() {
        for feedback in models() {
            let far: Vec<f64> = (0..2000).map(|t| 90.0 * (0.01 * f64::from(t)).sin()).collect();
            let model = whole(feedback);
            let refused = FeedForward::new(&model, within(20.0)).unwrap().whole(&far).unwrap_err();
            assert!(matches!(refused, Error::Unreachable { .. }), "{refused}");
            let settings = FeedForwardSettings { clip: true, ..within(20.0) };
            let clipped = FeedForward::new(&model, settings).unwrap().whole(&far).unwrap();
            assert!(clipped.clipped > 100 && clipped.u.iter().all(|u| u.abs() <= 20.0));
        }
    }
}
