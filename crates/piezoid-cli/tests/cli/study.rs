//! The paper's experiment from end to end.

use crate::bench::{Bench, Run, number};
use crate::workflow::assert_self_contained;
use std::collections::BTreeSet;
use std::sync::LazyLock;

/// A study of the paper's plant: its directory and the result of the command.
fn of_the_papers_plant() -> (Bench, Run) {
    let bench = Bench::new();
    let run = bench.run("study --plant paper --out a/b --json study.json").ok();
    (bench, run)
}

/// One study for all tests.
static PAPER: LazyLock<(Bench, Run)> = LazyLock::new(of_the_papers_plant);

#[test]
fn the_study_of_the_papers_plant_shows_what_the_paper_shows() {
    let (bench, Run { out, err, .. }) = &*PAPER;
    assert_eq!(err, "");
    for part in ["PLANT paper", "Table 1", "on the stepped sine", "Table 2", "Report: "] {
        assert!(out.contains(part), "`{part}` is missing: {out}");
    }
    assert!(out.contains("\n5     ") && out.contains("of 7 steps"), "{out}");
    assert!(out.lines().all(|line| line.chars().count() <= 80), "{out}");

    let json = bench.json("study.json");
    let of = |hz: f64, method: &str| {
        let mut rows = json["table1"].as_array().unwrap().iter();
        rows.find(|r| number(&r["frequency_hz"]) == hz && r["method"] == method)
            .unwrap_or_else(|| panic!("{hz} {method}"))
    };
    for (hz, table_1) in [(5.0, 0.0129), (20.0, 0.0155), (40.0, 0.0180), (80.0, 0.0322)] {
        let printed = number(&of(hz, "printed-rule")["mse"]);
        assert!((printed / table_1 - 1.0).abs() <= 0.2, "{printed} beside {table_1}");
        assert!(number(&of(hz, "held-direction")["mse"]) <= 5e-5);
    }
    for hz in [5.0, 20.0, 40.0, 80.0, 120.0, 160.0, 200.0, 250.0] {
        for method in ["printed-rule", "held-direction", "linear", "table2-arx", "joint"] {
            for key in ["mse", "nrmse_percent", "rms_pp_percent", "loop_width_percent"] {
                assert!(number(&of(hz, method)[key]).is_finite(), "{hz} {method} {key}");
            }
        }
        let held = of(hz, "held-direction");
        assert!(hz > 80.0 || number(&held["mse"]) <= 1e-3, "{held}");
        assert!(number(&held["rms_pp_percent"]) <= 2.0, "{held}");
    }
    let swarm = json["table2"].as_array().unwrap().iter().find(|row| row["estimator"] == "swarm").unwrap();
    let pole = &swarm["poles"][0];
    assert!((number(&pole["hz"]) - 146.7).abs() <= 1.0 && (number(&pole["damping"]) - 0.061).abs() <= 0.005, "{pole}");
    assert!(swarm["zeros"].as_array().is_some_and(|zeros| zeros.len() == 2));
    let costs: Vec<f64> = json["convergence"].as_array().unwrap().iter().map(number).collect();
    assert!(costs.len() > 100 && costs.is_sorted_by(|a, b| a >= b));
}

#[test]
fn the_pages_and_figures_are_whole_for_both_plants() {
    let bench = Bench::new();
    let run = bench.run("study --json study.json").ok().prints(&["PLANT paper", "PLANT pl140"]);
    assert!(
        run.out.contains("unstable") && run.out.contains("of its zeros"),
        "the unstable inverse is named with its zeros"
    );
    assert!(!run.out.contains("NaN"), "{}", run.out);
    assert!(run.out.lines().all(|line| line.chars().count() <= 80), "{}", run.out);
    let plants: BTreeSet<String> = bench.json("study.json")["table1"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["plant"].as_str().unwrap().to_string())
        .collect();
    assert_eq!(plants, BTreeSet::from(["paper".to_string(), "pl140".to_string()]));

    assert_self_contained(&bench.text("study/report.html"));
    let mut figures = 0;
    for (name, bytes) in bench.files().iter().filter(|(name, _)| name.ends_with(".svg")) {
        let text = std::str::from_utf8(bytes).unwrap();
        let svg = roxmltree::Document::parse(text).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(svg.root_element().tag_name().name(), "svg", "{name}");
        assert!(!text.contains("NaN"), "{name}");
        assert_eq!(text.matches("http").count(), text.matches("xmlns").count(), "{name} names an address");
        figures += 1;
    }
    assert!(figures >= 2 * 20, "{figures}");
}

#[test]
fn two_studies_give_the_same_bytes() {
    let [once, again] = [&*PAPER, &of_the_papers_plant()].map(|(bench, run)| (run.out.clone(), bench.files()));
    assert!(once == again);
}

#[test]
fn json_on_stdout_stands_there_alone_and_another_seed_gives_another_study() {
    let other = Bench::new();
    let json = other.run("study --plant paper --seed 2 --json -").ok().out_json();
    assert!(json["table1"].is_array() && json["table2"].is_array());
    assert_ne!(json, PAPER.0.json("study.json"));
}

#[test]
fn a_folder_that_cannot_be_made_is_refused() {
    let bench = Bench::new();
    bench.write("file", "");
    bench.refused("study --plant paper --out file").says(&["file", "not a folder", "--out"]);
    bench.refused("study --plant paper --out file/deeper").says(&["cannot create the folder file/deeper", "--out"]);
}
