//! Tables as plain text.

/// Minimum width of the first column of a table.
const NARROWEST: usize = 12;

/// Rows in columns as wide as necessary: the first column aligned left, the others right. If they are wider than
/// `room`, the first column is narrowed: its cells lose their beginning, because the end of a path is more specific. If
/// this is not enough, each row becomes a block of lines.
pub(crate) fn table(header: &[&str], rows: &[Vec<String>], room: Option<usize>) -> String {
    let width = |k: usize| {
        let cells = rows.iter().filter_map(|r| r.get(k)).map(|c| c.chars().count());
        cells.chain([header[k].chars().count()]).max().unwrap_or(0)
    };
    let mut widths: Vec<usize> = (0..header.len()).map(width).collect();
    let total = |widths: &[usize]| widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1);
    let over = room.map_or(0, |room| total(&widths).saturating_sub(room));
    if let (Some(first), Some(head)) = (widths.first_mut(), header.first()) {
        *first = (*first).min(first.saturating_sub(over).max(NARROWEST).max(head.chars().count()));
    }
    if room.is_some_and(|room| total(&widths) > room) {
        return blocks(header, rows);
    }
    let line = |cells: Vec<&str>| {
        let padded = cells.iter().zip(&widths).enumerate().map(|(k, (cell, &w))| match k {
            0 => format!("{:<w$}", ending(cell, w)),
            _ => format!("{cell:>w$}"),
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_string() + "\n"
    };
    let head = line(header.to_vec());
    let rule = "-".repeat(total(&widths)) + "\n";
    let body = rows.iter().map(|r| line(r.iter().map(String::as_str).collect()));
    [head, rule].into_iter().chain(body).collect()
}

/// Rows as blocks: the first cell, then one line per column with its heading.
fn blocks(header: &[&str], rows: &[Vec<String>]) -> String {
    let width = header.iter().skip(1).map(|head| head.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for row in rows {
        for (k, (head, cell)) in header.iter().zip(row).enumerate() {
            text += &if k == 0 { format!("{head} {cell}\n") } else { format!("  {head:<width$}  {cell}\n") };
        }
    }
    text
}

/// The last `width` characters, marked if some are left out.
fn ending(text: &str, width: usize) -> String {
    let count = text.chars().count();
    if count <= width {
        return text.into();
    }
    let kept: String = text.chars().skip(count - width.saturating_sub(1)).collect();
    format!("…{kept}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = [vec!["5 Hz".into(), "1".into()], vec!["x".into(), "0.25".into()]];
        assert_eq!(table(&["f", "mse"], &rows, None), "f      mse\n----------\n5 Hz     1\nx     0.25\n");
    }

    #[test]
    fn a_long_path_gives_way_to_the_figures() {
        let rows = [vec!["../measured/monday/sine-5hz.csv".into(), "1.0".into()]];
        let text = table(&["file", "rmse"], &rows, Some(24));
        assert_eq!(text, "file                rmse\n------------------------\n…nday/sine-5hz.csv   1.0\n");
        assert!(text.lines().all(|line| line.chars().count() <= 24), "{text}");
    }

    #[test]
    fn in_a_narrow_terminal_each_row_is_a_block() {
        let rows = [vec!["5".into(), "0.01128".into(), "2.391e-6".into()]];
        let text = table(&["f [Hz]", "printed-rule", "held"], &rows, Some(20));
        assert_eq!(text, "f [Hz] 5\n  printed-rule  0.01128\n  held          2.391e-6\n");
    }
}
