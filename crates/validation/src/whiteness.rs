//! Tests of the residuals: whiteness, and correlation with the input.
//!
//! ```text
//! r_k = sum over t of e_t e_{t-k} / sum of e_t^2          white noise: normal, of variance 1 / n
//! Q   = n (n + 2) sum over k from 1 to m of r_k^2 / (n - k)    white noise: chi-squared of m degrees (Ljung-Box)
//! c_k = sum over t of e_t u_{t-k} / sqrt(sum e^2 sum u^2)   e uncorrelated with u: normal, of variance P / n, where
//! P   = sum over |k| <= m of r_k (autocorrelation of u at k)
//! ```
//! all without the mean. In a free run the error of a good model is coloured if the actuator's own noise is, so the
//! second test is more important than the first. The size of the errors is a separate question: see the figures.
//!
//! No correlation exceeds 1. If input and errors both change slowly, P is large, and so is the bound: a wrong model
//! passes as well as a right one. Then the second test says nothing, and its text says so.
//!
//! Reference: Ljung & Box 1978, doi:10.1093/biomet/65.2.297; Ljung 1998, System Identification, section 16.6.

use libm::exp;
use piezoid_numerics::number::short;
use piezoid_numerics::series::mean;
use serde::Serialize;

/// Number of lags.
const LAG_COUNT: usize = 40;

/// Bound of the correlations in standard deviations: uncorrelated signals exceed it at any lag once in a hundred
/// records.
const BOUND_DEVIATIONS: f64 = 3.85;

/// Bound of the correlation with the input from which the test says nothing when no correlation exceeds it.
const MAX_USEFUL_BOUND: f64 = 0.5;

/// Probability below which errors are not white.
const MIN_P_VALUE: f64 = 0.01;

/// Correlations of the residuals, and their interpretation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Whiteness {
    /// Autocorrelation of the errors at lags 1, 2, ...
    pub autocorrelation: Vec<f64>,
    /// Bound of white noise at all of these lags, in 99 of 100 records.
    pub autocorrelation_bound: f64,
    /// The statistic Q of Ljung and Box over these lags.
    pub ljung_box: f64,
    /// The probability that white noise has a larger Q.
    pub p_value: f64,
    /// Correlation of the error with the input k samples earlier, for k from minus to plus the number of lags.
    pub cross_correlation: Vec<f64>,
    /// Bound of an error uncorrelated with the input at all of these lags, in 99 of 100 records.
    pub cross_correlation_bound: f64,
    /// The results of both tests in words.
    pub verdict: Vec<String>,
}

impl Whiteness {
    /// Tests errors against the input; `None` if there are fewer samples than four times the lags, or the errors are
    /// zero.
    pub fn of(u: &[f64], errors: &[f64]) -> Option<Self> {
        if errors.len() < 4 * LAG_COUNT {
            return None;
        }
        let mut sums = LaggedSums::new(mean(u), mean(errors));
        sums.add(u, errors);
        Whiteness::of_sums(&sums)
    }

    /// The same of sums over all samples.
    pub(super) fn of_sums(sums: &LaggedSums) -> Option<Self> {
        let LaggedSums { n, largest: size, .. } = *sums;
        let [uu, ee, eu, ue] = sums.by_lag();
        let (power_u, power_e) = (uu[0], ee[0]);
        if n < 4 * LAG_COUNT || !power_e.is_finite() || power_e <= 1e-24 * n as f64 * size * size {
            return None;
        }
        let over = |sum: f64, power: f64| if power > 0.0 { sum / power } else { 0.0 };
        let autocorrelation: Vec<f64> = ee[1..].iter().map(|sum| over(*sum, power_e)).collect();
        let of_input = uu[1..].iter().map(|sum| over(*sum, power_u));
        let variance = 1.0 + 2.0 * autocorrelation.iter().zip(of_input).map(|(r, s)| r * s).sum::<f64>();
        let terms = autocorrelation.iter().enumerate().map(|(k, r)| r * r / (n - k - 1) as f64);
        let ljung_box = n as f64 * (n as f64 + 2.0) * terms.sum::<f64>();
        let scale = (power_u * power_e).sqrt();
        let cross = |k: isize| {
            let lag = k.unsigned_abs();
            over(if k >= 0 { eu[lag] } else { ue[lag] }, scale)
        };
        let lags = LAG_COUNT as isize;
        let mut whiteness = Whiteness {
            autocorrelation,
            autocorrelation_bound: BOUND_DEVIATIONS / (n as f64).sqrt(),
            ljung_box,
            p_value: chi_squared_tail(ljung_box, LAG_COUNT),
            cross_correlation: (-lags..=lags).map(cross).collect(),
            cross_correlation_bound: BOUND_DEVIATIONS * (variance.max(1.0) / n as f64).sqrt(),
            verdict: Vec::new(),
        };
        whiteness.verdict = vec![whiteness.noise(), whiteness.input()];
        Some(whiteness)
    }

