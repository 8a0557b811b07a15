//! The exported program: blocks and functions, its interface, and test vectors.

use super::guard::guarded;
use super::vectors::{self, Vectors};
use super::{ExportRequest, ExportedFunction};
use piezoid::compensation::FeedForwardSettings;
use piezoid::{Error, Units};
use piezoid_identification::online::Online;
use piezoid_models::program::{Block, FieldValue, Program};
use piezoid_numerics::number::short;

/// A program and its interface.
#[derive(Debug, Clone)]
pub struct ExportedProgram {
    /// The blocks and functions.
    pub program: Program,
    /// The interface: the model first, then its feed-forward, the controller, and the estimator.
    pub entries: Vec<Entry>,
    /// Omissions and remarks, one sentence each.
    pub notes: Vec<String>,
}

/// A state and the function that advances it by one sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The function: `step`, `ff_step`, `control_step` or `online_step`.
    pub step: &'static str,
    /// The function that resets the state: `reset`, `ff_reset`, `control_reset` or `online_reset`.
    pub reset: &'static str,
    /// The block of the state.
    pub state: &'static str,
    /// One line.
    pub about: String,
    /// Inputs.
    pub inputs: Vec<Port>,
    /// Output.
    pub output: Port,
    /// Test vectors.
    pub vectors: Vectors,
}

/// A signal of the interface.
#[derive(Debug, Clone, PartialEq)]
pub struct Port {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: String,
    /// Description.
    pub about: &'static str,
}

/// The longest name of a unit.
const LONGEST_UNIT: usize = 40;

/// Share of the stroke from which the error of single precision is noted.
const NOTED: f64 = 1e-5;

impl Entry {
    fn new([step, reset, state]: [&'static str; 3], about: String, inputs: Vec<Port>, output: Port) -> Self {
        Entry { step, reset, state, about, inputs, output, vectors: Vectors::default() }
    }

    /// `name` with the kind of the entry, if it has one.
    pub(super) fn named(&self, name: &str) -> String {
        if self.kind().is_empty() { name.into() } else { format!("{name}_{}", self.kind()) }
    }

    /// Its inputs in a run: `u` of the model, `r` of the feed-forward, and both of controller and estimator, which read
    /// `read` times `r`.
    pub(super) fn rows(&self, u: &[f64], r: &[f64], read: f64) -> Vec<Vec<f64>> {
        match self.step {
            "step" => u.iter().map(|u| vec![*u]).collect(),
            "ff_step" => r.iter().map(|r| vec![*r]).collect(),
            "online_step" => r.iter().zip(u).map(|(r, u)| vec![*u, read * r]).collect(),
            _ => r.iter().zip(u).map(|(r, u)| vec![*r, read * r, *u]).collect(),
        }
    }

    /// Name of the state in examples.
    pub(super) fn called(&self) -> &'static str {
        match self.kind() {
            "" => "model",
            "ff" => "feed_forward",
            "online" => "estimator",
            _ => "controller",
        }
    }

    /// Prefix of its functions: nothing, `ff`, `control` or `online`.
    pub fn kind(&self) -> &'static str {
        self.step.trim_end_matches("step").trim_end_matches('_')
    }
}

/// The type of the state of a block, without the prefix of the export.
pub(super) fn state_of(block: &str) -> String {
    if block.ends_with("state") { block.into() } else { format!("{block}_state") }
}

impl ExportedProgram {
    /// The model, its inverse if it has one, and controller and estimator if requested.
    ///
    /// # Errors
    /// [`Error::Unsuited`] for a model or controller without a program, and a model without parameters that can move.
    pub fn new(request: &ExportRequest) -> Result<Self, Error> {
        Self::with(request, true)
    }

    /// The same without the guard of the model, for integers, all of which it takes.
    pub(super) fn unguarded(request: &ExportRequest) -> Result<Self, Error> {
        Self::with(request, false)
    }

