//! What Python calls: one file a subject, each of which converts and calls the library. What it is to a user of Python
//! stands in `python/piezoid`, beside its types.

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
    use crate::compensation::FeedForward;
    #[pymodule_export]
    use crate::control::{control, follow};
    #[pymodule_export]
    use crate::error::PiezoidError;
    #[pymodule_export]
    use crate::export::{export, export_options, write};
    #[pymodule_export]
    use crate::identify::{identify, identify_options};
    #[pymodule_export]
    use crate::linear::{Arx, fit};
    #[pymodule_export]
    use crate::lists::{excite, lists};
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
