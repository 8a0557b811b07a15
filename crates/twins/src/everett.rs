//! The Everett function of an exponential density of relays.
//!
//! A relay switches up at v + r and down at v - r, with mean v and half-width r. The density of relays is proportional
//! to exp(-r / rho) (1 + c v / U). The relays that switch when the input falls from a to b (or rises from b to a) add
//! up to
//! ```text
//! E(a, b) = K (1 + c m / U) J1(R),    R = (a - b) / 2,   m = (a + b) / 2
//! J1(R) = int_0^R (R - r)   exp(-r / rho) dr = rho R - rho^2 (1 - exp(-R / rho))
//! J2(R) = int_0^R (R - r)^2 exp(-r / rho) dr = rho R^2 - 2 rho J1(R)
//! ```
//! and on the first excursion from the demagnetised state, in which every relay with v < 0 is up, to
//! ```text
//! up to M:  +K/2 (J1(M) + c/(2U) J2(M)),     down to -M:  -K/2 (J1(M) - c/(2U) J2(M))
//! ```
//! Reference: I. D. Mayergoyz, "Mathematical models of hysteresis", Phys. Rev. Lett. 56, 1518 (1986),
//! DOI 10.1103/PhysRevLett.56.1518; D. H. Everett, Trans. Faraday Soc. 51, 1551 (1955), DOI 10.1039/TF9555101551.

use libm::expm1;
/// The density: strength K [m/V^2], spread rho [V], and asymmetry c / U [1/V].
#[derive(Debug, Clone)]
pub(super) struct ExponentialEverett {
    pub(super) k: f64,
    pub(super) rho: f64,
    pub(super) lean: f64,
}

impl ExponentialEverett {
    /// Displacement from the reversal at `from` to `to` [m]: positive if rising.
    #[inline]
    pub(super) fn branch(&self, from: f64, to: f64) -> f64 {
        let e = self.k * (1.0 + self.lean * 0.5 * (from + to)) * self.j1(0.5 * (to - from).abs());
        if to > from { e } else { -e }
    }

    /// Displacement at `v` on the virgin curve [m].
    pub(super) fn virgin(&self, v: f64) -> f64 {
        let m = v.abs();
        0.5 * self.k * (self.j1(m).copysign(v) + 0.5 * self.lean * self.j2(m))
    }

    /// J1 [V^2].
    pub(super) fn j1(&self, r: f64) -> f64 {
        self.rho * self.rho * remainder(r / self.rho, 1)
    }

    /// J2 [V^3].
    fn j2(&self, r: f64) -> f64 {
        2.0 * self.rho.powi(3) * remainder(r / self.rho, 2)
    }
}

/// x^(n+1)/(n+1)! - x^(n+2)/(n+2)! + .... For n = 1 this is exp(-x) - 1 + x, for n = 2 it is x^2/2 minus that. Below
/// 1/2 the series is used, to avoid cancellation in the closed form.
fn remainder(x: f64, n: u32) -> f64 {
    if x >= 0.5 {
        let first = expm1(-x) + x;
        return if n == 1 { first } else { 0.5 * x * x - first };
    }
    let lead = if n == 1 { 0.5 * x * x } else { x * x * x / 6.0 };
    // 1 - x/(n+2) (1 - x/(n+3) (1 - ...)): twelve terms have an error of 1e-17.
    lead * (1..=12).rev().fold(1.0, |sum, i| 1.0 - x / f64::from(n + 1 + i) * sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn series_and_closed_form_agree_at_their_boundary() {
        for n in [1, 2] {
            assert_close(&[remainder(0.5 - 1e-12, n)], &[remainder(0.5, n)], 1e-11, 0.0);
        }
        assert_close(&[remainder(1e-9, 1), remainder(1e-9, 2)], &[0.5e-18, 1e-27 / 6.0], 1e-9, 0.0);
    }

    #[test]
    fn the_integrals_are_those_of_quadrature() {
        let everett = ExponentialEverett { k: 1.0, rho: 20.0, lean: 0.01 };
        for reach in [3.0, 30.0] {
            let n = 20_000;
            let integral = |power: i32| -> f64 {
                let dr = reach / f64::from(n);
                let r = |i: i32| (f64::from(i) + 0.5) * dr;
                (0..n).map(r).map(|r| (reach - r).powi(power) * (-r / 20.0).exp() * dr).sum()
            };
            assert_close(&[everett.j1(reach), everett.j2(reach)], &[integral(1), integral(2)], 1e-7, 0.0);
        }
    }

    #[test]
    fn the_virgin_curve_meets_the_branch_to_its_mirror_point() {
        let everett = ExponentialEverett { k: 2e-6, rho: 20.0, lean: 0.01 };
        let there_and_back = everett.virgin(12.0) + everett.branch(12.0, -12.0);
        assert_close(&[there_and_back], &[everett.virgin(-12.0)], 1e-12, 0.0);
    }
}
