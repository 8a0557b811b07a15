//! The class in GNU Octave, and the S-functions with a stand-in for Simulink.

use crate::{TS, exported, in_both_precisions, model, models, run, there};
use piezoid::Model;
use piezoid::hysteresis::Operator;
use piezoid::linear::Arx;
use piezoid::record::Units;
use piezoid_control::feedback::Pi;
use piezoid_export::{ExportRequest, ExportTarget, ExportedProgram};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// A controller to be exported with the model.
fn controller() -> Pi {
    Pi::new(TS, 0.05, 20.0, (-30.0, 30.0)).unwrap()
}

/// A model with feed-through.
fn direct() -> (String, Model) {
    let plays = (Operator::find("prandtl-ishlinskii").unwrap().example)(TS).unwrap();
    let block = Arx::new(TS, vec![0.6], vec![0.3, 0.2]).unwrap();
    ("direct".into(), Model::new(plays, block, 2.0).unwrap())
}

/// A model with a resonance and creep, one with a driver, one with feed-through, and one with hysteresis in feedback,
/// each in both precisions.
fn kinds() -> Vec<(String, Model, bool)> {
    let kinds = ["bouc_wen", "driven_plays", "direct", "bender"];
    let models = models().into_iter().chain([direct()]).filter(|(name, _)| kinds.contains(&name.as_str()));
    in_both_precisions(models)
}

/// Runs a script. Returns its output, without the exit message of Octave 7, and true if it succeeded.
fn octave(folder: &Path, script: &str) -> (String, bool) {
    std::fs::write(folder.join("script.m"), script).unwrap();
    let mut command = Command::new("octave-cli");
    let output = command.args(["--quiet", "--no-init-file", "script.m"]).current_dir(folder).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    let text = text.lines().filter(|line| !line.contains("preparing to exit")).map(|line| format!("{line}\n"));
    (String::from_utf8_lossy(&output.stdout).into_owned() + &text.collect::<String>(), output.status.success())
}

#[test]
fn in_octave_the_class_gives_the_same_bits_for_every_operator_and_in_either_precision() {
    if !there("octave-cli") {
        return;
    }
    let (controller, folder) = (controller(), tempfile::tempdir().unwrap());
    let (mut script, mut expected) = (String::new(), String::new());
    let every = models().into_iter().chain([direct()]).map(|(name, model)| (name, model, false));
    for (name, model, single) in every.chain(kinds().into_iter().filter(|(.., single)| *single)) {
        let target =
            ExportRequest { controller: Some(&controller), ..ExportRequest::new(&model, &name).single(single) };
        exported("simulink", &target, folder.path());
        script += &format!("{name}_test();\n");
        for entry in ExportedProgram::new(&target).unwrap().entries {
            let (prefix, unit) = (entry.step.trim_end_matches("step"), &entry.output.unit);
            for (what, n) in [("simulate", 400), ("simulate of a row", 9), ("step", 40)] {
                expected += &format!("{name}, {prefix}{what}: 0 of {n} differ, by 0 {unit} at most\n");
            }
        }
    }
    assert_eq!(octave(folder.path(), &script), (expected, true));
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
    let (text, well) = octave(folder.path(), "bender_test();\n");
    assert!(!well && text.contains("error: the results differ from those of piezoid"), "{text}");
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
            held = bender();
            held.reset();
            other.reset();
            held.step(3);
            other.step(3);
            for v = [NaN, Inf, -1e300]
                assert(isequal(other.step(v), held.step(3)));
            end
            assert(isequal(other.state, held.state));
            model.step([1, 2]);\n"
        );
        let (text, well) = octave(folder.path(), &script);
        let refused = text.starts_with("error: step takes one sample: simulate takes a row or column\n");
        assert!(!well && refused, "{text}");
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
    let (text, well) = octave(folder.path(), script);
    assert!(well, "{text}");
}

