//! Prandtl-Ishlinskii: a sum of play (backlash) operators.
//!
//! ```text
//! p_k <- max(u - r_k, min(u + r_k, p_k))        play of threshold r_k
//! z = w_0 u + w_1 p_1 + ... + w_n p_n           w_k >= 0
//! ```
//! Loops are symmetric; minor loops over the same input range are congruent; passed reversals are wiped out.
//!
//! Reference: M. Brokate & J. Sprekels, "Hysteresis and Phase Transitions", Springer (1996), DOI
//! 10.1007/978-1-4612-4048-8; for piezo actuators P. Krejci & K. Kuhnen, IEE Proc. Control Theory Appl. 148 (2001), DOI
//! 10.1049/ip-cta:20010375. It does not do: asymmetric loops, saturation, rate.
//!
//! Inverse: exact. Away from the last input z(u) is piecewise linear, and the plays start to move one after another:
//! ```text
//! rising at u = p_k + r_k, falling at u = p_k - r_k;    dz/du = w_0 + w_1 + ... + w_k behind it
//! ```
//! The order is that of k because |p_{k+1} - p_k| <= r_{k+1} - r_k in every state reached from rest. In other states,
//! and with negative weights, Newton's method finds the right piece.
//!
//! Why: docs/decisions/compensation.md, "Operators are inverted by Newton's method on the law".

use super::inverse::Inverted;
use super::law::{Input, Law, Weighted};
use super::real::{Dual, Real};
use super::thresholds;
use super::{Class, Operator};
use crate::program::Block;
use multiversion::multiversion;
use serde::{Deserialize, Serialize};

/// Thresholds r_1 < r_2 < ... [input unit]. Weights: w_0 of the input, then one per threshold.
///
/// State: the plays p_k.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Play {
    thresholds: Vec<f64>,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "prandtl-ishlinskii",
    aliases: &["PI", "play"],
    summary: "a sum of play operators: symmetric loops, minor loops, a closed-form inverse",
    reference: "Krejci & Kuhnen 2001, doi:10.1049/ip-cta:20010375",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: true,
    class: Class::Plays,
    load: Weighted::<Play>::load,
    basis: |design| Weighted::basis(design.ts, design.range, Play { thresholds: thresholds::even(design) }),
    example: |ts| Weighted::example(ts, Play { thresholds: thresholds::example() }, thresholds::example_weights(0.7)),
};

impl Law for Play {
    const ROW: &'static Operator = &OPERATOR;
    const RESPONSE: &'static str = "x.play[k]";

    fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    fn step<R: Real>(&self, _: &[R], x: &mut [R], Input { u, .. }: Input<R>, mut phi: impl FnMut(usize, R)) {
        phi(0, u);
        for (k, (p, &r)) in x.iter_mut().zip(&self.thresholds).enumerate() {
            *p = p.clamp(u - r.into(), u + r.into());
            phi(k + 1, *p);
        }
    }

    fn run(&self, weights: &[f64], _: &[f64], x: &mut [f64], _: Input, signal: &mut [f64]) {
        sum_of_plays(weights, &self.thresholds, x, signal);
    }

    fn ahead(&self, weights: &[f64], _: &[f64], plays: &[f64], _: &mut [Dual], Input { u, .. }: Input<Dual>) -> Dual {
        let (value, slope) = sum_ahead(weights, &self.thresholds, plays, u.value);
        Dual { value, slope: u.slope * slope }
    }

    fn closed(&self, weights: &[f64], plays: &[f64], last: f64, z: f64, ends: (f64, f64)) -> Option<Inverted> {
        let u = outwards(weights, &self.thresholds, plays, last, z, ends)?;
        Some(Inverted { u, z: sum_ahead(weights, &self.thresholds, plays, u).0 })
    }

