//! The paper's fitness, for many particles at once:
//!
//! ```text
//! f(theta) = sum_t |y_t - psi_t' theta|
//! ```
//!
//! The lanes of the vector unit are particles. Each lane sums its rows in order, so a cost is bit-identical for any
//! vector width, any group of particles and any number of threads. After each block of rows, particles that can no
//! longer fall below their limits are dropped.
//!
//! Why: docs/decisions/study-of-the-paper.md, "The swarm evaluates its cost in a plain loop".

use super::regression::Regression;

use multiversion::multiversion;
use piezoid_numerics::optimize::swarm::Cost;

/// Rows between two checks of the limits.
const BLOCK: usize = 1024;

/// Maximum number of particles evaluated together: their errors and sums fit the vector registers.
const WIDEST: usize = 32;

/// One number per particle of a group, aligned for the vector unit.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct ParticleLanes([f64; WIDEST]);

/// The sum of absolute one-step prediction errors of a regression.
///
/// ```
/// use piezoid_models::linear::AbsoluteError;
/// use piezoid_numerics::optimize::swarm::Cost;
/// // |1 - 2 theta| + |3 - 2 theta| for theta = 0 and theta = 1
/// let cost = AbsoluteError::new(&[1.0, 2.0, 3.0, 2.0], 1);
/// let mut costs = [0.0; 2];
/// cost.evaluate(&[0.0, 1.0], &[f64::MAX; 2], &mut costs);
/// assert_eq!(costs, [4.0, 2.0]);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct AbsoluteError<'a> {
    /// `[y, psi...]` one after another.
    rows: &'a [f64],
    dimension: usize,
}

impl<'a> AbsoluteError<'a> {
    /// The cost over `rows` of `[y, psi...]`, with `dimension` numbers in psi.
    pub fn new(rows: &'a [f64], dimension: usize) -> Self {
        AbsoluteError { rows, dimension }
    }
}

impl<'a> From<&'a Regression> for AbsoluteError<'a> {
    fn from(regression: &'a Regression) -> Self {
        AbsoluteError::new(&regression.rows, regression.orders.parameters())
    }
}

impl Cost for AbsoluteError<'_> {
    fn evaluate(&self, positions: &[f64], limits: &[f64], costs: &mut [f64]) {
        costs.fill(0.0);
        let d = self.dimension;
        let mut theta = vec![ParticleLanes([0.0; WIDEST]); d];
        let mut live: Vec<usize> = (0..costs.len()).collect();
        for block in self.rows.chunks(BLOCK * (d + 1)) {
            for group in live.chunks(WIDEST) {
                let mut sums = ParticleLanes([0.0; WIDEST]);
                for (lane, &m) in group.iter().enumerate() {
                    sums.0[lane] = costs[m];
                    for (theta, position) in theta.iter_mut().zip(&positions[m * d..]) {
                        theta.0[lane] = *position;
                    }
                }
                // Order 2, the paper's, has five parameters.
                match (group.len(), d) {
                    (1..=8, 5) => accumulate::<8, 5>(block, &theta, &mut sums),
                    (9..=16, 5) => accumulate::<16, 5>(block, &theta, &mut sums),
                    (17..=24, 5) => accumulate::<24, 5>(block, &theta, &mut sums),
                    (_, 5) => accumulate::<WIDEST, 5>(block, &theta, &mut sums),
                    (1..=8, _) => accumulate::<8, ANY>(block, &theta, &mut sums),
                    _ => accumulate::<WIDEST, ANY>(block, &theta, &mut sums),
                }
                for (&m, sum) in group.iter().zip(sums.0) {
                    costs[m] = sum;
                }
            }
            live.retain(|&m| costs[m] < limits[m]);
        }
    }
}

/// For [`accumulate`]: the number of parameters is the length of theta.
const ANY: usize = 0;

/// Adds the rows' errors |y - psi' theta| to the sums of the first `L` lanes. `D` is the number of parameters; if the
/// compiler knows it, they stay in registers.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn accumulate<const L: usize, const D: usize>(rows: &[f64], theta: &[ParticleLanes], sums: &mut ParticleLanes) {
    let theta = if D == ANY { theta } else { &theta[..D] };
    let mut sum = [0.0; L];
    sum.copy_from_slice(&sums.0[..L]);
    for row in rows.chunks_exact(theta.len() + 1) {
        let mut error = [row[0]; L];
        for i in 0..theta.len() {
            let (psi, theta) = (row[1 + i], &theta[i].0);
            for lane in 0..L {
                // Not fused, so that it is the same on every machine.
                error[lane] -= psi * theta[lane];
            }
        }
        for lane in 0..L {
            sum[lane] += error[lane].abs();
        }
    }
    sums.0[..L].copy_from_slice(&sum);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(n: usize, d: usize) -> Vec<f64> {
        (0..n * (d + 1)).map(|i| (i as f64 * 0.37).sin() + 0.1 * (i as f64 * 1.7).cos()).collect()
    }

    fn positions(particles: usize, d: usize) -> Vec<f64> {
        (0..particles * d).map(|i| (i as f64 * 0.61).cos()).collect()
    }

    #[test]
    fn a_cost_is_bit_identical_alone_and_in_any_group() {
        for d in [1, 3, 5, 7] {
            let rows = rows(1000, d);
            let cost = AbsoluteError::new(&rows, d);
            let all = positions(77, d);
            let mut together = vec![0.0; 77];
            cost.evaluate(&all, &[f64::MAX; 77], &mut together);
            for (theta, expected) in all.chunks_exact(d).zip(&together) {
                let mut alone = [0.0];
                cost.evaluate(theta, &[f64::MAX], &mut alone);
                assert_eq!(alone[0], *expected);
                let deviation =
                    |row: &[f64]| (row[0] - row[1..].iter().zip(theta).map(|(a, b)| a * b).sum::<f64>()).abs();
                let plain: f64 = rows.chunks_exact(d + 1).map(deviation).sum();
                piezoid_testing::assert_close(&alone, &[plain], 1e-12, 0.0);
            }
        }
    }

    #[test]
    fn a_particle_above_its_limit_may_stop_early_but_not_below_the_limit() {
        let rows = rows(3000, 5);
        let cost = AbsoluteError::new(&rows, 5);
        let all = positions(50, 5);
        let (mut exact, mut limited) = (vec![0.0; 50], vec![0.0; 50]);
        cost.evaluate(&all, &[f64::MAX; 50], &mut exact);
        let limits: Vec<f64> = exact.iter().enumerate().map(|(m, f)| f * [0.1, 0.99, 1.01, 5.0][m % 4]).collect();
        cost.evaluate(&all, &limits, &mut limited);
        for ((limited, exact), limit) in limited.iter().zip(&exact).zip(&limits) {
            assert!(if exact < limit { limited == exact } else { limited >= limit });
        }
        assert!(limited[0] < 0.5 * exact[0], "a hopeless particle should have stopped early");
    }
}
