//! Rust modules, built by the installed compiler: every operator, in both precisions, with and without `std`.

use crate::{exported, in_both_precisions, models, skipped, there};
use piezoid_export::ExportRequest;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// A folder with all modules, each in both precisions, and the root of the crate.
fn modules() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut modules = Vec::new();
    for (name, model, single) in in_both_precisions(models()) {
        exported("rust", &ExportRequest::new(&model, &name).single(single), folder.path());
        modules.push(format!("pub mod {name};\n"));
    }
    modules.sort();
    std::fs::write(folder.path().join("all.rs"), format!("#![no_std]\n{}", modules.concat())).unwrap();
    folder
}

/// Runs a tool of the Rust installation, if it is there.
fn run(folder: &Path, tool: &str, arguments: &str) {
    if there(tool) {
        let output = Command::new(tool).args(arguments.split_whitespace()).current_dir(folder).output().unwrap();
        let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        assert!(output.status.success(), "{tool} {arguments}\n{text}");
    }
}

#[test]
fn modules_give_the_bits_of_piezoid_optimised_or_not() {
    let folder = modules();
    for level in [0, 3] {
        run(folder.path(), "rustc", &format!("-D warnings --edition 2021 --test -C opt-level={level} all.rs -o all"));
        let done = Command::new(folder.path().join("all")).arg("--quiet").output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stdout));
    }
}

#[test]
fn modules_are_free_of_warnings_in_every_edition_and_as_rustfmt_has_them() {
    let folder = modules();
    for edition in [2018, 2021, 2024] {
        let how = format!("-D warnings --edition {edition} --crate-type lib --emit metadata all.rs");
        // clippy-driver is a compiler, and also reports the compiler's warnings.
        let compiler = if there("clippy-driver") { "clippy-driver" } else { "rustc" };
        run(folder.path(), compiler, &how);
        run(folder.path(), compiler, &format!("--test {how}"));
        run(folder.path(), "rustfmt", &format!("--check --edition {edition} all.rs"));
    }
    let name = models().swap_remove(0).0;
    let main = format!("mod {name};\nfn main() {{\n    {name}::State::new().step(0.0);\n}}\n");
    std::fs::write(folder.path().join("main.rs"), main).unwrap();
    run(folder.path(), "rustc", "-D warnings --edition 2024 main.rs");
}

#[test]
fn modules_are_built_for_a_machine_without_std() {
    let installed = Command::new("rustc").args(["--print", "sysroot"]).output().map(|o| o.stdout).unwrap_or_default();
    let installed = String::from_utf8(installed).unwrap();
    let there = std::path::Path::new(installed.trim()).join("lib/rustlib/thumbv7em-none-eabihf").is_dir();
    if !there {
        return skipped("no target thumbv7em-none-eabihf: rustup target add thumbv7em-none-eabihf");
    }
    run(
        modules().path(),
        "rustc",
        "-D warnings --edition 2024 --crate-type lib --target thumbv7em-none-eabihf -O all.rs",
    );
}
