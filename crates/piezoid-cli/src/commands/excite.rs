//! `piezoid excite KIND`: a drive signal into a file. Each row of the library's list is a subcommand, each of its
//! parameters a flag.

use crate::console::{Console, number};
use crate::files;
use anyhow::{Result, bail};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, error::ErrorKind, value_parser};
use piezoid::excitation::{self, Driver, EXCITATIONS, Excitation, Limits};
use std::path::PathBuf;

pub(crate) struct Excite {
    kind: &'static Excitation,
    values: Vec<(&'static str, f64)>,
    common: Common,
}

/// What every kind takes.
#[derive(Args)]
struct Common {
    /// Sampling period.
    #[arg(long, value_name = "SECONDS")]
    ts: f64,
    /// Length of the signal.
    #[arg(long, value_name = "SECONDS")]
    duration: f64,
    /// The driver whose limits the signal must keep (see `piezoid drivers`).
    #[arg(long, value_name = "NAME")]
    driver: Option<String>,
    /// Capacitance of the load, for the driver's current limit.
    #[arg(long, value_name = "FARAD", requires = "driver")]
    capacitance: Option<f64>,
    /// Clip to the driver's limits instead of refusing.
    #[arg(long, requires = "driver")]
    clip: bool,
    /// The file to write; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

impl Args for Excite {
    fn augment_args(command: Command) -> Command {
        let kinds = EXCITATIONS.iter().map(|kind| {
            let flags = kind.parameters.iter().map(|p| {
                let help = match (p.unit, p.default) {
                    ("", None) => p.help.to_string(),
                    (unit, None) => format!("{} [{unit}]", p.help),
                    ("", Some(default)) => format!("{} [default: {default}]", p.help),
                    (unit, Some(default)) => format!("{} [{unit}] [default: {default}]", p.help),
                };
                Arg::new(p.name)
                    .long(p.name)
                    .value_name("NUMBER")
                    .help(help)
                    .required(p.default.is_none())
                    .allow_negative_numbers(true)
                    .value_parser(value_parser!(f64))
            });
            Common::augment_args(Command::new(kind.name).about(kind.summary).after_help(kind.reference).args(flags))
        });
        command.subcommands(kinds).subcommand_required(true).arg_required_else_help(true).subcommand_value_name("KIND")
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Excite {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let wrong = |text: String| clap::Error::raw(ErrorKind::InvalidSubcommand, text);
        let (name, matches) = matches.subcommand().ok_or_else(|| wrong("name a kind of drive signal".into()))?;
        let kind = excitation::find(name).map_err(|e| wrong(e.to_string()))?;
        let given = |p: &excitation::Parameter| Some((p.name, *matches.get_one::<f64>(p.name)?));
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
        let Common { ts, duration, driver, capacitance, clip, output } = self.common;
        let mut u = self.kind.samples(ts, duration, &self.values)?;
        if let Some(name) = driver {
            let mut limits: Limits = Driver::find(&name)?.limits;
            limits.capacitance = capacitance.or(limits.capacitance);
            if limits.current.is_some() && limits.capacitance.is_none() {
                bail!("driver `{name}` limits the current, which depends on the load: give its --capacitance in farad");
            }
            if clip {
                let clipped = limits.clip(&u, ts)?;
                let changed = u.iter().zip(&clipped).filter(|(u, c)| u != c).count();
                console.remark(&format!("{changed} of {} samples clipped to the limits of `{name}`", u.len()));
                u = clipped;
            }
            let usage = limits.refuse(&u, ts)?;
            for peak in usage.peaks() {
                let share = peak.share.map(|s| format!(", {} % of the limit", number(100.0 * s))).unwrap_or_default();
                console.remark(&format!("{}: {} {}{share}", peak.quantity, number(peak.value), peak.unit));
            }
        }
        files::write(&output, &piezoid::formats::csv::write(ts, &[("u_V", &u)])?, console)
    }
}
