//! How long work tells where it stands, and how it is told to stop.

use std::ops::ControlFlow;

/// Where a piece of work stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stage<'a> {
    /// What is being done, as a noun phrase: "linear block by swarm".
    pub what: &'a str,
    /// Steps done.
    pub done: usize,
    /// Steps in all.
    pub total: usize,
}

/// Called as work advances; [`ControlFlow::Break`] cancels it.
pub type Progress<'a> = dyn FnMut(Stage) -> ControlFlow<()> + 'a;

/// For work nobody watches.
///
/// ```
/// # use piezoid::progress::{Stage, silent};
/// assert!(silent(Stage { what: "anything", done: 1, total: 2 }).is_continue());
/// ```
pub fn silent(_: Stage) -> ControlFlow<()> {
    ControlFlow::Continue(())
}
