//! Reports: figures as SVG, pages of HTML in one file, the report on a model, and the study of the paper.

pub mod page;
pub mod plot;
pub mod report;
pub mod study;
#[cfg(test)]
#[path = "../../piezoid/src/testing.rs"]
mod testing;
