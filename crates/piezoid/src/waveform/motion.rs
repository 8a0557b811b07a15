//! How an input begins.

use crate::series::ends;

/// Share of its range by which an input counts as having moved, or as being off zero.
const MOVED: f64 = 0.02;

/// Whether a record with inputs `u` begins in motion: off zero, and moving as it does on average. An input stands where it
/// has not moved by a fiftieth of its range in the time in which on average it moves a fifth.
pub(crate) fn in_motion(u: &[f64]) -> bool {
    let (low, high) = ends(u.iter().copied());
    let least = MOVED * (high - low);
    let path: f64 = u.windows(2).map(|w| (w[1] - w[0]).abs()).sum();
    let a_fifth = 0.2 * (high - low) * (u.len() - 1) as f64 / path;
    let soon = (a_fifth as usize).clamp(1, u.len().max(2) - 1);
    u[0].abs() > least && u.iter().take(soon + 1).any(|v| (v - u[0]).abs() > least)
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
}
