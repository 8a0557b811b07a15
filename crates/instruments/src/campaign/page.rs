//! The page of a campaign: both paths side by side, what was measured, and the report on the model.

use super::{Campaign, Track};
use piezoid_numerics::number::{round, short};
use piezoid_report::Page;
use piezoid_report::page::{Fact, PageTable, Section};
use piezoid_report::plot::{Axes, Axis, Figure, Role, Series};
use piezoid_report::report::report;

impl Campaign {
    /// The page: one self-contained file.
    pub fn page(&self) -> Page {
        let subtitle = format!("{}, axis {}", self.setup.identity, self.setup.axis);
        let model = report(&self.identification.found.model, &self.validated);
        Page::new("Campaign").subtitle(subtitle).section(self.tracking()).section(self.measured()).followed_by(model)
    }

    fn tracking(&self) -> Section {
        let (straight, compensated) = (&self.straight, &self.compensated);
        let unit = &compensated.record.units().y;
        let row = |name: &str, track: &Track| {
            let m = &track.metrics;
            [name.to_string(), short(m.rmse), short(m.rms_pp_percent), short(m.max_abs)]
        };
        let table = PageTable::new("Errors of the measured path").text("voltages");
        let table = table.number(format!("rms [{unit}]")).number("rms / peak-to-peak [%]");
        let table = table.number(format!("largest [{unit}]"));
        let table = table.row(row("straight line", straight)).row(row("compensated", compensated)).note(
            "Of the path itself, without the move to it. The displacement at rest is measured before each path, and is \
             no part of the error.",
        );
        let time = |track: &Track| -> Vec<f64> { track.path.clone().map(|t| t as f64 * track.ts).collect() };
        let of = |track: &Track, x: &[f64]| x[track.path.clone()].to_vec();
        let error =
            |track: &Track| -> Vec<f64> { track.path.clone().map(|t| track.r[t] - track.record.y()[t]).collect() };
        let path = Axes::new(Axis::new("t [s]").tight(), Axis::new(format!("y [{unit}]")))
            .with(
                Series::line(&time(straight), &of(straight, straight.record.y()))
                    .role(Role::Muted)
                    .named("straight line"),
            )
            .with(
                Series::line(&time(compensated), &of(compensated, compensated.record.y()))
                    .role(Role::accent(0))
                    .named("compensated"),
            )
            .with(Series::dashed(&time(compensated), &of(compensated, &compensated.r)).named("requested"));
        let errors = Axes::new(Axis::new("t [s]").tight(), Axis::new(format!("error [{unit}]")))
            .with(Series::line(&time(straight), &error(straight)).role(Role::Muted))
            .with(Series::line(&time(compensated), &error(compensated)).role(Role::accent(0)));
        let along = |track: &Track| {
            Axes::new(Axis::new(format!("requested [{unit}]")), Axis::new(format!("measured [{unit}]")))
                .with(Series::line(&of(track, &track.r), &of(track, track.record.y())).role(Role::accent(0)))
        };
        let caption = "Measured displacement on the requested path, and below it the error.";
        let beside =
            "Measured against requested displacement: with a straight line at the left, compensated at the right.";
        Section::new("Tracking")
            .facts([
                Fact::new(short(self.better()), "times", "smaller rms error than with a straight line"),
                Fact::new(short(compensated.metrics.rms_pp_percent), "%", "rms error over peak-to-peak, compensated"),
                Fact::new(short(compensated.metrics.max_abs), unit.clone(), "largest error, compensated"),
            ])
            .table(table)
            .figure(Figure::new("The path", caption).panel(path).panel(errors).stacked())
            .figures(
                2,
                "Straight line and compensation",
                beside,
                vec![
                    Figure::new("Straight line", "").panel(along(straight)).medium(),
                    Figure::new("Compensated", "").panel(along(compensated)).medium(),
                ],
            )
    }

    fn measured(&self) -> Section {
        let table = PageTable::new("Records").text("record").text("purpose").number("duration [s]");
        let table = table.number("sampling period [s]").text("voltage [V]").text("measured");
        let row = |drive: &piezoid_verbs::PlannedDrive| {
            let [low, high] = [&drive.usage.lowest, &drive.usage.highest].map(|peak| round(peak.value));
            let when = if self.resumed.iter().any(|name| name == drive.name) { "earlier" } else { "now" };
            let (duration, ts) = (round(self.plan.duration(drive)), round(drive.ts));
            [drive.name.into(), drive.purpose.into(), duration, ts, format!("{low} to {high}"), when.to_string()]
        };
        let section = Section::new("Measured").table(table.rows(self.plan.drives.iter().map(row)));
        if self.notes.is_empty() { section } else { section.list(self.notes.clone()) }
    }
}
