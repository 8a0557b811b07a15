//! A block fitted as modes, feed-through, and a delay that need not be whole samples.
//!
//! The law, exact for a held input, and its derivatives: `modal_error.rs`. The search starts from the modes of an
//! output-error block with the best k, r and fraction of a sample, for the whole delays with the lowest initial cost.
//!
//! A mode above half the sampling rate appears as its image below it. For all modes except the largest, the two nearest
//! frequencies with the same image are tried as well, and accepted if the residual is clearly smaller; faster sampling
//! avoids this guess. A lag that is not a mode, such as an amplifier's, counts as delay, and the share of a mode is too
//! small by its effect. The standard errors account for noise only.

use super::free_run::dot;
use super::modal_error::{ModalError, ModalRun};
use super::output_error::{OutputError, Refinement, checked};
use super::uncertainty::{RecordScores, Uncertain, sandwich, spread};
use super::{Arx, Orders};
use libm::{exp, hypot, log};
use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::Minimum;
pub(super) use piezoid_numerics::optimize::levenberg_marquardt::{self, SumOfSquares};
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_records::record::Record;
use std::f64::consts::TAU;

/// A mode with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedMode {
    /// Natural frequency [Hz].
    pub hz: Uncertain,
    /// Damping ratio.
    pub damping: Uncertain,
    /// Share of the static displacement, from 0 to 1.
    pub share: Uncertain,
}

/// A block as modes, feed-through and delay.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalFit {
    /// Output for a constant input of 1 [output unit over input unit].
    pub gain: Uncertain,
    /// The modes, by rising frequency.
    pub modes: Vec<FittedMode>,
    /// Share of the feed-through.
    pub feed_through: Uncertain,
    /// Input delay [s]; negative where an output was logged after its input acted.
    pub delay: Uncertain,
    /// The same block as a difference equation.
    pub arx: Arx,
    /// Output offset of each record [output unit].
    pub offsets: Vec<f64>,
    /// Rms residual of the free run for each record [output unit].
    pub rms: Vec<f64>,
    /// The search: ln w, ln zeta and k of each mode, r, and the delay [samples].
    pub minimum: Minimum,
}

impl ModalFit {
    /// Fits `n` modes to `records`, with a delay between -1 and `longest` samples.
    ///
    /// ```
    /// use piezoid::{Record, linear::{ModalFit, Refinement}, plant::{Plant, Preset}, excitation::Prbs};
    /// let plant = Plant::named("paper", 5e-4)?;
    /// let u = Prbs::default().samples(5e-4, 2047)?;
    /// let record = Record::new(5e-4, u.clone(), plant.run(&u).y)?;
    /// let found = ModalFit::fit(&[record], 1, 1, &Refinement::default(), &mut piezoid::progress::Stage::ignore)?;
    /// assert!((found.modes[0].hz.value - 146.7).abs() < 0.1);
    /// assert!((found.delay.value + 5e-4).abs() < 1e-5); // it logs after the input acted
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`OutputError::fit`] for order 2 n; [`Error::Unidentifiable`] if it finds fewer than `n` modes;
    /// [`Error::Cancelled`].
    pub fn fit(
        records: &[Record],
        n: usize,
        longest: usize,
        settings: &Refinement,
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        if !(1..=64).contains(&n) {
            return Err(Error::parameter("modes", n, "must be from 1 to 64"));
        }
        let weights = checked(records, Orders { delay: longest, ..Orders::of(2 * n) }, settings)?;
        let starts = starts(records, n, longest, settings)?;
        let mut best: Option<(ModalError, Minimum)> = None;
        for (i, start) in starts.iter().enumerate() {
            let stage = Stage::new("modes", i, starts.len());
            if progress(stage).is_break() {
                return Err(Error::Cancelled { what: "the fit of modes".into(), done: i, total: starts.len() });
            }
            // An image fits nearly as well as the mode itself.
            let margin = if i == 0 { 1.0 } else { 0.9 };
            let bar = best.as_ref().map_or(f64::INFINITY, |(_, b)| margin * b.cost);
            let problem = |whole| ModalError { records, weights: &weights, modes: n, whole };
            let mut tried: Vec<_> = (0..=longest).map(|whole| (whole, problem(whole).with_best_gains(start))).collect();
            tried.sort_by(|(_, p), (_, q)| p.1.total_cmp(&q.1));
            for (whole, (x, _)) in tried.into_iter().take(TRIED) {
                let problem = problem(whole);
                let minimum = levenberg_marquardt::minimise(&problem, &x, &ROUGH, &mut Stage::ignore)?;
                if minimum.cost < bar && best.as_ref().is_none_or(|(_, b)| minimum.cost < b.cost) {
                    best = Some((problem, minimum));
                }
            }
        }
        let Some((problem, rough)) = best else {
            let because = "no frequency and damping near those of a difference equation gives a finite error".into();
            return Err(Error::Unidentifiable { what: format!("{n} modes"), because });
        };
        modal_fit(&problem, levenberg_marquardt::minimise(&problem, &rough.x, &settings.search, &mut Stage::ignore)?)
    }
}

