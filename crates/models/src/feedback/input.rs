//! The input between samples.

use libm::{cosh, sin, sqrt};
use std::f64::consts::PI;

/// How the input moves between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Intersample {
    /// It is held by a converter from its sample on; y is read at the end of this sample.
    Held,
    /// It is band-limited, as behind an anti-alias filter, and read at the same instant as y.
    BandLimited,
}

/// Shape of the window of the interpolation: an error of 1e-8 up to 0.4 times the sampling rate (J. F. Kaiser, R. W.
/// Schafer 1980, DOI 10.1109/TASSP.1980.1163349).
const KAISER: f64 = 18.0;

impl Intersample {
    /// Samples to either side from which the input is interpolated.
    pub const REACH: usize = 32;

    /// The input at start and end of each of the steps that lead to each sample. Before its first and after its last
    /// sample the input is held.
    pub(super) fn path(self, u: &[f64], substeps: usize) -> Vec<[f64; 2]> {
        match self {
            Intersample::Held => u.iter().flat_map(|&u| std::iter::repeat_n([u; 2], substeps)).collect(),
            Intersample::BandLimited => {
                let tables: Vec<Vec<f64>> = (0..substeps).map(|j| weights((j + 1) as f64 / substeps as f64)).collect();
                let last = u.len().saturating_sub(1);
                let at = |k: isize| u[k.clamp(0, last as isize) as usize];
                let mut before = u.first().copied().unwrap_or_default();
                let mut path = Vec::with_capacity(u.len() * substeps);
                for k in 0..u.len() as isize {
                    for table in &tables {
                        let first = k - Intersample::REACH as isize;
                        let end = table.iter().zip(first..).map(|(weight, k)| weight * at(k)).sum();
                        path.push([before, end]);
                        before = end;
                    }
                }
                path
            }
        }
    }
}

/// The weights of 2 REACH samples for the value at a share of the way from the last but REACH + 1 to the next one.
fn weights(share: f64) -> Vec<f64> {
    const REACH: usize = Intersample::REACH;
    let weight = |k: usize| {
        let x = k as f64 - (REACH - 1) as f64 - share;
        let sinc = if x == 0.0 { 1.0 } else { sin(PI * x) / (PI * x) };
        let r = x / REACH as f64;
        sinc * bessel(KAISER * sqrt((1.0 - r * r).max(0.0))) / bessel(KAISER)
    };
    (0..2 * REACH).map(weight).collect()
}

/// The modified Bessel function I_0, as the mean of cosh (x cos t) over half a turn: exact to rounding for x < 30.
fn bessel(x: f64) -> f64 {
    const POINTS: usize = 64;
    (0..POINTS).map(|k| cosh(x * libm::cos(PI * (k as f64 + 0.5) / POINTS as f64))).sum::<f64>() / POINTS as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn a_band_limited_input_is_interpolated_to_1e_8() {
        let at = |t: f64| (2.2 * t).sin() + (0.3 * t).cos();
        let u: Vec<f64> = (0..300).map(|k| at(f64::from(k))).collect();
        let path = Intersample::BandLimited.path(&u, 4);
        let inside = 100 * 4..200 * 4;
        let found: Vec<f64> = path[inside.clone()].iter().map(|step| step[1]).collect();
        let known: Vec<f64> = inside.map(|k| at((k + 1) as f64 / 4.0 - 1.0)).collect();
        assert_close(&found, &known, 0.0, 3e-8);
        // At its samples it is exact.
        let samples: Vec<f64> = path.iter().skip(3).step_by(4).map(|step| step[1]).collect();
        assert_close(&samples, &u, 1e-14, 1e-14);
    }
}
