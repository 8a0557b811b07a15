//! The client on lines that are cut or go silent, and work that is cancelled. The simulated controller keeps what it
//! was given, as a witness.

use super::tests::{at, simulation};
use crate::faulty::{Bench, Disturbed, Fault};
use crate::measuring::{but, drive, run};
use crate::{AcquireOptions, Rest};
use piezoid::Error;
use piezoid::progress::Stage;
use piezoid_verbs::DataFile;
use std::ops::ControlFlow::{Break, Continue};
use std::time::Duration;

fn bench(fault: Fault, at: usize) -> Bench {
    Bench::new(&simulation(), fault, at)
}

/// A drive of 0.6 s.
fn wave() -> DataFile {
    drive(0.05, &(0..12).map(|t| 20.0 * libm::sin(0.5 * f64::from(t))).collect::<Vec<_>>())
}

fn options(bench: &Bench, timeout: f64) -> AcquireOptions {
    but(at(bench.port), |options| (options.ramp, options.connection.timeout) = (0.0, timeout))
}

/// Checks what the client states against what the controller was given. True if a wave ran as it was stopped.
fn witness(bench: &Bench, text: &str, what: &str) -> bool {
    let log = bench.log.lock().unwrap().clone();
    let last = |is: &dyn Fn(&str) -> bool| log.iter().rposition(|one| is(&one.command));
    let moved = last(&|line| line.starts_with("set,") || line == "grun,1" || line.starts_with("modsrc,"));
    // Before that, the generator goes to its first value while `set` gives the setpoint.
    let is_moved = log.iter().any(|one| one.command.starts_with("set,"));
    let Some((moved, end)) = moved.zip(log.last()).filter(|_| is_moved) else {
        assert!(log.iter().all(|one| one.voltage == 0.0), "{what}: {text}");
        return false;
    };
    let stopped = last(&|line| line == "grun,0").unwrap_or_else(|| panic!("{what}: never stopped: {text}"));
    assert!(stopped > moved, "{what}: it moved after it was stopped: {text}");
    assert!(log[stopped + 1..].iter().all(|one| !one.runs), "{what}: {text}");
    let stated = format!("axis 1 is at {:.3} V, in open loop, and wave generator 1 is stopped", end.voltage);
    assert!(text.contains(&stated), "{what}: not `{stated}` but {text}");
    // No step but those of the drive is a large one: the source of the setpoint changes nothing.
    for (before, after) in log.iter().zip(&log[1..]).filter(|(before, _)| before.command.starts_with("modsrc,")) {
        let step = (after.voltage - before.voltage).abs();
        assert!(step < 0.1, "{what}: {} moves by {step} V", before.command);
    }
    log[stopped].runs
}

/// What may run on the way is checked but where the client states that nothing has moved.
fn disturbed() -> Disturbed<'static> {
    Disturbed {
        bench: &bench,
        options: &options,
        drive: wave(),
        longest: Duration::from_secs(60),
        by_the_clock: 40,
        // The XON after the last answer is too late for a fault.
        unnoticed: 40,
        errors: &["does not answer"],
        witness: &|bench, text, what| !text.contains("nothing has moved") && witness(bench, text, what),
    }
}

#[test]
fn a_line_that_is_cut_at_any_answer_leaves_a_stopped_generator_and_a_true_voltage() {
    disturbed().at_every_answer(Fault::Cut, 5.0);
}

#[test]
fn a_line_that_goes_silent_at_any_answer_leaves_a_stopped_generator_and_a_true_voltage() {
    disturbed().at_every_answer(Fault::Silent, 1.5);
}

#[test]
fn cancelling_at_any_moment_leaves_a_stopped_generator_and_a_true_voltage() {
    assert!(disturbed().cancelled_at_any_moment(41));
}

#[test]
fn after_a_cancelled_drive_the_next_one_takes_over_where_the_axis_is() {
    let bench = bench(Fault::None, 0);
    let mut plays = 0;
    let (outcome, text, _) = run(&options(&bench, 10.0), &wave(), &mut |stage: Stage| {
        plays += usize::from(stage.what.starts_with("the drive is played") && stage.done > 100);
        if plays > 0 { Break(()) } else { Continue(()) }
    });
    assert!(matches!(outcome, Err(Error::Cancelled { .. })), "{text}");
    let left = bench.log.lock().unwrap().last().unwrap().voltage;
    assert!(left.abs() > 1.0 && text.contains("in open loop, and wave generator 1 is stopped"), "{text}");
    let (outcome, text, _) = run(&options(&bench, 10.0), &wave(), &mut Stage::ignore);
    let acquired = outcome.unwrap();
    // It rests where it was found.
    assert!((acquired.voltage.unwrap() - left).abs() < 2e-3, "{left} V: {text}");
    let zero = but(options(&bench, 10.0), |options| options.rest = Rest::Zero);
    assert_eq!(run(&zero, &wave(), &mut Stage::ignore).0.unwrap().voltage, Some(0.0));
}