#[test]
fn the_s_functions_are_handed_to_mex_one_by_one_and_put_into_a_model_if_asked() {
    if !there("octave-cli") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (model, controller) = (model("bouc-wen", None).unwrap(), controller());
    let target = ExportRequest { controller: Some(&controller), ..ExportRequest::new(&model, "bender") };
    exported("simulink", &target, folder.path());
    let mex = "function mex(varargin)\n    assert(cellfun(@(f) exist(f, 'file'), varargin(3:4)), [2, 2]);\nend\n";
    std::fs::write(folder.path().join("mex.m"), mex).unwrap();
    let add = "function add_block(kind, place, varargin)\n    disp([place, ' is ', varargin{2}]);\nend\n";
    std::fs::write(folder.path().join("add_block.m"), add).unwrap();
    let (text, well) = octave(folder.path(), "bender_build();\nbender_build('rig');\n");
    assert!(well, "{text}");
    for part in
        ["Compiled: bender_sfun, ", "give it one of these names", "rig/bender_control_sfun is bender_control_sfun"]
    {
        assert!(text.contains(part), "{text}");
    }
}

/// Runs an S-function with the stand-in on `inputs`. Returns the outputs, and the properties that it reports.
fn simulated(engine: &Path, sfun: &str, inputs: &[Vec<f64>]) -> (Vec<f64>, String) {
    let mut engine = Command::new(engine);
    let mut child =
        engine.arg(sfun).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let bytes: Vec<u8> = inputs.iter().flatten().flat_map(|v| v.to_ne_bytes()).collect();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{sfun}: {text}");
    (output.stdout.chunks_exact(8).map(|v| f64::from_ne_bytes(v.try_into().unwrap())).collect(), text)
}

#[test]
fn behind_a_stand_in_for_simulink_every_s_function_gives_the_same_numbers_in_every_block() {
    if !there("gcc") {
        return;
    }
    let (controller, folder) = (controller(), tempfile::tempdir().unwrap());
    let (mut files, mut bare, mut listed, mut expected) = (String::new(), String::new(), String::new(), Vec::new());
    for (name, model, single) in kinds() {
        let target =
            ExportRequest { controller: Some(&controller), ..ExportRequest::new(&model, &name).single(single) };
        exported("simulink", &target, folder.path());
        files += &format!(" {name}.c");
        for entry in ExportedProgram::new(&target).unwrap().entries {
            let sfun = format!("{name}_{}sfun", entry.step.trim_end_matches("step"));
            let part = format!("#define s_function {sfun}_methods\n#include \"{sfun}.c\"\n");
            std::fs::write(folder.path().join(format!("{sfun}_part.c")), part).unwrap();
            files += &format!(" {sfun}_part.c");
            bare += &format!(" {sfun}.c");
            listed += &format!("S_FUNCTION({sfun})\n");
            let direct = entry.step != "step" || name.starts_with("direct");
            let says = format!("Ts 0.00050000000000000001, feedthrough {}\n", i32::from(direct));
            expected.push((sfun, entry.vectors, says));
        }
    }
    std::fs::write(folder.path().join("all.h"), listed).unwrap();
    let stand_in = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export/simulink");
    let stand_in = stand_in.to_str().unwrap();
    let gcc = format!(
        "gcc -std=c99 -pedantic -Wall -Wextra -Wconversion -Wshadow -Werror -ffp-contract=off -fsanitize=address,undefined \
         -I . -I {stand_in}"
    );
    // Compiled without `MATLAB_MEX_FILE`, as Simulink Coder does.
    run(folder.path(), &format!("{gcc} -c{bare}"));
    run(folder.path(), &format!("{gcc} -DMATLAB_MEX_FILE{files} {stand_in}/engine.c -o engine"));
    for (sfun, vectors, says) in expected {
        let (input, text) = simulated(&folder.path().join("engine"), &sfun, &vectors.inputs);
        assert!(input == vectors.outputs, "{sfun}");
        assert_eq!(text, says, "{sfun}");
    }
}

#[test]
fn names_that_matlab_or_octave_has_taken_are_refused() {
    let model = model("bouc-wen", None).unwrap();
    for (name, says) in [
        ("end", "is a reserved word"),
        ("zeros", "is a reserved word"),
        ("Simulate", "is a reserved word"),
        ("2fast", "must begin with a letter"),
        ("an_actuator_of_forty_one_characters_a_name", "must begin with a letter"),
    ] {
        let error =
            (ExportTarget::find("simulink").unwrap().make)(&ExportRequest::new(&model, name)).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(says), "{error}");
    }
}
