//! What the records of a rig are probably for, by their drives: a proposal that a user confirms.
//!
//! A small-signal record, for the linear block, has a small part of the largest range and many frequencies. All others
//! exercise the hysteresis. One of them is proposed for validation if its waveform is of another kind than those of the
//! others, and lies within their range: a model that predicts it has not learnt one waveform by heart.

use crate::record::{Record, Units};
use crate::waveform::{CycleGroups, band, reversals};
use piezoid_numerics::number::round;
use piezoid_numerics::series::{ends, range};

/// Largest range of a small signal, relative to that of the rig: an amplitude of 10 % of it, and noise.
const MAX_SMALL_RANGE_SHARE: f64 = 0.22;

/// Least range of the record for validation, relative to that of the rig.
const MIN_VALIDATION_RANGE_SHARE: f64 = 0.5;

/// A drive has many frequencies if the limits of its band have this ratio. A triangle stays below.
const MIN_BAND_RATIO: f64 = 4.0;

/// Cycles are equal if their amplitudes have at least this ratio to half the range of the drive.
const MIN_EQUAL_AMPLITUDE_SHARE: f64 = 0.8;

/// An irregular drive turns at least so often, by this share of its range. One that turns less often shows creep.
const MIN_REVERSALS: usize = 8;
const MIN_REVERSAL_SHARE: f64 = 0.1;

/// The record for validation may exceed the range of the others by this share of it.
const MAX_BEYOND_SHARE: f64 = 0.02;

/// What a record is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Identification of the hysteresis: a large-signal record.
    Training,
    /// Identification of the linear block.
    SmallSignal,
    /// Validation of the model.
    Validation,
}

impl Use {
    /// Its name in documents.
    pub fn name(self) -> &'static str {
        match self {
            Use::Training => "training",
            Use::SmallSignal => "small-signal",
            Use::Validation => "validation",
        }
    }
}

/// A proposed use, and the reason in one sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The use.
    pub of: Use,
    /// The reason.
    pub because: String,
}

/// The kind of a waveform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Waveform {
    Equal,
    Changing,
    Irregular,
    Few,
}

impl Waveform {
    fn words(self) -> &'static str {
        match self {
            Waveform::Equal => "equal cycles",
            Waveform::Changing => "cycles that change in amplitude or frequency",
            Waveform::Irregular => "no regular cycles",
            Waveform::Few => "few reversals",
        }
    }
}

/// The drive of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    ends: (f64, f64),
    unit: String,
    band: Option<(f64, f64)>,
    waveform: Waveform,
}

impl Drive {
    /// That of a record.
    pub fn of(record: &Record) -> Self {
        let (u, ts) = (record.u(), record.ts());
        let found = CycleGroups::of(u, ts);
        let amplitudes = found.groups.iter().map(|group| group.amplitude);
        let frequencies = ends(found.groups.iter().map(|group| group.frequency));
        let is_equal = amplitudes.fold(f64::INFINITY, f64::min) >= 0.5 * MIN_EQUAL_AMPLITUDE_SHARE * range(u)
            && frequencies.0 >= MIN_EQUAL_AMPLITUDE_SHARE * frequencies.1;
        let waveform = match found.groups.is_empty() {
            false if is_equal && found.minor.is_empty() => Waveform::Equal,
            false => Waveform::Changing,
            true if reversals(u, MIN_REVERSAL_SHARE).len() >= MIN_REVERSALS => Waveform::Irregular,
            true => Waveform::Few,
        };
        let drive = Drive { ends: (0.0, 0.0), unit: record.units().u.clone(), band: band(u, ts), waveform };
        drive.between(ends(u.iter().copied()))
    }

    /// The same for a longer record, whose input has these ends. Files of one rig may have other units: ends are in V.
    pub fn between(self, (low, high): (f64, f64)) -> Self {
        match Units::factor(&self.unit, "V") {
            Some(volts) => Drive { ends: (volts * low, volts * high), unit: "V".into(), ..self },
            None => Drive { ends: (low, high), ..self },
        }
    }

    fn range(&self) -> f64 {
        self.ends.1 - self.ends.0
    }

    fn is_rich(&self) -> bool {
        self.band.is_some_and(|(low, high)| high > MIN_BAND_RATIO * low)
    }
}

/// The proposed use of each record of a rig. One that is alone is for training.
pub fn uses(drives: &[&Drive]) -> Vec<Proposal> {
    let largest = |of: &Drive| {
        let same = drives.iter().filter(|drive| drive.unit == of.unit);
        same.map(|drive| drive.range()).fold(0.0, f64::max)
    };
    let is_small = |drive: &Drive| drive.range() <= MAX_SMALL_RANGE_SHARE * largest(drive) && drive.is_rich();
    let validates = validation(drives, &is_small);
    let proposal = |(k, drive): (usize, &&Drive)| {
        let (largest, unit) = (largest(drive), &drive.unit);
        let size = match round((100.0 * drive.range() / largest).round()) {
            _ if largest == 0.0 => "its input does not move".into(),
            percent => format!("its input has {percent} % of the largest range, {} {unit}", round(largest)),
        };
        let (of, because) = if is_small(drive) {
            let (low, high) = drive.band.unwrap_or_default();
            let band = [low, high].map(|hz| round((hz * 10.0).round() / 10.0));
            (Use::SmallSignal, format!("{size}, and frequencies from {} to {} Hz", band[0], band[1]))
        } else if validates == Some(k) {
            let own = drive.waveform.words();
            (Use::Validation, format!("its input has {own}, unlike that of the other records, and stays within theirs"))
        } else {
            (Use::Training, format!("{size}, and {}", drive.waveform.words()))
        };
        Proposal { of, because }
    };
    drives.iter().enumerate().map(proposal).collect()
}

