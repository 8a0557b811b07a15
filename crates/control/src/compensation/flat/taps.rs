//! Derivatives of a series at its samples, and held inputs.
//!
//! ```text
//! x'  = (d1 (x_1 - x_-1) + d2 (x_2 - x_-2)) / h          exact at 0 Hz and at the angle theta a sample
//! x'' = (c1 (x_1 - 2 x_0 + x_-1) + c2 (x_2 - 2 x_0 + x_-2)) / h^2                      the same
//! u   = sum_j t_j v_k+j,   j = 1, 0, -1, -2                                            the same
//! ```
//! At the resonance a mode multiplies an error of its force: there the formulas have none. For theta = 0 the
//! derivatives are the central differences of fourth order.
//!
//! A converter holds u from the end of sample k - 1 to that of sample k. Modes respond to a smooth voltage v with
//! `lag v' + v = w`, the response sin(theta/2) / (theta/2) of the hold and its delay of half a sample. The voltage
//! itself is a staircase behind the lag; along a ramp both are equal at one instant of each sample, without a lag in
//! its middle.
//!
//! Reference: B. Fornberg, Math. Comput. 51 (1988), DOI 10.1090/S0025-5718-1988-0935077-0 (differences); L. G. Ixaru,
//! Comput. Phys. Commun. 105 (1997), DOI 10.1016/S0010-4655(97)00067-2 (formulas exact for one frequency).

use nalgebra::Complex;
use piezoid_numerics::complex::polar;

/// Samples of a difference: the newest first, the derivative at the third.
pub(super) const TAPS: usize = 5;

/// Samples of a held input: one after it, and two before.
pub(super) const REACH: usize = 4;

/// Steps of the bisection for an instant: then its ends are neighbours.
const BISECTIONS: usize = 52;

/// Angles per sample between which a formula is exact at one frequency: below, its coefficients would be rounding
/// errors.
const ANGLES: (f64, f64) = (0.05, 1.0);

/// The differences for a sampling period.
#[derive(Debug, Clone, Copy)]
pub(super) struct Differences {
    h: f64,
    angle: f64,
}

impl Differences {
    /// For the sampling period `h` [s], exact at the angular frequency `w` [1/s].
    pub(super) fn new(h: f64, w: f64) -> Self {
        // Also for an angle that is not a number.
        Differences { h, angle: (w * h).max(ANGLES.0).min(ANGLES.1) }
    }

    /// The first derivative.
    pub(super) fn first(&self) -> [f64; TAPS] {
        let sine = libm::sin(self.angle);
        let d2 = (self.angle - sine) / (2.0 * libm::sin(2.0 * self.angle) - 4.0 * sine);
        let d1 = 0.5 - 2.0 * d2;
        [d2, d1, 0.0, -d1, -d2].map(|d| d / self.h)
    }

    /// The second derivative.
    pub(super) fn second(&self) -> [f64; TAPS] {
        let [once, twice] = [1.0, 2.0].map(|k| 2.0 * (1.0 - libm::cos(k * self.angle)));
        let c2 = (self.angle * self.angle - once) / (twice - 4.0 * once);
        let c1 = 1.0 - 4.0 * c2;
        [c2, c1, -2.0 * (c1 + c2), c1, c2].map(|c| c / self.h / self.h)
    }

    /// The third derivative, of second order.
    pub(super) fn third(&self) -> [f64; TAPS] {
        [0.5, -1.0, 0.0, 1.0, -0.5].map(|d| d / self.h / self.h / self.h)
    }

    /// The fourth derivative, of second order.
    pub(super) fn fourth(&self) -> [f64; TAPS] {
        [1.0, -4.0, 6.0, -4.0, 1.0].map(|d| d / self.h / self.h / self.h / self.h)
    }

