//! What front ends need of the machine they run on, and the library does without: files that are whole or not there,
//! and the C compiler.

pub mod compiler;
pub mod files;
