//! Schemes: a feed-forward and a controller, written `feed-forward+pi`.
//!
//! The default feed-forward is `gain`, the default controller is none (open loop). So `gain` uses only the gain of the
//! model, `pi` adds feedback to that, and `feed-forward` is the inverse alone.
//!
//! Reference: see the parts. It does not do: two feed-forwards or two controllers at the same time.
//!
//! Why: docs/decisions/control.md, "A scheme is a feed-forward with a controller".

use super::feed_forwards::{FEED_FORWARDS, FeedForwardKind, FeedForwardRequest, FeedForwardResult};
use super::{
    CONTROLLERS, ClosedLoop, ClosedLoopRun, ControlLoop, Controller, ControllerInput, ControllerKind, MarginTarget,
    Margins,
};
use crate::compensation::{FeedForward, FeedForwardSettings};
use piezoid_models::hammerstein::Model;
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use std::sync::Arc;

/// A feed-forward and a controller.
#[derive(Debug, Clone, Copy)]
pub struct Scheme {
    /// The feed-forward.
    pub feed_forward: &'static FeedForwardKind,
    /// The controller, if any.
    pub law: Option<&'static ControllerKind>,
}

impl Scheme {
    /// The scheme called `name`: a feed-forward, a controller, or both with a `+` between.
    ///
    /// ```
    /// use piezoid::control::Scheme;
    /// assert_eq!(Scheme::named("feed-forward+pi")?.name(), "feed-forward+pi");
    /// assert_eq!(Scheme::named("gain+pi")?.name(), "pi");
    /// assert!(Scheme::named("feed-forward+pj").unwrap_err().to_string().contains("did you mean `pi`?"));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Unknown`] with the known names; an error for two feed-forwards or two controllers.
    pub fn named(name: &str) -> Result<Self, Error> {
        let mut scheme = Scheme { feed_forward: &FEED_FORWARDS[0], law: None };
        let (mut forwards, mut laws) = (0, 0);
        for part in name.split('+') {
            if let Some(feed_forward) = FEED_FORWARDS.iter().find(|f| f.name == part) {
                (scheme.feed_forward, forwards) = (feed_forward, forwards + 1);
            } else if let Some(law) = CONTROLLERS.iter().find(|c| c.name == part) {
                (scheme.law, laws) = (scheme.law.or(Some(law)), laws + 1);
            } else {
                let known = FEED_FORWARDS.iter().map(|f| f.name).chain(CONTROLLERS.iter().map(|c| c.name));
                return Err(Error::unknown("controller", part, known));
            }
        }
        if forwards + laws > 1 && scheme.law.is_some_and(|law| !law.uses_feed_forward) {
            let rule = "predictive control cannot be combined with another controller: name it alone";
            return Err(Error::parameter("controller", name, rule));
        }
        if forwards > 1 || laws > 1 {
            let rule = "must name one feed-forward, one feedback, or one of each, such as feed-forward+pi";
            return Err(Error::parameter("controller", name, rule));
        }
        Ok(scheme)
    }

    /// The name that [`Scheme::named`] accepts.
    pub fn name(&self) -> String {
        match self.law {
            None => self.feed_forward.name.into(),
            Some(law) if self.feed_forward.name == FEED_FORWARDS[0].name => law.name.into(),
            Some(law) => format!("{}+{}", self.feed_forward.name, law.name),
        }
    }
}

/// Open loop.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Open {
    ts: f64,
}

impl Controller for Open {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        0
    }

    fn step(&self, _: &mut [f64], input: &ControllerInput) -> f64 {
        input.feed_forward
    }

    fn law(&self) -> Option<Arx> {
        None
    }
}

