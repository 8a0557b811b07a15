//! The key of a project folder: other users of this machine can open the port too, but they cannot read this file.

use std::io::Write;
use std::path::Path;

/// The file of the key. The interface gives no file whose name begins with a dot.
const FILE: &str = ".piezoid-key";

/// Bytes of a key.
const LENGTH: usize = 16;

/// The key in the folder, so that a page stays open when the server starts again; else a new one, which is kept there
/// if that is possible.
pub(crate) fn key(folder: &Path) -> std::io::Result<String> {
    let path = folder.join(FILE);
    let valid = |key: &String| key.len() == 2 * LENGTH && key.bytes().all(|digit| digit.is_ascii_hexdigit());
    if let Some(key) = std::fs::read_to_string(&path).ok().filter(valid) {
        return Ok(key);
    }
    let mut bytes = [0; LENGTH];
    getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
    let key: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    // Only the owner may read the temporary file, and so the key.
    let kept = tempfile::Builder::new().prefix(".piezoid-").tempfile_in(folder).and_then(|mut file| {
        file.write_all(key.as_bytes())?;
        file.persist(&path).map_err(|failed| failed.error)
    });
    // Without the file, the key is good until the server ends.
    drop(kept);
    Ok(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_keeps_its_key_for_its_owner() {
        let [one, other] = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        let first = key(one.path()).unwrap();
        assert_eq!((key(one.path()).unwrap(), first.len()), (first.clone(), 32));
        assert_ne!(key(other.path()).unwrap(), first);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(one.path().join(FILE)).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600);
        }
        std::fs::write(one.path().join(FILE), "damaged").unwrap();
        assert_ne!(key(one.path()).unwrap(), first);
    }
}
