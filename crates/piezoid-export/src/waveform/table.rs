//! Tables of voltages, each held for whole cycles of a controller, and their errors.
//!
//! ```text
//! v_j = mean of u over the time that point j is held,    period = points x cycles per point x cycle
//! ```
//! The mean is the best held voltage in the least-squares sense. If a point lasts one sample or longer, it also keeps
//! all limits of voltage, slew and current that the drive keeps. If a sample of the drive is a whole number of cycles
//! and all samples fit, the table is the drive. Otherwise the table with the most accurate period is used, then one
//! with whole samples per point, then the one with the most points.
//!
//! The response of a model to a table is that to the mean of the held voltage in each of its samples. It is exact if
//! points last whole samples; otherwise changes within a sample are not represented. If points are shorter than a
//! sample, those completely inside are corrected for those shared with a neighbour, so that each sample keeps its mean.

use super::drive::{Answer, PeriodicDrive, answer};
use crate::template::{Value, context};
use piezoid::{Error, Model, System};
use piezoid_numerics::number::{power, short};
use piezoid_numerics::series::ends;

/// Relative deviation of a sample from whole cycles that counts as zero.
const NONE: f64 = 1e-9;

/// The capacity of a controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct TableCapacity {
    /// Its cycle [s].
    pub(super) cycle: f64,
    /// Largest number of points.
    pub(super) points: usize,
    /// Largest number of cycles per point.
    pub(super) cycles: usize,
}

impl TableCapacity {
    /// Number of points, and cycles per point, for a period of `n` samples every `ts` [s].
    ///
    /// # Errors
    /// [`Error::Unsuited`] for a period that is shorter than two cycles or longer than the table can last.
    pub(super) fn shape(&self, n: usize, ts: f64) -> Result<(usize, usize), Error> {
        let sample = ts / self.cycle;
        let whole = sample.round();
        if n <= self.points && whole >= 1.0 && (sample - whole).abs() <= NONE * whole && whole <= self.cycles as f64 {
            return Ok((n, whole as usize));
        }
        let all = n as f64 * sample;
        let most = if all < self.points as f64 { all as usize } else { self.points };
        if most < 2 || all > self.points as f64 * self.cycles as f64 {
            let [cycle, period] = [self.cycle, n as f64 * ts].map(short);
            let because = format!(
                "a period of {period} s does not fit into 2 to {} points, each held for 1 to {} cycles of {cycle} s",
                self.points, self.cycles
            );
            return Err(Error::Unsuited { what: "table of voltages".into(), because });
        }
        let cycles = |points: usize| ((all / points as f64).round().max(1.0) as usize).min(self.cycles);
        let missed = |points: usize| ((points * cycles(points)) as f64 / all - 1.0).abs() / NONE;
        let best =
            (most.div_ceil(2).max(2)..=most).rev().min_by_key(|&p| (missed(p).round() as u64, !n.is_multiple_of(p)));
        let points = best.unwrap_or(most);
        Ok((points, cycles(points)))
    }
}

/// A table as it is in a file.
pub(super) struct WaveTable {
    /// The points as text.
    pub(super) written: Vec<String>,
    /// The voltages of the points [V].
    pub(super) held: Vec<f64>,
    /// Cycles that each is held for.
    pub(super) cycles: usize,
    /// The cycle [s].
    pub(super) cycle: f64,
}

impl WaveTable {
    /// The drive `u` [V], every `ts` [s], as a controller with capacity `room` holds it. Its numbers have `decimals`
    /// decimals; 0 is `zero` volts, and 1 is `scale` volts more.
    ///
    /// # Errors
    /// The errors of [`TableCapacity::shape`].
    pub(super) fn new(
        room: TableCapacity,
        u: &[f64],
        ts: f64,
        (zero, scale): (f64, f64),
        decimals: usize,
    ) -> Result<Self, Error> {
        let (points, cycles) = room.shape(u.len(), ts)?;
        // Adding 0 removes the sign of -0.
        let digits = power(10.0, decimals as i32);
        let rounded = |v: f64| (digits * (v - zero) / scale).round() / digits + 0.0;
        let values: Vec<f64> = fitted(u, points).into_iter().map(rounded).collect();
        Ok(WaveTable {
            written: values.iter().map(|value| format!("{value:.decimals$}")).collect(),
            held: values.iter().map(|value| zero + scale * value).collect(),
            cycles,
            cycle: room.cycle,
        })
    }

