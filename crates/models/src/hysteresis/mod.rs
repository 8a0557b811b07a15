//! The hysteresis block: input voltage u to hidden variable z. Each operator has one file and one row in [`OPERATORS`].

mod asymmetric_bouc_wen;
mod baber_noori;
mod basis;
mod bouc_wen;
mod branches;
mod dahl;
mod duhem;
mod gaussian_process;
mod generalised_play;
mod inverse;
mod jiles_atherton;
mod krasnoselskii;
mod law;
mod maxwell_slip;
mod narx;
mod neural;
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

#[doc(hidden)]
pub use basis::{Basis, BasisDesign, SensitiveOperator, ShapeParameter};
pub use branches::{Branches, LoopOptions, MeasuredLoop, Split};
pub use inverse::Inverted;
pub(crate) use inverse::{between, inverse, inverse_behind_a_driver, with_scratch};
pub use proportional::Proportional;
pub use rate_scheduled::{Pair, RateScheduled};
#[doc(hidden)]
pub use real::{LANES, Real, Sensitive, Several};
pub use two_branch::{HeldInput, TwoBranch};

use crate::program::{Block, Program};
use piezoid_numerics::error::{Error, alike, row};
use piezoid_numerics::system::System;
use serde::{Serialize, Serializer};
use serde_json::{Map, Value, json};
use std::sync::Arc;

/// A hysteresis operator with its parameters: a system from u to z that serialises.
pub trait Hysteresis: System {
    /// Its row of [`OPERATORS`].
    fn operator(&self) -> &'static Operator;

    /// Its parameters, as [`Operator::load`] reads them.
    fn params(&self) -> Map<String, Value>;

    /// Lowest and highest input of the identification data [input unit]. Outside this range the operator extrapolates.
    fn range(&self) -> Option<(f64, f64)> {
        None
    }

    /// The input between `ends` for which the next step from the state `x` gives `z`. If no such input exists, the
    /// nearer end. Found by bracketing unless the operator has its own inverse.
    fn invert(&self, x: &[f64], z: f64, ends: (f64, f64)) -> Inverted {
        inverse::by_trials(self, x, z, ends)
    }

    /// The operator as a program: a block named `hysteresis` with the same state layout. `None` if it cannot be
    /// exported. Its functions:
    /// - `hysteresis(x: hysteresis, u)`, the step;
    /// - for the inverse, `hysteresis_ahead(x: hysteresis, u)` (z and its slope after the next step), or
    ///   `hysteresis_inverse(x: hysteresis, z, low, high)`, or neither: then the step is differentiated;
    /// - optional: `hysteresis_move(x: hysteresis, u)`, the step without its output, if that is cheaper.
    fn block(&self) -> Option<Block> {
        None
    }

    /// Its weights and the responses that they multiply, if exported code can read these from its state: so an
    /// estimator can move the weights while it runs.
    fn linear_weights(&self) -> Option<LinearWeights<'_>> {
        None
    }

    /// z and dz/du after the next step, if the operator has a law.
    #[cfg(test)]
    fn ahead(&self, _x: &[f64], _u: f64) -> Option<(f64, f64)> {
        None
    }

    /// Standard deviation of z at the state `x` [unit of z], if the operator states one.
    fn deviation(&self, _x: &[f64]) -> Option<f64> {
        None
    }

    /// Lowest and highest frequency of the identification data [Hz], if the output depends on frequency.
    fn frequencies(&self) -> Option<(f64, f64)> {
        None
    }
}

/// The sum w_0 u + w_1 phi_1 + ... of an operator, of which exported code can read every response.
#[derive(Debug, Clone, Copy)]
pub struct LinearWeights<'a> {
    /// The weights.
    pub weights: &'a [f64],
    /// The responses, with the state of the operator; the first is the input.
    pub basis: &'a dyn Basis,
    /// The response of index `k` + 1 after a step with the input `u`, as an expression of a program with the state `x`.
    pub response: &'static str,
}

/// What the memory of an operator is. Operators of one class make similar errors; those of two classes seldom do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// None.
    Linear,
    /// The direction of the input alone.
    Branches,
    /// Play or slip elements.
    Plays,
    /// Relays over a triangle.
    Relays,
    /// The state of a differential equation.
    Equations,
    /// A form that records determine.
    Learned,
}

