//! From measured records of a piezo actuator to a model that predicts it, a voltage that makes it follow a path, and
//! code for the machine that drives it.
//!
//! ```
//! use piezoid::{IdentifyOptions, Record, formats::ColumnSelection, identify};
//! use piezoid_export::Export;
//! # use piezoid::{excitation::RisingSine, plant::{Plant, Preset}};
//! # let plant = Plant::named("pl140", 1e-3)?;
//! # let csv = |frequency, n| -> Result<Vec<u8>, piezoid::Error> {
//! #     let u = RisingSine { amplitude: 28.0, frequency, ..RisingSine::default() }.samples(1e-3, n)?;
//! #     let y = plant.run(&u).y.iter().map(|y| 1e6 * y).collect();
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
//! `Solver::InteriorPoint`; without `foreign` the only formats of files are text.
//!
//! The library does no input or output: no files, clock, printing or threads it was not asked for. Seeds are
//! parameters, and the same input gives the same bytes.

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

pub mod compensation;
mod complex;
pub mod control;
pub mod creep;
pub mod driver;
mod elementary;
pub mod error;
pub mod excitation;
pub mod formats;
mod fourier;
pub mod hammerstein;
pub mod hysteresis;
mod identification;
mod intervals;
pub mod linear;
#[doc(hidden)]
pub mod number;
pub mod optimize;
mod options;
pub mod plant;
mod preparation;
#[doc(hidden)]
pub mod program;
pub mod progress;
mod quality;
pub mod record;
#[doc(hidden)]
pub mod series;
mod spline;
pub mod system;
#[cfg(test)]
mod tests;
pub mod validation;
mod verbs;
#[doc(hidden)]
pub mod waveform;
mod words;

pub use error::Error;
pub use hammerstein::{Identified, Model};
pub use identification::{IdentifyOptions, Method, Records, identify};
#[doc(hidden)]
pub use options::rows_of;
pub use options::{OptionKind, OptionRow, Options};
pub use preparation::{PrepareOptions, Trend};
pub use record::{Record, Units};
pub use system::System;
pub use verbs::{
    CompareOptions, Compared, ComparedModel, CompensateOptions, Compensation, ControlOptions, ExciteOptions, Excited,
    File, Identification, ModelComparison, Plan, PlanOptions, PlannedDrive, SimulateOptions, Simulated, TuneOptions,
    Validated, Verdict,
};
#[doc(hidden)]
pub use verbs::{Origin, Source, Step};
#[doc(hidden)]
pub use words::Words;
