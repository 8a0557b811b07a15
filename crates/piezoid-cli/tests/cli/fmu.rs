//! FMUs in importers: FMPy validates, simulates and misuses them, and libcosim runs them; see `fmu.py`.

use crate::bench::{Bench, Run};
use piezoid::Model;
use piezoid::hysteresis::OPERATORS;
use piezoid::linear::Arx;
use piezoid_testing::skipped;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

const BOUC_WEN: &str = r#"{"piezoid": 1, "ts": 0.0005, "units": {"u": "V", "y": "um"},
    "hysteresis": {"operator": "bouc-wen", "range": [-30, 30], "beta": 0.02, "gamma_over_beta": 0.25, "weights": [1.4, 0.5]},
    "creep": [{"tau_s": 0.1, "gain": 0.01}, {"tau_s": 1, "gain": 0.01}],
    "linear": {"a": [1.7424, -0.9453], "b": [0.0, 3.0, 2.8]}, "offset": 2.0}"#;

const PLAYS: &str = r#"{"piezoid": 1, "ts": 0.001, "units": {"u": "V", "y": "<counts>"},
    "hysteresis": {"operator": "prandtl-ishlinskii", "range": [-30, 30],
    "thresholds": [1, 2, 3, 4, 5, 6, 7, 8, 9, 10], "weights": [0.7, 0.1, 0.09, 0.08, 0.07, 0.06, 0.05, 0.04, 0.03, 0.02, 0.01]},
    "creep": [], "linear": {"a": [1.6, -0.8], "b": [0.1, 0.1]}, "offset": -0.3}"#;

/// True if the program runs. If it does not, the test is reported as skipped, and fails in CI.
pub(crate) fn there(program: &str, arguments: &[&str], what: &str) -> bool {
    let found = Command::new(program).args(arguments).output().is_ok_and(|message| message.status.success());
    if !found {
        skipped(&format!("no {what}"));
    }
    found
}

pub(crate) fn fmpy() -> bool {
    there("python3", &["-c", "import fmpy, numpy"], "FMPy") && there("cc", &["--version"], "cc")
}

/// The end of the names of both versions.
const VERSIONS: [&str; 2] = ["fmi2", "fmi3"];

/// The files of [`exported`] without options, created once.
static EXPORTED: OnceLock<BTreeMap<String, Vec<u8>>> = OnceLock::new();

/// Writes a drive of 600 samples.
fn drive(bench: &Bench, ts: f64) {
    let row = |k: u32| {
        let t = f64::from(k);
        format!("{:?},{:?}\n", t * ts, 20.0 * (0.05 * t).sin() + 9.0 * (0.013 * t).cos())
    };
    bench.write("drive.csv", format!("t_s,u_V\n{}", (0..600).map(row).collect::<String>()));
}

/// Both models, their responses to a drive, and their FMUs of both versions: `<model>.csv`, `<model>_<version>.fmu`.
fn exported() -> Bench {
    let bench = Bench::new();
    for (name, bytes) in EXPORTED.get_or_init(|| exported_with("").files()) {
        std::fs::create_dir_all(bench.path(name).parent().unwrap()).unwrap();
        bench.write(name, bytes);
    }
    bench
}

fn exported_with(options: &str) -> Bench {
    let bench = Bench::new();
    for (name, model, ts) in [("bouc_wen", BOUC_WEN, 5e-4), ("plays", PLAYS, 1e-3)] {
        bench.write(&format!("{name}.json"), model);
        drive(&bench, ts);
        bench.run(&format!("simulate --model {name}.json --input drive.csv -o {name}.csv")).ok();
        for version in ["fmu2", "fmu3"] {
            bench
                .run(&format!(
                    "export --model {name}.json --target {version} --controller pi --name {name} {options} -o fmus"
                ))
                .ok();
        }
    }
    bench
}

/// Runs a check of `fmu.py` on the FMUs of both models.
fn holds(bench: &Bench, check: &str) {
    let fmus = VERSIONS.map(|v| ["bouc_wen", "plays"].map(|name| format!("fmus/{name}_{v}.fmu,{name}.csv")));
    python(bench, &format!("{check} {}", fmus.as_flattened().join(" "))).ok();
}

pub(crate) fn python(bench: &Bench, line: &str) -> Run {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/fmu.py");
    let mut python = Command::new("python3");
    python.current_dir(bench.path("")).arg(script).args(line.split_whitespace());
    Run::of(line, &python.output().unwrap())
}

/// The files in an FMU.
fn unpacked(fmu: &[u8]) -> BTreeMap<String, Vec<u8>> {
    let mut archive = zip::ZipArchive::new(Cursor::new(fmu)).unwrap();
    let file = |k| {
        let mut file = archive.by_index(k).unwrap();
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        (file.name().unwrap().into_owned(), bytes)
    };
    (0..zip::ZipArchive::new(Cursor::new(fmu)).unwrap().len()).map(file).collect()
}