    fn block(&self, block: Block, _: Input) -> Block {
        let n = self.thresholds.len();
        let rises = !block.constants.iter().any(|c| c.name == "w" && negative(&c.values));
        let block = block.numbers("play", vec![0.0; n]).table("r", &self.thresholds);
        let sum = if n <= WRITTEN { written_sum(n) } else { SUM.into() };
        block.count("n", n).count("lanes", LANES).text(&sum).text(STEP).text(if rises { CLOSED } else { "" })
    }
}

/// [`standing`] for many plays.
const SUM: &str = "
// z at u for the plays as they stand.
fn weighted_sum(x: hysteresis, u) {
    // Eight partial sums, added in pairs: the same order of additions everywhere.
    let sums = [0.0; lanes];
    for k in 0..n { sums[k % lanes] += w[k + 1] * x.play[k]; }
    let even = (sums[0] + sums[4]) + (sums[2] + sums[6]);
    let odd = (sums[1] + sums[5]) + (sums[3] + sums[7]);
    return w[0] * u + (even + odd);
}
";

/// Maximum number of plays whose sum is written out. Written out, it takes half the time of a loop.
const WRITTEN: usize = 4 * LANES;

/// [`SUM`] of `n` plays, written out.
fn written_sum(n: usize) -> String {
    let lane = |lane: usize| {
        let terms: String = (lane..n).step_by(LANES).map(|k| format!(" + w[{}] * x.play[{k}]", k + 1)).collect();
        format!("    let sum_{lane} = 0.0{terms};\n")
    };
    let lanes: String = (0..LANES).map(lane).collect();
    format!(
        "
// z at u for the plays as they stand.
fn weighted_sum(x: hysteresis, u) {{
    // Summed in lanes, and these in pairs.
{lanes}    let even = (sum_0 + sum_4) + (sum_2 + sum_6);
    let odd = (sum_1 + sum_5) + (sum_3 + sum_7);
    return w[0] * u + (even + odd);
}}
"
    )
}

/// [`Law::step`], weighted.
const STEP: &str = "
// Takes the plays along to u.
fn hysteresis_move(x: hysteresis, u) {
    for k in 0..n { x.play[k] = clamp(x.play[k], u - r[k], u + r[k]); }
    x.last = u;
}

fn hysteresis(x: hysteresis, u) {
    hysteresis_move(x, u);
    return weighted_sum(x, u);
}
";

/// [`outwards`] for weights that are not negative.
const CLOSED: &str = "
// The input between low and high for which the next step returns z, and 1. From the last input on, z is piecewise linear: the plays start to move one after another. The second value is 0 if the state cannot result from any input, because then the plays move in another order.
fn hysteresis_closed(x: hysteresis, z, low, high) {
    let closed = 1.0;
    if x.last < low || x.last > high { closed = 0.0; }
    let slack = 8.0 * epsilon * (magnitude(x.last) + r[n - 1]);
    let here = weighted_sum(x, x.last);
    let toward = -1.0;
    let limit = -low;
    if here < z {
        toward = 1.0;
        limit = high;
    }
    let left = magnitude(z - here);
    // On a flat piece rounding is no distance.
    if w[0] == 0.0 && left < 4.0 * epsilon * magnitude(z) { left = 0.0; }
    // If the input has to fall, all signs are reversed.
    let v = toward * x.last;
    let behind = v + slack;
    let slope = w[0];
    for k in 0..n {
        let p = toward * x.play[k];
        let contact = p + r[k];
        let gap = contact - v;
        if gap < -slack || p - r[k] > behind { closed = 0.0; }
        if left > slope * gap {
            if gap > 0.0 {
                left -= slope * gap;
                v = contact;
            }
            slope += w[k + 1];
        } else if left > 0.0 {
            v += left / slope;
            left = 0.0;
        }
    }
    if left > 0.0 {
        if slope > 0.0 { v += left / slope; } else { v = limit; }
    }
    if v > limit { v = limit; }
    return toward * v, closed;
}
";

/// Plays in one vector. The sums are added in the same order for every vector width of the processor.
const LANES: usize = 8;

