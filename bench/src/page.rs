//! Tables in pages of docs/: written between two comments, and read back by the tests that repeat their numbers.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

/// `percent` with two digits; 0 below a millionth of peak-to-peak, `-` if it is not finite.
pub fn cell(percent: f64) -> String {
    match percent {
        p if !p.is_finite() => "-".into(),
        p if p < 1e-4 => "0".into(),
        p => format!("{p:.*}", (1.0 - p.log10().floor()).clamp(0.0, 5.0) as usize),
    }
}

/// A row of a table.
pub fn row(cells: impl IntoIterator<Item = impl ToString>) -> String {
    let cells: Vec<String> = cells.into_iter().map(|cell| cell.to_string()).collect();
    format!("| {} |\n", cells.join(" | "))
}

/// The head of a table: the first columns hold so many `words`, the others numbers.
pub fn head(titles: impl IntoIterator<Item = impl ToString>, words: usize) -> String {
    let titles: Vec<_> = titles.into_iter().collect();
    let rule = "---|".repeat(words) + &"--:|".repeat(titles.len() - words);
    format!("{}|{rule}\n", row(titles))
}

/// The paragraphs of `text`, in lines of 120 characters at most.
pub fn wrapped(text: &str) -> String {
    text.lines().map(|paragraph| piezoid_numerics::words::wrapped(paragraph, 120, "") + "\n").collect()
}

/// Replaces the text in `page` between `<!-- name: written by ... -->` and `<!-- end of name -->`.
pub fn write(page: &Path, name: &str, table: &str) -> Result<(), Box<dyn Error>> {
    let (from, to) = (format!("<!-- {name}: written by "), format!("<!-- end of {name} -->"));
    let absent = |line: &str| format!("{} has no line {line}", page.display());
    let text = std::fs::read_to_string(page)?;
    let (before, rest) = text.split_once(&from).ok_or_else(|| absent(&from))?;
    let (by, rest) = rest.split_once('\n').ok_or_else(|| absent(&to))?;
    let (_, after) = rest.split_once(&to).ok_or_else(|| absent(&to))?;
    Ok(std::fs::write(page, format!("{before}{from}{by}\n{table}{to}{after}"))?)
}

/// The cells of a line of a table.
pub fn cells(line: &str) -> Vec<String> {
    line.trim_matches('|').split('|').map(|cell| cell.trim().into()).collect()
}

/// The cells of the only row of `page` that begins with these names, by the titles of their columns.
pub fn printed(page: &str, names: &[&str]) -> Result<BTreeMap<String, String>, String> {
    let lines: Vec<&str> = page.lines().collect();
    let begins = format!("| {} |", names.join(" | "));
    let rows: Vec<usize> = (0..lines.len()).filter(|k| lines[*k].starts_with(&begins)).collect();
    let [row] = rows[..] else { return Err(format!("{} rows begin with {begins}", rows.len())) };
    let outside = lines[..row].iter().rposition(|line| !line.starts_with('|'));
    let titles = cells(lines[outside.map_or(0, |k| k + 1)]);
    Ok(titles.into_iter().zip(cells(lines[row])).collect())
}

/// Whether a measured value is the printed one, within half of its last digit.
pub fn same(now: f64, printed: &str) -> Result<(), String> {
    let kept: f64 = printed.parse().map_err(|e| format!("{printed}: {e}"))?;
    let decimals = printed.split_once('.').map_or(0, |(_, decimals)| decimals.len() as i32);
    let alike = (now - kept).abs() <= 0.501 * 0.1f64.powi(decimals);
    if alike { Ok(()) } else { Err(format!("{now}, the page says {kept}: run `cargo xtask generate docs`")) }
}
