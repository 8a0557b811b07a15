//! How a front end writes the names of options and lists, which the library stores as data; paragraphs as plain text.
//!
//! The help of an option names other options as `{option}`, and the list that its names are from as `{list}`. An error
//! holds the setting that it is about, and the options that resolve it, as names and values.

use serde_json::Value;

/// How a front end writes options and lists.
pub trait Words {
    /// The option of this name.
    fn option(&self, name: &str) -> String;

    /// The text of an option that resolves an error, with its value, which is null if only the user knows it.
    fn remedy(&self, name: &str, value: &Value) -> String;

    /// The setting that an error is about, with its value. It may be no option of the front end.
    fn setting(&self, name: &str, value: &str) -> String {
        format!("{name} = {value}")
    }

    /// The list of this name, such as `drivers`.
    fn list(&self, name: &str) -> String;
}

/// The parts of a text outside and inside braces, in turn.
pub(crate) fn parts(text: &str) -> impl Iterator<Item = (bool, &str)> {
    text.split(['{', '}']).enumerate().map(|(k, part)| (k % 2 == 1, part))
}

/// Breaks a paragraph between words into lines of at most `width` characters. All lines except the first begin with
/// `indent`. Repeated spaces are kept.
pub fn wrapped(text: &str, width: usize, indent: &str) -> String {
    let mut lines = vec![String::new()];
    // Length of the last line; true if it contains a word.
    let (mut length, mut begun) = (0, false);
    for (k, word) in text.split(' ').enumerate() {
        let last = lines.len() - 1;
        let long = word.chars().count();
        if begun && !word.is_empty() && length + 1 + long > width {
            let end = lines[last].trim_end().len();
            lines[last].truncate(end);
            lines.push(format!("{indent}{word}"));
            length = indent.chars().count() + long;
        } else {
            let gap = if k > 0 { " " } else { "" };
            lines[last] += gap;
            lines[last] += word;
            length += gap.len() + long;
            begun |= !word.is_empty();
        }
    }
    lines.join("\n")
}

/// The text with a capital first letter.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paragraphs_break_between_words() {
        assert_eq!(wrapped("* one two three", 8, "  "), "* one\n  two\n  three");
        assert_eq!(wrapped("immeasurable", 4, ""), "immeasurable");
        assert_eq!(wrapped("  a    1.5  2.5  3.5", 14, "       "), "  a    1.5\n       2.5\n       3.5");
    }
}
