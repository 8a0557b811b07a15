//! Measured files for several tests.

use crate::skipped;
use std::path::PathBuf;

/// A measured file, such as `picma-p885/model_1Hz.csv`, from `PIEZOID_DATA` or from `../shared/data` beside the
/// workspace. If it is missing, the test is reported as skipped, and fails in CI.
#[track_caller]
pub fn measured(name: &str) -> Option<Vec<u8>> {
    let beside = || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"));
    let path = std::env::var_os("PIEZOID_DATA").map_or_else(beside, PathBuf::from).join(name);
    let bytes = std::fs::read(&path);
    if let Err(error) = &bytes {
        skipped(&format!("no measured data, {name} ({error}): set PIEZOID_DATA to the folder that has it"));
    }
    bytes.ok()
}
