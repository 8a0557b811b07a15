//! Prandtl-Ishlinskii: a sum of play (backlash) operators.
//!
//! ```text
//! p_k <- max(u - r_k, min(u + r_k, p_k))        play of threshold r_k
//! z = w_0 u + w_1 p_1 + ... + w_n p_n           w_k >= 0
//! ```
//! Loops are symmetric and those of equal inputs are congruent; reversals that are passed are wiped out.
//!
//! Reference: M. Brokate & J. Sprekels, "Hysteresis and Phase Transitions", Springer (1996), DOI
//! 10.1007/978-1-4612-4048-8; for piezo actuators P. Krejci & K. Kuhnen, IEE Proc. Control Theory Appl. 148 (2001), DOI
//! 10.1049/ip-cta:20010375. It does not do: asymmetric loops, saturation, rate.
//!
//! Inverse: exact. From a state z(u) is made of lines that rise, and Newton's method ends on the right one.

use super::Operator;
use super::basis::curvature;
use super::law::{Input, Law, Weighted};
use super::real::{Dual, Real};
use super::thresholds::{self, ELEMENTS};
use crate::error::Error;
use crate::program::Block;
use multiversion::multiversion;
use serde::{Deserialize, Serialize};

/// Thresholds r_1 < r_2 < ... [input unit]; the weights are w_0 of the input itself, then one each.
///
/// State: the plays p_k.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Play {
    thresholds: Vec<f64>,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "prandtl-ishlinskii",
    summary: "a sum of play operators: symmetric loops, minor loops, a closed inverse",
    reference: "Krejci & Kuhnen 2001, doi:10.1049/ip-cta:20010375",
    minor_loops: true,
    rate_independent: true,
    wipes_out: true,
    load: Weighted::<Play>::load,
    basis: |design| {
        let law = Play { thresholds: thresholds::even(design, ELEMENTS) };
        Weighted::basis(design.ts, design.range, law)
    },
    example: |ts| {
        let law = Play { thresholds: (1..=8).map(|k| 3.0 * f64::from(k)).collect() };
        let weights = (0..=8).map(|k| if k == 0 { 0.7 } else { 0.06 }).collect();
        Ok(std::sync::Arc::new(Weighted::new(ts, (-30.0, 30.0), law, weights)?))
    },
};

impl Law for Play {
    fn row() -> &'static Operator {
        &OPERATOR
    }

    fn check(&self) -> Result<(), Error> {
        thresholds::check(&self.thresholds)
    }

    fn responses(&self) -> usize {
        1 + self.thresholds.len()
    }

    fn order(&self) -> usize {
        self.thresholds.len()
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

    fn block(&self, block: Block, _: Input) -> Block {
        let n = self.thresholds.len();
        block.numbers("play", vec![0.0; n]).table("r", &self.thresholds).count("n", n).count("lanes", LANES).text(STEP)
    }

    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        curvature(1, self.responses())
    }
}

/// [`sum_of_plays`] for one input.
const STEP: &str = "
fn hysteresis(x: hysteresis, u) {
    x.last = u;
    // Summed in lanes, and these in pairs.
    let sums = [0.0; lanes];
    for lane in 0..lanes {
        let sum = 0.0;
        let k = lane;
        while k < n {
            x.play[k] = clamp(x.play[k], u - r[k], u + r[k]);
            sum += w[k + 1] * x.play[k];
            k += lanes;
        }
        sums[lane] = sum;
    }
    let even = (sums[0] + sums[4]) + (sums[2] + sums[6]);
    let odd = (sums[1] + sums[5]) + (sums[3] + sums[7]);
    return w[0] * u + (even + odd);
}
";

/// Plays side by side in the vector unit. Their sums are added up in one order, whatever its width.
const LANES: usize = 8;

/// Samples that a company of plays runs through before the next company does.
const STRETCH: usize = 64;

type Lanes = [f64; LANES];

/// Replaces u by z, the same to the bit however the signal is cut.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn sum_of_plays(weights: &[f64], thresholds: &[f64], plays: &mut [f64], signal: &mut [f64]) {
    if signal.len() < STRETCH / 2 {
        stretches::<1>(weights, thresholds, plays, signal);
    } else {
        stretches::<STRETCH>(weights, thresholds, plays, signal);
    }
}

#[inline(always)] // so that it is compiled for the instructions of the caller
fn stretches<const N: usize>(weights: &[f64], thresholds: &[f64], plays: &mut [f64], signal: &mut [f64]) {
    let [w0, weights @ ..] = weights else { return };
    let (w, w_rest) = weights.as_chunks();
    let (r, r_rest) = thresholds.as_chunks();
    let (p, p_rest) = plays.as_chunks_mut();
    // The last plays, if they are not as many as there are lanes, have companions of no weight.
    let (w_last, r_last, mut p_last) = (filled(w_rest), filled(r_rest), filled(p_rest));
    for stretch in signal.chunks_mut(N) {
        let mut sums = [[0.0; LANES]; N];
        for ((p, r), w) in p.iter_mut().zip(r).zip(w) {
            company(&mut sums, w, r, p, stretch);
        }
        if !p_rest.is_empty() {
            company(&mut sums, &w_last, &r_last, &mut p_last, stretch);
        }
        for (v, sums) in stretch.iter_mut().zip(sums) {
            *v = w0 * *v + added(sums);
        }
    }
    p_rest.copy_from_slice(&p_last[..p_rest.len()]);
}

#[inline(always)]
fn company(sums: &mut [Lanes], w: &Lanes, r: &Lanes, plays: &mut Lanes, u: &[f64]) {
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

/// z at `u`, to the bit that of a run, and its slope: the weight of the plays that move. The plays stay.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn sum_ahead(weights: &[f64], thresholds: &[f64], plays: &[f64], u: f64) -> (f64, f64) {
    let [w0, weights @ ..] = weights else { return (0.0, 0.0) };
    let (w, w_rest) = weights.as_chunks();
    let (r, r_rest) = thresholds.as_chunks();
    let (p, p_rest) = plays.as_chunks();
    let (mut sums, mut slopes) = ([0.0; LANES], [0.0; LANES]);
    for ((p, r), w) in p.iter().zip(r).zip(w) {
        look(&mut sums, &mut slopes, w, r, p, u);
    }
    if !p_rest.is_empty() {
        look(&mut sums, &mut slopes, &filled(w_rest), &filled(r_rest), &filled(p_rest), u);
    }
    (w0 * u + added(sums), w0 + added(slopes))
}

#[inline(always)]
fn look(sums: &mut Lanes, slopes: &mut Lanes, w: &Lanes, r: &Lanes, p: &Lanes, u: f64) {
    for lane in 0..LANES {
        let (low, high) = (u - r[lane], u + r[lane]);
        let below = if p[lane] > high { high } else { p[lane] };
        let now = if below < low { low } else { below };
        sums[lane] += w[lane] * now;
        slopes[lane] += if now == p[lane] { 0.0 } else { w[lane] };
    }
}

#[inline(always)]
fn added([a, b, c, d, e, f, g, h]: Lanes) -> f64 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// Lanes that begin with `rest`, and zeros.
fn filled(rest: &[f64]) -> Lanes {
    let mut lanes = [0.0; LANES];
    lanes[..rest.len()].copy_from_slice(rest);
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::System;
    use crate::testing::assert_close;

    #[test]
    fn runs_of_any_length_and_number_of_plays_are_the_definition_and_repeated_steps_to_the_bit() {
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
}
