//! The legend above a panel, which never covers the data.

use super::series::{Series, SeriesKind};
use super::svg::{MARKED, Stroke, Svg, marker};
use super::text::{shown, width};

/// Height of a row [units of the drawing].
pub(super) const ROW: f64 = 23.0;
const SWATCH: f64 = 22.0;
const GAP: f64 = 15.0;

/// Places of the entries.
#[derive(Debug, Default)]
pub(super) struct Legend {
    /// Row, left edge within the row, and index of the series.
    places: Vec<(usize, f64, usize)>,
    /// Number of rows.
    pub(super) rows: usize,
    /// Width of the widest row.
    pub(super) width: f64,
}

impl Legend {
    /// Fills rows of width `room` with the named series, at letter size `em`.
    pub(super) fn lay(series: &[Series], room: f64, em: f64) -> Self {
        let mut legend = Legend::default();
        let mut x = 0.0;
        for (i, s) in series.iter().enumerate().filter(|(_, s)| !s.name.is_empty()) {
            let wide = SWATCH + 7.0 + em * width(&s.name);
            if legend.rows == 0 || x + wide > room {
                (legend.rows, x) = (legend.rows + 1, 0.0);
            }
            legend.places.push((legend.rows - 1, x, i));
            legend.width = legend.width.max(x + wide);
            x += wide + GAP;
        }
        legend
    }

    /// Draws it with its upper left corner at `(left, top)`.
    pub(super) fn draw(&self, svg: &mut Svg, series: &[Series], left: f64, top: f64) {
        for &(row, x, i) in &self.places {
            let (x, y, s) = (left + x, top + ROW * row as f64 + ROW / 2.0, &series[i]);
            swatch(svg, s, x, y);
            svg.text("pz-key", x + SWATCH + 7.0, y + 5.0, "start", &s.name);
        }
    }
}

/// Draws the sample of a series to the right of `x` at height `y`.
fn swatch(svg: &mut Svg, s: &Series, x: f64, y: f64) {
    let (stroke, ends) = (Stroke::of(s), [[x, y], [x + SWATCH, y]]);
    svg.open_role(s.role);
    match s.kind {
        SeriesKind::Line | SeriesKind::Wide | SeriesKind::Dashed => svg.stroke(&stroke, &ends),
        SeriesKind::Marked => {
            svg.stroke(&stroke, &ends);
            svg.shape(MARKED, &marker(s.role, &[[x + SWATCH / 2.0, y]]));
        }
        SeriesKind::Points => svg.shape(MARKED, &marker(s.role, &[[x + SWATCH / 2.0, y]])),
        SeriesKind::Dots => {
            svg.dots(&[[4.0, 2.0], [9.0, -3.0], [13.0, 3.0], [18.0, -1.0]].map(|[dx, dy]| [x + dx, y + dy]));
        }
        SeriesKind::Band => svg.shape(
            "pz-band",
            &svg.outline(&[[x, y - 6.0], [x + SWATCH, y - 6.0], [x + SWATCH, y + 6.0], [x, y + 6.0]]),
        ),
    }
    svg.close();
}

/// The legend that several figures share, as a list for a page; empty without names. A name that several series have
/// is listed once.
pub(super) fn shared<'a>(series: impl Iterator<Item = &'a Series>) -> String {
    let mut listed: Vec<&str> = Vec::new();
    let mut out = String::new();
    for s in series.filter(|s| !s.name.is_empty()) {
        if listed.contains(&s.name.as_str()) {
            continue;
        }
        listed.push(&s.name);
        let mut sample = Svg::default();
        swatch(&mut sample, s, 1.0, 8.0);
        let (sample, name) = (sample.out, shown(&s.name));
        out += &format!(
            "<li><svg class=\"pz-fig\" viewBox=\"0 0 24 16\" aria-hidden=\"true\">\n{sample}</svg>{name}</li>\n"
        );
    }
    if out.is_empty() { out } else { format!("<ul class=\"keys\">\n{out}</ul>\n") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_do_not_fit_go_to_the_next_row() {
        let named = |n: &str| Series::line(&[], &[]).named(n);
        let series = [named("ascending branch"), Series::dots(&[], &[]), named("descending branch")];
        assert_eq!(Legend::lay(&series, 600.0, 15.0).rows, 1);
        assert_eq!(Legend::lay(&series, 220.0, 15.0).rows, 2);
        assert_eq!(Legend::lay(&series[1..2], 220.0, 15.0).rows, 0, "no name, no legend");
    }

    #[test]
    fn a_shared_legend_lists_each_name_once() {
        let named = |n: &str| Series::line(&[], &[]).named(n);
        let list = shared([named("a<b"), named("model"), named("a<b"), Series::line(&[], &[])].iter());
        assert_eq!((list.matches("<li>").count(), list.matches("a&lt;b").count()), (2, 1), "{list}");
        assert_eq!(shared([Series::line(&[], &[])].iter()), "");
    }
}
