//! A feedback model as a program: the step of its [state](super::state), in the same order.

use super::run::{Coefficients, LEAST};
use super::{FeedbackModel, Intersample};
use crate::hysteresis;
use crate::program::{Block, Program};
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;

impl FeedbackModel {
    /// The program: a block `state`, and a function `step(s: state, u)`, in which a band-limited input moves along
    /// straight lines; the inverse of the hysteresis if the input drives it.
    ///
    /// # Errors
    /// [`Error::Unsuited`] if the operator has no program.
    pub fn program(&self) -> Result<Program, Error> {
        let remembers = self.hysteresis.order() > 0;
        let mut program = hysteresis::program(&*self.hysteresis)?;
        if self.dynamics.sensed != 0.0 {
            hysteresis::inverse(&mut program)?;
        }
        let block = Block::new("state", "the model: modes with hysteresis in feedback");
        let block = if remembers { block.part("hysteresis", "hysteresis") } else { block };
        let block = self.constants(self.fields(block));
        let h = self.ts / self.dynamics.substeps as f64;
        let (block, start, end) = match self.dynamics.intersample {
            Intersample::Held => (block, "u", "u".into()),
            Intersample::Driven(driver) => {
                let (block, voltage) = driver.stepped(block, h, "s.before");
                (block, "s.before", voltage)
            }
            Intersample::BandLimited => (block, "s.before", "s.before + share".into()),
        };
        let hysteresis = if remembers { "hysteresis(s.hysteresis, next)" } else { "hysteresis(next)" };
        let vibrates = self.dynamics.senses_vibration;
        let interpolates = self.dynamics.intersample == Intersample::BandLimited;
        let creeps = !self.dynamics.creep.is_empty();
        let text =
            [SENSE, if creeps { CREPT } else { "" }, PUSH, STEP, if self.dynamics.delay > 0 { DELAYED } else { READ }]
                .concat();
        let text = text
            .replace("JUMP", if self.dynamics.sensed != 0.0 { JUMP } else { "" })
            .replace("SHARE", if interpolates { "let share = (u - s.before) / in_sample;" } else { "" })
            .replace("THROUGH", if vibrates { "(s.mode[2 * i] - b[i] * u - e[i] * s.z)" } else { "s.mode[2 * i]" })
            .replace("SOLVE", if vibrates { SOLVE } else { "" })
            .replace("SLOPE", if vibrates { SLOPE } else { "" })
            .replace("HYSTERESIS", hysteresis)
            .replace("HERE", if creeps { "let h = s.h;" } else { "" })
            .replace("CREEPS", if creeps { CREEPS } else { "" })
            .replace("WITH_CREEP", if creeps { " + crept(s)" } else { "" })
            .replace("START", start)
            .replace("END", &end);
        program.add(block.text(&text))?;
        Ok(program)
    }

    /// The state after that of the hysteresis.
    fn fields(&self, block: Block) -> Block {
        let at_rest = &self.initial()[self.hysteresis.order()..];
        let (modes, creep) = (self.dynamics.modes.len(), self.dynamics.creep.len());
        let others = 2 * modes + creep;
        let mut block = block.numbers("mode", vec![0.0; 2 * modes]).numbers("lag", vec![0.0; creep]);
        for (name, value) in ["sensed", "h", "slope", "z", "before"].iter().zip(&at_rest[others..]) {
            block = block.number(name, *value);
        }
        block.numbers("delayed", at_rest[at_rest.len() - self.dynamics.delay..].to_vec())
    }

