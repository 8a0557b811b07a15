//! Low-pass filter and interpolation in one: a sinc with a Kaiser window, centred on any point between samples.
//!
//! ```text
//! x(t) = sum over k of h((k - t) / r) x_k / sum over k of h((k - t) / r)
//! h(s) = c sinc(c s) I0(b sqrt(1 - (s / S)^2)) / I0(b),   |s| <= S
//! ```
//! t is in samples, and r is the new sampling period over the old one, at least 1. h is even: the filter has no phase.
//! The division keeps constants exactly. b and S follow from the attenuation and the width of the transition band:
//! b = 0.1102 (A - 8.7), 2 S = (A - 7.95) / (2.285 pi width).
//!
//! Before the first sample and after the last one, a record is continued by turning it about this sample by 180
//! degrees, which keeps its value and slope; a record of one period is continued periodically. Within S of an end of a
//! record that is not periodic, the result depends on the continuation.
//!
//! Reference: Kaiser 1974, Nonrecursive digital filter design using the I0-sinh window function, Proc. IEEE Int. Symp.
//! Circuits & Systems; Oppenheim & Schafer 2010, Discrete-Time Signal Processing, section 7.5.

use libm::sin;
use std::f64::consts::PI;

/// Attenuation of the stop band [dB]; the pass band is as exact, 3e-5.
const ATTENUATION: f64 = 90.0;

/// Share of the Nyquist frequency up to which a signal is kept.
pub(super) const KEPT: f64 = 0.8;

/// Points of the table from one sample to the next. The cubic between them is exact to 1e-9.
const GRID: usize = 256;

/// What stands before the first and after the last sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Ends {
    /// The record, turned about its first or last sample.
    Turned,
    /// The record itself: it is one period.
    Periodic,
}

/// The kernel h.
#[derive(Debug)]
pub(super) struct Kernel {
    /// h at -1, 0, 1, 2, ... / GRID.
    table: Vec<f64>,
    /// S.
    reach: usize,
}

impl Kernel {
    /// For a longer sampling period: nothing above the new Nyquist frequency remains.
    pub(super) fn anti_alias() -> Self {
        Kernel::new(0.5 * (1.0 + KEPT), 1.0 - KEPT)
    }

    /// For points between the samples: the images of what is kept are above 2 - 0.8 Nyquist frequencies. At a sample
    /// the kernel gives exactly this sample.
    pub(super) fn between() -> Self {
        Kernel::new(1.0, 2.0 * (1.0 - KEPT))
    }

    /// The kernel with this cut-off frequency and width of the transition band, relative to the Nyquist frequency.
    fn new(cutoff: f64, width: f64) -> Self {
        let reach = (0.5 * (ATTENUATION - 7.95) / (2.285 * PI * width)).ceil();
        let shape = 0.1102 * (ATTENUATION - 8.7);
        let at = |s: f64| {
            // Behind the end the window is constant, for the cubic up to it.
            let inside = (1.0 - (s / reach).powi(2)).max(0.0);
            cutoff * sinc(cutoff * s) * bessel(shape * inside.sqrt()) / bessel(shape)
        };
        let table = (0..reach as usize * GRID + 4).map(|k| at((k as f64 - 1.0) / GRID as f64)).collect();
        Kernel { table, reach: reach as usize }
    }

    /// h(s); 0 beyond S.
    fn value(&self, s: f64) -> f64 {
        let place = s.abs() * GRID as f64;
        let (k, f) = (place.floor(), place.fract());
        if place > (self.reach * GRID) as f64 {
            return 0.0;
        }
        let k = k as usize;
        // The cubic through four points.
        let [a, b, c, d] = [self.table[k], self.table[k + 1], self.table[k + 2], self.table[k + 3]];
        let (before, after, last) = (f + 1.0, f - 1.0, f - 2.0);
        -a * f * after * last / 6.0 + b * before * after * last / 2.0 - c * before * f * last / 2.0
            + d * before * f * after / 6.0
    }

    /// The signal at `t` [samples], filtered for a sampling period `ratio` times as long; `ratio` is at least 1.
    pub(super) fn at(&self, x: &[f64], t: f64, ratio: f64, ends: Ends) -> f64 {
        let reach = self.reach as f64 * ratio;
        let (mut sum, mut weights) = (0.0, 0.0);
        // One more on both sides, because the limits are rounded; their weights are 0.
        for k in (t - reach).floor() as isize..=(t + reach).ceil() as isize {
            let weight = self.value((k as f64 - t) / ratio);
            sum += weight * sample(x, k, ends);
            weights += weight;
        }
        sum / weights
    }

    /// The weights at a sample, for a sampling period `ratio` times as long.
    #[cfg(test)]
    pub(super) fn taps(&self, ratio: usize) -> Vec<f64> {
        let reach = (self.reach * ratio) as isize;
        let taps: Vec<f64> = (-reach..=reach).map(|k| self.value(k as f64 / ratio as f64)).collect();
        let sum: f64 = taps.iter().sum();
        taps.iter().map(|tap| tap / sum).collect()
    }
}

/// Sample `k` of a signal that is continued at its ends.
fn sample(x: &[f64], k: isize, ends: Ends) -> f64 {
    let n = x.len() as isize;
    let last = n - 1;
    match ends {
        Ends::Periodic => x[k.rem_euclid(n) as usize],
        _ if (0..n).contains(&k) => x[k as usize],
        // Turned twice, a short record would leave its range more and more: it is held.
        Ends::Turned if k < 0 => 2.0 * x[0] - x[(-k).min(last) as usize],
        Ends::Turned => 2.0 * x[last as usize] - x[(2 * last - k).max(0) as usize],
    }
}

/// sin(pi v) / (pi v), exactly 0 at integers.
fn sinc(v: f64) -> f64 {
    match v {
        0.0 => 1.0,
        _ if v.fract() == 0.0 => 0.0,
        _ => sin(PI * v) / (PI * v),
    }
}

/// The modified Bessel function I0, by its series.
fn bessel(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 0.0);
    while term > 1e-18 * sum {
        k += 1.0;
        term *= (0.5 * x / k).powi(2);
        sum += term;
    }
    sum
}
