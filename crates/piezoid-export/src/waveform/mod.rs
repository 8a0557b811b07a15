//! The compensated drive of a periodic reference as tables, for controllers that repeat a waveform and compute nothing.
//!
//! ```text
//! r, one period -> u, learnt on the model -> points, each held for whole cycles -> commands
//! ```
//! The drive is that of the steady state: both it and what the model answers repeat, creep included. Tables are rounded to the
//! digits that are written, and what this and the holding cost is measured on the numbers in the file and stated.
//!
//! Voltages come from Fourier transforms, whose last digits may differ from one machine to another; those that are written
//! do not, unless one lies on the edge of rounding.
//!
//! Reference: as [`drive`], [`table`], [`gcs`] and [`nv200`]. It does not do: closed loop, and the way from standing still
//! into the waveform.

mod drive;
mod gcs;
mod nv200;
mod table;

use super::template::{Value, context, render, template};
use super::{ExportOptions, ExportRequest, ExportTarget, Exported, File, named};
use drive::{PeriodicDrive, answer};
use piezoid::error::{Error, positive};
use piezoid::hammerstein::Model;
use piezoid::number::{round, short};
use piezoid::series::ends;
use piezoid::system::System;
use table::{Figures, TableCapacity, WaveTable};

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "waveform",
    summary: "the drive of a periodic reference as a table: CSV, PI GCS wave table, piezosystem jena NV200",
    reference: "PI GCS 2.0, E-727 user manual E727T0005; piezosystem jena NV200/D NET instruction manual",
    takes: &["reference", "clip", "servo_cycle", "range"],
    make,
};

/// Digits of the voltages in the CSV file after the point: 0.1 mV.
const DECIMALS: usize = 4;

/// Displacements are rounded to this share of the stroke, or finer.
const FINE: f64 = 1e-6;

fn make(request: &ExportRequest) -> Result<Exported, Error> {
    named(request.name(), "")?;
    let (model, name, ts) = (request.model, request.name(), request.model.ts());
    let Some(r) = request.reference else {
        return Err(Error::parameter("reference", "none", "must be given: one period of the requested displacement"));
    };
    let found = &model.units().u;
    if found != "V" {
        let what = "the model's input".into();
        return Err(Error::Units { what, found: found.clone(), wanted: "V, the unit of the tables,".into() });
    }
    let ExportOptions { servo_cycle, range, .. } = request.options;
    positive("servo_cycle", servo_cycle, "seconds")?;
    let drive = PeriodicDrive::new(model, request.settings, r)?;
    let plain =
        WaveTable::new(TableCapacity { cycle: ts, points: usize::MAX, cycles: 1 }, &drive.u, ts, (0.0, 1.0), DECIMALS)?;
    let wave = gcs::table(&drive.u, ts, servo_cycle)?;
    let buffer = range.map(|range| nv200::table(&drive.u, ts, range)).transpose()?;

    let mut made = Exported { files: Vec::new(), notes: drive.notes.clone() };
    let mut tables = Vec::new();
    let mut add = |whose, end, table: &WaveTable, text| {
        let (told, sentence) = stated(whose, format!("{name}{end}"), table, model, &drive);
        tables.push(told);
        made.files.push(File::new(format!("{name}{end}"), text));
        sentence
    };
    let mut sentences = vec![add("the model's own", ".csv", &plain, rows(request, &drive, &plain)?)];
    sentences.push(add("PI GCS 2.0", "_gcs.txt", &wave, gcs::commands(&wave)?));
    match &buffer {
        Some(buffer) => sentences.push(add("NV200", "_nv200.txt", buffer, nv200::commands(buffer)?)),
        None => made.notes.push(
            "there is no file for the NV200, which counts in percent of a range: give the voltages of 0 % and 100 %"
                .into(),
        ),
    }
    made.notes.extend(sentences);
    let stands = |(low, high): (f64, f64)| [low, high];
    let page = context! {
        name, ts => ts.to_string(), unit => &model.units().y, samples => drive.u.len(), period => drive.u.len() as f64 * ts,
        u => stands(ends(drive.u.iter().copied())), r => stands(ends(drive.r.iter().copied())), tables, servo_cycle,
        range => range.map(|(low, high)| [low.to_string(), high.to_string()]), beginning => beginning(model, &drive),
        slowest => model.creep().lags().iter().map(|lag| lag.tau_s).fold(0.0, f64::max),
    };
    made.files.push(File::new(format!("{name}.md"), render(template!("waveform/readme.md.j2"), page)?));
    Ok(made)
}

/// What the page is told of a table, errors in percent, and what a terminal says of it.
fn stated(whose: &str, file: String, table: &WaveTable, model: &Model, drive: &PeriodicDrive) -> (Value, String) {
    let Figures { period, u, y, differs } = table.figures(model, drive);
    let off = if period == 0.0 { String::new() } else { format!(", period {} % off", short(100.0 * period)) };
    let sentence = format!(
        "{file}: {} points of {} s{off}; on the model {} % of the stroke off, rms, {} % at most",
        table.held.len(),
        round(table.point()),
        short(y.rms),
        short(y.largest)
    );
    let figures = context! {
        whose, file, point => table.point(), period => 100.0 * period, differs,
        u_rms => u.rms, u_largest => u.largest, y_rms => y.rms, y_largest => y.largest,
    };
    (context! { ..figures, ..table.template_context() }, sentence)
}

/// How far off the model is at most in the first period from standing still at the first voltage [% of the stroke].
fn beginning(model: &Model, drive: &PeriodicDrive) -> f64 {
    let y = model.resume(&mut model.settled(drive.u.first().copied().unwrap_or(0.0)), &drive.u);
    let (low, high) = ends(drive.r.iter().copied());
    100.0 * y.iter().zip(&drive.r).map(|(y, r)| (y - r).abs()).fold(0.0, f64::max) / (high - low)
}

/// The table as CSV: time, voltage, what is wanted, and what the model answers.
fn rows(request: &ExportRequest, drive: &PeriodicDrive, table: &WaveTable) -> Result<String, Error> {
    let (model, y) = (request.model, &request.model.units().y);
    let (low, high) = ends(drive.r.iter().copied());
    let digits = (0..300).map(|k| 10f64.powi(k)).find(|digits| 1.0 / digits <= FINE * (high - low)).unwrap_or(1.0);
    let rounded = |x: &[f64]| x.iter().map(|x| (digits * x).round() / digits + 0.0).collect::<Vec<_>>();
    let (r, answered) = (rounded(&drive.r), rounded(&answer(model, &table.held).y));
    piezoid::formats::Table::write(
        model.ts(),
        &[("u_V", &table.held), (&format!("r_{y}"), &r), (&format!("y_{y}"), &answered)],
    )
}

#[cfg(test)]
mod tests;
