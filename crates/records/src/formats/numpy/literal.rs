//! The Python literals with which numpy describes an array: text, integers, booleans, tuples, lists, dictionaries.

use crate::formats::bytes::{DEEPEST, damaged};
use piezoid_numerics::error::Error;

/// A Python literal.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Literal {
    Text(String),
    Number(usize),
    Truth(bool),
    /// A tuple or a list.
    List(Vec<Literal>),
    Dict(Vec<(Literal, Literal)>),
}

/// Reads a literal, which only space may follow.
pub(super) fn parse(text: &str) -> Result<Literal, Error> {
    let mut rest = text;
    let value = value(&mut rest, 0).filter(|_| rest.trim().is_empty());
    value.ok_or_else(|| damaged(format!("the description of an array, {:.60?}", text.trim())))
}

fn value(rest: &mut &str, depth: usize) -> Option<Literal> {
    *rest = rest.trim_start();
    if depth > DEEPEST {
        return None;
    }
    match rest.chars().next()? {
        quote @ ('\'' | '"') => {
            let (text, after) = rest[1..].split_once(quote)?;
            *rest = after;
            Some(Literal::Text(text.into()))
        }
        '(' => series(rest, ')', |rest| value(rest, depth + 1)).map(Literal::List),
        '[' => series(rest, ']', |rest| value(rest, depth + 1)).map(Literal::List),
        '{' => series(rest, '}', |rest| {
            let key = value(rest, depth + 1)?;
            *rest = rest.trim_start().strip_prefix(':')?;
            Some((key, value(rest, depth + 1)?))
        })
        .map(Literal::Dict),
        _ => {
            let end = rest.find(|c: char| !c.is_alphanumeric()).unwrap_or(rest.len());
            let word;
            (word, *rest) = rest.split_at(end);
            match word {
                "True" => Some(Literal::Truth(true)),
                "False" => Some(Literal::Truth(false)),
                // Python 2 wrote 4L.
                _ => word.trim_end_matches('L').parse().ok().map(Literal::Number),
            }
        }
    }
}

/// The values between brackets, separated by commas; a comma may follow the last value.
fn series<T>(rest: &mut &str, close: char, one: impl Fn(&mut &str) -> Option<T>) -> Option<Vec<T>> {
    let mut values = Vec::new();
    *rest = &rest[1..];
    loop {
        *rest = rest.trim_start();
        if let Some(after) = rest.strip_prefix(close) {
            *rest = after;
            return Some(values);
        }
        values.push(one(rest)?);
        *rest = rest.trim_start();
        match rest.strip_prefix(',') {
            Some(after) => *rest = after,
            None if rest.starts_with(close) => {}
            None => return None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_numpy_writes_is_read_and_nothing_else() {
        use Literal::{Dict, List, Number, Text, Truth};
        let text = "{'descr': [('a', '<f8'), (\"b\", '<i2', (3,))], 'fortran_order': False, 'shape': (4L, 1), }  \n";
        let text_of = |text: &str| Text(text.into());
        let fields = vec![
            List(vec![text_of("a"), text_of("<f8")]),
            List(vec![text_of("b"), text_of("<i2"), List(vec![Number(3)])]),
        ];
        let expected = vec![
            (text_of("descr"), List(fields)),
            (text_of("fortran_order"), Truth(false)),
            (text_of("shape"), List(vec![Number(4), Number(1)])),
        ];
        assert_eq!(parse(text), Ok(Dict(expected)));
        let deep = "(".repeat(100_000);
        for wrong in ["", "{", "{'a' 1}", "(1 2)", "'a", "1 2", "-1", "import os", "\u{e9}", &deep] {
            assert!(parse(wrong).unwrap_err().to_string().contains("the description of an array"), "{wrong:.20}");
        }
    }
}
