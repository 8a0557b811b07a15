//! Which modes of a linear block the records can show: those in free decays, and those that the inputs excite.

use super::POLICY;
use super::fit::{MAX_MODE_DAMPING, MIN_MODE_DAMPING, Spread};
use libm::log;
use piezoid_models::linear::{Arx, Pole, PoleShare, free_decay_modes};
use piezoid_records::record::Record;
use piezoid_records::waveform::dominant_frequency;

/// Evidence for modes in the records.
pub(super) struct ModeEvidence {
    /// Modes in free decays.
    pub(super) free_decays: Vec<Pole>,
    /// The lowest frequency of a mode that shows only in the response to the inputs [Hz].
    pub(super) lowest: f64,
    /// The frequency above which a mode is above those of the inputs [Hz].
    above: f64,
    /// True if the inputs have one frequency: hysteresis explains its harmonics, so they show no mode.
    one_frequency: bool,
    /// True if the inputs show modes between their frequencies, and more than one above them.
    is_broad: bool,
    /// True if the user specified the order, who knows that there are as many poles.
    is_order_specified: bool,
}

impl ModeEvidence {
    /// The evidence in these records, small-signal ones included.
    pub(super) fn of(records: &[Record], is_order_specified: bool) -> Self {
        let input_hz = records.iter().filter_map(|record| dominant_frequency(record.u(), record.ts()));
        let mut input_hz: Vec<f64> = input_hz.collect();
        input_hz.sort_by(f64::total_cmp);
        let above = POLICY.above_inputs_ratio * input_hz.iter().copied().fold(0.0, f64::max);
        // Between a few frequencies of the inputs, a mode could be anywhere.
        let many = POLICY.many_frequencies;
        let spread: Vec<Spread> = records.iter().map(Spread::of).collect();
        let broad: Vec<f64> = spread.iter().filter(|one| one.lines >= many as f64).map(|one| one.low).collect();
        let is_many = input_hz.len() >= many;
        let lowest = broad.iter().chain(input_hz.iter().filter(|_| is_many)).copied().fold(above, f64::min);
        let fastest = spread.iter().map(|one| one.high).fold(0.0, f64::max);
        let is_one = input_hz.first().is_some_and(|slowest| fastest < POLICY.above_inputs_ratio * slowest);
        ModeEvidence {
            free_decays: free_decay_modes(records),
            lowest: if is_order_specified { 0.0 } else { lowest },
            above,
            one_frequency: broad.is_empty() && is_one,
            is_broad: !broad.is_empty() || is_many,
            is_order_specified,
        }
    }

    /// True if free decays show a mode of this frequency [Hz].
    pub(super) fn is_in_free_decays(&self, hz: f64) -> bool {
        self.free_decays.iter().any(|mode| log(mode.hz / hz).abs() < POLICY.same_mode_distance)
    }

    /// True if each mode of a linear block shows in the records, or if the order is specified. The harmonics of a few
    /// frequencies show one mode above them.
    pub(super) fn shows(&self, linear: &Arx) -> bool {
        if self.is_order_specified {
            return true;
        }
        let modes = linear.modal_form().modes().into_iter();
        let rings = |p: &PoleShare| p.pole.z.im > 0.0 && p.pole.damping < MAX_MODE_DAMPING;
        let excited: Vec<PoleShare> = modes.filter(|p| rings(p) && !self.is_in_free_decays(p.pole.hz)).collect();
        let is_excited = |p: &PoleShare| {
            let within = p.pole.hz >= self.lowest && p.share >= POLICY.min_mode_share;
            !self.one_frequency && (p.pole.hz >= self.above || within)
        };
        excited.iter().all(is_excited) && (self.is_broad || excited.len() <= 1)
    }

    /// True if a linear block is possible: its modes show in the records, or its error is so much smaller than the
    /// `least` so far that they need no further evidence; and none is at a limit.
    pub(super) fn allows(&self, linear: &Arx, error: f64, least: f64) -> bool {
        let is_obvious = !self.one_frequency && error < POLICY.obvious_mode_ratio * least;
        (self.shows(linear) || is_obvious) && !self.is_at_limit(linear)
    }

    /// True if a mode is at the least damping that the fit allows: it stands for something else, as a line of the
    /// input's spectrum or what its own state in each record can explain.
    fn is_at_limit(&self, linear: &Arx) -> bool {
        let least = POLICY.least_damping_ratio * MIN_MODE_DAMPING;
        linear.poles().iter().any(|pole| pole.damping < least && !self.is_in_free_decays(pole.hz))
    }

