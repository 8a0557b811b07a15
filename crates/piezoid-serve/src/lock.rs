//! One folder, one server: versions of files are compared in one process.

use piezoid::Error;
use piezoid_host::files::lock;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::time::Duration;

/// The file that is locked, with the address of the server. The operating system unlocks it however the server ends.
const FILE: &str = ".piezoid-lock";

/// How long a server that is ending may keep the lock.
const PATIENCE: Duration = Duration::from_secs(1);

/// The lock of a folder, held until this is dropped. `None` where a lock is neither possible nor needed.
pub(crate) struct Lock(Option<File>);

impl Lock {
    /// Locks a folder. One that takes no new files needs no lock: no server can change it.
    ///
    /// # Errors
    /// Returns an error if another server has it, with the address of that one, or if the folder cannot be locked.
    pub(crate) fn of(folder: &Path) -> Result<Self, Error> {
        let failed = |e| Error::Content(format!("the project folder {} cannot be locked: {e}", folder.display()));
        let path = folder.join(FILE);
        // The address is written into it.
        if std::fs::symlink_metadata(&path).is_ok_and(|what| !what.is_file()) {
            let path = path.display();
            return Err(Error::Content(format!(
                "{path} is no lock of `piezoid serve`: delete it, or name another folder"
            )));
        }
        let mut open = OpenOptions::new();
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut open, 0o600);
        let mut file = match open.read(true).write(true).create(true).truncate(false).open(&path) {
            Ok(file) => file,
            Err(e) if is_refused(&e) && !path.exists() => return Ok(Lock(None)),
            Err(e) => return Err(failed(e)),
        };
        match lock(&file, PATIENCE) {
            Ok(()) => Ok(Lock(Some(file))),
            // The file system has no locks.
            Err(TryLockError::Error(e)) if e.kind() == ErrorKind::Unsupported => Ok(Lock(None)),
            Err(TryLockError::Error(e)) => Err(failed(e)),
            Err(TryLockError::WouldBlock) => {
                let mut address = String::new();
                // Without the address, the folder says enough.
                let _ = file.read_to_string(&mut address);
                let at = if address.is_empty() { String::new() } else { format!(" at {}", address.trim()) };
                let folder = folder.display();
                Err(Error::Content(format!(
                    "another `piezoid serve` has the project folder {folder}{at}: use that one, or end it first"
                )))
            }
        }
    }

    /// True if no other server uses the folder.
    pub(crate) fn is_held(&self) -> bool {
        self.0.is_some()
    }

    /// Says where the server is, for the next that wants the folder.
    pub(crate) fn tell(&mut self, address: &str) {
        // The address is only for a message.
        let _ = self.0.as_mut().map(|file| file.set_len(0).and_then(|()| file.write_all(address.as_bytes())));
    }
}

/// True if new files cannot be made.
fn is_refused(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_server_until_that_ends() {
        let folder = tempfile::tempdir().unwrap();
        let mut first = Lock::of(folder.path()).unwrap();
        first.tell("http://127.0.0.1:8642/");
        let refused = Lock::of(folder.path()).err().unwrap().to_string();
        assert!(refused.contains("at http://127.0.0.1:8642/: use that one"), "{refused}");
        drop(first);
        assert!(Lock::of(folder.path()).is_ok());
    }

    #[test]
    #[cfg(unix)]
    fn a_link_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let victim = folder.path().join("victim");
        std::fs::write(&victim, "precious").unwrap();
        std::os::unix::fs::symlink(&victim, folder.path().join(FILE)).unwrap();
        assert!(Lock::of(folder.path()).err().unwrap().to_string().contains("is no lock of `piezoid serve`"));
        assert_eq!(std::fs::read_to_string(&victim).unwrap(), "precious");
    }
}
