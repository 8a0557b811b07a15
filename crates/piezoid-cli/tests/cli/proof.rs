//! Validation: the figures of the JSON result, and their meaning.

use crate::bench::{Bench, number};

const FIGURES: [&str; 7] = ["n", "mse", "rmse", "nrmse_percent", "rms_pp_percent", "max_abs", "fit_percent"];

#[test]
fn validate_gives_the_figures_of_the_contract_in_the_order_of_the_files() {
    let bench = Bench::stocked();
    let run = bench.run("validate --model model.json --data sine20.csv sine5.csv --data prbs.csv --json v.json").ok();
    run.prints(&["rmse [um]", "nrmse %", "sine20.csv", "sine5.csv", "prbs.csv", "total"]);
    let json = bench.json("v.json");
    let files = json["files"].as_array().unwrap();
    let names: Vec<&str> = files.iter().map(|f| f["file"].as_str().unwrap()).collect();
    assert_eq!(names, ["sine20.csv", "sine5.csv", "prbs.csv"]);
    for figures in files.iter().chain([&json["total"]]) {
        for key in FIGURES {
            assert!(number(&figures[key]).is_finite(), "{key} of {figures}");
        }
        assert!((number(&figures["rmse"]).powi(2) / number(&figures["mse"]) - 1.0).abs() < 1e-12);
        assert!((number(&figures["fit_percent"]) + number(&figures["nrmse_percent"]) - 100.0).abs() < 1e-9);
    }
    let n: Vec<f64> = files.iter().map(|f| number(&f["n"])).collect();
    assert_eq!((n.clone(), number(&json["total"]["n"])), (vec![2000.0, 2000.0, 4095.0], 8095.0));

    let alone = bench.run("validate --model model.json --data sine5.csv --json -").ok();
    assert_eq!(alone.out_json()["files"][0], files[1]);
    assert_eq!(alone.err, "");
}

#[test]
fn a_model_validated_against_its_own_simulation_is_perfect() {
    let bench = Bench::stocked();
    bench.run("simulate --model model.json --input drive5.csv --settled -o own.csv").ok();
    let file = bench.run("validate --model model.json --data own.csv --json -").ok().out_json()["files"][0].take();
    assert!(number(&file["mse"]) < 1e-18 && number(&file["fit_percent"]) > 99.999_999, "{file}");
}

#[test]
fn a_total_over_perfect_records_is_perfect() {
    let bench = Bench::stocked();
    bench.run("simulate --model model.json --input drive5.csv --settled -o own.csv").ok();
    let total = bench.run("validate --model model.json --data own.csv --json -").ok().out_json()["total"].take();
    assert_eq!((number(&total["nrmse_percent"]), number(&total["fit_percent"])), (0.0, 100.0), "{total}");
}

#[test]
fn simulate_reproduces_the_figures_of_validate() {
    let bench = Bench::stocked();
    let result = bench.run("validate --model model.json --data sine20.csv --json -").ok().out_json();
    let (total, begin) = (&result["total"], result["files"][0]["initial_condition"].as_str().unwrap());
    bench.run(&format!("simulate --model model.json --input sine20.csv --begin {begin} -o run.csv")).ok();
    let column = |name: &str| -> Vec<f64> {
        bench.text(name).lines().skip(1).map(|row| row.rsplit_once(',').unwrap().1.parse().unwrap()).collect()
    };
    let (y, run) = (column("sine20.csv"), column("run.csv"));
    let mse = y.iter().zip(&run).map(|(y, s)| (y - s).powi(2)).sum::<f64>() / y.len() as f64;
    assert!((number(&total["mse"]) / mse - 1.0).abs() < 1e-12, "{total} {mse}");
}

#[test]
fn a_free_offset_takes_the_mean_error_away() {
    let bench = Bench::stocked();
    let rows = bench.text("sine5.csv");
    let drifted = rows.lines().skip(1).map(|row| {
        let (head, y) = row.rsplit_once(',').unwrap();
        format!("{head},{}\n", y.parse::<f64>().unwrap() + 500.0)
    });
    bench.write("drifted.csv", format!("t_s,u_V,y_um\n{}", drifted.collect::<String>()));
    let rmse = |name: &str, offset: &str| {
        let line = format!("validate --model model.json --data {name} --offset {offset} --json -");
        number(&bench.run(&line).ok().out_json()["total"]["rmse"])
    };
    assert!(rmse("drifted.csv", "kept") > 450.0);
    assert!((rmse("drifted.csv", "free") / rmse("sine5.csv", "free") - 1.0).abs() < 1e-9);
    assert!(rmse("sine5.csv", "free") <= rmse("sine5.csv", "kept"));
}

