//! The project's own automation: `cargo xtask test|tidy|generate|python|book|web|bench|fuzz|mutants|release`.
//!
//! Needs a Rust toolchain with rustfmt and clippy; all except `tidy` and `generate` use Python 3 too. Messages name
//! what is missing.

mod book;
mod generate;
mod mutants;
mod release;
mod skipped;
mod tidy;
mod web;
mod words;

use skipped::Skipped;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus};
use std::time::Instant;

/// The work of a verb; the error names the step that failed.
type Work = fn() -> Result<(), String>;

/// The verbs with their descriptions.
const VERBS: [(&str, &str, Work); 10] = [
    (
        "test",
        "format, clippy with warnings denied, all tests, documentation, `tidy`, then the page and `python` at once",
        test,
    ),
    ("tidy", "what ARCHITECTURE.md says must stay true, as far as a program can tell; after `cargo doc`", tidy::tidy),
    ("python", "the Python package and its tests (makes its own environment in target/python)", python_package),
    ("book", "the book in target/book, its commands run and its links checked (mdbook); --check", book::book),
    (
        "web",
        "the page and its modules in web/dist, the plots of reports, and their tests (Node.js, Chromium)",
        web::web,
    ),
    ("bench", "all benches, then beside other tools (Python, its own environment); `-- NAME`: one bench", bench),
    ("fuzz", "damaged files of every format, models, plants and profiles, for a minute each (cargo-fuzz)", fuzz),
    (
        "mutants",
        "changes of the code that tests should notice, 200 of them or by path (cargo-mutants)",
        mutants::mutants,
    ),
    (
        "release",
        "programs, wheels, page, examples, checksums in target/dist, from the tag of the version; --rehearsal: any commit",
        release::release,
    ),
    ("generate", "write what is generated: bindings, vectors; by name page, golden, docs; --check", generate::generate),
];

fn main() -> ExitCode {
    let expected = std::env::args().nth(1).unwrap_or_default();
    let Some((_, _, run)) = VERBS.iter().find(|(name, ..)| *name == expected) else {
        eprintln!("usage: cargo xtask VERB");
        VERBS.iter().for_each(|(name, what, _)| eprintln!("  {name:10}{what}"));
        return ExitCode::from(2);
    };
    let start = Instant::now();
    match run() {
        Ok(()) => {
            eprintln!("xtask {expected}: all well, {:.0} s", start.elapsed().as_secs_f64());
            ExitCode::SUCCESS
        }
        Err(what) => {
            eprintln!("xtask {expected}: {what}");
            ExitCode::FAILURE
        }
    }
}

/// Reads damaged files of every format, and uses damaged models, plants and profiles, for a minute each; what fails is
/// kept in fuzz/artifacts.
fn fuzz() -> Result<(), String> {
    // The fuzzer needs flags of the compiler that are not stable.
    let fuzzer = |verb: &str| {
        let mut command = cargo(&["fuzz", verb, "--fuzz-dir", "fuzz"]);
        command.current_dir(root()).env("RUSTC_BOOTSTRAP", "1");
        command
    };
    let listed = fuzzer("list").output().map_err(|e| e.to_string())?;
    if !listed.status.success() {
        return Err("`cargo fuzz` is missing: install it with `cargo install cargo-fuzz`".into());
    }
    for target in String::from_utf8_lossy(&listed.stdout).lines() {
        let corpus = format!("fuzz/corpus/{target}");
        std::fs::create_dir_all(root().join(&corpus)).map_err(|e| format!("{corpus}: {e}"))?;
        let mut run = fuzzer("run");
        let seeds: &[&str] = match target {
            "model" => &["fuzz/models"],
            "plant" => &["fuzz/plants"],
            "profile" => &["fuzz/profiles"],
            _ => &["fuzz/seeds", "crates/testing/golden/formats"],
        };
        run.args([target, &corpus]).args(seeds).arg("--");
        step(run.args(["-max_total_time=60", "-max_len=16384", "-timeout=10", "-print_final_stats=1"]))?;
    }
    Ok(())
}

/// The target for web browsers.
const WEB: &str = "wasm32-unknown-unknown";

fn test() -> Result<(), String> {
    for (component, arguments) in [("rustfmt", ["fmt", "--version"]), ("clippy", ["clippy", "--version"])] {
        let there = cargo(&arguments).output().is_ok_and(|o| o.status.success());
        if !there {
            return Err(format!(
                "`cargo {}` is missing: install it with `rustup component add {component}`",
                arguments[0]
            ));
        }
    }
    let mut skipped = Skipped::default();
    step(&mut cargo(&["fmt", "--all", "--check"]))?;
    step(&mut cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))?;
    step(cargo(&["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"))?;
    tidy::tidy()?;
    build_workspace()?;
    // Many tests wait: for a simulated controller, or for a program that they have started.
    let threads = 2 * std::thread::available_parallelism().map_or(1, usize::from);
    skipped.step(cargo(&["test", "--workspace"]).env("RUST_TEST_THREADS", threads.to_string()))?;
    match book::available() {
        Err(missing) if std::env::var_os("CI").is_none() => skipped.add("the book", &missing),
        available => available.and_then(|()| book::of_built(true))?,
    }
    // Each of these keeps about one core busy.
    let mut of_page = Skipped::default();
    let (page, python) = std::thread::scope(|scope| {
        let page = scope.spawn(|| web::page(&mut of_page));
        let python = python_tests(&mut skipped);
        (page.join().unwrap_or_else(|_| Err("the tests of the page stopped".into())), python)
    });
    let failed: Vec<String> = [page, python].into_iter().filter_map(Result::err).collect();
    if !failed.is_empty() {
        return Err(failed.join("; "));
    }
    eprint!("{}", skipped.and(of_page));
    Ok(())
}

