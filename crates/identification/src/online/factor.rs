//! Weighted least squares, a row at a time, without square roots and without an inverse.
//!
//! ```text
//! H = U' D U,   U unit upper triangular, D diagonal
//! H <- keep H + x x' + n prior_i e_i e_i'         i runs from 1 to n, one an update
//! step = H^-1 (x e - n prior_i e_i away_i)        forward and backward substitution
//! ```
//! A row enters by Givens rotations without square roots (Gentleman 1973, DOI 10.1093/imamat/12.3.329). They add to D
//! and never subtract, so D stays positive in any precision. Forgetting scales D alone. The rows of the prior keep H
//! above `prior` times the memory in every direction, however poor the excitation: no gain grows without bound, as it
//! would with exponential forgetting alone (Ljung & Soderstrom 1983, "Theory and Practice of Recursive Identification",
//! MIT Press, section 5.6). If `pulls`, the prior is about the values of the start, and what the rows do not excite
//! returns to these; otherwise it only damps.
//!
//! It does not do: constraints; who uses a step bounds it.

use piezoid_models::program::Block;

/// An estimator of parameters in units in which its rows are about 1.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Factor {
    /// Name of its block.
    name: &'static str,
    /// Share of H that a sample keeps.
    keep: f64,
    /// D at the start.
    first: f64,
    /// Number of parameters times the prior of each.
    prior: Vec<f64>,
    /// True if what is not excited returns to the start.
    pulls: bool,
}

/// Its state, in the order of its block.
pub(super) struct FactorState<'x> {
    /// D.
    diagonal: &'x mut [f64],
    /// U above its diagonal, row by row.
    upper: &'x mut [f64],
    /// The next row; an update uses it up.
    pub(super) row: &'x mut [f64],
    /// The last step.
    pub(super) step: &'x mut [f64],
    /// The distance of the parameters from the start.
    pub(super) away: &'x mut [f64],
    /// The parameter whose prior comes next.
    turn: &'x mut f64,
}

/// Takes `n` numbers from the front of `x`.
pub(super) fn take<'x>(x: &mut &'x mut [f64], n: usize) -> &'x mut [f64] {
    let (front, rest) = std::mem::take(x).split_at_mut(n);
    *x = rest;
    front
}

impl Factor {
    /// `memory` [samples] is that of the forgetting; `prior` is per sample and parameter. The start counts as `first`
    /// memories.
    pub(super) fn new(name: &'static str, memory: f64, first: f64, prior: &[f64], pulls: bool) -> Self {
        let rows = prior.len() as f64;
        let prior = prior.iter().map(|prior| rows * prior).collect();
        Factor { name, keep: 1.0 - 1.0 / memory, first: first * memory, prior, pulls }
    }

    /// Number of parameters.
    pub(super) fn len(&self) -> usize {
        self.prior.len()
    }

