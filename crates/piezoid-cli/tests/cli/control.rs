//! Control schemes side by side on a simulated actuator.

use crate::bench::{Bench, number};
use std::sync::OnceLock;

/// The paper's plant within the limits of a driver, with a model whose hysteresis is monotonic.
const RUN: &str = "control --plant paper --model plays.json --driver pl140";

/// A bench with that model.
fn bench() -> Bench {
    static MODEL: OnceLock<Vec<u8>> = OnceLock::new();
    let bench = Bench::stocked();
    let identify =
        "identify sine5.csv sine20.csv --small-signal prbs.csv --operator prandtl-ishlinskii --no-creep -o plays.json";
    let identified = || {
        bench.run(identify).ok();
        bench.bytes("plays.json")
    };
    let model = MODEL.get_or_init(identified);
    bench.write("plays.json", model);
    bench
}

#[test]
fn schemes_stand_side_by_side_with_their_margins_and_the_inverse_is_nearer_than_a_straight_line() {
    let bench = bench();
    let line =
        format!("{RUN} --reference sine:5 --amplitude 800 --controller gain feed-forward feed-forward+pi predictive");
    let run = bench.run(&format!("{line} --json figures.json --report page.html")).ok();
    let run = run.prints(&[
        "sine 5 Hz",
        "rms [% of p-p of r]",
        "rms change of u per sample [V]",
        "feed-forward+pi",
        "phase margin [deg]",
        "bandwidth [Hz]",
    ]);
    run.says(&["predictive: one step of the controller takes", "the sampling period is 500 us"]);
    let figures = bench.json("figures.json");
    let percent = |k: usize| number(&figures["schemes"][k]["tracking"][0]["percent_of_stroke"]);
    // The model is poor, because it is identified from two steady sines. Each better scheme still reduces the error, the
    // last to a quarter of that of a gain.
    assert!(percent(1) < percent(0) && percent(2) < percent(1) && percent(3) < percent(2), "{figures}");
    assert!(percent(3) < 0.26 * percent(0) && percent(3) < 0.34, "{figures}");
    assert!(number(&figures["schemes"][2]["margins"]["gain_db"]) >= 5.99, "{figures}");
    assert_eq!(figures["schemes"][1]["margins"], serde_json::Value::Null);
    assert!(bench.text("page.html").contains("Comparison of controllers"));
    // The same command gives the same bytes.
    bench.run(&format!("{line} --json again.json --report again.html")).ok();
    assert_eq!(bench.bytes("figures.json"), bench.bytes("again.json"));
    assert_eq!(bench.bytes("page.html"), bench.bytes("again.html"));
}

#[test]
fn the_usual_table_has_ten_references_and_what_cannot_be_learnt_is_told() {
    let run = bench().run(&format!("{RUN} --amplitude 200")).ok();
    let run = run.prints(&[
        "sine 1 Hz",
        "triangle 40 Hz",
        "staircase 1 Hz",
        "random 20 Hz",
        "learning",
        "feed-forward+integral-notch",
    ]);
    run.says(&["learning, random 20 Hz", "learning needs a periodic one"]);
}

#[test]
fn a_run_goes_into_a_record_that_can_be_read_again() {
    let bench = bench();
    let line = format!(
        "{RUN} --reference triangle:10 --amplitude 200 --controller pid --delay-samples 2 --preview 0 --noise 0.1"
    );
    bench.run(&format!("{line} -o run.csv")).ok();
    assert!(bench.text("run.csv").starts_with("t_s,u_V,y_um,r_um\n"));
    bench.run("control --plant paper --model plays.json --controller pi --reference run.csv -o again.npz").ok();
    bench.run("validate run.csv again.npz --model model.json").ok();
}

