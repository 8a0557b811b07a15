//! The smoothing that keeps the voltage for a path within the rates of the training data.
//!
//! ```text
//! smallest S with  max |u_t - u_t-1| / ts <= slew,   u the voltage for the path smoothed over S
//! ```
//! by bisection, where slew is the largest rate of the training data. A corner of a path requests a jump of the
//! velocity, and so rates that no training record had; a minimum-jerk move of some milliseconds in its place does not.
//!
//! The same search finds the smoothing of a path that cannot be reached without it.
//!
//! It does not do: paths that are too long for a dozen inversions.

use crate::CompensateOptions;
use piezoid_control::compensation::shaping::Shaping;
use piezoid_control::compensation::{Compensated, FeedForward};
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::series::range;
use piezoid_numerics::system::System;
use piezoid_numerics::words::Words;
use piezoid_validation::{Metrics, rough};
use serde::Serialize;

/// Change of the path by smoothing, rms over its peak-to-peak, above which it is another path.
const ANOTHER_PATH: f64 = 0.1;

/// Most operations of all inversions together: seconds of work. An inversion takes some runs of the model.
const OPERATIONS: f64 = 4e9;
const INVERSIONS: f64 = 15.0;
const RUNS: f64 = 5.0;

/// Longest smoothing [samples], as that of the option.
const LONGEST: usize = 100_000;

/// A voltage that changes faster than that of the training data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Faster {
    /// Its largest rate [input unit/s].
    pub slew: f64,
    /// Largest rate of the training data [input unit/s].
    pub identified_slew: f64,
}

impl Faster {
    /// `None` if the voltage `u` is not faster, or if the rates of the training data are not known.
    pub(crate) fn of(model: &Model, u: &[f64]) -> Option<Self> {
        let (slew, known) = (Domain::slew_of(u, model.ts()), model.identified()?);
        known.is_slower_than(slew).then_some(Faster { slew, identified_slew: known.slew })
    }
}

/// The smoothing that keeps a voltage within the rates of the training data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Smoothing {
    /// Rate of the voltage without it [input unit/s].
    pub slew: f64,
    /// Largest rate of the training data [input unit/s].
    pub identified_slew: f64,
    /// Its duration, the value of the option `smooth` [s]; `None` if none keeps the voltage within, or only one that
    /// makes another path, and if the path is too long to look for it.
    pub smooth: Option<f64>,
    /// Rms difference of the smoothed path from the requested one [output unit].
    pub rms: Option<f64>,
    /// The same over the peak-to-peak of the requested path [%].
    pub rms_pp_percent: Option<f64>,
    /// True if the path is too long to look for a smoothing.
    pub is_too_long: bool,
    #[serde(skip)]
    units: [String; 2],
}

/// True if the inversions of a search take too long for a path of `n` samples, or if that is not known.
fn is_too_long(options: &CompensateOptions, model: &Model, n: usize) -> bool {
    let runs = RUNS * INVERSIONS * (options.iterations as f64 + 1.0);
    !model.effort().is_ok_and(|effort| runs * n as f64 * effort <= OPERATIONS)
}

/// The shortest smoothing whose voltage there is and changes at most so fast [input unit/s]: its duration [s], and the
/// path.
fn shortest(options: &CompensateOptions, model: &Model, r: &[f64], fastest: f64) -> Option<(f64, Vec<f64>)> {
    let ts = model.ts();
    let inverse = FeedForward::new(model, options.settings().ok()?).ok()?;
    let smoothed = |half: usize| {
        let seconds = duration(half, ts);
        let shape = Shaping { smooth: Some(seconds), ..options.shape };
        shape.of(model, r.to_vec()).ok().map(|shaped| (seconds, shaped))
    };
    let is_within = |half: usize| {
        let found = smoothed(half).and_then(|(_, shaped)| inverse.whole(&shaped).ok());
        found.is_some_and(|found| Domain::slew_of(&found.u, ts) <= fastest)
    };
    let longest = LONGEST.min(r.len() / 2);
    let mut low = options.shape.smooth.map_or(0, |seconds| (0.5 * seconds / ts) as usize);
    let mut high = low.saturating_add(1);
    while high <= longest && !is_within(high) {
        (low, high) = (high, 2 * high);
    }
    if high > longest {
        return None;
    }
    // A few percent of its duration need no further inversion.
    while high - low > 1 + high / 32 {
        let middle = low + (high - low) / 2;
        if is_within(middle) { high = middle } else { low = middle }
    }
    smoothed(high).filter(|(_, shaped)| Metrics::of(r, shaped).rmse <= ANOTHER_PATH * range(r))
}

