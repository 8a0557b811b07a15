//! A plant with a sampling period of its own, in the cycles of a controller.
//!
//! ```text
//! y(t) = y_k + (y_(k+1) - y_k) (t - t_k) / ts
//! ```
//! y_k is its response to the voltage at its sample k, y_(k+1) that of the next sample if the voltage is held. After a
//! rest, samples are counted from the first change of the voltage: all records of a drive then have the same delay. It
//! does not do: voltages between two samples, which the plant does not see.

use super::{COARSE, CYCLE};
use piezoid::control::SimulatedActuator;
use piezoid::{Error, System, Units};
use std::sync::Arc;

/// Time without a change of the voltage after which the next change begins a sample [s].
const REST: f64 = 0.05;

/// Share of a sample that is rounding.
const ROUNDING: f64 = 1e-6;

/// The plant [V, um] every servo cycle, and every [`COARSE`] cycles; both have the same states.
///
/// # Errors
/// Returns an error for a plant whose output is no length, and the errors of [`SimulatedActuator::played`].
pub(super) fn plants(actuator: &SimulatedActuator, seed: u64) -> Result<[Box<dyn System>; 2], Error> {
    let coarse = COARSE as f64 * CYCLE;
    let Some(ts) = actuator.period() else {
        return Ok([actuator.played(CYCLE, seed)?.0, actuator.played(coarse, seed)?.0]);
    };
    let (plant, unit) = actuator.played(ts, seed)?;
    let expected = "a length: m, mm, um or nm, as controllers state positions";
    let factor =
        Units::factor(&unit, "um").ok_or_else(|| Error::units("the output of the stand-in", &unit, expected))?;
    let plant: Arc<dyn System> = plant.into();
    Ok([CYCLE, coarse].map(|cycle| -> Box<dyn System> { Box::new(Clocked { plant: plant.clone(), factor, cycle }) }))
}

/// Such a plant. State: time since the last sample [s], time without a change of the voltage [s], last voltage [V],
/// displacement at the last sample and at the next one [unit of the plant]; then the state of the plant.
#[derive(Debug)]
struct Clocked {
    plant: Arc<dyn System>,
    /// Micrometres in a unit of the plant.
    factor: f64,
    /// Time of a step [s].
    cycle: f64,
}

const AGE: usize = 0;
const STILL: usize = 1;
const VOLTAGE: usize = 2;
const LAST: usize = 3;
const NEXT: usize = 4;
const HEAD: usize = 5;

impl Clocked {
    /// The state in which the next step is a sample, with this state of the plant.
    fn beginning(&self, voltage: f64, plant: Vec<f64>) -> Vec<f64> {
        let mut x = vec![0.0; HEAD];
        (x[AGE], x[STILL], x[VOLTAGE]) = ((self.plant.ts() - self.cycle).max(0.0), REST, voltage);
        x.extend(plant);
        x
    }
}

impl System for Clocked {
    fn ts(&self) -> f64 {
        self.cycle
    }

    fn order(&self) -> usize {
        HEAD + self.plant.order()
    }

    fn initial(&self) -> Vec<f64> {
        self.beginning(0.0, self.plant.initial())
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        self.beginning(u, self.plant.settled(u))
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        let (ts, (head, state)) = (self.plant.ts(), x.split_at_mut(HEAD));
        let moves = u != head[VOLTAGE];
        head[AGE] += self.cycle;
        if moves && head[STILL] >= REST {
            head[AGE] = head[AGE].max(ts);
        }
        let samples = (head[AGE] / ts + ROUNDING).floor();
        if samples >= 1.0 {
            (0..samples as u64).for_each(|_| head[LAST] = self.plant.step(state, u));
            head[NEXT] = self.plant.step(&mut state.to_vec(), u);
            head[AGE] = (head[AGE] - samples * ts).max(0.0);
        }
        head[STILL] = if moves { 0.0 } else { head[STILL] + self.cycle };
        head[VOLTAGE] = u;
        self.factor * (head[LAST] + head[AGE] / ts * (head[NEXT] - head[LAST]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    /// y_k = 0.5 y_(k-1) + u_(k-1), every 1 ms, in mm.
    #[derive(Debug)]
    struct Lag;

    impl System for Lag {
        fn ts(&self) -> f64 {
            1e-3
        }

        fn order(&self) -> usize {
            2
        }

        fn step(&self, x: &mut [f64], u: f64) -> f64 {
            let y = 0.5 * x[0] + x[1];
            (x[0], x[1]) = (y, u);
            y
        }
    }

    fn every(cycle: f64) -> Clocked {
        Clocked { plant: Arc::new(Lag), factor: 1e3, cycle }
    }

    #[test]
    fn at_its_samples_it_is_the_plant_and_between_them_a_straight_line() {
        let plant = every(1e-4);
        let u: Vec<f64> = (0..500).map(|k| f64::from(k / 10 % 7)).collect();
        let y = plant.resume(&mut plant.settled(0.0), &u);
        let at_samples: Vec<f64> = u.iter().step_by(10).copied().collect();
        let expected = Lag.resume(&mut Lag.settled(0.0), &at_samples);
        for (k, part) in y.chunks(10).enumerate().take(49) {
            let line = |j: usize| 1e3 * (expected[k] + 0.1 * j as f64 * (expected[k + 1] - expected[k]));
            assert_close(part, &(0..10).map(line).collect::<Vec<_>>(), 0.0, 1e-6);
        }
    }

    #[test]
    fn after_a_rest_a_drive_has_the_same_delay_whenever_it_begins() {
        let plant = every(1e-4);
        let response = |rest: usize| {
            let mut x = plant.settled(0.0);
            plant.resume(&mut x, &vec![0.0; rest]);
            plant.resume(&mut x, &[1.0; 60])
        };
        let first = response(600);
        for rest in [601, 604, 609, 1003] {
            assert_close(&response(rest), &first, 0.0, 1e-9);
        }
        // Without a rest the plant sees the voltage at its own sample.
        assert_ne!(response(104), first);
    }

    #[test]
    fn a_coarse_step_is_all_samples_in_it() {
        let (fine, coarse) = (every(1e-4), every(0.1));
        let mut x = fine.settled(0.0);
        fine.resume(&mut x, &[3.0; 7]);
        let mut same = x.clone();
        let expected = *fine.resume(&mut x, &[3.0; 1000]).last().unwrap();
        assert_close(&[coarse.step(&mut same, 3.0)], &[expected], 1e-9, 0.0);
        assert_close(&same, &x, 1e-6, 1e-9);
    }
}
