//! The input between samples.

use super::FeedbackModel;
use crate::driver::DriverModel;
use libm::{cosh, sin, sqrt};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// How the input moves between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Intersample {
    /// It is held by a converter from its sample on; y is read at the end of this sample.
    Held,
    /// It is held by a converter, and passes this driver, which is settled at the first sample; y is read at the end of
    /// this sample.
    Driven(DriverModel),
    /// It is band-limited, as behind an anti-alias filter, and read at the same instant as y.
    BandLimited,
}

/// Shape of the window of the interpolation: an error of 1e-8 up to 0.4 times the sampling rate (J. F. Kaiser, R. W.
/// Schafer 1980, DOI 10.1109/TASSP.1980.1163349).
const KAISER: f64 = 18.0;

impl Intersample {
    /// Samples to either side from which the input is interpolated.
    pub const REACH: usize = 32;
}

/// The input along the steps of a run, sample by sample. Of an input that is interpolated, the first and the last
/// sample are held before and after it.
pub(super) struct Path<'a> {
    u: &'a [f64],
    between: Intersample,
    /// For each step of a sample, the weights of the samples about it.
    tables: Vec<Vec<f64>>,
    /// True if the input stays until its first sample, and jumps there.
    jumps: bool,
    sample: usize,
    before: f64,
    /// Duration of a step [s].
    h: f64,
    /// The input at start and end of each step.
    steps: Vec<[f64; 2]>,
}

impl<'a> Path<'a> {
    /// The path along all samples of an input that was constant before.
    pub(super) fn of(model: &FeedbackModel, u: &'a [f64]) -> Self {
        Path::new(model, u, u.first().copied().unwrap_or_default(), true)
    }

    /// The path after the input `before` along all samples of an input, or, if it is not `whole`, sample by sample:
    /// then a band-limited input is on straight lines.
    pub(super) fn new(model: &FeedbackModel, u: &'a [f64], before: f64, whole: bool) -> Self {
        let (between, n) = (model.dynamics.intersample, model.dynamics.substeps);
        let tables = match between {
            Intersample::BandLimited if whole => (1..=n).map(|j| weights(j as f64 / n as f64)).collect(),
            _ => Vec::new(),
        };
        Path { jumps: false, u, between, tables, sample: 0, before, h: model.ts / n as f64, steps: vec![[0.0; 2]; n] }
    }

    /// The same path if nothing moves before the first sample: a band-limited input then jumps there.
    pub(super) fn at_rest(self) -> Self {
        Path { jumps: !self.tables.is_empty(), ..self }
    }

    /// The input before the first step.
    pub(super) fn start(&self) -> f64 {
        self.before
    }

    /// The steps that lead to the next sample.
    pub(super) fn next_sample(&mut self) -> Option<&[[f64; 2]]> {
        let u = *self.u.get(self.sample)?;
        let share = (u - self.before) / self.steps.len() as f64;
        for step in &mut self.steps {
            *step = match self.between {
                Intersample::Held => [u; 2],
                Intersample::Driven(driver) => [self.before, driver.advance(self.before, u, self.h)],
                Intersample::BandLimited if self.tables.is_empty() => [self.before, self.before + share],
                Intersample::BandLimited => break,
            };
            self.before = step[1];
        }
        if std::mem::take(&mut self.jumps) {
            self.steps.fill([self.before; 2]);
            (self.before, self.sample) = (u, self.sample + 1);
            return Some(&self.steps);
        }
        let last = self.u.len() - 1;
        for (step, table) in self.steps.iter_mut().zip(&self.tables) {
            let at = |k: usize| self.u[(self.sample + k).saturating_sub(Intersample::REACH).min(last)];
            let end = table.iter().enumerate().map(|(k, weight)| weight * at(k)).sum();
            *step = [self.before, end];
            self.before = end;
        }
        self.sample += 1;
        Some(&self.steps)
    }
}

/// The weights of 2 REACH samples for the value at a share of the way from sample REACH - 1 to sample REACH of them,
/// counted from 0.
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
        let tables = (1..=4).map(|j| weights(f64::from(j) / 4.0)).collect();
        let steps = vec![[0.0; 2]; 4];
        let mut path = Path {
            jumps: false,
            u: &u,
            between: Intersample::BandLimited,
            tables,
            sample: 0,
            before: u[0],
            h: 1.0,
            steps,
        };
        let (mut found, mut samples) = (Vec::new(), Vec::new());
        while let Some(steps) = path.next_sample() {
            found.extend(steps.iter().map(|step| step[1]));
            samples.push(steps[3][1]);
        }
        let inside = 100 * 4..200 * 4;
        let known: Vec<f64> = inside.clone().map(|k| at((k + 1) as f64 / 4.0 - 1.0)).collect();
        assert_close(&found[inside], &known, 0.0, 3e-8);
        // At its samples it is exact.
        assert_close(&samples, &u, 1e-14, 1e-14);
    }
}
