//! What came of each kind of fault, counted.

use std::collections::BTreeSet;
use std::time::Duration;

/// What came of a case, all of which was checked.
#[derive(Debug, Default)]
pub(super) struct Row {
    pub(super) title: &'static str,
    /// Time from the fault to the end, if it came.
    pub(super) took: Option<Duration>,
    pub(super) is_whole: bool,
    /// Whether the generator was stopped after an error; none where nothing had moved, or no end was in order.
    pub(super) is_stopped: Option<bool>,
    /// True if a voltage was stated that agrees with the log.
    pub(super) is_stated: bool,
}

pub(super) fn printed(rows: &[Row]) -> String {
    let titles: BTreeSet<&str> = rows.iter().map(|row| row.title).collect();
    let head = "| fault | cases | it came | exit 0 | other end | generator stopped | no line to stop it | true voltage \
                stated | longest until the end [s] |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    let line = |title: &str| {
        let of: Vec<&Row> = rows.iter().filter(|row| title == "all" || row.title == title).collect();
        let count = |is: &dyn Fn(&Row) -> bool| of.iter().filter(|row| is(row)).count();
        let [whole, came] = [count(&|row| row.is_whole), count(&|row| row.took.is_some())];
        let [stopped, not] = [true, false].map(|is| count(&|row| row.is_stopped == Some(is)));
        let stated = count(&|row| row.is_stated);
        let longest = of.iter().filter(|row| !row.is_whole).filter_map(|row| row.took).max().unwrap_or_default();
        let (cases, longest) = (of.len(), longest.as_secs_f64());
        let other = cases - whole;
        format!("| {title} | {cases} | {came} | {whole} | {other} | {stopped} | {not} | {stated} | {longest:.2} |\n")
    };
    head.to_string() + &titles.into_iter().chain(["all"]).map(line).collect::<String>()
}
