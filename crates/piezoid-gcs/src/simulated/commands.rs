//! The commands that the simulated controller knows.

use super::waves::{POINTS, RECORDED, SOURCES, TABLES, WAVES};
use super::{CYCLE, Simulated};

/// Numbers of errors.
const SYNTAX: i32 = 1;
const UNKNOWN: i32 = 2;
pub(super) const TOO_LONG: i32 = 3;
const SERVO_IS_OFF: i32 = 5;
const POSITION: i32 = 7;
const STOPPED: i32 = 10;
const AXIS: i32 = 15;
const RANGE: i32 = 17;
const COUNT: i32 = 24;
const NUMBER: i32 = 25;
const PARAMETER: i32 = 54;
const RECORDER_TABLE: i32 = 57;
const RECORDER_OPTION: i32 = 58;
const PROTECTED: i32 = 60;
const VOLTAGE: i32 = 66;
const WAVE_TOO_LARGE: i32 = 67;
const GENERATOR_RUNS: i32 = 73;
const NO_WAVE: i32 = 75;
const TOO_FEW_POINTS: i32 = 77;
const SERVO_IS_ON: i32 = 79;

/// Servo cycles that a wave takes at most: ten minutes.
const LONGEST_WAVE: u64 = 12_000_000;

/// The parameters of `SPA?`: number, type and what it is.
const PARAMETERS: [(u32, &str, &str); 3] = [
    (0x0E00_0200, "FLOAT", "Servo Update Time"),
    (0x1600_0200, "INT", "Data Recorder Max Points"),
    (0x1600_0300, "INT", "Data Recorder Channel Number"),
];

/// What `HLP?` lists.
const HELP: &str = include_str!("help.txt");

type Outcome = Result<Vec<String>, i32>;

