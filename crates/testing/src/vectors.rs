//! The files `operators` of every version: a model of every operator, inputs and outputs, the reference of every
//! language. `bench/src/vectors.rs` writes those of this version.

use crate::golden::document;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The files in a folder, sorted.
fn content(folder: PathBuf) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.sort();
    paths
}

/// The files of all versions, called NAME.json for an operator, and their content.
///
/// ```text
/// model    as in its file
/// step     inputs, outputs
/// ff_step  the same of the causal inverse; null if there is none
/// ```
pub fn vectors() -> Vec<(PathBuf, Value)> {
    let versions = Path::new(env!("CARGO_MANIFEST_DIR")).join("../piezoid/tests/compatibility");
    let folders = content(versions).into_iter().map(|version| version.join("operators"));
    let files = folders.filter(|folder| folder.is_dir()).flat_map(content);
    files.map(|path| (path.clone(), document(&path))).collect()
}