/// The error for a path that cannot be reached or exceeds limits, with the smoothing that resolves it, if there is one.
pub(crate) fn advised(options: &CompensateOptions, model: &Model, r: &[f64], error: Error) -> Error {
    if !matches!(error, Error::Unreachable(_) | Error::Limits(_)) {
        return error;
    }
    let fastest = model.identified().map_or(f64::INFINITY, |known| known.slew);
    let found = if is_too_long(options, model, r.len()) { None } else { shortest(options, model, r, fastest) };
    let Some((seconds, shaped)) = found else { return error };
    let (rms, unit) = (rough(Metrics::of(r, &shaped).rmse), &model.units().y);
    Error::Content(format!("{error}; a smoothed path differs by {rms} {unit} rms: "))
        .advised(vec![("smooth", seconds.into()), ("clip", true.into())])
}

impl Smoothing {
    /// The smoothing for the path `r` whose voltage was `found`; `None` if that is within the rates of the training
    /// data, and if these are not known.
    pub(crate) fn of(options: &CompensateOptions, model: &Model, r: &[f64], found: &Compensated) -> Option<Self> {
        let Faster { slew, identified_slew: known } = Faster::of(model, &found.u)?;
        let is_too_long = is_too_long(options, model, r.len());
        let found = if is_too_long { None } else { shortest(options, model, r, known) };
        let (smooth, rms) = found.map(|(seconds, shaped)| (seconds, Metrics::of(r, &shaped).rmse)).unzip();
        Some(Smoothing {
            slew,
            identified_slew: known,
            smooth,
            rms,
            rms_pp_percent: rms.map(|rms| 100.0 * rms / range(r)),
            is_too_long,
            units: [model.units().u.clone(), model.units().y.clone()],
        })
    }

    /// The note on it, in the words of a front end.
    pub fn note(&self, words: &dyn Words) -> String {
        let [input, output] = &self.units;
        let within =
            format!("keeps the input within the {} {input}/s of the identification data", short(self.identified_slew));
        match (self.smooth, self.rms.zip(self.rms_pp_percent)) {
            (Some(seconds), Some((rms, percent))) => format!(
                "{} {within}; the path then differs by {} {output} rms from the requested one ({} % of its peak-to-peak)",
                words.remedy("smooth", &seconds.into()),
                rough(rms),
                rough(percent)
            ),
            _ => format!(
                "{}: slow the path down, by about {} times, or add a record that is as fast to the training data",
                match self.is_too_long {
                    true => format!("the path is too long to look for the smoothing that {within}"),
                    false => format!(
                        "no smoothing {within} without changing the path by more than {} % of its peak-to-peak (rms)",
                        100.0 * ANOTHER_PATH
                    ),
                },
                rough(self.slew / self.identified_slew)
            ),
        }
    }
}

