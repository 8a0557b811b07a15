//! Records with defects that occur in laboratories, through `identify` from end to end: a note or an error names each.

use crate::bench::{Bench, number};
use crate::quality::rewritten;
use std::sync::OnceLock;

/// Changes input and output of sample `t` of a record; `None` if the row is missing.
type Change = fn(usize, f64, f64) -> Option<(f64, f64)>;

/// Options of all tests here, with the sampling period, because rewritten records have no time column.
const HOW: &str = "--ts 5e-4 --operator prandtl-ishlinskii --elements 8 -o m.json";
const ALL: &str = "--small-signal small.csv --large-signal r5.csv r17.csv r40.csv";
const RICH: &str = "--data r5.csv r17.csv r40.csv";

/// A PRBS, three rising sines, and a staircase for validation, of a plant with noise, creep and three modes.
fn bench() -> Bench {
    static STOCK: OnceLock<Vec<(String, Vec<u8>)>> = OnceLock::new();
    let records = STOCK.get_or_init(|| {
        let bench = Bench::new();
        let rising = |hz: u8| format!("rising-sine --duration 0.8 --amplitude 28 --frequency {hz}");
        for (name, kind) in [
            ("small", "prbs --duration 1.0235 --amplitude 1 --order 11".into()),
            ("r5", rising(5)),
            ("r17", rising(17)),
            ("r40", rising(40)),
            ("stairs", "staircase --duration 0.5 --amplitude 25 --frequency 10".into()),
        ] {
            bench.run(&format!("excite {kind} --ts 5e-4 -o drive.csv")).ok();
            bench.run(&format!("simulate --plant pl140 --input drive.csv -o {name}.csv")).ok();
        }
        bench.files().into_iter().filter(|(name, _)| name != "drive.csv").collect()
    });
    let bench = Bench::new();
    records.iter().for_each(|(name, bytes)| bench.write(name, bytes));
    bench
}

/// A bench in which these records are changed.
fn spoilt(records: &[&str], change: Change) -> Bench {
    let bench = bench();
    for name in records {
        let file = format!("{name}.csv");
        rewritten(&bench, &file, &file, change);
    }
    bench
}

/// Residual of the model on the staircase [% of peak-to-peak].
fn left(bench: &Bench) -> f64 {
    let observed = bench.run("validate --model m.json --data stairs.csv --offset free --json -").ok().out_json();
    number(&observed["total"]["rms_pp_percent"])
}

fn by_sound_records() -> f64 {
    static LEFT: OnceLock<f64> = OnceLock::new();
    *LEFT.get_or_init(|| {
        let bench = bench();
        bench.run(&format!("identify {ALL} {HOW}")).ok();
        left(&bench)
    })
}

const R: &[&str] = &["r5", "r17", "r40"];

#[test]
fn what_is_spoilt_is_named_and_the_model_is_about_as_good() {
    let cases: &[(&str, &[&str], Change, &[&str])] = &[
        ("drift", R, |t, u, y| Some((u, y + 0.06 * t as f64)), &["large-signal record 3: the output drifts"]),
        ("spikes", R, |t, u, y| Some((u, if t % 80 == 43 { y + 300.0 } else { y })), &["outliers"]),
        ("error codes", R, |t, u, y| Some((u, if t % 301 == 7 { -32768.0 } else { y })), &["outliers", "-32768"]),
        ("overflow", &["r5", "small"], |t, u, y| Some((u, if t == 500 { 1e9 } else { y })), &["outliers", "1.000e9"]),
        ("sensor limit", R, |_, u, y| Some((u, y.clamp(-750.0, 750.0))), &["saturated"]),
        ("frozen", R, |t, u, y| Some((u, if (1400..1460).contains(&t) { 77.0 } else { y })), &["frozen"]),
        ("far off", &["r5", "r17", "r40", "small"], |_, u, y| Some((u, y + 1e6)), &[]),
        ("lost rows", &["r17"], |t, u, y| (!(1203..1263).contains(&t)).then_some((u, y)), &["missing", "split"]),
    ];
    for (name, records, change, says) in cases {
        let bench = spoilt(records, *change);
        bench.run(&format!("identify {ALL} {HOW}")).ok().says(says);
        let (now, sound) = (left(&bench), by_sound_records());
        assert!(now < 1.5 * sound, "{name}: {now} % is left, {sound} % by sound records");
    }
}

#[test]
fn without_a_small_signal_record_neither_spikes_nor_drift_hide_the_dynamics() {
    let plain = bench();
    plain.run(&format!("identify {RICH} {HOW}")).ok();
    let cases: [Change; 2] =
        [|t, u, y| Some((u, if t % 80 == 43 { y + 300.0 } else { y })), |t, u, y| Some((u, y + 0.06 * t as f64))];
    for change in cases {
        let bench = spoilt(R, change);
        bench.run(&format!("identify {RICH} {HOW}")).ok();
        assert!(left(&bench) < 2.0 * left(&plain), "{} %, not {} %", left(&bench), left(&plain));
    }
}