    /// True if the errors are white.
    pub fn is_white(&self) -> bool {
        self.p_value >= MIN_P_VALUE
    }

    /// The correlation with the input that is largest in magnitude, and its lag [samples].
    pub fn largest_correlation(&self) -> (f64, isize) {
        let lags = (self.cross_correlation.len() / 2) as isize;
        let larger = |m: (f64, isize), (c, k): (&f64, isize)| if c.abs() > m.0.abs() { (*c, k) } else { m };
        self.cross_correlation.iter().zip(-lags..).fold((0.0, 0), larger)
    }

    /// True if the errors correlate with the input.
    pub fn correlates_with_input(&self) -> bool {
        self.cross_correlation.iter().any(|c| c.abs() > self.cross_correlation_bound)
    }

    fn noise(&self) -> String {
        let (q, lags) = (short(self.ljung_box), self.autocorrelation.len());
        let first = short(self.autocorrelation[0]);
        let p = if self.p_value < 1e-6 { "below 1e-6".into() } else { short(self.p_value) };
        match self.is_white() {
            true => format!("residuals are white (Ljung-Box Q {q} over {lags} lags, p {p})"),
            false => format!(
                "a part of the residuals is regular, not noise: lag-1 autocorrelation {first} (Ljung-Box Q {q} over \
                 {lags} lags, p {p}). In a long record this test finds parts that are far too small to matter: compare \
                 the error with the noise floor"
            ),
        }
    }

    fn input(&self) -> String {
        let (c, k) = self.largest_correlation();
        let (c, bound) = (short(c), short(self.cross_correlation_bound));
        match (self.correlates_with_input(), k) {
            (false, _) if self.cross_correlation_bound > MAX_USEFUL_BOUND => format!(
                "the correlation of the residuals with the input says nothing here: it is {c} at most, and only values \
                 above {bound} would be significant. Input and residuals change slowly, or there are few samples. \
                 A record with a PRBS or a multisine as input makes the test sensitive. Without one, compare the \
                 error with the noise floor"
            ),
            (false, _) => format!(
                "residuals are uncorrelated with the input (at most {c}, bound {bound}): the model covers the linear \
                 response to the input"
            ),
            (true, 0..) => format!(
                "a part of the residuals follows the input at a lag of {k} samples (correlation {c}, bound {bound}): \
                 the dynamics, the gain or the hysteresis of the model are incomplete"
            ),
            (true, _) => format!(
                "a part of the residuals precedes the input by {} samples (correlation {c}, bound {bound}): the delay \
                 of the model is too long, the record was taken in closed loop, or the input is smooth over that many \
                 samples",
                -k
            ),
        }
    }
}

/// The sums of products at each lag of which the correlations are made, piece by piece.
#[derive(Debug)]
pub(super) struct LaggedSums {
    /// Means of u and e.
    means: [f64; 2],
    n: usize,
    largest: f64,
    /// Sums of u_t u_{t-k}, e_t e_{t-k}, e_t u_{t-k}, u_t e_{t-k}, from the highest lag k to 0.
    sums: [Lags; 4],
    /// The last samples of u and e, as many as the highest lag; before the first sample they are zero.
    past: [Vec<f64>; 2],
}

/// A number for each lag.
type Lags = [f64; LAG_COUNT + 1];

impl LaggedSums {
    /// For an input and errors of these means.
    pub(super) fn new(mean_u: f64, mean_e: f64) -> Self {
        let past = [vec![0.0; LAG_COUNT], vec![0.0; LAG_COUNT]];
        LaggedSums { means: [mean_u, mean_e], n: 0, largest: 0.0, sums: [[0.0; LAG_COUNT + 1]; 4], past }
    }

