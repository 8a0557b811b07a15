//! Progress of long tasks, and their cancellation.

use serde::{Serialize, Serializer};
use std::ops::ControlFlow;

/// The present progress of a task. As a document, `figures` are an object.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stage<'a> {
    /// Name of the task as a noun phrase: "linear block by swarm".
    pub what: &'a str,
    /// Number of steps done.
    pub done: usize,
    /// Number of all steps.
    pub total: usize,
    /// The latest results by name, such as the errors of an operator or the cost of a search; often empty.
    #[serde(serialize_with = "by_name")]
    pub figures: &'a [(&'a str, f64)],
    /// The text of the file of a model, when a fit is finished. In an identification `what` is its operator then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<&'a str>,
    /// True if this model is better than those before: a task that is cancelled ends with the last one of these.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub best: bool,
}

/// A callback for progress; [`ControlFlow::Break`] cancels the task.
pub type Progress<'a> = dyn FnMut(Stage) -> ControlFlow<()> + 'a;

impl<'a> Stage<'a> {
    /// A stage that has found nothing yet.
    pub const fn new(what: &'a str, done: usize, total: usize) -> Self {
        Stage { what, done, total, figures: &[], model: None, best: false }
    }

    /// A callback that ignores progress.
    ///
    /// ```
    /// # use piezoid::progress::Stage;
    /// assert!(Stage::ignore(Stage::new("anything", 1, 2)).is_continue());
    /// ```
    pub fn ignore(_: Stage) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn by_name<S: Serializer>(figures: &&[(&str, f64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(figures.iter().copied())
}
