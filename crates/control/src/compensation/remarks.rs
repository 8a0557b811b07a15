//! Notes on a compensation, and the error for a reference that cannot be reached.

use super::{FeedForward, InverseRun};
use piezoid_models::hammerstein::Domain;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::series::ends;
use piezoid_numerics::system::System;
use piezoid_records::record::Units;

/// Range of a reference, over the displacements that can be held, from which its unit is doubted.
const MAX_STROKE_RATIO: f64 = 5.0;

impl FeedForward {
    /// The error for a reference that needs an input out of reach at `sample`.
    pub fn unreachable(&self, r: &[f64], sample: usize) -> Error {
        let Units { u: input, y: unit } = self.model.units();
        let [low, high] = [self.ends.0, self.ends.1].map(round);
        let ((bottom, top), (lowest, highest)) = (self.reach(), ends(r.iter().copied()));
        let times = (highest - lowest) / (top - bottom);
        let [from, to] = [lowest, highest].map(round);
        let is_inside = bottom <= lowest && highest <= top;
        let [value, at, bottom, top] = [r[sample], sample as f64 * self.model.ts(), bottom, top].map(round);
        if !is_inside {
            let why = match times > MAX_STROKE_RATIO {
                true => format!("this is {} times the stroke: check the unit of the reference", short(times)),
                false if times <= 1.0 => "shift it into this range".into(),
                false => "reduce its amplitude".into(),
            };
            return Error::Unreachable(format!(
                "it runs from {from} to {to} {unit}, but within {low} to {high} {input} only {bottom} to {top} {unit} \
                 can be held; {why}, or clip"
            ));
        }
        let instead = match sample < self.preview.ahead() {
            true => "begin the reference with some milliseconds at a constant value, or smooth it",
            false => "the reference changes too fast there: slow it down or smooth it",
        };
        Error::Unreachable(format!(
            "{value} {unit} at sample {sample} ({at} s) needs an input outside {low} to {high} {input} (at rest, \
             {bottom} to {top} {unit} can be held); {instead}, or clip"
        ))
    }

    /// Notes on clipped samples, jumps, and voltages outside the identification data.
    pub(super) fn notes_on(&self, run: &InverseRun) -> Vec<String> {
        let (n, clipped) = (run.u.len(), run.clipped);
        let mut notes = Vec::new();
        if clipped > 0 {
            notes.push(format!("{clipped} of {n} samples are clipped to the limits"));
        }
        if run.jumped > 0 {
            let jumped = run.jumped;
            notes.push(format!(
                "at {jumped} of {n} samples the hysteresis block cannot give the requested value (it jumps); the \
                 nearest value is used"
            ));
        }
        notes.extend(self.beyond(&run.u));
        notes
    }

    /// Notes on voltages `u` outside the identification data.
    pub fn beyond(&self, u: &[f64]) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(known) = self.model.identified() {
            let ((low, high), slew) = (ends(u.iter().copied()), Domain::slew_of(u, self.model.ts()));
            let input = &self.model.units().u;
            if !known.spans([low, high]) {
                let [low, high, known_low, known_high] = [low, high, known.u[0], known.u[1]].map(round);
                notes.push(format!(
                    "inputs from {low} to {high} {input} are used, but the model was identified from {known_low} to \
                    {known_high}"
                ));
            }
            if known.is_slower_than(slew) {
                let [slew, known] = [slew, known.slew].map(round);
                notes.push(format!(
                    "the input changes by {slew} {input}/s, but at most by {known} in the identification data"
                ));
            }
        }
        notes
    }
}
