//! The guard of an exported model: what no actuator can be given does not enter.
//!
//! ```text
//! taken = u    if -farthest <= u <= farthest, else the input that was taken before
//! ```
//! `farthest` is [`WIDER`] times the largest input of the range that the model is known for. A NaN, an infinity and the
//! number of a flipped bit are held back alike: the run is that of an instance that got the input before once more, bit
//! by bit. Two comparisons are all that a sample takes more. The library's own model has no guard, because a
//! [`Record`](piezoid::Record) holds finite numbers alone.
//!
//! Why: docs/decisions/export.md, "An input that cannot be is not taken".

use piezoid::{Error, Model};
use piezoid_models::program::{Field, FieldValue, Program};

/// The step without its guard.
pub(super) const UNGUARDED: &str = "unguarded";

/// The farthest input that is taken, over the largest of the known range.
const WIDER: f64 = 10.0;

/// The farthest one without a known range: its square is finite in single precision.
const FARTHEST: f64 = 1e18;

/// The largest input, either way, that the exported model takes.
pub(super) fn farthest(model: &Model) -> f64 {
    let known = model.known_inputs().map_or(0.0, |(low, high)| WIDER * low.abs().max(high.abs()));
    if known > 0.0 { known.min(FARTHEST) } else { FARTHEST }
}

/// Guards `step` of a program that has been made of `model` alone.
pub(super) fn guarded(program: &mut Program, model: &Model) -> Result<(), Error> {
    for function in program.functions.iter_mut().filter(|function| function.name == "step") {
        function.name = UNGUARDED.into();
        function.about = vec!["One sample of the input that was taken.".into()];
    }
    if let Some(state) = program.blocks.last_mut() {
        let taken = Field { name: "taken".into(), holds: FieldValue::Number(0.0) };
        state.fields.push(taken);
        *state = std::mem::take(state).constant("farthest", farthest(model));
    }
    program.extend(
        "
// One sample: the input u to the displacement. What is no number, or too far out, is not taken: the last input stays.
fn step(s: state, u) {
    if u >= -farthest && u <= farthest {
        s.taken = u;
    }
    let taken = s.taken;
    return unguarded(s, taken);
}
",
    )
}
