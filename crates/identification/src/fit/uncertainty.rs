//! Uncertainty of the parameters by the jackknife: each fold is left out in turn, and the change of the parameters
//! shows how much they depend on it.
//!
//! ```text
//! error^2 = (F - 1) / F  sum over folds of (value without the fold - mean of these)^2
//! ```
//! It needs no assumption about the residuals, and includes model errors as well as noise. Every fold contains a part
//! of each small-signal record; otherwise the parameters that only these records determine would have an error of 0.
//!
//! B. Efron & C. Stein, Ann. Statist. 9, 586 (1981), DOI 10.1214/aos/1176345462.

use super::estimate::{CreepOrder, Estimate};
use super::fitted::Fitted;
use libm::log;
use piezoid_models::creep::Creep;
use piezoid_models::linear::{Pole, PoleShare};
use piezoid_numerics::series::scatter;
use serde::Serialize;

/// Error over value from which a parameter counts as not identified.
const UNKNOWN_RELATIVE_ERROR: f64 = 0.5;

/// A physical parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FittedParameter {
    /// Its name, with the unit.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

impl FittedParameter {
    /// True if its standard error exceeds half of its value.
    pub fn is_unknown(&self) -> bool {
        self.error.is_nan() || self.error > UNKNOWN_RELATIVE_ERROR * self.value.abs()
    }
}

/// Shape of the hysteresis, lag of the driver, creep, and modes of the linear block, if there are any.
pub(crate) fn parameters(fitted: &Fitted) -> Vec<FittedParameter> {
    let estimate = &fitted.estimate;
    let others: Vec<_> = fitted.held_out.without.iter().filter_map(|x| estimate.moved(x.as_slice())).collect();
    let parameter = |name: String, value: f64, of: &dyn Fn(&Estimate) -> f64| {
        let values: Vec<f64> = others.iter().map(of).collect();
        let n = values.len() as f64;
        let error = if n > 1.0 { ((n - 1.0) / n * scatter(&values)).sqrt() } else { f64::INFINITY };
        FittedParameter { name, value, error }
    };
    let mut parameters = Vec::new();
    for (k, shape) in estimate.basis.shape().into_iter().enumerate() {
        parameters.push(parameter(shape.name.into(), shape.value, &|e| e.basis.shape()[k].value));
    }
    if let Some(driver) = estimate.driver.filter(|_| estimate.seeks_lag) {
        let lag_of = |e: &Estimate| e.driver.map_or(f64::NAN, |driver| driver.lag_s);
        parameters.push(parameter("driver lag [s]".into(), driver.lag_s, &lag_of));
    }
    if let Some(CreepOrder { value, error }) = estimate.creep_order {
        parameters.push(FittedParameter { name: "creep order [-]".into(), value, error });
        let after = |e: &Estimate| Creep::new(e.ts(), e.lags.clone()).map_or(f64::NAN, |creep| creep.after(1.0));
        parameters.push(parameter("creep within 1 s [-]".into(), after(estimate), &after));
    }
    let separate = estimate.lags.iter().enumerate().filter(|(_, lag)| estimate.creep_order.is_none() && lag.gain > 0.0);
    for (k, lag) in separate {
        let name = format!("creep gain at {} s [-]", piezoid_numerics::number::short(lag.tau_s));
        parameters.push(parameter(name, lag.gain, &|e| e.lags[k].gain));
    }
    for (k, mode) in estimate.linear.modal_form().modes().into_iter().enumerate() {
        // The nearest by frequency: their order may change.
        let nearest = |e: &Estimate| {
            let near = |p: &PoleShare| log(p.pole.hz / mode.pole.hz).abs();
            let modes = e.linear.modal_form().modes().into_iter();
            modes.min_by(|p, q| near(p).total_cmp(&near(q))).map(|p| p.pole)
        };
        let (k, Pole { hz, damping, .. }) = (k + 1, mode.pole);
        let of_nearest = |e: &Estimate, of: fn(Pole) -> f64| nearest(e).map_or(f64::NAN, of);
        parameters.push(parameter(format!("mode {k} frequency [Hz]"), hz, &|e| of_nearest(e, |p| p.hz)));
        parameters.push(parameter(format!("mode {k} damping"), damping, &|e| of_nearest(e, |p| p.damping)));
    }
    parameters
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parameter_is_unknown_if_its_error_exceeds_half_of_it() {
        let unknown = |value, error| FittedParameter { name: "p".into(), value, error }.is_unknown();
        assert!(!unknown(-4.0, 2.0) && unknown(-4.0, 2.1) && unknown(4.0, f64::NAN) && unknown(0.0, 1e-9));
    }
}
