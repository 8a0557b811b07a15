//! The two-sided quantiles of Student's t-distribution, the coverage factors of the GUM:
//!
//! ```text
//! P(|T| <= k) = 1 - I_x(nu / 2, 1 / 2),   x = nu / (nu + k^2)
//! ```
//! with the regularised incomplete beta function I, a continued fraction (Abramowitz & Stegun 26.7.1 and 26.5.8). From
//! 1e5 degrees of freedom on, the quantile is that of the normal distribution with the first correction in 1 / nu
//! (26.7.5). The degrees of freedom need not be whole.
//!
//! Reference: Abramowitz & Stegun 1964, Handbook of Mathematical Functions; JCGM 100:2008 (GUM), annex G.3.

use libm::{erfc, exp, lgamma, log, log1p};

/// Degrees of freedom from which the distribution is normal but for a correction.
const MANY: f64 = 1e5;

/// Number of bisections of the interval of a quantile: to the last digit.
const BISECTIONS: usize = 200;

/// The factor k within which a share `coverage` (between 0 and 1) of Student's t-distribution with `nu` degrees of
/// freedom (above 0, perhaps infinite) lies.
///
/// ```
/// use piezoid_numerics::student::coverage_factor;
/// let table = [(1.0, 13.97), (10.0, 2.28), (f64::INFINITY, 2.0)];
/// for (nu, k) in table {
///     assert!((coverage_factor(0.9545, nu) - k).abs() < 0.005, "table G.2 of the GUM");
/// }
/// ```
pub fn coverage_factor(coverage: f64, nu: f64) -> f64 {
    let left = 1.0 - coverage;
    if nu >= MANY {
        let z = solved(left, |z| erfc(z / std::f64::consts::SQRT_2));
        return z + z * (z * z + 1.0) / (4.0 * nu);
    }
    solved(left, |k| outside(k, nu))
}

/// The place from 0 on at which a falling function has this value.
fn solved(value: f64, falling: impl Fn(f64) -> f64) -> f64 {
    let mut high = 1.0;
    while falling(high) > value && high < f64::MAX / 4.0 {
        high *= 2.0;
    }
    let mut low = 0.0;
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if falling(middle) > value { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// P(|T| > k).
fn outside(k: f64, nu: f64) -> f64 {
    let (a, b) = (0.5 * nu, 0.5);
    // Both x and 1 - x without cancellation, by the smaller of k^2 and nu.
    let ratio = k * k / nu;
    let (x, rest) = if ratio.is_finite() { (1.0 / (1.0 + ratio), ratio / (1.0 + ratio)) } else { (0.0, 1.0) };
    if x <= 0.0 || rest <= 0.0 {
        return if x <= 0.0 { 0.0 } else { 1.0 };
    }
    let front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) - a * log1p(ratio) + b * log(rest));
    // The fraction converges quickly below the mean of the distribution, and by symmetry above it.
    if x < (a + 1.0) / (a + b + 2.0) { front * fraction(a, b, x) / a } else { 1.0 - front * fraction(b, a, rest) / b }
}

/// The continued fraction of the incomplete beta function, by Lentz's method.
fn fraction(a: f64, b: f64, x: f64) -> f64 {
    const TINY: f64 = 1e-300;
    const TERMS: u32 = 10_000;
    let away = |v: f64| if v.abs() < TINY { TINY } else { v };
    let mut d = 1.0 / away(1.0 - (a + b) * x / (a + 1.0));
    let (mut c, mut value) = (1.0, d);
    for m in 1..TERMS {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let before = value;
        for term in [even, odd] {
            d = 1.0 / away(1.0 + term * d);
            c = away(1.0 + term / c);
            value *= c * d;
        }
        if (value - before).abs() <= f64::EPSILON * value.abs() {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_quantiles_are_those_of_scipy() {
        for (p, nu, k) in SCIPY {
            // The next correction is of the order of 1 / nu^2.
            assert_close(&[coverage_factor(p, nu)], &[k], if nu < MANY { 1e-11 } else { 1e-9 }, 0.0);
        }
    }

    #[test]
    fn the_factor_falls_with_the_degrees_of_freedom_and_meets_the_normal_one() {
        let factors: Vec<f64> = [0.5, 1.0, 2.0, 1e2, 9.9e4, 1e5, 1e7].map(|nu| coverage_factor(0.9545, nu)).into();
        assert!(factors.windows(2).all(|two| two[0] > two[1]), "{factors:?}");
        assert!((factors[4] - factors[5]) / factors[5] < 1e-6);
    }

    /// scipy.stats.t.ppf(0.5 + p / 2, nu), and scipy.stats.norm.ppf for infinite nu (scipy 1.17.1).
    const SCIPY: [(f64, f64, f64); 28] = [
        (0.6827, 1.0, 1.837409429490547),
        (0.6827, 1.5, 1.4668573887584955),
        (0.6827, 3.0, 1.1969125599716923),
        (0.6827, 12.0, 1.043462512501105),
        (0.6827, 400.5, 1.001271766671165),
        (0.6827, 100000.0, 1.0000267135651382),
        (0.6827, f64::INFINITY, 1.0000217133229992),
        (0.95, 1.0, 12.706204736174694),
        (0.95, 1.5, 6.016663104427929),
        (0.95, 3.0, 3.1824463052837078),
        (0.95, 12.0, 2.1788128296672284),
        (0.95, 400.5, 1.9659048949683025),
        (0.95, 100000.0, 1.9599877075346095),
        (0.95, f64::INFINITY, 1.959963984540054),
        (0.9545, 1.0, 13.96781148750255),
        (0.9545, 1.5, 6.4182150024952405),
        (0.9545, 3.0, 3.306829920720108),
        (0.9545, 12.0, 2.231351317083423),
        (0.9545, 400.5, 2.0062637985250698),
        (0.9545, 100000.0, 2.0000274442852843),
        (0.9545, f64::INFINITY, 2.0000024438996027),
        (0.9973, 1.0, 235.78368715849922),
        (0.9973, 1.5, 42.717883752704125),
        (0.9973, 3.0, 9.218701822037435),
        (0.9973, 12.0, 3.764235224229145),
        (0.9973, 400.5, 3.018811193536559),
        (0.9973, 100000.0, 3.0000519928178746),
        (0.9973, f64::INFINITY, 2.9999769927034015),
    ];
}
