//! The hysteresis block: input voltage u to hidden variable z. One file an operator, one row each in [`OPERATORS`].

mod asymmetric_bouc_wen;
mod baber_noori;
mod basis;
mod bouc_wen;
mod branches;
mod dahl;
mod duhem;
mod generalised_play;
mod inverse;
mod krasnoselskii;
mod law;
mod maxwell_slip;
mod nodes;
mod play;
mod preisach;
mod proportional;
mod rate_play;
mod rate_scheduled;
mod real;
mod stop;
mod tellinen;
mod thresholds;
mod two_branch;

pub use basis::{Basis, BasisDesign, ShapeParameter};
pub use branches::{Branches, MeasuredLoop, Split};
pub use inverse::Inverted;
pub(crate) use inverse::{between, inverse, inverse_behind_a_driver, with_scratch};
pub use proportional::Proportional;
pub(crate) use rate_scheduled::{Pair, RateScheduled};
pub use two_branch::{HeldInput, TwoBranch};

use crate::error::{Error, row};
use crate::program::Block;
use crate::system::System;
use serde_json::{Map, Value};
use std::sync::Arc;

/// A hysteresis operator with its parameters: a system from u to z that serialises.
pub trait Hysteresis: System {
    /// Its row of [`OPERATORS`].
    fn operator(&self) -> &'static Operator;

    /// Its parameters, as [`Operator::load`] takes them back.
    fn params(&self) -> Map<String, Value>;

    /// The inputs it was identified on, from the lowest to the highest [input unit]; beyond them it extrapolates.
    fn range(&self) -> Option<(f64, f64)> {
        None
    }

    /// The input between `ends` that the next step, from the state `x`, answers with `z`; of what lies beyond, the nearer end.
    /// By trials unless the operator has a formula.
    fn invert(&self, x: &[f64], z: f64, ends: (f64, f64)) -> Inverted {
        inverse::by_trials(self, x, z, ends)
    }

    /// The same for programs: a block called `hysteresis` whose state is laid out as here, with a function
    /// `hysteresis(x: hysteresis, u)` for the step, and for the inverse either `hysteresis_ahead(x: hysteresis, u)`, which returns z and its slope
    /// as the next step would, `hysteresis_inverse(x: hysteresis, z, low, high)`, or neither where slopes come from the step itself. It may
    /// bring `hysteresis_move(x: hysteresis, u)`, the step without its answer, where that is cheaper. None if it cannot be exported.
    fn block(&self) -> Option<Block> {
        None
    }

    /// z and its slope as the next step would answer them, where a law tells.
    #[cfg(test)]
    fn ahead(&self, _x: &[f64], _u: f64) -> Option<(f64, f64)> {
        None
    }

    /// The frequencies it was identified at, from the lowest to the highest [Hz], if its output depends on them.
    fn frequencies(&self) -> Option<(f64, f64)> {
        None
    }
}

/// One kind of hysteresis operator: a row of [`OPERATORS`].
pub struct Operator {
    /// As users and files write it.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Where it comes from.
    pub reference: &'static str,
    /// Whether a minor loop leaves and rejoins the major one without a jump.
    pub minor_loops: bool,
    /// Whether the output depends on the order of inputs alone, not on their timing.
    pub rate_independent: bool,
    /// Whether an input that passes an older reversal forgets the loops inside it.
    pub wipes_out: bool,
    /// What the joint way fits of it, for inputs like these.
    pub basis: fn(&BasisDesign) -> Result<Box<dyn Basis>, Error>,
    /// Reads the parameters of a model file; the second argument is the sampling period [s].
    pub load: fn(Value, f64) -> Result<Arc<dyn Hysteresis>, Error>,
    /// A typical member for inputs of +-30, used by the documentation and the contract tests.
    pub example: fn(f64) -> Result<Arc<dyn Hysteresis>, Error>,
}

