//! Records: input and output sampled together.

use crate::error::{raised, refused};
use crate::json::{object, options};
use crate::samples::{Array, array, frozen, samples, slice};
use piezoid::formats::{Channel, ColumnSelection, Signal, Table};
use piezoid::{PrepareOptions, Units};
use piezoid_host::files;
use piezoid_verbs::{Origin, Step, inspect};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use serde_json::json;
use std::path::PathBuf;

/// Input and output sampled together, evenly.
#[pyclass(frozen, module = "piezoid", weakref)]
pub(crate) struct Record {
    pub(crate) record: piezoid::Record,
    /// Where it comes from, if not from arrays.
    pub(crate) origin: Option<Origin>,
    u: PyOnceLock<Array>,
    y: PyOnceLock<Array>,
}

impl From<piezoid::Record> for Record {
    fn from(record: piezoid::Record) -> Self {
        Record { record, origin: None, u: PyOnceLock::new(), y: PyOnceLock::new() }
    }
}

impl Record {
    /// The record after a step, of which its origin keeps note.
    fn after(&self, step: Step) -> PyResult<Self> {
        let record = step.run(self.record.clone()).map_err(raised)?;
        let origin = self.origin.clone().map(|mut origin| {
            origin.preparation.extend(Some(step).filter(|step| !step.is_empty()));
            origin
        });
        Ok(Record { origin, ..record.into() })
    }
}

#[pymethods]
impl Record {
    #[new]
    #[pyo3(signature = (u, y, ts, units=("V".into(), "um".into()), past=(Vec::new(), "null".into())))]
    fn new(
        u: &Bound<'_, PyAny>,
        y: &Bound<'_, PyAny>,
        ts: f64,
        units: (String, String),
        past: (Vec<String>, String),
    ) -> PyResult<Self> {
        let (history, origin) = past;
        let (u, y) = (samples("u", u)?, samples("y", y)?);
        let record = piezoid::Record::new(ts, slice(&u)?.to_vec(), slice(&y)?.to_vec()).map_err(raised)?;
        let record = record.with_units(Units { u: units.0, y: units.1 });
        let origin = serde_json::from_str(&origin).map_err(|e| refused(&format!("the origin of the record: {e}")))?;
        Ok(Record { origin, ..history.into_iter().fold(record, piezoid::Record::with_step).into() })
    }

    #[getter]
    fn ts(&self) -> f64 {
        self.record.ts()
    }

    #[getter]
    fn u(&self, py: Python<'_>) -> PyResult<Array> {
        self.u.get_or_try_init(py, || frozen(py, self.record.u())).map(|u| u.clone_ref(py))
    }

    #[getter]
    fn y(&self, py: Python<'_>) -> PyResult<Array> {
        self.y.get_or_try_init(py, || frozen(py, self.record.y())).map(|y| y.clone_ref(py))
    }

    #[getter]
    fn units(&self) -> (&str, &str) {
        let units = self.record.units();
        (&units.u, &units.y)
    }

    #[getter]
    fn history(&self) -> Vec<String> {
        self.record.history().to_vec()
    }

    /// Where it comes from, as JSON: null if from arrays.
    #[getter]
    fn origin(&self) -> String {
        json!(self.origin).to_string()
    }

    #[getter]
    fn duration(&self) -> f64 {
        self.record.duration()
    }

    fn part(&self, start: f64, stop: f64) -> PyResult<Self> {
        self.after(Step::Part(start, Some(stop).filter(|stop| *stop != f64::INFINITY)))
    }

    fn scaled(&self, input: String, output: String) -> PyResult<Self> {
        self.after(Step::Scaled(input, output))
    }

    fn prepare(&self, py: Python<'_>, settings: &Bound<'_, PyDict>) -> PyResult<Self> {
        let options: PrepareOptions = options(settings)?;
        py.detach(|| self.after(Step::Prepare(options)))
    }

    fn output_in(&self, unit: String) -> PyResult<Self> {
        self.after(Step::OutputIn(unit))
    }

    fn with_units(&self, units: (String, String)) -> PyResult<Self> {
        self.after(Step::Units(Units { u: units.0, y: units.1 }))
    }

    /// Writes the record in the format of its path.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let name = path.to_string_lossy();
        py.detach(|| files::write(&path, &self.record.written(&name).map_err(|error| error.of(&name))?)).map_err(raised)
    }

    fn __len__(&self) -> usize {
        self.record.len()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.record == other.record
    }
}

/// A profile of a rig: the name of its file, and its text.
type Profile = (String, String);

