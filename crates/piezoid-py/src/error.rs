//! Errors of the library as Python knows them.

use piezoid::Error;
use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

create_exception!(piezoid, PiezoidError, PyValueError, "What is wrong, the value, where, and what to do.");

/// The same error for Python, with options of the command line called as the keywords they are here.
pub(crate) fn raised(error: Error) -> PyErr {
    refused(&error.to_string())
}

/// A refusal in the library's words.
pub(crate) fn refused(message: &str) -> PyErr {
    PiezoidError::new_err(keywords(message))
}

/// `--input-col` is `input_col=` in Python.
fn keywords(message: &str) -> String {
    let mut out = String::with_capacity(message.len());
    let mut rest = message;
    while let Some(at) = rest.find("--") {
        let (before, option) = rest.split_at(at);
        let name: String = option[2..].chars().take_while(|c| c.is_ascii_lowercase() || *c == '-').collect();
        let is_option = name.starts_with(|c: char| c.is_ascii_lowercase()) && !before.ends_with(['-', '|']);
        out += before;
        out += &if is_option { format!("{}=", name.replace('-', "_")) } else { format!("--{name}") };
        rest = &option[2 + name.len()..];
        // A value stands behind a blank there, and behind the sign here.
        if let (true, Some(value)) = (is_option, rest.strip_prefix(' '))
            && value.starts_with(|c: char| c.is_ascii_digit())
        {
            rest = value;
        }
    }
    out + rest
}
