//! Table 1 over the unknown properties of the paper's test: the form of the signal, its number of steps per period, and
//! which branch is its "upper" one.
//!
//! The models are those of the study and one more ([`TestSignal::UPPER_RULE`]); only the test signal changes. The
//! signal closest to Table 1 has the smallest maximum of the four relative deviations.
//!
//! Why: docs/decisions/study-of-the-paper.md, "The study tests on a stepped sine of 7 steps".

use super::bench::Bench;
use super::{DURATION, Frequency, METHODS, MethodModel, SETTLING, Study, TS};
use piezoid::excitation::{Staircase, SteppedSine};
use piezoid::hysteresis::HeldInput;
use piezoid::progress::{Progress, Stage};
use piezoid::validation::Metrics;
use piezoid::{Error, Model, System};
use piezoid_models::hysteresis::TwoBranch;
use rayon::prelude::*;
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Table 1 for one test signal.
#[derive(Debug, Clone, PartialEq)]
pub struct TestSignal {
    /// Name of its form.
    pub form: &'static str,
    /// Steps per period of a stepped sine, levels of a staircase.
    pub steps: u32,
    /// Mean squared errors [mm^2] at the frequencies of Table 1, by method with branches, and for
    /// [`TestSignal::UPPER_RULE`].
    pub mse: Vec<(&'static str, [f64; 4])>,
}

impl TestSignal {
    /// Tested forms, by their names as excitations: steps of equal length, and steps of equal height.
    pub const FORMS: [&str; 2] = ["stepped-sine", "staircase"];

    /// Tested steps per period, or levels.
    pub const STEPS: RangeInclusive<u32> = 4..=40;

    /// The rule as printed, with the "upper" branch of its Fig. 2: while the input rises it reads the branch that lies
    /// above in the loop. The methods of the study take that to be the ascending branch, which lies below in a piezo
    /// loop.
    pub const UPPER_RULE: &str = "upper-rule";

    /// Mean squared errors [mm^2] of a method at the frequencies of Table 1.
    pub fn of(&self, method: &str) -> [f64; 4] {
        self.mse.iter().find(|(name, _)| *name == method).map_or([f64::NAN; 4], |(_, mse)| *mse)
    }

    /// The largest of the four deviations from Table 1, as a share of the paper's value.
    pub fn deviation(&self, method: &str) -> f64 {
        let each = self.of(method).into_iter().zip(Study::PRINTED_MSE);
        each.map(|(mse, (_, printed))| (mse / printed - 1.0).abs()).fold(0.0, f64::max)
    }

    /// "stepped sine of 7 steps", "staircase of 5 levels".
    pub fn words(&self) -> String {
        let each = if self.form == "staircase" { "levels" } else { "steps" };
        format!("{} of {} {each}", self.form.replace('-', " "), self.steps)
    }

    /// The test signal closest to Table 1 for `method`; `None` without signals.
    pub fn nearest<'s>(signals: impl IntoIterator<Item = &'s TestSignal>, method: &str) -> Option<&'s TestSignal> {
        signals.into_iter().min_by(|p, q| p.deviation(method).total_cmp(&q.deviation(method)))
    }
}

/// Every form with every number of steps.
pub(super) fn all(bench: &Bench, found: &[Frequency], progress: &mut Progress) -> Result<Vec<TestSignal>, Error> {
    let (models, total) = (models(found)?, TestSignal::FORMS.len());
    let mut signals = Vec::new();
    for (done, form) in TestSignal::FORMS.into_iter().enumerate() {
        let what = "Table 1 over the test signal";
        if progress(Stage::new(what, done, total)).is_break() {
            return Err(Error::Cancelled { what: what.into(), done, total });
        }
        let some = TestSignal::STEPS.into_par_iter().map(|steps| one(bench, &models, form, steps));
        signals.extend(some.collect::<Result<Vec<_>, _>>()?);
    }
    Ok(signals)
}

/// A frequency of Table 1 with the amplitude of the test there [V], and a model by method.
type Tested = (f64, f64, Vec<(&'static str, Model)>);

/// The models at each frequency of Table 1.
fn models(found: &[Frequency]) -> Result<Vec<Tested>, Error> {
    let branched = || METHODS.iter().filter(|method| matches!(method.way, MethodModel::Branches(..)));
    let at =
        |(hz, _): &(f64, f64)| {
            let f = found.iter().find(|f| f.hz == *hz)?;
            let own = branched().filter_map(|method| Some((method.name, f.row(method.name)?.model.clone())));
            Some(upper_rule(f).map(|upper| {
                (*hz, f.amplitude, own.chain(upper.map(|model| (TestSignal::UPPER_RULE, model))).collect())
            }))
        };
    Study::PRINTED_MSE.iter().filter_map(at).collect()
}

/// The model that reads the branch that lies above while the input rises, and the other one otherwise.
fn upper_rule(f: &Frequency) -> Result<Option<Model>, Error> {
    let (Some(row), found) = (f.row("printed-rule"), &f.own.found) else { return Ok(None) };
    let branches = if found.ascending_below { found.branches.exchanged() } else { found.branches.clone() };
    let block = TwoBranch::new(TS, branches, HeldInput::Printed)?;
    Model::new(Arc::new(block), row.model.linear().clone(), row.model.offset()).map(Some)
}

fn one(bench: &Bench, tested: &[Tested], form: &'static str, steps: u32) -> Result<TestSignal, Error> {
    let (n, settled) = ((DURATION / TS) as usize, (SETTLING / TS) as usize);
    let names = tested.first().map(|(_, _, models)| models.iter().map(|(name, _)| *name));
    let mut mse: Vec<(&str, [f64; 4])> = names.into_iter().flatten().map(|name| (name, [f64::NAN; 4])).collect();
    for (k, (hz, amplitude, models)) in tested.iter().enumerate() {
        let u = drive(form, *amplitude, *hz, steps, n)?;
        let (y, _) = bench.answer(&u);
        for ((_, model), (_, mse)) in models.iter().zip(&mut mse) {
            mse[k] = Metrics::of(&y[settled..], &model.simulate(&u)[settled..]).mse;
        }
    }
    Ok(TestSignal { form, steps, mse })
}

/// Samples of a form [V], every [`TS`].
fn drive(form: &str, amplitude: f64, frequency: f64, steps: u32, n: usize) -> Result<Vec<f64>, Error> {
    match form {
        "staircase" => Staircase { amplitude, frequency, levels: steps, offset: 0.0 }.samples(TS, n),
        _ => SteppedSine { amplitude, frequency, steps, offset: 0.0 }.samples(TS, n),
    }
}
