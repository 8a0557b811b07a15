//! The `piezoid` command: reads arguments and files, calls the library, prints the results.
//!
//! Exit status: 0 on success, 2 on a wrong command line, 130 after Ctrl-C, 1 on any other failure, with one message on
//! stderr.

mod columns;
mod commands;
mod console;
mod files;
mod flags;
mod layout;
mod sketch;
mod tables;
mod values;
mod words;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, Command};
use console::Console;
use std::process::ExitCode;

/// That of musl has one lock for all threads: an identification takes longer with it.
#[cfg(target_env = "musl")]
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const EXAMPLES: &str = "\
Start with:
  piezoid study                      the experiment of Kuklisova Pavelkova (ICINCO 2025), and report.html
  piezoid identify --help            a model from your own records
  piezoid help VERB                  help for one verb";

/// The whole command.
pub(crate) fn cli() -> Command {
    Command::new("piezoid")
        .version(env!("CARGO_PKG_VERSION"))
        .about("Hysteresis models of piezo actuators: identify, validate, invert and export")
        .max_term_width(100)
        .arg_required_else_help(true)
        .subcommand_required(true)
        .subcommand_value_name("VERB")
        .subcommand_help_heading("Verbs")
        .after_help(EXAMPLES)
        .arg(
            Arg::new("quiet")
                .long("quiet")
                .help("Show no progress")
                .global(true)
                .action(ArgAction::SetTrue)
                .display_order(900),
        )
        .subcommands(commands::all().iter().map(commands::Verb::command))
}

fn main() -> ExitCode {
    let matches = cli().try_get_matches().unwrap_or_else(|wrong| leave(wrong));
    let verbs = commands::all();
    let chosen =
        matches.subcommand().and_then(|(name, matches)| Some((verbs.iter().find(|v| v.name == name)?, matches)));
    let Some((verb, arguments)) = chosen else { return ExitCode::from(2) };
    let task = verb.task(arguments).unwrap_or_else(|wrong| leave(wrong.format(&mut cli())));
    // The server handles signals itself.
    if verb.name != "serve" {
        console::handle_signals();
    }
    match task(&Console::new(matches.get_flag("quiet"))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            console::complain(&error);
            ExitCode::from(error.downcast_ref().map_or(1, values::Ended::status))
        }
    }
}

/// Prints help or a message on the command line, and ends.
fn leave(wrong: clap::Error) -> ! {
    let wrong = with_the_names_there_are(wrong);
    match wrong.print() {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            console::complain(&anyhow::Error::new(error).context("cannot write to stdout"));
            std::process::exit(1)
        }
        _ => std::process::exit(wrong.exit_code()),
    }
}

/// Adds the known names to the message on an unknown verb or kind.
fn with_the_names_there_are(mut wrong: clap::Error) -> clap::Error {
    let arguments: Vec<String> = std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned()).collect();
    let cli = cli();
    let verb = arguments.iter().find_map(|word| cli.find_subcommand(word)).filter(|verb| verb.has_subcommands());
    if wrong.kind() == ErrorKind::InvalidSubcommand && wrong.get(ContextKind::SuggestedSubcommand).is_none() {
        let names = verb.unwrap_or(&cli).get_subcommands().map(|c| c.get_name()).collect::<Vec<_>>().join(", ");
        let tip = clap::builder::StyledStr::from(format!("known are {names}"));
        wrong.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip]));
    }
    wrong
}