impl std::fmt::Debug for Operator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Operator").field(&self.name).finish()
    }
}

/// The operators there are.
pub static OPERATORS: &[&Operator] = &[
    &proportional::OPERATOR,
    &two_branch::OPERATOR,
    &rate_scheduled::OPERATOR,
    &play::OPERATOR,
    &stop::OPERATOR,
    &generalised_play::OPERATOR,
    &rate_play::OPERATOR,
    &preisach::OPERATOR,
    &krasnoselskii::OPERATOR,
    &maxwell_slip::OPERATOR,
    &bouc_wen::OPERATOR,
    &asymmetric_bouc_wen::OPERATOR,
    &baber_noori::OPERATOR,
    &dahl::OPERATOR,
    &duhem::OPERATOR,
    &tellinen::OPERATOR,
];

impl Operator {
    /// The operator called `name`.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the names there are.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        row("operator", OPERATORS.iter().copied(), |row| row.name, name)
    }

    /// The operators of these names, which commas separate.
    ///
    /// # Errors
    /// As [`Operator::find`].
    pub fn list(names: &str) -> Result<Vec<&'static Self>, Error> {
        names.split(',').map(|name| Operator::find(name.trim())).collect()
    }
}

/// Writes an operator as `{"operator": name, ...params}`.
pub(crate) fn save(hysteresis: &dyn Hysteresis) -> Value {
    let mut document = Map::new();
    document.insert("operator".into(), hysteresis.operator().name.into());
    document.extend(hysteresis.params());
    Value::Object(document)
}

/// Reads what [`save`] wrote.
pub(crate) fn load(document: &Value, ts: f64) -> Result<Arc<dyn Hysteresis>, Error> {
    let missing = || Error::Content("the hysteresis block has no \"operator\" name: is this a model file?".into());
    let mut params = document.as_object().cloned().ok_or_else(missing)?;
    let name = params.remove("operator").and_then(|v| v.as_str().map(String::from)).ok_or_else(missing)?;
    (Operator::find(&name)?.load)(Value::Object(params), ts)
}

/// Parameters as a type that serde can fill, with an error that names the operator.
fn parse<T: serde::de::DeserializeOwned>(operator: &str, params: Value) -> Result<T, Error> {
    serde_json::from_value(params).map_err(|e| Error::Content(format!("hysteresis block `{operator}`: {e}")))
}

/// Parameters as a document.
fn document(params: &impl serde::Serialize) -> Map<String, Value> {
    match serde_json::to_value(params) {
        Ok(Value::Object(map)) => map,
        _ => Map::new(),
    }
}

#[cfg(test)]
mod tests {
    //! The contract every operator keeps.
    use super::*;

    use crate::program::{Machine, Program};

    fn examples() -> impl Iterator<Item = Arc<dyn Hysteresis>> {
        OPERATORS.iter().map(|o| (o.example)(5e-4).unwrap())
    }

    /// Those that have a program.
    fn programs() -> impl Iterator<Item = (Arc<dyn Hysteresis>, Block)> {
        examples().map(|e| (e.clone(), e.block().unwrap()))
    }

    fn wander(n: usize) -> Vec<f64> {
        (0..n).map(|t| 18.0 * (t as f64 * 0.05).sin() + 11.0 * (t as f64 * 0.173).sin()).collect()
    }

    /// A wandering input that stands now and then, and before it all that is rare: zeros of both signs, steps that are tiny or huge,
    /// turns.
    fn trying() -> Vec<f64> {
        let rare = [
            [-0.0, 0.0, 1e-12, -1e-12, 1e-12, 1e-300, -1e-300, 0.0, -3.0, -3.0 + 1e-12, -3.0, 3.0, 24.0, 24.0 + 1e-12],
            [24.0, -24.0, 30.0, -30.0, 9.0, 1e6, 1e6, 1e6 - 1e-9, -250.0, 0.0, -0.0, 7.0, 12.0, 12.0],
        ]
        .concat();
        let stands = wander(300).into_iter().enumerate().flat_map(|(t, u)| vec![u; if t % 7 == 6 { 2 } else { 1 }]);
        rare.into_iter().chain(stands).collect()
    }

