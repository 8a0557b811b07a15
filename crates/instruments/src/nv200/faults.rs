//! The client on lines that are cut or go silent, and work that is cancelled. The simulated controller keeps what it
//! was given, as a witness.

use super::tests::{at, but, run, simulation};
use crate::faulty::{Bench, Fault, each};
use crate::{AcquireOptions, Rest};
use piezoid::Error;
use piezoid::formats::Table;
use piezoid::progress::Stage;
use piezoid_verbs::{DataFile, File};
use std::ops::ControlFlow::{Break, Continue};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// So long must nothing take, even on a machine that is busy.
const GENEROUS: Duration = Duration::from_secs(60);

fn bench(fault: Fault, at: usize) -> Bench {
    Bench::new(&simulation(), fault, at)
}

fn options(bench: &Bench, timeout: f64) -> AcquireOptions {
    but(at(bench.port), |options| (options.ramp, options.connection.timeout) = (0.0, timeout))
}

/// A drive of 0.6 s.
fn drive() -> DataFile {
    let u: Vec<f64> = (0..12).map(|t| 20.0 * libm::sin(0.5 * f64::from(t))).collect();
    File::new("drive.csv", Table::write("drive.csv", 0.05, &[("u_V", &u)]).unwrap()).into()
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

/// Tries a fault in place of each of the first answers, and of some later ones.
fn at_many_answers(fault: Fault, timeout: f64) {
    let whole = bench(Fault::None, 0);
    let (outcome, ..) = run(&options(&whole, 10.0), &drive(), &mut Stage::ignore);
    assert_eq!(outcome.unwrap().unfinished, None);
    let last = whole.answers.load(Ordering::SeqCst);
    let running = AtomicUsize::new(0);
    let one = |at: usize| {
        let bench = bench(fault, at);
        let begin = Instant::now();
        let (outcome, text, kept) = run(&options(&bench, timeout), &drive(), &mut Stage::ignore);
        let what = format!("{fault:?} at answer {at} of {last}");
        assert!(begin.elapsed() < GENEROUS, "{what}: {:?}", begin.elapsed());
        if !bench.is_faulty.load(Ordering::SeqCst) {
            // The number of questions while the drive is played depends on the clock.
            assert!(outcome.unwrap().unfinished.is_none() && at + 40 > last, "{what}: {text}");
            return;
        }
        match outcome {
            // The XON after the last answer is too late for a fault.
            Ok(acquired) if acquired.unfinished.is_none() => return assert!(at + 40 > last, "{what}: {text}"),
            Ok(acquired) => {
                assert_eq!(kept.unwrap().record, acquired.record, "{what}");
                assert!(acquired.unfinished.is_some(), "{what}: {text}");
            }
            Err(error) => assert!(error.to_string().contains("does not answer") && kept.is_none(), "{what}: {error}"),
        }
        running.fetch_add(usize::from(witness(&bench, &text, &what)), Ordering::SeqCst);
    };
    each(last, one);
    assert!(fault == Fault::Silent || running.load(Ordering::SeqCst) > 0, "no fault came while the drive was played");
}

#[test]
fn a_line_that_is_cut_at_any_answer_leaves_a_stopped_generator_and_a_true_voltage() {
    at_many_answers(Fault::Cut, 5.0);
}

#[test]
fn a_line_that_goes_silent_at_any_answer_leaves_a_stopped_generator_and_a_true_voltage() {
    at_many_answers(Fault::Silent, 1.5);
}

#[test]
fn cancelling_at_any_moment_leaves_a_stopped_generator_and_a_true_voltage() {
    let mut was_running = false;
    for moment in (0..30).map(|k| Duration::from_millis(7 + 41 * k)) {
        let bench = bench(Fault::None, 0);
        let begin = Instant::now();
        let mut after = |_: Stage| if begin.elapsed() > moment { Break(()) } else { Continue(()) };
        let (outcome, text, kept) = run(&options(&bench, 10.0), &drive(), &mut after);
        match outcome {
            Err(Error::Cancelled { .. }) => assert!(kept.is_none(), "{text}"),
            Ok(acquired) if acquired.unfinished.is_none() => continue,
            Ok(acquired) => assert_eq!(kept.unwrap().record, acquired.record),
            Err(other) => panic!("{other}"),
        }
        was_running |= !text.contains("nothing has moved") && witness(&bench, &text, &format!("after {moment:?}"));
    }
    assert!(was_running);
}

#[test]
fn after_a_cancelled_drive_the_next_one_takes_over_where_the_axis_is() {
    let bench = bench(Fault::None, 0);
    let mut plays = 0;
    let (outcome, text, _) = run(&options(&bench, 10.0), &drive(), &mut |stage: Stage| {
        plays += usize::from(stage.what.starts_with("the drive is played") && stage.done > 100);
        if plays > 0 { Break(()) } else { Continue(()) }
    });
    assert!(matches!(outcome, Err(Error::Cancelled { .. })), "{text}");
    let left = bench.log.lock().unwrap().last().unwrap().voltage;
    assert!(left.abs() > 1.0 && text.contains("in open loop, and wave generator 1 is stopped"), "{text}");
    let (outcome, text, _) = run(&options(&bench, 10.0), &drive(), &mut Stage::ignore);
    let acquired = outcome.unwrap();
    // It rests where it was found.
    assert!((acquired.voltage.unwrap() - left).abs() < 2e-3, "{left} V: {text}");
    let zero = but(options(&bench, 10.0), |options| options.rest = Rest::Zero);
    assert_eq!(run(&zero, &drive(), &mut Stage::ignore).0.unwrap().voltage, Some(0.0));
}
