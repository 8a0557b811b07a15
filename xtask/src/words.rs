//! The words of docs/words.md: a name or phrase that another term replaces is not used.

use crate::root;
use crate::tidy::{files, read, shown};

/// Files that are not ours to word, or that have the list.
const APART: [&str; 7] = [
    "docs/words.md",
    "CHANGELOG.md",
    "bench/files/",
    "bench/plants/",
    "fuzz/corpus/",
    "web/dist/",
    "crates/piezoid-serve/page/",
];

/// Uses of what the third column of docs/words.md lists, one line each.
pub(crate) fn dialect() -> Result<Vec<String>, String> {
    let list = read(&root().join("docs/words.md"))?;
    let cells = list.lines().filter_map(|line| line.strip_prefix("| ")?.split(" | ").nth(2));
    let replaced: Vec<&str> = cells.flat_map(|cell| cell.trim_end_matches('|').trim().split(", ")).collect();
    let between = |mark: char| replaced.iter().filter_map(|word| word.strip_prefix(mark)?.strip_suffix(mark)).collect();
    let (names, words): (Vec<&str>, Vec<&str>) = (between('`'), between('"'));
    let mut uses = Vec::new();
    for extension in ["rs", "ts", "tsx", "py", "md"] {
        for file in files(root(), extension) {
            let path = shown(&file);
            if APART.iter().any(|apart| path.starts_with(apart)) {
                continue;
            }
            let text = read(&file)?;
            let in_code = if extension == "md" { String::new() } else { code(&text, extension == "py") };
            for (text, words) in [(&text, &words), (&in_code, &names)] {
                for (k, line) in text.lines().enumerate() {
                    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
                    let used = line.split(|c| !is_part(c)).find(|part| words.contains(part));
                    uses.extend(used.map(|word| format!("{path}:{}: `{word}`, see docs/words.md", k + 1)));
                }
            }
        }
    }
    Ok(uses)
}

/// A text without its strings and comments, which begin with `#` in Python and with `//` elsewhere. Its lines stay.
fn code(text: &str, is_python: bool) -> String {
    let comment = if is_python { "#" } else { "//" };
    let strings = if is_python { ["\"\"\"", "\"", "'"] } else { ["r#\"", "\"", "`"] };
    let (mut kept, mut rest) = (String::new(), text);
    while let Some(c) = rest.chars().next() {
        let skipped = if rest.starts_with(comment) {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if !is_python && rest.starts_with("'\"'") {
            3
        } else if let Some(open) = strings.iter().find(|open| rest.starts_with(**open)) {
            open.len() + length(&rest[open.len()..], if *open == "r#\"" { "\"#" } else { open })
        } else {
            kept.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        };
        kept.extend(rest[..skipped].chars().filter(|c| *c == '\n'));
        rest = &rest[skipped..];
    }
    kept
}

/// Length of a string up to and with its end.
fn length(text: &str, end: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices() {
        if !escaped && text[at..].starts_with(end) {
            return at + end.len();
        }
        escaped = !escaped && c == '\\';
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::code;

    #[test]
    fn strings_and_comments_are_no_names() {
        assert_eq!(code("let a = \"made \\\" made\"; b('\"'); // made\nc", false), "let a = ; b(); \nc");
        assert_eq!(code("let a = r#\"made \" made\"#; /* made\n */ b", false), "let a = ; \n b");
        assert_eq!(code("a = 'made' + \"\"\"made\nmade\"\"\"  # made", true), "a =  + \n  ");
    }
}
