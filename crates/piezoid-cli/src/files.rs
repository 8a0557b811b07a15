//! Files: reads records, writes results. Each file is complete or absent, and those of a verb are new or old together.

use crate::console::Console;
use crate::values::apart;
use anyhow::{Error, Result};
use piezoid_host::files::{self, FileSet};
use piezoid_verbs::{DataFile, File};
use serde_json::Value;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

fn named(path: &Path) -> String {
    path.display().to_string()
}

/// Reads the file at `path` once, because it may be a pipe.
pub(crate) fn read(path: &Path) -> Result<File> {
    Ok(noted(path, files::read(path)?))
}

/// The file of samples at `path`.
pub(crate) fn data(path: &Path) -> Result<DataFile> {
    Ok(noted(path, files::data(path)?))
}

/// The files at these paths, each by [`read`] or [`data`].
pub(crate) fn all<T>(paths: &[PathBuf], one: fn(&Path) -> Result<T>) -> Result<Vec<T>> {
    paths.iter().map(|path| one(path)).collect()
}

/// This file at `path`, with a note if its run was ended before it had written all files of its set.
fn noted<T>(path: &Path, file: T) -> T {
    if let Some(remark) = files::unfinished(path) {
        crate::console::say(&format!("note: {remark}"));
    }
    file
}

/// The results of a verb: files, which are written together, and what goes to stdout, pipes and devices, afterwards.
#[derive(Default)]
pub(crate) struct Results {
    files: FileSet,
    streams: Vec<(PathBuf, Vec<u8>)>,
}

impl Results {
    /// Results in a folder.
    pub(crate) fn of(files: FileSet) -> Self {
        Results { files, ..Results::default() }
    }

    /// With a result for this path, if there is one; - is stdout.
    pub(crate) fn file(self, path: Option<&Path>, content: impl Into<Vec<u8>>) -> Self {
        self.file_with(path, || content)
    }

    /// The same, computed only if there is a path.
    pub(crate) fn file_with<C: Into<Vec<u8>>>(mut self, path: Option<&Path>, content: impl FnOnce() -> C) -> Self {
        let Some(path) = path else { return self };
        let content = content();
        if is_stream(path) {
            self.streams.push((path.into(), content.into()));
        } else {
            self.files = self.files.with(path, content);
        }
        self
    }

    /// With a document.
    pub(crate) fn json(self, path: Option<&Path>, value: &Value) -> Self {
        self.file(path, format!("{value:#}\n"))
    }

    /// With a record, of which `content` makes a file of this name.
    pub(crate) fn record(
        self,
        path: Option<&Path>,
        content: impl FnOnce(&str) -> Result<Vec<u8>, piezoid::Error>,
    ) -> Result<Self> {
        let Some(path) = path else { return Ok(self) };
        let name = named(path);
        let content = content(&name).map_err(|error| crate::flags::failed(error.of(&name)))?;
        Ok(self.file(Some(path), content))
    }

    /// Writes them.
    pub(crate) fn write(self, console: &Console) -> Result<()> {
        self.files.write()?;
        self.streams.iter().try_for_each(|(path, content)| match path == Path::new("-") {
            true => console.print(content),
            false => stream(path, content),
        })
    }
}

/// True for stdout, a pipe or a device, which is written to and not replaced.
pub(crate) fn is_stream(path: &Path) -> bool {
    path == Path::new("-") || fs::metadata(path).is_ok_and(|what| !what.is_file() && !what.is_dir())
}

/// Writes to a pipe or a device.
fn stream(path: &Path, content: &[u8]) -> Result<()> {
    let open = fs::OpenOptions::new().write(true).open(path);
    open.and_then(|mut file| file.write_all(content)).or_else(|error| match error.kind() {
        ErrorKind::BrokenPipe => Ok(()),
        _ => Err(Error::new(error).context(format!("cannot write {}", named(path)))),
    })
}

/// Returns an error, before the work begins, if results would overwrite each other or an input, or if one could not be
/// written. True if none of them goes to stdout, which is then free for text.
pub(crate) fn check(outputs: &[Option<&Path>], inputs: &[&PathBuf]) -> Result<bool> {
    apart(outputs, inputs)?;
    ready(outputs)?;
    Ok(!outputs.contains(&Some(Path::new("-"))))
}

/// Returns an error, before the work begins, if a result could not be written.
pub(crate) fn ready(paths: &[Option<&Path>]) -> Result<()> {
    let named = paths.iter().copied().flatten().filter(|path| *path != Path::new("-"));
    let plain = |path: &&Path| fs::metadata(path).map_or(true, |what| what.is_file() || what.is_dir());
    Ok(named.filter(plain).try_for_each(files::ready)?)
}
