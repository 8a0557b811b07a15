//! Measurements whose line or whose process fails: `acquire` on a simulated controller, with a line between them.
//!
//! Each case is one fault at a moment by chance, or at a command. It never hangs, it leaves no half file, the generator
//! is stopped wherever a line could be had again, and the voltage that is stated is true: the log of the controller is
//! the witness. `PIEZOID_SEED` takes other cases, `PIEZOID_CASE` one alone.
//! `cargo test -p piezoid-cli --test cli faults -- --ignored --nocapture --test-threads 1` tries 1630, with tables.
//! It does not do: garbage that is a valid answer.
#![cfg(unix)]

mod checks;
mod line;
mod plan;
mod table;
mod witness;

use crate::bench::{Bench, Run};
use crate::instrument::Controller;
use crate::kills::{Dice, can_trace, message};
use line::Line;
use plan::{Kind, Moment, Place, Plan, Stall};
use rustix::process::Signal;
use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::thread::{scope, sleep};
use std::time::{Duration, Instant};
use table::{Row, printed};
use witness::Entry;

/// After this time a client hangs.
const HANG: Duration = Duration::from_secs(40);
const HANG_OF_A_CAMPAIGN: Duration = Duration::from_secs(300);

/// Limits that the clients are given [V], and the largest step of a slow move.
const LIMITS: (f64, f64) = (-25.0, 25.0);
const STEP: f64 = 0.05 * (LIMITS.1 - LIMITS.0);

/// Samples of the drive.
const SAMPLES: usize = 100;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Protocol {
    Gcs,
    Nv200,
}

impl Protocol {
    fn of(k: usize) -> Self {
        if k % 5 < 3 { Protocol::Gcs } else { Protocol::Nv200 }
    }

    /// Options of the simulated controller, the name of the protocol, and a query.
    fn words(self) -> [&'static str; 3] {
        match self {
            Protocol::Gcs => ["--plant paper", "gcs", "POS?\n"],
            Protocol::Nv200 => ["--plant paper --model nv200", "nv200", "meas\r\n"],
        }
    }

    /// The commands of a wave, those of an NV200 with the number of their arguments.
    fn commands(self) -> Vec<&'static str> {
        let commands = match self {
            Protocol::Gcs => "WAV DRT WOS DRC RTR WSL WGC WTR SVO SVA VOL? WGO #9 DRL? DRR?",
            Protocol::Nv200 => {
                "gbarb/2 gbarb/1 goarb/1 gsarb/1 gearb/1 gcarb/1 gtarb/1 grun/1 grun/0 set/1 modsrc/1 recsrc/2 \
                 recstr/1 reclen/1 recast/1 recrun/1 recout/3 recoutf/1"
            }
        };
        commands.split(' ').collect()
    }
}

