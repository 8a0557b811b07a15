//! Exponential and logarithm from sums, products and quotients: bit-identical on every machine and in every language.
//!
//! ```text
//! e^x = 2^n e^r,    r = x - n ln 2 in -ln 2 / 2 .. ln 2 / 2        e^r - 1 by its series, to r^13
//! ln x = k ln 2 + ln m,    m in 1 / sqrt 2 .. sqrt 2               ln m = 2 artanh((m - 1) / (m + 1)) by its series
//! ```
//! C libraries differ in the last digits of both, and small processors have no such library. Models use these functions
//! in every step; [`Block::elementary`] has them for programs. ln 2 is split so that n times its larger part is exact
//! (W. J. Cody & W. Waite, "Software Manual for the Elementary Functions", Prentice-Hall 1980). Errors are one or two
//! units in the last place. e^x is infinite from x = 709.5, slightly earlier than necessary.

use crate::program::Block;
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// ln 2 in two parts, the first of nine bits.
const LN_2: (f64, f64) = (0.693359375, -2.1219444005469058e-4);

/// 2^16: products and quotients by it are exact.
const COARSE: f64 = 65536.0;

/// ln 2 / 2.
const HALF_LN_2: f64 = 0.34657359027997264;

/// Arguments are clamped to this absolute value.
const MAX_ARGUMENT: f64 = 800.0;

/// e^r - 1 and 2^n of e^x = 2^n e^r.
#[inline]
fn parts(x: f64) -> (f64, f64) {
    // Most arguments in a model are small: they need no power of two.
    if x.abs() <= HALF_LN_2 { (series(x), 1.0) } else { large_parts(x) }
}

/// [`parts`] of any x.
fn large_parts(x: f64) -> (f64, f64) {
    let x = if x > MAX_ARGUMENT { MAX_ARGUMENT } else { x };
    let x = if x < -MAX_ARGUMENT { -MAX_ARGUMENT } else { x };
    let size = if x < 0.0 { -x } else { x };
    // False for NaN.
    let n = if size > HALF_LN_2 { (size * std::f64::consts::LOG2_E + 0.5) as usize } else { 0 };
    let whole = if x < 0.0 { -(n as f64) } else { n as f64 };
    let base = if x < 0.0 { 0.5 } else { 2.0 };
    (series((x - whole * LN_2.0) - whole * LN_2.1), power(base, n))
}

/// e^r - 1.
#[inline]
fn series(r: f64) -> f64 {
    let square = r * r;
    let fourth = square * square;
    let a = 1.0 / 2.0 + r * (1.0 / 6.0);
    let b = 1.0 / 24.0 + r * (1.0 / 120.0);
    let c = 1.0 / 720.0 + r * (1.0 / 5040.0);
    let d = 1.0 / 40320.0 + r * (1.0 / 362880.0);
    let e = 1.0 / 3628800.0 + r * (1.0 / 39916800.0);
    let f = 1.0 / 479001600.0 + r * (1.0 / 6227020800.0);
    let bend = (a + square * b) + fourth * ((c + square * d) + fourth * (e + square * f));
    r + square * bend
}

/// base^n, exact for powers of two.
fn power(base: f64, n: usize) -> f64 {
    let (mut result, mut factor, mut left) = (1.0, base, n);
    while left > 0 {
        if left % 2 == 1 {
            result *= factor;
        }
        factor *= factor;
        left /= 2;
    }
    result
}

/// e^x.
pub fn exp(x: f64) -> f64 {
    let (more, scale) = parts(x);
    scale * (1.0 + more)
}

/// e^x - 1, also accurate for small x.
pub(crate) fn exp_m1(x: f64) -> f64 {
    let (more, scale) = parts(x);
    // For a large scale the 1 is negligible, and infinity minus infinity is avoided.
    if scale > 1e18 { scale * (1.0 + more) } else { scale * more + (scale - 1.0) }
}

