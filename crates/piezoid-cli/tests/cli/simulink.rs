//! What `export --target simulink` writes: the class in GNU Octave, the S-functions behind a stand-in for Simulink.

use crate::bench::{Bench, Run, skipped};
use piezoid::creep::{Creep, Lag};
use piezoid::driver::Driver;
use piezoid::export::{Wanted, Whole, target};
use piezoid::hysteresis::OPERATORS;
use piezoid::linear::Arx;
use piezoid::{Error, Model};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

const TS: f64 = 5e-4;

const MODEL: &str = r#"{"piezoid": 1, "ts": 0.0005, "units": {"u": "V", "y": "um"}, "offset": 2.0, "creep": [{"tau_s": 0.1, "gain": 0.01}],
    "hysteresis": {"operator": "bouc-wen", "range": [-30, 30], "beta": 0.02, "gamma_over_beta": 0.25, "weights": [1.4, 0.5]},
    "linear": {"a": [1.7424, -0.9453], "b": [0.0, 3.0, 2.8]}}"#;

/// Whether there is such a tool; in CI there must be.
fn there_is(tool: &str) -> bool {
    let there = Command::new(tool).arg("--version").output().is_ok();
    if !there {
        assert!(std::env::var_os("CI").is_none(), "{tool} is missing in CI");
        skipped(&format!("no {tool}"));
    }
    there
}

/// Models of every operator that has a program; every other behind a driver, with creep, or with a direct path.
fn models() -> Vec<(String, Model)> {
    let lags = vec![Lag { tau_s: 0.1, gain: 0.01 }, Lag { tau_s: 1.0, gain: 0.02 }];
    let made = OPERATORS.iter().enumerate().filter_map(|(k, operator)| {
        let b = if k % 2 == 0 { vec![0.0, 0.3, 0.2] } else { vec![0.01, 0.3, 0.2] };
        let linear = Arx::new(TS, vec![1.5, -0.8], b).unwrap();
        let driver = (k % 3 == 0).then(|| Driver::new(1e-4, Some(6e4)).unwrap());
        // Behind a driver there are four substeps to a sample.
        let hysteresis = (operator.example)(if driver.is_some() { TS / 4.0 } else { TS }).unwrap();
        let model = Model::driven(driver, hysteresis, linear, 2.0).unwrap();
        let model = if k % 2 == 0 { model.with_creep(Creep::new(TS, lags.clone()).unwrap()).unwrap() } else { model };
        match model.program() {
            Err(Error::Unsuited { .. }) => None,
            program => {
                program.unwrap();
                Some((operator.name.replace('-', "_"), model))
            }
        }
    });
    made.collect()
}

/// Writes what the target makes of a model.
fn export(bench: &Bench, wanted: &Wanted) {
    for file in (target("simulink").unwrap().make)(wanted).unwrap().files {
        bench.write(&file.path, file.bytes);
    }
}

fn octave(bench: &Bench, script: &str) -> Run {
    bench.write("run_all.m", script);
    let line = "octave-cli --quiet --no-init-file run_all.m";
    let mut words = line.split(' ');
    let output = Command::new(words.next().unwrap()).args(words).current_dir(bench.path("")).output().unwrap();
    Run::of(line, &output)
}

#[test]
fn in_octave_the_class_gives_the_same_bits_for_every_operator_in_either_precision() {
    if !there_is("octave-cli") {
        return;
    }
    for single in [false, true] {
        let bench = Bench::new();
        let models = models();
        assert!(models.len() > 1);
        for (name, model) in &models {
            export(&bench, &Wanted { single, ..Wanted::new(model, name) });
        }
        let script: String = models.iter().map(|(name, _)| format!("{name}_test();\n")).collect();
        let run = octave(&bench, &script).ok();
        assert_eq!(run.err, "", "{run:#?}");
        for (name, _) in &models {
            for method in ["simulate", "step"] {
                assert!(run.out.contains(&format!("{name}, {method}: 0 of 400 differ, by 0 ")), "{name}: {run:#?}");
            }
        }
    }
}

#[test]
fn a_class_that_gives_other_numbers_fails_its_test() {
    if !there_is("octave-cli") {
        return;
    }
    let bench = Bench::new();
    bench.write("m.json", MODEL);
    bench.run("export --model m.json --target simulink --name bender -o .").ok();
    let class = bench.text("bender.m");
    assert!(class.contains("1.7424;"), "{class}");
    bench.write("bender.m", class.replace("1.7424;", "1.742400000000001;"));
    octave(&bench, "bender_test();\n").exits(1).says(&["other numbers than those of piezoid"]);
}

