//! A feedback model as a system: sample by sample, with a state.

use super::input::Path;
use super::modes::ModeStep;
use super::run::{Coefficients, Motion, Sensed};
use super::{FeedbackDynamics, FeedbackMode, FeedbackModel};
use piezoid_numerics::system::System;
use std::f64::consts::TAU;

/// Periods of the slowest mode, over 2 pi, in which it settles: what is left is 1e-5 at a damping ratio of 1.
const SETTLED: f64 = 15.0;

/// Most samples in which it settles.
const MAX_SETTLING: usize = 100_000;

/// Numbers of the state besides hysteresis, modes, creep and delay: s, H(s), dH/ds, z and the input.
const OTHERS: usize = 5;

impl FeedbackModel {
    /// The response from the state `x`, which is advanced to the end of the run, to an input that is known as a whole:
    /// a band-limited one is interpolated. Any other has the response of [`System::resume`].
    pub fn follow(&self, x: &mut [f64], u: &[f64]) -> Vec<f64> {
        self.advance(&self.coefficients, x, u, true)
    }

    /// The same with other coefficients; sample by sample unless it is known as a `whole`.
    fn advance(&self, of: &Coefficients<f64>, x: &mut [f64], u: &[f64], whole: bool) -> Vec<f64> {
        let (hysteresis, x) = x.split_at_mut(self.hysteresis.order());
        let (modes, x) = x.split_at_mut(2 * of.steps.len());
        let (crept, x) = x.split_at_mut(of.lags.len());
        let (others, delayed) = x.split_at_mut(OTHERS);
        let (modes, _) = modes.as_chunks_mut();
        let sensed = Sensed { s: others[0], h: others[1], slope: others[2] };
        let mut motion = Motion { modes, crept, sensed, z: others[3], before: others[4] };
        let path = Path::new(self, u, motion.before, whole);
        let is_at_rest = motion.modes.iter().all(|x| *x == [0.0; 2]);
        let mut path = if is_at_rest { path.at_rest() } else { path };
        let mut y = delayed.to_vec();
        while let Some(stretch) = path.next_sample() {
            y.push(motion.advance(of, stretch, &mut |s| self.hysteresis.step(hysteresis, s)));
        }
        let Sensed { s, h, slope } = motion.sensed;
        others.copy_from_slice(&[s, h, slope, motion.z, motion.before]);
        delayed.copy_from_slice(&y.split_off(u.len()));
        y
    }

    /// The state after the inputs `u`, from rest, if all modes were damped and creep was fast: slow movement, whatever
    /// the rate of `u`. It is settled at the last one.
    pub(crate) fn after_slow(&self, u: &[f64]) -> Vec<f64> {
        let FeedbackDynamics { modes, substeps, .. } = &self.dynamics;
        let damped = |mode: &FeedbackMode| ModeStep::new(mode.hz * TAU, 1.0, self.ts / *substeps as f64);
        let mut slow = Coefficients { steps: modes.iter().map(damped).collect(), ..self.coefficients.clone() };
        slow.lags.iter_mut().for_each(|(stays, _)| *stays = 0.0);
        let slowest = modes.iter().map(|mode| mode.hz).fold(f64::INFINITY, f64::min);
        let settling = ((SETTLED / (TAU * slowest) / self.ts).ceil() as usize).saturating_add(self.dynamics.delay + 1);
        let last = u.last().copied().unwrap_or_default();
        let mut inputs: Vec<f64> = u.to_vec();
        inputs.resize(u.len() + settling.min(MAX_SETTLING), last);
        let mut x = self.initial();
        self.advance(&slow, &mut x, &inputs, false);
        let (modes, _) = x[self.hysteresis.order()..].as_chunks_mut();
        modes.iter_mut().zip(&self.coefficients.steps).for_each(|(x, step)| *x = step.resting(x[0]));
        x
    }
}

impl FeedbackModel {
    /// s, H(s) and z after each sample of `u`, from rest.
    pub fn trace(&self, u: &[f64]) -> Vec<[f64; 3]> {
        let mut x = self.initial();
        let others = x.len() - self.dynamics.delay - OTHERS;
        let of = |u: &f64| {
            self.step(&mut x, *u);
            [x[others], x[others + 1], x[others + 3]]
        };
        u.iter().map(of).collect()
    }
}

