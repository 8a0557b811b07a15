//! Option rows that several excitations share.

pub(super) use piezoid_numerics::options::{OptionKind, OptionRow, Options, options};

/// Half of the peak-to-peak voltage.
pub(super) const AMPLITUDE: OptionRow = OptionRow::positive("V").required();

/// The voltage that the excitation is centred on.
pub(super) const OFFSET: OptionRow = OptionRow::number("V");

/// Periods per second.
pub(super) const FREQUENCY: OptionRow = OptionRow::positive("Hz").required();

/// An integer of at least `least`.
pub(super) const fn count(least: u64) -> OptionRow {
    OptionRow::new(OptionKind::Integer(least, u32::MAX as u64))
}
