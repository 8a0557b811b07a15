//! Text and numbers in SVG and HTML: escaped, with fixed precision and an estimated width.

/// Replaces the five markup characters and removes control characters that XML forbids.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\t' | '\n' | '\r' => out.push(c),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => {}
            c => out.push(c),
        }
    }
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
        out.push('\u{2212}');
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
