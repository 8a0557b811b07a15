//! The linear block that comes closest to a record in free run, whatever it takes.
//!
//! Least squares on the equation error is quick and exact where there is no noise. Noise, or samples taken often, bend it:
//! where it leaves much, output error looks again, with enough b for a delay. What is left is counted from a tenth of
//! the record on, from the settled block at its first input, about an offset and, where the record may drift, a line.
//!
//! Not here: delays of more than [`DELAY`] samples in noise.

use crate::linear::{self, Arx, Orders, Refinement};
use crate::optimize::{levenberg_marquardt, swarm};
use crate::progress::silent;
use crate::record::Record;
use crate::system::System;

/// Orders tried by least squares.
const ORDERS: [usize; 5] = [2, 4, 6, 8, 12];

/// Orders tried by output error.
const NOISY: [usize; 4] = [2, 4, 6, 8];

/// Delay that output error has b for [samples].
const DELAY: usize = 8;

/// Samples that tell output error enough.
const ENOUGH: usize = 16_384;

/// Steps that come close enough.
const ROUGH: levenberg_marquardt::SearchSettings =
    levenberg_marquardt::SearchSettings { iterations: 20, tolerance: 1e-6, damping: 1e-3 };

/// A record, and what of it counts.
pub(super) struct MaskedRecord {
    pub(super) record: Record,
    /// The samples that count.
    pub(super) usable: Vec<bool>,
    /// The first sample that counts.
    pub(super) start: usize,
    /// Whether a line is taken off what is left.
    pub(super) drifts: bool,
}

/// The free run of a block from where the record counts on.
pub(super) struct ClosestFit {
    /// It, with its offset [output unit].
    pub(super) simulated: Vec<f64>,
    /// What it leaves, zero where samples do not count [output unit].
    pub(super) errors: Vec<f64>,
    /// The rms of that where they do.
    pub(super) left: f64,
}

impl MaskedRecord {
    /// The block that leaves least; output error is asked where least squares leaves more than `enough`.
    pub(super) fn closest(&self, enough: f64) -> Option<ClosestFit> {
        let least = |blocks: &mut dyn Iterator<Item = Arx>| {
            blocks.filter_map(|arx| self.run(&arx)).min_by(|a, b| a.left.total_cmp(&b.left))
        };
        let plain = Orders { na: 0, nb: 2, delay: 0 };
        let quick = least(&mut ORDERS.map(Orders::of).into_iter().chain([plain]).filter_map(|o| self.least_squares(o)));
        match quick {
            Some(quick) if quick.left <= enough => Some(quick),
            quick => {
                let careful = least(&mut NOISY.into_iter().filter_map(|n| self.output_error(n)));
                quick.into_iter().chain(careful).min_by(|a, b| a.left.total_cmp(&b.left))
            }
        }
    }

    fn least_squares(&self, orders: Orders) -> Option<Arx> {
        let (estimator, settings) = (linear::Estimator::find("least-squares").ok()?, swarm::SwarmSettings::default());
        let records = std::slice::from_ref(&self.record);
        Some(estimator.fit(records, orders, &settings, &mut silent).ok()?.arx)
    }

    fn output_error(&self, n: usize) -> Option<Arx> {
        let (record, end) = (&self.record, self.record.len().min(ENOUGH));
        let part = Record::new(record.ts(), record.u()[..end].to_vec(), record.y()[..end].to_vec()).ok()?;
        let orders = Orders { na: n, nb: n + 1 + DELAY, delay: 0 };
        let how = Refinement { search: ROUGH, ..Refinement::default() };
        Some(linear::OutputError::fit(&[part], orders, &how, &mut silent).ok()?.arx)
    }

    fn run(&self, arx: &Arx) -> Option<ClosestFit> {
        let (u, y) = (self.record.u(), &self.record.y()[self.start..]);
        if !arx.is_stable() {
            return None;
        }
        let mut simulated = arx.resume(&mut arx.settled(u[0]), u);
        simulated.drain(..self.start);
        let usable = &self.usable[self.start..];
        let middle = 0.5 * (y.len() - 1) as f64;
        let counted: Vec<(f64, f64)> =
            (0..y.len()).filter(|t| usable[*t]).map(|t| (t as f64 - middle, y[t] - simulated[t])).collect();
        let (offset, rise) = line(&counted, self.drifts);
        let errors: Vec<f64> = (0..y.len())
            .map(|t| if usable[t] { y[t] - simulated[t] - offset - rise * (t as f64 - middle) } else { 0.0 })
            .collect();
        simulated.iter_mut().for_each(|s| *s += offset);
        let left = (errors.iter().map(|e| e * e).sum::<f64>() / counted.len() as f64).sqrt();
        left.is_finite().then_some(ClosestFit { simulated, errors, left })
    }
}

/// The offset of pairs of time about the middle and value, and their rise where they `drift`.
fn line(pairs: &[(f64, f64)], drift: bool) -> (f64, f64) {
    let n = pairs.len() as f64;
    let (t, e) = pairs.iter().fold((0.0, 0.0), |(t, e), pair| (t + pair.0 / n, e + pair.1 / n));
    let (across, along) = pairs
        .iter()
        .fold((0.0, 0.0), |(across, along), pair| (across + (pair.0 - t) * (pair.1 - e), along + (pair.0 - t).powi(2)));
    let rise = if drift && along > 0.0 { across / along } else { 0.0 };
    (e - rise * t, rise)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::Prbs;
    use crate::testing::assert_close;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// A resonance that is sampled often, 7 samples late, with noise of 0.3 and a spike that is masked.
    fn noisy() -> MaskedRecord {
        let u = Prbs { order: 12, offset: 5.0, ..Prbs::default() }.samples(2e-5, 4000).unwrap();
        let block = Arx::new(2e-5, vec![1.95, -0.966], [vec![0.0; 7], vec![0.02, 0.02]].concat()).unwrap();
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let noise = (0..4000).map(|_| StandardNormal.sample(&mut random)).map(|e: f64| 0.3 * e);
        let mut y: Vec<f64> = block.simulate(&u).iter().zip(noise).map(|(y, e)| y + e).collect();
        y[2000] += 100.0;
        let mut usable = vec![true; 4000];
        usable[2000] = false;
        MaskedRecord { record: Record::new(2e-5, u, y).unwrap(), usable, start: 400, drifts: true }
    }

    #[test]
    fn output_error_leaves_the_noise_where_least_squares_leaves_more() {
        let mut judged = noisy();
        judged.record = bridge(&judged);
        let (quick, careful) = (judged.closest(f64::INFINITY).unwrap(), judged.closest(0.0).unwrap());
        assert_close(&[careful.left], &[0.3], 0.03, 0.0);
        assert!(quick.left > 1.3 * careful.left, "{} {}", quick.left, careful.left);
        assert_eq!((careful.errors.len(), careful.errors[1600]), (3600, 0.0));
    }

    fn bridge(judged: &MaskedRecord) -> Record {
        let record = &judged.record;
        let y = crate::quality::bridged(record.y(), &judged.usable);
        Record::new(record.ts(), record.u().to_vec(), y).unwrap()
    }

    #[test]
    fn a_line_is_taken_off_where_it_may_be() {
        let pairs: Vec<(f64, f64)> = (-5..=7).map(|t| (f64::from(t), 3.0 + 0.5 * f64::from(t))).collect();
        let (offset, rise) = line(&pairs, true);
        assert_close(&[offset, rise], &[3.0, 0.5], 1e-12, 0.0);
        assert_close(&[line(&pairs, false).0], &[3.5], 1e-12, 0.0);
    }
}
