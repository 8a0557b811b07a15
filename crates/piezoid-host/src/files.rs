//! Files that are complete or absent, alone or as a set: written beside their places, then renamed.

use crate::temporary::{Own, beside, folder_of, forsake, make, own, sweep_files};
use piezoid::Error;
use piezoid_export::{EXPORT_LIST_FILE, ExportTarget, Exported, Placement};
use piezoid_verbs::{DataFile, File};
use std::collections::BTreeSet;
use std::fs::TryLockError;
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::NamedTempFile;

/// The file in a folder that names the files of a set while they are put in place.
pub const UNFINISHED: &str = "piezoid-unfinished.txt";

/// What it says, before the names.
const ABOUT: &str = "piezoid was ended while it replaced these files: some may be new and others old.
Repeat the command that writes them all; it removes this file.
";

/// Longest chain of links that is followed.
const LINKS: usize = 40;

/// How long another run may place its files in a folder before that is thought to be locked for another reason.
const PATIENCE: Duration = Duration::from_secs(10);

/// Files that replace older ones together.
///
/// All are written beside their places before the first is renamed. From the first to the last rename, signals wait
/// (see [`abandon`](crate::temporary::abandon)), and a file [`UNFINISHED`] names them, which stays if the process is
/// ended by force. Of two runs at once, one places its files after the other, on Unix. It does not do: wait until the
/// files are on the disk, so after a loss of power they may be old, new or empty.
#[derive(Default)]
pub struct FileSet {
    files: Vec<(PathBuf, Vec<u8>)>,
    /// Files of an older set that are removed.
    remove: Vec<PathBuf>,
    /// The folder of a set, which is created if it does not exist.
    folder: Option<PathBuf>,
}

/// Reads a file, once: it may be a pipe.
///
/// # Errors
/// Returns the reason why it cannot be read, and what to do.
pub fn read(path: &Path) -> Result<File, Error> {
    let mut bytes = Vec::new();
    open(path)?.read_to_end(&mut bytes).map_err(|error| unreadable(path, &error))?;
    Ok(File::new(path.display().to_string(), bytes))
}

/// A file of samples, which is read in pieces when it is needed; a pipe is read now, because it can be read only once.
///
/// # Errors
/// The errors of [`read`].
pub fn data(path: &Path) -> Result<DataFile, Error> {
    // What is a file under /dev is one that stdin was opened from, at the place where that was read to.
    let is_pipe = path.starts_with("/dev") || !std::fs::metadata(path).is_ok_and(|what| what.is_file());
    if is_pipe {
        return Ok(read(path)?.into());
    }
    open(path)?;
    let (name, place) = (path.display().to_string(), path.to_path_buf());
    Ok(DataFile::new(name, move || Ok(Box::new(std::fs::File::open(&place)?))))
}

fn open(path: &Path) -> Result<std::fs::File, Error> {
    std::fs::File::open(path).map_err(|error| unreadable(path, &error))
}

/// Why `path` cannot be read, and what to do.
fn unreadable(path: &Path, error: &io::Error) -> Error {
    let why = match error.kind() {
        ErrorKind::NotFound => "there is no such file: check its name and folder".to_string(),
        ErrorKind::PermissionDenied => "no permission to read this file: check its permissions".into(),
        _ if path.is_dir() => "this is a folder: name a file in it".into(),
        _ => format!("cannot be read: {error}"),
    };
    Error::Content(why).of(&path.display().to_string())
}

/// Writes a file. An existing file stays until the new one is complete. A link stays a link; its target is replaced.
///
/// # Errors
/// Returns the reason why the file cannot be written, and what to do.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    FileSet::default().with(path, bytes).write()
}

/// The same for a file that `fill` writes piece by piece; an error of `fill` leaves everything as it was.
///
/// # Errors
/// The errors of [`write`] and of `fill`.
pub fn write_in_pieces<T>(path: &Path, fill: impl FnOnce(&mut dyn Write) -> Result<T, Error>) -> Result<T, Error> {
    let (staged, result) = staged(path, fill)?;
    FileSet::default().place(vec![staged])?;
    Ok(result)
}

/// A file beside its place.
type Staged = (NamedTempFile, PathBuf);

/// The file for `path` beside its place, with what `fill` writes, and the result of that.
fn staged<T>(path: &Path, fill: impl FnOnce(&mut dyn Write) -> Result<T, Error>) -> Result<(Staged, T), Error> {
    let place = end(path)?;
    let file = beside(&mut own(), &place);
    let mut file = file.map_err(|error| unwritable(path, &error))?;
    // An error of the file itself does not name the place beside.
    let result = fill(file.as_file_mut())?;
    Ok(((file, place), result))
}

