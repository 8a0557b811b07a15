//! Tables of a validation for the terminal: the error figures, then errors by frequency and amplitude, loops and
//! residuals.

use crate::console::Console;
use crate::layout::{capitalised, table};
use piezoid::Verdict;
use piezoid::validation::{Bin, Floor, LoopComparison, Metrics};
use piezoid_numerics::number::{round, short as number};
use piezoid_validation::Source;
use piezoid_verbs::{Compared, Validated};

/// Maximum number of bands without `full`. If there are more, this number of the worst bands is shown.
const MOST: usize = 12;
const WORST: usize = 8;

/// A verdict as text.
pub(crate) fn verdict(found: Option<&Verdict>) -> String {
    found.map_or_else(|| "not proven: the output is constant, or the free run is not finite".into(), Verdict::to_string)
}

/// The table of the error figures.
pub(crate) fn brief(validated: &Validated, console: &Console) -> String {
    let unit = validated.files.first().map_or("", |first| &first.record.units().y);
    figures(validated, unit, console.room())
}

/// All tables; `full` adds all bands, all loops and the results of the residual tests.
pub(crate) fn all(validated: &Validated, full: bool, console: &Console) -> String {
    let compared = &validated.files[..];
    let Some(first) = compared.first() else { return String::new() };
    let (units, room) = (first.record.units(), console.room());
    let [by_frequency, by_amplitude] = validated.bins();
    let amplitude = format!("amplitude [{}]", units.u);
    [
        figures(validated, &units.y, room) + &summary(validated, console),
        bins("f [Hz]", &by_frequency, &units.y, full, console),
        bins(&amplitude, &by_amplitude, &units.y, full, console),
        loops(compared, full, console),
        residuals(compared, full, console),
        open(&validated.not_covered(), console),
    ]
    .into_iter()
    .filter(|part| !part.is_empty())
    .collect::<Vec<_>>()
    .join("\n")
}

fn figures(validated: &Validated, unit: &str, room: Option<usize>) -> String {
    let row = |name: &str, m: &Metrics, floor: Option<Floor>| {
        let noise = floor.map_or("-".into(), |f| number(f.nrmse_percent));
        let [rmse, max, nrmse, share, fit] =
            [m.rmse, m.max_abs, m.nrmse_percent, m.rms_pp_percent, m.fit_percent].map(number);
        vec![name.to_string(), m.n.to_string(), rmse, max, nrmse, noise, share, fit]
    };
    let each = |p: &Compared| row(&p.name, &p.validation.metrics, p.validation.floor);
    let mut rows: Vec<_> = validated.files.iter().map(each).collect();
    if rows.len() > 1 {
        rows.push(row("total", &validated.total(), validated.floor()));
    }
    let (rmse, max) = (format!("rmse [{unit}]"), format!("max [{unit}]"));
    table(&["free run", "n", &rmse, &max, "nrmse %", "noise %", "rms/pp %", "fit %"], &rows, room)
}

/// The error in one sentence: noise, drift, and what a better model could gain.
fn summary(validated: &Validated, console: &Console) -> String {
    validated.summary().map_or(String::new(), |sentence| console.paragraph(&format!("{}.", capitalised(&sentence)), ""))
}

/// Errors by frequency or amplitude. A single bin would only repeat the total, and is not shown.
fn bins(head: &str, bins: &[Bin], unit: &str, full: bool, console: &Console) -> String {
    if bins.len() < 2 {
        return String::new();
    }
    let least = match bins.len() > MOST && !full {
        true => {
            let mut errors: Vec<f64> = bins.iter().map(|b| b.rmse).collect();
            errors.sort_by(|a, b| b.total_cmp(a));
            errors[WORST - 1]
        }
        false => 0.0,
    };
    let shown: Vec<&Bin> = bins.iter().filter(|b| b.rmse >= least || b.rmse.is_nan()).collect();
    let row = |b: &&Bin| {
        let of = match b.source {
            Source::Cycles => b.cycles.to_string(),
            Source::Spectrum => "spectrum".into(),
        };
        vec![number(b.at), of, number(b.rmse), number(b.nrmse_percent), number(b.rms_pp_percent)]
    };
    let rmse = format!("rmse [{unit}]");
    let header = [head, "cycles", &rmse, "nrmse %", "rms/pp %"];
    let text = table(&header, &shown.iter().map(row).collect::<Vec<_>>(), console.room());
    match shown.len() < bins.len() {
        true => {
            let left = format!(
                "Only the {} of {} bands with the largest error are shown; `validate --full` shows all.",
                shown.len(),
                bins.len()
            );
            text + &console.paragraph(&left, "")
        }
        false => text,
    }
}

