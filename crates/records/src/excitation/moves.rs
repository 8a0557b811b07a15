//! Moves: a path through given points, with a move of minimum jerk from each to the next.
//!
//! `u = offset + amplitude (p + (q - p) m(x))` between the heights p and q, with `m(x) = x^3 (10 - 15 x + 6 x^2)` and x
//! from 0 to 1. The points are evenly spread from the first sample to the last. Speed and acceleration are 0 at every
//! point. It is a reference rather than a drive: it shows what an application asks for.
//!
//! Reference: Flash and Hogan, J. Neurosci. 5, 1688 (1985), DOI 10.1523/JNEUROSCI.05-07-01688.1985.

use super::Excitation;
use super::drive::Drive;
use super::rows::{AMPLITUDE, OFFSET, OptionKind, OptionRow, Options, options};
use piezoid_numerics::error::Error;

options! {
    /// Moves from point to point.
    pub(super) struct Moves {
        /// Heights of the points, two or more, as shares of the amplitude from -1 to 1.
        points: Vec<f64> = vec![0.0, 1.0, -1.0, 0.0], OptionRow::new(OptionKind::Numbers);
        /// Amplitude: the largest height that a point can have.
        amplitude: f64 = 1.0, AMPLITUDE;
        /// Voltage that the excitation is centred on.
        offset: f64 = 0.0, OFFSET;
    }
}

/// From 0 to 1 with the least jerk.
pub fn minimum_jerk(x: f64) -> f64 {
    x * x * x * (10.0 + x * (6.0 * x - 15.0))
}

impl Moves {
    /// `n` samples [V], every `ts` [s].
    fn samples(&self, ts: f64, n: usize) -> Result<Vec<f64>, Error> {
        let drive = Drive::new(self.amplitude, self.offset, ts)?;
        if self.points.len() < 2 {
            return Err(Error::parameter("points", self.points.len(), "must be two or more heights"));
        }
        if let Some(outside) = self.points.iter().find(|p| p.abs() > 1.0) {
            return Err(Error::parameter("points", outside, "must be from -1 to 1: shares of the amplitude"));
        }
        let (moves, last) = (self.points.len() - 1, (n - 1).max(1));
        let height = |t: usize| {
            let from = (t * moves / last).min(moves - 1);
            let [p, q] = [self.points[from], self.points[from + 1]];
            let x = (t * moves - from * last) as f64 / last as f64;
            drive.voltage(p + (q - p) * minimum_jerk(x))
        };
        Ok((0..n).map(height).collect())
    }
}

pub(super) const ROW: Excitation = Excitation {
    name: "moves",
    summary: "moves of minimum jerk through given points: a path that an actuator can follow",
    reference: "Flash and Hogan, J. Neurosci. 5, 1688 (1985), DOI 10.1523/JNEUROSCI.05-07-01688.1985",
    rows: Moves::rows,
    generate: |arguments, ts, n| Moves::from_json(arguments)?.samples(ts, n),
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_passes_through_its_points_and_stands_still_there() {
        let points = vec![-0.5, 1.0, 0.25, 0.25];
        let moves = Moves { points: points.clone(), amplitude: 8.0, offset: 1.0 };
        let u = moves.samples(1e-3, 301).unwrap();
        for (k, p) in points.iter().enumerate() {
            assert_eq!(u[100 * k], 1.0 + 8.0 * p);
            // Close to a point, a move has come as far as the third power of the time.
            let near = [(100 * k).checked_sub(1), (k < 3).then_some(100 * k + 1)];
            assert!(near.into_iter().flatten().all(|t| (u[t] - u[100 * k]).abs() < 8.0 * 1.5 * 1e-5), "{k}");
        }
        assert!((u[50] - 3.0).abs() < 1e-12, "half way at half the time");
    }

    #[test]
    fn any_number_of_samples_and_points_makes_a_path() {
        for (n, count) in [(1, 2), (2, 9), (3, 2), (1000, 40)] {
            let moves = Moves { points: (0..count).map(|k| f64::from(k % 2)).collect(), ..Moves::default() };
            let u = moves.samples(1e-3, n).unwrap();
            assert!(u.len() == n && u[0] == 0.0 && u.iter().all(|u| (0.0..=1.0).contains(u)), "{n}, {count}");
        }
    }

    #[test]
    fn points_that_make_no_path_are_refused() {
        let refused = |points| Moves { points, ..Moves::default() }.samples(1e-3, 10).unwrap_err().to_string();
        assert!(refused(vec![1.0]).starts_with("points = 1: must be two or more"));
        assert!(refused(vec![0.0, -1.5]).starts_with("points = -1.5: must be from -1 to 1"));
    }
}
