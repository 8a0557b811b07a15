//! The inverse of the hysteresis by bisection: a search for integers, of the same length in every sample.
//!
//! ```text
//! from the last input toward the wanted z:   u = (near + far) / 2;   short of z: near = u, else far = u
//! ```
//! Newton's method compares with the rounding of floating-point numbers. Bisection needs only the sign: after 31 passes
//! the ends are neighbouring counts. The last input stays unless another is nearer, so that a constant reference gives
//! a constant voltage. Where z is out of reach, the result is the end, and of a flat piece its beginning, as by
//! Newton's method. It does not do: laws that fall or jump between the ends, for which several inputs give the same z.

use crate::template::{context, render, template};
use piezoid::error::Error;
use piezoid_models::program::{Argument, FieldValue, Function, Program, Statement, ValueType};

/// One for the end, and one for each bit of a number.
const PASSES: usize = 32;

/// The inverses, and the function that each of them inverts.
const INVERSES: [(&str, &str); 2] = [("hysteresis_inverse", "hysteresis"), ("hidden_inverse", "hidden")];

/// Replaces each inverse that searches with floating-point numbers. Of a closed form with a search as a fallback, the
/// closed form stays.
pub(super) fn bisected(program: &mut Program) -> Result<(), Error> {
    for (name, forth) in INVERSES {
        let Some(at) = program.functions.iter().position(|f| f.name == name) else { continue };
        match program.function("hysteresis_closed") {
            Some(_) if forth == "hysteresis" => program.functions[at].steps.truncate(1),
            _ if !searches(&program.functions[at]) => {}
            _ => replace(program, at, forth)?,
        }
    }
    Ok(())
}

/// True if a function has a loop, or calls another function that searches.
fn searches(function: &Function) -> bool {
    let mut searches = false;
    let mut look = |step: &Statement| searches |= matches!(step, Statement::While(..));
    function.steps.iter().for_each(|step| step.all(&mut look));
    function.calls(&mut |name| searches |= name.contains("_by_"));
    searches
}

fn replace(program: &mut Program, at: usize, forth: &str) -> Result<(), Error> {
    let Function { name, block, takes, .. } = program.functions[at].clone();
    program.extend(&text(program, &takes, forth)?)?;
    if let Some(result) = program.functions.pop() {
        program.functions[at] = Function { name, block, ..result };
    }
    Ok(())
}

/// The text of the inverse with these parameters: states, then z, low and high.
fn text(program: &Program, takes: &[Argument], forth: &str) -> Result<String, Error> {
    let states = takes.iter().filter_map(|p| match &p.kind {
        ValueType::Part(block) => Some((p.name.as_str(), block.as_str())),
        _ => None,
    });
    let states: Vec<(&str, &str)> = states.collect();
    let declared: String = states.iter().map(|(name, block)| format!("{name}: {block}, ")).collect();
    let copies =
        |n: usize| states.iter().map(|(name, _)| format!("let {name}_{n} = copy({name}); ")).collect::<String>();
    let reached = |n: usize, u: &str| {
        let arguments: String = states.iter().map(|(name, _)| format!("{name}_{n}, ")).collect();
        format!("z - {forth}({arguments}{u})")
    };
    // Behind a driver, the last input of the hysteresis is not that of the model.
    let last = states.iter().find(|(_, block)| {
        let fields = program.block(block).map_or(&[][..], |b| &b.fields);
        forth == "hysteresis" && fields.iter().any(|f| f.name == "last" && matches!(f.holds, FieldValue::Number(_)))
    });
    let start = last.map_or("low".into(), |(name, _)| format!("clamp({name}.last, low, high)"));
    let context = context! {
        declared, start, passes => PASSES,
        copies_near => copies(1), left_of_near => reached(1, "near"),
        copies_tried => copies(2), left_of_tried => reached(2, "tried"),
    };
    render(template!("fixed/inverse.txt.j2"), context)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::Model;
    use piezoid::hysteresis::{OPERATORS, Operator};
    use piezoid::linear::Arx;
    use piezoid_models::program::Machine;
    use piezoid_numerics::series::ends;

    #[test]
    fn the_input_is_found_for_every_operator_as_by_the_library() {
        for operator in OPERATORS {
            let law = (operator.example)(5e-4).unwrap();
            let model = Model::new(law.clone(), Arx::gain(5e-4, 1.0).unwrap(), 0.0).unwrap();
            let mut program = model.program().unwrap();
            bisected(&mut program).unwrap();
            let mut machine = Machine::new(&program, "hysteresis", false);
            let u: Vec<f64> =
                (0..300).map(|t| 20.0 * (0.05 * f64::from(t)).sin() + 4.0 * (0.31 * f64::from(t)).cos()).collect();
            let z = law.simulate(&u);
            let height = ends(z.iter().copied());
            let mut worst = 0.0f64;
            for &z in &z {
                let found = machine.call("hysteresis_inverse", &[z, -30.0, 30.0]).unwrap()[0];
                let reached = machine.call("hysteresis", &[found]).unwrap()[0];
                worst = worst.max((reached - z).abs() / (height.1 - height.0));
            }
            // At a jump no input gives every z.
            assert!(worst < 1e-8 || !operator.minor_loops, "{}: {worst}", operator.name);
        }
    }

    #[test]
    fn a_constant_reference_gives_a_constant_input_and_one_out_of_reach_the_end() {
        let law = (Operator::find("stop").unwrap().example)(5e-4).unwrap();
        let mut program = Model::new(law, Arx::gain(5e-4, 1.0).unwrap(), 0.0).unwrap().program().unwrap();
        bisected(&mut program).unwrap();
        let mut machine = Machine::new(&program, "hysteresis", false);
        let mut input = |z: f64| {
            let u = machine.call("hysteresis_inverse", &[z, -30.0, 30.0]).unwrap()[0];
            machine.call("hysteresis", &[u]).unwrap();
            u
        };
        input(3.0);
        let still = input(3.0);
        assert!((0..100).all(|_| input(3.0).to_bits() == still.to_bits()));
        assert_eq!([input(1e6), input(1e6), input(-1e6)], [30.0, 30.0, -30.0]);
    }
}