    /// Evidence for every mode from a frequency [Hz] on.
    #[cfg(test)]
    pub(super) fn of_all(lowest: f64) -> Self {
        let (free_decays, above) = (Vec::new(), lowest);
        ModeEvidence { free_decays, lowest, above, one_frequency: false, is_broad: true, is_order_specified: true }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::pair;
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_mode_at_the_least_damping_is_at_a_limit_unless_a_free_decay_shows_it() {
        let u: Vec<f64> = (0..2000).map(|t| (0.05 * f64::from(t)).sin()).collect();
        let records = [Record::new(5e-4, u.clone(), u).unwrap()];
        let mut evidence = ModeEvidence::of(&records, false);
        let block = |damping: f64| pair(5e-4, 100.0, damping);
        assert!(evidence.is_at_limit(&block(0.0021)) && !evidence.is_at_limit(&block(0.003)));
        evidence.free_decays = block(0.0021).poles();
        assert!(!evidence.is_at_limit(&block(0.0021)));
    }

    #[test]
    fn a_mode_shows_between_the_frequencies_of_the_inputs_above_them_or_in_a_free_decay() {
        let few = || {
            let (free_decays, lowest, above) = (Vec::new(), 50.0, 200.0);
            ModeEvidence {
                free_decays,
                lowest,
                above,
                one_frequency: false,
                is_broad: false,
                is_order_specified: false,
            }
        };
        let block = |hz: f64| pair(5e-4, hz, 0.05);
        let shown = |evidence: &ModeEvidence| [40.0, 60.0, 150.0, 250.0].map(|hz| evidence.shows(&block(hz)));
        assert_eq!(shown(&few()), [false, true, true, true]);
        assert_eq!(shown(&ModeEvidence { lowest: 200.0, ..few() }), [false, false, false, true]);
        assert_eq!(shown(&ModeEvidence { one_frequency: true, ..few() }), [false; 4]);
        assert_eq!(shown(&ModeEvidence { is_order_specified: true, ..few() }), [true; 4]);
        assert!(few().shows(&pair(5e-4, 40.0, 0.6)), "it does not ring");
        let decays = ModeEvidence { free_decays: block(40.0).poles(), ..few() };
        assert_eq!([33.0, 48.0, 49.5].map(|hz| decays.shows(&block(hz))), [true, true, false]);

        // Few frequencies show one mode, not two.
        let (one, other) = (block(100.0).denominator(), block(300.0).denominator());
        let mut both = [0.0; 5];
        (0..9).for_each(|k| both[k / 3 + k % 3] += one[k / 3] * other[k % 3]);
        let two = Arx::new(5e-4, both[1..].iter().map(|c| -c).collect(), vec![0.1]).unwrap();
        assert!(!few().shows(&two) && ModeEvidence { is_broad: true, ..few() }.shows(&two));

        // An error of less than three tenths needs no evidence, unless the inputs have one frequency.
        assert_eq!([0.29, 0.31].map(|error| few().allows(&block(40.0), error, 1.0)), [true, false]);
        assert!(!ModeEvidence { one_frequency: true, ..few() }.allows(&block(40.0), 0.29, 1.0));
        assert!(few().allows(&block(100.0), 5.0, 1.0));
    }

    #[test]
    fn the_frequencies_of_the_inputs_are_the_evidence() {
        let sum = |lines: &[f64]| {
            let wave = |t: i32| lines.iter().map(|hz| (TAU * hz * 1e-3 * f64::from(t)).sin()).sum::<f64>();
            let u: Vec<f64> = (0..2000).map(wave).collect();
            Record::new(1e-3, u.clone(), u).unwrap()
        };
        let of = |inputs: &[&[f64]], is_order_specified: bool| {
            let records: Vec<Record> = inputs.iter().map(|lines| sum(lines)).collect();
            let found = ModeEvidence::of(&records, is_order_specified);
            (found.lowest.round(), found.one_frequency, found.is_broad)
        };
        let lines = [10.0, 12.0, 14.0, 16.0, 18.0, 19.0];
        assert_eq!(of(&[&lines[..1]], false), (20.0, true, false));
        assert_eq!(of(&[&[10.0], &[19.0]], false), (38.0, true, false));
        assert_eq!(of(&[&[10.0], &[21.0]], false), (42.0, false, false));
        assert_eq!(of(&[&[10.0], &[21.0]], true), (0.0, false, false));
        let each: Vec<&[f64]> = lines.chunks(1).collect();
        assert_eq!(of(&each[..5], false), (36.0, true, false));
        assert_eq!(of(&each, false), (10.0, true, true));
        assert_eq!(of(&[&[10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0]], false), (10.0, false, true));
    }
}
