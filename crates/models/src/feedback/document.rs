//! A feedback model in a model file.

use super::{FeedbackDynamics, FeedbackModel};
use crate::hysteresis;
use piezoid_numerics::error::Error;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What a file has of it.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FeedbackDocument {
    hysteresis: Value,
    dynamics: FeedbackDynamics,
}

impl FeedbackModel {
    pub(crate) fn document(&self) -> FeedbackDocument {
        FeedbackDocument { hysteresis: hysteresis::save(self.hysteresis()), dynamics: self.dynamics.clone() }
    }

    /// Reads what [`document`](Self::document) returned, sampled every `ts` [s].
    pub(crate) fn load(ts: f64, document: FeedbackDocument) -> Result<Self, Error> {
        let FeedbackDocument { hysteresis, dynamics } = document;
        let operator = hysteresis::load(&hysteresis, ts / dynamics.substeps.max(1) as f64)?;
        FeedbackModel::new(ts, dynamics, operator)
    }
}
