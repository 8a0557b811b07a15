//! What rich records say about the linear block when there is no small-signal record beside them.
//!
//! A block of p parameters needs at least p / 2 frequencies in its input, and one of them near each pole; with less,
//! any fit is a guess that repairs the hysteresis block instead. Then a gain is left, and the reason is told.

use crate::error::Error;
use crate::fourier::{LINE, power};
use crate::linear::{self, Arx, Fit, Orders};
use crate::number::round;
use crate::optimize::swarm;
use crate::progress::silent;
use crate::record::Record;
use crate::series::{mean, scatter};
use crate::system::System;

/// Power of a spectral line, against the strongest, from which it counts as excited.
const EXCITED: f64 = 1e-4;

/// The longest delay tried [samples].
const DELAY_MAX: usize = 3;

/// The error of a block with dynamics, over that of a gain, below which the dynamics are believed.
const CLEARLY_BETTER: f64 = 0.8;

/// The linear block with the offset it was found with, and how it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearPart {
    /// The block.
    pub arx: Arx,
    /// Constant in the output [output unit].
    pub offset: f64,
    /// The fit to small-signal or rich records; none where only a gain was found.
    pub fit: Option<Fit>,
    /// How it was found and why so, in words.
    pub reason: String,
}

/// The linear block from rich records alone: as much of a block of order `n` as they can tell, with its delay. Where
/// they do not tell a block of that order, lower ones are tried.
pub(super) fn linear_from_large_signal(records: &[Record], n: usize) -> Result<LinearPart, Error> {
    let (gain, lines) = (affine(records)?, lines(records));
    let asked = of_order(records, n, gain, &lines)?;
    for lower in (1..n).rev().take_while(|_| asked.fit.is_none()) {
        let part = of_order(records, lower, gain, &lines)?;
        if part.fit.is_some() {
            let reason = format!("{}; of order {n} there would be left {}", part.reason, asked.reason);
            return Ok(LinearPart { reason, ..part });
        }
    }
    Ok(asked)
}

/// A block of order `n` for inputs that hold these frequencies [Hz], or else the gain that [`affine`] found and why.
fn of_order(
    records: &[Record],
    n: usize,
    (gain, offset, left_by_gain): (f64, f64, f64),
    lines: &[f64],
) -> Result<LinearPart, Error> {
    let plain = |reason: String| {
        let (arx, reason) = (Arx::gain(records[0].ts(), gain)?, format!("a pure gain: {reason}"));
        Ok(LinearPart { arx, offset, fit: None, reason })
    };
    if let Some(why) = missing_excitation(lines, n) {
        return plain(format!("{why}; add a small-signal PRBS record to learn the dynamics"));
    }
    let highest = lines.iter().fold(0.0f64, |h, &l| h.max(l));
    let least_squares = linear::Estimator::find("least-squares")?;
    let candidates: Vec<(f64, usize, Fit)> = (0..=DELAY_MAX)
        .filter_map(|delay| {
            let orders = Orders { delay, ..Orders::of(n) };
            let fit = least_squares.fit(records, orders, &swarm::SwarmSettings::default(), &mut silent).ok()?;
            Some((left_by(&fit, records)?, delay, fit))
        })
        .collect();
    // A block that waits is the simpler one: the longest delay that costs nothing.
    let best = candidates.iter().map(|c| c.0).fold(f64::INFINITY, f64::min);
    let Some((left, delay, fit)) = candidates.into_iter().rfind(|c| c.0 <= 1.01 * best + 1e-9) else {
        return plain(format!("no stable block of order {n} fits the data"));
    };
    let fastest = fit.arx.poles().iter().map(|p| p.hz).fold(0.0, f64::max);
    if fastest > 1.5 * highest {
        return plain(format!(
            "the fit puts a pole at {fastest:.1} Hz but the input ends at {highest:.1} Hz, so nothing in the data shows it"
        ));
    }
    if left > CLEARLY_BETTER * left_by_gain {
        return plain(format!(
            "a block of order {n} leaves {left:.3} of the output's rms in free run, no clear gain over the {left_by_gain:.3} that a gain leaves"
        ));
    }
    let reason = format!(
        "order {n} with a delay of {delay} samples, by least squares on the rich records ({} frequencies up to {highest:.0} Hz): \
         it leaves {left:.3} of the output's rms in free run, a gain {left_by_gain:.3}",
        lines.len()
    );
    Ok(LinearPart { arx: fit.arx.clone(), offset: fit.offsets[0], fit: Some(fit), reason })
}

/// The gain that brings the inputs closest to the outputs, each record with an offset of its own; the offset of the
/// first; and the share of the outputs' rms that is left.
pub(super) fn affine(records: &[Record]) -> Result<(f64, f64, f64), Error> {
    let means = |r: &Record| (mean(r.u()), mean(r.y()));
    let (mut uu, mut uy, mut yy) = (0.0, 0.0, 0.0);
    for record in records {
        let (mu, my) = means(record);
        for (u, y) in record.u().iter().zip(record.y()) {
            uu += (u - mu) * (u - mu);
            uy += (u - mu) * (y - my);
            yy += (y - my) * (y - my);
        }
    }
    let gain = uy / uu;
    if gain == 0.0 || !gain.is_finite() {
        let because = match uu {
            0.0 => "the input of every record is constant: drive the actuator with a sine or a PRBS".into(),
            _ => format!("the output does not follow the input (covariance {uy}): are the columns the right ones?"),
        };
        return Err(Error::Unidentifiable { what: "the gain".into(), because });
    }
    let (mu, my) = records.first().map_or((0.0, 0.0), means);
    Ok((gain, my - gain * mu, ((yy - gain * uy).max(0.0) / yy).sqrt()))
}

