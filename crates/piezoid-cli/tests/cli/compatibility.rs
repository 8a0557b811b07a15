//! Files of every version so far: crates/piezoid/tests/compatibility.

use crate::bench::Bench;
use crate::fmu::{fmpy, python, there};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The folders of the versions.
fn versions() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../piezoid/tests/compatibility");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.is_dir()).collect()
}

/// A directory with the files of these folders.
fn with(folders: &[PathBuf]) -> Bench {
    let bench = Bench::new();
    for file in folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap()) {
        let file = file.unwrap();
        bench.write(file.file_name().to_str().unwrap(), std::fs::read(file.path()).unwrap());
    }
    bench
}

/// The lines of a text without its remarks: names of columns, and numbers.
fn numbers(csv: &str) -> Vec<&str> {
    csv.lines().filter(|line| !line.starts_with('#')).collect()
}

#[test]
fn this_version_keeps_files_for_later_ones() {
    let names: Vec<_> = versions().iter().map(|path| path.file_name().unwrap().to_owned()).collect();
    assert!(names.iter().any(|name| name == env!("CARGO_PKG_VERSION")), "{names:?}");
}

#[test]
fn files_of_every_version_are_read_and_give_the_same_numbers() {
    for version in versions() {
        let bench = with(&[version.join("given")]);
        let commands = std::fs::read_to_string(version.join("commands.txt")).unwrap();
        for line in commands.lines() {
            bench.run(line.strip_prefix("piezoid ").unwrap()).ok();
            let written = line.split_whitespace().last().unwrap();
            let expected = std::fs::read_to_string(version.join("expected").join(written)).unwrap();
            assert_eq!(numbers(&bench.text(written)), numbers(&expected), "{line}, {}", version.display());
        }
    }
}

#[test]
fn code_of_every_version_finds_no_number_that_differs() {
    if !there("cc", &["--version"], "cc") {
        return;
    }
    for version in versions() {
        let bench = with(&[version.join("exports")]);
        let mut cc = Command::new("cc");
        cc.current_dir(bench.path("")).args(["-std=c99", "-O2", "-ffp-contract=off", "joint.c", "joint_test.c"]);
        assert!(cc.args(["-lm", "-o", "joint_test"]).status().unwrap().success(), "{}", version.display());
        let test = Command::new(bench.path("joint_test")).output().unwrap();
        assert!(test.status.success(), "{}: {test:?}", version.display());
    }
}

#[test]
fn fmus_of_every_version_simulate_what_this_one_simulates() {
    if !fmpy() {
        return;
    }
    for version in versions() {
        let bench = with(&["given", "expected", "exports"].map(|part| version.join(part)));
        python(&bench, "simulates joint_fmi2.fmu,joint.csv").ok();
    }
}
