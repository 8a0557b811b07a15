//! The plants that schemes run on: twins of the catalogue, and stand-ins for an actuator that was measured.

mod stand_in;

pub use stand_in::{StandIn, StandInPlant};

use super::Scaled;
use crate::compensation::FeedForwardSettings;
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use piezoid_records::record::{Record, Units};
use piezoid_twins::{Plant, Spec};
use serde_json::Value;

/// A simulated actuator.
#[derive(Debug, Clone, PartialEq)]
pub enum SimulatedActuator {
    /// A twin, in V and um.
    Twin(Box<Spec>),
    /// A stand-in for the actuator of some records, in their units.
    StandIn(Box<StandIn>),
}

impl From<Spec> for SimulatedActuator {
    fn from(spec: Spec) -> Self {
        SimulatedActuator::Twin(Box::new(spec))
    }
}

impl From<StandIn> for SimulatedActuator {
    fn from(stand_in: StandIn) -> Self {
        SimulatedActuator::StandIn(Box::new(stand_in))
    }
}

impl SimulatedActuator {
    /// The actuator in the text of a file: the parameters of a twin, or a stand-in.
    ///
    /// # Errors
    /// The errors of [`Spec::from_json`] and [`StandIn::from_json`].
    pub fn from_json(text: &str) -> Result<Self, Error> {
        let document: Option<Value> = serde_json::from_str(text).ok();
        match document.is_some_and(|document| StandIn::is_in(&document)) {
            true => StandIn::from_json(text).map(Self::from),
            false => Spec::from_json(text).map(Self::from),
        }
    }

    /// The same without the noise of its sensor.
    pub fn without_noise(mut self) -> Self {
        *self.noise() = 0.0;
        self
    }

    /// The same with rms noise of the sensor [`unit`].
    ///
    /// # Errors
    /// Returns an error for a unit that cannot be converted to that of the actuator.
    pub fn with_noise(mut self, rms: f64, unit: &str) -> Result<Self, Error> {
        let own = if let SimulatedActuator::StandIn(stand_in) = &self { &stand_in.units().y } else { "m" };
        let factor = Units::factor(unit, own).ok_or_else(|| {
            let why =
                format!("the output of the model is in {unit}, which is not a length: leave out the option noise");
            Error::Content(why)
        })?;
        *self.noise() = rms * factor;
        Ok(self)
    }

    /// The rms noise of its sensor [m, or the output unit of a stand-in].
    fn noise(&mut self) -> &mut f64 {
        match self {
            SimulatedActuator::Twin(spec) => &mut spec.sensor.noise_rms_m,
            SimulatedActuator::StandIn(stand_in) => &mut stand_in.noise,
        }
    }

    /// The plant in the units and with the sampling period of `model`, with noise of `seed`.
    ///
    /// # Errors
    /// The errors of [`Plant::new`]; an error for units that cannot be converted, and for a stand-in with another
    /// sampling period.
    pub fn plant(&self, model: &Model, seed: u64) -> Result<Box<dyn System>, Error> {
        match self {
            SimulatedActuator::Twin(spec) => {
                let plant = Plant::new(spec, model.ts())?.with_seed(seed);
                Ok(Box::new(Scaled::new(plant, "um", model)?))
            }
            SimulatedActuator::StandIn(stand_in) => {
                Record::same_sampling("the model", model.ts(), "the stand-in", stand_in.ts())?;
                let (own, of_model) = (stand_in.units(), &model.units().u);
                if own.u != *of_model {
                    return Err(Error::units("the input of the stand-in", &own.u, of_model));
                }
                Ok(Box::new(Scaled::new(stand_in.plant(seed), &own.y, model)?))
            }
        }
    }

    /// The sampling period of a stand-in [s]; `None` for a twin, which has any.
    pub fn period(&self) -> Option<f64> {
        match self {
            SimulatedActuator::Twin(_) => None,
            SimulatedActuator::StandIn(stand_in) => Some(stand_in.ts()),
        }
    }

    /// Lowest and highest voltage: those of the driver of a twin; for a stand-in, those that its model allows without
    /// limits of a driver, as for a compensation [V].
    ///
    /// # Errors
    /// Returns an error for a driver without limits, a stand-in whose input is no voltage, and the errors of
    /// [`FeedForwardSettings::ends`].
    pub fn voltages(&self) -> Result<(f64, f64), Error> {
        match self {
            SimulatedActuator::Twin(spec) => {
                let (low, high) = (spec.driver.min_v, spec.driver.max_v);
                let ends = Some((low, high)).filter(|_| low.is_finite() && high.is_finite());
                ends.ok_or_else(|| Error::Content("the plant has a driver without limits".into()))
            }
            SimulatedActuator::StandIn(stand_in) => {
                stand_in.in_volts()?;
                FeedForwardSettings::default().ends(stand_in.model())
            }
        }
    }

