//! Splits a line into its cells, without copying them.

/// The separator of columns that only spaces and tabs set apart, however many.
pub(super) const SPACES: char = ' ';

/// The cells of a line, without the spaces and quotes around them; an invalid quote ends them with an error.
pub(super) fn cells(line: &str, separator: char) -> impl Iterator<Item = Result<&str, &'static str>> {
    let mut rest = Some(if separator == SPACES { line.trim() } else { line });
    std::iter::from_fn(move || {
        let line = rest.take()?;
        let (cell, after) = split(line, separator);
        if !cell.trim_start().starts_with('"') {
            rest = after;
            return Some(Ok(cell.trim()));
        }
        Some(quoted(line, separator).map(|(cell, after)| {
            rest = after;
            cell
        }))
    })
}

/// A cell in quotes, up to the quote that is not doubled, and the text after it.
fn quoted(line: &str, separator: char) -> Result<(&str, Option<&str>), &'static str> {
    let (_, body) = line.split_once('"').unwrap_or(("", line));
    let mut close = 0;
    loop {
        close += body[close..].find('"').ok_or("a quote is opened and not closed on its line: close or delete it")?;
        if !body[close + 1..].starts_with('"') {
            break;
        }
        close += 2;
    }
    let (between, after) = split(&body[close + 1..], separator);
    if !between.trim().is_empty() {
        return Err("text follows a closing quote: delete the quotes, or double those that belong to the text");
    }
    Ok((body[..close].trim(), after))
}

/// The text before the first separator, and the text after it, if there is one.
fn split(line: &str, separator: char) -> (&str, Option<&str>) {
    if separator == SPACES {
        return match line.split_once([' ', '\t']) {
            Some((cell, after)) => (cell, Some(after.trim_start()).filter(|after| !after.is_empty())),
            None => (line, None),
        };
    }
    match line.bytes().position(|b| char::from(b) == separator) {
        Some(at) => (&line[..at], Some(&line[at + 1..])),
        None => (line, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split_up(line: &str, separator: char) -> Vec<Result<&str, &'static str>> {
        cells(line, separator).collect()
    }

    #[test]
    fn cells_lose_their_spaces_and_quotes() {
        assert_eq!(split_up(" 1 ,\"2\", \" a,\"\"b \" ,\r", ','), [Ok("1"), Ok("2"), Ok("a,\"\"b"), Ok("")]);
        assert_eq!(split_up("\t1\t\"\"\t5\"\t", '\t'), [Ok(""), Ok("1"), Ok(""), Ok("5\""), Ok("")]);
        assert_eq!(split_up("", ','), [Ok("")]);
        assert_eq!(split_up("  1   2\t3 \r", SPACES), [Ok("1"), Ok("2"), Ok("3")]);
    }

    #[test]
    fn a_quote_that_does_not_fit_ends_the_line() {
        let [Ok("1"), Err(open)] = split_up("1,\"2,3", ',')[..] else { panic!() };
        assert!(open.starts_with("a quote is opened and not closed"));
        let [Err(after)] = split_up("\"1\" V,2", ',')[..] else { panic!() };
        assert!(after.starts_with("text follows a closing quote"));
        assert_eq!(split_up("\"\"\"", ',').len(), 1);
    }
}
