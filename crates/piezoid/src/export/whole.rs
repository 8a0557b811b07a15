//! What is exported, put together: the program, what of it is called from outside, and numbers to prove it by.

use super::Wanted;
use crate::compensation::Causal;
use crate::error::Error;
use crate::program::{Counts, Machine, Program};
use crate::series::ends;
use crate::system::System;

/// A program with its interface.
#[derive(Debug, Clone)]
pub struct Whole {
    /// The blocks and functions.
    pub program: Program,
    /// What is called from outside: the model first, then its feed-forward, then the controller.
    pub entries: Vec<Entry>,
    /// Why something is not there, one sentence each.
    pub notes: Vec<String>,
}

/// A state and the function that takes it one sample on.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The function: `step`, `ff_step` or `control_step`.
    pub step: &'static str,
    /// The function that begins anew: `reset`, `ff_reset` or `control_reset`.
    pub reset: &'static str,
    /// The block whose state it is.
    pub state: &'static str,
    /// One line.
    pub about: String,
    /// What it takes.
    pub inputs: Vec<Signal>,
    /// What it gives.
    pub output: Signal,
}

/// A number that passes the interface.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub about: &'static str,
}

/// What an entry answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Vectors {
    /// Its inputs, a row a sample.
    pub inputs: Vec<Vec<f64>>,
    /// Its outputs.
    pub outputs: Vec<f64>,
    /// What a sample takes, on average and at most.
    pub mean: Counts,
    /// The most operations that one sample took.
    pub most: usize,
    /// The largest difference to double precision, over the height of the outputs.
    pub off: f64,
}

/// Samples of the vectors.
pub(super) const SAMPLES: usize = 400;

impl Whole {
    /// The model, its inverse if it has one, and the controller if one is wanted.
    ///
    /// # Errors
    /// [`Error::Unsuited`] of a model or controller that has no program.
    pub fn new(wanted: &Wanted) -> Result<Self, Error> {
        let model = wanted.model;
        let (volts, metres) = (model.units().u.clone(), model.units().y.clone());
        let u = Signal { name: "u", unit: volts.clone(), about: "input" };
        let y = Signal { name: "y", unit: metres.clone(), about: "displacement" };
        let step = Entry {
            step: "step",
            reset: "reset",
            state: "state",
            about: "the model: input to displacement".into(),
            inputs: vec![u.clone()],
            output: y.clone(),
        };
        let mut whole = Whole { program: model.program()?, entries: vec![step], notes: Vec::new() };
        match Causal::new(model, wanted.how, wanted.preview) {
            Err(error) => whole.notes.push(format!("there is no feed-forward: {error}")),
            Ok(causal) => {
                causal.extend(&mut whole.program)?;
                let late = match wanted.preview {
                    0 => String::new(),
                    n => format!(", {n} samples late"),
                };
                whole.entries.push(Entry {
                    step: "ff_step",
                    reset: "ff_reset",
                    state: "ff_state",
                    about: format!("the feed-forward: wanted displacement to input{late}"),
                    inputs: vec![Signal { name: "r", unit: metres.clone(), about: "wanted displacement" }],
                    output: u.clone(),
                });
            }
        }
        if let Some(controller) = wanted.controller {
            let unsuited = || {
                let because =
                    "it plans anew in every sample, which is not exported; take one with a law, such as pi".into();
                Error::Unsuited { what: "exported controller".into(), because }
            };
            for block in controller.blocks().ok_or_else(unsuited)? {
                whole.program.add(block)?;
            }
            let about = whole.program.blocks.last().map_or(String::new(), |block| block.about.clone());
            whole.entries.push(Entry {
                step: "control_step",
                reset: "control_reset",
                state: "control_state",
                about: format!("the controller: {about}"),
                inputs: vec![
                    Signal { name: "r", unit: metres.clone(), about: "what was wanted when y was read" },
                    Signal { name: "y", unit: metres, about: "the last reading of the displacement" },
                    Signal { name: "feed", unit: volts, about: "the feed-forward of this sample, or 0" },
                ],
                output: u,
            });
        }
        let kept: Vec<&str> = whole.entries.iter().map(|entry| entry.step).collect();
        whole.program.keep(&kept);
        Ok(whole)
    }

    /// What each entry answers to inputs that wander through what the model knows; in single precision, what that gives.
    ///
    /// # Errors
    /// What a program cannot do.
    pub fn vectors(&self, wanted: &Wanted) -> Result<Vec<Vectors>, Error> {
        let model = wanted.model;
        let known = model.identified().map(|known| (known.u[0], known.u[1])).or(model.hysteresis().range());
        let u = wander(known.unwrap_or((-1.0, 1.0)), SAMPLES);
        let y = model.simulate(&u);
        let inputs = |entry: &Entry| match entry.step {
            "step" => u.iter().map(|u| vec![*u]).collect::<Vec<_>>(),
            "ff_step" => y.iter().map(|r| vec![*r]).collect(),
            // As if the actuator followed a fifth too far, and the feed-forward were the input.
            _ => y.iter().zip(&u).map(|(r, u)| vec![*r, 1.2 * r, *u]).collect(),
        };
        self.entries.iter().map(|entry| self.answers(entry, inputs(entry), wanted.single)).collect()
    }

    fn answers(&self, entry: &Entry, inputs: Vec<Vec<f64>>, single: bool) -> Result<Vectors, Error> {
        let run = |single: bool| {
            let mut machine = Machine::new(&self.program, entry.state, single);
            let (mut outputs, mut most, mut before) = (Vec::with_capacity(inputs.len()), 0, 0);
            for input in &inputs {
                outputs.push(machine.call(entry.step, input)?[0]);
                let total = machine.counts.total();
                (most, before) = (most.max(total - before), total);
            }
            Ok::<_, Error>((outputs, machine.counts, most))
        };
        let (exact, counts, most) = run(false)?;
        let outputs = if single { run(true)?.0 } else { exact.clone() };
        let (low, high) = ends(exact.iter().copied());
        let off = outputs.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / (high - low);
        let n = inputs.len();
        let mean = Counts {
            sums: counts.sums / n,
            products: counts.products / n,
            quotients: counts.quotients / n,
            comparisons: counts.comparisons / n,
        };
        Ok(Vectors { inputs, outputs, mean, most, off })
    }
}

/// Two turns of different speed, within 95 % of these ends: sums and products alone, for the same bits on every machine.
pub(super) fn wander((low, high): (f64, f64), n: usize) -> Vec<f64> {
    let turned = |(c, s): (f64, f64), (x, y): (f64, f64)| (c * x - s * y, s * x + c * y);
    // Steps of 0.13 and 0.0481 rad.
    let (quick, slow) = ((0.9915618937147881, 0.12963414261969486), (0.9988434179553187, 0.04808145522014453));
    let (mut a, mut b) = ((1.0, 0.0), (1.0, 0.0));
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    (0..n)
        .map(|_| {
            (a, b) = (turned(quick, a), turned(slow, b));
            middle + half * (0.35 * a.1 + 0.6 * b.1)
        })
        .collect()
}