/// ln x, for x > 0.
pub(crate) fn ln(x: f64) -> f64 {
    let (mut m, mut k) = (x, 0.0);
    // By 2^16 first, so that no number takes more than 83 passes.
    while m > COARSE * SQRT_2 && m <= f64::MAX {
        (m, k) = (m / COARSE, k + 16.0);
    }
    while m > SQRT_2 && m <= f64::MAX {
        (m, k) = (m * 0.5, k + 1.0);
    }
    while m < FRAC_1_SQRT_2 / COARSE && m > 0.0 {
        (m, k) = (m * COARSE, k - 16.0);
    }
    while m < FRAC_1_SQRT_2 && m > 0.0 {
        (m, k) = (m * 2.0, k - 1.0);
    }
    let s = (m - 1.0) / (m + 1.0);
    let square = s * s;
    let fourth = square * square;
    let a = 1.0 / 3.0 + square * (1.0 / 5.0);
    let b = 1.0 / 7.0 + square * (1.0 / 9.0);
    let c = 1.0 / 11.0 + square * (1.0 / 13.0);
    let d = 1.0 / 15.0 + square * (1.0 / 17.0);
    let e = 1.0 / 19.0 + square * (1.0 / 21.0);
    let bend = square * ((a + fourth * b) + fourth * fourth * ((c + fourth * d) + fourth * fourth * e));
    let twice = 2.0 * s;
    k * LN_2.0 + (k * LN_2.1 + (twice + twice * bend))
}

/// ln(1 + x), for x > -1, also accurate for small x.
pub(crate) fn ln_1p(x: f64) -> f64 {
    let y = 1.0 + x;
    // The factor corrects the rounding error of y.
    if y == 1.0 { x } else { ln(y) * (x / (y - 1.0)) }
}

/// (e^x - 1) / x, and 1 at 0.
pub(crate) fn growth(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { exp_m1(x) / x }
}

/// The slope of [`growth`].
pub(crate) fn growth_slope(x: f64) -> f64 {
    let near = 1.0 / 2.0 + x * (1.0 / 3.0 + x * (1.0 / 8.0 + x * (1.0 / 30.0 + x * (1.0 / 144.0))));
    if x.abs() < MIN_CLOSED_FORM_ARGUMENT { near } else { (exp(x) - growth(x)) / x }
}

/// ln(1 + x) / x, and 1 at 0.
pub(crate) fn log_growth(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { ln_1p(x) / x }
}

/// The slope of [`log_growth`].
pub(crate) fn log_growth_slope(x: f64) -> f64 {
    let near = -1.0 / 2.0 + x * (2.0 / 3.0 + x * (-3.0 / 4.0 + x * (4.0 / 5.0 + x * (-5.0 / 6.0))));
    if x.abs() < MIN_CLOSED_FORM_ARGUMENT { near } else { (1.0 / (1.0 + x) - log_growth(x)) / x }
}

/// For smaller arguments the slopes would suffer from cancellation; the first terms of their series are accurate to
/// 1e-9.
const MIN_CLOSED_FORM_ARGUMENT: f64 = 0.01;

impl Block {
    /// Exponential, logarithm and related functions, bit-identical in every language.
    pub fn elementary() -> Self {
        Block::new("elementary", "elementary functions with bit-identical results on every machine").text(TEXT)
    }
}

const TEXT: &str = "
// The size of v.
fn magnitude(v) {
    let size = v;
    if v < 0.0 { size = -v; }
    return size;
}

// Which way v points: 1, -1, or 0.
fn way(v) {
    let points = 0.0;
    if v > 0.0 { points = 1.0; }
    if v < 0.0 { points = -1.0; }
    return points;
}

// v, clipped to low..high; if low > high, the result is low.
fn clamp(v, low, high) {
    let held = v;
    if held > high { held = high; }
    if held < low { held = low; }
    return held;
}

// base^n, exact for powers of two.
fn power(base, n: whole) {
    let result = 1.0;
    let factor = base;
    let left = n;
    while left > 0 at most 11 {
        if left % 2 == 1 { result = result * factor; }
        factor = factor * factor;
        left = left / 2;
    }
    return result;
}

