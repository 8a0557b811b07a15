//! The SVG elements of figures.
//!
//! Colours come from the style sheet. The light ones are also attributes of the elements, for viewers without custom
//! properties; a style sheet overrides attributes.

use super::palette::{Role, ground};
use super::path::{PathData, Point};
use super::text::{escape, px};

/// Class of markers.
pub(super) const MARKED: &str = "pz-mark";

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
    pub(super) fn stroke(&mut self, class: &str, points: &[Point]) {
        let mut path = PathData::default();
        path.polyline(points);
        self.stroked(class, &path.finish());
    }

    /// A stroked path, in the colour of the group.
    pub(super) fn stroked(&mut self, class: &str, d: &str) {
        if !d.is_empty() {
            let dash = if class == "pz-dash" { " stroke-dasharray=\"6 4\"" } else { "" };
            self.put(&["<path class=\"", class, "\" fill=\"none\" stroke-width=\"2\"", dash, " d=\"", d, "\"/>\n"]);
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
        let d = path.finish();
        if !d.is_empty() {
            self.put(&["<path class=\"pz-dots\" fill=\"none\" stroke-width=\"3.2\" stroke-linecap=\"round\" "]);
            self.put(&["stroke-opacity=\"0.45\" d=\"", &d, "\"/>\n"]);
        }
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
        self.put(&["\" text-anchor=\"", anchor, "\">", &escape(text), "</text>\n"]);
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
