//! Jiles & Atherton's model: an anhysteretic curve, and an irreversible part that follows it with friction.
//!
//! ```text
//! A(v) = coth(v / a) - a / v,    g = sign(u') (A(u + alpha h) - h)          Langevin's function
//! h' = |u'| sign(u') max(g, 0) / (k max(1 - coupling g, 1/4)),    alpha = coupling k
//! z = w_0 u + w_1 S A(u + alpha h) + w_2 S h                                S half the input range, w_k >= 0
//! ```
//! `a` is the width of the anhysteretic curve, `k` the path of the input over which h follows it, and alpha the field
//! that h adds to the input. In the literature w_1 = c M_s / S and w_2 = (1 - c) M_s / S; w_0 is added, because a piezo
//! actuator also moves where no domain turns. Only h acts back on the input here, not all of z, so that z is linear in
//! its weights. The first limit of h' is the usual one: h never moves against the input. The second keeps h' finite.
//!
//! The integration rule is part of the definition. A path is divided into equal steps of at most an eighth of a and of
//! k, at most 256 of them, by the fourth-order method of Runge and Kutta; before the last 32 k a path has no effect.
//!
//! Reference: D. C. Jiles & D. L. Atherton, J. Magn. Magn. Mater. 61 (1986), DOI 10.1016/0304-8853(86)90066-1; for
//! piezo ceramics R. C. Smith & Z. Ounaies, Mater. Res. Soc. Symp. Proc. (2000), "A model for asymmetric hysteresis in
//! piezoceramic materials".
//! It does not do: rate, wiping out; minor loops start without a jump but do not close.
//!
//! Inverse: Newton's method through all steps of a path, at a few times the cost of one step.

use super::basis::ShapeParameter;
use super::law::{Input, Law, Weighted, require};
use super::real::Real;
use super::{Class, Operator};
use crate::program::Block;
use piezoid_numerics::error::{Error, positive};
use serde::{Deserialize, Serialize};

/// Weights: w_0, w_1, w_2.
///
/// State: h [-], from -1 to 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct JilesAtherton {
    /// [input unit]
    a: f64,
    /// [input unit]
    k: f64,
    coupling: f64,
}

/// Steps per a and per k, the most of them per sample, and the path before which nothing is remembered, in k.
const STEPS: f64 = 8.0;
const MAX_STEPS_PER_SAMPLE: f64 = 256.0;
const MEMORY: f64 = 32.0;

/// Least value of 1 - coupling g.
const LEAST: f64 = 0.25;

pub(super) static OPERATOR: Operator = Operator {
    name: "jiles-atherton",
    aliases: &["JA"],
    summary: "Langevin's curve, followed with friction: smooth loops that saturate",
    reference: "Jiles & Atherton 1986, doi:10.1016/0304-8853(86)90066-1",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: false,
    class: Class::Equations,
    load: Weighted::<JilesAtherton>::load,
    basis: |design| {
        let half = design.half();
        Weighted::basis(design.ts, design.range, JilesAtherton { a: half, k: 0.5 * half, coupling: 0.1 })
    },
    example: |ts| Weighted::example(ts, JilesAtherton { a: 12.0, k: 9.0, coupling: 0.4 }, vec![0.7, 0.1, 0.4]),
};

/// Langevin's function coth v - 1 / v; for small v by its continued fraction.
fn langevin<R: Real>(v: R) -> R {
    let one = R::from(1.0);
    let size = if v.value() < 0.0 { -v } else { v };
    if size.value() > 1.0 {
        let e = (R::from(-2.0) * size).exp();
        let bend = (one + e) / (one - e) - one / size;
        return if v.value() < 0.0 { -bend } else { bend };
    }
    let mut below = R::from(17.0);
    for odd in [15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        below = R::from(odd) + v * v / below;
    }
    v / below
}

/// |dh/du| at h and u, for a movement in direction `way`.
fn speed<R: Real>([a, k, coupling]: [R; 3], h: R, u: R, way: R) -> R {
    let g = way * (langevin((u + coupling * k * h) / a) - h);
    if g.value() <= 0.0 {
        return 0.0.into();
    }
    let less = R::from(1.0) - coupling * g;
    g / (k * if less.value() < LEAST { LEAST.into() } else { less })
}

