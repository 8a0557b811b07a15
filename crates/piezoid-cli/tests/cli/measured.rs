//! The paper's method on measured data: a PICMA P-885.91 stack at 1 Hz.

use crate::bench::{Bench, Run, number};
use crate::workflow::assert_self_contained;
use piezoid_testing::skipped;
use std::path::{Path, PathBuf};

/// The folder of the record: from `PIEZOID_DATA`, or beside the workspace.
fn data() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let input = std::env::var_os("PIEZOID_DATA").map(PathBuf::from);
    let found =
        [input, Some(beside)].into_iter().flatten().map(|folder| folder.join("picma-p885")).find(|f| f.is_dir());
    if found.is_none() {
        skipped("no measured data: set PIEZOID_DATA to the folder that holds picma-p885");
    }
    found
}

fn run(bench: &Bench, line: &str, folder: &Path) -> Run {
    let words = line.split_whitespace().map(|word| match word.ends_with("Hz.csv") {
        true => folder.join(word).into_os_string(),
        false => word.into(),
    });
    Run::of(line, &bench.command("").args(words).output().unwrap())
}

#[test]
fn the_papers_method_holds_on_the_second_half_of_a_measured_record() {
    let Some(folder) = data() else { return };
    let bench = Bench::new();
    let found =
        run(&bench, "identify model_1Hz.csv --method paper --from 1.5 --to 20 --verbose -o m.json", &folder).ok();
    found.says(&["pure gain", "one frequency (1", "Hz)"]).prints(&["two-branch", "cmdV"]);
    let total = run(&bench, "validate model_1Hz.csv --model m.json --from 20 --json -", &folder).ok().out_json();
    let nrmse = number(&total["total"]["nrmse_percent"]);
    assert!(nrmse <= 4.0, "{nrmse}");
    run(&bench, "report model_1Hz.csv --model m.json --from 20 -o report.html", &folder).ok();
    assert_self_contained(&bench.text("report.html"));
}

#[test]
fn growing_amplitudes_are_told_to_be_beyond_the_method_and_why() {
    let Some(folder) = data() else { return };
    let bench = Bench::new();
    run(&bench, "identify model_1Hz.csv --method paper --from 1.5 --to 20 --verbose -o m.json", &folder).ok();
    let proof = run(&bench, "validate test_am_1Hz.csv --model m.json --from 1.5 --offset free --json v.json", &folder);
    proof.ok().says(&["note:", "two-branch block has no minor loops"]);
    let json = bench.json("v.json");
    assert!(number(&json["total"]["nrmse_percent"]) > 10.0, "{json}");
    assert!(json["files"][0]["remarks"][0].as_str().unwrap().contains("no minor loops"));
    run(&bench, "report test_am_1Hz.csv --model m.json -o report.html", &folder).ok();
    let html = bench.text("report.html");
    assert!(html.contains("no minor loops"));
    assert_self_contained(&html);
}
