//! Two branches for each of several frequencies, interpolated: the paper's rate-dependent block (section 3, one pair of
//! branches per frequency) extended to inputs of unknown frequency.
//!
//! The frequency is estimated from the reversals of the input: the last two half periods are one period. A half period
//! lasts from reversal to reversal, the first one from the rest before the first sample. The last sample of an extreme
//! that is held is the reversal. A reversal counts when the input has moved back by more than 1/50 of the identified
//! range, so ripple and quantisation do not count. If the present half period is already longer than the last period,
//! it is taken as the period. Until there are two half periods the lowest frequency is used. Between two pairs z is
//! interpolated linearly in the logarithm of frequency; outside them the nearest pair is used.
//!
//! It does not do: minor loops. For an input that is not periodic the frequency is only an estimate.
//!
//! Inverse and saturation: like `two-branch`, at the frequency that results from the next input.

use super::basis::counted;
use super::inverse::{Inverted, by_slopes, by_trials};
use super::nodes::Nodes;
use super::real::Real;
use super::two_branch::{READ, example, read, read_slope};
use super::{Basis, BasisDesign, Branches, Class, HeldInput, Hysteresis, Operator, document, parse};
use crate::elementary::ln;
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::intervals::Intervals;
use piezoid_numerics::system::System;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::sync::Arc;

/// A reversal counts when the input has moved back by this share of the identified range.
const MIN_REVERSAL_SHARE: f64 = 0.02;

/// Frequencies of records with a smaller relative difference are treated as equal.
const SAME: f64 = 0.01;

/// Branches scheduled by the frequency of the input.
///
/// State: the last input; its direction (1, -1, 0 not yet known); the trend (the direction between reversals); the
/// extreme since the last reversal; samples since that extreme; samples since the reversal before it; the last and the
/// last but one half period [samples], 0 while unknown.
#[derive(Debug, Clone, PartialEq)]
pub struct RateScheduled {
    ts: f64,
    params: RateScheduledParams,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RateScheduledParams {
    #[serde(default)]
    reading: HeldInput,
    pairs: Vec<Pair>,
}

/// The branches at one frequency.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pair {
    /// Frequency of the loop [Hz].
    pub frequency_hz: f64,
    /// Its branches.
    pub branches: Branches,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "rate-scheduled",
    aliases: &[],
    summary: "two splines for each of several frequencies, interpolated by the rate of the input; no minor loops",
    reference: "Kuklisova Pavelkova, ICINCO 2025, section 3",
    minor_loops: false,
    needs_minor_loops: false,
    rate_independent: false,
    wipes_out: false,
    class: Class::Branches,
    basis: |design| Ok(Box::new(RateScheduledBasis::new(design)?)),
    load: |params, ts| {
        let params: RateScheduledParams = parse("rate-scheduled", params)?;
        Ok(Arc::new(RateScheduled::new(ts, params.pairs, params.reading)?))
    },
    example: |ts| {
        let pair = |frequency_hz, width| Ok(Pair { frequency_hz, branches: example(width)? });
        Ok(Arc::new(RateScheduled::new(ts, vec![pair(5.0, 1.0)?, pair(80.0, 3.0)?], HeldInput::Held)?))
    },
};

