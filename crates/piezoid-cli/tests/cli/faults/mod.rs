//! Measurements whose line or whose process fails: `acquire` on a simulated controller, with a line between them.
//!
//! Each case is one fault at a moment by chance, or at a command. It never hangs, it leaves no half file, the generator
//! is stopped wherever a line could be had again, and the voltage that is stated is true: the log of the controller is
//! the witness. `PIEZOID_SEED` takes other cases, `PIEZOID_CASE` one alone.
//! `cargo test -p piezoid-cli --test cli faults -- --ignored --nocapture --test-threads 1` tries some 1500 and prints a
//! table. It does not do: garbage that is a valid answer.
#![cfg(unix)]

mod checks;
mod line;
mod plan;
mod witness;

use crate::bench::{Bench, Run};
use crate::instrument::Controller;
use crate::kills::{Dice, can_trace, message};
use line::{Line, Shared};
use plan::{After, Kind, Moment, Place, Plan, Stall};
use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};
use witness::Entry;

/// `--timeout` of the clients.
const TIMEOUT: Duration = Duration::from_secs(1);

/// After this time a client hangs.
const HANG: Duration = Duration::from_secs(40);
const HANG_OF_A_CAMPAIGN: Duration = Duration::from_secs(300);

/// Limits that the clients are given [V], and the largest step of a slow move.
const LIMITS: (f64, f64) = (-25.0, 25.0);
const STEP: f64 = 0.05 * (LIMITS.1 - LIMITS.0);

/// Largest change of the drive from sample to sample [V]; its samples.
const WAVE_STEP: f64 = 1.0;
const SAMPLES: usize = 100;

/// Moments of a campaign: demagnetisation and first records.
const RECORDS: Duration = Duration::from_secs(10);

#[derive(Debug, Clone, Copy, PartialEq)]
enum Protocol {
    Gcs,
    Nv200,
}

impl Protocol {
    /// Options of the simulated controller.
    fn model(self) -> &'static str {
        if self == Protocol::Gcs { "--plant paper" } else { "--plant paper --model nv200" }
    }

    fn name(self) -> &'static str {
        if self == Protocol::Gcs { "gcs" } else { "nv200" }
    }

    /// The commands of a wave.
    fn commands(self) -> &'static [&'static str] {
        match self {
            Protocol::Gcs => &[
                "WAV", "DRT", "WOS", "DRC", "RTR", "WSL", "WGC", "WTR", "SVO", "SVA", "VOL?", "WGO", "#9", "DRL?",
                "DRR?",
            ],
            Protocol::Nv200 => &[
                "gbarb/2",
                "gbarb/1",
                "goarb/1",
                "gsarb/1",
                "gearb/1",
                "gcarb/1",
                "gtarb/1",
                "grun/1",
                "grun/0",
                "set/1",
                "modsrc/1",
                "recsrc/2",
                "recstr/1",
                "reclen/1",
                "recast/1",
                "recrun/1",
                "recout/3",
                "recoutf/1",
            ],
        }
    }
}

/// What the client does, and when its fault comes.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Work {
    /// `acquire`, at a moment by chance.
    Acquire,
    /// `acquire`, at this command.
    Command(&'static str),
    /// `campaign`, at a moment of its first records.
    Campaign,
}

