//! Kills every verb that writes files, over the files of an older run: no file is torn, and a set of old and new files
//! is named by its mark. A signal that can be handled leaves all old or all new, and nothing else; after one that
//! cannot, the next run cleans up.
//!
//! Half of the kills come at random moments, half of these from the first temporary file on; `strace` sends the others
//! at each rename, each removal and each new folder. `PIEZOID_KILLS` is their number; another `PIEZOID_SEED` takes
//! other moments. It does not do: loss of power.
#![cfg(unix)]

use crate::bench::{Bench, Run};
use piezoid::Model;
use piezoid_testing::skipped;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{DirEntry, File};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, ChildStdout, Command, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant, SystemTime};

/// Kills unless PIEZOID_KILLS says otherwise; 1000 before a release.
const KILLS: u64 = 50;

/// What a verb writes, the line that writes it, and how the line ends for the older and the newer files. Without an
/// older end there are no older files.
type Row<'r> = (&'r str, &'r str, Option<&'r str>, &'r str);

const ROWS: &[Row] = &[
    ("excite", "excite sine --ts 5e-4 --duration 1 --frequency 5 -o x.csv --amplitude", Some("10"), "20"),
    ("simulate", "simulate drive5.csv -o x.csv --plant", Some("paper"), "pl140"),
    ("prepare", "prepare -o x.csv --decimate 2", Some("sine5.csv"), "sine20.csv"),
    ("plan", "plan --actuator pl140 --driver pl140 -o out --json x.json --bandwidth", Some("80"), "50"),
    ("plan, new folder", "plan --actuator pl140 --driver pl140 -o new/out --bandwidth", None, "50"),
    ("study", "study --plant paper --out out --json x.json --seed", Some("1"), "2"),
    (
        "identify",
        "identify --operator stop -o 1/x.json --json 2/x.json --report x.html",
        Some("sine5.csv"),
        "sine20.csv",
    ),
    ("validate", "validate --model a.json --json x.json", Some("sine5.csv"), "sine20.csv"),
    ("report", "report --model a.json -o x.html", Some("sine5.csv"), "sine20.csv"),
    ("compare", "compare a.json model.json -o x.html --json x.json --data", Some("sine5.csv"), "sine20.csv"),
    ("compensate", "compensate path.csv -o x.csv --json x.json --model", Some("a.json"), "model.json"),
    (
        "control",
        "control --plant pl140 --controller pi --reference sine:5 -o x.csv --report x.html --json x.json --model",
        Some("a.json"),
        "model.json",
    ),
    ("c, new folder", "export --target c -o out --json x.json --model", None, "b.json"),
    ("simulink, fewer", "export --target simulink -o out --model", Some("a.json --controller pi"), "b.json"),
    ("simulink, more", "export --target simulink -o out --model", Some("a.json"), "b.json --controller pi"),
];

const SIGNALS: [&str; 4] = ["KILL", "TERM", "INT", "HUP"];

/// System calls at which a signal is sent.
const CALLS: [&str; 3] = ["rename,renameat,renameat2", "unlink,unlinkat,rmdir", "mkdir,mkdirat"];

/// A signal that is sent so soon may come before the process, on a busy machine, handles it.
const EARLY: Duration = Duration::from_millis(100);

/// The file that names a set which may be mixed.
const MARK: &str = "piezoid-unfinished.txt";

/// The best model of a search that was cancelled.
const BEST: &str = "1/x.unfinished.json";

