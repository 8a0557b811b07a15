//! Operating-system functions for front ends, which the library does without: writing complete files, the C compiler,
//! and signals.

pub mod compiler;
pub mod files;
#[cfg(unix)]
pub mod signals;
pub mod temporary;
