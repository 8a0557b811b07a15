//! Tolerance: a scheme on plants whose parameters differ from the nominal ones by catalogue tolerances.
//!
//! Every parameter of a draw is its nominal value times a number drawn uniformly from 1 - share to 1 + share:
//! stiffness, density (both set the frequencies), damping of each mode, displacement, width of the loop, creep,
//! capacitance and lag of the driver. After the reference its last value is held for half a second. The loop is
//! unstable if it then still oscillates by more than a hundredth of the reference's height, even within limits, or,
//! with feedback, if the error exceeds a tenth of it.
//!
//! Reference: PI datasheet PL112-PL140 (+-20 %). It does not do: correlated parameters, temperature.

use super::{SimulatedActuator, Tracking, TunedScheme};
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_numerics::series::ends;
use rayon::prelude::*;

/// Time for which the last value is held, and time at its end that is checked [s].
const HOLD_S: f64 = 0.5;
const CHECKED_S: f64 = 0.1;

/// Number of draws between two progress reports.
const BATCH: usize = 8;

/// Thresholds of an unstable loop, as shares of the reference's height: remaining oscillation, and error with feedback.
const MAX_OSCILLATION_SHARE: f64 = 0.01;
const MAX_FINAL_ERROR_SHARE: f64 = 0.1;

/// Size, number and seed of the draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Largest relative deviation of a parameter [-].
    pub share: f64,
    /// Number of plants.
    pub draws: usize,
    /// Seed of the draws and of their sensor noise.
    pub seed: u64,
}

impl Default for Tolerance {
    /// 20 %, 200 draws, seed 0.
    fn default() -> Self {
        Tolerance { share: 0.2, draws: 200, seed: 0 }
    }
}

/// One draw.
#[derive(Debug, Clone, PartialEq)]
pub struct Draw {
    /// The actuator.
    pub actuator: SimulatedActuator,
    /// Tracking error.
    pub tracking: Tracking,
    /// True if it came to rest at the reference.
    pub stable: bool,
}

/// All draws in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// The draws.
    pub trials: Vec<Draw>,
}

impl Spread {
    /// Number of draws that are unstable.
    pub fn unstable(&self) -> usize {
        self.trials.iter().filter(|t| !t.stable).count()
    }

    /// The rms error that a share of the draws (0.5 for the median, 1 for the worst) does not exceed [% of stroke].
    pub fn percent_of_stroke(&self, share: f64) -> f64 {
        let mut sorted: Vec<f64> = self.trials.iter().map(|t| t.tracking.percent_of_stroke).collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1);
        sorted.get((share.clamp(0.0, 1.0) * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
    }
}

impl Tolerance {
    /// Runs plants drawn around `nominal` along `r` [output unit of the scheme's model], in parallel. Errors count from
    /// sample `from` on, relative to the height of `r`. The order of the draws does not depend on the threads.
    ///
    /// # Errors
    /// Returns an error for a share outside 0 to below 1 or a model whose output is not a length, and the errors of
    /// [`TunedScheme`] and [`SimulatedActuator::plant`].
    pub(crate) fn trials(
        &self,
        nominal: &SimulatedActuator,
        drive: &TunedScheme,
        r: &[f64],
        from: usize,
        progress: &mut Progress,
    ) -> Result<Spread, Error> {
        let draw = |i: usize| {
            let drawn = nominal.drawn(self.share, self.seed, i as u64)?;
            trial(drawn, self.seed ^ i as u64, drive, r, from)
        };
        let mut trials = Vec::with_capacity(self.draws);
        for first in (0..self.draws).step_by(BATCH) {
            let stage = Stage::new("random plants", first, self.draws);
            if progress(stage).is_break() {
                return Err(Error::Cancelled { what: stage.what.into(), done: first, total: stage.total });
            }
            let some = (first..self.draws.min(first + BATCH)).into_par_iter().map(draw);
            trials.extend(some.collect::<Result<Vec<Draw>, Error>>()?);
        }
        Ok(Spread { trials })
    }
}

fn trial(actuator: SimulatedActuator, seed: u64, drive: &TunedScheme, r: &[f64], from: usize) -> Result<Draw, Error> {
    let plant = actuator.plant(drive.model(), seed)?;
    let held = |x: &[f64]| [x, &vec![x.last().copied().unwrap_or(0.0); (HOLD_S / plant.ts()) as usize]].concat();
    let mut feed_forward = drive.feed_forward(&*plant, r)?;
    feed_forward.u = held(&feed_forward.u);
    let mut done = drive.run(&*plant, &held(r), &feed_forward)?;
    let watched = &done.y[done.y.len() - (CHECKED_S / plant.ts()) as usize..];
    let ((low, high), (bottom, top)) = (ends(watched.iter().copied()), ends(r.iter().copied()));
    // Feedback with an integral reaches the reference; a loop stuck at a limit, or with values that are not numbers,
    // does not.
    let off = (0.5 * (low + high) - r.last().copied().unwrap_or(0.0)).abs();
    let arrived = drive.scheme.law.is_none() || off <= MAX_FINAL_ERROR_SHARE * (top - bottom);
    let stable =
        watched.iter().all(|y| y.is_finite()) && high - low <= MAX_OSCILLATION_SHARE * (top - bottom) && arrived;
    for series in [&mut done.r, &mut done.y, &mut done.u] {
        series.truncate(r.len());
    }
    Ok(Draw { actuator, tracking: done.tracking(from, top - bottom), stable })
}

#[cfg(test)]
mod tests {
    use super::super::pi::Pi;
    use super::super::{CONTROLLERS, ControllerKind, FeedForwardKind, MarginTarget, Scheme};
    use super::*;
    use crate::compensation::FeedForwardSettings;
    use piezoid_models::hammerstein::Model;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::progress::Stage;
    use piezoid_records::excitation::{Limits, Sine};
    use piezoid_twins::Preset;
    use std::sync::Arc;

