//! Files: reads records, writes results. A file is complete or absent: it is written beside its place and then renamed.

use anyhow::{Error, Result, anyhow};
use piezoid::File;
use piezoid_host::files;
use serde_json::Value;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

fn named(path: &Path) -> String {
    path.display().to_string()
}

/// Reads the file at `path` once, because it may be a pipe.
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

/// Reads the files at these paths.
pub(crate) fn read_all<'p>(paths: impl IntoIterator<Item = &'p PathBuf>) -> Result<Vec<File>> {
    paths.into_iter().map(|path| read(path)).collect()
}

/// Writes a file beside its place and then renames it; `-` is stdout.
pub(crate) fn write(
    path: &Path,
    content: &(impl AsRef<[u8]> + ?Sized),
    console: &crate::console::Console,
) -> Result<()> {
    let content = content.as_ref();
    if path == Path::new("-") {
        return console.print(content);
    }
    match std::fs::metadata(path) {
        // A pipe or a device is written to and not replaced.
        Ok(what) if !what.is_file() && !what.is_dir() => {
            let mut open = std::fs::OpenOptions::new();
            return open.write(true).open(path).and_then(|mut file| file.write_all(content)).or_else(
                |error| match error.kind() {
                    ErrorKind::BrokenPipe => Ok(()),
                    _ => Err(Error::new(error).context(format!("cannot write {}", named(path)))),
                },
            );
        }
        _ => {}
    }
    Ok(files::write(path, content)?)
}

/// Writes a record, of which `content` makes a file of this name.
pub(crate) fn write_record(
    path: &Path,
    content: impl FnOnce(&str) -> Result<Vec<u8>, piezoid::Error>,
    console: &crate::console::Console,
) -> Result<()> {
    let name = named(path);
    write(path, &content(&name).map_err(|error| crate::flags::failed(error.of(&name)))?, console)
}

/// Returns an error, before the work begins, if a result could not be written.
pub(crate) fn ready(paths: &[Option<&Path>]) -> Result<()> {
    let named = paths.iter().copied().flatten().filter(|path| *path != Path::new("-"));
    let plain = |path: &&Path| std::fs::metadata(path).map_or(true, |what| what.is_file() || what.is_dir());
    Ok(named.filter(plain).try_for_each(files::ready)?)
}

/// Writes a machine-readable result to the path of `--json`.
pub(crate) fn write_json(path: Option<&Path>, value: &Value, console: &crate::console::Console) -> Result<()> {
    match path {
        Some(path) => write(path, &format!("{value:#}\n"), console),
        None => Ok(()),
    }
}

/// The command line without folders: the same work gives the same bytes in every folder.
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