/// A scheme tuned to a model, ready to run on plants.
///
/// ```
/// use piezoid::control::{TunedScheme, Scheme, MarginTarget};
/// use piezoid::{Model, System, compensation::FeedForwardSettings, hysteresis::Operator, linear::Arx};
/// let plays = (Operator::find("prandtl-ishlinskii")?.example)(1e-3)?;
/// let with_gain = |k: f64| Model::new(plays.clone(), Arx::new(1e-3, vec![0.5], vec![k])?, 0.0);
/// let (model, actuator) = (with_gain(10.0)?, with_gain(11.0)?);
/// let r: Vec<f64> = (0..1500).map(|t| 300.0 * (std::f64::consts::TAU * f64::from(t) / 500.0).sin()).collect();
/// let error = |name: &str| {
///     let (settings, target) = (FeedForwardSettings::default(), MarginTarget::default());
///     let drive = TunedScheme::new(Scheme::named(name)?, &model, settings, 0, &target)?;
///     let feed_forward = drive.feed_forward(&actuator, &r)?;
///     Ok::<f64, piezoid::Error>(drive.run(&actuator, &r, &feed_forward)?.tracking(500, 600.0).percent_of_stroke)
/// };
/// assert!(error("feed-forward+pi")? < 0.3 * error("feed-forward")? && error("learning")? < 0.01);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct TunedScheme {
    /// The scheme.
    pub scheme: Scheme,
    /// Preview of the reference [samples].
    pub ahead: usize,
    settings: FeedForwardSettings,
    path: ControlLoop,
    controller: Arc<dyn Controller>,
}

impl TunedScheme {
    /// `scheme` for `model` within the limits of `settings`, its controller tuned to `target` for a sensor delay of
    /// `delay_samples` samples. References are known to their end.
    ///
    /// # Errors
    /// The errors of the tuning, and an error for a model without any allowed input.
    pub fn new(
        scheme: Scheme,
        model: &Model,
        settings: FeedForwardSettings,
        delay_samples: usize,
        target: &MarginTarget,
    ) -> Result<Self, Error> {
        let path = ControlLoop {
            delay_samples,
            slew: settings.limits.fastest(),
            ..ControlLoop::of(model, settings.ends(model)?)?
        };
        let controller = match scheme.law {
            Some(law) => (law.tune)(&path, target)?,
            None => Arc::new(Open { ts: model.ts() }),
        };
        Ok(TunedScheme { scheme, ahead: usize::MAX, settings, path, controller })
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.path.model
    }

    /// Sensor delay that the controller is tuned for [samples].
    pub fn delay_samples(&self) -> usize {
        self.path.delay_samples
    }

    /// The controller.
    pub fn controller(&self) -> &dyn Controller {
        &*self.controller
    }

    /// The margins of the loop at the largest slope of the hysteresis; `None` without feedback or without a linear law.
    pub fn margins(&self) -> Option<Margins> {
        self.path.margins(&*self.controller, self.path.slope.1)
    }

    /// The bandwidth at the smallest slope, where it is lowest [Hz].
    pub fn least_bandwidth_hz(&self) -> Option<f64> {
        Some(self.path.margins(&*self.controller, self.path.slope.0)?.bandwidth_hz)
    }

    /// |S| of the loop at these frequencies [Hz].
    pub fn sensitivity(&self, hz: &[f64]) -> Option<Vec<f64>> {
        self.path.sensitivity(&*self.controller, self.path.slope.1, hz)
    }

    /// Checks that the model can hold every value of `r` [output unit]. Passes if values are to be clipped, or if the
    /// model has no inverse.
    ///
    /// # Errors
    /// [`Error::Unreachable`], and a reference that is not finite.
    pub fn check(&self, r: &[f64]) -> Result<(), Error> {
        piezoid_numerics::error::finite("reference", r)?;
        match FeedForward::new(self.model(), self.settings) {
            Ok(inverse) if !self.settings.clip => inverse.holds(r),
            _ => Ok(()),
        }
    }

    /// The highest frequency of the identification data, if the model covers only a part of the frequencies [Hz].
    pub fn known_hz(&self) -> Option<f64> {
        self.path.known_hz()
    }

