//! How the rows of a file are written: what separates cells, how many there are, and which hold numbers.
//!
//! A sample of lines is split at tabs, semicolons, commas, bars and spaces. The separator with most numbers in rows of
//! one length is that of the file.

use super::cells::{SPACES, cells};
use super::encoding::lines;
use super::{clock, number};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Number of bytes of a large file that are tried.
const SAMPLE: usize = 1 << 16;
/// Separators, in the order of preference.
const SEPARATORS: [char; 5] = ['\t', ';', ',', '|', SPACES];

/// How the rows of a file are written.
#[derive(Debug, PartialEq)]
pub(super) struct Dialect {
    pub(super) separator: char,
    /// For every cell, true if most rows hold a number, a time of day or a missing number there.
    pub(super) numeric: Vec<bool>,
    /// For every cell, true if most rows hold nothing there.
    empty: Vec<bool>,
    /// True if numbers have decimal commas.
    pub(super) commas: bool,
}

impl Dialect {
    /// The dialect of a text; `None` if no line holds a number.
    pub(super) fn of(text: &str) -> Option<Dialect> {
        let samples = samples(text);
        let mut best = (0, None);
        for separator in SEPARATORS {
            let lines = samples.iter().flat_map(|sample| lines(sample)).filter(|(_, line)| !super::remark(line));
            let rows: Vec<Vec<Cell>> = lines.filter_map(|(_, line)| row(line, separator)).collect();
            // Rows of a length: how many, their numbers less words, and the place of the first.
            let mut lengths: BTreeMap<usize, (usize, usize, Reverse<usize>)> = BTreeMap::new();
            for (at, row) in rows.iter().enumerate() {
                let count = |kind| row.iter().filter(|cell| **cell == kind).count();
                let (numbers, words) = (count(Cell::Number), count(Cell::Word));
                let (rows, score, _) = lengths.entry(row.len()).or_insert((0, 0, Reverse(at)));
                *rows += usize::from(numbers > words);
                *score += (2 * numbers).saturating_sub(words);
            }
            let best_length = lengths.into_iter().max_by_key(|(_, (rows, score, first))| (*rows, *first, *score));
            let Some((width, (_, score, _))) = best_length else { continue };
            if score > best.0 {
                let of_numbers = |row: &&Vec<Cell>| row.len() == width && row.contains(&Cell::Number);
                let rows: Vec<&Vec<Cell>> = rows.iter().filter(of_numbers).collect();
                let numeric = |k: usize| {
                    let count = |kind| rows.iter().filter(|row| row[k] == kind).count();
                    count(Cell::Number) > 0
                        && count(Cell::Number) + count(Cell::Missing) + count(Cell::Empty) > count(Cell::Word)
                };
                let empty = |k: usize| 2 * rows.iter().filter(|row| row[k] == Cell::Empty).count() > rows.len();
                let [numeric, empty] =
                    [&numeric as &dyn Fn(usize) -> bool, &empty].map(|of| (0..width).map(of).collect());
                best = (score, Some(Dialect { separator, numeric, empty, commas: false }));
            }
        }
        let dialect = best.1?;
        let commas = samples.iter().flat_map(|sample| lines(sample)).any(|(_, line)| dialect.has_comma(line));
        Some(Dialect { commas, ..dialect })
    }

    /// True if a number in a row has a decimal comma.
    fn has_comma(&self, line: &str) -> bool {
        let commas =
            || cells(line, self.separator).flatten().any(|cell| matches!(number::read(cell), Some((_, Some(',')))));
        let row = row(line, self.separator);
        row.is_some_and(|row| row.len() == self.width() && row.contains(&Cell::Number)) && commas()
    }

    /// Number of cells in a row, without empty ones at its end.
    pub(super) fn width(&self) -> usize {
        self.numeric.len()
    }

    /// The first cell with numbers.
    pub(super) fn first(&self) -> usize {
        self.numeric.iter().position(|numeric| *numeric).unwrap_or(0)
    }

