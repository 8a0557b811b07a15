//! Least squares with sign constraints: minimises ½ x' H x - g' x where some x must not be negative.
//!
//! At the solution every constrained x is either free (positive, gradient zero) or fixed at zero (gradient not
//! negative). Block principal pivoting starts from a guess, solves for the free x, and exchanges all x that violate
//! their condition; usually a few iterations are enough. If it cycles, an active-set method (Lawson & Hanson) continues
//! from the best guess: it frees one x at a time, and its step ends where another x would become negative. Every
//! iteration decreases the sum; the number of iterations is limited to the number of x.
//!
//! Reference: L. F. Portugal, J. J. Judice, L. N. Vicente, Math. Comp. 63, 625 (1994), DOI
//! 10.1090/S0025-5718-1994-1250776-4; C. L. Lawson, R. J. Hanson, Solving Least Squares Problems (1974), DOI
//! 10.1137/1.9781611971217.

use super::cholesky::{MIN_PIVOT, cholesky};
use crate::series::dot_wide;
use nalgebra::{DMatrix, DVector};

/// Maximum number of block exchanges in a row that do not reduce the number of violations.
const PATIENCE: usize = 4;

/// Least number of free x for each that is exchanged, from which the factor is updated.
const MIN_X_PER_UPDATE: usize = 20;

/// Rounding tolerance below zero: of x relative to the largest x, and of the gradient relative to the largest g.
const TINY: f64 = 1e-11;
const LEVEL: f64 = 1e-9;

/// Minimises ½ x' H x - g' x for x_k >= 0 where `signed[k]`. H is symmetric. `free` is the guess which x are positive;
/// on return, it is the result. `None` if H is not positive definite.
pub fn non_negative(h: &DMatrix<f64>, g: &DVector<f64>, signed: &[bool], free: &mut [bool]) -> Option<DVector<f64>> {
    let n = g.len();
    (0..n).for_each(|k| free[k] |= !signed[k]);
    let (mut fewest, mut patience) = (n + 1, PATIENCE);
    let mut best = free.to_vec();
    let mut factor = FreeFactor::of(h, free)?;
    while patience > 0 {
        let mut x = factor.solve(g);
        let (smallest, gradient) = (-TINY * x.amax(), h * &x - g);
        let is_broken = |&k: &usize| match free[k] {
            true => signed[k] && x[k] < smallest,
            false => gradient[k] < -LEVEL * g.amax(),
        };
        let broken: Vec<usize> = (0..n).filter(is_broken).collect();
        if broken.is_empty() {
            (0..n).filter(|&k| signed[k]).for_each(|k| x[k] = x[k].max(0.0));
            return Some(x);
        }
        if broken.len() < fewest {
            (fewest, patience, best) = (broken.len(), PATIENCE, free.to_vec());
        } else {
            patience -= 1;
        }
        broken.iter().for_each(|&k| free[k] = !free[k]);
        if broken.len() > factor.free.len() / MIN_X_PER_UPDATE {
            factor = FreeFactor::of(h, free)?;
            continue;
        }
        for k in broken {
            match free[k] {
                true => factor.add(h, k)?,
                false => factor.remove(k),
            }
        }
    }
    free.copy_from_slice(&best);
    downhill(h, g, signed, free)
}

/// The active-set method, from the solution for the `free` x with negative values set to zero.
fn downhill(h: &DMatrix<f64>, g: &DVector<f64>, signed: &[bool], free: &mut [bool]) -> Option<DVector<f64>> {
    let n = g.len();
    let mut x = solve(h, g, free)?;
    for k in (0..n).filter(|&k| signed[k]) {
        free[k] &= x[k] > 0.0;
        x[k] = x[k].max(0.0);
    }
    let mut factor = FreeFactor::of(h, free)?;
    for _ in 0..n {
        // A step to the solution for the free x, or up to the first that would become negative.
        loop {
            let goal = factor.solve(g);
            let negative = factor.free.iter().copied().filter(|&k| signed[k] && goal[k] < 0.0);
            let reach = |k: usize| x[k] / (x[k] - goal[k]);
            let first = negative.min_by(|&j, &k| reach(j).total_cmp(&reach(k)).then(j.cmp(&k)));
            let step = first.map_or(1.0, reach);
            (0..n).for_each(|k| x[k] += step * (goal[k] - x[k]));
            let Some(first) = first else { break };
            (free[first], x[first]) = (false, 0.0);
            factor.remove(first);
        }
        let gradient = h * &x - g;
        let steepest = (0..n).filter(|&k| !free[k]).min_by(|&j, &k| gradient[j].total_cmp(&gradient[k]));
        match steepest.filter(|&k| gradient[k] < -LEVEL * g.amax()) {
            Some(k) => {
                free[k] = true;
                factor.add(h, k)?;
            }
            None => break,
        }
    }
    Some(x)
}

