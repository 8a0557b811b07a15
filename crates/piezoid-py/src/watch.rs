//! Long work: Python receives its progress, and Ctrl-C stops it.

use crate::error::raised;
use crate::model::Model;
use piezoid::Error;
use piezoid::progress::{Progress, Stage};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Maximum time between two checks for signals.
const PATIENCE: Duration = Duration::from_millis(50);

/// Number of samples between two checks for signals, for work without stages.
const PIECE: usize = 1 << 16;

/// Calls `resume` on `u` piece by piece, without the interpreter's lock; Ctrl-C stops it between two pieces.
pub(crate) fn in_pieces(
    py: Python<'_>,
    u: &[f64],
    mut resume: impl FnMut(&[f64]) -> Vec<f64> + Send,
) -> PyResult<Vec<f64>> {
    if u.len() <= PIECE {
        return Ok(py.detach(|| resume(u)));
    }
    let mut y = Vec::with_capacity(u.len());
    for piece in u.chunks(PIECE) {
        y.extend(py.detach(|| resume(piece)));
        py.check_signals()?;
    }
    Ok(y)
}

/// True if a stage says what was found.
fn found(stage: &Stage) -> bool {
    !stage.figures.is_empty() || stage.model.is_some()
}

/// Does `work` in this process. A forked process has none of the threads of its parent's pool, and would wait for them
/// forever. In a forked process each thread therefore works alone.
fn within_this_process<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    static FIRST: OnceLock<u32> = OnceLock::new();
    thread_local! {
        // Never freed, because a pool of the current thread must not be freed.
        static ALONE: Option<&'static ThreadPool> =
            ThreadPoolBuilder::new().num_threads(1).use_current_thread().build().ok().map(|pool| &*Box::leak(Box::new(pool)));
    }
    let is_forked = *FIRST.get_or_init(std::process::id) != std::process::id();
    match is_forked.then(|| ALONE.with(|pool| *pool)).flatten() {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// Does `work` without the interpreter's lock. `progress`, if given, is called with the kind of work, the number of
/// steps done, and the total; its method `found`, if it has one, with the kind of work, the figures that were found by
/// name, the model of a finished fit or None, and whether it is the best so far. An exception that it raises stops the
/// work, as Ctrl-C does.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&mut Progress) -> Result<T, Error> + Send,
) -> PyResult<T> {
    watched_until(py, progress, work, |_| None)
}

/// The same for work that may have a result when an exception stops it: `kept` makes the attribute `model` of the
/// exception from it.
pub(crate) fn watched_until<T: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&mut Progress) -> Result<T, Error> + Send,
    kept: impl FnOnce(T) -> Option<Model>,
) -> PyResult<T> {
    let results = progress.as_ref().and_then(|progress| progress.getattr(py, "found").ok());
    let (mut raised_within, mut last) = (None, None);
    let mut heard = Instant::now();
    let outcome = py.detach(|| {
        let mut tell = |stage: Stage| {
            let now = Instant::now();
            if progress.is_none() && now - heard < PATIENCE {
                return ControlFlow::Continue(());
            }
            heard = now;
            let message = Python::attach(|py| {
                py.check_signals()?;
                let Some(progress) = &progress else { return Ok(()) };
                last = Some((stage.what.to_string(), stage.done, stage.total));
                progress.call1(py, (stage.what, stage.done, stage.total))?;
                let Some(results) = results.as_ref().filter(|_| found(&stage)) else { return Ok(()) };
                let figures = stage.figures.iter().copied().collect::<HashMap<_, _>>();
                let model = stage.model.map(piezoid::Model::from_json).transpose().map_err(raised)?;
                results.call1(py, (stage.what, figures, model.map(Model::from), stage.best)).map(drop)
            });
            match message {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    raised_within = Some(error);
                    ControlFlow::Break(())
                }
            }
        };
        within_this_process(|| work(&mut tell))
    });
    if let Some(error) = raised_within {
        if let Some(model) = outcome.ok().and_then(kept) {
            // Not every exception takes an attribute.
            let _ = error.value(py).setattr("model", model);
        }
        return Err(error);
    }
    let result = outcome.map_err(raised)?;
    // Stages are reported when they begin. This reports the end of the last one.
    if let (Some(progress), Some((what, done, total))) = (&progress, last)
        && done < total
    {
        progress.call1(py, (what, total, total))?;
    }
    Ok(result)
}
