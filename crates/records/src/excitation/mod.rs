//! Excitations: voltages that drive an actuator for its identification.
//!
//! Small broad-band excitations ([`Prbs`], [`Multisine`]) identify the linear block; large ones ([`RisingSine`],
//! [`Sine`], [`Triangle`], [`Staircase`], [`SteppedSine`]) exercise the hysteresis; a [`DecayingSine`] demagnetises
//! it; a [`Chirp`] sweeps through the resonance; `moves` is a path through points. [`Limits`] checks that a driver can
//! deliver them; [`DRIVERS`] and [`ACTUATORS`] have figures of data sheets. Every excitation is `offset + amplitude
//! s(t)` with `|s| <= 1`, starts as its documentation says, and is the same for the same settings.
//!
//! [`EXCITATIONS`] is the list that the command line and Python use. A new kind needs one file, one `mod` line and one
//! row.
//!
//! Reference: Pintelon and Schoukens, System Identification: A Frequency Domain Approach, 2012,
//! DOI 10.1002/9781118287422.

mod actuators;
mod chirp;
mod crest;
mod decaying_sine;
mod drive;
mod drivers;
mod limits;
mod moves;
mod multisine;
mod prbs;
mod rising_sine;
mod rows;
mod sine;
mod staircase;
mod stepped_sine;
mod triangle;

pub use actuators::{ACTUATORS, Actuator};
pub use chirp::Chirp;
pub use decaying_sine::DecayingSine;
pub use drivers::{Amplifier, DRIVERS, LimitOptions};
pub use limits::{Limits, Peak, Usage};
pub use moves::minimum_jerk;
pub use multisine::Multisine;
pub use prbs::Prbs;
pub use rising_sine::RisingSine;
pub use sine::Sine;
pub use staircase::Staircase;
pub use stepped_sine::SteppedSine;
pub use triangle::Triangle;

use piezoid_numerics::error::{Error, positive, row};
use piezoid_numerics::options::{OptionRow, rows_of};
use serde::Serialize;
use serde_json::Value;

/// One kind of excitation.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Excitation {
    /// Name in every front end.
    pub name: &'static str,
    /// Summary in one line, with its purpose.
    pub summary: &'static str,
    /// Reference for a description.
    pub reference: &'static str,
    /// Its options.
    #[serde(rename = "options", serialize_with = "rows_of")]
    pub rows: fn() -> Vec<OptionRow>,
    #[serde(skip)]
    generate: fn(Value, ts: f64, n: usize) -> Result<Vec<f64>, Error>,
}

/// All kinds.
pub static EXCITATIONS: &[Excitation] = &[
    prbs::ROW,
    multisine::ROW,
    chirp::ROW,
    sine::ROW,
    rising_sine::ROW,
    decaying_sine::ROW,
    triangle::ROW,
    staircase::ROW,
    stepped_sine::ROW,
    moves::ROW,
];

const PINTELON_SCHOUKENS: &str = "Pintelon and Schoukens, System Identification, 2012, DOI 10.1002/9781118287422";

/// Maximum number of samples: 0.8 GB.
const MAX_SAMPLES: usize = 100_000_000;

