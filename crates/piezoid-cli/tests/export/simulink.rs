//! The class in GNU Octave, and the S-functions behind a stand-in for Simulink.

use crate::{TS, exported, model, models, run, there};
use piezoid::Model;
use piezoid::control::Pi;
use piezoid::linear::Arx;
use piezoid::record::Units;
use piezoid_export::{ExportRequest, ExportedProgram, target};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// A controller to go along.
fn controller() -> Pi {
    Pi::new(TS, 0.05, 20.0, (-30.0, 30.0)).unwrap()
}

/// A model with a resonance and creep, one of them behind a driver, and one that answers in the same sample.
fn kinds() -> Vec<(String, Model)> {
    let mut kinds = models();
    kinds.retain(|(name, _)| ["bouc_wen", "driven_plays"].contains(&name.as_str()));
    let plays = (piezoid::hysteresis::Operator::find("prandtl-ishlinskii").unwrap().example)(TS).unwrap();
    let direct = Model::new(plays, Arx::new(TS, vec![0.6], vec![0.3, 0.2]).unwrap(), 2.0).unwrap();
    kinds.push(("direct".into(), direct));
    kinds
}

/// Runs a script; what it prints and whether it ends well. What Octave 7 says of itself when it ends is left out.
fn octave(folder: &Path, script: &str) -> (String, bool) {
    std::fs::write(folder.join("script.m"), script).unwrap();
    let mut command = Command::new("octave-cli");
    let output = command.args(["--quiet", "--no-init-file", "script.m"]).current_dir(folder).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    let said = said.lines().filter(|line| !line.contains("preparing to exit")).map(|line| format!("{line}\n"));
    (String::from_utf8_lossy(&output.stdout).into_owned() + &said.collect::<String>(), output.status.success())
}

#[test]
fn in_octave_the_class_gives_the_same_bits_for_every_operator_and_in_either_precision() {
    if !there("octave-cli") {
        return;
    }
    let controller = controller();
    for (models, single) in [(models(), false), (kinds(), false), (kinds(), true)] {
        let folder = tempfile::tempdir().unwrap();
        let (mut script, mut expected) = (String::new(), String::new());
        for (name, model) in &models {
            let wanted =
                ExportRequest { controller: Some(&controller), ..ExportRequest::new(model, name).single(single) };
            exported("simulink", &wanted, folder.path());
            script += &format!("{name}_test();\n");
            for entry in ExportedProgram::new(&wanted).unwrap().entries {
                let (prefix, unit) = (entry.step.trim_end_matches("step"), &entry.output.unit);
                for (what, n) in [("simulate", 400), ("simulate of a row", 9), ("step", 40)] {
                    expected += &format!("{name}, {prefix}{what}: 0 of {n} differ, by 0 {unit} at most\n");
                }
            }
        }
        assert_eq!(octave(folder.path(), &script), (expected, true), "single {single}");
    }
}

#[test]
fn a_class_that_gives_other_numbers_fails_its_test() {
    if !there("octave-cli") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    exported("simulink", &ExportRequest::new(&model("bouc-wen", None).unwrap(), "bender"), folder.path());
    let class = std::fs::read_to_string(folder.path().join("bender.m")).unwrap();
    let changed = class.replace("1.7424;", "1.7424000000000002;");
    assert_ne!(changed, class);
    std::fs::write(folder.path().join("bender.m"), changed).unwrap();
    let (said, well) = octave(folder.path(), "bender_test();\n");
    assert!(!well && said.contains("error: other numbers than those of piezoid"), "{said}");
}

#[test]
fn the_example_of_the_help_runs_and_signals_keep_their_shape() {
    if !there("octave-cli") {
        return;
    }
    let model = model("bouc-wen", None).unwrap();
    for (single, class) in [(false, "double"), (true, "single")] {
        let folder = tempfile::tempdir().unwrap();
        exported("simulink", &ExportRequest::new(&model, "bender").single(single), folder.path());
        let help = std::fs::read_to_string(folder.path().join("bender.m")).unwrap();
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
            assert(bender.Ts, 5e-4);
            other = bender();
            other.step(20);
            assert(~isequal(other.state, bender().state));
            other.reset();
            assert(isequal(other.state, bender().state) && ~isequal(other.state, model.state));
            model.step([1, 2]);\n"
        );
        let (said, well) = octave(folder.path(), &script);
        let refused = said.starts_with("error: step takes one sample: simulate takes a row or column\n");
        assert!(!well && refused, "{said}");
    }
}