/// The record for validation: the only one of its kind among at least three large-signal records, and within the range
/// of the others. One without regular cycles is preferred; one with few reversals shows creep, which a model needs.
fn validation(drives: &[&Drive], is_small: &dyn Fn(&Drive) -> bool) -> Option<usize> {
    let large: Vec<usize> = (0..drives.len()).filter(|k| !is_small(drives[*k])).collect();
    let is_within = |k: usize| {
        let others = large.iter().filter(|other| **other != k && drives[**other].unit == drives[k].unit);
        let others = others.map(|other| drives[*other].ends);
        let (low, high) = others.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (a, b)| (l.min(a), h.max(b)));
        let margin = MAX_BEYOND_SHARE * (high - low);
        drives[k].ends.0 >= low - margin && drives[k].ends.1 <= high + margin
    };
    let largest = drives.iter().map(|drive| drive.range()).fold(0.0, f64::max);
    let only = |kind: Waveform| {
        let mut alike = large.iter().copied().filter(|k| drives[*k].waveform == kind);
        let first = alike.next().filter(|_| alike.next().is_none())?;
        let is_large = drives[first].range() >= MIN_VALIDATION_RANGE_SHARE * largest;
        (is_large && is_within(first)).then_some(first)
    };
    let kinds = [Waveform::Irregular, Waveform::Changing, Waveform::Equal];
    (large.len() >= 3).then(|| kinds.into_iter().find_map(only)).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{Chirp, DecayingSine, Multisine, Prbs, Sine};
    use piezoid_testing::noise;

    const TS: f64 = 1e-3;

    fn about(bias: f64, u: Vec<f64>) -> Drive {
        let u: Vec<f64> = u.iter().map(|u| bias + u).collect();
        Drive::of(&Record::new(TS, u.clone(), u).unwrap())
    }

    fn sine(amplitude: f64, frequency: f64) -> Drive {
        about(50.0, Sine { amplitude, frequency, offset: 0.0 }.samples(TS, 4000).unwrap())
    }

    /// Levels without order, each held for 100 samples.
    fn steps() -> Drive {
        let level = |e: &f64| [(50.0 + 15.0 * e).clamp(0.0, 100.0); 100];
        about(0.0, noise(8, 60).iter().flat_map(level).collect())
    }

    fn names(drives: &[Drive]) -> Vec<&'static str> {
        uses(&drives.iter().collect::<Vec<_>>()).iter().map(|proposal| proposal.of.name()).collect()
    }

    #[test]
    fn broadband_records_of_a_small_range_are_small_signals_and_small_sines_are_not() {
        let chirp = Chirp { amplitude: 9.0, frequency_start: 2.0, frequency_end: 200.0, ..Chirp::default() };
        let small = [
            about(50.0, Prbs::default().samples(TS, 4000).unwrap()),
            about(50.0, Multisine { frequency_high: 300.0, ..Multisine::default() }.samples(TS, 4000).unwrap()),
            about(50.0, chirp.samples(TS, 4000).unwrap()),
        ];
        for drive in small {
            assert_eq!(names(&[sine(50.0, 2.0), drive.clone()]), ["training", "small-signal"], "{drive:?}");
            assert_eq!(names(&[drive.clone(), drive]), ["training", "training"], "all records are as small");
        }
        assert_eq!(names(&[sine(50.0, 2.0), sine(5.0, 20.0)]), ["training", "training"]);
    }

    #[test]
    fn the_only_record_of_another_waveform_is_proposed_for_validation_with_its_reason() {
        let rig = [sine(50.0, 1.0), sine(50.0, 10.0), steps()];
        assert_eq!(names(&rig), ["training", "training", "validation"]);
        let because = &uses(&rig.iter().collect::<Vec<_>>())[2].because;
        assert_eq!(
            because,
            "its input has no regular cycles, unlike that of the other records, and stays within theirs"
        );
        let decaying = DecayingSine { amplitude: 45.0, frequency: 4.0, ..DecayingSine::default() };
        let decaying = about(50.0, decaying.samples(TS, 6000).unwrap());
        assert_eq!(names(&[sine(50.0, 1.0), decaying, sine(50.0, 10.0), steps()])[3], "validation");
        // A model would extrapolate; or two records would be left to one waveform each.
        assert_eq!(names(&[sine(30.0, 1.0), sine(30.0, 10.0), steps()]), ["training"; 3]);
        assert_eq!(names(&[sine(50.0, 1.0), steps()]), ["training"; 2]);
    }

    #[test]
    fn ranges_are_compared_in_one_unit() {
        let millivolts = |drive: Vec<f64>| {
            let u: Vec<f64> = drive.iter().map(|u| 1e3 * u).collect();
            let units = Units { u: "mV".into(), y: "um".into() };
            Drive::of(&Record::new(TS, u.clone(), u).unwrap().with_units(units))
        };
        let wave = Prbs::default().samples(TS, 4000).unwrap();
        assert_eq!(names(&[sine(50.0, 2.0), millivolts(wave)]), ["training", "small-signal"]);
    }

    #[test]
    fn records_without_a_movement_have_a_use_too() {
        let still = [about(2.0, vec![0.0; 50]), about(2.0, vec![0.0])];
        assert_eq!(names(&still), ["training"; 2]);
        assert_eq!(uses(&[&still[0], &still[1]])[0].because, "its input does not move, and few reversals");
        assert!(uses(&[]).is_empty());
    }
}
