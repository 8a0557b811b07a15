//! The free run of a feedback model, in f64 or with derivatives.
//!
//! s of a model that senses vibration depends on z at the same instant, z on s: one step of the secant method, by the
//! slope of the last movement, solves this to the second order of the step.

use super::input::Path;
use super::modes::ModeStep;
use crate::hysteresis::Real;

/// The coefficients of a run.
#[derive(Debug, Clone)]
pub(super) struct Coefficients<R> {
    pub(super) steps: Vec<ModeStep<R>>,
    /// b, e, k and softening of each mode.
    pub(super) coupled: Vec<[R; 4]>,
    pub(super) sensed: R,
    pub(super) senses_vibration: bool,
    /// K = sum_i k_i e_i: what z takes from s if it senses vibration.
    pub(super) returned: R,
    pub(super) direct: [R; 2],
    pub(super) curve: R,
    pub(super) offset: R,
    /// What a step leaves of the way to H(s), and the gain, of each lag.
    pub(super) lags: Vec<(f64, R)>,
    pub(super) delay: usize,
}

/// What moves.
pub(super) struct Motion<'x, R> {
    /// p and step times p' of each mode.
    pub(super) modes: &'x mut [[R; 2]],
    pub(super) crept: &'x mut [R],
    pub(super) sensed: Sensed<R>,
    /// The output of hysteresis and creep.
    pub(super) z: R,
    /// The input.
    pub(super) before: f64,
}

impl<R: Real> Motion<'_, R> {
    /// One sample: along these steps to the next reading.
    pub(super) fn advance(
        &mut self,
        of: &Coefficients<R>,
        stretch: &[[f64; 2]],
        hysteresis: &mut dyn FnMut(R) -> R,
    ) -> R {
        for &[start, end] in stretch {
            // If u jumps, z jumps with it.
            if start != self.before && of.sensed.value() != 0.0 {
                self.sensed.advance(of, self.modes, (start, self.z), hysteresis);
                self.z = self.sensed.h + self.slow(of);
            }
            self.push(of, start);
            self.modes.iter_mut().zip(&of.steps).for_each(|(x, step)| *x = step.turn(*x));
            let h = self.sensed.h;
            self.sensed.advance(of, self.modes, (end, self.z), hysteresis);
            let mean = (h + self.sensed.h) * R::from(0.5);
            for (x, (stays, _)) in self.crept.iter_mut().zip(&of.lags) {
                *x = mean + R::from(*stays) * (*x - mean);
            }
            self.z = self.sensed.h + self.slow(of);
            self.push(of, end);
            self.before = end;
        }
        self.reading(of)
    }

    /// What the sensor reads.
    pub(super) fn reading(&self, of: &Coefficients<R>) -> R {
        let q = of.direct[0] * R::from(self.before) + of.direct[1] * self.z;
        of.reading(self.modes.iter().fold(q, |q, x| q + x[0]))
    }

    /// The force acts on the modes at this input.
    fn push(&mut self, of: &Coefficients<R>, u: f64) {
        for ((x, step), [b, e, _, softening]) in self.modes.iter_mut().zip(&of.steps).zip(&of.coupled) {
            let force = *b * R::from(u) + *e * self.z;
            *x = step.push(*x, force + lost(*softening, x[0] - force));
        }
    }

    /// What creep adds to H(s).
    fn slow(&self, of: &Coefficients<R>) -> R {
        of.lags.iter().zip(&*self.crept).fold(R::from(0.0), |sum, ((_, gain), x)| sum + *gain * *x)
    }
}

/// A run of a feedback model. Before its first sample the hysteresis moved from rest to the first input, and creep
/// settled there.
#[derive(Debug, Clone, Copy, Default)]
pub struct FeedbackRun<'a> {
    /// p and step times p' of each mode before the first sample, in the unit of y. Modes without them are at rest:
    /// where the input holds them if it drives the hysteresis, else at 0.
    pub start: &'a [[f64; 2]],
    /// The input, whose first sample was the input before too.
    pub u: &'a [f64],
    /// An observer.
    pub observer: Option<Observer<'a>>,
}

/// An observer: after each sample the first mode moves by a share of the distance to the output measured. The run of a
/// wrong model then stays near the record.
#[derive(Debug, Clone, Copy)]
pub struct Observer<'a> {
    /// The output measured at each sample of the input; NaN where it is unknown.
    pub measured: &'a [f64],
    /// The share.
    pub gain: f64,
}

/// Iterations of the displacement at the start.
const SETTLING: usize = 30;

