//! The joint method, from the command line.

use crate::bench::{Bench, number};

/// A bench with records of the paper's actuator: a PRBS and rising sines for training, and a staircase for validation.
fn stocked() -> Bench {
    let bench = Bench::stocked();
    for (name, kind) in [
        ("rise5", "rising-sine --duration 2 --amplitude 28 --frequency 5"),
        ("rise40", "rising-sine --duration 1 --amplitude 20 --frequency 40"),
        ("stairs", "staircase --duration 1 --amplitude 25 --frequency 10"),
    ] {
        bench.run(&format!("excite {kind} --ts 5e-4 -o drive.csv")).ok();
        bench.run(&format!("simulate --plant paper --input drive.csv -o {name}.csv")).ok();
    }
    bench
}

#[test]
fn a_joint_model_foretells_what_it_has_not_seen_and_the_tables_say_why_it_is_this_one() {
    let bench = stocked();
    let line =
        "identify rise5.csv rise40.csv --small-signal prbs.csv --operator bouc-wen --verbose -o m.json --json f.json";
    let run = bench.run(line).ok();
    let run = run.prints(&[
        "held-out error",
        "bouc-wen",
        "taken",
        "mode 1 frequency",
        "standard error",
        "rise5.csv",
        "by",
        "lag-1 corr.",
    ]);
    let found = bench.json("f.json");
    assert!(number(&found["trials"][0]["held_out_percent"]) < 0.01, "{}", found["trials"]);
    let parameter = |name: &str| {
        let all = found["parameters"].as_array().unwrap();
        all.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("{name}: {all:?}"))["value"].as_f64().unwrap()
    };
    assert!((parameter("mode 1 frequency [Hz]") / 146.7 - 1.0).abs() < 1e-3);
    assert!((parameter("beta") / 0.02 - 1.0).abs() < 1e-2);
    let run = run.prints(&["mode 1 ", "share %", "feed-through", "ms in addition to the zero-order hold"]);
    assert!(run.out.lines().all(|line| line.chars().count() <= 80), "{}", run.out);
    let form = &found["linear"]["modal_form"];
    let mode = &form["poles"][0];
    let stiffness_over_mass = number(&mode["mass_per_stiffness"]).recip();
    assert!((stiffness_over_mass.sqrt() / std::f64::consts::TAU / number(&mode["hz"]) - 1.0).abs() < 1e-12);
    assert_eq!(mode["kind"], "mode");
    let shares = form["poles"].as_array().unwrap().iter().map(|p| number(&p["share_percent"])).sum::<f64>();
    assert!((shares + number(&form["feed_through_percent"]) - 100.0).abs() < 1e-9, "{form}");
    assert!(number(&form["gain"]).is_finite() && number(&form["delay_s"]).abs() < 2e-3, "{form}");
    bench.run("report stairs.csv --model m.json -o m.html").ok();
    let page = bench.text("m.html");
    for text in ["Operators tried", "mode 1 frequency [Hz]", "Loops of the hysteresis block", "Frequency response"] {
        assert!(page.contains(text), "{text}");
    }
    let left = bench.run("validate stairs.csv --model m.json --json -").ok().out_json();
    assert!(number(&left["total"]["rms_pp_percent"]) < 0.02, "{}", left["total"]["rms_pp_percent"]);
}

#[test]
fn auto_takes_the_law_the_actuator_has() {
    let bench = stocked();
    let line = "identify rise5.csv rise40.csv --small-signal prbs.csv --verbose -o m.json --json f.json";
    let run = bench.run(line).ok().prints(&["preisach", "tellinen", "duhem"]);
    let found = bench.json("f.json");
    assert_eq!(found["operator"], "bouc-wen", "{}", run.out);
}

#[test]
fn records_of_one_amplitude_cannot_tell_minor_loops_and_the_note_says_so() {
    let bench = stocked();
    let line = "identify sine5.csv sine20.csv --elements 6 -o m.json --json f.json";
    bench.run(line).ok().says(&["never turn back inside the range", "add a rising sine"]);
    let found = bench.json("f.json");
    let tried: Vec<&str> = found["trials"].as_array().unwrap().iter().filter_map(|t| t["operator"].as_str()).collect();
    assert!(tried.contains(&"prandtl-ishlinskii"), "{tried:?}");
    assert!(!tried.contains(&"preisach") && !tried.contains(&"bouc-wen"), "{tried:?}");
}

#[test]
fn settings_of_the_other_method_are_refused_and_a_driver_may_be_named() {
    let bench = stocked();
    for (line, says) in [
        ("identify sine5.csv --bins 9 -o m.json", "--bins 9: is an option of the method paper"),
        (
            "identify sine5.csv --global-best current -o m.json",
            "--global-best current: is an option of the method paper",
        ),
        ("identify sine5.csv --method paper --no-creep -o m.json", "--no-creep: is an option of the method joint"),
        ("identify sine5.csv --driver bd300 -o m.json", "--capacitance"),
        ("identify sine5.csv --driver bd30 -o m.json", "did you mean `bd300`?"),
    ] {
        bench.misused(line).says(&[says]);
    }
    bench.run("simulate --plant pl140 --input rise5.csv -o crept.csv").ok();
    let line = "identify crept.csv --operator stop --driver pl140 --driver-lag 1e-4 --verbose -o m.json";
    bench.run(line).ok().prints(&["Driver: a lag of 0.1 ms, at most 60976 V/s", "Creep: ", " % (0.05 s)"]);
    let model = bench.json("m.json");
    assert!(
        (number(&model["driver"]["slew"]) * 8.2e-6 - 0.5).abs() < 1e-9 && number(&model["driver"]["lag_s"]) == 1e-4
    );
    bench.run("validate rise5.csv --model m.json").ok();
}

#[test]
fn the_same_command_gives_the_same_bytes() {
    let bench = stocked();
    let line = "identify rise5.csv rise40.csv --operator generalised-prandtl-ishlinskii -o m.json --json f.json";
    bench.run(line).ok();
    let first = (bench.text("m.json"), bench.text("f.json"));
    bench.run(line).ok();
    assert!(first == (bench.text("m.json"), bench.text("f.json")));
}
