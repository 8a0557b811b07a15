//! The voltage for a requested displacement.

use crate::bench::{Bench, number};
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// A bench with a reference that is constant for 0.1 s and then a sine of 5 Hz and this amplitude [um].
fn bench(height: f64) -> Bench {
    let bench = Bench::stocked();
    let moved = |t: i32| height * (TAU * 5.0 * 5e-4 * f64::from((t - 200).max(0))).sin();
    let row = |t: i32| format!("{},{}\n", f64::from(t) * 5e-4, moved(t));
    bench.write("r.csv", "t_s,r_um\n".to_string() + &(0..800).map(row).collect::<String>());
    bench
}

const MAKE: &str = "compensate --model model.json --reference r.csv";

#[test]
fn the_voltage_makes_the_model_follow_and_the_table_says_how_near() {
    let bench = bench(400.0);
    let run = bench.run(&format!("{MAKE} --driver pl140 --json figures.json -o u.csv")).ok();
    run.prints(&["% of peak-to-peak of r", "expected on the actuator", "highest [V]", "current [A]", "% of limit"])
        .says(&["the model is good to", "unproven: amplitudes below 20 V"]);
    assert!(bench.text("u.csv").starts_with("t_s,u_V,r_um\n"));
    let figures = bench.json("figures.json");
    // The error is 0.004 %: the corner at the start of the sine causes 0.6 um for a few samples.
    assert!(number(&figures["rms_pp_percent"]) < 0.01 && number(&figures["clipped"]) == 0.0, "{figures}");
    bench.run(&format!("{MAKE} --driver pl140 -o u.mat")).ok();
    for voltage in ["u.csv", "u.mat"] {
        bench.run(&format!("simulate --plant paper --input {voltage} -o {voltage}.y")).ok();
    }
    assert_eq!(bench.text("u.csv.y"), bench.text("u.mat.y"));
    bench.run(&format!("{MAKE} --smooth 0.01 --zvd --notch --json - -o shaped.csv")).ok();
    assert_ne!(bench.text("u.csv"), bench.text("shaped.csv"));
}

#[test]
fn what_cannot_be_reached_is_refused_or_clipped_on_request() {
    let bench = bench(4000.0);
    bench.refused(&format!("{MAKE} --driver pl140 -o u.csv")).says(&["r.csv", "cannot be reached", "um", "--clip"]);
    bench.run(&format!("{MAKE} --driver pl140 --clip -o u.csv")).ok().says(&["samples are clipped"]);
    bench.misused(&format!("{MAKE} --driver bd300 -o u.csv")).says(&["--capacitance"]);
}

#[test]
fn a_current_beyond_the_driver_is_refused_with_its_sample_or_kept_on_request() {
    let bench = bench(400.0);
    let weak = format!("{MAKE} --driver bd300 --capacitance 8.2e-6 --json f.json -o u.csv");
    bench.refused(&weak).says(&[
        "r.csv: the drive exceeds its limits: current",
        "at sample 200",
        "limit 0.05 A",
        "--clip",
    ]);
    bench.run(&format!("{weak} --clip")).ok().says(&["samples are clipped"]);
    let share = number(&bench.json("f.json")["usage"]["current"]["share"]);
    assert!((0.99..1.0 + 1e-9).contains(&share), "{share}");
}

#[test]
fn references_of_no_use_are_named_with_the_place_and_what_to_do() {
    let bench = bench(400.0);
    let cases: [(&str, &[&str]); 5] = [
        ("t_s,r_um\n0,1\n0.0005,nan\n0.001,2\n", &["r.csv: line 3, column r_um: `nan` is not a finite number"]),
        ("t_s,r_um\n0,1\n0.001,2\n", &["r.csv: the model is sampled every 0.0005 s", "0.001 s: resample"]),
        ("t_s,r_counts\n0,1\n0.0005,2\n", &["r.csv", "counts", "um", "convert"]),
        ("t_s,wanted\n0,1\n0.0005,2\n", &["r.csv: line 1: there is no reference column", "`r_*`", "--output-col"]),
        ("", &["error: r.csv: the file is empty"]),
    ];
    for (text, says) in cases {
        bench.write("r.csv", text);
        bench.refused(&format!("{MAKE} -o u.csv")).says(says);
    }
}

#[test]
fn models_without_an_inverse_are_named_with_the_reason() {
    let bench = bench(400.0);
    let refused = |changes: &[(&str, Value)], says: &[&str]| {
        let mut model = bench.json("model.json");
        changes.iter().for_each(|(key, value)| model[*key] = value.clone());
        bench.write("other.json", model.to_string());
        bench.refused("compensate --model other.json --reference r.csv -o u.csv").says(says);
    };
    let plain = |gain: f64| ("hysteresis", json!({"operator": "proportional", "gain": gain}));
    let block = |a: Value, b: Value| ("linear", json!({"a": a, "b": b}));
    refused(
        &[block(json!([1.1]), json!([1]))],
        &["other.json: the linear block has no bounded inverse", "modulus 1.1"],
    );
    refused(&[block(json!([]), json!([1, -1]))], &["other.json: the linear block", "gain at 0 Hz is 0"]);
    refused(&[plain(0.0)], &["other.json", "no inverse of its hysteresis", "goes from 0 to 0", "must rise"]);
    let mut model = bench.json("model.json");
    [plain(1.0), ("identified", Value::Null)].into_iter().for_each(|(key, value)| model[key] = value);
    bench.write("other.json", model.to_string());
    bench.misused("compensate --model other.json --reference r.csv -o u.csv").says(&["--driver", "must be given"]);
}
