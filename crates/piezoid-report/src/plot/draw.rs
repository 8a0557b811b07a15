//! Draws one series into its panel.

use super::decimate;
use super::path::{PathData, Point};
use super::scale::Scale;
use super::series::{Series, SeriesKind};
use super::svg::{MARKED, Stroke, Svg, marker};

/// Largest number of dots of a series, and of single points of a broken line.
const DOTS: usize = 3000;
/// Largest number of markers on a line.
const MARKERS: usize = 300;
/// Smallest distance of two markers [units of the drawing].
const APART: f64 = 14.0;

/// Draws a series in the colour of its role.
pub(super) fn series(svg: &mut Svg, series: &Series, x: &Scale, y: &Scale) {
    let (runs, stroke) = (runs(series, x, y), Stroke::of(series));
    svg.open_role(series.role);
    match series.kind {
        SeriesKind::Dots => svg.dots(&decimate::dots(&runs.concat(), DOTS)),
        SeriesKind::Band => band(svg, series, x, y),
        SeriesKind::Dashed | SeriesKind::Wide | SeriesKind::Line => lines(svg, &stroke, &runs),
        SeriesKind::Marked | SeriesKind::Points => {
            if series.kind == SeriesKind::Marked {
                lines(svg, &stroke, &runs);
            }
            let places = decimate::dots(&decimate::markers(&runs.concat(), APART), MARKERS);
            svg.shape(MARKED, &marker(series.role, &places));
        }
    }
    svg.close();
}

/// The unbroken parts of a series, in coordinates.
fn runs(series: &Series, x: &Scale, y: &Scale) -> Vec<Vec<Point>> {
    let mut runs = vec![Vec::new()];
    for [px, py] in &series.points {
        match (x.at(*px), y.at(*py), runs.last_mut()) {
            (Some(px), Some(py), Some(run)) => run.push([px, py]),
            (_, _, Some(run)) if run.is_empty() => {}
            _ => runs.push(Vec::new()),
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}

/// All runs as one path. Single points between gaps become dots.
fn lines(svg: &mut Svg, stroke: &Stroke, runs: &[Vec<Point>]) {
    let mut path = PathData::default();
    let mut lone = Vec::new();
    for run in runs {
        match run[..] {
            [point] => lone.push(point),
            _ => path.polyline(&decimate::line(run)),
        }
    }
    decimate::dots(&lone, DOTS).iter().for_each(|p| path.dot(*p));
    svg.stroked(stroke, &path.finish());
}

/// The areas of a band: the upper edge forward, the lower edge back.
fn band(svg: &mut Svg, series: &Series, x: &Scale, y: &Scale) {
    let place = |(p, low): (&Point, &f64)| Some((x.at(p[0])?, y.at(p[1])?, y.at(*low)?));
    let places: Vec<_> = series.points.iter().zip(&series.lower).map(place).collect();
    for run in places.split(Option::is_none) {
        let edge =
            |of: fn(&(f64, f64, f64)) -> Point| decimate::line(&run.iter().flatten().map(of).collect::<Vec<_>>());
        let (upper, lower) = (edge(|p| [p.0, p.1]), edge(|p| [p.0, p.2]));
        let outline: Vec<Point> = upper.into_iter().chain(lower.into_iter().rev()).collect();
        if outline.len() > 2 {
            svg.shape("pz-band", &svg.outline(&outline));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(s: &Series) -> String {
        let mut svg = Svg::default();
        series(&mut svg, s, &Scale::linear(0.0, 10.0).onto(0.0, 100.0), &Scale::linear(0.0, 10.0).onto(100.0, 0.0));
        svg.out
    }

    #[test]
    fn a_line_breaks_at_a_missing_number() {
        let svg = drawn(&Series::line(&[0.0, 1.0, 2.0, 3.0, 4.0], &[0.0, 1.0, f64::NAN, 3.0, 4.0]));
        assert!(svg.contains("d=\"m0 100 10-10m20-20 10-10\""), "{svg}");
        assert!(!svg.contains("NaN"));
    }

    #[test]
    fn a_point_between_two_gaps_is_a_dot() {
        let svg = drawn(&Series::line(&[0.0, 1.0, 2.0], &[f64::NAN, 5.0, f64::INFINITY]));
        assert!(svg.contains("d=\"m10 50h0\""), "{svg}");
    }

    #[test]
    fn a_band_is_an_outline_and_breaks_at_a_missing_number() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0];
        let svg = drawn(&Series::band(&x, &[0.0, 0.0, f64::NAN, 1.0, 1.0], &[2.0, 2.0, 2.0, 3.0, 3.0]));
        assert_eq!(svg.matches("pz-band").count(), 2, "{svg}");
        assert!(svg.contains("d=\"m0 80 10 0 0 20-10 0z\""), "{svg}");
    }
}
