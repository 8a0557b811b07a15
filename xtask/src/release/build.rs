//! Programs, Python packages and archives of a release.

use super::{root, step, target};
use crate::{announced, cargo, copy_staged, python, succeeded, web};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A platform, and the program that runs its programs on this machine.
pub(super) struct Target {
    /// Of the program.
    pub(super) triple: &'static str,
    /// Of the Python package.
    pub(super) wheel: &'static str,
    pub(super) name: &'static str,
    pub(super) runner: Option<&'static str>,
}

/// The first is that of the machine that makes the release.
pub(super) const TARGETS: [Target; 5] = [
    Target {
        triple: "x86_64-unknown-linux-musl",
        wheel: "x86_64-unknown-linux-gnu",
        name: "Linux, x86-64",
        runner: None,
    },
    Target {
        triple: "aarch64-unknown-linux-musl",
        wheel: "aarch64-unknown-linux-gnu",
        name: "Linux, 64-bit ARM",
        runner: Some("qemu-aarch64-static"),
    },
    Target {
        triple: "x86_64-pc-windows-gnu",
        wheel: "x86_64-pc-windows-gnu",
        name: "Windows, x86-64",
        runner: Some("wine"),
    },
    Target {
        triple: "aarch64-apple-darwin",
        wheel: "aarch64-apple-darwin",
        name: "macOS, Apple silicon",
        runner: None,
    },
    Target { triple: "x86_64-apple-darwin", wheel: "x86_64-apple-darwin", name: "macOS, Intel", runner: None },
];

impl Target {
    /// True for Windows, for which MinGW links: with zig, maturin exports a wrong name from the Python package.
    fn is_windows(&self) -> bool {
        self.triple.contains("windows")
    }
}

/// Linkers for other platforms, and what packs wheels: from PyPI, of fixed versions.
const TOOLS: [&str; 4] =
    ["cargo-zigbuild==0.24.1", "cyclonedx-python-lib==11.12.0", "maturin==1.16.0", "ziglang==0.17.1"];

/// The version that is made, and where.
pub(super) struct Release {
    pub(super) version: String,
    pub(super) is_tagged: bool,
    /// Time of the commit [s since 1970].
    epoch: String,
    pub(super) folder: PathBuf,
    tools: PathBuf,
}

impl Release {
    /// The commit that is checked out; without `is_rehearsal` it must have the tag of its version.
    pub(super) fn of_this_commit(is_rehearsal: bool) -> Result<Self, String> {
        let version = env!("CARGO_PKG_VERSION").to_string();
        let changed = git(&["status", "--porcelain"])?;
        if !changed.is_empty() {
            return Err(format!("a release is made of a commit, and these files differ from it:\n{changed}"));
        }
        let tag = format!("v{version}");
        let is_tagged = git(&["tag", "--points-at", "HEAD"])?.lines().any(|line| line == tag);
        if !is_tagged && !is_rehearsal {
            return Err(format!("the commit has no tag {tag}: set it, or try a release without it by --rehearsal"));
        }
        let folder = target().join("dist");
        if folder.exists() {
            std::fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        }
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let tools = target().join("release-tools");
        if !tools.join("pyvenv.cfg").exists() {
            step(python().args(["-m", "venv"]).arg(&tools))?;
        }
        step(Command::new(tools.join("bin/pip")).args(["install", "--quiet"]).args(TOOLS))?;
        Ok(Release { version, is_tagged, epoch: git(&["log", "-1", "--format=%ct"])?, folder, tools })
    }

    /// A command whose results depend on nothing but the commit.
    fn fixed(&self, mut command: Command, of: &Target) -> Command {
        let mut path = self.tools.join("bin").into_os_string();
        path.push(":");
        path.push(std::env::var_os("PATH").unwrap_or_default());
        command.env("PATH", path).env("SOURCE_DATE_EPOCH", &self.epoch).env("CARGO_INCREMENTAL", "0");
        let mut flags = web::without_paths().to_vec();
        // Symbols name the files that the linker read, and the UUID of a program for macOS is a hash over them. Cargo
        // has only debug information removed; after that, the linker of MinGW ignores -s.
        if of.is_windows() {
            flags.extend(["-Cstrip=symbols", "-Clink-arg=-Wl,--no-insert-timestamp"].map(String::from));
        } else {
            flags.push("-Clink-arg=-s".into());
        }
        command.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
        // Libraries in C leave out their paths too, and when they were compiled: perhaps for an earlier commit.
        let paths = format!("-ffile-prefix-map={}=piezoid", root().display());
        let times = r#"-Wno-builtin-macro-redefined -D__DATE__="" -D__TIME__="""#;
        command.env("CFLAGS", format!("{paths} {times}"));
        command
    }

    /// The program of one platform.
    pub(super) fn program(&self, of: &Target) -> Result<PathBuf, String> {
        let file = if of.is_windows() { "piezoid.exe" } else { "piezoid" };
        self.built(of, &["--package", "piezoid-cli"], file)
    }

    /// The program that prints the lists of the page, built with the other one, whose crates it uses.
    pub(super) fn catalogue(&self, of: &Target) -> Result<PathBuf, String> {
        let packages = ["--package", "piezoid-cli", "--package", "piezoid-operations", "--bins"];
        self.built(of, &packages, "catalogue")
    }

    /// A file of a build.
    fn built(&self, of: &Target, what: &[&str], file: &str) -> Result<PathBuf, String> {
        let mut build = cargo(&[if of.is_windows() { "build" } else { "zigbuild" }, "--locked", "--release"]);
        build.args(["--target", of.triple]).args(what);
        step(&mut self.fixed(build, of))?;
        Ok(target().join(of.triple).join("release").join(file))
    }

