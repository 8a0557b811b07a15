//! Files: records in, results out. What is written is whole or not there: it is written beside and renamed.

use anyhow::{Error, Result, anyhow};
use piezoid::File;
use piezoid_host::files;
use serde_json::Value;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

fn named(path: &Path) -> String {
    path.display().to_string()
}

/// The file at `path`, read once: it may be a pipe.
pub(crate) fn read(path: &Path) -> Result<File> {
    let bytes = std::fs::read(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => anyhow!("{}: there is no such file: check its name and folder", named(path)),
        ErrorKind::PermissionDenied => {
            anyhow!("{}: no permission to read this file: check its permissions", named(path))
        }
        _ if path.is_dir() => anyhow!("{}: this is a folder: name a file in it", named(path)),
        _ => Error::new(error).context(format!("cannot read {}", named(path))),
    });
    Ok(File::new(named(path), bytes?))
}

/// The files at these paths.
pub(crate) fn read_all(paths: &[PathBuf]) -> Result<Vec<File>> {
    paths.iter().map(|path| read(path)).collect()
}

/// Writes a file beside its place and renames it there; `-` is stdout.
pub(crate) fn write(path: &Path, text: &str, console: &crate::console::Console) -> Result<()> {
    if path == Path::new("-") {
        return console.print(text);
    }
    match std::fs::metadata(path) {
        // A pipe or a device stays what it is.
        Ok(what) if !what.is_file() && !what.is_dir() => {
            let mut open = std::fs::OpenOptions::new();
            return open.write(true).open(path).and_then(|mut file| file.write_all(text.as_bytes())).or_else(|error| {
                match error.kind() {
                    ErrorKind::BrokenPipe => Ok(()),
                    _ => Err(Error::new(error).context(format!("cannot write {}", named(path)))),
                }
            });
        }
        _ => {}
    }
    Ok(files::write(path, text.as_bytes())?)
}

/// Refuses results that could not be written when the work is done: before it is begun.
pub(crate) fn ready(paths: &[Option<&Path>]) -> Result<()> {
    let named = paths.iter().copied().flatten().filter(|path| *path != Path::new("-"));
    let plain = |path: &&Path| std::fs::metadata(path).map_or(true, |what| what.is_file() || what.is_dir());
    Ok(named.filter(plain).try_for_each(files::ready)?)
}

/// Writes a machine-readable result where `--json` says.
pub(crate) fn write_json(path: Option<&Path>, value: &Value, console: &crate::console::Console) -> Result<()> {
    match path {
        Some(path) => write(path, &format!("{value:#}\n"), console),
        None => Ok(()),
    }
}

/// The command as it was given. Folders are left out, so that the same work gives the same bytes wherever it is done.
pub(crate) fn command() -> String {
    let word = |argument: std::ffi::OsString| {
        let argument = argument.to_string_lossy();
        let word = match argument.split_once('=') {
            Some((flag, value)) if flag.starts_with("--") => format!("{flag}={}", short(value)),
            _ => short(&argument),
        };
        if word.is_empty() || word.contains([' ', '\'', '"']) {
            format!("'{}'", word.replace('\'', "'\\''"))
        } else {
            word
        }
    };
    let words: Vec<String> = std::env::args_os().skip(1).map(word).collect();
    format!("piezoid {}", words.join(" "))
}

/// The name of a file without its folder.
fn short(text: &str) -> String {
    match Path::new(text).file_name() {
        Some(name) if text.contains(['/', '\\']) => name.to_string_lossy().into_owned(),
        _ => text.to_string(),
    }
}
