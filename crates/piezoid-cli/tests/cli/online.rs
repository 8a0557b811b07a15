//! Recursive identification along records and streams.

use crate::bench::Bench;
use std::io::Write;
use std::process::Stdio;

/// A bench with a model of plays of the records in it.
fn bench() -> Bench {
    let bench = Bench::stocked();
    bench.run("identify sine5.csv sine20.csv --operator pi --order 2 -o pi.json").ok();
    bench
}

#[test]
fn a_record_is_replayed_with_a_table_json_and_a_model() {
    let bench = bench();
    let run = bench.run("online sine20.csv --model pi.json -o now.json --json rows.txt").ok();
    run.prints(&["time [s]", "gain", "offset [um]", "mode [Hz]", "Wrote now.json."]);
    let rows: Vec<serde_json::Value> =
        bench.text("rows.txt").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(rows.len(), 20);
    assert!((rows[19]["gain"].as_f64().unwrap() - 1.0).abs() < 0.1, "{}", rows[19]);
    let model = bench.json("now.json");
    assert_eq!(model["fit"]["source"]["file"], "sine20.csv");
    bench.run("validate sine20.csv --model now.json").ok();
    let gain = bench.run("online sine20.csv --model pi.json --moves gain,offset --json -").ok();
    let first: serde_json::Value = serde_json::from_str(gain.out.lines().next().unwrap()).unwrap();
    assert_eq!(first["factors"], serde_json::json!([]));
}

#[test]
fn a_stream_gives_what_its_record_gives() {
    let bench = bench();
    bench.run("online sine20.csv --model pi.json --every 1 -o replayed.json").ok();
    let line = "online - --model pi.json -o streamed.json";
    let mut child = bench.command(line).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(bench.text("sine20.csv").as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    let [replayed, streamed] = ["replayed.json", "streamed.json"].map(|name| bench.json(name));
    assert_eq!((&replayed["linear"], &replayed["offset"]), (&streamed["linear"], &streamed["offset"]));
}

#[test]
#[cfg(unix)]
fn ctrl_c_ends_a_silent_stream_and_the_model_is_written() {
    let bench = bench();
    let line = "online - --model pi.json -o kept.json --every 1e-9";
    let mut child = bench.command(line).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(b"0,0\n1,10\n").unwrap();
    stdin.flush().unwrap();
    // The head and two rows: both samples have arrived, and signals are handled.
    let mut out = std::io::BufReader::new(child.stdout.take().unwrap());
    let mut text = String::new();
    for _ in 0..3 {
        std::io::BufRead::read_line(&mut out, &mut text).unwrap();
    }
    assert!(text.contains("time [s]"), "{text}");
    assert!(std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(bench.json("kept.json")["fit"]["samples"], 2);
    drop(stdin);
}

#[test]
fn a_bad_line_ends_a_stream_and_what_was_followed_is_written() {
    let bench = bench();
    let follow = |text: &str, name: &str| {
        let line = format!("online - --model pi.json -o {name}.json --json {name}.txt --every 1e-9");
        let mut child = bench.command(&line).stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(bench.json(&format!("{name}.json"))["fit"]["samples"], 2, "{name}");
        assert_eq!(bench.text(&format!("{name}.txt")).lines().count(), 2, "{name}");
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    assert_eq!(follow("0,0\n1,10\n12.", "cut").0, Some(0));
    let (code, why) = follow("0,0\n1,10\n12.3\n4,5\n", "bad");
    assert_eq!(code, Some(1), "{why}");
    assert!(why.contains("line 3") && why.contains("bad.json"), "{why}");
}

#[test]
fn what_cannot_be_followed_is_named() {
    let bench = bench();
    bench.run("identify sine5.csv --operator preisach --order 2 -o preisach.json").ok();
    let line = "online sine5.csv --model preisach.json";
    bench.run(&format!("{line} --moves weights")).exits(1).says(&["preisach.json", "for each weight of preisach"]);
    bench.run(line).ok().says(&["the weights keep their proportions"]);
    bench.run("online sine5.csv --model pi.json --moves slope").exits(2).says(&["slope", "gain"]);
    bench
        .run("online sine5.csv --model pi.json --memory 1")
        .exits(2)
        .says(&["--memory 1: must be at least", "at least 10"]);
    bench.run("online none.csv --model pi.json").exits(1).says(&["none.csv"]);
    bench.run("online - --model pi.json --fs 1000").exits(1).says(&["lines u,y or t,u,y"]);
    bench.run("online sine5.csv").exits(2).says(&["--model"]);
    bench.run("export --model pi.json --target c --memory 100 -o out").exits(2).says(&["--online"]);
    bench.run("export --model pi.json --target st --online -o out").exits(2).says(&["only to c"]);
    bench.run("export --model pi.json --target c --online --name bender -o out").ok();
    assert!(bench.text("out/bender.h").contains("bender_online_step"));
}
