//! Queries: what they answer is the state of the moment.

use super::errors::{AWAITED, CHANNEL, COUNT, NO_WAVE, RANGE, TOO_FEW_POINTS, UNKNOWN, refused};
use super::generators::{Generator, POINTS, WAVES};
use super::recorder::{RECORDED, SOURCES, TABLES, TRIGGERS, part, source, tables};
use super::waves::wave_table;
use super::words::{once, whole};
use super::{CYCLE, Device};
use crate::simulated::axis::Axis;

/// Points of an answer about wave tables: two whole tables.
const LARGEST: usize = 2 * POINTS;

type Outcome = Result<Vec<String>, i32>;

impl Device {
    pub(super) fn tell(&self, name: &str, arguments: &[&str]) -> Outcome {
        let one = |text: String| Ok(vec![text]);
        let number = |value: fn(&Axis) -> f64| self.each_axis(arguments, |axis| format!("{:.6}", value(axis)));
        let flag = |value: fn(&Axis) -> bool| self.each_axis(arguments, |axis| u8::from(value(axis)).to_string());
        let volts = |value: fn(&Axis) -> f64| {
            let line = |k: usize| format!("{}={:.6}", k + 1, value(&self.axes[k]));
            Ok(self.channels(arguments)?.into_iter().map(line).collect())
        };
        match name {
            "*IDN" | "IDN" => one(self.identity.clone()),
            "CSV" => one("2.0".into()),
            "VER" => one(format!("FW: V{}", env!("CARGO_PKG_VERSION"))),
            "CCL" => one(self.level.to_string()),
            "HLP" => Ok(listed("The following commands are available:", self.model.help().map(String::from).collect())),
            "HPA" => Ok(listed("#Available parameters", self.parameter_list())),
            "HDR" => Ok(listed("#RecordOptions", recorded_options())),
            "SAI" => Ok(self.axes.iter().map(|axis| axis.name.clone()).collect()),
            "TWG" | "TPC" => one(self.axes.len().to_string()),
            "SPA" => self.parameters(arguments, false),
            "SEP" => self.parameters(arguments, true),
            "IFC" => interface(arguments),
            "POS" => number(|axis| axis.position),
            "MOV" => number(|axis| if axis.servo { axis.goal } else { axis.target }),
            "SVA" => number(|axis| axis.demand() / axis.gain),
            "VEL" => number(|axis| axis.velocity),
            "TMN" => number(|axis| axis.travel.0),
            "TMX" => number(|axis| axis.travel.1),
            "AOS" => number(|_| 0.0),
            "TSP" => self.each_input(arguments, |axis| format!("{:.6}", axis.map_or(0.0, |axis| axis.position))),
            // The code of a converter of 20 bits over the travel.
            "TAD" => self.each_input(arguments, |axis| {
                let share = |axis: &Axis| (axis.position - axis.travel.0) / (axis.travel.1 - axis.travel.0);
                ((axis.map_or(0.0, share) * f64::from(1 << 19)) as i64).to_string()
            }),
            "ONT" => flag(Axis::is_on_target),
            "SVO" => flag(|axis| axis.servo),
            "OVF" => flag(Axis::is_overflowing),
            "ATZ" => flag(|axis| axis.is_zeroed),
            "PUN" => self.each_axis(arguments, |_| "um".into()),
            "CST" => self.each_axis(arguments, |_| self.plant.clone()),
            "VOL" => volts(|axis| axis.voltage),
            "VMI" => volts(|axis| axis.range.0),
            "VMA" => volts(|axis| axis.range.1),
            "TNR" => one(TABLES.to_string()),
            "RTR" => one(self.recorder.rate.to_string()),
            "DRC" => self.each_table(arguments, |table| {
                let table = &self.recorder.tables[table - 1];
                format!("{} {}", self.axes[table.source].name, table.option)
            }),
            "DRT" => self.each_table(arguments, |table| format!("{} 0", self.recorder.tables[table - 1].trigger)),
            "DRL" => self.each_table(arguments, |table| self.recorder.tables[table - 1].points.len().to_string()),
            "DRR" => self.recorded(arguments),
            "WMS" => waves_of(arguments, |_| POINTS),
            "WAV" => self.wave_lengths(arguments),
            "GWD" => self.wave_points(arguments),
            "WSL" => self.each_generator(arguments, |one| one.table.to_string()),
            "WGC" => self.each_generator(arguments, |one| one.times.to_string()),
            "WGO" => self.each_generator(arguments, |one| u8::from(one.is_running()).to_string()),
            "WTR" => self.each_generator(arguments, |one| format!("{} {}", one.rate, u8::from(one.is_linear))),
            "WOS" => self.each_generator(arguments, |one| format!("{:.6}", one.offset)),
            _ => Err(UNKNOWN),
        }
    }

