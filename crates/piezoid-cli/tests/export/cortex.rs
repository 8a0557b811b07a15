//! C on an emulated Cortex-M4F: the same bits as here, and how many instructions a step takes.

use crate::{TS, exported, models, run, there};
use piezoid::Model;
use piezoid::hysteresis::{BasisDesign, Operator};
use piezoid::linear::Arx;
use piezoid_export::{Wanted, Whole};
use std::path::Path;

const BUILD: &str = "arm-none-eabi-gcc -std=c99 -Wall -Wextra -Werror -O2 -ffp-contract=off -mcpu=cortex-m4 -mthumb -mfloat-abi=hard \
                     -mfpu=fpv4-sp-d16 -nostartfiles --specs=rdimon.specs";

/// An instruction of 64 ns beside a SysTick of 40.
const BOARD: &str = "qemu-system-arm -M mps2-an386 -nographic -monitor none -serial none \
                     -semihosting-config enable=on,target=native -icount shift=6 -kernel firmware.elf";

/// What a step of each entry takes [instructions].
#[derive(Debug)]
struct Taken {
    step: String,
    mean: f64,
    most: f64,
    /// Of text and constants [bytes].
    flash: usize,
}

/// Builds, runs the self-test on the board, and counts.
fn on_the_board(wanted: &Wanted) -> Vec<Taken> {
    let (name, folder) = (&*wanted.options.name, tempfile::tempdir().unwrap());
    exported("c", wanted, folder.path());
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/export/cortex");
    std::fs::write(folder.path().join("count.c"), counting(name, &Whole::new(wanted).unwrap())).unwrap();
    let [start, board] = ["start.c", "board.ld"].map(|file| here.join(file).display().to_string());
    run(folder.path(), &format!("{BUILD} -T {board} {name}.c count.c {start} -o firmware.elf"));
    run(folder.path(), &format!("{BUILD} -c {name}.c -o alone.o"));
    let sizes = run(folder.path(), "arm-none-eabi-size alone.o");
    let flash = sizes.lines().nth(1).and_then(|line| line.split_whitespace().next()).unwrap().parse().unwrap();
    let said = run(folder.path(), BOARD);
    assert!(!said.contains("0 of 0") && said.contains(": 0 of 400 differ"), "{said}");
    let rows = said.lines().filter_map(|line| line.strip_prefix("took "));
    rows.map(|row| {
        let words: Vec<&str> = row.split(' ').collect();
        let instructions = |word: &str| word.parse::<f64>().unwrap() * 40.0 / 64.0;
        Taken { step: words[0].into(), mean: instructions(words[1]) / 400.0, most: instructions(words[2]), flash }
    })
    .collect()
}

/// A main that runs the self-test, and each entry once more under the clock.
fn counting(name: &str, whole: &Whole) -> String {
    let mut body = String::new();
    for entry in &whole.entries {
        let inputs: String = entry.inputs.iter().map(|i| format!(", {}_{}[k]", entry.step, i.name)).collect();
        let state =
            if entry.state.ends_with("state") { entry.state.to_string() } else { format!("{}_state", entry.state) };
        body += &format!(
            "    {{ {name}_{state} s; unsigned all = 0, most = 0; {name}_{}(&s);\n    for (int k = 0; k < 400; k++) {{ const unsigned from = ticks(); \
             kept = {name}_{}(&s{inputs}); const unsigned took = (ticks() - from - idle) & 0xFFFFFF; all += took; if (took > most) {{ most = took; }} }}\n    \
             printf(\"took {} %u %u\\n\", all, most); }}\n",
            entry.reset, entry.step, entry.step,
        );
    }
    format!(
        "#define main self_test\n#include \"{name}_test.c\"\n#undef main\nextern unsigned ticks(void);\nint main(void)\n{{\n    volatile float kept = 0.0f;\n    \
         const unsigned before = ticks();\n    const unsigned idle = ticks() - before;\n    const int differs = self_test();\n{body}    (void)kept;\n    \
         return differs;\n}}\n"
    )
}

#[test]
fn every_operator_gives_the_bits_of_this_machine_and_what_a_step_takes_is_told() {
    if !(there("arm-none-eabi-gcc") && there("qemu-system-arm")) {
        return;
    }
    println!("| model | step | flash [bytes] | instructions, mean | most |\n|---|---|--:|--:|--:|");
    for (name, model) in models() {
        for taken in on_the_board(&Wanted::new(&model, &name).single(true)) {
            println!("| {name} | `{}` | {} | {:.0} | {:.0} |", taken.step, taken.flash, taken.mean, taken.most);
        }
    }
}

#[test]
fn the_papers_model_takes_600_instructions_at_most_and_a_feed_forward_of_15_plays_1500() {
    if !(there("arm-none-eabi-gcc") && there("qemu-system-arm")) {
        return;
    }
    let [papers, plays] = [papers_model(), fifteen_plays()];
    let step = |model: &Model, name: &str| {
        let taken = on_the_board(&Wanted::new(model, "m").single(true));
        taken.into_iter().find(|t| t.step == name).unwrap()
    };
    let (model, feed_forward) = (step(&papers, "step"), step(&plays, "ff_step"));
    println!("{model:?}\n{feed_forward:?}");
    assert!(model.most <= 600.0 && feed_forward.most <= 1500.0, "{model:?}, {feed_forward:?}");
}

/// Two branches and Table 2's block.
fn papers_model() -> Model {
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0012, -0.0004, -0.0003]).unwrap();
    Model::new((Operator::find("two-branch").unwrap().example)(TS).unwrap(), block, 0.0).unwrap()
}

/// 15 plays before a resonance, whose inverse is a filter of 48 taps.
fn fifteen_plays() -> Model {
    let design = BasisDesign { ts: TS, range: (-30.0, 30.0), elements: Some(15), frequencies: Vec::new() };
    let basis = (Operator::find("prandtl-ishlinskii").unwrap().basis)(&design).unwrap();
    let weights: Vec<f64> = (0..basis.len()).map(|k| if k == 0 { 0.7 } else { 0.03 }).collect();
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8]).unwrap();
    Model::new(basis.operator(&weights).unwrap(), block, 2.0).unwrap()
}