/// What the client does, and when its fault comes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Work {
    /// `acquire`, at a moment by chance.
    Acquire,
    /// `acquire`, at this command.
    Command(&'static str),
    /// `acquire`, at the nth rename of a file: a signal.
    Rename(&'static str, usize),
    /// `campaign`, at a moment of its first seconds: demagnetisation and first records.
    Campaign(u64),
}

/// A case.
struct Case {
    what: String,
    work: Work,
    protocol: Protocol,
    bench: Bench,
    controller: Controller,
    plan: Plan,
    is_closed: bool,
    /// The voltage before [V].
    before: f64,
    /// Entries of the log before the client.
    begin: usize,
    old: Option<[&'static str; 2]>,
}

/// An end of a client.
struct End {
    run: Run,
    status: ExitStatus,
    /// Time from the fault to the end, if it came.
    took: Option<Duration>,
    /// Entries of the log until the end.
    log: Vec<Entry>,
}

/// The drive of 0.5 s, which begins far from rest [V].
fn value(k: usize) -> f64 {
    4.0 + 15.0 * (std::f64::consts::TAU * 2.0 * k as f64 * 5e-3).cos()
}

impl Case {
    /// A controller, perhaps in closed loop or at another voltage, perhaps with files of an older measurement.
    fn new(what: &str, (protocol, work): (Protocol, Work), plan: Plan, dice: &mut Dice) -> Self {
        let bench = Bench::new();
        let rows: String = (0..SAMPLES).map(|k| format!("{:.3},{:.4}\n", k as f64 * 5e-3, value(k))).collect();
        bench.write("u.csv", format!("t_s,u_V\n{rows}"));
        let [options, name, query] = protocol.words();
        let controller = Controller::with(&format!("{options} --log {}", bench.path("log").display()));
        let is_servo = matches!(&plan.moment, Moment::Command(name, ..) if name == "SVO");
        let is_closed = protocol == Protocol::Gcs && (is_servo || dice.roll(3) == 0);
        let is_elsewhere = dice.roll(2) == 1;
        if is_closed {
            controller.text("SVO 1 1\nMOV 1 20\n");
            // The servo comes to rest.
            sleep(Duration::from_millis(800));
        } else if is_elsewhere {
            controller.text(if protocol == Protocol::Gcs { "SVA 1 4\n" } else { "set,4\r\n" });
        }
        sleep(Duration::from_millis(50));
        let old = (dice.roll(2) == 1).then_some(["old record", "old document"]);
        if let Some([record, document]) = old {
            bench.write("r.csv", record);
            bench.write("r.json", document);
        }
        controller.text(query);
        let entries = witness::read(&bench.path("log"));
        let before = entries.last().map_or(0.0, |entry| entry.voltage);
        let what = format!("{what}: {name} {work:?}, {:?}, {:?}, then {:?}", plan.kind, plan.moment, plan.after);
        Case { what, work, protocol, bench, controller, plan, is_closed, before, begin: entries.len(), old }
    }

    fn is_campaign(&self) -> bool {
        matches!(self.work, Work::Campaign(_))
    }

    fn line(&self, port: u16) -> String {
        if self.is_campaign() {
            return format!(
                "campaign --port {port} --bandwidth 50 --range -25 25 --low -25 --high 25 --slew 20000V/s --period 5e-5 \
                 --wait 1 --operator preisach --timeout 1 --ramp 0.2 --yes -o all"
            );
        }
        let ((low, high), [_, protocol, _]) = (LIMITS, self.protocol.words());
        format!(
            "acquire u.csv --protocol {protocol} --port {port} --low {low} --high {high} --timeout 1 --ramp 0.2 \
             --settle 0.05 -o r.csv --json r.json"
        )
    }

    fn log(&self) -> Vec<Entry> {
        witness::read(&self.bench.path("log")).split_off(self.begin)
    }

    /// Runs the client with its fault.
    fn run(&self) -> (End, Line) {
        let line = Line::new(self.plan.clone(), self.controller.port(), self.controller.id());
        let words = self.line(line.port);
        let mut client = self.bench.command(&words);
        if let Work::Rename(signal, nth) = self.work {
            let calls = "rename,renameat,renameat2";
            let mut strace = Command::new("strace");
            strace.args(["-qq", "-o", "/dev/null", "-e", &format!("trace={calls}")]);
            strace.args(["-e", &format!("inject={calls}:signal=SIG{signal}:when={nth}")]);
            strace.arg(client.get_program()).args(client.get_args()).current_dir(self.bench.path(""));
            client = strace;
            *line.shared.fired.lock().unwrap() = Some(Instant::now());
        }
        let mut child = client.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        line.shared.client.store(child.id(), SeqCst);
        let hang = if self.is_campaign() { HANG_OF_A_CAMPAIGN } else { HANG };
        let (begin, mut is_second, mut status) = (Instant::now(), false, None);
        while status.is_none() && begin.elapsed() < hang {
            if let (Kind::Twice(pause, _), Some(fired), false) = (self.plan.kind, line.shared.fired(), is_second)
                && fired.elapsed() >= pause
            {
                is_second = true;
                line.shared.signal(Signal::INT);
            }
            sleep(Duration::from_millis(2));
            status = child.try_wait().unwrap();
        }
        let end = Instant::now();
        // Its number may be that of another process from now on.
        line.shared.client.store(0, SeqCst);
        drop(child.kill());
        let run = Run::of(&words, &child.wait_with_output().unwrap());
        let status = status.unwrap_or_else(|| panic!("{}: it hangs", self.what));
        // What it sent before its end, the controller has obeyed by then.
        while line.shared.open.load(SeqCst) > 0 && end.elapsed() < HANG {
            sleep(Duration::from_millis(2));
        }
        sleep(Duration::from_millis(20));
        let took = line.shared.fired().map(|fired| end.saturating_duration_since(fired));
        (End { run, status, took, log: self.log() }, line)
    }
}

/// What an undisturbed measurement does: its time, and how often each command comes.
struct Whole(Duration, BTreeMap<String, usize>);

impl Whole {
    fn of(protocol: Protocol) -> Self {
        let case = Case::new("without a fault", (protocol, Work::Acquire), Plan::none(), &mut Dice(1));
        let begin = Instant::now();
        let (end, line) = case.run();
        let length = begin.elapsed();
        case.check(&end, &line);
        Whole(length, line.shared.counts.lock().unwrap().clone())
    }
}

fn tried(k: usize, seed: u64, of: (Protocol, Work), Whole(length, counts): &Whole) -> Row {
    let mut dice = Dice(((seed << 32) | (k as u64 + 1)).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let (command, length) = match of.1 {
        Work::Command(name) => (Some((name, counts.get(name).copied().unwrap_or(1))), *length),
        Work::Campaign(seconds) => (None, Duration::from_secs(seconds)),
        _ => (None, *length),
    };
    let plan = Plan::of(k, command, length, &mut dice);
    let case = Case::new(&format!("case {k}, PIEZOID_SEED={seed}"), of, plan, &mut dice);
    let (end, line) = case.run();
    let row = case.check(&end, &line);
    drop(line);
    let is_open = end.status.signal() == Some(9) || case.ends_abruptly(&end);
    if case.plan.kind != Kind::KillController && !case.is_campaign() && (is_open || dice.roll(4) == 0) {
        case.check_next();
    }
    row
}

/// Tries cases, so many at once, and prints a table of them.
fn try_all(cases: &[(Protocol, Work)], at_once: usize) {
    let seed = message("PIEZOID_SEED").unwrap_or(1);
    let alone = message("PIEZOID_CASE").map(|k| k as usize);
    let wholes = scope(|scope| {
        let both = [Protocol::Gcs, Protocol::Nv200].map(|protocol| scope.spawn(move || Whole::of(protocol)));
        both.map(|whole| whole.join().unwrap())
    });
    let next = AtomicUsize::new(0);
    let (rows, failures) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    let one = |k: usize| {
        let whole = &wholes[cases[k].0 as usize];
        match std::panic::catch_unwind(|| tried(k, seed, cases[k], whole)) {
            Ok(row) => rows.lock().unwrap().push(row),
            Err(why) => failures.lock().unwrap().push(why.downcast_ref::<String>().cloned().unwrap_or_default()),
        }
    };
    scope(|scope| {
        for _ in 0..at_once {
            scope.spawn(|| {
                let nth = || Some(next.fetch_add(1, SeqCst)).filter(|k| *k < cases.len());
                std::iter::from_fn(nth).filter(|k| alone.is_none_or(|alone| alone == *k)).for_each(one);
            });
        }
    });
    println!("{}", printed(&rows.into_inner().unwrap()));
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{} of {} fail:\n{}", failures.len(), cases.len(), failures.join("\n"));
}

#[test]
fn a_fault_at_any_moment_leaves_whole_files_a_stopped_generator_and_a_true_voltage() {
    let of = |k: usize| {
        let protocol = Protocol::of(k);
        let commands = protocol.commands();
        match k {
            0 => (Protocol::Gcs, Work::Campaign(4)),
            _ if k % 2 == 1 => (protocol, Work::Command(commands[k / 2 * 7 % commands.len()])),
            _ => (protocol, Work::Acquire),
        }
    };
    try_all(&(0..36).map(of).collect::<Vec<_>>(), 18);
}

#[test]
fn a_command_that_waits_on_a_stalled_line_is_not_obeyed_once_the_axis_is_stopped() {
    scope(|scope| {
        for (name, nth) in [("SVA", 15), ("SVO", 2), ("WGO", 1)] {
            scope.spawn(move || {
                let kind = Kind::Stall(Stall::Late(Duration::from_millis(3500)));
                let plan = Plan { kind, moment: Moment::Command(name.into(), nth, Place::Before), ..Plan::none() };
                let case = Case::new("a command that waits", (Protocol::Gcs, Work::Acquire), plan, &mut Dice(1));
                let (end, line) = case.run();
                assert!(end.took.is_some() && end.status.code() == Some(1), "{name}: {:?}", end.run);
                case.check(&end, &line);
                assert!(line.shared.is_delivered.load(SeqCst));
            });
        }
    });
}

#[test]
fn a_signal_while_files_are_renamed_leaves_whole_files_and_a_true_voltage() {
    if !can_trace() {
        return;
    }
    let signals = [("INT", Signal::INT), ("TERM", Signal::TERM), ("HUP", Signal::HUP), ("KILL", Signal::KILL)];
    scope(|scope| {
        // Both files and their mark, then the document alone.
        for (nth, (name, signal)) in (1..=4).flat_map(|nth| signals.map(|signal| (nth, signal))) {
            scope.spawn(move || {
                let plan = Plan { kind: Kind::Signal(signal), ..Plan::none() };
                let of = (Protocol::Gcs, Work::Rename(name, nth));
                let case = Case::new("a signal at a rename", of, plan, &mut Dice(0x9e37_79b9 * (nth + 1) as u64));
                let (end, line) = case.run();
                let is_last = nth == 4 && signal != Signal::KILL;
                assert_eq!(end.status.code() == Some(0), is_last, "{}: {:?}", case.what, end.run);
                case.check(&end, &line);
            });
        }
    });
}

#[test]
#[ignore = "minutes"]
fn five_hundred_faults_at_random_moments() {
    let of = |k: usize| match k % 17 {
        // Of each kind of fault some come in a campaign.
        0 => (Protocol::Gcs, Work::Campaign(10)),
        _ => (Protocol::of(k), Work::Acquire),
    };
    // After some the measurement has ended.
    try_all(&(0..640).map(of).collect::<Vec<_>>(), 16);
}

#[test]
#[ignore = "minutes"]
fn thirty_faults_at_each_command_of_a_wave() {
    let of = |protocol: Protocol| {
        let each = protocol.commands().into_iter().flat_map(|command| [Work::Command(command); 30]);
        each.map(move |work| (protocol, work))
    };
    try_all(&of(Protocol::Gcs).chain(of(Protocol::Nv200)).collect::<Vec<_>>(), 16);
}
