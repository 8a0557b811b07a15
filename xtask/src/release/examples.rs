//! The examples of a release: a folder of records, a model, results and exports, written by its programs.

use super::build::{Target, files, write as write_file};
use super::{root, target};
use crate::{announced, succeeded};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The model of README.md in each form.
const EXPORTS: &str = include_str!("examples.txt");

/// Files with a library of the machine that wrote them.
const COMPILED: &str = "fmu";

/// The commands of README.md, then the exports.
fn commands() -> Result<Vec<String>, String> {
    let readme = std::fs::read_to_string(root().join("README.md")).map_err(|e| format!("README.md: {e}"))?;
    let lines = readme.lines().chain(EXPORTS.lines());
    Ok(lines.filter(|line| line.starts_with("piezoid ")).map(String::from).collect())
}

/// The folder in which this program ran the commands.
pub(super) fn write(program: &Path) -> Result<PathBuf, String> {
    run(&[program.into()], "examples")
}

/// What ran the program of another platform, and whether it wrote the same.
pub(super) fn compare(of: &Target, program: &Path, examples: &Path) -> Result<String, String> {
    let found = |runner: &str| Command::new(runner).arg("--version").output().is_ok();
    let Some(runner) = of.runner.filter(|runner| found(runner)) else { return Ok("not run".into()) };
    let folder = run(&[runner.into(), program.into()], of.triple)?;
    let (written, expected) = (files(&folder)?, files(examples)?);
    if written != expected {
        return Err(format!("the program for {} writes other files: {written:?}", of.name));
    }
    let differs = |file: &&PathBuf| std::fs::read(folder.join(file)).ok() != std::fs::read(examples.join(file)).ok();
    let compared = || expected.iter().filter(|file| file.extension().is_none_or(|suffix| suffix != COMPILED));
    match compared().filter(differs).count() {
        0 => Ok(format!("by {runner}: the same {} files as on this machine", compared().count())),
        others => Ok(format!("by {runner}: {others} of {} files differ from this machine's", compared().count())),
    }
}

/// Runs the commands in a new folder.
fn run(program: &[OsString], name: &str) -> Result<PathBuf, String> {
    let folder = target().join("tours").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let lines = commands()?;
    for line in &lines {
        let mut command = Command::new(&program[0]);
        command.args(&program[1..]).args(line.split_whitespace().skip(1)).arg("--quiet").current_dir(&folder);
        let line = announced(&command);
        let status = command.status().map_err(|e| format!("cannot start `{line}`: {e}"))?;
        succeeded(&line, status)?;
    }
    write_file(&folder.join("commands.txt"), (lines.join("\n") + "\n").as_bytes())?;
    Ok(folder)
}
