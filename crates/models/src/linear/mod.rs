//! The linear block: an ARX difference equation, its analysis, its inverses, and the estimators that fit it.

mod absolute_error;
mod analysis;
mod arx;
mod delay;
mod fit;
mod fit_modes;
mod free_decay;
mod free_run;
mod hidden;
mod instrumental;
mod inverse;
mod modal_error;
mod modes;
mod output_error;
mod regression;
pub mod select;
mod tones;
mod uncertainty;

#[doc(hidden)]
pub use absolute_error::AbsoluteError;
pub use analysis::{Pole, Response, Root};
pub use arx::Arx;
pub use fit::{ESTIMATORS, Estimator, Fit, Residuals};
pub use fit_modes::{FittedMode, ModalFit};
pub use free_decay::free_decay_modes;
#[doc(hidden)]
pub use free_run::decays_within;
pub use modes::{ModalForm, PoleShare};
pub use output_error::refine;
pub use output_error::{OutputError, Refinement};
pub use regression::Orders;
#[doc(hidden)]
pub use regression::Regression;
pub use select::{OrderSearch, select};
pub use tones::select_beside_tones;
pub use uncertainty::{Bootstrap, Uncertain};
