//! Back through an operator: the input that its next step answers with a wanted z.
//!
//! ```text
//! u:  step(x, u) = z        from the state x, which stays as it is
//! ```
//! Where the operator rises with its input there is one such u at most. By slopes it is found from the last input
//! outwards, by Newton's method on the law itself: plays make z of lines, between which the method ends exactly after a few
//! of them, and on curves it doubles the digits; a law may have a formula of its own. Where z falls or jumps, copies of the
//! state are tried between the two ends that are allowed, by bisection and inverse quadratic interpolation, until the ends
//! meet. Beyond what the ends give, the nearer end is all there is, and [`Inverted::z`] says what it reaches. [`inverse`] is
//! the same for programs.
//!
//! References: P. Krejci & K. Kuhnen, IEE Proc. Control Theory Appl. 148 (2001), DOI 10.1049/ip-cta:20010375 (sums of plays
//! that rise have an inverse); T. R. Chandrupatla, Adv. Eng. Softw. 28, 145 (1997), DOI 10.1016/S0965-9978(96)00051-8
//! (trials). It does not do: operators that fall somewhere ([`falling_input`] tells), of which it finds one input of several, and none
//! where what both ends reach lies on the same side of z.

mod program;

pub(crate) use program::{inverse, inverse_behind_a_driver};

use super::Hysteresis;
use super::real::Dual;
use crate::series::ends;

/// Trials at most: twice what halving down to neighbouring floats takes.
const TRIALS: usize = 120;

/// What rounding may leave, in units of that of z; more is a jump.
const JUMP: f64 = 1e4;

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

/// Numbers for which room needs no allocation.
const SMALL: usize = 256;

/// The input between `ends` that the next step answers with `z`, by trials.
pub(super) fn by_trials<H: Hysteresis + ?Sized>(operator: &H, x: &[f64], z: f64, ends: (f64, f64)) -> Inverted {
    with_scratch(x.len(), |copy| {
        between(ends, z, |u| {
            copy.copy_from_slice(x);
            operator.step(copy, u)
        })
    })
}

