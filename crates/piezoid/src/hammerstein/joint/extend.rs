//! Extensions of the linear block: a lag, a mode, or one more coefficient of the numerator.
//!
//! ```text
//! B/A = B P / A P,    P = 1 - p q^-1   or   1 - 2 Re(p) q^-1 + |p|^2 q^-2
//! ```
//! The extended block is at first the same block. Where p helps most is seen in the responses to z, which is held: for
//! each p of a grid, and for the modes seen in free decays, the linearised problem is solved in all coefficients and
//! initial states. The best p of each kind and each band of frequencies is a candidate; the best candidates are refined
//! on these responses.
//!
//! Why: docs/decisions/structure-and-operator-selection.md, "A new pole is sought with z held".

use super::hidden::Hidden;
use super::refine::{Fitted, Iterate, StepCallback, refine};
use super::runs::TrainingRecord;
use super::solve::FreeParameters;
use crate::error::Error;
use crate::linear::{Arx, Pole};
use crate::number::short;
use crate::system::System;
use libm::{cos, exp, log};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Ratio of neighbouring time constants and of neighbouring frequencies of the grids, and damping of their modes.
const LAGS: f64 = 2.0;
const MODES: f64 = 1.3;
const DAMPING: [f64; 2] = [0.03, 0.2];

/// The shortest lag [samples], and the highest frequency of a mode, over the sampling rate.
const SHORTEST: f64 = 0.5;
const HIGHEST: f64 = 0.45;

/// Number of neighbouring frequencies of a kind, and of extensions.
const BAND: usize = 4;
const SEVERAL: usize = 3;

/// Difference of ln(minimum) of two extensions that are the same.
const SAME: f64 = 1e-6;

/// Cycles of a mode in the longest record.
const CYCLES: f64 = 10.0;

/// A coefficient that is next to nothing, over the gain: zero would be a delay.
const NOTHING: f64 = 1e-9;

/// An extended linear block, and what was added.
pub(super) struct Extension {
    pub(super) name: String,
    pub(super) linear: Arx,
    /// True if its poles are those of a mode seen in free decays.
    is_seen: bool,
}

/// Where poles are sought.
pub(super) struct Search {
    /// Modes seen in free decays.
    pub(super) modes: Vec<Pole>,
    /// Frequency of the slowest lag that is not creep [Hz].
    pub(super) slowest: f64,
    /// The lowest frequency of a mode that shows only in the response to the inputs [Hz].
    pub(super) lowest: f64,
    /// The highest order.
    pub(super) most: usize,
}

/// The extensions of the linear block of `fitted` that leave least, with z held: those that the records show, and the
/// best of the others.
pub(super) fn extensions(
    fitted: &Fitted,
    runs: &[TrainingRecord],
    search: &Search,
    shows: &dyn Fn(&Arx) -> bool,
    watch: StepCallback,
) -> Result<[Vec<Extension>; 2], Error> {
    let linear = &fitted.estimate.linear;
    let hidden = Hidden::crept(fitted, runs)?;
    let mut responses: Vec<_> = hidden.iter().zip(runs).map(|(z, run)| z.run(run)).collect();
    let estimate = |linear: Arx| Hidden::alone(Vec::new(), linear);
    let longest = runs.iter().map(|run| run.record.duration()).fold(0.0, f64::max);
    let mut found: Vec<(f64, Extension)> = Vec::new();
    for kind in kinds(linear, search, CYCLES / longest)? {
        let score = |one: &Extension| {
            Some(Iterate::at(estimate(one.linear.clone()).ok()?, &responses, &[], FreeParameters::All).predicted(0.0))
        };
        let scores: Vec<f64> = kind.par_iter().map(|one| score(one).unwrap_or(f64::INFINITY)).collect();
        found.extend(scores.into_iter().zip(kind).min_by(|p, q| p.0.total_cmp(&q.0)));
    }
    found.sort_by(|p, q| p.0.total_cmp(&q.0));
    let (mut shown, mut hidden) = (Vec::<(f64, Extension)>::new(), Vec::new());
    for (promised, Extension { name, linear, is_seen }) in found {
        if shown.len() == SEVERAL {
            break;
        }
        let (minimum, linear) = match is_seen {
            true => (promised, linear),
            false => {
                let alone = refine(estimate(linear)?, &mut responses, FreeParameters::All, watch)?;
                (alone.minimum, alone.estimate.linear)
            }
        };
        let list = if shows(&linear) { &mut shown } else { &mut hidden };
        if list.iter().all(|(other, _)| log(minimum / other).abs() > SAME) {
            list.push((minimum, Extension { name, linear, is_seen }));
        }
    }
    let mut lists = [shown, hidden];
    lists.iter_mut().for_each(|list| list.sort_by(|p, q| p.0.total_cmp(&q.0)));
    lists[1].truncate(1);
    Ok(lists.map(|list| list.into_iter().map(|(_, extension)| extension).collect()))
}

