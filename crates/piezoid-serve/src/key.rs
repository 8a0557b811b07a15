//! The key of a server: other users of this machine can open the port too, but they cannot read this file.
//!
//! Each start makes a new key, so that a key that anybody has learned opens no later server. And before the page sends
//! anything, the server proves that it has the key: the port may belong to another program by then.

use crate::Shared;
use crate::failure::document;
use axum::extract::{RawQuery, State};
use axum::response::Response;
use hmac::{Hmac, KeyInit, Mac};
use serde_json::json;
use sha2::Sha256;
use std::io::Write;
use std::path::Path;

/// The file of the key. The interface gives no file whose name begins with a dot.
const FILE: &str = ".piezoid-key";

/// Bytes of a key.
const LENGTH: usize = 16;

/// A new key, which is kept in the folder for programs, if that is possible.
pub(crate) fn key(folder: &Path) -> std::io::Result<String> {
    let mut bytes = [0; LENGTH];
    getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
    let key = hex(&bytes);
    // Only the owner may read the temporary file, and so the key.
    let kept = piezoid_host::temporary::secret(folder).and_then(|mut file| {
        file.write_all(key.as_bytes())?;
        file.persist(folder.join(FILE)).map_err(|failed| failed.error)
    });
    // Without the file, the key is good until the server ends.
    drop(kept);
    Ok(key)
}

/// The version, and for a request with `?nonce=` and 32 hexadecimal digits the HMAC-SHA256 (RFC 2104) of these digits
/// under the key.
pub(crate) async fn health(State(server): Shared, RawQuery(query): RawQuery) -> Response {
    let nonce = query.as_deref().and_then(|query| query.strip_prefix("nonce="));
    let valid = |nonce: &&str| nonce.len() == 2 * LENGTH && nonce.bytes().all(|digit| digit.is_ascii_hexdigit());
    document(&match nonce.filter(valid).and_then(|nonce| proof(&server.key, nonce)) {
        Some(proof) => json!({"version": env!("CARGO_PKG_VERSION"), "proof": proof}),
        None => json!({"version": env!("CARGO_PKG_VERSION")}),
    })
}

fn proof(key: &str, nonce: &str) -> Option<String> {
    let mut mac = Hmac::<Sha256>::new_from_slice(key.as_bytes()).ok()?;
    mac.update(nonce.as_bytes());
    Some(hex(&mac.finalize().into_bytes()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_proof_is_the_hmac_of_rfc_4231() {
        // Test case 2.
        let known = "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843";
        assert_eq!(proof("Jefe", "what do ya want for nothing?").unwrap(), known);
    }

    #[test]
    fn each_start_has_a_key_of_its_own_for_the_owner() {
        let one = tempfile::tempdir().unwrap();
        let first = key(one.path()).unwrap();
        assert_eq!((std::fs::read_to_string(one.path().join(FILE)).unwrap(), first.len()), (first.clone(), 32));
        assert_ne!(key(one.path()).unwrap(), first);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(one.path().join(FILE)).unwrap().permissions().mode();
            assert_eq!(mode & 0o777, 0o600);
        }
    }
}
