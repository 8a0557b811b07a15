//! Feedback: controllers that remove creep, drift and the residual error of a feed-forward.
//!
//! ```text
//! e = r - y,    u = feed + w,    w = C(q) e    within the voltages allowed
//! ```
//! A controller gets the last measured y, sampled one sample before u acts, and the reference r of that instant. It can
//! be tuned for a sensor delay. A controller with a law C(q) adds to a feed-forward voltage,
//! which may be zero, and does nothing while that alone keeps y at r. It is tuned to given margins ([`MarginTarget`]),
//! at the largest slope of the hysteresis and with detuned modes; [`Margins`] are computed independently of the tuning.
//! [`predictive`] optimises with the whole model. A [`Scheme`] is a feed-forward and a controller. [`TunedScheme::run`]
//! closes the loop on any plant, [`Tolerance`] draws plants with other parameters.
//!
//! Reference: K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, ISBN 978-1-55617-942-6; S. Devasia, E.
//! Eleftheriou, S. O. R. Moheimani, IEEE Trans. Control Syst. Technol. 15, 802 (2007), DOI 10.1109/TCST.2007.903345
//! (positioners). It does not do: several axes, adaptation.

mod comparison;
mod disturbance_observer;
mod feed_forwards;
mod filters;
mod integral_notch;
mod loops;
mod margins;
mod pi;
mod pid;
mod plants;
mod positive_position;
#[doc(hidden)]
pub mod predictive;
mod program;
mod references;
mod schemes;
mod tolerance;
mod tune;

pub use comparison::{Comparison, NamedReference, ReferenceResult, SchemeResult};
pub(crate) use feed_forwards::FeedForwardResult;
pub use feed_forwards::{FEED_FORWARDS, FeedForwardKind, Line};
pub(crate) use loops::ClosedLoop;
pub(crate) use loops::Scaled;
pub use loops::{ClosedLoopRun, Tracking};
pub use margins::ControlLoop;
pub use margins::Margins;
#[doc(hidden)]
pub use pi::Pi;
pub use plants::{SimulatedActuator, StandIn, StandInPlant};
pub use references::{REFERENCES, Reference};
pub use schemes::{Scheme, TunedScheme};
pub(crate) use tolerance::Spread;
pub use tolerance::Tolerance;
pub use tune::MarginTarget;

use piezoid_models::hysteresis::Real;
use piezoid_models::linear::Arx;
use piezoid_models::program::Block;
use piezoid_numerics::error::{Error, row};
use piezoid_numerics::number::is_measurable;
use serde::Serialize;
use std::fmt::Debug;
use std::sync::Arc;

/// The input of a controller in one sample.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ControllerInput<'a> {
    /// The last measurement [output unit].
    pub y: f64,
    /// The reference at the instant of that measurement [output unit].
    pub r: f64,
    /// The feed-forward voltage of this sample [V].
    pub feed_forward: f64,
    /// The reference from this sample on, as far as it is known [output unit].
    pub ahead: &'a [f64],
}

impl ControllerInput<'_> {
    /// The feed-forward within the limits; 0 if it is no [measurable](is_measurable) number.
    fn limited_feed_forward(&self, (low, high): (f64, f64)) -> f64 {
        Some(self.feed_forward).filter(|feed_forward| is_measurable(*feed_forward)).unwrap_or(0.0).clamp(low, high)
    }

    /// r - y; 0 if that is no measurable number, so that the state does not change.
    fn error(&self) -> f64 {
        Some(self.r - self.y).filter(|e| is_measurable(*e)).unwrap_or(0.0)
    }
}

/// A discrete-time controller: immutable data, with the state kept by the caller, as in
/// [`System`](piezoid_numerics::system::System).
pub trait Controller: Debug + Send + Sync {
    /// Sampling period [s].
    fn ts(&self) -> f64;

    /// Length of the state.
    fn order(&self) -> usize;

    /// The state before the first sample.
    fn initial(&self) -> Vec<f64> {
        vec![0.0; self.order()]
    }

    /// The state after a long time at the voltage `u` [V].
    fn settled(&self, _u: f64) -> Vec<f64> {
        self.initial()
    }

    /// One sample: advances the state `x` and returns the voltage u [V]. Does not allocate.
    fn step(&self, x: &mut [f64], input: &ControllerInput) -> f64;

    /// The controller as a program: blocks. The last one is the state, `control_state`, with a function
    /// `control_step(s: control_state, r, y, feed_forward)`. None if it cannot be exported.
    fn blocks(&self) -> Option<Vec<Block>> {
        None
    }

    /// C(q), the linear law from e to w while no limit is active [V / output unit]; `None` for a controller without
    /// one.
    fn law(&self) -> Option<Arx>;
}