/// A case.
struct Case {
    what: String,
    is_campaign: bool,
    /// A signal that comes at the nth rename of a file.
    at_rename: Option<(&'static str, usize)>,
    protocol: Protocol,
    bench: Bench,
    controller: Controller,
    plan: Plan,
    is_closed: bool,
    /// The voltage before [V].
    before: f64,
    /// Entries of the log before the client.
    begin: usize,
    old: Option<[Vec<u8>; 2]>,
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

fn drive(bench: &Bench) {
    let rows: String = (0..SAMPLES).map(|k| format!("{:.3},{:.4}\n", k as f64 * 5e-3, value(k))).collect();
    bench.write("u.csv", format!("t_s,u_V\n{rows}"));
}

impl Case {
    /// A controller, perhaps in closed loop or at another voltage, perhaps with files of an older measurement.
    fn new(what: &str, protocol: Protocol, plan: Plan, dice: &mut Dice) -> Self {
        let bench = Bench::new();
        drive(&bench);
        let log = bench.path("log").display().to_string();
        let controller = Controller::with(&format!("{} --log {log}", protocol.model()));
        let is_servo = matches!(&plan.moment, Moment::Command { name, .. } if name == "SVO");
        let is_closed = protocol == Protocol::Gcs && (is_servo || dice.roll(3) == 0);
        match (protocol, is_closed, dice.roll(2)) {
            (_, true, _) => {
                controller.text("SVO 1 1\nMOV 1 20\n");
                // The servo comes to rest.
                sleep(Duration::from_millis(800));
            }
            (Protocol::Gcs, _, 1) => drop(controller.text("SVA 1 4\n")),
            (Protocol::Nv200, _, 1) => drop(controller.text("set,4\r\n")),
            _ => (),
        }
        sleep(Duration::from_millis(50));
        let old = (dice.roll(2) == 1).then(|| [b"old record".to_vec(), b"old document".to_vec()]);
        if let Some([record, document]) = &old {
            bench.write("r.csv", record);
            bench.write("r.json", document);
        }
        controller.text(if protocol == Protocol::Gcs { "POS?\n" } else { "meas\r\n" });
        let entries = witness::read(&bench.path("log"));
        let before = entries.last().map_or(0.0, |entry| entry.voltage);
        let what = format!("{what}: {} {:?}, {:?}, then {:?}", protocol.name(), plan.kind, plan.moment, plan.after);
        Case {
            what,
            is_campaign: false,
            at_rename: None,
            protocol,
            bench,
            controller,
            plan,
            is_closed,
            before,
            begin: entries.len(),
            old,
        }
    }

    fn line(&self, port: u16) -> String {
        if self.is_campaign {
            return format!(
                "campaign --port {port} --bandwidth 50 --range -25 25 --low -25 --high 25 --slew 20000V/s --period 5e-5 \
                 --wait 1 --operator preisach --timeout 1 --ramp 0.2 --yes -o all"
            );
        }
        let (low, high) = LIMITS;
        format!(
            "acquire u.csv --protocol {} --port {port} --low {low} --high {high} --timeout {} --ramp 0.2 --settle 0.05 \
             -o r.csv --json r.json",
            self.protocol.name(),
            TIMEOUT.as_secs()
        )
    }

    fn log(&self) -> Vec<Entry> {
        witness::read(&self.bench.path("log")).split_off(self.begin)
    }

    /// Runs the client with its fault.
    fn run(&self) -> (End, Line) {
        let line = Line::new(self.plan.clone(), self.controller.port(), self.controller.id());
        let command = self.line(line.port);
        let mut client = self.bench.command(&command);
        if let Some((signal, nth)) = self.at_rename {
            let calls = "rename,renameat,renameat2";
            let mut strace = Command::new("strace");
            strace.args(["-qq", "-o", "/dev/null", "-e", &format!("trace={calls}")]);
            strace.args(["-e", &format!("inject={calls}:signal=SIG{signal}:when={nth}")]);
            strace.arg(client.get_program()).args(client.get_args()).current_dir(self.bench.path(""));
            client = strace;
            *line.shared.fired.lock().unwrap() = Some(Instant::now());
        }
        let mut child = client.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        line.shared.client.store(child.id(), Ordering::SeqCst);
        let hang = if self.is_campaign { HANG_OF_A_CAMPAIGN } else { HANG };
        let status = ended(&mut child, &line.shared, self.plan.kind, hang);
        let end = Instant::now();
        // What the controller is given before the client ends, it has obeyed by then.
        sleep(Duration::from_millis(20));
        let log = self.log();
        // Its number may be that of another process from now on.
        line.shared.client.store(0, Ordering::SeqCst);
        let took = line.shared.fired.lock().unwrap().map(|fired| end.saturating_duration_since(fired));
        let run = Run::of(&command, &child.wait_with_output().unwrap());
        assert!(status.is_some(), "{}: it hangs", self.what);
        (End { run, status: status.unwrap_or_default(), took, log }, line)
    }
}

/// Waits for the end of a client; none if it hangs. It may get a second signal.
fn ended(child: &mut Child, line: &Shared, kind: Kind, hang: Duration) -> Option<ExitStatus> {
    let (begin, mut is_second) = (Instant::now(), false);
    while begin.elapsed() < hang {
        if let Some(status) = child.try_wait().unwrap() {
            return Some(status);
        }
        let fired = *line.fired.lock().unwrap();
        if let (Kind::Twice(pause, _), Some(fired)) = (kind, fired)
            && !is_second
            && fired.elapsed() >= pause
        {
            is_second = true;
            line.interrupt();
        }
        sleep(Duration::from_millis(2));
    }
    drop(child.kill());
    None
}

/// What an undisturbed measurement does: its time, and how often each command comes.
struct Whole {
    length: Duration,
    counts: BTreeMap<String, usize>,
}

impl Whole {
    fn of(protocol: Protocol) -> Self {
        let case = Case::new("without a fault", protocol, Plan::none(), &mut Dice(1));
        let begin = Instant::now();
        let (end, line) = case.run();
        let length = begin.elapsed();
        case.check(&end, &line);
        let counts = line.shared.counts.lock().unwrap().clone();
        Whole { length, counts }
    }
}

/// One case. The title of its fault, and the time from the fault to the end.
fn case(k: usize, seed: u64, protocol: Protocol, whole: &Whole, work: Work) -> (&'static str, Option<Duration>) {
    let mut dice = Dice(((seed << 32) | (k as u64 + 1)).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let most = |name: &str| whole.counts.get(name).copied().unwrap_or(1);
    let is_campaign = work == Work::Campaign;
    let command = if let Work::Command(name) = work { Some((name, most(name))) } else { None };
    let plan = Plan::of(k, command, if is_campaign { RECORDS } else { whole.length }, &mut dice);
    let what = format!("case {k}, PIEZOID_SEED={seed}, {work:?}");
    let case = Case { is_campaign, ..Case::new(&what, protocol, plan, &mut dice) };
    let (end, line) = case.run();
    case.check(&end, &line);
    drop(line);
    let is_open = end.status.signal() == Some(9) || case.ends_abruptly(&end);
    if case.plan.kind != Kind::KillController && !is_campaign && (is_open || dice.roll(4) == 0) {
        case.check_next();
    }
    (if is_campaign { "in a campaign, all of these" } else { case.plan.kind.title() }, end.took)
}

/// Tries cases, so many at once, and prints a table of them.
fn tried(cases: &[(Protocol, Work)], at_once: usize) {
    let seed = message("PIEZOID_SEED").unwrap_or(1);
    let alone = message("PIEZOID_CASE").map(|k| k as usize);
    let wholes = [Protocol::Gcs, Protocol::Nv200].map(|protocol| (protocol, Whole::of(protocol)));
    let (next, table) = (AtomicUsize::new(0), Mutex::new(BTreeMap::<&str, (usize, usize, usize, Duration)>::new()));
    let failures = Mutex::new(Vec::new());
    let one = |k: usize| {
        let (protocol, work) = cases[k];
        let (_, whole) = &wholes[usize::from(protocol == Protocol::Nv200)];
        let tried = std::panic::catch_unwind(|| case(k, seed, protocol, whole, work));
        let mut table = table.lock().unwrap();
        match tried {
            Ok((title, took)) => {
                let row = table.entry(title).or_default();
                *row = (row.0 + 1, row.1 + usize::from(took.is_some()), row.2, row.3.max(took.unwrap_or_default()));
            }
            Err(why) => {
                let why = why.downcast_ref::<String>().cloned().unwrap_or_default();
                table.entry("failed").or_default().2 += 1;
                failures.lock().unwrap().push(why);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..at_once {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, Ordering::SeqCst);
                    if k >= cases.len() {
                        break;
                    }
                    if alone.is_none_or(|alone| alone == k) {
                        one(k);
                    }
                }
            });
        }
    });
    println!("| fault | cases | came | failed | longest until the end [s] |\n|---|--:|--:|--:|--:|");
    for (title, (cases, came, failed, longest)) in table.into_inner().unwrap() {
        println!("| {title} | {cases} | {came} | {failed} | {:.2} |", longest.as_secs_f64());
    }
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{} of {} fail:\n{}", failures.len(), cases.len(), failures.join("\n"));
}