impl Simulated {
    /// The answer to a byte that is a command.
    pub(super) fn answer_byte(&mut self, byte: u8) -> &'static [u8] {
        self.waves.go_on(&mut self.axis);
        #[cfg(test)]
        self.log(&format!("#{byte}"));
        match byte {
            // Nothing moves, and no macro runs.
            5 | 8 => b"0\n",
            // Ready.
            7 => b"\xb1\n",
            9 if self.waves.running() => b"0x1\n",
            9 => b"0x0\n",
            _ => {
                self.waves.stop();
                self.error = STOPPED;
                b""
            }
        }
    }

    /// The lines of the answer to a command line: none for a command, and for what is refused.
    pub(super) fn answer(&mut self, line: &str) -> Vec<String> {
        let mut words = line.split_whitespace();
        let Some(name) = words.next() else { return Vec::new() };
        let arguments: Vec<&str> = words.collect();
        self.waves.go_on(&mut self.axis);
        #[cfg(test)]
        self.log(line);
        self.obey(&name.to_uppercase(), &arguments).unwrap_or_else(|error| {
            self.error = error;
            Vec::new()
        })
    }

    fn obey(&mut self, name: &str, arguments: &[&str]) -> Outcome {
        match name.strip_suffix('?') {
            Some("ERR") => Ok(vec![std::mem::take(&mut self.error).to_string()]),
            Some(name) => self.tell(name, arguments),
            None => self.act(name, arguments).map(|()| Vec::new()),
        }
    }

    fn tell(&mut self, name: &str, arguments: &[&str]) -> Outcome {
        let one = |text: String| Ok(vec![text]);
        let of_axis = |value: f64| of_one(arguments).map(|()| vec![format!("1={value:.6}")]);
        let flag = |on: bool| of_one(arguments).map(|()| vec![format!("1={}", u8::from(on))]);
        let (axis, waves) = (&self.axis, &self.waves);
        match name {
            "*IDN" => one(self.identity.clone()),
            "CSV" => one("2.0".into()),
            "VER" => one(format!("FW: V{}", env!("CARGO_PKG_VERSION"))),
            "HLP" => Ok(listed("The following commands are available:", HELP.lines().map(String::from).collect())),
            "HPA" => {
                let row = |(number, kind, what)| format!("0x{number:X}=\t0\t1\t{kind}\tsystem\t{what}");
                Ok(listed("#Available parameters", PARAMETERS.map(row).into()))
            }
            "HDR" => {
                let mut lines: Vec<String> = SOURCES.map(|(option, what)| format!("{option}={what}")).into();
                lines.extend(["#TriggerOptions", "0=default setting", "#Additional information"].map(String::from));
                lines.extend([format!("{TABLES} record tables"), format!("{RECORDED} datapoints per table")]);
                Ok(listed("#RecordOptions", lines))
            }
            "SAI" | "TWG" => one("1".into()),
            "SPA" => match arguments {
                ["1", number] => one(format!("1 {number}={}", parameter(number).ok_or(PARAMETER)?)),
                _ => Err(COUNT),
            },
            "POS" => of_axis(axis.position),
            "MOV" => of_axis(axis.target),
            "ONT" => flag((axis.target - axis.position).abs() < 0.01 * (axis.travel.1 - axis.travel.0)),
            "SVO" => flag(axis.servo),
            "SVA" => of_axis(axis.voltage / axis.gain),
            "VOL" => of_axis(axis.voltage),
            "VMI" => of_axis(axis.range.0),
            "VMA" => of_axis(axis.range.1),
            "TMN" => of_axis(axis.travel.0),
            "TMX" => of_axis(axis.travel.1),
            "PUN" => of_one(arguments).map(|()| vec!["1=um".into()]),
            "TNR" => one(TABLES.to_string()),
            "WMS" => one(format!("{}={POINTS}", arguments.first().unwrap_or(&"1"))),
            "RTR" => one(waves.record_rate.to_string()),
            "DRT" => one("0=0 0".into()),
            "DRC" => Ok((1..=TABLES).zip(waves.options).map(|(table, option)| format!("{table}=1 {option}")).collect()),
            "DRL" => {
                let tables = if arguments.is_empty() { (1..=TABLES).collect() } else { tables(arguments)? };
                Ok(tables.into_iter().map(|table| format!("{table}={}", waves.recorded(table).len())).collect())
            }
            "DRR" => self.recorded(arguments),
            "GWD" => match arguments {
                [first, count, table] => {
                    let table = waves.tables.get(&whole(table)?).ok_or(NO_WAVE)?;
                    let points = part(table, first, count)?;
                    Ok(array(&[(format!("Wave Table {}", arguments[2]), points)], CYCLE * waves.rate as f64))
                }
                _ => Err(COUNT),
            },
            _ => Err(UNKNOWN),
        }
    }

    fn act(&mut self, name: &str, arguments: &[&str]) -> Result<(), i32> {
        let (axis, waves) = (&mut self.axis, &mut self.waves);
        match (name, arguments) {
            ("STP" | "HLT", _) => {
                waves.stop();
                return Err(STOPPED);
            }
            ("SVO", ["1", on]) => axis.close(whole(on)? != 0),
            ("SVA", ["1", value]) => {
                let (value, (low, high)) = (real(value)?, axis.range);
                refused(&[(axis.servo, SERVO_IS_ON), (waves.running(), GENERATOR_RUNS)])?;
                refused(&[(!(low..=high).contains(&(value * axis.gain)), VOLTAGE)])?;
                axis.go(value);
            }
            ("MOV" | "MVR", ["1", value]) => {
                let target = real(value)? + if name == "MVR" { axis.target } else { 0.0 };
                let (bottom, top) = axis.travel;
                refused(&[(!axis.servo, SERVO_IS_OFF), (waves.running(), GENERATOR_RUNS)])?;
                refused(&[(!(bottom..=top).contains(&target), POSITION)])?;
                axis.go(target);
            }
            ("DRC", [table, source, option]) => {
                let (table, option) = (tables(&[table])?[0], whole(option)? as u32);
                refused(&[(*source != "1", AXIS), (SOURCES.iter().all(|(o, _)| *o != option), RECORDER_OPTION)])?;
                waves.options[table - 1] = option;
            }
            ("SPA", [_, _, _]) => return Err(PROTECTED),
            // Every wave is recorded; there is no other trigger.
            ("DRT", [_, ..]) => {}
            ("RTR", [rate]) => waves.record_rate = positive(rate)?,
            ("WAV", [table, mode, shape, numbers @ ..]) => {
                refused(&[(waves.running(), GENERATOR_RUNS)])?;
                let segment = segment(shape, numbers)?;
                let table = whole(table)?;
                refused(&[(!(1..=WAVES).contains(&table), RANGE)])?;
                let points = waves.tables.entry(table).or_default();
                match *mode {
                    "X" => points.clear(),
                    "&" => (),
                    _ => return Err(SYNTAX),
                }
                refused(&[(points.len() + segment.len() > POINTS, WAVE_TOO_LARGE)])?;
                points.extend(segment);
            }
            ("WCL", arguments) => {
                for table in arguments {
                    waves.tables.remove(&whole(table)?);
                }
            }
            ("WSL", ["1", table]) => waves.selected = whole(table)?,
            ("WGC", ["1", times]) => waves.times = whole(times)? as u64,
            ("WTR", ["0" | "1", rate, _]) => waves.rate = positive(rate)?,
            ("WOS", ["1", offset]) => waves.offset = real(offset)?,
            ("WGO", ["1", mode]) if whole(mode)? == 0 => waves.stop(),
            ("WGO", ["1", _]) => {
                refused(&[(waves.running(), GENERATOR_RUNS), (waves.cycles().is_none(), NO_WAVE)])?;
                refused(&[(waves.cycles().is_some_and(|cycles| cycles > LONGEST_WAVE), RANGE)])?;
                waves.start();
            }
            ("SVO" | "SVA" | "MOV" | "MVR" | "WSL" | "WGC" | "WOS" | "WGO", [_, _]) => return Err(AXIS),
            _ if HELP.lines().any(|row| row.split(' ').next() == Some(name)) => return Err(COUNT),
            _ => return Err(UNKNOWN),
        }
        Ok(())
    }

    /// Tables of the recorder: first point, number of points, tables.
    fn recorded(&self, arguments: &[&str]) -> Outcome {
        let [first, count, tabled @ ..] = arguments else { return Err(COUNT) };
        let tables = if tabled.is_empty() { (1..=TABLES).collect() } else { tables(tabled)? };
        let column = |table: usize| {
            let option = self.waves.options[table - 1];
            let what = SOURCES.iter().find(|(number, _)| *number == option).map_or("", |(_, what)| what);
            Ok((format!("{what} 1"), part(self.waves.recorded(table), first, count)?))
        };
        let columns = tables.into_iter().map(column).collect::<Result<Vec<_>, i32>>()?;
        Ok(array(&columns, CYCLE * self.waves.record_rate as f64))
    }
}

