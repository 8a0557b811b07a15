//! The initial movement of an input, and probable inputs before the record.

use piezoid_numerics::series::range;

/// An input has moved, or is not at zero, if the difference exceeds this share of its range.
const MOVED: f64 = 0.02;

/// Maximum number of samples that are compared to find a repetition.
const LONGEST: usize = 64;

/// True if a record with inputs `u` starts in motion: not at zero, and not at rest. An input is at rest if it moves by
/// less than 1/50 of its range in the time in which it moves 1/5 on average.
pub fn in_motion(u: &[f64]) -> bool {
    let Some(&first) = u.first() else { return false };
    let least = MOVED * range(u);
    first.abs() > least && u.iter().take(samples_per_fifth(u) + 1).any(|v| (v - first).abs() > least)
}

/// The sample at which `u` best repeats its start. The inputs before it are probably also those before the record.
fn repetition_start(u: &[f64]) -> usize {
    let n = samples_per_fifth(u).min(LONGEST).min(u.len() / 4);
    let distance = |t: usize| u[t..].iter().zip(&u[..n]).map(|(v, first)| (v - first) * (v - first)).sum::<f64>();
    // After the first movement: before, every slow input resembles its start.
    let candidates = 2 * n..u.len() - n;
    candidates.map(|t| (distance(t), t)).min_by(|p, q| p.0.total_cmp(&q.0)).map_or(0, |(_, t)| t)
}

/// Probable inputs before a record that starts in motion: the record, then the record up to the repetition of its
/// start.
pub fn inputs_before(u: &[f64]) -> Vec<f64> {
    u.iter().chain(&u[..repetition_start(u)]).copied().collect()
}

/// Number of samples in which `u` moves 1/5 of its range on average.
fn samples_per_fifth(u: &[f64]) -> usize {
    let path: f64 = u.windows(2).map(|w| (w[1] - w[0]).abs()).sum();
    let samples = 0.2 * range(u) * (u.len() - 1) as f64 / path;
    (samples as usize).clamp(1, u.len().max(2) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sine(bias: f64, phase: f64) -> Vec<f64> {
        (0..2000).map(|t| bias + 10.0 * (TAU * f64::from(t) / 200.0 + phase).sin()).collect()
    }

    #[test]
    fn a_cut_from_a_sine_is_in_motion_and_a_start_at_zero_or_at_rest_is_not() {
        assert!(in_motion(&sine(50.0, 0.0)) && in_motion(&sine(0.0, 1.0)));
        assert!(!in_motion(&sine(0.0, 0.0)), "from zero");
        let held: Vec<f64> = [7.0; 300].into_iter().chain(sine(7.0, 0.0)).collect();
        assert!(!in_motion(&held) && !in_motion(&[3.0; 50]) && !in_motion(&[3.0]));
    }

    #[test]
    fn a_periodic_input_repeats_its_start_after_a_period() {
        let u = sine(50.0, 1.0);
        assert_eq!(repetition_start(&u) % 200, 0);
        let fading: Vec<f64> = (0..).zip(u).map(|(t, u)| (u - 50.0) * (-f64::from(t) / 3000.0).exp()).collect();
        assert!(repetition_start(&fading).abs_diff(200) < 4, "{}", repetition_start(&fading));
        assert_eq!((repetition_start(&[3.0]), repetition_start(&[3.0, 4.0, 5.0])), (0, 0));
    }
}