#[test]
fn the_example_of_the_help_runs_and_signals_keep_their_shape() {
    if !there_is("octave-cli") {
        return;
    }
    let bench = Bench::new();
    bench.write("m.json", MODEL);
    for (name, flag, class) in [("bender", "", "double"), ("slim", "--float", "single")] {
        bench.run(&format!("export --model m.json --target simulink --name {name} {flag} -o .")).ok();
        let help = bench.text(&format!("{name}.m"));
        let (_, example) = help.split_once("Example:\n").unwrap();
        let lines = example.lines().map_while(|line| line.trim().strip_prefix('%'));
        let example: String = lines.filter(|line| !line.contains("plot")).map(|line| format!("{line}\n")).collect();
        let script = format!(
            "{example}
            assert(size(y), [400, 1]);
            assert(class(y), '{class}');
            assert(size(model.simulate([1, 2, 3])), [1, 3]);
            assert(isempty(model.simulate([])));
            assert(class(model.step(int8(3))), '{class}');
            assert({name}.Ts, 5e-4);
            assert(model.units.y, 'um');
            other = {name}();
            other.step(20);
            other.reset();
            assert(isequal(other.state, {name}().state) && ~isequal(other.state, model.state));
            model.step([1, 2]);\n"
        );
        octave(&bench, &script).exits(1).says(&["error: step takes one sample: simulate takes a row or column"]);
    }
}

/// Compiles an S-function behind the stand-in and runs it on `inputs`.
fn simulated(bench: &Bench, name: &str, sfun: &str, inputs: &[Vec<f64>]) -> (Vec<f64>, String) {
    let stands_in = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/simulink");
    let gcc = |words: &[&str]| {
        let mut command = Command::new("gcc");
        command.args([
            "-std=c99",
            "-pedantic",
            "-Wall",
            "-Wextra",
            "-Wconversion",
            "-Wshadow",
            "-Werror",
            "-ffp-contract=off",
        ]);
        command.arg("-I").arg(&stands_in).args(words).current_dir(bench.path(""));
        Run::of(&format!("{command:?}"), &command.output().unwrap()).ok();
    };
    let (source, engine) = (format!("{sfun}.c"), stands_in.join("engine.c"));
    gcc(&["-c", &source, "-o", "as_for_simulink_coder.o"]);
    let sanitize = "-fsanitize=address,undefined";
    gcc(&["-DMATLAB_MEX_FILE", "-g", sanitize, &source, &format!("{name}.c"), engine.to_str().unwrap(), "-o", sfun]);
    let mut engine = Command::new(bench.path(sfun));
    let mut child = engine.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let bytes: Vec<u8> = inputs.iter().flatten().flat_map(|v| v.to_ne_bytes()).collect();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{sfun}: {said}");
    (output.stdout.chunks_exact(8).map(|v| f64::from_ne_bytes(v.try_into().unwrap())).collect(), said)
}

#[test]
fn behind_a_stand_in_for_simulink_every_s_function_gives_the_same_numbers_in_every_block() {
    if !there_is("gcc") {
        return;
    }
    for (name, model) in models() {
        for single in [false, true] {
            let bench = Bench::new();
            let wanted = Wanted { single, ..Wanted::new(&model, &name) };
            export(&bench, &wanted);
            let whole = Whole::new(&wanted).unwrap();
            for (entry, vectors) in whole.entries.iter().zip(whole.vectors(&wanted).unwrap()) {
                let sfun = format!("{name}_{}sfun", entry.step.trim_end_matches("step"));
                let (given, said) = simulated(&bench, &name, &sfun, &vectors.inputs);
                assert!(given == vectors.outputs, "{sfun}, single {single}");
                let direct = entry.step != "step" || model.linear().b()[0] != 0.0;
                let says = format!("Ts 0.00050000000000000001, feedthrough {}\n", i32::from(direct));
                assert_eq!(said, says, "{sfun}");
            }
        }
    }
}

#[test]
fn names_that_matlab_has_taken_are_refused_and_leave_nothing() {
    let bench = Bench::new();
    bench.write("m.json", MODEL);
    for (name, says) in [
        ("end", "is a word of the language"),
        ("zeros", "is a word of the language"),
        ("Simulate", "is a word of the language"),
        ("double", "is a word of the language"),
        ("2fast", "must be a letter"),
        ("an_actuator_of_forty_characters_in_a_name", "must be a letter, then letters"),
    ] {
        let run = bench.refused(&format!("export --model m.json --target simulink --name {name} -o out"));
        run.says(&[name, says]);
    }
}

#[test]
fn units_of_any_text_stay_text() {
    if !there_is("octave-cli") {
        return;
    }
    let bench = Bench::new();
    bench.write("m.json", MODEL.replace("\"um\"", r#""it's % */ \"um\"\n error('no')""#));
    bench.run("export --model m.json --target simulink --name bender -o .").ok();
    octave(&bench, "bender_test();\nassert(bender().units.y, 'it''s % */ \"um\"  error(''no'')');\n").ok();
}
