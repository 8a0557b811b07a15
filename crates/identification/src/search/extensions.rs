//! Extensions of the linear block: a lag, a mode, or one more coefficient of the numerator.
//!
//! ```text
//! B/A = B P / A P,    P = 1 - p q^-1   or   1 - 2 Re(p) q^-1 + |p|^2 q^-2
//! ```
//! At first P cancels, and the extended block has the same response. The responses to z, which is held, show where p
//! helps most: for each p of a grid, and for the modes in free decays, the linearised problem is solved in all
//! coefficients and initial states. The best p of each kind and each band of frequencies is refined on these responses,
//! the most promising first.
//!
//! Why: docs/decisions/structure-and-operator-selection.md, "A new pole is sought with z held".

use super::POLICY;
use super::fit::{Fitted, FreeParameters, Hidden, Iterate, StepCallback, TrainingRecord, refine};
use super::mode_evidence::ModeEvidence;
use crate::side_by_side::side_by_side;
use libm::{cos, exp, log};
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::system::System;
use rayon::prelude::*;
use std::f64::consts::TAU;
use tracing::trace_span;

/// Difference of ln(minimum) of two extensions that are the same.
const SAME_LOG_MINIMUM: f64 = 1e-6;

/// A coefficient that is next to nothing, over the gain: zero would be a delay.
const NEGLIGIBLE_COEFFICIENT: f64 = 1e-9;

/// An extended linear block, and what was added.
pub(super) struct Extension {
    pub(super) name: String,
    pub(super) linear: Arx,
    /// True if its poles are those of a mode in free decays.
    is_in_free_decays: bool,
}

/// Limits of the poles of the linear block.
pub(super) struct PoleLimits {
    /// Frequency of the slowest lag that is neither creep nor longer than the records [Hz]; not 0.
    pub(super) slowest: f64,
    /// Frequency of the slowest mode [Hz].
    pub(super) slowest_mode: f64,
    /// The highest order.
    pub(super) max_order: usize,
}

/// The extensions of the linear block of `fitted` that leave least, with z held: the best `count` of those that the
/// records show, and the best of the others.
pub(super) fn extensions(
    fitted: &Fitted,
    runs: &[TrainingRecord],
    limits: &PoleLimits,
    evidence: &ModeEvidence,
    count: usize,
    watch: StepCallback,
) -> Result<[Vec<Extension>; 2], Error> {
    let _stage = trace_span!(target: "stage", "extensions").entered();
    let linear = &fitted.estimate.linear;
    let hidden = Hidden::crept(fitted, runs)?;
    let responses: Vec<_> = hidden.iter().zip(runs).map(|(z, run)| z.run(run)).collect();
    let estimate = |linear: Arx| Hidden::alone(Vec::new(), linear);
    let score = |one: &Extension| {
        Some(Iterate::at(estimate(one.linear.clone()).ok()?, &responses, &[], FreeParameters::All).predicted(0.0))
    };
    let groups = groups(linear, limits, evidence)?;
    let scores: Vec<f64> = groups.par_iter().flatten().map(|one| score(one).unwrap_or(f64::INFINITY)).collect();
    let mut scores = scores.into_iter();
    let best = |group: Vec<Extension>| {
        let scored = group.into_iter().zip(scores.by_ref()).map(|(one, score)| (score, one));
        scored.min_by(|p, q| p.0.total_cmp(&q.0))
    };
    let mut best_of_groups: Vec<(f64, Extension)> = groups.into_iter().filter_map(best).collect();
    best_of_groups.sort_by(|p, q| p.0.total_cmp(&q.0));
    let (mut shown, mut others) = (Vec::<(f64, Extension)>::new(), Vec::<(f64, Extension)>::new());
    let alone = |(promised, one): (f64, Extension), watch: StepCallback| -> Result<_, Error> {
        if one.is_in_free_decays {
            return Ok((promised, one));
        }
        let fit = refine(estimate(one.linear)?, &mut responses.clone(), FreeParameters::All, watch)?;
        Ok((fit.minimum, Extension { linear: fit.estimate.linear, ..one }))
    };
    let mut best_of_groups = best_of_groups.into_iter().peekable();
    while shown.len() < count && best_of_groups.peek().is_some() {
        let next = best_of_groups.by_ref().take(count).collect();
        for fit in side_by_side(next, alone, |_, _| watch(0))? {
            let (minimum, extension) = fit?;
            let list = if evidence.shows(&extension.linear) { &mut shown } else { &mut others };
            if list.iter().all(|(other, _)| log(minimum / other).abs() > SAME_LOG_MINIMUM) {
                list.push((minimum, extension));
            }
        }
    }
    let mut lists = [shown, others];
    lists.iter_mut().for_each(|list| list.sort_by(|p, q| p.0.total_cmp(&q.0)));
    lists[0].truncate(count);
    lists[1].truncate(1);
    Ok(lists.map(|list| list.into_iter().map(|(_, extension)| extension).collect()))
}