    /// The last cell with numbers.
    pub(super) fn last(&self) -> usize {
        self.numeric.iter().rposition(|numeric| *numeric).unwrap_or(0)
    }

    /// True if a line is a row: it begins like one, holds at least half of the numbers, and no words in their place.
    pub(super) fn is_row(&self, line: &str) -> bool {
        let Some(row) = row(line, self.separator) else { return false };
        let here = |kind| row.iter().zip(&self.numeric).filter(|(cell, numeric)| **numeric && **cell == kind).count();
        let expected = self.numeric.iter().filter(|numeric| **numeric).count();
        let numbers = here(Cell::Number);
        self.leaves_empty(&row) && numbers > 0 && 2 * numbers >= expected && here(Cell::Word) == 0
    }

    /// True if a line begins like a row: its first number is one.
    pub(super) fn begins_like_a_row(&self, line: &str) -> bool {
        let number = |row: &[Cell]| row.get(self.first()) == Some(&Cell::Number);
        row(line, self.separator).is_some_and(|row| number(&row) && self.leaves_empty(&row))
    }

    /// True if these rows begin with their numbers: 0, 1, 2 or 1, 2, 3.
    pub(super) fn is_numbered<'a>(&self, rows: impl Iterator<Item = &'a str>) -> bool {
        let first = |row: &str| cells(row, self.separator).next()?.ok()?.parse::<u32>().ok();
        let found: Vec<Option<u32>> = rows.take(3).map(first).collect();
        found.len() == 3 && (found == [Some(0), Some(1), Some(2)] || found == [Some(1), Some(2), Some(3)])
    }

    /// True if nothing stands where the rows hold nothing.
    fn leaves_empty(&self, row: &[Cell]) -> bool {
        row.iter().zip(&self.empty).all(|(cell, empty)| !empty || *cell == Cell::Empty)
    }
}

/// What a cell holds.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Cell {
    Number,
    /// A notation for a number that is missing.
    Missing,
    Empty,
    Word,
}

/// The cells of a line without the empty ones at its end; `None` without cells.
fn row(line: &str, separator: char) -> Option<Vec<Cell>> {
    let one = |cell: Result<&str, &str>| match cell {
        // dSPACE marks the first row.
        Ok("" | "trace_values") => Cell::Empty,
        Ok(cell) if number::read(cell).is_some() || clock::read(cell).is_some() => Cell::Number,
        Ok(cell) if number::not_finite(cell) => Cell::Missing,
        _ => Cell::Word,
    };
    let all: Vec<Result<&str, &str>> = cells(line, separator).collect();
    let len = all.iter().rposition(|cell| *cell != Ok("")).map(|last| last + 1)?;
    Some(all[..len].iter().map(|cell| one(*cell)).collect())
}

