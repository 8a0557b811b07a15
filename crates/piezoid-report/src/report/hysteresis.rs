//! The hysteresis block in the report: operator, parameters, and loops.

use crate::each::Each;
use crate::page::{Cell, PageTable, Section, Text};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::hammerstein::Model;
use piezoid::hysteresis::Hysteresis;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::series::ends;
use piezoid_verbs::Compared;
use serde_json::Value;
use std::f64::consts::PI;

/// Minor loops, two on the ascending and two on the descending branch: their ends as shares of the range.
const MINOR: [(f64, f64); 4] = [(0.45, 0.2), (0.85, 0.6), (0.55, 0.8), (0.15, 0.4)];

/// Samples from one end of the range to the other: default, minimum and maximum.
const USUAL: f64 = 400.0;
const FEWEST: f64 = 8.0;
const MAX_LEG_SAMPLES: f64 = 20_000.0;

/// Adds the block.
pub(super) fn block(section: Section, model: &Model, trials: &[Compared]) -> Section {
    let (hysteresis, unit) = (model.hysteresis(), &model.units().u);
    let operator = hysteresis.operator();
    let range = range(model, trials);
    let identified = hysteresis
        .range()
        .map_or(String::new(), |(low, high)| format!("; identified from {} to {} {unit}", short(low), short(high)));
    let plain = format!(", {}{identified}. Source: {}.", operator.summary, operator.reference);
    let law = Text::new().code(operator.name).plain(plain);
    let figure = range.and_then(|range| figure(model, range));
    section.heading("Hysteresis").text(law).each(figure, Section::figure).table(parameters(hysteresis))
}

/// The range to show: that of the operator's or the model's identification data, or of the records.
fn range(model: &Model, trials: &[Compared]) -> Option<(f64, f64)> {
    let observed = || trials.iter().flat_map(|t| t.record.u()).copied();
    let domain = model.identified().map(|domain| (domain.u[0], domain.u[1]));
    let range = model.hysteresis().range().or(domain).unwrap_or_else(|| ends(observed()));
    (range.0 < range.1).then_some(range)
}

/// Runs an operator between reversal points, each a share of its range.
struct OperatorSweep<'a> {
    hysteresis: &'a dyn Hysteresis,
    range: (f64, f64),
    state: Vec<f64>,
    at: f64,
}

/// Inputs and outputs of a part of the run.
type Curve = [Vec<f64>; 2];

impl OperatorSweep<'_> {
    /// Moves along a half sine to a reversal point, with `n` samples for the whole range.
    fn to(&mut self, end: f64, n: f64) -> Curve {
        let (from, (low, high)) = (self.at, self.range);
        let n = ((end - from).abs() * n).ceil().max(FEWEST);
        let share = |k: i32| from + (end - from) * 0.5 * (1.0 - (PI * f64::from(k) / n).cos());
        let u: Vec<f64> = (1..=n as i32).map(|k| low + share(k) * (high - low)).collect();
        self.at = end;
        let z = self.hysteresis.resume(&mut self.state, &u);
        [u, z]
    }

    /// The major loop, ascending and descending, after one loop that wipes out the past.
    fn major(&mut self, n: f64) -> [Curve; 2] {
        self.to(1.0, n);
        self.to(0.0, n);
        [1.0, 0.0].map(|end| self.to(end, n))
    }

    /// The minor loops, separated by gaps.
    fn minor(&mut self, n: f64) -> Curve {
        let mut all: Curve = Default::default();
        for (k, (from, to)) in MINOR.into_iter().enumerate() {
            if k == MINOR.len() / 2 {
                self.to(1.0, n);
            }
            self.to(from, n);
            for way in [self.to(to, n), self.to(from, n), [vec![f64::NAN], vec![f64::NAN]]] {
                all.iter_mut().zip(way).for_each(|(all, way)| all.extend(way));
            }
        }
        all
    }
}

