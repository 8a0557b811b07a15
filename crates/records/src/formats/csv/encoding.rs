//! Converts bytes to text, or to the reason why they are not text.
//!
//! Text is UTF-8, UTF-16 (Excel's "Unicode text", PowerShell) or Windows-1252 (older programs), which this file
//! distinguishes by the byte-order mark, the zeros between letters, and the bytes that UTF-8 does not allow.

use piezoid_numerics::error::Error;
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

/// The letters of the bytes 0x80 to 0x9f in Windows-1252. All others are the first letters of Unicode.
const WINDOWS_1252: [char; 32] = [
    '\u{20ac}', '\u{81}', '\u{201a}', '\u{192}', '\u{201e}', '\u{2026}', '\u{2020}', '\u{2021}', //
    '\u{2c6}', '\u{2030}', '\u{160}', '\u{2039}', '\u{152}', '\u{8d}', '\u{17d}', '\u{8f}', //
    '\u{90}', '\u{2018}', '\u{2019}', '\u{201c}', '\u{201d}', '\u{2022}', '\u{2013}', '\u{2014}', //
    '\u{2dc}', '\u{2122}', '\u{161}', '\u{203a}', '\u{153}', '\u{9d}', '\u{17e}', '\u{178}',
];

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Cow<'_, str> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let letters = char::decode_utf16(pairs.iter().map(|pair| unit(*pair)));
    let cut = (!rest.is_empty()).then_some(char::REPLACEMENT_CHARACTER);
    letters.map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER)).chain(cut).collect::<String>().into()
}

/// A text in Windows-1252 from a line on. A file that begins with control characters is not text.
fn windows_1252(bytes: &[u8], line: u64) -> Result<Cow<'_, str>, Error> {
    let control = |b: &u8| *b < b' ' && !b"\t\n\r\x0c\x1a".contains(b);
    if line == 1 && bytes.iter().take(4096).any(control) {
        let invalid = std::str::from_utf8(bytes).map_or_else(|error| error.valid_up_to(), str::len);
        let (byte, line) = (bytes.get(invalid).copied().unwrap_or_default(), line + ends_before(bytes, invalid));
        return Err(Error::Content(format!(
            "this is not text with columns: byte 0x{byte:02x} on line {line} is not text; if it is another format, \
             give it the right extension"
        )));
    }
    let special = |byte: u8| WINDOWS_1252.get(usize::from(byte.checked_sub(0x80)?)).copied();
    Ok(bytes.iter().map(|byte| special(*byte).unwrap_or(char::from(*byte))).collect::<String>().into())
}

/// How a text is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    /// ASCII so far.
    Ascii,
    /// UTF-8.
    Utf8,
    /// Windows-1252, which is what is not UTF-8.
    Windows,
    /// UTF-16, the lower byte first.
    Little,
    /// UTF-16, the higher byte first.
    Big,
}

impl Encoding {
    /// The encoding of a text that begins with these bytes, and the length of its byte-order mark. The mark gives the
    /// encoding, or else the bytes.
    pub(super) fn of(bytes: &[u8]) -> Result<(Encoding, usize), Error> {
        let (encoding, mark) = match bytes {
            [0xef, 0xbb, 0xbf, ..] => (Encoding::Utf8, 3),
            [0xff, 0xfe, ..] => (Encoding::Little, 2),
            [0xfe, 0xff, ..] => (Encoding::Big, 2),
            [a, 0, b, 0, ..] if *a > 0 && *b > 0 => (Encoding::Little, 0),
            [0, a, 0, b, ..] if *a > 0 && *b > 0 => (Encoding::Big, 0),
            _ => (Encoding::Ascii, 0),
        };
        match OTHERS.iter().find(|(start, _)| bytes[mark..].starts_with(start)) {
            Some((_, kind)) => Err(Error::Content(format!("this is not text with columns but {kind}"))),
            None => Ok((encoding, mark)),
        }
    }

    /// The end of the last line in these bytes, if lines end with this letter.
    pub(super) fn end_of_lines(self, bytes: &[u8], end: u8) -> Option<usize> {
        let unit = |pair: [u8; 2]| bytes.as_chunks::<2>().0.iter().rposition(|found| *found == pair).map(|k| 2 * k + 2);
        match self {
            Encoding::Little => unit([end, 0]),
            Encoding::Big => unit([0, end]),
            Encoding::Ascii | Encoding::Utf8 | Encoding::Windows => {
                bytes.iter().rposition(|found| *found == end).map(|k| k + 1)
            }
        }
    }

    /// The encoding of text whose first bytes beyond ASCII may be among these: what is not UTF-8 is Windows-1252.
    pub(super) fn with(self, bytes: &[u8]) -> Self {
        match self {
            Encoding::Ascii if bytes.is_ascii() => self,
            Encoding::Ascii if std::str::from_utf8(bytes).is_ok() => Encoding::Utf8,
            Encoding::Ascii => Encoding::Windows,
            other => other,
        }
    }

    /// The text of bytes that begin on a line, from 1. What stands for no letter becomes U+FFFD.
    pub(super) fn decode(self, bytes: &[u8], line: u64) -> Result<Cow<'_, str>, Error> {
        let text = match self {
            Encoding::Ascii | Encoding::Utf8 => String::from_utf8_lossy(bytes),
            Encoding::Little => utf16(bytes, u16::from_le_bytes),
            Encoding::Big => utf16(bytes, u16::from_be_bytes),
            Encoding::Windows => windows_1252(bytes, line)?,
        };
        match text.find('\0') {
            None => Ok(text),
            Some(at) => {
                let problem = "a NUL byte, which is not allowed in text: the file is damaged from here on (was it \
                               written completely?)";
                Err(Error::line(line + ends_before(text.as_bytes(), at), problem))
            }
        }
    }
}

/// The text of a whole file, without its byte-order mark.
#[cfg(any(feature = "foreign", test))]
pub(in crate::formats) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, Error> {
    let (encoding, mark) = Encoding::of(bytes)?;
    encoding.with(&bytes[mark..]).decode(&bytes[mark..], 1)
}

/// The lines with their numbers, from 1. A line ends with a line feed, a carriage return, or both.
pub(in crate::formats) fn lines(text: &str) -> impl Iterator<Item = (u64, &str)> + Clone {
    let end = if text.contains('\n') { '\n' } else { '\r' };
    // A carriage return before a line feed remains; readers of cells treat it as a space.
    (1..).zip(text.split(end))
}

/// Number of ends of lines before a position.
fn ends_before(bytes: &[u8], at: usize) -> u64 {
    let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
    bytes.iter().take(at).filter(|b| **b == end).count() as u64
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
    fn older_programs_write_signs_that_unicode_has_elsewhere() {
        let bytes = b"\x80 \x81 \x8c \x96 \x9f \xa0 \xb5 \xff\n";
        let signs = "\u{20ac} \u{81} \u{152} \u{2013} \u{178} \u{a0} \u{b5} \u{ff}\n";
        assert_eq!(decode(bytes).unwrap(), signs);
    }

    #[test]
    fn damaged_letters_are_replaced() {
        let cases: [(&[u8], &str); 3] = [
            (b"\xEF\xBB\xBFa\xB5b", "a\u{fffd}b"),
            (b"\xFF\xFEa\0\x00\xD8b\0", "a\u{fffd}b"),
            (b"\xFE\xFF\0ab", "a\u{fffd}"),
        ];
        for (bytes, text) in cases {
            assert_eq!(decode(bytes).unwrap(), text, "{bytes:?}");
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
