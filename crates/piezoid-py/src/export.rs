//! Models for other machines.

use crate::compensation::{how, inner};
use crate::control::{Tuning, target};
use crate::error::{raised, refused};
use crate::model::Model;
use crate::samples::{samples, slice};
use piezoid::control::{Law, Scheme, TunedScheme};
use piezoid_export::{ExportRequest, Playback, target as chosen};
use piezoid_host::{compiler, files};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;

/// Files by their paths, and notes.
type ExportTuple = (Vec<(String, Py<PyBytes>)>, Vec<String>);

/// Writes a file, which is whole or not there.
#[pyfunction]
pub(crate) fn write(path: PathBuf, content: &[u8]) -> PyResult<()> {
    files::write(&path, content).map_err(raised)
}

/// What a target makes, written into a folder if one is named.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn export(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    target_name: &str,
    name: &str,
    options: (bool, usize, Option<String>),
    tuning: Tuning,
    settings: &Bound<'_, PyDict>,
    reference: Option<Bound<'_, PyAny>>,
    playback: (Option<f64>, Option<(f64, f64)>),
    folder: Option<PathBuf>,
) -> PyResult<ExportTuple> {
    let (model, how, (single, preview, law)) = (inner(model), how(settings)?, options);
    let chosen = chosen(target_name).map_err(raised)?;
    let given = [
        ("float", single),
        ("preview", preview > 0),
        ("controller", law.is_some()),
        ("reference", reference.is_some()),
    ];
    if law.is_none() && (tuning.0 > 0 || tuning.1.or(tuning.2).is_some()) {
        return Err(refused("late, gain_margin and phase_margin are of a controller: name one with controller="));
    }
    if (playback.0.is_some() || playback.1.is_some()) && !chosen.accepts.contains(&"reference") {
        return Err(refused(&format!("servo_cycle and range are not for the target {target_name}")));
    }
    if let Some((option, _)) = given.iter().find(|(option, given)| *given && !chosen.accepts.contains(option)) {
        return Err(refused(&format!("--{option} is not for the target {target_name}")));
    }
    let read = reference.as_ref().map(|r| samples("reference", r)).transpose()?;
    let reference = read.as_ref().map(|r| slice(r)).transpose()?;
    let usual = Playback::default();
    let playback = Playback { servo_cycle: playback.0.unwrap_or(usual.servo_cycle), range: playback.1 };
    let target = target(&tuning);
    let made = py
        .detach(|| {
            let drive = match &law {
                None => None,
                Some(name) => {
                    let scheme = Scheme { law: Some(Law::find(name)?), ..Scheme::named("gain")? };
                    Some(TunedScheme::new(scheme, &model, how, tuning.0, &target)?)
                }
            };
            let controller = drive.as_ref().map(TunedScheme::controller);
            let wanted = ExportRequest {
                single,
                settings: how,
                preview,
                controller,
                reference,
                playback,
                compiler: compiler::here(),
                ..ExportRequest::new(&model, name)
            };
            let made = (chosen.make)(&wanted)?;
            folder.iter().try_for_each(|folder| files::write_all(folder, &made.files))?;
            Ok(made)
        })
        .map_err(raised)?;
    let files = made.files.into_iter().map(|file| (file.path, PyBytes::new(py, &file.bytes).unbind()));
    Ok((files.collect(), made.notes))
}