    #[test]
    fn every_operator_says_what_it_is_and_where_it_comes_from() {
        for (o, example) in OPERATORS.iter().zip(examples()) {
            assert!(!o.summary.is_empty() && !o.reference.is_empty(), "{}", o.name);
            assert_eq!(example.operator().name, o.name);
            assert_eq!(Operator::find(o.name).unwrap().name, o.name);
        }
    }

    #[test]
    fn every_operator_answers_bounded_inputs_with_bounded_outputs() {
        for example in examples() {
            let z = example.simulate(&wander(5000));
            assert!(z.iter().all(|z| z.abs() < 100.0), "{example:?}");
        }
    }

    #[test]
    fn every_operator_survives_its_file_to_the_bit() {
        for example in examples() {
            let text = save(&*example).to_string();
            let again = load(&serde_json::from_str(&text).unwrap(), 5e-4).unwrap();
            assert_eq!(again.simulate(&wander(3000)), example.simulate(&wander(3000)));
            assert_eq!(save(&*again).to_string(), text);
        }
    }

    #[test]
    fn every_operator_may_be_stopped_and_resumed() {
        let u = wander(1000);
        for example in examples() {
            let mut x = example.initial();
            let mut z = example.resume(&mut x, &u[..377]);
            z.extend(example.resume(&mut x, &u[377..]));
            assert_eq!(z, example.simulate(&u));
            let mut x = example.initial();
            assert_eq!(u.iter().map(|&u| example.step(&mut x, u)).collect::<Vec<_>>(), z, "{example:?}");
        }
    }

    #[test]
    fn every_operator_that_has_settled_stays_where_it_is() {
        for example in examples() {
            let z = example.resume(&mut example.settled(12.0), &[12.0; 50]);
            assert!(z.iter().all(|later| *later == z[0]), "{example:?}");
        }
    }

    #[test]
    fn rate_independent_operators_ignore_how_long_an_input_is_held() {
        let u = wander(500);
        let held: Vec<f64> = u.iter().flat_map(|&u| [u; 3]).collect();
        for example in examples().filter(|e| e.operator().rate_independent) {
            let z: Vec<f64> = example.simulate(&held).into_iter().skip(2).step_by(3).collect();
            assert_eq!(z, example.simulate(&u), "{example:?}");
        }
    }

    #[test]
    fn rate_independent_operators_ignore_how_fast_time_passes() {
        for o in OPERATORS {
            let [slow, fast] = [1.0, 1e-5].map(|ts| load(&save(&*(o.example)(5e-4).unwrap()), ts).unwrap());
            let same = slow.simulate(&wander(500)) == fast.simulate(&wander(500));
            assert_eq!(same, o.rate_independent, "{}", o.name);
        }
    }

    #[test]
    fn operators_that_wipe_out_forget_a_loop_once_its_turning_points_are_passed() {
        let leg = |from: f64, to: f64| (1..=40).map(move |t| from + (to - from) * f64::from(t) / 40.0);
        let path = |turns: &[f64]| turns.windows(2).flat_map(|w| leg(w[0], w[1])).collect::<Vec<f64>>();
        // Up to 20, down to -8 with or without a loop on the way, and on to -25 and back.
        let plain = path(&[0.0, 20.0, -8.0, -25.0, 10.0]);
        let looped = path(&[0.0, 20.0, -5.0, 13.0, 2.0, 9.0, -8.0, -25.0, 10.0]);
        let end = |z: &[f64]| z[z.len() - 81..].to_vec();
        for example in examples() {
            let (z, after) = (end(&example.simulate(&plain)), end(&example.simulate(&looped)));
            let off = z.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if example.operator().wipes_out {
                assert_eq!(off, 0.0, "{example:?}");
            }
        }
    }

