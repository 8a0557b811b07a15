//! No hysteresis: z = k u. The baseline for all hysteresis operators.
//!
//! Inverse: u = z / k, exact. It does not saturate.

use super::basis::counted;
use super::inverse::Inverted;
use super::{Basis, Class, Hysteresis, Operator, document, parse};
use crate::program::Block;
use piezoid_numerics::error::{finite, positive};
use piezoid_numerics::system::System;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::sync::Arc;

/// z = gain u, without memory: the state is empty.
#[derive(Debug, Clone, PartialEq)]
pub struct Proportional {
    ts: f64,
    params: ProportionalParams,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ProportionalParams {
    gain: f64,
}

pub(super) static OPERATOR: Operator = Operator {
    name: "proportional",
    aliases: &["linear"],
    summary: "no hysteresis, z = k u: the baseline",
    reference: "a linear model",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: true,
    class: Class::Linear,
    basis: |design| Ok(Box::new(Proportional::new(design.ts, 1.0)?)),
    load: |params, ts| {
        let params: ProportionalParams = parse("proportional", params)?;
        Ok(Arc::new(Proportional::new(ts, params.gain)?))
    },
    example: |ts| Ok(Arc::new(Proportional::new(ts, 1.1)?)),
};

impl Proportional {
    /// z = `gain` u, sampled every `ts` [s].
    ///
    /// # Errors
    /// Returns an error if the gain is not finite or `ts` is not positive.
    pub fn new(ts: f64, gain: f64) -> Result<Self, piezoid_numerics::error::Error> {
        positive("ts", ts, "seconds")?;
        finite("gain", &[gain])?;
        Ok(Proportional { ts, params: ProportionalParams { gain } })
    }
}

impl System for Proportional {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        0
    }

    fn step(&self, _: &mut [f64], u: f64) -> f64 {
        self.params.gain * u
    }
}

impl Hysteresis for Proportional {
    fn operator(&self) -> &'static Operator {
        &OPERATOR
    }

    fn params(&self) -> Map<String, Value> {
        document(&self.params)
    }

    fn invert(&self, _: &[f64], z: f64, (low, high): (f64, f64)) -> Inverted {
        let k = self.params.gain;
        // For k = 0 the result is 0 if z = 0, otherwise an end.
        let u = if z == 0.0 { 0.0 } else { z / k };
        // NaN gives the lower end.
        let u = if u > low { u.min(high) } else { low };
        Inverted { u, z: k * u }
    }

    fn block(&self) -> Option<Block> {
        let block = Block::new("hysteresis", format!("{}: {}", OPERATOR.name, OPERATOR.summary));
        Some(block.constant("gain", self.params.gain).text(TEXT))
    }
}

const TEXT: &str = "
fn hysteresis(u) {
    return gain * u;
}

fn hysteresis_inverse(z, low, high) {
    let free = 0.0;
    if z != 0.0 { free = z / gain; }
    let u = low;
    if free > low { u = clamp(free, low, high); }
    return u;
}
";

impl Basis for Proportional {
    fn len(&self) -> usize {
        1
    }

    fn order(&self) -> usize {
        0
    }

    fn step(&self, _: &mut [f64], u: f64, phi: &mut [f64]) {
        phi[0] = u;
    }

    fn non_negative(&self) -> Vec<bool> {
        vec![false]
    }

    fn reshaped(&self, shape: &[f64]) -> Result<Box<dyn Basis>, piezoid_numerics::error::Error> {
        counted(OPERATOR.name, "shape", shape.len(), 0)?;
        Ok(Box::new(self.clone()))
    }

    fn operator(&self, weights: &[f64]) -> Result<Arc<dyn Hysteresis>, piezoid_numerics::error::Error> {
        counted(OPERATOR.name, "weights", weights.len(), 1)?;
        Ok(Arc::new(Proportional::new(self.ts, weights[0])?))
    }
}
