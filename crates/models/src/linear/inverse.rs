//! The inverse of the block: the paper's equation (8), and the alternative where (8) is unstable.
//!
//! ```text
//! z_t = (y_t - a1 y_{t-1} - ... - b1 z_{t-1} - b2 z_{t-2} - ...) / b0          (8)
//! ```
//!
//! The zeros of the block are the poles of (8). With a zero outside the unit circle (8) grows without bound. But a
//! factor 1 - zeta q^-1 with |zeta| > 1 has a bounded inverse backward in time, so a complete record can still be
//! inverted (Devasia, Chen & Paden 1996, doi:10.1109/9.508898). A zero on the unit circle has no inverse: its frequency
//! is not visible in the output.

use super::analysis::Root;
use super::arx::Arx;
use libm::log;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::join;
use piezoid_numerics::series::shift_in;
use piezoid_numerics::system::System;

/// Zeros closer to the unit circle than this count as on it.
const ON_THE_CIRCLE: f64 = 1e-9;

/// Samples over which the noise gain is summed.
const IMPULSE: usize = 1 << 14;

impl Arx {
    /// The causal inverse (8): displacement in, hidden variable out. Its state has the last outputs of the block and
    /// the last z.
    ///
    /// # Errors
    /// [`Error::NoInverse`], with the zeros, if b0 = 0 or a zero is not inside the unit circle.
    pub fn inverse(&self) -> Result<Arx, Error> {
        if self.b()[0] == 0.0 {
            let because = format!(
                "b0 = 0: the input is delayed by {} samples, and the inverse, equation (8) of the paper, divides by b0",
                self.delay()
            );
            return Err(Error::NoInverse { kind: "causal", because });
        }
        let zeros = self.zeros();
        let outside: Vec<&Root> =
            zeros.iter().filter(|z| z.modulus().is_nan() || z.modulus() >= 1.0 - ON_THE_CIRCLE).collect();
        if !outside.is_empty() {
            let (is, pole) = if outside.len() == 1 { ("is", "a pole") } else { ("are", "poles") };
            let because = format!(
                "of its zeros {}, {} {is} not inside the unit circle and would be {pole} of its inverse, equation (8) \
                 of the paper, which is therefore unstable",
                join(&zeros),
                join(&outside)
            );
            return Err(Error::NoInverse { kind: "stable causal", because });
        }
        // The inverse of y = A^-1 B z is z = B^-1 A y, scaled by b0.
        let b0 = self.b()[0];
        let a = self.b()[1..].iter().map(|b| -b / b0).collect();
        let b = std::iter::once(1.0 / b0).chain(self.a().iter().map(|a| -a / b0)).collect();
        Arx::new(self.ts(), a, b)
    }

    /// The bounded input for the whole output `y`: forward in time for the zeros inside the unit circle, backward for
    /// those outside. The block is assumed settled at `y[0]` before the record and at its last value after it; if that
    /// is wrong, the ends of the result are wrong.
    ///
    /// # Errors
    /// [`Error::NoInverse`] if a zero lies on the unit circle.
    pub fn invert_whole(&self, y: &[f64]) -> Result<Vec<f64>, Error> {
        let zeros = self.zeros();
        let on_circle = |z: &&Root| z.modulus().is_nan() || (z.modulus() - 1.0).abs() < ON_THE_CIRCLE;
        if let Some(zero) = zeros.iter().find(on_circle) {
            let because =
                format!("its zero {zero} lies on the unit circle: this frequency is not visible in the output");
            return Err(Error::NoInverse { kind: "stable", because });
        }
        let Some((&first, &last)) = y.first().zip(y.last()) else { return Ok(Vec::new()) };
        let (inside, outside): (Vec<Root>, Vec<Root>) = zeros.into_iter().partition(|z| z.modulus() < 1.0);

        // B = b_lead q^-d Pi_in (1 - zeta q^-1) Pi_out (-zeta q^-1) Pi_out (1 - q / zeta)
        let lead = self.b()[self.delay()] * product(&outside);
        let preview = self.delay() + outside.len();
        let past = |t: isize| y.get(t.clamp(0, y.len() as isize - 1) as usize).copied().unwrap_or(last);
        let inner = (0..y.len() + preview).map(|t| {
            let fed_back: f64 = self.a().iter().zip(1..).map(|(a, k)| a * past(t as isize - k)).sum();
            (past(t as isize) - fed_back) / lead
        });
        let mut z: Vec<f64> = inner.collect();

        let still = first * (1.0 - self.a().iter().sum::<f64>()) / lead;
        recurse(z.iter_mut(), &monic(&inside), still);
        // Only now, because the zeros inside the circle remember the first samples of y.
        z.drain(..preview);
        let reciprocal: Vec<Root> = outside.iter().map(reciprocal).collect();
        let end = z[z.len() - 1];
        recurse(z.iter_mut().rev(), &monic(&reciprocal), end);
        Ok(z)
    }

