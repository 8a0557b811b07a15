//! docs/evidence.md: errors on measured actuators. The records are not in this repository: they are in a folder for
//! each actuator, below the folder that PIEZOID_DATA names, or below `../shared/data` beside the checkout.

mod mirror;
pub mod stack;

use std::error::Error;
use std::path::{Path, PathBuf};

/// An actuator: the folder of its records, and what writes its section.
type Actuator = (&'static str, fn(&Path, &Path) -> Result<(), Box<dyn Error>>);

const ACTUATORS: [Actuator; 2] = [("picma-p885", stack::write), ("fsm", mirror::write)];

/// The folder of measured records.
pub fn data() -> PathBuf {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data"));
    std::env::var_os("PIEZOID_DATA").map_or_else(beside, PathBuf::from)
}

/// Writes the tables into evidence.md of this folder, and its figures beside it. An actuator without records keeps its
/// section; this is said.
pub fn write(docs: &Path) -> Result<(), Box<dyn Error>> {
    for (name, section) in ACTUATORS {
        let folder = data().join(name);
        if folder.is_dir() {
            section(&folder, docs)?;
        } else {
            let remedy = "its section of docs/evidence.md stays as it is; set PIEZOID_DATA to the folder that has it";
            eprintln!("SKIPPED: {name}: there is no folder {}: {remedy}", folder.display());
        }
    }
    Ok(())
}
