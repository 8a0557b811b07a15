//! A record in the report: time series, loops, and residuals.

use super::loops::{self, FreeRun, worst};
use super::{cycles, residuals};
use crate::each::Each;
use crate::page::{PageTable, Section, sentence};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::validation::Offset;
use piezoid_numerics::number::{round, short};
use piezoid_validation::LoopShape;
use piezoid_verbs::Compared;
use std::ops::Range;

/// The section of a record; its error in one sentence stands above already if it is the only one.
pub(super) fn section(trial: &Compared, is_only: bool) -> Section {
    let (name, record, validation) = (trial.short(), &trial.record, &trial.validation);
    let removed = |mean: f64| {
        let (mean, drift, unit) = (short(mean), short(validation.drift_per_s), &record.units().y);
        let removed = match validation.offset {
            Offset::Drift => format!("A mean error of {mean} {unit} and a drift of {drift} {unit}/s were"),
            _ => format!("A mean error of {mean} {unit} was"),
        };
        format!("{removed} removed before the comparison.")
    };
    let section = Section::new(name)
        .each(&validation.remarks, |section, remark| section.warning("Note", sentence(remark)))
        .each(validation.offset_removed, |section, mean| section.note("Offset", removed(mean)))
        .each(validation.summary.iter().filter(|_| !is_only), |section, summary| section.text(sentence(summary)))
        .figure(time_series(trial));
    let shapes = (!validation.loops.is_empty()).then(|| shapes(trial));
    residuals::residuals(loops(section, trial).each(shapes, Section::table), trial)
}

/// Measurement and free run over a few periods, and the residual over the whole record.
fn time_series(trial: &Compared) -> Figure {
    let Compared { record, validation, .. } = trial;
    let (units, start) = (record.units(), validation.start);
    let time = |range: Range<usize>| range.map(|k| k as f64 * record.ts()).collect::<Vec<f64>>();
    let (y, simulated) = (record.y(), &validation.simulated);
    let error: Vec<f64> = y[start..].iter().zip(&simulated[start..]).map(|(y, s)| y - s).collect();
    let worst = worst(trial);
    let (shown, words) = cycles::periods(record, start, worst);
    let [rms, at] = [validation.metrics.rms_pp_percent, worst as f64 * record.ts()].map(short);
    let caption = format!(
        "Above: measurement and free run{words}. Below: the residual over the whole record, {rms} % of peak-to-peak \
        (rms). It is largest at {at} s."
    );
    let (t, axis) = (|| Axis::new("t [s]").tight(), |label: &str| Axis::new(format!("{label} [{}]", units.y)));
    let top = Axes::new(t(), axis("y"))
        .height(0.75)
        .with(Series::wide(&time(shown.clone()), &y[shown.clone()]).named("measured"))
        .with(Series::line(&time(shown.clone()), &simulated[shown]).role(Role::Model).named("model"));
    let low = Axes::new(t(), axis("error")).height(0.55);
    let low = low.with(Series::line(&time(start..record.len()), &error).role(Role::Residual));
    Figure::new("Time series", caption).panel(top).panel(low)
}

/// Adds the loops of output over input if there are any, and beside them what a straight line leaves of them.
fn loops(section: Section, trial: &Compared) -> Section {
    let Compared { record, validation, .. } = trial;
    let model = FreeRun { name: "model", y: &validation.simulated, role: Role::Model, dashes: 0 };
    let Some((figures, words)) = loops::figures(record, validation.start, worst(trial), &[model]) else {
        return section;
    };
    let rms = short(validation.metrics.rms_pp_percent);
    let caption = format!(
        "Output against input, measured and in free run; beside it the same less the least-squares straight line of \
        each measured loop, so that the width of the loops is seen.{words} Over the whole record measurement and free \
        run differ by {rms} % of the peak-to-peak output (rms)."
    );
    section.figures(2, "Loops", caption, figures)
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
    table.rows(rows).note(
        "Width at mid input and closure (difference between end and start of a cycle) over the height of the loop; \
        negative area: the loop runs in the opposite direction; reversals of the output per cycle.",
    )
}
