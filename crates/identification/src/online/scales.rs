//! The constants of an estimator: half the stroke, in which rows and errors are measured, and what follows from it.
//!
//! ```text
//! z_m = half the difference of s_m, settled at the ends of the range      S = |G(1) sum_m z_m|
//! rows: v / S for the gain, 1 for the offset, g v_m / S for factors, A(1) / S for a, A(1) / Z for b
//! ```

use super::{EXCITATION_MEMORIES, MAX_B, MAX_OFFSET, OFFSET_PRIOR, OnlineSettings};
use piezoid_models::hammerstein::Model;
use piezoid_models::linear::decays_within;
use piezoid_numerics::error::Error;

/// The constants.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scales {
    /// Static gain of creep.
    pub(super) creep: f64,
    /// A(1).
    pub(super) rest: f64,
    /// Static gain of the linear block.
    pub(super) still: f64,
    /// S: half the static stroke over the range [output unit].
    pub(super) stroke: f64,
    /// Share of each group in it; their sum is 1.
    pub(super) share: Vec<f64>,
    /// Lowest and highest input that counts [input unit].
    pub(super) inputs: (f64, f64),
    /// 1 / S.
    pub(super) of_gain: f64,
    /// A(1) / S.
    pub(super) of_a: f64,
    /// A(1) / Z.
    pub(super) of_b: f64,
    /// Largest |b|.
    pub(super) most_b: f64,
    /// Lowest and highest offset [output unit].
    pub(super) offsets: (f64, f64),
    /// What a sample counts in the measure of excitation.
    pub(super) fresh: f64,
    /// Smallest mean square of the response at which all move [squared output unit].
    pub(super) least_power: f64,
    /// Step of the offset per error below that.
    pub(super) drift: f64,
}

impl Scales {
    /// `settled` gives the hidden variable of each group at an input, without creep.
    pub(super) fn new(
        model: &Model,
        settled: impl Fn(f64) -> Vec<f64>,
        settings: &OnlineSettings,
    ) -> Result<Self, Error> {
        let unsuited = |because: String| Error::Unsuited { what: "recursive identification".into(), because };
        let Some((low, high)) = model.known_inputs().filter(|(low, high)| low < high && (high - low).is_finite())
        else {
            let why = "the model does not state the range of its inputs, in which the stroke is measured: identify it \
                       again, or add `identified` to its file";
            return Err(unsuited(why.into()));
        };
        let linear = model.linear();
        if !decays_within(&mut linear.a().to_vec(), 1.0) {
            return Err(unsuited("the linear block of the model is unstable".into()));
        }
        let (rest, still) = (1.0 - linear.a().iter().sum::<f64>(), linear.dc_gain());
        let creep = 1.0 + model.creep().lags().iter().map(|lag| lag.gain).sum::<f64>();
        let halves: Vec<f64> = settled(high).iter().zip(settled(low)).map(|(high, low)| 0.5 * (high - low)).collect();
        let z = creep * halves.iter().sum::<f64>();
        let stroke = (still * z).abs();
        if !(stroke > 0.0 && stroke.is_finite() && (1.0 / stroke).is_finite() && rest > 0.0) {
            let why = format!("the static response of the model at the end of its range is {stroke}: it must not be 0");
            return Err(unsuited(why));
        }
        let sum = halves.iter().sum::<f64>();
        let largest = linear.b().iter().fold(0.0, |most: f64, b| most.max(b.abs()));
        let least = settings.excitation * stroke;
        let scales = Scales {
            creep,
            rest,
            still,
            stroke,
            share: halves.iter().map(|z| z / sum).collect(),
            inputs: (low - (high - low), high + (high - low)),
            of_gain: 1.0 / stroke,
            of_a: rest / stroke,
            of_b: rest / z.abs(),
            most_b: MAX_B * largest,
            offsets: (model.offset() - MAX_OFFSET * stroke, model.offset() + MAX_OFFSET * stroke),
            fresh: 1.0 / (EXCITATION_MEMORIES * settings.gain_memory),
            least_power: least * least,
            drift: 1.0 / ((1.0 + OFFSET_PRIOR) * settings.gain_memory),
        };
        let numbers = [scales.of_a, scales.of_b, scales.most_b, scales.least_power, scales.inputs.0, scales.inputs.1];
        match numbers.iter().chain(&scales.share).all(|value| value.is_finite()) {
            true => Ok(scales),
            false => Err(unsuited(format!("the stroke {stroke} or the range of the model is too large or too small"))),
        }
    }
}