impl RateScheduled {
    /// A block with sampling period `ts` [s] and the rule `reading` for held inputs. Pairs are sorted by frequency.
    /// Returns an error if there are no pairs, if two have the same frequency, or if a frequency or `ts` is not
    /// positive.
    pub fn new(ts: f64, mut pairs: Vec<Pair>, reading: HeldInput) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        if pairs.is_empty() {
            let what = "hysteresis block `rate-scheduled`: needs at least one pair of branches";
            return Err(Error::Content(what.into()));
        }
        for pair in &pairs {
            positive("frequency_hz", pair.frequency_hz, "hertz")?;
        }
        pairs.sort_by(|p, q| p.frequency_hz.total_cmp(&q.frequency_hz));
        if let Some(w) = pairs.windows(2).find(|w| w[0].frequency_hz == w[1].frequency_hz) {
            let rule = "two pairs of branches have this frequency: keep one";
            return Err(Error::parameter("frequency_hz", w[0].frequency_hz, rule));
        }
        Ok(RateScheduled { ts, params: RateScheduledParams { reading, pairs } })
    }

    /// The pairs, by ascending frequency.
    pub fn pairs(&self) -> &[Pair] {
        &self.params.pairs
    }

    /// The pairs on both sides of `frequency` [Hz] with their shares; outside all pairs only the nearest one.
    fn shares(&self, frequency: f64) -> [(usize, f64); 2] {
        let pairs = &self.params.pairs;
        let above = pairs.partition_point(|p| p.frequency_hz <= frequency);
        if above == 0 || above == pairs.len() {
            let nearest = above.saturating_sub(1);
            return [(nearest, 1.0), (nearest, 0.0)];
        }
        let (low, high) = (pairs[above - 1].frequency_hz, pairs[above].frequency_hz);
        let share = ln(frequency / low) / ln(high / low);
        [(above - 1, 1.0 - share), (above, share)]
    }

    /// What `read` returns for the pairs on both sides of `frequency` [Hz], by their shares.
    fn interpolate<R: Real>(&self, frequency: f64, read: impl Fn(&Branches) -> R) -> R {
        let [low, high] = self.shares(frequency);
        let z = |(k, share): (usize, f64)| R::from(share) * read(&self.params.pairs[k].branches);
        z(low) + z(high)
    }

    /// Advances the state by one input. Returns the direction to use and the frequency [Hz].
    fn follow(&self, x: &mut [f64], u: f64) -> (f64, f64) {
        let direction = self.params.reading.direction(x[0], u, x[1]);
        x[1] = HeldInput::Held.direction(x[0], u, x[1]);
        x[0] = u;
        self.find_reversals(x, u);
        (direction, self.frequency(x))
    }

    /// Updates the reversals in the state; the direction is already up to date.
    fn find_reversals(&self, x: &mut [f64], u: f64) {
        let [_, direction, trend, extreme, since_extreme, since_turn, last, before_last] = x else { return };
        *since_extreme += 1.0;
        *since_turn += 1.0;
        if *trend == 0.0 {
            *trend = *direction;
        }
        if (u - *extreme) * *trend >= 0.0 {
            // The last sample of a held extreme is the reversal.
            (*extreme, *since_extreme) = (u, 0.0);
        } else if (*extreme - u) * *trend > MIN_REVERSAL_SHARE * self.span() {
            *before_last = *last;
            *last = *since_turn - *since_extreme;
            *since_turn = *since_extreme;
            (*extreme, *since_extreme, *trend) = (u, 0.0, -*trend);
        }
    }

    /// The estimated frequency [Hz]; the lowest one until there are two half periods.
    fn frequency(&self, x: &[f64]) -> f64 {
        let [.., since_turn, last, before_last] = x else { return 0.0 };
        if *before_last == 0.0 {
            return self.params.pairs[0].frequency_hz;
        }
        1.0 / (self.ts * (last + before_last).max(*since_turn))
    }

    fn span(&self) -> f64 {
        self.range().map_or(0.0, |(low, high)| high - low)
    }
}

impl System for RateScheduled {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        8
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        vec![u, 0.0, 0.0, u, 0.0, 0.0, 0.0, 0.0]
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        let (direction, frequency) = self.follow(x, u);
        self.interpolate(frequency, |branches| read(branches, u, direction))
    }
}

impl Hysteresis for RateScheduled {
    fn operator(&self) -> &'static Operator {
        &OPERATOR
    }

    fn params(&self) -> Map<String, Value> {
        document(&self.params)
    }

    fn invert(&self, x: &[f64], z: f64, ends: (f64, f64)) -> Inverted {
        let mut trial = [0.0; 8];
        let ahead = |u| {
            trial.copy_from_slice(x);
            let (direction, frequency) = self.follow(&mut trial, u);
            self.interpolate(frequency, |branches| read_slope(branches, u, direction))
        };
        by_slopes(x[0], z, ends, ahead).unwrap_or_else(|| by_trials(self, x, z, ends))
    }

    fn block(&self) -> Option<Block> {
        let RateScheduledParams { reading, pairs } = &self.params;
        let hertz: Vec<f64> = pairs.iter().map(|p| p.frequency_hz).collect();
        let block = Block::new("hysteresis", format!("{}: {}", OPERATOR.name, OPERATOR.summary));
        let state = ["last", "direction", "trend", "extreme", "since_extreme", "since_turn", "half", "half_before"];
        let block = state.iter().fold(block, |block, name| block.number(name, 0.0));
        let block = block.constant("ts", self.ts).constant("turn", MIN_REVERSAL_SHARE * self.span());
        let block = Branches::block(block, pairs.iter().map(|p| &p.branches)).table("hertz", &hertz);
        let block =
            block.count("pairs", pairs.len()).text(READ).text(&Intervals::text("pair_below", "hertz", pairs.len()));
        Some(block.text(&STEP.replace("HELD", reading.held())))
    }

    fn frequencies(&self) -> Option<(f64, f64)> {
        let pairs = &self.params.pairs;
        Some((pairs[0].frequency_hz, pairs[pairs.len() - 1].frequency_hz))
    }

    fn range(&self) -> Option<(f64, f64)> {
        let ranges = self.params.pairs.iter().map(|p| p.branches.range());
        Some(ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |all, r| (all.0.min(r.0), all.1.max(r.1))))
    }
}

