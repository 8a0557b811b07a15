//! One curve, cloud or band of data in a panel.

use super::palette::Role;

/// Style of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SeriesKind {
    Line,
    Wide,
    Dashed,
    Marked,
    Points,
    Dots,
    Band,
}

/// Data in a panel: pairs of x and y, their style, and their meaning.
///
/// A pair that is not finite (or not positive on a logarithmic axis) breaks the line. If the slices differ in length,
/// the rest of the longer one is ignored.
///
/// ```
/// use piezoid_report::plot::{Role, Series};
/// let branch = Series::line(&[0.0, 30.0, 60.0], &[0.0, 40.0, 120.0]).role(Role::Ascending).named("ascending");
/// let cloud = Series::dots(&[0.0, 30.0, 60.0], &[1.0, 39.0, 121.0]);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub(super) kind: SeriesKind,
    pub(super) role: Role,
    pub(super) name: String,
    /// Dashes of a line: 0 is solid.
    pub(super) dashes: usize,
    /// Pairs `[x, y]`.
    pub(super) points: Vec<[f64; 2]>,
    /// Lower edge of a band, one value per point; empty otherwise.
    pub(super) lower: Vec<f64>,
}

impl Series {
    fn new(kind: SeriesKind, role: Role, x: &[f64], y: &[f64]) -> Self {
        let points = x.iter().zip(y).map(|(x, y)| [*x, *y]).collect();
        Series { kind, role, name: String::new(), dashes: 0, points, lower: Vec::new() }
    }

    /// A line through the points.
    pub fn line(x: &[f64], y: &[f64]) -> Self {
        Series::new(SeriesKind::Line, Role::Model, x, y)
    }

    /// A wide, pale line, drawn below all other series: a measurement stays visible under a model that follows it.
    pub fn wide(x: &[f64], y: &[f64]) -> Self {
        Series::new(SeriesKind::Wide, Role::Measured, x, y)
    }

    /// A dashed line.
    pub fn dashed(x: &[f64], y: &[f64]) -> Self {
        Series::new(SeriesKind::Dashed, Role::Reference, x, y)
    }

    /// A line with markers. Each accent has its own shape.
    pub fn marked(x: &[f64], y: &[f64]) -> Self {
        Series::new(SeriesKind::Marked, Role::Accent1, x, y)
    }

    /// Markers without a line between them: points of which none follows from another.
    pub fn points(x: &[f64], y: &[f64]) -> Self {
        Series::new(SeriesKind::Points, Role::Accent1, x, y)
    }

    /// Small, half transparent dots.
    pub fn dots(x: &[f64], y: &[f64]) -> Self {
        Series::new(SeriesKind::Dots, Role::Measured, x, y)
    }

    /// The area between two curves over the same x.
    pub fn band(x: &[f64], lower: &[f64], upper: &[f64]) -> Self {
        let n = x.len().min(lower.len()).min(upper.len());
        Series { lower: lower[..n].to_vec(), ..Series::new(SeriesKind::Band, Role::Muted, &x[..n], &upper[..n]) }
    }

    /// Its role, which sets its colour.
    pub fn role(self, role: Role) -> Self {
        Series { role, ..self }
    }

    /// A line with the `k`-th pattern of dashes; 0 is solid. Lines of different patterns that coincide show both
    /// colours.
    pub fn dashes(self, k: usize) -> Self {
        Series { dashes: k, ..self }
    }

    /// Its name in the legend; without one it is not listed.
    pub fn named(self, name: impl Into<String>) -> Self {
        Series { name: name.into(), ..self }
    }

    /// True without any point.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// All x of the points.
    pub(super) fn xs(&self) -> impl Iterator<Item = f64> {
        self.points.iter().map(|p| p[0])
    }

    /// All y of the points.
    pub(super) fn ys(&self) -> impl Iterator<Item = f64> {
        self.points.iter().map(|p| p[1]).chain(self.lower.iter().copied())
    }
}
