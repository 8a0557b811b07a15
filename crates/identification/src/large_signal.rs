//! The linear block from large-signal records, if there is no small-signal record.
//!
//! A block of p parameters needs at least p / 2 frequencies in its input, one of them near each pole. With fewer, a fit
//! compensates errors of the hysteresis block. Then only a gain is used, and the reason is reported.

use crate::LinearPart;
use piezoid_models::linear::{self, Arx, Fit, Orders};
use piezoid_numerics::error::Error;
use piezoid_numerics::fourier::{LINE_WIDTH_BINS, power};
use piezoid_numerics::number::round;
use piezoid_numerics::optimize::swarm;
use piezoid_numerics::progress::Stage;
use piezoid_numerics::series::{mean, scatter};
use piezoid_numerics::system::System;
use piezoid_records::record::Record;

/// Power of a spectral line over the strongest, from which it counts as excited.
const EXCITED: f64 = 1e-4;

/// The longest delay tried [samples].
const DELAY_MAX: usize = 3;

/// The error of a block with dynamics over that of a gain, below which the dynamics are accepted.
const CLEARLY_BETTER: f64 = 0.8;

/// The linear block from large-signal records alone: a block of order `n` with its delay, or the highest lower order
/// that the records determine, or a gain.
pub fn linear_from_large_signal(records: &[Record], n: usize) -> Result<LinearPart, Error> {
    let (gain, lines) = (affine(records)?, lines(records));
    let requested = of_order(records, n, gain, &lines)?;
    for lower in (1..n).rev().take_while(|_| requested.fit.is_none()) {
        let part = of_order(records, lower, gain, &lines)?;
        if part.fit.is_some() {
            let reason = format!("{}; for order {n} the result is {}", part.reason, requested.reason);
            return Ok(LinearPart { reason, ..part });
        }
    }
    Ok(requested)
}

/// A block of order `n` for inputs with these frequencies [Hz], or the gain that [`affine`] found, with the reason.
fn of_order(
    records: &[Record],
    n: usize,
    (gain, offset, residual_of_gain): (f64, f64, f64),
    lines: &[f64],
) -> Result<LinearPart, Error> {
    let plain = |reason: String| {
        let (arx, reason) = (Arx::gain(records[0].ts(), gain)?, format!("a pure gain: {reason}"));
        Ok(LinearPart { arx, offset, fit: None, reason })
    };
    if let Some(why) = missing_excitation(lines, n) {
        return plain(format!("{why}; add a small-signal PRBS record to identify the dynamics"));
    }
    let highest = lines.iter().fold(0.0f64, |h, &l| h.max(l));
    let least_squares = linear::Estimator::find("least-squares")?;
    let candidates: Vec<(f64, usize, Fit)> = (0..=DELAY_MAX)
        .filter_map(|delay| {
            let orders = Orders { delay, ..Orders::of(n) };
            let fit = least_squares.fit(records, orders, &swarm::SwarmSettings::default(), &mut Stage::ignore).ok()?;
            Some((residual(&fit, records)?, delay, fit))
        })
        .collect();
    // The longest delay without a larger residual is the simplest block.
    let best = candidates.iter().map(|c| c.0).fold(f64::INFINITY, f64::min);
    let Some((share, delay, fit)) = candidates.into_iter().rfind(|c| c.0 <= 1.01 * best + 1e-9) else {
        return plain(format!("no stable block of order {n} fits the data"));
    };
    let fastest = fit.arx.poles().iter().map(|p| p.hz).fold(0.0, f64::max);
    if fastest > 1.5 * highest {
        return plain(format!(
            "the fit has a pole at {fastest:.1} Hz, but the input has no power above {highest:.1} Hz, so the data do \
             not support it"
        ));
    }
    if share > CLEARLY_BETTER * residual_of_gain {
        return plain(format!(
            "the free-run residual of a block of order {n} is {share:.3} of the output's rms, no clear improvement \
             over {residual_of_gain:.3} with a pure gain"
        ));
    }
    let reason = format!(
        "order {n} with a delay of {delay} samples, by least squares on the large-signal records ({} frequencies up to \
         {highest:.0} Hz): its free-run residual is {share:.3} of the output's rms, that of a gain \
         {residual_of_gain:.3}",
        lines.len()
    );
    Ok(LinearPart { arx: fit.arx.clone(), offset: fit.offsets[0], fit: Some(fit), reason })
}

