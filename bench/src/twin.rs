//! Twins of a bender with creep, noise and a driver, as they are measured for docs/accuracy.md and docs/control.md: the
//! records to identify from, which a user could take, and validation records that are unlike them.

use piezoid::excitation::{Multisine, Prbs, RisingSine, Sine, Staircase};
use piezoid::feedback::Structure;
use piezoid::hammerstein::{Identified, Model};
use piezoid::plant::{Plant, Preset, Spec};
use piezoid::validation::Metrics;
use piezoid::{Error, IdentifyOptions, Method, Record, Records, System, identify};
use std::f64::consts::{SQRT_2, TAU};

/// Sampling period [s].
pub const TS: f64 = 5e-4;

/// The twins. Their true hysteresis is a Preisach density and a Bouc-Wen law.
pub const TWINS: [&str; 2] = ["pl140", "pl140-bouc-wen"];

/// A twin with effects that no model has.
pub const OUTSIDE: &str = "pl140-nonlinear";

/// Frequencies [Hz] and durations [s] of the training sines.
const SEEN: [(f64, f64); 6] = [(1.0, 8.0), (5.0, 4.0), (20.0, 3.0), (40.0, 3.0), (80.0, 3.0), (160.0, 3.0)];

/// Periods of the PRBS, of 2047 samples each.
const PERIODS: usize = 3;

/// Minimum duration of a validation record [s], and its minimum number of periods.
const DURATION: f64 = 2.0;
const CYCLES: f64 = 6.0;

/// Largest amplitude [V], and limit of the displacement [um]. The amplitude is reduced if the limit would be exceeded.
const AMPLITUDE: f64 = 28.0;
const REACH: f64 = 1200.0;

/// The input of a validation record, from frequency [Hz], amplitude [V] and number of samples.
type DriveSignal = fn(f64, f64, usize) -> Result<Vec<f64>, Error>;

/// A kind of validation record.
pub struct RecordKind {
    /// Its name in the tables.
    pub name: &'static str,
    drive: DriveSignal,
}

/// All kinds. The training data contain none of them.
pub static KINDS: [RecordKind; 3] = [
    RecordKind {
        name: "staircase",
        drive: |frequency, amplitude, n| Staircase { amplitude, frequency, ..Staircase::default() }.samples(TS, n),
    },
    RecordKind {
        name: "modulated sine",
        drive: |hz, amplitude, n| Ok((0..n).map(|t| modulated(hz, amplitude, t)).collect()),
    },
    RecordKind {
        name: "multisine",
        drive: |hz, amplitude, n| {
            let random = Multisine { seed: 1, ..Multisine::default() };
            Multisine { amplitude, frequency_low: hz / 12.0, frequency_high: hz, ..random }.samples(TS, n)
        },
    },
];

/// A sine whose amplitude is modulated at an incommensurate frequency.
fn modulated(hz: f64, amplitude: f64, t: usize) -> f64 {
    let turns = TAU * hz * TS * t as f64;
    amplitude * (0.5 + 0.5 * (turns * SQRT_2 / 9.0).sin()) * turns.sin()
}

/// A twin and its parameters.
pub struct Twin {
    plant: Plant,
    spec: Spec,
}

impl Twin {
    /// The twin called `name`.
    pub fn new(name: &str) -> Result<Self, Error> {
        Twin::of(&Preset::find(name)?.spec())
    }

    /// The twin of these parameters.
    pub fn of(spec: &Spec) -> Result<Self, Error> {
        Ok(Twin { plant: Plant::new(spec, TS)?, spec: spec.clone() })
    }

    /// Measures the response to a drive from rest [um]. The amplitude is reduced until the displacement stays within
    /// the limit. The seed sets the noise.
    fn measure(&self, drive: impl Fn(f64) -> Result<Vec<f64>, Error>, seed: f64) -> Result<Record, Error> {
        let plant = self.plant.clone().with_seed(seed as u64);
        let mut amplitude = AMPLITUDE;
        loop {
            let u = drive(amplitude)?;
            let y = plant.run(&u).y;
            let peak = y.iter().fold(0.0f64, |peak, y| peak.max(y.abs()));
            if peak <= REACH {
                return Record::new(TS, u, y);
            }
            amplitude *= (0.99 * REACH / peak).max(0.5);
        }
    }

    /// A PRBS of 1 V.
    fn small(&self) -> Result<Record, Error> {
        let prbs = Prbs::default();
        self.measure(|_| prbs.samples(TS, PERIODS * prbs.period() as usize), 0.0)
    }

    /// A training record for each frequency.
    fn sines(&self, drive: DriveSignal) -> Result<Vec<Record>, Error> {
        let record = |(hz, s)| self.measure(|amplitude| drive(hz, amplitude, (s / TS) as usize), hz);
        SEEN.into_iter().map(record).collect()
    }

    /// A model of the PRBS and rising sines.
    fn identified(&self, options: &IdentifyOptions) -> Result<Identified, Error> {
        let rising =
            |frequency, amplitude, n| RisingSine { amplitude, frequency, ..RisingSine::default() }.samples(TS, n);
        identify(Records { small_signal: &[self.small()?], large_signal: &self.sines(rising)? }, options)
    }

    /// One joint model for all frequencies, from the PRBS and rising sines.
    pub fn joint(&self, operator: &str, driver: bool) -> Result<Identified, Error> {
        let options = IdentifyOptions { operator: operator.into(), seed: 0, ..IdentifyOptions::default() };
        self.identified(&if driver { options.with_driver_of(&self.spec) } else { options })
    }

    /// The same with the driver given, of the structure that suits the records.
    pub fn joint_by(&self, operator: &str, structure: Structure) -> Result<Identified, Error> {
        let options = IdentifyOptions { operator: operator.into(), structure, ..IdentifyOptions::default() };
        self.identified(&options.with_driver_of(&self.spec))
    }

    /// Its output for these inputs from rest, with noise [um].
    pub fn response(&self, u: &[f64]) -> Vec<f64> {
        self.plant.run(u).y
    }

    /// The model by the paper's method, which needs loops of steady sines.
    pub fn paper(&self, options: IdentifyOptions) -> Result<Identified, Error> {
        let steady = |frequency, amplitude, n| Sine { amplitude, frequency, ..Sine::default() }.samples(TS, n);
        let options = IdentifyOptions { method: Method::Paper, ..options };
        identify(Records { small_signal: &[self.small()?], large_signal: &self.sines(steady)? }, &options)
    }

    /// A validation record of this kind and frequency [Hz].
    pub fn validation(&self, kind: &RecordKind, hz: f64) -> Result<Record, Error> {
        let n = (DURATION.max(CYCLES / hz) / TS) as usize;
        self.measure(|amplitude| (kind.drive)(hz, amplitude, n), 1000.0 + hz)
    }
}

/// The rms error of a free run of `model` from rest [% of peak-to-peak].
pub fn error(model: &Model, record: &Record) -> f64 {
    Metrics::of(record.y(), &model.simulate(record.u())).rms_pp_percent
}
