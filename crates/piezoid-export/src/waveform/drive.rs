//! A drive that repeats, what a model answers to it once that repeats too, and the drive that makes of this a wanted path.
//!
//! ```text
//! lag of creep after a period T:    x_T = x_0 e^{-T/tau} + c
//! where it ends:                    x*  = x_T + (x_T - x_0) / (e^{T/tau} - 1)
//! ```
//! The answer is that after many periods. Creep of minutes would take as long to get there, so its lags are put where they end;
//! hysteresis and linear block run until two periods are the same. The drive is learnt on the model itself
//! ([`learn`](piezoid::compensation::learn)): the feed-forward of a reference that goes on and on never ends to creep.
//!
//! Reference: as [`piezoid::compensation`]. It does not do: the way there, from standing still to what repeats.

use piezoid::compensation::{FeedForward, FeedForwardSettings, Learning};
use piezoid::error::{Error, finite};
use piezoid::hammerstein::Model;
use piezoid::number::{round, short};
use piezoid::series::ends;
use piezoid::system::System;
use piezoid::waveform::period;

/// The difference of two periods, as a share of the stroke, that is none.
const SAME: f64 = 1e-9;

/// Samples after which an answer is taken that still differs from period to period.
const PATIENCE: usize = 1_000_000;

/// Trials on the model, the first of which is the feed-forward.
const TRIALS: usize = 21;

/// One period of a drive that repeats.
pub(super) struct PeriodicDrive {
    /// What is wanted [output unit].
    pub(super) r: Vec<f64>,
    /// The voltage [V].
    pub(super) u: Vec<f64>,
    /// What is worth knowing, one sentence each.
    pub(super) notes: Vec<String>,
}

impl PeriodicDrive {
    /// The drive that makes `model` follow `r` [output unit], all of which is one period unless it repeats.
    ///
    /// # Errors
    /// A reference that stands still, that does not join its beginning, or that [`learn`] refuses; limits that the step
    /// from the last sample to the first exceeds.
    pub(super) fn new(model: &Model, settings: FeedForwardSettings, r: &[f64]) -> Result<Self, Error> {
        finite("reference", r)?;
        let n = period(r).unwrap_or(r.len());
        let whole = r.len();
        let r = r[..n].to_vec();
        let mut notes = joins(&r, &model.units().y)?;
        if n < whole {
            notes.push(format!("the reference repeats after {n} of its {whole} samples: this is the period"));
        }
        let inverse = FeedForward::new(model, settings)?;
        // The plant is the model, so that its inverse is right: no caution.
        let whole_steps = Learning { trials: TRIALS, gain: 1.0, cutoff_hz: None };
        let learned = whole_steps.run(&mut |u| answer(model, u).y, &inverse, &r)?;
        // A step back to the beginning that is too fast goes on into it.
        let u = if settings.clip {
            settings.limits.clip(&learned.u.repeat(2), model.ts())?.split_off(n)
        } else {
            learned.u
        };
        let joined = [u.as_slice(), &u[..1]].concat();
        settings.limits.refuse(&joined, model.ts())?;
        notes.extend(inverse.beyond(&joined));
        Ok(PeriodicDrive { r, u, notes })
    }
}

/// Refuses a period whose end does not join its beginning; what is worth knowing of how it does.
fn joins(r: &[f64], unit: &str) -> Result<Vec<String>, Error> {
    let (low, high) = ends(r.iter().copied());
    let (Some(first), Some(last)) = (r.first(), r.last()) else {
        let (what, remedy) = ("the reference".into(), "give it one period".into());
        return Err(Error::TooShort { what, have: 0, need: 2, remedy });
    };
    if low == high {
        return Err(Error::parameter(
            "reference",
            format!("{} {unit} throughout", round(low)),
            "must move to be a waveform",
        ));
    }
    let inside = r.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    let jump = (first - last).abs();
    if jump > inside * (1.0 + SAME) {
        let value = format!("{} {unit} from its last sample to its first", short(jump));
        let rule = format!(
            "must join its beginning: no step inside is larger than {} {unit}; give one whole period, or let it come back",
            short(inside)
        );
        return Err(Error::parameter("reference", value, rule));
    }
    let twice = first == last && r[0] != r[1];
    let note = "the reference ends with the sample it begins with, which therefore comes twice a period: leave the last one out \
                if it was meant to be the first of the next";
    Ok(twice.then(|| note.into()).into_iter().collect())
}

