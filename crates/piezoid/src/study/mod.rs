//! The paper's experiment as data: identify on a PRBS and sines, test on stepped sines, frequency by frequency.
//!
//! Each method sees the same records. What differs is told by its row of [`METHODS`]; what is the paper's and what is
//! ours is in its summary. The plant is asked only for what an experimenter could measure.

mod figures;
mod page;

pub use figures::figures;
pub use page::{page, verdict};

use crate::error::Error;
use crate::excitation::{Prbs, Sine, SteppedSine};
use crate::hammerstein::{Model, hidden};
use crate::hysteresis::{Branches, Hysteresis, Loop, Proportional, Reading, Split, TwoBranch};
use crate::linear::{self, Arx, Fit, Orders};
use crate::optimize::swarm;
use crate::plant::{Plant, Preset, Saturation};
use crate::progress::{Progress, Stage, unwatched};
use crate::record::{Record, Units};
use crate::system::System;
use crate::validation::Metrics;
use serde_json::{Value, json};
use std::sync::Arc;

/// Sampling period [s], the paper's.
pub const TS: f64 = 5e-4;

/// Frequencies of the loops [Hz]: the paper's four, then on through the resonance.
pub const FREQUENCIES: [f64; 8] = [5.0, 20.0, 40.0, 80.0, 120.0, 160.0, 200.0, 250.0];

/// Table 1 of the paper: frequency [Hz] and mean squared error.
pub const PRINTED_MSE: [(f64, f64); 4] = [(5.0, 0.0129), (20.0, 0.0155), (40.0, 0.0180), (80.0, 0.0322)];

/// Table 2 of the paper, the row of 5 Hz: a1, a2, b0, b1, b2.
pub const TABLE_2: [f64; 5] = [1.7424, -0.9453, 0.0012, -0.0004, -0.0003];

/// Amplitude of the sines, plain and stepped [V]: the whole range of the PL140, about its middle.
const AMPLITUDE: f64 = 30.0;

/// Amplitude of the PRBS [V], at which the hysteresis opens by less than 1 %.
const SMALL: f64 = 1.0;

/// Length of a sine, plain or stepped, and the part at its start that is left to settle [s].
const DURATION: f64 = 2.0;
const SETTLING: f64 = 0.5;

/// Largest share of the sensor's range the tip is sent to; where it would go further, the drive is lowered.
const RANGE_USED: f64 = 0.6;

/// Averages a branch.
const BINS: usize = 16;

/// One way to predict the test signal: a row of [`METHODS`].
#[derive(Debug)]
pub struct Method {
    /// As tables and files write it.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Whether its linear block is the paper's Table 2 instead of the identified one.
    table_2: bool,
    /// The branch read while the input is held; none for the model without hysteresis.
    reading: Option<Reading>,
}

/// The methods compared.
pub static METHODS: &[Method] = &[
    Method {
        name: "printed-rule",
        summary: "the paper's two branches, read by its rule to the letter",
        table_2: false,
        reading: Some(Reading::Printed),
    },
    Method {
        name: "held-direction",
        summary: "the same branches, the direction held while the input stands",
        table_2: false,
        reading: Some(Reading::Held),
    },
    Method { name: "linear", summary: "no hysteresis: the best gain", table_2: false, reading: None },
    Method {
        name: "table2-arx",
        summary: "the paper's rule with the linear block printed in its Table 2",
        table_2: true,
        reading: Some(Reading::Printed),
    },
];

/// A linear block of Table 2: the printed one, or one estimated here.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// `printed`, or the name of the estimator.
    pub name: &'static str,
    /// The block, in mm/V.
    pub arx: Arx,
    /// How it was fitted; none for the printed one.
    pub fit: Option<Fit>,
}

impl Block {
    /// a1, a2, b0, b1, b2.
    pub fn coefficients(&self) -> Vec<f64> {
        [self.arx.a(), self.arx.b()].concat()
    }
}

/// What one method made of one frequency: a row of Table 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name of the method.
    pub method: &'static str,
    /// Mean squared error [mm^2].
    pub mse: f64,
    /// All figures [mm].
    pub metrics: Metrics,
    /// Widest opening of the loop of (u, z) it stands on, in % of the peak-to-peak of z; negative when turned round.
    pub loop_width_percent: f64,
    /// Its free run over the test [mm], from the first sample of [`Frequency::test`].
    pub simulated: Vec<f64>,
}

