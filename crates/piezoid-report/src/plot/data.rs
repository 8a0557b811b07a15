//! The data of figures, for the plots that take their place on a page with scripts: panels, axes and series as JSON.
//!
//! Numbers have six digits of the span that is drawn. Long series keep at most some thousand points, by the same means
//! as the drawing but finer, so that there is something to zoom into.

use super::axes::{Axes, Mark};
use super::path::Point;
use super::scale::Scale;
use super::series::{Series, SeriesKind};
use super::svg::DASHES;
use super::{Figure, decimate, text::rendered};
use serde::Serialize;

/// Number of points from which a series is thinned.
const MANY: usize = 1200;
/// Columns of a thinned curve; each keeps its first, lowest, highest and last point.
const COLUMNS: f64 = 600.0;
/// Width and height of the drawing in which thinned loops look the same.
const FINE: Point = [2000.0, 1200.0];
/// Largest deviation of a curve of which every n-th point is kept [units of the fine drawing].
const DEVIATION: f64 = 0.5;
/// Significant digits of the span of an axis.
const DIGITS: i32 = 6;

/// A plot: panels over one x axis.
#[derive(Debug, Serialize)]
struct Plot {
    title: String,
    /// The line above it.
    #[serde(skip_serializing_if = "String::is_empty")]
    name: String,
    /// Height over width.
    height: f64,
    x: PlotAxis,
    panels: Vec<PlotPanel>,
    /// True if lines may go back in x.
    loops: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    span: Option<Span>,
}

#[derive(Debug, Serialize)]
struct PlotAxis {
    label: String,
    unit: String,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    log: bool,
    span: Span,
}

#[derive(Debug, Serialize)]
struct PlotPanel {
    y: PlotAxis,
    series: Vec<PlotSeries>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    levels: Vec<Level>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    places: Vec<Level>,
}

#[derive(Debug, Serialize, Clone, Copy, PartialEq)]
struct Span {
    from: f64,
    to: f64,
}

/// A line across a panel.
#[derive(Debug, Serialize)]
struct Level {
    at: f64,
    label: String,
}

/// A series; a break is `null`. Evenly spaced x are `start` and `step`.
#[derive(Debug, Serialize, Default)]
struct PlotSeries {
    name: String,
    colour: usize,
    style: &'static str,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    dash: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    step: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    x: Vec<Option<f64>>,
    y: Vec<Option<f64>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    lower: Vec<Option<f64>>,
}

impl Figure {
    /// The plots of this figure for the inside of a `script` element, as JSON without markup; `None` without any data.
    /// A series without a name has that of the series in `beside` which looks the same.
    pub(crate) fn data(&self, beside: &[Figure]) -> Option<String> {
        let all = || self.panels.iter().flat_map(|panel| &panel.series);
        if all().all(Series::is_empty) {
            return None;
        }
        let known: Vec<&Series> = all().chain(beside.iter().flat_map(|f| &f.panels).flat_map(|p| &p.series)).collect();
        let plots: Vec<Plot> = match self.stacked {
            true => vec![self.plot(&self.panels, &known)],
            false => self.panels.iter().map(|panel| self.plot(std::slice::from_ref(panel), &known)).collect(),
        };
        let text = serde_json::to_string(&plots).ok()?;
        // What could end the element, or is markup.
        Some(['<', '>', '&'].iter().fold(text, |text, c| text.replace(*c, &format!("\\u{:04x}", *c as u32))))
    }

    /// One plot of panels over a common x axis.
    fn plot(&self, panels: &[Axes], known: &[&Series]) -> Plot {
        let last = &panels[panels.len() - 1];
        let (x, _) = last.x.resolve(panels.iter().flat_map(Axes::xs), 6);
        let own = [panels[0].title.clone(), split(&last.y.label).0];
        let title = match (self.panels.len() > panels.len(), own) {
            (false, _) => self.title.clone(),
            (true, [title, label]) => format!("{}: {}", self.title, if title.is_empty() { label } else { title }),
        };
        let strips = panels.iter().flat_map(|panel| &panel.marks).filter_map(|mark| match mark {
            Mark::OverX(from, to) => Some(Span { from: *from, to: *to }),
            _ => None,
        });
        Plot {
            title: rendered(&title),
            name: rendered(&panels[0].title),
            height: panels.iter().map(|panel| panel.height).sum::<f64>() * self.panel[1] / self.panel[0],
            x: PlotAxis::new(&last.x.label, last.x.log, &x),
            loops: !panels.iter().flat_map(|panel| &panel.series).all(|series| decimate::rises(&series.points)),
            span: strips.into_iter().next(),
            panels: panels.iter().map(|panel| PlotPanel::of(panel, &x, last.x.log, known)).collect(),
        }
    }
}

