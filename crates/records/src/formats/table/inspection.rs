//! How a table is read: columns with their roles, a profile, what was guessed, what is doubtful.

use super::super::ColumnSelection;
use super::super::column::Column;
use super::super::roles::Role;
use super::super::time;
use super::Table;
use crate::record::Record;
use piezoid_numerics::number::exact;
use serde_json::{Value, json};

/// Relative deviation of a period that the user states from that of the file that is doubted.
const MAX_PERIOD_DEVIATION: f64 = 0.01;
/// Sampling period that nobody means [s].
const MAX_PERIOD_S: f64 = 20.0;

impl Table {
    /// All columns, with their units, ranges and roles.
    pub fn described(&self, selection: &ColumnSelection) -> Vec<Value> {
        let roles = [Role::Time, Role::Input, Role::Output];
        let found: Vec<_> = roles.iter().map(|role| (role, role.find(self, selection).ok())).collect();
        let one = |column: &Column| {
            let role = found.iter().find(|(_, found)| found.is_some_and(|found| std::ptr::eq(found, column)));
            let unit = role.and_then(|(role, _)| selection.stated_unit(**role));
            let numbers = || column.samples.iter().copied().filter(|sample| sample.is_finite());
            let (low, high) = piezoid_numerics::series::ends(numbers());
            json!({
                "name": self.title(column),
                "unit": unit.or(column.stated().map(String::from)),
                "samples": numbers().count(),
                "low": low,
                "high": high,
                "role": role.map(|(role, _)| role.what()),
                "flaw": column.doubt.as_ref().or(column.flaw.as_ref()).map(ToString::to_string),
            })
        };
        self.columns.iter().chain(&self.others).map(one).collect()
    }

    /// The selection, completed by the names and units that were found.
    pub fn profile(&self, selection: &ColumnSelection) -> ColumnSelection {
        let found = |role: Role| role.find(self, selection).ok();
        let name = |role: Role| role.requested(selection).cloned().or_else(|| Some(self.title(found(role)?)));
        let unit = |role: Role, text: &Option<String>, scale: &Option<String>| match (text, scale) {
            (None, None) => Some(found(role)?.unit(role)),
            _ => text.clone(),
        };
        let stamped = selection.period() == Ok(None) || selection.time_col.is_some();
        ColumnSelection {
            time_col: if stamped { name(Role::Time) } else { None },
            input_col: name(Role::Input),
            output_col: name(Role::Output),
            input_unit: unit(Role::Input, &selection.input_unit, &selection.input_scale),
            output_unit: unit(Role::Output, &selection.output_unit, &selection.output_scale),
            ..selection.clone()
        }
    }

    /// What was guessed, scaled and cut to make a record.
    pub(in crate::formats) fn history(&self, selection: &ColumnSelection) -> Vec<String> {
        let mut guessed = Vec::new();
        let mut steps = Vec::new();
        for role in [Role::Time, Role::Input, Role::Output] {
            let Ok(column) = role.find(self, selection) else { continue };
            if role.requested(selection).is_none()
                && !role.owns(column)
                && (role != Role::Time || selection.period() == Ok(None))
            {
                guessed.push(format!("{} `{}`", role.what(), self.title(column)));
            }
            let unit = if role == Role::Input { &selection.input_unit } else { &selection.output_unit };
            if role != Role::Time && unit.is_none() && !role.owns(column) && column.stated().is_none() {
                let assumed = column.unit(role);
                steps.push(format!("the unit of the {} is not stated: {assumed} is assumed", role.what()));
            }
        }
        steps.extend(self.relabelled(selection));
        steps.extend(self.timing(selection));
        steps.extend(self.doubt(selection));
        if !guessed.is_empty() {
            steps.insert(0, format!("{}, by names and units", guessed.join(", ")));
        }
        for (what, scale) in [("input", &selection.input_scale), ("output", &selection.output_scale)] {
            steps.extend(scale.as_ref().map(|scale| format!("{what} scaled by {scale}")));
        }
        if selection.from.is_some() || selection.to.is_some() {
            steps.push(Record::cut(selection.from, selection.to));
        }
        steps
    }

    /// The units that the user states and the file contradicts: the numbers stay as they are.
    fn relabelled(&self, selection: &ColumnSelection) -> Vec<String> {
        let one = |role: Role| {
            let (stated, column) = (selection.stated_unit(role)?, role.find(self, selection).ok()?);
            let own = column.own_unit(role).filter(|own| *own != stated)?;
            Some(format!("unit of the {}: {stated} as stated; the file has {own}", role.what()))
        };
        let is_used = |role: &Role| *role != Role::Time || selection.period() == Ok(None);
        [Role::Time, Role::Input, Role::Output].into_iter().filter(is_used).filter_map(one).collect()
    }

    /// Where the sampling period comes from, if that is not a time in a stated unit.
    fn timing(&self, selection: &ColumnSelection) -> Option<String> {
        if selection.period() != Ok(None) {
            return None;
        }
        match (Role::Time.find(self, selection), self.ts) {
            (Ok(time), None) if time.quantity().is_none() && selection.time_unit.is_none() && time.name != "t_s" => {
                Some("the unit of the time is not stated: s is assumed".into())
            }
            (Err(_), Some(ts)) if self.first > 0 => {
                Some(format!("sampling period {} s, as the head of the file states", exact(ts)))
            }
            _ => None,
        }
    }

    /// A doubt about the sampling period that the user or the file states.
    fn doubt(&self, selection: &ColumnSelection) -> Option<String> {
        let stated = selection.period().ok()?;
        // Without another statement there is nothing to doubt, and the times need not be read again.
        stated.or(self.ts)?;
        let time = Role::Time.find(self, selection).ok();
        let stamps = time.and_then(|time| self.period(time, 0..time.samples.len(), selection, None).ok());
        let differs = |a: f64, b: f64| (a / b - 1.0).abs() > MAX_PERIOD_DEVIATION;
        let Some(stated) = stated else {
            let own = self.ts?;
            if time.is_some_and(|time| time::period(&time.samples, "", &|_| 0).is_err()) {
                let used = format!("the sampling period of {} s that the file states is used", exact(own));
                return Some(format!("the times are uneven or rounded: {used}"));
            }
            let stamps = stamps?;
            let steps = "the time column is used, which has steps of";
            return differs(stamps, own).then(|| {
                format!("the file states a sampling period of {} s: {steps} {} s", exact(own), exact(stamps))
            });
        };
        let likely = match selection.fs {
            Some(fs) => format!("if {} is the sampling period in s, state it as such", exact(fs)),
            None => format!("if {} is the sampling rate in Hz, state it as such", exact(stated)),
        };
        match stamps.or(self.ts) {
            Some(own) if differs(own, stated) => {
                let likely = if !differs(own, 1.0 / stated) { format!("; {likely}") } else { String::new() };
                let [own, stated] = [own, stated].map(exact);
                Some(format!("the sampling period is {own} s in the file, but {stated} s in the options{likely}"))
            }
            None if stated > MAX_PERIOD_S => {
                Some(format!("the stated sampling period is {} s: {likely}", exact(stated)))
            }
            _ => None,
        }
    }
}
