//! Validation: the figures of the JSON result, and their meaning.

use crate::bench::{Bench, number};

const FIGURES: [&str; 7] = ["n", "mse", "rmse", "nrmse_percent", "rms_pp_percent", "max_abs", "fit_percent"];

#[test]
fn validate_gives_the_figures_of_the_contract_in_the_order_of_the_files() {
    let bench = Bench::stocked();
    let run = bench.run("validate sine20.csv sine5.csv prbs.csv --model model.json --json v.json").ok();
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

    let alone = bench.run("validate sine5.csv --model model.json --json -").ok();
    assert_eq!(alone.out_json()["files"][0], files[1]);
    assert_eq!(alone.err, "");
}

#[test]
fn a_model_validated_against_its_own_simulation_is_perfect() {
    let bench = Bench::stocked();
    bench.run("simulate --model model.json --input drive5.csv --settled -o own.csv").ok();
    let file = bench.run("validate own.csv --model model.json --json -").ok().out_json()["files"][0].take();
    assert!(number(&file["mse"]) < 1e-18 && number(&file["fit_percent"]) > 99.999_999, "{file}");
}

#[test]
fn a_total_over_perfect_records_is_perfect() {
    let bench = Bench::stocked();
    bench.run("simulate --model model.json --input drive5.csv --settled -o own.csv").ok();
    let total = bench.run("validate own.csv --model model.json --json -").ok().out_json()["total"].take();
    assert_eq!((number(&total["nrmse_percent"]), number(&total["fit_percent"])), (0.0, 100.0), "{total}");
}

#[test]
fn simulate_reproduces_the_figures_of_validate() {
    let bench = Bench::stocked();
    let result = bench.run("validate sine20.csv --model model.json --json -").ok().out_json();
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
        let line = format!("validate {name} --model model.json --offset {offset} --json -");
        number(&bench.run(&line).ok().out_json()["total"]["rmse"])
    };
    assert!(rmse("drifted.csv", "kept") > 450.0);
    assert!((rmse("drifted.csv", "free") / rmse("sine5.csv", "free") - 1.0).abs() < 1e-9);
    assert!(rmse("sine5.csv", "free") <= rmse("sine5.csv", "kept"));
}

#[test]
fn what_noise_and_drift_make_of_an_error_is_told_and_drift_is_taken_away_if_asked() {
    let bench = Bench::stocked();
    bench.run("excite rising-sine --ts 5e-4 --duration 4 --amplitude 28 --frequency 5 -o drive.csv").ok();
    bench.run("simulate --model model.json --input drive.csv -o clean.csv").ok();
    let text = bench.text("clean.csv");
    // A drift of 4 um/s, and noise of 0.5 um rms by a congruential generator.
    let mut state = 1_u64;
    let rows = text.lines().skip(1).enumerate().map(|(t, row)| {
        let (head, y) = row.rsplit_once(',').unwrap();
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let noise = 3f64.sqrt() * ((state >> 33) as f64 / 2f64.powi(30) - 1.0);
        format!("{head},{}\n", y.parse::<f64>().unwrap() + 4.0 * (t as f64 * 5e-4 - 2.0) + 0.5 * noise)
    });
    bench.write("drifted.csv", format!("t_s,u_V,y_um\n{}", rows.collect::<String>()));
    let line = "validate drifted.csv --verbose --model model.json";
    let observed = bench.run(&format!("{line} --json v.json")).ok();
    observed
        .prints(&["noise %", "% NRMSE, of which drift", "and noise"])
        .says(&["a drift of 4 um/s makes", "Set the offset to drift to see the rest"]);
    let file = &bench.json("v.json")["files"][0];
    assert!((number(&file["drift_per_s"]) - 4.0).abs() < 0.05, "{file}");
    assert!((number(&file["floor"]["rms"]) - 0.5).abs() < 0.1, "{}", file["floor"]);
    assert!(number(&file["floor"]["reducible_nrmse_percent"]) < 0.1 * number(&file["nrmse_percent"]), "{file}");
    bench.run(&format!("{line} --offset drift --json v.json")).ok().prints(&["no model could be clearly better"]);
    let json = bench.json("v.json");
    let rest = number(&json["total"]["nrmse_percent"]);
    assert!((rest / number(&file["nrmse_without_drift_percent"]) - 1.0).abs() < 0.01, "{json}");
    assert_eq!(json["total"]["summary"], json["files"][0]["summary"]);
    assert!((number(&json["total"]["floor"]["nrmse_percent"]) / rest - 1.0).abs() < 0.1, "{json}");
}

#[test]
fn the_error_is_told_by_frequency_by_amplitude_by_loop_and_beside_the_floor() {
    let bench = Bench::stocked();
    bench.run("excite rising-sine --ts 5e-4 --duration 2 --amplitude 28 --frequency 5 -o drive.csv").ok();
    bench.run("simulate --plant pl140 --input drive.csv -o rising.csv").ok();
    bench.run("simulate --plant pl140 --input drive5.csv -o noisy.csv").ok();
    let line = "validate sine5.csv sine20.csv rising.csv noisy.csv --model model.json";
    let run = bench.run(&format!("{line} --verbose --json v.json")).ok();
    run.prints(&["f [Hz]", "amplitude [V]", "width %", "floor [um]", "corr. with u", "the resonance at 146.7 Hz"]);
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
    assert_eq!(floor["source"], "periods");
    let floor = &json["files"][2]["floor"];
    assert!((number(&floor["rms"]) - 0.2).abs() < 0.02 && floor["source"] == "spectrum", "a rising sine: {floor}");
    let verdict = json["files"][3]["whiteness"]["verdict"].to_string();
    assert!(verdict.contains("regular, not noise"), "{verdict}");

    let brief = bench.run(line).ok().out.lines().count();
    let full = bench.run(&format!("{line} --full")).ok();
    assert!(full.out.lines().count() > brief + 10);
    full.prints(&["closure %", "slope after reversal", "noisy.csv: a part of the residuals is regular"]);
}

#[test]
fn a_record_beyond_what_the_model_was_identified_on_is_told_so() {
    let bench = Bench::stocked();
    let domain = &bench.json("model.json")["identified"];
    assert_eq!((number(&domain["u"][0]), number(&domain["u"][1])), (-30.0, 30.0));
    bench.run("excite sine --ts 5e-4 --duration 1 --amplitude 10 --frequency 20 --offset 18 -o drive.csv").ok();
    bench.run("simulate --plant paper --input drive.csv -o biased.csv").ok();
    bench.run("validate biased.csv --model model.json").ok().says(&["has a mean of 18.00 V", "another bias"]);
    bench.run("excite stepped-sine --ts 5e-4 --duration 1 --amplitude 28 --frequency 20 -o drive.csv").ok();
    bench.run("simulate --plant paper --input drive.csv -o steps.csv").ok();
    bench.run("validate steps.csv --model model.json").ok().says(&["changes by up to", "V/s"]);
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
    let found = bench.run("identify sine5.csv --method paper --small-signal large.csv -o m.json --json f.json").ok();
    found.says(&["large.csv: the record is not linear", "% of the output's rms"]);
    assert_eq!(bench.json("f.json")["linearity"][0]["is_linear"], false);
    let sound = bench.run("identify sine5.csv --method paper --small-signal prbs.csv -o m.json --json f.json").ok();
    assert!(!sound.err.contains("is not linear"), "{}", sound.err);
    assert_eq!(bench.json("f.json")["linearity"][0]["is_linear"], true);
}
