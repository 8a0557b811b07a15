//! The project that a report links to.

use piezoid::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_report::page::Address;

options! {
    /// The project of a call that writes a report.
    pub(crate) struct ProjectOptions {
        /// Address of the page that has the project open, for a link to it.
        project: Option<String> = None, OptionRow::new(OptionKind::Text("ADDRESS"));
    }
}

impl ProjectOptions {
    /// The address. A wrong one is an error before the work of a report, not after it.
    pub(super) fn address(&self) -> Result<Option<Address>, Error> {
        self.project.as_deref().map(str::parse).transpose()
    }
}