/// The share of the output's rms that a stable fit leaves in free run.
fn left_by(fit: &Fit, records: &[Record]) -> Option<f64> {
    if !fit.arx.is_stable() {
        return None;
    }
    let error = records.iter().zip(&fit.offsets).map(|(record, offset)| {
        let simulated = fit.arx.resume(&mut fit.arx.settled(record.u()[0]), record.u());
        record.y().iter().zip(&simulated).map(|(y, s)| (y - offset - s).powi(2)).sum::<f64>()
    });
    let power = records.iter().map(|record| scatter(record.y()));
    Some((error.sum::<f64>() / power.sum::<f64>()).sqrt())
}

/// Refuses records whose inputs hold too few frequencies for a block of order `n`.
pub(super) fn require_excitation(records: &[Record], n: usize) -> Result<(), Error> {
    match missing_excitation(&lines(records), n) {
        None => Ok(()),
        Some(why) => Err(Error::Unidentifiable {
            what: "the linear block".into(),
            because: format!("{why}; give a PRBS as the small-signal record, or this one as a rich record"),
        }),
    }
}

/// Why these frequencies do not suffice for a block of order `n`, if so.
fn missing_excitation(lines: &[f64], n: usize) -> Option<String> {
    let needed = Orders::of(n).parameters().div_ceil(2);
    let held = match lines {
        [] => "no frequency at all".into(),
        [one] => format!("one frequency ({} Hz)", round(*one)),
        many => format!("{} frequencies", many.len()),
    };
    (lines.len() < needed).then(|| format!("the input holds {held}, and a block of order {n} needs {needed}"))
}

/// The frequencies [Hz] that the inputs of all records hold, those within a tenth of each other once.
pub(super) fn lines(records: &[Record]) -> Vec<f64> {
    records.iter().flat_map(excited).fold(Vec::new(), |mut lines: Vec<f64>, hz| {
        if !lines.iter().any(|l| (l / hz - 1.0).abs() < 0.1) {
            lines.push(hz);
        }
        lines
    })
}

/// The frequencies [Hz] at which the input has power worth the name. A line is [`LINE`] bins wide, so bins in a row count
/// as a line each that many.
fn excited(record: &Record) -> Vec<f64> {
    let n = record.len();
    let power = power(record.u());
    let strongest = power.iter().copied().fold(0.0, f64::max);
    let hz = |bin: f64| bin / (n as f64 * record.ts());
    let strong: Vec<usize> = (1..power.len()).filter(|&k| power[k] > EXCITED * strongest).collect();
    let runs = strong.chunk_by(|p, q| q - p == 1);
    // Where the power of some bins lies, on average.
    let centre = |bins: &[usize]| {
        let (moment, sum) = bins.iter().fold((0.0, 0.0), |(m, s), &k| (m + k as f64 * power[k], s + power[k]));
        moment / sum
    };
    runs.flat_map(|run| run.chunks(run.len() / (run.len() / LINE).max(1)).map(centre).collect::<Vec<_>>())
        .map(hz)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn record(hz: &[f64], arx: &Arx) -> Record {
        let sum = |t: usize| hz.iter().map(|hz| 10.0 * (TAU * hz * t as f64 * 5e-4).sin()).sum::<f64>();
        let u: Vec<f64> = (0..8000).map(sum).collect();
        let y = arx.simulate(&u).iter().map(|y| y - 40.0).collect();
        Record::new(5e-4, u, y).unwrap()
    }

    fn beam() -> Arx {
        Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 0.0, 3.4, 3.3]).unwrap()
    }

    #[test]
    fn one_frequency_leaves_a_gain_and_says_so() {
        let part = linear_from_large_signal(&[record(&[5.0], &beam())], 2).unwrap();
        assert!(part.arx.a().is_empty());
        assert!(part.reason.contains("one frequency (5 Hz)"), "{}", part.reason);
    }

    #[test]
    fn frequencies_through_the_resonance_give_the_block_with_its_delay_and_offset() {
        let part = linear_from_large_signal(&[record(&[5.0, 40.0, 90.0, 150.0, 220.0], &beam())], 2).unwrap();
        assert!(part.reason.contains("delay of 2 samples"), "{}", part.reason);
        crate::testing::assert_close(&[part.arx.poles()[0].hz, part.offset], &[146.73, -40.0], 1e-3, 0.0);
    }

    #[test]
    fn frequencies_far_below_the_resonance_do_not_show_it() {
        let part = linear_from_large_signal(&[record(&[1.0, 2.5, 4.0, 6.0], &beam())], 2).unwrap();
        assert!(part.arx.a().is_empty(), "{}", part.reason);
    }
}
