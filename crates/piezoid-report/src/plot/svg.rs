//! The SVG elements of figures.
//!
//! Colours come from the style sheet. The light ones are also attributes of the elements, for viewers without custom
//! properties; a style sheet overrides attributes.

use super::palette::{Role, ground};
use super::path::{PathData, Point};
use super::series::{Series, SeriesKind};
use super::text::{px, shown};

/// Class of markers.
pub(super) const MARKED: &str = "pz-mark";

/// Patterns of dashes of lines [units of the drawing]; the first is solid. Round ends add the width of the line.
pub(super) const DASHES: [&str; 5] = ["", "9 6", "1 5", "12 5 1 5", "5 5"];

/// How a line is stroked: its class, and the same as attributes for viewers without style sheets.
#[derive(Debug)]
pub(super) struct Stroke {
    class: &'static str,
    attributes: String,
}

impl Stroke {
    /// The stroke of a series.
    pub(super) fn of(series: &Series) -> Self {
        let (class, plain) = match series.kind {
            SeriesKind::Wide => ("pz-under", " stroke-width=\"7\" stroke-opacity=\"0.45\""),
            SeriesKind::Dashed => ("pz-dash", " stroke-width=\"2\" stroke-dasharray=\"6 4\""),
            _ => ("pz-line", " stroke-width=\"1.8\""),
        };
        let dashes = match DASHES[series.dashes % DASHES.len()] {
            "" => String::new(),
            // As a style, because a pattern belongs to the series and not to its class.
            dashes => format!(" style=\"stroke-dasharray:{dashes}\""),
        };
        Stroke { class, attributes: [plain, &dashes].concat() }
    }
}

/// An SVG document under construction.
#[derive(Debug, Default)]
pub(super) struct Svg {
    pub(super) out: String,
}

impl Svg {
    fn put(&mut self, parts: &[&str]) {
        parts.iter().for_each(|p| self.out.push_str(p));
    }

    /// Opens a group in the colour of a role.
    pub(super) fn open_role(&mut self, role: Role) {
        self.put(&["<g class=\"pz-", role.name(), "\" stroke=\"", role.light(), "\" fill=\"", role.light(), "\">"]);
    }

    /// Closes the last group.
    pub(super) fn close(&mut self) {
        self.put(&["</g>\n"]);
    }

    /// A window that clips its contents without changing coordinates.
    pub(super) fn open_window(&mut self, [x, y]: Point, [w, h]: Point) {
        let [x, y, w, h] = [x, y, w, h].map(px);
        self.put(&["<svg x=\"", &x, "\" y=\"", &y, "\" width=\"", &w, "\" height=\"", &h]);
        self.put(&["\" viewBox=\"", &x, " ", &y, " ", &w, " ", &h, "\">\n"]);
    }

    pub(super) fn close_window(&mut self) {
        self.put(&["</svg>\n"]);
    }

    /// A line through points, in the colour of the group.
    pub(super) fn stroke(&mut self, stroke: &Stroke, points: &[Point]) {
        let mut path = PathData::default();
        path.polyline(points);
        self.stroked(stroke, &path.finish());
    }

    /// A stroked path, in the colour of the group.
    pub(super) fn stroked(&mut self, Stroke { class, attributes }: &Stroke, d: &str) {
        if !d.is_empty() {
            self.put(&["<path class=\"", class, "\" fill=\"none\"", attributes, " d=\"", d, "\"/>\n"]);
        }
    }

    /// A filled outline, in the colour of the group.
    pub(super) fn shape(&mut self, class: &str, d: &str) {
        if !d.is_empty() {
            let light = if class == MARKED { "" } else { " stroke=\"none\" fill-opacity=\"0.2\"" };
            self.put(&["<path class=\"", class, "\"", light, " d=\"", d, "\"/>\n"]);
        }
    }

    /// Dots, all in one path: round ends of lines of length zero.
    pub(super) fn dots(&mut self, points: &[Point]) {
        let mut path = PathData::default();
        points.iter().for_each(|p| path.dot(*p));
        let attributes = " stroke-width=\"3.2\" stroke-linecap=\"round\" stroke-opacity=\"0.45\"".into();
        self.stroked(&Stroke { class: "pz-dots", attributes }, &path.finish());
    }

    /// The closed outline of a polygon.
    pub(super) fn outline(&self, points: &[Point]) -> String {
        let mut path = PathData::default();
        path.polyline(points);
        path.close();
        path.finish()
    }

    /// A straight line of the frame, in one of the ground colours.
    pub(super) fn rule(&mut self, class: &str, from: Point, to: Point) {
        let [x1, y1, x2, y2] = [from[0], from[1], to[0], to[1]].map(px);
        let dash = if class == "reference" { " stroke-dasharray=\"2 4\"" } else { "" };
        let light = if class == "reference" { Role::Reference.light() } else { ground(class) };
        self.put(&["<path class=\"pz-", class, "-rule\" stroke=\"", light, "\"", dash]);
        self.put(&[" d=\"M", &x1, " ", &y1, "L", &x2, " ", &y2, "\"/>\n"]);
    }

    /// A filled rectangle in one of the ground colours.
    pub(super) fn rect(&mut self, class: &str, [x, y]: Point, [w, h]: Point) {
        let [x, y, w, h] = [x, y, w, h].map(px);
        self.put(&["<rect class=\"pz-", class, "-fill\" fill=\"", ground(class), "\" x=\"", &x, "\" y=\"", &y]);
        self.put(&["\" width=\"", &w, "\" height=\"", &h, "\"/>\n"]);
    }

    /// A line of text, anchored at its start, middle or end.
    pub(super) fn text(&mut self, class: &str, x: f64, y: f64, anchor: &str, text: &str) {
        self.put(&["<text class=\"", class, "\" x=\"", &px(x), "\" y=\"", &px(y)]);
        self.put(&["\" text-anchor=\"", anchor, "\">", &shown(text), "</text>\n"]);
    }
}

/// Outlines of markers at points. Each accent has its own shape, of similar visual weight.
pub(super) fn marker(role: Role, points: &[Point]) -> String {
    let shape: &[Point] = match role {
        Role::Accent2 => &[[-4.2, -4.2], [4.2, -4.2], [4.2, 4.2], [-4.2, 4.2]],
        Role::Accent3 => &[[0.0, -5.6], [5.2, 3.8], [-5.2, 3.8]],
        Role::Accent4 => &[[0.0, -6.0], [6.0, 0.0], [0.0, 6.0], [-6.0, 0.0]],
        Role::Accent5 => &[[0.0, 5.6], [5.2, -3.8], [-5.2, -3.8]],
        _ => &[],
    };
    let mut path = PathData::default();
    for [x, y] in points {
        if shape.is_empty() {
            path.start([x - 4.6, *y]);
            path.raw("a4.6 4.6 0 1 0 9.2 0a4.6 4.6 0 1 0-9.2 0z");
        } else {
            let corners: Vec<Point> = shape.iter().map(|[dx, dy]| [x + dx, y + dy]).collect();
            path.polyline(&corners);
            path.close();
        }
    }
    path.finish()
}
