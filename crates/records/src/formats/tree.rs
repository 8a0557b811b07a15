//! Nested content: structures of MATLAB, groups of HDF5 and TDMS, arrays of NumPy.
//!
//! ```text
//! t, u, y                                    arrays, at any depth
//! fs = 2000, Ts = 5e-4, sample_rate = 2000   the sampling period
//! {values, label, unit}, {Data, Name, Unit}  one channel, as Simulink, dSPACE and others write it
//! ```
//! A channel has the name of its array; if there are several of one name, also those of the groups around it.

use super::csv::stated_period;
use super::time::agreed;
use super::{Channel, Table, history};
use std::collections::HashMap;

/// Fields that hold the samples of a structure that is one channel.
const SAMPLES: [&str; 4] = ["values", "value", "data", "samples"];
/// Fields that hold its name.
const NAMES: [&str; 4] = ["name", "label", "channelname", "title"];
/// Fields that hold its unit.
const UNITS: [&str; 3] = ["unit", "units", "unitstring"];

/// A named content.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Node {
    /// An array with all that is known of it; its name is that of the node.
    Series(Channel),
    /// A line of text.
    Text(String),
    /// A structure or a group.
    Fields(Vec<(String, Node)>),
    /// Structures in an array.
    Items(Vec<Node>),
}

impl Node {
    /// An array, or a description if it is not a vector of real numbers; with its unit, if that stands beside it.
    pub(super) fn series(samples: Result<Vec<f64>, String>, unit: Option<String>) -> Self {
        Node::Series(Channel { unit, samples, ..Channel::new("", Vec::new()) })
    }

    /// The same, with the sampling period [s] that stands beside it.
    pub(super) fn every(self, ts: Option<f64>) -> Self {
        match self {
            Node::Series(channel) => Node::Series(Channel { ts: channel.ts.or(ts), ..channel }),
            other => other,
        }
    }

    /// What is left out, with a description.
    pub(super) fn other(what: impl Into<String>) -> Self {
        Node::Series(Channel::other("", what))
    }
}

/// The table of a file's content.
pub(super) fn table(content: Vec<(String, Node)>) -> Table {
    let mut found = Found::default();
    for (name, node) in content {
        found.walk(&[], name, node);
    }
    let mut counts: HashMap<String, usize> = HashMap::new();
    found.channels.iter().for_each(|(_, channel)| *counts.entry(channel.name.clone()).or_default() += 1);
    let Found { channels, periods, steps } = found;
    let own = channels.iter().filter_map(|(_, channel)| channel.ts);
    let only = agreed(periods.iter().map(|(_, ts)| *ts).chain(own));
    // Of several rates, that of the nearest group around a channel.
    let around = |path: &[String]| {
        let stated = |depth: usize| {
            let inside = |(group, _): &&(Vec<String>, f64)| group.len() == depth && path.starts_with(group);
            periods.iter().filter(inside).map(|(_, ts)| *ts).collect::<Vec<_>>()
        };
        agreed((0..=path.len()).rev().map(stated).find(|stated| !stated.is_empty())?)
    };
    let named = |(path, channel): (Vec<String>, Channel)| {
        let ts = if only.is_some() { channel.ts } else { channel.ts.or_else(|| around(&path)) };
        let name = match counts.get(&channel.name) {
            Some(1) | None => channel.name,
            Some(_) => [path, vec![channel.name]].concat().join("/"),
        };
        Channel { name, ts, ..channel }
    };
    Table { ts: only, steps, ..Table::of(channels.into_iter().map(named)) }
}

#[derive(Default)]
struct Found {
    /// Channels, with the names of the groups around them.
    channels: Vec<(Vec<String>, Channel)>,
    /// Stated sampling periods [s], with the names of the groups they stand in.
    periods: Vec<(Vec<String>, f64)>,
    /// The history of the record.
    steps: Vec<String>,
}

