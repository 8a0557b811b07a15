//! The commands and the C of the chapters, run as they are printed.
//!
//! - ```` ```sh ```` is run by `sh -e`. The commands of the first hour begin in an empty folder, those of every other
//!   chapter in a copy of the folder of the first hour.
//! - ```` ```output ```` must stand in what the block before it printed; three dots stand for anything.
//! - ```` ```c ```` blocks of a chapter are compiled as one file, with the headers that its commands have written.
//! - A block that cannot be run says why: ```` ```sh not-run: REASON ````, with a reason of [`REASONS`].
//!
//! Python blocks are run by the tests of the Python package, Rust blocks by `cargo test --doc`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The chapter whose files all others have.
const FIRST: &str = "first-hour";

/// Why a block may not be run.
const REASONS: [&str; 4] = ["needs a controller", "takes minutes", "runs until it is stopped", "needs other data"];

/// How many blocks may not be run.
const NOT_RUN: usize = 15;

/// What stands between two fences.
#[derive(Debug, PartialEq)]
struct Block {
    language: String,
    /// The reason, if it is not run.
    not_run: Option<String>,
    text: String,
    /// Number of the line of its fence.
    line: usize,
}

/// The blocks of a page.
fn blocks(page: &str) -> Vec<Block> {
    let (mut blocks, mut open): (Vec<Block>, Option<Block>) = (Vec::new(), None);
    for (k, line) in page.lines().enumerate() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(fence), None) => {
                let (language, rest) = fence.split_once(' ').unwrap_or((fence, ""));
                let not_run = rest.strip_prefix("not-run: ").map(String::from);
                open = Some(Block { language: language.into(), not_run, text: String::new(), line: k + 1 });
            }
            (None, Some(block)) => block.text.extend([line, "\n"]),
            (None, None) => {}
        }
    }
    blocks
}

/// Runs all chapters of `docs`, each in a folder of its name in `work`.
pub(super) fn run(docs: &Path, work: &Path, piezoid: &Path) -> Result<(), String> {
    let mut pages = Vec::new();
    for file in crate::tidy::files(docs, "md") {
        let name = file.strip_prefix(docs).unwrap_or(&file).with_extension("").display().to_string();
        pages.push((name, blocks(&crate::tidy::read(&file)?)));
    }
    pages.sort_by_key(|(name, _)| (name != FIRST, name.clone()));
    let mut left: BTreeMap<String, usize> = BTreeMap::new();
    for (name, blocks) in &pages {
        for block in blocks {
            let Some(reason) = &block.not_run else { continue };
            if !REASONS.contains(&reason.as_str()) {
                return Err(format!("docs/{name}.md:{}: `{reason}` is none of {}", block.line, REASONS.join(", ")));
            }
            *left.entry(reason.clone()).or_default() += 1;
        }
        if blocks.iter().any(|block| block.not_run.is_none() && ["sh", "c"].contains(&block.language.as_str())) {
            let folder = work.join(name);
            copy(&work.join(FIRST), &folder).map_err(|e| format!("{}: {e}", folder.display()))?;
            let start = std::time::Instant::now();
            chapter(name, blocks, &folder, piezoid)?;
            eprintln!("book: {name}, {:.1} s", start.elapsed().as_secs_f64());
        }
    }
    left.iter().for_each(|(reason, n)| eprintln!("book: {n} blocks not run: {reason}"));
    match left.values().sum::<usize>() {
        n if n > NOT_RUN => Err(format!("{n} blocks of the book are not run, {NOT_RUN} at most: run some of them")),
        _ => Ok(()),
    }
}

fn chapter(name: &str, blocks: &[Block], folder: &Path, piezoid: &Path) -> Result<(), String> {
    let place = |block: &Block| format!("docs/{name}.md:{}", block.line);
    let mut printed = String::new();
    for block in blocks.iter().filter(|block| block.not_run.is_none()) {
        if block.language == "sh" {
            printed = shell(&block.text, folder, piezoid).map_err(|e| format!("{}: {e}", place(block)))?;
        } else if block.language == "output" && !contains(&printed, &block.text) {
            return Err(format!("{}: not printed; this was:\n{printed}", place(block)));
        }
    }
    let c: Vec<&str> = blocks.iter().filter(|block| block.language == "c").map(|block| block.text.as_str()).collect();
    if c.is_empty() {
        return Ok(());
    }
    std::fs::write(folder.join("blocks.c"), c.concat()).map_err(|e| format!("docs/{name}.md: {e}"))?;
    let mut compiler = String::from("cc -std=c99 -Wall -Wextra -Werror -c blocks.c -o blocks.o");
    let headers = crate::tidy::files(folder, "h");
    headers.iter().filter_map(|file| file.parent()).for_each(|p| compiler += &format!(" -I '{}'", p.display()));
    shell(&compiler, folder, piezoid).map(|_| ()).map_err(|e| format!("docs/{name}.md: C: {e}"))
}

/// What the commands print, stdout and stderr.
fn shell(text: &str, folder: &Path, piezoid: &Path) -> Result<String, String> {
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let own = piezoid.parent().map(Path::to_path_buf);
    let paths =
        std::env::join_paths(own.into_iter().chain(std::env::split_paths(&paths))).map_err(|e| e.to_string())?;
    let mut command = Command::new("sh");
    command.args(["-e", "-c", &format!("exec 2>&1\n{text}")]).current_dir(folder).env("PATH", paths);
    let output = command.env_remove("COLUMNS").output().map_err(|e| e.to_string())?;
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() { Ok(printed) } else { Err(format!("{}:\n{printed}", output.status)) }
}

/// True if `expected` stands in `printed`; three dots stand for anything.
fn contains(printed: &str, expected: &str) -> bool {
    let plain = |text: &str| text.lines().map(|line| format!("{}\n", line.trim_end())).collect::<String>();
    let (printed, expected) = (plain(printed), plain(expected));
    let mut rest = printed.as_str();
    expected.split("...").all(|part| match rest.find(part) {
        Some(at) => {
            rest = &rest[at + part.len()..];
            true
        }
        None => false,
    })
}

/// Copies a folder with those in it, if it is there; `to` exists afterwards.
fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    if from == to || !from.exists() {
        return Ok(());
    }
    for entry in std::fs::read_dir(from)? {
        let entry = entry?;
        let place: PathBuf = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &place)?;
        } else {
            std::fs::copy(entry.path(), place)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{blocks, contains};

    #[test]
    fn a_fence_states_language_and_reason() {
        let found = blocks("a\n```sh\nls\n```\n```sh not-run: takes minutes\nmake\n```\n");
        assert_eq!((found[0].language.as_str(), found[0].text.as_str(), found[0].line), ("sh", "ls\n", 2));
        assert_eq!(found[1].not_run.as_deref(), Some("takes minutes"));
    }

    #[test]
    fn three_dots_stand_for_anything() {
        assert!(contains("a\nb \nc 1\nd\n", "a\n...\nc ...\nd\n") && contains("a\nb\n", "b\n"));
        assert!(!contains("a\nb\n", "b\n...\na\n") && !contains("a\n", "aa\n"));
    }
}