/// Checks that a file can be written, before the work begins.
///
/// # Errors
/// The errors of [`write`].
pub fn ready(path: &Path) -> Result<(), Error> {
    let place = end(path)?;
    sweep_files(folder_of(&place));
    beside(&mut own(), &place).map(drop).map_err(|error| unwritable(path, &error))
}

/// A remark on a file of a run that was ended before it had written all files of its set.
pub fn unfinished(path: &Path) -> Option<String> {
    let place = end(path).ok()?;
    let name = place.file_name()?.to_string_lossy().into_owned();
    named_in(folder_of(&place)).contains(&name).then(|| {
        let path = path.display();
        format!(
            "{path} may be older than other files of its run, which was ended while it replaced them (see {UNFINISHED})"
        )
    })
}

impl FileSet {
    /// Files in a folder, which is created if it does not exist.
    ///
    /// # Errors
    /// Returns an error if the folder, or a file, cannot be made because of what is there.
    pub fn in_folder(folder: &Path, files: &[File]) -> Result<Self, Error> {
        if folder.exists() && !folder.is_dir() {
            let folder = folder.display();
            return Err(Error::Content(format!("cannot write into {folder}: it is a file: name a folder")));
        }
        let files: Vec<_> = files.iter().map(|file| (folder.join(&file.name), file.bytes.clone())).collect();
        if let Some((path, _)) = files.iter().find(|(path, _)| path.is_dir()) {
            return Err(cannot_write(path, "there is a folder of that name: move it, or name another folder"));
        }
        Ok(FileSet { files, folder: Some(folder.into()), remove: Vec::new() })
    }

    /// An export in a folder, which is created if it does not exist.
    ///
    /// # Errors
    /// The errors of [`FileSet::in_folder`], and if the folder holds another export, unless `force` is given.
    pub fn export(folder: &Path, (target, name): (&str, &str), result: &Exported, force: bool) -> Result<Self, Error> {
        let list = std::fs::read(folder.join(EXPORT_LIST_FILE)).ok();
        let exists = |file: &str| folder.join(file).exists();
        let placed = result.placed((ExportTarget::find(target)?, name), list.as_deref(), &exists, force);
        let Placement { write, remove } = placed.map_err(|error| error.of(&folder.display().to_string()))?;
        // As the places of files that are written.
        let home = std::fs::canonicalize(folder).unwrap_or(folder.into());
        let remove = remove.iter().map(|file| home.join(file)).collect();
        Ok(FileSet { remove, ..FileSet::in_folder(folder, &write)? })
    }

    /// The set with another file.
    #[must_use]
    pub fn with(mut self, path: &Path, bytes: impl Into<Vec<u8>>) -> Self {
        self.files.push((path.into(), bytes.into()));
        self
    }

    /// Writes all files, or none.
    ///
    /// # Errors
    /// Returns the reason why a file cannot be written, and what to do.
    pub fn write(self) -> Result<(), Error> {
        let result = match self.folder.as_deref() {
            Some(folder) => make(folder).map_err(|error| unwritable(folder, &error))?,
            None => Vec::new(),
        };
        let written = self.staged().and_then(|staged| self.place(staged));
        forsake(&result);
        written
    }

    /// The files beside their places.
    fn staged(&self) -> Result<Vec<Staged>, Error> {
        let stage = |(path, bytes): &(PathBuf, Vec<u8>)| {
            let fill = |to: &mut dyn Write| to.write_all(bytes).map_err(|error| unwritable(path, &error));
            staged(path, fill).map(|(staged, ())| staged)
        };
        let staged: Vec<Staged> = self.files.iter().map(stage).collect::<Result<_, _>>()?;
        let mut places = BTreeSet::new();
        match staged.iter().find(|(_, place)| !places.insert(place)) {
            Some((_, place)) => Err(cannot_write(place, "two results lead to this file: name another for one of them")),
            None => Ok(staged),
        }
    }

    /// Renames the files to their places, while the marks of their folders name them.
    fn place(&self, staged: Vec<Staged>) -> Result<(), Error> {
        let places: Vec<PathBuf> = staged.iter().map(|(_, place)| place).chain(&self.remove).cloned().collect();
        let folders: BTreeSet<&Path> = places.iter().map(|place| folder_of(place)).collect();
        let locked: Vec<_> = folders.iter().filter_map(|folder| locked(folder)).collect();
        // A file alone needs no mark, but may end an older one.
        let marks = folders.iter().map(|folder| Mark::new(folder, &places));
        let marks: Vec<Mark> = marks.filter(|mark| places.len() > 1 || mark.before != mark.after).collect();
        // Signals wait.
        let mut held = own();
        let mut begun = false;
        let named = marks.iter().try_for_each(|mark| mark.name(&mark.during, &mut held));
        let placed = named.and_then(|()| self.replace(staged, &mut begun));
        let message = match (&placed, begun) {
            (Ok(()), _) => marks.iter().try_for_each(|mark| mark.name(&mark.after, &mut held)),
            (Err(_), false) => marks.iter().try_for_each(|mark| mark.name(&mark.before, &mut held)),
            (Err(_), true) => Ok(()),
        };
        let placed = placed.map_err(|error| match begun {
            true => Error::Content(format!(
                "{error}; some files of this set are new and others old by now, {UNFINISHED} names them: repeat the \
                 command afterwards"
            )),
            false => error,
        });
        drop((held, locked));
        folders.iter().for_each(|folder| sweep_files(folder));
        placed.and(message)
    }

