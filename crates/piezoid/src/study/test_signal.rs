//! Table 1 over what the paper leaves open of its test signal: the form, and the number of steps a period.
//!
//! The models are those of the study; only the signal they are tested on changes. Of all signals the nearest to Table 1 is
//! the one whose worst of four relative deviations is least.

use super::bench::Bench;
use super::{DURATION, Frequency, METHODS, PRINTED_MSE, SETTLING, TS, Way};
use crate::error::Error;
use crate::excitation::{Staircase, SteppedSine};
use crate::progress::{Progress, Stage};
use crate::system::System;
use crate::validation::Metrics;
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// A form of the step-wise test signal: a row of [`FORMS`].
#[derive(Debug)]
pub struct Form {
    /// As the list of excitations has it.
    pub name: &'static str,
    /// Samples [V] by amplitude [V], frequency [Hz], steps or levels, and number.
    drive: fn(f64, f64, u32, usize) -> Result<Vec<f64>, Error>,
}

/// Steps of equal length, and steps of equal height.
pub static FORMS: &[Form] = &[
    Form {
        name: "stepped-sine",
        drive: |amplitude, frequency, steps, n| SteppedSine { amplitude, frequency, steps, offset: 0.0 }.samples(TS, n),
    },
    Form {
        name: "staircase",
        drive: |amplitude, frequency, levels, n| Staircase { amplitude, frequency, levels, offset: 0.0 }.samples(TS, n),
    },
];

/// Steps a period, or levels, that are tried.
pub const STEPS: RangeInclusive<u32> = 4..=40;

/// Table 1 by one test signal.
#[derive(Debug, Clone, PartialEq)]
pub struct TestSignal {
    /// Name of its form.
    pub form: &'static str,
    /// Steps a period of a stepped sine, levels of a staircase.
    pub steps: u32,
    /// By method that has branches: its name, and its mean squared errors [mm^2] at the frequencies of Table 1.
    pub mse: Vec<(&'static str, [f64; 4])>,
}

impl TestSignal {
    /// Mean squared errors [mm^2] by a method at the frequencies of Table 1.
    pub fn of(&self, method: &str) -> [f64; 4] {
        self.mse.iter().find(|(name, _)| *name == method).map_or([f64::NAN; 4], |(_, mse)| *mse)
    }

    /// The largest of the four deviations from Table 1, as a share of the paper's value.
    pub fn deviation(&self, method: &str) -> f64 {
        let each = self.of(method).into_iter().zip(PRINTED_MSE);
        each.map(|(mse, (_, printed))| (mse / printed - 1.0).abs()).fold(0.0, f64::max)
    }

    /// "stepped sine of 7 steps", "staircase of 5 levels".
    pub fn words(&self) -> String {
        let each = if self.form == "staircase" { "levels" } else { "steps" };
        format!("{} of {} {each}", self.form.replace('-', " "), self.steps)
    }
}

/// The test signal by which `method` comes nearest to Table 1; none where there are no signals.
pub fn nearest<'s>(signals: &'s [TestSignal], method: &str) -> Option<&'s TestSignal> {
    signals.iter().min_by(|p, q| p.deviation(method).total_cmp(&q.deviation(method)))
}

/// Every form with every number of steps.
pub(super) fn all(bench: &Bench, found: &[Frequency], progress: &mut Progress) -> Result<Vec<TestSignal>, Error> {
    let total = FORMS.len();
    let mut signals = Vec::new();
    for (done, form) in FORMS.iter().enumerate() {
        let what = "Table 1 over the test signal";
        if progress(Stage { what, done, total }).is_break() {
            return Err(Error::Cancelled { what: what.into(), done, total });
        }
        let some = STEPS.into_par_iter().map(|steps| one(bench, found, form, steps));
        signals.extend(some.collect::<Result<Vec<_>, _>>()?);
    }
    Ok(signals)
}

fn one(bench: &Bench, found: &[Frequency], form: &Form, steps: u32) -> Result<TestSignal, Error> {
    let (n, settled) = ((DURATION / TS) as usize, (SETTLING / TS) as usize);
    let branched = METHODS.iter().filter(|method| matches!(method.way, Way::Branches(..)));
    let mut mse: Vec<(&str, [f64; 4])> = branched.map(|method| (method.name, [f64::NAN; 4])).collect();
    for (k, (hz, _)) in PRINTED_MSE.iter().enumerate() {
        let Some(f) = found.iter().find(|f| f.hz == *hz) else { continue };
        let u = (form.drive)(f.amplitude, *hz, steps, n)?;
        let (y, _) = bench.answer(&u);
        for (method, mse) in &mut mse {
            let simulated = f.row(method).map(|row| row.model.simulate(&u));
            mse[k] = simulated.map_or(f64::NAN, |simulated| Metrics::of(&y[settled..], &simulated[settled..]).mse);
        }
    }
    Ok(TestSignal { form: form.name, steps, mse })
}
