//! A verb from the row of its operation: files by their roles, options as flags, the result as JSON.

use super::Task;
use super::prelude::*;
use crate::flags::{argument, values};
use crate::words::flag;
use clap::{Arg, ArgMatches, Command, FromArgMatches};
use piezoid_host::files::FileSet;
use piezoid_numerics::options::Options;
use piezoid_operations::{Operation, Request};
use serde_json::{Value, json};

// Flags of every such verb. This is no doc comment, because that would become the help of each verb.
#[derive(Args)]
struct Common {
    /// The folder for the files that it writes, if it writes any.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Write the result as JSON; - is stdout [default: -].
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

/// The arguments of the operation `name`.
pub(super) fn arguments(name: &'static str, command: Command) -> Command {
    let Ok(operation) = Operation::find(name) else { return command };
    // The files of the first role stand after the verb.
    let files = operation.roles.iter().enumerate().map(|(place, role)| {
        let most = if role.many { usize::MAX } else { 1 };
        let help = format!("The {} {}", role.name.replace('_', " "), if role.many { "files" } else { "file" });
        let files = Arg::new(role.name).value_name("FILE").help(help).num_args(1..=most).required(role.least > 0);
        if place == 0 { files } else { files.long(flag(role.name)) }
    });
    Common::augment_args(command.args(files).args((operation.options)().iter().map(argument)))
}

/// Reads the arguments.
pub(super) fn parse(name: &'static str, matches: &ArgMatches) -> Result<Task, clap::Error> {
    let unknown = |error| clap::Error::raw(clap::error::ErrorKind::InvalidSubcommand, error);
    let operation = Operation::find(name).map_err(unknown)?;
    let of_role = |role: &str| matches.get_many::<String>(role).into_iter().flatten().cloned().collect::<Vec<_>>();
    let roles: Vec<(&str, Vec<String>)> = operation.roles.iter().map(|role| (role.name, of_role(role.name))).collect();
    let (options, common) = (values(&(operation.options)(), matches), Common::from_arg_matches(matches)?);
    Ok(Box::new(move |console| run(operation, &roles, &options, &common, console)))
}

fn run(
    operation: &Operation,
    roles: &[(&str, Vec<String>)],
    options: &Value,
    common: &Common,
    console: &Console,
) -> Result<()> {
    let paths: Vec<PathBuf> = roles.iter().flat_map(|(_, names)| names).map(PathBuf::from).collect();
    files::check(&[common.json.as_deref()], &paths.iter().collect::<Vec<_>>())?;
    let (files, columns) = (files::all(&paths, files::read)?, common.columns.read()?.to_json());
    let named: serde_json::Map<String, Value> = roles
        .iter()
        .filter(|(_, names)| !names.is_empty())
        .map(|(role, names)| ((*role).into(), json!(names)))
        .collect();
    let request = json!({"call": operation.name, "options": options, "columns": columns, "files": named});
    let request = Request::of(request).map_err(failed)?;
    let output = console.work(|progress| piezoid_operations::run(&request, &files, progress))?;
    let files = match &common.output {
        Some(folder) => FileSet::in_folder(folder, &output.files)?,
        None => FileSet::default(),
    };
    let stdout = PathBuf::from("-");
    Results::of(files).json(Some(common.json.as_ref().unwrap_or(&stdout)), &output.result).write(console)
}