/// What keywords say of the columns, and what the profile says where they say nothing.
fn selection(settings: &Bound<'_, PyDict>, profile: Option<Profile>) -> PyResult<ColumnSelection> {
    let sentence: ColumnSelection = options(settings)?;
    let Some((name, text)) = profile else { return Ok(sentence) };
    ColumnSelection::from_toml(&text).map(|profile| sentence.or(profile)).map_err(|error| raised(error.of(&name)))
}

/// A column of a table: its name and its samples.
type Column<'py> = (String, Bound<'py, PyAny>);

/// The named channels of a file, or named arrays.
#[pyclass(frozen, module = "piezoid._piezoid")]
#[derive(Debug)]
pub(crate) struct Columns {
    table: Table,
    /// The format of a file, and where records in it come from.
    file: Option<(&'static str, Origin)>,
}

impl Columns {
    /// The record that was read with this selection.
    fn read_as(&self, columns: ColumnSelection, record: piezoid::Record) -> Record {
        let origin = self.file.as_ref().map(|(_, origin)| Origin { columns, ..origin.clone() });
        Record { origin, ..record.into() }
    }
}

#[pymethods]
impl Columns {
    #[staticmethod]
    fn from_file(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| {
            let file = files::data(&path)?;
            let (table, format, sha256) = file.hashed()?;
            Ok(Columns { table, file: Some((format.name, Origin::of(&file.name, sha256))) })
        })
        .map_err(raised)
    }

    #[staticmethod]
    fn from_arrays(columns: Vec<Column<'_>>, others: Vec<(String, String)>) -> PyResult<Self> {
        let read = |(name, values): &Column<'_>| Ok(Channel::new(name, slice(&samples(name, values)?)?.to_vec()));
        let mut channels = columns.iter().map(read).collect::<PyResult<Vec<_>>>()?;
        channels.extend(others.into_iter().map(|(name, what)| Channel::other(name, what)));
        Ok(Columns { table: Table::of(channels), file: None })
    }

    #[getter]
    fn names(&self) -> Vec<&str> {
        self.table.names().collect()
    }

    fn record(&self, settings: &Bound<'_, PyDict>, profile: Option<Profile>) -> PyResult<Record> {
        let columns = selection(settings, profile)?;
        let record = self.table.record(&columns).map_err(raised)?;
        Ok(self.read_as(columns, record))
    }

    /// What the columns hold as a document, and the record if they make one, otherwise the reason.
    fn inspect(
        &self,
        py: Python<'_>,
        name: &str,
        settings: &Bound<'_, PyDict>,
        profile: Option<Profile>,
    ) -> PyResult<(Py<PyAny>, Option<Record>, Option<String>)> {
        let columns = selection(settings, profile)?;
        let format = self.file.as_ref().map_or("arrays", |(format, _)| format);
        let (inspection, read) = inspect(&self.table, name, format, &columns);
        let (record, error) = match read {
            Ok(record) => (Some(self.read_as(columns, record)), None),
            Err(error) => (None, Some(raised(error).value(py).to_string())),
        };
        Ok((object(py, &inspection)?, record, error))
    }

    /// How records like this one are read: the text of a profile.
    fn profile(&self, settings: &Bound<'_, PyDict>, profile: Option<Profile>) -> PyResult<String> {
        let selection = selection(settings, profile)?;
        self.table.record(&selection).map_err(raised)?;
        Ok(self.table.profile(&selection).to_toml())
    }

    /// The sampling period [s] and the samples of the input, in this unit; `ts` is the period if no column is a time.
    fn input(&self, py: Python<'_>, settings: &Bound<'_, PyDict>, model: (String, f64)) -> PyResult<(f64, Array)> {
        let ((unit, ts), mut selection) = (model, options::<ColumnSelection>(settings)?);
        if !self.table.is_timed(&selection) {
            selection.ts = Some(ts);
        }
        converted(py, self.table.input(&selection).map_err(raised)?, "the input", &unit)
    }

    /// The sampling period [s] and the samples of the reference, in this unit.
    fn reference(&self, py: Python<'_>, settings: &Bound<'_, PyDict>, unit: &str) -> PyResult<(f64, Array)> {
        converted(py, self.table.reference(&options(settings)?).map_err(raised)?, "the reference", unit)
    }
}

/// The sampling period of a signal, and its samples in this unit.
fn converted(py: Python<'_>, signal: Signal, what: &str, unit: &str) -> PyResult<(f64, Array)> {
    let Some(factor) = Units::factor(&signal.unit, unit) else {
        let own = signal.unit;
        return Err(refused(&format!("{what} is in {own}, but {unit} is needed: convert it first")));
    };
    Ok((signal.ts, array(py, signal.samples.iter().map(|v| v * factor).collect())))
}