/// The loop of the hidden variable that a linear block makes of the sine.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyLoop {
    /// Input [V].
    pub u: Vec<f64>,
    /// Hidden variable [V].
    pub z: Vec<f64>,
    /// Branches and separating line.
    pub found: Loop,
}

/// All about one frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Frequency {
    /// The frequency [Hz].
    pub hz: f64,
    /// Amplitude of both sines [V].
    pub amplitude: f64,
    /// The loop by the identified linear block.
    pub own: StudyLoop,
    /// The loop by the block of the paper's Table 2.
    pub by_table_2: StudyLoop,
    /// The stepped sine and the answer to it [mm], settled.
    pub test: Record,
    /// One row a method.
    pub rows: Vec<Row>,
}

impl Frequency {
    /// The row of a method.
    pub fn row(&self, method: &str) -> Option<&Row> {
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
    pub blocks: Vec<Block>,
    /// The swarm's best cost at the start and after each iteration [mm].
    pub convergence: Vec<f64>,
    /// The smallest cost there is, by linear programming [mm].
    pub optimum: f64,
    /// Noise gain of the inverse of the swarm's block [V/mm]; none when a zero lies on the unit circle.
    pub noise_gain: Option<f64>,
    /// By frequency.
    pub frequencies: Vec<Frequency>,
    /// What its reader should know.
    pub notes: Vec<String>,
}

/// Runs the experiment on `plant`; `seed` drives the swarm and the plant's noise.
///
/// # Errors
/// What the identification refuses, and [`Error::Cancelled`].
pub fn run(plant: &'static Preset, seed: u64, progress: &mut Progress) -> Result<Study, Error> {
    let spec = (plant.spec)();
    let bench = Bench { plant: Plant::new(&spec, TS)?.with_seed(seed), range: spec.sensor.range_m.map(|m| 1e3 * m) };
    let (mut notes, mut limits) = (Vec::new(), Vec::new());

    let period = (1 << 12) - 1;
    let prbs = Prbs { order: 12, amplitude: SMALL, ..Prbs::default() }.samples(TS, period)?;
    let small_signal = bench.measure(prbs, "PRBS", &mut limits)?;
    let settings = swarm::Settings { seed, ..swarm::Settings::default() };
    let by = |name, progress: &mut Progress| {
        let estimator = linear::estimator(name)?;
        linear::fit(std::slice::from_ref(&small_signal), Orders::of(2), estimator, &settings, progress)
    };
    let swarm_fit = by("swarm", &mut |stage| progress(Stage { what: stage_name(plant, "swarm"), ..stage }))?;
    let exact = by("least-absolute", &mut unwatched)?;
    let squares = by("least-squares", &mut unwatched)?;
    let (a, b) = TABLE_2.split_at(2);
    let table_2 = Arx::new(TS, a.to_vec(), b.to_vec())?;
    let own = (swarm_fit.arx.clone(), swarm_fit.offsets[0]);
    if let Err(why) = own.0.inverse() {
        notes.push(format!(
            "The paper's inverse (8) cannot be used: {why}. The loops stand on the inverse of the whole record instead, which runs \
             forward and backward in time."
        ));
    }
    notes.extend(second_mode(&small_signal, &squares));

    let mut frequencies = Vec::new();
    for (done, hz) in FREQUENCIES.into_iter().enumerate() {
        let total = FREQUENCIES.len();
        let what = stage_name(plant, "loops");
        if progress(Stage { what, done, total }).is_break() {
            return Err(Error::Cancelled { what: what.into(), done, total });
        }
        frequencies.push(bench.frequency(hz, &own, &table_2, &mut limits)?);
    }
    notes.extend(limits_in_words(&limits));
    let block = |fit: &Fit| Block { name: fit.estimator, arx: fit.arx.clone(), fit: Some(fit.clone()) };
    Ok(Study {
        plant,
        small_signal,
        convergence: swarm_fit.history.clone(),
        optimum: exact.residuals.sum_abs,
        noise_gain: own.0.noise_gain(),
        blocks: vec![
            Block { name: "printed", arx: table_2, fit: None },
            block(&swarm_fit),
            block(&exact),
            block(&squares),
        ],
        frequencies,
        notes,
    })
}

/// The records in which a limit of the plant was reached, one sentence a limit.
fn limits_in_words(limits: &[(String, Saturation)]) -> Vec<String> {
    type Count = fn(&Saturation) -> usize;
    let kinds: [(&str, Count); 3] = [
        ("The driver clamped its voltage", |s| s.clamped),
        ("The driver's current limit was reached", |s| s.current_limited),
        ("The sensor was driven out of its range", |s| s.sensor_clipped),
    ];
    let sentence = |(what, count): &(&str, Count)| {
        let hit = limits.iter().filter(|(_, s)| count(s) > 0);
        let records: Vec<String> = hit.map(|(record, s)| format!("{record} ({})", count(s))).collect();
        (!records.is_empty()).then(|| format!("{what} in, with the number of samples: {}.", records.join(", ")))
    };
    kinds.iter().filter_map(sentence).collect()
}

/// What a block of twice the order says, where the paper's order 2 leaves a visible part of the record unexplained.
fn second_mode(small_signal: &Record, second_order: &Fit) -> Option<String> {
    let power: f64 = small_signal.y().iter().map(|y| y * y).sum();
    let left = second_order.residuals.rms / (power / small_signal.len() as f64).sqrt();
    let squares = linear::estimator("least-squares").ok()?;
    let records = std::slice::from_ref(small_signal);
    let fit = linear::fit(records, Orders::of(4), squares, &swarm::Settings::default(), &mut unwatched).ok()?;
    let times = second_order.residuals.rms / fit.residuals.rms;
    let sharpest =
        fit.arx.poles().into_iter().filter(|p| p.z.im > 0.0).min_by(|p, q| p.damping.total_cmp(&q.damping))?;
    (left > 0.02 && times > 2.0).then(|| {
        format!(
            "Order 2 has room for one mode and leaves {:.0} % of this record's rms in prediction; order 4 predicts {times:.0} times as \
             well and puts the resonance at {:.1} Hz with damping {:.3}. Modes above half the sampling rate, as every bender has, fold back below it, \
             and the paper's block has to bend to them.",
            100.0 * left,
            sharpest.hz,
            sharpest.damping
        )
    })
}

fn stage_name(plant: &Preset, work: &str) -> &'static str {
    match (plant.name, work) {
        ("paper", "swarm") => "paper: linear block by swarm",
        ("paper", _) => "paper: loops and tests by frequency",
        (_, "swarm") => "pl140: linear block by swarm",
        _ => "pl140: loops and tests by frequency",
    }
}

