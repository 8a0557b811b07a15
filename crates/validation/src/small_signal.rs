//! Test whether a record is linear, as the identification of a linear block requires.
//!
//! - Residual: the smallest free-run residual of linear blocks up to order 12, by least squares and, if that is large,
//!   by output error. Noise is subtracted: with periodic input the noise between periods, and the mean period is
//!   tested; otherwise all of the residual that is uncorrelated with the input (`residual_noise.rs`).
//! - Detection limit: with sigma the noise rms in n independent samples, distortion of sigma (8 / n)^(1/4) adds to
//!   sigma^2 two standard deviations of the mean square, sqrt(8 / n) sigma^2; less is not detected.
//! - Gain over level: y = c0 + c1 s + c2 s^2 + c3 s^3, with s the output of the best block, scaled to -1 to 1. The gain
//!   changes by 4 c2 / c1 from the lower to the upper end (even), and by 3 c3 / c1 from the middle to the ends (odd).
//! - Gain over amplitude: the slopes of loops of different height.
//! - Lines not excited by the input: output at even and odd harmonics between the excited ones is distortion, if it
//!   exceeds the noise. A sine shows its harmonics, an odd multisine most; a PRBS excites all.
//!
//! Invalid samples ([`piezoid_records::quality`]) are interpolated. Slow creep is linear, but blocks of this order do
//! not model it: up to 1 % is accepted.
//!
//! Reference: Pintelon & Schoukens 2012, System Identification: A Frequency Domain Approach, chapter 4,
//! doi:10.1002/9781118287422.

use super::LoopComparison;
use super::best_block::MaskedRecord;
use super::bins::band;
use super::floor::Repeated;
use super::loops::loops;
use super::residual_noise::independent;
use libm::{hypot, pow};
use nalgebra::{Matrix4, Vector4};
use piezoid_numerics::error::Error;
use piezoid_numerics::fourier::plain_power;
use piezoid_numerics::number::short;
use piezoid_numerics::series::{centred, largest, scatter};
use piezoid_records::quality::{bridged, inspect};
use piezoid_records::record::Record;
use piezoid_records::waveform::{cycles, period};
use serde::Serialize;

/// Distortion up to which a record counts as linear [% of the output's rms].
const MAX_LINEAR_PERCENT: f64 = 1.0;

/// Distortion from which a record is not linear [% of the output's rms].
const MIN_NONLINEAR_PERCENT: f64 = 3.0;

/// Power of an input line over the strongest, up to which it is not excited.
const MAX_UNEXCITED_POWER_RATIO: f64 = 1e-6;

/// Result of the linearity test. Percentages are of the output's rms about its mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Linearity {
    /// Free-run residual of the best linear block, of the mean period if the input is periodic; `None` if the record
    /// has too few frequencies.
    pub residual_percent: Option<f64>,
    /// Noise per sample, from repeated periods, otherwise the residual of the best block if it is uncorrelated with the
    /// input; `None` if it is not.
    pub noise_percent: Option<f64>,
    /// Distortion below which it is not detected because of noise; `None` if the noise is unknown.
    pub detection_limit_percent: Option<f64>,
    /// Distortion: the largest result of the tests, without noise if that is known.
    pub distortion_percent: f64,
    /// Change of the gain from the lower to the upper end of the range [%].
    pub gain_across_percent: Option<f64>,
    /// Change of the gain from the middle to the ends of the range [%].
    pub gain_outward_percent: Option<f64>,
    /// Slopes of y over u by amplitude at one frequency: pairs (half the input's height, slope).
    pub gain_by_amplitude: Vec<[f64; 2]>,
    /// Output at even harmonics not excited by the input.
    pub even_percent: Option<f64>,
    /// Output at odd harmonics not excited by the input.
    pub odd_percent: Option<f64>,
    /// True if it is suitable as a linear record; `None` if noise hides it.
    pub is_linear: Option<bool>,
    /// The result in words.
    pub verdict: String,
}