/// [`speed`], [`langevin`] and [`Law::step`], weighted.
const STEP: &str = "
// Langevin's function coth v - 1 / v; for small v by its continued fraction.
fn langevin(v) {
    let size = magnitude(v);
    let bend = 0.0;
    if size > 1.0 {
        let e = exponential(-2.0 * size);
        bend = (1.0 + e) / (1.0 - e) - 1.0 / size;
        if v < 0.0 { bend = -bend; }
    } else {
        let square = v * v;
        let below = 3.0 + square / (5.0 + square / (7.0 + square / (9.0 + square / (11.0 + square / (13.0
            + square / (15.0 + square / 17.0))))));
        bend = v / below;
    }
    return bend;
}

// The change of h over a short movement of the input, at h and u.
fn speed(h, u, points) {
    let g = points * (langevin((u + alpha * h) / a) - h);
    let change = 0.0;
    if g <= 0.0 {
        change = 0.0;
    } else {
        let less = 1.0 - coupling * g;
        if less < least { less = least; }
        change = g / (k * less);
    }
    return change;
}

fn hysteresis(x: hysteresis, u) {
    let path = u - x.last;
    let points = way(path);
    if points != 0.0 {
        let length = path * points;
        if length > memory { length = memory; }
        // Steps of at most a share of a and k, and not more of them than there may be.
        let needed = length / longest;
        let steps = 1;
        if needed > real(most_steps) {
            steps = most_steps;
        } else if needed > 1.0 {
            steps = whole(needed);
            if real(steps) < needed { steps += 1; }
        }
        let s = points * (length / real(steps));
        let brief = 0.5 * s;
        let third = s / 6.0;
        let from = u - points * length;
        for i in 0..steps at most most_steps {
            let start = from + s * real(i);
            let first = speed(x.h, start, points);
            let second = speed(x.h + brief * first, start + brief, points);
            let other = speed(x.h + brief * second, start + brief, points);
            let last = speed(x.h + s * other, start + s, points);
            x.h = clamp(x.h + third * (first + 2.0 * (second + other) + last), -1.0, 1.0);
        }
    }
    x.last = u;
    return w[0] * u + w[1] * (half * langevin((u + alpha * x.h) / a)) + w[2] * (half * x.h);
}
";

impl Law for JilesAtherton {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        positive("a", self.a, "input unit")?;
        positive("k", self.k, "input unit")?;
        require((0.0..1.0).contains(&self.coupling), "coupling", self.coupling, "must be at least 0 and below 1")
    }

    fn responses(&self) -> usize {
        3
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let shape = [shape[0], shape[1], shape[2]];
        let [a, k, coupling] = shape;
        let way = input.direction();
        if way != 0.0 {
            let memory = R::from(MEMORY) * k;
            let length = if input.length() > memory { memory } else { input.length() };
            let longest = self.longest();
            let steps = (length.value() / longest).ceil().clamp(1.0, MAX_STEPS_PER_SAMPLE);
            let way = R::from(way);
            let (s, from) = (way * (length / steps.into()), input.u - way * length);
            let (brief, third) = (R::from(0.5) * s, s / 6.0.into());
            for i in 0..steps as usize {
                let start = from + s * R::from(i as f64);
                let first = speed(shape, x[0], start, way);
                let second = speed(shape, x[0] + brief * first, start + brief, way);
                let other = speed(shape, x[0] + brief * second, start + brief, way);
                let last = speed(shape, x[0] + s * other, start + s, way);
                let h = x[0] + third * (first + R::from(2.0) * (second + other) + last);
                x[0] = h.clamp((-1.0).into(), 1.0.into());
            }
        }
        let half = R::from(input.half());
        phi(0, input.u);
        phi(1, half * langevin((input.u + coupling * k * x[0]) / a));
        phi(2, half * x[0]);
    }

    fn block(&self, block: Block, input: Input) -> Block {
        let block = block.number("h", 0.0).constant("alpha", self.coupling * self.k).constant("half", input.half());
        let block = block.constant("memory", MEMORY * self.k).constant("longest", self.longest());
        block.constant("least", LEAST).count("most_steps", MAX_STEPS_PER_SAMPLE as usize).text(STEP)
    }

    /// The weights are those of curves, not of thresholds.
    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        Vec::new()
    }

    fn shape(&self, half: f64, _: f64) -> Vec<ShapeParameter> {
        vec![
            ShapeParameter { name: "a", value: self.a, low: 0.05 * half, high: 20.0 * half },
            ShapeParameter { name: "k", value: self.k, low: 0.02 * half, high: 20.0 * half },
            ShapeParameter { name: "coupling", value: self.coupling, low: 0.0, high: 0.9 },
        ]
    }
}

