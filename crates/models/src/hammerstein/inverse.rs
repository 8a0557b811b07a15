//! Inversion of the blocks before the linear block (driver, hysteresis and creep), one sample at a time. A state is
//! that of the blocks in series: of a model with mechanics in feedback, take the model [without
//! them](Model::without_feedback).

use super::Model;
use crate::hysteresis::{Inverted, between, with_scratch};
use piezoid_numerics::system::System;

impl Model {
    /// z for the input `u`. In the state `x` hysteresis and driver are updated.
    pub fn step_hidden(&self, x: &mut [f64], u: f64) -> f64 {
        let [hysteresis, _, _, driver] = self.parts(x);
        let mut z = [u];
        self.hidden(hysteresis, driver, &mut z);
        z[0]
    }

    /// The input between `ends` whose next sample has this `z`, or the nearest to it. The state `x` does not change.
    pub fn invert_hidden(&self, x: &[f64], z: f64, ends: (f64, f64)) -> f64 {
        if self.driver.is_none() {
            return self.hysteresis.invert(&x[..self.hysteresis.order()], z, ends).u;
        }
        let found = with_scratch(x.len(), |copy| {
            between(ends, z, |u| {
                copy.copy_from_slice(x);
                self.step_hidden(copy, u)
            })
        });
        found.u
    }

    /// z settled at `u`.
    pub fn settled_hidden(&self, u: f64) -> f64 {
        self.step_hidden(&mut self.settled_blocks(u), u)
    }

    /// The output of creep for the input `u`. The state `x` is updated except for the linear block.
    pub fn step_before_linear(&self, x: &mut [f64], u: f64) -> f64 {
        let z = self.step_hidden(x, u);
        let [_, creep, ..] = self.parts(x);
        self.creep.step(creep, z)
    }

    /// The input between `ends` for which the next output of creep is `requested`, and the actual output. The state `x`
    /// is updated by this input, except for the linear block.
    pub fn invert_before_linear(&self, x: &mut [f64], requested: f64, ends: (f64, f64)) -> Inverted {
        let [_, creep, ..] = self.parts(x);
        let z = self.creep.invert(creep, requested);
        let u = self.invert_hidden(x, z, ends);
        Inverted { u, z: self.step_before_linear(x, u) }
    }

    /// The input between `ends` whose settled output is `y`, or the nearest to it.
    pub fn static_input(&self, y: f64, ends: (f64, f64)) -> f64 {
        self.static_input_before_linear((y - self.offset) / self.linear.dc_gain(), ends).u
    }

    /// The input between `ends` for which the settled output of creep is `requested`, and the actual output.
    pub fn static_input_before_linear(&self, requested: f64, ends: (f64, f64)) -> Inverted {
        between(ends, requested, |u| self.settled_before_linear(u))
    }

    /// The output of creep settled at `u`.
    pub fn settled_before_linear(&self, u: f64) -> f64 {
        self.step_before_linear(&mut self.settled_blocks(u), u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creep::Creep;
    use crate::driver::DriverModel;
    use crate::hysteresis::OPERATORS;
    use crate::linear::Arx;
    use piezoid_testing::assert_close;

    #[test]
    fn the_input_is_found_from_the_output_of_creep_with_and_without_a_driver() {
        let wander = |t: i32| 18.0 * (f64::from(t) * 0.05).sin() + 9.0 * (f64::from(t) * 0.173).sin();
        for o in OPERATORS.iter().filter(|o| o.minor_loops && o.wipes_out) {
            for driver in [None, Some(DriverModel::new(1e-4, Some(6e4)).unwrap())] {
                let ts = 5e-4 / if driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 };
                let linear = Arx::gain(5e-4, 1.0).unwrap();
                let model = Model::from_blocks(driver, (o.example)(ts).unwrap(), linear, 0.0).unwrap();
                let model = model.with_creep(Creep::logarithmic(5e-4, 0.02, 0.01, 1.0).unwrap()).unwrap();
                let (mut there, mut back) = (model.settled(0.0), model.settled(0.0));
                for t in 0..200 {
                    let crept = model.step_before_linear(&mut there, wander(t));
                    let found = model.invert_before_linear(&mut back, crept, (-30.0, 30.0));
                    assert_close(&[found.z, found.u], &[crept, wander(t)], 1e-6, 1e-6);
                }
            }
        }
    }

    #[test]
    fn the_input_that_holds_an_output_gives_that_output_with_the_offset() {
        let plays = (crate::hysteresis::Operator::find("prandtl-ishlinskii").unwrap().example)(5e-4).unwrap();
        let model = Model::new(plays, Arx::new(5e-4, vec![0.6], vec![0.3, 0.2]).unwrap(), 7.0).unwrap();
        for u in [-20.0, 0.0, 11.0] {
            let held = model.resume(&mut model.settled(u), &[u])[0];
            assert_close(&[model.static_input(held, (-30.0, 30.0))], &[u], 1e-6, 1e-6);
        }
    }
}
