//! C on an emulated Cortex-M4F: bit-identical to this machine, and the number of instructions per step.

use crate::{TS, exported, models, online_models, run, there, together};
use piezoid::Model;
use piezoid::hysteresis::Operator;
use piezoid::linear::Arx;
use piezoid_export::{ExportRequest, ExportedProgram};
use piezoid_models::hysteresis::BasisDesign;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

const BUILD: &str = "arm-none-eabi-gcc -std=c99 -Wall -Wextra -Werror -O2 -ffp-contract=off -mcpu=cortex-m4 -mthumb -mfloat-abi=hard \
                     -mfpu=fpv4-sp-d16 -nostartfiles --specs=rdimon.specs";

/// An instruction takes 64 ns, a tick of SysTick 40 ns.
const BOARD: &str = "qemu-system-arm -M mps2-an386 -nographic -monitor none -serial none \
                     -semihosting-config enable=on,target=native -icount shift=6 -kernel firmware.elf";

/// Computing time of an entry [instructions].
#[derive(Debug)]
struct Taken {
    model: String,
    step: String,
    mean: f64,
    most: f64,
    /// The same of samples in any order, a quarter of them eight times as large.
    adverse: f64,
    /// Bound on the operations.
    bound: usize,
    /// Code and constants [bytes].
    flash: usize,
}

/// One firmware of all models: it runs the self-tests on the board, and measures the steps of each entry.
static ON_THE_BOARD: LazyLock<Vec<Taken>> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let mut models: BTreeMap<String, Model> = models().into_iter().collect();
    models.insert("papers".into(), papers_model());
    models.insert("fifteen".into(), fifteen_plays());
    models.extend(online_models().into_iter().map(|(name, model)| (format!("online_{name}"), model)));
    let names: Vec<String> = models.keys().cloned().collect();
    let bounds = std::cell::RefCell::new(BTreeMap::new());
    let files = together(folder.path(), &names, |name| {
        let mut expected = ExportRequest::new(&models[name], name).single(true);
        expected.options.online = name.starts_with("online_");
        let result = exported("c", &expected, folder.path());
        let stated = result.functions.iter().map(|f| ((name.to_string(), f.name.to_string()), f.bound));
        bounds.borrow_mut().extend(stated);
        counting(name, &ExportedProgram::new(&expected).unwrap())
    });
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export/cortex");
    let [start, board] = ["start.c", "board.ld"].map(|file| here.join(file).display().to_string());
    run(folder.path(), &format!("{BUILD} -c {files} {start}"));
    run(folder.path(), &format!("{BUILD} -T {board} {} start.o -o firmware.elf", files.replace(".c", ".o")));
    let text = run(folder.path(), BOARD);
    let flash = |name: &str| {
        assert!(text.contains(&format!("\n{name}_step: 0 of 400 differ")), "{name}\n{text}");
        let sizes = run(folder.path(), &format!("arm-none-eabi-size {name}.o"));
        sizes.lines().nth(1).and_then(|line| line.split_whitespace().next()).unwrap().parse().unwrap()
    };
    let flash: BTreeMap<&str, usize> = names.iter().map(|name| (name.as_str(), flash(name))).collect();
    let rows = text.lines().filter_map(|line| line.strip_prefix("took "));
    rows.map(|row| {
        let words: Vec<&str> = row.split(' ').collect();
        let instructions = |word: &str| word.parse::<f64>().unwrap() * 40.0 / 64.0;
        let (mean, most, adverse) = (instructions(words[2]) / 400.0, instructions(words[3]), instructions(words[4]));
        let (model, step) = (words[0].to_string(), words[1].to_string());
        let bound = bounds.borrow()[&(model.clone(), step.clone())];
        Taken { flash: flash[words[0]], model, step, mean, most, adverse, bound }
    })
    .collect()
});