/// All extensions of a linear block by kind, with modes from `lowest` [Hz] on.
fn kinds(linear: &Arx, search: &Search, lowest: f64) -> Result<Vec<Vec<Extension>>, Error> {
    let (ts, order, delay) = (linear.ts(), linear.a().len(), linear.delay());
    let by = |name: String, factor: &[f64], b: Vec<f64>| -> Result<Extension, Error> {
        let a = times(&linear.denominator(), factor);
        let linear = Arx::new(ts, a[1..].iter().map(|a| -a).collect(), b)?;
        Ok(Extension { name, linear, is_seen: false })
    };
    let with = |name: String, factor: &[f64]| by(name, factor, times(linear.b(), factor));
    let mut kinds = Vec::new();
    if order < search.most {
        let grid = std::iter::successors(Some(SHORTEST * ts), |tau| Some(LAGS * tau));
        let grid: Vec<f64> = grid.take_while(|tau| TAU * tau * search.slowest < 1.0).collect();
        let lag = |tau: f64| [1.0, -exp(-ts / tau)];
        kinds.push(grid.iter().map(|&tau| with("a lag".into(), &lag(tau))).collect::<Result<_, _>>()?);
        // A lag acts like a delay of its time constant.
        let instead = |&tau: &f64| {
            let [one, p] = lag(tau);
            let b = linear.b()[delay..].iter().map(|b| b * (1.0 + p)).collect();
            by("a lag instead of the delay".into(), &[one, p], b)
        };
        if delay > 0 {
            kinds.push(grid.iter().map(instead).collect::<Result<_, _>>()?);
        }
    }
    if order + 2 <= search.most {
        let grid: Vec<[f64; 3]> = modes(ts, search.lowest.max(lowest)).collect();
        for band in grid.chunks(BAND * DAMPING.len()) {
            kinds.push(band.iter().map(|mode| with("a mode".into(), mode)).collect::<Result<_, _>>()?);
        }
        // A mode acts like a delay too.
        let instead = |mode: &[f64; 3]| {
            let b = linear.b()[delay..].iter().map(|b| b * mode.iter().sum::<f64>()).collect();
            by("a mode instead of the delay".into(), mode, b)
        };
        if delay > 0 {
            kinds.push(grid.iter().map(instead).collect::<Result<_, _>>()?);
        }
        for pole in &search.modes {
            let name = format!("a mode at {} Hz, seen in free decays", short(pole.hz));
            let mode = with(name, &[1.0, -2.0 * pole.z.re, pole.z.modulus().powi(2)])?;
            kinds.push(vec![Extension { is_seen: true, ..mode }]);
        }
    }
    let longer = [linear.b(), &[NOTHING * linear.b().iter().sum::<f64>()]].concat();
    kinds.push(vec![by("one more coefficient".into(), &[1.0], longer)?]);
    Ok(kinds)
}

/// The denominators of the modes of the grid, from the highest frequency down to `lowest` [Hz].
fn modes(ts: f64, lowest: f64) -> impl Iterator<Item = [f64; 3]> {
    let grid = std::iter::successors(Some(HIGHEST / ts), |hz| Some(hz / MODES)).take_while(move |hz| *hz > lowest);
    let mode = move |(hz, damping): (f64, f64)| {
        let (radius, angle) = (exp(-damping * TAU * hz * ts), TAU * hz * ts * (1.0 - damping * damping).sqrt());
        [1.0, -2.0 * radius * cos(angle), radius * radius]
    };
    grid.flat_map(move |hz| DAMPING.map(|damping| mode((hz, damping))))
}

/// The product of two polynomials.
pub(super) fn times(p: &[f64], q: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; p.len() + q.len() - 1];
    for (i, p) in p.iter().enumerate() {
        q.iter().enumerate().for_each(|(j, q)| product[i + j] += p * q);
    }
    product
}