    /// The next samples.
    pub(super) fn add(&mut self, u: &[f64], errors: &[f64]) {
        self.n += u.len();
        self.largest = errors.iter().fold(self.largest, |largest, e| largest.max(e.abs()));
        let [u, e] = [(u, 0), (errors, 1)].map(|(new, k)| {
            let mut all = std::mem::take(&mut self.past[k]);
            all.extend(new.iter().map(|x| x - self.means[k]));
            all
        });
        let [uu, ee, eu, ue] = &mut self.sums;
        for (u, e) in u.array_windows::<{ LAG_COUNT + 1 }>().zip(e.array_windows::<{ LAG_COUNT + 1 }>()) {
            let (now_u, now_e) = (u[LAG_COUNT], e[LAG_COUNT]);
            // One sum a lag, so that all lags are added at once.
            for k in 0..=LAG_COUNT {
                uu[k] += now_u * u[k];
                ee[k] += now_e * e[k];
                eu[k] += now_e * u[k];
                ue[k] += now_u * e[k];
            }
        }
        self.past = [u, e].map(|all| all[all.len() - LAG_COUNT..].to_vec());
    }

    /// The same with lags that increase from 0.
    fn by_lag(&self) -> [Lags; 4] {
        self.sums.map(|mut sums| {
            sums.reverse();
            sums
        })
    }
}

