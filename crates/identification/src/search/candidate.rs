//! A candidate for the model: what was selected, and its fit.

use super::fit::{Estimate, Fitted};
use piezoid_models::hysteresis::Operator;

/// A structure, an operator and initial conditions with their fit.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    /// The structure of the linear block.
    pub(crate) structure: SelectedStructure,
    /// The operator: before the operators are compared, the coarse one.
    pub(crate) operator: &'static Operator,
    /// The parameters, with the initial condition of each record, and the errors.
    pub(crate) fitted: Fitted,
}

/// How the structure of the linear block was selected.
#[derive(Debug, Clone)]
pub(crate) struct SelectedStructure {
    /// The structures that were compared, with their errors.
    pub(crate) reason: String,
    /// The simpler structures that may be as good with another operator.
    pub(crate) simpler: Vec<Estimate>,
}

impl Candidate {
    /// The same structure and operator with another fit.
    pub(super) fn with_fit(&self, fitted: Fitted) -> Self {
        Candidate { structure: self.structure.clone(), operator: self.operator, fitted }
    }

    /// The held-out error: rms over peak-to-peak.
    pub(super) fn error(&self) -> f64 {
        self.fitted.held_out.rms_pp()
    }
}
