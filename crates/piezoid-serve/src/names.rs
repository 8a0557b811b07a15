//! Names of files in the project folder: good on every system, and in this folder alone.

/// Longest name [bytes].
const LONGEST: usize = 200;

/// Names that are devices on Windows, with any extension.
const DEVICES: [&str; 7] = ["con", "prn", "aux", "nul", "conin$", "conout$", "clock$"];

/// Characters that turn the direction of text, so that a name looks like another one.
const TURNS: [char; 12] = [
    '\u{61c}', '\u{200e}', '\u{200f}', '\u{202a}', '\u{202b}', '\u{202c}', '\u{202d}', '\u{202e}', '\u{2066}',
    '\u{2067}', '\u{2068}', '\u{2069}',
];

/// Why `name` cannot be the name of a file; `None` if it can.
pub(crate) fn fault(name: &str) -> Option<String> {
    let stem = name.split('.').next().unwrap_or_default().trim_end().to_ascii_lowercase();
    let numbered = ["com", "lpt"].iter().any(|port| {
        let number = stem.strip_prefix(port).unwrap_or_default();
        number.chars().count() == 1 && number.contains(|c: char| "0123456789¹²³".contains(c))
    });
    let special = name.chars().find(|c| c.is_control() || TURNS.contains(c) || "/\\<>:\"|?*".contains(*c));
    let why = match special {
        _ if name.is_empty() => "it is empty".into(),
        _ if name.len() > LONGEST => format!("it has {} bytes, at most {LONGEST} are possible", name.len()),
        Some(c) => format!("it has the character {c:?}"),
        _ if name.starts_with(['.', ' ']) => "it begins with a dot or a space".into(),
        _ if name.ends_with(['.', ' ']) => "it ends with a dot or a space".into(),
        _ if DEVICES.contains(&&*stem) || numbered => format!("`{stem}` is a device on Windows"),
        _ => return None,
    };
    Some(format!("{name:?} cannot be the name of a file: {why}: choose another name"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_the_folder_and_are_good_on_every_system() {
        for name in ["log.csv", "Messung 3 µm.csv", "a", "console.csv", "com10.csv", "x..y", &"n".repeat(200)] {
            assert_eq!(fault(name), None);
        }
        for (name, why) in [
            ("", "empty"),
            (".", "begins with a dot"),
            ("..", "begins with a dot"),
            (".piezoid-key", "begins with a dot"),
            ("a/b", "'/'"),
            ("..\\b", "'\\\\'"),
            ("a:b", "':'"),
            ("a\nb", "'\\n'"),
            ("a\0", "'\\0'"),
            ("a.", "ends with"),
            ("a ", "ends with"),
            (" a", "begins with a dot or a space"),
            ("NUL", "`nul` is a device"),
            ("con.csv", "`con` is a device"),
            ("Lpt1.tar.gz", "`lpt1` is a device"),
            ("com¹", "is a device"),
            ("CONIN$.csv", "`conin$` is a device"),
            ("clock$", "is a device"),
            ("a\u{202e}vsc.exe", "'\\u{202e}'"),
            (&"n".repeat(201), "201 bytes, at most 200"),
        ] {
            let message = fault(name).unwrap_or_default();
            assert!(message.contains(why), "{name:?}: {message}");
        }
    }
}
