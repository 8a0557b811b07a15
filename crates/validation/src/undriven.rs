//! The noise of a record whose input does not repeat, from the part of the spectrum that the input does not drive.
//!
//! ```text
//! R = E - (E S* / S S*) S        over blocks of 32 bins: the error without what is linear in the free run
//! level = median of |R|^2 / ln 2 in the highest octave where it is flat
//! sigma^2 = mean over all bins of the level, extended over the lower bins
//! ```
//! with the spectra E of the error and S of the free run. Their window keeps drift and ends of the record out of high
//! frequencies. In the median, ln 2 times the mean of the power of noise, lines at high frequency do not count.
//!
//! - Towards low frequencies the level is extended as a constant or, where the upper two octaves show it clearly, as
//!   w + c / f (strain gauges), but never above the error itself.
//! - If the level falls in the highest octave, because a low pass precedes the sampling, the two octaves below it are
//!   tried. There the free run must have next to no power, because the error of a model is not noise.
//! - Hum is added: lines at 50 or 60 Hz and multiples that neither the free run nor a multiple of the frequency of the
//!   input explains.
//! - Noise that grows towards low frequencies faster than 1 / f, and noise only at low frequencies, are not found. Then
//!   the figure is too low.
//!
//! Reference: Percival & Walden 1993, Spectral Analysis for Physical Applications, doi:10.1017/CBO9780511622762.

use libm::{log, pow};
use nalgebra::Complex;
use piezoid_numerics::fourier::{LINE_WIDTH_BINS, spectrum};
use piezoid_numerics::series::quantile;
use piezoid_records::record::Record;
use piezoid_records::waveform::dominant_frequency;
use std::f64::consts::LN_2;

/// Bins over which the response of the error to the free run is taken as constant, and how many of them count as
/// independent: the window widens each to two.
const BLOCK_BINS: usize = 32;
const INDEPENDENT_BIN_SHARE: f64 = 0.5;

/// Minimum number of bins of half an octave.
const MIN_HALF_OCTAVE_BINS: usize = 24;

/// Ratio of the levels of both halves of an octave up to which it is flat: noise as 1 / f has 1.4, behind a low pass of
/// first order 2.
const MAX_FLAT_LEVEL_RATIO: f64 = 1.5;

/// Power of the free run over that of the error, up to which a lower octave counts as not driven.
const MAX_UNDRIVEN_POWER_RATIO: f64 = 0.03;

/// Windows in the upper two octaves, and the standard errors by which 1 / f noise must exceed zero there; up to
/// `MAX_MISFIT`, exceeded once in 300 records, the squared deviations from w + c / f are random.
const WINDOW_COUNT: usize = 8;
const MIN_SLOPE_DEVIATIONS: f64 = 4.0;
const MAX_MISFIT: f64 = 20.0;

/// Mains frequencies [Hz], and the number of multiples of them.
const MAINS_HZ: [f64; 2] = [50.0, 60.0];
const MAINS_MULTIPLES: usize = 6;

/// Relative uncertainty of the mains frequency.
const MAINS_UNCERTAINTY: f64 = 0.002;

/// Multiples of the frequency of the input up to which a line is the model's error and not hum.
const MAX_HARMONIC: f64 = 20.0;

/// Noise of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    /// Standard deviation [output unit].
    pub(super) rms: f64,
    /// The mains frequency, if there is hum [Hz].
    pub(super) hum_hz: Option<f64>,
}

impl Noise {
    /// The noise of a record, from the errors of a free run; `None` if no part of the spectrum shows it, or the record
    /// is too short.
    pub(crate) fn of(record: &Record, errors: &[f64], simulated: &[f64]) -> Option<Self> {
        let (e, s) = (spectrum(errors), spectrum(simulated));
        let background = Background::of(&e, &s).square()?;
        let hum = hum(&e, &s, 1.0 / record.duration(), dominant_frequency(record.u(), record.ts()));
        let square = background + hum.map_or(0.0, |(power, _)| power);
        Some(Noise { rms: square.sqrt(), hum_hz: hum.map(|(_, hz)| hz) })
    }
}

