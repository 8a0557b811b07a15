//! The steady-state Kalman observer for measurements with a sensor delay of d samples.
//!
//! ```text
//! s^+ = A s^ + B z + L (y - y^),    y^ = C s^ + D z        L = A P C' / (C P C' + R)
//! P   = A P A' - L C P A' + Q
//! delay: e = y_t-d - y^_t-d,   s^+ = A s^ + B z + A^d L e,    y^_t-d+j += C A^(j-1) L e    j = 1, ..., d
//! ```
//! A delayed measurement corrects the state of its instant. The model propagates the correction: to s^ by A^d, and to
//! the predicted measurements that have not arrived. This is the observer of a system with d delays of its output. P is
//! computed by doubling: each round covers twice as many steps of the Riccati equation as the one before.
//!
//! Reference: E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, Int. J. Control 77, 767 (2004), DOI
//! 10.1080/00207170410001714988. It does not do: time-varying gains.

use nalgebra::{DMatrix, DVector, RowDVector};
use piezoid_numerics::error::Error;

/// The gains of an innovation.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Observer {
    /// A^d L, on s.
    pub(super) state: DVector<f64>,
    /// C L, ..., C A^(d-1) L, on the measurements that have not arrived, the oldest first.
    pub(super) unread: Vec<f64>,
}

impl Observer {
    /// From the gain `l` without delay, propagated by `delay_samples` samples.
    pub(super) fn new(a: &DMatrix<f64>, c: &RowDVector<f64>, l: DVector<f64>, delay_samples: usize) -> Self {
        let mut state = l;
        let carried = |_| {
            let unread = (c * &state)[0];
            state = a * &state;
            unread
        };
        let unread = (0..delay_samples).map(carried).collect();
        Observer { state, unread }
    }
}

/// Largest number of rounds: 2^60 samples.
const ROUNDS: usize = 60;

/// L, for the process noise covariance `q` per sample and the variance `r` of a measurement.
///
/// # Errors
/// [`Error::Unidentifiable`] if P does not converge: a drift of the state is not observable.
pub(super) fn gain(a: &DMatrix<f64>, c: &RowDVector<f64>, q: &DMatrix<f64>, r: f64) -> Result<DVector<f64>, Error> {
    let n = a.nrows();
    let unobservable = || Error::Unidentifiable {
        what: "the state of the model".into(),
        because: "a constant disturbance is not observable: the gain is 0, or there is a pole at z = 1".into(),
    };
    let (mut f, mut g, mut p) = (a.transpose(), c.transpose() * c / r, q.clone());
    for _ in 0..ROUNDS {
        let inverse = (DMatrix::identity(n, n) + &g * &p).try_inverse().ok_or_else(unobservable)?;
        let grown = f.transpose() * &p * &inverse * &f;
        g += &f * &inverse * &g * f.transpose();
        f = &f * inverse * &f;
        p += &grown;
        p = 0.5 * (&p + p.transpose());
        if !p.iter().all(|v| v.is_finite()) {
            break;
        }
        if grown.amax() <= 1e-14 * p.amax() {
            let observed = &p * c.transpose();
            return Ok(a * &observed / ((c * &observed)[0] + r));
        }
    }
    Err(unobservable())
}

#[cfg(test)]
mod tests {
    use super::super::realisation::{Realisation, tests::blocks};
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_gain_is_the_limit_of_a_full_kalman_filter() {
        let (creep, linear) = blocks(1);
        let model = Realisation::new(&creep, &linear);
        let (n, r) = (model.order(), 0.3);
        let mut q = &model.b * model.b.transpose() * 1e-2;
        q[(n - 1, n - 1)] += 1e-3;
        // Sample by sample, with the covariance in Joseph's form.
        let mut p = DMatrix::<f64>::identity(n, n);
        let mut k = DVector::<f64>::zeros(n);
        for _ in 0..40_000 {
            let observed: DVector<f64> = &p * model.c.transpose();
            k = &observed / (model.c.transpose().dot(&observed) + r);
            let left = DMatrix::identity(n, n) - &k * &model.c;
            let after = &left * &p * left.transpose() + r * &k * k.transpose();
            p = &model.a * after * model.a.transpose() + &q;
        }
        let known = &model.a * k;
        assert_close(gain(&model.a, &model.c, &q, r).unwrap().as_slice(), known.as_slice(), 1e-7, 1e-10);
    }

    #[test]
    fn a_sensor_delay_gives_the_kalman_gain_of_a_system_with_a_delay_line() {
        let (creep, linear) = blocks(1);
        let model = Realisation::new(&creep, &linear);
        let (n, delay_samples, r) = (model.order(), 3, 0.3);
        let mut q = &model.b * model.b.transpose() * 1e-2;
        q[(n - 1, n - 1)] += 1e-3;
        let observer = Observer::new(&model.a, &model.c, gain(&model.a, &model.c, &q, r).unwrap(), delay_samples);
        // The delayed outputs follow s, the oldest first, which is measured.
        let (mut a, mut noise) = (
            DMatrix::zeros(n + delay_samples, n + delay_samples),
            DMatrix::zeros(n + delay_samples, n + delay_samples),
        );
        a.view_mut((0, 0), (n, n)).copy_from(&model.a);
        (0..delay_samples - 1).for_each(|k| a[(n + k, n + k + 1)] = 1.0);
        a.view_mut((n + delay_samples - 1, 0), (1, n)).copy_from(&model.c);
        noise.view_mut((0, 0), (n, n)).copy_from(&q);
        let c = RowDVector::from_fn(n + delay_samples, |_, k| f64::from(u8::from(k == n)));
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
    fn a_drift_that_is_not_observable_is_an_error() {
        let (a, c) = (DMatrix::identity(2, 2), RowDVector::from_vec(vec![1.0, 0.0]));
        assert!(gain(&a, &c, &DMatrix::identity(2, 2), 1.0).unwrap_err().to_string().contains("not observable"));
    }

    #[test]
    fn only_the_ratio_of_the_covariances_counts() {
        let (creep, linear) = blocks(1);
        let model = Realisation::new(&creep, &linear);
        let p = model.order() - 1;
        let mut q = &model.b * model.b.transpose() * 1e-2;
        q[(p, p)] += 1e-3;
        let of = |scale: f64| gain(&model.a, &model.c, &(&q * scale), 0.3 * scale).unwrap();
        for scale in [2f64.powi(-60), 2f64.powi(60)] {
            assert_close(of(scale).as_slice(), of(1.0).as_slice(), 1e-12, 0.0);
        }
    }
}
