//! The main line of the input's spectrum, and how the output follows it there.

use libm::cos;
use nalgebra::Complex;
use piezoid_numerics::complex::argument;
use piezoid_numerics::fourier::{LINE_WIDTH_BINS, windowed};
use std::f64::consts::TAU;

/// An input is a tone if its line has this share of the power.
const MIN_LINE_POWER_SHARE: f64 = 0.7;

/// Fewer periods are a trend, not a line.
const MIN_PERIODS: usize = 5;

/// The line of a tone.
pub(super) struct Tone {
    /// Its frequency [periods/sample].
    pub(super) frequency: f64,
    /// Phase of the output relative to the input [degrees], positive if it leads.
    pub(super) phase: f64,
}

/// The line of the input; `None` if it is not a tone.
pub(super) fn tone(u: &[f64], y: &[f64]) -> Option<Tone> {
    let hann = |t: usize| 1.0 - cos(TAU * (t as f64 + 0.5) / u.len() as f64);
    let [input, output] = [u, y].map(|x| windowed(x, hann).0);
    let power = |k: usize| input[k].norm_sqr();
    let top = (1..input.len()).max_by(|i, j| power(*i).total_cmp(&power(*j)))?;
    let line = top.saturating_sub(LINE_WIDTH_BINS / 2).max(1)..(top + LINE_WIDTH_BINS / 2 + 1).min(input.len());
    let share = line.clone().map(power).sum::<f64>() / (1..input.len()).map(power).sum::<f64>();
    let response: Complex<f64> = line.map(|k| input[k].conj() * output[k]).sum();
    (top >= MIN_PERIODS && share > MIN_LINE_POWER_SHARE)
        .then(|| Tone { frequency: top as f64 / u.len() as f64, phase: argument(response).to_degrees() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tone_has_its_frequency_and_the_phase_of_the_output() {
        let sine = |lead: f64| (0..1000).map(|t| (0.7 * f64::from(t) + lead).sin()).collect::<Vec<f64>>();
        let tone = tone(&sine(0.0), &sine(-0.5)).unwrap();
        assert!((tone.frequency - 0.7 / TAU).abs() < 1e-3, "{}", tone.frequency);
        assert!((tone.phase + 0.5f64.to_degrees()).abs() < 0.1, "{}", tone.phase);
    }

    #[test]
    fn a_trend_and_two_lines_are_no_tones() {
        let trend: Vec<f64> = (0..1000).map(f64::from).collect();
        let lines: Vec<f64> = trend.iter().map(|t| (0.3 * t).sin() + (0.9 * t).sin()).collect();
        assert!(super::tone(&trend, &trend).is_none() && super::tone(&lines, &lines).is_none());
    }
}
