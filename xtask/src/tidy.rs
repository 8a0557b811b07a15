//! The invariants of ARCHITECTURE.md that a program can check: `cargo xtask tidy`, after `cargo doc`.

use crate::root;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The crates without input and output.
const PURE: [&str; 12] = [
    "numerics",
    "records",
    "twins",
    "models",
    "identification",
    "validation",
    "control",
    "paper",
    "verbs",
    "piezoid",
    "piezoid-export",
    "piezoid-report",
];

/// The crate of simulated plants, and the only crate of this workspace that it may use: it shares nothing with the
/// models.
const TWINS: (&str, &str) = ("twins", "numerics");

/// Names that read, write, wait or start something.
const SIDE_EFFECTS: [&str; 9] = [
    "std::fs",
    "std::env",
    "std::time",
    "std::net",
    "std::process",
    "std::thread",
    "println!",
    "eprintln!",
    "std::io::std",
];

/// Crates whose types must not be in public signatures; `serde_json::Value` is the exception.
const FOREIGN: [&str; 8] = ["nalgebra", "rand", "rand_chacha", "rand_distr", "rayon", "clarabel", "csv", "minijinja"];

/// Maximum number of public items of the facade.
const ITEMS: usize = 120;

/// Statements of pages on the length of a list: page, phrase with `#` for the number, file and name of the list.
const COUNTS: &[(&str, &str, &str, &str)] = &[
    ("docs/first-hour.md", "# operators", "crates/models/src/hysteresis/mod.rs", "OPERATORS"),
    ("README.md", "one of # operators", "crates/models/src/hysteresis/mod.rs", "OPERATORS"),
    ("docs/choosing.md", "all # operators", "crates/models/src/hysteresis/mod.rs", "OPERATORS"),
    ("docs/operators.md", "piezoid has #", "crates/models/src/hysteresis/mod.rs", "OPERATORS"),
    ("docs/reference.md", "(# kinds)", "crates/records/src/excitation/mod.rs", "EXCITATIONS"),
    ("docs/reference.md", "(# targets)", "crates/piezoid-export/src/lib.rs", "TARGETS"),
    ("docs/reference.md", "# formats are read", "crates/records/src/formats/mod.rs", "FORMATS"),
];

/// Numbers in words, from 0 on.
const WORDS: &str = "no one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen \
                     sixteen seventeen eighteen nineteen twenty";

/// Maximum width of a line of prose; rustfmt checks the code.
const WIDTH: usize = 120;

/// Checks the invariants; the error lists those that do not hold, one per line.
pub(crate) fn tidy() -> Result<(), String> {
    let mut broken = Vec::new();
    let rooms = rooms()?;
    for name in PURE {
        let folder = root().join("crates").join(name).join("src");
        let order = rooms.iter().find(|room| room.name == name).map_or(&[][..], |room| &room.modules);
        for file in files(&folder, "rs") {
            let text = read(&file)?;
            let code = without_tests(&text, &file);
            let name = shown(&file);
            if unknown_powers(&code) {
                broken.push(format!("{name}: uses powi of a variable, which differs on Windows: use numerics' power"));
            }
            broken.extend(SIDE_EFFECTS.iter().filter(|it| code.contains(*it)).map(|it| format!("{name}: uses {it}")));
            // The others use its numbers and matrices; users do not see it.
            if !name.starts_with("crates/numerics/") {
                broken.extend(foreign(&code).into_iter().map(|it| format!("{name}: {it} in a public signature")));
            }
            if let Some(module) = module_of(&file, &folder) {
                broken.extend(upward(&module, &code, order).into_iter().map(|it| format!("{name}: uses crate::{it}")));
            }
        }
        broken.extend(undeclared(&folder, order)?);
    }
    broken.extend(dependencies(&rooms)?);
    // This page is written by a program, which does not wrap it.
    let measured = |file: &PathBuf| file.ends_with("bench/side_by_side.md");
    for file in files(root(), "rs").into_iter().chain(files(root(), "md")).filter(|file| !measured(file)) {
        broken.extend(wide(&file)?);
    }
    for (page, phrase, file, list) in COUNTS {
        broken.extend(miscounted(page, phrase, file, list)?);
    }
    broken.extend(versions()?);
    broken.extend(crate::words::dialect()?);
    broken.extend(public_items()?);
    if broken.is_empty() { Ok(()) } else { Err(format!("tidy:\n  {}", broken.join("\n  "))) }
}

/// True for code with powers whose exponent the compiler may not know.
fn unknown_powers(code: &str) -> bool {
    let is_known = |exponent: &str| exponent.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit());
    !code.split(".powi(").skip(1).all(is_known)
}

