//! Records without information: too few samples, or a signal that is constant.

use super::Detection;
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
        let text = format!("the record has {n} samples, but at least {MIN_SAMPLES} are needed: take a longer record");
        (n < MIN_SAMPLES).then_some(text.into())
    },
};

pub(super) static CONSTANT_INPUT: Detector = Detector {
    name: "constant-input",
    criterion: "all samples of the input are equal",
    consequence: Consequence::Unusable,
    loop_remedy: None,
    run: |context| {
        let record = context.measured();
        constant("input", record.u(), &record.units().u, "drive the actuator with a sine or a PRBS")
    },
};

pub(super) static CONSTANT_OUTPUT: Detector = Detector {
    name: "constant-output",
    criterion: "all samples of the output are equal",
    consequence: Consequence::Unusable,
    loop_remedy: None,
    run: |context| {
        let (record, remedy) = (context.measured(), "check the connection of the sensor and the selected column");
        constant("output", record.y(), &record.units().y, remedy)
    },
};

/// `None` if the signal moves.
fn constant(signal: &str, x: &[f64], unit: &str, remedy: &str) -> Option<Detection> {
    let (low, high) = ends(x.iter().copied());
    let (level, n) = (round(low), x.len());
    let text = format!("the {signal} is constant at {level} {unit} over all {n} samples: {remedy}");
    (low == high).then_some(text.into())
}
