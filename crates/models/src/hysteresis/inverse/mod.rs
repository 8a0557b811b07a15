//! Inverse of an operator: the input for which its next step gives a requested z.
//!
//! ```text
//! u:  step(x, u) = z        from the state x, which does not change
//! ```
//! If z increases with the input, there is at most one such u. Newton's method ([`by_slopes`]) finds it on the law
//! itself, starting from the last input. For plays z(u) is piecewise linear, and the method ends exactly after a few
//! pieces; on curves it converges quadratically. A law may have a closed form instead. Where z decreases or jumps,
//! [`between`] evaluates copies of the state between the two allowed ends, by bisection and inverse quadratic
//! interpolation, until the bracket closes. If z is out of reach, the result is the nearer end, and [`Inverted::z`] is
//! the z reached there. [`inverse`] does the same for programs.
//!
//! References: P. Krejci & K. Kuhnen, IEE Proc. Control Theory Appl. 148 (2001), DOI 10.1049/ip-cta:20010375
//! (increasing sums of plays have an inverse); T. R. Chandrupatla, Adv. Eng. Softw. 28, 145 (1997), DOI
//! 10.1016/S0965-9978(96)00051-8 (bracketing). It does not do: operators that decrease somewhere (`falling_input`
//! reports where). For these it finds one input of several, or none if z at both ends lies on the same side of the
//! requested z.
//!
//! Why: docs/decisions/compensation.md, "Operators are inverted by Newton's method on the law".

mod program;

pub(crate) use program::{inverse, inverse_behind_a_driver};

use super::Hysteresis;
use super::real::Dual;
use piezoid_numerics::series::ends;

/// Maximum number of evaluations: twice as many as bisection down to neighbouring floats needs.
const TRIALS: usize = 120;

/// Largest residual that is due to rounding, relative to the rounding of z; a larger one is a jump.
const JUMP: f64 = 1e4;

/// Samples per leg of the path on which `falling_input` checks an operator.
const WATCHED: usize = 400;

/// The result of an inversion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inverted {
    /// The input [input unit].
    pub u: f64,
    /// z at this input: the requested one, or the nearest at an end of the allowed inputs [unit of z].
    pub z: f64,
}

/// Largest scratch space on the stack.
const MAX_STACK_NUMBERS: usize = 256;

/// The input between `ends` for which the next step gives `z`, by bracketing.
pub(super) fn by_trials<H: Hysteresis + ?Sized>(operator: &H, x: &[f64], z: f64, ends: (f64, f64)) -> Inverted {
    with_scratch(x.len(), |copy| {
        between(ends, z, |u| {
            copy.copy_from_slice(x);
            operator.step(copy, u)
        })
    })
}

/// Calls `run` with scratch space for `n` numbers.
pub(crate) fn with_scratch<R: Copy + From<f64>, T>(n: usize, run: impl FnOnce(&mut [R]) -> T) -> T {
    let mut small = [R::from(0.0); MAX_STACK_NUMBERS];
    match small.get_mut(..n) {
        Some(room) => run(room),
        None => run(&mut vec![R::from(0.0); n]),
    }
}

/// The input between `ends` for which `reached` gives `z`, by bracketing.
pub(crate) fn between(ends: (f64, f64), z: f64, mut reached: impl FnMut(f64) -> f64) -> Inverted {
    let (mut a, mut b) = (ends.0, ends.1);
    let (mut fa, mut fb) = (reached(a) - z, reached(b) - z);
    let (low, high) = if fa <= fb { ((a, fa), (b, fb)) } else { ((b, fb), (a, fa)) };
    if low.1 >= 0.0 || high.1 <= 0.0 {
        let u = if low.1 >= 0.0 { low.0 } else { high.0 };
        return Inverted { u, z: reached(u) };
    }
    // a is the newest point, b on the other side of the root, c the previous point.
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
        // Inverse quadratic interpolation if it stays well inside the bracket, else bisection.
        let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
        share = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        // Also if these are not numbers.
        share = share.max(least).min(1.0 - least);
    }
    Inverted { u: a, z: reached(a) }
}

