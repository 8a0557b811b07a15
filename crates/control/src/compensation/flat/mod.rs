//! The inverse of mechanics with hysteresis in feedback: reference in, voltage out, with a preview.
//!
//! The displacement of a mode and its derivatives give the force on it, and this the input, without a differential
//! equation (the system is flat):
//! ```text
//! q + c q^2 + offset = r                                              the sensor
//! p = q - sum_i rho_i F_i - rho_d F,   F_i = F - F''/w_i^2 - 2 zeta_i F'/w_i,   F = p + a with p = q / (1 + rho)
//! a = p''/w^2 + 2 zeta p'/w,   F = p + a / (1 - softening |a|)        the mode; of one that stiffens the root of
//!                                                                     |a| = e (1 + |softening| e), F = p + e
//! displacement drives the hysteresis:  z = H(k p) + creep,     v = (F - e z) / b,    u = v + lag v', held
//! input and vibration drive it:        z = F / e,              d_s v = H^-1(z - creep) - k (p - F)
//! input and displacement drive it:     z = F / e,              d_s v = H^-1(z - creep) - k p
//! ```
//! The mode is the slowest one that the force reaches. The other modes, of the shares rho_i of its static displacement,
//! and the direct path (rho_d) count to first order. Derivatives are differences over five samples ([`taps`]), of q and
//! of p, and the hold has four samples: the preview is 2 + 2 + 1 samples, and the delay of the sensor. A longer delay
//! waits in q.
//!
//! An input that drives the hysteresis makes a staircase of z, and the hysteresis turns where this turns: v and z are
//! those at the instant of a sample at which the staircase is what the smooth force requires.
//!
//! Creep is that of a z on straight lines between its samples, by its lags c_j: z = n H + sum_j c_j. A slew limit of
//! the driver is not inverted.
//!
//! Reference: M. Fliess, J. Levine, P. Martin, P. Rouchon, Int. J. Control 61 (1995), DOI 10.1080/00207179508921959
//! (flatness). It does not do: an input that acts on the modes and on the hysteresis, which is an equation to solve.

mod design;
mod program;
mod still;
mod taps;
mod whole;

use piezoid_models::feedback::{FeedbackMode, FeedbackModel};
use piezoid_numerics::series::shift_in;
use taps::{REACH, TAPS, dot};

/// Samples of the reference that the inverse knows in advance, besides the delay of the sensor.
const PREVIEW: usize = 5;

/// Samples of p after that of the force, and after that within which an input is held.
const FORCE: usize = TAPS / 2;
const WITHIN: usize = FORCE + 1;

/// Least stiffness of a mode that softens, over that at rest.
const LEAST_STIFFNESS: f64 = 0.1;

/// Least v of h^2 - h = v, which has no root below -1/4, and the steps of Newton's method to it.
const LEAST_BEND: f64 = -0.24;

/// Largest curve times a reading: its square is a number in single precision too.
const MOST_BEND: f64 = 1e15;
const ROOT_STEPS: usize = 6;

/// The inverse of a feedback model.
///
/// State: the displacements q, newest first, of which the last five count; p, newest first; samples of what is known
/// with p (z, or the vibration of the other modes); what is held (v, or F); v at the end of the last sample, behind a
/// driver; creep; hysteresis.
#[derive(Debug, Clone)]
pub(super) struct Flat {
    model: FeedbackModel,
    delay_samples: usize,
    mode: FeedbackMode,
    /// Largest q, and the largest reading without offset that counts: the root of a larger one would overflow.
    farthest: f64,
    farthest_reading: f64,
    /// Static share of the mode in q.
    share: f64,
    /// p of q.
    across: [f64; TAPS],
    /// a of p, and an estimate of it from q.
    vibrates: [f64; TAPS],
    estimates: [f64; TAPS],
    /// What the force adds to q besides p, over its part by `softening`.
    bends: f64,
    drive: Drive,
    /// u of v, or e z within a sample of F.
    held: [f64; REACH],
    creep: Vec<Slow>,
    /// n: z per H(s) within a sample, and after a long time.
    creeps: f64,
    settles: f64,
}

/// What drives the hysteresis.
#[derive(Debug, Clone, Copy)]
enum Drive {
    Displacement {
        /// s of q, besides k p.
        sensed: [f64; TAPS],
        /// z in q.
        direct: f64,
    },
    Input {
        /// What p, F and z add to s.
        displacement: f64,
        force: f64,
        z: f64,
        /// p and F within a sample.
        between: [f64; REACH],
        /// What the vibration of the other modes takes from it, of q.
        vibration: [f64; TAPS],
        /// Lowest and highest s that a search tries, without these.
        ends: (f64, f64),
        /// What is left within a sample and at its end of the difference between v and u.
        left: [f64; 2],
    },
}

/// A lag of creep: c <- c + adds H - leaves c.
#[derive(Debug, Clone, Copy)]
struct Slow {
    adds: f64,
    leaves: f64,
    /// c after a long time at H = 1.
    settled: f64,
}

/// The parts of a state.
struct Parts<'x> {
    q: &'x mut [f64],
    p: &'x mut [f64],
    beside: &'x mut [f64],
    held: &'x mut [f64],
    v: &'x mut [f64],
    crept: &'x mut [f64],
    hysteresis: &'x mut [f64],
}

impl Flat {
    /// Least delay from the reference to the reading [samples].
    pub(super) fn least_delay(model: &FeedbackModel) -> usize {
        PREVIEW + model.dynamics().delay
    }

    /// Delay from the reference to the reading [samples].
    pub(super) fn delay_samples(&self) -> usize {
        self.delay_samples
    }