fn protocol(k: usize) -> Protocol {
    if k % 5 < 3 { Protocol::Gcs } else { Protocol::Nv200 }
}

#[test]
fn a_fault_at_any_moment_leaves_whole_files_a_stopped_generator_and_a_true_voltage() {
    let of = |k: usize| {
        let protocol = protocol(k);
        let commands = protocol.commands();
        let work = if k % 2 == 1 { Work::Command(commands[k / 2 * 7 % commands.len()]) } else { Work::Acquire };
        if k == 2 { (Protocol::Gcs, Work::Campaign) } else { (protocol, work) }
    };
    tried(&(0..40).map(of).collect::<Vec<_>>(), 10);
}

#[test]
fn a_command_that_waits_on_a_stalled_line_is_not_obeyed_once_the_axis_is_stopped() {
    std::thread::scope(|scope| {
        for (name, nth) in [("SVA", 15), ("SVO", 2), ("WGO", 1)] {
            scope.spawn(move || {
                let kind = Kind::Stall(Stall::Late(Duration::from_millis(3500)));
                let moment = Moment::Command { name: name.into(), nth, place: Place::Before };
                let plan = Plan { kind, moment, after: After::Back, garbage: Vec::new() };
                let case = Case::new("a command that waits", Protocol::Gcs, plan, &mut Dice(1));
                let (end, line) = case.run();
                assert!(end.took.is_some() && end.status.code() == Some(1), "{name}: {:?}", end.run);
                case.check(&end, &line);
                assert!(line.shared.is_delivered.load(Ordering::SeqCst));
            });
        }
    });
}

