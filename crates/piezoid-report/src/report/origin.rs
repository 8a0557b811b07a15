//! Origin of the model: the entries of `piezoid identify` in the model's file, if any.

use crate::each::Each;
use crate::page::{Cell, PageTable, Section, Text, sentence};
use piezoid::{Model, StatedVerdict, Verdict};
use piezoid_numerics::number::short;
use serde_json::Value;

/// The operators tried, the parameters with their standard errors, and the command; `None` without any of them. The
/// verdict too, unless the page has `stated` it above.
pub(super) fn section(model: &Model, stated: Option<&Verdict>) -> Option<Section> {
    let result = model.provenance();
    let list = |name: &str| result[name].as_array().map(Vec::as_slice).unwrap_or_default();
    let (tried, known) = (list("trials"), list("parameters"));
    let section = Section::new("How it was identified")
        .each(model.verdict().filter(|own| Some(own) != stated), |section, verdict| {
            section.text(sentence(&verdict.to_string()))
        })
        .each((!tried.is_empty()).then(|| trials(tried)), Section::table)
        .each((!known.is_empty()).then(|| parameters(known)), Section::table);
    match result["command"].as_str() {
        Some(command) => Some(section.text(origin(command, result))),
        None => (tried.len() + known.len() > 0).then_some(section),
    }
}

/// The front end, the options that were changed, and the files.
fn origin(command: &str, result: &Value) -> Text {
    let text = Text::from("Made by ").code(command);
    let options = result["options"].as_object().into_iter().flatten();
    let options: Vec<String> = options.map(|(name, value)| format!("{name} = {}", plain(value))).collect();
    let text = if options.is_empty() { text } else { text.plain(" with ").code(options.join(", ")) };
    let files: Vec<&str> =
        result["files"].as_array().into_iter().flatten().filter_map(|one| one["file"].as_str()).collect();
    let text = if files.is_empty() { text } else { text.plain(" from ").code(files.join(", ")) };
    text.plain(".")
}

/// A value without quotes.
fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), String::from)
}

/// The operators, the best first.
fn trials(tried: &[Value]) -> PageTable {
    let error = |trial: &Value| trial["error_percent"].as_f64().unwrap_or(f64::INFINITY);
    let word = |trial: &Value, key: &str| trial[key].as_str().unwrap_or_default().to_string();
    let mut tried: Vec<&Value> = tried.iter().collect();
    tried.sort_by(|p, q| error(p).total_cmp(&error(q)));
    let row = |trial: &&Value| {
        let verdict = word(trial, "verdict");
        let taken = verdict == "taken";
        let parameters = trial["parameters"].as_u64().map_or("-".into(), |n| n.to_string());
        let errors = ["held_out_percent", "free_run_percent"].map(|key| number(&trial[key]));
        let [held_out, free_run] = errors;
        let cells = [word(trial, "operator"), parameters, held_out, free_run, verdict].map(Cell::from);
        if taken { cells.map(Cell::best) } else { cells }
    };
    let table = PageTable::new("Operators tried").text("operator").number("parameters");
    let table = table.number("held out [%]").number("free run [%]").text("verdict");
    let table = table.rows(tried.iter().map(row)).note(
        "Rms errors over peak-to-peak: of parts held out (cross-validation), and of the free run on the training \
        records; the larger of the two ranks them. Among the operators as good as the best, the simplest is selected.",
    );
    let refused = tried.iter().filter_map(|trial| Some((word(trial, "operator"), trial["refused"].as_str()?)));
    table.each(refused, |table, (operator, why)| table.note(format!("{operator}: {why}")))
}

/// A number, or a dash where there is none.
fn number(value: &Value) -> String {
    value.as_f64().map_or("-".into(), short)
}

fn parameters(known: &[Value]) -> PageTable {
    let row =
        |p: &Value| [p["name"].as_str().unwrap_or_default().to_string(), number(&p["value"]), number(&p["error"])];
    let table = PageTable::new("Estimated parameters with standard errors").text("parameter").number("value");
    table.number("standard error").rows(known.iter().map(row))
}
