//! The blocks from u to z alone, a sample at a time: the driver, if there is one, and the hysteresis.
//!
//! State: that of the hysteresis block, then that of the driver, as [`Model::hidden_call`] takes them.

use super::Model;

impl Model {
    /// The state of hysteresis block and driver at rest.
    pub fn hidden_initial(&self) -> Vec<f64> {
        let mut x = self.hysteresis.initial();
        x.extend(self.driver.iter().flat_map(|_| [0.0; 2]));
        x
    }

    /// Their state after a long time at the constant input `u`.
    pub fn hidden_settled(&self, u: f64) -> Vec<f64> {
        let mut x = self.hysteresis.settled(u);
        let z = self.hysteresis.step(&mut x.clone(), u);
        x.extend(self.driver.iter().flat_map(|_| [u, z]));
        x
    }

    /// One sample: advances their state `x` by the input `u` and returns z.
    pub fn hidden_step(&self, x: &mut [f64], u: f64) -> f64 {
        let (hysteresis, driver) = x.split_at_mut(self.hysteresis.order());
        let mut signal = [u];
        self.hidden(hysteresis, driver, &mut signal);
        signal[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::driver::DriverModel;
    use crate::hysteresis::Operator;
    use crate::linear::Arx;

    #[test]
    fn the_hidden_variable_is_the_input_of_the_linear_block_and_settles() {
        for driver in [None, Some(DriverModel::new(1e-4, Some(2e4)).unwrap())] {
            let ts = if driver.is_some() { 5e-4 / DriverModel::SUBSTEPS as f64 } else { 5e-4 };
            let plays = (Operator::find("stop").unwrap().example)(ts).unwrap();
            let model = Model::from_blocks(driver, plays, Arx::gain(5e-4, 2.0).unwrap(), 1.0).unwrap();
            let u: Vec<f64> = (0..300).map(|t| 25.0 * (f64::from(t) * 0.1).sin()).collect();
            let mut x = model.hidden_initial();
            let z: Vec<f64> = u.iter().map(|&u| model.hidden_step(&mut x, u)).collect();
            assert_eq!(z, model.simulate_before_linear(&u));
            let mut x = model.hidden_settled(12.0);
            let z = model.hidden_step(&mut x, 12.0);
            assert_eq!(model.hidden_step(&mut x, 12.0), z);
        }
    }
}
