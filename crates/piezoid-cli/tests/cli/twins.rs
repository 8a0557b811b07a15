//! Models of the simulated actuators that are not benders.

use crate::bench::{Bench, number};

/// Identifies `plant` about the voltage `middle` from a PRBS and two rising sines of `seconds` each, and validates the
/// model on a sine at another frequency: the error [% of peak-to-peak] and the poles, as kind and frequency [Hz].
fn identified(plant: &str, ts: &str, seconds: f64, middle: f64, large: f64, small: f64) -> (f64, Vec<(String, f64)>) {
    let bench = Bench::new();
    for (name, kind, amplitude) in [
        ("small", "prbs", small),
        ("slow", "rising-sine --frequency 10", large),
        ("fast", "rising-sine --frequency 40", large),
        ("other", "sine --frequency 25", 0.8 * large),
    ] {
        let drive = format!("--ts {ts} --duration {seconds} --amplitude {amplitude} --offset {middle}");
        bench.run(&format!("excite {kind} {drive} -o u.csv")).ok();
        bench.run(&format!("simulate --plant {plant} --input u.csv --begin settled -o {name}.csv")).ok();
    }
    let records = "slow.csv fast.csv --small-signal small.csv";
    bench.run(&format!("identify {records} --operator prandtl-ishlinskii -o m.json --json found.json")).ok();
    let left = bench.run("validate other.csv --model m.json --json -").ok().out_json();
    let poles = bench.json("found.json")["linear"]["modal_form"]["poles"].clone();
    let pole = |p: &serde_json::Value| (p["kind"].as_str().unwrap().to_string(), number(&p["hz"]));
    (number(&left["total"]["rms_pp_percent"]), poles.as_array().unwrap().iter().map(pole).collect())
}

fn has(poles: &[(String, f64)], kind: &str, hz: f64, tolerance: f64) -> bool {
    poles.iter().any(|pole| pole.0 == kind && (pole.1 / hz - 1.0).abs() < tolerance)
}

#[test]
fn a_unipolar_stack_is_identified_with_its_resonance() {
    let (error, poles) = identified("p885", "2e-4", 0.6, 60.0, 55.0, 1.0);
    assert!(error < 1.5 && has(&poles, "mode", 1125.0, 2e-3), "{error} %, {poles:?}");
}

#[test]
fn a_stage_is_identified_with_both_modes_and_the_bandwidth_of_its_strain_gauge() {
    let (error, poles) = identified("p611", "2e-4", 0.6, 50.0, 65.0, 1.0);
    assert!(
        error < 1.0 && has(&poles, "mode", 286.6, 2e-3) && has(&poles, "mode", 900.0, 2e-3),
        "{error} %, {poles:?}"
    );
    assert!(has(&poles, "lag", 1000.0, 0.05), "{poles:?}");
}

#[test]
fn a_tube_scanner_is_identified_with_its_resonance() {
    let (error, poles) = identified("tb3507", "1e-4", 0.3, 0.0, 240.0, 5.0);
    assert!(error < 1.0 && has(&poles, "mode", 2905.0, 2e-3), "{error} %, {poles:?}");
}