/// What `run` does with room for `n` numbers.
pub(crate) fn with_scratch<R: Copy + From<f64>, T>(n: usize, run: impl FnOnce(&mut [R]) -> T) -> T {
    let mut small = [R::from(0.0); SMALL];
    match small.get_mut(..n) {
        Some(room) => run(room),
        None => run(&mut vec![R::from(0.0); n]),
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

/// The input between `ends` that `ahead`, which gives z and its slope, answers with `z`, sought from `last` outwards: by
/// Newton's method, kept between what lies before the wanted z and what does not. Exact in a few steps where z is made of
/// lines; of a flat piece it is the input nearest to `last`. None where z is seen to fall, or to jump past what is wanted.
pub(super) fn by_slopes(last: f64, z: f64, ends: (f64, f64), mut ahead: impl FnMut(f64) -> Dual) -> Option<Inverted> {
    let close = 2.0 * f64::EPSILON * ends.0.abs().max(ends.1.abs());
    let start = last.max(ends.0).min(ends.1);
    let mut at = (start, ahead(start));
    let way = if at.1.value < z { 1.0 } else { -1.0 };
    let same = 4.0 * f64::EPSILON * at.1.value.abs().max(z.abs()).min(f64::MAX);
    // How far z still has to go; on a flat piece rounding is no distance.
    let left = |d: Dual| {
        let off = way * (z - d.value);
        if d.slope == 0.0 && off.abs() <= same { 0.0 } else { off }
    };
    if left(at.1) == 0.0 {
        return Some(found(at));
    }
    let (mut near, mut far) = (at, None);
    let end = if way > 0.0 { ends.1 } else { ends.0 };
    let mut before = f64::INFINITY;
    for _ in 0..TRIALS {
        let off = left(at.1);
        if at.1.slope < 0.0 || !off.is_finite() {
            return None;
        }
        if off > 0.0 {
            near = at;
        } else {
            far = Some(at);
        }
        // On a flat piece that has the wanted z the input before it tells where it begins.
        let from = if off == 0.0 && at.1.slope == 0.0 { near } else { at };
        let newton = from.0 + (z - from.1.value) / from.1.slope;
        let beyond = far.map_or(end, |far| far.0);
        if (newton - at.0).abs() <= close || (beyond - near.0).abs() <= close {
            let nearer = |far: &(f64, Dual)| left(far.1).abs() <= left(near.1);
            let best = far.filter(nearer).unwrap_or(near);
            return (left(best.1).abs() <= JUMP * same).then(|| found(best));
        }
        let inside = (newton - near.0) * way > 0.0 && (beyond - newton) * way > 0.0;
        let u = if inside && off.abs() <= 0.5 * before {
            before = off.abs();
            newton
        } else {
            before = f64::INFINITY;
            if far.is_none() { end } else { 0.5 * (near.0 + beyond) }
        };
        at = (u, ahead(u));
        if far.is_none() && u == end && left(at.1) > 0.0 && at.1.slope >= 0.0 {
            return Some(found(at));
        }
    }
    None
}

fn found((u, d): (f64, Dual)) -> Inverted {
    Inverted { u, z: d.value }
}

impl dyn Hysteresis + '_ {
    /// Whether this rises with its input wherever a major loop between `low` and `high` and a smaller one within it lead;
    /// else where it falls [input unit]. Without rising it has several inverses or none.
    pub fn falling_input(&self, low: f64, high: f64) -> Option<f64> {
        let leg = |from: f64, to: f64| (1..=WATCHED).map(move |t| from + (to - from) * t as f64 / WATCHED as f64);
        let (q, h) = (0.25 * (high - low), 0.5 * (high - low));
        let turns = [low, high, low, low + h + q, low + q, low + h, low + q];
        let path: Vec<f64> = turns.windows(2).flat_map(|w| leg(w[0], w[1])).collect();
        let z = self.resume(&mut self.settled(low), &path);
        let (bottom, top) = ends(z.iter().copied());
        let slack = 1e-9 * (top - bottom);
        let falling_input = |k: &usize| (z[*k] - z[k - 1]) * (path[*k] - path[k - 1]).signum() < -slack;
        (1..path.len()).find(falling_input).map(|k| path[k])
    }
}

#[cfg(test)]
mod tests {
    use super::super::{OPERATORS, Operator, load};
    use super::*;
    use crate::testing::assert_close;

    /// An input that never quite comes back to where it was.
    fn wander(t: u32) -> f64 {
        18.0 * (f64::from(t) * 0.05).sin() + 11.0 * (f64::from(t) * 0.173).sin()
    }

    #[test]
    fn the_input_found_is_the_input_that_was_given() {
        for o in OPERATORS {
            let operator = (o.example)(5e-4).unwrap();
            let mut x = operator.settled(0.0);
            let mut given = Vec::new();
            let mut found = Vec::new();
            for u in (0..400).map(wander) {
                let z = operator.step(&mut x.clone(), u);
                let back = operator.invert(&x, z, (-30.0, 30.0));
                // Between branches that jump there is more than one input; what they reach is the same.
                assert_close(&[back.z, operator.step(&mut x.clone(), back.u)], &[z, back.z], 1e-9, 1e-9);
                given.push(u);
                found.push(back.u);
                operator.step(&mut x, u);
            }
            if operator.falling_input(-30.0, 30.0).is_none() && o.minor_loops {
                assert_close(&found, &given, 1e-7, 1e-7);
            }
        }
    }

    #[test]
    fn slopes_find_what_trials_find_to_rounding_and_say_what_a_step_says_to_the_bit() {
        for o in OPERATORS {
            let operator = (o.example)(5e-4).unwrap();
            let rises = operator.falling_input(-30.0, 30.0).is_none() && o.minor_loops;
            let mut x = operator.settled(0.0);
            for t in 0..300 {
                let z = 0.9 * operator.step(&mut x.clone(), wander(t)) + 0.3;
                let (back, tried) =
                    (operator.invert(&x, z, (-25.0, 30.0)), by_trials(&*operator, &x, z, (-25.0, 30.0)));
                assert_eq!(operator.step(&mut x.clone(), back.u), back.z, "{} at {t}", o.name);
                assert!((back.z - z).abs() <= (tried.z - z).abs() + 1e-12, "{} at {t}: {back:?} {tried:?}", o.name);
                if rises {
                    assert_close(&[back.u], &[tried.u], 1e-11, 1e-11);
                }
                operator.step(&mut x, wander(t));
            }
        }
    }

    #[test]
    fn states_that_rest_never_leads_to_are_inverted_too() {
        let plays =
            ["prandtl-ishlinskii", "stop", "generalised-prandtl-ishlinskii", "rate-dependent-prandtl-ishlinskii"];
        for name in plays {
            let operator = (Operator::find(name).unwrap().example)(5e-4).unwrap();
            for t in 0..300 {
                let x: Vec<f64> = (0..9).map(|k| 1.4 * wander(37 * k + t)).collect();
                let z = wander(3 * t);
                let (back, tried) =
                    (operator.invert(&x, z, (-60.0, 60.0)), by_trials(&*operator, &x, z, (-60.0, 60.0)));
                assert_close(&[back.z, back.u], &[tried.z, tried.u], 1e-11, 1e-11);
            }
        }
    }

    #[test]
    fn where_many_inputs_do_the_one_nearest_to_the_last_is_taken() {
        let play = r#"{"operator": "prandtl-ishlinskii", "range": [-20, 20], "thresholds": [3], "weights": [0, 1]}"#;
        let play = load(&serde_json::from_str(play).unwrap(), 5e-4).unwrap();
        // The last input and the play, the wanted z; and the input: within the play's reach the last one.
        let cases = [
            (10.0, 7.0, 7.0, 10.0),
            (8.0, 7.0, 7.0, 8.0),
            (8.0, 7.0, 9.0, 12.0),
            (8.0, 7.0, 5.0, 2.0),
            (0.0, 7.0, 7.0, 4.0),
            (15.0, 7.0, 7.0, 10.0),
        ];
        for (last, p, z, u) in cases {
            let back = play.invert(&[last, p], z, (-20.0, 20.0));
            assert_close(&[back.u, back.z], &[u, z], 1e-14, 0.0);
        }
    }

    #[test]
    fn what_is_no_number_ends_within_the_ends() {
        for o in OPERATORS {
            let operator = (o.example)(5e-4).unwrap();
            let x = operator.settled(3.0);
            for (z, ends) in [(f64::NAN, (-20.0, 25.0)), (1.0, (4.0, 4.0)), (f64::NAN, (0.0, 0.0))] {
                let back = operator.invert(&x, z, ends);
                assert!(ends.0 <= back.u && back.u <= ends.1 && back.z.is_finite(), "{}: {back:?}", o.name);
            }
            for (z, u) in [(f64::INFINITY, 25.0), (f64::NEG_INFINITY, -20.0)] {
                assert_eq!(operator.invert(&x, z, (-20.0, 25.0)).u, u, "{}", o.name);
            }
        }
    }

    #[test]
    fn an_operator_that_falls_is_caught_where_it_does_and_one_of_its_inputs_is_found() {
        // What the stop of threshold 3 holds back outweighs the input for 6 after a reversal.
        let stop = r#"{"operator": "stop", "range": [-20, 20], "thresholds": [3], "weights": [1, 1.5]}"#;
        let stop = load(&serde_json::from_str(stop).unwrap(), 5e-4).unwrap();
        let at = stop.falling_input(-20.0, 20.0).unwrap();
        assert!((-20.0..-13.9).contains(&at), "{at}");
        let mut x = stop.settled(0.0);
        for t in 0..300 {
            let z = stop.step(&mut x.clone(), wander(t));
            let back = stop.invert(&x, z, (-60.0, 60.0));
            assert_close(&[back.z, stop.step(&mut x.clone(), back.u)], &[z, z], 1e-11, 1e-11);
            stop.step(&mut x, wander(t));
        }
        let falling = |o: &&&Operator| (o.example)(5e-4).unwrap().falling_input(-30.0, 30.0).is_some();
        let names: Vec<&str> = OPERATORS.iter().filter(falling).map(|o| o.name).collect();
        assert_eq!(names, ["two-branch", "rate-scheduled"], "these jump at a turn, the others rise");
    }

    #[test]
    fn what_cannot_be_reached_ends_at_the_nearer_end_and_says_what_there_is() {
        for o in OPERATORS {
            let operator = (o.example)(5e-4).unwrap();
            let x = operator.settled(3.0);
            let [top, bottom] = [1e6, -1e6].map(|z| operator.invert(&x, z, (-20.0, 25.0)));
            assert!(top.u == 25.0 && bottom.u == -20.0, "{}: {top:?} {bottom:?}", o.name);
            assert_eq!([top.z, bottom.z], [25.0, -20.0].map(|u| operator.step(&mut x.clone(), u)), "{}", o.name);
        }
    }
}
