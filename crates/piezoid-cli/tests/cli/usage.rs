//! Wrong command lines: status 2, and the name that was probably meant.

use crate::bench::Bench;

#[test]
fn a_wrong_command_line_exits_2_and_says_what_is_wrong() {
    let bench = Bench::stocked();
    let lines: &[(&str, &[&str])] = &[
        ("xyzzy", &["xyzzy", "known are study, plan, inspect, prepare, excite"]),
        ("identfy", &["a similar subcommand exists: 'identify'"]),
        ("validate sine5.csv --modle model.json", &["--modle", "'--model'"]),
        ("simulate --plant paper --input drive5.csv", &["--output"]),
        ("simulate --input drive5.csv -o y.csv", &["--plant", "--model"]),
        ("simulate --plant paper --model model.json --input drive5.csv -o y.csv", &["cannot be used with"]),
        ("excite noise --ts 1 --duration 1 -o u.csv", &["noise", "known are prbs, multisine"]),
        ("excite sin --ts 1 --duration 1 -o u.csv", &["'sine'"]),
        ("excite prbs --ts 5e-4 --duration 1 --amplitude 1", &["--output"]),
        ("excite prbs --ts 5e-4 --duration 1 --amplitude 1 --frequency 3 -o u.csv", &["--frequency"]),
        ("excite prbs --ts 5e-4 --duration 1 --amplitude 1 -o u.npy", &["u.npy", ".csv or .npz or .mat"]),
        ("simulate --plant paper --input drive5.csv -o y.h5", &["y.h5", ".h5 files are read, but not written"]),
        ("excite sine --ts 5e-4 --duration 1 --amplitude 1 -o u.csv", &["--frequency <Hz>"]),
        ("excite sine --ts -1 --duration 1 --amplitude 1 --frequency 5 -o u.csv", &["'-1'", "--ts", "positive"]),
        ("excite sine --ts 5e-4 --duration 0 --amplitude 1 --frequency 5 -o u.csv", &["'0'", "--duration"]),
        ("excite sine --ts 5e-4 --duration 1 --amplitude one --frequency 5 -o u.csv", &["'one'", "--amplitude"]),
        ("excite sine --ts 5e-4 --duration 1 --amplitude 1 --frequency 5 --clip -o u.csv", &["--driver"]),
        (
            "excite sine --ts 5e-4 --duration 1 --amplitude 1 --frequency 5 --driver bd300 -o u.csv",
            &["bd300", "--capacitance", "8.2e-6 F"],
        ),
        ("identify -o m.json", &["--small-signal"]),
        ("identify sine5.csv", &["--output"]),
        ("identify sine5.csv --method paper --order 0 -o m.json", &["--order 0", "at least 1"]),
        ("identify sine5.csv --order 99 -o m.json", &["'99'", "--order"]),
        ("identify sine5.csv --iterations 0 -o m.json", &["'0'", "--iterations", "1 or more"]),
        ("identify sine5.csv --particles -3 -o m.json", &["'-3'", "--particles"]),
        ("identify sine5.csv --bins 0 -o m.json", &["'0'", "--bins"]),
        ("identify sine5.csv --global-best last -o m.json", &["'last'", "ever", "current"]),
        ("identify sine5.csv --operator preisach,dhal -o m.json", &["`dhal`", "did you mean `dahl`"]),
        (
            "excite stepped-sine --ts 5e-4 --duration 1 --amplitude 1 --frequency 5 --steps 2 -o u.csv",
            &["steps", "from 3 to"],
        ),
        ("identify sine5.csv --method jiont -o m.json", &["'jiont'", "joint", "paper"]),
        ("identify sine5.csv -o - --json -", &["stdout"]),
        ("identify sine5.csv -o m.json --json m.json", &["m.json", "another file"]),
        ("identify sine5.csv -o sine5.csv", &["sine5.csv", "overwritten"]),
        ("simulate --plant paper --input drive5.csv -o drive5.csv", &["drive5.csv", "overwritten"]),
        ("report sine5.csv --model model.json -o model.json", &["model.json", "overwritten"]),
        ("validate sine5.csv --model model.json --json ./sine5.csv", &["sine5.csv", "overwritten"]),
        ("loops sine5.csv --json sine5.csv", &["sine5.csv", "overwritten"]),
        ("validate --model model.json", &["<FILE>..."]),
        ("validate sine5.csv --model model.json --skip -5", &["'-5'", "--skip", "0 or more"]),
        ("validate sine5.csv --model model.json --skip nan", &["'nan'", "--skip"]),
        ("validate sine5.csv --model model.json --from inf", &["'inf'", "--from"]),
        ("validate sine5.csv --model model.json --ts 0", &["'0'", "--ts", "positive"]),
        ("validate sine5.csv --model model.json --offset fre", &["'fre'", "free"]),
        ("study --plant papr", &["`papr`", "paper"]),
        ("study --seed minus", &["'minus'", "--seed"]),
        ("completions tcsh", &["'tcsh'", "zsh"]),
        ("man identfy", &["identfy", "identify"]),
    ];
    let before = bench.files();
    for (line, says) in lines {
        let run = bench.run(line).exits(2).says(says);
        assert!(run.err.starts_with("error: ") && run.out.is_empty(), "{run:?}");
    }
    assert!(before == bench.files(), "a wrong command line left {:?}", bench.names());
}

