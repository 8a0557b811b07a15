//! A temporary directory for a test, and the result of a command in it.

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;

/// Records and a model of the paper's plant, created once by the binary itself: `prbs.csv`, `sine5.csv`, `sine20.csv`
/// (records), `drive5.csv` (a drive signal) and `model.json`.
static STOCK: OnceLock<BTreeMap<String, Vec<u8>>> = OnceLock::new();

/// A separate directory for one test.
pub(crate) struct Bench {
    dir: TempDir,
}

impl Bench {
    /// An empty directory.
    pub(crate) fn new() -> Self {
        Bench { dir: tempfile::Builder::new().prefix("bench-").tempdir().unwrap() }
    }

    /// A directory with records and a model of the paper's plant.
    pub(crate) fn stocked() -> Self {
        let bench = Bench::new();
        for (name, bytes) in STOCK.get_or_init(stock) {
            bench.write(name, bytes);
        }
        bench
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }

    /// All files with their bytes, by path below the directory.
    pub(crate) fn files(&self) -> BTreeMap<String, Vec<u8>> {
        self.everything().into_iter().filter(|(name, _)| !name.ends_with('/')).collect()
    }

    /// All files with their bytes, and all folders, whose names end with a slash.
    pub(crate) fn everything(&self) -> BTreeMap<String, Vec<u8>> {
        let mut files = BTreeMap::new();
        let mut folders = vec![self.dir.path().to_path_buf()];
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
                let path = entry.path();
                let name = path.strip_prefix(self.dir.path()).unwrap().to_str().unwrap().replace('\\', "/");
                if path.is_dir() {
                    files.insert(name + "/", Vec::new());
                    folders.push(path);
                } else if path.is_file() {
                    files.insert(name, std::fs::read(&path).unwrap());
                }
            }
        }
        files
    }

    pub(crate) fn names(&self) -> Vec<String> {
        self.files().into_keys().collect()
    }

    /// The binary with the words of `line` as arguments, to be started in this directory.
    pub(crate) fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_piezoid"));
        command.current_dir(self.dir.path()).env_remove("COLUMNS").args(line.split_whitespace());
        command
    }

    /// Runs the binary with the words of `line` as arguments.
    pub(crate) fn run(&self, line: &str) -> Run {
        Run::of(line, &self.command(line).output().unwrap())
    }

    /// Runs a command that must fail with status 1 and one message, and must not change the directory.
    pub(crate) fn refused(&self, line: &str) -> Run {
        self.fails(line, 1)
    }

    /// The same with status 2, for an error in the command line.
    pub(crate) fn misused(&self, line: &str) -> Run {
        self.fails(line, 2)
    }

    fn fails(&self, line: &str, code: i32) -> Run {
        let before = self.files();
        let run = self.run(line).exits(code);
        assert_eq!(run.err.matches("error:").count(), 1, "{run:?}");
        assert!(run.err.starts_with("error: ") && run.err.ends_with('\n') && run.err.lines().count() == 1, "{run:?}");
        assert_eq!(run.out, "", "{run:?}");
        let after = self.files();
        assert!(before == after, "{run:?} left {:?}, there were {:?}", after.keys(), before.keys());
        run
    }
}

/// Result of a command.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) line: String,
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Run {
    pub(crate) fn of(line: &str, output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        Run { line: line.into(), code: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
    }

    pub(crate) fn exits(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{}: {self:#?}", self.line);
        self
    }

    /// Asserts that the command succeeded.
    pub(crate) fn ok(self) -> Self {
        self.exits(0)
    }

    /// Asserts that stderr contains all of this.
    pub(crate) fn says(self, parts: &[&str]) -> Self {
        for part in parts {
            assert!(self.err.contains(part), "`{part}` is missing: {self:#?}");
        }
        self
    }

    /// Asserts that stdout contains all of this.
    pub(crate) fn prints(self, parts: &[&str]) -> Self {
        for part in parts {
            assert!(self.out.contains(part), "`{part}` is missing: {self:#?}");
        }
        self
    }

    pub(crate) fn out_json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {self:#?}"))
    }
}

/// A number in a document.
pub(crate) fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

fn stock() -> BTreeMap<String, Vec<u8>> {
    let bench = Bench::new();
    bench.run("excite prbs --ts 5e-4 --duration 2.0475 --amplitude 1 --order 12 -o drive.csv").ok();
    bench.run("simulate --plant paper --input drive.csv -o prbs.csv").ok();
    for hz in [5, 20] {
        let drive = format!("drive{hz}.csv");
        bench.run(&format!("excite sine --ts 5e-4 --duration 1 --amplitude 30 --frequency {hz} -o {drive}")).ok();
        bench.run(&format!("simulate --plant paper --input {drive} -o sine{hz}.csv")).ok();
    }
    bench.run("identify sine5.csv sine20.csv --method paper --small-signal prbs.csv -o model.json").ok();
    bench.files().into_iter().filter(|(name, _)| !["drive.csv", "drive20.csv"].contains(&name.as_str())).collect()
}