impl Linearity {
    /// Tests whether `record` is linear.
    ///
    /// ```
    /// use piezoid::{Record, System, excitation::Prbs, linear::Arx, validation::Linearity};
    /// let u = Prbs { order: 8, ..Prbs::default() }.samples(5e-4, 765)?;
    /// let y = Arx::new(5e-4, vec![1.7, -0.9], vec![1.0, 0.5])?.simulate(&u);
    /// let distorted = y.iter().map(|y| y + 0.02 * y * y).collect();
    /// assert_eq!(Linearity::of(&Record::new(5e-4, u.clone(), y)?)?.is_linear, Some(true));
    /// assert_eq!(Linearity::of(&Record::new(5e-4, u, distorted)?)?.is_linear, Some(false));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Unidentifiable`] if nothing can be identified from the record, or if no linear block fits
    /// and the input is not periodic.
    pub fn of(record: &Record) -> Result<Self, Error> {
        let inspection = inspect(record);
        inspection.require_usable()?;
        let y = bridged(record.y(), &inspection.usable);
        let record = &Record::new(record.ts(), record.u().to_vec(), y)?.with_units(record.units().clone());
        let std = (scatter(record.y()) / record.len() as f64).sqrt();
        let percent = |x: f64| 100.0 * x / std;
        let repeated = period(record.u()).and_then(|p| Repeated::of(record.u(), record.y(), p));
        let unexcited = repeated.as_ref().map(unexcited_lines).unwrap_or_default();
        let masked = match &repeated {
            // The mean period replaces the record, twice: first for the transient.
            Some(r) => {
                let record = Record::new(record.ts(), [&*r.u, &r.u].concat(), [&*r.y, &r.y].concat())?;
                MaskedRecord { usable: vec![true; record.len()], start: r.period, drifts: false, record }
            }
            None => {
                let (usable, start) = (inspection.usable, record.len() / 10);
                MaskedRecord { usable, start, drifts: true, record: record.clone() }
            }
        };
        let (u, y) = (&masked.record.u()[masked.start..], &masked.record.y()[masked.start..]);
        let averaged = repeated.as_ref().map(|r| r.noise / (r.periods as f64).sqrt());
        let closest = masked.closest(hypot(averaged.unwrap_or(0.0), 0.01 * MAX_LINEAR_PERCENT * std));
        let rms = closest.as_ref().map(|c| c.rms);
        // Noise of the tested record, and its number of independent samples.
        let noise = match (averaged, &closest) {
            (Some(noise), _) => Some((noise, u.len() as f64)),
            (None, Some(c)) => independent(u, &c.simulated, &c.errors).map(|n| (c.rms, n)),
            (None, None) => None,
        };
        let detection_limit_percent = noise.map(|(noise, n)| percent(noise) * pow(8.0 / n, 0.25));
        let distorted = rms.map(|rms| percent((rms.powi(2) - noise.map_or(0.0, |n| n.0).powi(2)).max(0.0).sqrt()));
        let [even_percent, odd_percent] = unexcited.map(|rms| rms.map(percent));
        let lines = even_percent.zip(odd_percent).map(|(even, odd)| hypot(even, odd)).or(even_percent).or(odd_percent);
        let Some(distortion_percent) = distorted.into_iter().chain(lines).reduce(f64::max) else {
            let because = "no linear block fits it, and its input is not periodic: use three or more complete periods \
                           of a PRBS or a multisine";
            return Err(Error::Unidentifiable { what: "the linearity of the record".into(), because: because.into() });
        };
        let (gain_across_percent, gain_outward_percent) = closest.map(|c| gain_over_level(&c.simulated, y)).unzip();
        let loops = loops(record, record.y(), &cycles(record.u(), record.ts()));
        let hidden = detection_limit_percent.unwrap_or(0.0);
        let mut linearity = Linearity {
            residual_percent: rms.map(percent),
            noise_percent: repeated.as_ref().map(|r| r.noise).or(noise.map(|n| n.0)).map(percent),
            detection_limit_percent,
            distortion_percent,
            gain_across_percent,
            gain_outward_percent,
            gain_by_amplitude: gain_by_amplitude(&loops),
            even_percent,
            odd_percent,
            is_linear: (distortion_percent > hidden || hidden <= MIN_NONLINEAR_PERCENT)
                .then_some(distortion_percent <= hidden.max(MAX_LINEAR_PERCENT)),
            verdict: String::new(),
        };
        linearity.verdict = linearity.words(&record.units().u, repeated.is_some());
        Ok(linearity)
    }