/// The loops of the operator; `None` if they have no width.
fn figure(model: &Model, range: (f64, f64)) -> Option<Figure> {
    let hysteresis = model.hysteresis();
    let samples = |hz: f64| 0.5 / (hz * hysteresis.ts());
    let mut sweep = OperatorSweep { hysteresis, range, state: hysteresis.settled(range.0), at: 0.0 };
    let (slow, fast) = speeds(model);
    let quick = fast.map(|hz| {
        let [[up_u, up_z], [down_u, down_z]] = sweep.major(samples(hz));
        ([up_u, down_u].concat(), [up_z, down_z].concat(), hz)
    });
    let [up, down] = sweep.major(samples(slow));
    let minor = sweep.minor(samples(slow));

    let (bottom, top) = ends(up[1].iter().chain(&down[1]).copied());
    let middle = up[1].len() / 2 - 1;
    let width = 100.0 * (down[1][middle] - up[1][middle]).abs() / (top - bottom);
    if !(width > 1e-6 && width.is_finite()) {
        return None;
    }
    let inside = if hysteresis.operator().minor_loops { "minor loops" } else { "inside" };
    let panel = Axes::new(Axis::new(format!("u [{}]", model.units().u)), "z")
        .with(Series::line(&up[0], &up[1]).role(Role::Ascending).named("ascending"))
        .with(Series::line(&down[0], &down[1]).role(Role::Descending).named("descending"))
        .with(Series::line(&minor[0], &minor[1]).role(Role::Model).named(inside))
        .each(&quick, |panel, (u, z, hz)| panel.with(Series::dashed(u, z).named(format!("{} Hz", round(*hz)))));
    Some(Figure::new("Loops of the hysteresis block", caption(hysteresis, width, slow, fast)).panel(panel))
}

/// The frequencies of the loops [Hz]. For a rate-dependent operator: the lowest and the highest of its identification
/// data, the highest only if it differs.
fn speeds(model: &Model) -> (f64, Option<f64>) {
    let hysteresis = model.hysteresis();
    let of = |samples: f64| 0.5 / (samples * hysteresis.ts());
    let domain = || model.identified().and_then(|domain| domain.hz).map(|[low, high]| (low, high));
    let known = hysteresis.frequencies().or_else(domain).filter(|_| !hysteresis.operator().rate_independent);
    let Some((low, high)) = known else { return (of(USUAL), None) };
    let [low, high] = [low, high].map(|hz| hz.clamp(of(MAX_LEG_SAMPLES), of(FEWEST)));
    (low, (high > 2.0 * low).then_some(high))
}

fn caption(hysteresis: &dyn Hysteresis, width: f64, slow: f64, fast: Option<f64>) -> String {
    let operator = hysteresis.operator();
    let faster = fast.map_or(String::new(), |hz| format!(", and, dashed, at {} Hz", round(hz)));
    let time = match operator.rate_independent {
        true => String::new(),
        false => format!(" This operator is rate-dependent: its loops are drawn for {} Hz{faster}.", round(slow)),
    };
    let inside = match operator.minor_loops {
        true => "with minor loops inside",
        false => "and inputs inside its range, where it has no minor loops but jumps between the branches",
    };
    let width = short(width);
    format!("Hidden variable z against input u: the major loop (width {width} % of its height) {inside}.{time}")
}

/// The parameters as in the model's file; of lists, the length and range.
fn parameters(hysteresis: &dyn Hysteresis) -> PageTable {
    let mut rows = Vec::new();
    let document = Value::Object(hysteresis.params().into_iter().filter(|(name, _)| name != "range").collect());
    collect("", &document, &mut rows);
    let row = |(name, value): (String, String)| [Cell::from(Text::new().code(name)), value.into()];
    let table = PageTable::new("Parameters of the hysteresis block").text("parameter").number("value");
    table.rows(rows.into_iter().map(row))
}

fn collect(name: &str, value: &Value, rows: &mut Vec<(String, String)>) {
    let within = |key: &str| if name.is_empty() { key.to_string() } else { format!("{name}.{key}") };
    let numbers = |values: &[Value]| values.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>();
    match value {
        Value::Object(members) => members.iter().for_each(|(key, value)| collect(&within(key), value, rows)),
        Value::Array(values) => match numbers(values) {
            Some(all) => rows.push((name.into(), spread(&all))),
            None => (1..).zip(values).for_each(|(k, value)| collect(&within(&k.to_string()), value, rows)),
        },
        Value::Number(number) => rows.push((name.into(), number.as_f64().map_or_else(|| number.to_string(), round))),
        Value::String(text) => rows.push((name.into(), text.clone())),
        other => rows.push((name.into(), other.to_string())),
    }
}

fn spread(values: &[f64]) -> String {
    match values {
        [] => "none".into(),
        [one] => round(*one),
        _ => {
            let (low, high) = ends(values.iter().copied());
            format!("{} values from {} to {}", values.len(), round(low), round(high))
        }
    }
}
