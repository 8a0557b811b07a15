//! The process and its environment: closed pipes, full disks, Ctrl-C.
#![cfg(unix)]

use crate::bench::{Bench, Run};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let bench = Bench::stocked();
    for line in [
        "man",
        "completions bash",
        "plants",
        "identify --help",
        "excite sine --ts 1e-4 --duration 10 --amplitude 1 --frequency 5 -o -",
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = bench.command(line).stdout(writer).output().unwrap();
        let run = Run::of(line, &output);
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{line}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_a_failure() {
    let bench = Bench::stocked();
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    for line in ["man", "--help", "simulate --plant paper --input drive5.csv -o -"] {
        let output = bench.command(line).stdout(full()).output().unwrap();
        Run::of(line, &output).exits(1).says(&["error: cannot write to stdout"]);
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_takes_no_files_is_named() {
    let bench = Bench::stocked();
    let line = "simulate --plant paper --input drive5.csv -o /proc/x.csv";
    bench.run(line).exits(1).says(&["cannot write /proc/x.csv: /proc takes no new files: name another folder"]);
}

/// True if the process is piezoid, no more the shell that starts it, and already handles Ctrl-C.
#[cfg(target_os = "linux")]
fn handles_interrupts(pid: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let field = |name: &str| status.lines().find_map(|line| line.strip_prefix(name)).unwrap_or("0").trim();
    let caught = u64::from_str_radix(field("SigCgt:"), 16);
    field("Name:") == "piezoid" && caught.is_ok_and(|mask| mask & 0b10 != 0)
}

#[cfg(not(target_os = "linux"))]
fn handles_interrupts(_: u32) -> bool {
    std::thread::sleep(Duration::from_secs(2));
    true
}

#[test]
fn ctrl_c_ends_a_long_identification_in_good_order() {
    let bench = Bench::stocked();
    bench.write("m.json", "precious");
    let before = bench.files();
    let line = "identify sine5.csv --method paper --small-signal prbs.csv --iterations 2000000 -o m.json --json f.json";
    let child = bench.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let started = Instant::now();
    while !handles_interrupts(child.id()) && started.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_millis(200));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let interrupted = Instant::now();
    let run = Run::of(line, &child.wait_with_output().unwrap()).exits(130);
    assert!(interrupted.elapsed() < Duration::from_secs(2), "{:?}", interrupted.elapsed());
    let run = run.says(&["error: ", "cancelled: ", " of 2000000", "nothing was written"]);
    assert_eq!((run.err.lines().count(), run.out.as_str()), (1, ""));
    assert!(before == bench.files());
}

#[test]
fn ctrl_c_keeps_the_best_model_so_far_and_no_older_file_is_lost() {
    let bench = Bench::stocked();
    let line = "identify sine5.csv sine20.csv --small-signal prbs.csv --effort thorough -o m.json";
    let interrupted = |after: Duration| {
        let child = bench.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(after);
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        Run::of(line, &child.wait_with_output().unwrap()).exits(130)
    };
    // At first there is no model yet. Small steps: soon after the first model the search may be over.
    let kept = |after| Some(interrupted(after)).filter(|run| !run.err.contains("nothing was written"));
    let first_kept = || (0..12).map(|k| Duration::from_secs_f64(0.5 * 1.4f64.powi(k))).find_map(kept).unwrap();
    let run = first_kept().says(&["error: cancelled: wrote the best model until then to m.json, only good to "]);
    assert_eq!(run.out, "");
    let first = bench.text("m.json");
    let of =
        |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap()["fit"]["verdict"]["cancelled_in"].clone();
    assert!(of(&first).is_string(), "{first}");

    first_kept().says(&["m.unfinished.json"]);
    assert_eq!(bench.text("m.json"), first);
    assert!(of(&bench.text("m.unfinished.json")).is_string());
    bench.run("validate sine5.csv --model m.json").ok().prints(&["the search was cancelled in"]);
}

#[test]
fn ctrl_c_prints_what_was_compared_until_then() {
    let bench = Bench::stocked();
    let line = "compare model.json sine5.csv sine20.csv --operators auto,stop --effort thorough --json c.json";
    let child = bench.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let started = Instant::now();
    while !handles_interrupts(child.id()) && started.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_millis(1000));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let run = Run::of(line, &child.wait_with_output().unwrap()).exits(130);
    let run = run.says(&[
        "auto: cancelled",
        "stop: cancelled",
        "the table has what was compared until then; nothing was written",
    ]);
    run.prints(&["method", "model.json", "auto", "failed"]);
    assert!(!bench.path("c.json").exists());
}

/// Only Linux shows what is ignored.
#[test]
#[cfg(target_os = "linux")]
fn a_run_that_was_started_by_nohup_goes_on_after_its_terminal_is_gone() {
    let bench = Bench::stocked();
    let line = "identify sine5.csv --method paper --small-signal prbs.csv -o m.json";
    let mut run = Command::new("sh");
    run.args(["-c", "trap '' HUP; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_piezoid")]).args(line.split_whitespace());
    let child = run.current_dir(bench.path("")).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    while !handles_interrupts(child.id()) {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(Command::new("kill").args(["-HUP", &child.id().to_string()]).status().unwrap().success());
    Run::of(line, &child.wait_with_output().unwrap()).ok();
}
