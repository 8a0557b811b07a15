//! Tables of a validation for the terminal: the error figures, then errors by frequency and amplitude, loops and
//! residuals.

use crate::console::Console;
use piezoid::validation::{Bin, Floor, LoopComparison, Metrics};
use piezoid::{Units, Verdict};
use piezoid_numerics::number::{round, short as number};
use piezoid_numerics::words::capitalised;
use piezoid_validation::Source;
use piezoid_verbs::{Compared, Validated};

/// Maximum number of bands without `full`. If there are more, this number of the worst bands is shown.
const MOST: usize = 12;
const WORST: usize = 8;

/// The mark of a band.
const LITTLE: &str = "* Little is excited there: the error is that of noise or of other frequencies.";

/// A verdict as the beginning of a sentence.
pub(crate) fn verdict(found: Option<&Verdict>) -> String {
    let unproven = || "not proven: the output is constant, or the free run is not finite".into();
    capitalised(&found.map_or_else(unproven, Verdict::to_string))
}

/// The table of the error figures.
pub(crate) fn brief(validated: &Validated, console: &Console) -> String {
    let unit = validated.files.first().map_or("", |first| &first.record.units().y);
    figures(validated, unit, console)
}

/// All tables; `full` adds all bands, all loops and the results of the residual tests.
pub(crate) fn all(validated: &Validated, full: bool, console: &Console) -> String {
    let compared = &validated.files[..];
    let Some(first) = compared.first() else { return String::new() };
    let units = first.record.units();
    let [by_frequency, by_amplitude] = validated.bins();
    let amplitude = format!("amplitude [{}]", units.u);
    [
        figures(validated, &units.y, console) + &summary(validated, console),
        bins("f [Hz]", &by_frequency, &units.y, full, console),
        bins(&amplitude, &by_amplitude, &units.y, full, console),
        loops(compared, units, full, console),
        residuals(compared, units, full, console),
        open(&validated.not_covered(), console),
    ]
    .into_iter()
    .filter(|part| !part.is_empty())
    .collect::<Vec<_>>()
    .join("\n")
}

fn figures(validated: &Validated, unit: &str, console: &Console) -> String {
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
    console.table(&["free run", "n", &rmse, &max, "nrmse %", "noise %", "rms/pp %", "fit %"], rows)
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
        let of = if b.little_excited { of + " *" } else { of };
        let noise = b.noise_nrmse_percent.map_or("-".into(), number);
        vec![number(b.at), of, number(b.rmse), number(b.nrmse_percent), noise, number(b.rms_pp_percent)]
    };
    let rmse = format!("rmse [{unit}]");
    let mut text = console.table(&[head, "cycles", &rmse, "nrmse %", "noise %", "rms/pp %"], shown.iter().map(row));
    if shown.iter().any(|b| b.little_excited) {
        text += &console.paragraph(LITTLE, "");
    }
    if shown.len() == bins.len() {
        return text;
    }
    let (some, all) = (shown.len(), bins.len());
    let left = format!("Only the {some} of {all} bands with the largest error are shown; `validate --full` shows all.");
    text + &console.paragraph(&left, "")
}

/// The largest loops of each record; with `full`, all loops with all their figures.
fn loops(compared: &[Compared], unit: &Units, full: bool, console: &Console) -> String {
    let mut rows: Vec<(&str, &LoopComparison)> = Vec::new();
    for p in compared {
        let most = p.validation.loops.iter().map(|l| l.amplitude).fold(0.0, f64::max);
        let shown = p.validation.loops.iter().filter(|l| full || l.amplitude == most);
        rows.extend(shown.map(|l| (p.name.as_str(), l)));
    }
    if rows.is_empty() {
        return String::new();
    }
    let amplitude = format!("amplitude [{}]", unit.u);
    let (slope, area) = (format!("slope [{}/{}]", unit.y, unit.u), format!("area [{} {}]", unit.u, unit.y));
    let place = |file: &str, l: &LoopComparison| vec![file.to_string(), round(l.hz), number(l.amplitude)];
    let pair = |measured: f64, model: f64| [number(measured), number(model)];
    let widths = |(file, l): &(&str, &LoopComparison)| {
        let mut cells = place(file, l);
        cells.extend(pair(l.measured.width_percent, l.model.width_percent));
        cells.extend(pair(l.measured.slope, l.model.slope));
        if full {
            cells.extend(pair(l.measured.closure_percent, l.model.closure_percent));
        }
        cells
    };
    let mut header = vec!["loops", "f [Hz]", &amplitude, "width %", "model", &slope, "model"];
    if full {
        header.extend(["closure %", "model"]);
    }
    let mut text = console.table(&header, rows.iter().map(widths));
    if full {
        let more = |(file, l): &(&str, &LoopComparison)| {
            let known = |slope: Option<f64>| slope.map_or("-".into(), number);
            let mut cells = place(file, l);
            cells.extend(pair(l.measured.area, l.model.area));
            cells.extend([l.measured.slope_after_reversal, l.model.slope_after_reversal].map(known));
            cells.extend(pair(l.measured.reversals, l.model.reversals));
            cells
        };
        let header =
            ["loops", "f [Hz]", &amplitude, &area, "model", "slope after reversal", "model", "reversals", "model"];
        text += &format!("\n{}", console.table(&header, rows.iter().map(more)));
    }
    text
}

/// The noise floor, the drift, and the correlations of the residuals.
fn residuals(compared: &[Compared], unit: &Units, full: bool, console: &Console) -> String {
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
    if rows.is_empty() {
        return String::new();
    }
    let (floor, drift) = (format!("floor [{}]", unit.y), format!("drift [{}/s]", unit.y));
    let header = ["residuals", &floor, "rmse/floor", &drift, "lag-1 corr.", "corr. with u"];
    let mut text = console.table(&header, rows);
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