#[test]
fn the_error_is_told_by_frequency_by_amplitude_by_loop_and_beside_the_floor() {
    let bench = Bench::stocked();
    bench.run("excite rising-sine --ts 5e-4 --duration 2 --amplitude 28 --frequency 5 -o drive.csv").ok();
    bench.run("simulate --plant pl140 --input drive.csv -o rising.csv").ok();
    bench.run("simulate --plant pl140 --input drive5.csv -o noisy.csv").ok();
    let line = "validate --model model.json --data sine5.csv sine20.csv rising.csv noisy.csv";
    let run = bench.run(&format!("{line} --json v.json")).ok();
    run.prints(&["f [Hz]", "amplitude [V]", "width %", "floor [um]", "correlated with u", "the resonance at 146.7 Hz"]);
    let json = bench.json("v.json");
    let hz: Vec<f64> = json["total"]["by_frequency"].as_array().unwrap().iter().map(|b| number(&b["at"])).collect();
    assert!(hz.len() == 2 && (hz[0] - 5.0).abs() < 0.1 && (hz[1] - 20.0).abs() < 0.1, "{hz:?}");
    assert!(json["total"]["by_amplitude"].as_array().unwrap().len() >= 4);
    let loops = &json["files"][0]["loops"][0];
    let [measured, model] = ["measured", "model"].map(|who| number(&loops[who]["width_percent"]));
    assert!((12.0..14.0).contains(&measured) && (measured - model).abs() < 0.5, "{loops}");
    assert_eq!(number(&loops["measured"]["reversals"]), 2.0);
    // The sensor noise of the twin is 0.2 um.
    let floor = &json["files"][3]["floor"];
    assert!((number(&floor["rms"]) - 0.2).abs() < 0.02 && number(&floor["error_over_floor"]) > 10.0, "{floor}");
    assert!(json["files"][2]["floor"].is_null(), "a rising sine does not repeat");
    let verdict = json["files"][3]["whiteness"]["verdict"].to_string();
    assert!(verdict.contains("not white"), "{verdict}");

    let brief = bench.run(line).ok().out.lines().count();
    let full = bench.run(&format!("{line} --full")).ok();
    assert!(full.out.lines().count() > brief + 10);
    full.prints(&["closure %", "slope after reversal", "noisy.csv: residuals are not white"]);
}

#[test]
fn a_record_beyond_what_the_model_was_identified_on_is_told_so() {
    let bench = Bench::stocked();
    let domain = &bench.json("model.json")["identified"];
    assert_eq!((number(&domain["u"][0]), number(&domain["u"][1])), (-30.0, 30.0));
    bench.run("excite sine --ts 5e-4 --duration 1 --amplitude 10 --frequency 20 --offset 18 -o drive.csv").ok();
    bench.run("simulate --plant paper --input drive.csv -o biased.csv").ok();
    bench.run("validate --model model.json --data biased.csv").ok().says(&["has a mean of 18.00 V", "another bias"]);
    bench.run("excite stepped-sine --ts 5e-4 --duration 1 --amplitude 28 --frequency 20 -o drive.csv").ok();
    bench.run("simulate --plant paper --input drive.csv -o steps.csv").ok();
    bench.run("validate --model model.json --data steps.csv").ok().says(&["changes by up to", "V/s"]);
}

#[test]
fn a_large_multisine_is_told_to_be_no_small_signal() {
    let bench = Bench::stocked();
    bench
        .run(
            "excite multisine --ts 5e-4 --duration 2 --amplitude 28 --frequency-low 1 --frequency-high 60 -o drive.csv",
        )
        .ok();
    bench.run("simulate --plant paper --input drive.csv -o large.csv").ok();
    let found = bench
        .run("identify --method paper --small-signal large.csv --large-signal sine5.csv -o m.json --json f.json")
        .ok();
    found.says(&["large.csv: the record is not linear", "% of the output's rms"]);
    assert_eq!(bench.json("f.json")["linearity"][0]["is_linear"], false);
    let sound = bench
        .run("identify --method paper --small-signal prbs.csv --large-signal sine5.csv -o m.json --json f.json")
        .ok();
    assert!(!sound.err.contains("is not linear"), "{}", sound.err);
    assert_eq!(bench.json("f.json")["linearity"][0]["is_linear"], true);
}
