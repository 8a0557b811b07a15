//! The causal feed-forward as a program.

use super::Causal;
use crate::error::Error;
use crate::hysteresis::inverse_program;
use crate::program::{Block, Program};
use crate::system::System;

impl Causal {
    /// Adds to the program of its model a block `ff_state` and a function `ff_step(s: ff_state, r)`: the same as its step here.
    ///
    /// # Errors
    /// [`Error::Content`] of another program than that of its model.
    pub fn extend(&self, program: &mut Program) -> Result<(), Error> {
        let (model, fir) = (self.inverse.model(), self.preview().fir());
        inverse_program(program, model.driver().is_some())?;
        program.add(fir.block(self.resting()))?;
        let (low, high) = self.inverse.ends;
        let mut state = Block::new("ff_state", "the feed-forward: back through linear dynamics, creep and hysteresis")
            .number("before", 0.0);
        if fir.order() > 0 {
            state = state.part("preview", "preview");
        }
        state = model.hidden_parts(state);
        if model.driver().is_some() {
            state = state.part("driver", "driver");
        }
        let limits = if self.inverse.step.is_finite() {
            "let from = clamp(s.before - most_change, low, high);\n    let to = clamp(s.before + most_change, low, high);"
        } else {
            "let from = low;\n    let to = high;"
        };
        let told = if fir.order() > 0 { "s.preview.past[0]" } else { "0.0" };
        let text = format!(
            "
// One sample: the wanted displacement r to the input.
fn ff_step(s: ff_state, r) {{
    // What is no number counts as what was wanted before.
    let told = {told};
    if magnitude(r) <= most {{
        told = r;
    }}
    let wanted = {preview} - at_rest;
    {limits}
    let z = {back};
    let u = {inverse};
    // The state goes on as the actuator does.
    let moved = {hidden};
    {crept}
    s.before = u;
    return u;
}}
",
            preview = if fir.order() > 0 { "preview(s.preview, told)" } else { "preview(told)" },
            back = model.creep_call("s", "creep_inverse", "wanted"),
            inverse = model.hidden_inverse_call("s", "z, from, to"),
            hidden = model.hidden_call("s", "u"),
            crept = if model.creep().order() > 0 { "creep(s.creep, moved);" } else { "" },
        );
        let at_rest = model.offset() / model.linear().dc_gain();
        let state = state.constant("low", low).constant("high", high).constant("at_rest", at_rest);
        let state =
            if self.inverse.step.is_finite() { state.constant("most_change", self.inverse.step) } else { state };
        program.add(state.text(&text))
    }
}
