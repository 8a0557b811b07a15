//! The parts of a record that a figure draws, so that single loops and single periods are seen.
//!
//! A rising sine has a hundred loops inside each other, which together are a filled area. Three of them show the same:
//! the largest, a middle one and a small one.

use piezoid::Record;
use piezoid_numerics::number::short;
use piezoid_numerics::series::ends;
use piezoid_records::waveform::{Cycle, cycles};
use std::ops::Range;

/// Number of samples drawn of an input without cycles: more of them are a filled area.
const SHOWN: usize = 400;

/// Amplitudes of the loops drawn, relative to the largest.
const AMPLITUDES: [f64; 3] = [1.0, 0.55, 0.2];

/// Ratio from which amplitudes, or frequencies, count as different.
const DIFFERENT: f64 = 1.15;

/// Number of periods that a plot over time shows.
const PERIODS: usize = 8;

/// Samples of the loops to draw, and a sentence for the caption after a space.
#[derive(Debug, PartialEq)]
pub(super) struct Drawn {
    pub(super) parts: Vec<Range<usize>>,
    pub(super) words: String,
}

/// The loops to draw of a record from sample `start` on: one for each of a few amplitudes, or else frequencies. Without
/// cycles, a part around sample `about`; `None` for an input of two values, which has no loops.
pub(super) fn loops(record: &Record, start: usize, about: usize) -> Option<Drawn> {
    let found = cycles(&record.u()[start..], record.ts());
    let (amplitude, hz): (Value, Value) = (|c| c.amplitude, |c| c.hz);
    let unit = &record.units().u;
    if found.is_empty() {
        let (low, high) = ends(record.u()[start..].iter().copied());
        let binary = record.u()[start..].iter().all(|u| *u == low || *u == high);
        let (part, words) = part(record, start, about);
        let words = if words.is_empty() { words } else { format!(" They are drawn{words}.") };
        return (!binary).then(|| Drawn { parts: vec![part], words });
    }
    let (mut chosen, what) = match spread(&found, amplitude) {
        many if many > DIFFERENT => (AMPLITUDES.map(|share| near(&found, amplitude, share * many)).to_vec(), true),
        _ => match spread(&found, hz) {
            many if many > DIFFERENT => ([many, many.sqrt(), 1.0].map(|x| near(&found, hz, x)).to_vec(), false),
            _ => (vec![found.len() - 1], true),
        },
    };
    chosen.dedup();
    let value = |&k: &usize| if what { short(found[k].amplitude) } else { short(found[k].hz) };
    let values: Vec<String> = chosen.iter().map(value).collect();
    let (of, unit) = if what { ("amplitude", unit.as_str()) } else { ("frequency", "Hz") };
    let words = match (&values[..], found.len()) {
        ([_], 1) => " The only cycle of the input is drawn.".to_string(),
        ([one], n) => format!(" Drawn is the last of {n} cycles, of {of} {one} {unit}."),
        ([less @ .., last], n) => {
            let (count, less) = (values.len(), less.join(", "));
            format!(" Drawn are {count} of {n} cycles, of {of} {less} and {last} {unit}.")
        }
        ([], _) => String::new(),
    };
    let part = |k: usize| start + found[k].samples.start..start + found[k].samples.end;
    Some(Drawn { parts: chosen.into_iter().map(part).collect(), words })
}

/// The samples of a plot over time, and the words for its caption: a few periods around sample `about`, or all if they
/// are few.
pub(super) fn periods(record: &Record, start: usize, about: usize) -> (Range<usize>, String) {
    let found = cycles(&record.u()[start..], record.ts());
    if found.is_empty() {
        return part(record, start, about);
    }
    if found.len() <= 2 * PERIODS {
        return (start..record.len(), String::new());
    }
    let at = found.iter().position(|c| c.samples.end > about - start.min(about)).unwrap_or(found.len() - 1);
    let first = at.saturating_sub(PERIODS / 2).min(found.len() - PERIODS);
    let part = start + found[first].samples.start..start + found[first + PERIODS - 1].samples.end;
    let n = found.len();
    (part, format!(" over {PERIODS} of {n} periods, near the largest residual"))
}