// e^r - 1 and 2^n of e^x = 2^n e^r.
fn exponential_parts(v) {
    let x = clamp(v, -800.0, 800.0);
    let n = 0;
    // Skipped if x is NaN.
    if magnitude(x) > 0.34657359027997264 { n = whole(magnitude(x) * 1.4426950408889634 + 0.5); }
    let reduced = real(n);
    let base = 2.0;
    if x < 0.0 { reduced = -reduced; base = 0.5; }
    let r = (x - reduced * 0.693359375) - reduced * -2.1219444005469058e-4;
    let square = r * r;
    let fourth = square * square;
    let a = 1.0 / 2.0 + r * (1.0 / 6.0);
    let b = 1.0 / 24.0 + r * (1.0 / 120.0);
    let c = 1.0 / 720.0 + r * (1.0 / 5040.0);
    let d = 1.0 / 40320.0 + r * (1.0 / 362880.0);
    let e = 1.0 / 3628800.0 + r * (1.0 / 39916800.0);
    let f = 1.0 / 479001600.0 + r * (1.0 / 6227020800.0);
    let bend = (a + square * b) + fourth * ((c + square * d) + fourth * (e + square * f));
    return r + square * bend, power(base, n);
}

// e^x.
fn exponential(x) {
    let more, scale = exponential_parts(x);
    return scale * (1.0 + more);
}

// Its slope.
fn exponential_derivative(value) {
    return value;
}

// e^x - 1, exact for small x too.
fn exponential_less_1(x) {
    let more, scale = exponential_parts(x);
    let result = scale * (1.0 + more);
    if scale <= 1e18 { result = scale * more + (scale - 1.0); }
    return result;
}

// The natural logarithm of x > 0.
fn logarithm(x) {
    let m = x;
    let k = 0.0;
    // By 2^16 first, so that no number takes long.
    if m >= 1.0 {
        while m > 92681.90002368316 && m <= most at most 63 { m = m * 1.52587890625e-5; k = k + 16.0; }
        while m > 1.4142135623730951 && m <= most at most 16 { m = m * 0.5; k = k + 1.0; }
    } else {
        while m < 1.0789593218788873e-5 && m > 0.0 at most 67 { m = m * 65536.0; k = k - 16.0; }
        while m < 0.7071067811865476 && m > 0.0 at most 16 { m = m * 2.0; k = k - 1.0; }
    }
    let s = (m - 1.0) / (m + 1.0);
    let square = s * s;
    let fourth = square * square;
    let a = 1.0 / 3.0 + square * (1.0 / 5.0);
    let b = 1.0 / 7.0 + square * (1.0 / 9.0);
    let c = 1.0 / 11.0 + square * (1.0 / 13.0);
    let d = 1.0 / 15.0 + square * (1.0 / 17.0);
    let e = 1.0 / 19.0 + square * (1.0 / 21.0);
    let bend = square * ((a + fourth * b) + fourth * fourth * ((c + fourth * d) + fourth * fourth * e));
    let twice = 2.0 * s;
    return k * 0.693359375 + (k * -2.1219444005469058e-4 + (twice + twice * bend));
}

// Its slope.
fn logarithm_derivative(x) {
    return 1.0 / x;
}

// ln(1 + x), for x > -1, exact for small x too.
fn logarithm_of_1_and(x) {
    let y = 1.0 + x;
    let result = x;
    // Corrects the rounding error of 1 + x.
    if y != 1.0 { result = logarithm(y) * (x / (y - 1.0)); }
    return result;
}

// (e^x - 1) / x, and 1 at 0.
fn growth(x) {
    let result = 1.0;
    if x != 0.0 { result = exponential_less_1(x) / x; }
    return result;
}

// Its slope, near 0 by its series.
fn growth_derivative(x, value) {
    let slope = 1.0 / 2.0 + x * (1.0 / 3.0 + x * (1.0 / 8.0 + x * (1.0 / 30.0 + x * (1.0 / 144.0))));
    if magnitude(x) >= 0.01 { slope = (exponential(x) - value) / x; }
    return slope;
}

// ln(1 + x) / x, and 1 at 0.
fn log_growth(x) {
    let result = 1.0;
    if x != 0.0 { result = logarithm_of_1_and(x) / x; }
    return result;
}

