//! Settings of the feed-forward, and the inputs that they allow.

use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::round;
use piezoid_numerics::system::System;
use piezoid_records::excitation::{LimitOptions, Limits};

/// Allowed input beyond the identified range, as a share of that range on each side: operators extrapolate well so far.
pub(super) const BEYOND: f64 = 0.05;

/// Settings of the feed-forward. The default has no limits but the model's own, clips nothing, and makes no iterations.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FeedForwardSettings {
    /// Limits of the driver. A missing voltage limit is replaced by the range of the model's identification data.
    pub limits: Limits,
    /// True to clip to the limits instead of returning an error.
    pub clip: bool,
    /// Largest number of corrections by the residual of the model's free run. They reduce the error of the free run;
    /// that of the actuator only if the model is right at high frequencies, where the corrections act.
    pub iterations: usize,
}

impl FeedForwardSettings {
    /// The feed-forward within these limits, clipped to them or not.
    ///
    /// # Errors
    /// As [`LimitOptions::limits`].
    pub fn within(limits: &LimitOptions, clip: bool) -> Result<Self, Error> {
        Ok(FeedForwardSettings { limits: limits.limits()?.unwrap_or_default(), clip, ..Default::default() })
    }

    /// The lowest and highest input within the limits and the range of the identification data of `model`, extended by
    /// a twentieth on each side.
    ///
    /// # Errors
    /// Returns an error for invalid limits, limits outside that range, and missing limits of a model without that
    /// range.
    pub fn ends(&self, model: &Model) -> Result<(f64, f64), Error> {
        let limits = &self.limits;
        limits.check(&[0.5 * (limits.low.unwrap_or(0.0) + limits.high.unwrap_or(0.0))], model.ts())?;
        let known = model.known_inputs();
        let beyond = known.map(|(low, high)| (low - BEYOND * (high - low), high + BEYOND * (high - low)));
        let low = limits.low.into_iter().chain(beyond.map(|b| b.0)).reduce(f64::max);
        let high = limits.high.into_iter().chain(beyond.map(|b| b.1)).reduce(f64::min);
        match low.zip(high) {
            Some((low, high)) if low < high => Ok((low, high)),
            Some(_) => {
                let end = |end: Option<f64>| end.map_or("any".into(), round);
                let range = format!("{} to {}", end(limits.low), end(limits.high));
                let (from, to) = beyond.map_or((None, None), |(low, high)| (Some(low), Some(high)));
                let (unit, from, to) = (&model.units().u, end(from), end(to));
                let rule = format!("must overlap the inputs that the model allows, {from} to {to} {unit}");
                Err(Error::parameter("limits", range, rule))
            }
            None => {
                let rule = "must be given, or low and high, because the model does not state the range of inputs it was \
                            identified on";
                Err(Error::parameter("driver", "none", rule))
            }
        }
    }
}
