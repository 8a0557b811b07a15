//! Operating-system functions for front ends, which the library does without: writing complete files, and the C
//! compiler.

pub mod compiler;
pub mod files;
pub mod temporary;
