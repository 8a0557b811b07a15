//! Functions of complex numbers that are bit-identical on every machine: those of num-complex call the C library.

use libm::{atan2, hypot, sincos};
use nalgebra::Complex;

/// |z|.
pub(crate) fn modulus(z: Complex<f64>) -> f64 {
    hypot(z.re, z.im)
}

/// The angle of z [rad], from -pi to pi.
pub(crate) fn argument(z: Complex<f64>) -> f64 {
    atan2(z.im, z.re)
}

/// r e^(i phase).
pub(crate) fn polar(r: f64, phase: f64) -> Complex<f64> {
    let (sin, cos) = sincos(phase);
    Complex::new(r * cos, r * sin)
}

/// e^z.
pub(crate) fn exp(z: Complex<f64>) -> Complex<f64> {
    polar(libm::exp(z.re), z.im)
}

/// ln z.
pub(crate) fn log(z: Complex<f64>) -> Complex<f64> {
    Complex::new(libm::log(modulus(z)), argument(z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn they_are_those_of_the_c_library_but_for_rounding(re in -20.0..20.0f64, im in -20.0..20.0f64) {
            let z = Complex::new(re, im);
            let near = |a: Complex<f64>, b: Complex<f64>| (a - b).norm() <= 1e-14 * b.norm();
            prop_assert!(near(modulus(z).into(), z.norm().into()) && near(argument(z).into(), z.arg().into()));
            prop_assert!(near(exp(z), z.exp()) && near(log(z), z.ln()) && near(polar(re, im), Complex::from_polar(re, im)));
        }
    }
}