type Value = fn(&Cycle) -> f64;

/// The largest value over the smallest.
fn spread(found: &[Cycle], of: Value) -> f64 {
    let [low, high] = [f64::min, f64::max].map(|pick| found.iter().map(of).reduce(pick).unwrap_or(1.0));
    high / low
}

/// The last cycle whose value is nearest to `times` the smallest, as a ratio.
fn near(found: &[Cycle], of: Value, times: f64) -> usize {
    let least = found.iter().map(of).reduce(f64::min).unwrap_or(1.0);
    let off = |k: &usize| (of(&found[*k]) / (least * times)).ln().abs();
    (0..found.len()).rev().min_by(|i, j| off(i).total_cmp(&off(j))).unwrap_or(0)
}

/// A part of the record around sample `about`.
fn part(record: &Record, start: usize, about: usize) -> (Range<usize>, String) {
    let first = about.saturating_sub(SHOWN / 2).min(record.len().saturating_sub(SHOWN)).max(start);
    let part = first..record.len().min(first + SHOWN);
    let all = part == (start..record.len());
    let words = if all { String::new() } else { format!(" over {} samples, near the largest residual", part.len()) };
    (part, words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::excitation::{Chirp, Multisine, Prbs, RisingSine, Sine};

    fn drawn(u: Vec<f64>) -> Drawn {
        loops(&Record::new(5e-4, u.clone(), u).unwrap(), 0, 0).unwrap()
    }

    #[test]
    fn of_a_rising_sine_three_amplitudes_are_drawn_each_once() {
        let rising = RisingSine { amplitude: 28.0, frequency: 20.0, ..RisingSine::default() };
        let Drawn { parts, words } = drawn(rising.samples(5e-4, 4000).unwrap());
        assert_eq!(parts.len(), 3);
        assert!(parts.iter().all(|p| (95..=105).contains(&p.len())), "{parts:?}");
        assert!(words.starts_with(" Drawn are 3 of 38 cycles, of amplitude 28.00, 15.44 and "), "{words}");
    }

    #[test]
    fn of_a_sweep_three_frequencies_and_of_a_sine_the_last_cycle() {
        let sweep = Chirp { frequency_start: 1.0, frequency_end: 50.0, ..Chirp::default() };
        let words = drawn(sweep.samples(5e-4, 8000).unwrap()).words;
        assert!(words.contains("of frequency "), "{words}");
        let sine = Sine { amplitude: 3.0, frequency: 5.0, ..Sine::default() }.samples(5e-4, 2000).unwrap();
        let Drawn { parts, words } = drawn(sine);
        assert_eq!((parts[0].clone(), parts.len()), (1500..1901, 1));
        assert_eq!(words, " Drawn is the last of 4 cycles, of amplitude 3.000 V.");
    }

    #[test]
    fn an_input_without_cycles_is_drawn_in_part_and_a_binary_one_has_no_loops() {
        let of = |u: Vec<f64>| Record::new(5e-4, u.clone(), u).unwrap();
        let binary = of(Prbs::default().samples(5e-4, 5000).unwrap());
        assert_eq!(loops(&binary, 0, 4990), None);
        assert_eq!(periods(&binary, 0, 4990).0, 4600..5000);
        let wide = Multisine { frequency_high: 300.0, seed: 3, ..Multisine::default() };
        let Drawn { parts, words } = loops(&of(wide.samples(5e-4, 4000).unwrap()), 100, 150).unwrap();
        assert_eq!((parts[0].clone(), words.contains("400 samples")), (100..500, true), "{words}");
        let all = periods(&of(vec![0.0, 1.0, 1.0, 0.0]), 0, 2);
        assert_eq!(all, (0..4, String::new()));
    }
}
