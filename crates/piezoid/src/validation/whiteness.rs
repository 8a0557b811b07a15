//! Whether what the model leaves is noise.
//!
//! ```text
//! r_k = sum over t of e_t e_{t-k} / sum of e_t^2          white noise: normal, of variance 1 / n
//! Q   = n (n + 2) sum over k from 1 to m of r_k^2 / (n - k)    white noise: chi-squared of m degrees (Ljung-Box)
//! c_k = sum over t of e_t u_{t-k} / sqrt(sum e^2 sum u^2)   e apart from u: normal, of variance P / n, where
//! P   = sum over |k| <= m of r_k (autocorrelation of u at k)
//! ```
//! with the mean taken off. In a free run the error of a good model is still coloured where the actuator's own noise is: so
//! the second test counts for more than the first. Whether the errors are large is another question: see the figures.
//!
//! Reference: Ljung & Box 1978, doi:10.1093/biomet/65.2.297; Ljung 1998, System Identification, section 16.6.

use crate::number::short;
use crate::series::{dot, mean};
use serde::Serialize;

/// Lags looked at.
const LAGS: usize = 40;

/// Standard deviations that bound the correlations: what bears the test crosses them anywhere once in a hundred records.
const BOUND: f64 = 3.85;

/// Probability below which errors are not taken for white.
const SELDOM: f64 = 0.01;

/// Correlations of what is left, and what they mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Whiteness {
    /// Correlation of errors at lags 1, 2, ...
    pub autocorrelation: Vec<f64>,
    /// What white noise stays within at all of these lags, in 99 of 100 records.
    pub autocorrelation_bound: f64,
    /// The statistic Q of Ljung and Box over these lags.
    pub ljung_box: f64,
    /// The probability that white noise has a larger Q.
    pub p_value: f64,
    /// Correlation of the error with the input so many samples before, from minus as many lags to as many.
    pub cross_correlation: Vec<f64>,
    /// What an error apart from the input stays within at all of these lags, in 99 of 100 records.
    pub cross_correlation_bound: f64,
    /// What both tests say, in words.
    pub verdict: Vec<String>,
}

impl Whiteness {
    /// Tests errors against the input; none where there are fewer than four times as many as lags, or nothing is left.
    pub(super) fn of(u: &[f64], errors: &[f64]) -> Option<Self> {
        let n = errors.len();
        let (u, e) = (centred(u), centred(errors));
        let (power_u, power_e) = (dot(&u, &u), dot(&e, &e));
        let size = errors.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
        if n < 4 * LAGS || !power_e.is_finite() || power_e <= 1e-24 * n as f64 * size * size {
            return None;
        }
        let auto = |x: &[f64], power: f64, k: usize| if power > 0.0 { dot(&x[k..], &x[..n - k]) / power } else { 0.0 };
        let autocorrelation: Vec<f64> = (1..=LAGS).map(|k| auto(&e, power_e, k)).collect();
        let of_input = (1..=LAGS).map(|k| auto(&u, power_u, k));
        let shared = 1.0 + 2.0 * autocorrelation.iter().zip(of_input).map(|(r, s)| r * s).sum::<f64>();
        let terms = autocorrelation.iter().enumerate().map(|(k, r)| r * r / (n - k - 1) as f64);
        let ljung_box = n as f64 * (n as f64 + 2.0) * terms.sum::<f64>();
        let scale = (power_u * power_e).sqrt();
        let cross = |k: isize| {
            let lag = k.unsigned_abs();
            let sum = if k >= 0 { dot(&e[lag..], &u[..n - lag]) } else { dot(&e[..n - lag], &u[lag..]) };
            if scale > 0.0 { sum / scale } else { 0.0 }
        };
        let lags = LAGS as isize;
        let mut whiteness = Whiteness {
            autocorrelation,
            autocorrelation_bound: BOUND / (n as f64).sqrt(),
            ljung_box,
            p_value: chi_squared_tail(ljung_box, LAGS),
            cross_correlation: (-lags..=lags).map(cross).collect(),
            cross_correlation_bound: BOUND * (shared.max(1.0) / n as f64).sqrt(),
            verdict: Vec::new(),
        };
        whiteness.verdict = vec![whiteness.noise(), whiteness.input()];
        Some(whiteness)
    }

    /// Whether the errors are as uncorrelated as white noise.
    pub fn is_white(&self) -> bool {
        self.p_value >= SELDOM
    }

    /// Whether the errors go with the input.
    pub fn correlates_with_input(&self) -> bool {
        self.cross_correlation.iter().any(|c| c.abs() > self.cross_correlation_bound)
    }

    fn noise(&self) -> String {
        let (q, lags) = (short(self.ljung_box), self.autocorrelation.len());
        let p = if self.p_value < 1e-6 { "below 1e-6".into() } else { short(self.p_value) };
        match self.is_white() {
            true => format!("what is left is as white as noise (Ljung-Box Q {q} over {lags} lags, p {p})"),
            false => format!(
                "what is left is not white: neighbours correlate by {} (Ljung-Box Q {q} over {lags} lags, p {p}). It is not noise \
                 alone but something the model does not follow; a test that takes the errors for independent will believe too much",
                short(self.autocorrelation[0])
            ),
        }
    }

