//! Least squares under signs: the smallest ½ x' H x - g' x where some x may not be negative.
//!
//! At the solution every constrained x is either free (positive, with gradient zero) or held at zero (gradient not
//! negative). Block principal pivoting guesses which, solves for the free ones, and moves all that break the rule to the
//! other side at once; where that circles, one at a time, which always ends.
//!
//! Reference: L. F. Portugal, J. J. Judice, L. N. Vicente, Math. Comp. 63, 625 (1994), DOI
//! 10.1090/S0025-5718-1994-1250776-4; J. Kim & H. Park, SIAM J. Sci. Comput. 33, 3261 (2011), DOI 10.1137/110821172.

use multiversion::multiversion;

/// Exchanges of whole blocks that may fail to reduce the number of broken rules before single ones are made.
const PATIENCE: usize = 3;

/// Minimises ½ x' H x - g' x for x_k >= 0 where `signed[k]`. `h` holds the symmetric n x n matrix row by row; `free` says
/// which x are guessed to be positive, and is left as found. `None` where H is not positive definite.
pub(crate) fn non_negative(h: &[f64], g: &[f64], signed: &[bool], free: &mut [bool]) -> Option<Vec<f64>> {
    let n = g.len();
    let scale = g.iter().fold(0.0f64, |m, g| m.max(g.abs()));
    for k in 0..n {
        free[k] |= !signed[k];
    }
    let (mut fewest, mut patience) = (n + 1, PATIENCE);
    loop {
        let active: Vec<usize> = (0..n).filter(|&k| free[k]).collect();
        let mut x = vec![0.0; n];
        for (&k, value) in active.iter().zip(solve(h, g, n, &active)?) {
            x[k] = value;
        }
        let size = x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let broken: Vec<usize> = (0..n)
            .filter(|&k| match free[k] {
                true => signed[k] && x[k] < -1e-12 * size,
                false => dot(&h[k * n..(k + 1) * n], &x) - g[k] < -1e-10 * scale,
            })
            .collect();
        match broken.last() {
            None => return Some(x),
            Some(&last) => {
                if broken.len() < fewest {
                    (fewest, patience) = (broken.len(), PATIENCE);
                } else if patience > 0 {
                    patience -= 1;
                } else {
                    free[last] = !free[last];
                    continue;
                }
                broken.iter().for_each(|&k| free[k] = !free[k]);
            }
        }
    }
}

/// Solves H x = g for the `active` rows and columns, by Cholesky's factorisation.
fn solve(h: &[f64], g: &[f64], n: usize, active: &[usize]) -> Option<Vec<f64>> {
    let m = active.len();
    let mut l = vec![0.0; m * m];
    for (i, &row) in active.iter().enumerate() {
        let (done, here) = l.split_at_mut(i * m);
        for (j, &column) in active[..i].iter().enumerate() {
            let upper = &done[j * m..j * m + j + 1];
            here[j] = (h[row * n + column] - dot(&here[..j], &upper[..j])) / upper[j];
        }
        let pivot = h[row * n + row] - dot(&here[..i], &here[..i]);
        if !(pivot > 1e-14 * h[row * n + row]) {
            return None;
        }
        here[i] = pivot.sqrt();
    }
    let mut x: Vec<f64> = active.iter().map(|&k| g[k]).collect();
    for i in 0..m {
        x[i] = (x[i] - dot(&l[i * m..i * m + i], &x[..i])) / l[i * m + i];
    }
    for i in (0..m).rev() {
        x[i] /= l[i * m + i];
        for j in 0..i {
            x[j] -= l[i * m + j] * x[i];
        }
    }
    Some(x)
}

/// The product, summed in sixteen strands whatever the instruction set.
#[multiversion(targets("x86_64+avx512f+avx512vl+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 16];
    let (whole, rest) = (a.chunks_exact(16), a.len() / 16 * 16);
    for (a, b) in whole.zip(b.chunks_exact(16)) {
        for k in 0..16 {
            sums[k] += a[k] * b[k];
        }
    }
    let tail: f64 = a[rest..].iter().zip(&b[rest..]).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + tail
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::assert_close;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_solution_keeps_the_rules_that_define_it(
            (n, numbers) in (1usize..24).prop_flat_map(|n| (Just(n), prop::collection::vec(-1.0f64..1.0, n * n + n)))
        ) {
            let (a, g) = numbers.split_at(n * n);
            let mut h: Vec<f64> = (0..n * n).map(|k| (0..n).map(|i| a[i * n + k / n] * a[i * n + k % n]).sum()).collect();
            (0..n).for_each(|k| h[k * n + k] += 0.1);
            let signed: Vec<bool> = (0..n).map(|k| k % 3 != 0).collect();
            let x = non_negative(&h, g, &signed, &mut vec![true; n]).unwrap();
            for k in 0..n {
                let gradient: f64 = (0..n).map(|j| h[k * n + j] * x[j]).sum::<f64>() - g[k];
                if signed[k] {
                    prop_assert!(x[k] >= -1e-12 && gradient >= -1e-9 && (x[k] * gradient).abs() < 1e-9);
                } else {
                    prop_assert!(gradient.abs() < 1e-9);
                }
            }
            let from_nothing = non_negative(&h, g, &signed, &mut vec![false; n]).unwrap();
            assert_close(&from_nothing, &x, 1e-9, 1e-9);
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_is_no_problem_to_solve() {
        assert_eq!(non_negative(&[1.0, 1.0, 1.0, 1.0], &[1.0, 2.0], &[false; 2], &mut [true; 2]), None);
    }
}
