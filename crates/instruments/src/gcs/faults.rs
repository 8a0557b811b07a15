//! The client on lines that are cut, go silent or drip, and work that is cancelled. The simulated controller keeps what
//! it was given, as a witness.

use crate::faulty::{Bench, Disturbed, Fault, commands, passed};
use crate::measuring::{self, Measured, drive, sine};
use crate::{AcquireOptions, ConnectOptions, InstrumentOptions, Rest, Simulation};
use piezoid::Error;
use piezoid::progress::{Progress, Stage};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::ops::ControlFlow::{Break, Continue};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::spawn;
use std::time::{Duration, Instant};

/// So long must nothing take, even on a machine that is busy.
const GENEROUS: Duration = Duration::from_secs(30);

impl Bench {
    fn options(&self, timeout: f64) -> AcquireOptions {
        let connection = ConnectOptions { port: self.port, timeout, ..ConnectOptions::default() };
        let instrument = InstrumentOptions { connection, ramp: 0.0, ..InstrumentOptions::default() };
        AcquireOptions { instrument, settle: 0.0, ..AcquireOptions::default() }
    }

    /// Puts the axis into closed loop, perhaps.
    fn close(&self, is_closed: bool) {
        if is_closed {
            self.text(&crate::gcs::tests::at_rest("SVO 1 1\nMOV 1 100\n"));
        }
    }

    /// Answers of the controller itself.
    fn text(&self, lines: &str) -> String {
        measuring::text(self.direct, lines)
    }

    /// Checks what the controller says against `text`, what the client states.
    fn witness(&self, text: &str, what: &str) {
        let log = self.log.lock().unwrap().clone();
        let last = |names: &[&str]| log.iter().rposition(|one| names.iter().any(|name| one.command.starts_with(name)));
        let changed = last(&["SVO 1 0", "SVA ", "WGO 1 1"]);
        let Some(end) = log.last() else {
            // It was cancelled before the first command came.
            return assert_eq!(self.text("VOL?\n"), "1=0.000000\n", "{what}: {text}");
        };
        if let Some(changed) = changed {
            let stopped = last(&["WGO 1 0"]).unwrap_or_else(|| panic!("{what}: never stopped: {text}"));
            assert!(stopped > changed, "{what}: it moved after it was stopped: {text}");
            assert!(log[stopped + 1..].iter().all(|one| !one.runs), "{what}: {text}");
            let state = if end.servo { "closed" } else { "open" };
            let stated = format!("axis 1 is at {:.3} V, in {state} loop, and wave generator 1 is stopped", end.voltage);
            assert!(text.contains(&stated), "{what}: not `{stated}` but {text}");
        } else {
            let begin = log.iter().find(|one| one.command == "*IDN?").unwrap_or(end);
            assert_eq!((end.voltage, end.servo, end.runs), (begin.voltage, begin.servo, false), "{what}: {text}");
        }
        assert_eq!(self.text("\x09"), "0x0\n", "{what}: {text}");
        let voltage: f64 = self.text("VOL?\n").trim().strip_prefix("1=").unwrap().parse().unwrap();
        // In closed loop the servo goes on.
        let drift = if end.servo { 1e-3 } else { 1e-6 };
        assert!((voltage - end.voltage).abs() < drift, "{what}: {voltage} V, not {} V: {text}", end.voltage);
    }

    /// True if the generator ran as it was stopped.
    fn was_running(&self) -> bool {
        self.log.lock().unwrap().iter().any(|one| one.command == "WGO 1 0" && one.runs)
    }
}

fn bench(fault: Fault, at: usize) -> Bench {
    let simulation = Simulation { plant: "paper".into(), virtual_time: Some(0.05), ..Simulation::default() };
    Bench::new(&simulation, fault, at)
}

/// A measurement of a drive of 1 s.
fn run(options: &AcquireOptions, progress: &mut Progress) -> Measured {
    measuring::run(options, &drive(0.01, &sine(100)), progress)
}

/// Answers whose number depends on the clock: ten while the drive is awaited, and three for each report of what the
/// actuator does in a second.
const BY_THE_CLOCK: usize = 10 + 3 * 13;

/// Answers of a measurement without a fault.
fn answers(is_closed: bool) -> usize {
    let bench = bench(Fault::None, 0);
    bench.close(is_closed);
    let (outcome, ..) = run(&bench.options(10.0), &mut Stage::ignore);
    let acquired = outcome.unwrap();
    assert_eq!((acquired.unfinished, acquired.servo), (None, Some(is_closed)));
    bench.answers.load(Ordering::SeqCst)
}

/// A client on a line before this bench.
fn disturbed(bench: &(dyn Fn(Fault, usize) -> Bench + Sync)) -> Disturbed<'_> {
    Disturbed {
        bench,
        options: &Bench::options,
        drive: drive(0.01, &sine(100)),
        longest: GENEROUS,
        by_the_clock: BY_THE_CLOCK,
        unnoticed: 0,
        errors: &["does not answer"],
        witness: &|bench, text, what| {
            bench.witness(text, what);
            bench.was_running()
        },
    }
}

