//! The type and shape of an array: the header of a `.npy` file.

use super::literal::{Literal, parse};
use crate::formats::bytes::{DEEPEST, NumberFormat, NumberKind, damaged, shape, size};
use crate::formats::quote::quoted;
use piezoid_numerics::error::Error;

/// The header of a file.
#[derive(Debug, PartialEq)]
pub(super) struct ArrayHead {
    pub(super) descr: Descr,
    pub(super) dims: Vec<usize>,
}

/// The type of an element.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Descr {
    Numbers(NumberFormat),
    /// Points in time or time differences, integers of 8 bytes; a tick is `unit` / `per_second` seconds.
    Instants {
        big: bool,
        unit: f64,
        per_second: f64,
    },
    Fields(Vec<(String, Descr)>),
    /// A description of a type that is not a real number, and its bytes.
    Other(String, usize),
}

/// Reads the header of a file.
pub(super) fn head(bytes: &[u8]) -> Result<ArrayHead, Error> {
    let text = String::from_utf8_lossy(bytes);
    let wrong = || damaged(format!("the description of an array, {:.60?}", text.trim()));
    let Literal::Dict(entries) = parse(&text)? else { return Err(wrong()) };
    let entry = |expected: &str| {
        let found = entries.iter().find(|(key, _)| *key == Literal::Text(expected.into()));
        found.map(|(_, value)| value).ok_or_else(wrong)
    };
    let descr = descr(entry("descr")?, 0).ok_or_else(wrong)?;
    Ok(ArrayHead { descr, dims: dims(entry("shape")?).ok_or_else(wrong)? })
}

fn dims(literal: &Literal) -> Option<Vec<usize>> {
    let dim = |value: &Literal| if let Literal::Number(dim) = value { Some(*dim) } else { None };
    if let Literal::List(values) = literal { values.iter().map(dim).collect() } else { None }
}

fn descr(literal: &Literal, depth: usize) -> Option<Descr> {
    match literal {
        Literal::Text(code) => plain(code),
        Literal::List(fields) if depth < DEEPEST => {
            Some(Descr::Fields(fields.iter().map(|f| field(f, depth)).collect::<Option<_>>()?))
        }
        _ => None,
    }
}

/// A name, possibly with a title before it, a type, and possibly a shape.
fn field(literal: &Literal, depth: usize) -> Option<(String, Descr)> {
    let Literal::List(parts) = literal else { return None };
    let (name, kind, dims) = match &parts[..] {
        [name, kind] => (name, kind, None),
        [name, kind, shape] => (name, kind, Some(dims(shape)?)),
        _ => return None,
    };
    let name = match name {
        Literal::List(titled) if titled.len() == 2 => &titled[1],
        name => name,
    };
    let Literal::Text(name) = name else { return None };
    let descr = descr(kind, depth + 1)?;
    let descr = match dims {
        None => descr,
        Some(dims) => {
            Descr::Other(format!("of shape {} a row", shape(&dims)), descr.size()?.checked_mul(size(&dims).ok()?)?)
        }
    };
    Some((name.clone(), descr))
}

/// A type such as `<f8` or `<M8[us]`.
fn plain(code: &str) -> Option<Descr> {
    let (order, rest) = match code.chars().next()? {
        order @ ('<' | '>' | '|' | '=') => (order, &code[1..]),
        _ => ('<', code),
    };
    let kind = rest.chars().next()?;
    let (digits, unit) = rest[kind.len_utf8()..].split_once('[').unwrap_or((&rest[kind.len_utf8()..], ""));
    let size: usize = if kind == 'O' { 8 } else { digits.parse().ok()? };
    let (big, what) = (order == '>', || format!("of type {}", quoted(code)));
    let numbers = |kind| Some(Descr::Numbers(NumberFormat { kind, size, big }));
    match kind {
        'f' if matches!(size, 2 | 4 | 8) => numbers(NumberKind::Float),
        'i' if matches!(size, 1 | 2 | 4 | 8) => numbers(NumberKind::Signed),
        'u' if matches!(size, 1 | 2 | 4 | 8) => numbers(NumberKind::Unsigned),
        'b' if size == 1 => numbers(NumberKind::Unsigned),
        'M' | 'm' if size == 8 => Some(match seconds(unit.trim_end_matches(']')) {
            Some((unit, per_second)) => Descr::Instants { big, unit, per_second },
            None => Descr::Other(what(), size),
        }),
        'U' => Some(Descr::Other("text".into(), size.checked_mul(4)?)),
        'S' | 'a' => Some(Descr::Other("text".into(), size)),
        'O' => Some(Descr::Other("Python objects".into(), 8)),
        _ => Some(Descr::Other(what(), size)),
    }
}

