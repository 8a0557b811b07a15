//! Text and numbers in SVG and HTML: escaped, with fixed precision and an estimated width.

/// Whether a character is kept in XML: control characters other than white space are not.
pub(crate) fn allowed(c: char) -> bool {
    !(c.is_control() && !"\t\n\r".contains(c) || matches!(c, '\u{fffe}' | '\u{ffff}'))
}

/// Replaces the five markup characters and removes control characters that XML forbids.
pub(crate) fn escape(text: &str) -> String {
    let entities = [("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("\"", "&quot;"), ("'", "&#39;")];
    let text: String = text.chars().filter(|c| allowed(*c)).collect();
    entities.iter().fold(text, |text, (character, entity)| text.replace(character, entity))
}

const MINUS: &str = "\u{2212}";

/// Units with a Greek letter that data formats write in ASCII, and how people read them.
const MICRO: [(&str, &str); 3] = [("um", "\u{b5}m"), ("uV", "\u{b5}V"), ("uA", "\u{b5}A")];

/// A text for people, escaped, its units and numbers [`rendered`].
pub(crate) fn shown(text: &str) -> String {
    escape(&rendered(text))
}

/// A text for people: `um` that stands as a unit is `µm`, and numbers have a true minus. Data and models keep `um` and
/// the hyphen; this is the only place where they are rendered.
pub(super) fn rendered(text: &str) -> String {
    numbers(&units(text))
}

/// The text with true minus signs in its numbers.
fn numbers(text: &str) -> String {
    let number = |piece: &str| {
        let word = piece.trim_end_matches(|c: char| c.is_whitespace() || "()[],.;:%°".contains(c));
        if word.parse::<f64>().is_ok() { piece.replace('-', MINUS) } else { piece.into() }
    };
    text.split_inclusive(|c: char| c.is_whitespace() || "([".contains(c)).map(number).collect()
}

fn units(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('u') {
        let (before, from) = rest.split_at(at);
        out.push_str(before);
        // A unit stands by itself, or after its number: not in a word, and not in the name of a file.
        let last = out.chars().next_back();
        let begins = !last.is_some_and(|c| c.is_alphabetic() || matches!(c, '_' | '-' | '.' | '\\'));
        let ends = |unit: &str| {
            let mut next = from[unit.len()..].chars();
            match next.next() {
                Some('.') => !next.next().is_some_and(char::is_alphanumeric),
                Some(c) => !c.is_alphanumeric() && !matches!(c, '_' | '-'),
                None => true,
            }
        };
        let unit = MICRO.into_iter().find(|(unit, _)| begins && from.starts_with(unit) && ends(unit));
        let (plain, rendered) = unit.unwrap_or(("u", "u"));
        out.push_str(rendered);
        rest = &from[plain.len()..];
    }
    out.push_str(rest);
    out
}

/// A coordinate with one decimal, omitted if zero: `12.3`, `12`, never `-0`.
pub(super) fn px(v: f64) -> String {
    tenths(in_tenths(v))
}

/// A coordinate in tenths of a unit, clamped to a printable range.
pub(super) fn in_tenths(v: f64) -> i64 {
    (v.clamp(-1e5, 1e5) * 10.0).round() as i64
}

/// Tenths written as a decimal number.
pub(super) fn tenths(n: i64) -> String {
    let sign = if n < 0 { "-" } else { "" };
    match (n.abs() / 10, n.abs() % 10) {
        (whole, 0) => format!("{sign}{whole}"),
        (whole, tenth) => format!("{sign}{whole}.{tenth}"),
    }
}

/// `value` with `decimals` decimals, a typographic minus sign, and thin spaces between thousands from 10 000 on.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let plain = format!("{:.decimals$}", value.abs());
    let (whole, fraction) = plain.split_once('.').unwrap_or((&plain, ""));
    let mut out = String::new();
    if value < 0.0 && plain.contains(|c: char| ('1'..='9').contains(&c)) {
        out.push_str(MINUS);
    }
    for (i, digit) in whole.chars().enumerate() {
        let left = whole.len() - i;
        if whole.len() > 4 && i > 0 && left.is_multiple_of(3) {
            out.push('\u{2009}');
        }
        out.push(digit);
    }
    if !fraction.is_empty() {
        out.push('.');
        out.push_str(fraction);
    }
    out
}

/// A power of ten in superscript digits.
pub(super) fn power_of_ten(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = exponent.to_string().chars().map(|c| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize])).collect();
    ["10".to_owned(), raised].concat()
}

/// Estimated width of a text, in units of its font size, for a typical system font.
pub(super) fn width(text: &str) -> f64 {
    let em = |c: char| match c {
        '\u{2009}' => 0.2,
        'i' | 'j' | 'l' | 't' | 'f' | 'r' | ' ' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | '(' | ')' | '[' | ']' => {
            0.34
        }
        '⁰'..='⁹' | '¹' | '²' | '³' | '⁻' => 0.4,
        'm' | 'w' | 'M' | 'W' | '%' | '@' | '×' | '\u{2212}' | '±' => 0.9,
        '0'..='9' => 0.62,
        'A'..='Z' => 0.7,
        _ => 0.58,
    };
    text.chars().map(em).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_a_text_is_escaped() {
        assert_eq!(escape("a<b & \"c\">'d'\u{1}"), "a&lt;b &amp; &quot;c&quot;&gt;&#39;d&#39;");
    }

    #[test]
    fn a_unit_is_rendered_with_its_greek_letter_and_names_are_left_alone() {
        assert_eq!(shown("y [um], 22.4 um/V, 3um."), "y [µm], 22.4 µm/V, 3µm.");
        assert_eq!(shown("[V um] 5 uV < 1 um"), "[V µm] 5 µV &lt; 1 µm");
        for name in ["rise_um.csv", "um.csv", "sum", "umbra", "u [V]", "x_um", "um_x", "um2"] {
            assert_eq!(shown(name), name);
        }
    }

    #[test]
    fn numbers_have_a_true_minus_and_names_and_dates_keep_theirs() {
        assert_eq!(shown("-40 to -2e-3 V (-3 %, at -3.)"), "−40 to −2e−3 V (−3 %, at −3.)");
        assert_eq!(shown("at -3).  -3%. -123°, -0.5."), "at −3).  −3%. −123°, −0.5.");
        for name in ["2026-11-23", "run-3.csv", "feed-forward", "-o", "1e-3.csv"] {
            assert_eq!(shown(name), name);
        }
    }

    #[test]
    fn coordinates_have_one_decimal_and_no_negative_zero() {
        assert_eq!([px(12.34), px(12.04), px(-0.04), px(-0.26), px(1e300)], ["12.3", "12", "0", "-0.3", "100000"]);
    }

    #[test]
    fn numbers_are_typeset() {
        assert_eq!(number(-0.25, 2), "\u{2212}0.25");
        assert_eq!(number(-0.001, 1), "0.0");
        assert_eq!(number(1234567.0, 0), "1\u{2009}234\u{2009}567");
        assert_eq!(number(4000.0, 0), "4000");
        assert_eq!(power_of_ten(-12), "10⁻¹²");
    }
}