    /// A gain of 35 um / V with an integral controller of gain `KI` [1/s] (0.1 for `KI` = 1).
    fn drive<const KI: u32>() -> TunedScheme {
        static WEAK: ControllerKind =
            ControllerKind { tune: |_, _| Ok(Arc::new(Pi::new(5e-4, 0.0, 0.1, (-30.0, 30.0))?)), ..CONTROLLERS[0] };
        static STRONG: ControllerKind =
            ControllerKind { tune: |_, _| Ok(Arc::new(Pi::new(5e-4, 0.0, 30.0, (-30.0, 30.0))?)), ..CONTROLLERS[0] };
        let law = if KI > 1 { &STRONG } else { &WEAK };
        let model = Model::new(Arc::new(Proportional::new(5e-4, 1.0).unwrap()), Arx::gain(5e-4, 35.0).unwrap(), 0.0);
        let units = piezoid_records::record::Units { u: "V".into(), y: "um".into() };
        let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Default::default() };
        let scheme = Scheme { feed_forward: FeedForwardKind::find("gain").unwrap(), law: Some(law) };
        let settings = FeedForwardSettings { limits, ..Default::default() };
        TunedScheme::new(scheme, &model.unwrap().with_units(units), settings, 0, &MarginTarget::default()).unwrap()
    }

    fn trials(tolerance: Tolerance, drive: &TunedScheme) -> Spread {
        let r = Sine { amplitude: 500.0, frequency: 5.0, ..Default::default() }.samples(5e-4, 400).unwrap();
        let spec = Preset::find("pl140").unwrap().spec().into();
        tolerance.trials(&spec, drive, &r, 100, &mut Stage::ignore).unwrap()
    }

    fn spread(drive: &TunedScheme, threads: usize) -> Spread {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trials(Tolerance { draws: 4, ..Default::default() }, drive))
    }

    #[test]
    fn the_draws_are_the_same_on_one_thread_and_on_two() {
        let one = spread(&drive::<1>(), 1);
        assert_eq!(one, spread(&drive::<1>(), 2));
        assert_ne!(one.trials[0].actuator, one.trials[1].actuator);
        assert!(one.percent_of_stroke(0.0) < one.percent_of_stroke(1.0));
    }

    #[test]
    fn the_noise_of_each_draw_is_another() {
        let spread = trials(Tolerance { draws: 6, share: 0.0, seed: 1 }, &drive::<1>());
        for (k, one) in spread.trials.iter().enumerate() {
            assert!(spread.trials[..k].iter().all(|other| other.tracking != one.tracking), "{k}");
        }
    }

    #[test]
    fn a_loop_that_oscillates_within_its_limits_is_unstable() {
        assert_eq!(spread(&drive::<1>(), 2).unstable(), 0);
        assert_eq!(spread(&drive::<30>(), 2).unstable(), 4);
    }

    #[test]
    fn a_draw_stays_within_the_tolerance() {
        let spec = Preset::find("pl140").unwrap().spec();
        let lag = |i| spec.drawn(0.2, 0, i).unwrap().driver.lag_s / spec.driver.lag_s;
        let lags: Vec<f64> = (0..200).map(lag).collect();
        let (low, high) = ends(lags);
        assert!(low >= 0.8 && high <= 1.2 && low < 0.82 && high > 1.18, "{low} {high}");
    }

    #[test]
    fn a_loop_is_stable_if_it_rests_at_the_end_of_its_reference() {
        let spec: SimulatedActuator = Preset::find("pl140").unwrap().spec().into();
        let risen = |height: f64| {
            let r: Vec<f64> = (0..2500).map(|t| height * (f64::from(t) / 400.0).min(1.0)).collect();
            let tolerance = Tolerance { draws: 2, share: 0.05, seed: 0 };
            tolerance.trials(&spec, &drive::<1>(), &r, 0, &mut Stage::ignore).unwrap()
        };
        let (near, far) = (risen(400.0), risen(2000.0));
        // About half of the higher one is out of reach: it rests far below.
        assert_eq!([near.unstable(), far.unstable()], [0, 2]);
        let Tracking { rms, percent_of_stroke, .. } = near.trials[0].tracking;
        assert_eq!(percent_of_stroke, 100.0 * rms / 400.0);
    }
}
