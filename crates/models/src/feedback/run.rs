//! The free run of a feedback model, in f64 or with derivatives.
//!
//! s of a model that senses vibration depends on z at the same instant, z on s: one step of the secant method, by the
//! slope of the last movement, solves this to the second order of the step.

use super::input::Path;
use super::modes::ModeStep;
use crate::hysteresis::Real;

/// The coefficients of a run.
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
}

/// Runs along a path and passes each sample of y on; hysteresis and creep are at rest before.
pub(super) fn run<R: Real>(
    coefficients: &Coefficients<R>,
    hysteresis: &mut dyn FnMut(R) -> R,
    mut modes: Vec<[R; 2]>,
    mut path: Path,
    mut sample: impl FnMut(R),
) {
    let Coefficients { steps, coupled, direct, curve, offset, lags, .. } = coefficients;
    let zero = R::from(0.0);
    modes.resize(steps.len(), [zero; 2]);
    let push = |modes: &mut [[R; 2]], u: f64, z: R| {
        for ((x, step), [b, e, _, softening]) in modes.iter_mut().zip(steps).zip(coupled) {
            let force = *b * R::from(u) + *e * z;
            *x = step.push(*x, force + lost(*softening, x[0] - force));
        }
    };
    let mut crept = vec![zero; lags.len()];
    let slow = |crept: &[R]| lags.iter().zip(crept).fold(zero, |sum, ((_, gain), x)| sum + *gain * *x);
    let mut before = path.start();
    let mut sensed = Sensed::at_start(coefficients, &modes, before, hysteresis);
    let mut z = sensed.h;
    while let Some(stretch) = path.next_sample() {
        for &[start, end] in stretch {
            // If u jumps, z jumps with it.
            if start != before && coefficients.sensed.value() != 0.0 {
                sensed.advance(coefficients, &modes, (start, z), hysteresis);
                z = sensed.h + slow(&crept);
            }
            push(&mut modes, start, z);
            modes.iter_mut().zip(steps).for_each(|(x, step)| *x = step.turn(*x));
            let h = sensed.h;
            sensed.advance(coefficients, &modes, (end, z), hysteresis);
            let mean = (h + sensed.h) * R::from(0.5);
            for (x, (stays, _)) in crept.iter_mut().zip(lags) {
                *x = mean + R::from(*stays) * (*x - mean);
            }
            z = sensed.h + slow(&crept);
            push(&mut modes, end, z);
            before = end;
        }
        let end = R::from(before);
        let q = modes.iter().fold(direct[0] * end + direct[1] * z, |q, x| q + x[0]);
        sample(q + *curve * q * q + *offset);
    }
}

/// Least value of 1 + K dH/ds by which the secant divides.
const LEAST: f64 = 0.2;

/// The input of the hysteresis and its output H(s).
struct Sensed<R> {
    s: R,
    h: R,
    /// dH/ds of the last movement.
    slope: R,
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
