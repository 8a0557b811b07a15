//! The quadratic program of one sample, condensed to the moves, by a dual active-set method with buffers of fixed size.
//!
//! ```text
//! min over x of  1/2 x' H x - g' x + 1/2 sigma sum e_i^2     low_i - e_i <= a_i' x <= high_i + e_i
//! ```
//! e_i = 0 on hard rows. H and the rows are constant, so M = A H^-1 A' is computed once, and all operations are on
//! rows: v = A x and one multiplier per row. A soft row adds 1 / sigma to its diagonal of M; its e_i is its multiplier
//! over sigma. Starting at the free optimum, the most violated row (first among those that were active in the last
//! sample) is added, and active rows whose multiplier reaches zero are removed, until no row is violated.
//!
//! Reference: D. Goldfarb, A. Idnani, Math. Program. 27, 1 (1983), DOI 10.1007/BF02591962. It does not do: equalities
//! other than low = high; an H that is not positive definite.

use nalgebra::{Cholesky, DMatrix};
use piezoid_numerics::series::dot;

/// Violation of a row by rounding, relative to the size of the limited values.
const TINY: f64 = 1e-11;

/// Smallest remaining share of a row's curvature for which it is independent of the active rows.
const INDEPENDENT: f64 = 1e-10;

/// Largest number of active-set changes in one sample, per move.
const PATIENCE: usize = 4;

/// The program without g and the limits.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Condensed {
    /// H, the rows A and the stiffness of each, for other solvers.
    pub(super) h: DMatrix<f64>,
    pub(super) a: DMatrix<f64>,
    pub(super) sigma: Vec<f64>,
    /// A, row by row.
    rows: Vec<f64>,
    /// A H^-1 A' with the terms of soft rows, row by row.
    m: Vec<f64>,
    /// H^-1 A', row by row.
    back: Vec<f64>,
}

/// Result of a sample's program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SolveResult {
    /// Number of rows added and removed.
    pub(super) changes: usize,
    /// True if no row is violated.
    pub(super) solved: bool,
}

/// The buffers, cut from one slice.
struct Buffers<'w> {
    /// Multipliers: positive at the high end. Kept for the next sample.
    lambda: &'w mut [f64],
    /// Those of the last sample.
    last: &'w mut [f64],
    /// a_i' x, soft rows less their e_i.
    v: &'w mut [f64],
    /// The active rows in their order, counted from 1, negative at the low end.
    bound: &'w mut [f64],
    /// Decrease of their multipliers.
    r: &'w mut [f64],
    /// Cholesky factor of M among the active rows and a trial row, row by row.
    factor: &'w mut [f64],
}

impl Condensed {
    /// From H, the rows A, and sigma of each, infinite for a hard row. `None` if H is not positive definite.
    pub(super) fn new(h: DMatrix<f64>, a: DMatrix<f64>, sigma: Vec<f64>) -> Option<Self> {
        let back = Cholesky::new(h.clone())?.solve(&a.transpose());
        let mut m = &a * &back;
        sigma.iter().enumerate().for_each(|(i, sigma)| m[(i, i)] += 1.0 / sigma);
        Some(Condensed { rows: by_rows(&a), m: by_rows(&m), back: by_rows(&back), h, a, sigma })
    }

    /// Length of x.
    pub(super) fn moves(&self) -> usize {
        self.h.nrows()
    }

    /// Largest number of active rows: as many hard ones as there are moves, and the soft ones.
    fn most(&self) -> usize {
        self.sigma.len().min(self.moves() + self.sigma.iter().filter(|s| s.is_finite()).count())
    }

    /// Length of the buffers.
    pub(super) fn scratch(&self) -> usize {
        let (rows, most) = (self.sigma.len(), self.most() + 1);
        3 * rows + most * (most + 2)
    }

    /// Number of active-set changes after which a sample ends unsolved.
    fn patience(&self) -> usize {
        PATIENCE * self.moves()
    }

