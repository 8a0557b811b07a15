//! The linear block with the smallest free-run error of a record.
//!
//! Least squares on the equation error is fast, and exact without noise. It is biased by noise or by a high sampling
//! rate: if its residual is large, output error is tried too, with enough b coefficients for a delay. The residual is
//! computed from a tenth of the record on, from the block settled at its first input, without an offset and, if the
//! record may drift, without a line.
//!
//! Not here: delays of more than [`MAX_DELAY_SAMPLES`] samples with noise.

use piezoid_models::linear::{self, Arx, Orders, Refinement};
use piezoid_numerics::optimize::{levenberg_marquardt, swarm};
use piezoid_numerics::progress::Stage;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;

/// Orders tried by least squares.
const LEAST_SQUARES_ORDERS: [usize; 5] = [2, 4, 6, 8, 12];

/// Orders tried by output error.
const OUTPUT_ERROR_ORDERS: [usize; 4] = [2, 4, 6, 8];

/// Delay that the b coefficients of output error cover [samples].
const MAX_DELAY_SAMPLES: usize = 8;

/// Maximum number of samples for output error.
const MAX_OUTPUT_ERROR_SAMPLES: usize = 16_384;

/// Steps and tolerance of a sufficient search.
const OUTPUT_ERROR_SEARCH: levenberg_marquardt::SearchSettings =
    levenberg_marquardt::SearchSettings { iterations: 20, tolerance: 1e-6, damping: 1e-3 };

/// A record with its usable samples.
pub(super) struct MaskedRecord {
    pub(super) record: Record,
    /// True for samples that count.
    pub(super) usable: Vec<bool>,
    /// The first sample that counts.
    pub(super) start: usize,
    /// True if a line is subtracted from the residual.
    pub(super) drifts: bool,
}

/// The free run of a block from `start`.
pub(super) struct ClosestFit {
    /// The free run with its offset [output unit].
    pub(super) simulated: Vec<f64>,
    /// The residuals, zero for samples that do not count [output unit].
    pub(super) errors: Vec<f64>,
    /// Rms of the residuals that count.
    pub(super) rms: f64,
}

impl MaskedRecord {
    /// The block with the smallest residual. Output error is tried if the residual of least squares exceeds
    /// `tolerance`.
    pub(super) fn closest(&self, tolerance: f64) -> Option<ClosestFit> {
        let best = |blocks: &mut dyn Iterator<Item = Arx>| {
            blocks.filter_map(|arx| self.run(&arx)).min_by(|a, b| a.rms.total_cmp(&b.rms))
        };
        let plain = Orders { na: 0, nb: 2, delay: 0 };
        let orders = LEAST_SQUARES_ORDERS.map(Orders::of).into_iter().chain([plain]);
        let quick = best(&mut orders.filter_map(|orders| self.least_squares(orders)));
        match quick {
            Some(quick) if quick.rms <= tolerance => Some(quick),
            quick => {
                let careful = best(&mut OUTPUT_ERROR_ORDERS.into_iter().filter_map(|n| self.output_error(n)));
                quick.into_iter().chain(careful).min_by(|a, b| a.rms.total_cmp(&b.rms))
            }
        }
    }

    fn least_squares(&self, orders: Orders) -> Option<Arx> {
        let (estimator, settings) = (linear::Estimator::find("least-squares").ok()?, swarm::SwarmSettings::default());
        let records = std::slice::from_ref(&self.record);
        Some(estimator.fit(records, orders, &settings, &mut Stage::ignore).ok()?.arx)
    }

    fn output_error(&self, n: usize) -> Option<Arx> {
        let part = self.record.slice(0..self.record.len().min(MAX_OUTPUT_ERROR_SAMPLES)).ok()?;
        let orders = Orders { na: n, nb: n + 1 + MAX_DELAY_SAMPLES, delay: 0 };
        let settings = Refinement { search: OUTPUT_ERROR_SEARCH, ..Refinement::default() };
        Some(linear::OutputError::fit(&[part], orders, &settings, &mut Stage::ignore).ok()?.arx)
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
        let error = |t: usize| y[t] - simulated[t] - offset - rise * (t as f64 - middle);
        let errors: Vec<f64> = (0..y.len()).map(|t| if usable[t] { error(t) } else { 0.0 }).collect();
        simulated.iter_mut().for_each(|s| *s += offset);
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / counted.len() as f64).sqrt();
        rms.is_finite().then_some(ClosestFit { simulated, errors, rms })
    }
}

/// The offset of pairs (time about the middle, value), and their slope if they `drift`.
fn line(pairs: &[(f64, f64)], drift: bool) -> (f64, f64) {
    let n = pairs.len() as f64;
    let (t, e) = pairs.iter().fold((0.0, 0.0), |(t, e), pair| (t + pair.0 / n, e + pair.1 / n));
    let across: f64 = pairs.iter().map(|pair| (pair.0 - t) * (pair.1 - e)).sum();
    let along: f64 = pairs.iter().map(|pair| (pair.0 - t).powi(2)).sum();
    let rise = if drift && along > 0.0 { across / along } else { 0.0 };
    (e - rise * t, rise)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::{assert_close, noise};

    /// A resonance at a high sampling rate, delayed by 7 samples, with noise of 0.3 and a masked spike.
    fn noisy() -> MaskedRecord {
        let u = Prbs { order: 12, offset: 5.0, ..Prbs::default() }.samples(2e-5, 4000).unwrap();
        let block = Arx::new(2e-5, vec![1.95, -0.966], [vec![0.0; 7], vec![0.02, 0.02]].concat()).unwrap();
        let mut y: Vec<f64> = block.simulate(&u).iter().zip(noise(1, 4000)).map(|(y, e)| y + 0.3 * e).collect();
        y[2000] += 100.0;
        let mut usable = vec![true; 4000];
        usable[2000] = false;
        MaskedRecord { record: Record::new(2e-5, u, y).unwrap(), usable, start: 400, drifts: true }
    }

    #[test]
    fn the_residual_of_output_error_is_the_noise_and_that_of_least_squares_is_larger() {
        let mut masked = noisy();
        let y = piezoid_records::quality::bridged(masked.record.y(), &masked.usable);
        masked.record = Record::new(2e-5, masked.record.u().to_vec(), y).unwrap();
        let (quick, careful) = (masked.closest(f64::INFINITY).unwrap(), masked.closest(0.0).unwrap());
        assert_close(&[careful.rms], &[0.3], 0.03, 0.0);
        assert!(quick.rms > 1.3 * careful.rms, "{} {}", quick.rms, careful.rms);
        assert_eq!((careful.errors.len(), careful.errors[1600]), (3600, 0.0));
    }

    #[test]
    fn a_line_is_subtracted_if_the_record_may_drift() {
        let pairs: Vec<(f64, f64)> = (-5..=7).map(|t| (f64::from(t), 3.0 + 0.5 * f64::from(t))).collect();
        let (offset, rise) = line(&pairs, true);
        assert_close(&[offset, rise], &[3.0, 0.5], 1e-12, 0.0);
        assert_close(&[line(&pairs, false).0], &[3.5], 1e-12, 0.0);
    }
}
