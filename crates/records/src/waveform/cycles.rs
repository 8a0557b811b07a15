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

/// The complete cycles of `u`, with sampling period `ts` [s]; empty if `u` is not regular.
pub fn cycles(u: &[f64], ts: f64) -> Vec<Cycle> {
    let reversals = reversals(u, MIN_REVERSAL_SHARE);
    // The first reversal is skipped if it is a maximum.
    let first = usize::from(reversals.len() > 1 && u[reversals[0]] > u[reversals[1]]);
    let found: Vec<Cycle> = reversals[first.min(reversals.len())..]
        .windows(3)
        .step_by(2)
        .map(|w| {
            let hz = 1.0 / ((w[2] - w[0]) as f64 * ts);
            Cycle { samples: w[0]..w[2] + 1, peak: w[1], amplitude: 0.5 * range(&u[w[0]..=w[2]]), hz }
        })
        .collect();
    let median = |of: fn(&Cycle) -> f64| {
        let bend = |w: &[Cycle]| log(of(&w[0]) * of(&w[2]) / of(&w[1]).powi(2)).abs();
        quantile(found.windows(3).map(bend).collect(), 0.5)
    };
    let regular = median(|c| c.hz) < REGULAR && median(|c| c.amplitude) < REGULAR;
    if regular { found } else { Vec::new() }
}

/// The reversals of `x`: the samples of its extremes between movements of more than a `share` of its range. For a held
/// extreme, its middle sample. The first and the last extreme of the record count if they are near a limit of the
/// range.
pub fn reversals(x: &[f64], share: f64) -> Vec<usize> {
    let (low, high) = ends(x.iter().copied());
    let guard = share * (high - low);
    let outermost = |x: f64| (x - low).min(high - x) < 0.5 * guard;
    let mut reversals = Vec::new();
    // The direction, and the first and the last sample of the present extreme.
    let (mut trend, mut first, mut last) = (0.0, 0, 0);
    for (t, &now) in x.iter().enumerate() {
        let beyond = (now - x[first]) * trend;
        if trend == 0.0 {
            // No movement yet.
            if (now - x[0]).abs() > guard {
                reversals.extend(outermost(x[0]).then_some(0));
                (trend, first, last) = ((now - x[0]).signum(), t, t);
            }
        } else if beyond > 0.0 {
            (first, last) = (t, t);
        } else if beyond == 0.0 {
            last = t;
        } else if -beyond > guard {
            reversals.push(first.midpoint(last));
            (trend, first, last) = (-trend, t, t);
        }
    }
    reversals.extend((trend != 0.0 && outermost(x[first])).then_some(first.midpoint(last)));
    reversals
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
