//! Functions of complex numbers, bit-identical on every machine. Those of num-complex call the C library, and are left
//! out.

use libm::{atan2, hypot, sincos};
use nalgebra::Complex;

/// |z|.
pub fn modulus(z: Complex<f64>) -> f64 {
    hypot(z.re, z.im)
}

/// The angle of z [rad], from -pi to pi.
pub fn argument(z: Complex<f64>) -> f64 {
    atan2(z.im, z.re)
}

/// r e^(i phase).
pub fn polar(r: f64, phase: f64) -> Complex<f64> {
    let (sin, cos) = sincos(phase);
    Complex::new(r * cos, r * sin)
}

/// e^z.
pub fn exp(z: Complex<f64>) -> Complex<f64> {
    polar(libm::exp(z.re), z.im)
}

/// ln z.
pub fn log(z: Complex<f64>) -> Complex<f64> {
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
            let is_near = |a: Complex<f64>, re: f64, im: f64| {
                let (off, size) = ((a.re - re).hypot(a.im - im), re.hypot(im));
                off <= 1e-14 * size
            };
            prop_assert!(is_near(modulus(z).into(), re.hypot(im), 0.0) && is_near(argument(z).into(), im.atan2(re), 0.0));
            prop_assert!(is_near(polar(re, im), re * im.cos(), re * im.sin()));
            prop_assert!(is_near(exp(z), re.exp() * im.cos(), re.exp() * im.sin()));
            prop_assert!(is_near(log(z), re.hypot(im).ln(), im.atan2(re)));
        }
    }
}
