//! The closed loop on a plant, sample by sample, and its tracking error.
//!
//! ```text
//! u_t = C(y_{t-1-d}, r_{t-1-d}, feed_t, r_t ... r_{t+p}) within the limits,    y_t = plant(u_t)
//! ```
//! y_t is the response of the plant to u_t. The voltage answers the measurement before: one sample of delay, plus a
//! sensor delay of d samples. The error of a measurement refers to the reference at its instant, so that an exact
//! feed-forward is left unchanged. Before the first sample the plant is settled and the error is zero.
//!
//! Reference: none; it is the definition. It does not do: delays of a fraction of a sample, jitter.
//!
//! Why: docs/decisions/control.md, "A controller adds to a feed-forward".

use super::{Controller, ControllerInput};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::{Error, finite};
use piezoid_numerics::system::System;
use piezoid_records::record::{Record, Units};

/// A plant in other units: its output times a factor, for example micrometres for a plant in metres.
#[derive(Debug, Clone)]
pub(crate) struct Scaled<S> {
    /// The plant.
    pub system: S,
    /// Factor from the plant's unit to the output unit [-].
    pub factor: f64,
}

impl<S: System> Scaled<S> {
    /// A plant with displacements in `unit`, in the output unit of `model`.
    ///
    /// # Errors
    /// Returns an error if one cannot be converted into the other.
    pub(crate) fn new(system: S, unit: &str, model: &Model) -> Result<Self, Error> {
        let own = &model.units().y;
        let expected = if unit == "um" { "a length: m, mm, um or nm" } else { unit };
        let factor = Units::factor(unit, own).ok_or_else(|| Error::units("the model's output", own, expected))?;
        Ok(Scaled { system, factor })
    }
}

impl<S: System> System for Scaled<S> {
    fn ts(&self) -> f64 {
        self.system.ts()
    }

    fn order(&self) -> usize {
        self.system.order()
    }

    fn initial(&self) -> Vec<f64> {
        self.system.initial()
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        self.system.settled(u)
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        self.factor * self.system.step(x, u)
    }
}

/// The settings of a closed loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClosedLoop<'a> {
    /// The reference [output unit].
    pub r: &'a [f64],
    /// Feed-forward, one value per sample of the reference; zeros for none [V].
    pub feed_forward: &'a [f64],
    /// Lowest and highest voltage; voltages outside are clipped [V].
    pub limits: (f64, f64),
    /// Largest rate of the voltage; faster changes are clipped. Infinite for no limit [V/s].
    pub slew: f64,
    /// Sensor delay d [samples].
    pub delay_samples: usize,
    /// Preview p of the reference [samples].
    pub ahead: usize,
    /// Voltage at which the plant has settled [V].
    pub start: f64,
    /// State of the plant at the start, if it is not settled: the end of an earlier run.
    pub before: Option<&'a [f64]>,
}

#[cfg(test)]
impl<'a> ClosedLoop<'a> {
    /// From rest at 0 V, without sensor delay and with the whole reference known.
    pub(crate) fn new(r: &'a [f64], feed_forward: &'a [f64], limits: (f64, f64)) -> Self {
        ClosedLoop {
            r,
            feed_forward,
            limits,
            slew: f64::INFINITY,
            delay_samples: 0,
            ahead: usize::MAX,
            start: 0.0,
            before: None,
        }
    }
}

