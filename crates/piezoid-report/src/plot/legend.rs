//! The legend above a panel, which never covers the data.

use super::series::{Series, SeriesKind};
use super::svg::{MARKED, Svg, marker};
use super::text::width;

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
            svg.open_role(s.role);
            let (from, to) = ([x, y], [x + SWATCH, y]);
            match s.kind {
                SeriesKind::Line | SeriesKind::Step => svg.stroke("pz-line", &[from, to]),
                SeriesKind::Dashed => svg.stroke("pz-dash", &[from, to]),
                SeriesKind::Marked => {
                    svg.stroke("pz-line", &[from, to]);
                    svg.shape(MARKED, &marker(s.role, &[[x + SWATCH / 2.0, y]]));
                }
                SeriesKind::Dots => {
                    let dots = [[4.0, 2.0], [9.0, -3.0], [13.0, 3.0], [18.0, -1.0]].map(|[dx, dy]| [x + dx, y + dy]);
                    svg.dots(&dots);
                }
                SeriesKind::Band => svg.shape(
                    "pz-band",
                    &svg.outline(&[[x, y - 6.0], [x + SWATCH, y - 6.0], [x + SWATCH, y + 6.0], [x, y + 6.0]]),
                ),
            }
            svg.close();
            svg.text("pz-key", x + SWATCH + 7.0, y + 5.0, "start", &s.name);
        }
    }
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
}
