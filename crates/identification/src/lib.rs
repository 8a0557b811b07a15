//! The joint method: identification of all parts together, without inverting any.
//!
//! ```text
//! y = G(q) C(q) sum_k w_k phi_k[u; p] + c
//! ```
//! For given G, creep C and shape p, the weights w are the solution of a convex least-squares problem on the filtered
//! responses, with smoothness and physical signs. Then all parameters are refined by Gauss-Newton on the free-run
//! error, with exact derivatives. Each record has an offset, a trend, initial states of G and creep, and an initial
//! condition of the hysteresis; errors are relative to the peak-to-peak of their record, so all records count. Held-out
//! parts determine the smoothness, the structure of G if there are no small-signal records, and the operator: the
//! simplest that predicts as well as the best.
//!
//! Two modules: `fit` is the mathematics, for a given structure, operator and initial conditions; `search` is the
//! policy that selects these, a table of moves with their thresholds in one struct.
//!
//! Separable least squares: Golub & Pereyra 2003, DOI 10.1088/0266-5611/19/2/201. Hammerstein models by
//! over-parametrised and iterated least squares: Bai 1998, DOI 10.1016/S0005-1098(97)00198-2; Schoukens & Tiels 2017,
//! DOI 10.1016/j.automatica.2017.06.044 (a survey). Not here: hysteresis inside the feedback of the dynamics.
//!
//! Why: docs/decisions/identification.md, "The joint method never inverts a block".
//! Why: docs/decisions/identification.md, "Creep lags are half a decade apart".

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

mod check;
mod each;
pub mod feedback;
mod fit;
mod identified;
pub mod large_signal;
pub mod online;
mod records;
mod result;
mod search;
mod side_by_side;
#[cfg(test)]
mod tests;

pub use check::MIN_SAMPLES_PER_PARAMETER;
pub use each::{Clock, Each, EachOperator, identify_each};
pub use fit::FittedParameter;
pub use identified::{Identified, LinearPart, called, common_units, unexcited_resonance};
pub use search::OperatorTrial;

use fit::Parts;
use piezoid_models::driver::DriverModel;
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::Progress;
use piezoid_records::record::Record;
use records::Records;
use search::{Candidate, Search};
use serde::{Deserialize, Serialize};

/// Number of samples of a quick search, of all records together, and number from which another search begins with it.
const QUICK_SAMPLES: usize = 20_000;
const LONG_RECORDS: usize = 150_000;

/// Maximum number of thresholds, levels or knots.
const MAX_ELEMENTS: usize = 1000;

/// How much a search tries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// A gain, its delay, and a lag or a mode, with a coarse hysteresis, from the last part of each record.
    Quick,
    /// All operators that may be the best, each with the best of some shapes.
    #[default]
    Usual,
    /// More shapes, more structures, and every operator to its minimum.
    Thorough,
}

/// Options of the joint method.
#[derive(Debug, Clone, PartialEq)]
pub struct JointOptions {
    /// Name of the hysteresis operator. Of several (separated by commas), or of all (`auto`), the simplest is selected
    /// that predicts held-out data as well as the best.
    pub operator: String,
    /// Order of the linear block; `None` selects it.
    pub order: Option<usize>,
    /// Thresholds, levels or knots of the operator; `None` is the operator's default.
    pub elements: Option<usize>,
    /// True to identify creep.
    pub creep: bool,
    /// True for creep that is a power of time, whose order is fitted; else each lag of creep has its own gain.
    pub fractional_creep: bool,
    /// The driver; `None` if it is unknown.
    pub driver: Option<DriverModel>,
    /// Seed of the search of the shape of operators.
    pub seed: u64,
    /// How much the search tries.
    pub effort: Effort,
}

impl Default for JointOptions {
    fn default() -> Self {
        JointOptions {
            operator: "auto".into(),
            order: None,
            elements: None,
            creep: true,
            fractional_creep: false,
            driver: None,
            seed: 0,
            effort: Effort::Usual,
        }
    }
}

impl JointOptions {
    fn check(&self) -> Result<(), Error> {
        match self.elements {
            Some(n) if n > MAX_ELEMENTS => {
                Err(Error::parameter("elements", n, format!("must be at most {MAX_ELEMENTS}")))
            }
            _ if self.fractional_creep && !self.creep => {
                Err(Error::parameter("fractional_creep", true, "needs creep, which is switched off: identify it"))
            }
            _ if self.fractional_creep && self.effort == Effort::Quick => {
                Err(Error::parameter("fractional_creep", true, "needs more effort than quick: leave one of both out"))
            }
            _ => Ok(()),
        }
    }
}

/// Identifies all parts together. `small` are small-signal records (a PRBS) and may be empty; `large_signal` exercise
/// the hysteresis. A search that `progress` cancels returns the best model until then, if there is one; of long
/// records, the first is that of a quick search.
///
/// # Errors
/// Returns an error if sampling periods differ, units cannot be converted, there is no usable record, or an operator is
/// unknown; [`Error::Cancelled`].
pub fn identify_joint(
    small: &[Record],
    large_signal: &[Record],
    settings: &JointOptions,
    progress: &mut Progress,
) -> Result<Identified, Error> {
    settings.check()?;
    let records = Records::of(small, large_signal)?;
    let quick = JointOptions { effort: Effort::Quick, ..settings.clone() };
    let mut quickly = || identified(&records, &records.ends(QUICK_SAMPLES)?, &quick, progress);
    if settings.effort == Effort::Quick {
        return quickly();
    }
    let is_long = records.iter().map(Record::len).sum::<usize>() > LONG_RECORDS;
    let first = match is_long.then(quickly) {
        Some(Err(why @ Error::Cancelled { .. })) => return Err(why),
        Some(Ok(first)) if first.cancelled.is_some() => return Ok(first),
        first => first.and_then(Result::ok),
    };
    match (identified(&records, &records, settings, progress), first) {
        (Err(cancelled @ Error::Cancelled { .. }), Some(first)) => {
            Ok(Identified { cancelled: Some(cancelled), ..first })
        }
        (found, _) => found,
    }
}

/// The model of `records` that a search in their `ends` finds, or in themselves.
fn identified(
    records: &Records,
    ends: &Records,
    settings: &JointOptions,
    progress: &mut Progress,
) -> Result<Identified, Error> {
    let result = |search: &mut Search, best: Candidate| result::identified(best, search, records, settings);
    searched(records, ends, settings, progress, result)
}

/// What `then` makes of the search of `records` in their `ends`, and of the best candidate that it finds.
fn searched<T>(
    records: &Records,
    ends: &Records,
    settings: &JointOptions,
    progress: &mut Progress,
    then: impl FnOnce(&mut Search, Candidate) -> Result<T, Error>,
) -> Result<T, Error> {
    let mut notes = Vec::new();
    let operators = search::suitable_operators(&settings.operator, records, &mut notes)?;
    let runs = fit::training_records(ends.beside(), &ends.large_signal, &mut notes)?;
    let breadth = settings.effort.breadth();
    let parts = Parts::of(&runs, breadth.whole_samples, breadth.part_samples)?;
    let mut search = Search::new(settings, ends, &runs, &parts, operators, notes, progress)?;
    let best = search.run()?;
    then(&mut search, best)
}
