//! The recorder of a controller: which of its quantities are recorded, and the tables it answers.

use crate::controller::Controller;
use crate::line::Line;
use piezoid::formats::ColumnSelection;
use piezoid::{Error, File, Record};

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
            .query("HDR?")?
            .iter()
            .skip_while(|line| !line.starts_with("#RecordOptions"))
            .skip(1)
            .take_while(|line| !line.starts_with('#'))
            .filter_map(|line| {
                let (number, what) = line.split_once('=')?;
                Some((number.trim().parse().ok()?, what.trim().to_lowercase()))
            })
            .collect();
        let find = |wanted: &[&str]| {
            let named = |name: &&str| rows.iter().find(|(_, what)| what.starts_with(*name));
            wanted.iter().find_map(named).map(|(number, _)| *number).ok_or_else(|| {
                let told: Vec<&str> = rows.iter().map(|(_, what)| &**what).collect();
                let wanted = wanted[0];
                Error::Content(format!("the recorder cannot record the {wanted}: it records {}", told.join("; ")))
            })
        };
        Ok(Sources {
            voltage: find(&["voltage of output", "control voltage of output", "output voltage"])?,
            position: find(&["current position of axis", "actual position of axis", "real position of axis"])?,
        })
    }
}

/// The first `count` points of the tables 1 and 2 as a record in volts and `unit`.
pub(crate) fn read(controller: &mut Controller, count: usize, unit: &str) -> Result<Record, Error> {
    let lines = controller.line.query(&format!("DRR? 1 {count} 1 2"))?;
    let columns = ColumnSelection {
        input_col: Some("1".into()),
        output_col: Some("2".into()),
        input_unit: Some("V".into()),
        output_unit: Some(unit.into()),
        ..ColumnSelection::default()
    };
    let read = File::new("the answer of the recorder", lines.join("\n")).record(&columns)?;
    let record = Record::new(read.ts(), read.u().into(), read.y().into())?.with_units(read.units().clone());
    Ok(record.with_step(format!("measured by the controller {}", controller.identity)))
}
