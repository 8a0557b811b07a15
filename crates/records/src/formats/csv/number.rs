//! Converts a cell to a number, or to the reason why it is not a number.
//!
//! Read: `1.5`, `1,5`, `1.234,5`, `1,234.5`, `1 234,5`, `1'234.5`,
//! `1.5D-3`.

use crate::formats::quote::quoted;

/// Notations for a missing number, besides the `nan` and `inf` that Rust reads: those of Windows, spreadsheets, data
/// frames and instruments.
const NOT_FINITE: &[&str] = &[
    "1.#inf", "1.#nan", "1.#qnan", "1.#snan", "1.#ind", "nan(ind)", "nanq", "na", "n/a", "#n/a", "#num!", "#div/0!",
    "null", "none", "over", "overload", "ovl", "---", "--", "\u{221e}",
];

/// The number in a cell, and its decimal separator unless that is the point of a number as Rust writes it. A cell with
/// a comma stands between other separators, or in quotes.
pub(super) fn read(cell: &str) -> Option<(f64, Option<char>)> {
    match cell.parse::<f64>() {
        Ok(value) => Some((value, None)),
        Err(_) => match cell.split_once(' ') {
            // A sign in a column of its own.
            Some((sign @ ("+" | "-"), digits)) => spelled(&format!("{sign}{}", digits.trim_start())),
            _ => spelled(cell),
        },
    }
    .filter(|(value, _)| value.is_finite())
}

/// A number with a decimal comma, with marks between thousands, or with Fortran's exponent.
#[cold]
fn spelled(cell: &str) -> Option<(f64, Option<char>)> {
    // The minus sign of typesetters.
    let minus = cell.strip_prefix('\u{2212}').map(|digits| format!("-{digits}"));
    let cell = minus.as_deref().unwrap_or(cell);
    if !cell.starts_with(|c: char| c.is_ascii_digit() || "+-.,".contains(c)) {
        return None;
    }
    let (mantissa, exponent) = match cell.find(['e', 'E', 'd', 'D']) {
        Some(at) => (&cell[..at], format!("e{}", &cell[at + 1..])),
        None => (cell, String::new()),
    };
    let sign = mantissa.chars().rev().find(|c| ".,".contains(*c));
    let (whole, fraction) = match sign {
        Some(sign) => mantissa.rsplit_once(sign)?,
        None => (mantissa, ""),
    };
    let mark = whole.chars().find(|c| !c.is_ascii_digit() && !"+-".contains(*c));
    let apart = |mark: char| ".,' \u{a0}\u{202f}\u{2019}".contains(mark) && Some(mark) != sign;
    if mark.is_some_and(|mark| !(apart(mark) && in_thousands(whole, mark))) {
        return None;
    }
    let plain = whole.replace(|c: char| Some(c) == mark, "");
    let value = format!("{plain}.{fraction}{exponent}").parse().ok()?;
    Some((value, sign))
}

/// True if this mark stands before every three digits.
fn in_thousands(whole: &str, mark: char) -> bool {
    let mut groups = whole.trim_start_matches(['+', '-']).split(mark);
    let digits = |group: &str| group.bytes().all(|b| b.is_ascii_digit());
    groups.next().is_some_and(|first| (1..=3).contains(&first.len()) && digits(first))
        && groups.all(|group| group.len() == 3 && digits(group))
}

/// True if the comma in a number may stand between thousands: `1,234`.
#[cold]
pub(super) fn may_group(cell: &str) -> bool {
    let digits = cell.trim_start_matches(['+', '-']);
    !digits.starts_with('0') && in_thousands(digits, ',') && digits.contains(',')
}

/// True if a cell would be a number, or a notation for a missing number, in some format.
pub(super) fn looks_numeric(cell: &str) -> bool {
    read(cell).is_some() || not_finite(cell)
}

/// The reason why a cell is not a number.
pub(super) fn problem(cell: &str) -> String {
    match cell {
        "" => "the cell is empty".into(),
        _ if not_finite(cell) => format!("{} is not a finite number", quoted(cell)),
        _ => format!("{} is not a number", quoted(cell)),
    }
}

/// The problem of a column that uses point and comma.
pub(super) fn mixed(cell: &str, sign: char, above: u64) -> String {
    let remedy = "use one of them throughout, and no thousands separator";
    format!("{} has another decimal separator than line {above} (`{sign}`): {remedy}", quoted(cell))
}

/// True if a cell is a notation for a missing number, in any spelling.
pub(super) fn not_finite(cell: &str) -> bool {
    let unsigned = cell.trim_start_matches(['+', '-']);
    cell.parse::<f64>().is_ok_and(|value| !value.is_finite())
        || NOT_FINITE.iter().any(|spelling| unsigned.eq_ignore_ascii_case(spelling) || cell == *spelling)
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
            "OVER",
            "---",
            "\u{221e}",
        ] {
            assert_eq!(problem(cell), format!("`{cell}` is not a finite number"));
            assert!(read(cell).is_none());
        }
    }

    #[test]
    fn a_number_is_read_as_its_country_writes_it() {
        for (cell, expected) in [
            ("-1.5e-3", Some((-1.5e-3, None))),
            ("-1,5e-3", Some((-1.5e-3, Some(',')))),
            ("1,5", Some((1.5, Some(',')))),
            ("1.234,5", Some((1234.5, Some(',')))),
            ("1,234.5", Some((1234.5, Some('.')))),
            ("-12.345.678,5", Some((-12_345_678.5, Some(',')))),
            ("20\u{202f}049,1", Some((20_049.1, Some(',')))),
            ("1'234.5", Some((1234.5, Some('.')))),
            ("2.003120D+01", Some((20.0312, Some('.')))),
            ("1,234,5", None),
            ("1.23,5", None),
            ("12:30", None),
            ("-    0.25", Some((-0.25, Some('.')))),
            ("\u{2212}0.25", Some((-0.25, Some('.')))),
            ("", None),
            (",", None),
            ("1.2.3", None),
        ] {
            assert_eq!(read(cell), expected, "{cell}");
        }
    }

    #[test]
    fn what_is_not_a_number_is_shown() {
        assert_eq!(problem(""), "the cell is empty");
        assert_eq!(problem("1.5 V"), "`1.5 V` is not a number");
        assert!(problem(&"9".repeat(50)).starts_with("`99"));
        assert!(problem(&"x".repeat(5000)).len() < 100);
    }
}
