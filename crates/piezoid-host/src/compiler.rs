//! The C compiler of this machine, for exports that contain a library.

use piezoid::{Error, File};
use piezoid_export::Compiler;
use std::ffi::OsString;
use std::process::Command;

/// The compiler `cc`, on platforms where it always builds the same library from the same sources: on Linux.
pub fn here() -> Option<Compiler> {
    let platform = match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => "x86_64-linux",
        ("linux", "aarch64") => "aarch64-linux",
        _ => return None,
    };
    let there = Command::new("cc").arg("--version").output().is_ok_and(|told| told.status.success());
    there.then_some(Compiler { platform, run: library })
}

/// C99 without fused multiply-adds, position-independent; only the marked functions are visible.
const FLAGS: &[&str] = &["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden"];

/// No symbols and no build identifier: nothing depends on place or time.
const PLAIN: &[&str] = &["-s", "-Wl,--build-id=none"];

/// Compiles in a temporary folder. File names are given without a folder, so the library contains no path.
fn library(files: &[File]) -> Result<Vec<u8>, Error> {
    let failed = |error: std::io::Error| Error::Content(format!("the C compiler could not be run: {error}"));
    let folder = tempfile::Builder::new().prefix("piezoid-").tempdir().map_err(failed)?;
    for file in files {
        std::fs::write(folder.path().join(&file.name), &file.bytes).map_err(failed)?;
    }
    let sources = files.iter().filter(|file| file.name.ends_with(".c")).map(|file| OsString::from(&file.name));
    let mut cc = Command::new("cc");
    cc.current_dir(folder.path()).args(FLAGS).args(PLAIN).args(sources).args(["-o", "library"]);
    let told = cc.output().map_err(failed)?;
    if !told.status.success() {
        let why = String::from_utf8_lossy(&told.stderr);
        let first = why.lines().find(|line| line.contains("error")).unwrap_or("it did not say why");
        return Err(Error::Content(format!("the C compiler refuses them: {first}")));
    }
    std::fs::read(folder.path().join("library")).map_err(failed)
}