    /// The block 1 / product of (1 - zeta / z) over those zeros zeta inside the unit circle that are chosen, with
    /// gain 1 at 0 Hz; `None` if there are none. Of a conjugate pair both must be chosen.
    ///
    /// # Errors
    /// Those of [`Arx::new`].
    pub fn inverse_of_zeros(&self, is_chosen: impl Fn(&Root) -> bool) -> Result<Option<Arx>, Error> {
        let mut zeros = self.zeros();
        zeros.retain(|zero| zero.modulus() < 1.0 && is_chosen(zero));
        if zeros.is_empty() {
            return Ok(None);
        }
        let a: Vec<f64> = monic(&zeros).iter().map(|c| -c).collect();
        let gain = 1.0 - a.iter().sum::<f64>();
        Arx::new(self.ts(), a, vec![gain]).map(Some)
    }

    /// Number of samples at the end of a record that [`invert_whole`](Arx::invert_whole) does not determine: those that
    /// act on y only after its last sample, and those whose relative error by the assumed values after it exceeds a
    /// thousandth.
    pub fn undetermined_samples(&self) -> usize {
        let outside = self.zeros().into_iter().map(|z| z.modulus()).filter(|m| *m > 1.0);
        let (count, nearest) = outside.fold((0, f64::INFINITY), |(n, nearest), m| (n + 1, nearest.min(m)));
        let disturbed = if count == 0 { 0.0 } else { (log(1e3) / log(nearest)).ceil() };
        self.delay() + count + disturbed.min(1e6) as usize
    }

    /// Noise gain of the inverse: rms of z [V] for white output noise of rms 1. `None` if a zero lies on the unit
    /// circle.
    ///
    /// Computed over a window of 16384 samples: for zeros closer to the circle than about 1e-4 the true gain is larger.
    pub fn noise_gain(&self) -> Option<f64> {
        let mut impulse = vec![0.0; IMPULSE];
        impulse[IMPULSE / 2] = 1.0;
        let response = self.invert_whole(&impulse).ok()?;
        Some(response.iter().map(|z| z * z).sum::<f64>().sqrt())
    }
}

/// Solves v_t + c1 v_{t-1} + ... = w_t in place, with `w` constant at `still` before.
fn recurse<'a>(w: impl Iterator<Item = &'a mut f64>, c: &[f64], still: f64) {
    let mut past = vec![still / (1.0 + c.iter().sum::<f64>()); c.len()];
    for v in w {
        *v -= c.iter().zip(&past).map(|(c, p)| c * p).sum::<f64>();
        shift_in(&mut past, *v);
    }
}

/// c1, c2, ... of Pi (1 - zeta q^-1) = 1 + c1 q^-1 + ...; the roots come with their conjugates.
pub(super) fn monic(zeros: &[Root]) -> Vec<f64> {
    let mut c = vec![(1.0, 0.0)];
    for z in zeros {
        c.push((0.0, 0.0));
        for k in (1..c.len()).rev() {
            let (re, im) = c[k - 1];
            c[k].0 -= re * z.re - im * z.im;
            c[k].1 -= re * z.im + im * z.re;
        }
    }
    c.into_iter().skip(1).map(|(re, _)| re).collect()
}

/// Pi (-zeta): real, because the roots come with their conjugates.
fn product(zeros: &[Root]) -> f64 {
    let (re, _) = zeros.iter().fold((1.0, 0.0), |(re, im), z| (im * z.im - re * z.re, -re * z.im - im * z.re));
    re
}

