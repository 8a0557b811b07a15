//! What pages of docs/ state in numbers: one module a page measures it and writes it. The tests repeat parts of it.

pub mod accuracy;
pub mod control;
pub mod evidence;
pub mod feedback;
pub mod operators;
pub mod page;
pub mod paper;
pub mod profile;
pub mod stand_in;
pub mod twin;
pub mod vectors;
