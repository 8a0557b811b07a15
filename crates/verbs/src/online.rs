//! Recursive identification along a record or a stream: rows of the parameters that move, and the model at the end.

use super::{DataFile, File, Origin, blamed, short};
use piezoid_identification::online::{GAIN_RANGE, MAX_FACTOR, Moves, Online, OnlineParameters, OnlineSettings};
use piezoid_models::hammerstein::Model;
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short as rounded;
use piezoid_numerics::options::{OptionKind, OptionRow, Options, options};
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_numerics::system::System;
use piezoid_records::formats::ColumnSelection;
use piezoid_records::record::Record;
use serde::Serialize;
use serde_json::{Value, json};

options! {
    /// How the parameters move.
    pub struct EstimatorOptions {
        /// What moves: a list of gain, offset, weights and linear, or auto for all that the model allows.
        moves: String = "auto".into(), OptionRow::new(OptionKind::Text("LIST")).group(ESTIMATOR);
        /// Memory of the gain; the offset has ten times as much.
        gain_memory: f64 = 50.0, OptionRow::positive("samples").group(ESTIMATOR);
        /// Memory of weights and linear block.
        memory: f64 = 5000.0, OptionRow::positive("samples").group(ESTIMATOR);
        /// Number of groups in which the weights of the hysteresis move.
        groups: usize = 4, OptionRow::new(OptionKind::Integer(2, 4)).group(ESTIMATOR);
        /// Rms of the alternating response, relative to half the stroke, below which only the offset moves.
        excitation: f64 = 1.0, OptionRow { unit: "%", ..OptionRow::new(BELOW_ALL) }.group(ESTIMATOR);
        /// Errors up to this, in the unit of the output, move nothing.
        dead_zone: f64 = 0.0, OptionRow::not_negative("").group(ESTIMATOR);
    }
}

options! {
    /// Options of `online`.
    pub struct OnlineOptions {
        /// State of the actuator before the first sample: at rest, or settled at the first input.
        begin: String = "settled".into(), OptionRow::new(OptionKind::Choice(&[
            ("rest", "At rest, with a jump to the first input"),
            ("settled", "Settled at the first input"),
        ]));
        /// Time between two rows of parameters.
        every: Option<f64> = None, OptionRow::positive("s").absent("a twentieth of a record, 1 s of a stream");
    } with estimator: EstimatorOptions
}

const ESTIMATOR: &str = "Estimator";

const BELOW_ALL: OptionKind = OptionKind::Number { least: 0.0, open: false, below: 100.0 };

/// Rows of a record, unless the time between them is given.
const ROWS: f64 = 20.0;

/// The command in the files of models.
const COMMAND: &str = "piezoid online";

/// Samples between two reports of progress.
const PIECE: usize = 4096;

/// Largest relative difference of the step of the times in a stream to the sampling period.
const MAX_STEP_ERROR: f64 = 0.01;

impl EstimatorOptions {
    /// The same for the library.
    ///
    /// # Errors
    /// [`Error::Unknown`] for an unknown name in `moves`.
    pub fn settings(&self) -> Result<OnlineSettings, Error> {
        Ok(OnlineSettings {
            moves: Moves::of(&self.moves)?,
            gain_memory: self.gain_memory,
            memory: self.memory,
            groups: self.groups,
            excitation: self.excitation / 100.0,
            dead_zone: self.dead_zone,
        })
    }
}

/// The parameters at one time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OnlineRow {
    /// Time since the first sample [s].
    pub t: f64,
    /// Rms of the errors since the last row [output unit]; `None` without readings.
    pub error_rms: Option<f64>,
    /// Frequency of the first mode [Hz] and its damping ratio; `None` without a mode.
    pub mode: Option<(f64, f64)>,
    /// The parameters.
    #[serde(flatten)]
    pub parameters: OnlineParameters,
}

/// A recursive identification that goes on from sample to sample. Its size does not depend on their number.
#[derive(Debug, Clone)]
pub struct OnlineRun {
    online: Online,
    model: Model,
    options: OnlineOptions,
    state: Option<Vec<f64>>,
    samples: usize,
    between: usize,
    squares: f64,
    readings: usize,
}