/// The largest loops of each record; with `full`, all loops with all their figures.
fn loops(compared: &[Compared], full: bool, console: &Console) -> String {
    let largest = |p: &Compared| {
        let most = p.validation.loops.iter().map(|l| l.amplitude).fold(0.0, f64::max);
        p.validation.loops.iter().filter(move |l| full || l.amplitude == most).copied().collect::<Vec<_>>()
    };
    let rows: Vec<(&str, LoopComparison)> =
        compared.iter().flat_map(|p| largest(p).into_iter().map(move |l| (p.name.as_str(), l))).collect();
    let Some(unit) = compared.first().filter(|_| !rows.is_empty()).map(|p| p.record.units()) else {
        return String::new();
    };
    let pair = |measured: f64, model: f64| [number(measured), number(model)];
    let amplitude = format!("amplitude [{}]", unit.u);
    let (slope, area) = (format!("slope [{}/{}]", unit.y, unit.u), format!("area [{} {}]", unit.u, unit.y));
    let widths = |(file, l): &(&str, LoopComparison)| {
        let [width, closure, slope] = [
            pair(l.measured.width_percent, l.model.width_percent),
            pair(l.measured.closure_percent, l.model.closure_percent),
            pair(l.measured.slope, l.model.slope),
        ];
        let place = [file.to_string(), round(l.hz), number(l.amplitude)];
        place
            .into_iter()
            .chain(width)
            .chain(slope)
            .chain(if full { closure.to_vec() } else { vec![] })
            .collect::<Vec<_>>()
    };
    let mut header = vec!["loops", "f [Hz]", &amplitude, "width %", "model", &slope, "model"];
    if full {
        header.extend(["closure %", "model"]);
    }
    let mut text = table(&header, &rows.iter().map(widths).collect::<Vec<_>>(), console.room());
    if full {
        let more = |(file, l): &(&str, LoopComparison)| {
            let [area, reversals] =
                [pair(l.measured.area, l.model.area), pair(l.measured.reversals, l.model.reversals)];
            let known = |s: Option<f64>| s.map_or("-".into(), number);
            let turn = [known(l.measured.slope_after_reversal), known(l.model.slope_after_reversal)];
            let place = [file.to_string(), round(l.hz), number(l.amplitude)];
            place.into_iter().chain(area).chain(turn).chain(reversals).collect::<Vec<_>>()
        };
        let header =
            ["loops", "f [Hz]", &amplitude, &area, "model", "slope after reversal", "model", "reversals", "model"];
        text += &format!("\n{}", table(&header, &rows.iter().map(more).collect::<Vec<_>>(), console.room()));
    }
    text
}

/// The noise floor, the drift, and the correlations of the residuals.
fn residuals(compared: &[Compared], full: bool, console: &Console) -> String {
    let tested = compared.iter().filter(|p| p.validation.whiteness.is_some() || p.validation.floor.is_some());
    let row = |p: &Compared| {
        let (floor, whiteness) = (&p.validation.floor, &p.validation.whiteness);
        vec![
            p.name.clone(),
            floor.map_or("-".into(), |f| number(f.rms)),
            floor.map_or("-".into(), |f| number(f.error_over_floor)),
            number(p.validation.drift_per_s),
            whiteness.as_ref().map_or("-".into(), |w| number(w.autocorrelation[0])),
            whiteness.as_ref().map_or("-".into(), |w| number(w.largest_correlation().0)),
        ]
    };
    let rows: Vec<_> = tested.map(row).collect();
    let Some(unit) = compared.first().filter(|_| !rows.is_empty()).map(|p| p.record.units().y.clone()) else {
        return String::new();
    };
    let (floor, drift) = (format!("floor [{unit}]"), format!("drift [{unit}/s]"));
    let header = ["residuals", &floor, "rmse/floor", &drift, "lag-1 corr.", "corr. with u"];
    let mut text = table(&header, &rows, console.room());
    for p in compared.iter().filter(|_| full) {
        for sentence in p.validation.whiteness.iter().flat_map(|w| &w.verdict) {
            text += &console.paragraph(&format!("{}: {sentence}.", p.name), "  ");
        }
    }
    text
}

fn open(not_covered: &[String], console: &Console) -> String {
    let line = |text: &String| console.paragraph(&format!("Not tested by these records: {text}."), "  ");
    capitalised(&not_covered.iter().map(line).collect::<String>())
}
