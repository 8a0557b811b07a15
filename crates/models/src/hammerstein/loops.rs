//! The loops of the hidden variable: the points (u, z) of the records, grouped by frequency and split into branches.
//!
//! Sensors drift between records, so z of each record with the input range of the first is shifted to the mean of z of
//! the first.

use crate::hammerstein::Model;
use crate::hysteresis::{Branches, LoopOptions, MeasuredLoop, Split};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::series::{ends, mean};
use piezoid_numerics::system::System;
use piezoid_records::quality::loop_defects;
use piezoid_records::record::Record;
use piezoid_records::waveform::cycle_rate;
use serde_json::{Value, json};

/// Relative difference below which two frequencies are equal.
const SAME_FREQUENCY: f64 = 0.02;

/// Minimum number of samples of a loop.
const SHORTEST: usize = 16;

/// Shift between records, over the peak-to-peak of z, from which a note is written.
const SHIFTED: f64 = 0.02;

/// Share of points on the side of their direction, from which the loop counts as open.
pub const MIN_OPEN_AGREEMENT: f64 = 0.6;

/// A loop of the hidden variable.
#[derive(Debug, Clone, PartialEq)]
pub struct HiddenLoop {
    /// The rate of its cycles [Hz]; `None` if they differ in length.
    pub frequency_hz: Option<f64>,
    /// Input [input unit].
    pub u: Vec<f64>,
    /// Hidden variable [input unit], or the output [output unit].
    pub z: Vec<f64>,
    /// Branches and separating line.
    pub found: MeasuredLoop,
}

impl LoopOptions {
    /// The loop of a record without its first period, if it has three or more: (u, z) with z by the inverse of a
    /// model's linear block, or (u, y) without a model; and notes on the inverse and on what makes the loop wrong.
    ///
    /// # Errors
    /// The errors of [`Record::output_in`], [`Arx::hidden`](crate::linear::Arx::hidden) and [`Branches::of_loop`].
    pub fn run(&self, record: &Record, model: Option<&Model>) -> Result<(HiddenLoop, Option<String>), Error> {
        let (z, inverse) = match model {
            Some(model) => {
                Record::same_sampling("the model", model.ts(), "the record", record.ts())?;
                let record = record.output_in(&model.units().y)?;
                model.linear().hidden(model.offset(), record.y())?
            }
            None => (record.y().to_vec(), None),
        };
        let mut points = LoopPoints::default();
        points.add(record, z)?;
        let found = points.split(self)?.swap_remove(0);
        let notes: Vec<String> =
            loop_defects(record).into_iter().chain(found.clockwise(model.is_some())).chain(inverse).collect();
        Ok((found, (!notes.is_empty()).then(|| notes.join(". "))))
    }
}

impl HiddenLoop {
    /// A note if the width is negative; `by_model` if the loop is that of the hidden variable.
    fn clockwise(&self, by_model: bool) -> Option<String> {
        let width = 100.0 * self.found.branches.width();
        let block = if by_model { ", or the linear block of the model is wrong" } else { "" };
        (width < 0.0).then(|| {
            format!(
                "The width is negative ({} %): the loop turns clockwise, with its ascending branch above. Loops of \
                 actuators turn counter-clockwise. The sign of the output may be inverted, or the output comes too \
                 early or drifts{block}",
                short(width)
            )
        })
    }

    /// Its figures as a document.
    pub fn to_json(&self) -> Value {
        json!({
            "frequency_hz": self.frequency_hz,
            "loop_width_percent": 100.0 * self.found.branches.width(),
            "ascending_below": self.found.ascending_below,
            "agreement": self.found.agreement,
            "error_percent": 100.0 * self.found.error,
            "line": self.found.line,
        })
    }
}

/// The points of the records by frequency, not yet split.
#[derive(Debug, Default)]
pub struct LoopPoints {
    points: Vec<Points>,
    /// Ends of u and mean of z of the first record.
    first: Option<((f64, f64), f64)>,
}

#[derive(Debug)]
struct Points {
    frequency_hz: Option<f64>,
    u: Vec<f64>,
    z: Vec<f64>,
}