impl Found {
    fn walk(&mut self, path: &[String], name: String, node: Node) {
        match node {
            Node::Text(text) if name == history::NAME => self.steps = history::steps(&text),
            Node::Text(_) => {}
            Node::Series(channel) => {
                if let Ok([value]) = channel.samples.as_deref() {
                    self.periods.extend(stated_period(&name, *value).map(|ts| (path.to_vec(), ts)));
                }
                self.channels.push((path.to_vec(), Channel { name, ..channel }));
            }
            Node::Fields(fields) => {
                let inner = [path, std::slice::from_ref(&name)].concat();
                match channel(&name, &fields) {
                    Some(found) => self.channel(path, found),
                    None => fields.into_iter().for_each(|(name, node)| self.walk(&inner, name, node)),
                }
            }
            Node::Items(items) => {
                let each = |item: &Node| if let Node::Fields(fields) = item { channel(&name, fields) } else { None };
                match items.iter().map(each).collect::<Option<Vec<_>>>() {
                    Some(channels) => channels.into_iter().for_each(|found| self.channel(path, found)),
                    None => {
                        let what = format!("structures, 1 x {}", items.len());
                        self.channels.push((path.to_vec(), Channel::other(name, what)));
                    }
                }
            }
        }
    }

    /// Adds a channel, and its own time.
    fn channel(&mut self, path: &[String], (channel, time): (Channel, Option<Channel>)) {
        let inner = [path, std::slice::from_ref(&channel.name)].concat();
        self.channels.push((path.to_vec(), channel));
        self.channels.extend(time.map(|time| (inner, time)));
    }
}

/// A structure that is one channel, and the times in it.
fn channel(name: &str, fields: &[(String, Node)]) -> Option<(Channel, Option<Channel>)> {
    let one_of = |names: &[&str], name: &str| names.contains(&&*name.to_lowercase());
    // Units may stand in a structure of information on the data.
    let text = |names: &[&str]| texts(fields, "datainfo").find(|(name, _)| one_of(names, name)).map(|(_, text)| text);
    let vector = |names: &[&str]| {
        fields.iter().find_map(|(name, node)| match node {
            Node::Series(channel) if one_of(names, name) => Some(channel.samples.clone()),
            _ => None,
        })
    };
    let inner = |(name, node): &(String, Node)| match node {
        Node::Fields(inner) if one_of(&SAMPLES, name) => channel(name, inner),
        _ => None,
    };
    let (samples, inside) = match vector(&SAMPLES) {
        Some(samples) => (samples, None),
        None => {
            let (found, time) = fields.iter().find_map(inner)?;
            (found.samples.clone(), Some((found, time)))
        }
    };
    let own = text(&NAMES);
    let unit = text(&UNITS).or_else(|| inside.as_ref()?.0.unit.clone());
    // Samples beside others are one channel of several.
    let vectors = fields.iter().filter(|(name, node)| {
        matches!(node, Node::Series(Channel { samples: Ok(v), .. }) if v.len() > 1) && !one_of(&["time"], name)
    });
    let alone = vectors.count() <= 1;
    if own.is_none() && unit.is_none() && !alone {
        return None;
    }
    let time = vector(&["time"]).map(|samples| Channel { samples, ..Channel::new("time", Vec::new()) });
    let time = time.or_else(|| inside.and_then(|(_, time)| time));
    let name = own.unwrap_or_else(|| name.into());
    Some((Channel { unit, samples, ..Channel::new(name, Vec::new()) }, time))
}

