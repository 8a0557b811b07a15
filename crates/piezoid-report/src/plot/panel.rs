//! Layout and drawing of a panel: title, legend and y label above, ticks around, data inside.

use super::axes::{Axes, Mark};
use super::legend::{self, Legend};
use super::path::Point;
use super::scale::Scale;
use super::series::SeriesKind;
use super::svg::Svg;
use super::ticks::Tick;
use super::{draw, place, text::width};

/// Heights of the rows of text around the data, and gaps [units of the drawing].
const TITLE: f64 = 28.0;
const LABEL: f64 = 24.0;
const MARKS: f64 = 20.0;
const TICKS: f64 = 28.0;
const GAP: f64 = 9.0;
/// Space right of the data, for half of the last tick label.
pub(super) const RIGHT: f64 = 20.0;

/// A panel with its scales and the space around its data.
#[derive(Debug)]
pub(super) struct Panel<'a> {
    axes: &'a Axes,
    scales: (Scale, Scale),
    ticks: (Vec<Tick>, Vec<Tick>),
    legend: Legend,
    /// True if the x axis is labelled in this panel and not only in the one below.
    shows_x: bool,
    /// Letter size of the layout.
    em: f64,
    /// Space left of, above and below the data.
    pub(super) left: f64,
    pub(super) above: f64,
    pub(super) below: f64,
}

impl<'a> Panel<'a> {
    /// The layout of a panel of `size`. `xs` are the x to be shown, which stacked panels share.
    pub(super) fn lay(axes: &'a Axes, xs: impl Iterator<Item = f64>, size: Point, shows_x: bool, em: f64) -> Self {
        let legend = Legend::lay(&axes.series, size[0], em);
        let beside = axes.beside(&legend, size[0], em);
        let title = if axes.title.is_empty() { 0.0 } else { TITLE };
        let label = if axes.y.label.is_empty() && !beside { 0.0 } else { LABEL };
        let marks = if axes.marks_above() { MARKS } else { 0.0 };
        let rows = if beside { 0.0 } else { legend::ROW * legend.rows as f64 };
        let above = title + rows + label + marks + GAP;
        let x_label = if axes.x.label.is_empty() { 0.0 } else { LABEL };
        let below = if shows_x { TICKS + x_label } else { GAP };

        // About one label per 42 units of height; in x with space for half another label.
        let count = |room: f64, each: f64| (room / each).round().clamp(3.0, 8.0) as usize;
        let (y, y_ticks) = axes.y.resolve(axes.ys(), count(size[1] - above - below, 42.0));
        let widest = y_ticks.iter().map(|t| width(&t.label)).fold(0.0, f64::max);
        let left = em * widest + 12.0;
        let (x, x_ticks) = axes.x.resolve(xs, count(size[0] - left - RIGHT, 4.4 * em));
        Panel { axes, scales: (x, y), ticks: (x_ticks, y_ticks), legend, shows_x, em, left, above, below }
    }

    /// Takes the x axis of another panel, for equal scale, ticks and grid.
    pub(super) fn share_x(&mut self, other: &Panel) {
        self.scales.0 = other.scales.0;
        self.ticks.0.clone_from(&other.ticks.0);
    }

    /// Draws the panel: data between `corner` and `corner + size`, text from the left edge `edge` on.
    pub(super) fn draw(&self, svg: &mut Svg, edge: f64, corner: Point, size: Point) {
        let ([left, top], [right, bottom]) = (corner, [corner[0] + size[0], corner[1] + size[1]]);
        let (x, y) = (self.scales.0.onto(left, right), self.scales.1.onto(bottom, top));
        self.strips(svg, &x, top, bottom);
        self.ticks_of_y(svg, &y, left, right);
        self.ticks_of_x(svg, &x, top, bottom);
        if self.scales.1.low < 0.0
            && self.scales.1.high > 0.0
            && let Some(zero) = y.at(0.0)
        {
            svg.rule("axis", [left, zero], [right, zero]);
        }
        svg.rule("axis", [left, bottom], [right, bottom]);
        self.rules(svg, &x, &y, [left, right], [top, bottom]);
        let cut = self.axes.x.cuts() || self.axes.y.cuts();
        if cut {
            svg.open_window(corner, size);
        }
        // Wide lines first, so that they cover nothing.
        let (wide, thin): (Vec<_>, Vec<_>) = self.axes.series.iter().partition(|s| s.kind == SeriesKind::Wide);
        wide.into_iter().chain(thin).for_each(|s| draw::series(svg, s, &x, &y));
        if cut {
            svg.close_window();
        }
        self.words(svg, edge, corner, [right, bottom]);
        self.words_of_marks(svg, &x, &y, corner, size);
    }

