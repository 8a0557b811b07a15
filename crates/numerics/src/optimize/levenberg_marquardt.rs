//! Levenberg-Marquardt: minimises a sum of squares e'e from its normal equations.
//!
//! ```text
//! (J'J + mu D) h = -J'e,   D = diag(J'J)                             the step
//! rho = (f(x) - f(x + h)) / (h' (mu D h - J'e)),   f = e'e           actual over predicted decrease
//! rho > 0:  x <- x + h,  mu <- mu max(1/3, 1 - (2 rho - 1)^3)        step accepted
//! else:     mu <- nu mu,  nu <- 2 nu                                 step rejected
//! ```
//!
//! Scaling by D: Marquardt 1963 (doi:10.1137/0111030); it makes the path independent of the units of x. Damping:
//! Nielsen 1999 (IMM-REP-1999-05, Technical University of Denmark). J'J and J'e are sums over samples, so a problem of
//! any length can be accumulated in parts. The price: condition numbers of J above 1e8 are lost to rounding. mu has a
//! lower limit, so that directions of constant cost do not move. It finds a local minimum. A step is bounded by lower
//! limits of the unknowns, within which it minimises its own model of the cost (a quadratic programme), and by a cost
//! that is not finite.

use super::{Minimum, Reason, non_negative};
use crate::error::{Error, positive};
use crate::progress::{Progress, Stage};
use nalgebra::{Cholesky, DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// A sum of squares f(x) = e(x)'e(x).
pub trait SumOfSquares {
    /// Number of unknowns.
    fn dimension(&self) -> usize;

    /// e'e at `x`. An infinite or NaN cost rejects the step to `x`.
    fn cost(&self, x: &[f64]) -> f64;

    /// The normal equations at `x`. The cost there is finite.
    fn normal(&self, x: &[f64]) -> NormalEquations;

    /// The lower limit of each unknown; minus infinity if it has none.
    fn lowest(&self) -> Vec<f64> {
        vec![f64::NEG_INFINITY; self.dimension()]
    }
}

/// The normal equations at one point. J has the derivatives of e, one column per unknown.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalEquations {
    /// e'e.
    pub cost: f64,
    /// J'e, half the gradient.
    pub gradient: Vec<f64>,
    /// J'J, row by row.
    pub hessian: Vec<f64>,
}

/// Options of the search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SearchSettings {
    /// Maximum number of steps, including rejected ones.
    pub iterations: usize,
    /// Converged when the predicted relative decrease of the cost is smaller than this.
    pub tolerance: f64,
    /// Initial mu: small for a start close to the minimum, large otherwise.
    pub damping: f64,
}

impl Default for SearchSettings {
    fn default() -> Self {
        SearchSettings { iterations: 100, tolerance: 1e-12, damping: 1e-3 }
    }
}

/// The smallest mu. With a smaller one, rounding errors in J'J move x in directions of constant cost.
const LEAST_DAMPING: f64 = 1e-13;

/// The largest mu. With a larger one, steps are smaller than rounding errors.
const MOST_DAMPING: f64 = 1e20;

