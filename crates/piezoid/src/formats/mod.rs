//! Files into records and back: bytes in, [`Record`](crate::Record) out.
//!
//! A format turns bytes into a [`Table`] of named columns; the names, and a [`Selection`] where they do not suffice,
//! say which column is the time, the input and the output. Nothing here opens a file, and nothing is guessed: what
//! could mean two things is refused, with the option that decides it.

pub mod csv;
mod quote;
mod selection;
mod table;
mod time;

pub use selection::Selection;
pub use table::{Signal, Table};