/// Samples that one group of [`LANES`] plays processes before the next group.
const STRETCH: usize = 64;

type Lanes = [f64; LANES];

/// Replaces u by z. The result is bit-identical for any division of the signal.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn sum_of_plays(weights: &[f64], thresholds: &[f64], plays: &mut [f64], signal: &mut [f64]) {
    if signal.len() < STRETCH / 2 {
        stretches::<1>(weights, thresholds, plays, signal);
    } else {
        stretches::<STRETCH>(weights, thresholds, plays, signal);
    }
}

#[inline(always)] // compiled for the instruction set of the caller
fn stretches<const N: usize>(weights: &[f64], thresholds: &[f64], plays: &mut [f64], signal: &mut [f64]) {
    let [w0, weights @ ..] = weights else { return };
    let (w, w_rest) = weights.as_chunks();
    let (r, r_rest) = thresholds.as_chunks();
    let (p, p_rest) = plays.as_chunks_mut();
    // The last group is filled up with plays of weight 0.
    let (w_last, r_last, mut p_last) = (filled(w_rest), filled(r_rest), filled(p_rest));
    for stretch in signal.chunks_mut(N) {
        let mut sums = [[0.0; LANES]; N];
        for ((p, r), w) in p.iter_mut().zip(r).zip(w) {
            step_lanes(&mut sums, w, r, p, stretch);
        }
        if !p_rest.is_empty() {
            step_lanes(&mut sums, &w_last, &r_last, &mut p_last, stretch);
        }
        for (v, sums) in stretch.iter_mut().zip(sums) {
            *v = w0 * *v + total(sums);
        }
    }
    p_rest.copy_from_slice(&p_last[..p_rest.len()]);
}

#[inline(always)]
fn step_lanes(sums: &mut [Lanes], w: &Lanes, r: &Lanes, plays: &mut Lanes, u: &[f64]) {
    let mut p = *plays;
    for (sums, &u) in sums.iter_mut().zip(u) {
        for lane in 0..LANES {
            let (low, high) = (u - r[lane], u + r[lane]);
            let below = if p[lane] > high { high } else { p[lane] };
            p[lane] = if below < low { low } else { below };
            sums[lane] += w[lane] * p[lane];
        }
    }
    *plays = p;
}

/// z at `u`, bit-identical to a run, and its slope: the sum of the weights of the plays that move. The state does not
/// change.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn sum_ahead(weights: &[f64], thresholds: &[f64], plays: &[f64], u: f64) -> (f64, f64) {
    let [w0, weights @ ..] = weights else { return (0.0, 0.0) };
    let (w, w_rest) = weights.as_chunks();
    let (r, r_rest) = thresholds.as_chunks();
    let (p, p_rest) = plays.as_chunks();
    let (mut sums, mut slopes) = ([0.0; LANES], [0.0; LANES]);
    for ((p, r), w) in p.iter().zip(r).zip(w) {
        add_ahead(&mut sums, &mut slopes, w, r, p, u);
    }
    if !p_rest.is_empty() {
        add_ahead(&mut sums, &mut slopes, &filled(w_rest), &filled(r_rest), &filled(p_rest), u);
    }
    (w0 * u + total(sums), w0 + total(slopes))
}

#[inline(always)]
fn add_ahead(sums: &mut Lanes, slopes: &mut Lanes, w: &Lanes, r: &Lanes, p: &Lanes, u: f64) {
    for lane in 0..LANES {
        let (low, high) = (u - r[lane], u + r[lane]);
        let below = if p[lane] > high { high } else { p[lane] };
        let now = if below < low { low } else { below };
        sums[lane] += w[lane] * now;
        slopes[lane] += if now == p[lane] { 0.0 } else { w[lane] };
    }
}

