//! Validation: the figures of the contract, and what they mean.

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
    bench.run("simulate --model model.json --input sine20.csv --settled -o run.csv").ok();
    let column = |name: &str| -> Vec<f64> {
        bench.text(name).lines().skip(1).map(|row| row.rsplit_once(',').unwrap().1.parse().unwrap()).collect()
    };
    let (y, run) = (column("sine20.csv"), column("run.csv"));
    let mse = y.iter().zip(&run).map(|(y, s)| (y - s).powi(2)).sum::<f64>() / y.len() as f64;
    let total = bench.run("validate --model model.json --data sine20.csv --json -").ok().out_json()["total"].take();
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
