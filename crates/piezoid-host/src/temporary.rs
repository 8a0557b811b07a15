//! Temporary files and folders, which a signal removes, and which a later run sweeps if nothing could.

use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tempfile::{Builder, NamedTempFile, TempDir};

/// What names of temporary files and folders begin with; six letters or digits follow.
const FILE: &str = ".piezoid-";
const FOLDER: &str = "piezoid-";

/// Age from which a temporary file belongs to no run that is alive.
const OLD: Duration = Duration::from_secs(3600);

/// What this process has made and not finished. Who holds it makes or places files; others wait.
static OWN: Mutex<Own> = Mutex::new(Own { temporary: Vec::new(), folders: Vec::new() });

#[derive(Debug)]
pub(crate) struct Own {
    /// Temporary files and folders.
    temporary: Vec<PathBuf>,
    /// Folders of results, each after the one that it is in.
    folders: Vec<PathBuf>,
}

pub(crate) fn own() -> MutexGuard<'static, Own> {
    OWN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the temporary files and folders of this process, and folders that it made and put nothing into, before it
/// ends: it cannot make or place files afterwards. A set of files that is being placed is placed first.
pub fn abandon() {
    let own = own();
    for path in &own.temporary {
        // What is placed is not there any more.
        let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
    }
    remove_empty(&own.folders);
    std::mem::forget(own);
}

/// A file beside `path`, which is deleted unless it is kept.
pub(crate) fn beside(own: &mut Own, path: &Path) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let made = builder.prefix(FILE).tempfile_in(folder_of(path))?;
    own.temporary.retain(|path| path.exists());
    own.temporary.push(made.path().into());
    Ok(made)
}

/// A folder for work.
pub(crate) fn folder() -> io::Result<TempDir> {
    sweep(&std::env::temp_dir(), FOLDER);
    let mut own = own();
    let made = Builder::new().prefix(FOLDER).tempdir()?;
    own.temporary.push(made.path().into());
    Ok(made)
}

/// Makes a folder and those that it is in. Returns those that were not there, to be [forsaken](forsake).
pub(crate) fn make(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut own = own();
    let is_new = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let mut new: Vec<PathBuf> = folder.ancestors().take_while(is_new).map(PathBuf::from).collect();
    new.reverse();
    std::fs::create_dir_all(folder).inspect_err(|_| remove_empty(&new))?;
    own.folders.extend_from_slice(&new);
    Ok(new)
}

/// Removes those of these folders that are still empty; the others are finished.
pub(crate) fn forsake(made: &[PathBuf]) {
    let mut own = own();
    remove_empty(made);
    own.folders.retain(|folder| !made.contains(folder));
}

/// Removes empty folders, each after what is in it.
fn remove_empty(folders: &[PathBuf]) {
    for folder in folders.iter().rev() {
        // Others are not removed.
        let _ = std::fs::remove_dir(folder);
    }
}

/// The folder of a file.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
}

/// Removes what runs left in a folder that could not end in an orderly way.
pub(crate) fn sweep_files(folder: &Path) {
    sweep(folder, FILE);
}

fn sweep(folder: &Path, prefix: &str) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if is_temporary(&entry.file_name(), prefix) && is_left(&path) {
            // What belongs to another user stays.
            let _ = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        }
    }
}

fn is_temporary(name: &OsStr, prefix: &str) -> bool {
    let random = name.to_str().and_then(|name| name.strip_prefix(prefix));
    random.is_some_and(|rest| rest.len() == 6 && rest.bytes().all(|b| b.is_ascii_alphanumeric()))
}

/// True for files and folders, not links, that nobody has written to for long.
fn is_left(path: &Path) -> bool {
    let Ok(what) = std::fs::symlink_metadata(path) else { return false };
    let age = what.modified().ok().and_then(|time| time.elapsed().ok());
    !what.is_symlink() && age.is_some_and(|age| age > OLD)
}
