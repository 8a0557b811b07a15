//! Every hostile model of `fuzz/models` in every use: success or a clear error, within 10 s and 1 GiB.
#![cfg(target_os = "linux")]

use crate::bench::{Bench, Run};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Seconds of computing, and KiB of address space. Builds for tests are three times slower than releases.
const LIMITS: &str = "ulimit -t 30 && ulimit -v 1258291";

/// What is done with each model. Target `fixed` interprets for minutes in a build for tests: see below.
const USES: [&str; 11] = [
    "simulate sine.csv --model hostile.json -o a.csv",
    "validate sine.csv --model hostile.json --full --json v.json",
    "report sine.csv --model hostile.json -o r.html",
    "compare hostile.json plain.json --data sine.csv -o c.html",
    "compensate path.csv --model hostile.json -o u.csv",
    "compensate path.csv --model hostile.json --driver pl140 --clip --iterations 2 --smooth 10ms --zvd -o u.csv",
    "control --plant pl140 --model hostile.json --reference path.csv --controller feed-forward --json k.json",
    "plan --actuator pl140 --bandwidth 80 --driver pl140 --model hostile.json -o plan",
    "export --model hostile.json --target waveform --reference path.csv --driver pl140 --clip --force -o w",
    "export --model hostile.json --target c --controller integral-notch --force -o x",
    "identify --again hostile.json sine.csv -o again.json",
];

/// The other targets print the same program, so that few models are enough for them.
const TARGETS: [&str; 5] = ["st", "rust", "simulink", "fmu2", "fixed"];
const FEW: [&str; 5] =
    ["offset-of-1e308", "pole-at-two", "gain-of-1e-320", "units-that-end-comments", "delay-of-500-samples"];

/// A folder with a record, a path and a legitimate model.
fn stocked() -> Bench {
    let bench = Bench::new();
    for line in [
        "excite sine --frequency 10 --amplitude 25 --ts 1e-3 --duration 0.2 -o drive.csv",
        "simulate drive.csv --plant pl140 -o sine.csv",
        "excite sine --frequency 10 --amplitude 200 --unit um --ts 1e-3 --duration 0.2 -o path.csv",
    ] {
        bench.run(line).exits(0);
    }
    let plain = r#"{"piezoid": 1, "ts": 0.001, "units": {"u": "V", "y": "um"}, "linear": {"a": [0.5], "b": [5.0]},
        "hysteresis": {"operator": "proportional", "gain": 1.0}}"#;
    bench.write("plain.json", plain);
    bench
}

fn models() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/models");
    let mut found: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.sort();
    assert!(found.len() > 20);
    found
}

/// Runs `line` within the limits; it ends by itself, and an error has one line that says what is wrong.
fn ends(bench: &Bench, model: &Path, line: &str) {
    std::fs::copy(model, bench.path("hostile.json")).unwrap();
    let inner = bench.command(line);
    let mut shell = Command::new("sh");
    shell.current_dir(inner.get_current_dir().unwrap()).args(["-c", &format!("{LIMITS} && exec \"$0\" \"$@\"")]);
    let run = Run::of(line, &shell.arg(inner.get_program()).args(inner.get_args()).output().unwrap());
    let named = model.display();
    assert!(matches!(run.code, Some(0..=2)), "{named}: {run:?}");
    assert!(!run.err.contains("panicked"), "{named}: {run:?}");
    assert_eq!(run.err.matches("error: ").count(), usize::from(run.code != Some(0)), "{named}: {run:?}");
}

/// The models, divided among as many threads as tests may use.
fn each(expected: impl Fn(&Path) -> bool + Sync, lines: &[String]) {
    let models: Vec<_> = models().into_iter().filter(|model| expected(model)).collect();
    let next = std::sync::atomic::AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(2, usize::from).min(8) {
            scope.spawn(|| {
                let bench = stocked();
                while let Some(model) = models.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
                    lines.iter().for_each(|line| ends(&bench, model, line));
                }
            });
        }
    });
}

#[test]
fn every_use_of_a_hostile_model_ends_within_10_s_and_1_gib() {
    each(|_| true, &USES.map(String::from));
}

#[test]
fn every_target_exports_hostile_models_or_says_why_not() {
    let lines = TARGETS.map(|target| format!("export --model hostile.json --target {target} --force -o {target}"));
    each(|model| FEW.iter().any(|name| model.file_stem().is_some_and(|stem| stem == *name)), &lines);
}