    fn with(request: &ExportRequest, guard: bool) -> Result<Self, Error> {
        let model = request.model;
        let Units { u, y } = model.units();
        for (name, unit) in [("u", u), ("y", y)] {
            if unit.chars().any(char::is_control) || unit.len() > LONGEST_UNIT {
                let rule = format!("must be {LONGEST_UNIT} letters at most, on one line");
                return Err(Error::parameter(format!("units.{name}"), format!("{unit:?}"), rule));
            }
        }
        let u = Port { name: "u", unit: u.clone(), about: "actuator input" };
        let y = Port { name: "y", unit: y.clone(), about: "displacement" };
        let about = "the model: input to displacement".into();
        let step = Entry::new(["step", "reset", "state"], about, vec![u.clone()], y.clone());
        let mut program = model.program()?;
        if guard {
            guarded(&mut program, model)?;
        }
        let mut whole = ExportedProgram { program, entries: vec![step], notes: Vec::new() };
        if model.interpolates() {
            let note =
                "the input moves along a straight line between its samples; a simulation interpolates it instead";
            whole.notes.push(note.into());
        }
        whole.feed_forward(request, &u, &y)?;
        whole.controller(request, &u, &y)?;
        whole.estimator(request, &u, &y)?;
        let kept: Vec<&str> = whole.entries.iter().map(|entry| entry.step).collect();
        whole.program.keep(&kept);
        whole.held(request.options.float)?;
        let vectors = vectors::of(&whole, request)?;
        whole.entries.iter_mut().zip(vectors).for_each(|(entry, vectors)| entry.vectors = vectors);
        for Entry { step, vectors, .. } in whole.entries.iter().filter(|entry| entry.vectors.off > NOTED) {
            let off = short(vectors.off);
            whole.notes.push(format!("single precision changes the result of {step} by at most {off} of its stroke"));
        }
        Ok(whole)
    }

    /// Adds the inverse, or a note with the reason for its absence.
    fn feed_forward(&mut self, request: &ExportRequest, u: &Port, y: &Port) -> Result<(), Error> {
        match request.causal() {
            // A requested feed-forward is not omitted silently.
            Err(error) if request.settings != FeedForwardSettings::default() || request.options.preview > 0 => {
                return Err(error);
            }
            Err(error) => self.notes.push(format!("there is no feed-forward: {error}")),
            Ok(causal) => {
                causal.extend(&mut self.program)?;
                let preview = match causal.delay_samples() {
                    0 => String::new(),
                    n => format!("; the displacement must be given {n} samples ahead"),
                };
                let about = format!("the feed-forward: requested displacement to actuator voltage{preview}");
                let r = Port { name: "r", about: "wanted displacement", ..y.clone() };
                self.entries.push(Entry::new(["ff_step", "ff_reset", "ff_state"], about, vec![r], u.clone()));
            }
        }
        Ok(())
    }

    /// Adds the controller, if requested.
    fn controller(&mut self, request: &ExportRequest, u: &Port, y: &Port) -> Result<(), Error> {
        let Some(controller) = request.controller else { return Ok(()) };
        let unsuited = || Error::Unsuited {
            what: "export of this controller".into(),
            because: "it optimises in every sample: choose a linear controller, such as pi".into(),
        };
        for block in controller.blocks().ok_or_else(unsuited)? {
            self.program.add(block)?;
        }
        let about = self.program.blocks.last().map_or(String::new(), |block| block.about.clone());
        let inputs = vec![
            Port { name: "r", about: "requested displacement at the time of the reading y", ..y.clone() },
            Port { about: "the last reading of the displacement", ..y.clone() },
            Port { name: "feed_forward", about: "the feed-forward of this sample, or 0", ..u.clone() },
        ];
        let names = ["control_step", "control_reset", "control_state"];
        self.entries.push(Entry::new(names, format!("the controller: {about}"), inputs, u.clone()));
        Ok(())
    }

    /// Adds the estimator, if requested.
    fn estimator(&mut self, request: &ExportRequest, u: &Port, y: &Port) -> Result<(), Error> {
        if !request.options.online {
            return Ok(());
        }
        let online = Online::new(request.model, &request.options.estimator.settings()?)?;
        online.extend(&mut self.program)?;
        self.notes.extend(online.remarks().iter().cloned());
        let inputs = vec![u.clone(), Port { about: "the reading of the displacement in this sample", ..y.clone() }];
        let about = "the model with moving parameters: input and reading to the displacement that was expected".into();
        let output = Port { name: "expected", about: "displacement before the parameters move", ..y.clone() };
        self.entries.push(Entry::new(["online_step", "online_reset", "online_state"], about, inputs, output));
        Ok(())
    }

