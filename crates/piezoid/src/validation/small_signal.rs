//! Whether a record is linear, as one must be that a linear block is identified from.
//!
//! - What linear blocks leave: the least that any of orders up to 12 leaves in free run, with the noise of the sensor taken
//!   off where the input repeats and shows it; then the mean period is looked at.
//! - Gain over level: y = c0 + c1 s + c2 s^2 + c3 s^3 over s, the best block's output from -1 to 1. The gain at the upper
//!   end differs from that at the lower by 4 c2 / c1 (even), and at the ends from the middle by 3 c3 / c1 (odd).
//! - Gain over amplitude: the slopes of loops of different height.
//! - Lines that the input does not excite: what comes back at even and odd harmonics between the excited ones is
//!   distortion, if it exceeds the noise. A sine shows its harmonics, an odd multisine most; a PRBS excites all.
//!
//! Slow creep is linear, and yet no block of such order follows it: up to 1 % passes.
//!
//! Reference: Pintelon & Schoukens 2012, System Identification: A Frequency Domain Approach, chapter 4,
//! doi:10.1002/9781118287422.

use super::bins::band;
use super::floor::Repeated;
use super::loops::loops;
use super::{Loops, Run};
use crate::error::Error;
use crate::fourier::plain_power;
use crate::linear::{self, Arx, Orders};
use crate::number::short;
use crate::optimize::swarm;
use crate::progress::unwatched;
use crate::record::Record;
use crate::series::{mean, scatter};
use crate::system::System;
use crate::waveform::cycles;
use nalgebra::{Matrix4, Vector4};
use serde::Serialize;

/// Distortion up to which a record counts as linear [% of the output's rms].
const LINEAR: f64 = 1.0;

/// Distortion from which it is of no use as a linear one [% of the output's rms].
const BENT: f64 = 3.0;

/// Orders tried.
const ORDERS: [usize; 5] = [2, 4, 6, 8, 12];

/// Power of a line of the input, against the strongest, up to which it is not excited.
const DARK: f64 = 1e-6;

/// Whether a record is linear, and by how much not. Percentages are of the output's rms about its mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Linearity {
    /// What the best linear block leaves in free run, of the mean period where the input repeats; none where the record holds too few frequencies for any.
    pub left_percent: Option<f64>,
    /// Noise of a sample, from repeated periods; none where the input does not repeat.
    pub noise_percent: Option<f64>,
    /// What is neither linear nor, where that is known, noise: the largest of what the tests below and above say.
    pub distortion_percent: f64,
    /// Gain at the upper end of the range against that at the lower [%].
    pub gain_across_percent: Option<f64>,
    /// Gain at the ends of the range against that in the middle [%].
    pub gain_outward_percent: Option<f64>,
    /// Slopes of y over u by amplitude at one frequency: pairs of half the input's height and slope.
    pub gain_by_amplitude: Vec<[f64; 2]>,
    /// Output at even harmonics that the input leaves dark.
    pub even_percent: Option<f64>,
    /// Output at odd harmonics that the input leaves dark.
    pub odd_percent: Option<f64>,
    /// Whether it may serve as a linear record.
    pub is_linear: bool,
    /// All this in words.
    pub verdict: String,
}

/// Judges whether `record` is linear.
///
/// ```
/// use piezoid::{Record, System, excitation::Prbs, linear::Arx, validation::small_signal};
/// let u = Prbs { order: 8, ..Prbs::default() }.samples(5e-4, 765)?;
/// let y = Arx::new(5e-4, vec![1.7, -0.9], vec![1.0, 0.5])?.simulate(&u);
/// let bent = y.iter().map(|y| y + 0.02 * y * y).collect();
/// assert!(small_signal(&Record::new(5e-4, u.clone(), y)?)?.is_linear);
/// assert!(!small_signal(&Record::new(5e-4, u, bent)?)?.is_linear);
/// # Ok::<(), piezoid::Error>(())
/// ```
///
/// # Errors
/// [`Error::Unidentifiable`] when nothing can be said: no linear block fits, and the input does not repeat.
pub fn small_signal(record: &Record) -> Result<Linearity, Error> {
    let std = (scatter(record.y()) / record.len() as f64).sqrt();
    let percent = |x: f64| 100.0 * x / std;
    let repeated = Repeated::of(record);
    let noise_percent = repeated.as_ref().map(|r| percent(r.noise));
    let dark = repeated.as_ref().map(dark_lines);
    // Where the input repeats, the mean period stands for the record, twice over: once to get under way.
    let averaged = match &repeated {
        Some(r) => Record::new(record.ts(), [&*r.u, &r.u].concat(), [&*r.y, &r.y].concat())?,
        None => record.clone(),
    };
    let start = if repeated.is_some() { averaged.len() / 2 } else { averaged.len() / 10 };
    let best = best_block(&averaged, start);
    let left_percent = best.as_ref().map(|(_, left)| percent(*left));
    let noise = repeated.as_ref().map_or(0.0, |r| percent(r.noise) / (r.periods as f64).sqrt());
    let bent = left_percent.map(|left| (left.powi(2) - noise.powi(2)).max(0.0).sqrt());
    let (even_percent, odd_percent) = (dark.and_then(|d| d.even).map(percent), dark.and_then(|d| d.odd).map(percent));
    let lines = even_percent.zip(odd_percent).map(|(even, odd)| even.hypot(odd)).or(even_percent).or(odd_percent);
    let Some(distortion_percent) = bent.into_iter().chain(lines).reduce(f64::max) else {
        return Err(Error::Unidentifiable {
            what: "whether the record is linear".into(),
            because:
                "no linear block can be fitted to it and its input does not repeat; use whole periods of a PRBS or a \
                      multisine, three or more"
                    .into(),
        });
    };
    let gains = best.map(|(simulated, _)| gain_over_level(&simulated, &averaged.y()[start..]));
    let run = Run { record, simulated: record.y(), cycles: &cycles(record.u(), record.ts()) };
    let mut linearity = Linearity {
        left_percent,
        noise_percent,
        distortion_percent,
        gain_across_percent: gains.map(|(across, _)| across),
        gain_outward_percent: gains.map(|(_, outward)| outward),
        gain_by_amplitude: gain_by_amplitude(&loops(&run)),
        even_percent,
        odd_percent,
        is_linear: distortion_percent <= LINEAR,
        verdict: String::new(),
    };
    linearity.verdict = linearity.words(&record.units().u);
    Ok(linearity)
}