#[inline(always)]
fn total([a, b, c, d, e, f, g, h]: Lanes) -> f64 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// The input between `ends` for which the next step gives `z`, piece by piece from the last input. `None` if a weight
/// is negative, because z may then decrease, and in states that no input leads to, where the plays move in another
/// order.
fn outwards(w: &[f64], r: &[f64], plays: &[f64], last: f64, z: f64, ends: (f64, f64)) -> Option<f64> {
    if last < ends.0 || last > ends.1 {
        return None;
    }
    let slack = SLACK * f64::EPSILON * (last.abs() + r[r.len() - 1]);
    let here = standing(w, plays, last);
    let (toward, limit) = if here < z { (1.0, ends.1) } else { (-1.0, -ends.0) };
    let mut left = (z - here).abs();
    // On a flat piece rounding errors count as 0.
    if w[0] == 0.0 && left < 4.0 * f64::EPSILON * z.abs() {
        left = 0.0;
    }
    // A decreasing input is mirrored.
    let mut v = toward * last;
    let behind = v + slack;
    let (mut slope, mut taken) = (w[0], 0);
    for ((p, r), w) in plays.iter().zip(r).zip(&w[1..]) {
        let contact = toward * p + r;
        let gap = contact - v;
        if gap < -slack {
            return None;
        }
        if left > slope * gap {
            if gap > 0.0 {
                left -= slope * gap;
                v = contact;
            }
            slope += w;
            taken += 1;
        } else {
            break;
        }
    }
    if left > 0.0 {
        v = if slope > 0.0 { v + left / slope } else { limit };
    }
    let invalid = negative(w)
        || out_of_reach(r, plays, toward, behind)
        || passed(&r[taken..], &plays[taken..], toward, (v, slack));
    (!invalid).then_some(toward * if v > limit { limit } else { v })
}

/// Rounding error of a contact, relative to the rounding of the inputs.
const SLACK: f64 = 8.0;

/// True if a weight is negative.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn negative(weights: &[f64]) -> bool {
    weights.iter().fold(false, |negative, w| negative | (*w < 0.0))
}

/// True if a play is further ahead of the input than its threshold.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn out_of_reach(thresholds: &[f64], plays: &[f64], toward: f64, behind: f64) -> bool {
    plays.iter().zip(thresholds).fold(false, |out, (p, r)| out | (toward * p - r > behind))
}

/// True if a play would have started to move before `v`.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn passed(thresholds: &[f64], plays: &[f64], toward: f64, (v, slack): (f64, f64)) -> bool {
    plays.iter().zip(thresholds).fold(false, |passed, (p, r)| passed | (toward * p + r - v < -slack))
}

/// z at `u` for the present plays, bit-identical to a run in which no play moves.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn standing(weights: &[f64], plays: &[f64], u: f64) -> f64 {
    let [w0, weights @ ..] = weights else { return 0.0 };
    let (w, w_rest) = weights.as_chunks::<LANES>();
    let (p, p_rest) = plays.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (p, w) in p.iter().zip(w) {
        (0..LANES).for_each(|lane| sums[lane] += w[lane] * p[lane]);
    }
    for (lane, (p, w)) in p_rest.iter().zip(w_rest).enumerate() {
        sums[lane] += w * p;
    }
    w0 * u + total(sums)
}

/// `rest`, filled up with zeros.
fn filled(rest: &[f64]) -> Lanes {
    let mut lanes = [0.0; LANES];
    lanes[..rest.len()].copy_from_slice(rest);
    lanes
}

#[cfg(test)]
mod tests {
    use super::super::inverse::by_slopes;
    use super::super::tests::check_program;
    use super::super::{Hysteresis, inverse};
    use super::*;

    use crate::program::{Machine, Program};
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;

