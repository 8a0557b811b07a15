//! Versions of contents (RFC 9110, section 13): a tag is a hash, so the same content has the same tag.

use axum::http::HeaderMap;
use sha2::{Digest, Sha256};

/// The tag of what was hashed.
pub(crate) fn tag(hash: Sha256) -> String {
    let digits: String = hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    format!("\"{digits}\"")
}

/// The tag of a content.
pub(crate) fn tag_of(bytes: &[u8]) -> String {
    tag(Sha256::new_with_prefix(bytes))
}

/// True if the header of this name lists the tag; `*` is any. `None` without the header.
fn lists(headers: &HeaderMap, name: &str, present: Option<&str>) -> Option<bool> {
    let mut values = headers.get_all(name).iter().peekable();
    values.peek()?;
    let listed = |value: &str| value.split(',').map(str::trim).any(|one| one == "*" || Some(one) == present);
    Some(present.is_some() && values.any(|value| value.to_str().is_ok_and(listed)))
}

/// True if the sender already has this version.
pub(crate) fn has(headers: &HeaderMap, present: &str) -> bool {
    lists(headers, "if-none-match", Some(present)) == Some(true)
}

/// True if the content may be changed, of which `present` is the tag; `None` if there is none.
pub(crate) fn permits(headers: &HeaderMap, present: Option<&str>) -> bool {
    lists(headers, "if-match", present) != Some(false) && lists(headers, "if-none-match", present) != Some(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_needs_the_version_that_is_there() {
        let headers =
            |name: &'static str, value: &str| HeaderMap::from_iter([(name.parse().unwrap(), value.parse().unwrap())]);
        let tag = tag_of(b"content");
        assert_eq!((tag.len(), tag_of(b"content") == tag, tag_of(b"other") == tag), (34, true, false));
        let known = headers("if-match", &format!("\"a\", {tag}"));
        assert!(permits(&known, Some(&tag)) && !permits(&known, Some("\"b\"")) && !permits(&known, None));
        let any = headers("if-match", "*");
        assert!(permits(&any, Some(&tag)) && !permits(&any, None));
        let new = headers("if-none-match", "*");
        assert!(permits(&new, None) && !permits(&new, Some(&tag)) && has(&new, &tag));
        assert!(permits(&HeaderMap::new(), None) && permits(&HeaderMap::new(), Some(&tag)));
        assert!(!has(&HeaderMap::new(), &tag));
    }
}
