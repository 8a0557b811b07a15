//! `cargo xtask web`: the modules of the page, the lists, and the scripts, in web/dist.

use super::{WEB, announced, cargo, root, step, succeeded};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The modules, which are features of piezoid-wasm. Limits of their sizes stand in web/tests/sizes.test.mjs.
const MODULES: [&str; 4] = ["files", "models", "reports", "exports"];

/// Builds everything, and tests it.
pub(super) fn web() -> Result<(), String> {
    run(&["ci", "--no-audit", "--no-fund"])?;
    for script in ["check", "build"] {
        run(&["run", script])?;
    }
    for name in MODULES {
        module(name)?;
    }
    lists()?;
    run(&["test"])
}

/// Runs npm for the page.
fn run(arguments: &[&str]) -> Result<(), String> {
    let mut npm = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    step(npm.args(["--prefix", "web"]).args(arguments))
}

fn written(name: &str) -> PathBuf {
    root().join("web/dist").join(name)
}

/// The module of this name.
fn module(name: &str) -> Result<(), String> {
    let mut build = cargo(&["build", "--profile", "page", "--package", "piezoid-wasm", "--target", WEB]);
    step(build.args(["--features", name]).env("CARGO_ENCODED_RUSTFLAGS", flags().join("\x1f")))?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), |d| root().join(d));
    let (built, module) = (target.join(WEB).join("page/piezoid_wasm.wasm"), written(&format!("{name}.wasm")));
    std::fs::copy(&built, &module).map_err(|e| format!("{}: {e}", module.display()))?;
    Ok(())
}

/// Vector instructions, short addresses, and no paths of this machine, so that the same source gives the same bytes.
fn flags() -> Vec<String> {
    let home = std::env::home_dir().unwrap_or_default();
    let cargo = std::env::var_os("CARGO_HOME").map_or_else(|| home.join(".cargo"), PathBuf::from);
    let short = |path: &Path, name: &str| format!("--remap-path-prefix={}={name}", path.display());
    let fixed = ["-Ctarget-feature=+simd128", "-Clink-arg=--compress-relocations"].map(String::from);
    fixed.into_iter().chain([short(&cargo.join("registry/src"), "crates"), short(root(), "piezoid")]).collect()
}

/// The lists for menus and forms, of all modules.
fn lists() -> Result<(), String> {
    let mut print = cargo(&["run", "--package", "piezoid-calls", "--example", "lists"]);
    let line = announced(&print);
    let printed = print.current_dir(root()).stderr(Stdio::inherit()).output();
    let printed = printed.map_err(|e| format!("cannot start `{line}`: {e}"))?;
    succeeded(&line, printed.status)?;
    std::fs::write(written("lists.json"), printed.stdout).map_err(|e| format!("lists.json: {e}"))
}
