//! The hysteresis block in the report: its law, its parameters, and the loops that it makes by itself.

use super::Trial;
use crate::hammerstein::Model;
use crate::hysteresis::Hysteresis;
use crate::number::{round, short};
use crate::page::{Cell, Section, Table, Text};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use crate::series::ends;
use serde_json::Value;
use std::f64::consts::PI;

/// Minor loops on the way up and on the way down, from where to where: shares of the range.
const MINOR: [(f64, f64); 4] = [(0.45, 0.2), (0.85, 0.6), (0.55, 0.8), (0.15, 0.4)];

/// Samples from one end to the other: where time does not matter, and the fewest and the most where it does.
const TIMELESS: usize = 400;
const FEWEST: f64 = 20.0;
const MOST: f64 = 20_000.0;

/// Adds the block.
pub(super) fn block(section: Section, model: &Model, trials: &[Trial]) -> Section {
    let (hysteresis, unit) = (model.hysteresis(), &model.units().u);
    let operator = hysteresis.operator();
    let range = range(model, trials);
    let said = hysteresis
        .range()
        .map_or(String::new(), |(low, high)| format!("; identified from {} to {} {unit}", short(low), short(high)));
    let law =
        Text::new().code(operator.name).plain(format!(", {}{said}. Source: {}.", operator.summary, operator.reference));
    let section = section.heading("Hysteresis").text(law);
    let section = match range.and_then(|range| figure(model, range)) {
        Some(figure) => section.figure(figure),
        None => section,
    };
    section.table(parameters(hysteresis))
}

/// The inputs to show: those the operator was identified on, the model, or those of the records.
fn range(model: &Model, trials: &[Trial]) -> Option<(f64, f64)> {
    let seen = || trials.iter().flat_map(|t| t.record.u()).copied();
    let domain = model.identified().map(|domain| (domain.u[0], domain.u[1]));
    let range = model.hysteresis().range().or(domain).unwrap_or_else(|| ends(seen()));
    (range.0 < range.1).then_some(range)
}

/// The loops of the operator; none where it makes no loop.
fn figure(model: &Model, (low, high): (f64, f64)) -> Option<Figure> {
    let hysteresis = model.hysteresis();
    let (slow, fast) = speeds(model);
    let at = |share: f64| low + share * (high - low);
    // From turning point to turning point as a sine goes; the first way there and back makes the operator forget.
    let leg = |from: f64, to: f64, n: usize| {
        let n = ((to - from).abs() * n as f64).ceil().max(FEWEST);
        (1..=n as usize).map(move |k| at(from + (to - from) * 0.5 * (1.0 - (PI * k as f64 / n).cos()))).collect()
    };
    let mut x = hysteresis.settled(low);
    let mut run = |u: Vec<f64>| (hysteresis.resume(&mut x, &u), u);
    let mut major = |n| {
        run(leg(0.0, 1.0, n));
        run(leg(1.0, 0.0, n));
        [run(leg(0.0, 1.0, n)), run(leg(1.0, 0.0, n))]
    };
    let quick = fast.map(&mut major);
    let [(up, u_up), (down, u_down)] = major(slow);

    let (mut minor, mut u_minor, mut place) = (Vec::new(), Vec::new(), 0.0);
    for (k, (from, to)) in MINOR.into_iter().enumerate() {
        if k == MINOR.len() / 2 {
            run(leg(place, 1.0, slow));
            place = 1.0;
        }
        run(leg(place, from, slow));
        for (z, u) in [run(leg(from, to, slow)), run(leg(to, from, slow))] {
            minor.extend(z);
            u_minor.extend(u);
        }
        // A gap before the next one.
        minor.push(f64::NAN);
        u_minor.push(f64::NAN);
        place = from;
    }

    let (bottom, top) = ends(up.iter().chain(&down).copied());
    let width = 100.0 * (down[down.len() / 2 - 1] - up[up.len() / 2 - 1]).abs() / (top - bottom);
    if !(width > 1e-6 && width.is_finite()) {
        return None;
    }
    let caption = caption(model, width, slow, fast);
    let panel = Axes::new(Axis::new(format!("u [{}]", model.units().u)), "z")
        .with(Series::line(&u_up, &up).role(Role::Ascending).named("ascending"))
        .with(Series::line(&u_down, &down).role(Role::Descending).named("descending"))
        .with(Series::line(&u_minor, &minor).role(Role::Model).named("minor loops"));
    let panel = match quick {
        Some([(up, u_up), (down, u_down)]) => {
            let (u, z) = ([u_up, u_down].concat(), [up, down].concat());
            panel.with(Series::dashed(&u, &z).named("fast"))
        }
        None => panel,
    };
    Some(Figure::new("Loops of the hysteresis block", caption).panel(panel))
}

/// Samples from one end to the other, for an operator that minds the time: at the lowest and at the highest frequency it was
/// identified at, where they differ.
fn speeds(model: &Model) -> (usize, Option<usize>) {
    let hysteresis = model.hysteresis();
    if hysteresis.operator().rate_independent {
        return (TIMELESS, None);
    }
    let known =
        hysteresis.frequencies().or(model.identified().and_then(|domain| domain.hz).map(|[low, high]| (low, high)));
    let samples = |hz: f64| (0.5 / (hz * hysteresis.ts())).clamp(FEWEST, MOST).round() as usize;
    match known.map(|(low, high)| (samples(low), samples(high))) {
        Some((slow, fast)) if slow > 2 * fast => (slow, Some(fast)),
        Some((slow, _)) => (slow, None),
        None => (TIMELESS, None),
    }
}

fn caption(model: &Model, width: f64, slow: usize, fast: Option<usize>) -> String {
    let hysteresis = model.hysteresis();
    let hz = |samples: usize| round((500.0 / (samples as f64 * hysteresis.ts())).round() / 1e3);
    let time = match (hysteresis.operator().rate_independent, fast) {
        (true, _) => String::new(),
        (false, None) => format!(" This operator minds the time: it is run through at {} Hz.", hz(slow)),
        (false, Some(fast)) => {
            format!(
                " This operator minds the time: it is run through at {} Hz, and, dashed, at {} Hz.",
                hz(slow),
                hz(fast)
            )
        }
    };
    let inside = match hysteresis.operator().minor_loops {
        true => "with minor loops inside",
        false => "and what it does inside, where it has no minor loops but jumps from branch to branch",
    };
    let width = short(width);
    format!(
        "The hidden variable over the input, as the operator makes it: the major loop, {width} % of its height wide, {inside}.{time}"
    )
}

/// The parameters as the model's file has them; of lists, how many and from where to where.
fn parameters(hysteresis: &dyn Hysteresis) -> Table {
    let mut rows = Vec::new();
    let document = Value::Object(hysteresis.params().into_iter().filter(|(name, _)| name != "range").collect());
    collect("", &document, &mut rows);
    let table = Table::new("Parameters of the hysteresis block").text("parameter").number("value");
    rows.into_iter().fold(table, |table, (name, value)| table.row([Cell::from(Text::new().code(name)), value.into()]))
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
            format!("{} from {} to {}", values.len(), round(low), round(high))
        }
    }
}
