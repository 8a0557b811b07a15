//! Documents of the library as Python objects.

use crate::error::{Keywords, raised};
use piezoid_numerics::options::{OptionKind, OptionRow, Options};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyList, PyString};
use serde_json::{Map, Value, json};

/// A document: objects as dicts with the same order of members.
pub(crate) fn object(py: Python<'_>, value: &Value) -> PyResult<Py<PyAny>> {
    match value {
        Value::Null => Ok(py.None()),
        Value::Bool(b) => b.into_py_any(py),
        Value::Number(n) => match n.as_i64() {
            Some(whole) => whole.into_py_any(py),
            None => n.as_f64().into_py_any(py),
        },
        Value::String(text) => text.into_py_any(py),
        Value::Array(values) => {
            let values = values.iter().map(|v| object(py, v)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, values)?.into_py_any(py)
        }
        Value::Object(members) => {
            let dict = PyDict::new(py);
            for (name, value) in members {
                dict.set_item(name, object(py, value)?)?;
            }
            dict.into_py_any(py)
        }
    }
}

/// The members of a document by name, and others beside them: the keywords of a class of Python.
pub(crate) fn members<'py>(
    py: Python<'py>,
    document: &Value,
    others: impl IntoIterator<Item = (&'static str, Py<PyAny>)>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = object(py, document)?.into_bound(py).cast_into::<PyDict>()?;
    others.into_iter().try_for_each(|(name, value)| dict.set_item(name, value))?;
    Ok(dict)
}

/// Options of the library from keywords; numbers may have any Python type.
pub(crate) fn options<O: Options>(settings: &Bound<'_, PyDict>) -> PyResult<O> {
    O::from_json(document(settings)?).map_err(raised)
}

/// Settings by their names as a document.
pub(crate) fn document(settings: &Bound<'_, PyDict>) -> PyResult<Value> {
    let members = settings.iter().map(|(name, value)| Ok((name.extract()?, value_of(&value)?)));
    members.collect::<PyResult<Map<_, _>>>().map(Value::Object)
}

/// A setting as a document. A value that no document can contain becomes its text; the library then returns an error.
fn value_of(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if value.is_none() {
        return Ok(Value::Null);
    }
    if let Ok(switch) = value.cast::<PyBool>() {
        return Ok(switch.is_true().into());
    }
    let several = value.try_iter().ok().filter(|_| value.cast::<PyString>().is_err());
    if let Some(several) = several {
        return several.map(|value| value_of(&value?)).collect();
    }
    if value.cast::<PyString>().is_err() {
        let whole = if value.cast::<PyFloat>().is_ok() { None } else { value.extract::<u64>().ok() };
        if let Some(number) = whole.map(Value::from).or_else(|| value.extract::<f64>().ok().and_then(finite)) {
            return Ok(number);
        }
    }
    Ok(value.str()?.to_string().into())
}

fn finite(number: f64) -> Option<Value> {
    number.is_finite().then(|| number.into())
}

/// A table of options: names, defaults, units, names of choices, and help in the words of Python.
pub(crate) fn rows(rows: Vec<OptionRow>) -> Value {
    let row = |row: OptionRow| {
        let mut document = json!(row);
        document["help"] = row.help_in(&Keywords).into();
        document["choices"] = match row.values {
            OptionKind::Choice(known) => known.iter().map(|(name, _)| *name).collect(),
            _ => json!([]),
        };
        document
    };
    rows.into_iter().map(row).collect()
}
