//! Rows of options that excitations share, and what their tables need.

pub(super) use crate::options::{OptionKind, OptionRow, Options, options};

/// Half of peak to peak.
pub(super) const AMPLITUDE: OptionRow = OptionRow::positive("V").required();

/// What everything is centred on.
pub(super) const OFFSET: OptionRow = OptionRow::number("V");

/// Periods a second.
pub(super) const FREQUENCY: OptionRow = OptionRow::positive("Hz").required();

/// How many, from `least` on.
pub(super) const fn count(least: u64) -> OptionRow {
    OptionRow::new(OptionKind::Integer(least, u32::MAX as u64))
}
