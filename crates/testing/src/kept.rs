//! Results that are kept: another version gives the same, unless a change is meant.

use crate::assert_alike;
use std::path::Path;

/// Asserts that a text is like the one in `golden/kept` of this crate, with numbers to six digits. If the environment
/// has `PIEZOID_KEEP`, writes it there instead: after a change that is meant.
#[track_caller]
pub fn assert_kept(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("golden/kept/{name}.txt"));
    let shown = path.display();
    if std::env::var_os("PIEZOID_KEEP").is_some() {
        return std::fs::write(&path, text).unwrap_or_else(|error| panic!("{shown}: {error}"));
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{shown}: {error}"));
    println!("{name}");
    assert_alike(text, &kept, 1e-6, 1e-12);
}