const STEP: &str = "
// Advances the turning points by one input.
fn watch(x: hysteresis, u) {
    x.since_extreme += 1.0;
    x.since_turn += 1.0;
    if x.trend == 0.0 { x.trend = x.direction; }
    if (u - x.extreme) * x.trend >= 0.0 {
        // If the extreme is held, the reversal is its last sample.
        x.extreme = u;
        x.since_extreme = 0.0;
    } else if (x.extreme - u) * x.trend > turn {
        x.half_before = x.half;
        x.half = x.since_turn - x.since_extreme;
        x.since_turn = x.since_extreme;
        x.extreme = u;
        x.since_extreme = 0.0;
        x.trend = -x.trend;
    }
}

// The frequency of the input [Hz], from the last two half-periods; the lowest one until two reversals have occurred.
fn frequency(x: hysteresis) {
    let f = hertz[0];
    if x.half_before != 0.0 {
        let period = x.half + x.half_before;
        if x.since_turn > period { period = x.since_turn; }
        f = 1.0 / (ts * period);
    }
    return f;
}

// z at u between the pairs on either side of frequency f, and the slope; outside them all the nearest one alone.
fn interpolated(u, direction, f) {
    let nearest = whole(pair_below(0, pairs, f));
    let share = 0.0;
    if f >= hertz[0] && nearest + 1 < pairs {
        share = logarithm(f / hertz[nearest]) / logarithm(hertz[nearest + 1] / hertz[nearest]);
    }
    let z = 0.0;
    let slope = 0.0;
    let part = 1.0 - share;
    for pair in nearest..nearest + 2 at most 2 {
        if part != 0.0 {
            let on_pair, rises = read_pair(pair, u, direction);
            z += part * on_pair;
            slope += part * rises;
        }
        part = share;
    }
    return z, slope;
}

// Advances the state by one input; returns z, and the slope.
fn advanced(x: hysteresis, u) {
    let direction = heading(x.last, u, HELD);
    x.direction = heading(x.last, u, x.direction);
    x.last = u;
    watch(x, u);
    let z, slope = interpolated(u, direction, frequency(x));
    return z, slope;
}

fn hysteresis(x: hysteresis, u) {
    let z, slope = advanced(x, u);
    return z;
}

// What the next step would give, and the slope.
fn hysteresis_ahead(x: hysteresis, u) {
    let trial = copy(x);
    let z, slope = advanced(trial, u);
    return z, slope;
}
";

/// The basis: the branches of every frequency by their values at equidistant knots, with [`HeldInput::Held`].
#[derive(Debug, Clone)]
struct RateScheduledBasis {
    nodes: Nodes,
    /// Holds the frequencies; its branches are not used.
    schedule: RateScheduled,
}

impl RateScheduledBasis {
    fn new(design: &BasisDesign) -> Result<Self, Error> {
        if design.frequencies.is_empty() {
            let because = "the inputs of the records have no dominant frequency: use two-branch, or give one record \
                           per frequency"
                .into();
            return Err(Error::Unidentifiable { what: "the rate-scheduled block".into(), because });
        }
        let nodes = Nodes::new(design)?;
        let flat = nodes.branches(&vec![0.0; nodes.len()])?;
        // Records of nearly equal frequency share their branches.
        let mut frequencies = design.frequencies.clone();
        frequencies.sort_by(f64::total_cmp);
        frequencies.dedup_by(|next, f| *next < (1.0 + SAME) * *f);
        let pair = |frequency_hz| Pair { frequency_hz, branches: flat.clone() };
        let pairs = frequencies.into_iter().map(pair).collect();
        Ok(RateScheduledBasis { schedule: RateScheduled::new(design.ts, pairs, HeldInput::Held)?, nodes })
    }
}

impl Basis for RateScheduledBasis {
    fn len(&self) -> usize {
        self.nodes.len() * self.schedule.pairs().len()
    }

    fn order(&self) -> usize {
        self.schedule.order()
    }

    fn step(&self, x: &mut [f64], u: f64, phi: &mut [f64]) {
        let (direction, frequency) = self.schedule.follow(x, u);
        let n = self.nodes.len();
        phi.fill(0.0);
        for (k, share) in self.schedule.shares(frequency) {
            self.nodes.respond(u, -direction, share, &mut phi[k * n..(k + 1) * n]);
        }
    }

