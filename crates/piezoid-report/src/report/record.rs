//! A record in the report: time series, loops, and residuals.

use super::residuals;
use crate::page::{PageTable, Section, sentence};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::Compared;
use piezoid::number::{round, short};
use piezoid::validation::{LoopShape, Offset};

/// Number of samples that a figure shows.
const SHOWN: usize = 4000;

pub(super) fn section(trial: &Compared) -> Section {
    let (name, record, validation) = (trial.short(), &trial.record, &trial.validation);
    let section = Section::new(name);
    let section = validation.remarks.iter().fold(section, |s, remark| s.warning("Note", sentence(remark)));
    let section = match validation.offset_removed {
        Some(mean) => {
            let (mean, unit) = (short(mean), &record.units().y);
            let drift = short(validation.drift_per_s);
            let removed = match validation.offset {
                Offset::Drift => format!("A mean error of {mean} {unit} and a drift of {drift} {unit}/s were"),
                _ => format!("A mean error of {mean} {unit} was"),
            };
            section.note("Offset", format!("{removed} removed before the comparison."))
        }
        None => section,
    };
    let section = match &validation.summary {
        Some(summary) => section.text(sentence(summary)),
        None => section,
    };
    let section = section.figure(time_series(trial)).figure(loops(trial));
    let section = if validation.loops.is_empty() { section } else { section.table(shapes(trial)) };
    residuals::residuals(section, trial)
}

fn time_series(trial: &Compared) -> Figure {
    let Compared { record, validation, .. } = trial;
    let units = record.units();
    let range = validation.start..record.len().min(validation.start + SHOWN);
    let t: Vec<f64> = range.clone().map(|k| k as f64 * record.ts()).collect();
    let (y, simulated) = (&record.y()[range.clone()], &validation.simulated[range]);
    let error: Vec<f64> = y.iter().zip(simulated).map(|(y, s)| y - s).collect();
    let rms = short(validation.metrics.rms_pp_percent);
    let part = if record.len() - validation.start > SHOWN { "the first part of the record" } else { "the record" };
    let of = &record.y()[validation.start..];
    let errors = of.iter().zip(&validation.simulated[validation.start..]).map(|(y, s)| (y - s).abs());
    let worst = errors.enumerate().fold((0, 0.0), |worst, (k, e)| if e > worst.1 { (k, e) } else { worst }).0;
    let at = short((validation.start + worst) as f64 * record.ts());
    let caption = format!(
        "Measurement, free run and residual over {part}; residual over the whole record: {rms} % of peak-to-peak. The \
        largest error is at {at} s."
    );
    let (axis, residual) = (|label: &str| Axis::new(format!("{label} [{}]", units.y)), Role::Residual);
    let top = Axes::new("t [s]", axis("y")).height(0.6);
    let top = top.with(Series::line(&t, y).role(Role::Measured).named("measured"));
    let top = top.with(Series::line(&t, simulated).role(Role::Model).named("model"));
    let low = Axes::new("t [s]", axis("error")).height(0.4).with(Series::line(&t, &error).role(residual));
    Figure::new("Time series", caption).panel(top).panel(low).stacked()
}

fn loops(trial: &Compared) -> Figure {
    let Compared { record, validation, .. } = trial;
    let units = record.units();
    let range = validation.start..record.len().min(validation.start + SHOWN);
    let u = &record.u()[range.clone()];
    let part = if range.end < record.len() { "the first part of the record" } else { "the record" };
    let caption = format!(
        "Output against input in {part}, measured and in free run. In the whole record they differ by {} % of the \
         peak-to-peak output (rms).",
        short(validation.metrics.rms_pp_percent)
    );
    Figure::new("Loops", caption).panel(
        Axes::new(Axis::new(format!("u [{}]", units.u)), Axis::new(format!("y [{}]", units.y)))
            .with(Series::line(u, &record.y()[range.clone()]).role(Role::Measured).named("measured"))
            .with(Series::line(u, &validation.simulated[range]).role(Role::Model).named("model")),
    )
}

/// The shapes of the measured and the modelled loops, in alternating rows.
fn shapes(trial: &Compared) -> PageTable {
    let units = trial.record.units();
    let slope = format!("[{}/{}]", units.y, units.u);
    let table = PageTable::new("Loops, measured and model").number("f [Hz]").number(format!("amplitude [{}]", units.u));
    let table = table.number("cycles").text("").number("width [%]").number(format!("area [{} {}]", units.u, units.y));
    let table =
        table.number("closure [%]").number(format!("slope {slope}")).number(format!("after a reversal {slope}"));
    let table = table.number("reversals");
    let shape = |s: &LoopShape| {
        let reversal = s.slope_after_reversal.map_or("-".into(), short);
        [short(s.width_percent), short(s.area), short(s.closure_percent), short(s.slope), reversal, round(s.reversals)]
    };
    let rows = trial.validation.loops.iter().flat_map(|l| {
        let place = [round(l.hz), short(l.amplitude), l.cycles.to_string(), "measured".into()];
        let below = ["", "", "", "model"].map(String::from);
        [place.into_iter().chain(shape(&l.measured)), below.into_iter().chain(shape(&l.model))].map(Vec::from_iter)
    });
    rows.fold(table, PageTable::row).note(
        "Width at mid input and closure (difference between end and start of a cycle) over the height of the loop; \
        negative area: the loop runs in the opposite direction; reversals of the output per cycle.",
    )
}
