//! The cycles of an input, from one minimum to the next.

use libm::log;
use piezoid_numerics::series::{ends, quantile, range};
use std::ops::Range;

/// A reversal counts when the input has moved back by this share of its range.
pub const MIN_REVERSAL_SHARE: f64 = 0.02;

/// Upper limit of a regular input for the median second difference, over three cycles, of the logarithm of duration or
/// amplitude. It is 0 for sweeps and for rising amplitudes. PRBS and multisines with random phases exceed it. A
/// multisine with Schroeder phases is a sweep.
const REGULAR: f64 = 0.35;

/// A movement up and down.
#[derive(Debug, Clone, PartialEq)]
pub struct Cycle {
    /// From one minimum to the next, both included.
    pub samples: Range<usize>,
    /// The maximum.
    pub peak: usize,
    /// Half of peak-to-peak [input unit].
    pub amplitude: f64,
    /// Frequency [Hz].
    pub hz: f64,
}

impl Cycle {
    /// The cycle of `u` between these samples, its minimum, its maximum and the next minimum, with sampling period `ts`
    /// [s].
    pub fn of(u: &[f64], [start, peak, end]: [usize; 3], ts: f64) -> Self {
        let (amplitude, hz) = (0.5 * range(&u[start..=end]), 1.0 / ((end - start) as f64 * ts));
        Cycle { samples: start..end + 1, peak, amplitude, hz }
    }
}

/// The complete cycles of `u`, with sampling period `ts` [s]; empty if `u` is not regular.
pub fn cycles(u: &[f64], ts: f64) -> Vec<Cycle> {
    let reversals = reversals(u, MIN_REVERSAL_SHARE);
    // The first reversal is skipped if it is a maximum.
    let first = usize::from(reversals.len() > 1 && u[reversals[0]] > u[reversals[1]]);
    let found: Vec<Cycle> = reversals[first.min(reversals.len())..]
        .windows(3)
        .step_by(2)
        .map(|w| Cycle::of(u, [w[0], w[1], w[2]], ts))
        .collect();
    if are_regular(&found, REGULAR) { found } else { Vec::new() }
}

/// True if these are the cycles of a regular input; `most` is the limit for the amplitudes.
pub(super) fn are_regular(cycles: &[Cycle], most: f64) -> bool {
    let median = |of: fn(&Cycle) -> f64| {
        let bend = |w: &[Cycle]| log(of(&w[0]) * of(&w[2]) / of(&w[1]).powi(2)).abs();
        quantile(cycles.windows(3).map(bend).collect(), 0.5)
    };
    median(|c| c.hz) < REGULAR && median(|c| c.amplitude) < most
}

/// The reversals of `x`: the samples of its extremes between movements of more than a `share` of its range. For a held
/// extreme, its middle sample. The first and the last extreme of the record count if they are near a limit of the
/// range.
pub fn reversals(x: &[f64], share: f64) -> Vec<usize> {
    let mut reversals = Reversals::new(ends(x.iter().copied()), share);
    let mut found: Vec<usize> = x.iter().filter_map(|now| reversals.add(*now)).map(|turn| turn.at).collect();
    found.extend(reversals.end().map(|turn| turn.at));
    found
}

/// A reversal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Its sample.
    pub at: usize,
    /// The extreme.
    pub x: f64,
}

/// The [`reversals`] of a series of known range, sample by sample.
#[derive(Debug, Clone)]
struct Reversals {
    low: f64,
    high: f64,
    guard: f64,
    /// Number of samples so far.
    n: usize,
    /// The direction; 0 without a movement so far.
    trend: f64,
    /// The present extreme, its first and its last sample.
    extreme: f64,
    first: usize,
    last: usize,
}

impl Reversals {
    /// Before the first sample of a series with these ends.
    fn new((low, high): (f64, f64), share: f64) -> Self {
        let guard = share * (high - low);
        Reversals { low, high, guard, n: 0, trend: 0.0, extreme: 0.0, first: 0, last: 0 }
    }

    /// The next sample; returns the reversal that it shows.
    fn add(&mut self, now: f64) -> Option<Turn> {
        let t = self.n;
        self.n += 1;
        if t == 0 {
            self.extreme = now;
        }
        let beyond = (now - self.extreme) * self.trend;
        let turn = if self.trend == 0.0 {
            // No movement yet.
            if (now - self.extreme).abs() <= self.guard {
                return None;
            }
            self.trend = (now - self.extreme).signum();
            self.is_outermost().then_some(Turn { at: 0, x: self.extreme })
        } else if -beyond > self.guard {
            self.trend = -self.trend;
            Some(self.turn())
        } else if beyond >= 0.0 {
            self.last = t;
            if beyond > 0.0 {
                (self.extreme, self.first) = (now, t);
            }
            return None;
        } else {
            return None;
        };
        (self.extreme, self.first, self.last) = (now, t, t);
        turn
    }

