//! Converts a cell to a number, or to the reason why it is not a number.

use crate::formats::quote::quoted;

/// Notations for a missing number, besides the `nan` and `inf` that Rust reads: those of Windows, spreadsheets and data
/// frames.
const NOT_FINITE: [&str; 15] = [
    "1.#inf", "1.#nan", "1.#qnan", "1.#snan", "1.#ind", "nan(ind)", "nanq", "na", "n/a", "#n/a", "#num!", "#div/0!",
    "null", "none", "\u{221e}",
];

/// A cell that is not a finite number; [`problem`] gives the reason.
pub(super) struct NotANumber;

/// Reads numbers with the decimal separators that the column separator allows.
pub(super) struct NumberReader {
    /// True if a comma can be a decimal separator, because it does not separate columns.
    comma: bool,
    /// The last cell, with its comma replaced by a point.
    pointed: String,
}

impl NumberReader {
    pub(super) fn new(separator: char) -> Self {
        NumberReader { comma: separator != ',', pointed: String::new() }
    }

    /// Point or comma, if the cell has one and it could be either.
    pub(super) fn decimal_sign(&self, cell: &str) -> Option<char> {
        if self.comma { cell.chars().find(|c| ".,".contains(*c)) } else { None }
    }

    /// The number in a cell.
    pub(super) fn read(&mut self, cell: &str) -> Result<f64, NotANumber> {
        let value = match cell.split_once(',') {
            Some((whole, fraction)) if self.comma => {
                self.pointed.clear();
                self.pointed.extend([whole, ".", fraction]);
                self.pointed.parse::<f64>()
            }
            _ => cell.parse(),
        };
        value.ok().filter(|v| v.is_finite()).ok_or(NotANumber)
    }
}

/// True if a cell would be a number, or a notation for a missing number, in some format.
pub(super) fn looks_numeric(cell: &str) -> bool {
    cell.replacen(',', ".", 1).parse::<f64>().is_ok() || not_finite(cell)
}

/// The reason why a cell is not a number. If the `first` row contains words, it is probably a row of units.
pub(super) fn problem(cell: &str, first: bool) -> String {
    if cell.is_empty() {
        return "the cell is empty: every row needs a number here".into();
    }
    let shown = quoted(cell);
    if looks_numeric(cell) && !cell.contains(',') {
        return format!("{shown} is not a finite number: repair the sample, or end the record above this line");
    }
    if first && !cell.contains(|c: char| c.is_ascii_digit()) {
        return format!(
            "{shown} is not a number: if this is a row of units, delete it and put them into the names (u_V)"
        );
    }
    if looks_numeric(cell) {
        return format!("{shown} is not a number: decimal commas need semicolons or tabs between the columns");
    }
    format!("{shown} is not a number")
}

/// The problem of a column that uses point and comma.
pub(super) fn mixed(cell: &str, sign: char, above: u64) -> String {
    format!(
        "{} has another decimal separator than line {above} (`{sign}`): use one of them throughout, and no thousands \
         separator",
        quoted(cell)
    )
}

/// True if a cell is a notation for a missing number, in any spelling.
fn not_finite(cell: &str) -> bool {
    let unsigned = cell.trim_start_matches(['+', '-']);
    NOT_FINITE.iter().any(|spelling| unsigned.eq_ignore_ascii_case(spelling))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_and_infinity_are_recognised_in_any_spelling() {
        for cell in [
            "nan",
            "NaN",
            "-NAN",
            "inf",
            "-Inf",
            "+Infinity",
            "1e999",
            "-1.#IND",
            "1.#QNAN",
            "#N/A",
            "NULL",
            "\u{221e}",
        ] {
            assert_eq!(
                problem(cell, false),
                format!("`{cell}` is not a finite number: repair the sample, or end the record above this line")
            );
            assert!(NumberReader::new(',').read(cell).is_err());
        }
    }

    #[test]
    fn a_decimal_comma_is_read_where_it_does_not_separate() {
        assert_eq!(NumberReader::new(';').read("-1,5e-3").ok(), Some(-1.5e-3));
        assert!(NumberReader::new(',').read("-1,5").is_err());
        assert!(NumberReader::new(';').read("1.234,5").is_err());
        assert!(NumberReader::new(';').read("1,234,5").is_err());
    }

    #[test]
    fn what_is_not_a_number_is_shown() {
        assert_eq!(problem("", false), "the cell is empty: every row needs a number here");
        assert_eq!(problem("1.5 V", false), "`1.5 V` is not a number");
        assert_eq!(
            problem("[V]", true),
            "`[V]` is not a number: if this is a row of units, delete it and put them into the names (u_V)"
        );
        assert!(problem("1,5", false).contains("need semicolons or tabs"));
        assert!(problem(&"9".repeat(50), false).starts_with("`99"));
        assert!(problem(&"x".repeat(5000), false).len() < 100);
    }
}
