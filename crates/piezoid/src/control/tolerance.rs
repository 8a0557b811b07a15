//! Tolerance: a scheme on plants that differ from the one it was made for as catalogue values do.
//!
//! Every value of a draw is its value times a number drawn evenly from 1 - share to 1 + share: stiffness, density (which together
//! are the frequency), the damping of each mode, displacement, width of the loop, creep, capacitance and lag of the driver.
//! After the reference its last value is held for half a second; a loop that then still swings, by more than a hundredth
//! of the reference's height, is unstable, whatever limits bound it; so is feedback that has not come within a tenth of it.
//!
//! Reference: PI datasheet PL112-PL140 (+-20 %). It does not do: values that depend on each other, or on temperature.

use super::{Scaled, Tracking, TunedScheme};
use crate::error::Error;
use crate::plant::{BeamSpec, HysteresisSpec, Plant, Spec};
use crate::progress::{Progress, Stage};
use crate::series::ends;
use crate::system::System;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// How long the last value is held, and how long of it is watched [s].
const HELD: f64 = 0.5;
const WATCHED: f64 = 0.1;

/// Draws between two reports of progress.
const BATCH: usize = 8;

/// Swing that remains, and distance of a feedback from what is wanted, as shares of the reference's height, above which a loop
/// is unstable.
const SWINGS: f64 = 0.01;
const ARRIVED: f64 = 0.1;

/// How much, how often, and from which seed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Largest deviation of a value, as a share of it [-].
    pub share: f64,
    /// Plants drawn.
    pub draws: usize,
    /// Seed of the draws and of their noise.
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
    /// The plant.
    pub spec: Spec,
    /// How well it tracked.
    pub tracking: Tracking,
    /// Whether it came to rest.
    pub stable: bool,
}

/// All draws in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// The draws.
    pub trials: Vec<Draw>,
}

impl Spread {
    /// How many did not come to rest.
    pub fn unstable(&self) -> usize {
        self.trials.iter().filter(|t| !t.stable).count()
    }

    /// The rms error that a share of the draws (0.5 for the median, 1 for the worst) does not exceed, in percent of stroke.
    pub fn percent_of_stroke(&self, share: f64) -> f64 {
        let mut sorted: Vec<f64> = self.trials.iter().map(|t| t.tracking.percent_of_stroke).collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1);
        sorted.get((share.clamp(0.0, 1.0) * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
    }
}

impl Tolerance {
    /// Drives plants drawn about `spec` along `r` [output unit of the drive's model], in parallel; errors count from sample `from` on,
    /// of the height of `r`. The order of the draws does not depend on the threads.
    ///
    /// # Errors
    /// Refuses a share outside 0 to below 1, a model whose output is no length, and what [`TunedScheme`] and [`Plant::new`] refuse.
    pub(crate) fn trials(
        &self,
        spec: &Spec,
        drive: &TunedScheme,
        r: &[f64],
        from: usize,
        progress: &mut Progress,
    ) -> Result<Spread, Error> {
        let draw = |i: usize| {
            let drawn = spec.drawn(self.share, self.seed, i as u64)?;
            trial(drawn, self.seed ^ i as u64, drive, r, from)
        };
        let mut trials = Vec::with_capacity(self.draws);
        for first in (0..self.draws).step_by(BATCH) {
            let stage = Stage { what: "draws of tolerance", done: first, total: self.draws };
            if progress(stage).is_break() {
                return Err(Error::Cancelled { what: stage.what.into(), done: first, total: stage.total });
            }
            let some = (first..self.draws.min(first + BATCH)).into_par_iter().map(draw);
            trials.extend(some.collect::<Result<Vec<Draw>, Error>>()?);
        }
        Ok(Spread { trials })
    }
}

impl Spec {
    /// Plant `i` of those drawn from `seed` about this one, whose values differ by up to `share` of each.
    ///
    /// ```
    /// let bender = (piezoid::plant::Preset::find("pl140")?.spec)();
    /// let [one, other] = [0, 1].map(|i| bender.drawn(0.2, 7, i));
    /// assert_ne!(one?, other?);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Refuses a share outside 0 to below 1.
    pub fn drawn(&self, share: f64, seed: u64, i: u64) -> Result<Spec, Error> {
        if !(0.0..1.0).contains(&share) {
            return Err(Error::parameter("share", share, "must be from 0 to below 1"));
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(i);
        let mut about = |value: &mut f64| *value *= 1.0 + share * (2.0 * random.random::<f64>() - 1.0);
        let mut spec = self.clone();
        match &mut spec.beam {
            BeamSpec::Cantilever(beam) => {
                about(&mut beam.youngs_modulus_pa);
                about(&mut beam.density_kg_per_m3);
                beam.damping.iter_mut().for_each(&mut about);
            }
            BeamSpec::Modes(modes) => {
                let (mut stiffness, mut mass) = (1.0, 1.0);
                about(&mut stiffness);
                about(&mut mass);
                for mode in modes {
                    mode.frequency_hz *= f64::sqrt(stiffness / mass);
                    about(&mut mode.damping);
                }
            }
        }
        match &mut spec.hysteresis {
            HysteresisSpec::BoucWen { displacement_m, width, .. }
            | HysteresisSpec::Preisach { displacement_m, width, .. } => {
                about(displacement_m);
                about(width);
            }
        }
        about(&mut spec.creep_per_decade);
        about(&mut spec.driver.capacitance_f);
        about(&mut spec.driver.lag_s);
        Ok(spec)
    }
}

fn trial(spec: Spec, seed: u64, drive: &TunedScheme, r: &[f64], from: usize) -> Result<Draw, Error> {
    let plant = Scaled::of(Plant::new(&spec, drive.model().ts())?.with_seed(seed), drive.model())?;
    let held = |x: &[f64]| [x, &vec![x.last().copied().unwrap_or(0.0); (HELD / plant.ts()) as usize]].concat();
    let mut feed_forward = drive.feed(&plant, r)?;
    feed_forward.u = held(&feed_forward.u);
    let mut done = drive.run(&plant, &held(r), &feed_forward)?;
    let watched = &done.y[done.y.len() - (WATCHED / plant.ts()) as usize..];
    let ((low, high), (bottom, top)) = (ends(watched.iter().copied()), ends(r.iter().copied()));
    // Feedback that integrates comes to what is wanted; a loop stuck at a limit, or no number, does not.
    let off = (0.5 * (low + high) - r.last().copied().unwrap_or(0.0)).abs();
    let arrived = drive.scheme.law.is_none() || off <= ARRIVED * (top - bottom);
    let stable = watched.iter().all(|y| y.is_finite()) && high - low <= SWINGS * (top - bottom) && arrived;
    for series in [&mut done.r, &mut done.y, &mut done.u] {
        series.truncate(r.len());
    }
    Ok(Draw { spec, tracking: done.tracking(from, top - bottom), stable })
}

#[cfg(test)]
mod tests {
    use super::super::pi::Pi;
    use super::super::{CONTROLLERS, ControllerKind, FeedForwardKind, MarginTarget, Scheme};
    use super::*;
    use crate::compensation::FeedForwardSettings;
    use crate::excitation::{Limits, Sine};
    use crate::hammerstein::Model;
    use crate::hysteresis::Proportional;
    use crate::linear::Arx;
    use crate::plant::Preset;
    use crate::progress::silent;
    use std::sync::Arc;

