//! Functions that Python calls. Each file converts the arguments of one subject and calls the library. The interface
//! for users is in `python/piezoid`, with its types.
//!
//! Why: docs/decisions/front-ends-and-serve.md, "Python has a compiled and a typed layer".

mod campaign;
mod compare;
mod compensation;
mod control;
mod error;
mod export;
mod identify;
mod json;
mod linear;
mod lists;
mod model;
mod online;
mod plant;
mod record;
mod samples;
mod study;
mod timing;
mod watch;

/// The compiled part of piezoid.
#[pyo3::pymodule]
mod _piezoid {
    #[pymodule_export]
    use crate::{
        campaign::campaign,
        compare::{compare, contest, split},
        compensation::FeedForward,
        control::{control, follow},
        error::PiezoidError,
        export::{export, served, unfinished, write},
        identify::{again, identify, stand_in},
        linear::{Arx, fit},
        lists::{excite, lists, plan},
        model::Model,
        online::Online,
        plant::Plant,
        record::{Columns, Record},
        study::study,
        timing::timing,
    };

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