/// Powers by bin, in units of the variance of white noise.
struct Background {
    /// Of the error without what is linear in the free run.
    error: Vec<f64>,
    /// Of the free run.
    with_driver: Vec<f64>,
}

impl Background {
    fn of(e: &[Complex<f64>], s: &[Complex<f64>]) -> Self {
        let mut error = Vec::with_capacity(e.len());
        // Blocks end at the highest bin; what is left over counts to the lowest.
        let mut rest = (e, s);
        while !rest.0.is_empty() {
            let n = if rest.0.len() < 2 * BLOCK_BINS { rest.0.len() } else { BLOCK_BINS };
            let (lower, e) = rest.0.split_at(rest.0.len() - n);
            let s = &rest.1[lower.len()..];
            let both: Complex<f64> = e.iter().zip(s).map(|(e, s)| e * s.conj()).sum();
            let own: f64 = s.iter().map(Complex::norm_sqr).sum();
            let gain = if own > 0.0 { both / own } else { Complex::ZERO };
            let free = INDEPENDENT_BIN_SHARE * n as f64;
            let taken = free / (free - 1.0).max(1.0);
            error.extend(e.iter().zip(s).rev().map(|(e, s)| taken * (e - gain * s).norm_sqr()));
            rest = (lower, &rest.1[..lower.len()]);
        }
        error.reverse();
        Background { error, with_driver: s.iter().map(Complex::norm_sqr).collect() }
    }

    /// The mean square of the noise.
    fn square(&self) -> Option<f64> {
        let n = self.error.len();
        let (low, high) = self.flat_octave()?;
        let plain = level(&self.error[low..high]);
        let above: f64 = self.error[high..].chunks(BLOCK_BINS).map(|b| b.len() as f64 * level(b)).sum();
        let Some((white, slope)) = self.coloured().filter(|_| high == n) else {
            return Some((plain * high as f64 + above) / n as f64);
        };
        let each = self.error.chunks(BLOCK_BINS).enumerate().map(|(k, block)| {
            let middle = (k * BLOCK_BINS) as f64 + 0.5 * block.len() as f64;
            block.len() as f64 * (white + slope * n as f64 / middle).min(level(block))
        });
        Some(each.sum::<f64>() / n as f64)
    }

    /// The bins of the highest octave with a flat level.
    fn flat_octave(&self) -> Option<(usize, usize)> {
        (0..3).find_map(|k| {
            let high = self.error.len() >> k;
            let low = high / 2;
            let middle = (high as f64 / 2f64.sqrt()) as usize;
            if middle - low < MIN_HALF_OCTAVE_BINS {
                return None;
            }
            let of = |from: usize, to: usize| level(&self.error[from..to]);
            let spread = [middle - low, high - middle].map(|n| deviation(n).powi(2)).iter().sum::<f64>().sqrt();
            let flat = log(of(low, middle) / of(middle, high)).abs() < log(MAX_FLAT_LEVEL_RATIO) + 2.0 * spread;
            let quiet = k == 0 || level(&self.with_driver[low..high]) < MAX_UNDRIVEN_POWER_RATIO * of(low, high);
            (flat && quiet).then_some((low, high))
        })
    }

