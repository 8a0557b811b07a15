//! Writes what Python, TypeScript and the reference state of options, from the rows of the library: `cargo xtask
//! generate bindings`. A test compares the committed files with the rows.

mod python;
mod reference;
mod typescript;
mod verbs;
mod words;

use std::path::Path;
use std::process::ExitCode;

/// A page of the documentation, and the comments around its tables.
const REFERENCE: &str = "docs/reference.md";
const BEGIN: &str = "<!-- options: written by `cargo xtask generate bindings` -->\n";
const END: &str = "<!-- end of options -->";

/// The files with their contents.
fn files() -> Result<[(&'static str, String); 3], String> {
    let page = read(REFERENCE)?;
    let absent = |line: &str| format!("{REFERENCE} has no line {}: add it", line.trim());
    let (before, rest) = page.split_once(BEGIN).ok_or_else(|| absent(BEGIN))?;
    let (_, after) = rest.split_once(END).ok_or_else(|| absent(END))?;
    Ok([
        ("crates/piezoid-py/python/piezoid/_options.py", python::options()),
        ("web/src/catalogue.ts", typescript::catalogue()),
        (REFERENCE, format!("{before}{BEGIN}\n{}{END}{after}", reference::options())),
    ])
}

fn main() -> ExitCode {
    match write() {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn write() -> Result<(), String> {
    files()?.iter().try_for_each(|(name, text)| std::fs::write(place(name), text).map_err(|e| format!("{name}: {e}")))
}

fn read(name: &str) -> Result<String, String> {
    std::fs::read_to_string(place(name)).map_err(|e| format!("{name}: {e}"))
}

fn place(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

#[cfg(test)]
mod tests {
    #[test]
    fn committed_bindings_are_those_of_the_rows() {
        for (name, text) in super::files().unwrap() {
            assert!(super::read(name).unwrap() == text, "{name} is not current: run `cargo xtask generate bindings`");
        }
    }
}
