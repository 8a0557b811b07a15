//! `inspect`, and the profile that the other verbs take.

use crate::bench::Bench;

/// The record `sine5.csv` as a scope shows it: the input of an amplifier of gain 20, a sensor of 5 um/V.
fn scope(bench: &Bench) -> String {
    let scaled = |line: &str| {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        format!("{},{},{}", cells[0], cells[1] / 20.0, cells[2] / 5.0)
    };
    let rows: Vec<String> = bench.text("sine5.csv").lines().skip(1).map(scaled).collect();
    format!("TIME,CH1,CH2\ns,V,V\n{}\n", rows.join("\n"))
}

#[test]
fn a_file_is_shown_with_its_channels_its_roles_and_its_sketch() {
    let bench = Bench::stocked();
    let german = bench.text("sine5.csv").replacen("t_s,u_V,y_um", "Zeit [s],Spannung [V],Weg [\u{b5}m]", 1);
    bench.write("weg.csv", german);
    bench.run("inspect weg.csv").ok().prints(&[
        "weg.csv: csv",
        "Spannung [V]   input     V     2000    -30      30",
        "Weg [\u{b5}m]      output",
        "u in V, y in um",
        "input `Spannung [V]`, output `Weg [\u{b5}m]`",
        "\u{28b3}\u{2840}",
    ]);
    let inspection = bench.run("inspect weg.csv --json -").ok().out_json();
    assert_eq!(
        (&inspection[0]["channels"][1]["role"], &inspection[0]["record"]["ts"]),
        (&"input".into(), &5e-4.into())
    );
}

#[test]
fn a_profile_says_once_how_the_files_of_a_rig_are_read() {
    let bench = Bench::stocked();
    bench.write("scope.csv", scope(&bench));
    let input = "--input-col CH1 --output-col CH2 --input-scale 20 --output-scale 5um/V";
    let inspection = bench.run("inspect scope.csv").ok().prints(&["no record"]).out;
    let words: Vec<&str> = inspection.split_whitespace().collect();
    assert!(words.join(" ").contains("--input-col \"CH1\" --output-col \"CH2\""), "{inspection}");
    bench.run(&format!("inspect scope.csv {input} -o rig.toml")).ok().prints(&["u in V, y in um", "scaled by 5um/V"]);
    let figures = |flags: &str| {
        let run = bench.run(&format!("validate scope.csv --model model.json --json - {flags}"));
        run.ok().out_json()["files"].clone()
    };
    assert_eq!(figures("--profile rig.toml"), figures(input));
    assert_ne!(figures("--profile rig.toml --output-scale 6um/V"), figures(input), "a flag counts more");
    let error = figures("--profile rig.toml")[0]["nrmse_percent"].as_f64().unwrap();
    let plain = bench.run("validate sine5.csv --model model.json --json -").ok().out_json();
    assert!((error / plain["files"][0]["nrmse_percent"].as_f64().unwrap() - 1.0).abs() < 1e-6);
}

#[test]
fn files_that_look_alike_need_one_profile() {
    let bench = Bench::stocked();
    for name in ["a.csv", "b.csv", "c.csv"] {
        bench.write(name, scope(&bench));
    }
    let printed = |line: &str| bench.run(line).ok().out.split_whitespace().collect::<Vec<_>>().join(" ");
    let undecided = printed("inspect a.csv b.csv c.csv");
    assert!(undecided.ends_with("3 files look alike: one profile reads them: piezoid inspect a.csv FLAGS -o rig.toml"));
    let mixed = printed("inspect a.csv sine5.csv b.csv");
    assert!(mixed.contains("2 files (a.csv, b.csv) look alike: "), "{mixed}");
    assert!(!printed("inspect a.csv sine5.csv").contains("alike"));
    bench.run("inspect a.csv --input-col CH1 --output-col CH2 -o rig.toml").ok();
    assert!(!printed("inspect a.csv b.csv --profile rig.toml").contains("alike"));
    // What is said of all is asked for once.
    let refused = bench.refused("validate a.csv b.csv c.csv --model model.json");
    assert_eq!(refused.err.matches("--input-col").count(), 1, "{refused:?}");
}

#[test]
fn how_a_record_was_read_is_told_and_travels_in_the_model() {
    let bench = Bench::stocked();
    bench.write("scope.csv", scope(&bench));
    bench.run("inspect scope.csv --input-col 2 --output-col 3 --input-scale 20 --output-scale 5um/V -o rig.toml").ok();
    bench
        .run("identify scope.csv --profile rig.toml --operator proportional --order 1 -o new.json")
        .ok()
        .says(&["scope.csv: input scaled by 20", "output scaled by 5um/V"]);
    assert_eq!(bench.json("new.json")["fit"]["files"][0]["steps"][0], "input scaled by 20");
}

#[test]
fn a_profile_with_faults_is_refused_by_name() {
    let bench = Bench::stocked();
    for (text, says) in [
        ("inputcol = 3", "did you mean `input_col`"),
        ("# rig\nx = [", "rig.toml: line 2: not TOML"),
        ("fs = -1", "rig.toml: --fs -1: must be a positive number"),
        ("output_scale = \"um/V\"", "--output-scale um/V: must be a factor"),
    ] {
        bench.write("rig.toml", text);
        bench.refused("validate sine5.csv --model model.json --profile rig.toml").says(&[says]);
    }
    bench.refused("inspect sine5.csv --profile none.toml").says(&["none.toml: there is no such file"]);
}

#[test]
fn swapped_columns_are_a_problem() {
    let bench = Bench::stocked();
    let swapped = bench.run("inspect sine5.csv --input-col y_um --output-col u_V").ok();
    swapped.prints(&["problem: ", "exchanged"]);
    assert!(!bench.run("inspect sine5.csv").ok().out.contains("problem"));
}
