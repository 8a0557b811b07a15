//! One curve, cloud or band of data in a panel.

use super::palette::Role;

/// Style of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SeriesKind {
    Line,
    Dashed,
    Step,
    Marked,
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
    /// Pairs `[x, y]`.
    pub(super) points: Vec<[f64; 2]>,
    /// Lower edge of a band, one value per point; empty otherwise.
    pub(super) lower: Vec<f64>,
}

impl Series {
    fn new(kind: SeriesKind, role: Role, x: &[f64], y: &[f64]) -> Self {
        let points = x.iter().zip(y).map(|(x, y)| [*x, *y]).collect();
        Series { kind, role, name: String::new(), points, lower: Vec::new() }
    }

    /// A line through the points.
    pub fn line(x: &[f64], y: &[f64]) -> Self {
        Series::new(SeriesKind::Line, Role::Model, x, y)
    }

    /// A dashed line.
    pub fn dashed(x: &[f64], y: &[f64]) -> Self {
        Series::new(SeriesKind::Dashed, Role::Reference, x, y)
    }

    /// A line that holds each value until the next x.
    pub fn step(x: &[f64], y: &[f64]) -> Self {
        Series::new(SeriesKind::Step, Role::Model, x, y)
    }

    /// A line with markers. Each accent has its own shape.
    pub fn marked(x: &[f64], y: &[f64]) -> Self {
        Series::new(SeriesKind::Marked, Role::Accent1, x, y)
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

    /// Its name in the legend; without one it is not listed.
    pub fn named(self, name: impl Into<String>) -> Self {
        Series { name: name.into(), ..self }
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
