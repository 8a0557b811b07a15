//! `cargo xtask book [--check]`: the book, from docs/ to target/book.
//!
//! The commands of the chapters are run as they are printed; the figures of the gallery are what these commands draw.
//! With `--check` the picture of the README stays as it is, and the error says whether it would change.

mod chapters;
mod figures;
mod links;

use crate::{build_workspace, built, root};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The picture that README and book share, and the figure that it is.
const PICTURE: (&str, &str) = ("docs/tracking.svg", "control/path-csv.svg");

/// Builds the command, then the book.
pub(crate) fn book() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(2).collect();
    if let Some(unknown) = arguments.iter().find(|argument| *argument != "--check") {
        return Err(format!("there is no `{unknown}`: give --check or nothing"));
    }
    build_workspace()?;
    of_built(!arguments.is_empty())
}

/// The book with the command that is built.
pub(crate) fn of_built(check: bool) -> Result<(), String> {
    available()?;
    let (target, work) = (root().join("target/book"), root().join("target/book-chapters"));
    pages()?;
    let io = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    if work.exists() {
        std::fs::remove_dir_all(&work).map_err(|e| io(&work, e))?;
    }
    chapters::run(&root().join("docs"), &work, &built("piezoid"))?;
    let drawn = target.join("figures");
    figures::collect(&work.join("gallery"), &drawn)?;
    let (kept, drawing) = (root().join(PICTURE.0), drawn.join(PICTURE.1));
    let picture = std::fs::read(&drawing).map_err(|e| io(&drawing, e))?;
    if std::fs::read(&kept).ok().as_ref() != Some(&picture) {
        if check {
            return Err(format!("{} is not as drawn: run `cargo xtask book`", PICTURE.0));
        }
        std::fs::write(&kept, picture).map_err(|e| io(&kept, e))?;
    }
    links::check(&target)?;
    links::check_sources(&["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"])
}

/// The error if mdbook is missing.
pub(crate) fn available() -> Result<(), String> {
    let there = Command::new("mdbook").arg("--version").output().is_ok_and(|o| o.status.success());
    there.then_some(()).ok_or_else(|| "mdbook is missing: install it with `cargo install --locked mdbook`".into())
}

/// Writes the pages; a warning is an error.
fn pages() -> Result<(), String> {
    let mut command = Command::new("mdbook");
    let output = command.arg("build").current_dir(root()).env_remove("RUST_LOG").output().map_err(|e| e.to_string())?;
    let log = String::from_utf8_lossy(&output.stderr);
    let warned = |line: &&str| line.contains("WARN") || line.contains("ERROR");
    match log.lines().find(warned) {
        Some(line) => Err(format!("mdbook build: {line}")),
        None if !output.status.success() => Err(format!("mdbook build: {log}")),
        None => listed(),
    }
}

/// The error if a page of docs/ is not in the book.
fn listed() -> Result<(), String> {
    let docs = root().join("docs");
    let place = |file: &PathBuf| file.strip_prefix(&docs).map(|path| root().join("target/book").join(path));
    let is_in = |file: &PathBuf| place(file).is_ok_and(|page| page.with_extension("html").is_file());
    let pages = crate::tidy::files(&docs, "md").into_iter().filter(|file| !file.ends_with("SUMMARY.md"));
    let left: Vec<String> = pages.filter(|file| !is_in(file)).map(|file| crate::tidy::shown(&file)).collect();
    if left.is_empty() { Ok(()) } else { Err(format!("not in docs/SUMMARY.md: {}", left.join(", "))) }
}