/// One kind of hysteresis operator: a row of [`OPERATORS`].
pub struct Operator {
    /// Name, as users and files write it.
    pub name: &'static str,
    /// Other names in use, such as abbreviations.
    pub aliases: &'static [&'static str],
    /// Description in one line.
    pub summary: &'static str,
    /// Publication.
    pub reference: &'static str,
    /// True if a minor loop leaves and rejoins the major loop without a jump.
    pub minor_loops: bool,
    /// True if major loops do not determine its minor loops: its weights show only in minor loops.
    pub needs_minor_loops: bool,
    /// True if the output depends only on the order of the inputs, not on their timing.
    pub rate_independent: bool,
    /// True if an input that passes an older reversal deletes the loops inside it from memory.
    pub wipes_out: bool,
    /// What its memory is.
    pub class: Class,
    /// Its basis for the joint method, for the given inputs.
    pub basis: fn(&BasisDesign) -> Result<Box<dyn Basis>, Error>,
    /// Reads the parameters of a model file; the second argument is the sampling period [s].
    pub load: fn(Value, f64) -> Result<Arc<dyn Hysteresis>, Error>,
    /// A typical operator for inputs of +-30, used by the documentation and the contract tests.
    pub example: fn(f64) -> Result<Arc<dyn Hysteresis>, Error>,
}

impl std::fmt::Debug for Operator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Operator").field(&self.name).finish()
    }
}

/// The description and the properties; its other names are in the summary too.
impl Serialize for Operator {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let also = if self.aliases.is_empty() { String::new() } else { format!(" (or {})", self.aliases.join(", ")) };
        let row = json!({
            "name": self.name, "summary": format!("{}{also}", self.summary), "reference": self.reference,
            "aliases": self.aliases, "minor_loops": self.minor_loops, "needs_minor_loops": self.needs_minor_loops,
            "rate_independent": self.rate_independent, "wipes_out": self.wipes_out, "class": self.class,
            "learned": self.is_learned(),
        });
        row.serialize(to)
    }
}

/// All operators.
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
    &jiles_atherton::OPERATOR,
    &tellinen::OPERATOR,
    &narx::OPERATOR,
    &neural::OPERATOR,
    &gaussian_process::OPERATOR,
];

impl Operator {
    /// True if records determine its form, not only its parameters. `auto` leaves it out, because its fit takes longer
    /// than those of several laws together; `all` has it.
    pub fn is_learned(&self) -> bool {
        self.class == Class::Learned
    }

    /// The operator named `name`, or that has it as an alias.
    ///
    /// ```
    /// # use piezoid::hysteresis::Operator;
    /// assert_eq!(Operator::find("PI")?.name, Operator::find("prandtl_ishlinskii")?.name);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Unknown`] with the list of names.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        let alias = |row: &&&Operator| row.aliases.iter().any(|alias| alike(alias, name));
        let name = OPERATORS.iter().find(alias).map_or(name, |row| row.name);
        row("operator", OPERATORS.iter().copied(), |row| row.name, name)
    }

    /// The operators of a comma-separated list of names, without those after a minus sign; `all` stands for all, and
    /// `auto` for all but those that are [learned](Operator::is_learned).
    ///
    /// ```
    /// use piezoid::hysteresis::{OPERATORS, Operator};
    /// assert_eq!(Operator::list("stop, bouc-wen")?.len(), 2);
    /// assert_eq!(Operator::list("all,-preisach")?.len(), OPERATORS.len() - 1);
    /// let all = Operator::list("auto,narx")?;
    /// assert!(all.iter().filter(|operator| operator.is_learned()).map(|o| o.name).eq(["narx"]));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Operator::find`], and [`Error::Parameter`] if no operator is left.
    pub fn list(names: &str) -> Result<Vec<&'static Self>, Error> {
        let mut listed: Vec<&'static Self> = Vec::new();
        for name in names.split(',').map(str::trim) {
            match name.strip_prefix('-') {
                _ if name == AUTO => listed.extend(OPERATORS.iter().filter(|operator| !operator.is_learned())),
                _ if name == ALL => listed.extend(OPERATORS),
                None => listed.push(Operator::find(name)?),
                Some(without) => {
                    let without = Operator::find(without)?.name;
                    listed.retain(|operator| operator.name != without);
                }
            }
        }
        match listed.is_empty() {
            true => Err(Error::parameter("operator", names, "leaves no operator: begin with auto, or name one")),
            false => Ok(listed),
        }
    }
}

