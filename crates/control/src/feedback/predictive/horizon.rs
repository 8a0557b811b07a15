//! The horizon as a quadratic program: response to the moves, their cost, and the limited rows.
//!
//! ```text
//! y = offset + free s + G phi z        free_i = C A^(d+i),  phi_ij = h_{d+i-j} / G
//! H = phi' phi + move_cost S' S        S z: the steps of z, the first from the last z
//! rows: z;  S z except its first;  phi z if displacements are limited (soft)
//! ```
//! Errors are divided by |G|, so that nothing depends on the unit of y.

use super::PredictiveSettings;
use super::condensed::Condensed;
use super::realisation::Realisation;
use nalgebra::{Cholesky, DMatrix, DVector, DVectorView, DVectorViewMut};
use piezoid_numerics::error::Error;

/// Cost of a squared displacement beyond its limit, relative to a squared error.
const STIFFNESS: f64 = 1e3;

/// The matrices.
#[derive(Debug, Clone)]
pub(super) struct Horizon {
    /// C A^(d+i), and h over |G|.
    free: DMatrix<f64>,
    pub(super) phi: DMatrix<f64>,
    /// From the errors of the free response, and from the last z, to the optimal moves without limits.
    from_errors: DMatrix<f64>,
    from_last: DVector<f64>,
    /// |G| [output unit / z's unit].
    pub(super) gain: f64,
    pub(super) program: Condensed,
}

impl Horizon {
    /// The matrices for a plant with gain G.
    ///
    /// # Errors
    /// Returns an error if `move_cost` is too small for rounding.
    pub(super) fn new(plant: &Realisation, gain: f64, settings: &PredictiveSettings) -> Result<Self, Error> {
        let n = settings.horizon;
        let h = plant.impulse(plant.delay + n);
        let h = &h[plant.delay..];
        let phi = DMatrix::from_fn(n, n, |i, j| if i >= j { h[i - j] / gain } else { 0.0 });

        let steps = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - f64::from(u8::from(i == j + 1)));
        let curvature = phi.transpose() * &phi + settings.move_cost * steps.transpose() * &steps;
        let stiff =
            || Error::parameter("move_cost", settings.move_cost, "is too small for a unique solution: increase it");
        let factor = Cholesky::new(curvature.clone()).ok_or_else(stiff)?;
        let mut rows = DMatrix::zeros(settings.rows(n), n);
        rows.rows_mut(0, n).fill_with_identity();
        rows.rows_mut(n, n - 1).copy_from(&steps.rows(1, n - 1));
        let mut sigma = vec![f64::INFINITY; 2 * n - 1];
        if settings.displacement.is_some() {
            rows.rows_mut(2 * n - 1, n).copy_from(&phi);
            sigma.resize(3 * n - 1, STIFFNESS);
        }
        Ok(Horizon {
            free: plant.free(n),
            from_errors: factor.solve(&phi.transpose()) / gain,
            from_last: factor.solve(&DVector::from_fn(n, |i, _| if i == 0 { settings.move_cost } else { 0.0 })),
            program: Condensed::new(curvature, rows, sigma).ok_or_else(stiff)?,
            phi,
            gain,
        })
    }

    /// y over the horizon, without offset, for z = 0 [output unit].
    pub(super) fn free(&self, s: &[f64], y: &mut [f64]) {
        let n = y.len();
        DVectorViewMut::from_slice(y, n).gemv(1.0, &self.free, &DVectorView::from_slice(s, s.len()), 0.0);
    }

    /// The optimal moves without limits, for these errors of the free response [output unit].
    pub(super) fn without_limits(&self, errors: &[f64], last: f64, z: &mut [f64]) {
        let n = z.len();
        let mut z = DVectorViewMut::from_slice(z, n);
        z.gemv(1.0, &self.from_errors, &DVectorView::from_slice(errors, n), 0.0);
        z.axpy(last, &self.from_last, 1.0);
    }

    /// y over the horizon, without offset, for the moves `z` [output unit].
    pub(super) fn response(&self, s: &[f64], z: &[f64]) -> DVector<f64> {
        let (s, z) = (DVectorView::from_slice(s, s.len()), DVectorView::from_slice(z, z.len()));
        &self.free * s + self.gain * (&self.phi * z)
    }
}
