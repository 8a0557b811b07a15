//! The inverse for a whole reference: sample by sample, then corrected by iterations, r_{j+1} = r_j + (r - y_j).
//!
//! They correct what the differences and the other modes leave.

use super::super::{Compensated, FeedForward, InverseRun};
use super::Flat;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;

/// Iterations if no more are requested.
const LEAST_ITERATIONS: usize = 10;

impl FeedForward {
    /// The inverse of mechanics with hysteresis in feedback, if the model has such mechanics and they have an inverse.
    pub(in super::super) fn flat(&self) -> Option<Flat> {
        let model = self.whole.feedback()?;
        Flat::new(model, self.ends, Flat::least_delay(model))
    }

    /// The voltage for the reference `r` by this inverse.
    pub(in super::super) fn in_feedback(&self, flat: &Flat, r: &[f64]) -> Result<Compensated, Error> {
        let invert = |target: &[f64]| self.limited(flat.whole(target));
        let most = self.settings.iterations.max(LEAST_ITERATIONS);
        let (best, ..) = self.corrected(r, r.to_vec(), most, invert, smooth)?;
        self.compensated(best, Vec::new())
    }

    /// The response to the inputs `u`, within the limits.
    fn limited(&self, mut u: Vec<f64>) -> InverseRun {
        let mut run = InverseRun::default();
        let mut before = u.first().map_or(0.0, |u| self.nearest(*u, self.ends, 0.0));
        for (t, u) in u.iter_mut().enumerate() {
            let allowed = self.from(before);
            if !(allowed.0..=allowed.1).contains(u) {
                run.clipped += 1;
                run.missed = run.missed.or(Some(t));
            }
            *u = self.nearest(*u, allowed, before);
            before = *u;
        }
        let start = u.first().copied().unwrap_or_default();
        InverseRun { reached: self.whole.follow(&mut self.whole.settled(start), &u), u, ..run }
    }
}

impl Flat {
    /// The inputs for a whole reference, which is constant before, and turned about its last value after it.
    fn whole(&self, r: &[f64]) -> Vec<f64> {
        let (Some(&first), Some(&last)) = (r.first(), r.last()) else { return Vec::new() };
        let mut x = self.settled(first).1;
        let after = r.iter().rev().skip(1).map(|r| 2.0 * last - r);
        let end = 2.0 * last - first;
        let all = r.iter().copied().chain(after).chain(std::iter::repeat(end)).take(r.len() + self.delay_samples);
        all.map(|r| self.step(&mut x, r)).skip(self.delay_samples).collect()
    }
}

/// `x` without what is near half the sampling rate, where the inverse lacks the other modes: cos^4(pi f / fs) remains.
fn smooth(x: &[f64]) -> Vec<f64> {
    let last = x.len() as isize - 1;
    let of = |t: isize| {
        let [a, b, c, d, e] = [-2, -1, 0, 1, 2].map(|k| x[(t + k).clamp(0, last) as usize]);
        (a + 4.0 * b + 6.0 * c + 4.0 * d + e) / 16.0
    };
    (0..=last).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensation::FeedForwardSettings;
    use piezoid_models::hammerstein::Model;
    use piezoid_testing::{assert_close, in_feedback};

    #[test]
    fn a_record_goes_on_turned_about_its_last_value_and_then_rests() {
        for (_, document) in in_feedback() {
            let model = Model::from_json(&document.to_string()).unwrap();
            let flat = FeedForward::new(&model, FeedForwardSettings::default()).unwrap().flat().unwrap();
            let offset = model.feedback().unwrap().dynamics().offset;
            let along = |r: &[f64]| flat.whole(&r.iter().map(|r| offset + r).collect::<Vec<_>>());
            let ramp: Vec<f64> = (0..40).map(|t| 0.1 * f64::from(t)).collect();
            assert_close(&along(&ramp[..20]), &along(&ramp)[..20], 0.0, 1e-7);
            let goes_on = [vec![0.0, 1.0, 3.0, 5.0], vec![6.0; 12]].concat();
            let (short, long) = (along(&goes_on[..3]), along(&goes_on));
            assert_close(&short, &long[..3], 0.0, 1e-7);
        }
    }

    #[test]
    fn an_impulse_is_smoothed_to_binomial_shares_and_a_constant_stays() {
        assert_eq!(smooth(&[0.0, 0.0, 0.0, 16.0, 0.0, 0.0, 0.0]), [0.0, 1.0, 4.0, 6.0, 4.0, 1.0, 0.0]);
        assert_eq!(smooth(&[16.0, 0.0]), [11.0, 5.0]);
        assert_eq!(smooth(&[7.0; 3]), [7.0; 3]);
    }
}
