//! Tables of the results of `piezoid identify`.

use crate::console::Console;
use crate::tables;
use piezoid::hammerstein::{FittedParameter, Identified, OperatorTrial};
use piezoid::linear::ModalForm;
use piezoid::{Identification, Model, System, Units};
use piezoid_models::hammerstein::HiddenLoop;
use piezoid_models::linear::{Residuals, Root};
use piezoid_numerics::number::{round, short as number};
use piezoid_verbs::Validated;

const IN_FEEDBACK: &str = "Hysteresis in feedback of the mechanics gives the response: see its parameters below. The linear \
                           block and the hysteresis block in series approximate it, for margins and controllers.";

/// The results as text for the terminal.
pub(super) fn summary(result: &Identification, console: &Console) -> String {
    let found = &result.found;
    let (arx, Units { u, y }) = (found.model.linear(), found.model.units());
    let listed = |name: &str, values: Vec<String>| {
        console.paragraph(&format!("  {name:<9} {}", values.join("  ")), "            ")
    };
    let each = |values: &[f64]| values.iter().map(|v| format!("{v:.6}")).collect::<Vec<_>>();
    let is_gain = arx.a().is_empty() && arx.b().len() == 1;
    let form = match arx.a() {
        [] if is_gain => "a gain without dynamics",
        [] => "y = b0 u + b1 u1 + ...",
        _ => "y = a1 y1 + ... + b0 u + b1 u1 + ...",
    };
    let ts = arx.ts();
    let form = format!("Linear block: {form}, where y1 and u1 are the previous samples; sampled every {ts} s");
    let mut text = found.model.feedback().map_or_else(String::new, |_| console.paragraph(IN_FEEDBACK, ""));
    text += &console.paragraph(&form, "  ");
    for (name, values) in
        [("a", each(arx.a())), ("b", each(arx.b())), ("zeros", arx.zeros().iter().map(Root::to_string).collect())]
    {
        if !is_gain && !values.is_empty() {
            text += &listed(name, values);
        }
    }
    if let Some(fit) = &found.linear.fit {
        let Residuals { rms, max_abs, .. } = fit.residuals;
        let white = if fit.residuals.are_white() { "white" } else { "not white" };
        let [rms, most] = [rms, max_abs].map(number);
        let errors = format!("{rms} {y} rms, {most} {y} at most, of the one-step prediction");
        text += &format!("  errors    {errors}; residuals {white}\n");
    }
    let reading = Some(arx.modal_form()).filter(|reading| !reading.poles.is_empty());
    text += &format!("  gain      {} {y}/{u}\n", number(arx.dc_gain()));
    if let Some(reading) = &reading {
        let sampled = if reading.delay < 0.0 { ": the output was sampled after its input acted" } else { "" };
        let delay = number(1e3 * reading.delay);
        let delay = format!("{delay} ms in addition to the zero-order hold, from the phase at low frequency{sampled}");
        text += &listed("delay", vec![delay]);
    }
    text += &format!("  offset    {} {y}\n", number(found.model.offset()));
    if let Some(gain) = arx.noise_gain() {
        text += &format!("  inverse   noise gain {} {u} rms per {y} rms of sensor noise\n", number(gain));
    }
    if let Some(reading) = &reading {
        text += &format!("\n{}", mechanics(reading, console));
    }
    text += &format!("\nHysteresis block: {}\n", found.model.hysteresis().operator().name);
    text += &beside(&found.model, console);
    if !found.loops.is_empty() {
        let row = |l: &HiddenLoop| {
            let (low, high) = l.found.branches.range();
            let (hz, width) = (l.frequency_hz.map_or("-".into(), round), number(100.0 * l.found.branches.width()));
            let side = if l.found.ascending_below { "below" } else { "above" };
            vec![hz, round(low), round(high), width, side.into(), round(100.0 * l.found.agreement)]
        };
        let (from, to) = (format!("from [{u}]"), format!("to [{u}]"));
        let header = ["f [Hz]", &from, &to, "width %", "ascending branch", "side agrees with direction [% of points]"];
        text += &console.table(&header, found.loops.iter().map(row));
    }
    if !found.trials.is_empty() {
        text += &trials(found, console);
    }
    if !found.parameters.is_empty() {
        let error = |p: &FittedParameter| Option::<f64>::from(p.error).map_or("-".into(), number);
        let row = |p: &FittedParameter| vec![p.name.clone(), number(p.value), error(p)];
        let table = console.table(&["parameter", "value", "standard error"], found.parameters.iter().map(row));
        text += &format!("\n{table}");
    }
    if !result.training.is_empty() {
        let training = Validated { files: result.training.clone() };
        text += &format!("\nTraining records\n{}", tables::all(&training, false, console));
    }
    text
}

/// Modes, delay and shares of the linear block as a table of mechanics.
fn mechanics(reading: &ModalForm, console: &Console) -> String {
    let header = ["mechanics", "f [Hz]", "damping", "share %", "mass [g]", "damper [N s/m]"];
    let table = console.table(&header, reading.rows().into_iter().map(Vec::from));
    let note = "Shares of the static displacement. Mass and damper are for a spring of 1 N/mm at the point of \
                measurement: both are proportional to the stiffness.";
    let sentence = [Some(note.to_string()), reading.images()].into_iter().flatten();
    sentence.fold(table, |text, sentence| text + &console.paragraph(&sentence, ""))
}

/// Creep and driver, if the model has them.
fn beside(model: &Model, console: &Console) -> String {
    let lags: Vec<_> = model.creep().lags().iter().filter(|lag| lag.gain != 0.0).collect();
    let mut text = String::new();
    if !lags.is_empty() {
        let each = lags.iter().map(|lag| format!("{} % ({} s)", number(100.0 * lag.gain), round(lag.tau_s)));
        text += &console.paragraph(&format!("Creep: {}", each.collect::<Vec<_>>().join("  ")), "  ");
    }
    if let Some(driver) = model.driver() {
        let lag = format!("a lag of {} ms", round(1e3 * driver.lag_s));
        let slew = driver.slew.map(|slew| format!(", at most {} {}/s", number(slew), model.units().u));
        text += &console.paragraph(&format!("Driver: {lag}{}", slew.unwrap_or_default()), "  ");
    }
    text
}

/// The operators that were tried, best first.
fn trials(found: &Identified, console: &Console) -> String {
    let mut trials: Vec<&OperatorTrial> = found.trials.iter().collect();
    trials.sort_by(|p, q| p.error_percent.total_cmp(&q.error_percent));
    let row = |t: &&OperatorTrial| {
        let [held_out, free_run] = [t.held_out_percent, t.free_run_percent].map(number);
        vec![t.operator.to_string(), t.parameters.to_string(), held_out, free_run, t.verdict.to_string()]
    };
    let header = ["operators, rms/pp %", "parameters", "held-out error", "free run", ""];
    let text = format!("\n{}", console.table(&header, trials.iter().map(row)));
    let refused = trials.iter().filter_map(|t| t.refused.as_ref().map(|why| format!("{}: {why}", t.operator)));
    refused.fold(text, |text, why| text + &console.paragraph(&why, "  "))
}
