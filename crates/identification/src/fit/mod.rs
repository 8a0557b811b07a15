//! The mathematics of the joint method: the fit of all parts for a given structure, operator and initial conditions.
//!
//! ```text
//! estimate -> columns of the linearised free-run error -> products by run and fold -> equations -> one step
//! ```
//! [`refine()`] repeats this to the minimum. Held-out errors, standard errors and the optimality of a fit follow from
//! the same products. Nothing here selects a structure, an operator or an initial condition: that is `search`.

mod columns;
mod dynamics;
mod equations;
mod estimate;
mod fitted;
mod folds;
mod free_run;
mod gram;
mod held_out;
mod hidden;
mod iterate;
mod layout;
mod offset;
mod optimality;
mod parts;
mod products;
mod reduced;
mod refine;
mod runs;
mod signals;
mod solve;
mod spread;
mod terms;
#[cfg(test)]
mod testing;
mod uncertainty;
mod windows;

pub(super) use dynamics::{
    MAX_MODE_DAMPING, MIN_MODE_DAMPING, creep_pole, is_lag, slowest_observable, slowest_pole, with_slow_lags_limited,
    without_factor,
};
pub(super) use equations::SAMPLES_PER_ERROR;
pub(super) use estimate::{CreepOrder, Estimate};
pub(super) use fitted::Fitted;
pub(super) use free_run::{free_run_residual, free_run_squares};
pub(super) use held_out::Smoothness;
pub(super) use hidden::Hidden;
pub(super) use iterate::Iterate;
pub(super) use offset::offset;
pub(super) use optimality::optimality;
pub(super) use parts::Parts;
pub(super) use reduced::Reduced;
pub(crate) use refine::{
    StepCallback, refine, refine_from, refine_from_unknown, refine_further, refine_if_better, refine_promising,
    refine_to_minimum, refine_within_reach,
};
pub(super) use runs::{TrainingRecord, training_records};
pub(super) use solve::{FreeParameters, MAX_CREEP_GAIN, roughness};
pub(super) use spread::Spread;
pub(super) use terms::with_selected_terms;
#[cfg(test)]
pub(super) use testing::{estimate, pair};
pub use uncertainty::FittedParameter;
pub(super) use uncertainty::parameters;