/// Files that state another version than Cargo.toml.
fn versions() -> Result<Vec<String>, String> {
    let version = env!("CARGO_PKG_VERSION");
    let states = |file: &str, start: &str| -> Result<Option<String>, String> {
        let text = read(&root().join(file))?;
        let line = text.lines().find(|line| line.starts_with(start)).unwrap_or_default();
        let stated = line.trim_start_matches(start).split(',').next().unwrap_or_default();
        Ok((stated != version).then(|| format!("{file} states version {stated:?}, Cargo.toml {version:?}")))
    };
    Ok([states("CHANGELOG.md", "## ")?, states("CITATION.cff", "version: ")?].into_iter().flatten().collect())
}

/// A crate in the list of ARCHITECTURE.md.
struct Room {
    /// Its folder in `crates`.
    name: String,
    /// Its modules in their order; empty if they are not listed.
    modules: Vec<String>,
}

/// The crates in the order of ARCHITECTURE.md: each may use those before it. Of the modules of a crate, each may use
/// itself and those before it.
fn rooms() -> Result<Vec<Room>, String> {
    let text = read(&root().join("ARCHITECTURE.md"))?;
    let list = text.lines().skip_while(|line| !line.starts_with("crates/")).take_while(|line| *line != "```");
    let mut rooms: Vec<Room> = Vec::new();
    for line in list {
        let first = line.trim_start().split("  ").next().unwrap_or_default();
        if let Some(name) = first.strip_prefix("crates/") {
            let name = name.split_whitespace().next().unwrap_or_default();
            rooms.push(Room { name: name.into(), modules: Vec::new() });
        } else if line.starts_with("  ")
            && !line.starts_with("   ")
            && let Some(room) = rooms.last_mut()
        {
            room.modules.extend(first.split_whitespace().map(|name| name.trim_end_matches('/').to_string()));
        }
    }
    Ok(rooms)
}

/// The modules of a crate that ARCHITECTURE.md does not list, though it lists others of this crate.
fn undeclared(folder: &Path, order: &[String]) -> Result<Option<String>, String> {
    if order.is_empty() {
        return Ok(None);
    }
    let lib = read(&folder.join("lib.rs"))?;
    let declared = lib.lines().filter_map(|line| line.trim_start_matches("pub ").strip_prefix("mod "));
    let declared = declared.filter_map(|line| line.strip_suffix(';')).filter(|name| *name != "tests");
    let mut missing = declared.filter(|name| !order.iter().any(|listed| listed == name));
    Ok(missing.next().map(|name| format!("ARCHITECTURE.md does not list the module `{name}` of {}", shown(folder))))
}

/// The crates that use a crate below them in the list, and what the twins use but must not use.
fn dependencies(rooms: &[Room]) -> Result<Vec<String>, String> {
    let mut broken = Vec::new();
    for (place, room) in rooms.iter().enumerate() {
        let file = root().join("crates").join(&room.name).join("Cargo.toml");
        let text = read(&file)?;
        let own = text.split("[dependencies]").nth(1).unwrap_or_default().split("\n[").next().unwrap_or_default();
        let used =
            own.lines().filter_map(|line| line.split(['.', ' ', '=']).next()).filter(|it| it.starts_with("piezoid"));
        for package in used {
            let folder = package.strip_prefix("piezoid-").unwrap_or(package);
            let at = rooms.iter().position(|other| other.name == folder || other.name == package);
            if at.is_none_or(|at| at >= place) {
                broken.push(format!(
                    "{}: uses {package}, which does not stand above it in ARCHITECTURE.md",
                    shown(&file)
                ));
            }
            if room.name == TWINS.0 && folder != TWINS.1 {
                broken.push(format!("{}: uses {package}, but twins must share nothing with models", shown(&file)));
            }
        }
    }
    Ok(broken)
}

/// The module that a file of a crate belongs to; `None` for its tests and for lib.rs.
fn module_of(file: &Path, folder: &Path) -> Option<String> {
    let first = file.strip_prefix(folder).ok()?.components().next()?.as_os_str().to_string_lossy().into_owned();
    let module = first.trim_end_matches(".rs").to_string();
    (!["lib", "testing", "tests"].contains(&module.as_str())).then_some(module)
}

/// The modules that a module uses but must not use.
fn upward<'c>(module: &str, code: &'c str, order: &[String]) -> BTreeSet<&'c str> {
    let place = |name: &str| order.iter().position(|known| known == name);
    let is_end = |c: char| !(c.is_ascii_lowercase() || c == '_');
    let names = code.split("crate::").skip(1).filter_map(|rest| rest.split(is_end).next());
    names.filter(|name| place(name).is_some() && place(name) > place(module)).collect()
}

/// Types of other crates in public signatures.
fn foreign(code: &str) -> Vec<String> {
    let mut types = Vec::new();
    for line in code.lines().map(str::trim_start).filter(|line| line.starts_with("use ")) {
        if FOREIGN.iter().any(|name| line.starts_with(&format!("use {name}::"))) {
            types.extend(words(line).filter(|word| word.starts_with(|c: char| c.is_ascii_uppercase())));
        }
    }
    let mut found: Vec<String> = Vec::new();
    let mut rest = code;
    while let Some(at) = rest.find("\n    pub fn ").into_iter().chain(rest.find("\npub fn ")).min() {
        let signature = &rest[at..];
        let end = signature.find(" {\n").unwrap_or(signature.len());
        found.extend(words(&signature[..end]).filter(|word| types.contains(word)).map(String::from));
        rest = &signature[end..];
    }
    found
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|word| !word.is_empty())
}

