//! Series of numbers: from numpy and to numpy.

use crate::error::refused;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

/// A series of numbers in Python.
pub(crate) type Array = Py<PyArray1<f64>>;

/// The samples of a Python object: a view of a contiguous array of doubles, or a converted copy of anything else.
///
/// # Errors
/// Returns an error for more than one dimension (with the shape), complex numbers, masked arrays, and values that are
/// not numbers.
pub(crate) fn samples<'py>(what: &str, settings: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArray1<'py, f64>> {
    if let Ok(array) = settings.cast::<PyArray1<f64>>()
        && array.get_type().name().is_ok_and(|name| name == "ndarray")
        && let view = array.try_readonly()?
        && view.as_slice().is_ok()
    {
        return Ok(view);
    }
    converted(what, settings)
}

fn converted<'py>(what: &str, settings: &Bound<'py, PyAny>) -> PyResult<PyReadonlyArray1<'py, f64>> {
    let py = settings.py();
    let numpy = numpy(py)?;
    if settings.is_instance(&numpy.getattr(intern!(py, "ma"))?.getattr(intern!(py, "MaskedArray"))?)? {
        return Err(refused(&format!("{what} is a masked array: fill it, or leave the masked samples out")));
    }
    let array = numpy.call_method1(intern!(py, "asarray"), (settings,));
    let array = array.map_err(|e| refused(&format!("{what} is not a series of numbers: {}", e.value(py))))?;
    let untyped = array.cast::<PyUntypedArray>()?;
    if untyped.ndim() != 1 {
        let shape = array.getattr(intern!(py, "shape"))?.str()?;
        return Err(refused(&format!("{what} has shape {shape}: it must be one series of n samples, of shape (n,)")));
    }
    let kind: String = untyped.dtype().getattr(intern!(py, "kind"))?.extract()?;
    if !["f", "i", "u", "b"].contains(&kind.as_str()) && untyped.len() > 0 {
        let numbers = kind == "O" && settings.call_method0(intern!(py, "__len__")).is_ok();
        if !numbers {
            return Err(refused(&format!("{what} is of type {}: its samples must be real numbers", untyped.dtype())));
        }
    }
    // Aligned as well: arrays from a pickle in several pieces, as Dask sends it, may be misaligned.
    let doubles = numpy.call_method1(intern!(py, "require"), (array, intern!(py, "float64"), ["C", "A"]));
    let doubles =
        doubles.map_err(|e| refused(&format!("{what} contains a value that is not a number: {}", e.value(py))))?;
    Ok(doubles.cast_into::<PyArray1<f64>>()?.try_readonly()?)
}

/// A vector as an array that owns it, without a copy.
pub(crate) fn array(py: Python<'_>, values: Vec<f64>) -> Array {
    PyArray1::from_vec(py, values).unbind()
}

/// The same as a read-only array, because several objects share it.
pub(crate) fn frozen(py: Python<'_>, values: &[f64]) -> PyResult<Array> {
    let array = PyArray1::from_slice(py, values);
    array.call_method1(intern!(py, "setflags"), (false,))?;
    // A view, because an array that owns its samples could be made writable again.
    Ok(array.call_method0(intern!(py, "view"))?.cast_into()?.unbind())
}

/// The samples as a slice.
pub(crate) fn slice<'a>(samples: &'a PyReadonlyArray1<'_, f64>) -> PyResult<&'a [f64]> {
    Ok(samples.as_slice()?)
}

fn numpy(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    static NUMPY: PyOnceLock<Py<PyModule>> = PyOnceLock::new();
    let module = NUMPY.get_or_try_init(py, || py.import("numpy").map(Bound::unbind))?;
    Ok(module.bind(py).clone().into_any())
}