    pub(super) fn template_context(&self) -> Value {
        context! { points => self.written.iter().collect::<Value>(), cycles => self.cycles }
    }

    /// Duration of a point [s].
    pub(super) fn point(&self) -> f64 {
        self.cycles as f64 * self.cycle
    }

    /// The errors of the table.
    pub(super) fn figures(&self, model: &Model, drive: &PeriodicDrive) -> Figures {
        let (n, points) = (drive.u.len(), self.held.len());
        let off =
            |(i, j, length): (usize, usize, usize)| (drive.u[i] - self.held[j], length as f64 / (n * points) as f64);
        let Answer { y, differs } = answer(model, &means(&self.held, n));
        let errors = y.iter().zip(&drive.r).map(|(y, r)| (y - r, 1.0 / n as f64));
        Figures {
            period: points as f64 * self.point() / (n as f64 * model.ts()) - 1.0,
            u: Share::of(overlaps(n, points).map(off), &drive.u),
            y: Share::of(errors, &drive.r),
            differs,
        }
    }
}

/// Errors of a table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Figures {
    /// Relative error of its period.
    pub(super) period: f64,
    /// Error of the held voltage against the drive.
    pub(super) u: Share,
    /// Error of the model's response against the reference.
    pub(super) y: Share,
    /// Difference of two periods of that response, as a share of their stroke.
    pub(super) differs: f64,
}

/// An error in percent of the stroke.
#[derive(Debug, Clone, Copy)]
pub(super) struct Share {
    /// Rms error.
    pub(super) rms: f64,
    /// Largest error.
    pub(super) largest: f64,
}

impl Share {
    /// From errors with their shares of the period, relative to the stroke of `x`.
    fn of(errors: impl Iterator<Item = (f64, f64)>, x: &[f64]) -> Self {
        let (low, high) = ends(x.iter().copied());
        let (squares, largest) =
            errors.fold((0.0, 0.0f64), |(sum, most), (e, weight)| (sum + weight * e * e, most.max(e.abs())));
        Share { rms: 100.0 * squares.sqrt() / (high - low), largest: 100.0 * largest / (high - low) }
    }
}

/// The `n` points for the drive `u`: its means, corrected if they are shorter than its samples.
fn fitted(u: &[f64], n: usize) -> Vec<f64> {
    let mut points = means(u, n);
    let missing: Vec<f64> = u.iter().zip(means(&points, u.len())).map(|(u, mean)| u - mean).collect();
    let inside = || overlaps(u.len(), n).filter(|(_, _, length)| *length == u.len());
    let mut share = vec![0.0; u.len()];
    inside().for_each(|(i, _, length)| share[i] += length as f64 / n as f64);
    inside().for_each(|(i, j, _)| points[j] += missing[i] / share[i]);
    // The extremes of the drive may be limits, so they are kept.
    let (low, high) = ends(u.iter().copied());
    points.iter().map(|v| v.clamp(low, high)).collect()
}

/// Means over `n` equal parts of a period; `x` is held over equal parts of it.
pub(super) fn means(x: &[f64], n: usize) -> Vec<f64> {
    let mut means = vec![0.0; n];
    overlaps(x.len(), n).for_each(|(i, j, length)| means[j] += length as f64 / x.len() as f64 * x[i]);
    means
}