    #[test]
    fn runs_equal_the_definition_and_are_bit_identical_to_steps() {
        for n in [1, 7, 8, 9, 30, 64] {
            let thresholds: Vec<f64> = (1..=n).map(|k| 0.4 * f64::from(k)).collect();
            let weights: Vec<f64> = (0..=n).map(|k| (1.3 * f64::from(k)).cos()).collect();
            let law = Play { thresholds: thresholds.clone() };
            let block = Weighted::new(1.0, (-30.0, 30.0), law, weights.clone()).unwrap();
            let u: Vec<f64> =
                (0..777).map(|t| 29.0 * (0.05 * f64::from(t)).sin() * (0.011 * f64::from(t)).cos()).collect();

            let whole = block.simulate(&u);
            let mut x = block.initial();
            let stepped: Vec<f64> = u.iter().map(|&u| block.step(&mut x, u)).collect();
            assert_eq!(stepped, whole);

            let mut plays = vec![0.0f64; thresholds.len()];
            let defined = u.iter().map(|&u| {
                plays.iter_mut().zip(&thresholds).for_each(|(p, r)| *p = (u - r).max((u + r).min(*p)));
                weights[0] * u + plays.iter().zip(&weights[1..]).map(|(p, w)| p * w).sum::<f64>()
            });
            assert_close(&whole, &defined.collect::<Vec<_>>(), 1e-12, 1e-12);
        }
    }

    /// `n` plays up to 20, some of weight 0.
    fn plays(n: u32, w0: f64) -> (Play, Vec<f64>, Weighted<Play>) {
        let law = Play { thresholds: (1..=n).map(|k| 20.0 * f64::from(k) / f64::from(n)).collect() };
        let weights: Vec<f64> =
            (0..=n).map(|k| if k == 0 { w0 } else { 0.3 * f64::from(k % 3) / f64::from(n) }).collect();
        (law.clone(), weights.clone(), Weighted::new(1.0, (-30.0, 30.0), law, weights).unwrap())
    }

    /// An input with reversals at many levels.
    fn wander(t: u32) -> f64 {
        17.0 * (0.31 * f64::from(t)).sin() + 12.0 * (0.0173 * f64::from(t)).sin()
    }

    #[test]
    fn the_closed_inverse_is_as_accurate_as_newtons_method() {
        for (n, w0) in [(1, 0.6), (8, 1e-3), (15, 0.5), (30, 0.1)] {
            let (law, weights, block) = plays(n, w0);
            let mut x = block.initial();
            let mut worst = [0.0f64; 2];
            for t in 0..4000 {
                let z = block.step(&mut x.clone(), wander(t));
                let closed = law.closed(&weights, &x[1..], x[0], z, (-30.0, 30.0)).unwrap();
                let ahead = |u| {
                    let (value, slope) = sum_ahead(&weights, &law.thresholds, &x[1..], u);
                    Dual { value, slope }
                };
                let newton = by_slopes(x[0], z, (-30.0, 30.0), ahead).unwrap();
                for (worst, found) in worst.iter_mut().zip([closed, newton]) {
                    *worst = worst.max((found.z - z).abs());
                }
                assert_close(&[closed.u], &[newton.u], 0.0, 1e-12 / w0);
                block.step(&mut x, wander(t));
            }
            assert!(worst[0] <= 2.0 * worst[1] + 1e-14, "{worst:?}");
        }
    }

    #[test]
    fn the_inverse_program_is_bit_identical_for_all_states_and_weights() {
        let falling = Play { thresholds: vec![2.0, 5.0, 9.0] };
        let falling = Weighted::new(1.0, (-30.0, 30.0), falling, vec![0.5, 0.3, -1.1, 0.9]).unwrap();
        for block in [plays(9, 0.4).2, plays(9, 0.0).2, falling] {
            let mut program = Program::new(vec![Block::elementary(), block.block().unwrap()]).unwrap();
            inverse(&mut program).unwrap();
            let mut machine = Machine::new(&program, "hysteresis", false);
            for t in 0..300 {
                // Half of the states are reached by an input.
                let mut x: Vec<f64> = (0..block.order() as u32).map(|k| wander(37 * k + t)).collect();
                if t % 2 == 0 {
                    block.step(&mut x, wander(7 * t));
                }
                machine.state().copy_from_slice(&x);
                for z in [wander(3 * t), 0.3 * wander(5 * t), block.step(&mut x.clone(), wander(t))] {
                    let found = machine.call("hysteresis_inverse", &[z, -25.0, 31.0]).unwrap()[0];
                    assert_eq!(found.to_bits(), block.invert(&x, z, (-25.0, 31.0)).u.to_bits(), "{block:?} at {t}");
                }
            }
        }
    }

