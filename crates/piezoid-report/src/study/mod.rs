//! The paper's experiment as data: identification on a PRBS and sines, test on stepped sines, frequency by frequency;
//! and its Table 1 for other test signals, because the paper states only that its signal is periodic and step-wise.
//!
//! The paper's methods identify one model per frequency, from the PRBS and a sine of that frequency and amplitude. The
//! joint method identifies a single model for all, from the same PRBS and four rising sines; half of the test
//! frequencies are not in its data. The summaries in [`METHODS`] state the differences, and whether a property is the
//! paper's or ours. The plant returns only what an experimenter can measure, and no model uses a test record. The joint
//! model is given the lag and current limit of the plant's driver, which its experimenter knows.
//!
//! Why: docs/decisions/study-of-the-paper.md, "The study's joint model is the better of two operators".

mod bench;
mod document;
mod figures;
mod page;
mod test_signal;
mod words;

pub use test_signal::TestSignal;

use crate::plot::Figure;
use bench::Bench;
use piezoid::excitation::Prbs;
use piezoid::hysteresis::HeldInput;
use piezoid::linear::{self, Arx, Fit, Orders};
use piezoid::optimize::swarm::{GlobalBest, SwarmSettings};
use piezoid::plant::Preset;
use piezoid::progress::{Progress, Stage};
use piezoid::validation::Metrics;
use piezoid::{Error, Identified, IdentifyOptions, Model, Record, Records};
use piezoid_models::hammerstein::HiddenLoop;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_verbs::File;
use serde::Serialize;

/// Sampling period [s], the paper's.
const TS: f64 = 5e-4;

/// Table 2 of the paper: frequency [Hz], and a1, a2, b0, b1, b2. According to the paper the block is identified only
/// once, but the table has one row per frequency, with different b0 (50 Hz has that of 80 Hz). The unit is not stated;
/// mm/V is assumed.
const TABLE_2: [(f64, [f64; 5]); 2] =
    [(5.0, [1.7424, -0.9453, 0.0012, -0.0004, -0.0003]), (80.0, [1.7424, -0.9453, 0.0011, -0.0004, -0.0003])];

/// Amplitude of the sines, plain and stepped [V]: the whole range of the PL140.
const AMPLITUDE: f64 = 30.0;

/// Amplitude of the PRBS [V], at which the hysteresis opens by less than 1 %.
const PRBS_AMPLITUDE_V: f64 = 1.0;

/// Length of a sine, plain or stepped, and the settling time at its start [s].
const DURATION: f64 = 2.0;
const SETTLING: f64 = 0.5;

/// Largest used share of the sensor's range; the drive is reduced if needed.
const RANGE_USED: f64 = 0.6;

/// Number of averages per branch.
const BINS: usize = 16;

/// Frequencies [Hz] of the rising sines of the joint model, and their length [s].
const RISING: [f64; 4] = [5.0, 20.0, 80.0, 160.0];
const RISING_DURATION: f64 = 1.0;

/// Operators of the joint model; the better one is selected: the usual law of the literature, and the one closest to
/// measured ceramics. Fits of all laws (`auto`) would take ten times as long.
const OPERATORS: &str = "bouc-wen, preisach";

/// Levels of the Preisach operator.
const LEVELS: usize = 20;

/// A method to predict the test signal: a row of [`METHODS`].
#[derive(Debug, Serialize)]
pub struct StudyMethod {
    /// Name in tables and files.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    #[serde(skip)]
    way: MethodModel,
}

#[derive(Debug, Clone, Copy)]
enum MethodModel {
    /// Two branches of the loop at each frequency, from the printed or the estimated linear block.
    Branches(LoopSource, HeldInput),
    /// One gain per frequency.
    Gain,
    /// One model for all frequencies.
    Joint,
}

/// The linear block whose inverse gives the loop.
#[derive(Debug, Clone, Copy)]
enum LoopSource {
    ByTable2,
    ByOwn,
}

/// The methods compared.
pub static METHODS: &[StudyMethod] = &[
    StudyMethod {
        name: "printed-rule",
        summary: "the paper's two branches by its rule: ascending while u rises, otherwise descending",
        way: MethodModel::Branches(LoopSource::ByOwn, HeldInput::Printed),
    },
    StudyMethod {
        name: "held-direction",
        summary: "the same branches, with the direction held while the input is constant",
        way: MethodModel::Branches(LoopSource::ByOwn, HeldInput::Held),
    },
    StudyMethod { name: "linear", summary: "no hysteresis: the best gain", way: MethodModel::Gain },
    StudyMethod {
        name: "table2-arx",
        summary: "the paper's rule with the linear block of its Table 2; for 80 Hz and above, the row of 80 Hz",
        way: MethodModel::Branches(LoopSource::ByTable2, HeldInput::Printed),
    },
    StudyMethod {
        name: "joint",
        summary: "one model for all frequencies, identified jointly: the known driver, a hysteresis operator with \
            memory, and no inverse",
        way: MethodModel::Joint,
    },
];

