//! `piezoid online`: recursive identification along a stream or a record.

use super::prelude::*;
use crate::values::Ended;
use piezoid::Error;
use piezoid::formats::ColumnSelection;
use piezoid::progress::{Progress, Stage};
use piezoid_numerics::number::short as number;
use piezoid_verbs::{OnlineOptions, OnlineRow, OnlineRun};
use serde_json::json;
use std::io::{BufRead, Read};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  Follow an actuator, whose samples a program writes as lines `u,y`:
    reader | piezoid online - --model model.json -o now.json
  Replay a record, with a row every half second:
    piezoid online day.csv --model model.json --every 0.5 -o now.json
  Gain and offset alone, as JSON, one row a line:
    piezoid online day.csv --model model.json --moves gain,offset --json -

A stream has lines `u,y` or `t,u,y` in the units of the model, one a sampling period; an empty y is a missing reading. \
It ends with its last line or with Ctrl-C; either way the model is written as it is then.";

#[derive(Args)]
#[command(after_help = EXAMPLES, override_usage = "piezoid online <FILE|-> --model <FILE> [OPTIONS]")]
pub(crate) struct Online {
    /// The record; - is a stream on stdin.
    #[arg(value_name = "FILE")]
    data: PathBuf,
    /// The model file to start at.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    #[command(flatten)]
    options: Flags<OnlineOptions>,
    /// The file for the model as it is at the end; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the rows as JSON, one a line; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

/// Longest line of a stream [bytes].
const MAX_LINE: u64 = 4096;

/// Lines that wait at most.
const QUEUE: usize = 1024;

/// Time after which a stream without lines is left to look for a signal.
const PATIENCE: Duration = Duration::from_millis(100);

/// Widths of the columns of the table.
const WIDTHS: [usize; 6] = [10, 9, 12, 12, 10, 9];

impl Run for Online {
    fn run(self, console: &Console) -> Result<()> {
        let is_stream = self.data == Path::new("-");
        let inputs: Vec<&PathBuf> = std::iter::once(&self.model).chain((!is_stream).then_some(&self.data)).collect();
        let is_free = files::check(&[self.output.as_deref(), self.json.as_deref()], &inputs)?;
        let (options, columns, model) = (&self.options.0, self.columns.read()?, files::read(&self.model)?);
        if is_stream && columns != ColumnSelection::default() {
            bail!("options of data files apply to records: a stream has lines u,y or t,u,y");
        }
        let mut rows = Rows { console, table: is_free, json: self.json.clone(), lines: String::new(), first: true };
        let mut bad_line = None;
        let ((model, remarks), is_cancelled) = if is_stream {
            let mut run = options.start(&model).map_err(failed)?;
            rows.unit(run.unit());
            let lines = stdin();
            console.work_until_cancelled(|progress| {
                bad_line = follow(&mut run, &lines, &mut rows, progress).err();
                Ok((run.finished(json!("stream"))?, run.remarks()))
            })?
        } else {
            let data = files::data(&self.data)?;
            rows.unit(&model.model().map_err(failed)?.units().y);
            console.work_until_cancelled(|progress| {
                let result = options.replay(&model, &data, &columns, &mut |row| rows.take(row), progress)?;
                Ok((result.model, result.remarks))
            })?
        };
        console.remarks(remarks);
        let json = self.json.as_deref().filter(|path| *path != Path::new("-"));
        let results = Results::default().file(json, rows.lines).file_with(self.output.as_deref(), || model.to_json());
        results.write(console)?;
        if let Some(error) = bad_line {
            let wrote = self.output.map(|path| format!("; wrote the model until then to {}", path.display()));
            bail!("{error}{}", wrote.unwrap_or_default());
        }
        if is_cancelled {
            let samples = &model.provenance()["samples"];
            let wrote = self.output.map(|path| format!(": wrote the model to {}", path.display())).unwrap_or_default();
            bail!(Ended::Cancelled(format!("cancelled after {samples} samples{wrote}")));
        }
        match (is_free, &self.output) {
            (true, Some(path)) => console.sentence(&format!("Wrote {}", path.display())),
            _ => Ok(()),
        }
    }
}

/// Where rows go.
struct Rows<'c> {
    console: &'c Console,
    /// True if stdout is free for a table.
    table: bool,
    json: Option<PathBuf>,
    /// Rows for a file.
    lines: String,
    /// True before the first row.
    first: bool,
}

