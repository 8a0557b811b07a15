//! From records to a model and its report, as a user works.

use crate::bench::{Bench, number};

#[test]
fn a_model_is_identified_and_predicts_its_own_data() {
    let bench = Bench::stocked();
    let run = bench
        .run("identify sine5.csv sine20.csv --method paper --small-signal prbs.csv --verbose -o m.json --json f.json");
    run.ok()
        .prints(&["Hysteresis block: rate-scheduled", "mode 1", "146.7", "sine5.csv", "sine20.csv"])
        .says(&["note: linear block: order 2, estimated by swarm"]);
    let model = bench.json("m.json");
    assert_eq!((&model["piezoid"], &model["ts"], &model["units"]["y"]), (&1.into(), &5e-4.into(), &"um".into()));
    assert_eq!(model["hysteresis"]["operator"], "rate-scheduled");
    assert_eq!(
        (model["linear"]["a"].as_array().unwrap().len(), model["linear"]["b"].as_array().unwrap().len()),
        (2, 3)
    );
    let pole = &bench.json("f.json")["linear"]["poles"][0];
    assert!((number(&pole["hz"]) - 146.7).abs() < 1.0 && (number(&pole["damping"]) - 0.061).abs() < 0.005, "{pole}");

    bench.run("identify sine5.csv --method paper -o gain.json").ok().says(&["pure gain", "one frequency (5", "PRBS"]);
    bench.run("identify --method paper --small-signal prbs.csv -o floor.json").ok().says(&["no large-signal record"]);
    bench
        .run("identify sine5.csv --method paper --small-signal prbs.csv --order 3 --estimator least-squares -o m3.json")
        .ok();
    assert_eq!(bench.json("m3.json")["linear"]["a"].as_array().unwrap().len(), 3);
    for estimator in ["output-error", "instrumental"] {
        let line =
            format!("identify sine5.csv --method paper --small-signal prbs.csv --estimator {estimator} -o e.json");
        bench.run(&line).ok().prints(&["146.7"]).says(&[&format!("order 2, estimated by {estimator}")]);
    }
    bench
        .run("identify sine5.csv --method paper --small-signal prbs.csv --reading printed --split direction -o p.json")
        .ok();
    bench.run("identify sine5.csv --method paper --operator proportional -o linear.json").ok();
    for operator in ["two-branch", "rate-scheduled"] {
        bench
            .run(&format!(
                "identify sine5.csv sine20.csv --method paper --small-signal prbs.csv --operator {operator} -o o.json"
            ))
            .ok();
        assert_eq!(bench.json("o.json")["hysteresis"]["operator"], operator);
    }
}

#[test]
fn skip_from_and_to_choose_the_samples() {
    let bench = Bench::stocked();
    let n = |more: &str| {
        let line = format!("validate sine5.csv --model model.json --json - {more}");
        number(&bench.run(&line).ok().out_json()["total"]["n"])
    };
    assert_eq!((n(""), n("--skip 0.25"), n("--from 0.25")), (2000.0, 1500.0, 1500.0));
    assert_eq!((n("--from 0.2 --to 0.7"), n("--from 0.2 --to 0.7 --skip 0.1")), (1000.0, 800.0));
    bench.run("simulate --plant paper --input drive5.csv --from 0.2 --to 0.7 -o part.csv").ok();
    assert_eq!(bench.text("part.csv").lines().count(), 1001);
}

#[test]
fn columns_of_any_name_are_read_when_named_and_time_may_be_missing() {
    let bench = Bench::stocked();
    let renamed = bench.text("sine5.csv").replacen("t_s,u_V,y_um", "clock,command [V],sensor_um", 1);
    bench.write("named.csv", renamed);
    let mut line = bench.command("validate named.csv --model model.json --time-col clock --output-col sensor_um");
    let output = line.args(["--input-col", "command [V]", "--json", "-"]).output().unwrap();
    let named = crate::bench::Run::of("named", &output).ok().out_json();
    let plain = bench.run("validate sine5.csv --model model.json --json -").ok().out_json();
    assert_eq!(named["total"], plain["total"]);

    let cells = |row: &str| row.split_once(',').unwrap().1.to_string() + "\n";
    bench.write("timeless.csv", bench.text("sine5.csv").lines().map(cells).collect::<String>());
    let timeless = bench.run("validate timeless.csv --model model.json --ts 5e-4 --json -").ok().out_json();
    assert_eq!(timeless["total"], plain["total"]);
}

#[test]
fn a_report_opens_from_disk_and_tells_the_figures() {
    let bench = Bench::stocked();
    bench.run("report sine5.csv sine20.csv --model model.json -o report.html").ok();
    let html = bench.text("report.html");
    assert_self_contained(&html);
    for part in ["sine5.csv", "sine20.csv", "rate-scheduled", "146.7", "piezoid identify"] {
        assert!(html.contains(part), "{part}");
    }
    let piped = bench.run("report sine5.csv sine20.csv --model model.json -o -").ok();
    assert_eq!(piped.out, html);
}

/// Asserts that this is one HTML document that loads nothing.
pub(crate) fn assert_self_contained(html: &str) {
    let low = html.to_lowercase();
    assert_eq!((low.matches("<html").count(), low.matches("</html>").count()), (1, 1));
    assert!(low.starts_with("<!doctype html>"));
    for load in ["<link", "<script src", "@import", "url(http", "url(//", "<img", "<iframe", "<object", "src=\"http"] {
        assert!(!low.contains(load), "{load}");
    }
    // Without the scripts at the end.
    let html = html.split("<script>").next().unwrap();
    assert!(!html.contains("NaN") && !html.contains("inf,"), "a number that is none");
    let figures: Vec<&str> = html.split("<svg").skip(1).collect();
    assert!(!figures.is_empty());
    for figure in figures {
        let svg = format!("<svg{}</svg>", figure.split("</svg>").next().unwrap());
        roxmltree::Document::parse(&svg).unwrap_or_else(|e| panic!("{e}: {}", &svg[..200]));
    }
}

#[test]
fn results_go_down_a_pipe_and_come_up_from_one() {
    let bench = Bench::stocked();
    let drive = bench.run("excite sine --ts 5e-4 --duration 1 --amplitude 30 --frequency 5 -o -").ok();
    assert_eq!(drive.out, bench.text("drive5.csv"));
    assert_eq!(bench.run("simulate --plant paper --input drive5.csv -o -").ok().out, bench.text("sine5.csv"));
    let model = bench.run("identify sine5.csv --operator stop -o -").ok().out_json();
    assert_eq!(model["piezoid"], 1);
    assert!(bench.run("identify sine5.csv --operator stop -o m.json --json -").ok().out_json()["loops"].is_array());
}