/// The whole of a small text, or the lines in two parts of a large one: the first of them may be above the rows.
fn samples(text: &str) -> Vec<&str> {
    if text.len() <= 2 * SAMPLE {
        return vec![text];
    }
    let near = |at: usize| (at..text.len()).find(|at| text.is_char_boundary(*at)).unwrap_or(text.len());
    let part = |from: usize| {
        let part = &text[near(from)..near(from + SAMPLE / 2)];
        // The first and the last line are cut.
        let end = |c: char| "\r\n".contains(c);
        let start = part.find(end).map_or(0, |at| at + 1);
        part.get(start..part.rfind(end).unwrap_or(part.len())).unwrap_or(part)
    };
    vec![part(text.len() / 2), part(text.len() - text.len() / 8)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> (char, Vec<bool>) {
        Dialect::of(text).map(|Dialect { separator, numeric, .. }| (separator, numeric)).unwrap()
    }

    #[test]
    fn the_separator_is_the_one_that_gives_most_numbers() {
        for (text, separator, width) in [
            ("a,b\n0,1\n1,2\n", ',', 2),
            ("a;b\n0,5;1,5\n1,0;2,5\n", ';', 2),
            ("a\tb\n0,5\t1,5\n1,0\t2,5\n", '\t', 2),
            ("a b c\n  0.5  1.5 7\n 1 2.5   8\n", SPACES, 3),
            ("a,b,c,\n0, 1, 2,\n1, 2, 3,\n", ',', 3),
            ("\"a\",\"b\"\n\"0,5\",\"1,5\"\n\"1,0\",\"1,7\"\n", ',', 2),
            ("clock,u\n2024-03-05 14:07:09.5,1\n2024-03-05 14:07:10.5,2\n", ',', 2),
            ("u\n1\n2\n", '\t', 1),
        ] {
            assert_eq!(found(text), (separator, vec![true; width]), "{text}");
        }
        assert_eq!(found("t,note,u\n0,ok,1\n1,ok,2\n").1, [true, false, true]);
        assert_eq!(Dialect::of("no numbers,here\nn/a,n/a\n"), None);
    }

    #[test]
    fn a_large_file_is_judged_by_parts_of_it() {
        let text = format!("{}{}", "word;word;1;2;3\n".repeat(5000), "0,1\n".repeat(60_000));
        assert_eq!(found(&text), (',', vec![true; 2]));
        let text = format!("{}{}", "# a picture, in letters\n".repeat(10_000), "0,1\n".repeat(40_000));
        assert_eq!(found(&text), (',', vec![true; 2]), "more above the rows than in them");
    }

    #[test]
    fn a_cell_is_that_of_most_rows() {
        assert_eq!(found("0,x\n1,2\n").1, [true, false], "as many words as numbers");
        assert_eq!(found("0,1,5\n1,nan,5\n2,,5\n3,x,5\n4,x,5\n").1, [true; 3], "more numbers and gaps than words");
        assert_eq!(found("0,nan,1\n1,nan,2\n").1, [true, false, true], "no number");
        let empty = |text: &str| Dialect::of(text).unwrap().empty;
        assert_eq!(empty("0,,1\n1,,2\n2,5,3\n3,5,4\n"), [false; 3], "half of them");
        assert_eq!(empty("0,,1\n1,5,2\n"), [false; 3]);
        assert_eq!(empty("0,,1\n1,,2\n2,,3\n3,5,4\n"), [false, true, false]);
    }

    #[test]
    fn commas_are_decimal_if_a_row_has_one_within_a_number() {
        let commas = |text: &str| Dialect::of(text).unwrap().commas;
        assert!(commas("t;u\n0,5;1\n1;2\n"));
        assert!(!commas("t,u\n0,1\n1,2\n") && !commas("Gain;1,5;x\n0.5;1\n1.5;2\n"));
    }

    #[test]
    fn a_row_has_half_of_the_numbers_and_nothing_where_nothing_belongs() {
        let dialect = |numeric: &[bool], empty: &[bool]| Dialect {
            separator: ',',
            numeric: numeric.to_vec(),
            empty: empty.to_vec(),
            commas: false,
        };
        let six = dialect(&[true; 6], &[false; 6]);
        for (line, expected) in [("1,,2,,,3", true), ("1,,2,nan", false), ("1,2,3,4,x", false), ("1", false)] {
            assert_eq!(six.is_row(line), expected, "{line}");
        }
        let two = dialect(&[true, false], &[false, true]);
        assert!(two.is_row("1,") && two.begins_like_a_row("1,"));
        assert!(!two.is_row("1,note") && !two.begins_like_a_row("1,note") && !two.begins_like_a_row("x,"));
        assert!(!dialect(&[false], &[false]).is_row("x"));
        let numbered = |rows: [&str; 3]| two.is_numbered(rows.into_iter());
        assert!(numbered(["0,5", "1,5", "2,5"]) && numbered(["1", "2", "3"]));
        assert!(!numbered(["0", "2", "4"]) && !numbered(["5", "6", "7"]));
    }
}
