//! The `piezoid` command: reads arguments and files, calls the library, renders what it answers.
//!
//! Exit status: 0 on success, 2 on a wrong command line, 1 on any other failure, with one message on stderr.

mod commands;
mod console;
mod files;

use clap::Parser;
use commands::Verb;
use console::Console;
use std::process::ExitCode;

/// Piezo actuators: measure, identify, prove, compensate, export.
#[derive(Parser)]
#[command(name = "piezoid", version, max_term_width = 100, arg_required_else_help = true)]
pub(crate) struct Cli {
    /// No progress on stderr.
    #[arg(long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    verb: Verb,
}

fn main() -> ExitCode {
    let Cli { quiet, verb } = Cli::parse();
    match verb.run(&Console::new(quiet)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            console::complain(&error);
            ExitCode::FAILURE
        }
    }
}
