//! A drive signal within the limits of a driver, or a reference of the same form.

use piezoid_numerics::error::Error;
use piezoid_numerics::number::ascii_unit;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_records::excitation::{Excitation, LimitOptions, Usage};
use piezoid_records::formats::Table;
use serde_json::Value;

/// The unit of drive signals.
const VOLT: &str = "V";

options! {
    /// Options of all kinds of signals.
    pub struct ExciteOptions {
        /// Sampling period.
        ts: f64 = 5e-4, OptionRow::positive("s").required();
        /// Duration of the signal.
        duration: f64 = 1.0, OptionRow::positive("s").required();
        /// Clip the signal to the limits, instead of refusing one that exceeds them.
        clip: bool = false, OptionRow::new(OptionKind::Switch);
        /// Unit of the amplitude: `V` for a drive signal, a unit of displacement such as `um` for a reference.
        unit: String = "V".into(), OptionRow::new(OptionKind::Text("UNIT"));
    } with limits: LimitOptions
}

/// A drive signal, or a reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Excited {
    /// Sampling period [s].
    pub ts: f64,
    /// The voltages, or the displacements of a reference [`unit`](Self::unit).
    pub u: Vec<f64>,
    /// `V`, or the unit of the reference.
    pub unit: String,
    /// Use of the limits, if there are any.
    pub usage: Option<Usage>,
    /// Number of clipped samples.
    pub clipped: usize,
}

impl ExciteOptions {
    /// The signal of this kind; `arguments` contains the kind's own options by name.
    ///
    /// # Errors
    /// Returns an error for invalid options, for a signal that exceeds the limits unless it is to be clipped, and for
    /// limits together with a reference, which has none.
    pub fn run(&self, kind: &Excitation, arguments: Value) -> Result<Excited, Error> {
        let mut u = kind.samples(self.ts, self.duration, arguments)?;
        let unit = ascii_unit(&self.unit);
        if unit.is_empty() || !unit.chars().all(char::is_alphanumeric) {
            return Err(Error::parameter("unit", &self.unit, "must be a unit such as V, um or mrad"));
        }
        let limits = self.limits.limits()?;
        if limits.is_some() && unit != VOLT {
            let rule = "is not a voltage, but limits apply to voltages: leave the limits out";
            return Err(Error::parameter("unit", unit, rule));
        }
        let Some(limits) = limits else {
            if self.clip {
                let error = Error::parameter("clip", true, "needs limits to clip to: leave it out, or ");
                return Err(error.advised(vec![("driver", Value::Null)]));
            }
            return Ok(Excited { ts: self.ts, u, unit, usage: None, clipped: 0 });
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
        Ok(Excited { ts: self.ts, usage: Some(limits.refuse(&u, self.ts).map_err(named)?), u, unit, clipped })
    }
}

impl Excited {
    /// The signal as a file of this name, in a column `u_V` or, for a reference in um, `r_um`.
    ///
    /// # Errors
    /// The errors of [`Table::write`].
    pub fn written(&self, name: &str) -> Result<Vec<u8>, Error> {
        let column = if self.unit == VOLT { "u_V".to_string() } else { format!("r_{}", self.unit) };
        Table::write(name, self.ts, &[(&column, &self.u)])
    }
}
