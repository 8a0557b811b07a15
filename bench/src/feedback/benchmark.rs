//! The Bouc-Wen benchmark of system identification, in which the displacement drives the hysteresis.

use crate::page::{self, head, row};
use piezoid::excitation::Chirp;
use piezoid::feedback::{FeedbackFit, FeedbackModel, Structure};
use piezoid::plant::Plant;
use piezoid::progress::Stage;
use piezoid::{Error, IdentifyOptions, Model, PrepareOptions, Record, System, identify};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::TAU;
use std::path::Path;

/// Rate of the records [Hz], and that of the integration over it.
const FS: f64 = 750.0;
const FASTER: usize = 20;

/// Samples of a period.
const PERIOD: usize = 8192;

/// Rms of the output's noise [um].
const NOISE: f64 = 8.0;

/// Each parameter of a start over its value, by turns.
const OFF: [f64; 2] = [1.3, 0.7];

/// The benchmark's record along `u` [N] at the faster rate, from rest.
fn record(u: Vec<f64>) -> Result<Record, Error> {
    let ts = 1.0 / (FS * FASTER as f64);
    let y = Plant::named("bouc-wen-benchmark", ts)?.run(&u).y;
    PrepareOptions { decimate: Some(FASTER), ..PrepareOptions::default() }.run(&Record::new(ts, u, y)?)
}

/// Two periods of a multisine of random phases from 5 to 150 Hz, of 50 N rms.
fn multisine(seed: u64) -> Result<Record, Error> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let line = |hz: f64| (hz * PERIOD as f64 / FS).round() as usize;
    let lines: Vec<(usize, f64)> = (line(5.0)..=line(150.0)).map(|k| (k, TAU * random.random::<f64>())).collect();
    let (n, amplitude) = (PERIOD * FASTER, 50.0 * (2.0 / lines.len() as f64).sqrt());
    let table: Vec<f64> = (0..n).map(|t| libm::cos(TAU * t as f64 / n as f64)).collect();
    let mut u = vec![0.0; n];
    for (k, phase) in lines {
        let shift = (phase / TAU * n as f64) as usize;
        u.iter_mut().enumerate().for_each(|(t, u)| *u += amplitude * table[(k * t + shift) % n]);
    }
    record([&u[..], &u].concat())
}

/// 40 N from 20 to 50 Hz at 10 Hz/min.
fn sweep() -> Result<Record, Error> {
    let chirp = Chirp { amplitude: 40.0, frequency_start: 20.0, frequency_end: 50.0, ..Chirp::default() };
    record(chirp.samples(1.0 / (FS * FASTER as f64), (180.0 * FS) as usize * FASTER)?)
}

/// The second period with noise.
fn training() -> Result<Record, Error> {
    let record = multisine(1)?;
    let (mut random, noise) =
        (ChaCha8Rng::seed_from_u64(2), Normal::new(0.0, NOISE).map_err(|e| Error::Content(e.to_string()))?);
    let y = record.y()[PERIOD..].iter().map(|y| y + noise.sample(&mut random)).collect();
    record.with_samples(1.0 / FS, record.u()[PERIOD..].to_vec(), y)
}

/// The records without noise: the second period of another multisine counts, and a sweep from rest.
fn tests() -> Result<[Record; 2], Error> {
    Ok([multisine(3)?, sweep()?])
}

/// The rms error of a free run from rest along each of the tests [um].
fn errors(tests: &[Record; 2], model: &Model) -> [f64; 2] {
    [(&tests[0], PERIOD), (&tests[1], 0)].map(|(record, from)| {
        let run = model.follow(&mut model.initial(), record.u());
        let squares = record.y()[from..].iter().zip(&run[from..]).map(|(y, m)| (y - m).powi(2));
        (squares.sum::<f64>() / (record.len() - from) as f64).sqrt()
    })
}

/// The model with each parameter 30 % off.
fn off(model: &FeedbackModel) -> Result<FeedbackModel, Error> {
    let x: Vec<f64> = model.parameters().iter().zip(OFF.iter().cycle()).map(|(p, factor)| p.value * factor).collect();
    model.with_parameters(&x)
}

/// Measures, and writes the tables of the benchmark.
pub(super) fn write(page: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let (training, tests) = ([training()?], tests()?);
    let started = std::time::Instant::now();
    let found = identify(&training, &IdentifyOptions { structure: Structure::Auto, ..IdentifyOptions::default() })?;
    eprintln!("from the record alone: {:?}", started.elapsed());
    found.remarks().iter().for_each(|remark| eprintln!("{remark}"));
    let feedback = found.model.feedback().ok_or("the record does not show the feedback")?;
    let started = std::time::Instant::now();
    let again = FeedbackFit::from(&off(feedback)?, &training, &mut Stage::ignore)?;
    eprintln!("from 30 % off: {:?}", started.elapsed());
    let again = found.model.clone().with_feedback(again.model)?;
    let rows = [
        ("`--structure hammerstein`, the default", errors(&tests, &found.model.without_feedback())),
        ("`--structure auto`: hysteresis in feedback", errors(&tests, &found.model)),
        ("the same from each parameter 30 % off", errors(&tests, &again)),
    ];
    let table = head(["model", "multisine [um]", "sweep [um]"], 1)
        + &rows.map(|(name, errors)| row([name.into()].into_iter().chain(errors.map(page::cell)))).concat();
    page::write(page, "benchmark", &table)?;
    let known = ["25.165", "0.01581", "20", "0", "1", "0.0008", "-1.375"];
    let parameters = found.parameters.iter().zip(known).map(|(p, known)| {
        // Two digits of the standard error.
        let digits = (1.0 - p.error.log10().floor()).max(0.0) as usize;
        row([p.name.clone(), known.into(), format!("{:.digits$}", p.value), format!("{:.digits$}", p.error)])
    });
    let table = head(["parameter", "benchmark", "found", "standard error"], 1) + &parameters.collect::<String>();
    page::write(page, "parameters", &table)
}