/// A linear block of Table 2: the printed one, or one estimated here.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyBlock {
    /// `printed` and `printed-80hz`, the rows of 5 and 80 Hz, or the name of the estimator.
    pub name: &'static str,
    /// The block, in mm/V.
    pub arx: Arx,
    /// Its fit; none for a printed one.
    pub fit: Option<Fit>,
}

impl StudyBlock {
    /// a1, a2, b0, b1, b2 with four decimals, as in the paper's Table 2.
    pub fn printed(&self) -> Vec<String> {
        [self.arx.a(), self.arx.b()].concat().into_iter().map(words::four_decimals).collect()
    }
}

/// The block of Table 2 for `hz` [Hz]: the last row up to it, or the first.
fn table_2(hz: f64) -> Result<Arx, Error> {
    let (_, theta) = TABLE_2.iter().rev().find(|row| row.0 <= hz).unwrap_or(&TABLE_2[0]);
    let (a, b) = theta.split_at(2);
    Arx::new(TS, a.to_vec(), b.to_vec())
}

/// The result of one method at one frequency: a row of Table 1.
#[derive(Debug, Clone)]
pub struct StudyRow {
    /// Name of the method.
    pub method: &'static str,
    /// Its model, in mm and V.
    pub model: Model,
    /// The errors, in mm and mm^2.
    pub metrics: Metrics,
    /// Largest opening of its loop of (u, z), in % of the peak-to-peak of z; negative for an inverted loop.
    pub loop_width_percent: f64,
    /// Its free run over the test [mm], from the first sample of [`Frequency::test`].
    pub simulated: Vec<f64>,
}

/// The results at one frequency.
#[derive(Debug, Clone)]
pub struct Frequency {
    /// The frequency [Hz].
    pub hz: f64,
    /// Amplitude of both sines [V].
    pub amplitude: f64,
    /// The loop by the identified linear block.
    pub own: HiddenLoop,
    /// The loop by the block of the paper's Table 2.
    pub by_table_2: HiddenLoop,
    /// The loop of the joint model's hysteresis block, z in the scale of `own`.
    pub joint: HiddenLoop,
    /// The stepped sine and the response [mm], settled.
    pub test: Record,
    /// One row per method.
    pub rows: Vec<StudyRow>,
}

impl Frequency {
    /// The row of a method.
    pub fn row(&self, method: &str) -> Option<&StudyRow> {
        self.rows.iter().find(|r| r.method == method)
    }
}

/// The experiment on one plant.
#[derive(Debug, Clone)]
pub struct Study {
    /// The plant.
    pub plant: &'static Preset,
    /// The PRBS record [mm].
    pub small_signal: Record,
    /// Table 2: the printed block and those estimated from the PRBS.
    pub blocks: Vec<StudyBlock>,
    /// The swarm's best cost at the start and after each iteration [mm].
    pub convergence: Vec<f64>,
    /// The same with the g_best of equation (4) as printed: the best of the current positions [mm].
    pub convergence_as_printed: Vec<f64>,
    /// The exact minimum of the cost, by linear programming [mm]; none in a build without its solver.
    pub optimum: Option<f64>,
    /// Noise gain of the inverse of the swarm's block [V/mm]; none if a zero lies on the unit circle.
    pub noise_gain: Option<f64>,
    /// The model for all frequencies, with the operators tried.
    pub joint: Identified,
    /// The results by frequency, from low to high.
    pub frequencies: Vec<Frequency>,
    /// Table 1 for other test signals.
    pub test_signals: Vec<TestSignal>,
    /// Remarks.
    pub notes: Vec<String>,
}

options! {
    /// Which plants to study.
    pub struct StudyOptions {
        /// The plant to study (see {list}).
        plant: Option<String> = None, OptionRow::new(OptionKind::Text("NAME")).list("plants").absent("paper and pl140");
        /// Seed of the swarm and of the plant's noise.
        seed: u64 = 1, OptionRow::new(OptionKind::Integer(0, u64::MAX));
    }
}

impl StudyOptions {
    /// The plants to study.
    ///
    /// # Errors
    /// Returns an error for an unknown plant.
    pub fn plants(&self) -> Result<Vec<&'static Preset>, Error> {
        let plants = self.plant.as_deref().map_or(vec!["paper", "pl140"], |name| vec![name]);
        plants.into_iter().map(Preset::find).collect()
    }

    /// The study of each plant.
    ///
    /// # Errors
    /// Returns an error for an unknown plant, and the errors of [`Study::run`].
    pub fn run(&self, progress: &mut Progress) -> Result<Vec<Study>, Error> {
        self.plants()?.into_iter().map(|plant| Study::run(plant, self.seed, progress)).collect()
    }
}

impl Study {
    /// Frequencies of the loops [Hz]: the paper's four, then up to above the resonance.
    pub const FREQUENCIES: [f64; 8] = [5.0, 20.0, 40.0, 80.0, 120.0, 160.0, 200.0, 250.0];

    /// Table 1 of the paper: frequency [Hz] and mean squared error. The unit is not stated; mm^2 is assumed.
    pub const PRINTED_MSE: [(f64, f64); 4] = [(5.0, 0.0129), (20.0, 0.0155), (40.0, 0.0180), (80.0, 0.0322)];