    fn constants(&self, block: Block) -> Block {
        let Coefficients { steps, coupled, sensed, returned, direct, curve, offset, lags, delay, .. } =
            &self.coefficients;
        let matrix = |row: usize, column: usize| steps.iter().map(|step| step.matrix[row][column]).collect::<Vec<_>>();
        let coupling = |k: usize| coupled.iter().map(|of| of[k]).collect::<Vec<_>>();
        let mut block = block;
        for (name, values) in [
            ("m11", matrix(0, 0)),
            ("m12", matrix(0, 1)),
            ("m21", matrix(1, 0)),
            ("m22", matrix(1, 1)),
            ("kick", steps.iter().map(|step| step.kick).collect()),
            ("b", coupling(0)),
            ("e", coupling(1)),
            ("k", coupling(2)),
            ("softening", coupling(3)),
            ("stays", lags.iter().map(|lag| lag.0).collect()),
            ("gain", lags.iter().map(|lag| lag.1).collect()),
        ] {
            block = block.table(name, &values);
        }
        let (vibrates, between) = (self.dynamics.senses_vibration, self.dynamics.intersample);
        for (name, value, is_used) in [
            ("of_input", *sensed, true),
            ("returned", *returned, vibrates),
            ("least_back", LEAST, vibrates),
            ("direct_input", direct[0], true),
            ("direct_z", direct[1], true),
            ("curve", *curve, true),
            ("offset", *offset, true),
            ("in_sample", self.dynamics.substeps as f64, between == Intersample::BandLimited),
        ] {
            block = if is_used { block.constant(name, value) } else { block };
        }
        let counts = [("substeps", self.dynamics.substeps), ("modes", steps.len()), ("lags", lags.len())];
        let block = counts.into_iter().fold(block, |block, (name, n)| block.count(name, n));
        if *delay > 0 { block.count("last", delay - 1) } else { block }
    }
}

const SENSE: &str = "
// Moves the hysteresis to where the input and the modes are.
fn sense_modes(s: state, u) {
    let next = of_input * u;
    for i in 0..modes { next += k[i] * THROUGH; }
    SOLVE
    s.sensed = next;
    s.h = HYSTERESIS;
    SLOPE
}
";

const CREPT: &str = "
// What creep adds.
fn crept(s: state) {
    let sum = 0.0;
    for j in 0..lags { sum += gain[j] * s.lag[j]; }
    return sum;
}
";

const SOLVE: &str = "
    let old = s.sensed;
    let before = s.h;
    let back = 1.0 + returned * s.slope;
    if back < least_back { back = least_back; }
    next = old + (next - old) / back;
";

const SLOPE: &str = "
    let moved = next - old;
    if moved != 0.0 { s.slope = (s.h - before) / moved; }
";

const PUSH: &str = "
// The force of input and hysteresis acts on the modes.
fn push_modes(s: state, u) {
    for i in 0..modes {
        let force = b[i] * u + e[i] * s.z;
        let away = s.mode[2 * i] - force;
        let m = softening[i] * magnitude(away);
        let lost = away * m;
        if m >= 0.0 { lost = away * m / (1.0 + m); }
        s.mode[2 * i + 1] = s.mode[2 * i + 1] + kick[i] * (force + lost);
    }
}
";

const CREEPS: &str = "
    let mean = (h + s.h) * 0.5;
    for j in 0..lags { s.lag[j] = mean + stays[j] * (s.lag[j] - mean); }
";

const JUMP: &str = "
    if start != s.before {
        sense_modes(s, start);
        s.z = s.hWITH_CREEP;
    }
";

const STEP: &str = "
fn move_modes(s: state, start, end) {
    JUMP
    push_modes(s, start);
    for i in 0..modes {
        let p = s.mode[2 * i];
        let q = s.mode[2 * i + 1];
        s.mode[2 * i] = m11[i] * p + m12[i] * q;
        s.mode[2 * i + 1] = m21[i] * p + m22[i] * q;
    }
    HERE
    sense_modes(s, end);
    CREEPS
    s.z = s.hWITH_CREEP;
    push_modes(s, end);
    s.before = end;
}
fn reading(s: state, u) {
    SHARE
    for n in 0..substeps { move_modes(s, START, END); }
    let q = direct_input * s.before + direct_z * s.z;
    for i in 0..modes { q += s.mode[2 * i]; }
    return q + curve * q * q + offset;
}
";

const READ: &str = "
// One sample: the input u to the displacement.
fn step(s: state, u) {
    return reading(s, u);
}
";

const DELAYED: &str = "
// One sample: the input u to the displacement, some samples ago.
fn step(s: state, u) {
    let newest = reading(s, u);
    let y = s.delayed[0];
    for n in 0..last { s.delayed[n] = s.delayed[n + 1]; }
    s.delayed[last] = newest;
    return y;
}
";