    /// The plant for voltages [V] every `ts` [s], with noise of `seed`, and the unit of its displacements.
    ///
    /// # Errors
    /// The errors of [`Plant::new`]; an error for a stand-in with another sampling period or whose input is no voltage.
    pub fn played(&self, ts: f64, seed: u64) -> Result<(Box<dyn System>, String), Error> {
        match self {
            SimulatedActuator::Twin(spec) => Ok((Box::new(Plant::new(spec, ts)?.with_seed(seed)), "um".into())),
            SimulatedActuator::StandIn(stand_in) => {
                stand_in.in_volts()?;
                Record::same_sampling("the stand-in", stand_in.ts(), "what is played", ts)?;
                Ok((Box::new(stand_in.plant(seed)), stand_in.units().y.clone()))
            }
        }
    }

    /// Actuator `i` of those drawn with `seed`. The parameters of a twin differ by up to `share` of their values, the
    /// gain of a stand-in too, whose draws also have the spread of its parameters.
    ///
    /// # Errors
    /// Returns an error for a share outside 0 to below 1.
    pub fn drawn(&self, share: f64, seed: u64, i: u64) -> Result<Self, Error> {
        match self {
            SimulatedActuator::Twin(spec) => spec.drawn(share, seed, i).map(Self::from),
            SimulatedActuator::StandIn(stand_in) => stand_in.drawn(share, seed, i).map(Self::from),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::stand_in::tests::with_share;
    use super::*;
    use piezoid_testing::assert_close;
    use piezoid_twins::Preset;

    fn spec() -> Spec {
        Preset::find("pl140").unwrap().spec()
    }

    fn twin() -> SimulatedActuator {
        spec().into()
    }

    fn stand_in() -> SimulatedActuator {
        with_share(0.5).into()
    }

    #[test]
    fn voltages_are_those_of_the_driver_or_of_the_model() {
        let mut spec = spec();
        assert_eq!(twin().voltages(), Ok((spec.driver.min_v, spec.driver.max_v)));
        spec.driver.max_v = f64::INFINITY;
        assert!(SimulatedActuator::from(spec).voltages().unwrap_err().to_string().contains("without limits"));
        // The range of the identification data, -20 to 60 V, and a twentieth more on each side.
        let (low, high) = stand_in().voltages().unwrap();
        assert_close(&[low, high], &[-24.0, 64.0], 1e-12, 0.0);
    }

    #[test]
    fn a_twin_has_any_sampling_period_and_a_stand_in_its_own() {
        let ts = with_share(0.5).ts();
        assert_eq!((twin().period(), stand_in().period()), (None, Some(ts)));
        for ts in [1e-3, 2.5e-4] {
            let (plant, unit) = twin().played(ts, 1).unwrap();
            assert_eq!((plant.ts(), unit.as_str()), (ts, "um"));
        }
        let (plant, unit) = stand_in().played(ts, 1).unwrap();
        assert_eq!((plant.ts(), unit), (ts, with_share(0.5).units().y.clone()));
        assert!(stand_in().played(0.5 * ts, 1).is_err());
    }

    #[test]
    fn noise_is_in_the_unit_that_is_stated() {
        let noise = |mut actuator: SimulatedActuator| *actuator.noise();
        assert_close(&[noise(twin().with_noise(2.0, "um").unwrap())], &[2e-6], 1e-12, 0.0);
        assert_close(&[noise(stand_in().with_noise(2.0, "mm").unwrap())], &[2e3], 1e-12, 0.0);
        assert_eq!([twin(), stand_in()].map(|of| noise(of.with_noise(2.0, "um").unwrap().without_noise())), [0.0; 2]);
        assert!(twin().with_noise(2.0, "V").unwrap_err().to_string().contains("not a length"));
    }

    #[test]
    fn a_file_gives_the_actuator_that_it_was_written_from() {
        let text = with_share(0.5).to_json();
        assert_eq!(SimulatedActuator::from_json(&text), Ok(stand_in()));
        assert_eq!(SimulatedActuator::from_json(&spec().to_json().unwrap()), Ok(twin()));
        assert!(SimulatedActuator::from_json("{").is_err());
    }
}
