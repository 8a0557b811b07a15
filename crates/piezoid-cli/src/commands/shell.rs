//! `piezoid completions` and `piezoid man`: completion scripts and manual pages.

use super::prelude::*;
use crate::values::Ended::Misused;
use anyhow::Context;

const COMPLETE: &str = "\
Examples:
  piezoid completions bash > /etc/bash_completion.d/piezoid
  piezoid completions fish > ~/.config/fish/completions/piezoid.fish";

#[derive(Args)]
#[command(after_help = COMPLETE)]
pub(crate) struct Completions {
    /// The shell to complete for.
    shell: clap_complete::Shell,
}

impl Run for Completions {
    fn run(self, console: &Console) -> Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut crate::cli(), "piezoid", &mut script);
        console.print(&script)
    }
}

const READ: &str = "\
Examples:
  piezoid man | man -l -
  piezoid man identify > piezoid-identify.1
  piezoid man -o /usr/local/share/man/man1";

#[derive(Args)]
#[command(after_help = READ)]
pub(crate) struct Manual {
    /// The page of one verb [default: the page of the whole command].
    #[arg(conflicts_with = "output")]
    verb: Option<String>,
    /// The folder for the pages of the command and of all verbs; created if it does not exist.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

impl Run for Manual {
    fn run(self, console: &Console) -> Result<()> {
        // There is no page for `help`.
        let mut cli = crate::cli().disable_help_subcommand(true);
        if let Some(folder) = &self.output {
            let written = std::fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(cli, folder));
            return written.with_context(|| format!("cannot write manual pages to {}", folder.display()));
        }
        cli.build();
        let page = match &self.verb {
            None => &cli,
            Some(verb) => cli.find_subcommand(verb).ok_or_else(|| {
                let names: Vec<&str> = cli.get_subcommands().map(clap::Command::get_name).collect();
                Misused(format!("there is no verb called `{verb}`: there are {}", names.join(", ")))
            })?,
        };
        let mut text = Vec::new();
        clap_mangen::Man::new(page.clone()).render(&mut text)?;
        console.print(&text)
    }
}