/// The samples of y along a path; hysteresis and creep are settled at its start.
pub(super) fn run<R: Real>(
    of: &Coefficients<R>,
    hysteresis: &mut dyn FnMut(R) -> R,
    mut modes: Vec<[R; 2]>,
    mut path: Path,
    observer: Option<Observer>,
) -> Vec<R> {
    let zero = R::from(0.0);
    let (known, before) = (modes.len(), path.start());
    modes.resize(of.steps.len(), [zero; 2]);
    let mut sensed = Sensed::at_start(of, &modes, before, hysteresis);
    let settled = of.lags.iter().fold(R::from(1.0), |sum, (_, gain)| sum + *gain);
    if of.sensed.value() != 0.0 {
        // The modes are where the input holds them; their displacement may drive the hysteresis in turn.
        for _ in 0..SETTLING {
            for ((x, step), [b, e, ..]) in modes.iter_mut().zip(&of.steps).zip(&of.coupled).skip(known) {
                *x = step.resting(*b * R::from(before) + *e * settled * sensed.h);
            }
            if of.senses_vibration {
                break;
            }
            sensed.s = of.driven(&modes, before, settled * sensed.h);
            sensed.h = hysteresis(sensed.s);
        }
    }
    let crept = &mut vec![sensed.h; of.lags.len()][..];
    let mut motion = Motion { modes: &mut modes, crept, z: settled * sensed.h, sensed, before };
    let mut y = vec![motion.reading(of); of.delay];
    while let Some(stretch) = path.next_sample() {
        let read = motion.advance(of, stretch, hysteresis);
        if let Some(Observer { measured, gain }) = observer
            && let Some(measured) = measured.get(y.len()).filter(|measured| !measured.is_nan())
        {
            motion.modes[0][0] = motion.modes[0][0] + (R::from(*measured) - read) * R::from(gain);
        }
        y.push(read);
    }
    y.truncate(y.len() - of.delay);
    y
}

/// Least value of 1 + K dH/ds by which the secant divides.
pub(super) const LEAST: f64 = 0.2;

/// The input of the hysteresis and its output H(s).
#[derive(Clone, Copy)]
pub(super) struct Sensed<R> {
    pub(super) s: R,
    pub(super) h: R,
    /// dH/ds of the last movement.
    pub(super) slope: R,
}

impl<R: Real> Sensed<R> {
    /// At the start nothing vibrates.
    fn at_start(of: &Coefficients<R>, modes: &[[R; 2]], u: f64, hysteresis: &mut dyn FnMut(R) -> R) -> Self {
        let s = if of.senses_vibration { of.sensed * R::from(u) } else { of.driven(modes, u, R::from(0.0)) };
        Sensed { s, h: hysteresis(s), slope: R::from(0.0) }
    }

    /// Moves to the input `u`, with the z before.
    fn advance(
        &mut self,
        of: &Coefficients<R>,
        modes: &[[R; 2]],
        (u, z): (f64, R),
        hysteresis: &mut dyn FnMut(R) -> R,
    ) {
        let (old, before) = (self.s, self.h);
        self.s = of.driven(modes, u, z);
        if of.senses_vibration {
            // z follows s by `slope`, and takes its share of the way.
            let back = R::from(1.0) + of.returned * self.slope;
            self.s = old + (self.s - old) / if back.value() < LEAST { R::from(LEAST) } else { back };
        }
        self.h = hysteresis(self.s);
        let way = self.s - old;
        if of.senses_vibration && way.value() != 0.0 {
            self.slope = (self.h - before) / way;
        }
    }
}

impl<R: Real> Coefficients<R> {
    /// What the sensor reads at the displacement `q`.
    pub(super) fn reading(&self, q: R) -> R {
        q + self.curve * q * q + self.offset
    }

    /// s at this input; z matters if it senses vibration.
    fn driven(&self, modes: &[[R; 2]], u: f64, z: R) -> R {
        let u = R::from(u);
        let through = modes.iter().zip(&self.coupled).map(|(x, [b, e, k, _])| match self.senses_vibration {
            true => *k * (x[0] - *b * u - *e * z),
            false => *k * x[0],
        });
        through.fold(self.sensed * u, |s, through| s + through)
    }
}

/// N: what a mode at the distance `e` from its static displacement lacks of the linear restoring force, over w^2.
fn lost<R: Real>(softening: R, e: R) -> R {
    let m = softening * if e.value() < 0.0 { -e } else { e };
    if m.value() < 0.0 { e * m } else { e * m / (R::from(1.0) + m) }
}