/// A kind of extension.
struct Kind {
    name: &'static str,
    /// Number of poles that it adds.
    poles: usize,
    /// True if it replaces the delay: a lag acts like a delay of its time constant, and a mode does too.
    replaces_delay: bool,
    /// The factors P, in groups of which the best is tried.
    groups: fn(&Grid) -> Vec<Vec<Factor>>,
}

/// The factor P of an extension, as coefficients of q^-1.
type Factor = Vec<f64>;

/// All kinds of extensions but the modes in free decays and a further coefficient.
const KINDS: [Kind; 4] = [
    Kind { name: "a lag", poles: 1, replaces_delay: false, groups: |grid| vec![grid.lags()] },
    Kind { name: "a lag instead of the delay", poles: 1, replaces_delay: true, groups: |grid| vec![grid.lags()] },
    Kind {
        name: "a mode",
        poles: 2,
        replaces_delay: false,
        groups: |grid| {
            let band = POLICY.mode_band * POLICY.mode_damping.len();
            grid.modes().chunks(band).map(<[Factor]>::to_vec).collect()
        },
    },
    Kind { name: "a mode instead of the delay", poles: 2, replaces_delay: true, groups: |grid| vec![grid.modes()] },
];

/// All extensions of a linear block, in groups of which the best is tried.
fn groups(linear: &Arx, limits: &PoleLimits, evidence: &ModeEvidence) -> Result<Vec<Vec<Extension>>, Error> {
    let (ts, delay) = (linear.ts(), linear.delay());
    let fits = |poles: usize| linear.a().len() + poles <= limits.max_order;
    let by = |name: String, factor: &[f64], b: Vec<f64>| -> Result<Extension, Error> {
        let a = product(&linear.denominator(), factor);
        let linear = Arx::new(ts, a[1..].iter().map(|a| -a).collect(), b)?;
        Ok(Extension { name, linear, is_in_free_decays: false })
    };
    let grid = Grid { ts, slowest: limits.slowest, lowest: evidence.lowest.max(limits.slowest_mode) };
    let mut groups = Vec::new();
    for kind in KINDS.iter().filter(|kind| fits(kind.poles) && (delay > 0 || !kind.replaces_delay)) {
        let extended = |factor: &Factor| {
            let b = match kind.replaces_delay {
                true => linear.b()[delay..].iter().map(|b| b * factor.iter().sum::<f64>()).collect(),
                false => product(linear.b(), factor),
            };
            by(kind.name.into(), factor, b)
        };
        for factors in (kind.groups)(&grid) {
            groups.push(factors.iter().map(extended).collect::<Result<_, _>>()?);
        }
    }
    for pole in evidence.free_decays.iter().filter(|_| fits(2)) {
        let name = format!("a mode at {} Hz, seen in free decays", short(pole.hz));
        let factor = [1.0, -2.0 * pole.z.re, pole.z.modulus().powi(2)];
        let mode = by(name, &factor, product(linear.b(), &factor))?;
        groups.push(vec![Extension { is_in_free_decays: true, ..mode }]);
    }
    let longer = [linear.b(), &[NEGLIGIBLE_COEFFICIENT * linear.b().iter().sum::<f64>()]].concat();
    groups.push(vec![by("one more coefficient".into(), &[1.0], longer)?]);
    Ok(groups)
}

/// The poles that are tried.
struct Grid {
    /// Sampling period [s].
    ts: f64,
    /// Frequency of the slowest lag [Hz].
    slowest: f64,
    /// Frequency of the slowest mode [Hz].
    lowest: f64,
}

impl Grid {
    /// The factors of lags, from the shortest on.
    fn lags(&self) -> Vec<Factor> {
        let shortest = POLICY.shortest_lag * self.ts;
        let grid = std::iter::successors(Some(shortest), |tau| Some(POLICY.lag_grid_ratio * tau));
        grid.take_while(|tau| TAU * tau * self.slowest < 1.0).map(|tau| vec![1.0, -exp(-self.ts / tau)]).collect()
    }

    /// The factors of modes, from the highest frequency down.
    fn modes(&self) -> Vec<Factor> {
        let highest = POLICY.highest_mode / self.ts;
        let grid = std::iter::successors(Some(highest), |hz| Some(hz / POLICY.mode_grid_ratio));
        let mode = |(hz, damping): (f64, f64)| {
            let angle = TAU * hz * self.ts * (1.0 - damping * damping).sqrt();
            let radius = exp(-damping * TAU * hz * self.ts);
            vec![1.0, -2.0 * radius * cos(angle), radius * radius]
        };
        let grid = grid.take_while(|hz| *hz > self.lowest);
        grid.flat_map(|hz| POLICY.mode_damping.map(|damping| mode((hz, damping)))).collect()
    }
}

/// The product of two polynomials.
pub(super) fn product(p: &[f64], q: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; p.len() + q.len() - 1];
    for (i, p) in p.iter().enumerate() {
        q.iter().enumerate().for_each(|(j, q)| product[i + j] += p * q);
    }
    product
}

