//! The client on lines that are cut or go silent, and work that is cancelled. The simulated instruments keep what they
//! were given, as a witness.

use super::tests::{at, but, drive, run, simulation};
use crate::AcquireOptions;
use crate::faulty::{Bench, Fault, each};
use crate::simulated::Entry;
use piezoid::Error;
use piezoid::progress::Stage;
use piezoid_verbs::DataFile;
use std::ops::ControlFlow::{Break, Continue};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// So long must nothing take, even on a machine that is busy.
const GENEROUS: Duration = Duration::from_secs(60);

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

/// Tries a fault in place of each of the answers.
fn at_many_answers(fault: Fault, timeout: f64) {
    let whole = bench(Fault::None, 0);
    let (outcome, ..) = run(&options(&whole, 10.0), &wave(), &mut Stage::ignore);
    assert_eq!(outcome.unwrap().unfinished, None);
    jumps(&whole.log.lock().unwrap(), "no fault");
    let last = whole.answers.load(Ordering::SeqCst);
    let running = AtomicUsize::new(0);
    each(last, |at: usize| {
        let bench = bench(fault, at);
        let begin = Instant::now();
        let (outcome, text, kept) = run(&options(&bench, timeout), &wave(), &mut Stage::ignore);
        let what = format!("{fault:?} at answer {at} of {last}");
        assert!(begin.elapsed() < GENEROUS, "{what}: {:?}", begin.elapsed());
        match outcome {
            // The number of questions while the drive is played depends on the clock.
            Ok(acquired) if acquired.unfinished.is_none() => return assert!(at + 60 > last, "{what}: {text}"),
            Ok(acquired) => {
                assert_eq!(kept.unwrap().record, acquired.record, "{what}");
                assert!(acquired.unfinished.is_some(), "{what}: {text}");
            }
            Err(error) => {
                let expected = ["does not answer", "answers"].iter().any(|word| error.to_string().contains(word));
                assert!(expected && kept.is_none(), "{what}: {error}");
            }
        }
        running.fetch_add(usize::from(witness(&bench, &text, &what)), Ordering::SeqCst);
    });
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
    let mut was_running = false;
    for moment in (0..30).map(|k| Duration::from_millis(7 + 41 * k)) {
        let bench = bench(Fault::None, 0);
        let begin = Instant::now();
        let mut after = |_: Stage| if begin.elapsed() > moment { Break(()) } else { Continue(()) };
        let (outcome, text, kept) = run(&options(&bench, 10.0), &wave(), &mut after);
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
