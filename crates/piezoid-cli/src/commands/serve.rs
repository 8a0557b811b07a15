//! `piezoid serve`: the page on this machine, with a project folder.

use super::prelude::*;
use clap::builder::RangedU64ValueParser;
use piezoid_serve::Settings;
use std::process::{Command, Stdio};

const EXAMPLES: &str = "\
Examples:
  The page, with the files of this folder:
    piezoid serve --open
  The page, with a project folder of its own, which is made if it does not exist:
    piezoid serve bender

The address has a key, because other users of this machine can open the port too. Programs and pages of other sites \
cannot use it without the key.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Serve {
    /// The project folder: the page reads, writes and deletes its files.
    #[arg(default_value = ".")]
    folder: PathBuf,
    /// The port on this machine; 0 is any that is free.
    #[arg(long, value_name = "N", default_value_t = 8642)]
    port: u16,
    /// Open the page in the browser.
    #[arg(long)]
    open: bool,
    /// Largest file and largest request [MiB].
    #[arg(long, value_name = "MiB", default_value_t = 512, value_parser = RangedU64ValueParser::<u64>::new().range(1..=1 << 20))]
    limit: u64,
    /// Answer one request: the server starts itself so for every call.
    #[arg(long, hide = true)]
    answer: bool,
}

impl Run for Serve {
    fn run(self, console: &Console) -> Result<()> {
        if self.answer {
            return Ok(piezoid_serve::answer()?);
        }
        let folder = std::path::absolute(&self.folder)?;
        let worker = (itself()?, ["serve", "--answer"].map(String::from).into());
        let settings = Settings { folder: folder.clone(), port: self.port, limit: self.limit << 20, worker };
        let ready = |address: &str| {
            let message = format!("piezoid serves the folder {} at\n  {address}\nCtrl-C ends\n", folder.display());
            if let Err(error) = console.print(&message) {
                console.remark(&format!("{error:#}"));
            }
            if self.open && browser(address).is_err() {
                console.remark("no browser could be opened: open the address yourself");
            }
        };
        piezoid_serve::serve(&settings, ready).map_err(failed)
    }
}

/// This program, even if its file is replaced while it runs.
fn itself() -> Result<PathBuf> {
    let running = Path::new("/proc/self/exe");
    Ok(if running.exists() { running.into() } else { std::env::current_exe()? })
}

fn browser(address: &str) -> std::io::Result<()> {
    let mut command = match std::env::consts::OS {
        "macos" => Command::new("open"),
        "windows" => Command::new("rundll32"),
        _ => Command::new("xdg-open"),
    };
    if cfg!(windows) {
        command.arg("url.dll,FileProtocolHandler");
    }
    command.arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().map(drop)
}