/// Tunes a controller to a loop and a target.
pub type Tune = fn(&ControlLoop, &MarginTarget) -> Result<Arc<dyn Controller>, Error>;

/// One kind of controller: a row of [`CONTROLLERS`].
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ControllerKind {
    /// Name in options and files.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Publication.
    pub reference: &'static str,
    /// True if it adds to a feed-forward.
    pub uses_feed_forward: bool,
    /// Returns the controller with the largest integral gain that meets the target, or an error if there is none.
    #[serde(skip)]
    pub(crate) tune: Tune,
}

/// All controllers.
pub static CONTROLLERS: &[ControllerKind] =
    &[pi::ROW, pid::ROW, integral_notch::ROW, positive_position::ROW, disturbance_observer::ROW, predictive::ROW];

impl ControllerKind {
    /// The controller called `name`.
    ///
    /// ```
    /// use piezoid::control::ControllerKind;
    /// assert!(ControllerKind::find("pi")?.uses_feed_forward);
    /// assert!(ControllerKind::find("p").unwrap_err().to_string().contains("known are pi"));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Unknown`] with the known names.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        row("controller", CONTROLLERS.iter(), |row| row.name, name)
    }
}

/// `w` plus the feed-forward, within the limits. The integral changes by `gain`, unless that would drive the voltage
/// further beyond an active limit, and by no more than the limits are apart: one wrong reading cannot drive it where
/// right ones would not bring it back from.
fn integrating(limits: (f64, f64), input: &ControllerInput, w: f64, integral: &mut f64, gain: f64) -> f64 {
    let v = input.limited_feed_forward(limits) + w;
    let u = v.clamp(limits.0, limits.1);
    if u == v || (v - u) * gain < 0.0 {
        let span = apart(limits);
        *integral += Real::clamp(gain, -span, span);
    }
    u
}

/// How far the limits are apart [V].
fn apart((low, high): (f64, f64)) -> f64 {
    (high - low).min(f64::MAX)
}

/// Checks that gains are finite and not negative, and that the limits are ordered.
fn check(gains: &[(&str, f64)], limits: (f64, f64)) -> Result<(), Error> {
    for (name, value) in gains {
        if !(value.is_finite() && *value >= 0.0) {
            return Err(Error::parameter(*name, value, "must be a finite number, 0 or more"));
        }
    }
    if limits.0 < limits.1 && limits.0.is_finite() && limits.1.is_finite() {
        return Ok(());
    }
    Err(Error::parameter("limits", format!("{limits:?}"), "must be two voltages, the lower one first"))
}

#[cfg(test)]
mod kept;

#[cfg(test)]
mod tests {
    //! The contract of every controller.
    use super::margins::tests::path_of;
    use super::*;
    use piezoid_numerics::system::System;

    use piezoid_models::program::{Machine, Program};
    use piezoid_testing::assert_close;

    fn path(delay_samples: usize) -> ControlLoop {
        ControlLoop { delay_samples, ..path_of(filters::lag(5e-4, 160.0, 0.05).unwrap(), (30.0, 40.0)) }
    }
    /// Compares the steps of a controller with its law, for a sine error around the output `y`.
    pub(super) fn assert_follows_its_law(c: &dyn Controller, y: f64) {
        let e: Vec<f64> = (0..400).map(|t| 5.0 * (f64::from(t) * 0.3).sin()).collect();
        let mut x = c.initial();
        let step = |&e: &f64| c.step(&mut x, &ControllerInput { r: e + y, y, ..Default::default() });
        assert_close(&e.iter().map(step).collect::<Vec<f64>>(), &c.law().unwrap().simulate(&e), 1e-7, 1e-9);
    }

    fn tuned(delay_samples: usize) -> impl Iterator<Item = (&'static ControllerKind, Arc<dyn Controller>)> {
        CONTROLLERS.iter().map(move |c| (c, (c.tune)(&path(delay_samples), &MarginTarget::default()).unwrap()))
    }

    #[test]
    fn every_controller_has_a_summary_and_a_reference() {
        for c in CONTROLLERS {
            assert!(!c.summary.is_empty() && !c.reference.is_empty(), "{}", c.name);
            assert_eq!(ControllerKind::find(c.name).unwrap().name, c.name);
        }
        assert!(ControllerKind::find("pj").unwrap_err().to_string().contains("did you mean `pi`?"));
    }

