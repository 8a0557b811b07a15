//! The drive for a periodic reference as tables, for controllers that repeat a waveform and compute nothing.
//!
//! ```text
//! r, one period -> u, learnt on the model -> points, each held for whole cycles -> commands
//! ```
//! The drive is that of the steady state: it and the response of the model are periodic, with creep. Tables are rounded
//! to the written digits. The errors by rounding and holding are computed from the numbers in the file and stated.
//!
//! Voltages come from Fourier transforms, whose last digits may differ between machines. The written digits do not,
//! unless a value lies on the edge of rounding.
//!
//! Reference: see [`drive`], [`table`], [`gcs`] and [`nv200`]. It does not do: closed loop, the transient from rest
//! into the waveform.

mod drive;
mod gcs;
mod nv200;
mod table;

use super::template::{Value, context, render, template};
use super::{CODE, ExportOptions, ExportRequest, ExportTarget, Exported, FEED_FORWARD, File, named};
use drive::{PeriodicDrive, answer};
use piezoid::{Error, Model, System};
use piezoid_numerics::error::positive;
use piezoid_numerics::number::{power, round, short};
use piezoid_numerics::series::ends;
use table::{Figures, TableCapacity, WaveTable};

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "waveform",
    summary: "the drive voltage for a periodic reference as a table: CSV, PI GCS wave table, piezosystem jena NV200",
    reference: "PI GCS 2.0, E-727 user manual E727T0005; piezosystem jena NV200/D NET instruction manual",
    takes: &["reference", "clip", "servo_cycle", "range"],
    makes: &[FEED_FORWARD],
    make,
    ..CODE
};

/// Decimals of the voltages in the CSV file: 0.1 mV.
const DECIMALS: usize = 4;

/// Displacements are rounded to this share of the stroke or finer.
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
        return Err(Error::Units { what, found: found.clone(), expected: "V, the unit of the tables,".into() });
    }
    let ExportOptions { servo_cycle, range, .. } = request.options;
    positive("servo_cycle", servo_cycle, "seconds")?;
    let drive = PeriodicDrive::new(model, request.settings, r)?;
    let all = TableCapacity { cycle: ts, points: usize::MAX, cycles: 1 };
    let plain = WaveTable::new(all, &drive.u, ts, (0.0, 1.0), DECIMALS)?;
    let wave = gcs::table(&drive.u, ts, servo_cycle)?;
    let buffer = range.map(|range| nv200::table(&drive.u, ts, range)).transpose()?;

    let mut exported = Exported { notes: drive.notes.clone(), ..Exported::default() };
    let mut tables = Vec::new();
    let mut add = |whose, end, table: &WaveTable, text| {
        let (context, sentence) = stated(whose, format!("{name}{end}"), table, model, &drive);
        tables.push(context);
        exported.files.push(File::new(format!("{name}{end}"), text));
        sentence
    };
    let mut sentences = vec![add("the model's own", ".csv", &plain, rows(request, &drive, &plain)?)];
    sentences.push(add("PI GCS 2.0", "_gcs.txt", &wave, gcs::commands(&wave)?.into()));
    let missing = "no NV200 file is written, because its points are in percent of a voltage range: give the option \
        `range` with the voltages of 0 % and 100 %";
    match &buffer {
        Some(buffer) => sentences.push(add("NV200", "_nv200.txt", buffer, nv200::commands(buffer)?.into())),
        None => exported.notes.push(missing.into()),
    }
    exported.notes.extend(sentences);
    let pair = |(low, high): (f64, f64)| [low, high];
    let page = context! {
        name, ts => ts.to_string(), unit => &model.units().y, samples => drive.u.len(),
        period => drive.u.len() as f64 * ts, u => pair(ends(drive.u.iter().copied())),
        r => pair(ends(drive.r.iter().copied())), tables, servo_cycle,
        range => range.map(|(low, high)| [low.to_string(), high.to_string()]), beginning => beginning(model, &drive),
        slowest => model.creep().lags().iter().map(|lag| lag.tau_s).fold(0.0, f64::max),
    };
    exported.files.push(File::new(format!("{name}.md"), render(template!("waveform/readme.md.j2"), page)?));
    Ok(exported)
}

/// The template context of a table, errors in percent, and a note on it.
fn stated(whose: &str, file: String, table: &WaveTable, model: &Model, drive: &PeriodicDrive) -> (Value, String) {
    let Figures { period, u, y, differs } = table.figures(model, drive);
    let period_off = if period == 0.0 { String::new() } else { format!(", period error {} %", short(100.0 * period)) };
    let (points, point, rms, most) = (table.held.len(), round(table.point()), short(y.rms), short(y.largest));
    let sentence = format!(
        "{file}: {points} points of {point} s{period_off}; predicted error {rms} % of the stroke rms, at most {most} %"
    );
    let figures = context! {
        whose, file, point => table.point(), period => 100.0 * period, differs,
        u_rms => u.rms, u_largest => u.largest, y_rms => y.rms, y_largest => y.largest,
    };
    (context! { ..figures, ..table.template_context() }, sentence)
}

/// Largest error of the model in the first period, from rest at the first voltage [% of the stroke].
fn beginning(model: &Model, drive: &PeriodicDrive) -> f64 {
    let y = model.resume(&mut model.settled(drive.u.first().copied().unwrap_or(0.0)), &drive.u);
    let (low, high) = ends(drive.r.iter().copied());
    100.0 * y.iter().zip(&drive.r).map(|(y, r)| (y - r).abs()).fold(0.0, f64::max) / (high - low)
}

/// The table as CSV: time, voltage, reference, and the response of the model.
fn rows(request: &ExportRequest, drive: &PeriodicDrive, table: &WaveTable) -> Result<Vec<u8>, Error> {
    let (model, y) = (request.model, &request.model.units().y);
    let (low, high) = ends(drive.r.iter().copied());
    let digits = (0..300).map(|k| power(10.0, k)).find(|digits| 1.0 / digits <= FINE * (high - low)).unwrap_or(1.0);
    let rounded = |x: &[f64]| x.iter().map(|x| (digits * x).round() / digits + 0.0).collect::<Vec<_>>();
    let (r, answered) = (rounded(&drive.r), rounded(&answer(model, &table.held).y));
    let columns = [("u_V", &table.held[..]), (&format!("r_{y}"), &r), (&format!("y_{y}"), &answered)];
    piezoid::formats::Table::write("table.csv", model.ts(), &columns)
}

#[cfg(test)]
mod tests;
