//! Pseudo-random binary sequence: two levels, switched by a linear feedback shift register of maximal length.
//!
//! With the register `s_0 ... s_(n-1)` and the taps of its primitive polynomial, each clock outputs the bit `s_0`,
//! shifts down, and inserts `s_0 xor (xor of s_j over the taps j)` at the top; `u = offset + amplitude (2 bit - 1)`.
//! The sequence repeats after `2^n - 1` bits and not earlier; `2^(n-1)` of them are ones. Over whole periods its
//! autocorrelation is that of white noise. Holding each bit for `clock_divider` samples moves the power to low
//! frequencies: the spectrum falls as `sinc^2` with its first zero at `1 / (clock_divider ts)`.
//!
//! It differs from the sign of white noise, which has no period and no balance, and whose spectrum is flat only on
//! average. It is the paper's small signal (section 2.3): at about 1 V a bender stays linear to under 1 %.
//!
//! Reference: MacWilliams and Sloane, Pseudo-Random Sequences and Arrays, Proceedings of the IEEE 64(12), 1976,
//! DOI 10.1109/PROC.1976.10411. Taps, order of bits and default start are those of `scipy.signal.max_len_seq`.

use super::Excitation;
use super::drive::Drive;
use super::rows::{AMPLITUDE, OFFSET, OptionKind, OptionRow, Options, count, options};
use piezoid_numerics::error::Error;

options! {
    /// A maximal-length sequence of two levels.
    ///
    /// ```
    /// use piezoid::excitation::Prbs;
    /// let prbs = Prbs { order: 3, ..Prbs::default() };
    /// assert_eq!(prbs.samples(5e-4, 7)?, [1.0, 1.0, 1.0, -1.0, 1.0, -1.0, -1.0]);
    /// assert_eq!(prbs.period(), 7);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub struct Prbs {
        /// Amplitude: half of the peak-to-peak voltage.
        amplitude: f64 = 1.0, AMPLITUDE;
        /// Length of the shift register, 2 to 31; the sequence repeats after 2^order - 1 bits.
        order: u32 = 11, OptionRow::new(OptionKind::Integer(2, 31));
        /// Samples that each bit is held for.
        clock_divider: u32 = 1, count(1);
        /// Start value of the shift register, below 2^order: shifts the sequence in time; 0 means all ones.
        seed: u32 = 0, count(0);
        /// Voltage that the excitation is centred on.
        offset: f64 = 0.0, OFFSET;
    }
}

impl Prbs {
    /// `n` samples [V], every `ts` [s].
    ///
    /// # Errors
    /// The amplitude must be positive, the order 2 to 31, the clock divider at least 1 and the seed below `2^order`.
    pub fn samples(&self, ts: f64, n: usize) -> Result<Vec<f64>, Error> {
        let drive = Drive::new(self.amplitude, self.offset, ts)?;
        if !(2..=31).contains(&self.order) {
            return Err(Error::parameter("order", self.order, "must be from 2 to 31"));
        }
        if self.clock_divider == 0 {
            return Err(Error::parameter("clock_divider", 0, "must be at least 1 sample a bit"));
        }
        let ones = (1 << self.order) - 1;
        if self.seed > ones {
            let rule = format!("must be at most {ones}, which fills a register of order {}", self.order);
            return Err(Error::parameter("seed", self.seed, rule));
        }
        let mut register = Register { order: self.order, bits: if self.seed == 0 { ones } else { self.seed } };
        let mut u = Vec::with_capacity(n);
        while u.len() < n {
            let level = drive.voltage(if register.clock() { 1.0 } else { -1.0 });
            let held = (n - u.len()).min(self.clock_divider as usize);
            u.resize(u.len() + held, level);
        }
        Ok(u)
    }

    /// Samples after which the excitation repeats: `clock_divider (2^order - 1)`.
    pub fn period(&self) -> u64 {
        u64::from(self.clock_divider) * ((1 << self.order.min(31)) - 1)
    }
}

/// The shift register; bit 0 leaves first.
struct Register {
    order: u32,
    bits: u32,
}

impl Register {
    /// Shifts the register by one bit, and returns the bit that leaves.
    fn clock(&mut self) -> bool {
        let out = self.bits & 1;
        // The parity of the tapped bits is their exclusive or. Bit 0 is tapped in every polynomial.
        let fed_back = (self.bits & TAPS[self.order as usize]).count_ones() & 1;
        self.bits = (self.bits >> 1) | (fed_back << (self.order - 1));
        out == 1
    }
}

/// Words in which the tapped bits are set, by order: 0x9 for `s_3` and `s_0`.
const TAPS: [u32; 32] = [
    0x0, 0x0, 0x3, 0x5, 0x9, 0x9, 0x21, 0x41, 0xc3, 0x21, 0x81, 0x201, 0xc11, 0x1901, 0x3005, 0x4001, 0xa011, 0x4001,
    0x801, 0x64001, 0x20001, 0x80001, 0x200001, 0x40001, 0xc20001, 0x400001, 0x3100001, 0x6400001, 0x2000001,
    0x8000001, 0x30000081, 0x10000001,
];

pub(super) const ROW: Excitation = Excitation {
    name: "prbs",
    summary: "pseudo-random binary sequence: white over its period, for the linear block",
    reference: "MacWilliams and Sloane, Proc. IEEE 64(12), 1976, DOI 10.1109/PROC.1976.10411",
    rows: Prbs::rows,
    generate: |arguments, ts, n| Prbs::from_json(arguments)?.samples(ts, n),
};

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_register_returns_to_its_start_after_a_full_period_and_no_earlier(order in 2u32..=16, seed in 1u32..) {
            let start = (seed % ((1 << order) - 1)) + 1;
            let mut register = Register { order, bits: start };
            let mut ones = 0;
            for clock in 1..1u32 << order {
                ones += u32::from(register.clock());
                prop_assert_eq!(register.bits == start, clock == (1 << order) - 1);
            }
            prop_assert_eq!(ones, 1 << (order - 1));
        }

        #[test]
        fn each_bit_is_held_for_the_clock_divider(order in 2u32..=10, clock_divider in 1u32..7, n in 0usize..500) {
            let fast = Prbs { order, ..Prbs::default() }.samples(1.0, n).unwrap();
            let slow = Prbs { order, clock_divider, ..Prbs::default() }.samples(1.0, n).unwrap();
            prop_assert!((0..n).all(|t| slow[t] == fast[t / clock_divider as usize]));
        }
    }

    #[test]
    fn over_a_period_it_is_uncorrelated_with_itself_shifted() {
        let u = Prbs { order: 7, ..Prbs::default() }.samples(1.0, 127).unwrap();
        let correlation = |lag: usize| (0..127).map(|t| u[t] * u[(t + lag) % 127]).sum::<f64>();
        assert_eq!(correlation(0), 127.0);
        assert!((1..127).all(|lag| correlation(lag) == -1.0));
    }

    #[test]
    fn registers_that_do_not_exist_are_refused() {
        let message = |prbs: Prbs| prbs.samples(1.0, 1).unwrap_err().to_string();
        assert!(message(Prbs { order: 1, ..Prbs::default() }).contains("from 2 to 31"));
        assert!(message(Prbs { order: 32, ..Prbs::default() }).contains("from 2 to 31"));
        assert!(message(Prbs { clock_divider: 0, ..Prbs::default() }).contains("at least 1"));
        assert!(message(Prbs { order: 3, seed: 8, ..Prbs::default() }).contains("at most 7"));
        assert!(Prbs { order: 31, seed: (1 << 31) - 1, ..Prbs::default() }.samples(1.0, 100).is_ok());
    }
}
