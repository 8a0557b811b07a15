//! `cargo xtask generate [--check] [PART...]`: everything in the repository that a program writes.
//!
//! With `--check` the files stay as they are, and those that would change are named. Without parts it does those that
//! take seconds; the others are done by name.

use crate::{cargo, python, root, step, tidy, web};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Something generated.
struct Part {
    name: &'static str,
    summary: &'static str,
    /// The files that it writes, or folders of them.
    writes: &'static [&'static str],
    /// True if it takes seconds and needs cargo alone.
    is_quick: bool,
    run: fn() -> Result<(), String>,
}

/// What the operators give in this version.
const OPERATORS: &str = concat!("crates/piezoid/tests/compatibility/", env!("CARGO_PKG_VERSION"), "/operators");

const PARTS: [Part; 6] = [
    Part {
        name: "bindings",
        summary: "what Python, the page and docs/reference.md state of options, from their rows",
        writes: &["crates/piezoid-py/python/piezoid/_options.py", "web/src/catalogue.ts", "docs/reference.md"],
        is_quick: true,
        run: || step(&mut cargo(&["run", "--quiet", "--package", "piezoid-bindings"])),
    },
    Part {
        name: "vectors",
        summary: "the inputs and outputs of every operator, for the tests of exports",
        writes: &[OPERATORS],
        is_quick: true,
        run: || measured("vectors", &[], OPERATORS),
    },
    Part {
        name: "page",
        summary: "the page of `piezoid serve` and the figures of reports (npm)",
        writes: &web::COMMITTED,
        is_quick: false,
        run: web::scripts,
    },
    Part {
        name: "golden",
        summary: "the golden numbers of the tests (Python with numpy and scipy)",
        writes: &["crates/testing/golden"],
        is_quick: false,
        run: golden,
    },
    Part {
        name: "docs",
        summary: "the tables and figures of docs/, measured (minutes)",
        writes: &["docs"],
        is_quick: false,
        run: || {
            let pages = ["paper", "operators", "accuracy", "control", "feedback", "stand-in"];
            pages.iter().try_for_each(|page| measured(page, &["--release"], "docs"))
        },
    },
    Part {
        name: "evidence",
        summary: "docs/evidence.md, from measured records that PIEZOID_DATA names (half an hour)",
        writes: &["docs/evidence.md", "docs/evidence-stack.svg", "docs/evidence-mirror.svg"],
        is_quick: false,
        run: || measured("evidence", &["--release"], "docs"),
    },
];

/// Writes the parts that are named, or those that take seconds.
pub(crate) fn generate() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(2).collect();
    let (flags, names): (Vec<&str>, Vec<&str>) =
        arguments.iter().map(String::as_str).partition(|argument| argument.starts_with("--"));
    let unknown = flags.iter().find(|flag| **flag != "--check");
    if let Some(name) = unknown.or(names.iter().find(|name| !PARTS.iter().any(|part| part.name == **name))) {
        let parts: Vec<String> = PARTS.iter().map(|part| format!("  {:10}{}", part.name, part.summary)).collect();
        return Err(format!("there is no `{name}`: give --check, or some of\n{}", parts.join("\n")));
    }
    let chosen = |part: &&Part| if names.is_empty() { part.is_quick } else { names.contains(&part.name) };
    PARTS.iter().filter(chosen).try_for_each(|part| if flags.is_empty() { (part.run)() } else { check(part) })
}

/// The error if a part would change a file; then all its files are as before.
fn check(part: &Part) -> Result<(), String> {
    let before = contents(part.writes);
    (part.run)()?;
    let after = contents(part.writes);
    let names = before.keys().chain(after.keys());
    let changed: BTreeSet<&PathBuf> = names.filter(|name| before.get(*name) != after.get(*name)).collect();
    for name in &changed {
        let restored = match before.get(*name) {
            Some(bytes) => std::fs::write(name, bytes),
            None => std::fs::remove_file(name),
        };
        restored.map_err(|e| format!("{}: {e}", name.display()))?;
    }
    let names = changed.iter().map(|name| name.strip_prefix(root()).unwrap_or(name).display().to_string());
    match names.collect::<Vec<_>>().join(", ") {
        names if names.is_empty() => Ok(()),
        names => Err(format!("not as generated: {names}: run `cargo xtask generate {}`", part.name)),
    }
}

/// The files of these paths, with those in folders.
fn contents(paths: &[&str]) -> BTreeMap<PathBuf, Vec<u8>> {
    fn add(path: &Path, all: &mut BTreeMap<PathBuf, Vec<u8>>) {
        if let Ok(entries) = std::fs::read_dir(path) {
            entries.flatten().for_each(|entry| add(&entry.path(), all));
        } else if let Ok(bytes) = std::fs::read(path) {
            all.insert(path.into(), bytes);
        }
    }
    let mut all = BTreeMap::new();
    paths.iter().for_each(|path| add(&root().join(path), &mut all));
    all
}

/// What piezoid-bench measures and writes.
fn measured(what: &str, flags: &[&str], folder: &str) -> Result<(), String> {
    step(cargo(&["run", "--quiet", "--package", "piezoid-bench"]).args(flags).args(["--", what, folder]))
}

fn golden() -> Result<(), String> {
    let scripts = tidy::files(&root().join("crates/testing/golden"), "py");
    scripts.iter().try_for_each(|script| step(python().arg(script)))
}