    /// White noise w and 1 / f noise c of the level w + c / f, with f over half the sampling rate, if the upper two
    /// octaves show the latter.
    fn coloured(&self) -> Option<(f64, f64)> {
        let n = self.error.len() as f64;
        let edge = |k: usize| (n * 0.25 * pow(4.0, k as f64 / WINDOW_COUNT as f64)) as usize;
        // Levels with their inverse frequencies and relative standard deviations.
        let windows: [[f64; 3]; WINDOW_COUNT] = std::array::from_fn(|k| {
            let (low, high) = (edge(k), edge(k + 1));
            [level(&self.error[low..high]), n / (0.5 * (low + high) as f64), deviation(high - low)]
        });
        if (0..WINDOW_COUNT).any(|k| edge(k + 1) - edge(k) < MIN_HALF_OCTAVE_BINS) {
            return None;
        }
        let (mut white, mut slope) = (windows.iter().map(|w| w[0]).sum::<f64>() / WINDOW_COUNT as f64, 0.0);
        let mut error = 0.0;
        for _ in 0..5 {
            let mut sums = [0.0; 5];
            for [level, g, deviation] in &windows {
                let weight = ((white + slope * g).max(1e-3 * level) * deviation).powi(-2);
                for (sum, term) in sums.iter_mut().zip([1.0, *g, g * g, *level, g * level]) {
                    *sum += weight * term;
                }
            }
            let [one, g, gg, y, gy] = sums;
            let determinant = one * gg - g * g;
            (white, slope) = ((gg * y - g * gy) / determinant, (one * gy - g * y) / determinant);
            error = (one / determinant).sqrt();
        }
        // All of it may be 1 / f noise.
        let misfit: f64 = windows.iter().map(|[y, g, d]| ((y / (white + slope * g) - 1.0) / d).powi(2)).sum();
        (slope > MIN_SLOPE_DEVIATIONS * error && misfit < MAX_MISFIT).then_some((white, slope))
    }
}

/// Mean power of noise in these bins, from the median.
fn level(power: &[f64]) -> f64 {
    quantile(power.to_vec(), 0.5) / LN_2
}

/// Relative standard deviation of the level from `n` bins.
fn deviation(n: usize) -> f64 {
    1.0 / (LN_2 * (INDEPENDENT_BIN_SHARE * n as f64).sqrt())
}

