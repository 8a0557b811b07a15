//! Operations per sample of a model, so that programs that run models often can refuse a slow one in advance.

use super::Model;
use crate::program::Machine;
use piezoid_numerics::error::Error;

/// Samples that are tried: one pass through the range, up and down.
const TRIED: usize = 16;

impl Model {
    #[doc(hidden)]
    /// Operations of a sample, counted on the program of the model: the same on every machine.
    ///
    /// # Errors
    /// The errors of [`Model::program`].
    pub fn effort(&self) -> Result<f64, Error> {
        let program = self.program()?;
        let mut machine = Machine::new(&program, "state", false);
        let (low, high) = self.known_inputs().unwrap_or((-1.0, 1.0));
        for t in 0..TRIED {
            let way = 2.0 * t as f64 / TRIED as f64;
            machine.call("step", &[low + (high - low) * way.min(2.0 - way)])?;
        }
        Ok(machine.counts.total() as f64 / TRIED as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::OPERATORS;
    use crate::linear::Arx;

    #[test]
    fn the_effort_rises_with_the_order_and_is_small_for_all_default_sizes() {
        for o in OPERATORS {
            let effort = |n: usize| {
                let block = Arx::new(5e-4, vec![0.0; n], vec![1.0]).unwrap();
                Model::new((o.example)(5e-4).unwrap(), block, 0.0).unwrap().effort().unwrap()
            };
            assert!(effort(1) < 5000.0, "{}: {}", o.name, effort(1));
            assert!(effort(300) >= effort(100) + 200.0, "{}", o.name);
        }
    }
}
