//! Arrays of PI's controllers: GCS, the PI General Command Set, as PIMikroMove and PIPython save them.
//!
//! ```text
//! # SAMPLE_TIME = 0.00005
//! # NDATA = 1024
//! # NAME0 = Control Voltage of Axis1
//! # END_HEADER
//! 20.0 1.93
//! ```
//! The rows are those of CSV, whose head reads the names. GCS states no units.

use super::{Format, Table};

/// The row of GCS arrays.
pub(super) const ROW: Format = Format {
    name: "gcs",
    extensions: &["gcs"],
    summary: "an array of a PI controller, recorded by DRR?",
    reference: "Physik Instrumente, GCS Array Data Format Description SM146E",
    matches,
    read: Table::parse,
    in_pieces: true,
    write: None,
};

/// Bytes at the start among which the end of the head must be.
const HEAD: usize = 1 << 14;

fn matches(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(HEAD)];
    head.starts_with(b"#") && head.windows(10).any(|part| part == b"END_HEADER")
}