impl JilesAtherton {
    /// The longest step [input unit].
    fn longest(&self) -> f64 {
        self.a.min(self.k) / STEPS
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::path;
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;

    fn run(law: JilesAtherton, weights: [f64; 3], u: &[f64]) -> Vec<f64> {
        Weighted::new(1.0, (-30.0, 30.0), law, weights.to_vec()).unwrap().simulate(u)
    }

    #[test]
    fn langevins_function_is_continuous_and_odd_with_its_known_values() {
        // mpmath: coth(v) - 1 / v.
        let known = [(1e-3, 3.333333111111132e-4), (0.5, 0.1639534137386528), (1.0, 0.3130352854993313), (20.0, 0.95)];
        for (v, value) in known {
            assert_close(&[langevin(v), langevin(-v)], &[value, -value], 1e-14, 0.0);
        }
        assert_close(&[langevin(1.0 + 1e-15)], &[langevin(1.0)], 5e-15, 0.0);
        assert_eq!((langevin(0.0), langevin(1e300), langevin(f64::INFINITY)), (0.0, 1.0, 1.0));
    }

    #[test]
    fn without_coupling_it_approaches_the_anhysteretic_curve_exponentially() {
        // h' = (A(u) - h) / k with A linear for small u: h = (u - k + k e^(-u/k)) / (3 a).
        let law = JilesAtherton { a: 1000.0, k: 4.0, coupling: 0.0 };
        let u = path(&[0.0, 20.0], 400);
        let h: Vec<f64> = u.iter().map(|u| 30.0 * (u - 4.0 + 4.0 * (-u / 4.0f64).exp()) / 3000.0).collect();
        assert_close(&run(law, [0.0, 0.0, 1.0], &u), &h, 1e-4, 1e-7);
    }

    #[test]
    fn the_division_of_a_path_into_samples_has_little_effect() {
        let last = |pieces: u32| {
            let law = JilesAtherton { a: 12.0, k: 9.0, coupling: 0.6 };
            *run(law, [0.0, 0.3, 1.0], &path(&[0.0, 30.0, -20.0, 5.0, -30.0], pieces)).last().unwrap()
        };
        assert_close(&[last(1), last(7)], &[last(1000); 2], 1e-4, 0.0);
    }

    #[test]
    fn an_input_that_rises_for_long_forgets_what_was_before() {
        let law = || JilesAtherton { a: 12.0, k: 9.0, coupling: 0.4 };
        let last = |turns: &[f64]| *run(law(), [0.0, 0.0, 1.0], &path(turns, 1)).last().unwrap();
        assert_close(&[last(&[0.0, -30.0, 1e4])], &[last(&[0.0, 25.0, 1e4])], 1e-12, 0.0);
        assert!(last(&[0.0, 1e4]) > 0.99 * 30.0);
    }

    #[test]
    fn a_sample_takes_steps_of_at_most_an_eighth_of_a_and_of_k() {
        for (a, k) in [(16.0, 24.0), (24.0, 16.0)] {
            let last = |u: &[f64]| *run(JilesAtherton { a, k, coupling: 0.4 }, [0.0, 0.0, 1.0], u).last().unwrap();
            // 9 are five steps of at most 2.
            assert_close(&[last(&[9.0])], &[last(&[1.8, 3.6, 5.4, 7.2, 9.0])], 1e-13, 0.0);
        }
    }
}
