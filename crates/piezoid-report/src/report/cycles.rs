//! The parts of a record that a figure draws, so that single loops and single periods are seen.
//!
//! A rising sine has a hundred loops inside each other, which together are a filled area. Three of them show the same:
//! the largest, a middle one and a small one.

use piezoid::Record;
use piezoid::number::short;
use piezoid::waveform::{Cycle, cycles};
use std::ops::Range;

/// Largest number of samples drawn of an input without cycles.
const SHOWN: usize = 4000;

/// Amplitudes of the loops drawn, relative to the largest.
const AMPLITUDES: [f64; 3] = [1.0, 0.55, 0.2];

/// Ratio from which amplitudes, or frequencies, count as different.
const DIFFERENT: f64 = 1.15;

/// Number of periods that a plot over time shows.
const PERIODS: usize = 8;

/// Samples to draw, and the words for the caption.
#[derive(Debug, PartialEq)]
pub(super) struct Drawn {
    pub(super) parts: Vec<Range<usize>>,
    pub(super) words: String,
}

/// The loops to draw of a record from sample `start` on: one for each of a few amplitudes, or else frequencies.
pub(super) fn loops(record: &Record, start: usize) -> Drawn {
    let found = cycles(&record.u()[start..], record.ts());
    let (amplitude, hz): (Value, Value) = (|c| c.amplitude, |c| c.hz);
    let unit = &record.units().u;
    let (mut chosen, what) = match spread(&found, amplitude) {
        _ if found.is_empty() => return first_part(record, start),
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
        ([_], 1) => "The only cycle of the input is drawn.".to_string(),
        ([one], n) => format!("Drawn is the last of {n} cycles, of {of} {one} {unit}."),
        ([less @ .., last], n) => {
            let (count, less) = (values.len(), less.join(", "));
            format!("Drawn are {count} of {n} cycles, of {of} {less} and {last} {unit}.")
        }
        ([], _) => String::new(),
    };
    let part = |k: usize| start + found[k].samples.start..start + found[k].samples.end;
    Drawn { parts: chosen.into_iter().map(part).collect(), words }
}

/// The samples of a plot over time: a few periods about sample `about`, or all if they are few.
pub(super) fn periods(record: &Record, start: usize, about: usize) -> Drawn {
    let found = cycles(&record.u()[start..], record.ts());
    if found.len() <= 2 * PERIODS {
        let first = first_part(record, start);
        let words = if first.parts[0].end < record.len() { " over the first part of the record" } else { "" };
        return Drawn { words: words.into(), ..first };
    }
    let at = found.iter().position(|c| c.samples.end > about - start.min(about)).unwrap_or(found.len() - 1);
    let first = at.saturating_sub(PERIODS / 2).min(found.len() - PERIODS);
    let part = start + found[first].samples.start..start + found[first + PERIODS - 1].samples.end;
    let n = found.len();
    Drawn { parts: vec![part], words: format!(" over {PERIODS} of {n} periods, at the largest residual") }
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

fn first_part(record: &Record, start: usize) -> Drawn {
    let end = record.len().min(start + SHOWN);
    let words =
        if end < record.len() { "Drawn is the first part of the record." } else { "Drawn is the whole record." };
    Drawn { parts: vec![start..end], words: words.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::excitation::{Chirp, Prbs, RisingSine, Sine};

    fn drawn(u: Vec<f64>) -> Drawn {
        loops(&Record::new(5e-4, u.clone(), u).unwrap(), 0)
    }

    #[test]
    fn of_a_rising_sine_three_amplitudes_are_drawn_each_once() {
        let rising = RisingSine { amplitude: 28.0, frequency: 20.0, ..RisingSine::default() };
        let Drawn { parts, words } = drawn(rising.samples(5e-4, 4000).unwrap());
        assert_eq!(parts.len(), 3);
        assert!(parts.iter().all(|p| (95..=105).contains(&p.len())), "{parts:?}");
        assert!(words.starts_with("Drawn are 3 of 38 cycles, of amplitude 28.00, 15.44 and "), "{words}");
    }

    #[test]
    fn of_a_sweep_three_frequencies_and_of_a_sine_the_last_cycle() {
        let sweep = Chirp { frequency_start: 1.0, frequency_end: 50.0, ..Chirp::default() };
        let words = drawn(sweep.samples(5e-4, 8000).unwrap()).words;
        assert!(words.contains("of frequency "), "{words}");
        let sine = Sine { amplitude: 3.0, frequency: 5.0, ..Sine::default() }.samples(5e-4, 2000).unwrap();
        let one =
            Drawn { parts: vec![1500..1901], words: "Drawn is the last of 4 cycles, of amplitude 3.000 V.".into() };
        assert_eq!(drawn(sine), one);
    }

    #[test]
    fn an_input_without_cycles_is_drawn_from_its_start() {
        let Drawn { parts, words } = drawn(Prbs::default().samples(5e-4, 5000).unwrap());
        assert_eq!((&parts[..], words.contains("first part")), (&[0..4000][..], true));
    }
}
