//! What `export --target simulink` writes: the class in GNU Octave, the S-functions behind a stand-in for Simulink.

use crate::bench::{Bench, Run, skipped};
use piezoid::Model;
use piezoid::control::Pi;
use piezoid::creep::{Creep, Lag};
use piezoid::driver::Driver;
use piezoid::export::{Wanted, Whole, target};
use piezoid::hysteresis::OPERATORS;
use piezoid::linear::Arx;
use std::io::Write;
use std::path::{Path, PathBuf};
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
        let driver = (k % 3 == 1).then(|| Driver::new(1e-4, Some(6e4)).unwrap());
        // Behind a driver there are four substeps to a sample.
        let hysteresis = (operator.example)(if driver.is_some() { TS / 4.0 } else { TS }).unwrap();
        let model = Model::driven(driver, hysteresis, linear, 2.0).unwrap();
        let model = if k % 2 == 0 { model.with_creep(Creep::new(TS, lags.clone()).unwrap()).unwrap() } else { model };
        model.program().is_ok().then(|| (operator.name.replace('-', "_"), model))
    });
    made.collect()
}

/// A few of them: with and without a direct path, behind a driver and not.
fn kinds() -> Vec<(String, Model)> {
    let mut seen = Vec::new();
    let kind = |model: &Model| (model.linear().b()[0] == 0.0, model.driver().is_some());
    let new = |(_, model): &(String, Model)| {
        let new = !seen.contains(&kind(model));
        seen.push(kind(model));
        new
    };
    models().into_iter().filter(new).collect()
}

/// A controller to go with each.
fn controller() -> Pi {
    Pi::new(TS, 0.05, 20.0, (-30.0, 30.0)).unwrap()
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
fn in_octave_the_class_gives_the_same_bits_for_every_operator_and_in_either_precision() {
    if !there_is("octave-cli") {
        return;
    }
    for single in [false, true] {
        let bench = Bench::new();
        let models = if single { kinds() } else { models() };
        assert!(models.len() >= 4);
        for (name, model) in &models {
            export(&bench, &Wanted { single, controller: Some(&controller()), ..Wanted::new(model, name) });
        }
        let script: String = models.iter().map(|(name, _)| format!("{name}_test();\n")).collect();
        let run = octave(&bench, &script).ok();
        assert!(!run.err.contains("warning"), "{run:#?}");
        for (name, _) in &models {
            for (method, n) in [("simulate", 400), ("step", 40), ("control_simulate", 400), ("control_step", 40)] {
                assert!(run.out.contains(&format!("{name}, {method}: 0 of {n} differ, by 0 ")), "{name}: {run:#?}");
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

/// Where the stand-in for Simulink is.
fn stand_in() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/simulink")
}

/// Compiles as strictly as can be.
fn gcc(bench: &Bench, words: &[&str]) {
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
    command.args(["-g", "-fsanitize=address,undefined", "-I"]).arg(stand_in()).args(words).current_dir(bench.path(""));
    Run::of(&format!("{command:?}"), &command.output().unwrap()).ok();
}

/// Compiles an S-function behind the stand-in and runs it on `inputs`: the outputs, and what it says of itself.
fn simulated(bench: &Bench, sfun: &str, inputs: &[Vec<f64>]) -> (Vec<f64>, String) {
    let source = format!("{sfun}.c");
    gcc(bench, &["-c", &source, "-o", "as_for_simulink_coder.o"]);
    gcc(bench, &["-DMATLAB_MEX_FILE", &source, "step.o", "engine.o", "-o", sfun]);
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
    for (name, model) in kinds() {
        for single in [false, true] {
            let bench = Bench::new();
            let controller = controller();
            let wanted = Wanted { single, controller: Some(&controller), ..Wanted::new(&model, &name) };
            export(&bench, &wanted);
            gcc(&bench, &["-c", &format!("{name}.c"), "-o", "step.o"]);
            gcc(&bench, &["-c", stand_in().join("engine.c").to_str().unwrap(), "-o", "engine.o"]);
            let whole = Whole::new(&wanted).unwrap();
            for (entry, vectors) in whole.entries.iter().zip(whole.vectors(&wanted).unwrap()) {
                let sfun = format!("{name}_{}sfun", entry.step.trim_end_matches("step"));
                let (given, said) = simulated(&bench, &sfun, &vectors.inputs);
                assert!(given == vectors.outputs, "{sfun}, single {single}");
                let direct = entry.step != "step" || model.linear().b()[0] != 0.0;
                let says = format!("Ts 0.00050000000000000001, feedthrough {}\n", i32::from(direct));
                assert_eq!(said, says, "{sfun}");
            }
        }
    }
}

#[test]
fn what_compiles_the_s_functions_asks_mex_for_each_and_can_put_them_into_a_model() {
    if !there_is("octave-cli") {
        return;
    }
    let bench = Bench::new();
    bench.write("m.json", MODEL);
    bench.write("mex.m", "function mex(varargin)\n    assert(exist(varargin{3}, 'file') == 2 && exist(varargin{4}, 'file') == 2);\nend\n");
    bench.write(
        "add_block.m",
        "function add_block(kind, place, varargin)\n    disp([place, ' is ', varargin{2}]);\nend\n",
    );
    bench.run("export --model m.json --target simulink --name bender --controller pi -o .").ok();
    let run = octave(&bench, "bender_build();\nbender_build('rig');\n").ok();
    run.prints(&["bender_sfun", "bender_control_sfun", "rig/bender_sfun is bender_sfun", "give it one of these names"]);
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
