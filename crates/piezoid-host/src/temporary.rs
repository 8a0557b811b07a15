//! Temporary files and folders, which a signal removes, and which a later run sweeps if nothing could.

use piezoid_verbs::File;
use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tempfile::{Builder, NamedTempFile, TempDir};

/// What names of temporary files and folders begin with; [`RANDOM`] letters or digits follow.
const FILE: &str = ".piezoid-tmp-";
const FOLDER: &str = "piezoid-tmp-";
const UPLOAD: &str = ".piezoid-upload-";

/// So many that nobody gives such a name to a file of his own.
const RANDOM: usize = 12;

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
    let result = shared(FILE).tempfile_in(folder_of(path))?;
    own.temporary.retain(|path| path.exists());
    own.temporary.push(result.path().into());
    Ok(result)
}

/// A folder for work with these files.
pub(crate) fn folder(files: &[File]) -> io::Result<TempDir> {
    sweep(&std::env::temp_dir(), FOLDER, OLD);
    // Until the files are there, nobody removes the folder.
    let mut own = own();
    let result = named(FOLDER).tempdir()?;
    own.temporary.push(result.path().into());
    files.iter().try_for_each(|file| std::fs::write(result.path().join(&file.name), &file.bytes))?;
    Ok(result)
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
pub(crate) fn forsake(result: &[PathBuf]) {
    let mut own = own();
    remove_empty(result);
    own.folders.retain(|folder| !result.contains(folder));
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

/// A file for what arrives in a folder, which is deleted unless it is kept.
///
/// # Errors
/// Returns the reason why the folder takes no new file.
pub fn upload(folder: &Path) -> io::Result<NamedTempFile> {
    shared(UPLOAD).tempfile_in(folder)
}

/// Removes what arrived in a folder and was not kept, of whatever age: nobody else may receive there.
pub fn sweep_uploads(folder: &Path) {
    sweep(folder, UPLOAD, Duration::ZERO);
}

/// A file that its owner alone may read, which is deleted unless it is kept.
///
/// # Errors
/// Returns the reason why the folder takes no new file.
pub fn secret(folder: &Path) -> io::Result<NamedTempFile> {
    named(FILE).tempfile_in(folder)
}

fn named(prefix: &str) -> Builder<'_, 'static> {
    let mut builder = Builder::new();
    builder.prefix(prefix).rand_bytes(RANDOM);
    builder
}

/// The same, for files that others may read as far as the user allows.
fn shared(prefix: &str) -> Builder<'_, 'static> {
    #[cfg_attr(not(unix), expect(unused_mut))]
    let mut builder = named(prefix);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// Removes what runs left in a folder that could not end in an orderly way.
pub fn sweep_files(folder: &Path) {
    sweep(folder, FILE, OLD);
}

fn sweep(folder: &Path, prefix: &str, age: Duration) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if is_temporary(&entry.file_name(), prefix) && is_left(&path, age) {
            // What belongs to another user stays.
            let _ = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        }
    }
}

fn is_temporary(name: &OsStr, prefix: &str) -> bool {
    let random = name.to_str().and_then(|name| name.strip_prefix(prefix));
    random.is_some_and(|rest| rest.len() == RANDOM && rest.bytes().all(|b| b.is_ascii_alphanumeric()))
}

/// True for files and folders, not links, of at least this age.
fn is_left(path: &Path, age: Duration) -> bool {
    let Ok(what) = std::fs::symlink_metadata(path) else { return false };
    let since = what.modified().ok().and_then(|time| time.elapsed().ok());
    !what.is_symlink() && since.is_some_and(|since| since >= age)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::{File, create_dir, write};
    use std::time::SystemTime;

    #[test]
    fn only_what_runs_left_is_swept() {
        let home = tempfile::tempdir().unwrap();
        let result = [beside(&mut own(), &home.path().join("x")), upload(home.path()), secret(home.path())];
        let left = result.map(|file| file.unwrap().keep().unwrap().1);
        let others = [".piezoid-config", ".piezoid-backup", ".piezoid-tmp-notes", ".piezoid-upload-of-monday"];
        let others = others.map(|name| home.path().join(name));
        others.iter().for_each(|path| write(path, "a user's").unwrap());
        let folders = ["piezoid-models", "piezoid-tmp-folder"].map(|name| home.path().join(name));
        folders.iter().for_each(|path| create_dir(path).unwrap());
        sweep_files(home.path());
        assert!(left.iter().all(|path| path.exists()), "none is an hour old");
        let hours_ago = SystemTime::now() - 2 * OLD;
        left.iter().chain(&others).for_each(|path| File::open(path).unwrap().set_modified(hours_ago).unwrap());
        sweep_files(home.path());
        sweep(home.path(), FOLDER, Duration::ZERO);
        assert_eq!([0, 1, 2].map(|k| left[k].exists()), [false, true, false]);
        sweep_uploads(home.path());
        assert!(!left[1].exists() && others.iter().chain(&folders).all(|path| path.exists()));
    }
}