/// Steps and tolerance sufficient to compare starts.
const ROUGH: levenberg_marquardt::SearchSettings =
    levenberg_marquardt::SearchSettings { iterations: 100, tolerance: 1e-6, damping: 1e-3 };

/// Number of whole delays searched: those with the lowest initial cost.
const TRIED: usize = 2;

/// ln w, ln zeta and k = 0 of each mode, and r = 0: the modes with the largest shares of an output-error block. For
/// each but the first, also the other frequencies with the same image.
fn starts(records: &[Record], n: usize, longest: usize, settings: &Refinement) -> Result<Vec<Vec<f64>>, Error> {
    let block = |delay| OutputError::fit(records, Orders { delay, ..Orders::of(2 * n) }, settings, &mut Stage::ignore);
    let mut blocks: Vec<_> = (0..=longest).map(block).collect::<Result<_, _>>()?;
    blocks.sort_by(|p, q| p.minimum.cost.total_cmp(&q.minimum.cost));
    let mut found: Vec<(f64, f64)> = Vec::new();
    for block in &blocks {
        let mut modes = block.arx.modal_form().poles;
        modes.retain(|p| p.pole.z.im > 0.0 && p.pole.damping < 0.9);
        modes.sort_by(|p, q| q.share.abs().total_cmp(&p.share.abs()));
        if modes.len() >= n {
            found = modes[..n].iter().map(|p| (p.pole.hz, p.pole.damping)).collect();
            break;
        }
    }
    if found.is_empty() {
        let because = format!(
            "a block of order {} has fewer modes: its other poles do not oscillate; request fewer modes, or excite \
             higher frequencies",
            2 * n
        );
        return Err(Error::Unidentifiable { what: format!("{n} modes"), because });
    }
    let vector = |modes: &[(f64, f64)]| {
        let each = modes.iter().flat_map(|(hz, damping)| [log(TAU * hz), log(damping.clamp(1e-4, 0.9)), 0.0]);
        each.chain([0.0]).collect::<Vec<f64>>()
    };
    let mut starts = vec![vector(&found)];
    let rate = 1.0 / records[0].ts();
    for i in 1..n {
        let (hz, damping) = found[i];
        let rings = hz * (1.0 - damping * damping).sqrt();
        for image in [rate - rings, rate + rings] {
            // The same decay per sample.
            let image_hz = hypot(image, hz * damping);
            let mut others = found.clone();
            others[i] = (image_hz, hz * damping / image_hz);
            starts.push(vector(&others));
        }
    }
    Ok(starts)
}

