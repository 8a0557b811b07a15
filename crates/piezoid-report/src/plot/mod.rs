//! Figures as SVG.
//!
//! A [`Figure`] has panels ([`Axes`]), and a panel has [`Series`]. The [`Role`] of a curve sets its colour, so that the
//! ascending branch looks the same in every figure, light and dark. The drawing follows the system's choice of light or
//! dark (`prefers-color-scheme`), or `data-theme` on the root element of the page.
//!
//! The same figure gives the same bytes. Coordinates have one decimal. Invisible detail is removed, so a record of a
//! hundred thousand samples gives a file of some kilobytes.
//!
//! It does not do: files, three dimensions, pie charts, animation.
//!
//! ```
//! use piezoid_report::plot::{Axes, Figure, Role, Series};
//!
//! let (u, z) = ([0.0, 20.0, 40.0, 60.0, 40.0, 20.0], [0.0, 30.0, 70.0, 120.0, 90.0, 50.0]);
//! let panel = Axes::new("u [V]", "z [µm]")
//!     .with(Series::dots(&u, &z).named("measured"))
//!     .with(Series::line(&u[..4], &z[..4]).role(Role::Ascending).named("ascending"))
//!     .with(Series::dashed(&[0.0, 60.0], &[0.0, 120.0]).named("separating line"));
//! let figure = Figure::new("Hysteresis at 5 Hz", "The loop opens by 13 % of its height.").panel(panel);
//! let file: String = figure.svg(); // a document of its own
//! let part: String = figure.inline(); // for a page with `Figure::style()`
//! # assert!(file.starts_with("<svg ") && part.starts_with("<svg "));
//! ```

mod axes;
mod axis;
mod data;
mod decimate;
mod draw;
mod legend;
mod palette;
mod panel;
mod path;
mod place;
mod scale;
mod series;
mod svg;
mod text;
mod ticks;

pub use axes::Axes;
pub use axis::Axis;
pub use palette::Role;
pub use series::Series;
pub(crate) use text::{allowed, escape, shown};

use panel::{Panel, RIGHT};
use path::Point;
use svg::Svg;

/// Margin of a stand-alone figure [units of the drawing].
const MARGIN: f64 = 14.0;

/// One figure: a panel, a stack of panels over one x axis, or a grid of panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    title: String,
    caption: String,
    panels: Vec<Axes>,
    /// Width and height of one panel [units of the drawing].
    panel: Point,
    columns: usize,
    stacked: bool,
}

impl Figure {
    /// The style sheet of all figures, needed once on a page with [`Figure::inline`]. Its names begin with `pz-`.
    ///
    /// It also defines the colours for the page: `--pz-paper`, `--pz-ink`, `--pz-brass`...
    pub fn style() -> String {
        palette::properties() + include_str!("style.css")
    }

    /// An empty figure with a title. The caption describes it, also for those who cannot see it.
    pub fn new(title: impl Into<String>, caption: impl Into<String>) -> Self {
        let (title, caption) = (title.into(), caption.into());
        Figure { title, caption, panels: Vec::new(), panel: [640.0, 400.0], columns: 1, stacked: false }
    }

    /// Adds a panel.
    pub fn panel(mut self, panel: Axes) -> Self {
        self.panels.push(panel);
        self
    }

    /// Panels of 280 by 270 instead of 640 by 400 units.
    pub fn small(self) -> Self {
        Figure { panel: [280.0, 270.0], ..self }
    }

    /// Panels of 440 by 330 units, for two in a row.
    pub fn medium(self) -> Self {
        Figure { panel: [440.0, 330.0], ..self }
    }

    /// Panels side by side in rows of `columns`, each with its own axes.
    pub fn columns(self, columns: usize) -> Self {
        Figure { columns: columns.max(1), ..self }
    }

    /// Panels one below the other with a common x axis, labelled at the lowest.
    pub fn stacked(self) -> Self {
        Figure { stacked: true, columns: 1, ..self }
    }

    /// One legend for several figures, as a list for a page with [`Figure::style`]; empty without names.
    pub(crate) fn legend(figures: &[Figure]) -> String {
        legend::shared(figures.iter().flat_map(|f| &f.panels).flat_map(|axes| &axes.series))
    }

    /// The same figure without a legend of its own.
    pub(crate) fn without_legend(self) -> Self {
        Figure { panels: self.panels.into_iter().map(Axes::unnamed).collect(), ..self }
    }