    /// Steps per period of the test signal: of all tested on twin `paper` the closest to the paper's Table 1
    /// ([`TestSignal::nearest`]).
    pub const STEPS_USED: u32 = 7;

    /// The figures of studies, and their page.
    pub fn files(studies: &[Study]) -> Vec<File> {
        let svg = |(name, figure): (String, Figure)| File::new(format!("{name}.svg"), figure.svg());
        let page = File::new("report.html", Study::page(studies).html());
        studies.iter().flat_map(Study::figures).map(svg).chain([page]).collect()
    }

    /// Runs the experiment on `plant`; `seed` drives the swarms and the plant's noise.
    ///
    /// # Errors
    /// The errors of the identification, and [`Error::Cancelled`].
    pub fn run(plant: &'static Preset, seed: u64, progress: &mut Progress) -> Result<Study, Error> {
        let mut bench = Bench::new(&plant.spec(), seed)?;
        let mut notes = Vec::new();

        let period = (1 << 12) - 1;
        let prbs = Prbs { order: 12, amplitude: PRBS_AMPLITUDE_V, ..Default::default() }.samples(TS, period)?;
        let small_signal = bench.measure(prbs, "PRBS")?;
        let by = |name, global_best, progress: &mut Progress| {
            let (estimator, settings) =
                (linear::Estimator::find(name)?, SwarmSettings { seed, global_best, ..Default::default() });
            estimator.fit(std::slice::from_ref(&small_signal), Orders::of(2), &settings, progress)
        };
        let mut of_swarm =
            |stage: Stage| progress(Stage { what: &format!("{}: linear block by swarm", plant.name), ..stage });
        let swarm_fit = by("swarm", GlobalBest::Ever, &mut of_swarm)?;
        let as_printed = by("swarm", GlobalBest::Current, &mut of_swarm)?;
        // A build without the feature `clarabel` has no such estimator.
        let exact = match linear::Estimator::find("least-absolute") {
            Ok(known) => Some(by(known.name, GlobalBest::Ever, &mut Stage::ignore)?),
            Err(_) => None,
        };
        let squares = by("least-squares", GlobalBest::Ever, &mut Stage::ignore)?;
        if exact.is_none() {
            notes.push(
                "The result of the swarm is not compared with the exact minimum: this build of piezoid does not have \
                 the estimator least-absolute. The command line has it."
                    .into(),
            );
        }
        let own = (swarm_fit.arx.clone(), swarm_fit.offsets[0]);
        if let Err(why) = own.0.inverse() {
            notes.push(format!(
                "The paper's inverse (8) cannot be used: {why}. The loops are computed non-causally instead: the \
                 whole record is inverted, forward and backward in time."
            ));
        }
        if let Some(why) = squares.order_too_low(std::slice::from_ref(&small_signal)) {
            notes.push(format!(
                "Order 2 has one mode only{why}. Modes above half the sampling rate, which every bender has, are \
                aliased below it and distort the estimated block."
            ));
        }

        let rising = RISING.into_iter().map(|hz| bench.rising(hz)).collect::<Result<Vec<_>, _>>()?;
        let mut of_joint = |stage: Stage| {
            progress(Stage { what: &format!("{}: one model of all frequencies, {}", plant.name, stage.what), ..stage })
        };
        let options =
            IdentifyOptions { operator: OPERATORS.into(), elements: Some(LEVELS), seed, ..Default::default() }
                .with_driver_of(&plant.spec());
        let records = Records { small_signal: std::slice::from_ref(&small_signal), large_signal: &rising };
        let joint = records.identify(&options, &mut of_joint)?.finished()?;

        let mut frequencies = Vec::new();
        for (done, hz) in Study::FREQUENCIES.into_iter().enumerate() {
            let (what, total) = (format!("{}: loops and tests by frequency", plant.name), Study::FREQUENCIES.len());
            if progress(Stage::new(&what, done, total)).is_break() {
                return Err(Error::Cancelled { what, done, total });
            }
            frequencies.push(bench.frequency(hz, &own, &joint.model)?);
        }
        let mut of_signals =
            |stage: Stage| progress(Stage { what: &format!("{}: {}", plant.name, stage.what), ..stage });
        let test_signals = test_signal::all(&bench, &frequencies, &mut of_signals)?;
        notes.extend(words::limits_in_words(&bench.limits));
        let block = |fit: &Fit| StudyBlock { name: fit.estimator, arx: fit.arx.clone(), fit: Some(fit.clone()) };
        let mut blocks = vec![StudyBlock { name: "printed", arx: table_2(5.0)?, fit: None }, block(&swarm_fit)];
        blocks.extend(exact.as_ref().map(block));
        blocks.extend([block(&squares), StudyBlock { name: "printed-80hz", arx: table_2(80.0)?, fit: None }]);
        Ok(Study {
            plant,
            small_signal,
            convergence: swarm_fit.history.clone(),
            convergence_as_printed: as_printed.history,
            optimum: exact.as_ref().map(|exact| exact.residuals.sum_abs),
            noise_gain: own.0.noise_gain(),
            blocks,
            joint,
            frequencies,
            test_signals,
            notes,
        })
    }
}
