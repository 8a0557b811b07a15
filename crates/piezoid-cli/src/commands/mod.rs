//! One file per verb: arguments -> library call -> output.

mod acquire;
mod compare;
mod compensate;
mod control;
mod excite;
mod export;
mod identified;
mod identify;
mod inspect;
mod instrument;
mod lists;
mod plan;
mod prepare;
mod report;
mod serve;
mod shell;
mod simulate;
mod study;
mod validate;

use crate::console::Console;
use anyhow::Result;
use clap::Subcommand;

/// What can be done.
#[derive(Subcommand)]
pub(crate) enum Verb {
    /// Repeat the paper's experiment from end to end, as tables and a report.
    Study(study::Study),
    /// Plan the records of an identification: the drives within a driver's limits, and what each is for.
    Plan(plan::Plan),
    /// Show what data files hold, how they are read and what seems wrong; write a profile of a rig.
    Inspect(inspect::Inspect),
    /// Prepare a record: cut, filter, decimate, resample, average periods, align, repair, calibrate.
    Prepare(prepare::Prepare),
    /// Make a drive signal: PRBS, sines, chirps, steps.
    Excite(excite::Excite),
    /// Run a plant or a model on a drive signal.
    Simulate(simulate::Simulate),
    /// Play a drive on a controller with PI's GCS 2.0, and record what the actuator does.
    Acquire(acquire::Acquire),
    /// Simulate such a controller on this machine, around a plant.
    Instrument(instrument::Instrument),
    /// Find a model that predicts measured records.
    Identify(Box<identify::Identify>),
    /// Validate a model on records that were not used to identify it.
    Validate(validate::Validate),
    /// Compare models on the same records.
    Compare(compare::Compare),
    /// Compute the voltage for a requested displacement.
    Compensate(compensate::Compensate),
    /// Close the loop on a simulated actuator and compare controllers.
    Control(Box<control::Control>),
    /// Export a model and its inverse as code or tables: C, FMU, Simulink, structured text, Rust, waveforms.
    Export(export::Export),
    /// Write a self-contained HTML report on a model and how well it predicts records.
    Report(report::Report),
    /// Serve the page of piezoid on this machine: all of this in a browser, with a project folder.
    Serve(serve::Serve),
    /// List the hysteresis operators.
    Operators(lists::List),
    /// List the simulated actuators, or show the parameters of one.
    Plants(lists::Plants),
    /// List the drive signals.
    Excitations(lists::List),
    /// List the estimators of the linear block.
    Estimators(lists::List),
    /// List the drivers whose limits are known.
    Drivers(lists::List),
    /// List the actuators whose data sheets are known.
    Actuators(lists::List),
    /// List the controllers, feed-forwards first.
    Controllers(lists::List),
    /// List the export targets, and the operators that each serves.
    Targets(lists::Targets),
    /// Print a completion script for a shell.
    Completions(shell::Completions),
    /// Print the manual page.
    Man(shell::Manual),
}

impl Verb {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        match self {
            Verb::Study(verb) => verb.run(console),
            Verb::Plan(verb) => verb.run(console),
            Verb::Inspect(verb) => verb.run(console),
            Verb::Prepare(verb) => verb.run(console),
            Verb::Excite(verb) => verb.run(console),
            Verb::Simulate(verb) => verb.run(console),
            Verb::Acquire(verb) => verb.run(console),
            Verb::Instrument(verb) => verb.run(console),
            Verb::Identify(verb) => verb.run(console),
            Verb::Validate(verb) => verb.run(console),
            Verb::Compare(verb) => verb.run(console),
            Verb::Compensate(verb) => verb.run(console),
            Verb::Control(verb) => verb.run(console),
            Verb::Export(verb) => verb.run(console),
            Verb::Report(verb) => verb.run(console),
            Verb::Serve(verb) => verb.run(console),
            Verb::Operators(verb) => verb.run("operators", console),
            Verb::Plants(verb) => verb.run(console),
            Verb::Excitations(verb) => verb.run("excitations", console),
            Verb::Estimators(verb) => verb.run("estimators", console),
            Verb::Drivers(verb) => verb.run("drivers", console),
            Verb::Actuators(verb) => verb.run("actuators", console),
            Verb::Controllers(verb) => verb.run("controllers", console),
            Verb::Targets(verb) => verb.run(console),
            Verb::Completions(verb) => verb.run(console),
            Verb::Man(verb) => verb.run(console),
        }
    }
}
