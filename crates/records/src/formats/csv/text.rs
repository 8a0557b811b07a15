//! The text of a file, read in pieces of whole lines: a long file is never held.

use super::encoding::Encoding;
use crate::formats::read::broken;
use piezoid_numerics::error::Error;
use std::io::Read;

/// Number of bytes of a piece. The first one shows encoding, ends of lines, separators and names.
pub(in crate::formats) const PIECE: usize = 1 << 22;

/// The text of a source.
pub(super) struct Text<R> {
    source: R,
    /// Bytes that were read, and are in no piece yet.
    bytes: Vec<u8>,
    /// The encoding and the letter that ends lines, once they are known.
    written: Option<(Encoding, u8)>,
    /// The first line of the next piece, from 1.
    line: u64,
    /// Number of bytes of a piece.
    size: usize,
    /// True if the last piece was given.
    ended: bool,
}

/// Lines that follow each other.
pub(super) struct Piece {
    /// The first of them, from 1.
    line: u64,
    pub(super) text: String,
    end: char,
}

impl Piece {
    /// The lines with their numbers. A line ends with a line feed, a carriage return, or both; a carriage return before
    /// a line feed remains, and readers of cells treat it as a space.
    pub(super) fn lines(&self) -> impl Iterator<Item = (u64, &str)> + Clone {
        (self.line..).zip(self.text.split(self.end))
    }

    /// With the piece that follows it.
    pub(super) fn and(mut self, next: &Piece) -> Piece {
        self.text.push(self.end);
        self.text += &next.text;
        self
    }
}

impl<R: Read> Text<R> {
    /// The text of a source, in pieces of so many bytes.
    pub(super) fn new(source: R, size: usize) -> Self {
        Text { source, bytes: Vec::new(), written: None, line: 1, size, ended: false }
    }

    /// The next piece, without the end of its last line; `None` after the last one.
    pub(super) fn next(&mut self) -> Result<Option<Piece>, Error> {
        let mut expected = self.size;
        while !self.ended {
            let missing = expected.saturating_sub(self.bytes.len()) as u64;
            let read = self.source.by_ref().take(missing).read_to_end(&mut self.bytes);
            self.ended = (read.map_err(broken)? as u64) < missing;
            let (encoding, end) = match self.written {
                Some(written) => written,
                None => {
                    let (encoding, mark) = Encoding::of(&self.bytes)?;
                    let ends = |end: &u8| encoding.end_of_lines(&self.bytes, *end).is_some();
                    let end = [b'\n', b'\r'].into_iter().find(ends);
                    if end.is_none() && !self.ended {
                        expected *= 2;
                        continue;
                    }
                    self.bytes.drain(..mark);
                    (encoding, end.unwrap_or(b'\n'))
                }
            };
            let whole = if self.ended { Some(self.bytes.len()) } else { encoding.end_of_lines(&self.bytes, end) };
            let Some(whole) = whole else {
                // A long line.
                expected *= 2;
                continue;
            };
            let encoding = encoding.with(&self.bytes[..whole]);
            self.written = Some((encoding, end));
            let mut text = encoding.decode(&self.bytes[..whole], self.line)?.into_owned();
            self.bytes.drain(..whole);
            if !self.ended {
                text.pop();
            }
            let piece = Piece { line: self.line, text, end: char::from(end) };
            self.line += piece.lines().count() as u64;
            return Ok(Some(piece));
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_have_the_lines_of_the_whole_whatever_ends_and_encodes_them() {
        let lines: Vec<String> = (0..40).map(|k| format!("{k},\u{b5}{}", "x".repeat(k % 17))).collect();
        for end in ["\n", "\r\n", "\r"] {
            let text = lines.join(end);
            let utf16: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
            let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
            let marked = [b"\xEF\xBB\xBF", text.as_bytes()].concat();
            for bytes in [text.clone().into_bytes(), marked, [b"\xFF\xFE", &utf16[..]].concat(), utf16, latin] {
                for size in [40, 64, 1 << 20] {
                    let mut source = Text::new(&bytes[..], size);
                    let mut found = Vec::new();
                    while let Some(piece) = source.next().unwrap() {
                        found.extend(piece.lines().map(|(line, text)| (line, text.trim_end().to_string())));
                    }
                    let expected: Vec<(u64, String)> = (1..).zip(lines.clone()).collect();
                    assert_eq!(found, expected, "{size} {end:?} {bytes:?}");
                }
            }
        }
    }

    #[test]
    fn damage_is_named_with_its_line_in_the_file() {
        let text = format!("{}\0", "1,2\n".repeat(100));
        let mut source = Text::new(text.as_bytes(), 16);
        let error = std::iter::repeat_with(|| source.next()).find_map(Result::err).unwrap();
        assert!(error.to_string().starts_with("line 101: a NUL byte"), "{error}");
    }
}
