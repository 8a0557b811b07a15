//! The driver in front of the actuator, whose limits a voltage must keep.

use crate::values::{Misused, argument, farads};
use anyhow::{Error, Result, anyhow};
use clap::Args;
use piezoid::excitation::{Driver, Limits};

/// The driver and its load.
#[derive(Args)]
pub(crate) struct Amplifier {
    /// The driver whose limits the voltage must keep (see `piezoid drivers`).
    #[arg(long, value_name = "NAME")]
    pub(crate) driver: Option<String>,
    /// Capacitance of the load, for the driver's current limit.
    #[arg(long, value_name = "FARAD", requires = "driver", value_parser = farads)]
    capacitance: Option<f64>,
}

impl Amplifier {
    /// The limits of the driver, if one is named.
    pub(crate) fn limits(&self) -> Result<Option<Limits>> {
        self.driver.as_deref().map(|name| driver_limits(name, self.capacitance)).transpose()
    }

    /// What the library says of limits and references, with the option that helps.
    pub(crate) fn advised(&self, error: piezoid::Error) -> Error {
        match error {
            piezoid::Error::Limits(_) | piezoid::Error::Unreachable(_) => anyhow!("{error} (--clip)"),
            piezoid::Error::Parameter { ref name, .. } if self.driver.is_none() && name.starts_with("limits") => {
                anyhow!("{error} (--driver)")
            }
            other => other.into(),
        }
    }
}

/// The limits of a driver with its load.
pub(crate) fn driver_limits(name: &str, capacitance: Option<f64>) -> Result<Limits> {
    let limits = argument(Driver::find(name))?.loaded(capacitance);
    Ok(limits.map_err(|e| Misused(format!("{e} (--capacitance)")))?)
}