#[test]
fn what_says_nothing_is_refused_by_the_record_that_does() {
    let noise: Change = |t, u, _| Some((u, ((t * t) as f64 * 0.618_034).fract()));
    let cases: &[(&str, &[&str], Change, &[&str])] = &[
        (ALL, &["r17"], |_, _, y| Some((3.0, y)), &["large-signal record 2: the input is constant at 3 V", "drive"]),
        (ALL, &["r40"], |_, u, _| Some((u, 7.0)), &["large-signal record 3: the output is constant at 7 um", "sensor"]),
        (ALL, &["small"], |_, u, _| Some((u, 7.0)), &["small-signal record: the output is constant at 7 um"]),
        (ALL, R, noise, &["no better than a constant does", "large-signal record 1", "%", "depends on the input"]),
        (RICH, R, noise, &["no better than a constant does"]),
        (ALL, &["r5"], |t, u, y| (t < 3).then_some((u, y)), &["large-signal record 1: the record has 3 samples", "16"]),
        (RICH, &["r5"], |t, u, y| (t < 10).then_some((u, y)), &["10 samples", "at least 16", "take a longer record"]),
        (ALL, &["small"], |t, u, y| (t < 50).then_some((u, y)), &["record 1 that is held out", "record longer"]),
        (ALL, &["small"], |t, u, y| (t < 1).then_some((u, y)), &["1 sample", "16"]),
        (ALL, &["r40"], |t, u, y| Some((u, if t == 500 { f64::NAN } else { y })), &["line 502", "y_um", "NaN"]),
    ];
    for (line, records, change, says) in cases {
        spoilt(records, *change).refused(&format!("identify {line} {HOW}")).says(says);
    }
    let bench = bench();
    bench
        .refused("identify --small-signal stairs.csv --large-signal r5.csv --order 6 -o m.json")
        .says(&["needs 7", "PRBS"]);
    bench.run("excite sine --ts 1e-3 --duration 1 --amplitude 28 --frequency 5 -o drive.csv").ok();
    bench.run("simulate --plant pl140 --input drive.csv -o slow.csv").ok();
    bench.refused("identify --data r5.csv slow.csv -o m.json").says(&["0.0005 s", "0.001 s", "resample"]);
}

#[test]
fn a_model_that_cannot_be_trusted_is_told_as_such() {
    let noise: Change = |t, u, y| Some((u, 1e-3 * y + ((t * t) as f64 * 0.618_034).fract()));
    let cases: &[(&str, &[&str], Change, &[&str])] = &[
        (ALL, &["small"], noise, &["small-signal record: the residual is", "noise"]),
        (ALL, &["small"], |_, u, y| Some((u, -y)), &["small-signal record: the residual is", "sign"]),
        ("--data r5.csv", &["r5"], |t, u, y| (t < 40).then_some((u, y)), &["few for", "has a reversal"]),
        (
            "--data r5.csv r5.csv r17.csv",
            &[],
            |_, u, y| Some((u, y)),
            &["large-signal record 1 and large-signal record 2 are the same"],
        ),
        ("--data small.csv", &[], |_, u, y| Some((u, y)), &[]),
    ];
    for (line, records, change, says) in cases {
        let bench = spoilt(records, *change);
        bench.run(&format!("identify {line} {HOW}")).ok().says(says);
        if says.is_empty() {
            bench.run("validate --model m.json --data stairs.csv").ok().says(&["note:", "outside this range"]);
        }
    }
}

#[test]
fn sign_unit_and_sampling_period_of_the_records_change_nothing() {
    let held_out = |bench: &Bench, ts: &str| {
        let how = HOW.replace("5e-4", ts);
        bench.run(&format!("identify {RICH} {how} --order 0 --json f.json")).ok();
        number(&bench.json("f.json")["trials"][0]["held_out_percent"])
    };
    let scaled: [(Change, &str); 5] = [
        (|_, u, y| Some((u, y)), "5e-4"),
        (|_, u, y| Some((u, -y)), "5e-4"),
        (|_, u, y| Some((u, 1e-6 * y)), "1e-6"),
        (|_, u, y| Some((u, 1e9 * y)), "10"),
        (|_, u, y| Some((u, 1e-3 * y + 1e5)), "5e-4"),
    ];
    let all = scaled.map(|(change, ts)| held_out(&spoilt(R, change), ts));
    assert!(all.iter().all(|one| (one / all[0] - 1.0).abs() < 0.01), "{all:?}");
}
