//! The closed loop on a plant, sample by sample, and how well it tracks.
//!
//! ```text
//! u_t = C(r_{t-1} - y_{t-1}, feed_t) within the limits,    y_t = plant(u_t)
//! ```
//! y_t is what the plant returns for u_t, so that the voltage answers the measurement before: one sample of delay. The error of a
//! measurement is taken from what was wanted at its instant; a feed-forward that is exact is thus left alone. Before the
//! first measurement there is no error.
//!
//! Reference: none; it is the definition. It does not do: delays of part of a sample, or jitter.

use super::Controller;
use crate::error::{Error, finite};
use crate::record::same_sampling;
use crate::system::System;

/// A plant in other units: its output times a factor, as micrometres from a plant in metres.
#[derive(Debug, Clone)]
pub struct Scaled<S> {
    /// The plant.
    pub system: S,
    /// Output unit wanted over output unit [-].
    pub factor: f64,
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

/// A run of the loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// What was wanted [output unit].
    pub r: Vec<f64>,
    /// What was measured [output unit].
    pub y: Vec<f64>,
    /// The voltages [V].
    pub u: Vec<f64>,
    /// Samples whose voltage was at a limit.
    pub limited: usize,
}

/// How well a run tracks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracking {
    /// Rms of r - y [output unit].
    pub rms: f64,
    /// Largest |r - y| [output unit].
    pub max: f64,
    /// 100 rms / stroke [%].
    pub percent_of_stroke: f64,
    /// Rms of the change of voltage a sample [V].
    pub effort: f64,
}

/// Runs a controller on a plant from rest. `feed` is the feed-forward voltage [V], zeros for none; voltages beyond `limits` [V]
/// are clipped.
///
/// ```
/// use piezoid::{control::{Pi, run}, linear::Arx};
/// let plant = Arx::new(1e-3, vec![0.9], vec![0.0, 0.1])?;
/// let pi = Pi::new(1e-3, 0.3, 20.0, (-30.0, 30.0))?;
/// let done = run(&plant, &pi, &[1.0; 2000], &[0.0; 2000], (-30.0, 30.0))?;
/// assert!((done.y[1999] - 1.0).abs() < 1e-6);
/// assert!(done.tracking(1000, 2.0).percent_of_stroke < 0.1);
/// # Ok::<(), piezoid::Error>(())
/// ```
///
/// # Errors
/// Refuses series that are not finite or not equally long, other sampling periods, and limits the wrong way round.
pub fn run(
    plant: &dyn System,
    controller: &dyn Controller,
    r: &[f64],
    feed: &[f64],
    limits: (f64, f64),
) -> Result<Run, Error> {
    super::check(&[], limits)?;
    finite("reference", r)?;
    finite("feed", feed)?;
    same_sampling("the plant", plant.ts(), "the controller", controller.ts())?;
    if r.len() != feed.len() {
        let (left, right) = ("the reference".into(), "the feed-forward".into());
        return Err(Error::Lengths { left, left_len: r.len(), right, right_len: feed.len() });
    }
    let (mut x, mut state) = (plant.initial(), controller.initial());
    let (mut y, mut u) = (Vec::with_capacity(r.len()), Vec::with_capacity(r.len()));
    let mut last = (0.0, 0.0);
    for (&wanted, &feed) in r.iter().zip(feed) {
        let voltage = controller.step(&mut state, last.0, last.1, feed).clamp(limits.0, limits.1);
        let measured = plant.step(&mut x, voltage);
        last = (wanted, measured);
        u.push(voltage);
        y.push(measured);
    }
    let limited = u.iter().filter(|u| **u <= limits.0 || **u >= limits.1).count();
    Ok(Run { r: r.to_vec(), y, u, limited })
}

impl Run {
    /// How well it tracks from sample `from` on, of a stroke [output unit] from end to end; NaN if nothing is left.
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
    use crate::control::Pi;
    use crate::linear::Arx;

    #[test]
    fn an_exact_feed_forward_is_left_alone() {
        let plant = Arx::new(1e-3, vec![0.9], vec![0.0, 0.1]).unwrap();
        let feed: Vec<f64> = (0..500).map(|t| (f64::from(t) * 0.1).sin()).collect();
        let r = plant.simulate(&feed);
        let pi = Pi::new(1e-3, 0.3, 20.0, (-30.0, 30.0)).unwrap();
        let done = run(&plant, &pi, &r, &feed, (-30.0, 30.0)).unwrap();
        assert_eq!((done.u, done.y), (feed, r));
    }

    #[test]
    fn what_is_no_number_or_does_not_fit_is_refused() {
        let plant = Arx::gain(1e-3, 1.0).unwrap();
        let pi = Pi::new(1e-3, 0.3, 20.0, (-30.0, 30.0)).unwrap();
        let message = |r: &[f64], feed: &[f64]| run(&plant, &pi, r, feed, (-1.0, 1.0)).unwrap_err().to_string();
        assert!(message(&[0.0, f64::NAN], &[0.0; 2]).starts_with("reference[1] is NaN"));
        assert!(message(&[0.0; 2], &[0.0; 3]).contains("2 samples"));
        let slow = Pi::new(2e-3, 0.3, 20.0, (-30.0, 30.0)).unwrap();
        assert!(run(&plant, &slow, &[0.0], &[0.0], (-1.0, 1.0)).is_err());
    }

    #[test]
    fn tracking_is_of_what_follows_the_first_samples() {
        let done = Run { r: vec![9.0, 1.0, 2.0], y: vec![0.0, 0.0, 4.0], u: vec![7.0, 1.0, 3.0], limited: 0 };
        let t = done.tracking(1, 50.0);
        assert_eq!((t.max, t.effort, t.percent_of_stroke), (2.0, 2.0, 2.0 * t.rms));
        assert!((t.rms * t.rms - 2.5).abs() < 1e-12);
    }
}
