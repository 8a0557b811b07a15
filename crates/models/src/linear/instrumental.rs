//! Instrumental variables: estimates without the bias that noise in y causes in least squares.
//!
//! ```text
//! psi_t = [y_f, u_f shifted],   zeta_t = [y^_f, u_f shifted],   x_f = x / A of the last round
//! theta <- (sum zeta_t psi_t')^-1 sum zeta_t y_f,t
//! ```
//! Least squares is biased because the outputs in psi contain the noise that it minimises. The instruments zeta are
//! computed from the free run y^, which contains no noise; if they and psi are filtered by the A of the previous round,
//! the errors are those of the free run. Each round renews A and y^. At convergence sum zeta_t e_t = 0: these are the
//! normal equations of the output error, so with white noise in y both have the same solution. Instruments converge
//! from poor starting values, Levenberg-Marquardt at the minimum.
//!
//! Young & Jakeman 1979 (doi:10.1080/00207177908922676); Söderström & Stoica 1983, Instrumental Variable Methods for
//! System Identification (doi:10.1007/BFb0009019). Offsets and pasts of the records are projected out of both sides.
//! The cost need not fall from round to round, and rounds may cycle; the best free run is kept.
//!
//! Why: docs/decisions/linear-block.md, "Output error starts from instrumental variables".

use super::analysis::roots;
use super::free_run::{FreeRunError, decays};
use super::inverse::{monic, reciprocal};
use super::output_error::{Refinement, checked};
use super::regression::Orders;
use nalgebra::{DMatrix, DVector};
use piezoid_numerics::error::Error;
pub(super) use piezoid_numerics::optimize::levenberg_marquardt::{NormalEquations, SumOfSquares};
use piezoid_records::record::Record;

/// The end of the rounds.
#[derive(Debug, Clone, Copy)]
pub(super) struct StopRule {
    /// Maximum number of rounds.
    most: usize,
    /// A round that changes the cost by less than this share is the last.
    settled: f64,
}

/// Sufficient as the start of a search.
pub(super) const ROUGH: StopRule = StopRule { most: 15, settled: 1e-4 };

const FINE: StopRule = StopRule { most: 50, settled: 1e-10 };

/// The theta of the best free run, and the best cost and theta of each round.
pub(super) struct Iterations {
    pub(super) theta: Vec<f64>,
    /// One per record.
    pub(super) offsets: Vec<f64>,
    pub(super) cost: f64,
    pub(super) history: Vec<f64>,
    pub(super) courses: Vec<Vec<f64>>,
}

/// The estimator, from the poles of `a`.
pub(super) fn estimate(records: &[Record], orders: Orders, a: &[f64]) -> Result<Iterations, Error> {
    let weights = checked(records, orders, &Refinement::default())?;
    let problem = FreeRunError { records, weights: &weights, orders };
    let mut found = rounds(&problem, a, FINE);
    found.offsets = problem.runs(&found.theta).map(|(run, _)| run.offset).collect();
    Ok(found)
}

/// Rounds of refined instrumental variables from the poles of `a`.
pub(super) fn rounds(problem: &FreeRunError, a: &[f64], ends: StopRule) -> Iterations {
    let mut theta = with_best_b(problem, &stabilised(a));
    let cost = problem.cost(&theta);
    let mut best = Iterations {
        theta: theta.clone(),
        offsets: Vec::new(),
        cost,
        history: vec![cost],
        courses: vec![theta.clone()],
    };
    let mut before = cost;
    for _ in 0..ends.most {
        let Some(step) = step(problem, &theta) else { break };
        theta.iter_mut().zip(step.iter()).for_each(|(theta, step)| *theta += step);
        if !decays(&theta[..problem.orders.na]) {
            theta = with_best_b(problem, &stabilised(&theta[..problem.orders.na]));
        }
        let cost = problem.cost(&theta);
        if cost < best.cost {
            best.cost = cost;
            best.theta.clone_from(&theta);
        }
        best.history.push(best.cost);
        best.courses.push(best.theta.clone());
        if !cost.is_finite() || (cost - before).abs() <= ends.settled * cost {
            break;
        }
        before = cost;
    }
    best
}