    /// Removes what is no longer of the set before the rename of its list, which says what is. `begun` is set once a
    /// file is not as it was.
    fn replace(&self, staged: Vec<Staged>, begun: &mut bool) -> Result<(), Error> {
        for path in &self.remove {
            gone(std::fs::remove_file(path)).map_err(|error| {
                let what = "a file of the last export, cannot be removed";
                Error::Content(format!("{}, {what}: {error}: delete it", path.display()))
            })?;
            *begun = true;
        }
        for (file, place) in staged {
            file.persist(&place).map_err(|failed| unwritable(&place, &failed.error))?;
            *begun = true;
        }
        Ok(())
    }
}

/// The file that names what is unfinished in a folder: what it names before, while and after a set is placed.
struct Mark {
    path: PathBuf,
    before: BTreeSet<String>,
    during: BTreeSet<String>,
    after: BTreeSet<String>,
}

impl Mark {
    /// The mark for these of the places that are in the folder.
    fn new(folder: &Path, places: &[PathBuf]) -> Self {
        let own = places.iter().filter(|place| folder_of(place) == folder).filter_map(|place| place.file_name());
        let own: BTreeSet<String> = own.map(|name| name.to_string_lossy().into_owned()).collect();
        let before = named_in(folder);
        // A file that is not there, as one that the killed run removed, cannot be taken for another.
        let after = (&before - &own).into_iter().filter(|name| folder.join(name).exists()).collect();
        Mark { path: folder.join(UNFINISHED), during: &before | &own, after, before }
    }

    /// Names these files. Without any there is no mark.
    fn name(&self, names: &BTreeSet<String>, held: &mut Own) -> Result<(), Error> {
        let done = match names.is_empty() {
            true => gone(std::fs::remove_file(&self.path)),
            false => beside(held, &self.path).and_then(|mut mark| {
                mark.write_all(text(names).as_bytes())?;
                mark.persist(&self.path)?;
                Ok(())
            }),
        };
        done.map_err(|error| unwritable(&self.path, &error))
    }
}

/// What is not there needs not be removed.
fn gone(removed: io::Result<()>) -> io::Result<()> {
    removed.or_else(|error| if error.kind() == ErrorKind::NotFound { Ok(()) } else { Err(error) })
}

/// Locks a file or a folder. Waits so long for another process that has it locked.
///
/// # Errors
/// The errors of [`std::fs::File::try_lock`].
pub fn lock(file: &std::fs::File, patience: Duration) -> Result<(), TryLockError> {
    let requested = Instant::now();
    loop {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) if requested.elapsed() < patience => {
                std::thread::sleep(Duration::from_millis(1));
            }
            locked => return locked,
        }
    }
}

/// Has other runs wait until this is dropped. What cannot be locked is not.
fn locked(folder: &Path) -> Option<std::fs::File> {
    let file = std::fs::File::open(folder).ok()?;
    let waited = matches!(lock(&file, PATIENCE), Err(TryLockError::WouldBlock));
    (!waited).then_some(file)
}

fn text(names: &BTreeSet<String>) -> String {
    names.iter().fold(format!("{ABOUT}\n"), |text, name| text + name + "\n")
}

/// The files of a folder whose set is unfinished.
fn named_in(folder: &Path) -> BTreeSet<String> {
    let text = std::fs::read_to_string(folder.join(UNFINISHED)).unwrap_or_default();
    let names = text.strip_prefix(ABOUT).unwrap_or_default().lines();
    names.filter(|name| !name.is_empty()).map(String::from).collect()
}

/// The place of a file: `path`, or where its links lead, also if there is no file yet.
fn end(path: &Path) -> Result<PathBuf, Error> {
    if path.is_dir() {
        return Err(cannot_write(path, "this is a folder: name a file in it"));
    }
    let mut place = path.to_path_buf();
    for _ in 0..LINKS {
        match std::fs::read_link(&place) {
            Ok(next) => place = folder_of(&place).join(next),
            // All places of a folder name it in the same way.
            Err(_) => {
                let folder = std::fs::canonicalize(folder_of(&place)).ok();
                return Ok(folder.and_then(|folder| Some(folder.join(place.file_name()?))).unwrap_or(place));
            }
        }
    }
    Err(cannot_write(path, "it is a link that leads to itself: delete it"))
}

