//! The discrete Fourier transform, X_k = sum over t of x_t W^(k t) with W = exp(-2 pi i / n), in O(n log n) for any n.
//!
//! ```text
//! n = r m:  X_(r p' + k) from the transforms of length m of   W^(p k) sum over j < r of x_(p + m j) W_r^(j k)
//! ```
//! One factor r of n after the other, from one array to another, so that results are in order (W. T. Cochran et al.,
//! What is the fast Fourier transform?, 1967, DOI 10.1109/PROC.1967.5957). A large prime factor is replaced by a
//! convolution whose length is a power of two (L. Bluestein, 1970, DOI 10.1109/TAU.1970.1162132).
//!
//! Sums and products have one order, and W comes from libm: the same bits on every machine. Libraries take W from the C
//! library, and their order from the vector unit.
//!
//! Why: docs/decisions/numerics-and-determinism.md, "The Fourier transform is our own".

use crate::complex::polar;
use nalgebra::Complex;
use std::f64::consts::{PI, TAU};

type C = Complex<f64>;

/// Largest prime factor that is summed directly.
const DIRECT: usize = 31;

/// The transform of one length.
pub struct Transform {
    /// The factors of the length; of a convolution, those of its own length.
    factors: Vec<usize>,
    /// W^k.
    roots: Vec<C>,
    convolution: Option<Convolution>,
}

/// For `k t = (k^2 + t^2 - (k - t)^2) / 2`: X_k is c_k times the convolution of x_t c_t with the conjugate of c.
struct Convolution {
    /// c_k = exp(-pi i k^2 / n).
    chirp: Vec<C>,
    /// The transform of its conjugate, over the length of the convolution.
    spectrum: Vec<C>,
}

impl Transform {
    /// The transform of `n` samples.
    pub fn new(n: usize) -> Self {
        let factors = factors(n);
        if factors.iter().all(|r| *r <= DIRECT) {
            return Transform { factors, roots: roots(n), convolution: None };
        }
        let long = (2 * n - 1).next_power_of_two();
        // k^2 modulo 2 n: exact for any k.
        let chirp = |k: usize| polar(1.0, -PI * ((k as u128 * k as u128) % (2 * n as u128)) as f64 / n as f64);
        let chirp: Vec<C> = (0..n).map(chirp).collect();
        let mut spectrum = vec![C::ZERO; long];
        for (k, c) in chirp.iter().enumerate() {
            spectrum[k] = c.conj();
            spectrum[(long - k) % long] = c.conj();
        }
        let mut long = Transform::new(long);
        long.process(&mut spectrum);
        long.convolution = Some(Convolution { chirp, spectrum });
        long
    }

    /// Number of samples.
    pub(crate) fn len(&self) -> usize {
        self.convolution.as_ref().map_or(self.roots.len(), |c| c.chirp.len())
    }

    /// Transforms `x` in place.
    pub fn process(&self, x: &mut [C]) {
        let Some(Convolution { chirp, spectrum }) = &self.convolution else { return self.factor_by_factor(x) };
        let mut long = vec![C::ZERO; spectrum.len()];
        for ((long, x), c) in long.iter_mut().zip(&*x).zip(chirp) {
            *long = x * c;
        }
        self.factor_by_factor(&mut long);
        // The forward transform of the conjugate is the conjugate of the inverse.
        long.iter_mut().zip(spectrum).for_each(|(long, s)| *long = (*long * s).conj());
        self.factor_by_factor(&mut long);
        let scale = 1.0 / spectrum.len() as f64;
        for ((x, long), c) in x.iter_mut().zip(long).zip(chirp) {
            *x = long.conj() * c * scale;
        }
    }

    fn factor_by_factor(&self, x: &mut [C]) {
        let mut other = vec![C::ZERO; x.len()];
        let (mut from, mut to) = (&mut *x, &mut *other);
        let mut apart = 1;
        for &r in &self.factors {
            match r {
                2 => self.pass::<2>(apart, from, to),
                3 => self.pass::<3>(apart, from, to),
                4 => self.pass_of_four(apart, from, to),
                5 => self.pass::<5>(apart, from, to),
                _ => self.pass_of(r, apart, from, to),
            }
            apart *= r;
            (from, to) = (to, from);
        }
        if self.factors.len() % 2 == 1 {
            x.copy_from_slice(&other);
        }
    }

