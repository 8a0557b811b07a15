//! A system with its state, which advances only when its output was applied; and states as documents.
//!
//! ```text
//! plan:    y, x' = step(x, u)        x stays
//! commit:  x <- x'                   the hardware has acknowledged y
//! ```
//! A voltage that the hardware refuses has not moved the actuator: its hysteresis has not advanced, and the memory of
//! the compensator must not advance either. A run in which samples are refused is bit-identical to the run with the
//! other samples alone. It does not know whether the hardware applied a voltage that it did not acknowledge.

use crate::error::{Error, finite};
use crate::system::System;
use serde::{Deserialize, Serialize};

/// A system with its state: [`Stepper::plan`] computes the next output, [`Stepper::commit`] advances.
///
/// ```
/// use piezoid::compensation::{Causal, FeedForwardSettings};
/// use piezoid::{Model, hysteresis::Operator, linear::Arx};
/// use piezoid_numerics::stepper::Stepper;
/// # fn apply(_voltage: f64) -> Result<(), ()> { Ok(()) }
/// let plays = (Operator::find("prandtl-ishlinskii")?.example)(5e-4)?;
/// let model = Model::new(plays, Arx::gain(5e-4, 33.0)?, 2.0)?;
/// let mut compensator = Stepper::new(Causal::new(&model, FeedForwardSettings::default(), 0)?);
/// for r in [10.0, 20.0, 15.0] {
///     let voltage = compensator.plan(r);
///     if apply(voltage).is_ok() {
///         compensator.commit()?;
///     }
/// }
/// let text = serde_json::to_string(&compensator.save())?;
/// let mut again = Stepper::new(Causal::new(&model, FeedForwardSettings::default(), 0)?);
/// again.restore(&serde_json::from_str(&text)?)?;
/// assert_eq!(again.plan(30.0), compensator.plan(30.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Stepper<S> {
    system: S,
    state: Vec<f64>,
    next: Vec<f64>,
    is_planned: bool,
}

impl<S: System> Stepper<S> {
    /// The system at rest.
    pub fn new(system: S) -> Self {
        let state = system.initial();
        Stepper { next: state.clone(), system, state, is_planned: false }
    }

    /// The system.
    pub fn system(&self) -> &S {
        &self.system
    }

    /// The state after the last committed sample.
    pub fn state(&self) -> &[f64] {
        &self.state
    }

    /// Replaces the state, such as by [`System::settled`]. What was planned is dropped.
    ///
    /// # Errors
    /// An error if its length is not the order of the system.
    pub fn set_state(&mut self, state: Vec<f64>) -> Result<(), Error> {
        let (order, n) = (self.system.order(), state.len());
        if n != order {
            let rule = format!("must have {order} numbers: take the state of the same system");
            return Err(Error::parameter("state", format!("{n} numbers"), rule));
        }
        self.state = state;
        self.is_planned = false;
        Ok(())
    }

    /// The output for the input `u`. The state stays until [`Stepper::commit`]; another plan replaces this one.
    pub fn plan(&mut self, u: f64) -> f64 {
        self.next.clone_from(&self.state);
        self.is_planned = true;
        self.system.step(&mut self.next, u)
    }

    /// Advances to the state after the planned sample.
    ///
    /// # Errors
    /// An error if nothing is planned; nothing changes then.
    pub fn commit(&mut self) -> Result<(), Error> {
        if !self.is_planned {
            let rule =
                "must follow a plan: each plan is committed once, and a step, a reset or a restored state drops it";
            return Err(Error::parameter("commit", "nothing is planned", rule));
        }
        std::mem::swap(&mut self.state, &mut self.next);
        self.is_planned = false;
        Ok(())
    }

    /// One sample, planned and committed.
    pub fn step(&mut self, u: f64) -> f64 {
        self.is_planned = false;
        self.system.step(&mut self.state, u)
    }

