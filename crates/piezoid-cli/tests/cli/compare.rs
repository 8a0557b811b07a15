//! Several models on the same records, and the page that identify writes beside a model.

use crate::bench::Bench;
use crate::workflow::assert_self_contained;

/// A bench with two models.
fn bench() -> Bench {
    let bench = Bench::stocked();
    bench.run("identify sine5.csv --operator stop -o stop.json --report stop.html").ok();
    bench
}

#[test]
fn identify_writes_a_report_beside_the_model() {
    let bench = bench();
    let html = bench.text("stop.html");
    assert_self_contained(&html);
    for part in ["Training records", "sine5.csv", "Operators tried", "piezoid identify", "operator = stop"] {
        assert!(html.contains(part), "{part}");
    }
    let again = bench.run("identify sine5.csv --operator stop -o again.json --report again.html").ok();
    again.prints(&["wrote again.json and again.html"]);
    bench.run("identify sine5.csv --operator stop -o again.json --report again.json").exits(2).says(&["same file"]);
    let before = bench.names();
    bench.run("identify sine5.csv --operator stop -o a.json --report no/b.html").exits(1).says(&["no/b.html"]);
    assert_eq!(bench.names(), before, "nothing is written if one result cannot be");
}

#[test]
fn models_are_compared_in_a_table_a_page_and_a_document() {
    let bench = bench();
    let line = "compare model.json stop.json --data sine5.csv sine20.csv";
    let run = bench.run(&format!("{line} -o both.html --json both.json")).ok();
    run.prints(&["model.json", "stop", "sine20.csv", "total", "Smallest error in free run: ", "wrote both.html"]);
    let html = bench.text("both.html");
    assert_self_contained(&html);
    for part in ["Errors by record", "Residuals", "Error by frequency", "stop.json", "without the straight line"] {
        assert!(html.contains(part), "{part}");
    }
    let found = bench.run(&format!("{line} --json -")).ok().out_json();
    assert_eq!(found.to_string(), bench.json("both.json").to_string());
    let alone = bench.run("validate sine5.csv sine20.csv --model stop.json --json -").ok().out_json();
    assert_eq!(found["models"][1]["total"], alone["total"], "the same figures as validate");
    let other = bench.run(&format!("{line} --record sine20.csv -o -")).ok();
    assert!(other.out != html && other.out.contains("sine20.csv</h2>"));
}

#[test]
fn what_cannot_be_compared_is_named() {
    let bench = bench();
    bench.run("compare model.json --data sine5.csv --record none.csv").exits(2).says(&["none.csv", "sine5.csv"]);
    bench.run("compare model.json").exits(2).says(&["--data"]);
    let remedy = "give a file that `identify` wrote";
    bench.run("compare sine5.csv --data sine5.csv").exits(1).says(&["sine5.csv: ", remedy]);
    bench.run("compare model.json --data sine5.csv -o model.json").exits(2).says(&["overwritten"]);
}

#[test]
fn operators_and_structures_are_identified_and_compared_on_one_split() {
    let bench = bench();
    let line = "compare sine5.csv sine20.csv stop.json --operators stop,prandtl-ishlinskii --effort quick \
                --structures hammerstein,linear";
    let run = bench.run(&format!("{line} --json a.json --figure a.svg -o a.html")).ok();
    run.prints(&["method", "noise %", "step ns", "stop.json", "prandtl-ishlinskii", "linear", "Smallest error"]);
    let found = bench.json("a.json");
    assert_eq!(found["models"].as_array().unwrap().len() + found["failed"].as_array().unwrap().len(), 4);
    let n = |k: &str| found["split"][k][0]["n"].as_f64().unwrap();
    assert_eq!(((0.75 * n("compared")).round(), &found["split"]["held_out"]), (n("training"), &0.25.into()));
    assert_eq!(found["models"][0]["total"]["n"], found["models"][1]["total"]["n"]);
    let html = bench.text("a.html");
    assert_self_contained(&html);
    assert!(html.contains("Error against parameters") && bench.text("a.svg").contains("<svg"));
    bench.run(&format!("{line} --json b.json --figure b.svg -o b.html")).ok();
    for end in ["json", "svg", "html"] {
        assert_eq!(bench.text(&format!("a.{end}")), bench.text(&format!("b.{end}")), "{end}: no times");
    }
    let other = bench.run(&format!("{line} --data sine5.csv --json -")).ok().out_json();
    assert_eq!(
        (&other["split"]["held_out"], other["split"]["training"][0]["n"].as_f64()),
        (&serde_json::Value::Null, Some(n("compared")))
    );
    let line = "compare sine5.csv --operators";
    bench.run(&format!("{line} preisac")).exits(2).says(&["preisach"]);
    bench.run(&format!("{line} stop --structures series")).exits(2).says(&["series", "hammerstein"]);
    bench.run(&format!("{line} stop --held-out 1")).exits(2).says(&["--held-out"]);
}
