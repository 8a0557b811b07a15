//! Functions that Python calls. Each file converts the arguments of one subject and calls the library. The interface
//! for users is in `python/piezoid`, with its types.
//!
//! Why: docs/decisions/front-ends-and-serve.md, "Python has a compiled and a typed layer".

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
mod plant;
mod record;
mod samples;
mod study;
mod watch;

/// The compiled part of piezoid.
#[pyo3::pymodule]
mod _piezoid {
    #[pymodule_export]
    use crate::compare::compare;
    #[pymodule_export]
    use crate::compensation::FeedForward;
    #[pymodule_export]
    use crate::control::{control, follow};
    #[pymodule_export]
    use crate::error::PiezoidError;
    #[pymodule_export]
    use crate::export::{export, served, unfinished, write};
    #[pymodule_export]
    use crate::identify::{again, identify};
    #[pymodule_export]
    use crate::linear::{Arx, fit};
    #[pymodule_export]
    use crate::lists::{excite, lists, plan};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::plant::Plant;
    #[pymodule_export]
    use crate::record::{Columns, Record};
    #[pymodule_export]
    use crate::study::study;

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