/// When a signal is sent.
#[derive(Clone, Copy, Debug)]
enum Moment {
    /// At a share of the undisturbed run.
    Share(f64),
    /// So long after a temporary file in the second half of the run.
    Staged(Duration),
    /// At the k-th of these system calls.
    Call(&'static str, usize),
}

/// Files with their bytes, and folders, which end with a slash.
type Content = BTreeMap<String, Vec<u8>>;

/// What is counted of kills.
const COUNTED: [&str; 9] = ["kills", "finished", "old", "new", "named", "unnamed", "torn", "left", "right again"];

type Counts = [u64; COUNTED.len()];

/// A command over the files of an older one.
struct Scenario {
    name: String,
    bench: Bench,
    line: String,
    old: Content,
    new: Content,
    /// How long an undisturbed run takes.
    took: Duration,
    /// All of [`CALLS`] that it makes.
    calls: Vec<Moment>,
}

impl Scenario {
    fn new(inputs: &Content, traces: bool, (name, line, older, newer): Row) -> Self {
        let bench = Bench::new();
        inputs.iter().for_each(|(name, bytes)| bench.write(name, bytes));
        ["1", "2", "tmp"].iter().for_each(|folder| std::fs::create_dir(bench.path(folder)).unwrap());
        if let Some(older) = older {
            bench.run(&format!("{line} {older}")).ok();
        }
        let old = bench.everything();
        let line = format!("{line} {newer}");
        let mut result = Scenario {
            name: name.into(),
            bench,
            line,
            old,
            new: Content::new(),
            took: Duration::ZERO,
            calls: Vec::new(),
        };
        let started = Instant::now();
        let run = if traces { result.traced(&CALLS.join(","), None) } else { result.command().output().unwrap() };
        result.took = started.elapsed();
        result.new = result.bench.everything();
        let message = Run::of(&result.line, &run).ok().err;
        let count = |call: &str| message.lines().filter(|line| line.starts_with(&format!("{call}("))).count();
        for calls in CALLS {
            let most = calls.split(',').map(count).max().unwrap_or(0);
            result.calls.extend((1..=most).map(|k| Moment::Call(calls, k)));
        }
        result
    }

