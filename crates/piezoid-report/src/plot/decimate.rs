//! Decimation: a record of a hundred thousand samples is drawn with a few hundred points.
//!
//! It works on coordinates, after scaling. Lines with increasing x keep the first, lowest, highest and last point of
//! every pixel column, so no peak is lost. Then every line, loops included, is simplified by the method of Douglas and
//! Peucker (doi:10.3138/FM57-6770-U75U-7727) to a tolerance far below the stroke width.

use super::path::Point;
use std::collections::HashSet;

/// Largest deviation of a simplified line [units of the drawing].
const TOLERANCE: f64 = 0.12;
/// Points simplified at a time: limits the work, and keeps one more point per block.
const BLOCK: usize = 512;
/// Largest number of points of a line; beyond it the tolerance increases.
const MAX_LINE_POINTS: usize = 5000;

/// A visually identical line with fewer points.
pub(super) fn line(points: &[Point]) -> Vec<Point> {
    let points = if rises(points) { at(points, &columns(points)) } else { points.to_vec() };
    at(&points, &corners(&points, MAX_LINE_POINTS))
}

/// True if no x is below the one before.
pub(super) fn rises(points: &[Point]) -> bool {
    points.windows(2).all(|w| w[1][0] >= w[0][0])
}

/// The points with these numbers.
fn at(points: &[Point], kept: &[usize]) -> Vec<Point> {
    kept.iter().map(|&k| points[k]).collect()
}

/// The numbers of at most `most` points, whose line is visually identical; more if the line is too restless.
pub(super) fn corners(points: &[Point], most: usize) -> Vec<usize> {
    let mut tolerance = TOLERANCE;
    loop {
        let kept = simplified(points, tolerance);
        if kept.len() <= most || tolerance > 4.0 {
            return kept;
        }
        tolerance *= 1.6;
    }
}

/// At most `most` dots, one per cell of a grid that is coarsened until they are few enough.
pub(super) fn dots(points: &[Point], most: usize) -> Vec<Point> {
    at(points, &cells(points, most))
}

/// The numbers of these dots.
pub(super) fn cells(points: &[Point], most: usize) -> Vec<usize> {
    let mut cell = 0.8;
    loop {
        let mut taken = HashSet::new();
        let place = |p: Point| p.map(|v| (v / cell).floor() as i64);
        let kept: Vec<usize> = (0..points.len()).filter(|&k| taken.insert(place(points[k]))).collect();
        if kept.len() <= most {
            return kept;
        }
        cell *= 1.25;
    }
}

/// Points at least `apart` from each other, for markers.
pub(super) fn markers(points: &[Point], apart: f64) -> Vec<Point> {
    let mut kept: Vec<Point> = Vec::new();
    for p in points {
        if kept.last().is_none_or(|k| (p[0] - k[0]).hypot(p[1] - k[1]) >= apart) {
            kept.push(*p);
        }
    }
    kept
}

/// The numbers of the first, lowest, highest and last point of every pixel column, in their order.
pub(super) fn columns(points: &[Point]) -> Vec<usize> {
    let (mut out, mut first) = (Vec::new(), 0);
    for column in points.chunk_by(|a, b| a[0].floor() == b[0].floor()) {
        let by_height = |&i: &usize, &j: &usize| column[i][1].total_cmp(&column[j][1]);
        let low = (0..column.len()).min_by(by_height).unwrap_or(0);
        let high = (0..column.len()).max_by(by_height).unwrap_or(0);
        let mut keep = [0, low.min(high), low.max(high), column.len() - 1].to_vec();
        keep.dedup();
        out.extend(keep.into_iter().map(|i| first + i));
        first += column.len();
    }
    out
}

/// Douglas-Peucker, block by block.
fn simplified(points: &[Point], tolerance: f64) -> Vec<usize> {
    let mut keep = vec![false; points.len()];
    if let Some(last) = keep.last_mut() {
        *last = true;
    }
    for start in (0..points.len()).step_by(BLOCK) {
        keep[start] = true;
        let mut open = vec![(start, (start + BLOCK).min(points.len() - 1))];
        while let Some((i, j)) = open.pop() {
            let distance = |k: usize| from_segment(points[k], points[i], points[j]);
            let farthest = (i + 1..j).map(|k| (distance(k), k)).max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((d, k)) = farthest
                && d > tolerance
            {
                keep[k] = true;
                open.extend([(i, k), (k, j)]);
            }
        }
    }
    (0..points.len()).filter(|&k| keep[k]).collect()
}

/// Distance of `p` from the segment `a` to `b`.
fn from_segment(p: Point, a: Point, b: Point) -> f64 {
    let (d, q) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length = d[0] * d[0] + d[1] * d[1];
    let along = if length > 0.0 { ((q[0] * d[0] + q[1] * d[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
    (q[0] - along * d[0]).hypot(q[1] - along * d[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lowest_and_highest(points: &[Point]) -> (f64, f64) {
        points.iter().fold((f64::MAX, f64::MIN), |(lo, hi), p| (lo.min(p[1]), hi.max(p[1])))
    }

    #[test]
    fn a_single_spike_in_a_hundred_thousand_samples_is_kept() {
        let mut points: Vec<Point> = (0..100_000).map(|i| [f64::from(i) * 0.005, 100.0]).collect();
        points[31_416][1] = 7.0;
        points[65_537][1] = 193.0;
        let kept = line(&points);
        assert!(kept.len() < 20, "{}", kept.len());
        assert_eq!(lowest_and_highest(&kept), (7.0, 193.0));
    }

    #[test]
    fn noise_keeps_the_envelope_of_every_column() {
        let noise = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 12) / 4096.0;
        let points: Vec<Point> = (0..100_000).map(|i| [f64::from(i) * 0.005, noise(i)]).collect();
        let kept = at(&points, &columns(&points));
        assert!(kept.len() <= 4 * 501);
        for (a, b) in
            points.chunk_by(|a, b| a[0].floor() == b[0].floor()).zip(kept.chunk_by(|a, b| a[0].floor() == b[0].floor()))
        {
            assert_eq!(lowest_and_highest(a), lowest_and_highest(b));
        }
    }

    #[test]
    fn a_loop_run_many_times_keeps_its_shape() {
        let at = |i: i32| (f64::from(i) * 0.02).sin_cos();
        let points: Vec<Point> = (0..50_000).map(|i| [300.0 + 250.0 * at(i).0, 200.0 + 150.0 * at(i).1]).collect();
        let kept = line(&points);
        assert!(kept.len() <= MAX_LINE_POINTS, "{}", kept.len());
        let worst = points[..5000]
            .iter()
            .map(|p| kept.windows(2).map(|w| from_segment(*p, w[0], w[1])).fold(f64::MAX, f64::min))
            .fold(0.0, f64::max);
        assert!(worst < 0.6, "strays {worst}");
    }

    #[test]
    fn dots_are_thinned_evenly() {
        let points: Vec<Point> = (0..100_000).map(|i| [f64::from(i % 500), f64::from(i / 500)]).collect();
        let kept = dots(&points, 3000);
        assert!((1500..=3000).contains(&kept.len()), "{}", kept.len());
        assert!(kept.iter().any(|p| p[0] > 490.0 && p[1] > 190.0));
    }

    #[test]
    fn markers_keep_their_distance() {
        let points: Vec<Point> = (0..100).map(|i| [f64::from(i), 0.0]).collect();
        assert_eq!(markers(&points, 10.0).len(), 10);
    }
}