#[cfg(test)]
mod tests {
    use super::super::fit::{Smoothness, estimate, refine_from, training_records};
    use super::*;
    use piezoid_records::record::Record;
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
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let from = refine(estimate("prandtl-ishlinskii", 6), &mut runs, FreeParameters::All, &mut |_| Ok(())).unwrap();
        let (limits, evidence) =
            (PoleLimits { slowest: 1.0, slowest_mode: 10.0, max_order: 4 }, ModeEvidence::of_all(10.0));
        let linear = &from.estimate.linear;
        let response = linear.simulate(records[0].u());
        let size = response.iter().fold(0.0f64, |m, y| m.max(y.abs()));
        let same = groups(linear, &limits, &evidence)
            .unwrap()
            .into_iter()
            .flatten()
            .filter(|one| !one.name.contains("instead"));
        let mut count = 0;
        for Extension { name, linear, .. } in same {
            let extended = linear.simulate(records[0].u());
            let off = response.iter().zip(&extended).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(off < 1e-6 * size, "{name}: {off:e} of {size}");
            count += 1;
            if count % 4 == 0 {
                let start = from.estimate.with_linear(linear);
                let smoothness = Smoothness::Fixed(from.held_out.lambda);
                let longer = refine_from(start, smoothness, &mut runs, FreeParameters::All, &mut |_| Ok(())).unwrap();
                // What is expected of the initial state depends on the slowest pole.
                let ratio = longer.minimum / from.minimum;
                assert!(ratio < 1.001, "{name}: the minimum rises by the ratio {ratio}");
            }
        }
        assert!(count > 20, "{count}");
    }

    #[test]
    fn a_delay_is_replaced_by_a_lag_or_a_mode_of_the_same_static_gain() {
        let (limits, evidence) =
            (PoleLimits { slowest: 1.0, slowest_mode: 10.0, max_order: 4 }, ModeEvidence::of_all(10.0));
        let instead = |block: &Arx| -> Vec<Extension> {
            let all = groups(block, &limits, &evidence).unwrap().into_iter().flatten();
            all.filter(|one| one.name.ends_with("instead of the delay")).collect()
        };
        let delayed = Arx::new(5e-4, vec![0.6], vec![0.0, 0.0, 0.3, 0.1]).unwrap();
        let found = instead(&delayed);
        for order in [2, 3] {
            assert!(found.iter().any(|one| one.linear.a().len() == order), "order {order}");
        }
        for Extension { linear, .. } in found {
            assert_eq!(linear.delay(), 0);
            assert_close(&[linear.dc_gain()], &[delayed.dc_gain()], 1e-9, 0.0);
        }
        assert!(instead(&Arx::new(5e-4, vec![0.6], vec![0.3, 0.1]).unwrap()).is_empty());
    }

    #[test]
    fn the_extension_behind_the_record_is_found_first() {
        let block = Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1]).unwrap();
        let u: Vec<f64> = (0..1500).map(|t| 28.0 * (0.01 * f64::from(t)).sin() * (0.13 * f64::from(t)).sin()).collect();
        let y = block.simulate(&u);
        let records = [Record::new(5e-4, u, y).unwrap()];
        let mut runs = training_records(&[], &records, &mut Vec::new()).unwrap();
        let gain = estimate("proportional", 1).with_linear(Arx::gain(5e-4, 1.0).unwrap());
        let from = refine(gain, &mut runs, FreeParameters::All, &mut |_| Ok(())).unwrap();
        let (limits, evidence) =
            (PoleLimits { slowest: 1.0, slowest_mode: 10.0, max_order: 4 }, ModeEvidence::of_all(10.0));
        let [shown, _] = extensions(&from, &runs, &limits, &evidence, 3, &mut |_| Ok(())).unwrap();
        assert_eq!(shown[0].name, "a mode");
        assert_close(shown[0].linear.a(), block.a(), 1e-3, 0.0);
    }

    #[test]
    fn the_grid_has_lags_an_octave_apart_and_modes_from_the_highest_frequency_down() {
        let grid = Grid { ts: 1e-3, slowest: 20.0, lowest: 100.0 };
        let lags: Vec<f64> = grid.lags().iter().map(|factor| -1e-3 / log(-factor[1])).collect();
        assert_close(&lags, &[0.5e-3, 1e-3, 2e-3, 4e-3], 1e-12, 0.0);
        let pole = |factor: &Factor| {
            let [_, b, c] = factor[..] else { panic!("{factor:?}") };
            let (decay, angle) = (0.5 * log(c), libm::acos(-0.5 * b / c.sqrt()));
            let size = libm::hypot(decay, angle);
            [size / (TAU * 1e-3), -decay / size]
        };
        let found: Vec<f64> = grid.modes().iter().flat_map(pole).collect();
        let hz = (0..6).map(|k| 450.0 / libm::pow(1.3, f64::from(k)));
        let expected: Vec<f64> = hz.flat_map(|hz| [hz, 0.03, hz, 0.2]).collect();
        assert_close(&found, &expected, 1e-9, 0.0);
    }
}