    fn cut<'w>(&self, scratch: &'w mut [f64]) -> Buffers<'w> {
        let (rows, most) = (self.sigma.len(), self.most() + 1);
        let (lambda, rest) = scratch.split_at_mut(rows);
        let (last, rest) = rest.split_at_mut(rows);
        let (v, rest) = rest.split_at_mut(rows);
        let (bound, rest) = rest.split_at_mut(most);
        let (r, factor) = rest.split_at_mut(most);
        Buffers { lambda, last, v, bound, r, factor }
    }

    /// Replaces the free optimum `x` = H^-1 g by the optimum within the limits `low` and `high` of each row. `scratch`,
    /// of length [`Condensed::scratch`], carries the multipliers from sample to sample and starts as zeros.
    pub(super) fn solve(&self, x: &mut [f64], low: &[f64], high: &[f64], scratch: &mut [f64]) -> SolveResult {
        let mut w = self.cut(scratch);
        w.last.copy_from_slice(w.lambda);
        w.lambda.fill(0.0);
        w.v.iter_mut().zip(self.rows.chunks_exact(x.len())).for_each(|(v, a)| *v = dot(a, x));
        let size = low.iter().chain(high).filter(|v| v.is_finite()).chain(&*w.v);
        let size = TINY * size.fold(0.0, |m: f64, v| m.max(v.abs()));

        let (mut count, mut changes) = (0, 0);
        let solved = 'rows: loop {
            let Some((p, side)) = self.worst(low, high, size, count, &w) else { break true };
            loop {
                if changes == self.patience() {
                    break 'rows false;
                }
                changes += 1;
                // Raising the multiplier of p by t lowers those of the active rows by t r, and the violation of p by t
                // curvature.
                let curvature = self.direction(p, side, count, &mut w);
                let over = if side > 0.0 { w.v[p] - high[p] } else { low[p] - w.v[p] };
                let independent = count < self.most() && curvature > INDEPENDENT * self.m(p, p);
                let whole = if independent { over.max(0.0) / curvature } else { f64::INFINITY };
                let (until, gone) = first_gone(&w.bound[..count], w.lambda, w.r);
                let t = whole.min(until);
                if t == f64::INFINITY {
                    break 'rows false;
                }
                self.raise(p, side, t, count, &mut w);
                if t == whole {
                    w.factor[count * (self.most() + 2)] = curvature.sqrt();
                    w.bound[count] = side * (p + 1) as f64;
                    count += 1;
                    break;
                }
                w.lambda[named(w.bound[gone]).0] = 0.0;
                w.bound.copy_within(gone + 1..count, gone);
                count -= 1;
                for k in gone..count {
                    let left = self.forward(named(w.bound[k]).0, k, &mut w);
                    w.factor[k * (self.most() + 2)] = left.max(f64::MIN_POSITIVE).sqrt();
                }
            }
        };
        let eliminate = |(x, back): (&mut f64, &[f64])| *x -= dot(back, w.lambda);
        x.iter_mut().zip(self.back.chunks_exact(w.lambda.len())).for_each(eliminate);
        SolveResult { changes, solved }
    }

    fn m(&self, i: usize, j: usize) -> f64 {
        self.m[i * self.sigma.len() + j]
    }

    /// The most violated row and its side; rows that were active in the last sample come first.
    fn worst(&self, low: &[f64], high: &[f64], tiny: f64, count: usize, w: &Buffers<'_>) -> Option<(usize, f64)> {
        let mut worst = (false, 0.0, None);
        for (i, &v) in w.v.iter().enumerate() {
            let (over, side) = if v > high[i] { (v - high[i], 1.0) } else { (low[i] - v, -1.0) };
            if over <= tiny || w.bound[..count].iter().any(|&b| named(b).0 == i) {
                continue;
            }
            let rank = (w.last[i] * side > 0.0, over / self.m(i, i).sqrt());
            if (rank.0, rank.1) > (worst.0, worst.1) {
                worst = (rank.0, rank.1, Some((i, side)));
            }
        }
        worst.2
    }

    /// Puts L^-1 M_p into row `k` of the factor L of the first `k` active rows. Returns the remaining curvature of p.
    fn forward(&self, p: usize, k: usize, w: &mut Buffers<'_>) -> f64 {
        let stride = self.most() + 1;
        let (factor, rest) = w.factor.split_at_mut(k * stride);
        let mut left = self.m(p, p);
        for (j, before) in factor.chunks_exact(stride).enumerate() {
            rest[j] = (self.m(p, named(w.bound[j]).0) - dot(&before[..j], &rest[..j])) / before[j];
            left -= rest[j] * rest[j];
        }
        left
    }

    /// The decrease r of the multipliers of the active rows for that of row `p`, and the remaining curvature of p.
    fn direction(&self, p: usize, side: f64, count: usize, w: &mut Buffers<'_>) -> f64 {
        let left = self.forward(p, count, w);
        let stride = self.most() + 1;
        for j in (0..count).rev() {
            let known = (j + 1..count).map(|i| w.factor[i * stride + j] * w.r[i]).sum::<f64>();
            w.r[j] = (side * w.factor[count * stride + j] - known) / w.factor[j * stride + j];
        }
        left
    }

    /// Raises the multiplier of row `p` by `t`.
    fn raise(&self, p: usize, side: f64, t: f64, count: usize, w: &mut Buffers<'_>) {
        let rows = self.sigma.len();
        let mut add = |i: usize, by: f64| {
            w.lambda[i] += by;
            // M is symmetric: its row i is the decrease of each v.
            w.v.iter_mut().zip(&self.m[i * rows..]).for_each(|(v, m)| *v -= by * m);
        };
        add(p, side * t);
        w.bound[..count].iter().zip(&*w.r).for_each(|(&b, r)| add(named(b).0, -t * r));
    }
}

