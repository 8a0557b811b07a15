//! Low & Guo's hysteresis of a piezo bender.
//!
//! ```text
//! w = d u - h,    h' = alpha d u' - beta |u'| h - gamma u' |h|
//! ```
//! Divided by |u'| the law does not contain time. With H = h sign(u') and the path s = |change of u| it is linear on
//! either side of H = 0:
//! ```text
//! dH/ds = alpha d - (beta + gamma sign H) H
//! ```
//! Each piece is an exponential, so the law is integrated exactly for any division of the path into steps.
//!
//! Reference: T. S. Low, W. Guo, "Modeling of a three-layer piezoelectric bimorph beam with hysteresis", J. MEMS 4(4),
//! 230-237 (1995), DOI 10.1109/84.475550. The law neither wipes out nor closes minor loops, and is symmetric.
//!
//! State: voltage u [V], hysteresis h [m].

use super::spec::require;
use piezoid_numerics::error::{Error, positive};

/// Low & Guo's law. Bounded for beta > 0 and beta + gamma > 0.
#[derive(Debug, Clone)]
pub(super) struct BoucWenStage {
    /// Displacement per volt without hysteresis [m/V].
    d: f64,
    /// alpha d [m/V].
    alpha_d: f64,
    /// [1/V]
    beta: f64,
    /// [1/V]
    gamma: f64,
}

impl BoucWenStage {
    pub(super) const ORDER: usize = 2;

    /// The law with a steady loop between +-`range` [V] of height `2 displacement` [m], and of width `width` at 0 V,
    /// relative to the height.
    ///
    /// h is proportional to alpha d, so the loop for alpha d = 1 gives both parameters. With X at its end and `middle`
    /// at 0 V on the ascending branch: width = alpha middle / (range - alpha X) and displacement = d (range - alpha X).
    pub(crate) fn new(range: f64, displacement: f64, width: f64, beta: f64, gamma: f64) -> Result<Self, Error> {
        positive("hysteresis.range_v", range, "volts")?;
        positive("hysteresis.displacement_m", displacement, "metres")?;
        require((0.0..1.0).contains(&width), "hysteresis.width", width, "must be at least 0 and below 1")?;
        positive("hysteresis.beta_per_v", beta, "1/V")?;
        let rule = "must be a number above -beta_per_v, otherwise the hysteresis is unbounded";
        require(gamma.is_finite() && beta + gamma > 0.0, "hysteresis.gamma_per_v", gamma, rule)?;

        let unit = BoucWenStage { d: 0.0, alpha_d: 1.0, beta, gamma };
        let x = unit.steady(range);
        let middle = unit.climb(-x, range);
        let alpha = width * range / (middle + width * x);
        let d = displacement / (range - alpha * x);
        Ok(BoucWenStage { d, alpha_d: alpha * d, beta, gamma })
    }

    /// Moves to the voltage `u` and returns the static displacement w [m].
    pub(super) fn displacement(&self, x: &mut [f64], u: f64) -> f64 {
        let du = u - x[0];
        if du != 0.0 {
            let sign = du.signum();
            x[0] = u;
            x[1] = sign * self.climb(sign * x[1], du.abs());
        }
        self.d * u - x[1]
    }

    /// H after a path of `s` [V], exactly.
    fn climb(&self, h: f64, s: f64) -> f64 {
        if h >= 0.0 {
            return self.piece(h, self.beta + self.gamma, s);
        }
        let below = self.beta - self.gamma;
        let end = self.piece(h, below, s);
        if end <= 0.0 {
            return end;
        }
        // The path after which H changes its sign:
        let zero = -h / self.alpha_d * ratio(libm::log1p, -below * h / self.alpha_d);
        self.piece(0.0, self.beta + self.gamma, (s - zero).max(0.0))
    }

    /// H after a path of `s` along dH/ds = alpha d - rate H.
    fn piece(&self, h: f64, rate: f64, s: f64) -> f64 {
        h + (self.alpha_d - rate * h) * s * ratio(libm::expm1, -rate * s)
    }

    /// H at the end of the steady loop between +-`range`: the value that a path from -H reaches. This value falls as H
    /// rises, so bisection finds it.
    fn steady(&self, range: f64) -> f64 {
        let (mut low, mut high) = (0.0, 2.0 * range * self.alpha_d);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if self.climb(-middle, 2.0 * range) > middle { low = middle } else { high = middle }
        }
        low
    }
}