    fn ticks_of_y(&self, svg: &mut Svg, y: &Scale, left: f64, right: f64) {
        for tick in &self.ticks.1 {
            let Some(at) = y.at(tick.at) else { continue };
            if tick.label.is_empty() {
                svg.rule("axis", [left - 3.0, at], [left, at]);
                continue;
            }
            svg.rule("grid", [left, at], [right, at]);
            svg.text("pz-tick", left - 8.0, at + 5.0, "end", &tick.label);
        }
    }

    /// Labels that would touch the previous one are omitted; their ticks stay.
    fn ticks_of_x(&self, svg: &mut Svg, x: &Scale, top: f64, bottom: f64) {
        let mut free = f64::MIN;
        for tick in &self.ticks.0 {
            let Some(at) = x.at(tick.at) else { continue };
            if tick.label.is_empty() {
                svg.rule("axis", [at, bottom], [at, bottom + 3.0]);
                continue;
            }
            svg.rule("grid", [at, top], [at, bottom]);
            svg.rule("axis", [at, bottom], [at, bottom + 6.0]);
            let half = 0.5 * self.em * width(&tick.label);
            if self.shows_x && at - half > free {
                svg.text("pz-tick", at, bottom + 22.0, "middle", &tick.label);
                free = at + half + 7.0;
            }
        }
    }

    fn strips(&self, svg: &mut Svg, x: &Scale, top: f64, bottom: f64) {
        for mark in &self.axes.marks {
            if let Mark::OverX(from, to) = mark
                && let (Some(from), Some(to)) = (x.at(*from), x.at(*to))
            {
                svg.rect("raised", [from.min(to), top], [(to - from).abs(), bottom - top]);
            }
        }
    }

    fn rules(&self, svg: &mut Svg, x: &Scale, y: &Scale, [left, right]: Point, [top, bottom]: Point) {
        let inside = |v: Option<f64>, a: f64, b: f64| v.filter(|v| (a - 0.1..=b + 0.1).contains(v));
        for mark in &self.axes.marks {
            let ends = match mark {
                Mark::X(at, _) => inside(x.at(*at), left, right).map(|at| [[at, top - 4.0], [at, bottom]]),
                Mark::Y(at, _) => inside(y.at(*at), top, bottom).map(|at| [[left, at], [right, at]]),
                Mark::OverX(..) => None,
            };
            if let Some([from, to]) = ends {
                svg.rule("reference", from, to);
            }
        }
    }

    /// Title, legend and axis labels.
    fn words(&self, svg: &mut Svg, edge: f64, corner: Point, [right, bottom]: Point) {
        let (axes, mut top) = (self.axes, corner[1] - self.above);
        if !axes.title.is_empty() {
            svg.text("pz-title", edge, top + 18.0, "start", &axes.title);
            top += TITLE;
        }
        if axes.beside(&self.legend, right - edge + RIGHT, self.em) {
            self.legend.draw(svg, &axes.series, right - self.legend.width, top);
        } else {
            self.legend.draw(svg, &axes.series, edge, top);
            top += legend::ROW * self.legend.rows as f64;
        }
        if !axes.y.label.is_empty() {
            svg.text("pz-label", edge, top + 17.0, "start", &axes.y.label);
        }
        if self.shows_x && !axes.x.label.is_empty() {
            svg.text("pz-label", right, bottom + TICKS + 16.0, "end", &axes.x.label);
        }
    }

    /// Labels of vertical lines are above the data, those of horizontal lines where they cover the least data.
    fn words_of_marks(&self, svg: &mut Svg, x: &Scale, y: &Scale, corner: Point, size: Point) {
        let ([left, top], [right, bottom]) = (corner, [corner[0] + size[0], corner[1] + size[1]]);
        for mark in &self.axes.marks {
            match mark {
                Mark::X(at, label) if !label.is_empty() => {
                    let Some(at) = x.at(*at).filter(|at| (left..=right).contains(at)) else { continue };
                    let half = 0.5 * self.em * width(label);
                    let at = at.min(right + RIGHT - half).max(left + half);
                    svg.text("pz-note", at, top - 9.0, "middle", label);
                }
                Mark::Y(at, label) if !label.is_empty() => {
                    let Some(at) = y.at(*at).filter(|at| (top..=bottom).contains(at)) else { continue };
                    let room = [self.em * width(label), 22.0];
                    let place = place::beside_rule(&self.axes.series, x, y, corner, size, at, room);
                    svg.text("pz-note", place[0], place[1] + 16.0, "start", label);
                }
                _ => {}
            }
        }
    }
}

impl Axes {
    /// True if the legend fits into the row of the y label.
    fn beside(&self, legend: &Legend, room: f64, em: f64) -> bool {
        legend.rows == 1 && legend.width + em * width(&self.y.label) + 30.0 < room - RIGHT
    }

    /// True if a line has a label above the data.
    fn marks_above(&self) -> bool {
        self.marks.iter().any(|m| matches!(m, Mark::X(_, label) if !label.is_empty()))
    }
}
