//! Converts bytes to lines of text, or to the reason why they are not text.

use crate::Error;

/// Signatures of files that are taken for CSV by mistake.
const OTHERS: [(&[u8], &str); 7] = [
    (b"PK\x03\x04", "a zip archive, such as .xlsx or .npz"),
    (b"\x89HDF", "an HDF5 file, such as .mat of version 7.3"),
    (b"MATLAB 5.0 MAT-file", "a MATLAB .mat file"),
    (b"\x93NUMPY", "a numpy .npy file"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"{", "JSON, such as a model"),
    (b"<", "HTML or XML"),
];

/// The text without its byte-order mark. All lines end in the same way and contain no NUL.
pub(super) fn decode(bytes: &[u8]) -> Result<&str, Error> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if let Some((_, kind)) = OTHERS.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Err(Error::Content(format!(
            "this does not look like a CSV file but like {kind}: give it the right extension, or export it as CSV"
        )));
    }
    if utf16(bytes) {
        return Err(Error::Content(
            "this is UTF-16 text (as PowerShell and \"Unicode text\" in Excel write it), but UTF-8 is needed: save it \
             as \"CSV UTF-8\", or convert it with `iconv -f UTF-16 -t UTF-8`"
                .into(),
        ));
    }
    let text = std::str::from_utf8(bytes).map_err(|e| not_utf8(bytes, e.valid_up_to()))?;
    let problem = if let Some(at) = text.find('\0') {
        Some((
            at,
            "a NUL byte, which is not allowed in text: the file is damaged from here on (was it written completely?)",
        ))
    } else if text.contains('\n') {
        stray_return(bytes)
            .map(|at| (at, "a carriage return within the line: the file mixes line endings; use one kind throughout"))
    } else {
        None
    };
    match problem {
        None => Ok(text),
        Some((at, problem)) => Err(Error::Line { line: line_at(bytes, at), column: None, problem: problem.into() }),
    }
}

/// The lines with their numbers, from 1. They end with a line feed or, in a file without line feeds, with a carriage
/// return. A carriage return before a line feed remains; readers of cells treat it as a space.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (u64, &str)> {
    let end = if text.contains('\n') { '\n' } else { '\r' };
    (1..).zip(text.split(end))
}

/// True if every other byte at the start is zero, or if there is a UTF-16 byte-order mark.
fn utf16(bytes: &[u8]) -> bool {
    match bytes {
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => true,
        [a, b, c, d, ..] => (*a == 0) != (*b == 0) && (*a == 0) == (*c == 0) && (*b == 0) == (*d == 0),
        _ => false,
    }
}

/// The error for a byte that is not UTF-8: text in another encoding, or no text.
fn not_utf8(bytes: &[u8], at: usize) -> Error {
    let control = |b: &u8| *b < b' ' && !b"\t\n\r\x0c".contains(b);
    let byte = bytes.get(at).copied().unwrap_or_default();
    let line = line_at(bytes, at);
    if bytes.iter().take(4096).any(control) {
        return Error::Content(format!(
            "this does not look like a CSV file: byte 0x{byte:02x} on line {line} is not text; if it is another \
             format, give it the right extension"
        ));
    }
    Error::Line {
        line,
        column: None,
        problem: format!(
            "byte 0x{byte:02x} is not UTF-8: save the file as UTF-8, or write the header in plain letters (um for \
             \u{b5}m)"
        ),
    }
}

/// Position of a carriage return without a line feed after it, in a file with line feeds.
fn stray_return(bytes: &[u8]) -> Option<usize> {
    bytes.windows(2).position(|pair| pair[0] == b'\r' && !b"\r\n".contains(&pair[1]))
}

/// The line, from 1, of a position in the file.
fn line_at(bytes: &[u8], at: usize) -> u64 {
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    1 + bytes.iter().take(at).filter(|b| **b == end).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(bytes: &[u8]) -> String {
        decode(bytes).unwrap_err().to_string()
    }

    #[test]
    fn utf16_is_refused_with_or_without_its_mark() {
        let utf16 = |mark: &[u8]| [mark, b"t\0_\0s\0,\0u\0_\0V\0"].concat();
        assert_eq!(
            refusal(&utf16(b"\xFF\xFE")),
            "this is UTF-16 text (as PowerShell and \"Unicode text\" in Excel write it), but UTF-8 is needed: save it \
             as \"CSV UTF-8\", or convert it with `iconv -f UTF-16 -t UTF-8`"
        );
        assert!(refusal(&utf16(b"")).starts_with("this is UTF-16"));
        assert!(refusal(b"\0t\0_\0s").starts_with("this is UTF-16"));
        assert!(refusal(b"\xFE\xFF\0t\0_\0s").starts_with("this is UTF-16"));
    }

    #[test]
    fn a_binary_file_does_not_look_like_a_csv() {
        assert_eq!(
            refusal(b"PK\x03\x04\x14\0\x06\0"),
            "this does not look like a CSV file but like a zip archive, such as .xlsx or .npz: give it the right \
             extension, or export it as CSV"
        );
        assert!(refusal(b"\x89HDF\r\n\x1a\n").contains("HDF5"));
        assert_eq!(
            refusal(b"\x7fELF\x02\x01\x01\xd0\n"),
            "this does not look like a CSV file: byte 0xd0 on line 1 is not text; if it is another format, give it the \
             right extension"
        );
    }

    #[test]
    fn another_encoding_is_named_with_its_line_and_byte() {
        assert_eq!(
            refusal(b"# rig 2\nt_s,u_V,y_\xb5m\n0,1,2\n"),
            "line 2: byte 0xb5 is not UTF-8: save the file as UTF-8, or write the header in plain letters (um for \
             \u{b5}m)"
        );
    }

    #[test]
    fn a_nul_byte_is_named_with_its_line() {
        assert_eq!(
            refusal(b"t_s,u_V\n0,1\n0.1,2\n\0\0\0\0"),
            "line 4: a NUL byte, which is not allowed in text: the file is damaged from here on (was it written completely?)"
        );
    }

    #[test]
    fn line_ends_of_two_kinds_are_refused() {
        assert_eq!(
            refusal(b"t_s,u_V\n0,1\r0.1,2\n"),
            "line 2: a carriage return within the line: the file mixes line endings; use one kind throughout"
        );
    }
}