    /// The feed-forward for `r` [output unit]; the output of `plant` is in the same unit.
    ///
    /// # Errors
    /// The errors of the row of [`FEED_FORWARDS`].
    pub fn feed_forward(&self, plant: &dyn System, r: &[f64]) -> Result<FeedForwardResult, Error> {
        (self.scheme.feed_forward.make)(&FeedForwardRequest {
            model: self.model(),
            settings: self.settings,
            r,
            ahead: self.ahead,
            plant,
        })
    }

    /// Runs `plant` along `r` [output unit] with this feed-forward. It starts settled at the first value of `r` (by the
    /// model), or at the end of the learning trials.
    ///
    /// # Errors
    /// Returns an error for series that are not finite or differ in length, and different sampling periods.
    pub fn run(&self, plant: &dyn System, r: &[f64], feed_forward: &FeedForwardResult) -> Result<ClosedLoopRun, Error> {
        let ControlLoop { limits, slew, delay_samples, .. } = self.path;
        let start = r.first().map_or(0.0, |r| self.model().static_input(*r, limits));
        let (ahead, before) = (self.ahead, feed_forward.after.as_deref());
        let closed_loop =
            ClosedLoop { r, feed_forward: &feed_forward.u, limits, slew, delay_samples, ahead, start, before };
        closed_loop.run(plant, &*self.controller)
    }
}

#[cfg(test)]
mod tests {
    use super::super::feed_forwards::{ALL, FeedForwardKind};
    use super::*;
    use piezoid_models::hysteresis::Operator;
    use piezoid_records::excitation::Sine;
    use piezoid_testing::assert_close;

    const TS: f64 = 5e-4;

