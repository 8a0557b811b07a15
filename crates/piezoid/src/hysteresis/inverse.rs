//! Back through an operator: the input that its next step answers with a wanted z.
//!
//! ```text
//! u:  step(x, u) = z        from the state x, which stays as it is
//! ```
//! Where the operator rises with its input there is one such u at most. Operators with a formula for it have their own;
//! the others are tried on copies of the state, between the two ends that are allowed, by bisection and inverse quadratic
//! interpolation, until the ends meet. Beyond what the ends give, the nearer end is all there is, and [`Inverted::z`] says
//! what it reaches.
//!
//! Reference: T. R. Chandrupatla, Adv. Eng. Softw. 28, 145 (1997), DOI 10.1016/S0965-9978(96)00051-8. It does not do: an
//! operator that falls somewhere, of which it finds one input of several ([`falls`] tells).

use super::Hysteresis;
use crate::series::ends;

/// Trials at most: twice what halving down to neighbouring floats takes.
const TRIALS: usize = 120;

/// Inputs of each way through which an operator is watched.
const WATCHED: usize = 400;

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inverted {
    /// The input [input unit].
    pub u: f64,
    /// What it reaches: the wanted z, or at an end of the allowed inputs what there is [z's unit].
    pub z: f64,
}

/// Numbers of a state whose copy needs no allocation.
const SMALL: usize = 256;

/// The input between `ends` that the next step answers with `z`, by trials.
pub(super) fn by_trials<H: Hysteresis + ?Sized>(operator: &H, x: &[f64], z: f64, ends: (f64, f64)) -> Inverted {
    on_copy(x, |copy| {
        between(ends, z, |u| {
            copy.copy_from_slice(x);
            operator.step(copy, u)
        })
    })
}

/// What `run` makes of a copy of the state.
pub(crate) fn on_copy<T>(x: &[f64], run: impl FnOnce(&mut [f64]) -> T) -> T {
    let mut small = [0.0; SMALL];
    match small.get_mut(..x.len()) {
        Some(copy) => {
            copy.copy_from_slice(x);
            run(copy)
        }
        None => run(&mut x.to_vec()),
    }
}

/// The input between `ends` for which what is `reached` is `z`, by trials.
pub(crate) fn between(ends: (f64, f64), z: f64, mut reached: impl FnMut(f64) -> f64) -> Inverted {
    let (mut a, mut b) = (ends.0, ends.1);
    let (mut fa, mut fb) = (reached(a) - z, reached(b) - z);
    let (low, high) = if fa <= fb { ((a, fa), (b, fb)) } else { ((b, fb), (a, fa)) };
    if low.1 >= 0.0 || high.1 <= 0.0 {
        let u = if low.1 >= 0.0 { low.0 } else { high.0 };
        return Inverted { u, z: reached(u) };
    }
    // a is the newest, b across the root from it, c the one before.
    let mut share = 0.5;
    for _ in 0..TRIALS {
        let u = a + share * (b - a);
        let f = reached(u) - z;
        let (c, fc) = if (f < 0.0) == (fa < 0.0) {
            (a, fa)
        } else {
            let across = (b, fb);
            (b, fb) = (a, fa);
            across
        };
        (a, fa) = (u, f);
        let (nearest, off) = if fa.abs() < fb.abs() { (a, fa) } else { (b, fb) };
        let least = (f64::EPSILON * nearest.abs() + f64::MIN_POSITIVE) / (b - a).abs();
        if off == 0.0 || least > 0.25 {
            return Inverted { u: nearest, z: reached(nearest) };
        }
        // Inverse quadratic interpolation where it stays well inside, else halving.
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        share = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        share = share.clamp(least, 1.0 - least);
    }
    Inverted { u: a, z: reached(a) }
}

/// Whether `operator` rises with its input wherever a major loop between `low` and `high` and a smaller one within it lead;
/// else where it falls [input unit]. Without rising it has several inverses or none.
pub fn falls(operator: &dyn Hysteresis, low: f64, high: f64) -> Option<f64> {
    let leg = |from: f64, to: f64| (1..=WATCHED).map(move |t| from + (to - from) * t as f64 / WATCHED as f64);
    let (q, h) = (0.25 * (high - low), 0.5 * (high - low));
    let turns = [low, high, low, low + h + q, low + q, low + h, low + q];
    let path: Vec<f64> = turns.windows(2).flat_map(|w| leg(w[0], w[1])).collect();
    let z = operator.resume(&mut operator.settled(low), &path);
    let (bottom, top) = ends(z.iter().copied());
    let slack = 1e-9 * (top - bottom);
    let falls = |k: &usize| (z[*k] - z[k - 1]) * (path[*k] - path[k - 1]).signum() < -slack;
    (1..path.len()).find(falls).map(|k| path[k])
}

#[cfg(test)]
mod tests {
    use super::super::OPERATORS;
    use super::*;
    use crate::testing::assert_close;

    #[test]
    fn the_input_found_is_the_input_that_was_given() {
        for o in OPERATORS {
            let operator = (o.example)(5e-4).unwrap();
            let mut x = operator.settled(0.0);
            let mut given = Vec::new();
            let mut found = Vec::new();
            for t in 0..400 {
                let u = 18.0 * (f64::from(t) * 0.05).sin() + 11.0 * (f64::from(t) * 0.173).sin();
                let z = operator.step(&mut x.clone(), u);
                let back = operator.invert(&x, z, (-30.0, 30.0));
                // Between branches that jump there is more than one input; what they reach is the same.
                assert_close(&[back.z, operator.step(&mut x.clone(), back.u)], &[z, back.z], 1e-9, 1e-9);
                given.push(u);
                found.push(back.u);
                operator.step(&mut x, u);
            }
            if falls(&*operator, -30.0, 30.0).is_none() && o.minor_loops {
                assert_close(&found, &given, 1e-7, 1e-7);
            }
        }
    }

    #[test]
    fn what_cannot_be_reached_ends_at_the_nearer_end_and_says_what_there_is() {
        for o in OPERATORS {
            let operator = (o.example)(5e-4).unwrap();
            let x = operator.settled(3.0);
            let [top, bottom] = [1e6, -1e6].map(|z| operator.invert(&x, z, (-20.0, 25.0)));
            assert!(top.u == 25.0 && bottom.u == -20.0, "{}: {top:?} {bottom:?}", o.name);
            assert_eq!(top.z, operator.step(&mut x.clone(), 25.0), "{}", o.name);
        }
    }
}