/// The texts among fields, and those in the structure of this name.
fn texts<'a>(fields: &'a [(String, Node)], inner: &'a str) -> impl Iterator<Item = (&'a str, String)> {
    let inside = fields.iter().filter_map(move |(name, node)| match node {
        Node::Fields(more) if name.eq_ignore_ascii_case(inner) => Some(more),
        _ => None,
    });
    fields.iter().chain(inside.flatten()).filter_map(|(name, node)| match node {
        Node::Text(text) if !text.trim().is_empty() => Some((name.as_str(), text.trim().to_string())),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::ColumnSelection;

    fn vector(values: &[f64]) -> Node {
        Node::series(Ok(values.to_vec()), None)
    }

    fn fields(fields: &[(&str, Node)]) -> Node {
        Node::Fields(fields.iter().map(|(name, node)| (name.to_string(), node.clone())).collect())
    }

    fn text(text: &str) -> Node {
        Node::Text(text.into())
    }

    const U: [f64; 3] = [0.0, 1.0, 2.0];
    const Y: [f64; 3] = [0.5, 1.5, 2.5];
    const T: [f64; 3] = [0.0, 0.5e-3, 1e-3];

    #[test]
    fn one_record_is_found_in_any_structure() {
        let simulink = fields(&[
            ("time", vector(&T)),
            (
                "signals",
                Node::Items(vec![
                    fields(&[("values", vector(&U)), ("label", text("Voltage")), ("dimensions", vector(&[1.0]))]),
                    fields(&[("values", vector(&Y)), ("label", text("Position"))]),
                ]),
            ),
        ]);
        let units = fields(&[
            ("drive", fields(&[("Data", vector(&U)), ("Unit", text("Volts"))])),
            ("sensor", fields(&[("Data", vector(&Y)), ("Unit", text("um"))])),
            ("Ts", vector(&[5e-4])),
        ]);
        let rates = fields(&[("u", vector(&U)), ("y", vector(&Y)), ("fs", vector(&[2000.0]))]);
        let iddata = fields(&[("OutputData", vector(&Y)), ("InputData", vector(&U)), ("Ts", vector(&[5e-4]))]);
        let logged = |name: &str, samples: &[f64]| {
            let values = fields(&[("Time", vector(&T)), ("Data", vector(samples))]);
            fields(&[("Name", text(name)), ("BlockPath", text("controller")), ("Values", values)])
        };
        let dataset = fields(&[("elements", Node::Items(vec![logged("u_piezo", &U), logged("y_disp", &Y)]))]);
        let series = |name: &str, samples: &[f64], unit: &str| {
            let info = fields(&[("Units", text(unit))]);
            fields(&[("Name", text(name)), ("Time", vector(&T)), ("Data", vector(samples)), ("DataInfo", info)])
        };
        let series = fields(&[("a", series("Command", &U, "V")), ("b", series("Stage", &Y, "um"))]);
        for content in [simulink, units, rates, iddata, dataset, series] {
            let record = table(vec![("data".into(), content.clone())]).record(&ColumnSelection::default());
            let record = record.unwrap_or_else(|error| panic!("{error}: {content:?}"));
            assert_eq!((record.ts(), record.u(), record.y()), (5e-4, &U[..], &Y[..]));
        }
    }

    #[test]
    fn two_runs_in_one_file_are_told_apart_by_their_groups() {
        let run = |y: &[f64]| fields(&[("t", vector(&T)), ("u", vector(&U)), ("y", vector(y))]);
        let table = table(vec![("run1".into(), run(&Y)), ("run2".into(), run(&U))]);
        let error = table.record(&ColumnSelection::default()).unwrap_err().to_string();
        assert!(error.contains("output_col") && error.contains("run1/y"), "{error}");
        let requested = ColumnSelection {
            input_col: Some("run2/u".into()),
            output_col: Some("run2/y".into()),
            ..ColumnSelection::default()
        };
        assert_eq!(table.record(&requested).unwrap().u(), U);
    }

    #[test]
    fn a_rate_is_that_of_the_nearest_group() {
        let run = |fs: f64| fields(&[("u", vector(&U)), ("y", vector(&Y)), ("fs", vector(&[fs]))]);
        let content = || vec![("slow".to_string(), run(100.0)), ("fast".to_string(), run(2000.0))];
        let of = |u: &str, y: &str| {
            let requested =
                ColumnSelection { input_col: Some(u.into()), output_col: Some(y.into()), ..ColumnSelection::default() };
            table(content()).record(&requested)
        };
        assert_eq!(of("slow/u", "slow/y").unwrap().ts(), 0.01);
        assert_eq!(of("fast/u", "fast/y").unwrap().ts(), 5e-4);
        let error = of("slow/u", "fast/y").unwrap_err().to_string();
        assert_eq!(error, "`slow/u` is sampled every 0.01 s, but `fast/y` every 0.0005 s: resample one of them");
        let two = fields(&[("u", vector(&U)), ("y", vector(&Y)), ("fs", vector(&[100.0])), ("Ts", vector(&[5e-4]))]);
        let error = table(vec![("run".into(), two)]).record(&ColumnSelection::default()).unwrap_err().to_string();
        assert!(error.contains("there is no time column"), "two rates: {error}");
    }

    #[test]
    fn structures_without_samples_are_left_out() {
        let runs = Node::Items(vec![fields(&[("u", vector(&U))]); 3]);
        assert_eq!(table(vec![("run".into(), runs)]).left, "run (structures, 1 x 3)");
    }
}
