//! The linear block: an ARX difference equation, its analysis, its inverses, and the estimators that fit it.

mod absolute_error;
mod analysis;
mod arx;
mod fit;
mod free_run;
mod instrumental;
mod inverse;
mod output_error;
mod regression;
mod select;
mod uncertainty;

pub use absolute_error::AbsoluteError;
pub use analysis::{Pole, Response, Root};
pub use arx::Arx;
pub use fit::{ESTIMATORS, Estimator, Fit, Residuals, estimator, fit, too_low};
pub use inverse::Inverse;
pub use output_error::{OutputError, Refinement, output_error, refine};
pub use regression::{Orders, Regression};
pub use select::{Candidate, Choice, Selection, select};