/// A label without its unit, and the unit.
fn split(label: &str) -> (String, String) {
    match label.strip_suffix(']').and_then(|label| label.rsplit_once('[')) {
        Some((label, unit)) => (rendered(label.trim_end()), rendered(unit)),
        None => (rendered(label), String::new()),
    }
}

impl PlotAxis {
    fn new(label: &str, log: bool, scale: &Scale) -> Self {
        let ((label, unit), digits) = (split(label), Digits::of(scale, log));
        PlotAxis { label, unit, log, span: Span { from: digits.rounded(scale.low), to: digits.rounded(scale.high) } }
    }
}

impl PlotPanel {
    fn of(panel: &Axes, x: &Scale, log: bool, known: &[&Series]) -> Self {
        let (y, _) = panel.y.resolve(panel.ys(), 6);
        let (mut levels, mut places) = (Vec::new(), Vec::new());
        for mark in &panel.marks {
            match mark {
                Mark::Y(at, label) => levels.push(Level { at: *at, label: rendered(label) }),
                Mark::X(at, label) => places.push(Level { at: *at, label: rendered(label) }),
                Mark::OverX(..) => {}
            }
        }
        let digits = [Digits::of(x, log), Digits::of(&y, panel.y.log)];
        let series = panel.series.iter().filter(|series| !series.is_empty());
        let series = series.map(|series| PlotSeries::of(series, name(series, known), x, &y, digits)).collect();
        PlotPanel { y: PlotAxis::new(&panel.y.label, panel.y.log, &y), series, levels, places }
    }
}

/// The name of a series, or of one that looks the same.
fn name(series: &Series, known: &[&Series]) -> String {
    let same = |other: &&&Series| {
        other.role == series.role && other.dashes == series.dashes && !other.name.is_empty() && series.name.is_empty()
    };
    rendered(known.iter().find(same).map_or(&series.name, |other| &other.name))
}

impl PlotSeries {
    fn of(series: &Series, name: String, x: &Scale, y: &Scale, digits: [Digits; 2]) -> Self {
        let style = match series.kind {
            SeriesKind::Wide => "pale",
            SeriesKind::Points => "points",
            SeriesKind::Marked => "marks",
            SeriesKind::Dots => "dots",
            SeriesKind::Dashed => "dashed",
            SeriesKind::Band => "band",
            SeriesKind::Line => "line",
        };
        let dash = DASHES[series.dashes % DASHES.len()].split_whitespace().filter_map(|part| part.parse().ok());
        let result =
            PlotSeries { name, colour: series.role.number(), style, dash: dash.collect(), ..Default::default() };
        let kept = kept(series, &x.onto(0.0, FINE[0]), &y.onto(FINE[1], 0.0));
        let number = |k: Option<usize>, axis: usize| Some(digits[axis].rounded(series.points[k?][axis]));
        let of = |axis: usize| kept.iter().map(|&k| number(k, axis)).collect::<Vec<_>>();
        let lower = |k: &Option<usize>| Some(digits[1].rounded(*series.lower.get((*k)?)?));
        let band = if series.lower.is_empty() { Vec::new() } else { kept.iter().map(lower).collect() };
        let result = PlotSeries { y: of(1), lower: band, ..result };
        match even(&kept.iter().map(|k| Some(series.points[(*k)?][0])).collect::<Vec<_>>()) {
            Some((start, step)) => PlotSeries { start: Some(start), step: Some(step), ..result },
            None => PlotSeries { x: of(0), ..result },
        }
    }
}

/// Start and step of evenly spaced numbers.
fn even(x: &[Option<f64>]) -> Option<(f64, f64)> {
    let (first, last) = ((*x.first()?)?, (*x.last()?)?);
    let step = Digits(12, None).rounded((last - first) / (x.len().max(2) - 1) as f64);
    let near = |(k, x): (usize, &Option<f64>)| x.is_some_and(|x| (x - first - k as f64 * step).abs() < 1e-6 * step);
    (x.len() > 2 && step > 0.0 && x.iter().enumerate().all(near)).then_some((first, step))
}

/// The numbers of the points to keep, `None` for a break.
fn kept(series: &Series, x: &Scale, y: &Scale) -> Vec<Option<usize>> {
    let drawn: Vec<Option<Point>> = series.points.iter().map(|p| Some([x.at(p[0])?, y.at(p[1])?])).collect();
    let mut out = Vec::new();
    let mut first = 0;
    for run in drawn.split(Option::is_none) {
        let points: Vec<Point> = run.iter().flatten().copied().collect();
        if !points.is_empty() {
            out.extend((!out.is_empty()).then_some(None));
            out.extend(thinned(series.kind, &points, drawn.len()).into_iter().map(|k| Some(first + k)));
        }
        first += run.len() + 1;
    }
    out
}