/// Why `path` cannot be written, and what to do.
fn unwritable(path: &Path, error: &io::Error) -> Error {
    let target = std::fs::read_link(path).map_or_else(|_| path.into(), |target| folder_of(path).join(target));
    let folder = folder_of(&target);
    let why = match error.kind() {
        ErrorKind::NotFound if folder.is_dir() => {
            format!("{} takes no new files: name another folder", folder.display())
        }
        ErrorKind::NotFound => format!("there is no folder {}: make it first", folder.display()),
        ErrorKind::NotADirectory => format!("{} is not a folder: name a file in a folder", folder.display()),
        ErrorKind::PermissionDenied => format!("the folder {} may not be written to: name another", folder.display()),
        other => other.to_string(),
    };
    cannot_write(path, &why)
}

fn cannot_write(path: &Path, why: &str) -> Error {
    Error::Content(format!("cannot write {}: {why}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder in which a run was ended while it replaced `m.json` and `r.json`.
    fn marked() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        ["m.json", "r.json"].iter().for_each(|name| std::fs::write(folder.path().join(name), "").unwrap());
        std::fs::write(folder.path().join(UNFINISHED), text(&["m.json", "r.json"].map(String::from).into())).unwrap();
        folder
    }

    #[test]
    fn a_mark_names_what_is_still_unfinished() {
        let folder = marked();
        let [m, r, other] = ["m.json", "r.json", "other"].map(|name| folder.path().join(name));
        write(&other, b"").unwrap();
        FileSet::default().with(&other, "").with(&folder.path().join("more"), "").write().unwrap();
        assert_eq!([&m, &r, &other].map(|path| unfinished(path).is_some()), [true, true, false]);
        write(&m, b"").unwrap();
        assert_eq!([&m, &r, &other].map(|path| unfinished(path).is_some()), [false, true, false]);
        std::fs::remove_file(&r).unwrap();
        FileSet::default().with(&other, "").with(&folder.path().join("more"), "").write().unwrap();
        assert!(!folder.path().join(UNFINISHED).exists());
    }

    #[test]
    fn a_file_that_is_not_filled_leaves_the_older_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.csv");
        let fill = |text: &str, result: Result<(), Error>| {
            write_in_pieces(&path, |to| {
                to.write_all(text.as_bytes()).unwrap();
                result
            })
        };
        fill("old", Ok(())).unwrap();
        assert!(fill("new", Err(Error::Content("overflow".into()))).is_err());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        fill("new", Ok(())).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
    }

    #[test]
    #[cfg(unix)]
    fn links_count_as_the_files_that_they_lead_to() {
        let folder = marked();
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir(path("in")).unwrap();
        std::os::unix::fs::symlink("../m.json", path("in/link")).unwrap();
        assert!(unfinished(&path("in/link")).is_some());
        let both = FileSet::default().with(&path("in/link"), "1").with(&path("m.json"), "2");
        let refused = both.write().unwrap_err().to_string();
        assert!(refused.ends_with("m.json: two results lead to this file: name another for one of them"), "{refused}");
        write(&path("in/link"), b"1").unwrap();
        assert_eq!(std::fs::read(path("m.json")).unwrap(), b"1");
        for (link, target) in [("self", "self"), ("away", "nowhere/x")] {
            std::os::unix::fs::symlink(target, path(link)).unwrap();
            assert!(write(&path(link), b"").is_err() && path(link).is_symlink(), "{link}");
        }
    }

    #[test]
    fn a_set_that_cannot_be_placed_leaves_its_folders_as_they_were() {
        let folder = marked();
        let mark = || std::fs::read_to_string(folder.path().join(UNFINISHED)).unwrap();
        let before = mark();
        let set = FileSet::default().with(&folder.path().join("m.json"), "").with(&folder.path().join("new"), "");
        // A folder is not removed as a file.
        let stuck = folder.path().join("stuck");
        std::fs::create_dir(&stuck).unwrap();
        let failed = FileSet { remove: vec![stuck], ..set }.write().unwrap_err().to_string();
        assert!(failed.contains("stuck, a file of the last export, cannot be removed"), "{failed}");
        assert_eq!(mark(), before);
        let within = FileSet::in_folder(&folder.path().join("a/b"), &[File::new("c/d", "")]).unwrap();
        assert!(within.write().unwrap_err().to_string().contains("there is no folder"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
    }
}