impl ClosedLoop<'_> {
    /// Runs a controller on a plant.
    ///
    /// # Errors
    /// Returns an error for series that are not finite or differ in length, different sampling periods, and limits in
    /// the wrong order.
    pub(crate) fn run(&self, plant: &dyn System, controller: &dyn Controller) -> Result<ClosedLoopRun, Error> {
        let ClosedLoop { r, feed_forward, limits, slew, delay_samples, ahead, start, before } = *self;
        super::check(&[], limits)?;
        finite("reference", r)?;
        finite("feed_forward", feed_forward)?;
        Record::same_sampling("the plant", plant.ts(), "the controller", controller.ts())?;
        if r.len() != feed_forward.len() {
            let (left, right) = ("the reference".into(), "the feed-forward".into());
            return Err(Error::Lengths { left, left_len: r.len(), right, right_len: feed_forward.len() });
        }
        let mut last = start.clamp(limits.0, limits.1);
        let (mut x, mut state) =
            (before.map_or_else(|| plant.settled(last), <[f64]>::to_vec), controller.settled(last));
        let (mut y, mut u) = (Vec::with_capacity(r.len()), Vec::with_capacity(r.len()));
        let rest = match before {
            None => plant.step(&mut x.clone(), last),
            Some(_) => r.first().copied().unwrap_or(0.0),
        };
        let step = slew * plant.ts();
        // The inverse reaches a limit only within its own accuracy.
        let near = 1e-6 * (limits.1 - limits.0);
        let mut limited = 0;
        for (t, &feed_forward) in feed_forward.iter().enumerate() {
            let (y_read, r_read) =
                t.checked_sub(delay_samples.saturating_add(1)).map_or((rest, rest), |t| (y[t], r[t]));
            let known = t.saturating_add(ahead).saturating_add(1).min(r.len());
            let input = ControllerInput { y: y_read, r: r_read, feed_forward, ahead: &r[t..known] };
            let requested = controller.step(&mut state, &input);
            let (low, high) = ((last - step).max(limits.0), (last + step).min(limits.1));
            last = if requested.is_finite() { requested.clamp(low, high) } else { last };
            limited += usize::from(last != requested || last <= limits.0 + near || last >= limits.1 - near);
            u.push(last);
            y.push(plant.step(&mut x, last));
        }
        Ok(ClosedLoopRun { r: r.to_vec(), y, u, limited })
    }
}

/// Result of a run of the loop.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedLoopRun {
    /// The reference [output unit].
    pub r: Vec<f64>,
    /// The measured output [output unit].
    pub y: Vec<f64>,
    /// The voltages [V].
    pub u: Vec<f64>,
    /// Number of samples at a limit or clipped.
    pub limited: usize,
}

/// Tracking error of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracking {
    /// Rms of r - y [output unit].
    pub rms: f64,
    /// Largest |r - y| [output unit].
    pub max: f64,
    /// 100 rms / stroke [%].
    pub percent_of_stroke: f64,
    /// Rms of the change of voltage per sample [V].
    pub effort: f64,
}

impl ClosedLoopRun {
    /// The largest absolute voltage [V].
    pub fn max_abs_voltage(&self) -> f64 {
        self.u.iter().fold(0.0, |m, u| m.max(u.abs()))
    }