fn listed(head: &str, lines: Vec<String>) -> Vec<String> {
    [vec![head.into()], lines, vec!["end of help".into()]].concat()
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
    let row = |t: usize| columns.iter().map(|(_, points)| format!("{:.6}", points[t])).collect::<Vec<_>>().join(" ");
    head.into_iter().chain(names).chain(["# END_HEADER".into()]).chain((0..rows).map(row)).collect()
}

fn part<'a>(points: &'a [f64], first: &str, count: &str) -> Result<&'a [f64], i32> {
    let (first, count) = (whole(first)?, whole(count)?);
    let from = first.checked_sub(1).ok_or(RANGE)?;
    let to = from.checked_add(count).ok_or(RANGE)?;
    points.get(from..to).ok_or(TOO_FEW_POINTS)
}

fn parameter(number: &str) -> Option<String> {
    let hex = number.strip_prefix("0x").or_else(|| number.strip_prefix("0X"));
    let number = hex.map_or_else(|| number.parse(), |hex| u32::from_str_radix(hex, 16)).ok()?;
    match PARAMETERS.iter().position(|(known, ..)| *known == number)? {
        0 => Some(CYCLE.to_string()),
        1 => Some((RECORDED * TABLES).to_string()),
        _ => Some(TABLES.to_string()),
    }
}

/// The points of a segment of a wave.
fn segment(shape: &str, arguments: &[&str]) -> Result<Vec<f64>, i32> {
    let numbers: Vec<f64> = arguments.iter().map(|word| real(word)).collect::<Result<_, _>>()?;
    match (shape, &numbers[..]) {
        ("PNT", [_, count, points @ ..]) if *count == points.len() as f64 => Ok(points.to_vec()),
        // Length of the segment, height, offset, length of the period, first point of the period, point of the maximum.
        ("SIN_P", [_, height, offset, _, start, centre]) => {
            let (length, period) = (positive(arguments[0])?, positive(arguments[3])? as f64);
            refused(&[(length as usize > POINTS, WAVE_TOO_LARGE), (*centre < 1.0 || *centre >= period, RANGE)])?;
            let share = |t: f64| match t {
                _ if !(0.0..period).contains(&t) => 0.0,
                _ if t < *centre => 0.5 * t / centre,
                _ => 0.5 + 0.5 * (t - centre) / (period - centre),
            };
            let point = |t: f64| offset + 0.5 * height * (1.0 - (std::f64::consts::TAU * share(t)).cos());
            Ok((0..length).map(|k| point(k as f64 - start)).collect())
        }
        ("PNT" | "SIN_P", _) => Err(COUNT),
        _ => Err(SYNTAX),
    }
}

/// Tables of the recorder by their numbers.
fn tables(arguments: &[&str]) -> Result<Vec<usize>, i32> {
    let table = |word: &&str| whole(word).ok().filter(|table| (1..=TABLES).contains(table)).ok_or(RECORDER_TABLE);
    arguments.iter().map(table).collect()
}

/// A query names the only axis, or none.
fn of_one(arguments: &[&str]) -> Result<(), i32> {
    match arguments {
        [] | ["1"] => Ok(()),
        _ => Err(AXIS),
    }
}

/// The first error of which the condition holds.
fn refused(checks: &[(bool, i32)]) -> Result<(), i32> {
    checks.iter().find(|(refused, _)| *refused).map_or(Ok(()), |(_, error)| Err(*error))
}

fn real(word: &str) -> Result<f64, i32> {
    word.parse().ok().filter(|x: &f64| x.is_finite()).ok_or(NUMBER)
}

fn whole(word: &str) -> Result<usize, i32> {
    word.parse().map_err(|_| NUMBER)
}

fn positive(word: &str) -> Result<u64, i32> {
    word.parse().ok().filter(|n| *n > 0).ok_or(RANGE)
}
