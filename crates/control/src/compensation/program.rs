//! The causal feed-forward as a program.

use super::Causal;
use super::sample::Law;
use piezoid_models::program::{Block, Program};
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;

impl Causal {
    /// Adds a block `ff_state` and a function `ff_step(s: ff_state, r)` to the program of the model: the same as
    /// [`System::step`].
    ///
    /// # Errors
    /// [`Error::Content`] if the program is not that of the model.
    pub fn extend(&self, program: &mut Program) -> Result<(), Error> {
        let (model, preview) = (self.inverse.model(), self.preview());
        if let Law::Feedback(flat) = &self.law {
            return flat.extend(program, self.inverse.ends, self.inverse.step);
        }
        for block in preview.blocks(self.resting()) {
            program.add(block)?;
        }
        let (low, high) = self.inverse.ends;
        let slews = self.inverse.step.is_finite();
        let mut state =
            Block::new("ff_state", "the feed-forward: the inverses of linear dynamics, creep and hysteresis");
        if slews {
            state = state.number("before", 0.0);
        }
        if preview.order() > 0 {
            state = state.part("preview", "preview");
        }
        if preview.is_recursive() {
            state = state.part("recursion", "recursion");
        }
        state = model.hidden_parts(state);
        if model.driver().is_some() {
            state = state.part("driver", "driver");
        }
        if state.fields.is_empty() {
            state = state.number("unused", 0.0);
        }
        let limits = if slews {
            "let from = clamp(s.before - most_change, low, high);\n    \
             let to = clamp(s.before + most_change, low, high);"
        } else {
            "let from = low;\n    let to = high;"
        };
        let last = if preview.order() > 0 { "s.preview.past[0]" } else { "0.0" };
        let (hidden, moves) = (model.hidden_call("", "u"), program.function("hysteresis_move").is_some());
        let moves = match (model.creep().order() > 0, model.driver().is_some()) {
            (true, _) => format!("creep(s.creep, {hidden});"),
            // The value of z is not needed.
            (false, false) if moves => "hysteresis_move(s.hysteresis, u);".into(),
            (false, false) if model.hysteresis().order() == 0 => String::new(),
            (false, _) => format!("{hidden};"),
        };
        let remembered = if slews { "s.before = u;\n    " } else { "" };
        let text = format!(
            "
// One sample: requested displacement r to actuator input u.
fn ff_step(s: ff_state, r) {{
    // If the reference is not measurable, the last one that was is used.
    let last = {last};
    if magnitude(r) <= measurable {{
        last = r;
    }}
    let shaped = {shaped} - at_rest;
    {limits}
    let z = {back};
    let u = {inverse};
    // The state is updated as that of the actuator.
    {moves}
    {remembered}return u;
}}
",
            shaped = match (preview.order() > 0, preview.is_recursive()) {
                (false, _) => "preview(last)",
                (true, false) => "preview(s.preview, last)",
                (true, true) => "recursion(s.recursion, preview(s.preview, last))",
            },
            back = model.creep_call("creep_inverse", "shaped"),
            inverse = model.hidden_call("_inverse", "z, from, to"),
        );
        let at_rest = model.offset() / model.linear().dc_gain();
        let state = state.constant("low", low).constant("high", high).constant("at_rest", at_rest);
        let state = if slews { state.constant("most_change", self.inverse.step) } else { state };
        program.add(state.text(&text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensation::FeedForwardSettings;
    use piezoid_models::creep::Creep;
    use piezoid_models::driver::DriverModel;
    use piezoid_models::hammerstein::Model;
    use piezoid_models::hysteresis::OPERATORS;
    use piezoid_models::linear::Arx;
    use piezoid_models::program::Machine;
    use piezoid_records::excitation::Limits;

    #[test]
    fn the_program_is_bit_identical_to_the_causal_feed_forward_for_every_operator() {
        let limits = Limits { low: Some(-28.0), high: Some(29.0), ..Default::default() };
        let slewing = Limits { slew: Some(4000.0), ..limits };
        for o in OPERATORS {
            for (driver, limits) in
                [(None, limits), (None, slewing), (Some(DriverModel::new(1e-4, Some(2e4)).unwrap()), limits)]
            {
                let ts = if driver.is_some() { 5e-4 / DriverModel::SUBSTEPS as f64 } else { 5e-4 };
                let a = vec![1.7424, -0.9453];
                let block = match driver {
                    None if limits == slewing => Arx::gain(5e-4, 40.0),
                    // Slow zeros, which need a recursion.
                    None => Arx::new(5e-4, a, vec![0.0, 60.0, -112.0, 58.0]),
                    Some(_) => Arx::new(5e-4, a, vec![0.0, 3.0, 2.8]),
                };
                let model = Model::from_blocks(driver, (o.example)(ts).unwrap(), block.unwrap(), 2.0).unwrap();
                let model = model.with_creep(Creep::logarithmic(5e-4, 0.02, 0.01, 1.0).unwrap()).unwrap();
                let causal = Causal::new(&model, FeedForwardSettings { limits, ..Default::default() }, 2).unwrap();
                let mut program = model.program().unwrap();
                causal.extend(&mut program).unwrap();
                assert_eq!(program.function("recursion").is_some(), driver.is_none() && limits != slewing);
                let mut machine = Machine::new(&program, "ff_state", false);
                let mut x = causal.initial();
                for t in 0..120 {
                    let r =
                        if t == 50 { f64::NAN } else { 700.0 * (0.05 * f64::from(t)).sin() + 300.0 * f64::from(t % 5) };
                    let (u, found) = (causal.step(&mut x, r), machine.call("ff_step", &[r]).unwrap()[0]);
                    assert_eq!(found.to_bits(), u.to_bits(), "{}, {driver:?}, at {t}: {found} for {u}", o.name);
                }
            }
        }
    }
}