    /// A gain of 35 um / V under an integral of this gain, in 1/s.
    fn drive<const KI: u32>() -> TunedScheme {
        static WEAK: ControllerKind =
            ControllerKind { tune: |_, _| Ok(Arc::new(Pi::new(5e-4, 0.0, 0.1, (-30.0, 30.0))?)), ..CONTROLLERS[0] };
        static STRONG: ControllerKind =
            ControllerKind { tune: |_, _| Ok(Arc::new(Pi::new(5e-4, 0.0, 30.0, (-30.0, 30.0))?)), ..CONTROLLERS[0] };
        let law = if KI > 1 { &STRONG } else { &WEAK };
        let model = Model::new(Arc::new(Proportional::new(5e-4, 1.0).unwrap()), Arx::gain(5e-4, 35.0).unwrap(), 0.0);
        let units = crate::record::Units { u: "V".into(), y: "um".into() };
        let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Limits::default() };
        let scheme = Scheme { feed: FeedForwardKind::find("gain").unwrap(), law: Some(law) };
        let settings = FeedForwardSettings { limits, ..FeedForwardSettings::default() };
        TunedScheme::new(scheme, &model.unwrap().with_units(units), settings, 0, &MarginTarget::default()).unwrap()
    }

    fn spread(drive: &TunedScheme, threads: usize) -> Spread {
        let r = Sine { amplitude: 500.0, frequency: 5.0, ..Sine::default() }.samples(5e-4, 400).unwrap();
        let tolerance = Tolerance { draws: 4, ..Tolerance::default() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let spec = (Preset::find("pl140").unwrap().spec)();
        pool.install(|| tolerance.trials(&spec, drive, &r, 100, &mut silent)).unwrap()
    }

    #[test]
    fn the_draws_are_the_same_on_one_thread_and_on_two() {
        let one = spread(&drive::<1>(), 1);
        assert_eq!(one, spread(&drive::<1>(), 2));
        assert_ne!(one.trials[0].spec, one.trials[1].spec);
        assert!(one.percent_of_stroke(0.0) < one.percent_of_stroke(1.0));
    }

    #[test]
    fn a_loop_that_swings_within_its_limits_is_unstable_all_the_same() {
        assert_eq!(spread(&drive::<1>(), 2).unstable(), 0);
        assert_eq!(spread(&drive::<30>(), 2).unstable(), 4);
    }

    #[test]
    fn a_draw_stays_within_the_tolerance() {
        let spec = (Preset::find("pl140").unwrap().spec)();
        let lag = |i| spec.drawn(0.2, 0, i).unwrap().driver.lag_s / spec.driver.lag_s;
        let lags: Vec<f64> = (0..200).map(lag).collect();
        let (low, high) = ends(lags);
        assert!(low >= 0.8 && high <= 1.2 && low < 0.82 && high > 1.18, "{low} {high}");
    }
}