/// The gain of the best fit with one offset per record; the offset of the first record; and the residual over the
/// outputs' rms.
pub fn affine(records: &[Record]) -> Result<(f64, f64, f64), Error> {
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
            _ => format!("the output does not depend on the input (covariance {uy}): check the columns"),
        };
        return Err(Error::Unidentifiable { what: "the gain".into(), because });
    }
    let (mu, my) = records.first().map_or((0.0, 0.0), means);
    Ok((gain, my - gain * mu, ((yy - gain * uy).max(0.0) / yy).sqrt()))
}

/// The gain k and offset c for which k G u + c fits the outputs of `records` best. Without records, or if G is
/// unstable: 1 and `offset`.
pub fn proportional(arx: &Arx, offset: f64, records: &[Record]) -> Result<(f64, f64), Error> {
    if records.is_empty() || !arx.is_stable() {
        return Ok((1.0, offset));
    }
    let filtered = |r: &Record| Record::new(r.ts(), arx.resume(&mut arx.settled(r.u()[0]), r.u()), r.y().to_vec());
    let (gain, offset, _) = affine(&records.iter().map(filtered).collect::<Result<Vec<_>, _>>()?)?;
    Ok((gain, offset))
}

/// The free-run residual of a stable fit over the output's rms.
fn residual(fit: &Fit, records: &[Record]) -> Option<f64> {
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

/// Returns an error if the inputs have too few frequencies for a block of order `n`.
pub fn require_excitation(records: &[Record], n: usize) -> Result<(), Error> {
    match missing_excitation(&lines(records), n) {
        None => Ok(()),
        Some(why) => Err(Error::Unidentifiable {
            what: "the linear block".into(),
            because: format!("{why}; give a PRBS as the small-signal record, or this one as a large-signal record"),
        }),
    }
}

/// The reason why these frequencies are too few for a block of order `n`.
fn missing_excitation(lines: &[f64], n: usize) -> Option<String> {
    let needed = Orders::of(n).parameters().div_ceil(2);
    let frequencies = match lines {
        [] => "no frequency at all".into(),
        [one] => format!("one frequency ({} Hz)", round(*one)),
        many => format!("{} frequencies", many.len()),
    };
    (lines.len() < needed).then(|| format!("the input has {frequencies}, but a block of order {n} needs {needed}"))
}

/// The frequencies [Hz] of the inputs of all records. Those within a tenth of each other count once.
pub fn lines(records: &[Record]) -> Vec<f64> {
    records.iter().flat_map(excited).fold(Vec::new(), |mut lines: Vec<f64>, hz| {
        if !lines.iter().any(|l| (l / hz - 1.0).abs() < 0.1) {
            lines.push(hz);
        }
        lines
    })
}

/// The frequencies [Hz] at which the input has significant power. A line is [`LINE_WIDTH_BINS`] bins wide; consecutive
/// bins count as one line per that many.
fn excited(record: &Record) -> Vec<f64> {
    let n = record.len();
    let power = power(record.u());
    let strongest = power.iter().copied().fold(0.0, f64::max);
    let hz = |bin: f64| bin / (n as f64 * record.ts());
    let strong: Vec<usize> = (1..power.len()).filter(|&k| power[k] > EXCITED * strongest).collect();
    let runs = strong.chunk_by(|p, q| q - p == 1);
    // The mean frequency of the power in some bins.
    let centre = |bins: &[usize]| {
        let (moment, sum) = bins.iter().fold((0.0, 0.0), |(m, s), &k| (m + k as f64 * power[k], s + power[k]));
        moment / sum
    };
    runs.flat_map(|run| run.chunks(run.len() / (run.len() / LINE_WIDTH_BINS).max(1)).map(centre).collect::<Vec<_>>())
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
    fn one_frequency_gives_a_gain_and_the_reason() {
        let part = linear_from_large_signal(&[record(&[5.0], &beam())], 2).unwrap();
        assert!(part.arx.a().is_empty());
        assert!(part.reason.contains("one frequency (5 Hz)"), "{}", part.reason);
    }

    #[test]
    fn frequencies_around_the_resonance_give_the_block_with_delay_and_offset() {
        let part = linear_from_large_signal(&[record(&[5.0, 40.0, 90.0, 150.0, 220.0], &beam())], 2).unwrap();
        assert!(part.reason.contains("delay of 2 samples"), "{}", part.reason);
        piezoid_testing::assert_close(&[part.arx.poles()[0].hz, part.offset], &[146.73, -40.0], 1e-3, 0.0);
    }

    #[test]
    fn frequencies_somewhat_below_the_resonance_give_the_block() {
        let part = linear_from_large_signal(&[record(&[5.0, 40.0, 80.0, 110.0], &beam())], 2).unwrap();
        piezoid_testing::assert_close(&[part.arx.poles()[0].hz], &[146.73], 1e-3, 0.0);
    }

    #[test]
    fn frequencies_far_below_the_resonance_give_a_gain() {
        let part = linear_from_large_signal(&[record(&[1.0, 2.5, 4.0, 6.0], &beam())], 2).unwrap();
        assert!(part.arx.a().is_empty(), "{}", part.reason);
    }

    /// Least squares by hand: sums of squares and products about the mean of each record 13, 16 and 23.
    #[test]
    fn the_gain_is_that_of_all_records_each_with_its_offset() {
        let first = Record::new(1.0, vec![0.0, 1.0, 2.0, 3.0], vec![1.0, 2.0, 2.0, 5.0]).unwrap();
        let second = Record::new(1.0, vec![2.0, 0.0, -2.0], vec![10.0, 9.0, 5.0]).unwrap();
        let (gain, offset, share) = affine(&[first, second]).unwrap();
        let expected = [16.0 / 13.0, 2.5 - 1.5 * 16.0 / 13.0, (43.0f64 / 299.0).sqrt()];
        piezoid_testing::assert_close(&[gain, offset, share], &expected, 1e-14, 0.0);
    }

    #[test]
    fn a_constant_input_and_an_output_that_does_not_follow_are_different_errors() {
        let moving = vec![0.0, 1.0, 0.0, -1.0];
        for (u, y, says) in [(vec![2.0; 4], &moving, "is constant"), (moving.clone(), &vec![2.0; 4], "does not depend")]
        {
            let error = affine(&[Record::new(1.0, u, y.clone()).unwrap()]).unwrap_err();
            assert!(error.to_string().contains(says), "{error}");
        }
    }

    #[test]
    fn the_gain_behind_dynamics_is_found_with_its_offset_and_is_one_without_evidence() {
        let record = record(&[5.0, 40.0], &beam());
        let half = beam().b().iter().map(|b| 0.5 * b).collect();
        let half = Arx::new(5e-4, beam().a().to_vec(), half).unwrap();
        let (gain, offset) = proportional(&half, 1.0, std::slice::from_ref(&record)).unwrap();
        piezoid_testing::assert_close(&[gain, offset], &[2.0, -40.0], 1e-9, 0.0);
        assert_eq!(proportional(&half, 1.0, &[]).unwrap(), (1.0, 1.0));
        let unstable = Arx::new(5e-4, vec![1.1], vec![1.0]).unwrap();
        assert_eq!(proportional(&unstable, 1.0, &[record]).unwrap(), (1.0, 1.0));
    }

    #[test]
    fn the_residual_is_that_of_the_free_run_over_the_scatter_of_the_output() {
        let record = record(&[5.0, 40.0, 90.0, 150.0, 220.0], &beam());
        let part = linear_from_large_signal(std::slice::from_ref(&record), 2).unwrap();
        let mut fit = part.fit.unwrap();
        fit.offsets[0] += 3.0;
        let expected = 3.0 * (record.len() as f64 / scatter(record.y())).sqrt();
        piezoid_testing::assert_close(&[residual(&fit, &[record]).unwrap()], &[expected], 1e-6, 0.0);
    }

    #[test]
    fn frequencies_of_all_records_count_once_and_too_few_are_an_error() {
        let records = [record(&[5.0, 40.0], &beam()), record(&[5.25, 90.0], &beam())];
        piezoid_testing::assert_close(&lines(&records), &[5.0, 40.0, 90.0], 1e-3, 0.0);
        require_excitation(&records, 2).unwrap();
        let error = require_excitation(&records, 4).unwrap_err();
        assert!(error.to_string().contains("3 frequencies, but a block of order 4 needs"), "{error}");
    }

    #[test]
    fn dynamics_are_taken_if_they_leave_less_than_four_fifths_of_what_a_gain_leaves() {
        let exact = record(&[5.0, 40.0, 90.0, 150.0, 220.0], &beam());
        let y = exact.y().iter().zip(piezoid_testing::noise(1, exact.len())).map(|(y, e)| y + 1e-3 * e).collect();
        let records = [Record::new(5e-4, exact.u().to_vec(), y).unwrap()];
        let (gain, offset, _) = affine(&records).unwrap();
        let part = |left: f64| of_order(&records, 2, (gain, offset, left), &lines(&records)).unwrap();
        let share = residual(&part(1.0).fit.unwrap(), &records).unwrap();
        assert!(share > 0.0);
        let of_gain = part(share / 0.82);
        assert!(of_gain.fit.is_none() && of_gain.reason.contains("no clear improvement"), "{}", of_gain.reason);
        assert!(part(share / 0.78).fit.is_some());
    }

    #[test]
    fn too_few_frequencies_for_an_order_give_the_highest_order_that_they_determine() {
        let part = linear_from_large_signal(&[record(&[5.0, 60.0, 120.0], &beam())], 4).unwrap();
        assert_eq!(part.arx.a().len(), 2);
        piezoid_testing::assert_close(&[part.arx.poles()[0].hz], &[146.73], 1e-3, 0.0);
        let (own, requested) = part.reason.split_once("; for order 4 the result is a pure gain: ").unwrap();
        assert!(own.starts_with("order 2 with a delay of ") && own.contains("(3 frequencies up to 120 Hz)"), "{own}");
        assert!(requested.starts_with("the input has 3 frequencies, but a block of order 4 needs 5"), "{requested}");
    }

    #[test]
    fn a_pole_far_above_all_frequencies_of_the_input_is_not_believed() {
        let part = linear_from_large_signal(&[record(&[5.0, 40.0, 60.0, 80.0], &beam())], 2).unwrap();
        let says = "for order 2 the result is a pure gain: the fit has a pole at 146.7 Hz, but the input has no power \
                    above 80.0 Hz";
        assert!(part.arx.a().len() == 1 && part.reason.contains(says), "{}", part.reason);
    }

    /// The lines of 32 neighbouring sines without gaps, by numpy: 36 bins, of which nine count as one line.
    #[test]
    fn neighbouring_lines_count_by_their_width() {
        let wave = |k: f64, t: f64| (TAU * 0.25 * (200.0 + k) * 5e-4 * t + 0.1 * k * k).sin();
        let u: Vec<f64> = (0..8000).map(|t| (0..32).map(|k| wave(f64::from(k), f64::from(t))).sum()).collect();
        let found = excited(&Record::new(5e-4, u.clone(), u).unwrap());
        piezoid_testing::assert_close(&found, &[50.1625, 53.2435, 54.5414, 57.4812], 1e-5, 0.0);
    }
}