/// A drive signal [V] by its amplitude [V].
type Drive<'a> = dyn Fn(f64) -> Result<Vec<f64>, Error> + 'a;

/// The plant on a bench: what can be measured there, in millimetres.
struct Bench {
    plant: Plant,
    /// Range of the sensor [mm].
    range: Option<f64>,
}

impl Bench {
    /// Drives the plant from rest and records it; what limits were reached is added to `limits`.
    fn measure(&self, u: Vec<f64>, what: &str, limits: &mut Vec<(String, Saturation)>) -> Result<Record, Error> {
        let run = self.plant.run(&u);
        if run.saturation.any() {
            limits.push((what.into(), run.saturation));
        }
        let units = Units { u: "V".into(), y: "mm".into() };
        let y = run.y.iter().map(|y| 1e3 * y).collect();
        Ok(Record::new(TS, u, y)?.with_units(units))
    }

    /// The amplitude [V] at which the answers to all `drives` stay well within the sensor's range: lowered from the whole
    /// range of the driver as an experimenter would, by what the sensor shows.
    fn amplitude(&self, drives: &[&Drive]) -> Result<f64, Error> {
        let Some(range) = self.range else { return Ok(AMPLITUDE) };
        let mut amplitude = AMPLITUDE;
        loop {
            let mut peak = 0.0f64;
            for drive in drives {
                peak = self.plant.run(&drive(amplitude)?).y.iter().fold(peak, |peak, y| peak.max(1e3 * y.abs()));
            }
            if peak <= RANGE_USED * range || amplitude <= 1.0 {
                break;
            }
            amplitude = (amplitude * (RANGE_USED * range / peak).max(0.5)).floor().max(1.0);
        }
        Ok(amplitude)
    }