    /// One factor; `apart` is the product of those before.
    fn pass<const R: usize>(&self, apart: usize, from: &[C], to: &mut [C]) {
        let (n, m) = (from.len(), from.len() / R / apart);
        let turns: [[C; R]; R] = std::array::from_fn(|k| std::array::from_fn(|j| self.roots[j * k % R * (n / R)]));
        for (p, to) in to.chunks_exact_mut(R * apart).enumerate() {
            let turned: [C; R] = std::array::from_fn(|k| self.roots[p * k * apart]);
            for q in 0..apart {
                let x: [C; R] = std::array::from_fn(|j| from[q + apart * (p + m * j)]);
                for k in 0..R {
                    let sum = (1..R).fold(x[0], |sum, j| sum + x[j] * turns[k][j]);
                    to[q + apart * k] = sum * turned[k];
                }
            }
        }
    }

    /// The factor 4, whose turns are by quarters.
    fn pass_of_four(&self, apart: usize, from: &[C], to: &mut [C]) {
        let m = from.len() / 4 / apart;
        for (p, to) in to.chunks_exact_mut(4 * apart).enumerate() {
            let [one, two, three] = [1, 2, 3].map(|k| self.roots[p * k * apart]);
            for q in 0..apart {
                let [a, b, c, d] = [0, 1, 2, 3].map(|j| from[q + apart * (p + m * j)]);
                let (even, odd, sum, less) = (a + c, a - c, b + d, b - d);
                // -i (b - d)
                let turned = C::new(less.im, -less.re);
                to[q] = even + sum;
                to[q + apart] = (odd + turned) * one;
                to[q + 2 * apart] = (even - sum) * two;
                to[q + 3 * apart] = (odd - turned) * three;
            }
        }
    }

    /// A factor of any size.
    fn pass_of(&self, r: usize, apart: usize, from: &[C], to: &mut [C]) {
        let (n, m) = (from.len(), from.len() / r / apart);
        for (p, to) in to.chunks_exact_mut(r * apart).enumerate() {
            for (q, k) in (0..apart).flat_map(|q| (0..r).map(move |k| (q, k))) {
                let term = |j: usize| from[q + apart * (p + m * j)] * self.roots[j * k % r * (n / r)];
                to[q + apart * k] = (0..r).map(term).sum::<C>() * self.roots[p * k * apart];
            }
        }
    }
}

/// W^k for each k below n.
fn roots(n: usize) -> Vec<C> {
    (0..n).map(|k| polar(1.0, -TAU * k as f64 / n as f64)).collect()
}

/// The factors of n, fours before primes.
fn factors(mut n: usize) -> Vec<usize> {
    let mut found = Vec::new();
    let mut r = 4;
    while n > 1 {
        if n.is_multiple_of(r) {
            found.push(r);
            n /= r;
        } else {
            r = match r {
                4 => 2,
                2 => 3,
                // What is left of n is a prime.
                r if r * r > n => n,
                r => r + 2,
            };
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complex::modulus;

    #[test]
    fn every_length_gives_the_direct_sum() {
        let lengths = (1..=70).chain([81, 100, 121, 127, 128, 31 * 31, 37 * 4, 1000, 1009, 2 * 1009]);
        for n in lengths {
            let x: Vec<C> = (0..n).map(|t| C::new((t as f64 * 0.7).sin(), (t * t % 11) as f64 - 5.0)).collect();
            let transform = Transform::new(n);
            let mut fast = x.clone();
            transform.process(&mut fast);
            let root = |k: usize| polar(1.0, -TAU * k as f64 / n as f64);
            for k in (0..n).step_by(1 + n / 97) {
                let direct: C = (0..n).map(|t| x[t] * root(k * t % n)).sum();
                assert!(modulus(fast[k] - direct) < 1e-13 * (8.0 * n as f64), "{n}: {k}: {} {direct}", fast[k]);
            }
            assert_eq!(transform.len(), n);
        }
    }
}
