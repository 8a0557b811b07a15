//! `piezoid excite KIND`: writes a drive signal or a reference. Each row of the library's list is a subcommand, each of
//! its parameters a flag.

use super::Task;
use super::prelude::*;
use crate::flags::{argument, placeholder, values};
use crate::values::record;
use crate::words::flag;
use clap::{ArgMatches, Command, FromArgMatches, error::ErrorKind};
use piezoid::excitation::{EXCITATIONS, Excitation};
use piezoid_numerics::number::{round, short as number};
use piezoid_numerics::words::{capitalised, wrapped};
use piezoid_verbs::ExciteOptions;
use serde_json::Value;

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

/// The kinds as subcommands.
pub(super) fn arguments(_: &'static str, command: Command) -> Command {
    let kinds = EXCITATIONS.iter().map(|kind| {
        let rows = (kind.rows)();
        let needed = rows.iter().filter(|row| row.required);
        let needed: String = needed.map(|row| format!("--{} <{}> ", flag(row.name), placeholder(row))).collect();
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

/// Reads the arguments.
pub(super) fn parse(_: &'static str, matches: &ArgMatches) -> Result<Task, clap::Error> {
    let wrong = |text: String| clap::Error::raw(ErrorKind::InvalidSubcommand, text);
    let (name, matches) = matches.subcommand().ok_or_else(|| wrong("name a kind of drive signal".into()))?;
    let kind = Excitation::find(name).map_err(|e| wrong(e.to_string()))?;
    let (parameters, common) = (values(&(kind.rows)(), matches), Common::from_arg_matches(matches)?);
    Ok(Box::new(move |console| run(kind, parameters, common, console)))
}

fn run(kind: &Excitation, parameters: Value, common: Common, console: &Console) -> Result<()> {
    let Common { options: Flags(options), output } = common;
    files::ready(&[Some(&output)])?;
    let result = options.run(kind, parameters).map_err(failed)?;
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