    /// Name of its block.
    pub(super) fn name(&self) -> &'static str {
        self.name
    }

    fn pairs(&self) -> usize {
        self.len() * (self.len() - 1) / 2
    }

    /// Length of the state.
    pub(super) fn order(&self) -> usize {
        self.pairs() + 4 * self.len() + 1
    }

    /// The state at the start.
    pub(super) fn initial(&self) -> Vec<f64> {
        let mut x = vec![0.0; self.order()];
        x[..self.len()].fill(self.first);
        x
    }

    /// Takes its state from the front of `x`.
    pub(super) fn state<'x>(&self, x: &mut &'x mut [f64]) -> FactorState<'x> {
        let n = self.len();
        let [diagonal, upper, row] = [n, self.pairs(), n].map(|n| take(x, n));
        let [step, away, turn] = [n, n, 1].map(|n| take(x, n));
        FactorState { diagonal, upper, row, step, away, turn: &mut turn[0] }
    }

    /// Forgets, adds the row with the error `e`, and leaves the step.
    pub(super) fn update(&self, q: &mut FactorState, e: f64) {
        q.diagonal.iter_mut().for_each(|d| *d *= self.keep);
        q.step.iter_mut().zip(&*q.row).for_each(|(step, x)| *step = x * e);
        q.absorb(1.0);
        if self.pulls {
            let i = *q.turn as usize;
            q.step[i] -= self.prior[i] * q.away[i];
        }
        q.solve();
    }

    /// Adds the prior of one parameter.
    pub(super) fn recall(&self, q: &mut FactorState) {
        let i = *q.turn as usize;
        q.row.fill(0.0);
        q.row[i] = 1.0;
        q.absorb(self.prior[i]);
        *q.turn = if i + 1 < self.len() { *q.turn + 1.0 } else { 0.0 };
    }

    /// The same as a program: a block with functions `NAME_update(q: NAME, e)` and `NAME_recall(q: NAME)`.
    pub(super) fn block(&self, about: &str) -> Block {
        let n = self.len();
        let pull = if self.pulls { PULL } else { "" };
        let text = TEXT.replace("NAME", self.name).replace("    PULL\n", pull);
        Block::new(self.name, about)
            .numbers("diagonal", vec![self.first; n])
            .numbers("upper", vec![0.0; self.pairs()])
            .numbers("row", vec![0.0; n])
            .numbers("step", vec![0.0; n])
            .numbers("away", vec![0.0; n])
            .number("turn", 0.0)
            .constant("keep", self.keep)
            .table("prior", &self.prior)
            .count("n", n)
            .text(&text)
    }
}

impl FactorState<'_> {
    /// Rotates the row, with this weight, into the factor.
    fn absorb(&mut self, weight: f64) {
        let (n, mut w, mut at) = (self.row.len(), weight, 0);
        for i in 0..n {
            let x = self.row[i];
            let pairs = n - 1 - i;
            if x != 0.0 {
                let old = self.diagonal[i];
                let wx = w * x;
                let new = old + wx * x;
                let (c, s) = (old / new, wx / new);
                self.diagonal[i] = new;
                w *= c;
                for (v, upper) in self.row[i + 1..].iter_mut().zip(&mut self.upper[at..at + pairs]) {
                    let before = *v;
                    *v = before - x * *upper;
                    *upper = c * *upper + s * before;
                }
            }
            at += pairs;
        }
    }

    /// Replaces the gradient in `step` by the solution.
    fn solve(&mut self) {
        let (n, mut at) = (self.step.len(), 0);
        for i in 0..n {
            let f = self.step[i];
            for k in i + 1..n {
                self.step[k] -= self.upper[at] * f;
                at += 1;
            }
        }
        for i in (0..n).rev() {
            let mut f = self.step[i] / self.diagonal[i];
            for k in (i + 1..n).rev() {
                at -= 1;
                f -= self.upper[at] * self.step[k];
            }
            self.step[i] = f;
        }
    }
}

const PULL: &str = "    let i = whole(q.turn);
    q.step[i] -= prior[i] * q.away[i];
";

const TEXT: &str = "
// Rotates the row, with this weight, into the factor: Givens rotations without square roots.
fn NAME_absorb(q: NAME, weight) {
    let w = weight;
    let at = 0;
    for i in 0..n {
        let x = q.row[i];
        if x != 0.0 {
            let old = q.diagonal[i];
            let wx = w * x;
            let new = old + wx * x;
            let c = old / new;
            let s = wx / new;
            q.diagonal[i] = new;
            w = w * c;
            for k in i + 1..n {
                let before = q.row[k];
                q.row[k] = before - x * q.upper[at];
                q.upper[at] = c * q.upper[at] + s * before;
                at += 1;
            }
        } else {
            at += n - 1 - i;
        }
    }
}

// Adds the prior of one parameter.
fn NAME_recall(q: NAME) {
    let i = whole(q.turn);
    for k in 0..n { q.row[k] = 0.0; }
    q.row[i] = 1.0;
    NAME_absorb(q, prior[i]);
    if i + 1 < n { q.turn += 1.0; } else { q.turn = 0.0; }
}