    #[test]
    fn gains_and_limits_without_meaning_are_refused() {
        assert_eq!(check(&[("kp", 0.0), ("ki", 2.0)], (-1.0, 1.0)), Ok(()));
        for gain in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(check(&[("kp", 1.0), ("ki", gain)], (-1.0, 1.0)).unwrap_err().to_string().contains("ki"), "{gain}");
        }
        for limits in [(1.0, -1.0), (1.0, 1.0), (f64::NEG_INFINITY, 1.0), (0.0, f64::INFINITY), (f64::NAN, 1.0)] {
            assert!(check(&[], limits).unwrap_err().to_string().contains("limits"), "{limits:?}");
        }
    }

    #[test]
    fn every_controller_follows_its_law_within_the_limits() {
        for (_, c) in tuned(0).filter(|(_, c)| c.law().is_some()) {
            assert_follows_its_law(&*c, 1.0);
        }
    }

    #[test]
    fn every_controller_keeps_its_limits_and_recovers_from_them() {
        for delay_samples in [0, 3] {
            for (kind, c) in tuned(delay_samples) {
                let plant = Scaled { system: path(delay_samples).linear().clone(), factor: 40.0 };
                let r = [[2500.0; 4000], [100.0; 4000]].concat();
                let closed_loop = ClosedLoop { delay_samples, ..ClosedLoop::new(&r, &[0.0; 8000], (-1e3, 1e3)) };
                let done = closed_loop.run(&plant, &*c).unwrap();
                assert!(
                    done.u.iter().all(|u| u.abs() <= 30.0) && done.u.contains(&30.0),
                    "{}, {delay_samples} late",
                    kind.name
                );
                // Within 0.5 s. After windup by 1300 um for two seconds it would take two seconds more.
                assert_close(&done.y[5000..], &[100.0; 3000], 0.0, 1.0);
            }
        }
    }

    #[test]
    fn every_controller_with_a_law_is_bit_identical_to_its_program() {
        for delay_samples in [0, 3] {
            for (kind, c) in tuned(delay_samples) {
                assert_eq!(c.blocks().is_some(), c.law().is_some(), "{}", kind.name);
                let Some(blocks) = c.blocks() else { continue };
                let program = Program::new([vec![Block::elementary()], blocks].concat()).unwrap();
                let mut machine = Machine::new(&program, "control_state", false);
                let mut x = c.initial();
                for t in 0..600 {
                    // Into the limits and back, with lost measurements.
                    let r = 900.0 * (0.03 * f64::from(t)).sin();
                    let y = if t % 50 == 7 { f64::NAN } else { 0.2 * r + f64::from(t % 11) };
                    let feed_forward = if t % 70 == 9 { f64::NAN } else { 35.0 * (0.05 * f64::from(t)).cos() };
                    let u = c.step(&mut x, &ControllerInput { y, r, feed_forward, ahead: &[] });
                    let found = machine.call("control_step", &[r, y, feed_forward]).unwrap()[0];
                    assert_eq!(found.to_bits(), u.to_bits(), "{} at {t}", kind.name);
                    assert_eq!(machine.state(), x, "{} at {t}", kind.name);
                }
            }
        }
    }

    #[test]
    fn a_measurement_that_is_not_a_number_is_ignored() {
        for (kind, c) in tuned(0) {
            let mut x = c.initial();
            let lost = |t| ControllerInput {
                y: if t % 5 == 3 { f64::NAN } else { 1.0 },
                r: 1.5,
                feed_forward: 0.0,
                ahead: &[1.5],
            };
            assert!((0..60).all(|t| c.step(&mut x, &lost(t)).is_finite()), "{}", kind.name);
        }
    }

    #[test]
    fn every_controller_leaves_an_exact_feed_forward_unchanged() {
        for (_, c) in tuned(0).filter(|(_, c)| c.law().is_some()) {
            let mut x = c.initial();
            let exact = |t| ControllerInput { y: 7.0, r: 7.0, feed_forward: f64::from(t) * 0.1, ahead: &[] };
            assert!((0..50).all(|t| c.step(&mut x, &exact(t)) == exact(t).feed_forward));
        }
    }

    #[test]
    fn an_integral_changes_by_no_more_than_the_limits_are_apart_and_not_further_beyond_one() {
        let after = |w: f64, gain: f64| {
            let mut integral = 1.0;
            let u = integrating((-30.0, 10.0), &ControllerInput::default(), w, &mut integral, gain);
            [u, integral]
        };
        assert_eq!([after(5.0, 1e6), after(10.0, -1e6), after(5.0, 3.0)], [[5.0, 41.0], [10.0, -39.0], [5.0, 4.0]]);
        let beyond = [after(20.0, 2.0), after(20.0, -2.0), after(-40.0, 2.0), after(-40.0, -2.0)];
        assert_eq!(beyond, [[10.0, 1.0], [10.0, -1.0], [-30.0, 3.0], [-30.0, 1.0]]);
    }
}
