//! Files that are complete or absent: written beside their place and renamed.

use piezoid::{Error, File};
use piezoid_export::{ExportTarget, Exported, LIST, Placement};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes a file. An existing file stays until the new one is complete. A link stays a link; its target is replaced.
///
/// # Errors
/// Returns the reason why the file cannot be written, and what to do.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    replace(&end(path)?, bytes).map_err(|error| unwritable(path, &error))
}

/// Checks that a file can be written, before the work begins.
///
/// # Errors
/// The errors of [`write`].
pub fn ready(path: &Path) -> Result<(), Error> {
    beside(&end(path)?).map(drop).map_err(|error| unwritable(path, &error))
}

/// Writes files into a folder, which is created if it does not exist: all of them, or none.
///
/// # Errors
/// The errors of [`write`].
pub fn write_all(folder: &Path, files: &[File]) -> Result<(), Error> {
    let new = !folder.exists();
    if !new && !folder.is_dir() {
        let folder = folder.display();
        return Err(Error::Content(format!("cannot write into {folder}: it is a file: name a folder")));
    }
    let paths: Vec<PathBuf> = files.iter().map(|file| folder.join(&file.name)).collect();
    if let Some(path) = paths.iter().find(|path| path.is_dir()) {
        let what = "there is a folder of that name: move it, or name another folder";
        return Err(Error::Content(format!("cannot write {}: {what}", path.display())));
    }
    std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    let stage = |(file, path): (&File, &PathBuf)| {
        let staged = beside(path).and_then(|mut staged| staged.write_all(&file.bytes).map(|()| staged));
        staged.map_err(|error| unwritable(path, &error))
    };
    let staged: Result<Vec<_>, _> = files.iter().zip(&paths).map(stage).collect();
    let written = staged.and_then(|staged| {
        let place = |(file, path): (NamedTempFile, &PathBuf)| {
            file.persist(path).map(drop).map_err(|failed| unwritable(path, &failed.error))
        };
        staged.into_iter().zip(&paths).try_for_each(place)
    });
    if written.is_err() && new {
        drop(std::fs::remove_dir_all(folder));
    }
    written
}

/// Writes an export into a folder, which is created if it does not exist: all of it, or nothing.
///
/// # Errors
/// The errors of [`write`], and if the folder holds another export, unless `force` is given.
pub fn write_export(folder: &Path, (target, name): (&str, &str), made: &Exported, force: bool) -> Result<(), Error> {
    let list = std::fs::read(folder.join(LIST)).ok();
    let exists = |file: &str| folder.join(file).exists();
    let placed = made.placed((ExportTarget::find(target)?, name), list.as_deref(), &exists, force);
    let Placement { write, remove } = placed.map_err(|error| error.of(&folder.display().to_string()))?;
    write_all(folder, &write)?;
    remove.iter().map(|file| folder.join(file)).try_for_each(|path| {
        std::fs::remove_file(&path).map_err(|error| {
            let what = "a file of the last export, cannot be removed";
            Error::Content(format!("{}, {what}: {error}: delete it", path.display()))
        })
    })
}

fn end(path: &Path) -> Result<PathBuf, Error> {
    if path.is_dir() {
        let path = path.display();
        return Err(Error::Content(format!("cannot write {path}: this is a folder: name a file in it")));
    }
    Ok(std::fs::canonicalize(path).unwrap_or_else(|_| path.into()))
}

/// Why `path` cannot be written, and what to do.
fn unwritable(path: &Path, error: &io::Error) -> Error {
    let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let why = match error.kind() {
        ErrorKind::NotFound => format!("there is no folder {}: make it first", folder.display()),
        ErrorKind::NotADirectory => format!("{} is not a folder: name a file in a folder", folder.display()),
        ErrorKind::PermissionDenied => format!("the folder {} may not be written to: name another", folder.display()),
        other => other.to_string(),
    };
    Error::Content(format!("cannot write {}: {why}", path.display()))
}

/// A file beside `path`, which is deleted unless it is kept.
///
/// # Errors
/// Returns the error of the file system.
pub fn beside(path: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let folder = path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    builder.prefix(".piezoid-").tempfile_in(folder)
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut beside = beside(path)?;
    beside.write_all(bytes)?;
    beside.persist(path).map_err(|failed| failed.error)?;
    Ok(())
}
