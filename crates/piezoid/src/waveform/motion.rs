//! How an input begins, and what it may have done before.

use crate::series::ends;

/// Share of its range by which an input counts as having moved, or as being off zero.
const MOVED: f64 = 0.02;

/// Samples at most by which two moments are told alike.
const LONGEST: usize = 64;

/// Whether a record with inputs `u` begins in motion: off zero, and moving as it does on average. An input stands where it
/// has not moved by a fiftieth of its range in the time in which on average it moves a fifth.
pub(crate) fn in_motion(u: &[f64]) -> bool {
    let Some(&first) = u.first() else { return false };
    let (low, high) = ends(u.iter().copied());
    let least = MOVED * (high - low);
    first.abs() > least && u.iter().take(samples_per_fifth(u) + 1).any(|v| (v - first).abs() > least)
}

/// The sample from which `u` does most nearly again what it does first: what comes before it may have come before the record.
fn repetition_start(u: &[f64]) -> usize {
    let n = samples_per_fifth(u).min(LONGEST).min(u.len() / 4);
    let apart = |t: &usize| u[*t..].iter().zip(&u[..n]).map(|(v, first)| (v - first) * (v - first)).sum::<f64>();
    // Past its first movement: before, a slow input is always like itself.
    let moments = 2 * n..u.len() - n;
    moments.map(|t| (apart(&t), t)).min_by(|p, q| p.0.total_cmp(&q.0)).map_or(0, |(_, t)| t)
}

/// The inputs before those of a record that began in motion: as in it, and then as in it once more up to its first motion.
pub(crate) fn inputs_before(u: &[f64]) -> Vec<f64> {
    u.iter().chain(&u[..repetition_start(u)]).copied().collect()
}

/// The samples in which `u` moves a fifth of its range, on average.
fn samples_per_fifth(u: &[f64]) -> usize {
    let (low, high) = ends(u.iter().copied());
    let path: f64 = u.windows(2).map(|w| (w[1] - w[0]).abs()).sum();
    let samples = 0.2 * (high - low) * (u.len() - 1) as f64 / path;
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
    fn a_cut_from_a_running_sine_is_in_motion_and_what_starts_from_zero_or_stands_is_not() {
        assert!(in_motion(&sine(50.0, 0.0)) && in_motion(&sine(0.0, 1.0)));
        assert!(!in_motion(&sine(0.0, 0.0)), "from zero");
        let held: Vec<f64> = [7.0; 300].into_iter().chain(sine(7.0, 0.0)).collect();
        assert!(!in_motion(&held) && !in_motion(&[3.0; 50]) && !in_motion(&[3.0]));
    }

    #[test]
    fn a_motion_comes_again_a_turn_later() {
        let u = sine(50.0, 1.0);
        assert_eq!(repetition_start(&u) % 200, 0);
        let fading: Vec<f64> = (0..).zip(u).map(|(t, u)| (u - 50.0) * (-f64::from(t) / 3000.0).exp()).collect();
        assert!(repetition_start(&fading).abs_diff(200) < 4, "{}", repetition_start(&fading));
        assert_eq!((repetition_start(&[3.0]), repetition_start(&[3.0, 4.0, 5.0])), (0, 0));
    }
}