/// A unit of time, such as `us` or `10us`: the quotient of the two numbers is its duration [s].
fn seconds(unit: &str) -> Option<(f64, f64)> {
    let digits = unit.len() - unit.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let count: f64 = if digits > 0 { unit[..digits].parse().ok()? } else { 1.0 };
    let (each, per_second) = match &unit[digits..] {
        "W" => (604_800.0, 1.0),
        "D" => (86_400.0, 1.0),
        "h" => (3600.0, 1.0),
        "m" => (60.0, 1.0),
        "s" => (1.0, 1.0),
        "ms" => (1.0, 1e3),
        "us" => (1.0, 1e6),
        "ns" => (1.0, 1e9),
        "ps" => (1.0, 1e12),
        "fs" => (1.0, 1e15),
        "as" => (1.0, 1e18),
        _ => return None,
    };
    Some((count * each, per_second))
}

impl Descr {
    /// Bytes per element; `None` if the number is too large.
    pub(super) fn size(&self) -> Option<usize> {
        match self {
            Descr::Numbers(numbers) => Some(numbers.size),
            Descr::Instants { .. } => Some(8),
            Descr::Fields(fields) => fields.iter().try_fold(0, |sum: usize, (_, field)| sum.checked_add(field.size()?)),
            Descr::Other(_, size) => Some(*size),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(code: &str) -> Option<Descr> {
        descr(&parse(code).unwrap(), 0)
    }

    #[test]
    fn a_unit_of_time_is_a_quotient_of_whole_numbers() {
        for (code, unit, per_second) in [
            ("W", 604_800.0, 1.0),
            ("D", 86_400.0, 1.0),
            ("h", 3600.0, 1.0),
            ("m", 60.0, 1.0),
            ("s", 1.0, 1.0),
            ("ms", 1.0, 1e3),
            ("us", 1.0, 1e6),
            ("10us", 10.0, 1e6),
            ("ns", 1.0, 1e9),
            ("ps", 1.0, 1e12),
            ("fs", 1.0, 1e15),
            ("as", 1.0, 1e18),
        ] {
            assert_eq!(seconds(code), Some((unit, per_second)), "{code}");
            for (order, big) in [('<', false), ('>', true)] {
                let instants = Some(Descr::Instants { big, unit, per_second });
                assert_eq!(of(&format!("'{order}M8[{code}]'")), instants, "{code}");
            }
        }
        assert_eq!((seconds("Y"), seconds("")), (None, None));
        assert_eq!(of("'<M8[Y]'"), Some(Descr::Other("of type `<M8[Y]`".into(), 8)));
    }

    #[test]
    fn a_type_is_a_kind_a_size_and_an_order_of_bytes() {
        let numbers = |kind, size, big| Some(Descr::Numbers(NumberFormat { kind, size, big }));
        for size in [1, 2, 4, 8] {
            assert_eq!(of(&format!("'>i{size}'")), numbers(NumberKind::Signed, size, true));
            assert_eq!(of(&format!("'u{size}'")), numbers(NumberKind::Unsigned, size, false));
        }
        assert_eq!(of("'<f2'"), numbers(NumberKind::Float, 2, false));
        assert_eq!(of("'|b1'"), numbers(NumberKind::Unsigned, 1, false));
        for (code, what, size) in [
            ("<U6", "text", 24),
            ("|S6", "text", 6),
            ("|O", "Python objects", 8),
            ("<f16", "of type `<f16`", 16),
            ("<i3", "of type `<i3`", 3),
            ("<u5", "of type `<u5`", 5),
            ("|V7", "of type `|V7`", 7),
        ] {
            assert_eq!(of(&format!("'{code}'")), Some(Descr::Other(what.into(), size)), "{code}");
        }
        assert_eq!((of("''"), of("'<f'")), (None, None));
    }

    #[test]
    fn fields_have_names_titles_and_shapes() {
        let both = of("[(('drive', 'u_V'), '<f8'), ('log', [('k', '<i2'), ('corner', '<f4', (2, 3))])]").unwrap();
        assert_eq!(both.size(), Some(8 + 2 + 24));
        let Descr::Fields(fields) = both else { panic!("no fields") };
        assert_eq!(fields[0].0, "u_V");
        let Descr::Fields(log) = &fields[1].1 else { panic!("no fields within the field") };
        assert_eq!(log[1], ("corner".into(), Descr::Other("of shape 2 x 3 a row".into(), 24)));
        assert_eq!((of("[('u_V',)]"), of("[(3, '<f8')]")), (None, None));
    }
}