/// What a model answers to a drive after many periods.
pub(super) struct Answer {
    /// One period of it [output unit].
    pub(super) y: Vec<f64>,
    /// The largest difference to the period before, as a share of the stroke.
    pub(super) differs: f64,
}

/// What `model` answers to one period of `u` [V] after many of them.
pub(super) fn answer(model: &Model, u: &[f64]) -> Answer {
    let length = u.len() as f64 * model.ts();
    let lags = model.creep().lags();
    let from = model.hysteresis().order();
    let mut x = model.settled(u.first().copied().unwrap_or(0.0));
    let mut answer = Answer { y: model.resume(&mut x, u), differs: f64::INFINITY };
    for _ in 0..(PATIENCE / u.len().max(1)).max(2) {
        let before = x[from..from + lags.len()].to_vec();
        let next = model.resume(&mut x, u);
        for ((x, before), lag) in x[from..].iter_mut().zip(before).zip(lags) {
            *x += (*x - before) / (length / lag.tau_s).exp_m1();
        }
        let (low, high) = ends(next.iter().copied());
        let off = answer.y.iter().zip(&next).map(|(y, next)| (y - next).abs()).fold(0.0, f64::max);
        answer = Answer { y: next, differs: if off > 0.0 { off / (high - low) } else { 0.0 } };
        if answer.differs <= SAME {
            break;
        }
    }
    answer
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_close;
    use piezoid::creep::Creep;
    use piezoid::excitation::Limits;
    use piezoid::hysteresis::Operator;
    use piezoid::linear::Arx;
    use std::f64::consts::TAU;

    /// With creep and a resonance of 147 Hz.
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
    fn the_answer_is_that_after_many_periods_without_waiting_for_creep() {
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
    fn the_drive_makes_the_model_follow_again_and_again() {
        for name in ["preisach", "prandtl-ishlinskii"] {
            let creeping = model(name, Creep::logarithmic(1e-3, 0.02, 0.01, 10.0).unwrap());
            let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Limits::default() };
            let drive = PeriodicDrive::new(
                &creeping,
                FeedForwardSettings { limits, ..FeedForwardSettings::default() },
                &sine(100, 60.0),
            )
            .unwrap();
            let Answer { y, differs } = answer(&creeping, &drive.u);
            assert!(differs <= SAME, "{name}: {differs}");
            let left = y.iter().zip(&drive.r).map(|(y, r)| (y - r).abs()).fold(0.0, f64::max);
            assert!(left < 1e-4 * 120.0, "{name}: {left}");
        }
    }

    #[test]
    fn one_period_is_taken_of_a_reference_that_repeats() {
        let still = model("prandtl-ishlinskii", Creep::new(1e-3, Vec::new()).unwrap());
        let drive = PeriodicDrive::new(&still, FeedForwardSettings::default(), &sine(50, 60.0).repeat(3)).unwrap();
        assert_eq!((drive.u.len(), drive.r.len()), (50, 50));
        assert!(drive.notes[0].contains("after 50 of its 150 samples"), "{:?}", drive.notes);
    }

    #[test]
    fn an_end_that_does_not_join_the_beginning_is_refused_and_one_too_many_is_told() {
        let said = |r: &[f64]| joins(r, "um").unwrap_err().to_string();
        assert!(said(&[0.0, 1.0, 2.0, 3.0]).contains("3.000 um from its last sample to its first"));
        assert!(said(&[0.0, 1.0, 2.0, 3.0]).contains("no step inside is larger than 1.000 um"));
        assert!(said(&[4.0; 5]).contains("4 um throughout"));
        assert!(said(&[]).contains("0 samples"));
        assert!(joins(&[0.0, 1.0, 0.0, -1.0], "um").unwrap().is_empty());
        assert!(joins(&[0.0, 1.0, 0.0, -1.0, 0.0], "um").unwrap()[0].contains("twice a period"));
    }
}