#[test]
fn units_of_any_text_stay_text() {
    if !there("octave-cli") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let units = Units { u: "V".into(), y: "it's % */ \"um\" error('no')".into() };
    let model = model("bouc-wen", None).unwrap().with_units(units);
    exported("simulink", &ExportRequest::new(&model, "bender"), folder.path());
    let script = "bender_test();\nassert(bender().units.y, 'it''s % */ \"um\" error(''no'')');\n";
    let (said, well) = octave(folder.path(), script);
    assert!(well, "{said}");
}

#[test]
fn the_s_functions_are_handed_to_mex_one_by_one_and_put_into_a_model_if_asked() {
    if !there("octave-cli") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (model, controller) = (model("bouc-wen", None).unwrap(), controller());
    let wanted = ExportRequest { controller: Some(&controller), ..ExportRequest::new(&model, "bender") };
    exported("simulink", &wanted, folder.path());
    let mex = "function mex(varargin)\n    assert(cellfun(@(f) exist(f, 'file'), varargin(3:4)), [2, 2]);\nend\n";
    std::fs::write(folder.path().join("mex.m"), mex).unwrap();
    let add = "function add_block(kind, place, varargin)\n    disp([place, ' is ', varargin{2}]);\nend\n";
    std::fs::write(folder.path().join("add_block.m"), add).unwrap();
    let (said, well) = octave(folder.path(), "bender_build();\nbender_build('rig');\n");
    assert!(well, "{said}");
    for part in
        ["Compiled: bender_sfun, ", "give it one of these names", "rig/bender_control_sfun is bender_control_sfun"]
    {
        assert!(said.contains(part), "{said}");
    }
}

/// Compiles an S-function behind the stand-in and runs it on `inputs`: the outputs, and what it says of itself.
fn simulated(folder: &Path, name: &str, sfun: &str, inputs: &[Vec<f64>]) -> (Vec<f64>, String) {
    let stand_in = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export/simulink");
    let stand_in = stand_in.to_str().unwrap();
    let gcc = "gcc -std=c99 -pedantic -Wall -Wextra -Wconversion -Wshadow -Werror -ffp-contract=off -fsanitize=address,undefined";
    run(folder, &format!("{gcc} -I {stand_in} -c {sfun}.c -o as_for_simulink_coder.o"));
    run(folder, &format!("{gcc} -I {stand_in} -DMATLAB_MEX_FILE {sfun}.c {name}.c {stand_in}/engine.c -o {sfun}"));
    let mut engine = Command::new(folder.join(sfun));
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
    if !there("gcc") {
        return;
    }
    let controller = controller();
    for (name, model) in kinds() {
        for single in [false, true] {
            let folder = tempfile::tempdir().unwrap();
            let wanted =
                ExportRequest { controller: Some(&controller), ..ExportRequest::new(&model, &name).single(single) };
            exported("simulink", &wanted, folder.path());
            let whole = ExportedProgram::new(&wanted).unwrap();
            for entry in &whole.entries {
                let vectors = &entry.vectors;
                let sfun = format!("{name}_{}sfun", entry.step.trim_end_matches("step"));
                let (given, said) = simulated(folder.path(), &name, &sfun, &vectors.inputs);
                assert!(given == vectors.outputs, "{sfun}, single {single}");
                let direct = entry.step != "step" || name == "direct";
                let expected = format!("Ts 0.00050000000000000001, feedthrough {}\n", i32::from(direct));
                assert_eq!(said, expected, "{sfun}");
            }
        }
    }
}

#[test]
fn names_that_matlab_or_octave_has_taken_are_refused() {
    let model = model("bouc-wen", None).unwrap();
    for (name, says) in [
        ("end", "is a word of the language"),
        ("zeros", "is a word of the language"),
        ("Simulate", "is a word of the language"),
        ("2fast", "must be a letter"),
        ("an_actuator_of_forty_one_characters_a_name", "must be a letter"),
    ] {
        let error = (target("simulink").unwrap().make)(&ExportRequest::new(&model, name)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(says), "{error}");
    }
}