#[test]
fn an_operation_without_output_of_its_own_is_a_verb_by_its_row() {
    let bench = Bench::stocked();
    let found = bench.run("loops sine5.csv --bins 8").ok().out_json();
    assert_eq!(found["units"]["y"], "um");
    // A quarter of 0.2 s, in samples of 0.5 ms.
    assert_eq!((&found["loop"]["frequency_hz"], &found["reversals"][0]), (&5.0.into(), &100.into()));
    bench.run("loops sine5.csv --bins 0").exits(2).says(&["'0'", "--bins"]);
}

#[test]
fn an_unknown_name_is_answered_with_the_nearest_one() {
    let bench = Bench::stocked();
    let lines = [
        ("simulate --plant papr --input drive5.csv -o y.csv", "`paper`"),
        ("simulate --plant pl14o --input drive5.csv -o y.csv", "`pl140`"),
        ("plants --show pl1400", "`pl140`"),
        ("identify sine5.csv --operator twobranch -o m.json", "`two-branch`"),
        ("identify sine5.csv --method paper --estimator swrm -o m.json", "`swarm`"),
        ("excite sine --ts 5e-4 --duration 1 --amplitude 1 --frequency 5 --driver pl40 -o u.csv", "`pl140`"),
    ];
    for (line, meant) in lines {
        bench.misused(line).says(&["known are", "did you mean", meant]);
    }
    // Only the file can show that this name is wrong.
    let line = "validate sine5.csv --model model.json --output-col y_u";
    bench.refused(line).says(&["known are", "did you mean", "`y_um`"]);
}

#[test]
fn a_setting_outside_its_domain_is_refused_with_its_value() {
    let bench = Bench::new();
    let sine = "excite sine --ts 5e-4 --amplitude 1 -o u.csv";
    bench.misused(&format!("{sine} --duration 1 --frequency 5000")).says(&["--frequency 5000 Hz", "1000 Hz"]);
    bench.misused(&format!("{sine} --duration 1e9 --frequency 5")).says(&["--duration 1000000000 s", "samples"]);
    let nan = format!("{sine} --duration 1 --frequency nan");
    bench.run(&nan).exits(2).says(&["--frequency", "positive number"]);
    let prbs = "excite prbs --ts 5e-4 --duration 1 --amplitude 1 -o u.csv";
    bench.run(&format!("{prbs} --order 2.5")).exits(2).says(&["'2.5' for '--order", "whole number"]);
    bench.run(&format!("{prbs} --order 99")).exits(2).says(&["'99' for '--order", "31"]);
    bench.run(&format!("{prbs} --clock-divider 0")).exits(2).says(&["'0' for '--clock-divider"]);
}

#[test]
fn help_fits_a_terminal_of_80_columns_and_every_working_verb_has_examples() {
    let bench = Bench::new();
    let kinds: Vec<String> = bench
        .run("excitations --json -")
        .ok()
        .out_json()
        .as_array()
        .unwrap()
        .iter()
        .map(|row| format!("excite {}", row["name"].as_str().unwrap()))
        .collect();
    let verbs = "study excite simulate identify validate compare report serve plants completions man";
    let verbs = std::iter::once("").chain(verbs.split(' '));
    for verb in verbs.chain(kinds.iter().map(String::as_str)) {
        for flag in ["-h", "--help"] {
            let output = bench.command(verb).arg(flag).env("COLUMNS", "80").output().unwrap();
            let run = crate::bench::Run::of(verb, &output).ok();
            let longest = run.out.lines().map(|line| line.chars().count()).max().unwrap();
            assert!(longest <= 80, "{longest} columns: {run:#?}");
            if !["", "plants", "completions", "man"].contains(&verb) && !verb.starts_with("excite ") {
                assert!(run.out.contains("Example"), "{verb}");
            }
        }
    }
}

#[test]
fn every_kind_of_drive_signal_is_described_in_its_help() {
    let bench = Bench::new();
    let help = bench.run("excite --help").ok();
    for row in bench.run("excitations --json -").ok().out_json().as_array().unwrap() {
        let (name, summary) = (row["name"].as_str().unwrap(), row["summary"].as_str().unwrap());
        let line = help.out.lines().find(|line| line.trim_start().starts_with(&format!("{name} "))).unwrap();
        assert!(line.contains(&summary[1..20]), "{line}");
    }
}
