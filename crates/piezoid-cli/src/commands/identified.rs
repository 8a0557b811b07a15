//! What `piezoid identify` found, as tables and as JSON.

use super::{Proven, figures};
use crate::console::Console;
use crate::layout::table;
use crate::tables;
use piezoid::System;
use piezoid::hammerstein::{Identified, Parameter, Trial};
use piezoid::linear::{Residuals, Root};
use piezoid::number::{round, short as number};
use piezoid::validation::Metrics;
use serde_json::{Value, json};

/// What was found, for the terminal.
pub(super) fn summary(found: &Identified, trained: &[Proven], console: &Console) -> String {
    let (arx, units) = (found.model.linear(), found.model.units());
    let listed = |name: &str, values: Vec<String>| {
        console.paragraph(&format!("  {name:<9} {}", values.join("  ")), "            ")
    };
    let each = |values: &[f64]| values.iter().map(|v| format!("{v:.6}")).collect::<Vec<_>>();
    let form = match arx.a() {
        [] => "a gain without dynamics",
        _ => "y = a1 y1 + ... + b0 u + b1 u1 + ...",
    };
    let mut text = console.paragraph(&format!("Linear block: {form}, every {} s", arx.ts()), "  ");
    if !arx.a().is_empty() {
        text += &listed("a", each(arx.a()));
        text += &listed("b", each(arx.b()));
        text += &listed(
            "poles",
            arx.poles().iter().map(|p| format!("{} Hz (damping {})", number(p.hz), round(p.damping))).collect(),
        );
        text += &listed("zeros", arx.zeros().iter().map(Root::to_string).collect());
    }
    if let Some(fit) = &found.linear.fit {
        let Residuals { rms, max_abs, .. } = fit.residuals;
        let white = if fit.residuals.are_white() { "white" } else { "not white" };
        text += &format!(
            "  errors    {} {} rms, {} at most, one step ahead; {white}\n",
            number(rms),
            units.y,
            number(max_abs)
        );
    }
    text += &format!("  gain      {} {}/{}\n", number(arx.dc_gain()), units.y, units.u);
    text += &format!("  offset    {} {}\n", number(found.model.offset()), units.y);
    if let Some(gain) = arx.noise_gain() {
        text += &format!("  inverse   makes {} {} of 1 {} of noise\n", number(gain), units.u, units.y);
    }
    text += &format!("\nHysteresis block: {}\n", found.model.hysteresis().operator().name);
    if !found.loops.is_empty() {
        let row = |l: &piezoid::hammerstein::HiddenLoop| {
            let (low, high) = l.found.branches.range();
            let side = if l.found.ascending_below { "below" } else { "above" };
            let width = number(100.0 * l.found.branches.width());
            vec![
                l.frequency_hz.map_or("-".into(), round),
                round(low),
                round(high),
                width,
                side.into(),
                round(100.0 * l.found.agreement),
            ]
        };
        let (from, to) = (format!("from [{}]", units.u), format!("to [{}]", units.u));
        let header = ["f [Hz]", &from, &to, "width %", "ascending", "agreement %"];
        text += &table(&header, &found.loops.iter().map(row).collect::<Vec<_>>(), console.room());
    }
    if !found.trials.is_empty() {
        text += &trials(found, console);
    }
    if !found.parameters.is_empty() {
        let row = |p: &Parameter| vec![p.name.clone(), number(p.value), number(p.error)];
        let rows: Vec<_> = found.parameters.iter().map(row).collect();
        text += &format!("\n{}", table(&["parameter", "value", "std error"], &rows, console.room()));
    }
    if !trained.is_empty() {
        let each: Vec<Metrics> = trained.iter().map(|p| p.validation.metrics).collect();
        text += &format!("\nIts own records\n{}", tables::all(trained, &Metrics::total(&each), false, console));
    }
    text
}

/// The operators that were tried, the best first.
fn trials(found: &Identified, console: &Console) -> String {
    let mut trials: Vec<&Trial> = found.trials.iter().collect();
    trials.sort_by(|p, q| p.held_out_percent.total_cmp(&q.held_out_percent));
    let chosen = found.model.hysteresis().operator().name;
    let row = |trial: &&Trial| {
        let verdict = match &trial.refused {
            Some(why) => why.clone(),
            None if trial.operator == chosen => "taken".into(),
            None if trial.as_good => "as good".into(),
            None => String::new(),
        };
        vec![trial.operator.to_string(), trial.parameters.to_string(), number(trial.held_out_percent), verdict]
    };
    let header = ["operator", "parameters", "held out, rms/pp %", ""];
    format!("\n{}", table(&header, &trials.iter().map(row).collect::<Vec<_>>(), console.room()))
}

/// What was found, for scripts.
pub(super) fn result(found: &Identified, trained: &[Proven]) -> Value {
    let arx = found.model.linear();
    let each = |l: &piezoid::hammerstein::HiddenLoop| {
        json!({
            "frequency_hz": l.frequency_hz,
            "loop_width_percent": 100.0 * l.found.branches.width(),
            "ascending_below": l.found.ascending_below,
            "agreement": l.found.agreement,
        })
    };
    json!({
        "linear": {
            "a": arx.a(),
            "b": arx.b(),
            "poles": arx.poles(),
            "zeros": arx.zeros(),
            "noise_gain": arx.noise_gain(),
            "reason": found.linear.reason,
            "residuals": found.linear.fit.as_ref().map(|f| f.residuals),
            "offsets": found.linear.fit.as_ref().map(|f| &f.offsets),
            "convergence": found.linear.fit.as_ref().map(|f| &f.history),
        },
        "operator": found.model.hysteresis().operator().name,
        "loops": found.loops.iter().map(each).collect::<Vec<_>>(),
        "trials": found.trials,
        "parameters": found.parameters,
        "creep": found.model.creep().lags(),
        "training": trained.iter().map(figures).collect::<Vec<_>>(),
        "notes": found.notes,
    })
}
