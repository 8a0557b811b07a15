//! A drive signal within the limits of a driver.

use crate::error::Error;
use crate::excitation::{Excitation, LimitOptions, Usage};
use crate::formats::Table;
use crate::options::{OptionKind, OptionRow, options};
use serde_json::Value;

options! {
    /// What every kind of drive signal takes.
    pub struct ExciteOptions {
        /// Sampling period.
        ts: f64 = 5e-4, OptionRow::positive("s").required();
        /// Length of the signal.
        duration: f64 = 1.0, OptionRow::positive("s").required();
        /// Clip the signal to the limits, instead of refusing one that exceeds them.
        clip: bool = false, OptionRow::new(OptionKind::Switch);
    } with limits: LimitOptions
}

/// A drive signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Excited {
    /// Sampling period [s].
    pub ts: f64,
    /// The voltages [V].
    pub u: Vec<f64>,
    /// Use of the limits, if there are any.
    pub usage: Option<Usage>,
    /// Number of clipped samples.
    pub clipped: usize,
}

impl ExciteOptions {
    /// The signal of this kind; `given` contains the kind's own options by name.
    ///
    /// # Errors
    /// Returns an error for invalid options, and for a signal that exceeds the limits unless it is to be clipped.
    pub fn run(&self, kind: &Excitation, given: Value) -> Result<Excited, Error> {
        let mut u = kind.samples(self.ts, self.duration, given)?;
        let Some(limits) = self.limits.limits()? else {
            if self.clip {
                let error = Error::parameter("clip", true, "needs limits to clip to: leave it out, or ");
                return Err(error.advised(vec![("driver", Value::Null)]));
            }
            return Ok(Excited { ts: self.ts, u, usage: None, clipped: 0 });
        };
        let mut clipped = 0;
        if self.clip {
            let within = limits.clip(&u, self.ts)?;
            clipped = u.iter().zip(&within).filter(|(u, within)| u != within).count();
            u = within;
        }
        let named = |e: Error| match &self.limits.driver {
            Some(name) => e.about(&format!("driver `{name}`")),
            None => e,
        };
        Ok(Excited { ts: self.ts, usage: Some(limits.refuse(&u, self.ts).map_err(named)?), u, clipped })
    }
}

impl Excited {
    /// The signal as a file of this name.
    ///
    /// # Errors
    /// The errors of [`Table::write`].
    pub fn written(&self, name: &str) -> Result<Vec<u8>, Error> {
        Table::write(name, self.ts, &[("u_V", &self.u)])
    }
}