/// The input between `ends` for which `ahead` (z and its slope) gives `z`, by Newton's method from `last`, kept inside
/// a bracket. Exact after a few steps if z(u) is piecewise linear; on a flat piece the result is the input nearest to
/// `last`. `None` if z decreases or jumps past the requested value.
pub(super) fn by_slopes(last: f64, z: f64, ends: (f64, f64), mut ahead: impl FnMut(f64) -> Dual) -> Option<Inverted> {
    let close = 2.0 * f64::EPSILON * ends.0.abs().max(ends.1.abs());
    let start = last.max(ends.0).min(ends.1);
    let mut at = (start, ahead(start));
    let way = if at.1.value < z { 1.0 } else { -1.0 };
    let same = 4.0 * f64::EPSILON * at.1.value.abs().max(z.abs()).min(f64::MAX);
    // Remaining distance to z; on a flat piece rounding errors count as 0.
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
        // On a flat piece at the requested z, the input before it determines where the piece begins.
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
    /// The first input at which z decreases while the input increases, or the reverse [input unit]; `None` if there is
    /// none. Checked along a major loop between `low` and `high` and a minor loop in it. An operator that decreases
    /// somewhere has several inverses or none.
    pub fn falling_input(&self, low: f64, high: f64) -> Option<f64> {
        let leg = |from: f64, to: f64| (1..=WATCHED).map(move |t| from + (to - from) * t as f64 / WATCHED as f64);
        let (q, h) = (0.25 * (high - low), 0.5 * (high - low));
        let reversals = [low, high, low, low + h + q, low + q, low + h, low + q];
        let path: Vec<f64> = reversals.windows(2).flat_map(|w| leg(w[0], w[1])).collect();
        let z = self.resume(&mut self.settled(low), &path);
        let (bottom, top) = ends(z.iter().copied());
        let slack = 1e-9 * (top - bottom);
        let falls = |k: &usize| (z[*k] - z[k - 1]) * (path[*k] - path[k - 1]).signum() < -slack;
        (1..path.len()).find(falls).map(|k| path[k])
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::path;
    use super::super::{OPERATORS, Operator, load};
    use super::*;
    use crate::program::{Block, Machine, Program};
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;
    use serde_json::{Map, Value, json};
    use std::sync::Mutex;

    /// An input that is not periodic.
    fn wander(t: u32) -> f64 {
        18.0 * (f64::from(t) * 0.05).sin() + 11.0 * (f64::from(t) * 0.173).sin()
    }

    #[test]
    fn the_inverse_returns_the_input_of_the_step() {
        for o in OPERATORS {
            let operator = (o.example)(5e-4).unwrap();
            let mut x = operator.settled(0.0);
            let mut inputs = Vec::new();
            let mut found = Vec::new();
            for u in (0..400).map(wander) {
                let z = operator.step(&mut x.clone(), u);
                let back = operator.invert(&x, z, (-30.0, 30.0));
                // Between branches with jumps several inputs give the same z.
                assert_close(&[back.z, operator.step(&mut x.clone(), back.u)], &[z, back.z], 1e-9, 1e-9);
                inputs.push(u);
                found.push(back.u);
                operator.step(&mut x, u);
            }
            if operator.falling_input(-30.0, 30.0).is_none() && o.minor_loops {
                assert_close(&found, &inputs, 1e-7, 1e-7);
            }
        }
    }

    #[test]
    fn newtons_method_agrees_with_bracketing_and_its_z_is_bit_identical_to_a_step() {
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
    fn states_that_cannot_be_reached_from_rest_are_inverted_too() {
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
    fn of_several_inputs_the_nearest_to_the_last_one_is_returned() {
        let play = r#"{"operator": "prandtl-ishlinskii", "range": [-20, 20], "thresholds": [3], "weights": [0, 1]}"#;
        let play = load(&serde_json::from_str(play).unwrap(), 5e-4).unwrap();
        // Last input, play, requested z, and the input: the last one if the play need not move.
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
    fn a_requested_z_that_is_not_finite_gives_an_input_within_the_ends() {
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
    fn an_operator_that_decreases_is_detected_and_one_of_its_inputs_is_found() {
        // For 6 input units after a reversal the stop of threshold 3 changes z more than the input does.
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
        assert_eq!(names, ["two-branch", "rate-scheduled"], "these jump at a reversal, the others increase");
    }

    #[test]
    fn a_z_out_of_reach_gives_the_nearer_end_and_the_z_there() {
        for o in OPERATORS {
            let operator = (o.example)(5e-4).unwrap();
            let x = operator.settled(3.0);
            let [top, bottom] = [1e6, -1e6].map(|z| operator.invert(&x, z, (-20.0, 25.0)));
            assert!(top.u == 25.0 && bottom.u == -20.0, "{}: {top:?} {bottom:?}", o.name);
            assert_eq!([top.z, bottom.z], [25.0, -20.0].map(|u| operator.step(&mut x.clone(), u)), "{}", o.name);
        }
    }

    #[test]
    fn bracketing_takes_few_steps_and_ends_at_the_nearer_end() {
        let mut count = 0;
        let found = between((-3.0, 50.0), 2.0, |u| {
            count += 1;
            u.exp().min(1e6)
        });
        assert_close(&[found.u, found.z], &[2f64.ln(), 2.0], 1e-15, 0.0);
        assert!(count <= 24, "{count} steps");
        for (z, u) in [(-5.0, -3.0), (5.0, 4.0)] {
            assert_eq!(between((-3.0, 4.0), z, |u| u), Inverted { u, z: u });
            assert_eq!(between((4.0, -3.0), z, |u| u), Inverted { u, z: u });
            assert_eq!(between((-3.0, 4.0), -z, |u| -u), Inverted { u, z: -u });
        }
    }

    /// A program whose z is this curve of the input, with its slope. It adds up the inputs that it looks at, the last
    /// one most.
    fn curved(curve: &str) -> Program {
        let text = format!(
            "
fn curve(u) {{
    {curve}
}}

fn hysteresis(x: hysteresis, u) {{
    let z, slope = curve(u);
    x.last = u;
    return z;
}}

fn hysteresis_ahead(x: hysteresis, u) {{
    x.trace = 0.75 * x.trace + u;
    let z, slope = curve(u);
    return z, slope;
}}
"
        );
        let block = Block::new("hysteresis", "a curve").number("last", 0.0).number("trace", 0.0).text(&text);
        let mut program = Program::new(vec![Block::elementary(), block]).unwrap();
        inverse(&mut program).unwrap();
        program
    }

    #[test]
    fn a_program_searches_along_the_same_inputs() {
        let curves = [
            // Flat in the middle and at both ends.
            "let z = clamp(u, -8.0, -3.0) + clamp(3.0 * u, 6.0, 12.0);
             let slope = 0.0;
             if u > -8.0 && u < -3.0 { slope = 1.0; }
             if u > 2.0 && u < 4.0 { slope = 3.0; }
             return z, slope;",
            // Kinks, from which a step goes too far or not far enough.
            "let z = u;
             let slope = 1.0;
             if u > 0.0 { z = 3.0 * u; slope = 3.0; }
             return z, slope;",
            "let z = u;
             let slope = 1.0;
             if u < 0.0 { z = 3.0 * u; slope = 3.0; }
             if u < -10.0 { z = -30.0; slope = 0.0; }
             return z, slope;",
            // A jump, a step, a maximum.
            "let z = u;
             if u >= 2.0 { z = u + 6.0; }
             return z, 1.0;",
            "return 5.0 * way(u - 2.0), 0.0;",
            "return u - 0.05 * u * u, 1.0 - 0.1 * u;",
            // Smooth curves.
            "let z = exponential(0.3 * u);
             return z, 0.3 * z;",
            "return 0.01 * u * u * u, 0.03 * u * u;",
            // The teeth of a saw: the inputs on the way decide which solution is found.
            "let k = whole(0.5 * (u + 30.0));
             let t = 0.5 * (u + 30.0) - real(k);
             return 8.0 * t + 0.3 * u - 4.0, 4.3;",
        ];
        for curve in curves {
            let program = curved(curve);
            let mut machine = Machine::new(&program, "hysteresis", false);
            for (low, high) in [(-20.0, 25.0), (-12.0, 10.0), (4.0, 4.0), (-3.0, 2.0)] {
                let at_ends = [low, high].map(|u| machine.call("hysteresis", &[u]).unwrap()[0]);
                // Also within rounding of an end.
                let near = at_ends.map(|z| [-3.0, -1.0, 0.0, 1.0, 3.0].map(|k| z * (1.0 + k * f64::EPSILON)));
                for z in (-12..=12).map(f64::from).chain(near.concat()) {
                    let known = between((low, high), z, |u| machine.call("hysteresis", &[u]).unwrap()[0]).u;
                    let found = machine.call("hysteresis_by_trials", &[z, low, high]).unwrap()[0];
                    assert_eq!(found.to_bits(), known.to_bits(), "{found}, not {known}: {z} of {curve}");
                    for last in [-40.0, -12.0, -10.0, -1.0, 2.0, 7.0] {
                        machine.state().copy_from_slice(&[last, 0.0]);
                        let ahead = |u| {
                            let found = machine.call("hysteresis_ahead", &[u]).unwrap();
                            Dual { value: found[0], slope: found[1] }
                        };
                        let known = by_slopes(last, z, (low, high), ahead).map(|found| found.u);
                        let trace = machine.state()[1];
                        machine.state().copy_from_slice(&[last, 0.0]);
                        let found = machine.call("hysteresis_by_slopes", &[z, low, high]).unwrap();
                        assert_eq!(machine.state()[1], trace, "from {last} to {z} of {curve}");
                        assert_eq!((found[1] == 1.0).then_some(found[0]), known, "from {last} to {z} of {curve}");
                    }
                }
            }
        }
    }

    /// A gain that keeps its inputs.
    #[derive(Debug, Default)]
    struct Watched(Mutex<Vec<f64>>);

    impl System for Watched {
        fn ts(&self) -> f64 {
            1.0
        }

        fn order(&self) -> usize {
            0
        }

        fn step(&self, _: &mut [f64], u: f64) -> f64 {
            self.0.lock().unwrap().push(u);
            u
        }
    }

    impl Hysteresis for Watched {
        fn operator(&self) -> &'static Operator {
            OPERATORS[0]
        }

        fn params(&self) -> Map<String, Value> {
            Map::new()
        }
    }

    #[test]
    fn an_operator_is_checked_along_a_major_loop_and_a_minor_loop_in_it() {
        let watched = Watched::default();
        assert_eq!((&watched as &dyn Hysteresis).falling_input(-10.0, 30.0), None);
        let known = path(&[-10.0, 30.0, -10.0, 20.0, 0.0, 10.0, 0.0], 400);
        // Before that it settles.
        assert_close(&watched.0.into_inner().unwrap(), &[&[-10.0][..], &known].concat(), 1e-12, 1e-12);
    }

    #[test]
    fn whether_an_operator_decreases_does_not_depend_on_its_unit() {
        let block = |name: &str, weights: &[f64]| {
            let document = json!({"operator": name, "range": [-20, 20], "thresholds": [3], "weights": weights});
            load(&document, 1.0).unwrap()
        };
        let at = block("stop", &[1.0, 1.5]).falling_input(-20.0, 20.0);
        assert!(at.is_some());
        for unit in [1e-12, 1e12] {
            assert_eq!(block("stop", &[unit, 1.5 * unit]).falling_input(-20.0, 20.0), at);
            // A play stands still after each reversal.
            assert_eq!(block("prandtl-ishlinskii", &[0.0, unit]).falling_input(-60.0, -20.0), None);
        }
        let nothing = load(&json!({"operator": "proportional", "gain": 0}), 1.0).unwrap();
        assert_eq!(nothing.falling_input(-1.0, 1.0), None);
    }
}