    fn words(&self, unit: &str, repeats: bool) -> String {
        let limit = self.detection_limit_percent.unwrap_or(0.0);
        let [distortion, hidden] = [self.distortion_percent, limit].map(short);
        let mut text = match (self.is_linear, self.distortion_percent) {
            (None, _) => {
                let noise = self.noise_percent.map_or_else(String::new, short);
                return format!(
                    "cannot tell whether the record is linear: noise is {noise} % of the output's rms and hides \
                     distortion up to {hidden} %; use a larger amplitude or a longer record"
                );
            }
            (Some(true), d) if d <= limit => format!(
                "the record is linear: distortion is below {hidden} % of the output's rms, the noise floor of this test"
            ),
            (Some(true), _) => format!("the record is linear: {distortion} % of the output's rms is distortion"),
            (_, d) if d <= MIN_NONLINEAR_PERCENT => format!(
                "the record is nearly linear: {distortion} % of the output's rms is distortion; below {MAX_LINEAR_PERCENT} % is \
                 recommended"
            ),
            _ => format!(
                "the record is not linear: {distortion} % of the output's rms is distortion; use a smaller amplitude"
            ),
        };
        match (self.residual_percent, self.noise_percent) {
            (Some(left), Some(noise)) if repeats => {
                let [left, noise] = [left, noise].map(short);
                text += &format!(" (residual of the best linear block: {left} % rms of the averaged period; ");
                text += &format!("noise: {noise} % per sample)");
            }
            (Some(left), Some(_)) => {
                text +=
                    &format!(" (residual of the best linear block: {} %, uncorrelated with the input)", short(left));
            }
            (Some(_), None) => {
                text += ", including noise, because the input is not periodic (three periods would separate it)";
            }
            _ => {}
        }
        if let Some((across, outward)) = self.gain_across_percent.zip(self.gain_outward_percent)
            && across.abs().max(outward.abs()) > MAX_LINEAR_PERCENT
        {
            let [across, outward] = [across, outward].map(short);
            text += &format!("; the gain changes by {across} % from one end of the range to the other");
            text += &format!(", and by {outward} % from the middle to the ends");
        }
        if let [first, .., last] = self.gain_by_amplitude.as_slice()
            && first[0] < 0.8 * last[0]
        {
            let change = 100.0 * (last[1] / first[1] - 1.0);
            let [large, change, small] = [last[0], change, first[0]].map(short);
            text +=
                &format!("; the gain at {large} {unit} amplitude differs by {change} % from that at {small} {unit}");
        }
        if let Some((even, odd)) = self.even_percent.zip(self.odd_percent) {
            text += &format!("; harmonics not in the input: {} % even, {} % odd", short(even), short(odd));
        }
        text
    }
}

/// Slopes by amplitude at the frequency with the most amplitudes, because the gain depends on frequency.
fn gain_by_amplitude(loops: &[LoopComparison]) -> Vec<[f64; 2]> {
    let most = loops.chunk_by(|a, b| band(a.hz) == band(b.hz)).max_by_key(|same| same.len()).unwrap_or_default();
    most.iter().map(|l| [l.amplitude, l.measured.slope]).collect()
}