    #[test]
    fn a_closed_inverse_needs_a_state_that_an_input_leads_to() {
        let (law, weights, e) = (Play { thresholds: vec![1.0, 2.0, 4.0] }, [0.5, 0.25, 0.125, 0.0625], f64::EPSILON);
        let all = (-30.0, 30.0);
        for way in [1.0, -1.0] {
            // z rises by `more`; all signs may be reversed.
            let closed = |w: [f64; 4], plays: [f64; 3], last: f64, more: f64, (low, high): (f64, f64)| {
                let (plays, ends) = (plays.map(|p| way * p), if way > 0.0 { (low, high) } else { (-high, -low) });
                let z = standing(&w, &plays, way * last) + way * more;
                law.closed(&w, &plays, way * last, z, ends).map(|found| way * found.u)
            };
            let touching = |w, ends| closed(w, [9.0, 8.0, 6.0], 10.0, 0.5, ends);
            for ends in [all, (10.0, 30.0)] {
                assert_close(&[touching(weights, ends).unwrap()], &[10.0 + 8.0 / 15.0], 1e-14, 0.0);
            }
            assert_eq!(touching(weights, (-30.0, 10.0)), Some(10.0));
            assert_eq!([(10.5, 30.0), (-30.0, 9.5)].map(|ends| touching(weights, ends)), [None; 2]);
            assert_eq!([0.125, -0.125].map(|w| touching([0.5, -0.25, w, 0.0625], all)), [None; 2]);
            // Two plays ahead of the input, and one; those that would have moved before another, two and one; behind.
            let states = [[9.0, 13.0, 15.0], [9.0, 8.0, 15.0], [11.0, 8.0, 6.0], [11.0, 8.0, 8.0], [8.0, 8.0, 6.0]];
            assert_eq!(states.map(|plays| closed(weights, plays, 10.0, 0.75, all)), [None; 5]);
            // Rounding is no difference.
            assert!(closed(weights, [1.0, 2.0, 4.0 + 8.0 * e], 0.0, 0.5, all).is_some());
            let beyond = |units: f64| closed(weights, [11.0, 12.0, 14.0 + units * e], 10.0, 0.5, all).is_some();
            assert_eq!([96.0, 200.0].map(beyond), [true, false]);
        }
    }

    #[test]
    fn a_difference_within_rounding_moves_no_play_where_z_is_flat() {
        let law = Play { thresholds: vec![3.0] };
        let from_10 = |w0: f64, p: f64, z: f64| law.closed(&[w0, 1.0], &[p], 10.0, z, (-30.0, 30.0)).unwrap().u;
        let e = f64::EPSILON;
        assert_eq!([8.0, 8.0 + 16.0 * e, 8.0 - 16.0 * e].map(|z| from_10(0.0, 8.0, z)), [10.0; 3]);
        // From four units in the last place on it is a difference.
        assert_close(&[from_10(0.0, 8.0, 8.0 + 40.0 * e), from_10(0.0, 8.0 - 32.0 * e, 8.0)], &[11.0; 2], 1e-13, 0.0);
        assert!(from_10(0.5, 8.0, 13.0 + 8.0 * e) > 10.0);
    }

    #[test]
    fn sums_of_few_plays_are_written_out_and_those_of_many_are_a_loop() {
        let u: Vec<f64> = (0..200).map(wander).collect();
        for (n, is_loop) in [(1, false), (32, false), (33, true), (40, true)] {
            let block = plays(n, 0.5).2;
            assert_eq!(block.block().unwrap().text.contains("sums[k % lanes]"), is_loop, "{n}");
            check_program(&block, &u);
        }
    }
}
