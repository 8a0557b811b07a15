//! Exports: what a folder may hold, operations as JSON, and which target serves which operator.

use crate::bench::Bench;

const EXPORT: &str = "export --model model.json";

#[test]
fn a_folder_with_another_export_is_refused_unless_forced() {
    let bench = Bench::stocked();
    bench.run(&format!("{EXPORT} --target simulink --controller pi --name a -o out")).ok();
    let first = bench.names();
    assert!(first.contains(&"out/a_control_sfun.c".into()));
    for (options, says) in [
        ("--target c --name a", "target simulink, name a; a.h, a.c, a.md would be replaced"),
        ("--target simulink --name b", "target simulink, name a: name another folder, or give --force"),
        ("--target fmu2 --name a", "target simulink, name a: name another folder, or give --force"),
    ] {
        bench
            .refused(&format!("{EXPORT} {options} -o out"))
            .says(&["out: the folder holds the export of another", says]);
    }
    // The same export again, with fewer files, is as in a folder of its own.
    bench.run(&format!("{EXPORT} --target simulink --name a -o out")).ok();
    bench.run(&format!("{EXPORT} --target simulink --name a -o fresh")).ok();
    let of = |folder: &str| {
        let files = bench.files().into_iter();
        files.filter_map(|(name, bytes)| Some((name.strip_prefix(folder)?.to_string(), bytes))).collect::<Vec<_>>()
    };
    assert_eq!(of("out/"), of("fresh/"));
    bench.run(&format!("{EXPORT} --target c --name b -o out --force")).ok();
    bench.run(&format!("{EXPORT} --target simulink --name a -o out")).ok();
    let list = bench.json("out/piezoid-export.json");
    assert_eq!((&list["exports"][0]["name"], &list["exports"][1]["name"]), (&"a".into(), &"b".into()));
}

#[test]
fn fmus_share_a_folder_and_no_other_file_is_replaced() {
    let bench = Bench::stocked();
    for options in
        ["--target fmu2 --name a", "--target fmu3 --name a", "--target fmu3 --name b", "--target fmu2 --name a"]
    {
        bench.run(&format!("{EXPORT} {options} -o fmus")).ok();
    }
    assert_eq!(
        bench.names().iter().filter(|name| name.ends_with("a_fmi3.fmu") || name.ends_with("b_fmi3.fmu")).count(),
        2
    );
    std::fs::create_dir(bench.path("own")).unwrap();
    bench.write("own/a.c", "int own;\n");
    bench.refused(&format!("{EXPORT} --target c --name a -o own")).says(&[
        "own: the folder holds a.c, not from this target under this name: name another folder, or give --force",
    ]);
    bench.run(&format!("{EXPORT} --target c --name a -o own --force")).ok();
}

#[test]
fn the_operations_of_every_function_are_given_as_json_with_their_bound() {
    let bench = Bench::stocked();
    let text = bench.run(&format!("{EXPORT} --target c --name a -o out --json -")).ok().out_json();
    assert_eq!(text["files"][0]["file"], "a.h");
    assert_eq!(text["functions"][0]["function"], "step");
    let operations = &text["functions"][0]["operations"];
    let [most, bound] = ["most_seen", "bound"].map(|key| operations[key].as_u64().unwrap());
    assert!(0 < most && most <= bound, "{operations}");
    let stated = format!("Operations in one call: at most {most} in the self-test, at most {bound} for every input.");
    assert!(bench.text("out/a.h").contains(&stated));
    bench.misused(&format!("{EXPORT} --target c -o new --json model.json")).says(&["model.json is an input file"]);
}

#[test]
fn targets_tell_the_operators_that_they_serve() {
    let bench = Bench::new();
    let message = bench.run("targets --operators").ok();
    let all = piezoid::hysteresis::OPERATORS.len();
    message.prints(&[
        &format!("model and feed-forward: all {all} operators"),
        &format!("model: no operator; feed-forward: all {all}"),
    ]);
    let rows = bench.run("targets --operators --json -").ok().out_json();
    let rows = rows.as_array().unwrap();
    let of = |target: &str| &rows.iter().find(|row| row["name"] == target).unwrap()["operators"]["preisach"];
    assert_eq!(of("fixed"), &serde_json::json!(["model", "feed-forward"]));
    assert_eq!(of("waveform"), &serde_json::json!(["feed-forward"]));
}

#[test]
fn identify_takes_the_target_of_its_export() {
    let bench = Bench::stocked();
    let line = "identify sine5.csv --operator stop --order 2 -o found.json";
    bench.run(&format!("{line} --for fixed")).ok();
    assert_eq!(bench.json("found.json")["fit"]["options"], serde_json::json!({"operator": "stop", "order": 2}));
    bench.misused(&format!("{line} --for fixd")).says(&["there is no target called `fixd`", "did you mean `fixed`"]);
}