pub(super) fn reciprocal(z: &Root) -> Root {
    let square = z.re * z.re + z.im * z.im;
    Root { re: z.re / square, im: -z.im / square }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::analysis::roots;
    use piezoid_testing::assert_close;
    use proptest::prelude::*;

    fn wiggle(n: usize) -> Vec<f64> {
        (0..n).map(|t| (t as f64 * 0.07).sin() + 0.3 * (t as f64 * 0.31).sin()).collect()
    }

    #[test]
    fn a_zero_outside_the_circle_is_reported_and_inverted_backward() {
        let arx = Arx::new(5e-4, vec![1.2, -0.7], vec![0.5, 1.2, 0.1]).unwrap();
        let message = arx.inverse().unwrap_err().to_string();
        assert!(message.contains("-2.314"), "{message}");
        let z = wiggle(400);
        let found = arx.invert_whole(&arx.simulate(&z)).unwrap();
        assert_close(&found[..360], &z[..360], 0.0, 1e-9);
        let determined = 400 - arx.undetermined_samples();
        assert!(determined > 380);
        assert_close(&found[..determined], &z[..determined], 0.0, 2e-3);
    }

    #[test]
    fn a_pair_of_zeros_outside_the_circle_is_inverted_backward() {
        // 1.2 +- 0.9i, of modulus 1.5, and 0.5.
        let arx = Arx::new(1.0, vec![1.2, -0.7], vec![0.0, 2.0, -5.8, 6.9, -2.25]).unwrap();
        let z = wiggle(300);
        let found = arx.invert_whole(&arx.simulate(&z)).unwrap();
        assert_close(&found[..240], &z[..240], 0.0, 1e-9);
        let undelayed = Arx::new(1.0, vec![], vec![2.0, -5.8, 6.9, -2.25]).unwrap();
        let message = undelayed.inverse().unwrap_err().to_string();
        let expected = "1.200-0.900i and 1.200+0.900i are not inside the unit circle and would be poles of";
        assert!(message.contains(expected), "{message}");
    }

    #[test]
    fn samples_are_undetermined_by_the_delay_the_zeros_outside_and_their_decay() {
        let undetermined = |b: &[f64]| Arx::new(1.0, vec![0.5], b.to_vec()).unwrap().undetermined_samples();
        assert_eq!(undetermined(&[0.0, 2.0, 1.0]), 1);
        // 2^-10 is less than a thousandth.
        assert_eq!(undetermined(&[0.0, 0.0, 1.0, 2.0]), 2 + 1 + 10);
        assert_eq!(undetermined(&[1.0, -1.0, -6.0]), 2 + 10);
    }

    #[test]
    fn a_delayed_input_is_found_at_its_time() {
        let arx = Arx::new(1.0, vec![0.5], vec![0.0, 0.0, 2.0, 0.4]).unwrap();
        assert!(arx.inverse().unwrap_err().to_string().contains("delayed by 2 samples"));
        let z = wiggle(100);
        assert_close(&arx.invert_whole(&arx.simulate(&z)).unwrap()[..90], &z[..90], 0.0, 1e-12);
    }

    #[test]
    fn a_zero_on_the_circle_has_no_inverse() {
        let arx = Arx::new(1.0, vec![], vec![1.0, 1.0]).unwrap();
        assert!(arx.inverse().is_err() && arx.invert_whole(&[1.0, 2.0]).is_err());
        assert_eq!(arx.noise_gain(), None);
    }

    #[test]
    fn a_record_settled_off_zero_has_no_initial_transient() {
        let arx = Arx::new(5e-4, vec![1.2, -0.7], vec![0.5, 1.2, 0.1]).unwrap();
        let y = arx.resume(&mut arx.settled(3.0), &[3.0; 50]);
        assert_close(&arx.invert_whole(&y).unwrap(), &[3.0; 50], 1e-9, 0.0);
    }

    #[test]
    fn the_noise_gain_is_the_root_of_the_sum_of_squares() {
        // z_t = y_t / 2 - 0.5 z_{t-1}: sum of (0.5 * 0.5^k)^2 = 0.25 / 0.75
        let arx = Arx::new(1.0, vec![], vec![2.0, 1.0]).unwrap();
        assert_close(&[arx.noise_gain().unwrap()], &[(0.25f64 / 0.75).sqrt()], 1e-12, 0.0);
    }

    proptest! {
        #[test]
        fn inverse_after_block_is_the_identity_when_minimum_phase(
            r in 0.0..0.95f64, angle in 0.0..3.1f64, z1 in -0.9..0.9f64, z2 in -0.9..0.9f64, b0 in 0.1..10.0f64,
        ) {
            let a = vec![2.0 * r * angle.cos(), -r * r];
            let arx = Arx::new(1e-3, a, vec![b0, -b0 * (z1 + z2), b0 * z1 * z2]).unwrap();
            let z = wiggle(200);
            let y = arx.simulate(&z);
            assert_close(&arx.inverse().unwrap().simulate(&y), &z, 0.0, 1e-7);
        }
    }

    #[test]
    fn the_product_of_the_factors_is_the_polynomial() {
        let c = [1.0, 0.4, 0.9, -0.2];
        let again = monic(&roots(&c));
        assert_close(&again, &c[1..], 1e-12, 0.0);
    }

    #[test]
    fn chosen_zeros_inside_the_circle_become_poles_with_gain_one() {
        // Zeros at 0.5, -0.4 and 3.
        let arx = Arx::new(0.1, vec![0.3], vec![2.0, -6.2, 0.2, 1.2]).unwrap();
        let all = arx.inverse_of_zeros(|_| true).unwrap().unwrap();
        assert_close(all.a(), &[0.1, 0.2], 0.0, 1e-12);
        assert_close(all.b(), &[0.7], 0.0, 1e-12);
        assert_eq!(all.ts(), 0.1);
        let one = arx.inverse_of_zeros(|zero| zero.re > 0.0).unwrap().unwrap();
        assert_close(&[one.a(), one.b()].concat(), &[0.5, 0.5], 0.0, 1e-12);
        assert_eq!(arx.inverse_of_zeros(|_| false).unwrap(), None);
        assert_eq!(Arx::new(0.1, vec![0.3], vec![1.0, 3.0]).unwrap().inverse_of_zeros(|_| true).unwrap(), None);
    }
}
