//! The verbs: one row each, and one file for what it prints. An operation of the library without a file of its own
//! becomes a verb by its row alone ([`derived`]).

mod acquire;
mod agreed;
mod campaign;
mod certificate;
mod compare;
mod compensate;
mod contribute;
mod control;
mod derived;
mod excite;
mod export;
mod identified;
mod identify;
mod inspect;
mod instrument;
mod lists;
mod online;
mod plan;
mod plant;
mod prepare;
mod report;
mod serve;
mod shell;
mod simulate;
mod study;
mod timing;
mod validate;

/// What the files of verbs have in common.
mod prelude {
    pub(super) use super::Run;
    pub(super) use crate::columns::Columns;
    pub(super) use crate::console::Console;
    pub(super) use crate::files::{self, Results};
    pub(super) use crate::flags::{Flags, failed};
    pub(super) use anyhow::{Result, bail};
    pub(super) use clap::Args;
    pub(super) use std::path::{Path, PathBuf};
}

use crate::console::Console;
use anyhow::Result;
use clap::{ArgMatches, Args, Command, FromArgMatches};
use piezoid_operations::Operation;

/// A verb of the command line.
#[derive(Clone, Copy)]
pub(crate) struct Verb {
    pub(crate) name: &'static str,
    about: &'static str,
    arguments: fn(&'static str, Command) -> Command,
    parse: fn(&'static str, &ArgMatches) -> Result<Task, clap::Error>,
}

/// What a verb does once its arguments are read.
pub(crate) type Task = Box<dyn FnOnce(&Console) -> Result<()>>;

/// The arguments of a verb.
pub(crate) trait Run: Args + 'static {
    /// Does it.
    fn run(self, console: &Console) -> Result<()>;
}

/// A verb of the command line alone.
const fn own<V: Run>(name: &'static str, about: &'static str) -> Verb {
    let parse = |_, matches: &ArgMatches| -> Result<Task, clap::Error> {
        let verb = V::from_arg_matches(matches)?;
        Ok(Box::new(move |console| verb.run(console)))
    };
    Verb { name, about, arguments: |_, command| V::augment_args(command), parse }
}

/// An operation of the library with output of its own; its row says what it does.
const fn operation<V: Run>(name: &'static str) -> Verb {
    own::<V>(name, "")
}

/// An operation without output of its own.
const fn derived(name: &'static str) -> Verb {
    Verb { name, about: "", arguments: derived::arguments, parse: derived::parse }
}

/// A list of the catalogue.
const fn list(name: &'static str, about: &'static str) -> Verb {
    let parse = |name, matches: &ArgMatches| -> Result<Task, clap::Error> {
        let list = lists::List::from_arg_matches(matches)?;
        Ok(Box::new(move |console| list.run(name, console)))
    };
    Verb { name, about, arguments: |_, command| lists::List::augment_args(command), parse }
}

const VERBS: &[Verb] = &[
    operation::<study::Study>("study"),
    operation::<plan::Plan>("plan"),
    operation::<inspect::Inspect>("inspect"),
    operation::<prepare::Prepare>("prepare"),
    Verb { name: "excite", about: "", arguments: excite::arguments, parse: excite::parse },
    operation::<simulate::Simulate>("simulate"),
    operation::<acquire::Acquire>("acquire"),
    operation::<campaign::Campaign>("campaign"),
    own::<instrument::Instrument>("instrument", "Simulate a GCS controller with a plant on this machine"),
    operation::<identify::Identify>("identify"),
    operation::<validate::Validate>("validate"),
    operation::<compare::Compare>("compare"),
    operation::<compensate::Compensate>("compensate"),
    operation::<timing::TimingCall>("timing"),
    operation::<control::Control>("control"),
    operation::<online::Online>("online"),
    operation::<export::Export>("export"),
    operation::<report::Report>("report"),
    operation::<certificate::Certificate>("certificate"),
    operation::<contribute::Contribute>("contribute"),
    own::<serve::Serve>(
        "serve",
        "Serve the page of piezoid on this machine: the same work in a browser, with a project folder",
    ),
    list("operators", "List the hysteresis operators"),
    own::<lists::Plants>("plants", "List the simulated actuators, or show the parameters of one"),
    list("excitations", "List the drive signals"),
    list("estimators", "List the estimators of the linear block"),
    list("drivers", "List the drivers whose limits are known"),
    list("actuators", "List the actuators whose data sheets are known"),
    list("controllers", "List the controllers, feed-forwards first"),
    own::<lists::Targets>("targets", "List the export targets, and the operators that each serves"),
    own::<shell::Completions>("completions", "Print a completion script for a shell"),
    own::<shell::Manual>("man", "Print the manual page"),
];

/// All verbs: the rows above, and the operations that they leave out. `acquire` does what `controller` does, and
/// `timing --controller` what `moves` does.
pub(crate) fn all() -> Vec<Verb> {
    let names = Operation::all().map(|operation| operation.name).filter(|name| !["controller", "moves"].contains(name));
    let others = names.filter(|name| VERBS.iter().all(|verb| verb.name != *name)).map(derived);
    VERBS.iter().copied().chain(others).collect()
}

impl Verb {
    /// The subcommand.
    pub(crate) fn command(&self) -> Command {
        let about = Operation::find(self.name).map_or(self.about, |operation| operation.summary);
        (self.arguments)(self.name, Command::new(self.name)).about(about)
    }

    /// What it does with these arguments.
    ///
    /// # Errors
    /// Returns an error for arguments that make no sense together.
    pub(crate) fn task(&self, matches: &ArgMatches) -> Result<Task, clap::Error> {
        (self.parse)(self.name, matches)
    }
}