impl Linearity {
    fn words(&self, unit: &str) -> String {
        let distortion = short(self.distortion_percent);
        let mut text = match self.distortion_percent {
            d if d <= LINEAR => format!("the record is linear: {distortion} % of the output's rms is distortion"),
            d if d <= BENT => format!(
                "the record is nearly linear: {distortion} % of the output's rms is distortion, better below {LINEAR} %"
            ),
            _ => format!(
                "the record is not linear: {distortion} % of the output's rms is distortion; drive it with less amplitude"
            ),
        };
        match (self.left_percent, self.noise_percent) {
            (Some(left), Some(noise)) => {
                text += &format!(
                    " (the best linear block leaves {} % of the mean period; a sample has {} % of noise)",
                    short(left),
                    short(noise)
                );
            }
            (Some(_), None) => text += ", noise included, as the input does not repeat",
            _ => {}
        }
        if let Some((across, outward)) = self.gain_across_percent.zip(self.gain_outward_percent)
            && across.abs().max(outward.abs()) > LINEAR
        {
            text += &format!(
                "; the gain changes by {} % from one end of the range to the other and by {} % from the middle outward",
                short(across),
                short(outward)
            );
        }
        if let [first, .., last] = self.gain_by_amplitude.as_slice()
            && first[0] < 0.8 * last[0]
        {
            let change = 100.0 * (last[1] / first[1] - 1.0);
            text += &format!(
                "; the gain at {} {unit} is {} % off that at {} {unit}",
                short(last[0]),
                short(change),
                short(first[0])
            );
        }
        if let Some((even, odd)) = self.even_percent.zip(self.odd_percent) {
            text += &format!("; harmonics that the input does not hold: {} % even, {} % odd", short(even), short(odd));
        }
        text
    }
}