/// Unpacks an FMU into a folder of the bench.
fn unpack(bench: &Bench, fmu: &str, folder: &str) {
    for (name, bytes) in unpacked(&bench.bytes(fmu)) {
        let path = bench.path(folder).join(&name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

#[test]
fn an_importer_finds_nothing_wrong_with_the_descriptions() {
    if fmpy() {
        let bench = exported();
        holds(&bench, "validates");
        python(&bench, "validates fmus/bouc_wen_control_fmi2.fmu fmus/plays_control_fmi3.fmu").ok();
    }
}

#[test]
fn an_importer_simulates_what_piezoid_simulates_bit_for_bit() {
    if fmpy() {
        holds(&exported(), "simulates");
    }
}

#[test]
fn every_operator_is_simulated_bit_for_bit() {
    if !fmpy() {
        return;
    }
    let bench = Bench::new();
    drive(&bench, 5e-4);
    let mut line = String::from("simulates");
    for (operator, version) in OPERATORS.iter().zip([2, 3].into_iter().cycle()) {
        let name = operator.name.replace('-', "_");
        let block = Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8]).unwrap();
        let model = Model::new((operator.example)(5e-4).unwrap(), block, 2.0).unwrap();
        bench.write(&format!("{name}.json"), model.to_json());
        bench.run(&format!("simulate --model {name}.json --input drive.csv -o {name}.csv")).ok();
        bench.run(&format!("export --model {name}.json --target fmu{version} --name {name} -o out")).ok();
        line += &format!(" out/{name}_fmi{version}.fmu,{name}.csv");
    }
    python(&bench, &line).ok();
}

#[test]
fn single_precision_stays_close() {
    if fmpy() {
        let bench = exported_with("--float");
        python(&bench, "simulates fmus/bouc_wen_fmi2.fmu,bouc_wen.csv,1e-5 fmus/plays_fmi3.fmu,plays.csv,1e-5").ok();
    }
}

#[test]
fn inputs_are_held_and_scaled_and_instances_know_nothing_of_each_other() {
    if fmpy() {
        holds(&exported(), "steps");
    }
}

#[test]
fn states_are_kept_brought_back_and_written_down() {
    if fmpy() {
        holds(&exported(), "states");
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_the_reason() {
    if fmpy() {
        holds(&exported(), "refusals");
    }
}

#[test]
fn an_importer_in_cpp_simulates_the_same_bits() {
    if fmpy() && there("python3", &["-c", "import libcosimpy"], "libcosimpy") {
        python(&exported(), "cosimulates fmus/bouc_wen_fmi2.fmu,bouc_wen.csv fmus/plays_fmi2.fmu,plays.csv").ok();
    }
}

#[test]
fn sources_compiled_by_hand_give_the_same_bits() {
    if !fmpy() {
        return;
    }
    let bench = exported();
    for (fmu, folder) in VERSIONS.map(|version| format!("plays_{version}")).iter().zip(["linux64", "x86_64-linux"]) {
        unpack(&bench, &format!("fmus/{fmu}.fmu"), "rebuilt");
        let library = bench.path("rebuilt/binaries").join(folder).join(format!("{fmu}.so"));
        std::fs::create_dir_all(library.parent().unwrap()).unwrap();
        let mut cc = Command::new("cc");
        cc.current_dir(bench.path("rebuilt/sources")).args([
            "-std=c99",
            "-O1",
            "-ffp-contract=off",
            "-fPIC",
            "-shared",
        ]);
        let message = cc.args(["plays.c", &format!("{fmu}_fmu.c"), "-o"]).arg(&library).output().unwrap();
        Run::of("cc", &message).ok();
        python(&bench, &format!("simulates {},plays.csv", bench.path("rebuilt").display())).ok();
        std::fs::remove_dir_all(bench.path("rebuilt")).unwrap();
    }
}

/// Strict compiler options.
const STRICT: &str = "-std=c99 -pedantic -Wall -Wextra -Wshadow -Wconversion -Werror -O1 -fPIC -shared -o library";

#[test]
fn the_sources_compile_without_a_warning_in_either_precision() {
    let compilers = ["gcc", "clang"].into_iter().filter(|cc| there(cc, &["--version"], cc)).collect::<Vec<_>>();
    for options in ["", "--float"] {
        let bench = exported_with(options);
        for fmu in bench.names().iter().filter_map(|name| name.strip_suffix(".fmu")) {
            unpack(&bench, &format!("{fmu}.fmu"), fmu);
            let sources = bench.path(fmu).join("sources");
            let paths = std::fs::read_dir(&sources).unwrap().map(|entry| entry.unwrap().path());
            let code: Vec<_> = paths.filter(|path| path.extension().is_some_and(|e| e == "c")).collect();
            assert_eq!(code.len(), 2, "{fmu}");
            for compiler in &compilers {
                let message = Command::new(compiler).current_dir(&sources).args(STRICT.split(' ')).args(&code).output();
                assert_eq!(Run::of(compiler, &message.unwrap()).ok().err, "", "{fmu} {options}");
            }
        }
    }
}

#[test]
fn calls_in_any_order_are_done_or_refused_as_the_standard_says_and_no_sanitizer_speaks() {
    let driver = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/fmu_calls.c");
    let compilers = [("gcc", ""), ("clang", ",float-cast-overflow")];
    let compilers: Vec<_> = compilers.into_iter().filter(|(name, _)| there(name, &["--version"], name)).collect();
    for (bench, kind) in
        [(exported(), "bouc_wen"), (exported(), "bouc_wen_control"), (exported_with("--float"), "bouc_wen")]
    {
        for (version, (compiler, more)) in VERSIONS.iter().flat_map(|v| compilers.iter().map(move |c| (v, c))) {
            unpack(&bench, &format!("fmus/{kind}_{version}.fmu"), version);
            let mut command = Command::new(compiler);
            command.current_dir(bench.path(version)).args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1"]).args([
                "-ffp-contract=off",
                "-fno-sanitize-recover=all",
                &format!("-fsanitize=address,undefined{more}"),
                &format!("-DVERSION={}", &version[3..]),
                &format!("-DWRAPPER=\"{kind}_{version}_fmu.c\""),
                "-Isources",
                "sources/bouc_wen.c",
                "-o",
                "calls",
                "-lm",
            ]);
            Run::of(compiler, &command.arg(&driver).output().unwrap()).ok();
            let message = Command::new(bench.path(version).join("calls")).output().unwrap();
            Run::of("calls", &message).ok().prints(&["500000 calls"]);
        }
    }
}

#[test]
fn several_fmus_fit_into_one_program() {
    if !there("cc", &["--version"], "cc") {
        return;
    }
    let bench = exported();
    let mut cc = Command::new("cc");
    cc.current_dir(bench.path("")).args(["-std=c99", "-ffp-contract=off", "main.c"]);
    for name in ["plays", "bouc_wen"] {
        unpack(&bench, &format!("fmus/{name}_fmi3.fmu"), name);
        let mut one = Command::new("cc");
        one.current_dir(bench.path(&format!("{name}/sources"))).args([
            "-std=c99",
            "-c",
            &format!("-DFMI3_FUNCTION_PREFIX={name}_"),
        ]);
        Run::of("cc", &one.args([format!("{name}.c"), format!("{name}_fmi3_fmu.c")]).output().unwrap()).ok();
        cc.args([format!("{name}/sources/{name}.o"), format!("{name}/sources/{name}_fmi3_fmu.o")]);
    }
    let main = "extern const char *plays_fmi3GetVersion(void);\nextern const char *bouc_wen_fmi3GetVersion(void);\n\
                int main(void)\n{\n    return plays_fmi3GetVersion()[0] - bouc_wen_fmi3GetVersion()[0];\n}\n";
    bench.write("main.c", main);
    Run::of("cc", &cc.args(["-o", "both"]).output().unwrap()).ok();
    assert!(Command::new(bench.path("both")).status().unwrap().success());
}

#[test]
fn the_same_model_gives_the_same_bytes() {
    let (one, two) = (exported(), exported_with(""));
    for fmu in ["fmus/bouc_wen_fmi2.fmu", "fmus/plays_fmi3.fmu"] {
        assert!(one.bytes(fmu) == two.bytes(fmu), "{fmu}");
        let text = String::from_utf8_lossy(&one.bytes(fmu)).into_owned();
        let folder = one.path("").display().to_string();
        assert!(!text.contains(&folder) && !text.contains("/tmp/"), "{fmu} holds a path");
    }
}

#[test]
fn without_a_compiler_the_sources_go_alone_and_a_note_says_so() {
    let bench = Bench::new();
    bench.write("m.json", BOUC_WEN);
    let mut command = bench.command("export --model m.json --target fmu2 --name alone -o out");
    let message = command.env("PATH", "").output().unwrap();
    Run::of("export", &message).ok().says(&["alone_fmi2.fmu contains sources only", "no C compiler"]);
    let inside = unpacked(&bench.bytes("out/alone_fmi2.fmu"));
    let names: Vec<&str> = inside.keys().map(String::as_str).collect();
    let sources = ["sources/alone.c", "sources/alone.h", "sources/alone_fmi2_fmu.c"];
    assert_eq!(names, [&["documentation/index.html", "modelDescription.xml"][..], &sources].concat());
}
