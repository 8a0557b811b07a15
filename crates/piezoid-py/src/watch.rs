//! Long work: Python hears where it stands, and Ctrl-C ends it.

use crate::error::raised;
use piezoid::Error;
use piezoid::progress::{Progress, Stage};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// How long signals may wait.
const PATIENCE: Duration = Duration::from_millis(50);

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
