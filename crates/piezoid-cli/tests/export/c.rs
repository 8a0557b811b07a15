//! C by two compilers, without and with optimisation, checked by sanitizers.

use crate::{exported, in_both_precisions, models, online_models, run, self_tested, there};
use piezoid_export::{ExportRequest, ExportTarget};

const STRICT: &str = "-std=c99 -pedantic -Wall -Wextra -Werror -Wconversion -Wshadow -ffp-contract=off";

#[test]
fn every_operator_gives_the_same_bits_from_both_compilers_at_any_level_and_no_sanitizer_speaks() {
    let folder = tempfile::tempdir().unwrap();
    let models = in_both_precisions(models());
    for (name, model, single) in &models {
        exported("c", &ExportRequest::new(model, name).single(*single), folder.path());
    }
    let names: Vec<String> = models.into_iter().map(|(name, ..)| name).collect();
    self_tested(folder.path(), &names, STRICT);
}

#[test]
fn the_estimator_gives_the_same_bits_from_both_compilers_at_any_level() {
    let folder = tempfile::tempdir().unwrap();
    let models = in_both_precisions(online_models());
    for (name, model, single) in &models {
        let mut request = ExportRequest::new(model, name).single(*single);
        request.options.online = true;
        let result = exported("c", &request, folder.path());
        assert!(result.functions.iter().any(|function| function.name == "online_step"), "{name}");
    }
    let names: Vec<String> = models.into_iter().map(|(name, ..)| name).collect();
    self_tested(folder.path(), &names, STRICT);
}

#[test]
fn single_precision_is_within_a_hundred_thousandth_of_the_stroke_and_feed_forwards_within_a_few_of_them() {
    for (name, model) in models() {
        let expected = ExportRequest::new(&model, &name).single(true);
        let whole = piezoid_export::ExportedProgram::new(&expected).unwrap();
        for entry in &whole.entries {
            let vectors = &entry.vectors;
            println!("{name} {}: {:.1e}", entry.step, vectors.off);
            // Operators that jump from branch to branch may do so one sample earlier or later.
            let jumps = ["two_branch", "rate_scheduled"].contains(&name.as_str());
            let within = if entry.step == "step" { 1e-5 } else { 1e-4 };
            assert!(
                vectors.off < within || (jumps && entry.step == "ff_step"),
                "{name} {}: {}",
                entry.step,
                vectors.off
            );
        }
    }
}

#[test]
fn a_header_may_be_read_by_cpp() {
    let (name, model) = models().swap_remove(0);
    if there("g++") {
        let folder = tempfile::tempdir().unwrap();
        exported("c", &ExportRequest::new(&model, &name), folder.path());
        run(folder.path(), &format!("g++ -std=c++11 -pedantic -Wall -Wextra -Werror -fsyntax-only -x c++ {name}.h"));
    }
}

#[test]
fn bounds_on_operations_hold_for_every_model_and_are_stated() {
    println!("| model | `step`, most seen | bound | `ff_step`, most seen | bound |\n|---|--:|--:|--:|--:|");
    for (name, model) in models() {
        let result = (ExportTarget::find("c").unwrap().make)(&ExportRequest::new(&model, &name).single(true)).unwrap();
        let page = String::from_utf8(result.files[3].bytes.clone()).unwrap();
        let mut row = format!("| {name} |");
        for f in &result.functions {
            assert!(f.most_seen <= f.bound && page.contains(&format!("| {} | {} |\n", f.most_seen, f.bound)), "{f:?}");
            row += &format!(" {} | {} |", f.most_seen, f.bound);
        }
        println!("{row}");
    }
}
