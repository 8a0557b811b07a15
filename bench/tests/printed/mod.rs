//! The tables of docs/, with which tests compare what they measure.

#![allow(dead_code, clippy::expect_used, clippy::panic)] // no test needs all of it; a failing one panics

use std::collections::BTreeMap;

/// The cells of a line of a table.
pub(crate) fn cells(line: &str) -> Vec<String> {
    line.trim_matches('|').split('|').map(|cell| cell.trim().into()).collect()
}

/// The cells of the only row of `page` that begins with these names, by the titles of their columns.
#[track_caller]
pub(crate) fn row(page: &str, names: &[&str]) -> BTreeMap<String, String> {
    let lines: Vec<&str> = page.lines().collect();
    let begins = format!("| {} |", names.join(" | "));
    let rows: Vec<usize> = (0..lines.len()).filter(|k| lines[*k].starts_with(&begins)).collect();
    let [row] = rows[..] else { panic!("{} rows begin with {begins}", rows.len()) };
    let outside = lines[..row].iter().rposition(|line| !line.starts_with('|'));
    let titles = cells(lines[outside.map_or(0, |k| k + 1)]);
    titles.into_iter().zip(cells(lines[row])).collect()
}

/// Asserts that a measured value is the printed one, within half of its last digit.
#[track_caller]
pub(crate) fn assert_printed(what: &str, now: f64, printed: &str) {
    let kept: f64 = printed.parse().unwrap_or_else(|e| panic!("{what}: {printed}: {e}"));
    let decimals = printed.split_once('.').map_or(0, |(_, decimals)| decimals.len() as i32);
    let alike = (now - kept).abs() <= 0.501 * 0.1f64.powi(decimals);
    assert!(alike, "{what}: {now}, the page says {kept}: run `cargo xtask docs`");
}