/// State: hysteresis; p and step times p' of each mode; creep; s, H(s), dH/ds, z, the input behind the driver; the
/// readings to come. A band-limited input moves along straight lines here, because its next samples are unknown.
impl System for FeedbackModel {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        let FeedbackDynamics { modes, creep, delay, .. } = &self.dynamics;
        self.hysteresis.order() + 2 * modes.len() + creep.len() + OTHERS + delay
    }

    fn initial(&self) -> Vec<f64> {
        let mut x = self.hysteresis.initial();
        let before = x.len();
        x.resize(self.order() - self.dynamics.delay, 0.0);
        let h = self.hysteresis.step(&mut x[..before], 0.0);
        let others = x.len() - OTHERS;
        (x[others + 1], x[others + 3]) = (h, h);
        x.resize(self.order(), self.coefficients.reading(self.dynamics.direct[1] * h));
        x
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        self.after_slow(&[u])
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        let mut signal = [u];
        self.respond(x, &mut signal);
        signal[0]
    }

    fn respond(&self, x: &mut [f64], signal: &mut [f64]) {
        let y = self.advance(&self.coefficients, x, signal, false);
        signal.copy_from_slice(&y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creep::Lag;
    use crate::driver::DriverModel;
    use crate::feedback::Intersample;
    use crate::hammerstein::{InitialCondition, Model};
    use crate::hysteresis::OPERATORS;
    use crate::linear::Arx;
    use crate::program::Machine;
    use piezoid_testing::assert_close;

    /// Models of all operators that may be in feedback, with each kind of input.
    fn models() -> Vec<FeedbackModel> {
        let driver = DriverModel::new(1e-4, Some(2e4)).unwrap();
        let intersample = [Intersample::Held, Intersample::Driven(driver), Intersample::BandLimited];
        let mode =
            |hz, sensed| FeedbackMode { hz, damping: 0.05, input: 0.5, hysteretic: 0.9, sensed, softening: 1e-3 };
        let of = |(k, row): (usize, &&crate::hysteresis::Operator)| {
            let dynamics = FeedbackDynamics {
                substeps: 4,
                intersample: intersample[k % 3],
                delay: k % 4,
                modes: vec![mode(160.0, -0.01), mode(700.0, 0.0)],
                senses_vibration: k % 2 == 0,
                direct: [0.1, 0.2],
                creep: vec![Lag { tau_s: 0.02, gain: 0.05 }; usize::from(k % 4 < 2)],
                curve: 1e-4,
                offset: 3.0,
                ..FeedbackDynamics::default()
            };
            FeedbackModel::new(5e-4, dynamics, (row.example)(1e-4).unwrap()).unwrap()
        };
        OPERATORS.iter().filter(|row| row.rate_independent).enumerate().map(of).collect()
    }

    fn wave(n: usize) -> Vec<f64> {
        (0..n).map(|t| 15.0 * (0.05 * t as f64).sin() + 5.0 * (0.173 * t as f64).sin()).collect()
    }

    #[test]
    fn a_run_is_bit_identical_to_its_steps() {
        for model in models() {
            let (mut x, u) = (model.initial(), wave(300));
            assert_eq!((x.len(), model.settled(3.0).len()), (model.order(), model.order()));
            let stepped: Vec<f64> = u.iter().map(|u| model.step(&mut x, *u)).collect();
            assert_eq!(model.simulate(&u), stepped, "{model:?}");
            if model.dynamics().intersample != Intersample::BandLimited {
                assert_eq!(model.follow(&mut model.initial(), &u), stepped);
            }
        }
    }

    #[test]
    fn the_program_is_bit_identical_to_the_steps() {
        for model in models() {
            let program = model.program().unwrap();
            let (mut machine, mut x) = (Machine::new(&program, "state", false), model.initial());
            assert_eq!(machine.state(), x);
            for (t, u) in wave(200).into_iter().enumerate() {
                let y = model.step(&mut x, u);
                assert_eq!(machine.call("step", &[u]).unwrap()[0].to_bits(), y.to_bits(), "{model:?} at {t}");
            }
            assert_eq!(machine.state(), x);
        }
    }

    #[test]
    fn a_model_that_has_it_responds_as_it_does_also_after_its_file() {
        let blocks = Model::new((OPERATORS[0].example)(5e-4).unwrap(), Arx::gain(5e-4, 2.0).unwrap(), 1.0).unwrap();
        for feedback in models() {
            let model = blocks.clone().with_feedback(feedback.clone()).unwrap();
            let again = Model::from_json(&model.to_json()).unwrap();
            assert_eq!(again.to_json(), model.to_json());
            assert_eq!(again.simulate(&wave(200)), feedback.simulate(&wave(200)));
            assert_eq!(again.without_feedback(), blocks);
            for before in InitialCondition::of(&wave(200)) {
                let y = again.follow(&mut again.before(&wave(200), before), &wave(200));
                assert!(y.iter().all(|y| y.abs() < 100.0), "{before:?}: {y:?}");
            }
            // Errors of a free run that are measured are predicted, as far as the linear block lets them last.
            let y: Vec<f64> = feedback.follow(&mut feedback.initial(), &wave(200)).iter().map(|y| y + 1.0).collect();
            assert_close(
                &again.predict(&wave(200), &y).unwrap(),
                &y.iter().map(|y| y - 1.0).collect::<Vec<_>>(),
                1e-12,
                1e-9,
            );
        }
    }

    #[test]
    fn a_run_that_begins_at_rest_is_that_of_a_search() {
        // A search interpolates a band-limited input also before its first sample.
        for model in models().iter().filter(|model| model.dynamics().intersample != Intersample::BandLimited) {
            // An input that is 0 before its first sample too.
            let u = [&[0.0], &wave(300)[..]].concat();
            assert_eq!(model.follow(&mut model.initial(), &u), model.simulate_from(&[], &u), "{model:?}");
        }
    }

    #[test]
    fn a_settled_model_stays_where_it_is() {
        // The two branches change with each direction, however little a mode moves.
        for model in models().iter().filter(|model| model.hysteresis.operator().name != "two-branch") {
            let y = model.resume(&mut model.settled(12.0), &[12.0; 400]);
            assert_close(&y, &[y[0]; 400], 3e-6, 0.0);
        }
    }
}