/// True if code for web browsers can be built; otherwise `test` is added to `skipped`, and in CI this is an error.
fn for_the_web(skipped: &mut Skipped, test: &str) -> Result<bool, String> {
    let sysroot = Command::new("rustc").args(["--print", "sysroot"]).output().map(|o| o.stdout).unwrap_or_default();
    let installed = Path::new(String::from_utf8_lossy(&sysroot).trim()).join("lib/rustlib").join(WEB).is_dir();
    let missing = format!("no target {WEB}: rustup target add {WEB}");
    match (installed, std::env::var_os("CI")) {
        (false, Some(_)) => Err(missing),
        (false, None) => {
            skipped.add(test, &missing);
            Ok(false)
        }
        (true, _) => Ok(true),
    }
}

/// Builds all that is built for tests, with the features of the whole workspace: what is then tried outside of
/// `cargo test` needs no second build.
fn build_workspace() -> Result<(), String> {
    step(&mut cargo(&["build", "--workspace", "--lib", "--bins", "--tests", "--examples"]))
}

/// The file that [`build_workspace`] made.
fn built(file: &str) -> PathBuf {
    target().join("debug").join(file)
}

fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), |d| root().join(d))
}

/// Writes the files of the repository, as they are staged, into a new folder.
fn copy_staged(into: &Path) -> Result<(), String> {
    let _ = std::fs::remove_dir_all(into);
    step(Command::new("git").args(["checkout-index", "--all"]).arg(format!("--prefix={}/", into.display())))
}

/// Installs the Python package in a separate environment, and runs its tests there.
fn python_package() -> Result<(), String> {
    let mut skipped = Skipped::default();
    python_tests(&mut skipped)?;
    eprint!("{skipped}");
    Ok(())
}

/// The same as [`python_package`]; adds what is missing to `skipped`. In CI this is an error.
fn python_tests(skipped: &mut Skipped) -> Result<(), String> {
    let home = root().join("target/python");
    let inside = || Command::new(home.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" }));
    let package = root().join("crates/piezoid-py");
    let ready = || {
        if !home.join("pyvenv.cfg").exists() {
            step(python().args(["-m", "venv"]).arg(&home))?;
        }
        step(inside().arg("xtask/src/install.py").arg(&package).args(["plot", "learn", "fleet", "progress", "test"]))
    };
    match ready() {
        Err(what) if std::env::var_os("CI").is_none() => {
            let missing = format!("no Python 3.11 with venv, or no packages from PyPI ({what})");
            skipped.add("the Python package, all tests", &missing);
            return Ok(());
        }
        ready => ready?,
    }
    build_workspace()?;
    let library = format!("{}_piezoid{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let module = package.join("python/piezoid").join(if cfg!(windows) { "_piezoid.pyd" } else { "_piezoid.abi3.so" });
    std::fs::copy(built(&library), &module).map_err(|e| format!("{}: {e}", module.display()))?;
    let settings = package.join("pyproject.toml");
    skipped.step(inside().args(["-m", "pytest", "-rs", "--config-file"]).arg(settings).arg(package.join("tests")))
}

/// All benches and the comparison with other tools, or the bench that is named after `--`, with its arguments.
fn bench() -> Result<(), String> {
    let words: Vec<String> = std::env::args().skip(2).filter(|word| word != "--").collect();
    if let Some((name, words)) = words.split_first() {
        return step(cargo(&["bench", "--package", "piezoid-bench", "--bench", name, "--"]).args(words));
    }
    step(&mut cargo(&["bench", "--package", "piezoid-bench"]))?;
    step(python().arg(root().join("bench/side_by_side.py")))
}

/// Runs a command in the workspace, and shows its output.
fn step(command: &mut Command) -> Result<(), String> {
    let line = announced(command);
    let status = command.current_dir(root()).status().map_err(|e| format!("cannot start `{line}`: {e}"))?;
    succeeded(&line, status)
}

/// Prints a command that is about to run, and returns what was printed.
fn announced(command: &Command) -> String {
    let line: Vec<_> = std::iter::once(command.get_program()).chain(command.get_args()).collect();
    let line = line.iter().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
    eprintln!("== {line}");
    line
}

fn succeeded(line: &str, status: ExitStatus) -> Result<(), String> {
    if status.success() { Ok(()) } else { Err(format!("`{line}` failed ({status})")) }
}

fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments);
    command
}

fn python() -> Command {
    Command::new(if cfg!(windows) { "python" } else { "python3" })
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}
