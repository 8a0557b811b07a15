//! C under stress: NaN, infinities, numbers that no sensor gives, states saved and reset in the middle; then the same
//! from a compiler that assumes that all numbers are finite.

use crate::{TS, WATCHED, exported, model, models, run, there, together};
use piezoid::compensation::FeedForwardSettings;
use piezoid::control::{CONTROLLERS, MarginTarget, Scheme, TunedScheme};
use piezoid::excitation::Limits;
use piezoid::linear::Arx;
use piezoid_export::{ExportRequest, ExportedProgram};
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

const STRICT: &str = "-std=c99 -pedantic -Wall -Wextra -Werror -Wno-unused-function";

/// The largest input that the model takes.
fn farthest(whole: &ExportedProgram) -> f64 {
    let constants = &whole.program.block("state").unwrap().constants;
    constants.iter().find(|constant| constant.name == "farthest").unwrap().values[0]
}

/// The part of one model: each of its functions under stress.
fn part(name: &str, single: bool, whole: &ExportedProgram) -> String {
    let (number, largest) = if single { ("float", "FLT_MAX") } else { ("double", "DBL_MAX") };
    let mut text =
        format!("#define main {name}_self_test\n#include \"{name}_test.c\"\n#undef main\n#define NUMBER {number}\n");
    text += &format!("#define LARGEST ((double){largest})\n");
    let mut calls = String::new();
    for entry in &whole.entries {
        let (step, kind) = (entry.step, entry.kind());
        let own = if kind.is_empty() { name.to_string() } else { format!("{name}_{kind}") };
        let inputs: String = entry.inputs.iter().map(|i| format!(", wild({step}_{}[k])", i.name)).collect();
        let farthest = match step {
            "step" => format!("((double)({number}){:?})", farthest(whole)),
            _ => "0.0".into(),
        };
        let again = if step == "step" { format!("{name}_step(s, u)") } else { "(u)".into() };
        for (what, value) in [
            ("ENTRY", step.to_string()),
            ("NAME", format!("\"{name} {step}\"")),
            ("STATE", format!("{name}_{}", entry.state)),
            ("RESET", format!("{name}_{}", entry.reset)),
            ("SAVE", format!("{own}_save")),
            ("RESTORE", format!("{own}_restore")),
            ("SAVED", format!("{}_SAVED", own.to_uppercase())),
            ("SAMPLES", entry.vectors.outputs.len().to_string()),
            ("GIVES", format!("{step}_gives")),
            ("CALL(s, k)", format!("{name}_{step}(s{inputs})")),
            ("STEP(s, u)", again),
            ("ROUNDS", if step == "ff_step" { "6" } else { "20" }.into()),
            ("FARTHEST", farthest),
        ] {
            let macro_name = what.split('(').next().unwrap();
            text += &format!("#undef {macro_name}\n#define {what} {value}\n");
        }
        text += "#include \"stress.h\"\n";
        calls += &format!("    failed += {step}_stressed();\n");
    }
    text + &format!(
        "int {name}_part(void);\nint {name}_part(void)\n{{\n    int failed = 0;\n{calls}    return failed;\n}}\n"
    )
}

/// A program of these models (in single and double precision by turns), controllers and estimators.
struct Program {
    folder: TempDir,
    names: Vec<String>,
    files: String,
}

fn program(kept: fn(&str) -> bool) -> Program {
    let folder = tempfile::tempdir().unwrap();
    let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Limits::default() };
    let settings = FeedForwardSettings { limits, ..FeedForwardSettings::default() };
    let mut parts = Vec::new();
    let mut add = |name: String, request: &ExportRequest| {
        if !kept(&name) {
            return;
        }
        exported("c", request, folder.path());
        let text = part(&name, request.options.float, &ExportedProgram::new(request).unwrap());
        parts.push((name, text));
    };
    // Slow zeros, which a recursion inverts.
    let slow = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 60.0, -112.0, 58.0]).unwrap();
    let recursive = ("recursive".to_string(), model("stop", None).unwrap().with_linear(slow).unwrap());
    for (k, (name, model)) in models().into_iter().chain([recursive]).enumerate() {
        add(name.clone(), &ExportRequest::new(&model, &name).single(k % 2 == 1));
    }
    let plays = model("prandtl-ishlinskii", None).unwrap();
    for (k, law) in CONTROLLERS.iter().filter(|law| law.uses_feed_forward).enumerate() {
        let name = format!("with_{}", law.name.replace('-', "_"));
        if !kept(&name) {
            continue;
        }
        let scheme = Scheme { law: Some(law), ..Scheme::named("gain").unwrap() };
        let tuned = TunedScheme::new(scheme, &plays, settings, 0, &MarginTarget::default()).unwrap();
        let controller = Some(tuned.controller());
        add(
            name.clone(),
            &ExportRequest { controller, settings, ..ExportRequest::new(&plays, &name).single(k % 2 == 0) },
        );
    }
    let mut online = ExportRequest::new(&plays, "estimator").single(true);
    online.options.online = true;
    add("estimator".into(), &online);
    let names: Vec<String> = parts.iter().map(|(name, _)| name.clone()).collect();
    let text = |name: &str| parts.iter().find(|(other, _)| other == name).unwrap().1.clone();
    let files = together(folder.path(), &names, text);
    Program { folder, names, files }
}

