//! Where the power of an input lies: which modes it can show.

use piezoid_numerics::fourier::plain_power;
use piezoid_records::record::Record;

/// Share of its power below the lowest frequency of an input, and above the highest.
const EDGE_POWER_SHARE: f64 = 0.02;

/// Where the power of an input lies.
pub(crate) struct Spread {
    /// The number of lines of equal power with the same spread.
    pub(crate) lines: f64,
    /// The frequencies below and above which it has next to no power [Hz].
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Spread {
    pub(crate) fn of(record: &Record) -> Self {
        let power = &plain_power(record.u())[1..];
        let total: f64 = power.iter().sum();
        let below = |share: f64| {
            let mut sum = 0.0;
            let lines = power.iter().take_while(|p| {
                sum += **p;
                sum < share * total
            });
            (lines.count() + 1) as f64 / record.duration()
        };
        let lines = total * total / power.iter().map(|p| p * p).sum::<f64>();
        Spread { lines, low: below(EDGE_POWER_SHARE), high: below(1.0 - EDGE_POWER_SHARE) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    #[test]
    fn lines_of_equal_power_are_counted_and_their_ends_found() {
        let of = |lines: &[f64]| {
            let at = |t: i32| lines.iter().map(|hz| (TAU * hz * 1e-3 * f64::from(t)).sin()).sum::<f64>();
            let u: Vec<f64> = (0..2000).map(at).collect();
            Spread::of(&Record::new(1e-3, u, vec![0.0; 2000]).unwrap())
        };
        for (lines, low, high) in [(&[10.0][..], 10.0, 10.0), (&[10.0, 35.0, 60.0], 10.0, 60.0)] {
            let spread = of(lines);
            assert_close(&[spread.lines, spread.low, spread.high], &[lines.len() as f64, low, high], 1e-6, 0.0);
        }
    }
}
