//! The examples of a release: a folder of records, a model, results and exports, written by its programs.

use super::build::{Target, files, write as write_file};
use super::{root, step, target};
use crate::{announced, python, succeeded};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The model of README.md in each form.
const EXPORTS: &str = include_str!("examples.txt");

/// The program of the first hour.
const TOUR: &str = "tour.py";

/// What no program of a release writes.
const WRITTEN_APART: [&str; 2] = ["commands.txt", TOUR];

/// Files with a library of the machine that wrote them.
const COMPILED: &str = "fmu";

/// The commands in the blocks of README.md, then the exports.
fn commands() -> Result<Vec<String>, String> {
    let readme = std::fs::read_to_string(root().join("README.md")).map_err(|e| format!("README.md: {e}"))?;
    let blocks = readme.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    let lines = blocks.chain([EXPORTS]).flat_map(str::lines);
    Ok(lines.filter(|line| line.starts_with("piezoid ")).map(String::from).collect())
}

/// The folder in which this program ran the commands, with them and the program in Python of the first hour.
pub(super) fn write(program: &Path) -> Result<PathBuf, String> {
    let folder = run(&[program.into()], "examples")?;
    write_file(&folder.join("commands.txt"), (commands()?.join("\n") + "\n").as_bytes())?;
    let chapter = std::fs::read_to_string(root().join("docs/first-hour.md")).map_err(|e| e.to_string())?;
    let tour = chapter.split("```python\n").nth(1).and_then(|rest| rest.split("```").next());
    write_file(&folder.join(TOUR), tour.ok_or("docs/first-hour.md has no program in Python")?.as_bytes())?;
    Ok(folder)
}

/// What ran the program of another platform, and whether it wrote the same.
pub(super) fn compare(of: &Target, program: &Path, examples: &Path) -> Result<String, String> {
    let Some(runner) = of.runner else { return Ok("not run".into()) };
    let starts = Command::new(runner).arg(program).arg("--version").output().is_ok_and(|run| run.status.success());
    if !starts {
        return Ok(format!("not run: there is no {runner}, or it cannot start the program"));
    }
    let folder = run(&[runner.into(), program.into()], of.triple)?;
    let (written, mut expected) = (files(&folder)?, files(examples)?);
    expected.retain(|file| !WRITTEN_APART.iter().any(|name| file == Path::new(name)));
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

/// What runs the Python package of this machine: the program of the first hour, in a new environment.
pub(super) fn try_package(wheel: &Path, examples: &Path) -> Result<String, String> {
    let home = target().join("tours/python");
    let _ = std::fs::remove_dir_all(&home);
    step(python().args(["-m", "venv"]).arg(&home))?;
    step(Command::new(home.join("bin/pip")).args(["install", "--quiet"]).arg(wheel))?;
    let mut run = Command::new(home.join("bin/python"));
    let line = announced(run.arg(TOUR).current_dir(examples));
    let status = run.status().map_err(|e| format!("cannot start `{line}`: {e}"))?;
    succeeded(&line, status)?;
    Ok("on this machine: the program of the first hour".into())
}

/// Runs the commands in a new folder.
fn run(program: &[OsString], name: &str) -> Result<PathBuf, String> {
    let folder = target().join("tours").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    for line in commands()? {
        let mut command = Command::new(&program[0]);
        command.args(&program[1..]).args(line.split_whitespace().skip(1)).arg("--quiet").current_dir(&folder);
        let line = announced(&command);
        let status = command.status().map_err(|e| format!("cannot start `{line}`: {e}"))?;
        succeeded(&line, status)?;
    }
    Ok(folder)
}
