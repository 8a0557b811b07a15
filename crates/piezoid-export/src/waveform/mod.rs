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
mod readme;
mod table;

use super::{File, Made, Target, Wanted, named};
use drive::{Drive, answer};
use piezoid::error::{Error, positive};
use piezoid::formats::csv;
use piezoid::series::ends;
use piezoid::system::System;
use readme::{Shown, readme};
use table::{Room, Table};

pub(super) const TARGET: Target = Target {
    name: "waveform",
    summary: "the drive of a periodic reference as a table: CSV, PI GCS wave table, piezosystem jena NV200",
    reference: "PI GCS 2.0, E-727 user manual E727T0005; piezosystem jena NV200/D NET instruction manual",
    heeds: &["reference"],
    make,
};

/// How controllers play a table.
///
/// ```
/// use piezoid_export::{Playback, Wanted, target};
/// use piezoid::{Model, hysteresis::operator, linear::Arx};
/// let plays = (operator("prandtl-ishlinskii")?.example)(5e-4)?;
/// let model = Model::new(plays, Arx::new(5e-4, vec![1.6, -0.8], vec![2.0, 2.0])?, 2.0)?;
/// let r: Vec<f64> = (0..100).map(|t| 200.0 * (std::f64::consts::TAU * 0.01 * f64::from(t)).sin()).collect();
/// let playback = Playback { range: Some((-30.0, 120.0)), ..Playback::default() };
/// let made = (target("waveform")?.make)(&Wanted { reference: Some(&r), playback, ..Wanted::new(&model, "scan") })?;
/// let paths: Vec<&str> = made.files.iter().map(|file| file.path.as_str()).collect();
/// assert_eq!(paths, ["scan.csv", "scan_gcs.txt", "scan_nv200.txt", "scan.md"]);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Playback {
    /// Servo cycle of the GCS controller [s].
    pub servo_cycle: f64,
    /// The voltages that are 0 % and 100 % for the NV200 amplifier, counted as the model's input does [V]; without them
    /// there is no file for it.
    pub range: Option<(f64, f64)>,
}

impl Default for Playback {
    /// The servo cycle of an E-727, 50 us; no range.
    fn default() -> Self {
        Playback { servo_cycle: 5e-5, range: None }
    }
}

/// Digits of the voltages in the CSV file after the point: 0.1 mV.
const DECIMALS: usize = 4;

/// Displacements are rounded to this share of the stroke, or finer.
const FINE: f64 = 1e-6;

fn make(wanted: &Wanted) -> Result<Made, Error> {
    named(wanted.name, "")?;
    let (model, name, ts) = (wanted.model, wanted.name, wanted.model.ts());
    let Some(r) = wanted.reference else {
        return Err(Error::parameter("reference", "none", "must be given: one period of the wanted displacement"));
    };
    if wanted.controller.is_some() || wanted.single || wanted.preview > 0 {
        let because = "it holds voltages alone: leave controller, preview and single precision out".into();
        return Err(Error::Unsuited { what: "table that computes".into(), because });
    }
    let found = &model.units().u;
    if found != "V" {
        let what = "the model's input".into();
        return Err(Error::Units { what, found: found.clone(), wanted: "V, the unit of the tables,".into() });
    }
    let Playback { servo_cycle, range } = wanted.playback;
    positive("servo_cycle", servo_cycle, "seconds")?;
    let drive = Drive::new(model, wanted.how, r)?;
    let plain = Table::new(Room { cycle: ts, points: usize::MAX, cycles: 1 }, &drive.u, ts, (0.0, 1.0), DECIMALS)?;
    let wave = gcs::table(&drive.u, ts, servo_cycle)?;
    let buffer = range.map(|range| nv200::table(&drive.u, ts, range)).transpose()?;

    let mut files = vec![File::text(format!("{name}.csv"), rows(wanted, &drive, &plain)?)];
    let mut shown = vec![Shown::of("the model's own", &files[0], &plain, model, &drive)];
    files.push(File::text(format!("{name}_gcs.txt"), gcs::commands(&wave)));
    shown.push(Shown::of("PI GCS 2.0", &files[1], &wave, model, &drive));
    let mut notes = drive.notes.clone();
    if let Some(buffer) = &buffer {
        files.push(File::text(format!("{name}_nv200.txt"), nv200::commands(buffer)));
        shown.push(Shown::of("NV200", &files[2], buffer, model, &drive));
    } else {
        notes.push(
            "there is no file for the NV200, which counts in percent of a range: give the voltages of 0 % and 100 %"
                .into(),
        );
    }
    notes.extend(shown.iter().map(Shown::sentence));
    files.push(File::text(format!("{}.md", wanted.name), readme(wanted, &drive, &shown)));
    Ok(Made { files, notes })
}

/// The table as CSV: time, voltage, what is wanted, and what the model answers.
fn rows(wanted: &Wanted, drive: &Drive, table: &Table) -> Result<String, Error> {
    let (model, y) = (wanted.model, &wanted.model.units().y);
    let (low, high) = ends(drive.r.iter().copied());
    let digits = (0..300).map(|k| 10f64.powi(k)).find(|digits| 1.0 / digits <= FINE * (high - low)).unwrap_or(1.0);
    let rounded = |x: &[f64]| x.iter().map(|x| (digits * x).round() / digits + 0.0).collect::<Vec<_>>();
    let (r, answered) = (rounded(&drive.r), rounded(&answer(model, &table.held).y));
    csv::write(model.ts(), &[("u_V", &table.held), (&format!("r_{y}"), &r), (&format!("y_{y}"), &answered)])
}

#[cfg(test)]
mod tests;
