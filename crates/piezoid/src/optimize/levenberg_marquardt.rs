//! Levenberg-Marquardt: the least of a sum of squares e'e, from its normal equations alone.
//!
//! ```text
//! (J'J + mu D) h = -J'e,   D = diag(J'J)                             the step
//! rho = (f(x) - f(x + h)) / (h' (mu D h - J'e)),   f = e'e           what it gained over what the model promised
//! rho > 0:  x <- x + h,  mu <- mu max(1/3, 1 - (2 rho - 1)^3)        taken
//! else:     mu <- nu mu,  nu <- 2 nu                                 refused, and the more shyly the oftener
//! ```
//!
//! Marquardt 1963 (doi:10.1137/0111030) for the scaling by D, which makes the path independent of the units of x;
//! Nielsen 1999 (IMM-REP-1999-05, Technical University of Denmark) for the damping. J'J and J'e are sums over samples, so
//! a problem of any length is accumulated piece by piece; the price is that a condition number beyond 1e8 in J is lost to
//! rounding. There mu never falls to nothing, so directions in which the cost is flat are left alone instead of taken
//! far. It finds the minimum that the start leads to, and has no bounds but a cost that is not finite.

use super::{Minimum, Reason};
use crate::error::{Error, positive};
use crate::progress::{Progress, Stage};
use nalgebra::{Cholesky, DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// A sum of squares f(x) = e(x)'e(x).
pub(crate) trait SumOfSquares {
    /// Number of unknowns.
    fn dimension(&self) -> usize;

    /// e'e at `x`; infinite or NaN where `x` makes no sense, which refuses the step there.
    fn cost(&self, x: &[f64]) -> f64;

    /// The normal equations at `x`, where the cost is finite.
    fn normal(&self, x: &[f64]) -> NormalEquations;
}

/// The normal equations at one point, with J the derivatives of e, one column an unknown.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NormalEquations {
    /// e'e.
    pub cost: f64,
    /// J'e, half the gradient.
    pub gradient: Vec<f64>,
    /// J'J, row by row.
    pub hessian: Vec<f64>,
}

/// How to search.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct SearchSettings {
    /// Steps tried at most, refused ones included.
    pub iterations: usize,
    /// Converged when a step promises to lower the cost by less than this share of it.
    pub tolerance: f64,
    /// mu at the start: small trusts the start, large distrusts it.
    pub damping: f64,
}

impl Default for SearchSettings {
    /// 100 steps, 1e-12, 1e-3.
    fn default() -> Self {
        SearchSettings { iterations: 100, tolerance: 1e-12, damping: 1e-3 }
    }
}

/// The smallest mu: below it, rounding in J'J decides which way flat directions go.
const LEAST_DAMPING: f64 = 1e-13;

/// A mu beyond which steps are rounding.
const MOST_DAMPING: f64 = 1e20;