    fn command(&self) -> Command {
        let mut command = self.bench.command(&self.line);
        command.env("TMPDIR", self.bench.path("tmp")).stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    /// The same under `strace`, which shows and changes these system calls.
    fn traced(&self, calls: &str, inject: Option<String>) -> Output {
        let plain = self.command();
        let mut strace = Command::new("strace");
        strace.args(["-qq", "-e", &format!("trace={calls}")]);
        strace.args(inject.iter().flat_map(|inject| ["-e", inject]));
        strace.arg(plain.get_program()).args(plain.get_args());
        strace.current_dir(self.bench.path("")).env("TMPDIR", self.bench.path("tmp")).output().unwrap()
    }

    /// Makes the folder as it was before the command.
    fn restore(&self) {
        let now = self.bench.everything();
        // What is inside of a folder comes after it.
        for name in now.keys().rev().filter(|name| !self.old.contains_key(*name)) {
            let path = self.bench.path(name);
            if path.is_dir() { std::fs::remove_dir(path) } else { std::fs::remove_file(path) }.unwrap();
        }
        for (name, bytes) in self.old.iter().filter(|(name, bytes)| now.get(*name) != Some(bytes)) {
            self.bench.write(name, bytes);
        }
    }

    /// Runs the command and kills it.
    fn killed(&self, sender: &mut Sender, signal: &str, moment: Moment) -> ExitStatus {
        if let Moment::Call(calls, k) = moment {
            return self.traced(calls, Some(format!("inject={calls}:signal=SIG{signal}:when={k}"))).status;
        }
        let mut child = self.command().spawn().unwrap();
        match moment {
            Moment::Share(share) => std::thread::sleep(self.took.mul_f64(share)),
            Moment::Staged(later) => {
                std::thread::sleep(self.took / 2);
                while !self.is_staged() && child.try_wait().unwrap().is_none() {}
                std::thread::sleep(later);
            }
            Moment::Call(..) => {}
        }
        if child.try_wait().unwrap().is_none() {
            sender.send(signal, &child);
        }
        child.wait().unwrap()
    }

    /// True if a temporary file is there.
    fn is_staged(&self) -> bool {
        let folders = self.new.keys().filter(|name| name.ends_with('/')).map(String::as_str).chain([""]);
        let mut entries = folders.flat_map(|folder| std::fs::read_dir(self.bench.path(folder))).flatten().flatten();
        entries.any(|entry| entry.file_name().to_string_lossy().trim_start_matches('.').starts_with("piezoid-"))
    }

    /// Waits until no process is in the folder: the compiler of an FMU ends a moment after its caller.
    fn is_quiet(&self) -> bool {
        let home = self.bench.path("").canonicalize().unwrap();
        let is_here =
            |process: DirEntry| process.path().join("cwd").read_link().is_ok_and(|cwd| cwd.starts_with(&home));
        let requested = Instant::now();
        while std::fs::read_dir("/proc").into_iter().flatten().flatten().any(is_here) {
            if requested.elapsed() > Duration::from_secs(5) {
                return false;
            }
        }
        true
    }

    /// The best model of a search that was cancelled, which is written beside the older one, and is removed here.
    fn take_best(&self) -> Option<String> {
        let best = std::fs::read_to_string(self.bench.path(BEST)).ok();
        best.inspect(|_| std::fs::remove_file(self.bench.path(BEST)).unwrap())
    }

    /// Kills a run over the older files, counts what that leaves, and runs the command again. Returns the counts, and
    /// what must not be.
    fn trial(&self, sender: &mut Sender, signal: &str, moment: Moment) -> (Counts, Vec<String>) {
        self.restore();
        let status = self.killed(sender, signal, moment);
        let is_quiet = self.is_quiet();
        let is_best_torn = self.take_best().is_some_and(|best| Model::from_json(&best).is_err());
        let now = self.bench.everything();
        let names: BTreeSet<&String> = self.old.keys().chain(self.new.keys()).filter(|n| !n.ends_with('/')).collect();
        let is = |name: &String, as_in: &Content| now.get(name) == as_in.get(name);
        let (same, differ): (Vec<&String>, Vec<&String>) =
            names.into_iter().partition(|name| self.old.get(*name) == self.new.get(*name));
        let torn = differ.iter().filter(|n| !is(n, &self.old) && !is(n, &self.new)).count()
            + same.iter().filter(|n| !is(n, &self.old)).count();
        let [is_old, is_new] = [&self.old, &self.new].map(|set| differ.iter().all(|name| is(name, set)));
        let is_named = |name: &&String| {
            let (folder, file) = name.rsplit_once('/').map_or(("", &***name), |(folder, file)| (folder, file));
            let mark = now.get(format!("{folder}/{MARK}").trim_start_matches('/'));
            mark.is_some_and(|mark| String::from_utf8_lossy(mark).lines().any(|line| line == file))
        };
        let is_mixed = !is_old && !is_new;
        let is_named = is_mixed && differ.iter().all(is_named);
        let is_extra = |name: &&String| !self.old.contains_key(*name) && !self.new.contains_key(*name);
        let handled = signal != "KILL" && status.signal().is_none();
        // Folders that the command makes are there with their files or not at all.
        let expected = if is_old { &self.old } else { &self.new };
        let mut left = handled && !now.keys().eq(expected.keys()) || !is_quiet;
        let right_end = match (status.code(), status.signal()) {
            (Some(0), _) => is_new,
            (Some(130), _) => signal != "KILL",
            // A signal may come before it can be handled, but not once files are written.
            (None, Some(_)) => {
                let is_early = matches!(moment, Moment::Share(share) if self.took.mul_f64(share) < EARLY);
                signal == "KILL" || is_early && is_old && now.keys().eq(self.old.keys())
            }
            _ => false,
        };

        // Later.
        let hours_ago = SystemTime::now() - Duration::from_secs(2 * 3600);
        for name in now.keys().filter(is_extra).filter(|name| !name.ends_with(MARK)) {
            File::open(self.bench.path(name)).and_then(|file| file.set_modified(hours_ago)).unwrap();
        }
        let again = Run::of(&self.line, &self.command().stderr(Stdio::piped()).output().unwrap());
        let after = self.bench.everything();
        let extra: Vec<&String> = after.keys().filter(is_extra).collect();
        left |= !extra.is_empty();
        let is_right = again.code == Some(0) && after == self.new;

        let finished = status.code() == Some(0);
        let unnamed = is_mixed && !is_named;
        let faults = [
            (unnamed || handled && is_mixed, "old and new files are mixed".into()),
            (torn > 0, format!("{torn} files are torn")),
            (is_best_torn, format!("{BEST} is torn")),
            (left, format!("left are {:?}, then {extra:?}", now.keys().filter(is_extra).collect::<Vec<_>>())),
            (!is_quiet, "a process is left".into()),
            (!right_end, format!("the end is {status}")),
            (!is_right, format!("the next run ends with {again:?}")),
        ];
        let faults = faults.into_iter().filter(|(is_so, _)| *is_so);
        let faults = faults.map(|(_, fault)| format!("{}, {signal} at {moment:?}: {fault}", self.name)).collect();
        let counts =
            [true, finished, is_old, is_new && !is_old, is_named, unnamed, torn > 0, left, is_right].map(u64::from);
        (counts, faults)
    }
}

/// A shell that sends signals, which is quicker than a process for each.
struct Sender {
    shell: Child,
    message: BufReader<ChildStdout>,
}

impl Sender {
    fn new() -> Self {
        let mut shell = Command::new("sh").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let message = BufReader::new(shell.stdout.take().unwrap());
        Sender { shell, message }
    }

