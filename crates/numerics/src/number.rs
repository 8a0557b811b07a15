//! Numbers as text, and whole powers.

use libm::{log10, pow};

/// The largest size of a reading, in any unit. Its square is finite in single precision. What is beyond is a fault of
/// the sensor or of the memory, as a NaN is.
pub const MEASURABLE: f64 = 1e18;

/// True for a number that a sensor can give.
pub fn is_measurable(v: f64) -> bool {
    v.abs() <= MEASURABLE
}

/// x^n by squaring: 1/x^-n for a negative n. `f64::powi` of an n that the compiler does not know calls another function
/// on Windows, and differs there.
///
/// ```
/// use piezoid_numerics::number::power;
/// assert_eq!([power(10.0, 3), power(2.0, -2), power(-0.5, 1), power(0.0, 0)], [1000.0, 0.25, -0.5, 1.0]);
/// ```
pub fn power(mut x: f64, n: i32) -> f64 {
    let (mut left, mut product) = (n.unsigned_abs(), 1.0);
    while left > 0 {
        if left % 2 == 1 {
            product *= x;
        }
        x *= x;
        left /= 2;
    }
    if n < 0 { 1.0 / product } else { product }
}

/// `x` with four significant digits, with a power of ten if it is very small or large; `-` if it is not finite.
///
/// ```
/// use piezoid_numerics::number::short;
/// let shown = ["0", "0.01289", "146.7", "1.000e-7", "1.235e5", "-"];
/// assert_eq!([0.0, 0.01289, 146.72, 1e-7, 123456.0, f64::NAN].map(short), shown);
/// ```
pub fn short(x: f64) -> String {
    match x.abs() {
        a if !a.is_finite() => "-".into(),
        0.0 => "0".into(),
        a if (1e-3..1e5).contains(&a) => {
            let decimals = (3 - log10(a).floor() as i32).max(0) as usize;
            format!("{x:.decimals$}")
        }
        _ => format!("{x:.3e}"),
    }
}

/// Like [`short`], but without zeros at the end, for settings and other round numbers.
///
/// ```
/// use piezoid_numerics::number::round;
/// assert_eq!([5.0, 0.061, 12.5, 1e6].map(round), ["5", "0.061", "12.5", "1e6"]);
/// ```
pub fn round(x: f64) -> String {
    let text = short(x);
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, ""));
    let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    if exponent.is_empty() { digits.into() } else { format!("{digits}e{exponent}") }
}

/// `x` in `unit`, with the prefix that leaves 1 to 999.9 of it.
///
/// ```
/// use piezoid_numerics::number::quantity;
/// let shown = ["1.5 uF", "70 kF", "0 F", "500 mF"];
/// assert_eq!([1.5e-6, 7e4, 0.0, 0.5].map(|x| quantity(x, "F")), shown);
/// ```
pub fn quantity(x: f64, unit: &str) -> String {
    const PREFIXES: [&str; 8] = ["p", "n", "u", "m", "", "k", "M", "G"];
    let thousands =
        if x == 0.0 || !x.is_finite() { 0.0 } else { (log10(x.abs()) / 3.0 + 1e-9).floor().clamp(-4.0, 3.0) };
    format!("{} {}{unit}", round(x / pow(1000.0, thousands)), PREFIXES[(thousands + 4.0) as usize])
}

/// `x` with all its digits, and with an exponent beyond 1e15: never with hundreds of zeros.
///
/// ```
/// use piezoid_numerics::number::exact;
/// let shown = ["0.1", "0.0005", "1234567", "1e15", "1e300", "5e-324"];
/// assert_eq!([0.1, 0.0005, 1234567.0, 1e15, 1e300, 5e-324].map(exact), shown);
/// ```
pub fn exact(x: f64) -> String {
    let plain = x == 0.0 || !x.is_finite() || (1e-15..1e15).contains(&x.abs());
    if plain { x.to_string() } else { format!("{x:e}") }
}

/// A text such as `from 1000000000000000000000 s`, with its numbers as [`exact`] writes them.
pub(crate) fn tamed(text: &str) -> String {
    let digit = |c: char| c.is_ascii_digit() || c == '.';
    let mut message = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let end = rest[start..].find(|c| !digit(c)).map_or(rest.len(), |length| start + length);
        let number = rest[start..end].trim_end_matches('.');
        message += &rest[..start];
        // A seed has up to 20 digits of its own.
        match number.parse::<f64>() {
            Ok(x) if number.len() > 20 || number.len() > 15 && x.to_string() == number => message += &exact(x),
            _ => message += number,
        }
        rest = &rest[start + number.len()..];
    }
    message + rest
}

/// Items as text: "a, b and c".
pub fn join(items: &[impl ToString]) -> String {
    let texts: Vec<String> = items.iter().map(ToString::to_string).collect();
    match texts.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => texts.concat(),
    }
}

/// A unit with the Greek letter of micro written as `u`.
pub fn ascii_unit(unit: &str) -> String {
    unit.replace(['\u{b5}', '\u{3bc}'], "u")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        let shown = [-33.333333, 0.061, 99999.5, 1e308].map(short);
        assert_eq!(shown, ["-33.33", "0.06100", "100000", "1.000e308"]);
    }

    #[test]
    fn round_numbers_have_no_zeros_at_their_end() {
        let shown = [120.0, -30.0, 1e-7, 0.0, f64::NAN].map(round);
        assert_eq!(shown, ["120", "-30", "1e-7", "0", "-"]);
    }
}