/// The free run from `start` on of the linear block that leaves least, with its offset, and the rms that it leaves.
fn best_block(record: &Record, start: usize) -> Option<(Vec<f64>, f64)> {
    let least_squares = linear::estimator("least-squares").ok()?;
    let plain = Orders { na: 0, nb: 2, delay: 0 };
    let fits = ORDERS.map(Orders::of).into_iter().chain([plain]).filter_map(|orders| {
        let settings = swarm::Settings::default();
        let fit = linear::fit(std::slice::from_ref(record), orders, least_squares, &settings, &mut unwatched).ok()?;
        let arx: Arx = fit.arx.is_stable().then_some(fit.arx)?;
        let mut simulated = arx.resume(&mut arx.settled(record.u()[0]), record.u());
        simulated.drain(..start);
        let errors: Vec<f64> = record.y()[start..].iter().zip(&simulated).map(|(y, s)| y - s).collect();
        let offset = mean(&errors);
        simulated.iter_mut().for_each(|s| *s += offset);
        let left = (scatter(&errors) / errors.len() as f64).sqrt();
        left.is_finite().then_some((simulated, left))
    });
    fits.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Slopes by amplitude at the frequency that has loops of most amplitudes: between frequencies the gain differs anyway.
fn gain_by_amplitude(loops: &[Loops]) -> Vec<[f64; 2]> {
    let most = loops.chunk_by(|a, b| band(a.hz) == band(b.hz)).max_by_key(|same| same.len()).unwrap_or_default();
    most.iter().map(|l| [l.amplitude, l.measured.slope]).collect()
}

/// How the gain changes across the range and from its middle outward [%].
fn gain_over_level(simulated: &[f64], y: &[f64]) -> (f64, f64) {
    let middle = mean(simulated);
    let reach = simulated.iter().fold(0.0, |m: f64, s| m.max((s - middle).abs()));
    let (mut normal, mut right) = (Matrix4::<f64>::zeros(), Vector4::<f64>::zeros());
    for (s, y) in simulated.iter().zip(y) {
        let s = (s - middle) / reach;
        let row = Vector4::new(1.0, s, s * s, s * s * s);
        normal += row * row.transpose();
        right += row * *y;
    }
    let c = normal.lu().solve(&right).unwrap_or_default();
    (400.0 * c[2] / c[1], 300.0 * c[3] / c[1])
}

/// Rms of the mean period of the output at even and odd lines that the input leaves dark, noise taken off.
#[derive(Debug, Clone, Copy)]
struct Dark {
    even: Option<f64>,
    odd: Option<f64>,
}

fn dark_lines(repeated: &Repeated) -> Dark {
    let (input, output) = (plain_power(&repeated.u), plain_power(&repeated.y));
    let strongest = input.iter().copied().fold(0.0, f64::max);
    let noise_a_line = repeated.noise.powi(2) / repeated.periods as f64 / input.len() as f64;
    let rms = |parity: usize| {
        let lines: Vec<usize> = (1..input.len()).filter(|k| k % 2 == parity && input[*k] <= DARK * strongest).collect();
        let power = lines.iter().map(|&k| output[k] - noise_a_line).sum::<f64>();
        // Fewer tell nothing: a PRBS leaves the odd line dark by chance.
        (lines.len() >= 3).then(|| power.max(0.0).sqrt())
    };
    Dark { even: rms(0), odd: rms(1) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{Multisine, Prbs, RisingSine, Sine};
    use crate::plant::{Plant, find};
    use crate::testing::assert_close;

    const TS: f64 = 5e-4;

    fn measured(plant: &str, u: Vec<f64>) -> Record {
        let y = Plant::new(&(find(plant).unwrap().spec)(), TS).unwrap().run(&u).y;
        Record::new(TS, u, y.iter().map(|y| 1e6 * y).collect()).unwrap()
    }

    #[test]
    fn a_small_prbs_on_every_bender_is_linear_and_a_large_sine_on_none() {
        for plant in crate::plant::PLANTS {
            let prbs = Prbs { order: 10, ..Prbs::default() }.samples(TS, 4 * 1023).unwrap();
            let small = small_signal(&measured(plant.name, prbs)).unwrap();
            assert!(small.is_linear && small.verdict.contains("is linear"), "{}: {small:?}", plant.name);
            let sine = Sine { amplitude: 28.0, frequency: 5.0, ..Sine::default() }.samples(TS, 4000).unwrap();
            let large = small_signal(&measured(plant.name, sine)).unwrap();
            assert!(!large.is_linear && large.odd_percent.unwrap() > 1.0, "{}: {large:?}", plant.name);
        }
    }

    #[test]
    fn a_square_shows_as_even_and_a_cube_as_odd() {
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
            small_signal(&Record::new(TS, u.clone(), u.iter().map(|u| f(*u)).collect()).unwrap()).unwrap()
        };
        let (plain, square, cube) =
            (of(|u| 33.0 * u), of(|u| 33.0 * u + 5.0 * u * u), of(|u| 33.0 * u + 9.0 * u * u * u));
        assert!(plain.is_linear && plain.distortion_percent < 1e-6, "{plain:?}");
        assert!(square.even_percent > Some(3.0) && square.odd_percent < Some(1e-6) && !square.is_linear, "{square:?}");
        assert!(cube.odd_percent > Some(1.0) && cube.even_percent < Some(1e-6) && !cube.is_linear, "{cube:?}");
        assert_close(&[square.gain_across_percent.unwrap()], &[400.0 * 5.0 / 33.0], 0.1, 0.0);
        assert!(cube.gain_outward_percent.unwrap() > 30.0 && cube.gain_across_percent.unwrap().abs() < 5.0, "{cube:?}");
    }

    #[test]
    fn the_gain_of_growing_loops_grows_and_the_verdict_says_so() {
        let rising = RisingSine { amplitude: 30.0, frequency: 5.0, ..RisingSine::default() }.samples(TS, 8000).unwrap();
        let seen = small_signal(&measured("pl140", rising)).unwrap();
        let slopes: Vec<f64> = seen.gain_by_amplitude.iter().map(|[_, slope]| *slope).collect();
        assert!(slopes.len() > 3 && slopes.is_sorted(), "{slopes:?}");
        assert!(!seen.is_linear && seen.verdict.contains("the gain at"), "{}", seen.verdict);
    }

    #[test]
    fn noise_is_not_taken_for_distortion_where_the_input_repeats() {
        let prbs = Prbs { order: 9, ..Prbs::default() }.samples(TS, 6 * 511).unwrap();
        let sound = measured("pl140", prbs);
        let noisy = sound.y().iter().enumerate().map(|(t, y)| y + 3.0 * ((t * t * 7) as f64).sin()).collect();
        let seen = small_signal(&Record::new(TS, sound.u().to_vec(), noisy).unwrap()).unwrap();
        assert!(seen.noise_percent > Some(5.0 * LINEAR) && seen.is_linear, "{seen:?}");
    }
}