// Forgets, adds the row with the error e, and solves for the step.
fn NAME_update(q: NAME, e) {
    for i in 0..n {
        q.diagonal[i] = q.diagonal[i] * keep;
        q.step[i] = q.row[i] * e;
    }
    NAME_absorb(q, 1.0);
    PULL
    let at = 0;
    for j in 0..n {
        let f = q.step[j];
        for k in j + 1..n {
            q.step[k] -= q.upper[at] * f;
            at += 1;
        }
    }
    for j in 0..n down {
        let f = q.step[j] / q.diagonal[j];
        for k in j + 1..n down {
            at -= 1;
            f -= q.upper[at] * q.step[k];
        }
        q.step[j] = f;
    }
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use piezoid_models::program::{Machine, Program};
    use piezoid_testing::assert_close;

    /// Rows of three parameters, the third hardly excited, with their errors.
    fn rows() -> Vec<([f64; 3], f64)> {
        let at = |t: f64| ([(0.3 * t).sin(), (0.7 * t + 1.0).cos(), 1e-3 * (0.1 * t).sin()], (1.3 * t).cos());
        (0..300).map(|t| at(f64::from(t))).collect()
    }

    fn factor(pulls: bool) -> Factor {
        Factor::new("fit", 40.0, 1.0, &[1e-3, 2e-3, 1e-4], pulls)
    }

    #[test]
    fn steps_solve_the_normal_equations_of_all_rows() {
        for pulls in [false, true] {
            let factor = factor(pulls);
            let mut all = factor.initial();
            let mut h = DMatrix::from_diagonal_element(3, 3, 40.0);
            for (t, (row, e)) in rows().into_iter().enumerate() {
                let mut q = factor.state(&mut &mut all[..]);
                q.row.copy_from_slice(&row);
                q.away.copy_from_slice(&[0.5, -0.25, 2.0]);
                factor.update(&mut q, e);
                factor.recall(&mut q);
                let x = DVector::from_row_slice(&row);
                h = &h * factor.keep + &x * x.transpose();
                let mut gradient = x * e;
                if pulls {
                    gradient[t % 3] -= factor.prior[t % 3] * q.away[t % 3];
                }
                let step = h.clone().cholesky().unwrap().solve(&gradient);
                assert_close(q.step, step.as_slice(), 1e-9, 1e-12);
                h[(t % 3, t % 3)] += factor.prior[t % 3];
            }
        }
    }

    #[test]
    fn the_program_is_bit_identical() {
        for pulls in [false, true] {
            let factor = factor(pulls);
            let text = "fn go(q: fit, a, b, c, e) {
                q.row[0] = a; q.row[1] = b; q.row[2] = c; q.away[1] = a;
                fit_update(q, e);
                fit_recall(q);
                return q.step[0];
            }";
            let program = Program::new(vec![factor.block("").text(text)]).unwrap();
            let mut machine = Machine::new(&program, "fit", false);
            let mut x = factor.initial();
            assert_eq!(machine.state(), x);
            for ([a, b, c], e) in rows() {
                machine.call("go", &[a, b, c, e]).unwrap();
                let mut q = factor.state(&mut &mut x[..]);
                q.row.copy_from_slice(&[a, b, c]);
                q.away[1] = a;
                factor.update(&mut q, e);
                factor.recall(&mut q);
                assert_eq!(machine.state(), x);
            }
        }
    }

    #[test]
    fn without_excitation_the_factor_stays_between_bounds() {
        let factor = factor(false);
        let mut x = factor.initial();
        for _ in 0..100_000 {
            let mut q = factor.state(&mut &mut x[..]);
            q.row.copy_from_slice(&[0.0, 1.0, 0.0]);
            factor.update(&mut q, 1.0);
            factor.recall(&mut q);
        }
        // The prior times the memory, and one passage of the three priors more or less.
        let q = factor.state(&mut &mut x[..]);
        assert!(
            (0.036..0.044).contains(&q.diagonal[0]) && (0.0036..0.0044).contains(&q.diagonal[2]),
            "{:?}",
            q.diagonal
        );
    }
}
