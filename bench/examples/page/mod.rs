//! Shared by the examples that write tables into pages of docs/.

#![allow(dead_code)] // no example needs all of it

use std::error::Error;
use std::path::Path;

/// `percent` with two digits; 0 below a millionth of peak-to-peak, `-` if it is not finite.
pub(crate) fn cell(percent: f64) -> String {
    match percent {
        p if !p.is_finite() => "-".into(),
        p if p < 1e-4 => "0".into(),
        p => format!("{p:.*}", (1.0 - p.log10().floor()).clamp(0.0, 5.0) as usize),
    }
}

/// A row of a table.
pub(crate) fn row(cells: &[String]) -> String {
    format!("| {} |\n", cells.join(" | "))
}

/// The paragraphs of `text`, in lines of 120 characters at most.
pub(crate) fn wrapped(text: &str) -> String {
    let mut lines = String::new();
    for paragraph in text.lines() {
        let mut width = 0;
        for word in paragraph.split_whitespace() {
            let n = word.chars().count();
            let gap = if width == 0 {
                ""
            } else if width + 1 + n > 120 {
                "\n"
            } else {
                " "
            };
            width = if gap == " " { width + 1 + n } else { n };
            lines += gap;
            lines += word;
        }
        lines += "\n";
    }
    lines
}

/// Replaces the text in `page` between `<!-- name: written by ... -->` and `<!-- end of name -->`.
pub(crate) fn write(page: &Path, name: &str, table: &str) -> Result<(), Box<dyn Error>> {
    let (from, to) = (format!("<!-- {name}: written by `cargo xtask docs` -->"), format!("<!-- end of {name} -->"));
    let absent = |line: &str| format!("{} has no line {line}", page.display());
    let text = std::fs::read_to_string(page)?;
    let (before, rest) = text.split_once(&from).ok_or_else(|| absent(&from))?;
    let (_, after) = rest.split_once(&to).ok_or_else(|| absent(&to))?;
    Ok(std::fs::write(page, format!("{before}{from}\n{table}{to}{after}"))?)
}