/// In a list of operators, all but those that are learned, and all.
const AUTO: &str = "auto";
const ALL: &str = "all";

/// True if a list of operators leaves the choice to the records.
pub fn is_auto(names: &str) -> bool {
    names.split(',').any(|name| [AUTO, ALL].iter().any(|all| name.trim().eq_ignore_ascii_case(all)))
}

/// Writes an operator as `{"operator": name, ...params}`.
pub fn save(hysteresis: &dyn Hysteresis) -> Value {
    let mut document = Map::new();
    document.insert("operator".into(), hysteresis.operator().name.into());
    document.extend(hysteresis.params());
    Value::Object(document)
}

/// Reads what [`save`] wrote.
pub fn load(document: &Value, ts: f64) -> Result<Arc<dyn Hysteresis>, Error> {
    let missing = || Error::Content("the hysteresis block has no \"operator\" name: is this a model file?".into());
    let mut params = document.as_object().cloned().ok_or_else(missing)?;
    let name = params.remove("operator").and_then(|v| v.as_str().map(String::from)).ok_or_else(missing)?;
    (Operator::find(&name)?.load)(Value::Object(params), ts)
}

/// The program of an operator, with the elementary functions.
pub(crate) fn program(hysteresis: &dyn Hysteresis) -> Result<Program, Error> {
    let unsuited = || {
        let because = format!("its operator, `{}`, has none", hysteresis.operator().name);
        Error::Unsuited { what: "program".into(), because }
    };
    Program::new(vec![Block::elementary(), hysteresis.block().ok_or_else(unsuited)?])
}

/// Deserialises parameters; the error names the operator.
fn parse<T: serde::de::DeserializeOwned>(operator: &str, params: Value) -> Result<T, Error> {
    serde_json::from_value(params).map_err(|e| Error::Content(format!("hysteresis block `{operator}`: {e}")))
}

/// Serialises parameters.
fn document(params: &impl serde::Serialize) -> Map<String, Value> {
    match serde_json::to_value(params) {
        Ok(Value::Object(map)) => map,
        _ => Map::new(),
    }
}

#[cfg(test)]
mod tests {
    //! Contract tests of all operators.
    use super::*;

    use crate::program::{Machine, Program};

    fn examples() -> impl Iterator<Item = Arc<dyn Hysteresis>> {
        OPERATORS.iter().map(|o| (o.example)(5e-4).unwrap())
    }

    /// The program of an operator and of its inverse.
    fn program(block: Block) -> Program {
        let mut program = Program::new(vec![Block::elementary(), block]).unwrap();
        super::inverse(&mut program).unwrap();
        program
    }

    /// Inputs on straight lines from one value of `turns` to the next, `pieces` samples each.
    pub(in crate::hysteresis) fn path(turns: &[f64], pieces: u32) -> Vec<f64> {
        let leg = |w: &[f64]| {
            let (from, to) = (w[0], w[1]);
            (1..=pieces).map(move |i| from + (to - from) * f64::from(i) / f64::from(pieces))
        };
        turns.windows(2).flat_map(leg).collect()
    }

    fn wander(n: usize) -> Vec<f64> {
        (0..n).map(|t| 18.0 * (t as f64 * 0.05).sin() + 11.0 * (t as f64 * 0.173).sin()).collect()
    }

    /// Rare inputs (zeros of both signs, tiny and huge steps, reversals), then a wandering input that is held now and
    /// then.
    fn difficult_inputs() -> Vec<f64> {
        let rare = [
            [-0.0, 0.0, 1e-12, -1e-12, 1e-12, 1e-300, -1e-300, 0.0, -3.0, -3.0 + 1e-12, -3.0, 3.0, 24.0, 24.0 + 1e-12],
            [24.0, -24.0, 30.0, -30.0, 9.0, 1e6, 1e6, 1e6 - 1e-9, -250.0, 0.0, -0.0, 7.0, 12.0, 12.0],
        ]
        .concat();
        let stands = wander(300).into_iter().enumerate().flat_map(|(t, u)| vec![u; if t % 7 == 6 { 2 } else { 1 }]);
        rare.into_iter().chain(stands).collect()
    }