    /// The shares of x_k+1 to x_k-2 in a value with the response `of` to a wave, counted from the middle of sample k;
    /// near 0 Hz it is that of x as many samples after it as `after` states.
    fn shares(&self, of: impl Fn(f64) -> Complex<f64>, after: f64) -> [f64; REACH] {
        let (half, of) = (0.5 * self.angle, of(self.angle));
        let (near, far) = ((libm::cos(half), libm::sin(half)), (libm::cos(3.0 * half), libm::sin(3.0 * half)));
        let even = (of.re - near.0) / (2.0 * (far.0 - near.0));
        let odd = (of.im - 2.0 * after * near.1) / (2.0 * far.1 - 6.0 * near.1);
        let (nearer, steeper) = (0.5 - even, after - 3.0 * odd);
        [even + odd, nearer + steeper, nearer - steeper, even - odd]
    }
}

/// A held input behind a lag. Ends of samples count.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hold {
    differences: Differences,
    /// Of the driver, in samples.
    lag: f64,
    /// Share of a sample after which the voltage is what a smooth input would make of it.
    pub(super) at: f64,
    /// What is left then, and at the end of the sample, of the difference between voltage and input.
    pub(super) left: [f64; 2],
}

impl Hold {
    /// Behind a lag [s].
    pub(super) fn new(differences: Differences, lag: f64) -> Self {
        let lag = lag / differences.h;
        let left = |at: f64| if lag > 0.0 { libm::exp(-at / lag) } else { 0.0 };
        // The voltage of a ramp, before what it would be without the hold [samples].
        let before = |at: f64| 0.5 + lag - at - left(at) / (1.0 - left(1.0));
        let (mut low, mut high) = (0.5, 1.0);
        for _ in 0..if lag > 0.0 { BISECTIONS } else { 0 } {
            let at = 0.5 * (low + high);
            if before(at) > 0.0 { low = at } else { high = at }
        }
        Hold { differences, lag, at: low, left: [left(low), left(1.0)] }
    }

    /// The input for a voltage whose samples x are.
    pub(super) fn input(&self) -> [f64; REACH] {
        self.differences.shares(|angle| self.held(angle), self.lag)
    }

    /// The voltage within sample k for one whose samples x are, if the input is computed from it.
    pub(super) fn voltage(&self) -> [f64; REACH] {
        let [left, at_end] = self.left;
        let of = |angle: f64| {
            let turned = polar(1.0, -angle);
            self.held(angle) * ((1.0 - left) + turned * (left * (1.0 - at_end)) / (1.0 - turned * at_end))
        };
        self.differences.shares(of, self.at - 0.5)
    }

    /// What is smooth, at the same instant.
    pub(super) fn between(&self) -> [f64; REACH] {
        self.differences.shares(|angle| polar(1.0, angle * (self.at - 0.5)), self.at - 0.5)
    }

    /// How far the voltage of a ramp is behind at the end of a sample [s].
    pub(super) fn behind(&self) -> f64 {
        let at_end = self.left[1];
        self.differences.h * (0.5 - self.lag + at_end / (1.0 - at_end))
    }

    /// The input for a wave of the voltage, counted from the middle of a sample.
    fn held(&self, angle: f64) -> Complex<f64> {
        Complex::new(1.0, angle * self.lag) * (0.5 * angle / libm::sin(0.5 * angle))
    }
}

/// The sum of the products.
pub(super) fn dot(taps: &[f64], x: &[f64]) -> f64 {
    taps.iter().zip(x).fold(0.0, |sum, (tap, x)| sum + tap * x)
}

