//! Records without information: too few samples, or a signal that is constant.

use super::detector::{Consequence, Detector};
use piezoid_numerics::number::round;
use piezoid_numerics::series::ends;

/// Minimum number of samples of a record.
const MIN_SAMPLES: usize = 16;

pub(super) static TOO_SHORT: Detector = Detector {
    name: "too-short",
    criterion: "fewer than 16 samples",
    consequence: Consequence::Unusable,
    loop_remedy: None,
    run: |context| {
        let n = context.measured().len();
        let text =
            || format!("the record has {n} samples, but at least {MIN_SAMPLES} are needed: take a longer record");
        (n < MIN_SAMPLES).then(|| text().into())
    },
};

pub(super) static CONSTANT_INPUT: Detector = Detector {
    name: "constant-input",
    criterion: "all samples of the input are equal",
    consequence: Consequence::Unusable,
    loop_remedy: None,
    run: |context| {
        let (u, unit) = (context.measured().u(), &context.measured().units().u);
        let at = constant("input", u, unit)?;
        Some(format!("{at}: drive the actuator with a sine or a PRBS").into())
    },
};

pub(super) static CONSTANT_OUTPUT: Detector = Detector {
    name: "constant-output",
    criterion: "all samples of the output are equal",
    consequence: Consequence::Unusable,
    loop_remedy: None,
    run: |context| {
        let (y, unit) = (context.measured().y(), &context.measured().units().y);
        let at = constant("output", y, unit)?;
        Some(format!("{at}: check the connection of the sensor and the selected column").into())
    },
};

/// The value of a constant signal in words; `None` if it moves.
fn constant(signal: &str, x: &[f64], unit: &str) -> Option<String> {
    let (low, high) = ends(x.iter().copied());
    (low == high).then(|| format!("the {signal} is constant at {} {unit} over all {} samples", round(x[0]), x.len()))
}
