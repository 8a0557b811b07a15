//! All parts together: Gauss-Newton on the free-run error, damped where a step would not lower it (Levenberg and Marquardt).
//!
//! First the weights alone, then with the gains of creep, then everything.

use super::dynamics::{creep_pole, slowest_observable};
use super::equations::{RecordEquations, ReducedEquations, equations};
use super::estimate::Estimate;
use super::held_out::{HeldOut, cross_validate};
use super::products::{Segment, products};
use super::runs::TrainingRecord;
use super::solve::{FreeParameters, Prior};
use crate::error::Error;
use crate::series::mean;
use nalgebra::DVector;

/// How short steps are held at first.
const DAMPING: f64 = 1e-6;

/// Steps at most, and tries to find one that lowers the cost.
const STEPS: usize = 14;
const TRIES: usize = 8;

/// The step from which smoothness and the weights of the two kinds of records stand.
const SETTLED: usize = 3;

/// Fall of the cost, relative, below which no further step is made.
const ENOUGH: f64 = 1e-3;

/// How much heavier small-signal samples may become than rich ones.
const HEAVIEST: f64 = 30.0;

/// Told each step; an error ends the work.
pub(super) type StepCallback<'a> = &'a mut dyn FnMut(usize) -> Result<(), Error>;

/// A fitted estimate.
#[derive(Debug)]
pub(super) struct Fitted {
    pub(super) estimate: Estimate,
    /// State of creep, state of G and constant of each run.
    pub(super) own: Vec<Vec<f64>>,
    pub(super) held_out: HeldOut,
    /// Of each run, the mean squared error over the squared peak-to-peak.
    pub(super) left: Vec<f64>,
}

/// An estimate and the equations there.
struct Iterate {
    estimate: Estimate,
    prior: Prior,
    segments: Vec<Segment>,
    normal: ReducedEquations,
    each: Vec<RecordEquations>,
}

impl Iterate {
    fn at(estimate: Estimate, runs: &[TrainingRecord], own: &[Vec<f64>]) -> Self {
        let segments = products(&estimate, runs, own);
        let (normal, each) = equations(&estimate, &segments, |_| true);
        Iterate { prior: Prior::of(&estimate), estimate, segments, normal, each }
    }

    /// Where all parameters stand, as the equations take them.
    fn here(&self) -> DVector<f64> {
        self.prior.steps(self.prior.now())
    }

    fn cost(&self, lambda: f64) -> f64 {
        self.normal.left(&self.here()) + self.prior.penalty(&self.normal, lambda, self.prior.now())
    }

    /// What the equations foretell of what is held out in turn.
    fn held_out(&self, free: FreeParameters, lambda: Option<f64>) -> HeldOut {
        cross_validate(&self.estimate, &self.prior, &self.segments, DAMPING, free, lambda)
    }

    /// The runs' own coefficients at `x`.
    fn own(&self, x: &DVector<f64>) -> Vec<Vec<f64>> {
        let steps = self.prior.steps(x);
        self.each.iter().map(|run| run.own(&steps)).collect()
    }

    /// Of each run, the mean squared error over the squared peak-to-peak.
    fn left(&self, runs: &[TrainingRecord]) -> Vec<f64> {
        let here = self.here();
        let of = |run: &RecordEquations| run.normal.left(&here) / run.normal.samples / runs[run.run].heavier.powi(2);
        self.each.iter().map(of).collect()
    }
}

/// Fits the parameters that are `free` from `start` on, whose weights need not be known.
///
/// # Errors
/// What `watch`, which is told each step, returns.
pub(super) fn refine(
    start: Estimate,
    runs: &mut [TrainingRecord],
    free: FreeParameters,
    watch: StepCallback,
) -> Result<Fitted, Error> {
    runs.iter_mut().for_each(|run| run.heavier = 1.0);
    let mut point = Iterate::at(start, runs, &[]);
    let (mut damping, mut lambda) = (DAMPING, 0.0);
    for step in 0..STEPS {
        watch(step)?;
        let now = match (step, free) {
            (0, _) => FreeParameters::Weights,
            (1, FreeParameters::All) => FreeParameters::Creep,
            (_, free) => free,
        };
        if step <= SETTLED {
            lambda = point.held_out(now, None).lambda;
        }
        let cost = if step == 0 { f64::INFINITY } else { point.cost(lambda) };
        let Some(next) = lower(&point, runs, cost, lambda, &mut damping, now) else {
            if now == free {
                break;
            }
            // Nothing to gain yet; more is freed next.
            damping = DAMPING;
            continue;
        };
        let fall = 1.0 - next.cost(lambda) / cost;
        point = next;
        if step + 1 < SETTLED && weigh(runs, &point.left(runs)) {
            let own = point.own(point.prior.now());
            point = Iterate::at(point.estimate, runs, &own);
        }
        if step > SETTLED && fall < ENOUGH {
            break;
        }
    }
    let (own, held_out) = (point.own(point.prior.now()), point.held_out(free, Some(lambda)));
    let left = point.left(runs);
    Ok(Fitted { estimate: point.estimate, own, held_out, left })
}

/// The next point, of lower cost; none where none is found.
fn lower(
    point: &Iterate,
    runs: &[TrainingRecord],
    cost: f64,
    lambda: f64,
    damping: &mut f64,
    free: FreeParameters,
) -> Option<Iterate> {
    let slowest = slowest_observable(runs.iter().map(|run| run.record));
    let (mut positive, mut harder) = (vec![true; point.prior.now().len()], 2.0);
    for _ in 0..TRIES {
        let x = point.prior.solve(&point.normal, lambda, *damping, free, &mut positive)?;
        let moved = point.estimate.moved(x.as_slice());
        if let Some(estimate) = moved.filter(|estimate| creep_pole(&estimate.linear, slowest).is_none()) {
            let next = Iterate::at(estimate, runs, &point.own(&x));
            if next.cost(lambda) < cost {
                *damping = (*damping * 0.1).max(1e-9);
                return Some(next);
            }
        }
        // Nielsen's rule: each failure makes the next step shorter than the last one did.
        *damping *= harder;
        harder *= 2.0;
    }
    None
}

/// Gives both kinds of records the weight that what they leave asks for; whether that changed anything.
fn weigh(runs: &mut [TrainingRecord], left: &[f64]) -> bool {
    let of = |large_signal: bool| {
        mean(
            &runs.iter().zip(left).filter(|(r, _)| r.large_signal == large_signal).map(|(_, l)| *l).collect::<Vec<_>>(),
        )
    };
    let heavier = (of(true) / of(false)).sqrt().clamp(1.0, HEAVIEST);
    if !heavier.is_finite() {
        return false;
    }
    for run in runs.iter_mut().filter(|run| !run.large_signal) {
        run.heavier = heavier;
    }
    true
}