/// The same with an axis in closed loop before.
fn closed(fault: Fault, at: usize) -> Bench {
    let bench = bench(fault, at);
    bench.close(true);
    bench
}

#[test]
fn a_line_that_is_cut_at_any_answer_leaves_a_stopped_generator_and_a_true_voltage() {
    disturbed(&bench).at_every_answer(Fault::Cut, 5.0);
    answers(true);
    disturbed(&closed).at_every_answer(Fault::Cut, 5.0);
}

#[test]
fn a_line_that_goes_silent_at_any_answer_leaves_a_stopped_generator_and_a_true_voltage() {
    disturbed(&bench).at_every_answer(Fault::Silent, 1.5);
}

#[test]
fn an_answer_that_drips_ends_at_its_deadline() {
    let last = answers(false);
    for at in [0, 3, last / 2, last - 5] {
        let bench = bench(Fault::Drip, at);
        let begin = Instant::now();
        let (outcome, text, _) = run(&bench.options(1.5), &mut Stage::ignore);
        let finished = outcome.as_ref().is_ok_and(|acquired| acquired.unfinished.is_none());
        if !bench.is_faulty.load(Ordering::SeqCst) {
            // A machine that is busy has fewer answers.
            assert!(finished && at + BY_THE_CLOCK > last, "{at}: {text}");
            continue;
        }
        assert!(!finished && begin.elapsed() < GENEROUS, "{at}: {text}");
        assert!(text.contains("there was no whole answer within 1.5 s"), "{text}");
        bench.witness(&text, &format!("drip at {at}"));
    }
}

#[test]
fn cancelling_is_noticed_while_an_answer_is_awaited() {
    let last = answers(false);
    for (fault, at) in [(Fault::Silent, 0), (Fault::Silent, last / 2), (Fault::Drip, last - 8)] {
        let bench = bench(fault, at);
        let (is_faulty, mut cancelled) = (bench.is_faulty.clone(), None);
        // The time from the fault to the end is far below the time for an answer.
        let (outcome, text, _) = run(&bench.options(3000.0), &mut |_: Stage| {
            if !is_faulty.load(Ordering::SeqCst) {
                return Continue(());
            }
            cancelled.get_or_insert_with(Instant::now);
            Break(())
        });
        if !bench.is_faulty.load(Ordering::SeqCst) {
            assert!(outcome.is_ok() && at + BY_THE_CLOCK > last, "{at}: {text}");
            continue;
        }
        assert!(cancelled.unwrap().elapsed() < GENEROUS, "{text}");
        let is_cancelled = matches!(outcome, Err(Error::Cancelled { .. }));
        assert!(is_cancelled || outcome.is_ok_and(|acquired| acquired.unfinished.is_some()), "{text}");
        bench.witness(&text, &format!("{fault:?} at {at}"));
    }
}

#[test]
fn cancelling_at_any_moment_leaves_a_stopped_generator_and_a_true_voltage() {
    disturbed(&bench).cancelled_at_any_moment(53);
}

#[test]
fn cancelling_on_the_way_to_the_rest_keeps_the_record() {
    let bench = bench(Fault::None, 0);
    let instrument = InstrumentOptions { ramp: 1.0, rest: Rest::Zero, ..bench.options(10.0).instrument };
    let options = AcquireOptions { instrument, ..bench.options(10.0) };
    let mut is_read = false;
    let (outcome, text, kept) = run(&options, &mut |stage: Stage| {
        is_read |= stage.what == "the record is read";
        if is_read && stage.what.starts_with("slow move") && stage.done > 5 { Break(()) } else { Continue(()) }
    });
    let acquired = outcome.unwrap();
    assert!(acquired.unfinished.as_deref().is_some_and(|why| why.starts_with("cancelled: slow move")), "{text}");
    assert_eq!(kept.unwrap().record, acquired.record);
    assert!(acquired.voltage.is_some_and(|voltage| voltage.abs() > 1.0), "{:?}", acquired.voltage);
    bench.witness(&text, "cancelled on the way");
}

#[test]
fn a_controller_that_is_gone_is_said_to_be_perhaps_in_motion() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let (port, begin) = (listener.local_addr().unwrap().port(), Instant::now());
    let bench = bench(Fault::None, 0);
    let direct = bench.direct;
    // A line that ends with the controller's last answer, and takes no client again.
    spawn(move || {
        let (client, _) = listener.accept().unwrap();
        drop(listener);
        let controller = TcpStream::connect(("127.0.0.1", direct)).unwrap();
        let (from, to) = (client.try_clone().unwrap(), controller.try_clone().unwrap());
        spawn(move || commands(from, to, &AtomicBool::new(false)));
        passed(&controller, &client, Some((80, &AtomicUsize::new(0))), Fault::Cut);
        drop((client.shutdown(Shutdown::Both), controller.shutdown(Shutdown::Both)));
    });
    let mut options = bench.options(5.0);
    options.instrument.connection.port = port;
    let (_, text, _) = run(&options, &mut Stage::ignore);
    assert!(text.contains("wave generator 1 could not be stopped, and may run on"), "{text}");
    assert!(begin.elapsed() < GENEROUS);
}