/// Where `stress.h` is.
fn include() -> String {
    format!("-I {}", Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export/stress").display())
}

/// What the program says of a function.
#[derive(Debug)]
struct Stressed {
    /// Model and function.
    name: String,
    /// Results that are not finite, that are not those of a held input, of a restored state, and after a reset.
    wrong: [usize; 4],
    /// The largest difference after a reset, over the stroke.
    off: f64,
    /// The largest difference to usual results, after usual inputs have come for a while, over the stroke.
    left: f64,
}

fn stressed(text: &str) -> Vec<Stressed> {
    let row = |line: &str| {
        let words: Vec<&str> = line.strip_prefix("stressed ")?.split(' ').collect();
        let wrong = [2, 3, 4, 5].map(|k| words[k].parse().unwrap());
        let name = format!("{} {}", words[0], words[1]);
        Some(Stressed { name, wrong, off: words[6].parse().unwrap(), left: words[7].parse().unwrap() })
    };
    text.lines().filter_map(row).collect()
}

#[test]
fn no_input_makes_any_output_infinite_or_is_remembered_for_ever_and_no_sanitizer_speaks() {
    if !there("clang") {
        return;
    }
    let Program { folder, names, files } = program(|_| true);
    let watched = format!("{WATCHED} -fsanitize=float-cast-overflow -fno-sanitize-recover=all");
    let build = format!("clang {STRICT} -O1 -ffp-contract=off {watched} {} {files} -o stress -lm", include());
    run(folder.path(), &build);
    let rows = stressed(&run(folder.path(), "./stress"));
    assert!(rows.len() > names.len());
    for Stressed { name, left, .. } in rows {
        let most = match &*name {
            // Without a known range creep takes up what comes, and gives it back over many seconds.
            "proportional step" => continue,
            // The energy that they have lost has changed them for good.
            "bouc_wen_baber_noori step" | "bouc_wen_baber_noori ff_step" => 0.05,
            // Integrals wait for the loop to be closed, parameters for the next readings.
            name if name.ends_with("control_step") || name.ends_with("online_step") => 0.5,
            _ => 3e-3,
        };
        assert!(left < most, "{name}: {left}");
    }
}

#[test]
fn with_fast_math_outputs_stay_finite_and_inputs_are_held_though_last_digits_change() {
    let Program { folder, names, files } = program(|name| {
        ["two_branch", "prandtl_ishlinskii", "preisach", "bouc_wen", "dahl", "with_pid", "estimator"].contains(&name)
    });
    let listed = |of: &dyn Fn(&&str) -> bool| files.split(' ').filter(of).map(|f| format!(" {f}")).collect::<String>();
    let parts = listed(&|file| file.ends_with("_part.c") || *file == "all.c");
    let own: String = names.iter().map(|name| format!(" {name}.c")).collect();
    println!(
        "| compiler | function | bits differ | most [stroke] | not finite | not held | NaN restored | left [stroke] |"
    );
    for compiler in ["gcc", "clang"].into_iter().filter(|compiler| there(compiler)) {
        run(folder.path(), &format!("{compiler} {STRICT} -O3 -ffast-math -c{own}"));
        run(folder.path(), &format!("{compiler} {STRICT} -O0 -ffp-contract=off {} -c{parts}", include()));
        let objects = format!("{own}{parts}").replace(".c", ".o");
        run(folder.path(), &format!("{compiler} -ffast-math{objects} -o fast -lm"));
        let output = Command::new("./fast").current_dir(folder.path()).output().unwrap();
        let rows = stressed(&String::from_utf8(output.stdout).unwrap());
        assert!(rows.len() > names.len());
        for Stressed { name, wrong: [infinite, held, refused, bits], off, left } in rows {
            println!("| {compiler} | {name} | {bits} | {off:.0e} | {infinite} | {held} | {refused} | {left:.0e} |");
            assert!(infinite == 0 && held == 0, "{compiler}, {name}: {infinite} not finite, {held} not held");
        }
    }
}
