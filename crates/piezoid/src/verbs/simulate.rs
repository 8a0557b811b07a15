//! The response of a plant or a model to a drive signal.

use super::File;
use crate::error::Error;
use crate::formats::{ColumnSelection, Table};
use crate::hammerstein::InitialCondition;
use crate::options::{OptionKind, OptionRow, options};
use crate::plant::{Plant, Spec};
use crate::record::{Record, Units};
use crate::series::ends;
use crate::system::System;

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
        /// Initial condition: rest; settled at the first input, without a past or after cycles over the whole range;
        /// or already in the motion of the record.
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
        let plant = Plant::new(plant, ts)?.with_seed(self.seed);
        let mut x = self.before(&plant, &u);
        let y = plant.resume(&mut x, &u).iter().map(|y| y * 1e6).collect();
        let saturation = plant.saturation(&x);
        let reached = if saturation.any() { saturation.to_string() } else { String::new() };
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
