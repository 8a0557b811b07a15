//! A path on a simulated actuator: with a constant gain, and with the compensated voltage.
//!
//! The displacements are without the noise of the sensor, which is no motion. The errors leave out a constant: it
//! depends on the zero of the sensor and on the past of the actuator, which no path contains. A stand-in states how far
//! its prediction may be off: random ones lie on either side of the model (see
//! [`StandIn`](piezoid_control::feedback::StandIn)).

use super::Compensation;
use super::same_actuator::matched;
use piezoid_control::compensation::FeedForwardSettings;
use piezoid_control::feedback::{Line, MarginTarget, NamedReference, Scheme, SimulatedActuator, TunedScheme};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::series::mean;
use piezoid_numerics::system::System;
use piezoid_validation::Metrics;
use serde::{Serialize, Serializer};
use serde_json::json;

/// Number of random stand-ins, and how many of them the range leaves out at either end.
const DRAWS: u64 = 20;
const LEFT_OUT: usize = 2;

/// A path on a simulated actuator.
#[derive(Debug, Clone, PartialEq)]
pub struct OnPlant {
    /// Name of the actuator.
    pub plant: String,
    /// The constant gain: that of the least error in the response of the model.
    pub line: Option<Line>,
    /// Displacements with the constant gain, and with the compensated voltage [output unit].
    pub displacements: [Vec<f64>; 2],
    /// Their errors against the path without a constant, from its first sample that counts (see
    /// [`NamedReference::new`]).
    pub errors: [Metrics; 2],
    /// Lowest and highest rms error of the compensated voltage on random stand-ins, in 8 of 10 of them [output unit];
    /// `None` for a twin.
    pub spread: Option<[f64; 2]>,
    /// Remarks, one sentence each.
    pub notes: Vec<String>,
}

impl OnPlant {
    /// Plays the voltages of `found` on an actuator with this name.
    ///
    /// # Errors
    /// The errors of [`SimulatedActuator::plant`] and [`TunedScheme::new`].
    pub(super) fn of(
        (name, actuator): (&str, &SimulatedActuator),
        model: &Model,
        found: &Compensation,
        settings: FeedForwardSettings,
    ) -> Result<Self, Error> {
        let (r, u) = (&found.shaped, &found.compensated.u);
        let (actuator, note) = matched((name, actuator), model, &settings)?;
        let actuator = actuator.without_noise();
        let plant = actuator.plant(model, 0)?;
        let gain = TunedScheme::new(Scheme::named("gain")?, model, settings, 0, &MarginTarget::default())?;
        let gain = gain.feed_forward(&*plant, r)?;
        let (with_gain, line) = (settings.limits.clip(&gain.u, model.ts())?, gain.line);
        let NamedReference { from, .. } = NamedReference::new(name, model.ts(), r.clone());
        let error = |y: &[f64]| {
            let aside = mean(&y[from..]) - mean(&r[from..]);
            Metrics::of(&r[from..], &y[from..].iter().map(|y| y - aside).collect::<Vec<_>>())
        };
        let displacements = [&with_gain, u].map(|u| played(&*plant, u));
        let drawn = |i: u64| Ok(error(&played(&*actuator.drawn(0.0, 0, i)?.plant(model, 0)?, u)).rmse);
        let spread = match actuator {
            SimulatedActuator::Twin(_) => None,
            SimulatedActuator::StandIn(_) => {
                let mut errors = (0..DRAWS).map(drawn).collect::<Result<Vec<f64>, Error>>()?;
                errors.sort_by(f64::total_cmp);
                Some([errors[LEFT_OUT], errors[errors.len() - 1 - LEFT_OUT]])
            }
        };
        let errors = displacements.each_ref().map(|y| error(y));
        Ok(OnPlant { plant: name.into(), line, displacements, errors, spread, notes: note.into_iter().collect() })
    }
}

/// The displacement with the voltage `u`, from the settled state at its first value.
pub(super) fn played(plant: &dyn System, u: &[f64]) -> Vec<f64> {
    plant.resume(&mut plant.settled(u.first().copied().unwrap_or_default()), u)
}

/// Its figures.
impl Serialize for OnPlant {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let OnPlant { plant, line, errors: [gain, compensated], spread, notes, .. } = self;
        json!({"plant": plant, "line": line, "gain": gain, "compensated": compensated, "spread": spread, "notes": notes})
            .serialize(to)
    }
}
