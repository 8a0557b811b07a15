//! The buffer of the arbitrary waveform generator in piezosystem jena's NV200 amplifiers.
//!
//! ```text
//! cl,0                  open loop
//! gtarb,k               a point lasts k times 50 us
//! gbarb,j,p_j           point j, from 0 up to 1023, in percent of the range
//! gsarb,0               first point of the cycle
//! gearb,N-1             last point of the cycle
//! goarb,0               first point of the first cycle
//! gcarb,0               endless
//! modsrc,3              the generator is the setpoint
//! grun,1                start
//! ```
//! In open loop the setpoint is a voltage. 0 % and 100 % are assumed to be the answers of the amplifier to `avmin` and
//! `avmax`, which depend on the connected actuator. The list of its commands does not say so; generators in the nano
//! box USB of the same maker count in percent of the voltage range. The language has no comments, so the file has none.
//! Every line can be sent as it is, with a carriage return at its end.
//!
//! Reference: NV200/D NET instruction manual, command list (section 8.5); piezosystem jena's nv200-python-lib
//! (`NV200Device`, `WaveformGenerator`); nano box USB manual, section 9.1.1.23. It does not do: closed loop and `gparb`
//! in micrometres, which belongs to it; saving in the amplifier (`gsave`).

use super::table::{TableCapacity, WaveTable};
use crate::template::{render, template};
use piezoid::error::Error;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::series::ends;

/// Capacity of its buffer, and its time base.
const ROOM: TableCapacity = TableCapacity { cycle: 5e-5, points: 1024, cycles: 65535 };

/// Decimals: a millionth of the range.
const DECIMALS: usize = 4;

/// The drive `u` [V], every `ts` [s], for an amplifier whose 0 % and 100 % are the ends of `range` [V].
///
/// # Errors
/// Returns an error if the drive leaves the range or the range is empty; also the errors of [`WaveTable::new`].
pub(super) fn table(u: &[f64], ts: f64, range: (f64, f64)) -> Result<WaveTable, Error> {
    let (low, high) = range;
    let value = format!("{} to {} V", round(low), round(high));
    if !(low < high && (high - low).is_finite()) {
        let rule = "must be the voltage of 0 % followed by the higher voltage of 100 %";
        return Err(Error::parameter("range", value, rule));
    }
    let (lowest, highest) = ends(u.iter().copied());
    if lowest < low || highest > high {
        let rule = format!("must contain the drive, which goes from {} to {} V", short(lowest), short(highest));
        return Err(Error::parameter("range", value, rule));
    }
    WaveTable::new(ROOM, u, ts, (low, (high - low) / 100.0), DECIMALS)
}

pub(super) fn commands(table: &WaveTable) -> Result<String, Error> {
    render(template!("waveform/nv200.txt.j2"), table.template_context())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_percent_of_the_range_and_counted_from_zero() {
        let table = table(&[-20.0, 55.0, 130.0], 1e-3, (-20.0, 130.0)).unwrap();
        assert_eq!(
            commands(&table).unwrap(),
            "cl,0\ngtarb,20\ngbarb,0,0.0000\ngbarb,1,50.0000\ngbarb,2,100.0000\n\
             gsarb,0\ngearb,2\ngoarb,0\ngcarb,0\nmodsrc,3\ngrun,1\n"
        );
        assert_eq!(table.held, [-20.0, 55.0, 130.0]);
    }

    #[test]
    fn the_buffer_limits_the_number_of_points() {
        let u: Vec<f64> = (0..5000).map(|t| f64::from(t % 100)).collect();
        let table = table(&u, 5e-4, (0.0, 100.0)).unwrap();
        assert_eq!((table.held.len(), table.cycles), (1000, 50));
        assert!(commands(&table).unwrap().contains("\ngearb,999\n"));
    }

    #[test]
    fn a_range_that_does_not_contain_the_drive_is_an_error() {
        let text = |range| table(&[-1.0, 4.0], 1e-3, range).map(drop).unwrap_err().to_string();
        let expected = "range = 0 to 100 V: must contain the drive, which goes from -1.000 to 4.000 V";
        assert!(text((0.0, 100.0)).contains(expected));
        assert!(text((5.0, -5.0)).contains("must be the voltage of 0 %"));
    }
}
