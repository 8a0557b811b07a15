//! Failures with an exit status of their own; checks of a command line that the parser cannot do: files must differ,
//! and records have a format that is written.

use Ended::{Cancelled, Misused};
use anyhow::{Result, bail};
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::path::{Path, PathBuf};

/// A failure with an exit status of its own.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Ended {
    /// An error in the command line that the parser cannot find.
    #[error("{0}")]
    Misused(String),
    /// Ctrl-C.
    #[error("{0}")]
    Cancelled(String),
}

/// Exit status after Ctrl-C: 128 and the number of the signal, as in shells.
pub(crate) const CANCELLED: u8 = 130;

impl Ended {
    /// The exit status.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Misused(_) => 2,
            Cancelled(_) => CANCELLED,
        }
    }
}

/// Takes the path of a record to write, whose extension selects its format.
pub(crate) fn record() -> impl TypedValueParser<Value = PathBuf> {
    let writable = |path: PathBuf| piezoid::formats::Table::writable(&path.to_string_lossy()).map(|()| path);
    PathBufValueParser::new().try_map(writable)
}

/// Returns an error if results would overwrite each other or an input file.
pub(crate) fn apart(outputs: &[Option<&Path>], inputs: &[&PathBuf]) -> Result<()> {
    let same = |a: &Path, b: &Path| {
        a == b || std::fs::canonicalize(a).is_ok_and(|a| std::fs::canonicalize(b).is_ok_and(|b| a == b))
    };
    let outputs: Vec<&Path> = outputs.iter().copied().flatten().collect();
    for (k, output) in outputs.iter().enumerate() {
        if outputs[..k].iter().any(|earlier| same(earlier, output)) {
            let place = if *output == Path::new("-") { "stdout".into() } else { output.display().to_string() };
            let what = format!("two results cannot be written to the same file {place}");
            bail!(Misused(format!("{what}: name another file for one of them")));
        }
        if inputs.iter().any(|input| same(input, output)) && output.metadata().is_ok_and(|m| m.is_file()) {
            let what = format!("{} is an input file and would be overwritten", output.display());
            bail!(Misused(format!("{what}: name another file for the result")));
        }
    }
    Ok(())
}
