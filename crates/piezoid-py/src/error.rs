//! Errors of the library as Python exceptions.

use piezoid::Error;
use piezoid_numerics::words::Words;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::Value;

create_exception!(piezoid, PiezoidError, PyValueError, "What is wrong, the value, where, and what to do.");

/// The words of Python: options are keywords.
pub(crate) struct Keywords;

impl Words for Keywords {
    fn option(&self, name: &str) -> String {
        format!("{name}=")
    }

    fn remedy(&self, name: &str, value: &Value) -> String {
        match value {
            Value::Null => self.option(name),
            Value::Bool(true) => format!("{name}=True"),
            value => format!("{name}={value}"),
        }
    }

    fn list(&self, name: &str) -> String {
        format!("`piezoid.{name}`")
    }
}

/// The same error for Python. `setting` has the name, the value and the rule of a setting outside its domain.
pub(crate) fn raised(error: Error) -> PyErr {
    let raised = refused(&error.message(&Keywords));
    if let Error::Parameter { name, value, rule } = error {
        // Without it, the error names the setting as the library does.
        let _ = Python::attach(|py| raised.value(py).setattr("setting", (name, value, rule)));
    }
    raised
}

/// An error with this message.
pub(crate) fn refused(message: &str) -> PyErr {
    PiezoidError::new_err(message.to_string())
}
