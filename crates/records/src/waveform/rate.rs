//! The rate of the cycles of an input.
//!
//! A cycle runs from one rise to the next. The time of a rise is that at which it passes a level: the mid-value of the
//! whole input, or the middle of this rise. The first is exact for a sine that rises about a constant value. The second
//! is exact for one that decays towards an end of the range, which passes a fixed level later from cycle to cycle, and
//! soon not at all. Of the two, the one with the more even cycles counts.

use super::{crossings, reversals};
use piezoid_numerics::series::{mean, quantile};

/// A reversal counts when the input has moved back by this share of its range.
const BACK: f64 = 0.1;

/// Cycles are steady if at least this share of them last as long as the median one, up to this relative difference.
const MIN_STEADY_CYCLE_SHARE: f64 = 0.8;
const MAX_CYCLE_DEVIATION: f64 = 0.1;

/// The rate of the cycles of `u` [Hz], with sampling period `ts` [s]; `None` if there is no whole cycle, or if the
/// cycles differ in length, as those of random steps, of a PRBS and of a sweep.
pub fn cycle_rate(u: &[f64], ts: f64) -> Option<f64> {
    let reversals = reversals(u, BACK);
    let middle = |w: &[usize]| {
        let level = 0.5 * u[w[0]] + 0.5 * u[w[1]];
        let t = (w[0]..w[1]).find(|&t| u[t] < level && u[t + 1] >= level)?;
        Some(t as f64 + (level - u[t]) / (u[t + 1] - u[t]))
    };
    let rises: Vec<f64> = reversals.windows(2).filter(|w| u[w[0]] < u[w[1]]).filter_map(middle).collect();
    let [own, fixed] = [rises, crossings(u)].map(|at| at.windows(2).map(|w| w[1] - w[0]).collect::<Vec<f64>>());
    // With fewer crossings, the fixed level misses cycles.
    let is_fixed = fixed.len() >= own.len() && uneven(&fixed) < uneven(&own);
    let lengths = if is_fixed { fixed } else { own };
    let median = median(&lengths)?;
    let even: Vec<f64> =
        lengths.iter().copied().filter(|length| (length / median - 1.0).abs() <= MAX_CYCLE_DEVIATION).collect();
    let is_steady = even.len() as f64 >= MIN_STEADY_CYCLE_SHARE * lengths.len() as f64;
    is_steady.then(|| 1.0 / (mean(&even) * ts))
}

/// Mean deviation from the median, relative to it; 0 for no lengths.
fn uneven(lengths: &[f64]) -> f64 {
    let Some(median) = median(lengths) else { return 0.0 };
    mean(&lengths.iter().map(|length| (length / median - 1.0).abs()).collect::<Vec<_>>())
}

fn median(lengths: &[f64]) -> Option<f64> {
    (!lengths.is_empty()).then(|| quantile(lengths.to_vec(), 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{Chirp, Multisine, Prbs, RisingSine, Sine};
    use piezoid_testing::{assert_close, noise};

    const TS: f64 = 2e-4;

    /// A triangle from 0 to 100 V whose amplitude falls to a fifth.
    fn decaying(hz: f64) -> Vec<f64> {
        let wave = |t: f64| {
            let (cycle, phase) = ((t * hz).floor(), (t * hz).fract());
            (1.0 - 0.1 * cycle) * 100.0 * (1.0 - (2.0 * phase - 1.0).abs())
        };
        (0..(8.0 / hz / TS) as usize).map(|t| wave(t as f64 * TS)).collect()
    }

    #[test]
    fn the_rate_is_that_of_the_cycles_also_if_the_amplitude_decays_or_rises() {
        let sine = Sine { amplitude: 3.0, frequency: 7.3, offset: 40.0 }.samples(TS, 8000).unwrap();
        let noisy: Vec<f64> = sine.iter().zip(noise(1, 8000)).map(|(u, e)| u + 0.01 * e).collect();
        let rising = RisingSine { amplitude: 3.0, frequency: 7.3, ..RisingSine::default() };
        let rising = rising.samples(TS, 8000).unwrap();
        for (u, hz, accuracy) in [
            (sine, 7.3, 1e-5),
            (noisy, 7.3, 1e-3),
            (rising, 7.3, 1e-3),
            (decaying(4.0), 4.0, 1e-4),
            (decaying(2.0), 2.0, 1e-4),
        ] {
            assert_close(&[cycle_rate(&u, TS).unwrap()], &[hz], accuracy, 0.0);
        }
    }

    #[test]
    fn an_input_without_steady_cycles_has_no_rate() {
        // Levels without order, each held for 125 samples.
        let steps: Vec<f64> = noise(8, 80).iter().flat_map(|level| [50.0 * level; 125]).collect();
        let sweep = Chirp { frequency_start: 1.0, frequency_end: 50.0, ..Chirp::default() }.samples(TS, 8000).unwrap();
        let wide = Multisine { frequency_high: 300.0, seed: 3, ..Multisine::default() }.samples(TS, 8000).unwrap();
        let prbs = Prbs::default().samples(TS, 2047).unwrap();
        let step: Vec<f64> = (0..900).map(|t| if t < 100 { 0.0 } else { 80.0 }).collect();
        for (name, u) in [("steps", steps), ("sweep", sweep), ("multisine", wide), ("prbs", prbs), ("step", step)] {
            assert_eq!(cycle_rate(&u, TS), None, "{name}");
        }
        assert_eq!((cycle_rate(&[2.0; 50], TS), cycle_rate(&[1.0], TS)), (None, None));
    }
}