    /// The Python package of one platform, for every Python from 3.10 on, with the bill of materials.
    pub(super) fn wheel(&self, of: &Target) -> Result<PathBuf, String> {
        let into = target().join("wheels").join(of.wheel);
        let _ = std::fs::remove_dir_all(&into);
        let mut build = self.fixed(Command::new(self.tools.join("bin/maturin")), of);
        build.args(["build", "--locked", "--release", "--manifest-path", "crates/piezoid-py/Cargo.toml"]);
        if !of.is_windows() {
            build.arg("--zig");
        }
        if of.wheel.contains("linux") {
            build.args(["--compatibility", "manylinux2014"]);
        }
        build.arg("--sbom-include").arg(self.bill());
        step(build.args(["--target", of.wheel, "--out"]).arg(&into))?;
        let entries = std::fs::read_dir(&into).map_err(|e| format!("{}: {e}", into.display()))?;
        let wheel = entries.filter_map(|file| Some(file.ok()?.path())).find(|file| file.extension().is_some());
        let wheel = wheel.ok_or_else(|| format!("{} holds no wheel", into.display()))?;
        let handed_out = self.folder.join(wheel.file_name().unwrap_or_default());
        copy(&wheel, &handed_out)?;
        Ok(handed_out)
    }

    /// The archive of a program, with licences, completions and manual pages, which `native` prints.
    pub(super) fn archive_program(&self, of: &Target, program: &Path, native: &Path) -> Result<(), String> {
        let folder = self.staged(of.triple)?;
        let name = |path: &Path| path.file_name().map(PathBuf::from).unwrap_or_default();
        copy(program, &folder.join(name(program)))?;
        for file in ["CHANGELOG.md", "CITATION.cff", "LICENSE-APACHE", "LICENSE-MIT", "README.md"] {
            copy(&root().join(file), &folder.join(file))?;
        }
        let print = |words: &[&str], file: &str| {
            let printed = Command::new(native).args(words).output().map_err(|e| e.to_string())?;
            succeeded(&words.join(" "), printed.status)?;
            write(&folder.join(file), &printed.stdout)
        };
        let shells =
            [("bash", "piezoid.bash"), ("fish", "piezoid.fish"), ("zsh", "_piezoid"), ("powershell", "piezoid.ps1")];
        shells.iter().try_for_each(|(shell, file)| print(&["completions", shell], &format!("completions/{file}")))?;
        step(Command::new(native).args(["man", "--output"]).arg(folder.join("man/man1")))?;
        self.pack(&folder, if of.is_windows() { "zip" } else { "tar.gz" })
    }

    /// The archive of a folder.
    pub(super) fn archive(&self, name: &str, content: &Path) -> Result<(), String> {
        let folder = self.staged(name)?;
        for file in files(content)? {
            copy(&content.join(&file), &folder.join(&file))?;
        }
        self.pack(&folder, "tar.gz")
    }

    /// The sources as they are committed.
    pub(super) fn sources(&self) -> Result<(), String> {
        let name = format!("piezoid-{}", self.version);
        let folder = target().join("staged").join(&name);
        copy_staged(&folder)?;
        self.pack(&folder, "tar.gz")
    }

    /// The bill of materials, and the recipe of the container.
    pub(super) fn materials(&self, targets: &[&Target]) -> Result<(), String> {
        copy(&root().join("Containerfile"), &self.folder.join("Containerfile"))?;
        let mut bill = Command::new(self.tools.join("bin/python"));
        bill.arg("xtask/src/release/sbom.py").args([&self.version, &self.epoch]).arg(self.bill());
        step(bill.args(targets.iter().map(|target| target.triple)))
    }

    /// The file of the bill of materials.
    fn bill(&self) -> PathBuf {
        self.folder.join(format!("piezoid-{}.cdx.json", self.version))
    }

    /// An empty folder of the name that an archive has.
    fn staged(&self, name: &str) -> Result<PathBuf, String> {
        let folder = target().join("staged").join(format!("piezoid-{}-{name}", self.version));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        Ok(folder)
    }

    fn pack(&self, folder: &Path, suffix: &str) -> Result<(), String> {
        let name = format!("{}.{suffix}", folder.file_name().unwrap_or_default().to_string_lossy());
        step(python().arg("xtask/src/release/pack.py").args([folder, &self.folder.join(name)]).arg(&self.epoch))
    }
}

/// The files in a folder, relative to it, sorted.
pub(super) fn files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let (mut found, mut open) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(&next).map_err(|e| format!("{}: {e}", next.display()))? {
            let path = entry.map_err(|e| e.to_string())?.path();
            if path.is_dir() { open.push(path) } else { found.push(path) }
        }
    }
    found.sort();
    Ok(found.iter().filter_map(|path| Some(path.strip_prefix(folder).ok()?.to_path_buf())).collect())
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let folder = to.parent().unwrap_or(to);
    let copied = std::fs::create_dir_all(folder).and_then(|()| std::fs::copy(from, to));
    copied.map(drop).map_err(|e| format!("{} to {}: {e}", from.display(), to.display()))
}

pub(super) fn write(file: &Path, content: &[u8]) -> Result<(), String> {
    let folder = file.parent().unwrap_or(file);
    let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(file, content));
    written.map_err(|e| format!("{}: {e}", file.display()))
}

fn git(arguments: &[&str]) -> Result<String, String> {
    let mut git = Command::new("git");
    let printed = git.current_dir(root()).args(arguments).output().map_err(|e| format!("git: {e}"))?;
    succeeded(&announced(&git), printed.status)?;
    Ok(String::from_utf8_lossy(&printed.stdout).trim_end().to_string())
}