#[test]
fn draws_of_tolerance_are_counted_and_a_seed_decides_them() {
    let bench = bench();
    let line = format!("{RUN} --reference sine:5 --amplitude 200 --controller pi --tolerance 20 --draws 5");
    bench.run(&format!("{line} --json one.json")).ok().prints(&["random plants", "median", "worst", "0 of 5"]);
    bench.run(&format!("{line} --seed 2 --json other.json")).ok();
    let drawn = |name| bench.json(name)["schemes"][0]["tolerance"]["percent_of_stroke"].clone();
    assert_eq!(drawn("one.json").as_array().map(Vec::len), Some(5));
    assert_ne!(drawn("one.json"), drawn("other.json"));
}

#[test]
fn controllers_are_tuned_for_readings_that_come_late() {
    let bench = bench();
    let figures = |delay_samples: usize| {
        let line = format!("{RUN} --reference sine:5 --amplitude 200 --controller pi --delay-samples {delay_samples}");
        bench.run(&format!("{line} --json figures.json")).ok();
        let margins = bench.json("figures.json")["schemes"][0]["margins"].clone();
        assert!(number(&margins["gain_db"]) >= 5.99 && number(&margins["phase_deg"]) >= 44.9, "{margins}");
        margins
    };
    assert_ne!(figures(0), figures(8));
}

#[test]
fn what_makes_no_sense_is_named() {
    let bench = bench();
    bench.misused(&format!("{RUN} --controller pj")).says(&["pj", "did you mean `pi`?"]);
    bench.misused(&format!("{RUN} --controller pi+pid")).says(&["pi+pid", "feed-forward+pi"]);
    bench.misused(&format!("{RUN} --reference sine:0")).says(&["sine:0", "positive number of hertz"]);
    bench.misused(&format!("{RUN} --reference sine:1e-9")).says(&["sine:1e-9", "Hz or more"]);
    bench.misused(&format!("{RUN} --reference sin:5")).says(&["no such file", "did you mean `sine`?"]);
    bench.misused(&format!("{RUN} --reference sine:5 triangle:5 -o run.csv")).says(&["-o holds one run"]);
    bench.run(&format!("{RUN} --gain-margin 0")).exits(2).says(&["0", "positive"]);
    bench.run(&format!("{RUN} --delay-samples 21")).exits(2).says(&["21", "from 0 to 20"]);
    bench.run(&format!("{RUN} --tolerance 100")).exits(2).says(&["100", "below 100"]);
    bench
        .refused(&format!("{RUN} --controller pi --phase-margin 200"))
        .says(&["no controller is possible", "no gain meets the margins"]);
    // One that is refused does not cost the others.
    let line = format!("{RUN} --reference sine:5 --amplitude 200 --controller gain pi --phase-margin 200");
    bench.run(&line).ok().says(&["pi is left out", "no gain meets the margins"]);
    bench.refused(&format!("{RUN} --reference sine:5 --amplitude 5000")).says(&["cannot be reached", "um", "--clip"]);
    bench.run(&format!("{RUN} --reference sine:5 --amplitude 5000 --clip --controller pi")).ok().says(&["at a limit"]);
    bench.write("r.csv", "t_s,r_um\n0,1\n0.0005,nan\n");
    bench.refused(&format!("{RUN} --reference r.csv")).says(&["r.csv", "line 3", "nan"]);
    bench.write("r.csv", "t_s,r_counts\n0,1\n0.0005,2\n");
    bench.refused(&format!("{RUN} --reference r.csv")).says(&["counts", "um", "convert"]);
}

#[test]
fn a_scheme_that_a_model_does_not_give_is_left_out_of_the_usual_ones_and_refused_by_name() {
    let bench = Bench::stocked(); // by the paper's method: its branches are not monotonic
    let line = "control --plant paper --model model.json --driver pl140 --reference sine:5 --amplitude 200";
    bench.run(line).ok().says(&["predictive is left out", "is not monotonic"]);
    bench.refused(&format!("{line} --controller predictive")).says(&["model.json", "predictive", "is not monotonic"]);
}

#[test]
fn controllers_are_listed_feed_forwards_first() {
    let run = Bench::new().run("controllers").ok();
    run.prints(&["gain", "feed-forward", "learning", "integral-notch", "disturbance-observer", "predictive"]);
}
