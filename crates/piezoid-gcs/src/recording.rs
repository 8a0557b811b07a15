//! The recorder of a controller: which of its quantities are recorded, and the tables it answers.

use crate::controller::Controller;
use crate::line::Line;
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
    pub(crate) fn of(line: &mut Line) -> Result<Self, Error> {
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
const ROW: u64 = 64;
const HEAD: u64 = 1 << 14;

/// The lines of the first `count` points of the tables 1 and 2.
pub(crate) fn points(controller: &mut Controller, count: usize) -> Result<Vec<String>, Error> {
    controller.line.query_long(&format!("DRR? 1 {count} 1 2"), HEAD + ROW * count as u64)
}

/// These lines as a record of `count` samples in volts and `unit`.
pub(crate) fn record(lines: Vec<String>, count: usize, unit: &str, identity: &str) -> Result<Record, Error> {
    let columns = ColumnSelection {
        input_col: Some("1".into()),
        output_col: Some("2".into()),
        input_unit: Some("V".into()),
        output_unit: Some(unit.into()),
        ..ColumnSelection::default()
    };
    let read = DataFile::from(File::new("the answer of the recorder", lines.join("\n"))).record(&columns)?;
    if read.len() != count {
        let have = read.len();
        return Err(Error::Content(format!("the recorder answers {have} samples, not the {count} of the drive")));
    }
    let record = Record::new(read.ts(), read.u().into(), read.y().into())?.with_units(read.units().clone());
    Ok(record.with_step(format!("measured by the controller {identity}")))
}