    fn each_axis(&self, names: &[&str], text: impl Fn(&Axis) -> String) -> Outcome {
        let line = |k: usize| format!("{}={}", self.axes[k].name, text(&self.axes[k]));
        Ok(self.axes_of(names)?.into_iter().map(line).collect())
    }

    /// Inputs: the sensors of the axes, then two analogue ones at 0.
    fn each_input(&self, numbers: &[&str], text: impl Fn(Option<&Axis>) -> String) -> Outcome {
        let last = self.axes.len() + 2;
        let input = |word: &&str| whole(word).and_then(|k| if (1..=last).contains(&k) { Ok(k) } else { Err(CHANNEL) });
        let these = numbers.iter().map(input).collect::<Result<Vec<_>, i32>>()?;
        let these = if these.is_empty() { (1..=last).collect() } else { these };
        Ok(these.into_iter().map(|k| format!("{k}={}", text(self.axes.get(k - 1)))).collect())
    }

    fn each_generator(&self, numbers: &[&str], text: impl Fn(&Generator) -> String) -> Outcome {
        let line = |k: usize| format!("{}={}", k + 1, text(&self.generators[k]));
        Ok(self.channels(numbers)?.into_iter().map(line).collect())
    }

    fn each_table(&self, numbers: &[&str], text: impl Fn(usize) -> String) -> Outcome {
        Ok(tables(numbers)?.into_iter().map(|table| format!("{table}={}", text(table))).collect())
    }

    /// Tables of the recorder: first point, number of points, tables. Without arguments, all that is recorded.
    fn recorded(&self, arguments: &[&str]) -> Outcome {
        let all;
        let (first, count, numbers) = match arguments {
            [] => {
                let least = self.recorder.tables.iter().map(|table| table.points.len()).min();
                all = least.filter(|least| *least > 0).ok_or(TOO_FEW_POINTS)?.to_string();
                ("1", &*all, &[][..])
            }
            [first, count, numbers @ ..] => (*first, *count, numbers),
            [_] => return Err(COUNT),
        };
        let last = whole(first)?.saturating_add(whole(count)?).saturating_sub(1);
        let column = |table: usize| {
            let table = &self.recorder.tables[table - 1];
            let name = format!("{} {}", source(table.option).unwrap_or_default(), self.axes[table.source].name);
            let points = part(&table.points, first, count);
            let is_awaited = points == Err(TOO_FEW_POINTS) && table.records() && last <= RECORDED;
            Ok((name, if is_awaited { Err(AWAITED) } else { points }?))
        };
        let columns = tables(numbers)?.into_iter().map(column).collect::<Result<Vec<_>, i32>>()?;
        Ok(array(&columns, CYCLE * self.recorder.rate as f64))
    }