    fn non_negative(&self) -> Vec<bool> {
        self.schedule.pairs().iter().flat_map(|_| self.nodes.non_negative()).collect()
    }

    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        let n = self.nodes.len();
        (0..self.schedule.pairs().len()).flat_map(|k| self.nodes.roughness(k * n)).collect()
    }

    fn reshaped(&self, shape: &[f64]) -> Result<Box<dyn Basis>, Error> {
        counted(OPERATOR.name, "shape", shape.len(), 0)?;
        Ok(Box::new(self.clone()))
    }

    fn operator(&self, weights: &[f64]) -> Result<Arc<dyn Hysteresis>, Error> {
        counted(OPERATOR.name, "weights", weights.len(), self.len())?;
        let pair = |(pair, weights): (&Pair, &[f64])| {
            Ok(Pair { frequency_hz: pair.frequency_hz, branches: self.nodes.branches(weights)? })
        };
        let pairs = self.schedule.pairs().iter().zip(weights.chunks(self.nodes.len())).map(pair);
        let pairs = pairs.collect::<Result<Vec<_>, Error>>()?;
        Ok(Arc::new(RateScheduled::new(self.schedule.ts, pairs, HeldInput::Held)?))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::check_program;
    use super::*;
    use piezoid_testing::assert_close;

    fn pair(frequency_hz: f64, width: f64) -> Pair {
        Pair { frequency_hz, branches: example(width).unwrap() }
    }

    fn block() -> RateScheduled {
        RateScheduled::new(5e-4, vec![pair(80.0, 3.0), pair(5.0, 1.0)], HeldInput::Held).unwrap()
    }

    /// The frequency that the block estimates from a sine of `hz`, quantised in steps of `levels`.
    fn estimated(hz: f64, levels: Option<f64>) -> f64 {
        let (block, mut x) = (block(), block().initial());
        let sine = (0..2000).map(|t| 30.0 * (f64::from(t) * 5e-4 * std::f64::consts::TAU * hz).sin());
        let u: Vec<f64> = sine.map(|u| levels.map_or(u, |q| (u / q).round() * q)).collect();
        block.resume(&mut x, &u);
        block.frequency(&x)
    }

    #[test]
    fn the_frequency_is_estimated_from_sines_and_from_staircases() {
        for hz in [5.0, 12.5, 20.0, 40.0] {
            assert_close(&[estimated(hz, None)], &[hz], 0.03, 0.0);
            assert_close(&[estimated(hz, Some(3.0))], &[hz], 0.15, 0.0);
        }
    }

    #[test]
    fn between_two_frequencies_the_loop_width_is_linear_in_the_logarithm() {
        let block = block();
        let width = |hz| block.interpolate(hz, |branches| branches.descending(0.0) - branches.ascending(0.0));
        assert_close(&[1.0, 5.0, 20.0, 80.0, 300.0].map(width), &[2.0, 2.0, 4.0, 6.0, 6.0], 1e-12, 0.0);
    }

    #[test]
    fn the_program_is_bit_identical_for_several_pairs_and_both_rules() {
        let u: Vec<f64> =
            (0..4000).map(|t| 28.0 * (2e-6 * f64::from(t * t)).sin()).map(|u| (4.0 * u).round() / 4.0).collect();
        for reading in [HeldInput::Held, HeldInput::Printed] {
            for pairs in [vec![pair(5.0, 1.0), pair(20.0, 2.5), pair(80.0, 3.0)], vec![pair(20.0, 2.0)]] {
                check_program(&RateScheduled::new(5e-4, pairs, reading).unwrap(), &u);
            }
        }
    }

    #[test]
    fn two_pairs_at_one_frequency_are_an_error() {
        assert!(RateScheduled::new(5e-4, vec![pair(5.0, 1.0), pair(5.0, 1.0)], HeldInput::Held).is_err());
        assert!(RateScheduled::new(5e-4, vec![], HeldInput::Held).is_err());
    }

    #[test]
    fn a_dip_of_a_fiftieth_of_the_range_is_no_reversal() {
        let branch = || (vec![-20.0, 0.0, 30.0], vec![-20.0, 0.0, 30.0]);
        let pairs = vec![Pair { frequency_hz: 5.0, branches: Branches::new(branch(), branch()).unwrap() }];
        let block = RateScheduled::new(5e-4, pairs, HeldInput::Held).unwrap();
        let trend = |u: [f64; 2]| {
            let mut x = block.initial();
            block.resume(&mut x, &u);
            x[2]
        };
        assert_eq!([[10.0, 9.0], [10.0, 8.999], [-10.0, -9.0], [-10.0, -8.999]].map(trend), [1.0, -1.0, -1.0, 1.0]);
    }
}
