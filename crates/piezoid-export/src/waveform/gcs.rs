//! A wave table for controllers with PI's General Command Set, GCS 2.0.
//!
//! ```text
//! SVO 1 0                           axis 1 in open loop
//! WAV 1 X PNT 1 10 v_1 ... v_10     the first ten points of table 1; X starts a new one
//! WAV 1 & PNT 11 10 v_11 ... v_20   the next ten; & appends
//! WSL 1 1                           generator 1 plays table 1
//! WTR 1 k 0                         each point for k servo cycles, without interpolation
//! WGC 1 0                           endless
//! SVA 1 v_1                         move to the first point
//! WGO 1 1                           start
//! ```
//! The language has no comments, so the file has none. Every line can be sent as it is, with a line feed at its end.
//!
//! Reference: order of arguments, counting from 1 and ten points per line (the limit differs between controllers) as
//! PI's PIPython sends them (`gcscommands.WAV_PNT`, `pitools.writewavepoints`, samples/advanced/wavegenerator_pnt.py);
//! period = servo cycle x WTR x points and 50 us, E-727 user manual E727T0005. It does not do: axes and tables other
//! than the first, closed loop, triggers.

use super::table::{TableCapacity, WaveTable};
use crate::template::{render, template};
use piezoid::error::Error;

/// Points of a table; `WMS?` returns the capacity of a controller.
const POINTS: usize = 4096;

/// Digits after the point: 0.1 mV.
const DECIMALS: usize = 4;

/// The drive `u` [V], every `ts` [s], for servo cycles of this length [s].
pub(super) fn table(u: &[f64], ts: f64, cycle: f64) -> Result<WaveTable, Error> {
    WaveTable::new(TableCapacity { cycle, points: POINTS, cycles: 65535 }, u, ts, (0.0, 1.0), DECIMALS)
}

pub(super) fn commands(table: &WaveTable) -> Result<String, Error> {
    render(template!("waveform/gcs.txt.j2"), table.template_context())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_in_lines_of_ten_and_counted_from_one() {
        let u: Vec<f64> = (0..23).map(|t| f64::from(t) - 7.00004).collect();
        let text = commands(&table(&u, 5e-4, 5e-5).unwrap()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "SVO 1 0");
        assert!(lines[1].starts_with("WAV 1 X PNT 1 10 -7.0000 -6.0000 "), "{}", lines[1]);
        assert!(lines[2].starts_with("WAV 1 & PNT 11 10 3.0000 "), "{}", lines[2]);
        assert_eq!(lines[3], "WAV 1 & PNT 21 3 13.0000 14.0000 15.0000");
        assert_eq!(lines[4..], ["WSL 1 1", "WTR 1 10 0", "WGC 1 0", "SVA 1 -7.0000", "WGO 1 1"]);
    }

    #[test]
    fn zero_has_no_sign() {
        assert_eq!(table(&[-1e-9, 1.0], 5e-4, 5e-5).unwrap().written, ["0.0000", "1.0000"]);
    }
}