    /// Plays and a resonance, with `share` of the nominal gain.
    fn model(share: f64) -> Model {
        let plays = (Operator::find("prandtl-ishlinskii").unwrap().example)(TS).unwrap();
        Model::new(plays, Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.1 * share, 3.1 * share]).unwrap(), 4.0)
            .unwrap()
    }

    fn sine(n: usize) -> Vec<f64> {
        Sine { amplitude: 400.0, offset: 4.0, frequency: 10.0 }.samples(TS, n).unwrap()
    }

    fn tuned(name: &str, settings: FeedForwardSettings, delay_samples: usize) -> TunedScheme {
        TunedScheme::new(Scheme::named(name).unwrap(), &model(1.0), settings, delay_samples, &MarginTarget::default())
            .unwrap()
    }

    fn drive(name: &str) -> TunedScheme {
        tuned(name, FeedForwardSettings::default(), 0)
    }
    fn percent(drive: &TunedScheme, plant: &Model, r: &[f64]) -> f64 {
        let feed_forward = drive.feed_forward(plant, r).unwrap();
        drive.run(plant, r, &feed_forward).unwrap().tracking(400, 800.0).percent_of_stroke
    }

    #[test]
    fn every_scheme_tracks_on_another_plant_and_keeps_its_name() {
        let r = sine(2000);
        let line = percent(&drive("gain"), &model(1.1), &r);
        for feed_forward in FEED_FORWARDS {
            assert!(!feed_forward.summary.is_empty() && !feed_forward.reference.is_empty());
            for law in std::iter::once(None).chain(CONTROLLERS.iter().map(Some)) {
                let scheme = Scheme { feed_forward, law };
                if law.is_some_and(|law| !law.uses_feed_forward) && feed_forward.name != FEED_FORWARDS[0].name {
                    assert!(Scheme::named(&scheme.name()).is_err());
                    continue;
                }
                assert_eq!(Scheme::named(&scheme.name()).unwrap().name(), scheme.name());
                for delay_samples in [0, 3] {
                    let drive = tuned(&scheme.name(), FeedForwardSettings::default(), delay_samples);
                    let error = percent(&drive, &model(1.1), &r);
                    assert!(
                        drive.delay_samples() == delay_samples && error < 1.5 * line,
                        "{}: {error} after {line}",
                        scheme.name()
                    );
                }
            }
        }
        for wrong in ["gain+feed-forward", "pi+pid", "pi+", "", "feed_forward"] {
            assert!(Scheme::named(wrong).is_err(), "{wrong}");
        }
        assert!(FeedForwardKind::find("learn").is_err() && FeedForwardKind::find("learning").is_ok());
    }

    #[test]
    fn the_sensitivity_of_a_scheme_peaks_where_its_margins_state() {
        let pi = drive("pi");
        let hz: Vec<f64> = (1..4000).map(|k| 0.25 * f64::from(k)).collect();
        let peak = pi.sensitivity(&hz).unwrap().into_iter().fold(0.0, f64::max);
        assert_close(&[peak], &[pi.margins().unwrap().peak], 1e-2, 0.0);
        assert_eq!(drive("feed-forward").sensitivity(&hz), None);
    }

    #[test]
    fn a_constant_reference_is_held_from_the_first_sample_for_any_preview() {
        let (model, r) = (model(1.0), [300.0; 200]);
        for ahead in [0, 1, 5] {
            let drive = TunedScheme { ahead, ..drive("feed-forward") };
            let u = drive.feed_forward(&model, &r).unwrap().u;
            assert!(u.iter().all(|v| (v - u[0]).abs() < 1e-9), "{ahead}: {u:?}");
        }
    }

    #[test]
    fn no_other_straight_line_is_better_on_the_model() {
        let (model, r, drive) = (model(1.0), sine(2000), drive("gain"));
        let FeedForwardResult { u, line, .. } = drive.feed_forward(&model, &r).unwrap();
        let line = line.unwrap();
        let lead = (line.lead / TS).round() as usize;
        let along: Vec<f64> = r[lead..].iter().map(|r| line.gain * r + line.offset).collect();
        piezoid_testing::assert_close(&u[..r.len() - lead], &along, 1e-12, 1e-9);
        let error = |share: f64| {
            let u: Vec<f64> = u.iter().map(|u| share * u).collect();
            let feed_forward = FeedForwardResult { u, ..Default::default() };
            drive.run(&model, &r, &feed_forward).unwrap().tracking(400, 800.0).percent_of_stroke
        };
        let [less, best, more] = [0.97, 1.0, 1.03].map(error);
        assert!(less > best && more > best && best > 0.3, "{less} {best} {more}");
    }

    #[test]
    fn the_error_falls_with_the_preview_down_to_that_of_the_whole_reference() {
        let (model, r) = (model(1.0), sine(2000));
        let error = |ahead: usize| percent(&TunedScheme { ahead, ..drive("feed-forward") }, &model, &r);
        assert!(error(0) > error(2) && error(2) > error(6), "{} {} {}", error(0), error(2), error(6));
        assert!(error(usize::MAX) < 0.01 && error(ALL - 1) < 0.01, "{} {}", error(usize::MAX), error(ALL - 1));
    }

    #[test]
    fn a_reference_beyond_the_model_is_an_error_unless_it_is_clipped() {
        let far: Vec<f64> = sine(400).iter().map(|r| 5.0 * r).collect();
        let refused = drive("pi").check(&far).unwrap_err().to_string();
        assert!(
            refused.contains("cannot be reached") && refused.contains("only -987.9 to 995.9 um can be held"),
            "{refused}"
        );
        let clipped = tuned("pi", FeedForwardSettings { clip: true, ..Default::default() }, 0);
        assert!(clipped.check(&far).is_ok() && clipped.check(&[f64::NAN]).is_err());
        assert!(drive("pi").check(&sine(400)).is_ok());
    }

    #[test]
    fn learning_needs_a_periodic_reference_and_returns_its_trials() {
        let path: Vec<f64> = (0..3000).map(|t| f64::from(t) * 0.1).collect();
        let refused = drive("learning").feed_forward(&model(1.0), &path).unwrap_err().to_string();
        assert!(refused.contains("learning needs a periodic one"), "{refused}");
        let feed_forward = drive("learning").feed_forward(&model(1.2), &sine(1000)).unwrap();
        assert_eq!((feed_forward.u.len(), feed_forward.trials.len()), (1000, 11));
        assert!(feed_forward.trials[10] < 0.01 * feed_forward.trials[0], "{:?}", feed_forward.trials);
    }
}