/// The overlaps (i, j, length) of `n` equal parts of a period with `m`, in units of 1 / (n m).
fn overlaps(n: usize, m: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    let (mut i, mut j, mut at) = (0, 0, 0);
    std::iter::from_fn(move || {
        let (first, second) = ((i + 1) * m, (j + 1) * n);
        let end = first.min(second);
        let overlap = (i, j, end - at);
        (i, j, at) = (i + usize::from(first == end), j + usize::from(second == end), end);
        (overlap.0 < n).then_some(overlap)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    const ROOM: TableCapacity = TableCapacity { cycle: 5e-5, points: 1024, cycles: 65535 };

    #[test]
    fn the_table_is_the_drive_if_samples_are_whole_cycles() {
        assert_eq!(ROOM.shape(400, 5e-4).unwrap(), (400, 10));
        assert_eq!(ROOM.shape(1024, 1e-4).unwrap(), (1024, 2));
        let u = [1.25, -0.5, 3.0];
        assert_eq!(means(&u, 3), u);
    }

    #[test]
    fn longer_periods_use_the_largest_number_of_points_of_whole_samples() {
        // 20000 cycles.
        assert_eq!(ROOM.shape(2000, 5e-4).unwrap(), (1000, 20));
        // 15000 cycles in 1000 points would be 1.5 samples each.
        assert_eq!(ROOM.shape(1500, 5e-4).unwrap(), (750, 20));
        // A sample of 2.5 cycles: points are shorter than samples.
        assert_eq!(ROOM.shape(100, 1.25e-4).unwrap(), (250, 1));
    }

    #[test]
    fn other_periods_are_met_within_half_a_thousandth() {
        for (n, ts) in [(1999, 5e-4), (4093, 5e-4), (333, 1.0 / 3000.0), (44100, 1.0 / 44100.0)] {
            let (points, cycles) = ROOM.shape(n, ts).unwrap();
            let off = (points * cycles) as f64 * 5e-5 / (n as f64 * ts) - 1.0;
            assert!((512..=1024).contains(&points) && off.abs() < 5e-4, "{n} {ts}: {points} {cycles} {off}");
        }
    }

    #[test]
    fn periods_that_are_too_short_or_too_long_are_errors() {
        let text = |n, ts| ROOM.shape(n, ts).unwrap_err().to_string();
        assert!(text(3, 3e-5).contains("a period of 9.000e-5 s does not fit into 2 to 1024 points"));
        assert!(text(4000, 1.0).contains("65535 cycles"));
    }

    #[test]
    fn the_mean_is_kept_and_no_limit_is_exceeded() {
        let u: Vec<f64> = (0..91).map(|t| f64::from(t * t % 37)).collect();
        let of = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let step = |x: &[f64]| (0..x.len()).map(|t| (x[t] - x[(t + 1) % x.len()]).abs()).fold(0.0, f64::max);
        for n in [1, 2, 13, 45, 91, 120, 364] {
            let held = means(&u, n);
            assert_close(&[of(&held)], &[of(&u)], 1e-12, 0.0);
            assert!(ends(held.iter().copied()).1 <= ends(u.iter().copied()).1);
            // The slew over the point is at most that over the sample.
            assert!(step(&held) <= step(&u) * (91.0 / n as f64).max(1.0) + 1e-9);
        }
        assert_close(&means(&[1.0, 2.0, 4.0], 2), &[4.0 / 3.0, 10.0 / 3.0], 1e-15, 0.0);
    }

    #[test]
    fn points_shorter_than_a_sample_keep_its_mean_within_the_extremes() {
        let u: Vec<f64> = (0..100).map(|t| (std::f64::consts::TAU * f64::from(t) / 100.0).sin()).collect();
        let off = |points: &[f64]| means(points, 100).iter().zip(&u).map(|(v, u)| (v - u).abs()).fold(0.0, f64::max);
        let points = fitted(&u, 250);
        assert!(off(&means(&u, 250)) > 5e-3 && off(&points) < 3e-4, "{}", off(&points));
        assert_eq!(ends(points), ends(u.iter().copied()));
        assert_eq!(fitted(&u, 100), u);
        assert_eq!(fitted(&u, 50), means(&u, 50));
    }

    #[test]
    fn overlaps_cover_the_period_once() {
        for (n, m) in [(1, 1), (3, 2), (7, 7), (12, 8), (5, 1024)] {
            let all: Vec<_> = overlaps(n, m).collect();
            assert_eq!(all.iter().map(|o| o.2).sum::<usize>(), n * m);
            assert!(all.iter().all(|o| o.0 < n && o.1 < m && o.2 > 0));
        }
    }
}