    /// Tracking error from sample `from` on, for a peak-to-peak reference of `stroke` [output unit]; NaN for an empty
    /// range.
    pub fn tracking(&self, from: usize, stroke: f64) -> Tracking {
        let from = from.min(self.r.len());
        let errors = || self.r[from..].iter().zip(&self.y[from..]).map(|(r, y)| r - y);
        let rms = |sum: f64, n: usize| (sum / n as f64).sqrt();
        let rms_error = rms(errors().map(|e| e * e).sum(), self.r.len() - from);
        let steps = self.u[from..].windows(2).map(|w| (w[1] - w[0]).powi(2));
        Tracking {
            rms: rms_error,
            max: errors().fold(0.0, |m: f64, e| m.max(e.abs())),
            percent_of_stroke: 100.0 * rms_error / stroke,
            effort: rms(steps.clone().sum(), steps.count()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feedback::pi::Pi;
    use piezoid_models::linear::Arx;
    use piezoid_testing::assert_close;

    #[test]
    fn an_exact_feed_forward_is_left_unchanged() {
        let plant = Arx::new(1e-3, vec![0.9], vec![0.0, 0.1]).unwrap();
        let feed_forward: Vec<f64> = (0..500).map(|t| (f64::from(t) * 0.1).sin()).collect();
        let r = plant.simulate(&feed_forward);
        let pi = Pi::new(1e-3, 0.3, 20.0, (-30.0, 30.0)).unwrap();
        let done = ClosedLoop::new(&r, &feed_forward, (-30.0, 30.0)).run(&plant, &pi).unwrap();
        assert_eq!((done.u, done.y), (feed_forward, r));
    }

    #[test]
    fn a_controller_gets_the_reference_of_delayed_measurements_and_only_the_preview() {
        /// Returns its inputs as digits.
        #[derive(Debug)]
        struct Echo;
        impl Controller for Echo {
            fn ts(&self) -> f64 {
                1e-3
            }
            fn order(&self) -> usize {
                0
            }
            fn step(&self, _: &mut [f64], input: &ControllerInput) -> f64 {
                input.y + 1e3 * input.r + 1e6 * input.ahead.len() as f64 + 1e9 * input.ahead[0]
            }
            fn law(&self) -> Option<Arx> {
                None
            }
        }
        let plant = Arx::gain(1e-3, 1e-20).unwrap();
        let r = [1.0, 2.0, 3.0, 4.0, 5.0];
        let observed = |delay_samples, ahead| {
            let closed_loop = ClosedLoop { delay_samples, ahead, ..ClosedLoop::new(&r, &[0.0; 5], (-1e12, 1e12)) };
            closed_loop.run(&plant, &Echo).unwrap().u.iter().map(|u| u.round()).collect::<Vec<f64>>()
        };
        assert_eq!(
            observed(0, 1),
            [1_002_000_000.0, 2_002_001_000.0, 3_002_002_000.0, 4_002_003_000.0, 5_001_004_000.0]
        );
        assert_eq!(
            observed(2, 9),
            [1_005_000_000.0, 2_004_000_000.0, 3_003_000_000.0, 4_002_001_000.0, 5_001_002_000.0]
        );
    }

    #[test]
    fn series_that_are_not_finite_or_differ_in_length_are_errors() {
        let plant = Arx::gain(1e-3, 1.0).unwrap();
        let pi = Pi::new(1e-3, 0.3, 20.0, (-30.0, 30.0)).unwrap();
        let message = |r: &[f64], feed_forward: &[f64]| {
            ClosedLoop::new(r, feed_forward, (-1.0, 1.0)).run(&plant, &pi).unwrap_err().to_string()
        };
        assert!(message(&[0.0, f64::NAN], &[0.0; 2]).starts_with("reference[1] is NaN"));
        assert!(message(&[0.0; 2], &[0.0; 3]).contains("2 samples"));
        let slow = Pi::new(2e-3, 0.3, 20.0, (-30.0, 30.0)).unwrap();
        assert!(ClosedLoop::new(&[0.0], &[0.0], (-1.0, 1.0)).run(&plant, &slow).is_err());
    }

    #[test]
    fn tracking_ignores_the_first_samples() {
        let done = ClosedLoopRun { r: vec![9.0, 1.0, 2.0], y: vec![0.0, 0.0, 4.0], u: vec![7.0, 1.0, 3.0], limited: 0 };
        let t = done.tracking(1, 50.0);
        assert_eq!((t.max, t.effort, t.percent_of_stroke), (2.0, 2.0, 2.0 * t.rms));
        assert!((t.rms * t.rms - 2.5).abs() < 1e-12);
    }

    #[test]
    fn samples_at_a_limit_or_clipped_are_counted() {
        let plant = Arx::gain(1e-3, 1.0).unwrap();
        // Without gains, its voltage is the feed-forward.
        let pi = Pi::new(1e-3, 0.0, 0.0, (-10.0, 30.0)).unwrap();
        let run = |feed_forward: &[f64], slew: f64| {
            let r = vec![0.0; feed_forward.len()];
            let closed_loop = ClosedLoop { slew, ..ClosedLoop::new(&r, feed_forward, (-10.0, 30.0)) };
            let done = closed_loop.run(&plant, &pi).unwrap();
            (done.u, done.limited)
        };
        // Near a limit within 40e-6 V, a millionth of their distance.
        let near = [29.99997, 29.99995, -9.99997, -9.99995, 12.0];
        assert_eq!(run(&near, f64::INFINITY), (near.to_vec(), 2));
        assert_eq!(run(&[0.5, 3.0, 3.0, 3.0, 1.5], 1e3), (vec![0.5, 1.5, 2.5, 3.0, 2.0], 3));
    }

    #[test]
    fn a_plant_in_other_units_has_another_scale_and_the_same_states() {
        let system = Arx::new(1e-3, vec![0.9], vec![0.0, 0.1]).unwrap();
        let scaled = Scaled { system: system.clone(), factor: 4.0 };
        let (u, four_times) = ([1.0, -2.0, 5.0, 0.0, 3.0], |y: Vec<f64>| y.iter().map(|y| 4.0 * y).collect::<Vec<_>>());
        assert_eq!((scaled.ts(), scaled.order()), (system.ts(), system.order()));
        let settled = |system: &dyn System| system.resume(&mut system.settled(7.0), &u);
        assert_close(&scaled.simulate(&u), &four_times(system.simulate(&u)), 1e-12, 0.0);
        assert_close(&settled(&scaled), &four_times(settled(&system)), 1e-12, 0.0);
    }
}