/// The duration of a smoothing over `half` samples on both sides [s], as a decimal number.
fn duration(half: usize, ts: f64) -> f64 {
    let exact = 2.0 * half as f64 * ts;
    format!("{exact:.9e}").parse().unwrap_or(exact)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Compensation;
    use piezoid_models::hysteresis::OPERATORS;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::options::Options;
    use serde_json::Value;

    const TS: f64 = 5e-4;

    /// Hysteresis before a beam, identified on sines of 25 V at 20 Hz.
    fn model() -> Model {
        let operator = OPERATORS.iter().find(|operator| operator.name == "prandtl-ishlinskii").unwrap();
        let beam = Arx::new(TS, vec![1.7424, -0.9453], vec![3.4, 3.3]).unwrap();
        let u: Vec<f64> = (0..2000).map(|t| 25.0 * (std::f64::consts::TAU * 20.0 * f64::from(t) * TS).sin()).collect();
        Model::new((operator.example)(TS).unwrap(), beam, 0.0).unwrap().with_identified(Domain::of_input(&u, TS))
    }

    /// Limits of the voltage, and this smoothing.
    fn options(smooth: Option<f64>) -> CompensateOptions {
        let mut options = CompensateOptions::from_json(serde_json::json!({"low": -200, "high": 200})).unwrap();
        options.shape.smooth = smooth;
        options
    }

    /// The voltage for a path, and the smoothing that is offered.
    fn compensated(smooth: Option<f64>, model: &Model, r: &[f64]) -> (Compensation, Option<Smoothing>) {
        let options = options(smooth);
        let found = options.of(model, r.to_vec()).unwrap();
        let smoothing = options.smoothing(model, &found);
        (found, smoothing)
    }

    fn triangle(hz: f64, height: f64) -> Vec<f64> {
        let phase = |t: i32| (f64::from(t) * TS * hz).fract();
        let one = |t: i32| 1.0 - (4.0 * (phase(t) - 0.5)).abs();
        [vec![-height; 100], (0..3000).map(|t| -height * one(t)).collect(), vec![height; 100]].concat()
    }

    struct Flags;

    impl Words for Flags {
        fn option(&self, name: &str) -> String {
            format!("--{name}")
        }

        fn remedy(&self, name: &str, value: &Value) -> String {
            format!("--{name} {value}")
        }

        fn list(&self, name: &str) -> String {
            name.into()
        }
    }

    #[test]
    fn the_smallest_smoothing_keeps_the_voltage_of_a_path_with_corners_within_the_known_rates() {
        let (model, r) = (model(), triangle(5.0, 60.0));
        let found = compensated(None, &model, &r).1.unwrap();
        let known = model.identified().unwrap().slew;
        assert!(found.slew > 2.0 * known && found.identified_slew == known, "{found:?}");
        let smooth = found.smooth.unwrap();
        let slew = |found: &Compensation| Domain::of_input(&found.compensated.u, TS).slew;
        let (enough, none) = compensated(Some(smooth), &model, &r);
        assert!(slew(&enough) <= known && none.is_none());
        let shorter = 0.9 * smooth - 2.0 * TS;
        assert!(slew(&compensated(Some(shorter), &model, &r).0) > known, "{smooth}");
        let rms = Metrics::of(&r, &enough.shaped).rmse;
        assert!(found.rms == Some(rms) && rms < 0.1 * 120.0, "{found:?}");
        let note = found.note(&Flags);
        assert!(note.starts_with(&format!("--smooth {smooth} keeps the input within the ")), "{note}");
        assert!(note.contains(" um rms from the requested one ("), "{note}");
    }

    #[test]
    fn a_path_that_is_itself_too_fast_is_not_smoothed_into_another() {
        let r: Vec<f64> = (0..3000).map(|t| 200.0 * (std::f64::consts::TAU * 60.0 * f64::from(t) * TS).sin()).collect();
        let found = compensated(None, &model(), &r).1.unwrap();
        assert_eq!((found.smooth, found.rms), (None, None));
        let note = found.note(&Flags);
        assert!(note.starts_with("no smoothing keeps") && note.contains("slow the path down, by about "), "{note}");
    }

    #[test]
    fn a_path_too_long_to_search_is_not_called_one_without_a_smoothing() {
        let (model, r) = (model(), triangle(5.0, 60.0));
        assert!(!is_too_long(&options(None), &model, r.len()) && is_too_long(&options(None), &model, 1_000_000_000));
        let found = compensated(None, &model, &r).1.unwrap();
        let note = Smoothing { smooth: None, is_too_long: true, ..found }.note(&Flags);
        assert!(note.starts_with("the path is too long to look for the smoothing that keeps the input"), "{note}");
    }

    #[test]
    fn nothing_is_offered_within_the_known_rates_or_without_them() {
        let slow: Vec<f64> =
            (0..3000).map(|t| 200.0 * (std::f64::consts::TAU * 2.0 * f64::from(t) * TS).cos()).collect();
        let model = model();
        assert_eq!(compensated(None, &model, &slow).1, None);
        let operator = (OPERATORS[0].example)(TS).unwrap();
        let unknown = Model::new(operator, model.linear().clone(), 0.0).unwrap();
        assert_eq!(compensated(None, &unknown, &triangle(5.0, 300.0)).1, None);
    }

    #[test]
    fn the_error_of_a_path_that_changes_too_fast_has_the_smoothing_that_resolves_it() {
        let (model, r) = (model(), triangle(5.0, 300.0));
        let within = CompensateOptions::default();
        let error = within.of(&model, r.clone()).unwrap_err();
        assert!(matches!(error, Error::Unreachable(_)), "{error}");
        let message = advised(&within, &model, &r, error).message(&Flags);
        let (_, smooth) = message.split_once(" um rms: give --smooth ").unwrap_or_else(|| panic!("{message}"));
        let smooth = smooth.strip_suffix(" or --clip true").unwrap().parse().unwrap();
        let shape = Shaping { smooth: Some(smooth), ..Shaping::default() };
        assert!(CompensateOptions { shape, ..within.clone() }.of(&model, r).is_ok());
        // Nothing but another path is within the stroke.
        let far = triangle(5.0, 3000.0);
        let error = within.of(&model, far.clone()).unwrap_err();
        assert_eq!(advised(&within, &model, &far, error.clone()), error);
    }
}