    fn input(&self) -> String {
        let lags = (self.cross_correlation.len() / 2) as isize;
        let largest = self
            .cross_correlation
            .iter()
            .zip(-lags..)
            .fold((0.0, 0), |m: (f64, isize), (c, k)| if c.abs() > m.0.abs() { (*c, k) } else { m });
        let (c, k, bound) = (short(largest.0), largest.1, short(self.cross_correlation_bound));
        match (self.correlates_with_input(), largest.1) {
            (false, _) => format!(
                "it does not go with the input (correlation {c} at most, within the bound of {bound}): what the input does, as \
                 far as a line can follow, is in the model"
            ),
            (true, 0..) => format!(
                "it goes with the input {k} samples before (correlation {c}, beyond the bound of {bound}): dynamics, gain or \
                 hysteresis that the model lacks"
            ),
            (true, _) => format!(
                "it goes with the input {} samples later (correlation {c}, beyond the bound of {bound}): a delay too long in the \
                 model, a controller that acts on the output, or an input that is smooth over so many samples",
                -k
            ),
        }
    }
}

fn centred(x: &[f64]) -> Vec<f64> {
    let middle = mean(x);
    x.iter().map(|x| x - middle).collect()
}

/// The probability that chi-squared of an even number of degrees is larger than `q`: exp(-q/2) times the sum of
/// (q/2)^j / j! for j below half of the degrees (Abramowitz & Stegun 26.4.21).
fn chi_squared_tail(q: f64, degrees: usize) -> f64 {
    let half = 0.5 * q;
    let mut term = 1.0;
    let sum: f64 = (0..degrees / 2)
        .map(|j| {
            term *= if j == 0 { 1.0 } else { half / j as f64 };
            term
        })
        .sum();
    // Where exp(-q/2) underflows the sum may overflow, and the product is none.
    if half > 700.0 { 0.0 } else { (-half).exp() * sum }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::Prbs;
    use crate::testing::assert_close;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn noise(n: usize, seed: u64) -> Vec<f64> {
        let mut generator = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        (0..n).map(|_| StandardNormal.sample(&mut generator)).collect()
    }

    fn prbs(n: usize) -> Vec<f64> {
        Prbs { order: 13, ..Prbs::default() }.samples(5e-4, n).unwrap()
    }

    /// scipy.stats.chi2.sf(q, 40).
    #[test]
    fn the_tail_is_scipys() {
        let tail = [10.0, 40.0, 63.690_739_751_564_5, 120.0].map(|q| chi_squared_tail(q, 40));
        assert_close(
            &tail,
            &[0.999999654786418, 0.4702572668392401, 0.009999999999999799, 6.35191834037896e-10],
            1e-9,
            0.0,
        );
        assert_eq!(chi_squared_tail(1e6, 40), 0.0);
    }

    #[test]
    fn noise_passes_in_ninety_nine_of_a_hundred_records() {
        let u = prbs(2000);
        let seen: Vec<Whiteness> = (0..300).map(|seed| Whiteness::of(&u, &noise(2000, seed)).unwrap()).collect();
        let not_white = seen.iter().filter(|w| !w.is_white()).count();
        let followers = seen.iter().filter(|w| w.correlates_with_input()).count();
        assert!((1..=9).contains(&not_white) && followers <= 9, "{not_white} {followers}");
    }

    #[test]
    fn coloured_noise_is_not_white_but_apart_from_the_input() {
        let u = prbs(4000);
        let mut state = 0.0;
        let e: Vec<f64> = noise(4000, 3)
            .iter()
            .map(|w| {
                state = 0.9 * state + w;
                state
            })
            .collect();
        let seen = Whiteness::of(&u, &e).unwrap();
        assert!(!seen.is_white() && !seen.correlates_with_input(), "{seen:?}");
        assert_close(&[seen.autocorrelation[0]], &[0.9], 0.05, 0.0);
        assert!(seen.verdict[0].contains("not white") && seen.verdict[1].contains("does not go with the input"));
    }

    #[test]
    fn a_forgotten_lag_shows_at_its_place() {
        let (u, w) = (prbs(4000), noise(4000, 4));
        let e: Vec<f64> = (0..4000).map(|t| w[t] + if t >= 7 { 0.2 * u[t - 7] } else { 0.0 }).collect();
        let seen = Whiteness::of(&u, &e).unwrap();
        assert!(seen.correlates_with_input() && seen.verdict[1].contains("7 samples before"), "{:?}", seen.verdict);
        assert_close(&[seen.cross_correlation[40 + 7]], &[0.2 / 1.04f64.sqrt()], 0.2, 0.0);
    }

    #[test]
    fn nothing_left_and_too_few_samples_are_not_judged() {
        assert_eq!(Whiteness::of(&prbs(400), &[1e-3; 400]), None);
        assert_eq!(Whiteness::of(&prbs(100), &noise(100, 1)), None);
    }
}
