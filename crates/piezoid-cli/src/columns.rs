//! How data files are read: flags, and a profile that says it once for a rig.

use crate::files;
use crate::flags::{Flags, failed};
use anyhow::Result;
use clap::Args;
use piezoid::formats::ColumnSelection;
use std::path::PathBuf;

/// The flags on data files. A flag counts more than the profile.
#[derive(Args)]
pub(crate) struct Columns {
    #[command(flatten)]
    selection: Flags<ColumnSelection>,
    /// A profile that `piezoid inspect` wrote: columns, units and scales.
    #[arg(long, value_name = "FILE", help_heading = "Data files")]
    profile: Option<PathBuf>,
}

impl Columns {
    /// True if a profile says how files are read.
    pub(crate) fn has_profile(&self) -> bool {
        self.profile.is_some()
    }

    /// What flags and profile say together.
    pub(crate) fn read(&self) -> Result<ColumnSelection> {
        let selection = self.selection.0.clone();
        let Some(path) = &self.profile else { return Ok(selection) };
        let file = files::read(path)?;
        let profile = file.text().and_then(ColumnSelection::from_toml).map_err(|error| failed(error.of(&file.name)))?;
        Ok(selection.or(profile))
    }
}