/// Solves H x = g for the `free` x; the others are 0.
fn solve(h: &DMatrix<f64>, g: &DVector<f64>, free: &[bool]) -> Option<DVector<f64>> {
    Some(FreeFactor::of(h, free)?.solve(g))
}

/// The Cholesky factor of the equations of the free x. Where one x enters or leaves, it is updated, which takes n^2
/// operations in place of n^3.
struct FreeFactor {
    /// The free x, in the order of the rows.
    free: Vec<usize>,
    /// The rows of L, each up to its diagonal.
    rows: Vec<Vec<f64>>,
}

impl FreeFactor {
    fn of(h: &DMatrix<f64>, free: &[bool]) -> Option<Self> {
        let free: Vec<usize> = (0..free.len()).filter(|&k| free[k]).collect();
        let m = free.len();
        let l = cholesky(DMatrix::from_fn(m, m, |i, j| h[(free[i], free[j])]))?;
        let rows = (0..m).map(|i| (0..=i).map(|j| l[(i, j)]).collect()).collect();
        Some(FreeFactor { free, rows })
    }

    /// Solves H x = g for the free x; the others are 0.
    fn solve(&self, g: &DVector<f64>) -> DVector<f64> {
        let mut x = self.forward(|i| g[self.free[i]]);
        for (i, row) in self.rows.iter().enumerate().rev() {
            x[i] /= row[i];
            let (rest, last) = x.split_at_mut(i);
            rest.iter_mut().zip(row).for_each(|(x, l)| *x -= l * last[0]);
        }
        let mut all = DVector::zeros(g.len());
        self.free.iter().zip(&x).for_each(|(&k, x)| all[k] = *x);
        all
    }

    /// Solves L x = b.
    fn forward(&self, b: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut x: Vec<f64> = Vec::with_capacity(self.rows.len());
        for (i, row) in self.rows.iter().enumerate() {
            x.push((b(i) - dot_wide::<8>(&row[..i], &x)) / row[i]);
        }
        x
    }

    /// Frees x_k; `None` if H is not positive definite.
    fn add(&mut self, h: &DMatrix<f64>, k: usize) -> Option<()> {
        let mut row = self.forward(|i| h[(self.free[i], k)]);
        let pivot = h[(k, k)] - row.iter().map(|l| l * l).sum::<f64>();
        row.push((pivot > MIN_PIVOT * h[(k, k)]).then(|| pivot.sqrt())?);
        self.rows.push(row);
        self.free.push(k);
        Some(())
    }

    /// Fixes x_k. The column l of L that leaves is added to the rest: L L' + l l'.
    fn remove(&mut self, k: usize) {
        let Some(at) = self.free.iter().position(|&free| free == k) else { return };
        self.free.remove(at);
        self.rows.remove(at);
        let mut l: Vec<f64> = self.rows[at..].iter_mut().map(|row| row.remove(at)).collect();
        for j in at..self.rows.len() {
            let (pivot, off) = (self.rows[j][j], l[j - at]);
            let root = (pivot * pivot + off * off).sqrt();
            let (cosine, sine) = (root / pivot, off / pivot);
            self.rows[j][j] = root;
            for (row, l) in self.rows[j + 1..].iter_mut().zip(&mut l[j + 1 - at..]) {
                row[j] = (row[j] + sine * *l) / cosine;
                *l = cosine * *l - sine * row[j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_solution_satisfies_the_optimality_conditions(
            (n, numbers) in (1usize..40).prop_flat_map(|n| (Just(n), prop::collection::vec(-1.0f64..1.0, n * n + n)))
        ) {
            let (a, g) = numbers.split_at(n * n);
            let (a, g) = (DMatrix::from_column_slice(n, n, a), DVector::from_column_slice(g));
            let h = a.tr_mul(&a) + 0.1 * DMatrix::identity(n, n);
            let signed: Vec<bool> = (0..n).map(|k| k % 3 != 0).collect();
            let x = non_negative(&h, &g, &signed, &mut vec![true; n]).unwrap();
            for k in 0..n {
                let gradient = h.column(k).dot(&x) - g[k];
                if signed[k] {
                    prop_assert!(x[k] >= -1e-12 && gradient >= -1e-9 && (x[k] * gradient).abs() < 1e-9);
                } else {
                    prop_assert!(gradient.abs() < 1e-9);
                }
            }
            let from_nothing = non_negative(&h, &g, &signed, &mut vec![false; n]).unwrap();
            assert_close(from_nothing.as_slice(), x.as_slice(), 1e-9, 1e-8);
            let mut some: Vec<bool> = (0..n).map(|k| k % 2 == 0 || !signed[k]).collect();
            assert_close(downhill(&h, &g, &signed, &mut some).unwrap().as_slice(), x.as_slice(), 1e-9, 1e-8);
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_has_no_solution() {
        let (h, g) = (DMatrix::repeat(2, 2, 1.0), DVector::from_vec(vec![1.0, 2.0]));
        assert_eq!(non_negative(&h, &g, &[false; 2], &mut [true; 2]), None);
    }
}