/// The numbers of the points to keep of a run, which is a part of a series of `all` points.
fn thinned(kind: SeriesKind, points: &[Point], all: usize) -> Vec<usize> {
    let n = points.len();
    if all <= MANY || n < 3 {
        return (0..n).collect();
    }
    let most = (MANY * n / all).max(3);
    if matches!(kind, SeriesKind::Dots | SeriesKind::Points) {
        return decimate::cells(points, most);
    }
    let each = n.div_ceil(most);
    // The end may be missing, less than a thousandth of the curve: even steps need no x.
    let regular: Vec<usize> = (0..n).step_by(each).collect();
    let between = |w: &[usize]| {
        let (a, b, count) = (points[w[0]], points[w[1]], (w[1] - w[0]) as f64);
        (w[0]..w[1]).all(|k| {
            let share = (k - w[0]) as f64 / count;
            (0..2).all(|axis| (a[axis] + share * (b[axis] - a[axis]) - points[k][axis]).abs() < DEVIATION)
        })
    };
    if regular.windows(2).all(between) {
        return regular;
    }
    if decimate::rises(points) {
        let share = COLUMNS * n as f64 / all as f64 / (points[n - 1][0] - points[0][0]).max(1e-9);
        let columns: Vec<Point> = points.iter().map(|p| [p[0] * share, p[1]]).collect();
        return decimate::columns(&columns);
    }
    decimate::corners(points, most)
}

/// How numbers of an axis are rounded: to so many digits, of the number itself or of the span with this exponent.
#[derive(Debug, Clone, Copy)]
struct Digits(i32, Option<i32>);

impl Digits {
    fn of(scale: &Scale, log: bool) -> Self {
        let span = (scale.high - scale.low).abs().log10().floor();
        Digits(DIGITS, (!log && span.is_finite()).then_some(span as i32))
    }

    fn rounded(self, value: f64) -> f64 {
        if value == 0.0 || !value.is_finite() {
            return value;
        }
        let own = value.abs().log10().floor() as i32;
        let digits = self.0 + self.1.map_or(0, |span| own - span);
        if digits < 1 {
            return 0.0;
        }
        format!("{value:.*e}", digits.min(17) as usize - 1).parse().unwrap_or(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Axis, Role};
    use piezoid_testing::assert_close;
    use serde_json::Value;

    fn data(figure: &Figure) -> Value {
        serde_json::from_str(&figure.data(&[]).unwrap()).unwrap()
    }

    fn numbers(value: &Value) -> Vec<f64> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
    }

    fn ramp(n: usize) -> Vec<f64> {
        (0..n).map(|k| k as f64).collect()
    }

    #[test]
    fn a_plot_has_axes_series_and_lines_of_its_figure() {
        let u = [0.0, 1.0, 0.5, f64::NAN, 0.25];
        let panel =
            Axes::new("u [um]", Axis::log("y & z [V]")).titled("</script>").at_y(2.0, "limit").at_x(0.5, "here");
        let series = Series::line(&u, &[1.0, 2.0, 1.0 / 3.0, 4.0, -1.0]).role(Role::Residual).named("a < b");
        let figure = Figure::new("T", "").panel(panel.with(series.dashes(1)));
        let text = figure.data(&[]).unwrap();
        assert!(!text.contains(['<', '>', '&']) && text.contains("a \\u003c b"), "{text}");
        let plot = &data(&figure)[0];
        assert_eq!(
            (&plot["x"]["label"], &plot["x"]["unit"], &plot["x"]["log"]),
            (&"u".into(), &"µm".into(), &Value::Null)
        );
        assert_eq!((&plot["panels"][0]["y"]["log"], &plot["loops"]), (&true.into(), &true.into()));
        let result = &plot["panels"][0]["series"][0];
        assert_eq!((&result["colour"], &result["style"], &result["dash"][0]), (&4.into(), &"line".into(), &9.0.into()));
        // What a logarithmic axis cannot show is left out.
        assert_eq!((numbers(&result["x"]), numbers(&result["y"])), (vec![0.0, 1.0, 0.5], vec![1.0, 2.0, 0.333333]));
        assert_eq!(plot["panels"][0]["levels"][0]["label"], "limit");
        assert_eq!(plot["panels"][0]["places"][0]["at"], 0.5);
    }

