//! The initial condition of a record.
//!
//! Why: docs/decisions/initial-conditions.md, "Six initial conditions are tried, and the one used is named".

use super::Model;
use piezoid_numerics::series::{ends, mean};
use piezoid_numerics::system::System;
use piezoid_records::waveform::{in_motion, inputs_before};
use std::f64::consts::TAU;

/// The state of the actuator before a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InitialCondition {
    /// At rest; it jumps to the first input.
    Rest,
    /// Settled at the first input.
    Settled,
    /// Settled at the first input, after cycles over the whole range that ended with a fall from its top.
    FromAbove,
    /// Settled at the first input, after cycles over the whole range that ended with a rise from its bottom.
    FromBelow,
    /// Settled at the first input, after a decaying sine about it.
    Demagnetised,
    /// In motion, as in the record.
    Motion,
}

/// Samples of a sweep from one end of the range to the other.
const SWEEP: usize = 100;

/// Periods of a decaying sine, and samples of each.
const PERIODS: usize = 25;
const PERIOD: usize = 40;

impl InitialCondition {
    /// All, in order of likelihood for the inputs `u` of a record.
    pub fn of(u: &[f64]) -> [Self; 6] {
        use InitialCondition::{Demagnetised, FromAbove, FromBelow, Motion, Rest, Settled};
        if in_motion(u) {
            [Motion, Settled, FromBelow, FromAbove, Demagnetised, Rest]
        } else {
            [Settled, Rest, FromBelow, FromAbove, Demagnetised, Motion]
        }
    }

    /// The inputs before those of a record, `u`, from rest; `range` are the lowest and the highest input.
    pub fn inputs_before(self, u: &[f64], (low, high): (f64, f64)) -> Vec<f64> {
        let first = u.first().copied().unwrap_or_default();
        let sweep = |through: [f64; 3]| {
            let ramp = |ends: &[f64]| {
                let [from, to] = [ends[0], ends[1]];
                (0..=SWEEP).map(move |k| from + (to - from) * k as f64 / SWEEP as f64)
            };
            through.windows(2).flat_map(ramp).collect()
        };
        match self {
            InitialCondition::Rest => vec![0.0],
            InitialCondition::Settled => vec![first],
            InitialCondition::FromAbove => sweep([low, high, first]),
            InitialCondition::FromBelow => sweep([high, low, first]),
            InitialCondition::Demagnetised => {
                let amplitude = (first - low).min(high - first).max(0.0);
                let decaying = |t: usize| {
                    let left = 1.0 - t as f64 / (PERIODS * PERIOD) as f64;
                    first + amplitude * left * libm::sin(TAU * ((t % PERIOD) as f64 / PERIOD as f64))
                };
                (0..=PERIODS * PERIOD).map(decaying).collect()
            }
            InitialCondition::Motion => inputs_before(u),
        }
    }
}

