//! Identifies a model of a piezo actuator from measured records, validates it, computes the voltage for a reference,
//! and exports code for controllers.
//!
//! ```
//! use piezoid::{IdentifyOptions, Record, Validate, compensation::Compensate, formats::ColumnSelection, identify};
//! use piezoid_export::Export;
//! # use piezoid::{excitation::RisingSine, plant::{Plant, Preset}};
//! # let plant = Plant::named("pl140", 1e-3)?;
//! # let csv = |frequency, n| -> Result<Vec<u8>, piezoid::Error> {
//! #     let u = RisingSine { amplitude: 28.0, frequency, ..RisingSine::default() }.samples(1e-3, n)?;
//! #     let y = plant.run(&u).y;
//! #     Record::new(1e-3, u, y)?.written("record.csv")
//! # };
//! # let (train, test) = (csv(4.0, 2000)?, csv(7.0, 1000)?);
//! # let path: Vec<f64> = (0..1000).map(|t| 200.0 * (0.02 * f64::from(t)).sin()).collect();
//! // Bytes of CSV files with the columns t_s, u_V and y_um.
//! let columns = ColumnSelection::default();
//! let (train, test) = (Record::from_csv(&train, &columns)?, Record::from_csv(&test, &columns)?);
//! let options = IdentifyOptions { operator: "prandtl-ishlinskii".into(), ..IdentifyOptions::default() };
//! let model = identify(&[train], &options)?.model;
//! println!("{} % of peak-to-peak", model.validate(&test)?.metrics.rms_pp_percent);
//! let voltage = model.compensate(&path)?.u;
//! let files = model.export("c", "bender")?.files;
//! # assert!(model.validate(&test)?.metrics.rms_pp_percent < 3.0 && voltage.len() == 1000 && files.len() == 4);
//! # Ok::<(), piezoid::Error>(())
//! ```
//!
//! Both features are on by default. Without `clarabel` there is no estimator `least-absolute` and no
//! `Solver::InteriorPoint`; without `foreign` only text files are read and written.
//!
//! The library does no input or output: no files, no clock, no printing, and threads only on request. Seeds are
//! parameters, and the same input gives the same bytes.

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

#[cfg(test)]
extern crate self as piezoid;
#[cfg(test)]
mod tests;

pub use piezoid_models::{creep, driver};
pub use piezoid_numerics::{progress, system};

/// The inverse of a model, for a whole reference or sample by sample; shaping of references; iterative learning.
pub mod compensation {
    pub use piezoid_control::compensation::{
        Causal, Compensate, Compensated, FeedForward, FeedForwardSettings, Learned, Learning,
    };

    /// Shapers that do not excite a mode.
    pub mod shaping {
        pub use piezoid_control::compensation::shaping::Shaping;
    }
}

/// Controllers, their tuning and margins, the closed loop, and the comparison of schemes.
pub mod control {
    pub use piezoid_control::feedback::{
        CONTROLLERS, ClosedLoopRun, Comparison, Controller, ControllerInput, ControllerKind, FEED_FORWARDS,
        FeedForwardKind, MarginTarget, Margins, NamedReference, REFERENCES, Reference, ReferenceResult, Scheme,
        SchemeResult, SimulatedActuator, Tolerance, Tracking, TunedScheme,
    };
}

/// Errors: what is wrong, the value, where, and what to do.
pub mod error {
    pub use piezoid_numerics::error::Error;
}

/// Drive signals, the limits of drivers, and data sheets of actuators.
pub mod excitation {
    pub use piezoid_records::excitation::{
        ACTUATORS, Actuator, Amplifier, Chirp, DRIVERS, EXCITATIONS, Excitation, LimitOptions, Limits, Multisine, Prbs,
        RisingSine, Sine, Staircase, SteppedSine, Triangle, Usage,
    };
}

/// Mechanics with hysteresis in feedback: driven by the displacement, for instance.
pub mod feedback {
    pub use piezoid_identification::feedback::{FeedbackFit, Structure};
    pub use piezoid_models::feedback::{FeedbackDynamics, FeedbackMode, FeedbackModel, Intersample};
}

/// File formats: bytes, tables, columns, records.
pub mod formats {
    pub use piezoid_records::formats::{Channel, ColumnSelection, FORMATS, Format, Signal, Table};
}

/// The Hammerstein model, and the results of its identification.
pub mod hammerstein {
    pub use piezoid_identification::{FittedParameter, Identified, LinearPart, OperatorTrial};
    pub use piezoid_models::hammerstein::{Domain, InitialCondition, Model};
}

/// Hysteresis operators.
pub mod hysteresis {
    pub use piezoid_models::hysteresis::{HeldInput, Hysteresis, OPERATORS, Operator, Proportional, Split};
}

/// The linear block: its analysis, its inverses, and the estimators that fit it.
pub mod linear {
    pub use piezoid_models::linear::{
        Arx, Bootstrap, ESTIMATORS, Estimator, Fit, ModalFit, ModalForm, Orders, OutputError, Pole, Refinement,
        Uncertain,
    };
}

/// Search for a minimum.
pub mod optimize {
    pub use piezoid_numerics::optimize::{Minimum, Reason};

    /// Particle swarms.
    pub mod swarm {
        pub use piezoid_numerics::optimize::swarm::{GlobalBest, SwarmSettings};
    }
}

/// Simulated actuators, which share no code with the models.
pub mod plant {
    pub use piezoid_twins::{PLANTS, Plant, Preset, Saturation, Spec};
}

/// Measured records.
pub mod record {
    pub use piezoid_records::record::{Record, Units};
}

/// Comparison of models with records.
pub mod validation {
    pub use piezoid_validation::{
        Bin, Floor, Linearity, LoopComparison, Metrics, Offset, Validate, ValidateOptions, Validation, Whiteness,
    };
}

#[doc(no_inline)]
pub use compensation::Compensate;
#[doc(no_inline)]
pub use error::Error;
#[doc(no_inline)]
pub use hammerstein::{Identified, Model};
pub use piezoid_identification::Effort;
pub use piezoid_records::preparation::{PrepareOptions, Trend};
pub use piezoid_verbs::{Identification, IdentifyOptions, Method, Records, StatedVerdict, Verdict, identify};
#[doc(no_inline)]
pub use record::{Record, Units};
#[doc(no_inline)]
pub use system::System;
#[doc(no_inline)]
pub use validation::Validate;

/// The Rust of the book, compiled by `cargo test --doc`.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/first-hour.md")]
struct FirstHour;
