//! C in fixed point by two compilers: the same integers as computed here, for any input, without floating point.

use crate::{TS, WATCHED, exported, model, models, run, self_tested, there, together};
use piezoid::Model;
use piezoid::control::Pi;
use piezoid_export::{ExportRequest, ExportTarget};
use tempfile::TempDir;

const STRICT: &str = "-std=c99 -pedantic -Wall -Wextra -Werror -Wconversion -Wshadow";
const CORTEX_M0: &str = "arm-none-eabi-gcc -std=c99 -Wall -Wextra -Werror -O2 -mcpu=cortex-m0 -mthumb -mfloat-abi=soft";

/// Operators that cannot be exported in fixed point.
const REFUSED: &[&str] = &["preisach"];

/// A folder of all models that can be exported in fixed point, and their names.
fn all() -> (TempDir, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let models = models().into_iter().filter(|(name, _)| !REFUSED.contains(&name.as_str()));
    let export = |(name, model): (String, Model)| {
        exported("fixed", &ExportRequest::new(&model, &name), folder.path());
        name
    };
    let names = models.map(export).collect();
    (folder, names)
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

/// A function that passes arbitrary 32-bit numbers to the model.
fn wild(name: &str) -> String {
    format!(
        "#include \"{name}.h\"\nint {name}_part(void);\nint {name}_part(void)\n{{\n    {name}_state s;\n    uint32_t r = 1U;\n    {name}_reset(&s);\n    \
         for (int k = 0; k < 50000; k++) {{\n        r = (r * 1664525U) + 1013904223U;\n        \
         const int64_t u = (int64_t)r - 2147483648LL;\n        \
         (void){name}_step(&s, ((r >> 8) % 5U == 0U) ? INT32_MIN : (((r >> 8) % 5U == 1U) ? INT32_MAX : (int32_t)u));\n    \
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
    let allowed = ["__aeabi_lmul", "__aeabi_ldivmod", "__aeabi_uldivmod", "__aeabi_idiv", "memset", "memcpy"];
    for line in needs.lines() {
        let needed = line.split_whitespace().last().unwrap_or_default();
        assert!(allowed.contains(&needed), "{line}");
    }
}

#[test]
fn a_controller_counts_the_same_where_the_feed_forward_has_to_stay_behind() {
    let (model, pi) = (model("bouc-wen", None).unwrap(), Pi::new(TS, 0.05, 20.0, (-30.0, 30.0)).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let made =
        exported("fixed", &ExportRequest { controller: Some(&pi), ..ExportRequest::new(&model, "m") }, folder.path());
    assert!(made.notes.iter().any(|note| note.contains("no feed-forward")), "{:?}", made.notes);
    if there("gcc") {
        run(folder.path(), &format!("gcc {STRICT} m.c m_test.c -o self_test"));
        let said = run(folder.path(), "./self_test");
        assert!(said.contains("m_step: 0 of 400") && said.contains("m_control_step: 0 of 400"), "{said}");
    }
}

#[test]
fn what_cannot_be_counted_is_refused_with_the_reason() {
    for name in REFUSED {
        let model = model(name, None).unwrap();
        let error =
            (ExportTarget::find("fixed").unwrap().make)(&ExportRequest::new(&model, name)).unwrap_err().to_string();
        assert!(error.contains("compares with the largest floating-point number"), "{error}");
    }
}