impl Excitation {
    /// The excitation called `name`.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the known names.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        row("excitation", EXCITATIONS.iter(), |row| row.name, name)
    }

    /// The voltages [V], every `ts` [s] for a `duration` [s]: `round(duration / ts)` samples. `arguments` contains the
    /// options by name.
    ///
    /// ```
    /// let sine = piezoid::excitation::Excitation::find("sine")?;
    /// let u = sine.samples(5e-4, 1.0, serde_json::json!({"amplitude": 30.0, "frequency": 5.0}))?;
    /// assert_eq!((u.len(), u[0], u[100]), (2000, 0.0, 30.0));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error for unknown and missing options, and for invalid values.
    pub fn samples(&self, ts: f64, duration: f64, arguments: Value) -> Result<Vec<f64>, Error> {
        positive("ts", ts, "seconds")?;
        positive("duration", duration, "seconds")?;
        let n = (duration / ts).round();
        if !(1.0..=MAX_SAMPLES as f64).contains(&n) {
            let rule = format!("must give from 1 to {MAX_SAMPLES} samples, not {n}, at ts = {ts} s");
            return Err(Error::parameter("duration", format!("{duration} s"), rule));
        }
        (self.generate)(arguments, ts, n as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const AMPLITUDE: f64 = 7.3;
    const OFFSET: f64 = -2.1;

    /// One second of an excitation, with its defaults and with usable values of the required options.
    fn example(excitation: &Excitation) -> Vec<f64> {
        let value = |row: OptionRow| match row.name {
            "amplitude" => Some(("amplitude", AMPLITUDE)),
            "offset" => Some(("offset", OFFSET)),
            "frequency_start" | "frequency_low" => Some((row.name, 3.0)),
            name if row.required => Some((name, 50.0)),
            _ => None,
        };
        excitation
            .samples(5e-4, 1.0, (excitation.rows)().into_iter().filter_map(value).collect())
            .unwrap_or_else(|e| panic!("{}: {e}", excitation.name))
    }

    #[test]
    fn every_excitation_stays_within_its_amplitude_and_reaches_it() {
        for excitation in EXCITATIONS {
            let u = example(excitation);
            assert_eq!(u.len(), 2000);
            let (low, high) = u.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
            assert!(u.iter().all(|v| v.is_finite()), "{}", excitation.name);
            assert!(low >= OFFSET - AMPLITUDE && high <= OFFSET + AMPLITUDE, "{}: {low}, {high}", excitation.name);
            assert!((high - OFFSET).max(OFFSET - low) > 0.99 * AMPLITUDE, "{}: {low}, {high}", excitation.name);
        }
    }

    #[test]
    fn every_excitation_is_the_same_twice() {
        for excitation in EXCITATIONS {
            assert_eq!(example(excitation), example(excitation), "{}", excitation.name);
        }
    }

    #[test]
    fn every_excitation_is_described_and_its_parameters_are_named_alike() {
        for (i, e) in EXCITATIONS.iter().enumerate() {
            assert!(!e.summary.is_empty() && !e.reference.is_empty(), "{}", e.name);
            assert!(EXCITATIONS[..i].iter().all(|other| other.name != e.name), "{} twice", e.name);
            let rows = (e.rows)();
            assert!(["amplitude", "offset"].iter().all(|name| rows.iter().any(|row| row.name == *name)));
            assert!(rows.iter().all(|row| row.required || row.fit((row.default)()).is_ok()), "{}", e.name);
            assert_eq!(Excitation::find(e.name).unwrap().name, e.name);
        }
    }

    #[test]
    fn every_excitation_refuses_an_amplitude_of_zero() {
        for excitation in EXCITATIONS {
            let required = (excitation.rows)().into_iter().filter(|row| row.required);
            let arguments = required.map(|row| (row.name, if row.name == "amplitude" { 0.0 } else { 10.0 })).collect();
            let error = excitation.samples(1e-3, 1.0, arguments).unwrap_err();
            assert!(error.to_string().starts_with("amplitude = 0"), "{}: {error}", excitation.name);
        }
    }

    #[test]
    fn an_option_that_is_unknown_missing_or_no_number_is_refused_by_its_name() {
        let refusal = |arguments: Value| {
            Excitation::find("stepped-sine").unwrap().samples(1e-3, 1.0, arguments).unwrap_err().to_string()
        };
        assert!(refusal(json!({"amplitud": 1.0})).ends_with("did you mean `amplitude`?"));
        assert!(
            refusal(json!({"amplitude": 1.0})).starts_with("frequency = (not given): must be a positive number [Hz]")
        );
        let steps = |steps: Value| refusal(json!({"amplitude": 1.0, "frequency": 700.0, "steps": steps}));
        assert!(steps(json!(7.5)).starts_with("steps = 7.5: must be a whole number from 3"));
        assert!(steps(json!(7.0)).starts_with("frequency = 700"), "a number that is whole counts something");
    }

    #[test]
    fn a_duration_that_makes_no_sense_is_refused() {
        let prbs = Excitation::find("prbs").unwrap();
        let message = |ts, duration| prbs.samples(ts, duration, json!({"amplitude": 1.0})).unwrap_err().to_string();
        assert!(message(1e-3, 0.0).starts_with("duration = 0"));
        assert!(message(-1.0, 1.0).starts_with("ts = -1"));
        assert!(message(1.0, 0.4).contains("from 1 to 100000000 samples, not 0"));
        assert!(message(1e-6, 1e6).contains("not 1000000000000"));
        assert!(Excitation::find("sinus").unwrap_err().to_string().contains("known are prbs, multisine"));
    }
}
