//! Dual numbers: forward automatic differentiation, exact to rounding.
//!
//! ```text
//! (x, x') + (y, y') = (x + y, x' + y')    (x, x') (y, y') = (x y, x' y + x y')    f((x, x')) = (f(x), f'(x) x')
//! ```
//! A law of hysteresis is written once, for any [`Real`]. With `f64` it simulates; with [`Dual`] it also gives the
//! derivative of z by one of its parameters. At a kink the derivative is that of the selected side.
//!
//! R. E. Wengert, "A simple automatic derivative evaluation program", Commun. ACM 7 (1964), DOI 10.1145/355586.364791.

use crate::elementary;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The numbers of the laws: `f64`, or a number with derivatives.
pub trait Real:
    Copy
    + PartialOrd
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// The number without derivatives.
    fn value(self) -> f64;
    /// f(self), given its value and its derivative, which is computed only if needed.
    fn map(self, f: f64, slope: impl FnOnce() -> f64) -> Self;

    /// e^self.
    fn exp(self) -> Self {
        let e = elementary::exp(self.value());
        self.map(e, || e)
    }
    /// For self > 0.
    fn ln(self) -> Self {
        let x = self.value();
        self.map(elementary::ln(x), || 1.0 / x)
    }
    /// (e^x - 1) / x, and 1 at 0.
    fn growth(self) -> Self {
        let x = self.value();
        self.map(elementary::growth(x), || elementary::growth_slope(x))
    }
    /// ln(1 + x) / x, and 1 at 0.
    fn log_growth(self) -> Self {
        let x = self.value();
        self.map(elementary::log_growth(x), || elementary::log_growth_slope(x))
    }
    /// max(low, min(high, self)). If the limits cross, the result is `low`.
    fn clamp(self, low: Self, high: Self) -> Self {
        let below = if self > high { high } else { self };
        if below < low { low } else { below }
    }
}

impl Real for f64 {
    fn value(self) -> f64 {
        self
    }
    fn map(self, f: f64, _: impl FnOnce() -> f64) -> f64 {
        f
    }
}

/// A derivative, or several at once.
pub trait Slope:
    Copy + Add<Output = Self> + Sub<Output = Self> + Neg<Output = Self> + Mul<f64, Output = Self> + Div<f64, Output = Self>
{
    const ZERO: Self;
}

impl Slope for f64 {
    const ZERO: f64 = 0.0;
}

/// A value and its derivative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<S = f64> {
    pub value: f64,
    pub slope: S,
}

impl<S: Slope> From<f64> for Dual<S> {
    fn from(value: f64) -> Self {
        Dual { value, slope: S::ZERO }
    }
}

impl<S: PartialEq> PartialOrd for Dual<S> {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl<S: Slope> Neg for Dual<S> {
    type Output = Self;
    fn neg(self) -> Self {
        Dual { value: -self.value, slope: -self.slope }
    }
}

impl<S: Slope> Add for Dual<S> {
    type Output = Self;
    fn add(self, y: Self) -> Self {
        Dual { value: self.value + y.value, slope: self.slope + y.slope }
    }
}

impl<S: Slope> Sub for Dual<S> {
    type Output = Self;
    fn sub(self, y: Self) -> Self {
        Dual { value: self.value - y.value, slope: self.slope - y.slope }
    }
}

impl<S: Slope> Mul for Dual<S> {
    type Output = Self;
    fn mul(self, y: Self) -> Self {
        Dual { value: self.value * y.value, slope: self.slope * y.value + y.slope * self.value }
    }
}

impl<S: Slope> Div for Dual<S> {
    type Output = Self;
    fn div(self, y: Self) -> Self {
        let value = self.value / y.value;
        Dual { value, slope: (self.slope - y.slope * value) / y.value }
    }
}

impl<S: Slope + PartialEq> Real for Dual<S> {
    fn value(self) -> f64 {
        self.value
    }
    fn map(self, f: f64, slope: impl FnOnce() -> f64) -> Self {
        Dual { value: f, slope: self.slope * slope() }
    }
}

/// The derivatives by several parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Several<const N: usize>(pub [f64; N]);

/// Number of parameters of a [`Sensitive`] number.
pub const LANES: usize = 8;

/// A value and its derivatives by some parameters.
pub type Sensitive = Dual<Several<LANES>>;

impl<const N: usize> Several<N> {
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Several(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }
}

impl<const N: usize> Slope for Several<N> {
    const ZERO: Self = Several([0.0; N]);
}

impl<const N: usize> Add for Several<N> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |x, y| x + y)
    }
}

impl<const N: usize> Sub for Several<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |x, y| x - y)
    }
}

impl<const N: usize> Neg for Several<N> {
    type Output = Self;
    fn neg(self) -> Self {
        Several(self.0.map(|x| -x))
    }
}

impl<const N: usize> Mul<f64> for Several<N> {
    type Output = Self;
    fn mul(self, by: f64) -> Self {
        Several(self.0.map(|x| x * by))
    }
}

impl<const N: usize> Div<f64> for Several<N> {
    type Output = Self;
    fn div(self, by: f64) -> Self {
        Several(self.0.map(|x| x / by))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn derivatives_equal_the_analytical_ones() {
        let x = Dual { value: 0.7, slope: 1.0 };
        let two = Dual::from(2.0);
        let of = |y: Dual| y.slope;
        let found = [of(x * x / (two + x)), of((-x).exp()), of((two * x.ln()).exp()), of((x * two.ln()).exp())];
        let known = [(2.0 * 0.7 * 2.7 - 0.49) / (2.7 * 2.7), -(-0.7f64).exp(), 1.4, 2f64.powf(0.7) * 2f64.ln()];
        assert_close(&found, &known, 1e-14, 0.0);
        assert_eq!(x.clamp(Dual::from(0.8), two).slope, 0.0, "outside the limits the derivative is 0");
    }

    #[test]
    fn several_derivatives_at_once_are_the_same_as_one_by_one() {
        let f = |x: f64, slopes: [f64; 2], y: f64, others: [f64; 2]| {
            let (x, y) = (Dual { value: x, slope: Several(slopes) }, Dual { value: y, slope: Several(others) });
            let one = |k: usize| {
                let (x, y) = (Dual { value: x.value, slope: slopes[k] }, Dual { value: y.value, slope: others[k] });
                (((x * y - x) / (y + x)).exp() * (-y).growth()).slope
            };
            (((x * y - x) / (y + x)).exp() * (-y).growth(), [one(0), one(1)])
        };
        let (at_once, one_by_one) = f(0.7, [1.0, 0.0], 1.9, [0.3, 1.0]);
        assert_eq!(at_once.slope, Several(one_by_one));
    }

    #[test]
    fn growth_functions_have_the_right_derivatives_near_zero() {
        for x in [-3.0, -0.5, -0.011, -0.009, 1e-5, 0.009, 0.011, 0.7] {
            let at = |x| Dual { value: x, slope: 1.0 };
            let h = 1e-4;
            for f in [Dual::growth, Dual::log_growth] {
                let y = |x: f64| f(at(x)).value;
                // ln(1 + x) is defined above -1.
                let x = f64::max(x, -0.9);
                let difference = (8.0 * (y(x + h) - y(x - h)) - (y(x + 2.0 * h) - y(x - 2.0 * h))) / (12.0 * h);
                assert_close(&[f(at(x)).slope], &[difference], 1e-8, 0.0);
            }
        }
        assert_eq!((0.0.growth(), 0.0.log_growth()), (1.0, 1.0));
    }
}