/// Searches from `start`. If cancelled, returns the best point so far. Returns an error if the start has a wrong length
/// or a cost that is not finite, if there are no iterations, or if the damping or the tolerance is not positive.
pub fn minimise(
    problem: &impl SumOfSquares,
    start: &[f64],
    settings: &SearchSettings,
    progress: &mut Progress,
) -> Result<Minimum, Error> {
    check(problem, start, settings)?;
    let lowest = problem.lowest();
    let mut x = start.to_vec();
    let mut normal = problem.normal(&x);
    if !normal.cost.is_finite() {
        return Err(Error::parameter("start", format!("{} numbers", start.len()), "must have a finite cost"));
    }
    let (mut mu, mut nu) = (settings.damping, 2.0);
    let (mut history, mut courses) = (vec![normal.cost], vec![x.clone()]);
    let reason = loop {
        let done = history.len() - 1;
        if done >= settings.iterations {
            break Reason::Iterations;
        }
        let figures = &[("cost", history[done])];
        let stage = Stage { figures, ..Stage::new("Levenberg-Marquardt", done, settings.iterations) };
        if progress(stage).is_break() {
            break Reason::Cancelled;
        }
        let mut gain = -1.0;
        // As far as each unknown may fall.
        let room: Vec<f64> = x.iter().zip(&lowest).map(|(x, low)| low - x).collect();
        if let Some((h, predicted)) = step(&normal, mu, &room) {
            // With a large mu the predicted decrease is small even far from the minimum.
            if mu < 1.0 && predicted <= settings.tolerance * normal.cost {
                break Reason::Converged;
            }
            // By rounding, x + (low - x) can be below the limit.
            let trial: Vec<f64> = x.iter().zip(&h).zip(&lowest).map(|((x, h), low)| (x + h).max(*low)).collect();
            let cost = problem.cost(&trial);
            if cost < normal.cost {
                gain = (normal.cost - cost) / predicted;
                x = trial;
                normal = problem.normal(&x);
            }
        }
        if gain > 0.0 {
            mu = (mu * f64::max(1.0 / 3.0, 1.0 - (2.0 * gain - 1.0).powi(3))).max(LEAST_DAMPING);
            nu = 2.0;
        } else {
            mu *= nu;
            nu *= 2.0;
        }
        history.push(normal.cost);
        courses.push(x.clone());
        if mu > MOST_DAMPING {
            break Reason::Stall;
        }
    };
    Ok(Minimum { x, cost: normal.cost, history, courses, reason })
}

fn check(problem: &impl SumOfSquares, start: &[f64], settings: &SearchSettings) -> Result<(), Error> {
    if start.len() != problem.dimension() {
        let (left, right) = ("the start".into(), "the vector of unknowns".into());
        return Err(Error::Lengths { left, left_len: start.len(), right, right_len: problem.dimension() });
    }
    positive("damping", settings.damping, "J'J's diagonal")?;
    positive("tolerance", settings.tolerance, "the cost")?;
    if settings.iterations == 0 {
        return Err(Error::parameter("iterations", 0, "must be at least 1"));
    }
    Ok(())
}

/// The damped step, of which no element is below `room`, and the predicted decrease of e'e; `None` if the factorisation
/// fails.
fn step(normal: &NormalEquations, mu: f64, room: &[f64]) -> Option<(Vec<f64>, f64)> {
    let d = normal.gradient.len();
    // Lengths of the columns of J; 1 for a column of zeros, whose unknown then does not move.
    let length = |i: usize| normal.hessian[i * d + i].sqrt();
    let size: Vec<f64> = (0..d).map(|i| if length(i) > 0.0 { length(i) } else { 1.0 }).collect();
    let scaled =
        DMatrix::from_fn(d, d, |i, j| normal.hessian[i * d + j] / (size[i] * size[j]) + if i == j { mu } else { 0.0 });
    let downhill = DVector::from_fn(d, |i, _| -normal.gradient[i] / size[i]);
    let is_limited: Vec<bool> = room.iter().map(|room| room.is_finite()).collect();
    let (h, predicted) = if is_limited.contains(&true) {
        // What is above the limit is the unknown: it must not be negative.
        let limit = DVector::from_fn(d, |i, _| if is_limited[i] { room[i] * size[i] } else { 0.0 });
        let mut is_above: Vec<bool> = room.iter().map(|room| *room < 0.0).collect();
        let above = non_negative(&scaled, &(&downhill - &scaled * &limit), &is_limited, &mut is_above)?;
        let h = above + limit;
        let predicted = 2.0 * h.dot(&downhill) - h.dot(&(&scaled * &h)) + mu * h.norm_squared();
        (h, predicted)
    } else {
        let h = Cholesky::new(scaled)?.solve(&downhill);
        let predicted = h.dot(&(&h * mu + downhill));
        (h, predicted)
    };
    let h: Vec<f64> = h.iter().zip(&size).zip(room).map(|((h, size), room)| (h / size).max(*room)).collect();
    h.iter().all(|h| h.is_finite()).then_some((h, predicted))
}