    /// What users call, with its operations.
    pub(super) fn functions(&self) -> Vec<ExportedFunction> {
        let function = |entry: &Entry| {
            let Vectors { mean, most, bound, bounds, .. } = entry.vectors;
            ExportedFunction { name: entry.step, about: entry.about.clone(), mean, most_seen: most, bound, bounds }
        };
        self.entries.iter().map(function).collect()
    }

    /// The blocks of the states, each after its inner blocks.
    pub fn states(&self) -> Vec<&Block> {
        let mut within: Vec<&str> = self.entries.iter().map(|entry| entry.state).collect();
        let mut states = Vec::new();
        for block in self.program.blocks.iter().rev().filter(|block| !block.fields.is_empty()) {
            if within.contains(&&*block.name) {
                within.extend(block.fields.iter().filter_map(|field| match &field.holds {
                    FieldValue::Block(inner) => Some(&**inner),
                    _ => None,
                }));
                states.push(block);
            }
        }
        states.reverse();
        states
    }

    /// Checks that all numbers are in the range of the precision.
    fn held(&self, single: bool) -> Result<(), Error> {
        let (largest, kind, instead) = match single {
            true => (f64::from(f32::MAX), "float", ": use double"),
            false => (f64::MAX, "double", ""),
        };
        for block in &self.program.blocks {
            let constants = block.constants.iter().map(|c| (&c.name, &c.values[..]));
            let at_rest = block.fields.iter().filter_map(|f| match &f.holds {
                FieldValue::Number(value) => Some((&f.name, std::slice::from_ref(value))),
                FieldValue::Numbers(values) => Some((&f.name, &values[..])),
                FieldValue::Block(_) => None,
            });
            for (name, values) in constants.chain(at_rest) {
                if let Some(value) = values.iter().find(|v| v.is_nan() || v.abs() > largest) {
                    let because =
                        format!("`{name}` of its {} is {value:?}, out of the range of {kind}{instead}", block.name);
                    return Err(Error::Unsuited { what: "export".into(), because });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::TARGETS;
    use super::*;
    use piezoid::Model;
    use piezoid::hysteresis::Operator;
    use piezoid::linear::Arx;
    use piezoid_models::program::Machine;

    fn model(operator: &str) -> Model {
        let law = (Operator::find(operator).unwrap().example)(5e-4).unwrap();
        Model::new(law, Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1]).unwrap(), 2.0).unwrap()
    }

    #[test]
    fn every_target_states_the_most_seen_and_the_bound_of_every_function() {
        let model = model("bouc-wen");
        for target in TARGETS.iter().filter(|target| !target.takes.contains(&"reference")) {
            let result = (target.make)(&ExportRequest::new(&model, "m")).unwrap();
            let text: String = result.files.iter().map(|file| String::from_utf8_lossy(&file.bytes)).collect();
            let json = result.to_json();
            for (k, f) in result.functions.iter().enumerate() {
                assert!(0 < f.most_seen && f.most_seen <= f.bound, "{}: {f:?}", target.name);
                let bound = format!("at most {} for every input", f.bound);
                // Fixed-point and code in its header, others in their own comments or page.
                assert!(text.contains(&bound), "{}: {bound}", target.name);
                if !target.name.starts_with("fmu") {
                    assert!(text.contains(&format!("| {} | {} |\n", f.most_seen, f.bound)), "{}", target.name);
                }
                let operations = &json["functions"][k]["operations"];
                assert_eq!((&operations["most_seen"], &operations["bound"]), (&f.most_seen.into(), &f.bound.into()));
            }
        }
    }

    #[test]
    fn no_input_takes_more_operations_than_the_bound() {
        for operator in ["krasnoselskii-pokrovskii", "bouc-wen-baber-noori", "preisach"] {
            let model = model(operator);
            let request = ExportRequest::new(&model, "m");
            let whole = ExportedProgram::new(&request).unwrap();
            for entry in &whole.entries {
                let mut machine = Machine::new(&whole.program, entry.state, false);
                for v in [0.0, 30.0, -30.0, 1e300, f64::NAN, 1e-300, f64::INFINITY, 12.0, f64::NEG_INFINITY, 3.0] {
                    let before = machine.counts.total();
                    machine.call(entry.step, &[v]).unwrap();
                    let taken = machine.counts.total() - before;
                    assert!(taken <= entry.vectors.bound, "{operator} {}: {taken}", entry.step);
                }
            }
        }
    }
}