/// Multiplications of one sample in the worst case, for `n` moves and `rows` rows with at most `most` active ones: rows
/// are added up to the maximum, then one is removed and another added in every change.
pub(super) fn operations(n: usize, rows: usize, most: usize) -> usize {
    let (every, first) = (PATIENCE * n, most.min(PATIENCE * n));
    let taken_in = first * (rows * most / 2 + most * most / 3);
    let exchanged = (every - first) * (rows * most + most * most + most * most * most / 12);
    // The search over rows costs about four multiplications per row.
    2 * rows * n + taken_in + exchanged + every * 4 * rows
}

/// Largest increase of the multiplier of a row until one of the `bound` rows has to be removed, and that row's
/// position.
fn first_gone(bound: &[f64], lambda: &[f64], r: &[f64]) -> (f64, usize) {
    let mut first = (f64::INFINITY, 0);
    for (k, (&b, r)) in bound.iter().zip(r).enumerate() {
        let (row, side) = named(b);
        let until = (side * lambda[row]).max(0.0) / (side * r);
        if side * r > 0.0 && until < first.0 {
            first = (until, k);
        }
    }
    first
}

/// The row and the side of an entry in `bound`.
fn named(bound: f64) -> (usize, f64) {
    (bound.abs() as usize - 1, bound.signum())
}

fn by_rows(m: &DMatrix<f64>) -> Vec<f64> {
    m.transpose().as_slice().to_vec()
}

#[cfg(test)]
mod tests {
    use super::super::interior;
    use super::*;
    use nalgebra::DVector;
    use piezoid_testing::assert_close;
    use rand::{Rng, RngExt, SeedableRng};

    /// Bounds, rates and soft outputs of eight random moves.
    fn program(random: &mut impl Rng) -> Condensed {
        let n = 8;
        let phi = DMatrix::from_fn(n, n, |i, j| if i >= j { random.random_range(-1.0..1.0) } else { 0.0 });
        let mut rows = DMatrix::zeros(3 * n - 1, n);
        let mut sigma = vec![f64::INFINITY; 3 * n - 1];
        for i in 0..n {
            rows[(i, i)] = 1.0;
            if i > 0 {
                rows[(n + i - 1, i)] = 1.0;
                rows[(n + i - 1, i - 1)] = -1.0;
            }
            rows.row_mut(2 * n - 1 + i).copy_from(&phi.row(i));
            sigma[2 * n - 1 + i] = 10.0;
        }
        let h = phi.transpose() * &phi + 0.1 * DMatrix::identity(n, n);
        Condensed::new(h, rows, sigma).unwrap()
    }

