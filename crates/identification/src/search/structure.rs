//! Structures of the linear block, their comparison, and the selection of the simplest that is as good as the best.

use super::fit::{Estimate, Fitted, MAX_MODE_DAMPING, TrainingRecord};
use super::promises::Promises;
use super::{POLICY, basis_ts};
use libm::hypot;
use piezoid_models::creep::Lag;
use piezoid_models::driver::DriverModel;
use piezoid_models::hammerstein::InitialCondition;
use piezoid_models::hysteresis::Basis;
use piezoid_models::linear::{Arx, Pole};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::system::System;
use std::cell::RefCell;
use std::cmp::Ordering;
use std::rc::Rc;

/// Held-out error, rms over peak-to-peak, that is rounding.
const ROUNDING_RMS_PP: f64 = 1e-6;

/// Makes the basis of an operator for a sampling period [s].
pub(super) type MakeBasis<'a> = &'a dyn Fn(f64) -> Result<Box<dyn Basis>, Error>;

/// A fit, and the last extension of its linear block; empty if there is none.
pub(super) struct Structure {
    pub(super) extension: String,
    pub(super) fitted: Fitted,
    /// The promises that were computed last, and the initial conditions of the runs then.
    promises: RefCell<Option<(Vec<InitialCondition>, Rc<Promises>)>>,
}

impl Structure {
    pub(super) fn new(extension: String, fitted: Fitted) -> Self {
        Structure { extension, fitted: fitted.without_segments(), promises: RefCell::new(None) }
    }

    /// What the linearised equations promise for changes of the fit; `slowest` is the frequency of the slowest lag that
    /// is not creep [Hz].
    pub(super) fn promises(&self, runs: &[TrainingRecord], slowest: f64) -> Result<Rc<Promises>, Error> {
        let initial_conditions: Vec<_> = runs.iter().map(|run| run.initial).collect();
        let mut last = self.promises.borrow_mut();
        match last.as_ref().filter(|(of, _)| *of == initial_conditions) {
            Some((_, promises)) => Ok(promises.clone()),
            None => {
                let promises = Rc::new(Promises::of(&self.fitted, runs, slowest)?);
                *last = Some((initial_conditions, promises.clone()));
                Ok(promises)
            }
        }
    }

    /// Orders by the held-out error, the smallest first.
    pub(super) fn by_error(p: &&Structure, q: &&Structure) -> Ordering {
        p.error().total_cmp(&q.error())
    }

    /// The held-out error: rms over peak-to-peak, with rounding.
    pub(super) fn error(&self) -> f64 {
        hypot(self.fitted.held_out.rms_pp(), ROUNDING_RMS_PP)
    }

    /// True if this is clearly better than `other`.
    pub(super) fn gains_on(&self, other: &Structure) -> bool {
        let of_whole = |t: &Structure| hypot(t.fitted.cost().sqrt(), ROUNDING_RMS_PP);
        let (held_out, whole) = (self.error() / other.error(), of_whole(self) / of_whole(other));
        held_out < POLICY.held_out_gain_ratio || (held_out <= 1.0 && whole < POLICY.whole_record_gain_ratio)
    }

    /// The order of the linear block.
    pub(super) fn order(&self) -> usize {
        self.fitted.estimate.linear.a().len()
    }

    /// The number of modes that ring.
    pub(super) fn modes(&self) -> usize {
        let rings = |pole: &&Pole| pole.z.im > 0.0 && pole.damping < MAX_MODE_DAMPING;
        self.fitted.estimate.linear.poles().iter().filter(rings).count()
    }

    /// Order and delay, and what was added last.
    fn describe(&self) -> String {
        let Estimate { linear, driver, seeks_lag, .. } = &self.fitted.estimate;
        let (order, delay) = (linear.a().len(), linear.delay());
        let block = if order == 0 { "a gain".into() } else { format!("order {order}") };
        let delayed = if delay == 0 { String::new() } else { format!(", delay {delay}") };
        let lag = driver.filter(|_| *seeks_lag).map_or(String::new(), |d| format!(", driver lag {} s", short(d.lag_s)));
        let by = if self.extension.is_empty() { String::new() } else { format!(" by {}", self.extension) };
        format!("{block}{delayed}{lag}{by}")
    }
}

/// A structure that was selected.
pub(super) struct Selected {
    pub(super) fitted: Fitted,
    pub(super) reason: String,
    /// The simpler structures that may be as good with another operator.
    pub(super) simpler: Vec<Estimate>,
    /// True if there were others.
    pub(super) of_several: bool,
}

/// The simplest structure that is as good as the best, of at least one, from the simplest on; of the specified order,
/// if one has it.
pub(super) fn select(mut tried: Vec<Structure>, order: Option<usize>) -> Selected {
    let is_of_order = |structure: &Structure| order == Some(structure.order());
    let is_specified = tried.iter().any(is_of_order);
    let why = match is_specified {
        true => "the best of the specified order is selected",
        false => "the simplest that is as good as the best is selected",
    };
    let may = |t: &&Structure| !is_specified || is_of_order(t);
    let selected = tried.iter().position(|t| may(&t) && !tried.iter().filter(may).any(|other| other.gains_on(t)));
    let selected = selected.unwrap_or(tried.len().saturating_sub(1));
    let listed = tried.iter().map(|t| format!("{} {} %", t.describe(), short(100.0 * t.error())));
    let listed: Vec<String> = listed.collect();
    let of_several = tried.len() > 1;
    let structure = tried.remove(selected);
    let reason = format!("{}: held-out error, rms/pp: {}; {why}", structure.describe(), listed.join(", "));
    tried.truncate(selected);
    tried.retain(|t| t.error() < POLICY.hopeless_structure_ratio * structure.error());
    let simpler = tried.into_iter().map(|t| t.fitted.estimate).collect();
    Selected { fitted: structure.fitted, reason, simpler, of_several }
}

/// The hysteresis of an estimate with another driver, and whether its lag is sought, other creep and another linear
/// block.
pub(super) fn with_other_blocks(
    estimate: &Estimate,
    (driver, seeks_lag): (Option<DriverModel>, bool),
    lags: &[Lag],
    linear: Arx,
    basis: MakeBasis,
) -> Result<Estimate, Error> {
    let ts = basis_ts(linear.ts(), driver.is_some());
    // Terms that records have selected remain.
    let basis = match estimate.basis.with_period(ts) {
        Some(same) => same.into(),
        None => basis(ts)?.reshaped(&estimate.shape())?.into(),
    };
    Ok(Estimate { driver, seeks_lag, basis, lags: lags.to_vec(), linear, ..estimate.clone() })
}

/// The block with another static gain.
pub(super) fn rescaled(arx: &Arx, gain: f64) -> Result<Arx, Error> {
    let k = gain / arx.dc_gain();
    Arx::new(arx.ts(), arx.a().to_vec(), arx.b().iter().map(|b| b * k).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_with_another_gain_keeps_its_poles_and_zeros() {
        let arx = Arx::new(1e-3, vec![1.2, -0.7], vec![0.0, 2.0, -1.0]).unwrap();
        let scaled = rescaled(&arx, -5.0).unwrap();
        assert!((scaled.dc_gain() + 5.0).abs() < 1e-12);
        assert_eq!((scaled.a(), scaled.ts(), scaled.delay()), (arx.a(), 1e-3, 1));
        assert!((scaled.b()[2] / scaled.b()[1] + 0.5).abs() < 1e-12);
    }
}