impl LoopPoints {
    /// Adds the points of a record with hidden variable `z` to those of the same frequency. If it has three periods or
    /// more, the first is left out: loops close only after the first reversal. Because sensors drift, the z of a record
    /// with the same input range as the first is shifted to the mean of the first; a large shift gives a note. With
    /// another input range the mean may differ by hysteresis, and is kept.
    ///
    /// # Errors
    /// [`Error::TooShort`] if there is no complete loop.
    pub fn add(&mut self, record: &Record, mut z: Vec<f64>) -> Result<Option<String>, Error> {
        if z.len() < SHORTEST {
            let remedy = "record at least one period, better three".into();
            let what = "the hidden variable of a large-signal record".into();
            return Err(Error::TooShort { what, have: z.len(), need: SHORTEST, remedy });
        }
        let frequency_hz = cycle_rate(record.u(), record.ts());
        let period = frequency_hz.map_or(0, |hz| (1.0 / (hz * record.ts())).ceil() as usize);
        let skip = if 3 * period <= z.len() { period } else { 0 };
        let (u, z) = (&record.u()[skip..z.len()], &mut z[skip..]);
        let (ends_of_first, mean_of_first) = *self.first.get_or_insert((ends(u.iter().copied()), mean(z)));
        let shift = if alike(ends_of_first, ends(u.iter().copied())) { mean_of_first - mean(z) } else { 0.0 };
        z.iter_mut().for_each(|z| *z += shift);

        let same = |known: &&mut Points| match (known.frequency_hz, frequency_hz) {
            (Some(a), Some(b)) => (a / b - 1.0).abs() < SAME_FREQUENCY,
            (a, b) => a == b,
        };
        match self.points.iter_mut().find(same) {
            Some(known) => {
                known.u.extend(u);
                known.z.extend(&*z);
            }
            None => self.points.push(Points { frequency_hz, u: u.to_vec(), z: z.to_vec() }),
        }
        let (low, high) = ends(z.iter().copied());
        let share = shift.abs() / (high - low);
        Ok((share > SHIFTED).then(|| {
            let share = round(100.0 * share);
            format!(
                "the offset of a large-signal record differs from the first by {share} % of its height; it was removed"
            )
        }))
    }

    /// Merges all into one loop.
    pub fn pool(&mut self) {
        if self.points.len() > 1 {
            let concat = |part: fn(&Points) -> &Vec<f64>| self.points.iter().flat_map(part).copied().collect();
            self.points = vec![Points { frequency_hz: None, u: concat(|p| &p.u), z: concat(|p| &p.z) }];
        }
    }

    /// The loops, by rising frequency.
    ///
    /// # Errors
    /// The errors of [`Branches::of_loop`].
    pub fn split(mut self, options: &LoopOptions) -> Result<Vec<HiddenLoop>, Error> {
        self.points.sort_by(|p, q| p.frequency_hz.unwrap_or(0.0).total_cmp(&q.frequency_hz.unwrap_or(0.0)));
        let one = |Points { frequency_hz, u, z }| {
            let found = Branches::of_loop(&u, &z, options)?;
            Ok(HiddenLoop { frequency_hz, u, z, found })
        };
        self.points.into_iter().map(one).collect()
    }
}

/// True if two inputs have the same range, to a twentieth.
pub(super) fn alike((low, high): (f64, f64), (other_low, other_high): (f64, f64)) -> bool {
    (low - other_low).abs().max((high - other_high).abs()) <= 0.05 * (high - low)
}

/// Remarks on the loops, which were split by `split`.
pub fn remarks(loops: &[HiddenLoop], split: Split) -> Vec<String> {
    let unclear = named(loops, |found| found.agreement < MIN_OPEN_AGREEMENT).map(|which| {
        let advice = match split {
            Split::Line => ", try the option split = direction",
            Split::Direction => "",
        };
        format!(
            "{which} the line through the reversals does not separate the two branches: the loop crosses itself or is \
             hidden by noise{advice}"
        )
    });
    let inverted = named(loops, |found| found.agreement >= MIN_OPEN_AGREEMENT && !found.ascending_below).map(|which| {
        format!(
            "{which} the loop is inverted (ascending branch above descending): the linear block is wrong there, for \
             example because it lacks a resonance below this frequency, or because the sampling is too slow"
        )
    });
    unclear.into_iter().chain(inverted).collect()
}