    #[test]
    fn the_optimum_matches_the_interior_point_method() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut bound = 0;
        for _ in 0..200 {
            let program = program(&mut random);
            let mut scratch = vec![0.0; program.scratch()];
            // Similar samples, so that the start is warm.
            let mut g = DVector::from_fn(8, |_, _| random.random_range(-5.0..5.0));
            for _ in 0..4 {
                g += DVector::from_fn(8, |_, _| random.random_range(-0.5..0.5));
                let half = |i: usize| if i < 8 { 1.0 } else { 0.4 };
                let high: Vec<f64> = (0..23).map(half).collect();
                let low: Vec<f64> = (0..23).map(|i| -0.7 * half(i)).collect();
                let mut x = Cholesky::new(program.h.clone()).unwrap().solve(&g).as_slice().to_vec();
                let ended = program.solve(&mut x, &low, &high, &mut scratch);
                assert!(ended.solved, "{ended:?}");
                bound += usize::from(ended.changes > 0);
                let known = interior::solve(&program, g.as_slice(), &low, &high).unwrap();
                assert_close(&x, &known, 0.0, 1e-6);
            }
        }
        assert!(bound > 600, "{bound}");
    }

    #[test]
    fn limits_that_cannot_be_met_end_unsolved() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let program = program(&mut random);
        let (mut low, mut high) = (vec![-1.0; 23], vec![1.0; 23]);
        (low[0], high[1], high[8], low[8]) = (0.9, -0.9, 0.1, -0.1);
        let mut x = vec![0.3; 8];
        assert!(!program.solve(&mut x, &low, &high, &mut vec![0.0; program.scratch()]).solved);
        assert!(x.iter().all(|x| x.is_finite()));
    }

    fn seeded(seed: u64) -> rand_chacha::ChaCha8Rng {
        rand_chacha::ChaCha8Rng::seed_from_u64(seed)
    }

    #[test]
    fn limits_that_contradict_each_other_do_not_drive_the_moves_away() {
        let mut random = seeded(5);
        let (mut low, mut high) = (vec![-1.0; 23], vec![1.0; 23]);
        (low[0], high[1], high[8], low[8]) = (0.9, -0.9, 0.1, -0.1);
        for _ in 0..50 {
            let program = program(&mut random);
            let mut x = vec![0.3; 8];
            let ended = program.solve(&mut x, &low, &high, &mut vec![0.0; program.scratch()]);
            assert!(!ended.solved && x.iter().all(|x| x.abs() < 1e3), "{x:?}");
        }
        assert_eq!(interior::solve(&program(&mut random), &[0.0; 8], &low, &high), None);
    }

    #[test]
    fn the_unit_of_the_cost_does_not_matter() {
        let mut random = seeded(3);
        for _ in 0..20 {
            let one = program(&mut random);
            let g = DVector::from_fn(8, |_, _| random.random_range(-5.0..5.0));
            let start = Cholesky::new(one.h.clone()).unwrap().solve(&g);
            let solved = |factor: f64| {
                let sigma = one.sigma.iter().map(|sigma| factor * sigma).collect();
                let program = Condensed::new(&one.h * factor, one.a.clone(), sigma).unwrap();
                let mut x = start.as_slice().to_vec();
                let ended = program.solve(&mut x, &[-0.4; 23], &[0.5; 23], &mut vec![0.0; program.scratch()]);
                (x, ended)
            };
            let expected = solved(1.0);
            // Powers of four: every rounding is the same.
            assert_eq!([solved(2f64.powi(40)), solved(2f64.powi(-40))], [expected.clone(), expected]);
        }
    }

    #[test]
    fn the_row_that_raises_the_cost_most_is_added_first_but_after_those_of_the_last_sample() {
        let h = DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 4.0]));
        let program = Condensed::new(h, DMatrix::identity(2, 2), vec![f64::INFINITY; 2]).unwrap();
        let worst = |last: [f64; 2]| {
            let mut scratch = vec![0.0; program.scratch()];
            let w = program.cut(&mut scratch);
            w.v.copy_from_slice(&[3.3, 2.2]);
            w.last.copy_from_slice(&last);
            let over = program.worst(&[-1.0; 2], &[1.0; 2], 0.0, 0, &w);
            w.v.copy_from_slice(&[-3.3, -2.2]);
            [over, program.worst(&[-1.0; 2], &[1.0; 2], 0.0, 0, &w)]
        };
        // Beyond their ends by 2.3 and 1.2, over the roots of 1 and of a quarter.
        assert_eq!(worst([0.0, 0.0]), [Some((1, 1.0)), Some((1, -1.0))]);
        assert_eq!(worst([1.0, 0.0]), [Some((0, 1.0)), Some((1, -1.0))]);
        assert_eq!(worst([-1.0, 0.0]), [Some((1, 1.0)), Some((0, -1.0))]);
    }

    #[test]
    fn the_buffers_hold_each_row_and_the_most_active_ones_and_a_trial() {
        let program = program(&mut seeded(4));
        let mut scratch = vec![0.0; program.scratch()];
        let Buffers { lambda, last, v, bound, r, factor } = program.cut(&mut scratch);
        // 23 rows; as many hard ones as moves can be active, and the 8 soft ones.
        assert_eq!([lambda.len(), last.len(), v.len()], [23; 3]);
        assert_eq!([bound.len(), r.len(), factor.len()], [17, 17, 17 * 17]);
    }

    #[test]
    fn the_operations_of_the_worst_case_are_counted() {
        // 12 changes, of which 5 add a row (17 + 8) and 7 exchange one (35 + 25 + 10); 42 for v, 28 a change to search.
        assert_eq!(operations(3, 7, 5), 5 * 25 + 7 * 70 + 42 + 12 * 28);
    }
}