impl NormalEquations {
    /// Zero sums for `dimension` unknowns.
    pub fn empty(dimension: usize) -> Self {
        NormalEquations { cost: 0.0, gradient: vec![0.0; dimension], hessian: vec![0.0; dimension * dimension] }
    }

    /// Adds `weight` times the sums of `other`, which has the same unknowns.
    pub fn add(&mut self, weight: f64, other: &NormalEquations) {
        let sums = std::iter::once(&mut self.cost).chain(&mut self.gradient).chain(&mut self.hessian);
        let terms = std::iter::once(&other.cost).chain(&other.gradient).chain(&other.hessian);
        sums.zip(terms).for_each(|(sum, term)| *sum += weight * term);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Stage;
    use piezoid_testing::assert_close;
    use std::ops::ControlFlow;

    /// Errors and their derivatives as functions of x: e_i, then row i of J.
    struct Rows<F: Fn(&[f64]) -> Vec<Vec<f64>>>(usize, F);

    impl<F: Fn(&[f64]) -> Vec<Vec<f64>>> SumOfSquares for Rows<F> {
        fn dimension(&self) -> usize {
            self.0
        }
        fn cost(&self, x: &[f64]) -> f64 {
            self.normal(x).cost
        }
        fn normal(&self, x: &[f64]) -> NormalEquations {
            let mut sums = NormalEquations::empty(self.0);
            for row in (self.1)(x) {
                let (e, slopes) = (row[0], &row[1..]);
                let hessian = slopes.iter().flat_map(|a| slopes.iter().map(move |b| a * b)).collect();
                let gradient = slopes.iter().map(|a| a * e).collect();
                sums.add(1.0, &NormalEquations { cost: e * e, gradient, hessian });
            }
            sums
        }
    }

    fn rosenbrock(x: &[f64]) -> Vec<Vec<f64>> {
        vec![vec![10.0 * (x[1] - x[0] * x[0]), -20.0 * x[0], 10.0], vec![1.0 - x[0], -1.0, 0.0]]
    }

    fn search(problem: &impl SumOfSquares, start: &[f64]) -> Minimum {
        minimise(problem, start, &SearchSettings::default(), &mut Stage::ignore).unwrap()
    }

    #[test]
    fn it_finds_the_minimum_of_rosenbrocks_function() {
        let found = search(&Rows(2, rosenbrock), &[-1.2, 1.0]);
        assert_close(&found.x, &[1.0, 1.0], 1e-9, 0.0);
        assert!(found.history.len() < 40 && found.history.windows(2).all(|w| w[1] <= w[0]));
    }

    #[test]
    fn a_lower_limit_is_kept_and_the_others_end_at_the_minimum_on_it() {
        struct Limited;
        impl SumOfSquares for Limited {
            fn dimension(&self) -> usize {
                2
            }
            fn cost(&self, x: &[f64]) -> f64 {
                if x[0] < 1.5 { f64::INFINITY } else { Rows(2, rosenbrock).cost(x) }
            }
            fn normal(&self, x: &[f64]) -> NormalEquations {
                Rows(2, rosenbrock).normal(x)
            }
            fn lowest(&self) -> Vec<f64> {
                vec![1.5, f64::NEG_INFINITY]
            }
        }
        assert_close(&search(&Limited, &[3.0, 2.0]).x, &[1.5, 2.25], 1e-9, 0.0);
        // From the limit too.
        assert_close(&search(&Limited, &[1.5, 9.0]).x, &[1.5, 2.25], 1e-9, 0.0);
    }

    #[test]
    fn the_path_does_not_depend_on_the_units_of_the_unknowns() {
        let in_other_units = |x: &[f64]| {
            let rows = rosenbrock(&[x[0] * 1e-6, x[1] * 1e4]);
            rows.into_iter().map(|r| vec![r[0], r[1] * 1e-6, r[2] * 1e4]).collect()
        };
        let plain = search(&Rows(2, rosenbrock), &[-1.2, 1.0]);
        let other = search(&Rows(2, in_other_units), &[-1.2e6, 1e-4]);
        assert_close(&other.history[..10], &plain.history[..10], 1e-6, 0.0);
    }

    #[test]
    fn directions_of_constant_cost_do_not_move() {
        // The cost depends only on the product: x0 x1 = 6.
        let product = Rows(2, |x: &[f64]| vec![vec![x[0] * x[1] - 6.0, x[1], x[0]]]);
        let found = search(&product, &[1.0, 1.0]);
        assert_close(&[found.x[0] * found.x[1], found.x[0]], &[6.0, found.x[1]], 1e-9, 0.0);
        let constant = Rows(2, |x: &[f64]| vec![vec![x[0] - 3.0, 1.0, 0.0]]);
        assert_close(&search(&constant, &[1.0, 7.0]).x, &[3.0, 7.0], 1e-9, 0.0);
    }

    #[test]
    fn a_step_to_an_undefined_cost_is_rejected() {
        // (ln x)^2: undefined below 0, where the first full step from 10 leads.
        let log = Rows(1, |x: &[f64]| vec![vec![x[0].ln(), 1.0 / x[0]]]);
        let settings = SearchSettings { damping: 1e-9, ..SearchSettings::default() };
        let found = minimise(&log, &[10.0], &settings, &mut Stage::ignore).unwrap();
        assert_close(&found.x, &[1.0], 1e-6, 0.0);
        assert!(
            minimise(&log, &[-1.0], &settings, &mut Stage::ignore).unwrap_err().to_string().contains("finite cost")
        );
    }

    #[test]
    fn the_reason_for_the_end_is_reported() {
        let noisy = Rows(2, |x: &[f64]| {
            (0..20)
                .map(|t| (f64::from(t), f64::from(t * t % 7)))
                .map(|(t, y)| vec![x[0] + x[1] * t - y, 1.0, t])
                .collect()
        });
        let reason =
            |settings: &SearchSettings| minimise(&noisy, &[0.0, 0.0], settings, &mut Stage::ignore).unwrap().reason;
        assert_eq!(reason(&SearchSettings::default()), Reason::Converged);
        assert_eq!(reason(&SearchSettings { iterations: 1, ..SearchSettings::default() }), Reason::Iterations);
        let mut stop = |_: Stage| ControlFlow::Break(());
        let start = minimise(&noisy, &[0.5, 0.0], &SearchSettings::default(), &mut stop).unwrap();
        assert_eq!((start.reason, start.x), (Reason::Cancelled, vec![0.5, 0.0]));
        let message = |settings, x: &[f64]| minimise(&noisy, x, &settings, &mut Stage::ignore).unwrap_err().to_string();
        assert!(message(SearchSettings::default(), &[1.0]).contains("the start has 1"));
        let undamped = SearchSettings { damping: 0.0, ..SearchSettings::default() };
        assert!(message(undamped, &[0.0, 0.0]).contains("damping = 0"));
    }

    #[test]
    fn the_rate_of_a_decay_is_found() {
        let error = |x: f64, t: i32| {
            vec![(-x * f64::from(t)).exp() - 0.5f64.powi(t), -f64::from(t) * (-x * f64::from(t)).exp()]
        };
        let decay = Rows(1, |x: &[f64]| (0..5).map(|t| error(x[0], t)).collect());
        assert_close(&search(&decay, &[0.1]).x, &[2f64.ln()], 0.0, 1e-9);
    }
}