#[cfg(test)]
mod tests {
    use super::super::refine::refine_from;
    use super::super::{held_out::Smoothness, runs::of, testing::estimate};
    use super::*;
    use crate::record::Record;
    use piezoid_testing::assert_close;

    /// A record of a second-order block with curved hysteresis and noise.
    fn records() -> Vec<Record> {
        let block = Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1]).unwrap();
        let u: Vec<f64> = (0..1500).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let z: Vec<f64> = u.iter().map(|u| u + 0.01 * u * u).collect();
        let rough = |(t, y): (usize, f64)| y + 0.1 * ((t * t) as f64 * 0.618_034).fract();
        let y = block.simulate(&z).into_iter().enumerate().map(rough).collect();
        vec![Record::new(5e-4, u, y).unwrap()]
    }

    #[test]
    fn an_extended_fit_starts_at_the_poorer_one_and_ends_no_higher() {
        let records = records();
        let mut runs = of(&[], &records, &mut Vec::new()).unwrap();
        let from = refine(estimate("prandtl-ishlinskii", 6), &mut runs, FreeParameters::All, &mut |_| Ok(())).unwrap();
        let search = Search { modes: Vec::new(), slowest: 1.0, lowest: 10.0, most: 4 };
        let linear = &from.estimate.linear;
        let response = linear.simulate(records[0].u());
        let size = response.iter().fold(0.0f64, |m, y| m.max(y.abs()));
        let same =
            kinds(linear, &search, 10.0).unwrap().into_iter().flatten().filter(|one| !one.name.contains("instead"));
        let mut seen = 0;
        for Extension { name, linear, .. } in same {
            let extended = linear.simulate(records[0].u());
            let off = response.iter().zip(&extended).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(off < 1e-6 * size, "{name}: {off:e} of {size}");
            seen += 1;
            if seen % 4 == 0 {
                let start = from.estimate.with_linear(linear).unwrap();
                let smoothness = Smoothness::Fixed(from.held_out.lambda);
                let longer = refine_from(start, smoothness, &mut runs, FreeParameters::All, &mut |_| Ok(())).unwrap();
                // What is expected of the initial state depends on the slowest pole.
                let ratio = longer.minimum / from.minimum;
                assert!(ratio < 1.001, "{name}: the minimum rises by the ratio {ratio}");
            }
        }
        assert!(seen > 20, "{seen}");
    }

    #[test]
    fn a_delay_is_replaced_by_a_lag_or_a_mode_of_the_same_static_gain() {
        let search = Search { modes: Vec::new(), slowest: 1.0, lowest: 10.0, most: 4 };
        let instead = |block: &Arx| -> Vec<Extension> {
            let all = kinds(block, &search, 10.0).unwrap().into_iter().flatten();
            all.filter(|one| one.name.ends_with("instead of the delay")).collect()
        };
        let late = Arx::new(5e-4, vec![0.6], vec![0.0, 0.0, 0.3, 0.1]).unwrap();
        let found = instead(&late);
        for order in [2, 3] {
            assert!(found.iter().any(|one| one.linear.a().len() == order), "order {order}");
        }
        for Extension { linear, .. } in found {
            assert_eq!(linear.delay(), 0);
            assert_close(&[linear.dc_gain()], &[late.dc_gain()], 1e-9, 0.0);
        }
        assert!(instead(&Arx::new(5e-4, vec![0.6], vec![0.3, 0.1]).unwrap()).is_empty());
    }

    #[test]
    fn the_extension_that_made_the_record_is_found_first() {
        let block = Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1]).unwrap();
        let u: Vec<f64> = (0..1500).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let y = block.simulate(&u);
        let records = [Record::new(5e-4, u, y).unwrap()];
        let mut runs = of(&[], &records, &mut Vec::new()).unwrap();
        let gain = estimate("proportional", 1).with_linear(Arx::gain(5e-4, 1.0).unwrap()).unwrap();
        let from = refine(gain, &mut runs, FreeParameters::All, &mut |_| Ok(())).unwrap();
        let search = Search { modes: Vec::new(), slowest: 1.0, lowest: 10.0, most: 4 };
        let [shown, _] = extensions(&from, &runs, &search, &|_| true, &mut |_| Ok(())).unwrap();
        assert_eq!(shown[0].name, "a mode");
        assert_close(shown[0].linear.a(), block.a(), 1e-3, 0.0);
    }
}