    /// Samples for which a reference waits until it counts.
    fn waits(&self) -> usize {
        self.delay_samples - Flat::least_delay(&self.model)
    }

    /// Samples of what is known with p.
    fn beside(&self) -> usize {
        match &self.drive {
            Drive::Displacement { .. } => FORCE + 1,
            Drive::Input { vibration, .. } if vibration.iter().all(|tap| *tap == 0.0) => 0,
            Drive::Input { .. } => WITHIN + 1,
        }
    }

    /// True if what is left of a voltage at the end of a sample counts.
    fn lags(&self) -> bool {
        matches!(self.drive, Drive::Input { left: [left, _], .. } if left != 0.0)
    }

    /// Length of the state.
    pub(super) fn order(&self) -> usize {
        let before = self.waits() + TAPS + WITHIN + REACH - 1 + self.beside() + REACH + usize::from(self.lags());
        before + self.creep.len() + self.model.hysteresis().order()
    }

    /// The parts of a state.
    fn parts<'x>(&self, x: &'x mut [f64]) -> Parts<'x> {
        let (q, x) = x.split_at_mut(self.waits() + TAPS);
        let (p, x) = x.split_at_mut(WITHIN + REACH - 1);
        let (beside, x) = x.split_at_mut(self.beside());
        let (held, x) = x.split_at_mut(REACH);
        let (v, x) = x.split_at_mut(usize::from(self.lags()));
        let (crept, hysteresis) = x.split_at_mut(self.creep.len());
        Parts { q, p, beside, held, v, crept, hysteresis }
    }

    /// One sample: the next reference to an input, without limits.
    pub(super) fn step(&self, x: &mut [f64], r: f64) -> f64 {
        let waits = self.waits();
        let Parts { q, p, beside, held, v, crept, hysteresis } = self.parts(x);
        let operator = self.model.hysteresis();
        let read = self.displacement(r);
        shift_in(q, if read.is_finite() { read } else { q[0] });
        let q = &q[waits..];
        let mut newest = dot(&self.across, q);
        if self.bends != 0.0 {
            let a = dot(&self.estimates, q);
            newest -= self.bends * (self.away(a) - a);
        }
        if let Drive::Displacement { sensed, direct } = &self.drive {
            if *direct != 0.0 {
                // z of this sample is not known yet.
                newest -= direct * (2.0 * beside[0] - beside[1]);
            }
            let s = self.mode.sensed * newest + dot(sensed, q);
            let mut z = beside[0];
            if s.is_finite() {
                let inner = operator.step(hysteresis, s);
                z = crept.iter().fold(self.creeps * inner, |z, c| z + c);
                self.creep_on(crept, inner);
            }
            shift_in(beside, z);
        }
        shift_in(p, newest);
        let force = p[FORCE] + self.away(dot(&self.vibrates, p));
        match &self.drive {
            Drive::Displacement { .. } => {
                shift_in(held, (force - self.mode.hysteretic * beside[FORCE]) / self.mode.input);
                dot(&self.held, held)
            }
            Drive::Input { displacement, force: of_force, z: of_z, between, vibration, ends, left } => {
                shift_in(held, force);
                let z = dot(&self.held, held) / self.mode.hysteretic;
                let mut back = displacement * dot(between, &p[FORCE..]) + of_z * z;
                if *of_force != 0.0 {
                    back += of_force * dot(between, held);
                }
                if !beside.is_empty() {
                    shift_in(beside, dot(vibration, q));
                    back -= beside[WITHIN];
                }
                let inner = crept.iter().fold(z, |z, c| z - c) / self.creeps;
                let s = operator.invert(hysteresis, inner, (back + ends.0, back + ends.1)).u;
                let within = (s - back) / self.model.dynamics().sensed;
                if !within.is_finite() {
                    return f64::NAN;
                }
                let inner = operator.step(hysteresis, s);
                self.creep_on(crept, inner);
                let (Some(before), [left, at_end]) = (v.first_mut(), left) else { return within };
                let u = (within - left * *before) / (1.0 - left);
                *before = u + (*before - u) * at_end;
                u
            }
        }
    }

    /// q of the reading `r`, no farther than the farthest one; not finite if that is not.
    fn displacement(&self, r: f64) -> f64 {
        let y = r - self.model.dynamics().offset;
        if !y.is_finite() {
            return y;
        }
        let y = y.max(-self.farthest_reading).min(self.farthest_reading);
        let q = y / root(self.model.dynamics().curve * y);
        q.max(-self.farthest).min(self.farthest)
    }

    /// The distance F - p of the mode for this a.
    fn away(&self, a: f64) -> f64 {
        let softening = self.mode.softening;
        if softening < 0.0 {
            return a / root(-softening * a.abs());
        }
        let left = 1.0 - softening * a.abs();
        a / if left < LEAST_STIFFNESS { LEAST_STIFFNESS } else { left }
    }

    /// Moves creep on by a sample of H(s).
    fn creep_on(&self, crept: &mut [f64], inner: f64) {
        crept.iter_mut().zip(&self.creep).for_each(|(c, lag)| *c += lag.adds * inner - lag.leaves * *c);
    }
}

/// The root h >= 1/2 of h^2 - h = v, which is 1 for v = 0.
fn root(v: f64) -> f64 {
    let v = if v < LEAST_BEND { LEAST_BEND } else { v };
    let start = if v > 0.0 { 1.0 + v } else { 1.0 };
    (0..ROOT_STEPS).fold(start, |h, _| (h * h + v) / (2.0 * h - 1.0))
}

#[cfg(test)]
mod tests;