/// The minimum as modes, with their uncertainty.
fn modal_fit(problem: &ModalError, mut minimum: Minimum) -> Result<ModalFit, Error> {
    let (m, ts) = (problem.modes, problem.records[0].ts());
    let x = &mut minimum.x;
    x[3 * m + 1] = x[3 * m + 1].clamp(problem.whole as f64 - 1.0, problem.whole as f64);
    let x = &minimum.x;
    let runs: Vec<ModalRun> = problem.records.iter().map(|r| problem.run(r, x)).collect();
    let samples: usize = problem.records.iter().map(Record::len).sum();
    let fitted = problem.dimension() + problem.records.len() * (2 * m + problem.whole + 1);
    let evidence = runs.iter().zip(problem.weights).map(|(run, &weight)| RecordScores {
        weight,
        e: run.e.clone(),
        jacobian: problem.jacobian(run, x),
    });
    let covariance = sandwich(evidence, x.len(), samples as f64 / (samples - fitted) as f64);
    let number = |value: f64, slopes: &[(usize, f64)]| {
        let mut dense = vec![0.0; x.len()];
        slopes.iter().for_each(|&(k, slope)| dense[k] += slope);
        spread(value, &dense, &covariance, x.len())
    };
    let carriers: Vec<usize> = (0..m).map(|i| 3 * i + 2).chain([3 * m]).collect();
    let gain: f64 = carriers.iter().map(|&k| x[k]).sum();
    let share = |k: usize| {
        let slopes = carriers.iter().map(|&j| (j, (if j == k { 1.0 } else { 0.0 } - x[k] / gain) / gain));
        number(x[k] / gain, &slopes.collect::<Vec<_>>())
    };
    let mode = |i: usize| {
        let (hz, damping) = (exp(x[3 * i]) / TAU, exp(x[3 * i + 1]));
        FittedMode {
            hz: number(hz, &[(3 * i, hz)]),
            damping: number(damping, &[(3 * i + 1, damping)]),
            share: share(3 * i + 2),
        }
    };
    let mut modes: Vec<FittedMode> = (0..m).map(mode).collect();
    modes.sort_by(|p, q| p.hz.value.total_cmp(&q.hz.value));
    Ok(ModalFit {
        gain: number(gain, &carriers.iter().map(|&k| (k, 1.0)).collect::<Vec<_>>()),
        modes,
        feed_through: share(3 * m),
        delay: number(ts * x[3 * m + 1], &[(3 * m + 1, ts)]),
        arx: problem.arx(x)?,
        offsets: runs.iter().map(|run| run.offset).collect(),
        rms: runs.iter().map(|run| (dot(&run.e, &run.e) / run.e.len() as f64).sqrt()).collect(),
        minimum,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::{modal_error::tests::held, output_error::tests::pl140};
    use piezoid_numerics::system::System;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::{assert_close, noise};

    const TS: f64 = 5e-4;

    #[test]
    fn modes_without_noise_are_found_exactly_for_any_initial_condition() {
        let arx = held(&[(166.3, 0.03, 27.0), (700.0, 0.1, 2.0)], 1.0, 2.3e-4);
        let u = Prbs::default().samples(TS, 1500).unwrap();
        let y = arx.simulate(&u).iter().map(|y| y + 5.0).collect::<Vec<_>>();
        // An input around 9 V, settled at 9 V before the record.
        let (u, gain) = (u[200..].iter().map(|u| u + 9.0).collect(), 30.0);
        let record = Record::new(TS, u, y[200..].iter().map(|y| y + 9.0 * gain).collect()).unwrap();
        let found = ModalFit::fit(&[record], 2, 3, &Refinement::default(), &mut Stage::ignore).unwrap();
        let [first, second] = [found.modes[0], found.modes[1]];
        assert_close(&[first.hz.value, first.damping.value, first.share.value], &[166.3, 0.03, 0.9], 1e-6, 0.0);
        assert_close(&[second.hz.value, second.damping.value], &[700.0, 0.1], 1e-6, 0.0);
        assert_close(&[found.feed_through.value, found.delay.value], &[1.0 / 30.0, 2.3e-4], 1e-5, 0.0);
        assert_close(&[found.gain.value, found.offsets[0]], &[30.0, 5.0], 1e-6, 0.0);
        assert_close(found.arx.a(), arx.a(), 1e-6, 0.0);
    }

    #[test]
    fn the_truth_lies_within_its_uncertainty() {
        let truth = held(&[(166.3, 0.03, 27.0), (700.0, 0.1, 2.0)], 1.0, 2.3e-4);
        let u = Prbs::default().samples(TS, 1500).unwrap();
        let mut outside = [0; 8];
        for seed in 0..40 {
            let y = truth.simulate(&u).iter().zip(noise(seed, 1500)).map(|(y, e)| y + e).collect();
            let record = Record::new(TS, u.clone(), y).unwrap();
            let found = ModalFit::fit(&[record], 2, 1, &Refinement::default(), &mut Stage::ignore).unwrap();
            let [first, second] = [found.modes[0], found.modes[1]];
            let pairs = [
                (first.hz, 166.3),
                (first.damping, 0.03),
                (first.share, 0.9),
                (second.hz, 700.0),
                (second.damping, 0.1),
                (found.feed_through, 1.0 / 30.0),
                (found.delay, 2.3e-4),
                (found.gain, 30.0),
            ];
            for (outside, (number, truth)) in outside.iter_mut().zip(pairs) {
                *outside += usize::from((number.value - truth).abs() > 2.0 * number.error);
            }
        }
        // Two of 40 are expected.
        assert!(outside.iter().all(|&n| n <= 6) && outside.iter().sum::<usize>() >= 3, "{outside:?} of 40");
    }

    #[test]
    fn the_modes_of_the_pl140_are_found_from_its_noisy_record() {
        let found = ModalFit::fit(&[pl140(1, 3 * 2047)], 2, 2, &Refinement::default(), &mut Stage::ignore).unwrap();
        let [first, second] = [found.modes[0], found.modes[1]];
        assert_close(&[first.hz.value, first.damping.value], &[166.3, 0.03], 5e-4, 0.0);
        // Creep increases the gain, the amplifier's lag decreases the first mode: 1 % together.
        assert_close(&[first.share.value], &[0.891], 0.0, 0.01);
        // The second mode lies above half the sampling rate and is distinguished from its image at 958 Hz.
        assert_close(&[second.hz.value], &[1042.0], 3e-3, 0.0);
        // For modes this slow the lag of 0.1 ms is a delay.
        assert_close(&[found.delay.value], &[1e-4], 0.02, 0.0);
    }

    #[test]
    fn too_many_modes_are_an_error() {
        let z = (-TS / 0.02f64).exp();
        let lag = Arx::new(TS, vec![z], vec![0.0, 1.0 - z]).unwrap();
        let u = Prbs::default().samples(TS, 1500).unwrap();
        let y = lag.simulate(&u).iter().zip(noise(1, 1500)).map(|(y, e)| y + 1e-3 * e).collect();
        let record = [Record::new(TS, u, y).unwrap()];
        let message =
            |n| ModalFit::fit(&record, n, 1, &Refinement::default(), &mut Stage::ignore).unwrap_err().to_string();
        assert!(message(1).contains("do not oscillate"), "{}", message(1));
        assert!(message(0).starts_with("modes = 0"));
    }
}
