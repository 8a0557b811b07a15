//! `cargo xtask mutants`: changes the code of the core by one operator or result at a time, and lists the changes that
//! no test of the same crate notices.

use super::{announced, cargo, copy_staged, root, step, succeeded, target};
use std::path::Path;
use std::process::Command;

/// What is changed: folders of the core.
const AREAS: [&str; 7] = [
    "crates/models/src/hysteresis",
    "crates/models/src/linear",
    "crates/identification/src",
    "crates/control/src/compensation",
    "crates/control/src/feedback",
    "crates/validation/src",
    "crates/records/src/formats",
];

/// Number of changes that are tried: of all, every n-th.
const SAMPLE: usize = 200;

/// The sample of all areas, or of the path that is named; a second word is the number of the sample, from 0 on.
pub(super) fn mutants() -> Result<(), String> {
    let words: Vec<String> = std::env::args().skip(2).collect();
    let sample: usize =
        words.get(1).map_or(Ok(0), |word| word.parse()).map_err(|_| "usage: mutants [PATH [NUMBER]]")?;
    let paths = words.first().map_or(AREAS.to_vec(), |path| vec![path.trim_end_matches('/')]);
    let (folder, tree) = (target().join("mutants"), target().join("mutants/tree"));
    copy(&tree)?;
    let mutate = |arguments: &[&str]| {
        let mut command = cargo(&["mutants", "--workspace", "--in-place", "--all-features"]);
        for path in &paths {
            let is_file = root().join(path).is_file();
            command.arg("--file").arg(if is_file { path.to_string() } else { format!("{path}/**") });
        }
        command.args(arguments).current_dir(&tree).env("CARGO_TARGET_DIR", folder.join("target"));
        command
    };
    let listed = mutate(&["--list"]).output().map_err(|e| e.to_string())?;
    if !listed.status.success() {
        return Err("`cargo mutants` is missing: install it with `cargo install cargo-mutants cargo-nextest`".into());
    }
    let total = listed.stdout.iter().filter(|byte| **byte == b'\n').count();
    let samples = total.div_ceil(SAMPLE).max(1);
    let shard = format!("{}/{samples}", sample % samples);
    eprintln!("{total} changes; sample {shard}");
    let mut run = mutate(&["--sharding", "round-robin", "--shard", &shard, "--test-tool", "nextest", "--no-times"]);
    let line = announced(run.arg("--output").arg(&folder).env("CARGO_INCREMENTAL", "1"));
    let status = run.status().map_err(|e| format!("cannot start `{line}`: {e}"))?;
    // 2: some are missed; 3: some tests took too long.
    match status.code() {
        Some(0 | 2 | 3) => {}
        _ => succeeded(&line, status)?,
    }
    step(Command::new("python3").arg("xtask/src/mutants.py").arg(folder.join("mutants.out/outcomes.json")))
}

/// Copies the files as they are staged. There the crates of the core do not have the facade, which only the examples in
/// their documentation use: with it, each change of them would build all crates.
fn copy(tree: &Path) -> Result<(), String> {
    copy_staged(tree)?;
    for area in AREAS {
        let manifest = tree.join(area.split("/src").next().unwrap_or_default()).join("Cargo.toml");
        let reason = |e: std::io::Error| format!("{}: {e}", manifest.display());
        let text = std::fs::read_to_string(&manifest).map_err(reason)?;
        let is_facade = |line: &&str| line.starts_with("piezoid.") || line.starts_with("piezoid = ");
        let others: Vec<&str> = text.lines().filter(|line| !is_facade(line)).collect();
        std::fs::write(&manifest, others.join("\n") + "\n").map_err(reason)?;
    }
    Ok(())
}