/// The sum of multiples of taps.
pub(super) fn combined<const N: usize>(of: [(f64, [f64; TAPS]); N]) -> [f64; TAPS] {
    std::array::from_fn(|k| of.iter().fold(0.0, |sum, (factor, taps)| sum + factor * taps[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_numerics::complex::modulus;
    use piezoid_testing::assert_close;

    /// A wave of `angle` a sample about its sample 0, and its derivatives there.
    fn wave(angle: f64, h: f64) -> ([f64; TAPS], [f64; 5]) {
        let (phase, w) = (0.7f64, angle / h);
        let at = |k: usize| (angle * (2.0 - k as f64) + phase).sin();
        let (s, c) = phase.sin_cos();
        (std::array::from_fn(at), [s, w * c, -w * w * s, -w * w * w * c, w * w * w * w * s])
    }

    #[test]
    fn derivatives_are_exact_at_the_resonance_and_of_fourth_order_below_it() {
        let h = 5e-4;
        for (resonance, angle, most) in [(0.5, 0.5, 1e-12), (0.5, 0.3, 4e-4), (0.5, 0.01, 1e-6), (0.0, 0.1, 2e-6)] {
            let (differences, w) = (Differences::new(h, resonance / h), angle / h);
            let (x, [_, first, second, third, fourth]) = wave(angle, h);
            assert_close(&[dot(&differences.first(), &x)], &[first], 0.0, most * w);
            assert_close(&[dot(&differences.second(), &x)], &[second], 0.0, most * w * w);
            assert_close(&[dot(&differences.third(), &x)], &[third], 0.0, 0.3 * angle * angle * w * w * w);
            assert_close(&[dot(&differences.fourth(), &x)], &[fourth], 0.0, 0.2 * angle * angle * w * w * w * w);
        }
    }

    /// The sum of the shares of a wave.
    fn response(shares: &[f64; REACH], angle: f64) -> Complex<f64> {
        shares.iter().zip([1.0, 0.0, -1.0, -2.0]).map(|(share, k)| polar(*share, angle * k)).sum()
    }

    #[test]
    fn a_held_input_behind_a_lag_has_the_response_of_the_voltage() {
        for (angle, most) in [(0.5, 1e-12), (0.4, 2e-3), (0.2, 1e-3), (0.01, 1e-5)] {
            for lag in [0.0, 0.2, 1.5] {
                let h = 5e-4;
                let hold = Hold::new(Differences::new(h, 0.5 / h), lag * h);
                // The hold that ends with sample k, then the lag.
                let of = (polar(1.0, angle) - 1.0) / Complex::new(0.0, angle) / Complex::new(1.0, angle * lag);
                let of_input = response(&hold.input(), angle) * of;
                assert!(modulus(of_input - 1.0) < most, "{angle}, {lag}: {of_input}");
                // From a voltage within the samples, the input by the voltage at the end of the one before.
                let (taps, [left, at_end]) = (hold.voltage(), hold.left);
                let (mut v, mut inputs) = (0.0, Complex::from(0.0));
                for k in 0..4000 {
                    let within = (response(&taps, angle) * polar(1.0, angle * f64::from(k))).re;
                    let u = (within - left * v) / (1.0 - left);
                    v = u + (v - u) * at_end;
                    if k >= 2000 {
                        inputs += polar(u / 1000.0, -angle * f64::from(k));
                    }
                }
                assert!(modulus(inputs * of - 1.0) < most.max(3e-3 / angle.sin()), "{angle}, {lag}: {inputs}");
                assert!(modulus(response(&hold.between(), angle) - polar(1.0, angle * (hold.at - 1.0))) < most);
            }
        }
    }

    #[test]
    fn along_a_ramp_the_voltage_is_right_within_and_behind_at_the_end_of_each_sample() {
        for lag in [0.0, 0.2, 1.0, 5.0] {
            let hold = Hold::new(Differences::new(1.0, 0.5), lag);
            let (mut v, mut within, [left, at_end]) = (0.0, 0.0, hold.left);
            // The ramp t + lag, in the middle of each sample.
            for k in 1..400 {
                let u = f64::from(k) - 0.5 + lag;
                within = u + (v - u) * left;
                v = u + (v - u) * at_end;
            }
            assert_close(&[within, 399.0 - v], &[398.0 + hold.at, hold.behind()], 0.0, 1e-9);
        }
    }
}
