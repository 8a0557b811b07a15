//! docs/paper.md: the paper's Table 1 beside the errors of the study, and the test signals that it may have used.

use crate::page::{self, head, row};
use piezoid::plant::Preset;
use piezoid::progress::Stage;
use piezoid_numerics::number::short;
use piezoid_report::study::{METHODS, Study, TestSignal};
use std::path::Path;

/// Figures of the study that docs/ contain: their names in the study, and in docs/.
const KEPT: [(&str, &str); 3] =
    [("paper-error", "error"), ("paper-test-signal", "test_signal"), ("paper-deviation", "deviation")];

/// Errors of every method at the frequencies of Table 1.
fn table_1(study: &Study) -> String {
    let heads = ["f [Hz]", "the paper"].into_iter().chain(METHODS.iter().map(|method| method.name));
    let mut text = head(heads, 0);
    for (hz, printed) in Study::PRINTED_MSE {
        let Some(f) = study.frequencies.iter().find(|f| f.hz == hz) else { continue };
        let errors = f.rows.iter().map(|r| short(r.metrics.mse));
        text += &row([hz.to_string(), format!("{printed:.4}")].into_iter().chain(errors));
    }
    text
}

/// The nearest test signal of each form, for both readings of the rule and for the block of Table 2.
fn signals(study: &Study) -> String {
    let heads = ["method", "test signal"].map(String::from).into_iter();
    let heads = heads.chain(Study::PRINTED_MSE.map(|(hz, _)| format!("{hz} Hz"))).chain(["largest deviation".into()]);
    let mut text = head(heads, 2);
    for method in ["printed-rule", TestSignal::UPPER_RULE, "table2-arx"] {
        for form in TestSignal::FORMS {
            let some = study.test_signals.iter().filter(|s| s.form == form);
            let Some(signal) = TestSignal::nearest(some, method) else { continue };
            let errors = signal.of(method).map(|mse| format!("{mse:.4}"));
            let off = format!("{:.0} %", 100.0 * signal.deviation(method));
            text += &row([format!("`{method}`"), signal.words()].into_iter().chain(errors).chain([off]));
        }
    }
    text
}

/// Writes the tables into paper.md of this folder, and its figures beside it.
pub fn write(docs: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let study = Study::run(Preset::find("paper")?, 1, &mut Stage::ignore)?;
    let page = docs.join("paper.md");
    page::write(&page, "verdict", &page::wrapped(&study.verdict()))?;
    page::write(&page, "table 1", &table_1(&study))?;
    page::write(&page, "test signals", &signals(&study))?;
    for (name, figure) in study.figures() {
        if let Some((_, kept)) = KEPT.iter().find(|(drawn, _)| *drawn == name) {
            std::fs::write(docs.join(format!("{kept}.svg")), figure.svg())?;
        }
    }
    Ok(())
}
