//! A periodic drive, the steady-state response of a model to it, and the drive that makes the model follow a reference.
//!
//! ```text
//! lag of creep after a period T:    x_T = x_0 e^{-T/tau} + c
//! its final value:                  x*  = x_T + (x_T - x_0) / (e^{T/tau} - 1)
//! ```
//! The response is that after many periods. Creep of minutes would take as long to settle, so its lags are set to their
//! final values; hysteresis and linear block run until two periods are equal. The drive is learnt on the model itself
//! ([`Learning`]), because the feed-forward of an endless reference has no settled creep.
//!
//! Reference: see [`piezoid::compensation`]. It does not do: the transient from rest to the steady state.

use piezoid::compensation::{FeedForward, FeedForwardSettings, Learning};
use piezoid::{Error, Model, System};
use piezoid_numerics::error::finite;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::series::ends;
use piezoid_records::waveform::period;

/// Difference of two periods, as a share of the stroke, that counts as zero.
const SAME: f64 = 1e-9;

/// Number of samples after which the response is used although it still changes, and of their operations.
const PATIENCE: f64 = 1e6;
const OPERATIONS: f64 = 2e10;

/// A driver is too slow for a period if its lag is more than this many periods, or if it slews less than this share of
/// the range in one: the steady state is then out of reach within [`PATIENCE`].
const LAGGING: f64 = 5.0;
const SLEWING: f64 = 0.01;

/// Number of trials on the model; the first is the feed-forward. There are fewer if a sample takes more operations than
/// this: no operator of default size does.
const TRIALS: usize = 21;
const HEAVY: f64 = 2e4;

/// One period of a drive.
pub(super) struct PeriodicDrive {
    /// The reference [output unit].
    pub(super) r: Vec<f64>,
    /// The voltage [V].
    pub(super) u: Vec<f64>,
    /// Remarks, one sentence each.
    pub(super) notes: Vec<String>,
}

impl PeriodicDrive {
    /// The drive that makes `model` follow `r` [output unit], which is one period or several equal ones.
    ///
    /// # Errors
    /// Returns an error for a reference that is constant or does not end where it begins, and if the step from the last
    /// sample to the first exceeds the limits; also the errors of [`Learning::run`].
    pub(super) fn new(model: &Model, settings: FeedForwardSettings, r: &[f64]) -> Result<Self, Error> {
        finite("reference", r)?;
        let n = period(r).unwrap_or(r.len());
        let whole = r.len();
        let r = r[..n].to_vec();
        let mut notes = joins(&r, &model.units().y)?;
        if n < whole {
            notes.push(format!("the reference repeats after {n} of its {whole} samples: only this period is exported"));
        }
        follows(model, n)?;
        let inverse = FeedForward::new(model, settings)?;
        // The plant is the model, so its inverse is right and the gain can be 1.
        let share = (HEAVY / model.effort()?.max(1.0)).min(1.0);
        let trials = ((TRIALS as f64 * share) as usize).max(2);
        let learning = Learning { trials, gain: 1.0, cutoff_hz: None };
        let learned = learning.run(&mut |u| answer(model, u).y, &inverse, &r)?;
        // If the step from the end to the start is too fast, clipping continues into the start.
        let u = match settings.clip {
            true => settings.limits.clip(&learned.u.repeat(2), model.ts())?.split_off(n),
            false => learned.u,
        };
        let joined = [u.as_slice(), &u[..1]].concat();
        settings.limits.refuse(&joined, model.ts())?;
        notes.extend(inverse.beyond(&joined));
        Ok(PeriodicDrive { r, u, notes })
    }
}

/// Checks that the driver of the model can follow a period of `n` samples.
fn follows(model: &Model, n: usize) -> Result<(), Error> {
    let length = n as f64 * model.ts();
    let (Some(driver), Some((low, high))) = (model.driver(), model.known_inputs()) else { return Ok(()) };
    let unit = &model.units().u;
    let because = if driver.lag_s > LAGGING * length {
        format!("its driver has a lag of {} s", short(driver.lag_s))
    } else if let Some(slew) = driver.slew.filter(|slew| slew * length < SLEWING * (high - low)) {
        let (most, range) = (short(slew * length), round(high - low));
        format!("its driver slews at most {most} {unit} in a period, but the range is {range} {unit}")
    } else {
        return Ok(());
    };
    let because = format!("{because}, which is too slow for a period of {} s: check the driver", short(length));
    Err(Error::Unsuited { what: "periodic drive".into(), because })
}

/// Checks that a period ends where it begins; returns remarks.
fn joins(r: &[f64], unit: &str) -> Result<Vec<String>, Error> {
    let (low, high) = ends(r.iter().copied());
    let (Some(first), Some(last)) = (r.first(), r.last()) else {
        let (what, remedy) = ("the reference".into(), "give it one period".into());
        return Err(Error::TooShort { what, have: 0, need: 2, remedy });
    };
    if low == high {
        let value = format!("constant at {} {unit}", round(low));
        return Err(Error::parameter("reference", value, "must not be constant"));
    }
    let inside = r.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    let jump = (first - last).abs();
    if jump > inside * (1.0 + SAME) {
        let value = format!("{} {unit} from its last sample to its first", short(jump));
        let rule = "the step from the last sample to the first must not exceed the largest step inside";
        let rule = format!("{rule} ({} {unit}): give one whole period", short(inside));
        return Err(Error::parameter("reference", value, rule));
    }
    let twice = first == last && r[0] != r[1];
    let note = "the last sample equals the first and therefore occurs twice per period: remove the last one if it \
        belongs to the next period";
    Ok(twice.then(|| note.into()).into_iter().collect())
}

