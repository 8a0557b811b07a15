//! `piezoid excite KIND`: a drive signal into a file. Each row of the library's list is a subcommand, each of its
//! parameters a flag.

use super::driver::Amplifier;
use crate::console::Console;
use crate::files;
use crate::layout::{capitalised, wrapped};
use crate::values::{argument, period};
use anyhow::{Result, anyhow};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, error::ErrorKind, value_parser};
use piezoid::excitation::{self, EXCITATIONS, Excitation, Parameter};
use piezoid::number::{round, short as number};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  A small signal for the linear block, two periods of a PRBS:
    piezoid excite prbs --order 12 --amplitude 1 --ts 5e-4 --duration 4.095 \\
        -o prbs.csv
  A sine for the hysteresis, refused if the driver cannot follow:
    piezoid excite sine --frequency 20 --amplitude 30 --ts 5e-4 --duration 2 \\
        --driver pl140 -o sine20.csv
  What one kind takes:
    piezoid excite multisine --help";

pub(crate) struct Excite {
    kind: &'static Excitation,
    values: Vec<(&'static str, f64)>,
    common: Common,
}

// What every kind takes. (No doc comment: it would become the help of each kind.)
#[derive(Args)]
struct Common {
    /// Sampling period.
    #[arg(long, value_name = "SECONDS", value_parser = period, allow_negative_numbers = true)]
    ts: f64,
    /// Length of the signal.
    #[arg(long, value_name = "SECONDS", value_parser = period, allow_negative_numbers = true)]
    duration: f64,
    #[command(flatten)]
    amplifier: Amplifier,
    /// Clip to the driver's limits instead of refusing.
    #[arg(long, requires = "driver")]
    clip: bool,
    /// The file to write; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

const COMMON_USAGE: &str = "--ts <SECONDS> --duration <SECONDS> [OPTIONS] -o <FILE>";

/// What stands for the value of a parameter in help.
fn value_name(parameter: &Parameter) -> &'static str {
    match parameter.unit {
        "" => "NUMBER",
        "s" => "SECONDS",
        unit => unit,
    }
}

impl Args for Excite {
    fn augment_args(command: Command) -> Command {
        let kinds = EXCITATIONS.iter().map(|kind| {
            let flags = kind.parameters.iter().map(|p| {
                let default = p.default.map_or(String::new(), |default| format!(" [default: {default}]"));
                let help = capitalised(p.help) + &default;
                Arg::new(p.name)
                    .long(p.name)
                    .value_name(value_name(p))
                    .help(help)
                    .required(p.default.is_none())
                    .allow_negative_numbers(true)
                    .value_parser(value_parser!(f64))
            });
            let needed = kind.parameters.iter().filter(|p| p.default.is_none());
            let needed: String = needed.map(|p| format!("--{} <{}> ", p.name, value_name(p))).collect();
            let usage = format!("piezoid excite {} {needed}{COMMON_USAGE}", kind.name);
            Common::augment_args(Command::new(kind.name).args(flags))
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
        let given = |p: &Parameter| Some((p.name, *matches.get_one::<f64>(p.name)?));
        let values = kind.parameters.iter().filter_map(given).collect();
        Ok(Excite { kind, values, common: Common::from_arg_matches(matches)? })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Excite {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let Common { ts, duration, amplifier, clip, output } = self.common;
        files::ready(&[Some(&output)])?;
        let limits = amplifier.limits()?;
        let mut u = argument(self.kind.samples(ts, duration, &self.values))?;
        if let (Some(limits), Some(name)) = (limits, amplifier.driver) {
            if clip {
                let clipped = limits.clip(&u, ts)?;
                let changed = u.iter().zip(&clipped).filter(|(u, c)| u != c).count();
                console.remark(&format!("{changed} of {} samples clipped to the limits of `{name}`", u.len()));
                u = clipped;
            }
            let usage = limits.refuse(&u, ts).map_err(|e| match e {
                piezoid::Error::Limits(_) => anyhow!("driver `{name}`: {e} (--clip)"),
                other => other.into(),
            })?;
            for peak in usage.peaks() {
                let share = peak.share.map(|s| format!(", {} % of the limit", round(100.0 * s))).unwrap_or_default();
                console.remark(&format!("{}: {} {}{share}", peak.quantity, number(peak.value), peak.unit));
            }
        }
        files::write(&output, &piezoid::formats::Table::write(ts, &[("u_V", &u)])?, console)
    }
}