/// The result of a replay.
#[derive(Debug, Clone, PartialEq)]
pub struct Replayed {
    /// The rows of parameters.
    pub rows: Vec<OnlineRow>,
    /// The model with the last parameters.
    pub model: Model,
    /// What does not move, and why.
    pub remarks: Vec<String>,
}

impl OnlineOptions {
    /// A run that starts at the model in a file.
    ///
    /// # Errors
    /// The errors of [`Online::new`].
    pub fn start(&self, file: &File) -> Result<OnlineRun, Error> {
        self.start_at(file.model()?).map_err(|error| blamed(error, file))
    }

    /// A run that starts at this model.
    ///
    /// # Errors
    /// The errors of [`Online::new`].
    pub fn start_at(&self, model: Model) -> Result<OnlineRun, Error> {
        let online = Online::new(&model, &self.estimator.settings()?)?;
        let between = samples(self.every.unwrap_or(1.0), model.ts());
        let options = self.clone();
        Ok(OnlineRun { online, model, options, state: None, samples: 0, between, squares: 0.0, readings: 0 })
    }

    /// Replays a record; `take` gets each row as it comes. A cancelled replay ends where it is.
    ///
    /// # Errors
    /// The errors of [`OnlineOptions::start`]; errors for a file without a record, with another sampling period or in
    /// units that cannot be converted.
    pub fn replay(
        &self,
        file: &File,
        data: &DataFile,
        columns: &ColumnSelection,
        take: &mut dyn FnMut(&OnlineRow) -> Result<(), Error>,
        progress: &mut Progress,
    ) -> Result<Replayed, Error> {
        let mut run = self.start(file)?;
        let record = data.record(columns)?;
        let rows = run.follow(&record, take, progress).map_err(|error| error.about(&data.name))?;
        let (file, sha256, columns) = (short(&data.name).into(), data.sha256()?, columns.clone());
        let source = json!(Origin { file, sha256, columns, preparation: Vec::new() });
        Ok(Replayed { rows, model: run.finished(source)?, remarks: run.remarks() })
    }
}

impl OnlineRun {
    /// Follows a record from here on; `take` gets each row as it comes. A cancelled run ends where it is.
    ///
    /// # Errors
    /// Errors for another sampling period and for units that cannot be converted; those of `take`.
    pub fn follow(
        &mut self,
        record: &Record,
        take: &mut dyn FnMut(&OnlineRow) -> Result<(), Error>,
        progress: &mut Progress,
    ) -> Result<Vec<OnlineRow>, Error> {
        Record::same_sampling("the model", self.model.ts(), "the record", record.ts())?;
        let units = self.model.units();
        if record.units().u != units.u {
            let rule = format!("must be that of the model, {}: convert it with input_unit or input_scale", units.u);
            return Err(Error::parameter("unit of the input", &record.units().u, rule));
        }
        let record = record.output_in(&units.y)?;
        if self.options.every.is_none() {
            self.between = samples(record.duration() / ROWS, record.ts());
        }
        let (n, mut rows) = (record.len(), Vec::new());
        for (t, (u, y)) in record.u().iter().zip(record.y()).enumerate() {
            if t % PIECE == 0 && progress(Stage::new("recursive identification", t, n)).is_break() {
                break;
            }
            if let Some(row) = self.step(*u, *y) {
                take(&row)?;
                rows.push(row);
            }
        }
        Ok(rows)
    }

    /// One sample. Returns the parameters whenever a row is due. A reading that is no number is skipped.
    pub fn step(&mut self, u: f64, y: f64) -> Option<OnlineRow> {
        let online = &self.online;
        let is_settled = self.options.begin == "settled" && u.is_finite();
        let begin = || if is_settled { online.settled(u) } else { online.initial() };
        let x = self.state.get_or_insert_with(begin);
        let e = y - online.step(x, u, y);
        if e.is_finite() {
            self.squares += e * e;
            self.readings += 1;
        }
        self.samples += 1;
        if !self.samples.is_multiple_of(self.between) {
            return None;
        }
        let row = self.row();
        (self.squares, self.readings) = (0.0, 0);
        Some(row)
    }