#[test]
fn a_signal_while_files_are_renamed_leaves_whole_files_and_a_true_voltage() {
    if !can_trace() {
        return;
    }
    let kinds =
        [("INT", Kind::Interrupt), ("TERM", Kind::Terminate), ("HUP", Kind::Hangup), ("KILL", Kind::KillClient)];
    std::thread::scope(|scope| {
        // Both files and their mark, then the document alone.
        for (nth, (signal, kind)) in (1..=4).flat_map(|nth| kinds.map(|kind| (nth, kind))) {
            scope.spawn(move || {
                let what = format!("{signal} at rename {nth}");
                let plan = Plan { kind, ..Plan::none() };
                let case = Case::new(&what, Protocol::Gcs, plan, &mut Dice(0x9e37_79b9 * (nth + 1) as u64));
                let case = Case { at_rename: Some((signal, nth)), ..case };
                let (end, line) = case.run();
                let is_last = nth == 4 && kind != Kind::KillClient;
                assert_eq!(end.status.code() == Some(0), is_last, "{what}: {:?}", end.run);
                case.check(&end, &line);
            });
        }
    });
}

#[test]
#[ignore = "minutes"]
fn five_hundred_faults_at_random_moments() {
    // Of each kind of fault some come in a campaign.
    let of =
        |k: usize| if k.is_multiple_of(17) { (Protocol::Gcs, Work::Campaign) } else { (protocol(k), Work::Acquire) };
    tried(&(0..500).map(of).collect::<Vec<_>>(), 16);
}

#[test]
#[ignore = "minutes"]
fn thirty_faults_at_each_command_of_a_wave() {
    let of = |protocol: Protocol| {
        let each = protocol.commands().iter().flat_map(|command| std::iter::repeat_n(Work::Command(command), 30));
        each.map(move |work| (protocol, work))
    };
    let cases: Vec<_> = of(Protocol::Gcs).chain(of(Protocol::Nv200)).collect();
    tried(&cases, 16);
}