    /// Its title.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Its caption.
    pub fn caption(&self) -> &str {
        &self.caption
    }

    /// A stand-alone document, with its style, background and margin.
    pub fn svg(&self) -> String {
        let (body, size) = self.draw();
        let [w, h] = size.map(|s| text::px(s + 2.0 * MARGIN));
        let (sized, from) = (format!(" width=\"{w}\" height=\"{h}\""), text::px(-MARGIN));
        let fill = palette::ground("paper");
        let ground = format!("<rect class=\"pz-paper-fill\" fill=\"{fill}\" x=\"{from}\" y=\"{from}\"{sized}/>\n");
        let head = self.head(&format!("{from} {from} {w} {h}"), &sized);
        format!("{head}<style>\n{}</style>\n{ground}{body}", Figure::style())
    }

    /// An element for a page with [`Figure::style`].
    pub fn inline(&self) -> String {
        let (body, size) = self.draw();
        let [w, h] = size.map(text::px);
        self.head(&format!("0 0 {w} {h}"), "") + &body
    }

    /// The opening tag, with title and description for screen readers.
    fn head(&self, window: &str, attributes: &str) -> String {
        let wide = if self.grows() { " pz-wide" } else { "" };
        let (title, caption) = (shown(&self.title), shown(&self.caption));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"pz-fig{wide}\" viewBox=\"{window}\"{attributes} \
             role=\"img\" font-family=\"sans-serif\" font-size=\"15\">\n\
             <title>{title}</title>\n<desc>{caption}</desc>\n"
        )
    }

    /// True if letters grow on a narrow screen: for one panel as wide as the figure.
    fn grows(&self) -> bool {
        self.columns == 1 && self.panel[0] > 520.0
    }

    /// Everything between the head and the end, with its width and height.
    fn draw(&self) -> (String, Point) {
        let columns = self.columns.min(self.panels.len().max(1));
        let width = self.panel[0] * columns as f64;
        let em = if self.grows() { 17.0 } else { 15.0 };
        let mut svg = Svg::default();
        let mut top = 6.0;
        let mut laid: Vec<Panel> = (0..self.panels.len()).map(|i| self.lay(i, em)).collect();
        if self.stacked
            && let Some((lowest, above)) = laid.split_last_mut()
        {
            above.iter_mut().for_each(|panel| panel.share_x(lowest));
        }
        for (row, panels) in laid.chunks(columns).enumerate() {
            // Frames are aligned: in a row by the text above and below, in a column by the text on the left.
            let most = |of: fn(&Panel) -> f64| panels.iter().map(of).fold(0.0, f64::max);
            let (above, below) = (most(|p| p.above), most(|p| p.below));
            let share = self.panels[row * columns..].iter().take(columns).map(|a| a.height).fold(0.0, f64::max);
            let inner = (self.panel[1] * share - above - below).max(60.0);
            for (column, panel) in panels.iter().enumerate() {
                let left = laid.iter().skip(column).step_by(columns).map(|p| p.left).fold(0.0, f64::max);
                let edge = self.panel[0] * column as f64 + 4.0;
                let size = [self.panel[0] - 4.0 - left - RIGHT, inner];
                panel.draw(&mut svg, edge, [edge + left, top + above], size);
            }
            top += above + inner + below + 6.0;
        }
        svg.out.push_str("</svg>\n");
        (svg.out, [width, top])
    }

    fn lay(&self, i: usize, em: f64) -> Panel<'_> {
        let axes = &self.panels[i];
        let size = [self.panel[0] - 4.0, self.panel[1] * axes.height];
        if !self.stacked {
            return Panel::lay(axes, axes.xs(), size, true, em);
        }
        let shared = self.panels.iter().flat_map(Axes::xs);
        Panel::lay(axes, shared, size, i + 1 == self.panels.len(), em)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(n: usize) -> Vec<f64> {
        (0..n).map(|i| i as f64).collect()
    }

    fn nasty() -> Figure {
        let y = [1.0, f64::NAN, f64::INFINITY, -3.0, 1e-320, 2.0];
        let series =
            [Series::line, Series::dashed, Series::wide, Series::marked, Series::dots].map(|s| s(&ramp(6), &y));
        let mut panel = Axes::new("u <V> & [\u{1}]", Axis::log("\"y\" > 0")).titled("a < b & c");
        for (i, s) in series.into_iter().enumerate() {
            panel = panel.with(s.role(Role::accent(i)).named(format!("<{i}>")));
        }
        let panel = panel
            .with(Series::band(&ramp(6), &y, &y))
            .at_x(f64::NAN, "<x>")
            .at_x(1.5, "'")
            .at_y(-1.0, "&")
            .over_x(1.0, 2.0);
        let empty = Axes::new("", "").titled("empty");
        let cut = Axes::new(Axis::new("x").range(1.0, 2.0), "y").with(Series::line(&ramp(9), &ramp(9)));
        Figure::new("<title>", "a & b").panel(panel).panel(empty).panel(cut)
    }

    #[test]
    fn every_document_is_well_formed_and_free_of_nan() {
        for figure in [nasty(), nasty().small().columns(2), nasty().stacked(), Figure::new("", "")] {
            for text in [figure.svg(), figure.inline()] {
                let document = roxmltree::Document::parse(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
                assert_eq!(document.root_element().attribute("role"), Some("img"));
                assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
            }
        }
        let text = nasty().svg();
        let document = roxmltree::Document::parse(&text).unwrap();
        let words: Vec<&str> = document.descendants().filter_map(|n| n.text()).collect();
        for sentence in ["<title>", "a & b", "u <V> & []", "\"y\" > 0", "<4>", "'"] {
            assert!(words.contains(&sentence), "{sentence}: {words:?}");
        }
    }

    #[test]
    fn the_same_figure_gives_the_same_bytes() {
        assert_eq!(nasty().svg(), nasty().svg());
        assert!(nasty().svg().contains(&nasty().inline()[nasty().inline().len() - 400..]));
    }

    #[test]
    fn a_hundred_thousand_points_make_a_small_file() {
        let n = 100_000;
        let t = ramp(n);
        let noise: Vec<f64> = (0..n as u32).map(|i| f64::from(i.wrapping_mul(2_654_435_761) >> 8)).collect();
        let wave = |rate: f64| t.iter().map(|t| (t * rate).sin()).collect::<Vec<f64>>();
        let drifting: Vec<f64> = wave(0.011).iter().zip(&t).map(|(y, t)| y + 1e-5 * t).collect();
        let gaps: Vec<f64> = noise.iter().enumerate().map(|(i, v)| if i % 2 == 0 { *v } else { f64::NAN }).collect();
        let huge = [
            Series::line(&t, &noise),
            Series::line(&t, &wave(0.3)),
            Series::line(&wave(0.01), &drifting),
            Series::dots(&noise, &t),
            Series::dots(&t, &noise),
            Series::marked(&t, &noise),
            Series::line(&t, &gaps),
            Series::band(&t, &noise, &wave(0.2)),
        ];
        for (i, series) in huge.into_iter().enumerate() {
            let bytes = Figure::new("huge", "").panel(Axes::new("x", "y").with(series)).svg().len();
            assert!(bytes < 60_000, "series {i}: {bytes} bytes");
        }
    }

    #[test]
    fn a_measurement_is_drawn_wide_below_a_model_that_was_added_before_it() {
        let (model, measured) = (Series::line(&ramp(3), &ramp(3)), Series::wide(&ramp(3), &ramp(3)));
        let text = Figure::new("", "").panel(Axes::new("t", "y").with(model).with(measured)).inline();
        let at = |class: &str| text.find(class).unwrap_or_else(|| panic!("{class}: {text}"));
        assert!(at("class=\"pz-under\"") < at("class=\"pz-line\""), "{text}");
    }

    #[test]
    fn lines_that_coincide_differ_in_their_dashes() {
        let line = |k| Series::line(&ramp(3), &ramp(3)).dashes(k);
        let drawn = |k| Figure::new("", "").panel(Axes::new("t", "y").with(line(k))).inline();
        let all: std::collections::BTreeSet<String> = (0..5).map(drawn).collect();
        assert_eq!(all.len(), 5);
        assert!(!drawn(0).contains("stroke-dasharray:") && drawn(1).contains("stroke-dasharray:9 6"));
    }

    #[test]
    fn stacked_panels_share_their_x_axis_and_label_it_once() {
        let panel = |to: usize| Axes::new("t [s]", "y").with(Series::line(&ramp(to), &ramp(to)));
        let text = Figure::new("", "").panel(panel(3)).panel(panel(11).height(0.5)).stacked().inline();
        assert_eq!(text.matches("t [s]").count(), 1);
        assert_eq!(text.matches(">10</text>").count(), 2, "once below, once as y: {text}");
    }
}