    /// The examples, and members with few and more elements, on other ranges, with shape parameters at their ends and weights of both signs.
    fn members() -> Vec<Arc<dyn Hysteresis>> {
        let mut members: Vec<_> = examples().collect();
        let mut bare = save(&*(generalised_play::OPERATOR.example)(5e-4).unwrap());
        (bare["dead_zones"], bare["weights"]) = (serde_json::json!([]), serde_json::json!(vec![0.6; 9]));
        members.push(load(&bare, 5e-4).unwrap());
        for (elements, range) in [(1, (-30.0, 30.0)), (3, (0.0, 100.0)), (10, (-30.0, 12.0))] {
            let design = BasisDesign { ts: 5e-4, range, elements: Some(elements), frequencies: vec![5.0, 20.0, 80.0] };
            for basis in OPERATORS.iter().map(|o| (o.basis)(&design).unwrap()) {
                let weights: Vec<f64> = (0..basis.len()).map(|k| 0.4 * (1.3 * k as f64 - 1.0).cos()).collect();
                for end in [|s: &ShapeParameter| s.low, |s: &ShapeParameter| s.high] {
                    let shape: Vec<f64> = basis.shape().iter().map(end).collect();
                    members.extend(basis.reshaped(&shape).and_then(|b| b.operator(&weights)));
                }
            }
        }
        members
    }

    /// Steps `operator` and its program along `u`.
    pub(in crate::hysteresis) fn same_as_a_program(operator: &dyn Hysteresis, u: &[f64]) {
        let program = Program::new(vec![Block::elementary(), operator.block().unwrap()]).unwrap();
        let mut machine = Machine::new(&program, "hysteresis", false);
        let mut x = operator.initial();
        assert_eq!(machine.state(), x, "{operator:?}");
        for (t, &u) in u.iter().enumerate() {
            let z = operator.step(&mut x, u);
            assert_eq!(machine.call("hysteresis", &[u]).unwrap()[0].to_bits(), z.to_bits(), "{operator:?} at {t}");
            assert_eq!(machine.state(), x, "{operator:?} at {t}");
        }
    }

    #[test]
    fn every_operator_as_a_program_gives_the_same_bits_and_leaves_the_same_state() {
        for example in members() {
            same_as_a_program(&*example, &trying());
        }
    }

    #[test]
    fn a_law_as_a_program_has_the_slope_of_the_law_to_the_bit() {
        for example in members() {
            let (name, mut x) = (example.operator().name, example.initial());
            let (Some(block), Some(_)) = (example.block(), example.ahead(&x, 0.0)) else { continue };
            let mut program = Program::new(vec![Block::elementary(), block]).unwrap();
            super::inverse(&mut program).unwrap();
            let mut machine = Machine::new(&program, "hysteresis", false);
            for (t, u) in trying().into_iter().enumerate() {
                let (z, slope) = example.ahead(&x, u).unwrap();
                let found = machine.call("hysteresis_ahead", &[u]).unwrap();
                assert_eq!(found[0].to_bits(), z.to_bits(), "{example:?} at {t}, {u}: {found:?} for {z}");
                // But for the sign of a slope of 0.
                assert_eq!(found[1], slope, "{example:?} at {t}, {u}");
                assert_eq!(machine.state(), x, "a look ahead moves nothing: {name} at {t}");
                assert_eq!(example.step(&mut x, u).to_bits(), z.to_bits(), "{name} at {t}");
                machine.call("hysteresis", &[u]).unwrap();
            }
        }
    }

