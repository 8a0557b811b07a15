//! The same command gives the same bytes, wherever it is run.

use crate::bench::Bench;
use piezoid_testing::skipped;

#[test]
fn identify_gives_the_same_bytes_wherever_it_is_run() {
    let [once, again] = [(); 2].map(|()| {
        let bench = Bench::stocked();
        let run = bench
            .run("identify sine5.csv sine20.csv --method paper --small-signal prbs.csv -o m.json --json f.json")
            .ok();
        (run.out, bench.text("m.json"), bench.text("f.json"))
    });
    assert!(once == again);
    let bench = Bench::stocked();
    bench.run("identify sine5.csv sine20.csv --method paper --small-signal prbs.csv --seed 2 -o m.json").ok();
    assert_ne!(bench.text("m.json"), once.1);
}

#[test]
fn a_model_tells_how_it_was_made_and_names_no_folder() {
    let bench = Bench::stocked();
    std::fs::create_dir(bench.path("lab")).unwrap();
    bench.write("lab/a b.csv", bench.bytes("sine20.csv"));
    let mut command = bench.command("identify --method paper --seed 7 --iterations 30");
    command.arg(bench.path("sine5.csv")).arg("lab/a b.csv").arg("--small-signal").arg(bench.path("prbs.csv"));
    command.arg("-o").arg(bench.path("m.json"));
    assert!(command.output().unwrap().status.success());
    let text = bench.text("m.json");
    let folder = bench.path("").file_name().unwrap().to_str().unwrap().to_string();
    for private in [folder.as_str(), "lab", std::env::temp_dir().to_str().unwrap(), "/"] {
        assert!(!text.replace("um/V", "").contains(private), "{private} in {text}");
    }
    let fit = &bench.json("m.json")["fit"];
    assert_eq!(fit["command"], "piezoid identify");
    assert_eq!(fit["options"], serde_json::json!({"method": "paper", "seed": 7, "iterations": 30}));
    assert_eq!((&fit["seed"], &fit["version"]), (&7.into(), &env!("CARGO_PKG_VERSION").into()));
    let files: Vec<&str> = fit["files"].as_array().unwrap().iter().map(|f| f["file"].as_str().unwrap()).collect();
    assert_eq!(files, ["prbs.csv", "sine5.csv", "a b.csv"]);
}

#[test]
fn files_are_named_with_the_hash_of_what_was_read() {
    let bench = Bench::new();
    let rows: String = (0..40).map(|t| format!("{},{},{}\n", f64::from(t) / 1024.0, t % 8, 2 * (t % 8))).collect();
    bench.write("r.csv", format!("t_s,u_V,y_um\n{rows}"));
    bench.run("identify r.csv --operator proportional -o m.json").ok();
    // The expected hash is that of `sha256sum` on the same bytes.
    let Ok(sum) = std::process::Command::new("sha256sum").arg(bench.path("r.csv")).output() else {
        skipped("no sha256sum to compare a hash with");
        return;
    };
    let sum = String::from_utf8(sum.stdout).unwrap();
    assert_eq!(bench.json("m.json")["fit"]["files"][0]["sha256"], sum.split_whitespace().next().unwrap());
}
