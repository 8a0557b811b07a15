//! Excitations: the voltages that make an actuator show what it is.
//!
//! Small and broad-band ones ([`Prbs`], [`Multisine`]) identify the linear block; rich ones ([`RisingSine`], [`Sine`],
//! [`Triangle`], [`Staircase`], [`SteppedSine`]) exercise the hysteresis; a [`Chirp`] passes through the resonance. [`Limits`] tells
//! whether a driver can deliver them. Every excitation is `offset + amplitude s(t)` with `|s| <= 1`, starts where its own
//! page says, and is the same for the same settings.
//!
//! [`EXCITATIONS`] is the list that the command line, Python and the web page iterate. A new kind costs one file, one
//! `mod` line and one row.
//!
//! Reference: Pintelon and Schoukens, System Identification: A Frequency Domain Approach, 2012,
//! DOI 10.1002/9781118287422.

mod chirp;
mod crest;
mod drive;
mod drivers;
mod limits;
mod multisine;
mod parameter;
mod prbs;
mod rising_sine;
mod sine;
mod staircase;
mod stepped_sine;
mod triangle;

pub use chirp::{Chirp, Sweep};
pub use drivers::{DRIVERS, Driver};
pub use limits::{Limits, Peak, Usage};
pub use multisine::Multisine;
pub use parameter::Parameter;
pub use prbs::Prbs;
pub use rising_sine::RisingSine;
pub use sine::Sine;
pub use staircase::Staircase;
pub use stepped_sine::SteppedSine;
pub use triangle::Triangle;

use crate::error::{Error, positive, row};
use parameter::Values;

/// One kind of excitation.
#[derive(Debug, Clone, Copy)]
pub struct Excitation {
    /// What it is called in every front end.
    pub name: &'static str,
    /// What it is and what it is for, in one line.
    pub summary: &'static str,
    /// Where it is described.
    pub reference: &'static str,
    /// Its settings.
    pub parameters: &'static [Parameter],
    generate: fn(&Values, ts: f64, n: usize) -> Result<Vec<f64>, Error>,
}

/// Every kind there is.
pub static EXCITATIONS: &[Excitation] = &[
    prbs::ROW,
    multisine::ROW,
    chirp::ROW,
    sine::ROW,
    rising_sine::ROW,
    triangle::ROW,
    staircase::ROW,
    stepped_sine::ROW,
];

const PINTELON_SCHOUKENS: &str = "Pintelon and Schoukens, System Identification, 2012, DOI 10.1002/9781118287422";

/// The most samples that are made: 0.8 GB of them.
const MOST: usize = 100_000_000;

impl Excitation {
    /// The excitation called `name`.    ///
    /// # Errors
    /// [`Error::Unknown`] with the names there are.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        row("excitation", EXCITATIONS.iter(), |row| row.name, name)
    }
}

impl Excitation {
    /// The voltages [V], every `ts` [s] for a `duration` [s]: `round(duration / ts)` samples.
    ///
    /// ```
    /// let sine = piezoid::excitation::Excitation::find("sine")?;
    /// let u = sine.samples(5e-4, 1.0, &[("amplitude", 30.0), ("frequency", 5.0)])?;
    /// assert_eq!((u.len(), u[0], u[100]), (2000, 0.0, 30.0));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Unknown, missing and non-finite settings, and those that the kind itself refuses.
    pub fn samples(&self, ts: f64, duration: f64, values: &[(&str, f64)]) -> Result<Vec<f64>, Error> {
        positive("ts", ts, "seconds")?;
        positive("duration", duration, "seconds")?;
        let n = (duration / ts).round();
        if !(1.0..=MOST as f64).contains(&n) {
            let rule = format!("must give from 1 to {MOST} samples, not {n}, at ts = {ts} s");
            return Err(Error::parameter("duration", format!("{duration} s"), rule));
        }
        (self.generate)(&Values::new(self.name, self.parameters, values)?, ts, n as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AMPLITUDE: f64 = 7.3;
    const OFFSET: f64 = -2.1;

    /// A second of an excitation with its defaults and something reasonable for what it requires.
    fn example(excitation: &Excitation) -> Vec<f64> {
        let values: Vec<(&str, f64)> = excitation
            .parameters
            .iter()
            .filter_map(|p| match p.name {
                "amplitude" => Some(("amplitude", AMPLITUDE)),
                "offset" => Some(("offset", OFFSET)),
                "frequency-start" | "frequency-low" => Some((p.name, 3.0)),
                name if p.default.is_none() => Some((name, 50.0)),
                _ => None,
            })
            .collect();
        excitation.samples(5e-4, 1.0, &values).unwrap_or_else(|e| panic!("{}: {e}", excitation.name))
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
            assert!(["amplitude", "offset"].iter().all(|name| e.parameters.iter().any(|p| p.name == *name)));
            for (j, p) in e.parameters.iter().enumerate() {
                assert!(p.name.chars().all(|c| c.is_ascii_lowercase() || c == '-') && !p.help.is_empty(), "{}", p.name);
                assert!(e.parameters[..j].iter().all(|other| other.name != p.name), "{} twice", p.name);
            }
            assert_eq!(Excitation::find(e.name).unwrap().name, e.name);
        }
    }

    #[test]
    fn every_excitation_refuses_an_amplitude_of_zero() {
        for excitation in EXCITATIONS {
            let required = excitation.parameters.iter().filter(|p| p.default.is_none());
            let values: Vec<(&str, f64)> =
                required.map(|p| (p.name, if p.name == "amplitude" { 0.0 } else { 10.0 })).collect();
            let error = excitation.samples(1e-3, 1.0, &values).unwrap_err();
            assert!(error.to_string().starts_with("amplitude = 0"), "{}: {error}", excitation.name);
        }
    }

    #[test]
    fn the_defaults_of_the_rows_are_those_of_the_structs() {
        let row = |name: &str, extra: &[(&str, f64)]| {
            Excitation::find(name).unwrap().samples(1e-3, 2.0, &[&[("amplitude", 1.0)], extra].concat())
        };
        let frequency = [("frequency", 1.0)];
        assert_eq!(row("prbs", &[]), Prbs::default().samples(1e-3, 2000));
        assert_eq!(row("sine", &frequency), Sine::default().samples(1e-3, 2000));
        assert_eq!(row("triangle", &frequency), Triangle::default().samples(1e-3, 2000));
        assert_eq!(row("staircase", &frequency), Staircase::default().samples(1e-3, 2000));
        assert_eq!(row("rising-sine", &frequency), RisingSine::default().samples(1e-3, 2000));
        let sweep = [("frequency-start", 1.0), ("frequency-end", 100.0)];
        assert_eq!(row("chirp", &sweep), Chirp::default().samples(1e-3, 2000));
        let band = [("frequency-low", 1.0), ("frequency-high", 100.0)];
        assert_eq!(row("multisine", &band), Multisine::default().samples(1e-3, 2000));
    }

    #[test]
    fn a_duration_that_makes_no_sense_is_refused() {
        let prbs = Excitation::find("prbs").unwrap();
        let message = |ts, duration| prbs.samples(ts, duration, &[("amplitude", 1.0)]).unwrap_err().to_string();
        assert!(message(1e-3, 0.0).starts_with("duration = 0"));
        assert!(message(-1.0, 1.0).starts_with("ts = -1"));
        assert!(message(1.0, 0.4).contains("from 1 to 100000000 samples, not 0"));
        assert!(message(1e-6, 1e6).contains("not 1000000000000"));
        assert!(Excitation::find("sinus").unwrap_err().to_string().contains("known are prbs, multisine"));
    }
}