    #[test]
    fn every_operator_has_a_summary_and_a_reference() {
        for (o, example) in OPERATORS.iter().zip(examples()) {
            assert!(!o.summary.is_empty() && !o.reference.is_empty(), "{}", o.name);
            assert_eq!(example.operator().name, o.name);
            assert_eq!(Operator::find(o.name).unwrap().name, o.name);
        }
    }

    #[test]
    fn every_operator_but_the_gain_states_the_range_of_its_data() {
        for example in examples() {
            let range = Some((-30.0, 30.0)).filter(|_| example.operator().name != "proportional");
            assert_eq!(example.range(), range, "{example:?}");
        }
    }

    #[test]
    fn bounded_inputs_give_bounded_outputs() {
        for example in examples() {
            let z = example.simulate(&wander(5000));
            assert!(z.iter().all(|z| z.abs() < 100.0), "{example:?}");
        }
    }

    #[test]
    fn every_operator_is_bit_identical_after_saving_and_loading() {
        for example in examples() {
            let text = save(&*example).to_string();
            let again = load(&serde_json::from_str(&text).unwrap(), 5e-4).unwrap();
            assert_eq!(again.simulate(&wander(3000)), example.simulate(&wander(3000)));
            assert_eq!(save(&*again).to_string(), text);
        }
    }

