//! Progress of long tasks, and their cancellation.

use std::ops::ControlFlow;

/// The present progress of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stage<'a> {
    /// Name of the task as a noun phrase: "linear block by swarm".
    pub what: &'a str,
    /// Number of steps done.
    pub done: usize,
    /// Number of all steps.
    pub total: usize,
}

/// A callback for progress; [`ControlFlow::Break`] cancels the task.
pub type Progress<'a> = dyn FnMut(Stage) -> ControlFlow<()> + 'a;

impl Stage<'_> {
    /// A callback that ignores progress.
    ///
    /// ```
    /// # use piezoid::progress::Stage;
    /// assert!(Stage::ignore(Stage { what: "anything", done: 1, total: 2 }).is_continue());
    /// ```
    pub fn ignore(_: Stage) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}