impl Model {
    /// The state before the first of the inputs `u` for this initial condition. In motion it is the state after the
    /// probable inputs before the record; z is shifted by the effect of the difference between the first input and the
    /// expected one. The range is [`Model::known_inputs`].
    pub fn before(&self, u: &[f64], initial_condition: InitialCondition) -> Vec<f64> {
        let Some(&first) = u.first() else { return self.initial() };
        let range = || self.known_inputs().unwrap_or_else(|| ends(u.iter().copied()));
        if let Some(feedback) = self.feedback() {
            return match initial_condition {
                InitialCondition::Rest => feedback.initial(),
                InitialCondition::Motion => {
                    let mut x = feedback.settled(mean(u));
                    feedback.follow(&mut x, &inputs_before(u));
                    x
                }
                _ => feedback.after_slow(&initial_condition.inputs_before(u, range())),
            };
        }
        match initial_condition {
            InitialCondition::Rest => self.initial(),
            InitialCondition::Settled => self.settled(first),
            InitialCondition::FromAbove | InitialCondition::FromBelow | InitialCondition::Demagnetised => {
                let mut z = initial_condition.inputs_before(u, range());
                let mut x = self.settled(z[0]);
                let [hysteresis, creep, linear, driver] = self.parts(&mut x);
                self.hidden(hysteresis, driver, &mut z);
                let last = z[z.len() - 1];
                creep.copy_from_slice(&self.creep().settled(last));
                let crept = self.creep().step(&mut creep.to_vec(), last);
                linear.copy_from_slice(&self.linear().settled(crept));
                x
            }
            InitialCondition::Motion => {
                let mut x = self.settled(first);
                let [hysteresis, creep, linear, driver] = self.parts(&mut x);
                let mut z = inputs_before(u);
                self.hidden(hysteresis, driver, &mut z);
                creep.copy_from_slice(&self.creep().settled(mean(&z[..u.len()])));
                self.creep().respond(creep, &mut z);
                let next = |u: f64| {
                    let (mut next, mut creep) = ([u], creep.to_vec());
                    self.hidden(&mut hysteresis.to_vec(), &mut driver.to_vec(), &mut next);
                    self.creep().respond(&mut creep, &mut next);
                    next[0]
                };
                let over = next(first) - next(u[z.len() - u.len()]);
                z.iter_mut().for_each(|z| *z += over);
                linear.copy_from_slice(&self.linear().settled(z[0]));
                self.linear().respond(linear, &mut z);
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

    fn sine(bias: f64, phase: f64) -> Vec<f64> {
        (0..2000).map(|t| bias + 10.0 * (TAU * f64::from(t) / 200.0 + phase).sin()).collect()
    }

    #[test]
    fn creep_of_an_actuator_in_motion_is_at_the_mean_of_its_inputs() {
        let arx = Arx::gain(1e-3, 2.0).unwrap();
        let creep = Creep::logarithmic(1e-3, 0.05, 1.0, 100.0).unwrap();
        let model = Model::new((OPERATORS[0].example)(1e-3).unwrap(), arx, 0.0).unwrap().with_creep(creep).unwrap();
        // It starts at its maximum; creep is settled at the mean, 50.
        let u = sine(50.0, TAU / 4.0);
        let first = |initial_condition| mean(&model.resume(&mut model.before(&u, initial_condition), &u)[..200]);
        let [motion, settled, .., rest] = InitialCondition::of(&u).map(first);
        piezoid_testing::assert_close(&[motion], &[50.0 * 1.1 * 2.0 * 1.15], 1e-3, 0.0);
        assert!(settled > 1.02 * motion && rest < 0.9 * motion, "{settled} {rest}");
    }

    /// A sum of plays that was demagnetised about 20 has turned at no voltage above it without one below it: its z lies
    /// between those after a rise and after a fall, where a loop about 20 is centred.
    #[test]
    fn a_demagnetised_hysteresis_is_in_the_middle_of_its_loop() {
        let row = OPERATORS.iter().find(|row| row.name == "prandtl-ishlinskii").unwrap();
        let model = Model::new((row.example)(1e-3).unwrap(), Arx::gain(1e-3, 1.0).unwrap(), 0.0).unwrap();
        let domain = super::super::Domain { u: [0.0, 40.0], hz: None, slew: 0.0, mean: [0.0, 40.0] };
        let model = model.with_identified(domain);
        let y = |initial_condition| model.resume(&mut model.before(&[20.0], initial_condition), &[20.0])[0];
        let [above, below, middle, settled] = [
            InitialCondition::FromAbove,
            InitialCondition::FromBelow,
            InitialCondition::Demagnetised,
            InitialCondition::Settled,
        ]
        .map(y);
        let width = above - below;
        piezoid_testing::assert_close(&[middle], &[0.5 * (above + below)], 0.0, 0.03 * width);
        assert!(width > 0.0 && (settled - middle).abs() > 0.1 * width, "{above} {below} {settled}");
    }
}
