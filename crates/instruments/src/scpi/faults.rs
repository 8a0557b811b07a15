//! The client on lines that are cut or go silent, and work that is cancelled. The simulated instruments keep what they
//! were given, as a witness.

use super::tests::{at, simulation};
use crate::AcquireOptions;
use crate::faulty::{Bench, Disturbed, Fault};
use crate::measuring::{but, drive, run};
use crate::simulated::Entry;
use piezoid::Error;
use piezoid::progress::Stage;
use piezoid_verbs::DataFile;
use std::ops::ControlFlow::{Break, Continue};
use std::time::Duration;

fn bench(fault: Fault, at: usize) -> Bench {
    Bench::new(&simulation(), fault, at)
}

fn options(bench: &Bench, timeout: f64) -> AcquireOptions {
    but(at((bench.port, bench.oscilloscope)), |options| (options.ramp, options.connection.timeout) = (0.0, timeout))
}

/// A drive of 0.6 s that ends elsewhere than it begins.
fn wave() -> DataFile {
    let u: Vec<f64> = (0..120).map(|t| 20.0 * libm::sin(0.05 * f64::from(t)) + 0.05 * f64::from(t)).collect();
    drive(5e-3, &u)
}

/// The commands that move the output.
fn moves(entry: &Entry) -> bool {
    ["VOLT ", "VOLT:OFFS ", "FUNC ", "BURS:STAT ", "OUTP1 ON", "*TRG", "ABOR"]
        .iter()
        .any(|word| entry.command.trim_start_matches("SOUR1:").starts_with(word))
}

/// Checks what the client states against what the generator was given. True if a burst ran as it was stopped.
fn witness(bench: &Bench, text: &str, what: &str) -> bool {
    let log = bench.log.lock().unwrap().clone();
    let Some(end) = log.last().filter(|_| log.iter().any(moves)) else {
        assert!(log.iter().all(|one| one.voltage == 0.0), "{what}: {text}");
        return false;
    };
    assert!(!end.runs, "{what}: the burst goes on: {text}");
    let stated = format!("axis 1 is at {:.3} V, in open loop", end.voltage);
    assert!(text.contains(&stated), "{what}: not `{stated}` but {text}");
    jumps(&log, what);
    // The first step of a fade.
    log.iter().any(|one| one.runs && one.command.starts_with("SOUR1:VOLT "))
}

/// Without a burst no step is larger than that of a slow move, a twentieth of 60 V. A burst begins and ends where the
/// output was.
fn jumps(log: &[Entry], what: &str) {
    for (before, after) in log.iter().zip(&log[1..]).filter(|(before, after)| !before.runs && !after.runs) {
        let step = (after.voltage - before.voltage).abs();
        assert!(step <= 3.001, "{what}: {} moves by {step} V", before.command);
    }
    let first = log.iter().zip(&log[1..]).find(|(before, after)| !before.runs && after.runs);
    let last = log.iter().zip(&log[1..]).rfind(|(before, after)| before.runs && !after.runs);
    if let (Some((first, _)), Some((_, last))) = (first, last) {
        // The least amplitude of 2 mV times the gain is the error.
        assert!((first.voltage - last.voltage).abs() < 0.01, "{what}: {} V, {} V", first.voltage, last.voltage);
    }
}

/// What may run on the way is checked but where the client states that nothing has moved.
fn disturbed() -> Disturbed<'static> {
    Disturbed {
        bench: &bench,
        options: &options,
        drive: wave(),
        longest: Duration::from_secs(60),
        by_the_clock: 60,
        unnoticed: 60,
        errors: &["does not answer", "answers"],
        witness: &|bench, text, what| !text.contains("nothing has moved") && witness(bench, text, what),
    }
}

#[test]
fn without_a_fault_the_output_does_not_jump() {
    let bench = bench(Fault::None, 0);
    let (outcome, ..) = run(&options(&bench, 10.0), &wave(), &mut Stage::ignore);
    assert_eq!(outcome.unwrap().unfinished, None);
    jumps(&bench.log.lock().unwrap(), "no fault");
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
fn an_answer_that_drips_leaves_a_stopped_generator_and_a_true_voltage() {
    for place in [0, 1, 9, 20, 40, 50, 55] {
        let bench = bench(Fault::Drip, place);
        let (outcome, text, _) = run(&options(&bench, 0.5), &wave(), &mut Stage::ignore);
        assert!(outcome.is_err() || outcome.unwrap().unfinished.is_some(), "{place}: {text}");
        witness(&bench, &text, &format!("drip at {place}"));
    }
}

#[test]
fn an_oscilloscope_that_is_lost_leaves_a_stopped_generator_and_a_true_voltage() {
    for place in [0, 2, 14, 25, 28, 40] {
        let inside = bench(Fault::None, 0);
        // The line of another bench, to the oscilloscope of the first.
        let line = Bench::before(inside.oscilloscope, Fault::Cut, place);
        let options = but(options(&inside, 2.0), |options| {
            options.scpi.oscilloscope = Some(format!("127.0.0.1:{line}"));
        });
        let (outcome, text, kept) = run(&options, &wave(), &mut Stage::ignore);
        let error = outcome.unwrap_err().to_string();
        assert!(error.contains("does not answer") && kept.is_none(), "{place}: {error}");
        witness(&inside, &text, &format!("oscilloscope at {place}"));
    }
}

#[test]
fn cancelling_at_any_moment_leaves_a_stopped_generator_and_a_true_voltage() {
    assert!(disturbed().cancelled_at_any_moment(41));
}

#[test]
fn after_a_cancelled_drive_the_next_one_goes_on_where_the_axis_is() {
    let bench = bench(Fault::None, 0);
    let drive = drive(5e-3, &(0..120).map(|t| 5.0 + 10.0 * libm::sin(0.05 * f64::from(t))).collect::<Vec<_>>());
    let mut plays = 0;
    let (outcome, text, _) = run(&options(&bench, 10.0), &drive, &mut |stage: Stage| {
        plays += usize::from(stage.what.starts_with("the drive is played") && stage.done > 100);
        if plays > 0 { Break(()) } else { Continue(()) }
    });
    assert!(matches!(outcome, Err(Error::Cancelled { .. })), "{text}");
    assert!(text.contains("axis 1 is at 5.000 V, in open loop, and wave generator 1 is stopped"), "{text}");
    let (outcome, text, _) = run(&options(&bench, 10.0), &drive, &mut Stage::ignore);
    assert_eq!(outcome.unwrap().voltage, Some(5.0), "{text}");
}
