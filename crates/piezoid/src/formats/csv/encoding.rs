//! Converts bytes to text, or to the reason why they are not text.
//!
//! Text is UTF-8, UTF-16 (Excel's "Unicode text", PowerShell) or Windows-1252 (older programs), which this file tells
//! apart by the byte-order mark, the zeros between letters, and the bytes that UTF-8 does not allow.

use crate::Error;
use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};
use std::borrow::Cow;

/// Signatures of files that are taken for CSV by mistake, and what to do with them.
const OTHERS: &[(&[u8], &str)] = &[
    (b"PK\x03\x04", "a zip archive or an Excel workbook: unpack it, or save the sheet as CSV"),
    (b"\x89HDF", "a damaged HDF5 file, such as .mat of version 7.3"),
    (b"MATLAB 5.0 MAT-file", "a damaged MATLAB .mat file"),
    (b"\x93NUMPY", "a damaged numpy .npy file"),
    (b"\x1f\x8b", "a gzip archive: unpack it first"),
    (b"{", "JSON, such as a model: save the samples as CSV"),
    (b"<", "a web page or XML: save the samples as CSV"),
    (b"PAR1", "a Parquet file: save the columns as CSV or .npz (pandas: to_csv)"),
    (b"ARROW1", "an Arrow or Feather file: save the columns as CSV or .npz (pandas: to_csv)"),
    (b"FEA1", "a Feather file: save the columns as CSV or .npz (pandas: to_csv)"),
    (b"MDF ", "an MDF file of measurements: export the channels as CSV or .mat"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"\x89PNG", "a PNG picture"),
    (b"%PDF", "a PDF document"),
    (b"\xd0\xcf\x11\xe0", "an Excel workbook: save the sheet as CSV"),
    (b"version https://git-lfs", "a pointer of Git LFS, not the data: fetch them with `git lfs pull`"),
];

/// The text, without its byte-order mark.
pub(in crate::formats) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, Error> {
    let (encoding, mark) = Encoding::for_bom(bytes).unwrap_or((bare(bytes), 0));
    let bytes = &bytes[mark..];
    if let Some((_, kind)) = OTHERS.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Err(Error::Content(format!("this is not text with columns but {kind}")));
    }
    let control = |b: &u8| *b < b' ' && !b"\t\n\r\x0c\x1a".contains(b);
    if encoding == WINDOWS_1252 && bytes.iter().take(4096).any(control) {
        let at = std::str::from_utf8(bytes).map_or_else(|error| error.valid_up_to(), |_| 0);
        return Err(Error::Content(format!(
            "this is not text with columns: byte 0x{:02x} on line {} is not text; if it is another format, give it the \
             right extension",
            bytes.get(at).copied().unwrap_or_default(),
            line_at(bytes, at)
        )));
    }
    let (text, _) = encoding.decode_without_bom_handling(bytes);
    match text.find('\0') {
        None => Ok(text),
        Some(at) => Err(Error::Line {
            line: line_at(text.as_bytes(), at),
            column: None,
            problem: "a NUL byte, which is not allowed in text: the file is damaged from here on (was it written \
                      completely?)"
                .into(),
        }),
    }
}

/// The encoding of text without a byte-order mark.
fn bare(bytes: &[u8]) -> &'static Encoding {
    match bytes {
        [a, 0, b, 0, ..] if *a > 0 && *b > 0 => UTF_16LE,
        [0, a, 0, b, ..] if *a > 0 && *b > 0 => UTF_16BE,
        _ if std::str::from_utf8(bytes).is_ok() => UTF_8,
        _ => WINDOWS_1252,
    }
}

/// The lines with their numbers, from 1. A line ends with a line feed, a carriage return, or both.
pub(in crate::formats) fn lines(text: &str) -> impl Iterator<Item = (u64, &str)> + Clone {
    let end = if text.contains('\n') { '\n' } else { '\r' };
    // A carriage return before a line feed remains; readers of cells treat it as a space.
    (1..).zip(text.split(end))
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
    fn text_is_read_in_its_encoding() {
        let text = "Weg (\u{b5}m)\tU\n0,1\t2\n";
        let units: Vec<u16> = text.encode_utf16().collect();
        let little: Vec<u8> = units.iter().flat_map(|unit| unit.to_le_bytes()).collect();
        let big: Vec<u8> = units.iter().flat_map(|unit| unit.to_be_bytes()).collect();
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        for bytes in [
            text.as_bytes().to_vec(),
            [b"\xEF\xBB\xBF", text.as_bytes()].concat(),
            [b"\xFF\xFE", &little[..]].concat(),
            [b"\xFE\xFF", &big[..]].concat(),
            little,
            big,
            latin,
        ] {
            assert_eq!(decode(&bytes).unwrap(), text, "{bytes:?}");
        }
    }

    #[test]
    fn a_binary_file_is_named() {
        assert_eq!(
            refusal(b"PK\x03\x04\x14\0\x06\0"),
            "this is not text with columns but a zip archive or an Excel workbook: unpack it, or save the sheet as CSV"
        );
        assert!(refusal(b"\x89HDF\r\n\x1a\n").contains("HDF5"));
        assert_eq!(
            refusal(b"\x7fELF\x02\x01\x01\xd0\n"),
            "this is not text with columns: byte 0xd0 on line 1 is not text; if it is another format, give it the \
             right extension"
        );
    }

    #[test]
    fn a_nul_byte_is_named_with_its_line() {
        assert_eq!(
            refusal(b"t_s,u_V\n0,1\n0.1,2\n\0\0\0\0"),
            "line 4: a NUL byte, which is not allowed in text: the file is damaged from here on (was it written completely?)"
        );
    }
}
