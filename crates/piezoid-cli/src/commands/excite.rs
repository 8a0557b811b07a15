//! `piezoid excite KIND`: writes a drive signal or a reference. Each row of the library's list is a subcommand, each of
//! its parameters a flag.

use super::Run;
use crate::console::Console;
use crate::files::{self, Results};
use crate::flags::{Flags, argument, failed, placeholder, values};
use crate::layout::{capitalised, wrapped};
use crate::values::record;
use anyhow::Result;
use clap::{ArgMatches, Args, Command, FromArgMatches, error::ErrorKind};
use piezoid::excitation::{self, EXCITATIONS, Excitation};
use piezoid_numerics::number::{round, short as number};
use piezoid_verbs::{ExciteOptions, Excited};
use serde_json::Value;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  A small signal for the linear block: two periods of a PRBS
    piezoid excite prbs --order 12 --amplitude 1 --ts 5e-4 --duration 4.095 \\
        -o prbs.csv
  A sine for the hysteresis, refused if the driver cannot follow:
    piezoid excite sine --frequency 20 --amplitude 30 --ts 5e-4 --duration 2 \\
        --driver pl140 -o sine20.csv
  A path for `compensate`: a sine of +-500 um, in a column r_um:
    piezoid excite sine --frequency 10 --amplitude 500 --unit um --ts 5e-4 \
        --duration 1 -o path.csv
  Options of one kind:
    piezoid excite multisine --help";

pub(crate) struct Excite {
    kind: &'static Excitation,
    parameters: Value,
    common: Common,
}

// Flags of every kind. This is no doc comment, because that would become the help of each kind.
#[derive(Args)]
struct Common {
    #[command(flatten)]
    options: Flags<ExciteOptions>,
    /// The file to write: CSV, or .npz or .mat by the extension; - is stdout.
    #[arg(short, long, value_name = "FILE", value_parser = record())]
    output: PathBuf,
}

const COMMON_USAGE: &str = "--ts <SECONDS> --duration <SECONDS> [OPTIONS] -o <FILE>";

impl Args for Excite {
    fn augment_args(command: Command) -> Command {
        let kinds = EXCITATIONS.iter().map(|kind| {
            let rows = (kind.rows)();
            let needed = rows.iter().filter(|row| row.required);
            let needed: String =
                needed.map(|row| format!("--{} <{}> ", row.name.replace('_', "-"), placeholder(row))).collect();
            let usage = format!("piezoid excite {} {needed}{COMMON_USAGE}", kind.name);
            Common::augment_args(Command::new(kind.name).args(rows.iter().map(argument)))
                .about(capitalised(kind.summary))
                .override_usage(wrapped(&usage, 70, "           "))
                .after_help(format!("Reference: {}", kind.reference))
        });
        command
            .subcommands(kinds)
            .subcommand_required(true)
            .arg_required_else_help(true)
            .subcommand_value_name("KIND")
            .subcommand_help_heading("Kinds")
            .after_help(EXAMPLES)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Excite {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let wrong = |text: String| clap::Error::raw(ErrorKind::InvalidSubcommand, text);
        let (name, matches) = matches.subcommand().ok_or_else(|| wrong("name a kind of drive signal".into()))?;
        let kind = excitation::Excitation::find(name).map_err(|e| wrong(e.to_string()))?;
        Ok(Excite { kind, parameters: values(&(kind.rows)(), matches), common: Common::from_arg_matches(matches)? })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Run for Excite {
    fn run(self, console: &Console) -> Result<()> {
        let Common { options: Flags(options), output } = self.common;
        files::ready(&[Some(&output)])?;
        let result: Excited = options.run(self.kind, self.parameters).map_err(failed)?;
        if options.clip {
            let of = options.limits.driver.map(|name| format!(" of `{name}`")).unwrap_or_default();
            console.remark(&format!("{} of {} samples clipped to the limits{of}", result.clipped, result.u.len()));
        }
        for peak in result.usage.iter().flat_map(|usage| usage.peaks()) {
            let share = peak.share.map(|s| format!(", {} % of the limit", round(100.0 * s))).unwrap_or_default();
            console.remark(&format!("{}: {} {}{share}", peak.quantity, number(peak.value), peak.unit));
        }
        Results::default().record(Some(&output), |name| result.written(name))?.write(console)
    }
}