    #[test]
    fn a_figure_without_points_has_no_data() {
        assert_eq!(Figure::new("", "").panel(Axes::new("x", "y")).data(&[]), None);
        assert_eq!(Figure::new("", "").panel(Axes::new("x", "y").with(Series::line(&[], &[]))).data(&[]), None);
    }

    #[test]
    fn numbers_have_six_digits_of_what_is_drawn() {
        let figure = |y: [f64; 2]| Figure::new("", "").panel(Axes::new("x", "y").with(Series::line(&[0.0, 3.0], &y)));
        let y = |y| numbers(&data(&figure(y))[0]["panels"][0]["series"][0]["y"]);
        assert_eq!(y([1.0 / 3.0, 2.0 / 3.0]), [0.333333, 0.666667]);
        assert_eq!(y([1e6 + 1.0 / 3.0, 1e6 + 1.0]), [1_000_000.333333, 1_000_001.0], "a small span far from zero");
        assert_eq!(y([1e-9, 123.456789]), [0.0, 123.457], "nothing beside a large span");
    }

    #[test]
    fn a_break_is_null_and_even_steps_are_start_and_step() {
        let t: Vec<f64> = (0..40).map(|k| 0.5 + f64::from(k) * 5e-4).collect();
        let y: Vec<f64> = t.iter().map(|t| t * t).collect();
        let plot = data(&Figure::new("", "").panel(Axes::new("t", "y").with(Series::line(&t, &y))));
        let result = &plot[0]["panels"][0]["series"][0];
        assert_eq!((&result["start"], &result["step"], &result["x"]), (&0.5.into(), &5e-4.into(), &Value::Null));
        assert_eq!(plot[0]["loops"], false);
        let gap = [0.0, f64::NAN, 2.0, 3.0];
        let plot = data(&Figure::new("", "").panel(Axes::new("t", "y").with(Series::line(&ramp(4), &gap))));
        assert_eq!(plot[0]["panels"][0]["series"][0]["y"].to_string(), "[0.0,null,2.0,3.0]");
    }

    #[test]
    fn long_series_keep_their_shape_in_some_thousand_points() {
        let n = 100_000;
        let wave: Vec<f64> = (0..n).map(|k| (f64::from(k) * 2e-4).sin()).collect();
        let mut spike = wave.clone();
        spike[31_416] = 7.0;
        let turn: Vec<f64> = (0..n).map(|k| (f64::from(k) * 2e-4).cos()).collect();
        let noise: Vec<f64> = (0..n as u32).map(|i| f64::from(i.wrapping_mul(2_654_435_761) >> 8)).collect();
        let of = |series: Series| {
            let result = data(&Figure::new("", "").panel(Axes::new("x", "y").with(series)));
            let series = result[0]["panels"][0]["series"][0].clone();
            assert!(series.to_string().len() < 80_000, "{}", series.to_string().len());
            series
        };
        let t = ramp(n as usize);
        let regular = of(Series::line(&t, &wave));
        assert!(regular["x"].is_null(), "every so many samples of a smooth curve");
        let ends = |result: &Value| piezoid_numerics::series::ends(numbers(&result["y"]));
        assert_close(&[ends(&regular).1], &[1.0], 0.0, 1e-4);
        assert_eq!(ends(&of(Series::line(&t, &spike))).1, 7.0);
        assert!(numbers(&of(Series::line(&turn, &wave))["y"]).len() <= MANY);
        assert!(numbers(&of(Series::dots(&t, &noise))["y"]).len() <= MANY);
        let loudest = noise.iter().copied().fold(0.0, f64::max);
        assert_close(&[ends(&of(Series::line(&t, &noise))).1], &[loudest], 1e-5, 0.0);
    }

    #[test]
    fn unnamed_series_are_called_as_those_that_look_the_same() {
        let line = |role| Series::line(&[0.0, 1.0], &[0.0, 1.0]).role(role);
        let top = Axes::new("t", "y").with(line(Role::Model).named("model")).with(line(Role::Ascending).named("up"));
        let figure = Figure::new("", "").panel(top).panel(Axes::new("t", "e").with(line(Role::Model))).stacked();
        assert_eq!(data(&figure)[0]["panels"][1]["series"][0]["name"], "model");
        let alone = Figure::new("", "").panel(Axes::new("t", "e").with(line(Role::Ascending)));
        assert_eq!(data(&alone)[0]["panels"][0]["series"][0]["name"], "");
        assert!(alone.data(std::slice::from_ref(&figure)).unwrap().contains("\"up\""));
    }
}
