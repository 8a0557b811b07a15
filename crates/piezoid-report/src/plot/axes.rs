//! One panel of a figure: two axes and the data between them.

use super::axis::Axis;
use super::series::Series;

/// A line or strip across the panel, with a label.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mark {
    /// A vertical line at an x.
    X(f64, String),
    /// A horizontal line at a y.
    Y(f64, String),
    /// A shaded strip from one x to another.
    OverX(f64, f64),
}

/// One panel: axes, series in the order they are drawn, and reference lines behind them.
///
/// ```
/// use piezoid_report::plot::{Axes, Axis, Series};
/// let panel = Axes::new(Axis::log("f [Hz]"), "rms error [%]")
///     .titled("Error against frequency")
///     .with(Series::marked(&[5.0, 20.0, 80.0], &[0.3, 0.4, 0.9]).named("direction held"))
///     .at_y(2.0, "2 %")
///     .at_x(146.7, "resonance");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Axes {
    pub(super) title: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) series: Vec<Series>,
    pub(super) marks: Vec<Mark>,
    /// Height relative to the default.
    pub(super) height: f64,
}

impl Axes {
    /// An empty panel. A text as an axis is the label of a linear one.
    pub fn new(x: impl Into<Axis>, y: impl Into<Axis>) -> Self {
        let (x, y) = (x.into(), y.into());
        Axes { title: String::new(), x, y, series: Vec::new(), marks: Vec::new(), height: 1.0 }
    }

    /// A title above the panel.
    pub fn titled(self, title: impl Into<String>) -> Self {
        Axes { title: title.into(), ..self }
    }

    /// Adds a series, drawn over those before it.
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// A vertical reference line.
    pub fn at_x(mut self, x: f64, label: impl Into<String>) -> Self {
        self.marks.push(Mark::X(x, label.into()));
        self
    }

    /// A horizontal reference line.
    pub fn at_y(mut self, y: f64, label: impl Into<String>) -> Self {
        self.marks.push(Mark::Y(y, label.into()));
        self
    }

    /// A shaded strip over a part of the x axis.
    pub fn over_x(mut self, from: f64, to: f64) -> Self {
        self.marks.push(Mark::OverX(from, to));
        self
    }

    /// Height relative to the default, from 0.3 to 3.
    pub fn height(self, share: f64) -> Self {
        Axes { height: if share.is_finite() { share.clamp(0.3, 3.0) } else { 1.0 }, ..self }
    }

    /// The same without names, and so without a legend: for a panel beside one with the same series.
    pub fn unnamed(mut self) -> Self {
        self.series.iter_mut().for_each(|s| s.name.clear());
        self
    }

    /// All x of series and marks.
    pub(super) fn xs(&self) -> impl Iterator<Item = f64> {
        let marks = self.marks.iter().flat_map(|m| match m {
            Mark::X(x, _) => [*x, f64::NAN],
            Mark::Y(..) => [f64::NAN; 2],
            Mark::OverX(from, to) => [*from, *to],
        });
        self.series.iter().flat_map(Series::xs).chain(marks)
    }

    /// All y of series and marks.
    pub(super) fn ys(&self) -> impl Iterator<Item = f64> {
        let marks = self.marks.iter().map(|m| if let Mark::Y(y, _) = m { *y } else { f64::NAN });
        self.series.iter().flat_map(Series::ys).chain(marks)
    }
}