/// The probability that chi-squared of an even number of degrees is larger than `q`: exp(-q/2) times the sum of
/// (q/2)^j / j! for j below half of the degrees (Abramowitz & Stegun 26.4.21).
fn chi_squared_tail(q: f64, degrees: usize) -> f64 {
    let half = 0.5 * q;
    let mut term = 1.0;
    let next = |j: usize| {
        term *= if j == 0 { 1.0 } else { half / j as f64 };
        term
    };
    let sum: f64 = (0..degrees / 2).map(next).sum();
    // If exp(-q/2) underflows, the sum may overflow.
    if half > 700.0 { 0.0 } else { exp(-half) * sum }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::{assert_close, noise};

    fn prbs(n: usize) -> Vec<f64> {
        Prbs { order: 13, ..Prbs::default() }.samples(5e-4, n).unwrap()
    }

    /// scipy.stats.chi2.sf(q, 40).
    #[test]
    fn the_tail_is_scipys() {
        let tail = [10.0, 40.0, 63.690_739_751_564_5, 120.0].map(|q| chi_squared_tail(q, 40));
        let scipys = [0.999999654786418, 0.4702572668392401, 0.009999999999999799, 6.35191834037896e-10];
        assert_close(&tail, &scipys, 1e-9, 0.0);
        assert_eq!(chi_squared_tail(1e6, 40), 0.0);
    }

    #[test]
    fn correlations_and_statistics_are_those_of_their_definitions() {
        const N: usize = 300;
        let coloured = |seed: u64, level: f64| -> Vec<f64> {
            noise(seed, N + 1).windows(2).map(|w| level + w[1] + 0.6 * w[0]).collect()
        };
        let (u, e) = (coloured(1, 3.0), coloured(2, -2.0));
        let found = Whiteness::of(&u, &e).unwrap();
        let [u, e] = [u, e].map(|x| x.iter().map(|v| v - mean(&x)).collect::<Vec<_>>());
        let sum = |x: &[f64], y: &[f64], lag: isize| -> f64 {
            let pairs = (0..N as isize).filter(|t| (0..N as isize).contains(&(t - lag)));
            pairs.map(|t| x[t as usize] * y[(t - lag) as usize]).sum()
        };
        let (r, s) = (|k| sum(&e, &e, k) / sum(&e, &e, 0), |k| sum(&u, &u, k) / sum(&u, &u, 0));
        let (lags, n) = (LAG_COUNT as isize, N as f64);
        let autocorrelation: Vec<f64> = (1..=lags).map(r).collect();
        assert_close(&found.autocorrelation, &autocorrelation, 1e-12, 1e-12);
        let cross: Vec<f64> = (-lags..=lags).map(|k| sum(&e, &u, k)).collect();
        let scale = (sum(&e, &e, 0) * sum(&u, &u, 0)).sqrt();
        assert_close(&found.cross_correlation, &cross.iter().map(|c| c / scale).collect::<Vec<_>>(), 1e-12, 1e-12);
        let q = n * (n + 2.0) * (1..=lags).map(|k| r(k).powi(2) / (n - k as f64)).sum::<f64>();
        assert_close(&[found.ljung_box, found.p_value], &[q, chi_squared_tail(q, LAG_COUNT)], 1e-9, 0.0);
        let p: f64 = (-lags..=lags).map(|k| r(k) * s(k)).sum();
        assert!(p > 1.2, "{p}");
        let bounds = [BOUND_DEVIATIONS / n.sqrt(), BOUND_DEVIATIONS * (p / n).sqrt()];
        assert_close(&[found.autocorrelation_bound, found.cross_correlation_bound], &bounds, 1e-12, 0.0);
    }

    #[test]
    fn an_error_before_the_input_is_noted_with_its_lead() {
        let (u, w) = (prbs(4000), noise(4, 4000));
        let e: Vec<f64> = (0..3997).map(|t| w[t] - 0.3 * u[t + 3]).collect();
        let whiteness = Whiteness::of(&u[..3997], &e).unwrap();
        let (largest, lag) = whiteness.largest_correlation();
        assert!(largest < 0.0 && lag == -3, "{largest} {lag}");
        assert!(whiteness.verdict[1].contains("precedes the input by 3 samples"), "{:?}", whiteness.verdict);
    }

    #[test]
    fn noise_passes_in_99_of_100_records() {
        let u = prbs(2000);
        let all: Vec<Whiteness> = (0..300).map(|seed| Whiteness::of(&u, &noise(seed, 2000)).unwrap()).collect();
        let not_white = all.iter().filter(|w| !w.is_white()).count();
        let correlated = all.iter().filter(|w| w.correlates_with_input()).count();
        assert!((1..=9).contains(&not_white) && correlated <= 9, "{not_white} {correlated}");
    }

    #[test]
    fn coloured_noise_is_not_white_but_uncorrelated_with_the_input() {
        let u = prbs(4000);
        let mut state = 0.0;
        let colour = |w: &f64| {
            state = 0.9 * state + w;
            state
        };
        let e: Vec<f64> = noise(3, 4000).iter().map(colour).collect();
        let whiteness = Whiteness::of(&u, &e).unwrap();
        assert!(!whiteness.is_white() && !whiteness.correlates_with_input(), "{whiteness:?}");
        assert_close(&[whiteness.autocorrelation[0]], &[0.9], 0.05, 0.0);
        assert!(
            whiteness.verdict[0].contains("regular, not noise")
                && whiteness.verdict[1].contains("uncorrelated with the input")
        );
    }

    #[test]
    fn a_missing_delayed_term_shows_at_its_lag() {
        let (u, w) = (prbs(4000), noise(4, 4000));
        let e: Vec<f64> = (0..4000).map(|t| w[t] + if t >= 7 { 0.2 * u[t - 7] } else { 0.0 }).collect();
        let whiteness = Whiteness::of(&u, &e).unwrap();
        assert!(
            whiteness.correlates_with_input() && whiteness.verdict[1].contains("at a lag of 7 samples"),
            "{:?}",
            whiteness.verdict
        );
        assert_close(&[whiteness.cross_correlation[40 + 7]], &[0.2 / 1.04f64.sqrt()], 0.2, 0.0);
    }

    /// A sine with the error of a wrong gain and phase: the bound was 1.1, and the model "covered the linear response".
    #[test]
    fn a_bound_that_nothing_could_exceed_is_no_proof_of_a_model() {
        let wave = |phase: f64| -> Vec<f64> { (0..4000).map(|t| (0.004 * f64::from(t) + phase).sin()).collect() };
        let whiteness = Whiteness::of(&wave(0.0), &wave(2.0)).unwrap();
        assert!(
            whiteness.cross_correlation_bound > MAX_USEFUL_BOUND && !whiteness.correlates_with_input(),
            "{whiteness:?}"
        );
        assert!(
            whiteness.verdict[1].contains("says nothing here") && !whiteness.verdict[1].contains("covers"),
            "{whiteness:?}"
        );
    }

    #[test]
    fn zero_errors_and_too_few_samples_are_not_tested() {
        assert_eq!(Whiteness::of(&prbs(400), &[1e-3; 400]), None);
        assert_eq!(Whiteness::of(&prbs(100), &noise(1, 100)), None);
    }
}