/// f(x) / x, for f(x) = x + O(x^2).
fn ratio(f: impl Fn(f64) -> f64, x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { f(x) / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    fn pl140() -> BoucWenStage {
        BoucWenStage::new(30.0, 1e-3, 0.13, 0.020, 0.005).unwrap()
    }

    /// Width at 0 V over height of the steady loop of amplitude `a` [V].
    fn width(law: &BoucWenStage, a: f64) -> f64 {
        let mut x = vec![0.0; BoucWenStage::ORDER];
        (0..400).for_each(|_| {
            law.displacement(&mut x, -a);
            law.displacement(&mut x, a);
        });
        let [top, descending, bottom, ascending] = [a, 0.0, -a, 0.0].map(|u| law.displacement(&mut x, u));
        (descending - ascending) / (top - bottom)
    }

    #[test]
    fn the_parameters_are_those_computed_with_numpy() {
        // Computed with numpy for 10, 13 and 15 % and 1000 um at 30 V.
        for (width, alpha, d) in [(0.10, 0.287, 43.8e-6), (0.13, 0.349, 46.9e-6), (0.15, 0.385, 49.0e-6)] {
            let law = BoucWenStage::new(30.0, 1e-3, width, 0.020, 0.005).unwrap();
            assert_close(&[law.alpha_d / law.d, law.d], &[alpha, d], 2e-3, 0.0);
        }
    }

    #[test]
    fn the_width_of_small_loops_is_that_of_numpy() {
        // Computed with numpy over a few cycles: at 10 V the third cycle is 5.1 % wide, the steady one 5.23 %.
        let widths = [1.0, 3.0, 10.0, 30.0].map(|a| width(&pl140(), a));
        assert_close(&widths, &[0.0053, 0.016, 0.051, 0.13], 0.03, 0.0);
        assert_close(&widths[3..], &[0.13], 1e-12, 0.0);
    }

    #[test]
    fn the_closed_form_is_the_differential_equation() {
        let law = pl140();
        // Also for gamma above beta.
        for law in [law.clone(), BoucWenStage { gamma: 0.05, ..law.clone() }, BoucWenStage { gamma: 0.02, ..law }] {
            let rate = |t: f64, h: f64| {
                let du = 30.0 * t.cos() * (1.0 + 0.5 * (0.3 * t).sin()) + 4.5 * t.sin() * (0.3 * t).cos();
                law.alpha_d * du - law.beta * du.abs() * h - law.gamma * du * h.abs()
            };
            let (mut x, mut h, mut worst) = (vec![0.0; BoucWenStage::ORDER], 0.0, 0.0_f64);
            let dt = 5e-4;
            for i in 0..40_000 {
                let t = f64::from(i) * dt;
                let k1 = rate(t, h);
                let k2 = rate(t + dt / 2.0, h + dt / 2.0 * k1);
                let k3 = rate(t + dt / 2.0, h + dt / 2.0 * k2);
                let k4 = rate(t + dt, h + dt * k3);
                h += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                let t = t + dt;
                law.displacement(&mut x, 30.0 * t.sin() * (1.0 + 0.5 * (0.3 * t).sin()));
                worst = worst.max((x[1] - h).abs());
            }
            assert!(worst < 1e-10, "off by {worst:e} m");
        }
    }

    #[test]
    fn the_division_of_a_path_does_not_matter() {
        let run = |pieces: u32| {
            let (law, mut x) = (pl140(), vec![0.0; BoucWenStage::ORDER]);
            for (from, to) in [(0.0, 30.0), (30.0, -20.0), (-20.0, 5.0), (5.0, -30.0)] {
                for i in 1..=pieces {
                    law.displacement(&mut x, from + (to - from) * f64::from(i) / f64::from(pieces));
                }
            }
            x[1]
        };
        assert_close(&[run(1000)], &[run(1)], 1e-12, 0.0);
    }

    #[test]
    fn without_width_it_is_a_line() {
        let law = BoucWenStage::new(30.0, 1e-3, 0.0, 0.020, 0.005).unwrap();
        assert_close(&[law.displacement(&mut [0.0; 2], 15.0)], &[0.5e-3], 1e-15, 0.0);
    }

    #[test]
    fn an_unbounded_law_is_an_error() {
        let message = BoucWenStage::new(30.0, 1e-3, 0.13, 0.02, -0.03).unwrap_err().to_string();
        assert!(message.starts_with("hysteresis.gamma_per_v = -0.03"), "{message}");
        assert!(BoucWenStage::new(30.0, 1e-3, f64::NAN, 0.02, 0.005).is_err());
    }
}