/// Mean square and frequency of the hum; `hz` is the width of a bin and `drive` the frequency of the input.
fn hum(e: &[Complex<f64>], s: &[Complex<f64>], hz: f64, drive: Option<f64>) -> Option<(f64, f64)> {
    // The power of the line at a frequency, over the median and over the largest of its surroundings, if it is no
    // response to the input.
    let line = |at: f64| {
        let half = LINE_WIDTH_BINS / 2 + (MAINS_UNCERTAINTY * at / hz).ceil() as usize;
        let (centre, width) = ((at / hz).round() as usize, 2 * half + 1);
        let first = centre.checked_sub(half + 5 * width)?;
        let sums = |x: &[Complex<f64>]| {
            let part = x.get(first..first + 11 * width)?;
            let sums = part.chunks(width).map(|bins| bins.iter().map(Complex::norm_sqr).sum::<f64>());
            let mut sums: Vec<f64> = sums.collect();
            let own = sums[5];
            sums.drain(4..7);
            sums.sort_by(f64::total_cmp);
            Some((own, 0.5 * (sums[3] + sums[4]), sums[7]))
        };
        let ((own, median, largest), (response, beside, _)) = (sums(e)?, sums(s)?);
        let is_harmonic = drive.is_some_and(|drive| {
            let order = (at / drive).round();
            (1.0..=MAX_HARMONIC).contains(&order) && (at - order * drive).abs() < half as f64 * hz
        });
        (response < 3.0 * beside && !is_harmonic).then_some((own - median, own / median, own / largest))
    };
    let of = |mains: f64| {
        let (power, ..) = line(mains).filter(|(_, over, clear)| *over > 100.0 && *clear > 10.0)?;
        let multiples = (2..=MAINS_MULTIPLES).filter_map(|k| line(k as f64 * mains));
        let more = multiples.filter(|(_, over, clear)| *over > 10.0 && *clear > 2.0).map(|l| l.0);
        Some(((power + more.sum::<f64>()) / e.len() as f64, mains))
    };
    MAINS_HZ.iter().filter_map(|mains| of(*mains)).max_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_records::excitation::{Prbs, RisingSine};
    use piezoid_testing::{assert_close, noise};
    use std::f64::consts::TAU;

    const TS: f64 = 1e-3;
    const N: usize = 8000;

    fn rising() -> Vec<f64> {
        RisingSine { amplitude: 10.0, frequency: 7.0, ..RisingSine::default() }.samples(TS, N).unwrap()
    }

    /// The noise of a record with input `u`, of a model that gives `s`, where `y` = `u` + disturbance.
    fn found(u: Vec<f64>, disturbance: &[f64], s: &[f64]) -> Option<Noise> {
        let y: Vec<f64> = u.iter().zip(disturbance).map(|(u, e)| u + e).collect();
        let errors: Vec<f64> = y.iter().zip(s).map(|(y, s)| y - s).collect();
        Noise::of(&Record::new(TS, u, y).unwrap(), &errors, s)
    }

    /// A model with a wrong gain, a missing cubic term and an offset.
    fn poor(u: &[f64]) -> Vec<f64> {
        u.iter().map(|u| 1.1 * u - 1e-3 * u.powi(3) + 5.0).collect()
    }

    fn low_passed(x: &[f64], share: f64) -> Vec<f64> {
        let pass = |state: &mut f64, x: &f64| {
            *state += share * (x - *state);
            Some(*state)
        };
        x.iter().scan(0.0, pass).collect()
    }

    fn rms(x: &[f64]) -> f64 {
        (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
    }

    #[test]
    fn white_noise_is_found_below_a_poor_model() {
        for seed in 0..5 {
            let u = rising();
            let e: Vec<f64> = noise(seed, N).iter().enumerate().map(|(t, e)| 0.05 * e + 1e-4 * t as f64).collect();
            let model = poor(&u);
            let found = found(u, &e, &model).unwrap();
            assert_close(&[found.rms], &[0.05], 0.1, 0.0);
            assert_eq!(found.hum_hz, None);
        }
    }

    #[test]
    fn a_broadband_input_and_a_model_with_wrong_gain_and_delay_leave_the_noise() {
        let u = Prbs { order: 13, ..Prbs::default() }.samples(TS, N).unwrap();
        let delayed: Vec<f64> = std::iter::once(0.0).chain(u.iter().map(|u| 1.05 * u)).take(N).collect();
        let e: Vec<f64> = noise(3, N).iter().map(|e| 0.02 * e).collect();
        assert_close(&[found(u, &e, &delayed).unwrap().rms], &[0.02], 0.15, 0.0);
    }

    #[test]
    fn noise_that_grows_as_1_over_f_and_noise_behind_a_low_pass_are_extended_by_their_shape() {
        // The sum of lags over the decades has a power of about 1 / f.
        let mut pink = vec![0.0; N];
        for (seed, share) in [1.0, 0.3, 0.1, 0.03, 0.01].into_iter().enumerate() {
            let part = low_passed(&noise(seed as u64, N), share);
            let size = rms(&part);
            pink.iter_mut().zip(part).for_each(|(sum, x)| *sum += x / size);
        }
        let filtered = low_passed(&noise(9, N), 0.8);
        for (x, tolerance) in [(pink, 0.25), (filtered, 0.1)] {
            let e: Vec<f64> = x.iter().map(|v| 0.02 * v / rms(&x)).collect();
            let u = rising();
            let model = poor(&u);
            assert_close(&[found(u, &e, &model).unwrap().rms], &[0.02], tolerance, 0.0);
        }
    }

    #[test]
    fn hum_is_noise_unless_it_is_a_harmonic_of_the_input() {
        let hum = |t: usize| 0.03 * (TAU * 50.02 * t as f64 * TS).sin() + 0.01 * (TAU * 150.06 * t as f64 * TS).sin();
        let e: Vec<f64> = noise(1, N).iter().enumerate().map(|(t, e)| 0.01 * e + hum(t)).collect();
        let u = rising();
        let model = poor(&u);
        let with_hum = found(u, &e, &model).unwrap();
        assert_eq!(with_hum.hum_hz, Some(50.0));
        assert_close(&[with_hum.rms], &[rms(&e)], 0.1, 0.0);
        let u = RisingSine { amplitude: 10.0, frequency: 25.0, ..RisingSine::default() }.samples(TS, N).unwrap();
        let e: Vec<f64> = noise(2, N).iter().zip(&u).map(|(e, u)| 0.01 * e + 1e-3 * u * u).collect();
        assert_eq!(found(u.clone(), &e, &u).unwrap().hum_hz, None, "twice 25 Hz is the error of the model");
    }

    #[test]
    fn noise_that_no_part_of_the_spectrum_shows_is_unknown() {
        let u = rising();
        let model = poor(&u);
        assert_eq!(found(u[..150].to_vec(), &noise(1, 150), &model[..150]), None, "too short");
        // Its power falls as 1 / f^4.
        let slow = low_passed(&low_passed(&noise(5, N), 0.002), 0.002);
        assert_eq!(found(u, &slow, &model), None);
    }

    /// Powers in `n` bins, without a free run.
    fn background(n: usize, error: impl Fn(usize) -> f64) -> Background {
        Background { error: (0..n).map(error).collect(), with_driver: vec![0.0; n] }
    }

    #[test]
    fn what_is_linear_in_the_free_run_block_by_block_is_no_background() {
        // Blocks of 36, 32 and 32 bins, each with its own response, and errors with no part along the free run.
        let s = vec![Complex::new(0.5, 1.0); 100];
        let response = |k: usize| Complex::new(2.0, [-1.0, 3.0, 0.5][k.saturating_sub(4) / 32]);
        let beside = |k: usize| (1.0 + (k / 2) as f64) * if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let other: Vec<_> = (0..100).map(|k| Complex::from(beside(k))).collect();
        let error: Vec<_> = (0..100).map(|k| response(k) * s[k] + other[k]).collect();
        // A response takes one of 18 or 16 independent bins.
        let scale = |k: usize| if k < 36 { 18.0 / 17.0 } else { 16.0 / 15.0 };
        let expected: Vec<f64> = (0..100).map(|k| scale(k) * beside(k).powi(2)).collect();
        let found = Background::of(&error, &s);
        assert_close(&found.error, &expected, 1e-9, 1e-9);
        assert_close(&found.with_driver, &[1.25; 100], 1e-12, 0.0);
        assert_close(&Background::of(&other, &[Complex::ZERO; 100]).error, &expected, 1e-12, 0.0);
    }

    #[test]
    fn the_highest_flat_octave_that_is_not_driven_shows_the_level() {
        // Its halves may differ by 1.5 and two standard deviations of 2.9 %.
        let step = |ratio: f64| background(40_000, |k| if k < 28_284 { ratio } else { 1.0 }).flat_octave();
        assert_eq!([step(1.55), step(1.0 / 1.55)], [Some((20_000, 40_000)); 2]);
        assert_eq!([step(1.65), step(1.0 / 1.65)], [Some((10_000, 20_000)); 2]);
        let mut passed = background(4000, |k| if k < 2000 { 1.0 } else { 2.0 - k as f64 / 2001.0 });
        assert_eq!(passed.flat_octave(), Some((1000, 2000)));
        passed.with_driver[500..1000].fill(0.02);
        passed.with_driver[1000..2000].fill(0.05);
        assert_eq!(passed.flat_octave(), Some((500, 1000)));
        passed.with_driver[500..1000].fill(0.05);
        assert_eq!(passed.flat_octave(), None);
        let driven = Background { with_driver: vec![10.0; 4000], ..background(4000, |_| 1.0) };
        assert_eq!(driven.flat_octave(), Some((2000, 4000)));
        assert_eq!([115, 114].map(|n| background(n, |_| 1.0).flat_octave()), [Some((57, 115)), None]);
    }

    /// By weighted least squares in a script.
    #[test]
    fn noise_as_1_over_f_is_found_where_the_levels_show_it_clearly() {
        let coloured = |slope: f64, higher: f64| {
            let level = |k: usize| LN_2 * (1.0 + slope * 4000.0 / (k as f64 + 0.5));
            // One of the eight windows is higher.
            background(4000, |k| level(k) * if (2000..2378).contains(&k) { higher } else { 1.0 }).coloured()
        };
        let found = |(white, slope): (f64, f64)| [white, slope];
        assert_close(&found(coloured(0.42, 1.0).unwrap()), &[1.0, 0.42], 1e-4, 0.0);
        assert_eq!(coloured(0.35, 1.0), None);
        assert_close(&found(coloured(1.0, 1.3).unwrap()), &[0.966_934_4, 1.080_127_7], 1e-6, 0.0);
        assert!(coloured(1.0, 1.5).is_some() && coloured(1.0, 1.6).is_none());
    }

    #[test]
    fn the_mean_square_is_that_of_the_level_in_all_bins() {
        assert_close(&[background(4000, |_| LN_2).square().unwrap()], &[1.0], 1e-12, 0.0);
        // Behind a low pass, the bins above have their own levels: 26 blocks of 0.5, then 0.1.
        let passed = background(4000, |k| LN_2 * [1.0, 0.5, 0.1][usize::from(k >= 2000) + usize::from(k >= 2828)]);
        assert_close(&[passed.square().unwrap()], &[(2000.0 + 832.0 * 0.5 + 1168.0 * 0.1) / 4000.0], 1e-9, 0.0);
        // 1 + 1 / f by the middles of 125 blocks.
        let pink = background(4000, |k| LN_2 * (1.0 + 4000.0 / (k as f64 + 0.5)));
        let expected = 1.0 + (0..125).map(|block| 1.0 / (f64::from(block) + 0.5)).sum::<f64>();
        assert_close(&[pink.square().unwrap()], &[expected], 1e-3, 0.0);
    }

    #[test]
    fn hum_is_the_power_of_clear_lines_of_the_mains_that_the_input_does_not_explain() {
        // Bins of 0.25 Hz with a power of 1, and lines at 60, 120 and 180 Hz, of which the last is not clear.
        let with = |lines: &[(usize, f64)], floor: f64| {
            let mut bins = vec![Complex::from(floor); 1000];
            lines.iter().for_each(|(bin, power)| bins[*bin] = Complex::from(power.sqrt()));
            bins
        };
        let lines = [(240, 2000.0), (480, 200.0), (720, 60.0)];
        let (e, quiet) = (with(&lines, 1.0), with(&[], 1e-3));
        let expected = ((2000.0 - 1.0) + (200.0 - 1.0)) / 1000.0;
        for drive in [None, Some(2.5), Some(6.2), Some(200.0)] {
            let (power, hz) = hum(&e, &quiet, 0.25, drive).unwrap();
            assert_close(&[power, hz], &[expected, 60.0], 1e-9, 0.0);
        }
        // A multiple of the input up to the twentieth, within half the width of a line.
        for drive in [3.0, 6.1] {
            assert_eq!(hum(&e, &quiet, 0.25, Some(drive)), None, "{drive}");
        }
        let driven = with(&[(240, 1.0)], 1e-3);
        assert_eq!(hum(&e, &driven, 0.25, None), None, "a line of the free run");
        let beside = with(&[(240, 2000.0), (270, 300.0)], 1.0);
        assert_eq!(hum(&beside, &quiet, 0.25, None), None, "one of several lines");
        assert_eq!(hum(&with(&[(240, 1000.0)], 1.0), &quiet, 0.25, None), None, "a line that is not clear");
    }
}
