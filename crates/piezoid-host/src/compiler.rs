//! The C compiler of this machine, for exports that contain a library.

use piezoid::Error;
use piezoid_export::Compiler;
use piezoid_verbs::File;
use std::ffi::OsString;
use std::process::{Command, Stdio};

/// The compiler `cc`, on platforms where it always builds the same library from the same sources: on Linux.
pub fn here() -> Option<Compiler> {
    let platform = match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => "x86_64-linux",
        ("linux", "aarch64") => "aarch64-linux",
        _ => return None,
    };
    let there = Command::new("cc").arg("--version").output().is_ok_and(|message| message.status.success());
    there.then_some(Compiler { platform, run: library })
}

/// C99 without fused multiply-adds, position-independent; only the marked functions are visible.
const FLAGS: &[&str] = &["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden"];

/// No symbols and no build identifier: nothing depends on place or time.
const PLAIN: &[&str] = &["-s", "-Wl,--build-id=none"];

/// Runs its arguments as a command. Once the standard input ends, which it does when this process is gone, the command
/// is ended with all that it has started, and its folder is removed.
const WATCHED: &str = r#"exec 3<&0 </dev/null
{ trap '' TERM; read -r _ <&3; kill -TERM 0; rm -rf -- "$TMPDIR"; } >/dev/null 2>&1 &
"$@" 3<&-
status=$?
kill -KILL $!
exit $status"#;

/// Compiles in a temporary folder. File names are given without a folder, so the library contains no path.
fn library(files: &[File]) -> Result<Vec<u8>, Error> {
    let failed = |error: std::io::Error| Error::Content(format!("the C compiler could not be run: {error}"));
    let folder = crate::temporary::folder(files).map_err(failed)?;
    let sources = files.iter().filter(|file| file.name.ends_with(".c")).map(|file| OsString::from(&file.name));
    let mut cc = Command::new("sh");
    cc.args(["-c", WATCHED, "sh", "cc"]).args(FLAGS).args(PLAIN).args(sources).args(["-o", "library"]);
    cc.current_dir(folder.path()).env("TMPDIR", folder.path());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut cc, 0);
    let mut cc = cc.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().map_err(failed)?;
    // Open until the compiler has ended.
    let _alive = cc.stdin.take();
    let message = cc.wait_with_output().map_err(failed)?;
    if !message.status.success() {
        let why = String::from_utf8_lossy(&message.stderr);
        let first = why.lines().find(|line| line.contains("error")).unwrap_or("it did not say why");
        return Err(Error::Content(format!("the C compiler refuses them: {first}")));
    }
    std::fs::read(folder.path().join("library")).map_err(failed)
}