    /// What is wanted of the next step from the state `x`: within reach of a wandering input, the same as before, hardly another, and far
    /// beyond what there is.
    fn wanted(operator: &dyn Hysteresis, x: &[f64], t: usize, before: f64) -> f64 {
        match t % 17 {
            3 | 4 => before,
            7 => before + 1e-9,
            9 => 1e-12,
            11 => 1e3,
            14 => -1e3,
            _ => operator.step(&mut x.to_vec(), wander(t * t % 2000 + 1)[t * t % 2000]),
        }
    }

    #[test]
    fn every_inverse_as_a_program_gives_the_same_bits() {
        for (example, block) in programs() {
            let name = example.operator().name;
            let mut program = Program::new(vec![Block::elementary(), block]).unwrap();
            super::inverse(&mut program).unwrap();
            let rises = example.falling_input(-30.0, 30.0).is_none();
            let mut machine = Machine::new(&program, "hysteresis", false);
            let mut single = Machine::new(&program, "hysteresis", true);
            let (mut x, mut z) = (example.initial(), 0.0);
            for t in 0..500 {
                z = wanted(&*example, &x, t, z);
                let u = example.invert(&x, z, (-25.0, 30.0)).u;
                let found = machine.call("hysteresis_inverse", &[z, -25.0, 30.0]).unwrap()[0];
                assert_eq!(found.to_bits(), u.to_bits(), "{name} at {t}: {found} for {u}, wanted {z}");
                let reached = example.step(&mut x, u);
                machine.call("hysteresis", &[u]).unwrap();
                assert_eq!(machine.state(), x, "{name} at {t}");

                let u = single.call("hysteresis_inverse", &[z, -25.0, 30.0]).unwrap()[0];
                let back = single.call("hysteresis", &[u]).unwrap()[0];
                assert!((-25.0..=30.0).contains(&u), "{name} at {t}: {u}");
                if rises {
                    assert!(
                        (back - reached).abs() <= 64.0 * f64::from(f32::EPSILON) * 30.0,
                        "{name} at {t}: {back} for {reached}, wanted {z}"
                    );
                }
            }
        }
    }

    #[test]
    fn programs_bear_what_is_no_number() {
        for (_, block) in programs() {
            let mut program = Program::new(vec![Block::elementary(), block]).unwrap();
            super::inverse(&mut program).unwrap();
            let mut machine = Machine::new(&program, "hysteresis", false);
            for u in [1.0, f64::NAN, 2.0, f64::INFINITY, -3.0, f64::NEG_INFINITY, 5.0, -8.0, 1e300, -1e300, 4.0] {
                for z in [u, 3.0] {
                    machine.call("hysteresis_inverse", &[z, -25.0, 30.0]).unwrap();
                }
                machine.call("hysteresis", &[u]).unwrap();
            }
            machine.state().fill(f64::NAN);
            machine.call("hysteresis_inverse", &[1.0, -25.0, 30.0]).unwrap();
            machine.call("hysteresis", &[1.0]).unwrap();
        }
    }

    #[test]
    fn operators_with_minor_loops_turn_without_a_jump() {
        for example in examples() {
            // Small steps: what a step of 0.01 moves is small, unless it jumps between branches.
            let fine: Vec<f64> =
                (0..20_000).map(|t| 29.0 * (f64::from(t) * 0.0013).sin() * (f64::from(t) * 0.0002).cos()).collect();
            let z = example.resume(&mut example.settled(fine[0]), &fine);
            let largest = z.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
            assert_eq!(largest < 0.2, example.operator().minor_loops, "{example:?} moved by {largest}");
        }
    }

    #[test]
    fn parameters_that_make_no_sense_are_refused_with_the_operators_name() {
        for o in OPERATORS {
            let error = (o.load)(serde_json::json!({"nonsense": 1}), 5e-4).unwrap_err().to_string();
            assert!(error.contains(o.name), "{error}");
        }
        let error = load(&serde_json::json!({"operator": "two-brunch"}), 5e-4).unwrap_err().to_string();
        assert!(error.contains("did you mean `two-branch`?"), "{error}");
    }
}