/// The frequencies of the loops for which `are` is true, as text: "at 5, 20 Hz"; `None` without such loops.
pub fn named(loops: &[HiddenLoop], are: impl Fn(&MeasuredLoop) -> bool) -> Option<String> {
    let some: Vec<Option<f64>> = loops.iter().filter(|l| are(&l.found)).map(|l| l.frequency_hz).collect();
    let hz: Vec<String> = some.iter().flatten().map(|hz| round(*hz)).collect();
    match (some.is_empty(), hz.is_empty()) {
        (true, _) => None,
        (false, true) => Some("in a loop without a dominant frequency".into()),
        (false, false) => Some(format!("at {} Hz", hz.join(", "))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn record(hz: f64, bias: f64) -> Record {
        let u: Vec<f64> = (0..2000).map(|t| bias + 20.0 * (TAU * hz * f64::from(t) * 5e-4).sin()).collect();
        Record::new(5e-4, u.clone(), u).unwrap()
    }

    fn lagging(record: &Record, offset: f64) -> Vec<f64> {
        let u = record.u();
        (0..u.len()).map(|t| 2.0 * u[t.saturating_sub(3)] + offset).collect()
    }

    #[test]
    fn a_record_that_drifted_is_shifted_to_the_first_and_noted() {
        let mut gathered = LoopPoints::default();
        let (one, biased) = (record(20.0, 0.0), record(20.0, 5.0));
        assert_eq!(gathered.add(&one, lagging(&one, 0.0)).unwrap(), None);
        assert_eq!(gathered.add(&biased, lagging(&biased, 0.0)).unwrap(), None, "a bias of the input is no drift");
        let note = gathered.add(&one, lagging(&one, 50.0)).unwrap().unwrap();
        assert!(note.contains("by 62"), "{note}");
        let loops = gathered.split(&LoopOptions::default()).unwrap();
        assert!(loops.len() == 1 && loops[0].found.agreement > 0.9, "{}", loops[0].found.agreement);
    }

    /// A sensor that clips made a loop of 6 % one of 17 %, and a drift made one of -9 %, without a word.
    #[test]
    fn a_loop_that_a_defect_makes_wrong_or_that_turns_clockwise_has_a_note() {
        let record = record(5.0, 0.0);
        let y = lagging(&record, 0.0);
        let note = |y: Vec<f64>| {
            let record = Record::new(record.ts(), record.u().to_vec(), y).unwrap();
            LoopOptions::default().run(&record, None).unwrap().1
        };
        assert_eq!(note(y.clone()), None);
        let clipped = note(y.iter().map(|y| y.min(25.0)).collect()).unwrap();
        assert!(clipped.starts_with("Width and branches of this loop are wrong, because the output is saturated"));
        let inverted = note(y.iter().map(|y| -y).collect()).unwrap();
        assert!(inverted.contains("The width is negative") && inverted.contains("turns clockwise"), "{inverted}");
    }

    #[test]
    fn a_decaying_amplitude_does_not_change_the_frequency_of_a_loop() {
        let wave = |t: f64| (1.0 - 0.1 * t.floor()) * (1.0 - (TAU * t).cos());
        let u: Vec<f64> = (0..4000).map(|t| 50.0 * wave(0.002 * f64::from(t))).collect();
        let record = Record::new(5e-4, u.clone(), u).unwrap();
        let hz = LoopOptions::default().run(&record, None).unwrap().0.frequency_hz.unwrap();
        assert!((hz - 4.0).abs() < 0.01, "{hz}");
    }

    #[test]
    fn less_than_one_loop_is_an_error() {
        let error = LoopPoints::default().add(&record(20.0, 0.0), vec![0.0; 9]).unwrap_err().to_string();
        assert!(error.contains("has 9 samples") && error.contains("at least one period"), "{error}");
    }
}
