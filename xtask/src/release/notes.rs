//! Release notes: what changed, the files with their sizes and checksums, and what was run before they were handed out.

use super::build::{Release, Target, files, write as write_file};
use super::root;
use crate::python;
use std::fmt::Write;

/// Writes SHA256SUMS and NOTES.md.
pub(super) fn write(release: &Release, built: &[(&Target, String, String)]) -> Result<(), String> {
    let mut sums = String::new();
    let mut table = String::from("| file | size |\n|---|---:|\n");
    for file in files(&release.folder)? {
        let path = release.folder.join(&file);
        let size = std::fs::metadata(&path).map_err(|e| format!("{}: {e}", path.display()))?.len();
        let digest = "import hashlib, sys; print(hashlib.file_digest(open(sys.argv[1], 'rb'), 'sha256').hexdigest())";
        let printed = python().args(["-c", digest]).arg(&path).output().map_err(|e| e.to_string())?;
        let _ = writeln!(sums, "{}  {}", String::from_utf8_lossy(&printed.stdout).trim(), file.display());
        let _ = writeln!(table, "| {} | {:.2} MB |", file.display(), size as f64 / 1e6);
    }
    write_file(&release.folder.join("SHA256SUMS"), sums.as_bytes())?;
    let mut text = format!("# piezoid {}\n\n", release.version);
    if !release.is_tagged {
        text += "A rehearsal: the commit has no tag of this version.\n\n";
    }
    text += "## Files\n\n";
    text += &table;
    text += "\nSHA256SUMS has the checksums. Archives of programs hold completions and manual pages.\n\n## What was run\n\n\
             | platform | commands of the README and all exports | Python package |\n|---|---|---|\n";
    for (target, run, package) in built {
        let _ = writeln!(text, "| {} | {run} | {package} |", target.name);
    }
    text += "\nContainer and page were not tried. `xtask/src/release/chroot.sh` tries them, and program and package without \
             Rust.\n\n## Changes\n\n";
    text += &changes(&release.version)?;
    write_file(&release.folder.join("NOTES.md"), text.as_bytes())
}

/// The section of the version in CHANGELOG.md.
fn changes(version: &str) -> Result<String, String> {
    let log = std::fs::read_to_string(root().join("CHANGELOG.md")).map_err(|e| format!("CHANGELOG.md: {e}"))?;
    let section = log.split("\n## ").find(|section| section.starts_with(&format!("{version},")));
    let section = section.ok_or_else(|| format!("CHANGELOG.md has no section `## {version}, DATE`"))?;
    Ok(section.lines().skip(2).collect::<Vec<_>>().join("\n") + "\n")
}
