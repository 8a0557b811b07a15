//! `cargo xtask web`: the modules of the page, the lists, and the scripts, in web/dist.

use super::{Skipped, WEB, announced, build_workspace, built, cargo, for_the_web, root, step, succeeded, target};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::SystemTime;

/// The modules, which are features of piezoid-wasm, and the profiles that they are built by. Limits of their sizes
/// stand in web/tests/sizes.test.mjs.
const MODULES: [(&str, &str); 7] = [
    ("files", "page"),
    ("plans", "page"),
    ("models", "page-search"),
    ("compensation", "page-search"),
    ("reports", "page"),
    ("studies", "page"),
    ("exports", "page"),
];

/// The size of functions that modules of level 3 inline: the default makes that of the search 11 % larger, and no
/// search faster. The others are smaller with the default of their level.
const INLINED_UP_TO: &str = "-Cllvm-args=-inline-threshold=40";

/// What `npm run build` writes outside of web/dist: committed, so that cargo alone builds.
pub(super) const COMMITTED: [&str; 5] = [
    "crates/piezoid-serve/page/icon.svg",
    "crates/piezoid-serve/page/index.html",
    "crates/piezoid-serve/page/main.js",
    "crates/piezoid-serve/page/style.css",
    "crates/piezoid-report/src/page/figures.js",
];

/// What prints the lists, among what is built.
const CATALOGUE: &str = "catalogue";

/// Tests that need no module, and those of the modules as they are handed out.
const SERVED: [&str; 10] =
    ["campaign", "download", "linked", "plot", "project", "remaining", "rig", "serve", "server", "words"];
const HANDED_OUT: [&str; 1] = ["sizes"];

/// Builds everything, and tests it.
pub(super) fn web() -> Result<(), String> {
    build_workspace()?;
    handed_out(&built(CATALOGUE))?;
    run(&["test"])
}

/// The page as it is handed out, in web/dist, with the lists that this program prints.
pub(super) fn handed_out(catalogue: &Path) -> Result<(), String> {
    scripts()?;
    for (name, profile) in MODULES {
        module(profile, &[name], &[name])?;
    }
    lists(catalogue)
}

/// Builds everything, the modules without optimisation as a whole, compares the scripts with those that are committed,
/// and tests it. Adds what is missing to `skipped`; in CI this is an error.
pub(super) fn page(skipped: &mut Skipped) -> Result<(), String> {
    let npm = npm().arg("--version").stdout(Stdio::null()).status().is_ok_and(|status| status.success());
    if !npm && std::env::var_os("CI").is_none() {
        skipped.add("the page", "no npm");
        return Ok(());
    }
    let committed = COMMITTED.iter().map(|name| Committed::read(name)).collect::<Result<Vec<_>, _>>()?;
    scripts()?;
    committed.iter().try_for_each(Committed::check)?;
    let mut node = Command::new("node");
    node.args(["--test", "--test-reporter", "spec"]);
    let has_modules = for_the_web(skipped, "the page without a server")?;
    if has_modules {
        tested_modules()?;
    }
    let is_tried = |name: &str| if has_modules { !HANDED_OUT.contains(&name) } else { SERVED.contains(&name) };
    let folder = root().join("web/tests");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(&folder).map_err(|e| e.to_string())?.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.sort();
    let name = |file: &Path| Some(file.file_name()?.to_str()?.strip_suffix(".test.mjs")?.to_string());
    node.args(files.iter().filter(|file| name(file).is_some_and(|name| is_tried(&name))));
    skipped.step(&mut node)
}

/// A committed file of `npm run build`.
struct Committed {
    name: &'static str,
    content: Vec<u8>,
    modified: SystemTime,
}

impl Committed {
    fn read(name: &'static str) -> Result<Self, String> {
        let path = root().join(name);
        let read = || Ok((std::fs::read(&path)?, std::fs::metadata(&path)?.modified()?));
        let (content, modified) = read().map_err(|e: io::Error| format!("{name}: {e}"))?;
        Ok(Committed { name, content, modified })
    }

    /// An error if its content is another now. Otherwise it gets its old time: cargo need not build again what has it.
    fn check(&self) -> Result<(), String> {
        if Committed::read(self.name)?.content != self.content {
            return Err(format!(
                "{} was not built from web/src as it is: commit it as `cargo xtask generate page` wrote it now",
                self.name
            ));
        }
        let file = File::options().write(true).open(root().join(self.name));
        file.and_then(|file| file.set_modified(self.modified)).map_err(|e| format!("{}: {e}", self.name))
    }
}

/// Types, and what `npm run build` writes.
pub(super) fn scripts() -> Result<(), String> {
    run(&["ci", "--no-audit", "--no-fund"])?;
    ["check", "build"].into_iter().try_for_each(|script| run(&["run", script]))
}

fn npm() -> Command {
    let mut npm = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    npm.args(["--prefix", "web"]).current_dir(root());
    npm
}

/// Runs npm for the page.
fn run(arguments: &[&str]) -> Result<(), String> {
    step(npm().args(arguments))
}

fn written(name: &str) -> PathBuf {
    root().join("web/dist").join(name)
}

/// The same for tests: one build has the features of every module, which takes half as long.
fn tested_modules() -> Result<(), String> {
    let names = MODULES.map(|(name, _)| name);
    module("page-test", &names, &names)?;
    build_workspace()?;
    lists(&built(CATALOGUE))
}

/// One build of piezoid-wasm, by this profile and with these features, as the modules of these names.
fn module(profile: &str, features: &[&str], names: &[&str]) -> Result<(), String> {
    let mut build = cargo(&["build", "--profile", profile, "--package", "piezoid-wasm", "--target", WEB]);
    let mut flags = flags();
    if profile == "page-search" {
        flags.push(INLINED_UP_TO.into());
    }
    let flags = flags.join("\x1f");
    step(build.args(["--features", &features.join(",")]).env("CARGO_ENCODED_RUSTFLAGS", flags))?;
    let built = target().join(WEB).join(profile).join("piezoid_wasm.wasm");
    names.iter().map(|name| written(&format!("{name}.wasm"))).try_for_each(|module| {
        std::fs::copy(&built, &module).map(drop).map_err(|e| format!("{}: {e}", module.display()))
    })
}

/// Vector instructions and short addresses.
fn flags() -> Vec<String> {
    let fixed = ["-Ctarget-feature=+simd128", "-Clink-arg=--compress-relocations"].map(String::from);
    fixed.into_iter().chain(without_paths()).collect()
}

/// Flags of the compiler that leave out the paths of this machine, so that the same source gives the same bytes.
pub(super) fn without_paths() -> [String; 2] {
    let home = std::env::home_dir().unwrap_or_default();
    let cargo = std::env::var_os("CARGO_HOME").map_or_else(|| home.join(".cargo"), PathBuf::from);
    let short = |path: &Path, name: &str| format!("--remap-path-prefix={}={name}", path.display());
    [short(&cargo.join("registry/src"), "crates"), short(root(), "piezoid")]
}

/// The lists for menus and forms, of all modules.
fn lists(catalogue: &Path) -> Result<(), String> {
    let mut print = Command::new(catalogue);
    let line = announced(&print);
    let printed = print.stderr(Stdio::inherit()).output().map_err(|e| format!("cannot start `{line}`: {e}"))?;
    succeeded(&line, printed.status)?;
    std::fs::write(written("lists.json"), printed.stdout).map_err(|e| format!("lists.json: {e}"))
}