    /// The lengths of wave tables, which are parameter 1 of each.
    fn wave_lengths(&self, arguments: &[&str]) -> Outcome {
        let line = |table: usize| format!("{table} 1={}", self.tables.get(&table).map_or(0, Vec::len));
        if arguments.is_empty() {
            return Ok((1..=WAVES).map(line).collect());
        }
        refused(&[
            (arguments.len() % 2 == 1, COUNT),
            (arguments.iter().skip(1).step_by(2).any(|one| *one != "1"), RANGE),
        ])?;
        arguments.iter().step_by(2).map(|table| Ok(line(wave_table(table)?))).collect()
    }

    /// Points of wave tables: first point, number of points, tables.
    fn wave_points(&self, arguments: &[&str]) -> Outcome {
        let [first, count, numbers @ ..] = arguments else { return Err(COUNT) };
        let tables = once(numbers.iter().map(|word| wave_table(word)).collect::<Result<_, _>>()?)?;
        refused(&[(tables.is_empty(), COUNT), (tables.len().saturating_mul(whole(count)?) > LARGEST, RANGE)])?;
        let column = |table: &usize| {
            let points = self.tables.get(table).ok_or(NO_WAVE)?;
            Ok((format!("Wave Table {table}"), part(points, first, count)?))
        };
        Ok(array(&tables.iter().map(column).collect::<Result<Vec<_>, i32>>()?, CYCLE))
    }
}

/// What a wave table has.
fn waves_of(numbers: &[&str], value: impl Fn(usize) -> usize) -> Outcome {
    let these = numbers.iter().map(|word| wave_table(word)).collect::<Result<Vec<_>, i32>>()?;
    let these = if these.is_empty() { (1..=WAVES).collect() } else { these };
    Ok(these.into_iter().map(|table| format!("{table}={}", value(table))).collect())
}

/// The parameters of the interface, or those of these names.
fn interface(names: &[&str]) -> Outcome {
    let all = ["RSBAUD=115200", "IPADR=127.0.0.1", "IPSTART=0", "IPMASK=255.0.0.0", "MACADR=00:00:00:00:00:00"];
    let of = |name: &&str| all.iter().find(|row| row.split('=').next() == Some(*name)).ok_or(RANGE);
    let rows = names.iter().map(of).collect::<Result<Vec<_>, i32>>()?;
    Ok(if rows.is_empty() { all.map(String::from).into() } else { rows.into_iter().map(ToString::to_string).collect() })
}

fn listed(head: &str, lines: Vec<String>) -> Vec<String> {
    [vec![head.into()], lines, vec!["end of help".into()]].concat()
}

fn recorded_options() -> Vec<String> {
    let row = |(number, what): (u32, &str)| format!("{number}={what}");
    let heads = ["#TriggerOptions", "#Additional information"].map(String::from);
    let [triggers, more] = heads;
    let sizes = [format!("{TABLES} record tables"), format!("{RECORDED} datapoints per table")];
    [SOURCES.map(row).to_vec(), vec![triggers], TRIGGERS.map(row).to_vec(), vec![more], sizes.to_vec()].concat()
}

/// A GCS array.
fn array(columns: &[(String, &[f64])], ts: f64) -> Vec<String> {
    let rows = columns.first().map_or(0, |(_, points)| points.len());
    let head = [
        "# REM simulated by piezoid".into(),
        "# VERSION = 1".into(),
        "# TYPE = 1".into(),
        "# SEPARATOR = 32".into(),
        format!("# DIM = {}", columns.len()),
        format!("# SAMPLE_TIME = {ts}"),
        format!("# NDATA = {rows}"),
    ];
    let names = columns.iter().enumerate().map(|(k, (name, _))| format!("# NAME{k} = {name}"));
    let mut lines: Vec<String> = head.into_iter().chain(names).collect();
    // In one piece, because there can be many rows.
    let row = |t: usize| columns.iter().map(|(_, points)| format!("{:.6}", points[t])).collect::<Vec<_>>().join(" ");
    let body = (0..rows).fold("# END_HEADER".into(), |body: String, t| body + " \n" + &row(t));
    lines.push(body);
    lines
}