/// A program part that runs the self-test, and then each entry again with time measurement.
fn counting(name: &str, whole: &ExportedProgram) -> String {
    let mut body = String::new();
    for entry in &whole.entries {
        let inputs: String = entry.inputs.iter().map(|i| format!(", {}_{}[k]", entry.step, i.name)).collect();
        let adverse = inputs.replace("[k]", "[j] * far");
        let state =
            if entry.state.ends_with("state") { entry.state.to_string() } else { format!("{}_state", entry.state) };
        body += &format!(
            "    {{ {name}_{state} s; unsigned all = 0, most = 0; {name}_{}(&s);\n    for (int k = 0; k < 400; k++) {{ const unsigned from = ticks(); \
             kept = {name}_{}(&s{inputs}); const unsigned took = (ticks() - from - idle) & 0xFFFFFF; all += took; if (took > most) {{ most = took; }} }}\n    \
             unsigned adverse = 0, r = 1;\n    for (int k = 0; k < 400; k++) {{ r = r * 1664525u + 1013904223u; const int j = (int)((r >> 8) % 400u); \
             const float far = (r >> 30) == 0u ? 8.0f : 1.0f; const unsigned from = ticks(); kept = {name}_{}(&s{adverse}); \
             const unsigned took = (ticks() - from - idle) & 0xFFFFFF; if (took > adverse) {{ adverse = took; }} }}\n    \
             printf(\"took {name} {} %u %u %u\\n\", all, most, adverse); }}\n",
            entry.reset, entry.step, entry.step, entry.step,
        );
    }
    format!(
        "#define main {name}_self_test\n#include \"{name}_test.c\"\nextern unsigned ticks(void);\nint {name}_part(void)\n{{\n    \
         volatile float kept = 0.0f;\n    const unsigned before = ticks();\n    const unsigned idle = ticks() - before;\n    \
         const int differs = {name}_self_test();\n{body}    (void)kept;\n    return differs;\n}}\n"
    )
}

#[test]
fn every_operator_gives_the_bits_of_this_machine_and_what_a_step_takes_is_told() {
    if !(there("arm-none-eabi-gcc") && there("qemu-system-arm")) {
        return;
    }
    println!("| model | step | flash [bytes] | instructions, mean | most |\n|---|---|--:|--:|--:|");
    for Taken { model, step, mean, most, flash, .. } in ON_THE_BOARD.iter() {
        println!("| {model} | `{step}` | {flash} | {mean:.0} | {most:.0} |");
    }
}

#[test]
fn no_sample_takes_more_than_four_instructions_for_each_operation_of_the_bound() {
    if !(there("arm-none-eabi-gcc") && there("qemu-system-arm")) {
        return;
    }
    println!(
        "| model | step | instructions, most | adverse | bound [operations] | instructions over bound |\n|---|---|--:|--:|--:|--:|"
    );
    for Taken { model, step, most, adverse, bound, .. } in ON_THE_BOARD.iter() {
        let share = most.max(*adverse) / *bound as f64;
        println!("| {model} | `{step}` | {most:.0} | {adverse:.0} | {bound} | {share:.2} |");
        // Call, copies and return take the rest.
        assert!(most.max(*adverse) <= 4.0 * *bound as f64 + 60.0, "{model} {step}: {most}, {adverse} for {bound}");
    }
}

#[test]
fn the_papers_model_takes_600_instructions_at_most_and_a_feed_forward_of_15_plays_1500() {
    if !(there("arm-none-eabi-gcc") && there("qemu-system-arm")) {
        return;
    }
    let step = |model: &str, step: &str| ON_THE_BOARD.iter().find(|t| t.model == model && t.step == step).unwrap();
    let (model, feed_forward) = (step("papers", "step"), step("fifteen", "ff_step"));
    println!("{model:?}\n{feed_forward:?}");
    assert!(model.most <= 600.0 && feed_forward.most <= 1500.0, "{model:?}, {feed_forward:?}");
}

#[test]
fn a_step_of_the_estimator_takes_3000_instructions_at_most() {
    if !(there("arm-none-eabi-gcc") && there("qemu-system-arm")) {
        return;
    }
    println!("| model | `online_step`, mean | most |\n|---|--:|--:|");
    let taken: Vec<&Taken> = ON_THE_BOARD.iter().filter(|taken| taken.step == "online_step").collect();
    assert_eq!(taken.len(), online_models().len());
    for Taken { model, mean, most, .. } in taken {
        println!("| {model} | {mean:.0} | {most:.0} |");
        assert!(*most <= 3000.0, "{model}: {most}");
    }
}

/// Two branches and the linear block of Table 2.
fn papers_model() -> Model {
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0012, -0.0004, -0.0003]).unwrap();
    Model::new((Operator::find("two-branch").unwrap().example)(TS).unwrap(), block, 0.0).unwrap()
}

/// 15 plays before a resonance. The inverse is a filter of 48 taps.
pub(crate) fn fifteen_plays() -> Model {
    let design = BasisDesign { ts: TS, range: (-30.0, 30.0), elements: Some(15), frequencies: Vec::new() };
    let basis = (Operator::find("prandtl-ishlinskii").unwrap().basis)(&design).unwrap();
    let weights: Vec<f64> = (0..basis.len()).map(|k| if k == 0 { 0.7 } else { 0.03 }).collect();
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8]).unwrap();
    Model::new(basis.operator(&weights).unwrap(), block, 2.0).unwrap()
}
