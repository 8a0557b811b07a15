//! C in fixed point by two compilers: the same integers as computed here, for any input, without floating point.

use crate::{TS, WATCHED, exported, model, models, run, self_tested, there, together};
use piezoid::Model;
use piezoid::compensation::FeedForwardSettings;
use piezoid::excitation::Limits;
use piezoid::hysteresis::Operator;
use piezoid::linear::Arx;
use piezoid_control::feedback::Pi;
use piezoid_export::{ExportRequest, ExportTarget, Exported};
use piezoid_testing::in_feedback;
use piezoid_verbs::File;
use std::sync::LazyLock;
use tempfile::TempDir;

const STRICT: &str = "-std=c99 -pedantic -Wall -Wextra -Werror -Wconversion -Wshadow";
const CORTEX_M0: &str = "arm-none-eabi-gcc -std=c99 -Wall -Wextra -Werror -O2 -mcpu=cortex-m0 -mthumb -mfloat-abi=soft";

/// All models in fixed point, by name.
static ALL: LazyLock<Vec<(String, Exported)>> = LazyLock::new(|| {
    let fixed = ExportTarget::find("fixed").unwrap();
    let make = |(name, model): (String, Model)| {
        let result = (fixed.make)(&limited(&model, &name)).unwrap();
        (name, result)
    };
    models().into_iter().map(make).collect()
});

/// A request with limits, because a model without a range has a feed-forward only within limits.
fn limited<'m>(model: &'m Model, name: &str) -> ExportRequest<'m> {
    let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Limits::default() };
    let settings = FeedForwardSettings { limits, ..FeedForwardSettings::default() };
    ExportRequest { settings, ..ExportRequest::new(model, name) }
}

/// A folder of all models in fixed point, and their names.
fn all() -> (TempDir, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    for File { name, bytes } in ALL.iter().flat_map(|(_, result)| &result.files) {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    (folder, ALL.iter().map(|(name, _)| name.clone()).collect())
}

#[test]
fn every_operator_has_a_model_and_a_feed_forward_within_a_millionth_of_the_stroke() {
    println!("| model | function | error, rms | largest | operations, most seen | bound |\n|---|---|--:|--:|--:|--:|");
    for (name, result) in ALL.iter() {
        let is_in_feedback = in_feedback().iter().any(|(known, _)| known == name);
        // That a band-limited input moves along straight lines.
        assert!(result.notes.len() <= usize::from(name == "filtered"), "{name}: {:?}", result.notes);
        let header = String::from_utf8(result.files[0].bytes.clone()).unwrap();
        // A mode adds up the roundings of 20 steps a sample, and its inverse differentiates the reference twice.
        let most = match (is_in_feedback, name == "driven_plays") {
            (true, _) => [1e-5, 1e-5],
            (_, driven) => [5e-7, if driven { 5e-6 } else { 1e-6 }],
        };
        for (k, (step, most)) in ["step", "ff_step"].into_iter().zip(most).enumerate() {
            let line = header.lines().find_map(|line| line.trim().strip_prefix(&format!("{step} has an error of ")));
            let words: Vec<&str> = line.unwrap().split_whitespace().collect();
            let (rms, largest) = (words[0], words[6]);
            let f = &result.functions[k];
            println!("| {name} | `{step}` | {rms} | {largest} | {} | {} |", f.most_seen, f.bound);
            // Bisection evaluates the law 33 times, whatever the reference.
            assert!(f.name == step && f.bound < 40 * result.functions[0].bound, "{name}: {f:?}");
            assert!(largest.parse::<f64>().unwrap() <= most, "{name}: {line:?}");
        }
    }
}

#[test]
fn every_operator_counts_the_same_from_both_compilers_at_any_level_and_no_sanitizer_speaks() {
    let (folder, names) = all();
    self_tested(folder.path(), &names, STRICT);
    if there("gcc") {
        // With inputs over the full range of 32 bits, nothing overflows.
        let files = together(folder.path(), &names, wild);
        run(folder.path(), &format!("gcc {STRICT} -O1 {WATCHED} {files} -o wild"));
        run(folder.path(), "./wild");
    }
}

/// A function that passes arbitrary 32-bit numbers to the model and to its feed-forward.
fn wild(name: &str) -> String {
    format!(
        "#include \"{name}.h\"\nint {name}_part(void);\nint {name}_part(void)\n{{\n    {name}_state s;\n    {name}_ff_state f;\n    uint32_t r = 1U;\n    \
         {name}_reset(&s);\n    {name}_ff_reset(&f);\n    \
         for (int k = 0; k < 50000; k++) {{\n        r = (r * 1664525U) + 1013904223U;\n        \
         const int64_t any = (int64_t)r - 2147483648LL;\n        \
         const int32_t u = ((r >> 8) % 5U == 0U) ? INT32_MIN : (((r >> 8) % 5U == 1U) ? INT32_MAX : (int32_t)any);\n        \
         (void){name}_step(&s, u);\n        if (k % 100 == 0) {{ (void){name}_ff_step(&f, u); }}\n    \
         }}\n    return 0;\n}}\n"
    )
}

#[test]
fn a_core_without_floating_point_needs_nothing_but_whole_numbers() {
    if !there("arm-none-eabi-gcc") {
        return;
    }
    let (folder, names) = all();
    let files = |ending: &str| names.iter().map(|name| format!(" {name}.{ending}")).collect::<String>();
    run(folder.path(), &format!("{CORTEX_M0} -c{}", files("c")));
    let needs = run(folder.path(), &format!("arm-none-eabi-nm --undefined-only --print-file-name{}", files("o")));
    let allowed =
        ["__aeabi_lmul", "__aeabi_ldivmod", "__aeabi_uldivmod", "__aeabi_idiv", "memset", "memcpy", "memmove"];
    for line in needs.lines() {
        let needed = line.split_whitespace().last().unwrap_or_default();
        assert!(allowed.contains(&needed), "{line}");
    }
}

#[test]
fn a_controller_counts_the_same() {
    let (model, pi) = (model("bouc-wen", None).unwrap(), Pi::new(TS, 0.05, 20.0, (-30.0, 30.0)).unwrap());
    let folder = tempfile::tempdir().unwrap();
    exported("fixed", &ExportRequest { controller: Some(&pi), ..ExportRequest::new(&model, "m") }, folder.path());
    if there("gcc") {
        run(folder.path(), &format!("gcc {STRICT} m.c m_test.c -o self_test"));
        let text = run(folder.path(), "./self_test");
        for step in ["step", "ff_step", "control_step"] {
            assert!(text.contains(&format!("m_{step}: 0 of 400")), "{text}");
        }
    }
}

#[test]
fn a_model_that_32_bits_do_not_hold_is_refused_with_its_error() {
    let law = (Operator::find("stop").unwrap().example)(TS).unwrap();
    let far = Model::new(law, Arx::gain(TS, 1.0).unwrap(), 1e9).unwrap();
    let error = (ExportTarget::find("fixed").unwrap().make)(&ExportRequest::new(&far, "m")).unwrap_err().to_string();
    assert!(
        error.contains("32-bit rounding changes the result of `step` by") && error.contains("use the target `c`"),
        "{error}"
    );
}
