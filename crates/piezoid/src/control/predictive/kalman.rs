//! The steady-state Kalman observer, of readings that come d samples late.
//!
//! ```text
//! s^+ = A s^ + B z + L (y - y^),    y^ = C s^ + D z        L = A P C' / (C P C' + R)
//! P   = A P A' - L C P A' + Q
//! late: e = y_t-d - y^_t-d,    s^+ = A s^ + B z + A^d L e,    y^_t-d+j += C A^(j-1) L e    j = 1, ..., d
//! ```
//! A late reading corrects the state of its instant, and the model carries the correction on: to s^ by A^d, and to what was
//! predicted of the readings that have not come yet. This is the observer of the system with d delays of its output. P is found by doubling: each round stands for twice as many steps of the Riccati equation as the one before.
//!
//! Reference: E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, Int. J. Control 77, 767 (2004), DOI
//! 10.1080/00207170410001714988. It does not do: gains that vary in time.

use crate::error::Error;
use nalgebra::{DMatrix, DVector, RowDVector};

/// What an innovation corrects.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Observer {
    /// A^d L, of s.
    pub(super) state: DVector<f64>,
    /// C L, ..., C A^(d-1) L, of the readings that have not come yet, the oldest first.
    pub(super) unread: Vec<f64>,
}

impl Observer {
    /// Of readings in time by the gain `l`, brought forward by `late` samples.
    pub(super) fn new(a: &DMatrix<f64>, c: &RowDVector<f64>, l: DVector<f64>, late: usize) -> Self {
        let mut state = l;
        let carried = |_| {
            let unread = (c * &state)[0];
            state = a * &state;
            unread
        };
        let unread = (0..late).map(carried).collect();
        Observer { state, unread }
    }
}

/// Rounds at most: 2^60 samples.
const ROUNDS: usize = 60;

/// L, for the covariance `q` of what disturbs s in one sample and the variance `r` of a reading.
///
/// # Errors
/// [`Error::Unidentifiable`] where P does not settle: the readings cannot tell a state that drifts.
pub(super) fn gain(a: &DMatrix<f64>, c: &RowDVector<f64>, q: &DMatrix<f64>, r: f64) -> Result<DVector<f64>, Error> {
    let n = a.nrows();
    let untold = || Error::Unidentifiable {
        what: "the state of the model".into(),
        because: "its readings cannot tell a constant disturbance apart: a gain of 0, or a pole at 1, at 0 Hz".into(),
    };
    let (mut f, mut g, mut p) = (a.transpose(), c.transpose() * c / r, q.clone());
    for _ in 0..ROUNDS {
        let inverse = (DMatrix::identity(n, n) + &g * &p).try_inverse().ok_or_else(untold)?;
        let grown = f.transpose() * &p * &inverse * &f;
        g += &f * &inverse * &g * f.transpose();
        f = &f * inverse * &f;
        p += &grown;
        p = 0.5 * (&p + p.transpose());
        if !p.iter().all(|v| v.is_finite()) {
            break;
        }
        if grown.amax() <= 1e-14 * p.amax() {
            let seen = &p * c.transpose();
            return Ok(a * &seen / ((c * &seen)[0] + r));
        }
    }
    Err(untold())
}

#[cfg(test)]
mod tests {
    use super::super::realisation::{Realisation, tests::blocks};
    use super::*;
    use crate::testing::assert_close;

    #[test]
    fn the_gain_is_where_a_kalman_filter_in_full_comes_to() {
        let (creep, linear) = blocks(1);
        let model = Realisation::new(&creep, &linear);
        let (n, r) = (model.order(), 0.3);
        let mut q = &model.b * model.b.transpose() * 1e-2;
        q[(n - 1, n - 1)] += 1e-3;
        // Sample by sample, with a covariance in Joseph's form.
        let mut p = DMatrix::<f64>::identity(n, n);
        let mut k = DVector::<f64>::zeros(n);
        for _ in 0..40_000 {
            let seen: DVector<f64> = &p * model.c.transpose();
            k = &seen / (model.c.transpose().dot(&seen) + r);
            let left = DMatrix::identity(n, n) - &k * &model.c;
            let after = &left * &p * left.transpose() + r * &k * k.transpose();
            p = &model.a * after * model.a.transpose() + &q;
        }
        let known = &model.a * k;
        assert_close(gain(&model.a, &model.c, &q, r).unwrap().as_slice(), known.as_slice(), 1e-7, 1e-10);
    }

    #[test]
    fn late_readings_are_filtered_as_by_the_kalman_gain_of_a_system_with_a_delay_line() {
        let (creep, linear) = blocks(1);
        let model = Realisation::new(&creep, &linear);
        let (n, late, r) = (model.order(), 3, 0.3);
        let mut q = &model.b * model.b.transpose() * 1e-2;
        q[(n - 1, n - 1)] += 1e-3;
        let observer = Observer::new(&model.a, &model.c, gain(&model.a, &model.c, &q, r).unwrap(), late);
        // Behind s the outputs, the oldest first, which is what is read.
        let (mut a, mut noise) = (DMatrix::zeros(n + late, n + late), DMatrix::zeros(n + late, n + late));
        a.view_mut((0, 0), (n, n)).copy_from(&model.a);
        (0..late - 1).for_each(|k| a[(n + k, n + k + 1)] = 1.0);
        a.view_mut((n + late - 1, 0), (1, n)).copy_from(&model.c);
        noise.view_mut((0, 0), (n, n)).copy_from(&q);
        let c = RowDVector::from_fn(n + late, |_, k| f64::from(u8::from(k == n)));
        let known = gain(&a, &c, &noise, r).unwrap();
        let found = [observer.state.as_slice(), &observer.unread].concat();
        assert_close(&found, known.as_slice(), 1e-6, 1e-9);
    }

    #[test]
    fn a_random_walk_has_the_golden_gain() {
        let one = DMatrix::identity(1, 1);
        let known = (5f64.sqrt() - 1.0) / 2.0;
        assert_close(
            gain(&one, &RowDVector::from_element(1, 1.0), &one, 1.0).unwrap().as_slice(),
            &[known],
            1e-12,
            0.0,
        );
    }

    #[test]
    fn a_drift_that_leaves_no_trace_is_refused() {
        let (a, c) = (DMatrix::identity(2, 2), RowDVector::from_vec(vec![1.0, 0.0]));
        assert!(gain(&a, &c, &DMatrix::identity(2, 2), 1.0).unwrap_err().to_string().contains("cannot tell"));
    }
}
