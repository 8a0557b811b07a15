//! The tokens of a program: names, numbers, signs, comments.

use piezoid_numerics::error::Error;

/// A token.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Token {
    Name(String),
    Real(f64),
    Integer(usize),
    Sign(&'static str),
    Note(String),
}

/// Longer signs first, so that `<=` is not read as `<`.
const SIGNS: [&str; 28] = [
    "..", "+=", "-=", "*=", "/=", "<=", ">=", "==", "!=", "&&", "||", "(", ")", "{", "}", "[", "]", ",", ";", ":", "=",
    "+", "-", "*", "/", "%", "<", ">",
];

/// The tokens of a text, in order.
pub(super) fn tokens(text: &str) -> Result<Vec<Token>, Error> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = |ends: &dyn Fn(char) -> bool| rest.find(|c| !ends(c)).unwrap_or(rest.len());
        let taken = if let Some(note) = rest.strip_prefix("//") {
            let note = note.lines().next().unwrap_or_default();
            tokens.push(Token::Note(note.trim().into()));
            2 + note.len()
        } else if first.is_ascii_alphabetic() {
            let n = length(&|c| c.is_ascii_alphanumeric() || c == '_');
            tokens.push(Token::Name(rest[..n].into()));
            n
        } else if first.is_ascii_digit() {
            let (number, n) = number(rest)?;
            tokens.push(number);
            n
        } else if rest.starts_with('.') && !rest.starts_with("..") {
            tokens.push(Token::Sign("."));
            1
        } else if let Some(sign) = SIGNS.iter().find(|sign| rest.starts_with(**sign)) {
            tokens.push(Token::Sign(sign));
            sign.len()
        } else {
            return Err(Error::Content(format!("program: unknown character `{first}`")));
        };
        rest = rest[taken..].trim_start();
    }
    Ok(tokens)
}

/// The number at the start of `text` and its length; it is real if it has a point or an exponent.
fn number(text: &str) -> Result<(Token, usize), Error> {
    let digits = |text: &str| text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let mut n = digits(text);
    let whole = n;
    if text[n..].starts_with('.') && !text[n..].starts_with("..") {
        n += 1 + digits(&text[n + 1..]);
    }
    if let Some(exponent) = text[n..].strip_prefix('e') {
        let sign = usize::from(exponent.starts_with(['-', '+']));
        n += 1 + sign + digits(&exponent[sign..]);
    }
    let bad = || Error::Content(format!("program: `{}` is not a number", &text[..n]));
    let number = if n == whole {
        Token::Integer(text[..n].parse().map_err(|_| bad())?)
    } else {
        Token::Real(text[..n].parse().map_err(|_| bad())?)
    };
    Ok((number, n))
}