    /// Steps 3 to 6 of the paper at one frequency, for every method.
    fn frequency(
        &self,
        hz: f64,
        own: &(Arx, f64),
        table_2: &Arx,
        limits: &mut Vec<(String, Saturation)>,
    ) -> Result<Frequency, Error> {
        let n = (DURATION / TS) as usize;
        let frequency = hz;
        let sine = |amplitude| Sine { amplitude, frequency, ..Sine::default() }.samples(TS, n);
        let stepped = |amplitude| SteppedSine { amplitude, frequency, ..SteppedSine::default() }.samples(TS, n);
        let amplitude = self.amplitude(&[&sine, &stepped])?;
        let sine = self.measure(sine(amplitude)?, &format!("sine of {hz} Hz"), limits)?;
        let whole = self.measure(stepped(amplitude)?, &format!("stepped sine of {hz} Hz"), limits)?;
        let settled = (SETTLING / TS) as usize;

        let loop_by = |arx: &Arx, offset: f64| -> Result<StudyLoop, Error> {
            let (z, _) = hidden(arx, offset, sine.y())?;
            let (u, z) = (sine.u()[settled..].to_vec(), z[settled..].to_vec());
            let found = Branches::of_loop(&u, &z, BINS, Split::Line)?;
            Ok(StudyLoop { u, z, found })
        };
        let (by_own, by_table_2) = (loop_by(&own.0, own.1)?, loop_by(table_2, 0.0)?);
        let test = whole.part(SETTLING, f64::INFINITY)?;
        let rows = METHODS.iter().map(|method| {
            let (arx, offset, found) = match method.table_2 {
                true => (table_2, 0.0, &by_table_2.found),
                false => (&own.0, own.1, &by_own.found),
            };
            let (hysteresis, offset): (Arc<dyn Hysteresis>, f64) = match method.reading {
                Some(reading) => (Arc::new(TwoBranch::new(TS, found.branches.clone(), reading)), offset),
                None => {
                    let (gain, offset) = crate::hammerstein::proportional(arx, offset, std::slice::from_ref(&sine))?;
                    (Arc::new(Proportional::new(TS, gain)?), offset)
                }
            };
            let model = Model::new(hysteresis, arx.clone(), offset)?;
            let simulated = model.simulate(whole.u())[settled..].to_vec();
            let metrics = Metrics::of(test.y(), &simulated);
            let loop_width_percent = method.reading.map_or(0.0, |_| 100.0 * found.branches.width());
            Ok(Row { method: method.name, mse: metrics.mse, metrics, loop_width_percent, simulated })
        });
        let rows = rows.collect::<Result<_, Error>>()?;
        Ok(Frequency { hz, amplitude, own: by_own, by_table_2, test, rows })
    }
}

/// The studies as one document: `table1`, `table2` over all plants, `convergence` of the first, and each study whole
/// under `studies`. Numbers that are not finite are null.
pub fn to_json(studies: &[Study]) -> Value {
    let all = |table: &dyn Fn(&Study) -> Vec<Value>| studies.iter().flat_map(table).collect::<Vec<_>>();
    let each = |s: &Study| {
        json!({
            "plant": s.plant.name,
            "table1": table1(s),
            "table2": table2(s),
            "convergence": s.convergence,
            "optimum": s.optimum,
            "noise_gain": s.noise_gain,
            "notes": s.notes,
        })
    };
    json!({
        "table1": all(&table1),
        "table2": all(&table2),
        "convergence": studies.first().map(|s| &s.convergence),
        "studies": studies.iter().map(each).collect::<Vec<_>>(),
    })
}

fn table1(study: &Study) -> Vec<Value> {
    let row = |f: &Frequency, r: &Row| {
        json!({
            "plant": study.plant.name,
            "frequency_hz": f.hz,
            "method": r.method,
            "amplitude_v": f.amplitude,
            "mse": r.mse,
            "nrmse_percent": r.metrics.nrmse_percent,
            "rms_pp_percent": r.metrics.rms_pp_percent,
            "loop_width_percent": r.loop_width_percent,
            "printed_mse": PRINTED_MSE.iter().find(|(hz, _)| *hz == f.hz).map(|(_, mse)| mse),
        })
    };
    study.frequencies.iter().flat_map(|f| f.rows.iter().map(move |r| row(f, r))).collect()
}

fn table2(study: &Study) -> Vec<Value> {
    let row = |b: &Block| {
        json!({
            "plant": study.plant.name,
            "estimator": b.name,
            "a": b.arx.a(),
            "b": b.arx.b(),
            "poles": b.arx.poles().iter().map(|p| json!({"hz": p.hz, "damping": p.damping})).collect::<Vec<_>>(),
            "zeros": b.arx.zeros().iter().map(|z| json!({"re": z.re, "im": z.im})).collect::<Vec<_>>(),
            "dc_gain": b.arx.dc_gain(),
            "inverse_is_stable": b.arx.inverse().is_ok(),
            "residual_sum_abs": b.fit.as_ref().map(|f| f.residuals.sum_abs),
            "residual_rms": b.fit.as_ref().map(|f| f.residuals.rms),
            "offset": b.fit.as_ref().map(|f| f.offsets[0]),
        })
    };
    study.blocks.iter().map(row).collect()
}