/// Steady-state response of a model to a drive.
pub(super) struct Answer {
    /// One period of it [output unit].
    pub(super) y: Vec<f64>,
    /// The largest difference to the period before, as a share of the stroke.
    pub(super) differs: f64,
}

/// The steady-state response of `model` to one period of `u` [V].
pub(super) fn answer(model: &Model, u: &[f64]) -> Answer {
    let length = u.len() as f64 * model.ts();
    let (from, lags) = model.creep_of_state();
    let mut x = model.settled(u.first().copied().unwrap_or(0.0));
    let mut answer = Answer { y: model.resume(&mut x, u), differs: f64::INFINITY };
    let patience = PATIENCE.min(OPERATIONS / model.effort().map_or(f64::INFINITY, |effort| effort.max(1.0))) as usize;
    for _ in 0..(patience / u.len().max(1)).max(2) {
        let before = x[from..from + lags.len()].to_vec();
        let next = model.resume(&mut x, u);
        for ((x, before), lag) in x[from..].iter_mut().zip(before).zip(lags) {
            *x += (*x - before) / (length / lag.tau_s).exp_m1();
        }
        let (low, high) = ends(next.iter().copied());
        let off = answer.y.iter().zip(&next).map(|(y, next)| (y - next).abs()).fold(0.0, f64::max);
        answer = Answer { y: next, differs: if off > 0.0 { off / (high - low) } else { 0.0 } };
        // What is not finite does not become periodic.
        if answer.differs <= SAME || answer.differs.is_nan() {
            break;
        }
    }
    answer
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::creep::Creep;
    use piezoid::excitation::Limits;
    use piezoid::hysteresis::Operator;
    use piezoid::linear::Arx;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    /// A model with creep and a resonance of 147 Hz.
    fn model(name: &str, creep: Creep) -> Model {
        let block = Arx::new(1e-3, vec![1.2, -0.9], vec![0.0, 3.0, 2.8]).unwrap();
        Model::new((Operator::find(name).unwrap().example)(1e-3).unwrap(), block, 2.0)
            .unwrap()
            .with_creep(creep)
            .unwrap()
    }

    fn sine(n: usize, height: f64) -> Vec<f64> {
        (0..n).map(|t| 5.0 + height * (TAU * t as f64 / n as f64).sin()).collect()
    }

    #[test]
    fn the_response_is_that_after_many_periods_without_waiting_for_creep() {
        for name in ["preisach", "prandtl-ishlinskii", "bouc-wen"] {
            let creeping = model(name, Creep::logarithmic(1e-3, 0.02, 0.01, 10.0).unwrap());
            let u = sine(40, 20.0);
            let mut x = creeping.settled(u[0]);
            // Twenty times the slowest lag.
            (1..5000).for_each(|_| drop(creeping.resume(&mut x, &u)));
            assert_close(&answer(&creeping, &u).y, &creeping.resume(&mut x, &u), 0.0, 1e-5);
        }
    }

    #[test]
    fn the_drive_makes_the_model_follow_periodically() {
        for name in ["preisach", "prandtl-ishlinskii"] {
            let creeping = model(name, Creep::logarithmic(1e-3, 0.02, 0.01, 10.0).unwrap());
            let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Default::default() };
            let settings = FeedForwardSettings { limits, ..Default::default() };
            let drive = PeriodicDrive::new(&creeping, settings, &sine(100, 60.0)).unwrap();
            let Answer { y, differs } = answer(&creeping, &drive.u);
            assert!(differs <= SAME, "{name}: {differs}");
            let error = y.iter().zip(&drive.r).map(|(y, r)| (y - r).abs()).fold(0.0, f64::max);
            assert!(error < 1e-4 * 120.0, "{name}: {error}");
        }
    }

    #[test]
    fn of_several_periods_one_is_used() {
        let still = model("prandtl-ishlinskii", Creep::new(1e-3, Vec::new()).unwrap());
        let drive = PeriodicDrive::new(&still, FeedForwardSettings::default(), &sine(50, 60.0).repeat(3)).unwrap();
        assert_eq!((drive.u.len(), drive.r.len()), (50, 50));
        assert!(drive.notes[0].contains("after 50 of its 150 samples"), "{:?}", drive.notes);
    }

    #[test]
    fn an_end_that_differs_from_the_start_is_an_error_and_a_repeated_sample_is_noted() {
        let text = |r: &[f64]| joins(r, "um").unwrap_err().to_string();
        assert!(text(&[0.0, 1.0, 2.0, 3.0]).contains("3.000 um from its last sample to its first"));
        assert!(text(&[0.0, 1.0, 2.0, 3.0]).contains("largest step inside (1.000 um)"));
        assert!(text(&[4.0; 5]).contains("constant at 4 um"));
        assert!(text(&[]).contains("0 samples"));
        assert!(joins(&[0.0, 1.0, 0.0, -1.0], "um").unwrap().is_empty());
        assert!(joins(&[0.0, 1.0, 0.0, -1.0, 0.0], "um").unwrap()[0].contains("twice per period"));
    }
}
