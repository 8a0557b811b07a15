//! The parameters in a state, and the model that they make.

use super::{Moves, Online};
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis;
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use serde::Serialize;

/// The parameters that move, as they are now.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OnlineParameters {
    /// Gain, relative to that of the model at the start.
    pub gain: f64,
    /// Offset of the output [output unit].
    pub offset: f64,
    /// Factor of each group of weights; empty if they do not move.
    pub factors: Vec<f64>,
    /// Coefficients a1, a2, ... of the linear block.
    pub a: Vec<f64>,
    /// Coefficients b0, b1, ... of the linear block, without the gain.
    pub b: Vec<f64>,
    /// The last reading less the response that was expected [output unit].
    pub error: f64,
}

impl Online {
    /// The parameters in the state `x`.
    pub fn parameters(&self, x: &[f64]) -> OnlineParameters {
        let mut x = x.to_vec();
        let s = self.layout.state(&mut x);
        OnlineParameters {
            gain: *s.gain,
            offset: *s.offset,
            factors: if self.moves.weights { s.factor.to_vec() } else { Vec::new() },
            a: s.a.to_vec(),
            b: s.b.to_vec(),
            error: *s.error,
        }
    }

    /// The model with the parameters in the state `x`. It has the units and the range of the model at the start, and no
    /// provenance.
    ///
    /// # Errors
    /// Returns an error for a state with parameters that no model allows, which no run leads to.
    pub fn model(&self, x: &[f64]) -> Result<Model, Error> {
        let OnlineParameters { gain, offset, factors, a, b, .. } = self.parameters(x);
        let start = &self.model;
        let mut document = hysteresis::save(start.hysteresis());
        if let Some(linear) = start.hysteresis().linear_weights().filter(|_| !factors.is_empty()) {
            let mut weights = linear.weights.to_vec();
            for (group, factor) in self.groups.iter().zip(factors) {
                weights[group.clone()].iter_mut().for_each(|w| *w *= factor);
            }
            document["weights"] = weights.into();
        }
        let hysteresis = hysteresis::load(&document, start.hysteresis().ts())?;
        let linear = Arx::new(start.linear().ts(), a, b.iter().map(|b| gain * b).collect())?;
        let model = Model::from_blocks(start.driver().copied(), hysteresis, linear, offset)?;
        let model = model.with_creep(start.creep().clone())?.with_units(start.units().clone());
        Ok(match start.identified() {
            Some(domain) => model.with_identified(*domain),
            None => model,
        })
    }
}

impl Moves {
    /// The names of the parameters that may move.
    pub const NAMES: [&'static str; 4] = ["gain", "offset", "weights", "linear"];

    /// The parameters of a comma-separated list of names; `None` for `auto`, all that the model allows.
    ///
    /// # Errors
    /// [`Error::Unknown`] for an unknown name.
    pub fn of(names: &str) -> Result<Option<Self>, Error> {
        if names.trim().eq_ignore_ascii_case("auto") {
            return Ok(None);
        }
        let mut moves = Moves { gain: false, offset: false, weights: false, linear: false };
        for name in names.split(',').map(str::trim) {
            *match name {
                "gain" => &mut moves.gain,
                "offset" => &mut moves.offset,
                "weights" => &mut moves.weights,
                "linear" => &mut moves.linear,
                _ => {
                    return Err(Error::unknown("parameter that moves", name, Moves::NAMES.into_iter().chain(["auto"])));
                }
            } = true;
        }
        Ok(Some(moves))
    }
}