/// The change of theta that solves sum zeta_t (y_f,t - psi_t' theta) = 0, where y_f,t - psi_t' theta = e_t at the theta
/// of the filter.
fn step(problem: &FreeRunError, theta: &[f64]) -> Option<DVector<f64>> {
    let d = problem.dimension();
    let (mut matrix, mut right) = (DMatrix::zeros(d, d), DVector::zeros(d));
    for (run, weight) in problem.runs(theta) {
        let measured: Vec<f64> = run.model.iter().zip(&run.e).map(|(y, e)| y + e).collect();
        let (model, measured) = (run.filtered(&run.model), run.filtered(&measured));
        let instruments = run.slopes(&model);
        matrix += weight * run.products(&instruments, &run.slopes(&measured));
        right += weight * DVector::from_vec(run.along(&instruments));
    }
    let size: Vec<f64> = matrix.diagonal().iter().map(|d: &f64| d.abs().sqrt().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(d, d, |i, j| matrix[(i, j)] / (size[i] * size[j]));
    let solved = scaled.lu().solve(&DVector::from_fn(d, |i, _| right[i] / size[i]))?;
    let step = DVector::from_fn(d, |i, _| solved[i] / size[i]);
    step.iter().all(|s| s.is_finite()).then_some(step)
}

/// [a, b] with the b that minimises the free-run error, which is linear in b.
pub(super) fn with_best_b(problem: &FreeRunError, a: &[f64]) -> Vec<f64> {
    let (d, na, nb) = (problem.dimension(), problem.orders.na, problem.orders.nb);
    let mut theta = a.to_vec();
    theta.resize(d, 0.0);
    let NormalEquations { gradient, hessian, .. } = problem.normal(&theta);
    let size: Vec<f64> = (na..d).map(|k| hessian[k * d + k].sqrt().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(nb, nb, |i, j| hessian[(na + i) * d + na + j] / (size[i] * size[j]));
    let right = DVector::from_fn(nb, |i, _| -gradient[na + i] / size[i]);
    if let Ok(b) = scaled.svd(true, true).solve(&right, 1e-13) {
        theta[na..].iter_mut().zip(b.iter().zip(&size)).for_each(|(theta, (b, size))| *theta = b / size);
    }
    theta
}

/// The same poles; those outside the unit circle are mirrored into it, those on it are moved inside.
pub(super) fn stabilised(a: &[f64]) -> Vec<f64> {
    if decays(a) {
        return a.to_vec();
    }
    let characteristic: Vec<f64> = std::iter::once(1.0).chain(a.iter().map(|a| -a)).collect();
    let mut inside = roots(&characteristic);
    for z in &mut inside {
        if z.modulus() > 1.0 {
            *z = reciprocal(z);
        }
        let shrink = (0.999 / z.modulus()).min(1.0);
        (z.re, z.im) = (z.re * shrink, z.im * shrink);
    }
    let a: Vec<f64> = monic(&inside).iter().map(|c| -c).collect();
    if decays(&a) { a } else { vec![0.0; a.len()] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::{Arx, Estimator, Fit};
    use piezoid_numerics::optimize::swarm;
    use piezoid_numerics::progress::Stage;
    use piezoid_numerics::series::mean;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal as Gauss};

    const A: [f64; 2] = [1.7, -0.9];
    const B: [f64; 3] = [0.0, 3.0, 2.5];

    /// Two records of one block, with different offsets and white noise in y, 5 % of its rms.
    fn noisy(seed: u64) -> [Record; 2] {
        let truth = Arx::new(5e-4, A.to_vec(), B.to_vec()).unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut record = |offset: f64, n| {
            let u: Vec<f64> = (0..n).map(|_| Gauss::new(0.0, 1.0).unwrap().sample(&mut random)).collect();
            let noise = Gauss::new(offset, 1.0).unwrap();
            let y = truth.simulate(&u).iter().map(|y| y + noise.sample(&mut random)).collect();
            Record::new(5e-4, u, y).unwrap()
        };
        [record(30.0, 700), record(-12.0, 500)]
    }

    fn fitted(seed: u64, name: &str) -> Fit {
        let orders = Orders { na: 2, nb: 2, delay: 1 };
        let settings = swarm::SwarmSettings::default();
        Estimator::find(name).unwrap().fit(&noisy(seed), orders, &settings, &mut Stage::ignore).unwrap()
    }

    #[test]
    fn it_has_no_bias_where_least_squares_is_biased() {
        let errors = |name: &str| -> (Vec<f64>, f64) {
            let all: Vec<f64> = (0..20).map(|seed| fitted(seed, name).arx.a()[0] - A[0]).collect();
            let scatter = (piezoid_numerics::series::scatter(&all) / 19.0 / 20.0).sqrt();
            (vec![mean(&all)], scatter)
        };
        for name in ["instrumental", "output-error"] {
            let (bias, error) = errors(name);
            assert_close(&bias, &[0.0], 0.0, 3.0 * error);
            assert!(error < 1e-3, "{name}: {error}");
        }
        let (bias, error) = errors("least-squares");
        assert!(bias[0].abs() > 20.0 * error, "least squares should be biased: {bias:?} +- {error}");
    }

    #[test]
    fn it_converges_to_the_minimum_of_the_output_error() {
        let (rounds, search) = (fitted(3, "instrumental"), fitted(3, "output-error"));
        assert_close(rounds.arx.a(), search.arx.a(), 1e-5, 0.0);
        assert_close(&rounds.offsets, &search.offsets, 1e-4, 0.0);
        assert_close(&rounds.offsets, &[30.0, -12.0], 0.0, 0.2);
        assert_eq!(rounds.arx.b()[0], 0.0);
    }

    #[test]
    fn poles_outside_the_circle_are_mirrored_into_it() {
        // (1 - 2 q^-1)(1 - 0.5 q^-1), and a pair at 1.25 exp(+-0.7i) at 0.8 exp(+-0.7i)
        assert_close(&stabilised(&[2.5, -1.0]), &[1.0, -0.25], 1e-12, 0.0);
        let pair = |r: f64| [2.0 * r * 0.7f64.cos(), -r * r];
        assert_close(&stabilised(&pair(1.25)), &pair(0.8), 1e-12, 0.0);
        assert!(decays(&stabilised(&[1.0])) && decays(&stabilised(&[0.0, 0.0, 1.0])));
    }
}