    /// The parameters now.
    pub fn row(&self) -> OnlineRow {
        let parameters = self.parameters();
        let rms = (self.squares / self.readings.max(1) as f64).sqrt();
        let mode = || {
            let block = Arx::new(self.model.ts(), parameters.a.clone(), parameters.b.clone()).ok()?;
            let mode = block.modal_form().modes().first().copied()?;
            Some((mode.pole.hz, mode.pole.damping))
        };
        OnlineRow {
            t: self.samples.saturating_sub(1) as f64 * self.model.ts(),
            error_rms: (self.readings > 0).then_some(rms),
            mode: mode(),
            parameters,
        }
    }

    fn parameters(&self) -> OnlineParameters {
        self.online.parameters(self.state.as_ref().unwrap_or(&self.online.initial()))
    }

    /// The model with the parameters as they are. Its provenance states the identification that it started from, how
    /// many runs were between, the options and `source`, where the samples come from.
    ///
    /// # Errors
    /// The errors of [`Online::model`].
    pub fn finished(&self, source: Value) -> Result<Model, Error> {
        let model = self.online.model(self.state.as_ref().unwrap_or(&self.online.initial()))?;
        // Of a chain of runs, the identification stays: a file that holds all of them grows without end.
        let before = self.model.provenance();
        let (runs, start) = match before["command"] == COMMAND {
            true => (before["runs_before"].as_u64().unwrap_or_default() + 1, &before["start"]),
            false => (0, before),
        };
        Ok(model.with_provenance(json!({
            "command": COMMAND,
            "version": env!("CARGO_PKG_VERSION"),
            "options": self.options.to_json(),
            "samples": self.samples,
            "source": source,
            "runs_before": runs,
            "start": start,
        })))
    }

    /// What does not move, and why, and what is at an end of its range, one sentence each.
    pub fn remarks(&self) -> Vec<String> {
        let OnlineParameters { gain, factors, .. } = self.parameters();
        let (low, high) = GAIN_RANGE;
        let ends = [low, high].into_iter().filter(|end| *end == gain).map(|end| {
            format!(
                "the gain is at the end of its range, {end} times that of the start: sign, unit or role of a column may \
                 be wrong, or the model that of another actuator"
            )
        });
        let is_end = |factor: &&f64| **factor <= 0.0 || **factor >= MAX_FACTOR;
        let stuck = factors.iter().filter(is_end).count();
        let stuck = (stuck > 0).then(|| {
            format!("factors of weights at an end of their range, 0 to {MAX_FACTOR}: {stuck}; identify the model again")
        });
        self.online.remarks().iter().cloned().chain(ends).chain(stuck).collect()
    }

    /// Number of samples so far.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Unit of the output.
    pub fn unit(&self) -> &str {
        &self.model.units().y
    }