    /// The last extreme, if it counts.
    fn end(&self) -> Option<Turn> {
        (self.trend != 0.0 && self.is_outermost()).then(|| self.turn())
    }

    fn turn(&self) -> Turn {
        Turn { at: self.first.midpoint(self.last), x: self.extreme }
    }

    fn is_outermost(&self) -> bool {
        (self.extreme - self.low).min(self.high - self.extreme) < 0.5 * self.guard
    }
}

/// The cycles of a series of known range, sample by sample, as minimum, maximum and minimum; and whether they are
/// regular.
#[derive(Debug, Clone)]
pub struct CycleSearch {
    reversals: Reversals,
    turns: Vec<Turn>,
    /// Durations and amplitudes of up to three cycles.
    cycles: Vec<[f64; 2]>,
    /// Number of second differences, and of those of durations and of amplitudes that are regular.
    bends: usize,
    regular: [usize; 2],
}

impl CycleSearch {
    /// Before the first sample of a series with these ends.
    pub fn new(ends: (f64, f64)) -> Self {
        let reversals = Reversals::new(ends, MIN_REVERSAL_SHARE);
        CycleSearch { reversals, turns: Vec::new(), cycles: Vec::new(), bends: 0, regular: [0; 2] }
    }

    /// The next sample; returns the cycle that ended before it.
    pub fn add(&mut self, now: f64) -> Option<[Turn; 3]> {
        let turn = self.reversals.add(now)?;
        self.cycle(turn)
    }

    /// The cycle that the end of the series shows. No sample may follow.
    pub fn end(&mut self) -> Option<[Turn; 3]> {
        let turn = self.reversals.end()?;
        self.cycle(turn)
    }

    fn cycle(&mut self, turn: Turn) -> Option<[Turn; 3]> {
        self.turns.push(turn);
        if let [a, b] = self.turns[..]
            && a.x > b.x
        {
            // It begins with a maximum.
            self.turns.remove(0);
        }
        let [start, peak, end] = self.turns[..] else { return None };
        self.turns = vec![end];
        self.cycles.push([(end.at - start.at) as f64, 0.5 * (peak.x - start.x.min(end.x))]);
        if let [a, b, c] = self.cycles[..] {
            self.bends += 1;
            for (k, regular) in self.regular.iter_mut().enumerate() {
                *regular += usize::from(log(a[k] * c[k] / b[k].powi(2)).abs() < REGULAR);
            }
            self.cycles.remove(0);
        }
        Some([start, peak, end])
    }

    /// True if the median second difference is that of a regular series.
    pub fn is_regular(&self) -> bool {
        self.bends == 0 || self.regular.iter().all(|regular| *regular > self.bends / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{Chirp, Multisine, Prbs, RisingSine, Sine, Staircase};

    const TS: f64 = 5e-4;

    #[test]
    fn the_cycles_of_a_sine_start_at_its_minima() {
        let u = Sine { amplitude: 3.0, frequency: 5.0, ..Sine::default() }.samples(TS, 2000).unwrap();
        let cycles = cycles(&u, TS);
        assert_eq!(cycles.iter().map(|c| c.samples.start).collect::<Vec<_>>(), [300, 700, 1100, 1500]);
        let right = |c: &Cycle| c.hz == 5.0 && (c.amplitude - 3.0).abs() < 1e-9 && c.peak == c.samples.start + 200;
        assert!(cycles.iter().all(right));
    }

    #[test]
    fn rising_sines_and_sweeps_have_cycles() {
        let rising = RisingSine { amplitude: 3.0, frequency: 5.0, ..RisingSine::default() }.samples(TS, 8000).unwrap();
        let amplitudes: Vec<f64> = cycles(&rising, TS).iter().map(|c| c.amplitude).collect();
        assert!(amplitudes.len() > 15 && amplitudes.is_sorted(), "{amplitudes:?}");
        let sweep = Chirp { frequency_start: 1.0, frequency_end: 50.0, ..Chirp::default() };
        let hz: Vec<f64> = cycles(&sweep.samples(TS, 8000).unwrap(), TS).iter().map(|c| c.hz).collect();
        assert!(hz[0] < 6.0 && hz[hz.len() - 1] > 45.0, "{hz:?}");
    }

    #[test]
    fn steps_are_not_reversals_and_broadband_inputs_have_no_cycles() {
        let steps = Staircase { amplitude: 3.0, frequency: 5.0, ..Staircase::default() }.samples(TS, 2000).unwrap();
        assert_eq!(cycles(&steps, TS).len(), 4);
        assert!(cycles(&Prbs::default().samples(TS, 2047).unwrap(), TS).is_empty());
        let wide = Multisine { frequency_high: 300.0, seed: 3, ..Multisine::default() }.samples(TS, 4000).unwrap();
        assert!(cycles(&wide, TS).is_empty());
        assert!(cycles(&[1.0; 50], TS).is_empty() && cycles(&[1.0, 2.0], TS).is_empty());
    }
}