// Its slope, near 0 by its series.
fn log_growth_derivative(x, value) {
    let slope = -1.0 / 2.0 + x * (2.0 / 3.0 + x * (-3.0 / 4.0 + x * (4.0 / 5.0 + x * (-5.0 / 6.0))));
    if magnitude(x) >= 0.01 { slope = (1.0 / (1.0 + x) - value) / x; }
    return slope;
}
";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Machine, Program};
    use proptest::prelude::*;

    /// Error of `found` in units in the last place.
    fn ulps(found: f64, known: f64) -> f64 {
        (found - known).abs() / (f64::EPSILON * known.abs()).max(f64::MIN_POSITIVE)
    }

    proptest! {
        #[test]
        fn they_agree_with_the_c_library_to_some_units_in_the_last_place(x in -700.0..700.0f64, small in -1.0..1.0f64, e in -300.0..300.0f64) {
            for x in [x, 0.01 * x, small, 1e-6 * small] {
                prop_assert!(ulps(exp(x), x.exp()) < 3.0, "exp {x}");
                prop_assert!(ulps(exp_m1(x), x.exp_m1()) < 4.0, "exp_m1 {x}");
            }
            let y = 10f64.powf(e);
            for y in [y, 1.0 + 0.3 * small, 1.5 + 0.5 * small] {
                prop_assert!(ulps(ln(y), y.ln()) < 4.0, "ln {y}");
            }
            for y in [y, 0.99 * small, 1e-6 * small] {
                prop_assert!(ulps(ln_1p(y), y.ln_1p()) < 4.0, "ln_1p {y}");
            }
        }

        #[test]
        fn programs_are_bit_identical(x in -750.0..750.0f64, small in -0.9..0.9f64) {
            let program = Program::new(vec![Block::elementary()]).unwrap();
            let mut machine = Machine::new(&program, "", false);
            let mut of = |name: &str, numbers: &[f64]| machine.call(name, numbers).unwrap()[0];
            for x in [x, small, 0.01 * small, 0.0] {
                prop_assert_eq!(of("exponential", &[x]).to_bits(), exp(x).to_bits());
                prop_assert_eq!(of("growth", &[x]).to_bits(), growth(x).to_bits());
                prop_assert_eq!(of("growth_derivative", &[x, growth(x)]).to_bits(), growth_slope(x).to_bits());
                prop_assert_eq!(of("logarithm", &[1e-6 + x.abs()]).to_bits(), ln(1e-6 + x.abs()).to_bits());
            }
            prop_assert_eq!(of("log_growth", &[small]).to_bits(), log_growth(small).to_bits());
            prop_assert_eq!(of("log_growth_derivative", &[small, log_growth(small)]).to_bits(), log_growth_slope(small).to_bits());
        }
    }

    #[test]
    fn limits_are_those_of_the_c_library() {
        let limits = [exp(f64::INFINITY), exp(-800.0), exp_m1(-800.0), exp_m1(1e9)];
        assert_eq!(limits, [f64::INFINITY, 0.0, -1.0, f64::INFINITY]);
        assert!(exp(f64::NAN).is_nan() && ln(f64::NAN).is_nan() && exp_m1(f64::NAN).is_nan());
        assert_eq!([exp(0.0), exp_m1(0.0), ln(1.0), ln_1p(0.0)], [1.0, 0.0, 0.0, 0.0]);
        assert!(ulps(ln(5e-324), 5e-324f64.ln()) < 2.0);
        // A machine fails if a loop is longer than its text says.
        let program = Program::new(vec![Block::elementary()]).unwrap();
        let mut machine = Machine::new(&program, "", false);
        for x in [f64::INFINITY, f64::MAX, 1e300, 92681.90002368316, 1.5, 1.0, 0.5, 1e-5, 1e-300, 5e-324, 0.0, -1.0] {
            assert_eq!(machine.call("logarithm", &[x]).unwrap()[0].to_bits(), ln(x).to_bits(), "{x}");
            machine.call("exponential", &[x]).unwrap();
        }
    }
}