    /// One line of a stream: `u,y` or `t,u,y` in the units of the model, separated by commas, semicolons, tabs or
    /// blanks. `None` for an empty line, a comment (`#`), and the names of columns in the first line. An empty `y`, or
    /// `nan`, is a missing reading. `last` is the time in the line before.
    ///
    /// # Errors
    /// Returns an error for another number of columns, for what is no number, and for times that are not one sampling
    /// period apart.
    pub fn line(&self, text: &str, last: &mut Option<f64>) -> Result<Option<(f64, f64)>, Error> {
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') {
            return Ok(None);
        }
        let separator = [',', ';', '\t'].into_iter().find(|c| text.contains(*c));
        let fields: Vec<&str> = match separator {
            Some(separator) => text.split(separator).map(str::trim).collect(),
            None => text.split_whitespace().collect(),
        };
        let number = |text: &str| if text.is_empty() { Some(f64::NAN) } else { text.parse::<f64>().ok() };
        let numbers: Option<Vec<f64>> = fields.iter().map(|field| number(field)).collect();
        let Some(numbers) = numbers else {
            let is_head = self.samples == 0 && fields.iter().all(|field| number(field).is_none());
            let why = format!("`{text}` is no sample: write u,y or t,u,y in numbers, with a decimal point");
            return if is_head { Ok(None) } else { Err(Error::Content(why)) };
        };
        let (u, y) = match numbers[..] {
            [u, y] => (u, y),
            [t, u, y] => {
                let ts = self.model.ts();
                let is_period = |step: f64| (step - ts).abs() <= MAX_STEP_ERROR * ts;
                if let Some(step) = last.map(|last| t - last).filter(|step| !is_period(*step)) {
                    let why = format!(
                        "the time {t} s comes {} s after the last one, and the sampling period of the model is {ts} s: \
                         resample the stream, write missing readings as empty fields, or leave the times out",
                        rounded(step)
                    );
                    return Err(Error::Content(why));
                }
                *last = Some(t);
                (u, y)
            }
            _ => {
                let why = format!("`{text}` has {} columns: write u,y or t,u,y", numbers.len());
                return Err(Error::Content(why));
            }
        };
        Ok(Some((u, y)))
    }
}

/// The number of samples in a time, at least one.
fn samples(seconds: f64, ts: f64) -> usize {
    (seconds / ts).round().clamp(1.0, 1e15) as usize
}

impl Replayed {
    /// The rows and remarks as a document.
    pub fn to_json(&self) -> Value {
        json!({"rows": self.rows, "remarks": self.remarks, "ts": self.model.ts(), "units": self.model.units()})
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hammerstein::Domain;
    use piezoid_models::hysteresis::Operator;
    use std::ops::ControlFlow;

    const TS: f64 = 1e-3;

    fn model() -> Model {
        let plays = (Operator::find("prandtl-ishlinskii").unwrap().example)(TS).unwrap();
        let block = Arx::new(TS, vec![1.2, -0.7], vec![0.0, 0.5]).unwrap();
        Model::new(plays, block, 1.0).unwrap().with_identified(Domain::of_input(&[-30.0, 30.0], TS))
    }

    fn file() -> File {
        File::new("m.json", model().to_json())
    }

    /// A record of this gain, as a text.
    fn record(gain: f64, samples: usize) -> String {
        let u: Vec<f64> = (0..samples).map(|t| 25.0 * (0.2 * t as f64).sin()).collect();
        let rows = u.iter().zip(model().simulate(&u)).enumerate();
        let rows = rows.map(|(t, (u, y))| format!("{},{u},{}\n", TS * t as f64, gain * (y - 1.0) + 1.0));
        format!("t_s,u_V,y_um\n{}", rows.collect::<String>())
    }

    #[test]
    fn a_replay_and_a_stream_of_the_same_lines_give_the_same_model() {
        let (options, text) = (OnlineOptions { begin: "rest".into(), ..OnlineOptions::default() }, record(1.1, 3000));
        let data: DataFile = File::new("lab/d.csv", text.clone()).into();
        let columns = ColumnSelection::default();
        let replayed = options.replay(&file(), &data, &columns, &mut |_| Ok(()), &mut Stage::ignore).unwrap();
        assert_eq!(replayed.rows.len(), 20);
        let last = &replayed.rows[19];
        assert!((last.parameters.gain - 1.1).abs() < 0.005 && last.mode.is_some(), "{last:?}");
        let (mut run, mut time) = (options.start(&file()).unwrap(), None);
        for line in text.lines() {
            if let Some((u, y)) = run.line(line, &mut time).unwrap() {
                run.step(u, y);
            }
        }
        assert_eq!(run.finished(Value::Null).unwrap(), replayed.model);
        let fit = replayed.model.provenance();
        assert_eq!((&fit["source"]["file"], &fit["samples"]), (&json!("d.csv"), &json!(3000)));
        assert_eq!(fit["options"], json!({"begin": "rest"}));
    }

    #[test]
    fn a_cancelled_replay_has_the_model_up_to_there() {
        let data: DataFile = File::new("d.csv", record(1.0, 10_000)).into();
        let mut progress =
            |stage: Stage| if stage.done > 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let options = OnlineOptions::default();
        let replayed =
            options.replay(&file(), &data, &ColumnSelection::default(), &mut |_| Ok(()), &mut progress).unwrap();
        assert_eq!(replayed.model.provenance()["samples"], json!(PIECE));
    }

    #[test]
    fn lines_that_are_no_samples_are_named() {
        let run = OnlineOptions::default().start(&file()).unwrap();
        let read = |text: &str| run.line(text, &mut Some(0.5)).map_err(|e| e.to_string());
        for nothing in ["", "  ", "# a comment", "t_s,u_V,y_um"] {
            assert_eq!(read(nothing), Ok(None), "{nothing}");
        }
        assert_eq!(read("0.501; 1; -2"), Ok(Some((1.0, -2.0))));
        assert_eq!(read("1 2"), Ok(Some((1.0, 2.0))));
        assert!(read("1,").unwrap().unwrap().1.is_nan());
        for (text, why) in [
            ("1,2,3,4", "`1,2,3,4` has 4 columns: write u,y or t,u,y"),
            ("1,x", "`1,x` is no sample"),
            ("0.6,1,2", "the time 0.6 s comes 0.1"),
            ("nan,1,2", "the time NaN s comes"),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.starts_with(why), "{message}");
        }
    }

