//! Errors of the library as Python exceptions.

use piezoid::Error;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::Value;

create_exception!(piezoid, PiezoidError, PyValueError, "What is wrong, the value, where, and what to do.");

/// The same error for Python, with options named as keywords.
pub(crate) fn raised(error: Error) -> PyErr {
    refused(&error.told(&|name, value| match value {
        Value::Null => format!("{name}="),
        Value::Bool(true) => format!("{name}=True"),
        value => format!("{name}={value}"),
    }))
}

/// An error with this message.
pub(crate) fn refused(message: &str) -> PyErr {
    PiezoidError::new_err(message.to_string())
}