/// Lines of prose wider than [`WIDTH`], except tables and links; rustfmt checks the code.
fn wide(file: &Path) -> Result<Vec<String>, String> {
    let text = read(file)?;
    let is_code = file.extension().is_some_and(|extension| extension == "rs");
    let wraps = |line: &str| match is_code {
        // Plain comments are not checked, because those of program texts are printed unchanged.
        true => ["///", "//!"].iter().any(|mark| line.trim_start().starts_with(mark)) && !line.contains("http"),
        false => !line.contains("](") && !line.starts_with('|') && !line.contains("http"),
    };
    let lines = text.lines().enumerate().filter(|(_, line)| line.chars().count() > WIDTH && wraps(line));
    let long = lines.map(|(k, line)| format!("{}:{}: {} columns", shown(file), k + 1, line.chars().count()));
    Ok(long.collect())
}

/// Too many public items, and type names that occur twice, from the lists that `cargo doc` wrote.
fn public_items() -> Result<Vec<String>, String> {
    let (mut count, mut types): (usize, BTreeMap<String, Vec<String>>) = (0, BTreeMap::new());
    for name in ["piezoid", "piezoid_export", "piezoid_report"] {
        let list = root().join("target/doc").join(name).join("all.html");
        let html = std::fs::read_to_string(&list).map_err(|_| "tidy: run `cargo doc --workspace --no-deps` first")?;
        let mut kind = "";
        for part in html.split("<h3 id=\"").skip(1) {
            kind = part.split('"').next().unwrap_or(kind);
            for item in part.split("<li><a href=\"").skip(1) {
                count += usize::from(name == "piezoid");
                let path = item.split_once('>').and_then(|(_, rest)| rest.split('<').next()).unwrap_or_default();
                if ["structs", "enums", "traits", "types"].contains(&kind) {
                    let last = path.rsplit("::").next().unwrap_or_default();
                    types.entry(last.into()).or_default().push(format!("{name}::{path}"));
                }
            }
        }
    }
    let twice =
        types.into_values().filter(|paths| paths.len() > 1).map(|paths| format!("one name: {}", paths.join(", ")));
    let many = (count > ITEMS).then(|| format!("{count} public items of the facade, {ITEMS} at most"));
    eprintln!("tidy: {count} public items of the facade");
    Ok(twice.chain(many).collect())
}

/// The error if a page does not state the number of rows of a list.
fn miscounted(page: &str, phrase: &str, file: &str, list: &str) -> Result<Option<String>, String> {
    let source = read(&root().join(file))?;
    let source: Vec<&str> = source.lines().filter(|line| !line.trim_start().starts_with("#[")).collect();
    let source = source.join("\n");
    let rows = source.split(&format!("pub static {list}: ")).nth(1).and_then(|rest| rest.split(']').nth(1));
    let count = rows.unwrap_or_default().split(',').filter(|row| row.contains("::")).count();
    let word = WORDS.split(' ').nth(count).unwrap_or_default();
    let text = read(&root().join(page))?.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase();
    let sentence = [count.to_string(), word.to_string()].iter().any(|n| text.contains(&phrase.replace('#', n)));
    Ok((!sentence).then(|| format!("{page}: {list} has {count} rows, and \"{phrase}\" with this number is missing")))
}

/// The code of a file without its tests, which are at its end, and without comments.
fn without_tests(text: &str, file: &Path) -> String {
    let is_test = file.file_stem().is_some_and(|stem| stem == "tests" || stem == "testing")
        || file.components().any(|part| part.as_os_str() == "tests");
    let code = if is_test { "" } else { text.split("#[cfg(test)]\nmod ").next().unwrap_or_default() };
    let code = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    code.collect::<Vec<_>>().join("\n")
}

/// The files of a folder with this extension, in order, without those of builds.
pub(crate) fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.sort();
    let skipped = ["target", ".git", "node_modules"];
    paths.retain(|path| !path.file_name().is_some_and(|name| skipped.iter().any(|s| name == *s)));
    let inside = |path: PathBuf| match path.is_dir() {
        true => files(&path, extension),
        false if path.extension().is_some_and(|e| e == extension) => vec![path],
        false => Vec::new(),
    };
    paths.into_iter().flat_map(inside).collect()
}

pub(crate) fn read(file: &Path) -> Result<String, String> {
    std::fs::read_to_string(file).map_err(|e| format!("cannot read {}: {e}", shown(file)))
}

pub(crate) fn shown(file: &Path) -> String {
    file.strip_prefix(root()).unwrap_or(file).display().to_string()
}