/// Change of the gain across the range, and from its middle to its ends [%].
fn gain_over_level(simulated: &[f64], y: &[f64]) -> (f64, f64) {
    let level = centred(simulated);
    let reach = largest(&level);
    let (mut normal, mut right) = (Matrix4::<f64>::zeros(), Vector4::<f64>::zeros());
    for (s, y) in level.iter().zip(y) {
        let s = s / reach;
        let row = Vector4::new(1.0, s, s * s, s * s * s);
        normal += row * row.transpose();
        right += row * *y;
    }
    let c = normal.lu().solve(&right).unwrap_or_default();
    (400.0 * c[2] / c[1], 300.0 * c[3] / c[1])
}

/// Rms of the mean output period at even and at odd lines not excited by the input, without noise.
fn unexcited_lines(repeated: &Repeated) -> [Option<f64>; 2] {
    let (input, output) = (plain_power(&repeated.u), plain_power(&repeated.y));
    let strongest = input.iter().copied().fold(0.0, f64::max);
    let noise_per_line = repeated.noise.powi(2) / repeated.periods as f64 / input.len() as f64;
    let rms = |parity: usize| {
        let unexcited = |k: &usize| k % 2 == parity && input[*k] <= MAX_UNEXCITED_POWER_RATIO * strongest;
        let lines: Vec<usize> = (1..input.len()).filter(unexcited).collect();
        let power = lines.iter().map(|&k| output[k] - noise_per_line).sum::<f64>();
        // Fewer are not significant: a PRBS may miss a single line.
        (lines.len() >= 3).then(|| power.max(0.0).sqrt())
    };
    [0, 1].map(rms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::system::System;
    use piezoid_records::excitation::{Multisine, Prbs, RisingSine, Sine};
    use piezoid_testing::{assert_close, noise};
    use piezoid_twins::Plant;

    const TS: f64 = 5e-4;

    fn measured(plant: &str, u: Vec<f64>) -> Record {
        let y = Plant::named(plant, TS).unwrap().run(&u).y;
        Record::new(TS, u, y).unwrap()
    }

    #[test]
    fn a_small_prbs_is_linear_and_a_large_sine_is_not_on_every_plant() {
        for plant in piezoid_twins::PLANTS {
            let prbs = Prbs { order: 10, ..Prbs::default() }.samples(TS, 4 * 1023).unwrap();
            let small = Linearity::of(&measured(plant.name, prbs)).unwrap();
            // A volt at the resonance of the oscillator is a large signal.
            let is_linear = !["pl140-nonlinear", "bouc-wen-benchmark"].contains(&plant.name);
            assert_eq!(small.is_linear, Some(is_linear), "{}: {small:?}", plant.name);
            assert_eq!(small.verdict.contains("is linear"), is_linear, "{}: {small:?}", plant.name);
            let amplitude = 0.93 * plant.spec().driver.max_v;
            let sine = Sine { amplitude, frequency: 5.0, ..Sine::default() }.samples(TS, 4000).unwrap();
            let large = Linearity::of(&measured(plant.name, sine)).unwrap();
            assert!(large.is_linear == Some(false) && large.odd_percent.unwrap() > 1.0, "{}: {large:?}", plant.name);
        }
    }

    #[test]
    fn a_square_gives_even_and_a_cube_odd_harmonics() {
        let odd = Multisine {
            amplitude: 1.0,
            frequency_low: 1.0,
            frequency_high: 100.0,
            period: 1.0,
            odd: true,
            ..Multisine::default()
        };
        let u = odd.samples(TS, 8000).unwrap();
        let of = |f: fn(f64) -> f64| {
            Linearity::of(&Record::new(TS, u.clone(), u.iter().map(|u| f(*u)).collect()).unwrap()).unwrap()
        };
        let (plain, square, cube) =
            (of(|u| 33.0 * u), of(|u| 33.0 * u + 5.0 * u * u), of(|u| 33.0 * u + 9.0 * u * u * u));
        assert!(plain.is_linear == Some(true) && plain.distortion_percent < 1e-6, "{plain:?}");
        assert!(square.even_percent > Some(3.0) && square.odd_percent < Some(1e-6), "{square:?}");
        assert!(cube.odd_percent > Some(1.0) && cube.even_percent < Some(1e-6), "{cube:?}");
        assert_eq!((square.is_linear, cube.is_linear), (Some(false), Some(false)));
        assert_close(&[square.gain_across_percent.unwrap()], &[400.0 * 5.0 / 33.0], 0.1, 0.0);
        assert!(cube.gain_outward_percent.unwrap() > 30.0 && cube.gain_across_percent.unwrap().abs() < 5.0, "{cube:?}");
    }

    #[test]
    fn the_gain_increases_with_the_amplitude_of_loops() {
        let rising = RisingSine { amplitude: 30.0, frequency: 5.0, ..RisingSine::default() }.samples(TS, 8000).unwrap();
        let linearity = Linearity::of(&measured("pl140", rising)).unwrap();
        let slopes: Vec<f64> = linearity.gain_by_amplitude.iter().map(|[_, slope]| *slope).collect();
        assert!(slopes.len() > 3 && slopes.is_sorted(), "{slopes:?}");
        assert!(
            linearity.is_linear == Some(false) && linearity.verdict.contains("the gain at"),
            "{}",
            linearity.verdict
        );
    }

    #[test]
    fn noise_is_not_distortion_if_the_input_is_periodic() {
        let prbs = Prbs { order: 9, ..Prbs::default() }.samples(TS, 6 * 511).unwrap();
        let sound = measured("pl140", prbs);
        let noisy = sound.y().iter().enumerate().map(|(t, y)| y + 3.0 * ((t * t * 7) as f64).sin()).collect();
        let linearity = Linearity::of(&Record::new(TS, sound.u().to_vec(), noisy).unwrap()).unwrap();
        assert!(
            linearity.noise_percent > Some(5.0 * MAX_LINEAR_PERCENT) && linearity.is_linear == Some(true),
            "{linearity:?}"
        );
    }

    fn with_noise(record: &Record, size: f64) -> Record {
        let y = record.y().iter().zip(noise(3, record.len())).map(|(y, e)| y + size * e).collect();
        Record::new(record.ts(), record.u().to_vec(), y).unwrap()
    }

    #[test]
    fn noise_and_a_delay_at_a_high_sampling_rate_are_not_distortion() {
        let u = Prbs { order: 13, amplitude: 3.0, offset: 20.0, ..Prbs::default() }.samples(2e-5, 8000).unwrap();
        let block = Arx::new(2e-5, vec![1.975, -0.9915], [vec![0.0; 7], vec![0.01]].concat()).unwrap();
        let y = block.resume(&mut block.settled(20.0), &u);
        let plain = Record::new(2e-5, u, y).unwrap();
        let std = (scatter(plain.y()) / 8000.0).sqrt();
        let linearity = Linearity::of(&with_noise(&plain, 0.04 * std)).unwrap();
        assert!(
            linearity.is_linear == Some(true) && linearity.verdict.contains("the record is linear"),
            "{linearity:?}"
        );
        assert_close(&[linearity.noise_percent.unwrap()], &[4.0], 0.05, 0.0);
        assert!(linearity.detection_limit_percent < Some(MAX_LINEAR_PERCENT), "{linearity:?}");
        let distorted = plain.y().iter().map(|y| y + 0.2 * (y - 12.0).powi(2) / std).collect();
        let distorted =
            Linearity::of(&with_noise(&Record::new(2e-5, plain.u().to_vec(), distorted).unwrap(), 0.04 * std)).unwrap();
        assert!(
            distorted.is_linear == Some(false) && distorted.distortion_percent > MIN_NONLINEAR_PERCENT,
            "{distorted:?}"
        );
    }

    #[test]
    fn spikes_are_not_distortion() {
        let sound = measured("pl140", Prbs { order: 12, ..Prbs::default() }.samples(TS, 4000).unwrap());
        for spikes in [vec![1900], (100..4000).step_by(430).collect()] {
            let mut y = sound.y().to_vec();
            spikes.iter().for_each(|t| y[*t] += 2000.0);
            let linearity = Linearity::of(&Record::new(TS, sound.u().to_vec(), y).unwrap()).unwrap();
            assert!(
                linearity.is_linear == Some(true) && linearity.residual_percent < Some(MAX_LINEAR_PERCENT),
                "{linearity:?}"
            );
        }
    }

    #[test]
    fn linearity_is_unknown_for_a_prbs_below_the_noise() {
        let once = Prbs { order: 12, ..Prbs::default() }.samples(TS, 4000).unwrap();
        let again = Prbs { order: 9, ..Prbs::default() }.samples(TS, 6 * 511).unwrap();
        for u in [once, again] {
            let sound = measured("pl140", u);
            let std = (scatter(sound.y()) / sound.len() as f64).sqrt();
            let linearity = Linearity::of(&with_noise(&sound, 2.0 * std)).unwrap();
            assert_eq!(linearity.is_linear, None, "{linearity:?}");
            assert!(linearity.verdict.contains("hides distortion up to"), "{}", linearity.verdict);
            assert!(
                linearity.noise_percent > Some(80.0) && linearity.detection_limit_percent > Some(MIN_NONLINEAR_PERCENT),
                "{linearity:?}"
            );
        }
    }

    #[test]
    fn hysteresis_is_detected_in_noise_without_periodic_input() {
        let multisine = Multisine {
            amplitude: 28.0,
            frequency_low: 1.0,
            frequency_high: 60.0,
            period: 2.0,
            ..Multisine::default()
        };
        let rising = RisingSine { amplitude: 28.0, frequency: 20.0, ..RisingSine::default() };
        for u in [multisine.samples(TS, 4000).unwrap(), rising.samples(TS, 4000).unwrap()] {
            let sound = measured("pl140", u);
            let std = (scatter(sound.y()) / sound.len() as f64).sqrt();
            let linearity = Linearity::of(&with_noise(&sound, 0.01 * std)).unwrap();
            assert!(linearity.is_linear == Some(false) && linearity.verdict.contains("not linear"), "{linearity:?}");
        }
    }

    #[test]
    fn the_gain_over_the_level_is_that_of_a_cubic_through_the_free_run() {
        let level: Vec<f64> = (-10..=10).map(|k| 0.1 * f64::from(k)).collect();
        let simulated: Vec<f64> = level.iter().map(|s| 4.0 * s + 50.0).collect();
        let y: Vec<f64> = level.iter().map(|s| 2.0 + 3.0 * s + 0.5 * s * s + 0.2 * s * s * s).collect();
        let (across, outward) = gain_over_level(&simulated, &y);
        assert_close(&[across, outward], &[200.0 / 3.0, 20.0], 1e-9, 0.0);
    }

    #[test]
    fn lines_that_the_input_does_not_excite_are_measured_without_noise_if_there_are_three() {
        let sine = |line: usize, n: usize, t: usize| (std::f64::consts::TAU * (line * t) as f64 / n as f64).sin();
        let u: Vec<f64> = (0..64).map(|t| sine(3, 64, t)).collect();
        let y = (0..64).map(|t| u[t] + 0.2 * sine(4, 64, t) + 0.3 * sine(5, 64, t)).collect();
        let repeated = Repeated { period: 64, periods: 3, u, y, noise: 0.33 };
        // Each of 33 lines has 0.33^2 / 3 / 33 of noise: 16 even ones, 15 odd ones beside the third.
        let expected = [(0.02f64 - 16.0 * 0.0011).sqrt(), (0.045f64 - 15.0 * 0.0011).sqrt()];
        assert_close(&unexcited_lines(&repeated).map(Option::unwrap), &expected, 1e-9, 0.0);
        let u: Vec<f64> = (0..12).map(|t| sine(1, 12, t)).collect();
        let [even, odd] = unexcited_lines(&Repeated { period: 12, periods: 3, y: u.clone(), u, noise: 0.0 });
        assert!(even.is_some_and(|even| even < 1e-9) && odd.is_none(), "{even:?} {odd:?}");
    }

    #[test]
    fn the_words_state_the_result_and_what_shows_it() {
        let plain = Linearity {
            residual_percent: None,
            noise_percent: None,
            detection_limit_percent: None,
            distortion_percent: 0.5,
            gain_across_percent: None,
            gain_outward_percent: None,
            gain_by_amplitude: Vec::new(),
            even_percent: None,
            odd_percent: None,
            is_linear: Some(true),
            verdict: String::new(),
        };
        let of = |distortion_percent: f64, limit: Option<f64>, is_linear: Option<bool>| {
            let noise_percent = Some(50.0);
            let detection_limit_percent = limit;
            Linearity { distortion_percent, noise_percent, detection_limit_percent, is_linear, ..plain.clone() }
        };
        for (linearity, says) in [
            (of(0.5, Some(0.6), Some(true)), "the record is linear: distortion is below 0.6000 % of the output's rms"),
            (of(0.6, Some(0.5), Some(true)), "the record is linear: 0.6000 % of the output's rms is distortion"),
            (of(2.9, None, Some(false)), "the record is nearly linear: 2.900 % of the output's rms is distortion"),
            (of(3.1, None, Some(false)), "the record is not linear: 3.100 % of the output's rms is distortion"),
            (
                of(0.5, Some(4.0), None),
                "cannot tell whether the record is linear: noise is 50.00 % of the output's rms",
            ),
        ] {
            let words = linearity.words("V", false);
            assert!(words.starts_with(says), "{words}");
        }
        let found = Linearity { residual_percent: Some(2.0), noise_percent: Some(1.0), ..plain.clone() };
        let block = " (residual of the best linear block: 2.000 %";
        let start = "the record is linear: 0.5000 % of the output's rms is distortion";
        let average = format!("{start}{block} rms of the averaged period; noise: 1.000 % per sample)");
        assert_eq!(found.words("V", true), average);
        assert_eq!(found.words("V", false), format!("{start}{block}, uncorrelated with the input)"));
        let unknown = Linearity { noise_percent: None, ..found };
        assert!(unknown.words("V", true).starts_with(&format!("{start}, including noise, because")));
        let gains = |across: f64, outward: f64, amplitudes: [f64; 2]| {
            let (gain_across_percent, gain_outward_percent) = (Some(across), Some(outward));
            let gain_by_amplitude = vec![[amplitudes[0], 10.0], [5.0, 1.0], [amplitudes[1], 11.0]];
            let shown = Linearity { gain_across_percent, gain_outward_percent, gain_by_amplitude, ..plain.clone() }
                .words("V", false);
            shown.strip_prefix(start).unwrap().to_string()
        };
        assert_eq!(gains(0.9, -0.9, [1.7, 2.0]), "");
        let levels = "; the gain changes by 0.5000 % from one end of the range to the other, and by -1.100 % from the \
                      middle to the ends";
        assert_eq!(gains(0.5, -1.1, [1.7, 2.0]), levels);
        let amplitudes = "; the gain at 2.000 V amplitude differs by 10.00 % from that at 1.500 V";
        assert_eq!(gains(0.5, 0.9, [1.5, 2.0]), amplitudes);
        let lines = Linearity { even_percent: Some(0.1), odd_percent: Some(0.2), ..plain };
        assert!(lines.words("V", false).ends_with("; harmonics not in the input: 0.1000 % even, 0.2000 % odd"));
    }
}
