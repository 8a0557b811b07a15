//! Places a label along a horizontal line where it covers the least data.

use super::path::Point;
use super::scale::Scale;
use super::series::{Series, SeriesKind};

/// Largest number of points used per series.
const LOOKED_AT: usize = 2000;
/// Number of positions along the line, from right to left.
const PLACES: usize = 12;

/// The upper left corner for a label of size `room` directly above or below a line at height `at`, in the panel from
/// `corner` of `size`. Among equal places, the rightmost above the line wins.
pub(super) fn beside_rule(
    series: &[Series],
    x: &Scale,
    y: &Scale,
    corner: Point,
    size: Point,
    at: f64,
    room: Point,
) -> Point {
    let drawn: Vec<Point> =
        series.iter().filter(|s| s.kind != SeriesKind::Band).flat_map(|s| outline(s, x, y)).collect();
    let (from, to) = (corner[0] + 5.0, corner[0] + size[0] - room[0] - 5.0);
    let above = at - room[1] - 1.0;
    let heights = [above, at + 1.0].into_iter().filter(|h| *h >= corner[1] && h + room[1] <= corner[1] + size[1]);
    let lefts = |i: usize| to.max(from) + (from.min(to) - to.max(from)) * i as f64 / (PLACES - 1) as f64;
    let places = heights.flat_map(|h| (0..PLACES).map(move |i| [lefts(i), h]));
    let covered = |[l, t]: Point| {
        let inside = |p: &&Point| (l - 4.0..l + room[0] + 4.0).contains(&p[0]) && (t..t + room[1]).contains(&p[1]);
        drawn.iter().filter(inside).count()
    };
    places.min_by_key(|place| covered(*place)).unwrap_or([to, above])
}

/// Points along a series, a few units apart.
fn outline(series: &Series, x: &Scale, y: &Scale) -> Vec<Point> {
    let every = series.points.len().div_ceil(LOOKED_AT).max(1);
    let place = |p: &Point| Some([x.at(p[0])?, y.at(p[1])?]);
    let points: Vec<Point> = series.points.iter().step_by(every).filter_map(place).collect();
    if series.kind == SeriesKind::Dots {
        return points;
    }
    let between = points.windows(2).flat_map(|w| {
        let ([x0, y0], [dx, dy]) = (w[0], [w[1][0] - w[0][0], w[1][1] - w[0][1]]);
        let pieces = (dx.hypot(dy) / 5.0).ceil().clamp(1.0, 200.0) as usize;
        (0..pieces).map(move |i| i as f64 / pieces as f64).map(move |s| [x0 + s * dx, y0 + s * dy])
    });
    between.chain(points.last().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_avoids_a_curve() {
        let (x, y) = (Scale::linear(0.0, 1.0).onto(0.0, 400.0), Scale::linear(0.0, 1.0).onto(200.0, 0.0));
        let place = |series: &[Series], at| beside_rule(series, &x, &y, [0.0, 0.0], [400.0, 200.0], at, [80.0, 22.0]);
        assert_eq!(place(&[], 100.0), [315.0, 77.0], "free: right, above");
        assert_eq!(place(&[], 10.0), [315.0, 11.0], "no room above");
        let rising = Series::line(&[0.0, 1.0], &[0.2, 0.6]);
        let [left, top] = place(&[rising], 100.0);
        assert!(top == 77.0 && left + 80.0 < 300.0, "left of where the line crosses the rule: {left} {top}");
    }
}
