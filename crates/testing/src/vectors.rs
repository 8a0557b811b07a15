//! The files `operators` of every version: a model of every operator, inputs and outputs, the reference of every
//! language. `bench/src/vectors.rs` writes those of this version.

use serde_json::Value;
use std::path::{Path, PathBuf};

/// The files in a folder.
fn content(folder: PathBuf) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    entries.filter_map(|entry| Some(entry.ok()?.path())).collect()
}

/// The files of all versions: the name of the operator, and the content.
///
/// ```text
/// model    as in its file
/// step     inputs, outputs
/// ff_step  the same of the causal inverse; null if there is none
/// ```
pub fn vectors() -> Vec<(String, Value)> {
    let versions = Path::new(env!("CARGO_MANIFEST_DIR")).join("../piezoid/tests/compatibility");
    let folders = content(versions).into_iter().map(|version| version.join("operators"));
    let files = folders.filter(|folder| folder.is_dir()).flat_map(content);
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let vectors = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        (path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), vectors)
    };
    files.map(read).collect()
}
