//! The model as a program.

use super::Model;
use crate::hysteresis::{self, inverse, inverse_behind_a_driver};
use crate::program::{Block, Program};
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;

impl Model {
    /// The model as a program: a block `state` with all its parts, in the order of its state here, and a function
    /// `step(s: state, u)`.
    ///
    /// ```
    /// use piezoid::{Model, System, hysteresis::Operator, linear::Arx};
    /// use piezoid_models::program::Machine;
    /// let plays = (Operator::find("prandtl-ishlinskii")?.example)(5e-4)?;
    /// let model = Model::new(plays, Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1])?, 2.0)?;
    /// let program = model.program()?;
    /// let mut machine = Machine::new(&program, "state", false);
    /// assert_eq!(machine.call("step", &[20.0])?, model.simulate(&[20.0]));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Unsuited`] if the operator has no program.
    pub fn program(&self) -> Result<Program, Error> {
        if let Some(feedback) = self.feedback() {
            return feedback.program();
        }
        let mut program = self.before_the_linear_block()?;
        program.add(self.linear().block("linear", "the linear block: a difference equation"))?;
        let mut state = self.hidden_parts(Block::new("state", "the model: hysteresis, creep, linear dynamics, offset"));
        if self.linear().order() > 0 {
            state = state.part("linear", "linear");
        }
        if self.driver().is_some() {
            state = state.part("driver", "driver");
        }
        let state = if state.fields.is_empty() { state.number("unused", 0.0) } else { state };
        let linear = if self.linear().order() > 0 { "linear(s.linear, crept)" } else { "linear(crept)" };
        let text = format!(
            "
// One sample: the input u to the displacement.
fn step(s: state, u) {{
    let z = {};
    let crept = {};
    return {linear} + offset;
}}
",
            self.hidden_call("", "u"),
            self.creep_call("creep", "z"),
        );
        program.add(state.constant("offset", self.offset()).text(&text))?;
        Ok(program)
    }

    /// The blocks before the linear one, and their inverses.
    pub fn before_the_linear_block(&self) -> Result<Program, Error> {
        let mut program = hysteresis::program(self.hysteresis())?;
        inverse(&mut program)?;
        if let Some(driver) = self.driver() {
            let remembers = self.hysteresis().order() > 0;
            program.add(driver.block(self.ts(), remembers))?;
            inverse_behind_a_driver(&mut program, remembers)?;
        }
        if self.creep().order() > 0 {
            program.add(self.creep().block())?;
        }
        Ok(program)
    }

    /// `block` with the states of hysteresis and creep, if they have any.
    pub fn hidden_parts(&self, block: Block) -> Block {
        let block = if self.hysteresis().order() > 0 { block.part("hysteresis", "hysteresis") } else { block };
        if self.creep().order() > 0 { block.part("creep", "creep") } else { block }
    }

    /// The call that gives z for the input in `arguments`, with the state called `s`; with `_inverse` as `suffix` the
    /// one that gives the input for a z between two ends.
    pub fn hidden_call(&self, suffix: &str, arguments: &str) -> String {
        match (self.hysteresis().order() > 0, self.driver().is_some()) {
            (false, false) => format!("hysteresis{suffix}({arguments})"),
            (true, false) => format!("hysteresis{suffix}(s.hysteresis, {arguments})"),
            (false, true) => format!("hidden{suffix}(s.driver, {arguments})"),
            (true, true) => format!("hidden{suffix}(s.hysteresis, s.driver, {arguments})"),
        }
    }

    /// The call of `function` of the creep block for `z`, with the state called `s`; without creep, `z`.
    pub fn creep_call(&self, function: &str, z: &str) -> String {
        if self.creep().order() > 0 { format!("{function}(s.creep, {z})") } else { z.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creep::Creep;
    use crate::driver::DriverModel;
    use crate::hysteresis::OPERATORS;
    use crate::linear::Arx;
    use crate::program::Machine;

    /// A model of an operator, with or without driver, with these numbers of coefficients.
    fn model(operator: usize, driver: Option<DriverModel>, (na, nb): (usize, usize)) -> Model {
        let ts = if driver.is_some() { 5e-4 / DriverModel::SUBSTEPS as f64 } else { 5e-4 };
        let coefficient = |k: usize| 0.5 * (-0.5f64).powi(k as i32);
        let (a, b) = ((0..na).map(coefficient).collect(), (0..nb).map(|k| coefficient(k) + 1.0).collect());
        let hysteresis = (OPERATORS[operator].example)(ts).unwrap();
        let model = Model::from_blocks(driver, hysteresis, Arx::new(5e-4, a, b).unwrap(), -0.7).unwrap();
        if na % 2 == 0 { model } else { model.with_creep(Creep::logarithmic(5e-4, 0.02, 0.01, 1.0).unwrap()).unwrap() }
    }

    #[test]
    fn the_program_of_any_model_is_bit_identical_to_the_model() {
        let drivers = [(1e-4, Some(2e4)), (0.0, Some(2e4)), (1e-4, None), (0.0, None)];
        let drivers = drivers.map(|(lag, slew)| Some(DriverModel::new(lag, slew).unwrap()));
        for operator in 0..OPERATORS.len() {
            for (k, driver) in drivers.into_iter().chain([None]).enumerate() {
                let model = model(operator, driver, [(0, 1), (2, 3), (1, 7), (5, 2), (6, 6)][(k + operator) % 5]);
                let program = model.program().unwrap();
                let mut machine = Machine::new(&program, "state", false);
                let mut x = model.initial();
                if !x.is_empty() {
                    assert_eq!(machine.state(), x);
                }
                for t in 0..300 {
                    let u = 25.0 * (0.07 * f64::from(t / 2)).sin();
                    let y = model.step(&mut x, u);
                    assert_eq!(machine.call("step", &[u]).unwrap()[0].to_bits(), y.to_bits(), "{model:?} at {t}");
                }
            }
        }
    }
}