    #[test]
    fn what_cannot_move_is_refused_by_name_and_left_out_of_auto() {
        let estimator = |moves: &str| EstimatorOptions { moves: moves.into(), ..EstimatorOptions::default() };
        let start = |file: &File, moves: &str| {
            let options = OnlineOptions { estimator: estimator(moves), ..OnlineOptions::default() };
            options.start(file).map(|run| run.remarks()).map_err(|error| error.to_string())
        };
        let preisach = (Operator::find("preisach").unwrap().example)(TS).unwrap();
        let model = Model::new(preisach, Arx::gain(TS, 2.0).unwrap(), 0.0).unwrap();
        let other = File::new("p.json", model.with_identified(Domain::of_input(&[-30.0, 30.0], TS)).to_json());
        let message = start(&other, "gain,weights").unwrap_err();
        assert!(message.starts_with("p.json") && message.contains("preisach"), "{message}");
        assert!(start(&other, "linear").unwrap_err().contains("it is a gain"));
        assert_eq!(start(&other, "auto").unwrap().len(), 2);
        assert!(start(&file(), "gain,slope").unwrap_err().contains("slope"));
        assert_eq!(start(&file(), "auto"), Ok(Vec::new()));
    }

    #[test]
    fn a_model_that_goes_on_from_run_to_run_stays_small() {
        let (options, columns) = (OnlineOptions::default(), ColumnSelection::default());
        let data: DataFile = File::new("d.csv", record(1.0, 100)).into();
        let mut models = vec![model().with_provenance(json!({"command": "piezoid identify"}))];
        for _ in 0..3 {
            let file = File::new("m.json", models[models.len() - 1].to_json());
            models.push(options.replay(&file, &data, &columns, &mut |_| Ok(()), &mut Stage::ignore).unwrap().model);
        }
        let fit = models[3].provenance();
        assert_eq!((&fit["runs_before"], &fit["start"]), (&json!(2), &json!({"command": "piezoid identify"})));
    }

    #[test]
    fn a_gain_at_the_end_of_its_range_is_remarked_on() {
        let data: DataFile = File::new("d.csv", record(-1.0, 2000)).into();
        let options = OnlineOptions {
            estimator: EstimatorOptions { moves: "gain".into(), ..Default::default() },
            ..Default::default()
        };
        let found = options.replay(&file(), &data, &ColumnSelection::default(), &mut |_| Ok(()), &mut Stage::ignore);
        let remarks = found.unwrap().remarks;
        assert!(remarks.iter().any(|remark| remark.contains("the end of its range, 0.25")), "{remarks:?}");
    }
}
