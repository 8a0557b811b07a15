//! `piezoid completions` and `piezoid man`: what a shell and `man` want to know.

use crate::Cli;
use crate::console::Console;
use anyhow::Result;
use clap::{Args, CommandFactory};

#[derive(Args)]
pub(crate) struct Completions {
    /// The shell to complete for.
    shell: clap_complete::Shell,
}

impl Completions {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "piezoid", &mut script);
        console.print(&String::from_utf8_lossy(&script))
    }
}

pub(crate) fn man(console: &Console) -> Result<()> {
    let mut page = Vec::new();
    clap_mangen::Man::new(Cli::command()).render(&mut page)?;
    console.print(&String::from_utf8_lossy(&page))
}
