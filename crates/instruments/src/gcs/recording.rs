//! The recorder of a controller: which of its quantities are recorded, and the tables it answers.

use crate::gcs::line::Line;
use crate::instrument::measured_by_controller;
use piezoid::formats::ColumnSelection;
use piezoid::{Error, Record};
use piezoid_verbs::{DataFile, File};

/// What is recorded, by the options that `HDR?` lists.
pub(crate) struct Sources {
    /// Voltage of an output channel.
    pub(crate) voltage: u32,
    /// Position of an axis.
    pub(crate) position: u32,
}

impl Sources {
    /// The options of this controller.
    pub(crate) fn of(line: &mut Line<'_>) -> Result<Self, Error> {
        let rows: Vec<(u32, String)> = line
            .optional_query("HDR?")?
            .ok_or_else(|| Error::Content("the controller has no recorder that lists what it records (`HDR?`)".into()))?
            .iter()
            .skip_while(|line| !line.starts_with("#RecordOptions"))
            .skip(1)
            .take_while(|line| !line.starts_with('#'))
            .filter_map(|line| {
                let (number, what) = line.split_once('=')?;
                Some((number.trim().parse().ok()?, what.trim().to_lowercase()))
            })
            .collect();
        let find = |expected: &[&str]| {
            let named = |name: &&str| rows.iter().find(|(_, what)| what.starts_with(*name));
            expected.iter().find_map(named).map(|(number, _)| *number).ok_or_else(|| {
                let message: Vec<&str> = rows.iter().map(|(_, what)| &**what).collect();
                let expected = expected[0];
                Error::Content(format!("the recorder cannot record the {expected}: it records {}", message.join("; ")))
            })
        };
        Ok(Sources {
            voltage: find(&["voltage of output", "control voltage of output", "output voltage"])?,
            position: find(&["current position of axis", "actual position of axis", "real position of axis"])?,
        })
    }
}

/// Bytes of a row of two tables, and of the head, at most.
const ROW: usize = 64;
const HEAD: usize = 1 << 14;

/// Points of an answer: few enough to come within the time for an answer on a slow line.
const PIECE: usize = 1000;

/// The first `count` points of the tables 1 and 2 as a record in volts and `unit`.
pub(crate) fn read(line: &mut Line, count: usize, unit: &str, identity: &str) -> Result<Record, Error> {
    let columns = ColumnSelection {
        input_col: Some("1".into()),
        output_col: Some("2".into()),
        input_unit: Some("V".into()),
        output_unit: Some(unit.into()),
        ..ColumnSelection::default()
    };
    // Pieces of nearly the same length: a file of one point is no record.
    let pieces = count.div_ceil(PIECE).max(1);
    let (mut u, mut y, mut period) = (Vec::new(), Vec::new(), None);
    for k in 0..pieces {
        line.watch.stage("the record is read", u.len(), count)?;
        let (from, to) = (k * count / pieces, (k + 1) * count / pieces);
        let rows = to - from;
        let lines = line.query_long(&format!("DRR? {} {rows} 1 2", from + 1), HEAD + ROW * rows)?;
        let part = DataFile::from(File::new("the answer of the recorder", lines.join("\n"))).record(&columns)?;
        if part.len() != rows {
            let have = u.len() + part.len();
            return Err(Error::Content(format!("the recorder answers {have} samples, not the {count} of the drive")));
        }
        u.extend(part.u());
        y.extend(part.y());
        period.get_or_insert((part.ts(), part.units().clone()));
    }
    let (ts, units) = period.ok_or_else(|| Error::Content("the drive has no samples".into()))?;
    let record = Record::new(ts, u, y)?.with_units(units);
    Ok(measured_by_controller(identity, record))
}
