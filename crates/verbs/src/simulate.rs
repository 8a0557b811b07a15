//! The response of a plant or a model to a drive signal.

use super::File;
use piezoid_models::hammerstein::InitialCondition;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::quantity;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::series::ends;
use piezoid_numerics::system::System;
use piezoid_records::formats::{ColumnSelection, Table};
use piezoid_records::record::{Record, Units};
use piezoid_twins::{Plant, Spec};

const INITIAL_CONDITIONS: OptionKind = OptionKind::Choice(&[
    ("rest", "At rest, with a jump to the first input"),
    ("settled", "Settled at the first input"),
    ("from-above", "Settled at the first input, after a fall from the top of the range"),
    ("from-below", "Settled at the first input, after a rise from the bottom of the range"),
    ("motion", "In motion as in the record, as if the record had begun earlier"),
]);

options! {
    /// How to simulate.
    #[derive(Copy)]
    pub struct SimulateOptions {
        /// Initial condition: at rest; settled at the first input, directly or after cycles over the whole range; or in
        /// motion as in the record.
        begin: InitialCondition = InitialCondition::Rest, OptionRow::new(INITIAL_CONDITIONS);
        /// Seed of the plant's noise.
        seed: u64 = 1, OptionRow::new(OptionKind::Integer(0, u64::MAX));
    }
}

/// An input and the response to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// Sampling period [s].
    pub ts: f64,
    /// The input.
    pub u: Vec<f64>,
    /// The response.
    pub y: Vec<f64>,
    /// Their units.
    pub units: Units,
    /// The limits that were reached, as text; empty if there were none.
    pub reached: String,
}

impl SimulateOptions {
    /// The response [um] of a plant to the input [V] in a file.
    ///
    /// # Errors
    /// Returns an error for a file without an input. The errors of [`Plant::new`].
    pub fn plant(&self, plant: &Spec, input: &File, columns: &ColumnSelection) -> Result<Simulated, Error> {
        let (ts, u) = input_in("V", input, columns)?;
        let spec = plant;
        let plant = Plant::new(spec, ts)?.with_seed(self.seed);
        let mut x = self.before(&plant, &u);
        let y = plant.resume(&mut x, &u);
        let saturation = plant.saturation(&x);
        let mut reached = if saturation.any() { saturation.to_string() } else { String::new() };
        if saturation.current_limited > 0 {
            let first = if self.begin == InitialCondition::Rest { 0.0 } else { u.first().copied().unwrap_or_default() };
            reached += &jumps(spec, first, &u, ts).unwrap_or_default();
        }
        Simulated { ts, u, y, units: Units::default(), reached }.bounded()
    }

    /// The state of a plant before the input `u` [V].
    pub fn before(&self, plant: &Plant, u: &[f64]) -> Vec<f64> {
        let settled = || plant.settled(u.first().copied().unwrap_or_default());
        match self.begin {
            InitialCondition::Rest => plant.initial(),
            InitialCondition::Settled => settled(),
            InitialCondition::Motion => {
                let mut x = settled();
                plant.resume(&mut x, u);
                x
            }
            InitialCondition::FromAbove | InitialCondition::FromBelow => {
                let mut x = settled();
                let sweep = self.begin.inputs_before(u, ends(u.iter().copied()));
                let waits = std::iter::repeat_n(sweep[sweep.len() - 1], sweep.len());
                plant.resume(&mut x, &sweep.iter().copied().chain(waits).collect::<Vec<_>>());
                x
            }
        }
    }

    /// The response of a model to the input in a file.
    ///
    /// # Errors
    /// Returns an error for files without an input or a model, and for an input with another unit or sampling period.
    pub fn model(&self, model: &File, input: &File, columns: &ColumnSelection) -> Result<Simulated, Error> {
        let model = model.model()?;
        let units = model.units().clone();
        let (ts, u) = input_in(&units.u, input, columns)?;
        Record::same_sampling("the model", model.ts(), "the input", ts).map_err(|e| e.of(&input.name))?;
        let mut x = model.before(&u, self.begin);
        let y = model.resume(&mut x, &u);
        Simulated { ts, u, y, units, reached: String::new() }.bounded()
    }
}

/// Why the current is at its limit although the drive is slow enough for the driver, after the voltage `first` [V]: a
/// held voltage jumps from sample to sample, and a plan counts the mean current over a sampling period. `None` if the
/// drive is too fast.
fn jumps(spec: &Spec, first: f64, u: &[f64], ts: f64) -> Option<String> {
    let (limit, farad) = (spec.driver.current_a?, spec.driver.capacitance_f);
    let inside = std::iter::once(first).chain(u.iter().copied()).map(|u| u.clamp(spec.driver.min_v, spec.driver.max_v));
    let inside: Vec<f64> = inside.collect();
    let most = inside.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max) * farad / ts;
    let rounded = |current: f64| format!("{current:.3e}").parse().unwrap_or(current);
    (most <= limit).then(|| {
        format!(
            " at the jump from one held voltage to the next, and only there. The driver can follow the drive: the mean \
             current over a sampling period, which plans compare with the limit, is at most {} of {}. A shorter \
             sampling period makes the jumps smaller",
            quantity(rounded(most), "A"),
            quantity(limit, "A")
        )
    })
}

/// The sampling period and the input in a file, in a unit.
fn input_in(unit: &str, file: &File, columns: &ColumnSelection) -> Result<(f64, Vec<f64>), Error> {
    let input = file.input(columns)?;
    let ts = input.ts;
    Ok((ts, input.samples_in(unit, "the input").map_err(|error| error.of(&file.name))?))
}

impl Simulated {
    /// Returns an error if the response is not finite.
    fn bounded(self) -> Result<Self, Error> {
        let Some(k) = self.y.iter().position(|y| !y.is_finite()) else { return Ok(self) };
        let time = k as f64 * self.ts;
        let why = "the model is unstable, or the input far too large";
        Err(Error::Content(format!("the output overflows at {time} s: {why}")))
    }

    /// Input and response as a file of this name.
    ///
    /// # Errors
    /// The errors of [`Table::write`].
    pub fn written(&self, name: &str) -> Result<Vec<u8>, Error> {
        let (u, y) = (format!("u_{}", self.units.u), format!("y_{}", self.units.y));
        Table::write(name, self.ts, &[(&u, &self.u), (&y, &self.y)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_twins::Preset;

    /// A sine of 50 Hz every 1 ms is planned with a seventh of the driver's current; the twin then reported that the
    /// current was at its limit.
    #[test]
    fn a_drive_that_the_driver_follows_is_told_to_reach_the_limit_in_jumps_only() {
        let reached = |volts: f64, ts: f64| {
            let u: Vec<f64> = (0..200).map(|t| volts * (0.314_159 * f64::from(t)).sin()).collect();
            let input = File::new("u.csv", Table::write("u.csv", ts, &[("u_V", &u)]).unwrap());
            let spec = Preset::find("pl140").unwrap().spec();
            SimulateOptions::default().plant(&spec, &input, &ColumnSelection::default()).unwrap().reached
        };
        let (slow, fast) = (reached(28.0, 1e-3), reached(28.0, 5e-5));
        assert!(slow.contains("samples limited by the driver's current at the jump from one held"), "{slow}");
        assert!(slow.contains("is at most 70.95 mA of 500 mA"), "{slow}");
        assert!(fast.ends_with("samples limited by the driver's current"), "{fast}");
        assert_eq!(reached(10.0, 1e-3), "");
    }
}