impl Rows<'_> {
    /// Prints the head of the table.
    fn unit(&self, unit: &str) {
        if self.table {
            let [offset, error] = ["offset", "error"].map(|name| format!("{name} [{unit}]"));
            let head = ["time [s]", "gain", &offset, &error, "mode [Hz]", "damping"];
            // Whoever closed the pipe reads no rows either.
            let _ = self.print(&head.map(String::from));
        }
    }

    fn take(&mut self, row: &OnlineRow) -> Result<(), Error> {
        let line = || serde_json::to_string(row).unwrap_or_default() + "\n";
        let failed = |error: anyhow::Error| Error::Content(format!("{error:#}"));
        match &self.json {
            Some(path) if path == Path::new("-") => self.console.print(&line()).map_err(failed)?,
            Some(_) => self.lines += &line(),
            None => {}
        }
        self.first = false;
        if self.table { self.print(&cells(row)).map_err(failed) } else { Ok(()) }
    }

    fn print(&self, cells: &[String; 6]) -> Result<()> {
        let padded: Vec<String> = cells.iter().zip(WIDTHS).map(|(cell, width)| format!("{cell:>width$}")).collect();
        self.console.print(&(padded.join("  ") + "\n"))
    }
}

fn cells(row: &OnlineRow) -> [String; 6] {
    let none = || "-".to_string();
    let (hz, damping) = row.mode.map_or((none(), none()), |(hz, damping)| (format!("{hz:.1}"), number(damping)));
    let (gain, offset) = (format!("{:.4}", row.parameters.gain), number(row.parameters.offset));
    [number(row.t), gain, offset, row.error_rms.map_or_else(none, number), hz, damping]
}

/// The lines of stdin, read by a thread of their own, so that a signal ends a stream that is silent. A last line
/// without an end is cut: a number in it may be another one.
fn stdin() -> Receiver<std::io::Result<String>> {
    let (to, lines) = sync_channel(QUEUE);
    std::thread::spawn(move || {
        let mut source = std::io::stdin().lock();
        loop {
            let mut line = String::new();
            let read = (&mut source).take(MAX_LINE).read_line(&mut line);
            let is_cut = read.is_ok() && !line.ends_with('\n') && (line.len() as u64) < MAX_LINE;
            let is_end = is_cut || read.is_err();
            if is_cut || to.send(read.map(|_| line)).is_err() || is_end {
                return;
            }
        }
    });
    lines
}

/// Follows a stream to its end, or to a signal.
fn follow(
    run: &mut OnlineRun,
    lines: &Receiver<std::io::Result<String>>,
    rows: &mut Rows,
    progress: &mut Progress,
) -> Result<(), Error> {
    let (mut time, mut number) = (None, 0u64);
    loop {
        let line = match lines.recv_timeout(PATIENCE) {
            Ok(line) => line.map_err(|error| Error::Content(format!("stdin cannot be read: {error}")))?,
            Err(RecvTimeoutError::Timeout) => String::new(),
            Err(RecvTimeoutError::Disconnected) => break,
        };
        number += u64::from(!line.is_empty());
        if line.len() as u64 >= MAX_LINE {
            return Err(
                Error::line(number, format!("longer than {MAX_LINE} bytes: write one sample a line")).of("stdin")
            );
        }
        let sample = run.line(&line, &mut time);
        let sample = sample.map_err(|error| Error::line(number, error.to_string()).of("stdin"))?;
        if let Some(row) = sample.and_then(|(u, y)| run.step(u, y)) {
            rows.take(&row)?;
        }
        if (line.is_empty() || number % 256 == 0) && progress(Stage::new("stream", 0, 0)).is_break() {
            break;
        }
    }
    // A stream shorter than a row shows where it ended.
    if rows.first && run.samples() > 0 { rows.take(&run.row()) } else { Ok(()) }
}