    /// The outputs of as many samples.
    pub fn resume(&mut self, u: &[f64]) -> Vec<f64> {
        self.is_planned = false;
        self.system.resume(&mut self.state, u)
    }

    /// The state as a document. What is planned is not in it.
    pub fn save(&self) -> SavedState {
        let fingerprint = format!("{:08x}", self.system.fingerprint());
        SavedState { piezoid_state: SCHEMA, fingerprint, numbers: self.state.clone() }
    }

    /// Continues from a saved state, bit-identically. What was planned is dropped.
    ///
    /// # Errors
    /// An error for a state of another system, of another length, or with a number that is not finite. The state stays
    /// then.
    pub fn restore(&mut self, saved: &SavedState) -> Result<(), Error> {
        let SavedState { piezoid_state, fingerprint, numbers } = saved;
        if *piezoid_state != SCHEMA {
            let rule = format!("must be {SCHEMA}: save the state with this version");
            return Err(Error::parameter("piezoid_state", piezoid_state, rule));
        }
        let own = format!("{:08x}", self.system.fingerprint());
        if *fingerprint != own {
            let rule = format!(
                "must be {own}: this is the state of another model, or of one with another delay; reset instead"
            );
            return Err(Error::parameter("fingerprint", fingerprint, rule));
        }
        finite("numbers", numbers)?;
        self.set_state(numbers.clone())
    }
}

/// Version of the document.
const SCHEMA: u32 = 1;

/// A state as a document, which survives JSON to the bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedState {
    /// Version of the document.
    pub piezoid_state: u32,
    /// The system that it belongs to: [`System::fingerprint`] in hexadecimal digits.
    pub fingerprint: String,
    /// The state.
    pub numbers: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Clone)]
    struct Sum(f64);

    impl System for Sum {
        fn ts(&self) -> f64 {
            1e-3
        }

        fn order(&self) -> usize {
            1
        }

        fn step(&self, x: &mut [f64], u: f64) -> f64 {
            x[0] += self.0 * u;
            x[0]
        }
    }

    #[test]
    fn a_plan_advances_nothing_until_it_is_committed_once() {
        let mut sum = Stepper::new(Sum(2.0));
        assert_eq!((sum.plan(1.0), sum.plan(3.0), sum.state()), (2.0, 6.0, &[0.0][..]));
        sum.commit().unwrap();
        assert_eq!(sum.state(), [6.0]);
        let error = sum.commit().unwrap_err().to_string();
        assert!(error.contains("nothing is planned"), "{error}");
        sum.plan(1.0);
        assert_eq!(sum.step(0.5), 7.0);
        assert!(sum.commit().is_err());
        sum.plan(1.0);
        sum.set_state(vec![1.0]).unwrap();
        assert!(sum.commit().is_err() && sum.state() == [1.0]);
    }

    #[test]
    fn a_state_of_another_system_or_length_and_one_that_is_not_finite_are_refused() {
        let mut sum = Stepper::new(Sum(2.0));
        sum.step(0.1);
        let saved = sum.save();
        let refused = |saved: &SavedState, words: &str| {
            let mut other = Stepper::new(Sum(2.0));
            let error = other.restore(saved).unwrap_err().to_string();
            assert!(error.contains(words) && other.state() == [0.0], "{error}");
        };
        refused(&Stepper::new(Sum(2.5)).save(), "another model");
        refused(&SavedState { numbers: vec![0.0; 2], ..saved.clone() }, "must have 1 numbers");
        refused(&SavedState { numbers: vec![f64::NAN], ..saved.clone() }, "numbers[0] is NaN");
        refused(&SavedState { piezoid_state: 2, ..saved.clone() }, "must be 1");
        let text = serde_json::to_string(&saved).unwrap();
        let mut again = Stepper::new(Sum(2.0));
        again.restore(&serde_json::from_str(&text).unwrap()).unwrap();
        assert_eq!(again.state(), sum.state());
    }
}
