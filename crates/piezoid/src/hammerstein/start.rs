//! How a record begins, which its input alone tells.

use super::Model;
use crate::series::{ends, mean};
use crate::system::System;

/// Share of its range by which an input counts as having moved, or as being off zero.
const MOVED: f64 = 0.02;

/// Whether a record with inputs `u` begins in motion: off zero, and moving as it does on average. An input stands where it
/// has not moved by a fiftieth of its range in the time in which on average it moves a fifth.
pub(super) fn in_motion(u: &[f64]) -> bool {
    let (low, high) = ends(u.iter().copied());
    let least = MOVED * (high - low);
    let path: f64 = u.windows(2).map(|w| (w[1] - w[0]).abs()).sum();
    let a_fifth = 0.2 * (high - low) * (u.len() - 1) as f64 / path;
    let soon = (a_fifth as usize).clamp(1, u.len().max(2) - 1);
    u[0].abs() > least && u.iter().take(soon + 1).any(|v| (v - u[0]).abs() > least)
}

/// What the actuator did before a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Beginning {
    /// It was at rest, and jumped to the first input.
    Rest,
    /// It went to the first input and settled there.
    Settled,
    /// The same as in the record: it was in motion.
    Motion,
}

impl Beginning {
    /// All, those first that the inputs `u` of a record make likely.
    pub fn of(u: &[f64]) -> [Self; 3] {
        use Beginning::{Motion, Rest, Settled};
        if in_motion(u) { [Motion, Settled, Rest] } else { [Settled, Rest, Motion] }
    }
}

impl Model {
    /// The state before the first of the inputs `u`, if the record began like this. Of a record that began in motion, what
    /// the hysteresis remembers and where creep stands come from a run over the record; the linear block, which forgets
    /// soon, settles at its first input.
    pub fn before(&self, u: &[f64], beginning: Beginning) -> Vec<f64> {
        let Some(&first) = u.first() else { return self.initial() };
        match beginning {
            Beginning::Rest => self.initial(),
            Beginning::Settled => self.settled(first),
            Beginning::Motion => {
                let mut x = self.settled(first);
                let [hysteresis, creep, linear, driver] = self.parts(&mut x);
                let z: Vec<f64> = u.iter().map(|&u| self.hidden(hysteresis, driver, u)).collect();
                creep.copy_from_slice(&self.creep().settled(mean(&z)));
                z.iter().for_each(|&z| _ = self.creep().step(creep, z));
                let z = self.hidden(&mut hysteresis.to_vec(), &mut driver.to_vec(), first);
                let crept = self.creep().step(&mut creep.to_vec(), z);
                linear.copy_from_slice(&self.linear().settled(crept));
                x
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creep::Creep;
    use crate::hysteresis::OPERATORS;
    use crate::linear::Arx;
    use std::f64::consts::TAU;

    fn sine(bias: f64, phase: f64) -> Vec<f64> {
        (0..2000).map(|t| bias + 10.0 * (TAU * f64::from(t) / 200.0 + phase).sin()).collect()
    }

    #[test]
    fn a_cut_from_a_running_sine_is_in_motion_and_what_starts_from_zero_or_stands_is_not() {
        assert!(in_motion(&sine(50.0, 0.0)) && in_motion(&sine(0.0, 1.0)));
        assert!(!in_motion(&sine(0.0, 0.0)), "from zero");
        let held: Vec<f64> = [7.0; 300].into_iter().chain(sine(7.0, 0.0)).collect();
        assert!(!in_motion(&held) && !in_motion(&[3.0; 50]) && !in_motion(&[3.0]));
    }

    #[test]
    fn creep_of_what_is_in_motion_stands_at_the_mean_of_its_inputs() {
        let arx = Arx::gain(1e-3, 2.0).unwrap();
        let creep = Creep::logarithmic(1e-3, 0.05, 1.0, 100.0).unwrap();
        let model = Model::new((OPERATORS[0].example)(1e-3).unwrap(), arx, 0.0).unwrap().with_creep(creep).unwrap();
        // At its top when it begins; creep has long settled at the middle, 50.
        let u = sine(50.0, TAU / 4.0);
        let first = |beginning| mean(&model.resume(&mut model.before(&u, beginning), &u)[..200]);
        let [motion, settled, rest] = Beginning::of(&u).map(first);
        crate::testing::assert_close(&[motion], &[50.0 * 1.1 * 2.0 * 1.15], 1e-3, 0.0);
        assert!(settled > 1.02 * motion && rest < 0.9 * motion, "{settled} {rest}");
    }
}
