//! What is exported, put together: the program, what of it is called from outside, and numbers to prove it by.

use super::Wanted;
use super::vectors::{self, Vectors};
use crate::compensation::{Causal, How, LATEST};
use crate::error::Error;
use crate::number::short;
use crate::program::{Holds, Program};

/// A program with its interface.
#[derive(Debug, Clone)]
pub struct Whole {
    /// The blocks and functions.
    pub program: Program,
    /// What is called from outside: the model first, then its feed-forward, then the controller.
    pub entries: Vec<Entry>,
    /// Why something is not there, and what is worth knowing, one sentence each.
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
    /// Inputs, and what it answers.
    pub vectors: Vectors,
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

/// The longest name of a unit.
const LONGEST_UNIT: usize = 40;

/// Share of the stroke from which on the error of single precision is told.
const NOTED: f64 = 1e-5;

impl Whole {
    /// The model, its inverse if it has one, and the controller if one is wanted.
    ///
    /// # Errors
    /// [`Error::Unsuited`] of a model or controller that has no program.
    pub fn new(wanted: &Wanted) -> Result<Self, Error> {
        let model = wanted.model;
        for (name, unit) in [("u", &model.units().u), ("y", &model.units().y)] {
            if unit.chars().any(char::is_control) || unit.len() > LONGEST_UNIT {
                let rule = format!("must be {LONGEST_UNIT} letters at most, on one line");
                return Err(Error::parameter(format!("units.{name}"), format!("{unit:?}"), rule));
            }
        }
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
            vectors: Vectors::default(),
        };
        let mut whole = Whole { program: model.program()?, entries: vec![step], notes: Vec::new() };
        if wanted.preview > LATEST {
            let rule = format!("must be at most {LATEST} samples");
            return Err(Error::parameter("preview", wanted.preview, rule));
        }
        match Causal::new(model, wanted.how, wanted.preview) {
            // What was asked for is not left out in silence.
            Err(error) if wanted.how != How::default() || wanted.preview > 0 => return Err(error),
            Err(error) => whole.notes.push(format!("there is no feed-forward: {error}")),
            Ok(causal) => {
                causal.extend(&mut whole.program)?;
                let late = match wanted.preview {
                    0 => String::new(),
                    n => format!(", which is to be given {n} samples ahead of time"),
                };
                whole.entries.push(Entry {
                    step: "ff_step",
                    reset: "ff_reset",
                    state: "ff_state",
                    about: format!("the feed-forward: wanted displacement to input{late}"),
                    inputs: vec![Signal { name: "r", unit: metres.clone(), about: "wanted displacement" }],
                    output: u.clone(),
                    vectors: Vectors::default(),
                });
            }
        }
        if let Some(controller) = wanted.controller {
            let unsuited = || {
                let rule =
                    "must have a law to be exported; this one plans anew in every sample: take another, such as pi";
                Error::parameter("controller", "predictive", rule)
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
                vectors: Vectors::default(),
            });
        }
        let kept: Vec<&str> = whole.entries.iter().map(|entry| entry.step).collect();
        whole.program.keep(&kept);
        whole.held(wanted.single)?;
        let vectors = vectors::of(&whole, wanted)?;
        whole.entries.iter_mut().zip(vectors).for_each(|(entry, vectors)| entry.vectors = vectors);
        for entry in whole.entries.iter().filter(|entry| entry.vectors.off > NOTED) {
            let off = short(entry.vectors.off);
            whole.notes.push(format!("single precision moves {} by {off} of its stroke at most", entry.step));
        }
        Ok(whole)
    }

    /// Refuses numbers that the precision has no room for.
    fn held(&self, single: bool) -> Result<(), Error> {
        let (largest, kind, else_) = match single {
            true => (f64::from(f32::MAX), "float", "; take double"),
            false => (f64::MAX, "double", ""),
        };
        for block in &self.program.blocks {
            let constants = block.constants.iter().map(|c| (&c.name, &c.values[..]));
            let at_rest = block.fields.iter().filter_map(|f| match &f.holds {
                Holds::Number(value) => Some((&f.name, std::slice::from_ref(value))),
                Holds::Numbers(values) => Some((&f.name, &values[..])),
                Holds::Block(_) => None,
            });
            for (name, values) in constants.chain(at_rest) {
                if let Some(value) = values.iter().find(|v| v.is_nan() || v.abs() > largest) {
                    let because =
                        format!("`{name}` of its {} is {value:?}, which a {kind} does not hold{else_}", block.name);
                    return Err(Error::Unsuited { what: "export".into(), because });
                }
            }
        }
        Ok(())
    }
}
