//! Text from a file in a message: in backticks, with control characters escaped, shortened if it is long.

/// Maximum number of characters of a cell or name in a message.
const SHOWN: usize = 40;
/// Maximum number of names in a message.
const LISTED: usize = 12;

/// `` `text` ``, shortened if it is long.
pub(super) fn quoted(text: &str) -> String {
    format!("`{}`", shortened(text))
}

/// The text without backticks, shortened if it is long.
pub(super) fn shortened(text: &str) -> String {
    let mut shown = String::new();
    for c in text.chars().take(SHOWN) {
        if c.is_control() { shown.extend(c.escape_debug()) } else { shown.push(c) }
    }
    let length = text.chars().count();
    if length > SHOWN {
        shown += &format!("... ({length} characters)");
    }
    shown
}

/// `` `a`, `b`, `c` and 7 more``.
pub(super) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names = names.into_iter();
    let shown: Vec<String> = names.by_ref().take(LISTED).map(quoted).collect();
    match names.count() {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_long_is_cut_and_what_is_invisible_is_escaped() {
        assert_eq!(quoted("1.5\u{7}V"), "`1.5\\u{7}V`");
        assert_eq!(quoted(&"x".repeat(100)), format!("`{}... (100 characters)`", "x".repeat(40)));
        assert_eq!(listed(["a", "b"]), "`a`, `b`");
        assert!(listed(["c"; 20]).ends_with("`c` and 8 more"));
    }
}