    fn send(&mut self, signal: &str, child: &Child) {
        writeln!(self.shell.stdin.as_mut().unwrap(), "kill -{signal} {}; echo", child.id()).unwrap();
        self.message.read_line(&mut String::new()).unwrap();
    }
}

impl Drop for Sender {
    fn drop(&mut self) {
        drop(self.shell.stdin.take());
        let _ = self.shell.wait();
    }
}

/// Random numbers (xorshift, Marsaglia 2003).
pub(crate) struct Dice(pub(crate) u64);

impl Dice {
    pub(crate) fn roll(&mut self, sides: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % sides
    }
}

/// True if `strace` can end a process here.
pub(crate) fn can_trace() -> bool {
    let end = ["-qq", "-e", "trace=exit_group", "-e", "inject=exit_group:signal=SIGKILL", "true"];
    let ended = Command::new("strace").args(end).output();
    let can = ended.is_ok_and(|ended| ended.status.signal() == Some(9));
    if cfg!(target_os = "linux") && !can {
        skipped("no strace that may trace: no kill comes between two files");
    }
    can
}

/// Records, a path and models: b.json has another sampling period than the others.
fn inputs() -> Content {
    let bench = Bench::stocked();
    for line in [
        "excite sine --ts 5e-4 --duration 1 --amplitude 20 --frequency 5 --unit um -o path.csv",
        "excite sine --ts 1e-3 --duration 1 --amplitude 30 --frequency 5 -o slow.csv",
        "simulate slow.csv --plant pl140 -o slow5.csv",
        "identify sine5.csv --operator stop --order 2 -o a.json",
        "identify slow5.csv --operator stop --order 2 -o b.json",
    ] {
        bench.run(line).ok();
    }
    bench.files()
}

pub(crate) fn message(variable: &str) -> Option<u64> {
    std::env::var(variable).ok().map(|value| value.parse().unwrap())
}

#[test]
fn a_killed_run_tears_nothing_names_what_it_mixed_and_the_next_one_leaves_nothing() {
    let kills = message("PIEZOID_KILLS").unwrap_or(KILLS);
    let seed = message("PIEZOID_SEED").unwrap_or(1);
    println!("{kills} kills, PIEZOID_SEED={seed}");
    let targets = Bench::new().run("targets --json -").ok().out_json();
    let targets = targets.as_array().unwrap().iter().map(|target| {
        let name = target["name"].as_str().unwrap();
        let (option, newer) = if name == "waveform" { (" --reference path.csv", "model.json") } else { ("", "b.json") };
        (name, format!("export --target {name}{option} -o out --json x.json --model"), newer)
    });
    let targets: Vec<_> = targets.collect();
    let exports = targets.iter().map(|(name, line, newer)| (*name, &**line, Some("a.json"), *newer));
    // A study takes seconds.
    let rows = ROWS.iter().copied().filter(|row| row.0 != "study" || kills > KILLS).chain(exports);
    let traces = can_trace();
    let (inputs, mut dice, mut sender) = (inputs(), Dice(seed.max(1)), Sender::new());
    let scenarios: Vec<_> = rows.map(|row| Scenario::new(&inputs, traces, row)).collect();
    let calls = scenarios.iter().flat_map(|one| one.calls.iter().map(move |call| (one, *call)));
    let mut traced: Vec<_> =
        calls.flat_map(|(one, call)| ["KILL", "TERM", "INT"].map(|signal| (one, signal, call))).collect();

    let mut counts = BTreeMap::<_, Counts>::new();
    let mut faults = Vec::new();
    for k in 0..kills as usize {
        let share = dice.roll(1000) as f64 / 1000.0;
        let (one, signal, moment) = match k % 2 == 1 && !traced.is_empty() {
            true => traced.swap_remove(dice.roll(traced.len() as u64) as usize),
            false => {
                let moment = match dice.roll(2) {
                    0 => Moment::Share(share),
                    _ => Moment::Staged(Duration::from_millis(3).mul_f64(share)),
                };
                (&scenarios[k / 2 % scenarios.len()], SIGNALS[dice.roll(4) as usize], moment)
            }
        };
        let (observed, wrong) = one.trial(&mut sender, signal, moment);
        faults.extend(wrong);
        for row in [(one.name.as_str(), signal), ("all", signal), ("all", "")] {
            counts.entry(row).or_default().iter_mut().zip(observed).for_each(|(sum, one)| *sum += one);
        }
    }
    println!("| command | signal | {} |\n|---|---|{}", COUNTED.join(" | "), "--:|".repeat(COUNTED.len()));
    for ((name, signal), counts) in &counts {
        println!("| {name} | {signal} | {} |", counts.map(|count| count.to_string()).join(" | "));
    }
    assert!(faults.is_empty(), "{} faults, PIEZOID_SEED={seed}:\n{}", faults.len(), faults.join("\n"));
}

/// Otherwise each would replace some files after the other.
#[test]
fn of_two_runs_at_once_all_files_are_of_one() {
    let bench = Bench::stocked();
    let line = |hz: &str| format!("plan --actuator pl140 --driver pl140 -o out --json x.json --bandwidth {hz}");
    let [one, other] = ["80", "50"].map(|hz| {
        bench.run(&line(hz)).ok();
        bench.everything()
    });
    for _ in 0..message("PIEZOID_KILLS").unwrap_or(KILLS) / 4 {
        let mut both = ["80", "50"].map(|hz| bench.command(&line(hz)).stdout(Stdio::null()).spawn().unwrap());
        both.iter_mut().for_each(|run| assert!(run.wait().unwrap().success()));
        let now = bench.everything();
        assert!(now == one || now == other, "mixed are {:?}", now.keys());
    }
}

/// The files of a killed export in C are found by the compiler too.
#[test]
fn a_mixed_export_in_c_does_not_compile() {
    let bench = Bench::stocked();
    bench.run("identify sine5.csv --operator stop --order 2 -o other.json").ok();
    let files = ["piezo_model.h", "piezo_model.c", "piezo_model_test.c"];
    let [old, new] = ["model.json", "other.json"].map(|model| {
        bench.run(&format!("export --target c -o out --model {model}")).ok();
        files.map(|file| bench.bytes(&format!("out/{file}")))
    });
    for choice in 0..8 {
        let of = |k: usize| if choice & 1 << k == 0 { &old[k] } else { &new[k] };
        files.iter().enumerate().for_each(|(k, file)| bench.write(&format!("out/{file}"), of(k)));
        let mut cc = Command::new("cc");
        cc.args(["-std=c99", "-fsyntax-only", files[1], files[2]]).current_dir(bench.path("out")).stderr(Stdio::null());
        let Ok(status) = cc.status() else { return skipped("no C compiler cc") };
        assert_eq!(status.success(), [0, 7].contains(&choice), "new are the files of bits {choice:03b}");
    }
}
