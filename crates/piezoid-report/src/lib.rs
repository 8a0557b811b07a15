//! Reports: figures as SVG, pages of HTML in one file, the report on a model, and the study of the paper.

mod dcc;
mod each;
mod hysteresis_part;
#[doc(hidden)]
pub mod page;
#[doc(hidden)]
pub mod plot;
pub mod report;
pub mod study;

pub use dcc::dcc;
pub use page::Page;