    #[test]
    fn a_run_in_parts_or_steps_equals_one_run() {
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
    fn a_settled_operator_is_constant_while_the_input_is_held() {
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
    fn only_rate_independent_operators_ignore_the_sampling_period() {
        for o in OPERATORS {
            let [slow, fast] = [1.0, 1e-5].map(|ts| load(&save(&*(o.example)(5e-4).unwrap()), ts).unwrap());
            let same = slow.simulate(&wander(500)) == fast.simulate(&wander(500));
            assert_eq!(same, o.rate_independent, "{}", o.name);
        }
    }

    #[test]
    fn operators_that_wipe_out_forget_a_loop_once_its_reversals_are_passed() {
        // Up to 20, down to -8 with or without loops on the way, then to -25 and back.
        let plain = path(&[0.0, 20.0, -8.0, -25.0, 10.0], 40);
        let looped = path(&[0.0, 20.0, -5.0, 13.0, 2.0, 9.0, -8.0, -25.0, 10.0], 40);
        let end = |z: Vec<f64>| z[z.len() - 81..].to_vec();
        for example in examples().filter(|e| e.operator().wipes_out) {
            assert_eq!(end(example.simulate(&plain)), end(example.simulate(&looped)), "{example:?}");
        }
    }

    /// The examples, and operators with few and many elements, other ranges, shape parameters at their bounds, and
    /// weights of both signs.
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

    /// Checks that `operator` and its program are bit-identical along `u`.
    pub(in crate::hysteresis) fn check_program(operator: &dyn Hysteresis, u: &[f64]) {
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
    fn every_program_is_bit_identical_to_its_operator() {
        members().iter().for_each(|operator| check_program(&**operator, &difficult_inputs()));
    }

    #[test]
    fn the_slope_of_a_program_is_bit_identical_to_that_of_its_law() {
        for example in members() {
            let (name, mut x) = (example.operator().name, example.initial());
            let (Some(block), Some(_)) = (example.block(), example.ahead(&x, 0.0)) else { continue };
            let program = program(block);
            let mut machine = Machine::new(&program, "hysteresis", false);
            for (t, u) in difficult_inputs().into_iter().enumerate() {
                let (z, slope) = example.ahead(&x, u).unwrap();
                let found = machine.call("hysteresis_ahead", &[u]).unwrap();
                assert_eq!(found[0].to_bits(), z.to_bits(), "{example:?} at {t}, {u}: {found:?} for {z}");
                // Except for the sign of a slope of 0.
                assert_eq!(found[1], slope, "{example:?} at {t}, {u}");
                assert_eq!(machine.state(), x, "a look ahead keeps the state: {name} at {t}");
                assert_eq!(example.step(&mut x, u).to_bits(), z.to_bits(), "{name} at {t}");
                machine.call("hysteresis", &[u]).unwrap();
            }
        }
    }

    /// The z requested of the next step from the state `x`: reachable, the same as `before`, almost the same, or far
    /// out of reach.
    fn requested(operator: &dyn Hysteresis, x: &[f64], t: usize, before: f64) -> f64 {
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
    fn every_inverse_program_is_bit_identical_to_the_inverse() {
        for example in examples() {
            let name = example.operator().name;
            let program = program(example.block().unwrap());
            let rises = example.falling_input(-30.0, 30.0).is_none();
            let mut machine = Machine::new(&program, "hysteresis", false);
            let mut single = Machine::new(&program, "hysteresis", true);
            let (mut x, mut z) = (example.initial(), 0.0);
            for t in 0..500 {
                z = requested(&*example, &x, t, z);
                let u = example.invert(&x, z, (-25.0, 30.0)).u;
                let found = machine.call("hysteresis_inverse", &[z, -25.0, 30.0]).unwrap()[0];
                assert_eq!(found.to_bits(), u.to_bits(), "{name} at {t}: {found} for {u}, requested {z}");
                let reached = example.step(&mut x, u);
                machine.call("hysteresis", &[u]).unwrap();
                assert_eq!(machine.state(), x, "{name} at {t}");

                let u = single.call("hysteresis_inverse", &[z, -25.0, 30.0]).unwrap()[0];
                let back = single.call("hysteresis", &[u]).unwrap()[0];
                assert!((-25.0..=30.0).contains(&u), "{name} at {t}: {u}");
                let near = (back - reached).abs() <= 64.0 * f64::from(f32::EPSILON) * 30.0;
                assert!(near || !rises, "{name} at {t}: {back} for {reached}, requested {z}");
            }
        }
    }

    #[test]
    fn no_step_and_no_inverse_takes_more_operations_than_its_bound() {
        for example in members() {
            let program = program(example.block().unwrap());
            let [step, inverse] = ["hysteresis", "hysteresis_inverse"].map(|name| program.bound(name).unwrap());
            for single in [false, true] {
                let mut machine = Machine::new(&program, "hysteresis", single);
                for u in difficult_inputs() {
                    let mut taken = |name: &str, numbers: &[f64]| {
                        let before = machine.counts.total();
                        machine.call(name, numbers).unwrap();
                        machine.counts.total() - before
                    };
                    let [z, forth] = [("hysteresis_inverse", &[u, -25.0, 30.0][..]), ("hysteresis", &[u])]
                        .map(|(name, numbers)| taken(name, numbers));
                    assert!(z <= inverse && forth <= step, "{example:?} at {u}: {z} of {inverse}, {forth} of {step}");
                }
            }
        }
    }

    #[test]
    fn programs_accept_values_that_are_not_finite() {
        for example in examples() {
            let program = program(example.block().unwrap());
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
    fn only_operators_without_minor_loops_jump_at_a_reversal() {
        for example in examples() {
            // Steps of about 0.01: z moves little unless it jumps between branches.
            let fine: Vec<f64> =
                (0..20_000).map(|t| 29.0 * (f64::from(t) * 0.0013).sin() * (f64::from(t) * 0.0002).cos()).collect();
            let z = example.resume(&mut example.settled(fine[0]), &fine);
            let largest = z.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
            assert_eq!(largest < 0.2, example.operator().minor_loops, "{example:?} moved by {largest}");
        }
    }

    #[test]
    fn errors_about_parameters_name_the_operator() {
        for o in OPERATORS {
            let error = (o.load)(serde_json::json!({"nonsense": 1}), 5e-4).unwrap_err().to_string();
            assert!(error.contains(o.name), "{error}");
        }
        let error = load(&serde_json::json!({"operator": "two-brunch"}), 5e-4).unwrap_err().to_string();
        assert!(error.contains("did you mean `two-branch`?"), "{error}");
    }

    fn names(list: &str) -> Vec<&'static str> {
        Operator::list(list).unwrap().iter().map(|operator| operator.name).collect()
    }

    #[test]
    fn a_list_names_operators_and_those_that_it_leaves_out() {
        assert_eq!(names("stop, PI"), ["stop", "prandtl-ishlinskii"]);
        let all: Vec<_> = OPERATORS.iter().map(|operator| operator.name).collect();
        let learned = ["narx", "neural", "gaussian-process"];
        let laws: Vec<_> = all.iter().copied().filter(|name| !learned.contains(name)).collect();
        assert_eq!((names("all"), names("auto")), (all.clone(), laws));
        let without: Vec<_> = all.into_iter().filter(|name| *name != "preisach").collect();
        assert_eq!(names("all,-preisach"), without);
        for refused in ["stop,-stop", "", "furlong", "stop,-furlong"] {
            assert!(Operator::list(refused).is_err(), "{refused}");
        }
        assert!(is_auto("stop, Auto") && is_auto("all,-stop") && !is_auto("stop,dahl") && !is_auto(""));
    }

    #[test]
    fn the_row_of_an_operator_is_written_with_its_properties() {
        let row = |name: &str| serde_json::to_value(Operator::find(name).unwrap()).unwrap();
        let preisach = row("preisach");
        assert_eq!((&preisach["name"], &preisach["class"]), (&json!("preisach"), &json!("relays")));
        assert_eq!((&preisach["learned"], &row("narx")["learned"]), (&json!(false), &json!(true)));
        assert_eq!((&preisach["minor_loops"], &preisach["wipes_out"]), (&json!(true), &json!(true)));
        let plays = Operator::find("PI").unwrap();
        let summary = format!("{} (or {})", plays.summary, plays.aliases.join(", "));
        assert_eq!((&row("PI")["summary"], &row("PI")["aliases"]), (&json!(summary), &json!(plays.aliases)));
        assert_eq!(row("dahl")["summary"], Operator::find("dahl").unwrap().summary);
    }

    #[test]
    fn weights_that_a_program_can_move_multiply_the_responses() {
        let mut count = 0;
        for operator in examples() {
            let Some(linear) = operator.linear_weights() else { continue };
            count += 1;
            let mut phi = vec![0.0; linear.weights.len()];
            let (mut x, mut of_basis) = (operator.initial(), operator.initial());
            for u in wander(50) {
                linear.basis.step(&mut of_basis, u, &mut phi);
                let sum: f64 = linear.weights.iter().zip(&phi).map(|(w, phi)| w * phi).sum();
                let z = operator.step(&mut x, u);
                assert!((z - sum).abs() <= 1e-12 * z.abs().max(1.0), "{}: {z} {sum}", operator.operator().name);
            }
        }
        assert!(count >= 4, "{count} operators have such weights");
    }

    #[test]
    fn only_an_operator_of_frequencies_has_frequencies() {
        let known: Vec<_> = examples().filter_map(|o| Some((o.operator().name, o.frequencies()?))).collect();
        assert_eq!(known, [("rate-scheduled", (5.0, 80.0))]);
    }

    #[test]
    fn a_shape_parameter_is_refused_at_a_limit_that_no_operator_has() {
        let loaded = |name: &str, parameter: &str, value: f64| {
            let mut document = save(&*(Operator::find(name).unwrap().example)(5e-4).unwrap());
            document[parameter] = json!(value);
            load(&document, 5e-4).map_err(|error| error.to_string())
        };
        let refused = [
            ("asymmetric-bouc-wen", "gamma_over_beta", -1.0),
            ("asymmetric-bouc-wen", "loading_skew", -1.0),
            ("asymmetric-bouc-wen", "loading_skew", 1.0),
            ("asymmetric-bouc-wen", "unloading_skew", -1.0),
            ("asymmetric-bouc-wen", "unloading_skew", 1.0),
            ("bouc-wen-baber-noori", "gamma_over_beta", -1.0),
            ("bouc-wen-baber-noori", "pinch", 1.0),
            ("jiles-atherton", "coupling", 1.0),
            ("maxwell-slip", "rise", -1.0),
        ];
        for (name, parameter, limit) in refused {
            let message = loaded(name, parameter, limit).unwrap_err();
            assert!(message.starts_with(&format!("{parameter} = {limit}: must be")), "{name}: {message}");
            assert!(loaded(name, parameter, 0.999 * limit).is_ok(), "{name}: {parameter}");
        }
        let allowed = [
            ("asymmetric-bouc-wen", "gamma_over_beta", 1.0),
            ("bouc-wen", "gamma_over_beta", -10.0),
            ("bouc-wen-baber-noori", "gamma_over_beta", 1.0),
            ("bouc-wen-baber-noori", "strength_loss", 0.0),
            ("rate-dependent-prandtl-ishlinskii", "growth", 0.0),
        ];
        for (name, parameter, limit) in allowed {
            assert!(loaded(name, parameter, limit).is_ok(), "{name}: {parameter}");
        }
    }

    #[test]
    fn an_operator_is_printed_by_its_name() {
        assert_eq!(format!("{:?}", Operator::find("PI").unwrap()), r#"Operator("prandtl-ishlinskii")"#);
    }
}
