//! Long work: Python hears where it stands, and Ctrl-C ends it.

use crate::error::raised;
use piezoid::Error;
use piezoid::progress::{Progress, Stage};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// How long signals may wait.
const PATIENCE: Duration = Duration::from_millis(50);

/// Samples between two looks at signals, of what has no stages.
const PIECE: usize = 1 << 16;

/// What `resume` makes of `u`, piece by piece, without the interpreter's lock; Ctrl-C ends it between two pieces.
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

/// Does `work` without the interpreter's lock. `progress`, if any, is called with what is done, how far, and of how much; what it
/// raises ends the work, as Ctrl-C does.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&mut Progress) -> Result<T, Error> + Send,
) -> PyResult<T> {
    let mut raised_within = None;
    let outcome = py.detach(|| {
        let mut heard = Instant::now();
        work(&mut |stage: Stage| {
            let now = Instant::now();
            if progress.is_none() && now - heard < PATIENCE {
                return ControlFlow::Continue(());
            }
            heard = now;
            let told = Python::attach(|py| {
                py.check_signals()?;
                let call = |progress: &Py<PyAny>| progress.call1(py, (stage.what, stage.done, stage.total));
                progress.as_ref().map(call).transpose().map(drop)
            });
            match told {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    raised_within = Some(error);
                    ControlFlow::Break(())
                }
            }
        })
    });
    match (outcome, raised_within) {
        (_, Some(error)) => Err(error),
        (outcome, None) => outcome.map_err(raised),
    }
}