/// Searches from `start`. How it ended is in [`Minimum::reason`]; cancelling keeps the best so far.
///
/// # Errors
/// Refuses a start of another length than the problem's dimension or whose cost is not finite, no iterations, and a
/// damping or tolerance that is not positive.
pub(crate) fn minimise(
    problem: &impl SumOfSquares,
    start: &[f64],
    settings: &SearchSettings,
    progress: &mut Progress,
) -> Result<Minimum, Error> {
    check(problem, start, settings)?;
    let mut x = start.to_vec();
    let mut normal = problem.normal(&x);
    if !normal.cost.is_finite() {
        return Err(Error::parameter("start", format!("{start:?}"), "must have a finite cost"));
    }
    let (mut mu, mut nu) = (settings.damping, 2.0);
    let (mut history, mut courses) = (vec![normal.cost], vec![x.clone()]);
    let reason = loop {
        let done = history.len() - 1;
        if done >= settings.iterations {
            break Reason::Iterations;
        }
        if progress(Stage { what: "Levenberg-Marquardt", done, total: settings.iterations }).is_break() {
            break Reason::Cancelled;
        }
        let mut gain = -1.0;
        if let Some((h, promise)) = step(&normal, mu) {
            // A promise may be small for two reasons: nothing left to gain, or too shy to gain it.
            if mu < 1.0 && promise <= settings.tolerance * normal.cost {
                break Reason::Converged;
            }
            let trial: Vec<f64> = x.iter().zip(&h).map(|(x, h)| x + h).collect();
            let cost = problem.cost(&trial);
            if cost < normal.cost {
                gain = (normal.cost - cost) / promise;
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
        return Err(Error::Lengths {
            left: "the start".into(),
            left_len: start.len(),
            right: "the vector of unknowns".into(),
            right_len: problem.dimension(),
        });
    }
    positive("damping", settings.damping, "J'J's diagonal")?;
    positive("tolerance", settings.tolerance, "the cost")?;
    if settings.iterations == 0 {
        return Err(Error::parameter("iterations", 0, "must be at least 1"));
    }
    Ok(())
}

/// The damped step and the fall of e'e that the model promises for it; `None` where rounding has left no step.
fn step(normal: &NormalEquations, mu: f64) -> Option<(Vec<f64>, f64)> {
    let d = normal.gradient.len();
    let size = sizes(normal);
    let scaled =
        DMatrix::from_fn(d, d, |i, j| normal.hessian[i * d + j] / (size[i] * size[j]) + if i == j { mu } else { 0.0 });
    let downhill = DVector::from_fn(d, |i, _| -normal.gradient[i] / size[i]);
    let h = Cholesky::new(scaled)?.solve(&downhill);
    let promise = h.dot(&(&h * mu + downhill));
    let h: Vec<f64> = h.iter().zip(&size).map(|(h, size)| h / size).collect();
    h.iter().all(|h| h.is_finite()).then_some((h, promise))
}

/// The lengths of J's columns; 1 for a column of zeros, whose unknown then stays where it is.
fn sizes(normal: &NormalEquations) -> Vec<f64> {
    let d = normal.gradient.len();
    let length = |i: usize| normal.hessian[i * d + i].sqrt();
    (0..d).map(|i| if length(i) > 0.0 { length(i) } else { 1.0 }).collect()
}

impl NormalEquations {
    /// No samples yet, for `dimension` unknowns.
    pub(crate) fn empty(dimension: usize) -> Self {
        NormalEquations { cost: 0.0, gradient: vec![0.0; dimension], hessian: vec![0.0; dimension * dimension] }
    }

    /// Adds `weight` times the sums of `other`, which has the same unknowns.
    pub(crate) fn add(&mut self, weight: f64, other: &NormalEquations) {
        let sums = std::iter::once(&mut self.cost).chain(&mut self.gradient).chain(&mut self.hessian);
        let terms = std::iter::once(&other.cost).chain(&other.gradient).chain(&other.hessian);
        sums.zip(terms).for_each(|(sum, term)| *sum += weight * term);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::silent;
    use crate::testing::assert_close;
    use std::ops::ControlFlow;

    /// Errors and their derivatives as functions of x: row i of J after e_i.
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

    #[test]
    fn it_walks_down_rosenbrocks_valley() {
        let found = minimise(&Rows(2, rosenbrock), &[-1.2, 1.0], &SearchSettings::default(), &mut silent).unwrap();
        assert_close(&found.x, &[1.0, 1.0], 1e-9, 0.0);
        assert!(found.history.len() < 40 && found.history.windows(2).all(|w| w[1] <= w[0]));
    }

    #[test]
    fn units_of_the_unknowns_change_nothing() {
        let in_other_units = |x: &[f64]| {
            let rows = rosenbrock(&[x[0] * 1e-6, x[1] * 1e4]);
            rows.into_iter().map(|r| vec![r[0], r[1] * 1e-6, r[2] * 1e4]).collect()
        };
        let plain = minimise(&Rows(2, rosenbrock), &[-1.2, 1.0], &SearchSettings::default(), &mut silent).unwrap();
        let other =
            minimise(&Rows(2, in_other_units), &[-1.2e6, 1e-4], &SearchSettings::default(), &mut silent).unwrap();
        assert_close(&other.history[..10], &plain.history[..10], 1e-6, 0.0);
    }

    #[test]
    fn a_direction_that_changes_nothing_is_left_alone() {
        // Only the product is seen: x0 x1 = 6.
        let product = Rows(2, |x: &[f64]| vec![vec![x[0] * x[1] - 6.0, x[1], x[0]]]);
        let found = minimise(&product, &[1.0, 1.0], &SearchSettings::default(), &mut silent).unwrap();
        assert_close(&[found.x[0] * found.x[1], found.x[0]], &[6.0, found.x[1]], 1e-9, 0.0);
        let unseen = Rows(2, |x: &[f64]| vec![vec![x[0] - 3.0, 1.0, 0.0]]);
        let found = minimise(&unseen, &[1.0, 7.0], &SearchSettings::default(), &mut silent).unwrap();
        assert_close(&found.x, &[3.0, 7.0], 1e-9, 0.0);
    }

    #[test]
    fn a_step_to_where_nothing_is_defined_is_refused() {
        // (ln x)^2: undefined below 0, where the first full step from 10 leads.
        let log = Rows(1, |x: &[f64]| vec![vec![x[0].ln(), 1.0 / x[0]]]);
        let settings = SearchSettings { damping: 1e-9, ..SearchSettings::default() };
        let found = minimise(&log, &[10.0], &settings, &mut silent).unwrap();
        assert_close(&found.x, &[1.0], 1e-6, 0.0);
        assert!(minimise(&log, &[-1.0], &settings, &mut silent).unwrap_err().to_string().contains("finite cost"));
    }

    #[test]
    fn how_it_ended_is_told() {
        let noisy = Rows(2, |x: &[f64]| {
            (0..20)
                .map(|t| (f64::from(t), f64::from(t * t % 7)))
                .map(|(t, y)| vec![x[0] + x[1] * t - y, 1.0, t])
                .collect()
        });
        let reason = |settings: &SearchSettings| minimise(&noisy, &[0.0, 0.0], settings, &mut silent).unwrap().reason;
        assert_eq!(reason(&SearchSettings::default()), Reason::Converged);
        assert_eq!(reason(&SearchSettings { iterations: 1, ..SearchSettings::default() }), Reason::Iterations);
        let mut stop = |_: Stage| ControlFlow::Break(());
        let start = minimise(&noisy, &[0.5, 0.0], &SearchSettings::default(), &mut stop).unwrap();
        assert_eq!((start.reason, start.x), (Reason::Cancelled, vec![0.5, 0.0]));
        let message = |settings, x: &[f64]| minimise(&noisy, x, &settings, &mut silent).unwrap_err().to_string();
        assert!(message(SearchSettings::default(), &[1.0]).contains("the start has 1"));
        assert!(
            message(SearchSettings { damping: 0.0, ..SearchSettings::default() }, &[0.0, 0.0]).contains("damping = 0")
        );
    }

    #[test]
    fn the_rate_of_a_decay_is_found() {
        /// sum over t of (exp(-x t) - y_t)^2
        struct Decay(Vec<f64>);
        impl SumOfSquares for Decay {
            fn dimension(&self) -> usize {
                1
            }
            fn cost(&self, x: &[f64]) -> f64 {
                self.normal(x).cost
            }
            fn normal(&self, x: &[f64]) -> NormalEquations {
                let mut sums = NormalEquations { cost: 0.0, gradient: vec![0.0], hessian: vec![0.0] };
                for (t, y) in self.0.iter().enumerate() {
                    let model = (-x[0] * t as f64).exp();
                    let (e, slope) = (model - y, -(t as f64) * model);
                    sums.cost += e * e;
                    sums.gradient[0] += slope * e;
                    sums.hessian[0] += slope * slope;
                }
                sums
            }
        }
        let half = Decay((0..5).map(|t| 0.5f64.powi(t)).collect());
        let found = minimise(&half, &[0.1], &SearchSettings::default(), &mut crate::progress::silent).unwrap();
        assert!((found.x[0] - 2f64.ln()).abs() < 1e-9);
    }
}
