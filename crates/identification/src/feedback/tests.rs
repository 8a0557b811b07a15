mod derivatives;

use super::*;
use crate::{Effort, Identified, JointOptions, identify_joint};
use piezoid_models::driver::DriverModel;
use piezoid_models::feedback::Intersample;
use piezoid_models::hammerstein::Model;
use piezoid_models::linear::Arx;
use piezoid_numerics::series::scatter;
use piezoid_numerics::system::System;
use piezoid_records::excitation::{Multisine, Prbs, RisingSine};
use piezoid_records::preparation::PrepareOptions;
use piezoid_testing::{assert_close, assert_kept};
use piezoid_twins::Plant;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// The rate of the benchmark, and that at which it is integrated.
const FS: f64 = 750.0;
const FASTER: usize = 20;

/// Kinds of input, one of which is that of the benchmark.
const ALL: [Intersample; 2] = [Intersample::Held, Intersample::BandLimited];

/// Samples of a period.
const N: usize = 2048;

/// The benchmark's record along two periods of a multisine, without its first `skip` samples, with noise of this
/// rms [um].
fn benchmark(seed: u32, skip: usize, noise: f64) -> Record {
    let ts = 1.0 / (FS * FASTER as f64);
    let (period, amplitude) = (N as f64 / FS, 100.0);
    let multisine =
        Multisine { amplitude, frequency_low: 5.0, frequency_high: 150.0, period, seed, ..Multisine::default() };
    let u = multisine.samples(ts, 2 * N * FASTER).unwrap();
    let y = Plant::named("bouc-wen-benchmark", ts).unwrap().run(&u).y;
    let options = PrepareOptions { decimate: Some(FASTER), ..PrepareOptions::default() };
    let record = options.run(&Record::new(ts, u, y).unwrap()).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let noise = Normal::new(0.0, noise).unwrap();
    let y = record.y()[skip..].iter().map(|y| y + noise.sample(&mut random)).collect();
    Record::new(1.0 / FS, record.u()[skip..].to_vec(), y).unwrap()
}

fn training() -> (FeedbackFit, [Record; 1]) {
    let records = [benchmark(1, N, 8.0)];
    (FeedbackFit::oscillator(&records, &ALL, &mut Stage::ignore).unwrap(), records)
}

#[test]
fn the_benchmark_is_found_from_a_noisy_period() {
    let (fit, _) = training();
    assert_eq!(fit.periodic, [true]);
    assert_close(&fit.rms, &[8.0], 0.02, 0.0);
    // Newmark's step of 1/15000 s lowers the frequency by 2e-5, far less than its error.
    let known = [2.5e4f64.sqrt() / TAU, 10.0 / (4.0 * 2.5e4f64.sqrt()), 20.0, 0.0, 1.0, 8e-4, -1.375];
    assert_eq!(fit.parameters.len(), known.len());
    for (FittedParameter { name, value, error }, known) in fit.parameters.iter().zip(known) {
        let most = if known == 0.0 { 0.4 } else { 0.0 };
        let is_known = (value - known).abs() < 4.0 * error && *error < f64::max(0.02 * known.abs(), most);
        assert!(is_known, "{name}: {value} +- {error}, not {known}");
    }
    // A free run from rest, without noise [um]; black boxes leave 7.5 um.
    let test = benchmark(2, 0, 0.0);
    let run = fit.model.simulate_from(&[], test.u());
    let second_period: f64 = test.y()[N..].iter().zip(&run[N..]).map(|(y, m)| (y - m).powi(2)).sum();
    let rms = (second_period / N as f64).sqrt();
    assert!(rms < 1.0, "{rms}");
}

#[test]
fn a_start_that_is_thirty_percent_off_ends_at_the_same_minimum() {
    let (fit, records) = training();
    let off = |(k, p): (usize, FeedbackParameter)| p.value * if k % 2 == 0 { 1.3 } else { 0.7 };
    let x: Vec<f64> = fit.model.parameters().into_iter().enumerate().map(off).collect();
    let start = fit.model.with_parameters(&x).unwrap();
    let again = FeedbackFit::from(&start, &records, &mut Stage::ignore).unwrap();
    assert_close(&again.rms, &fit.rms, 1e-6, 0.0);
}

#[test]
fn a_record_without_a_resonance_is_an_error_and_a_cancelled_search_says_so() {
    let u: Vec<f64> = (0..400).map(|t| f64::from(t * t % 13) - 6.0).collect();
    let y = Arx::new(1e-3, vec![0.8], vec![0.3]).unwrap().simulate(&u);
    let y = y.iter().zip(u.iter().rev()).map(|(y, noise)| y + 0.01 * noise).collect();
    let record = Record::new(1e-3, u, y).unwrap();
    let refused = |records: &[Record]| {
        FeedbackFit::oscillator(records, &[Intersample::Held], &mut Stage::ignore).unwrap_err().to_string()
    };
    assert!(refused(&[record]).contains("no resonance shows"));
    assert!(!refused(&[]).is_empty());
    let records = [benchmark(1, N, 8.0)];
    let mut cancelled = |stage: Stage| match stage.what {
        STAGE => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let error = FeedbackFit::oscillator(&records, &ALL, &mut cancelled).unwrap_err();
    assert!(error.to_string().contains("hysteresis in feedback"), "{error}");
}

/// The model of records with the structure that suits them, from a quick search of blocks in series.
fn of_structure(records: &[Record], structure: Structure) -> Identified {
    let quick = JointOptions { effort: Effort::Quick, ..JointOptions::default() };
    let found = identify_joint(&[], records, &quick, &mut Stage::ignore).unwrap();
    identify_structure(found, records.iter(), structure, None, &mut Stage::ignore).unwrap()
}

/// What a search found, and why, without parameters that the records hardly determine.
fn text(found: &Identified) -> String {
    let rows = found.trials.iter().map(|trial| format!("{trial:?}"));
    let determined = found.parameters.iter().filter(|p| p.error < 0.01 * p.value.abs());
    rows.chain(determined.map(|p| format!("{p:?}"))).chain(found.reasons.clone()).collect::<Vec<_>>().join("\n")
}

#[test]
fn auto_takes_feedback_only_where_it_predicts_better() {
    let found = of_structure(&[benchmark(1, N, 8.0)], Structure::Auto);
    let feedback = found.model.feedback().unwrap().dynamics();
    assert_eq!((feedback.intersample, feedback.delay), (Intersample::BandLimited, 0));
    assert_close(&[feedback.modes[0].hz], &[25.165], 2e-3, 0.0);
    let [.., row] = &found.trials[..] else { panic!() };
    assert_eq!((row.operator, row.verdict), ("bouc-wen, in feedback", "taken"));
    assert_eq!(found.trials.iter().filter(|trial| trial.verdict == "taken").count(), 1);
    assert!(found.reasons.iter().any(|reason| reason.starts_with("structure: hysteresis in feedback: ")));
    assert_kept("feedback-displacement", &text(&found));

    // Hysteresis first, mechanics after: a bender at its resonance.
    let u = RisingSine { amplitude: 2.0, frequency: 160.0, ..RisingSine::default() }.samples(5e-4, 2000).unwrap();
    let y = Plant::named("pl140", 5e-4).unwrap().run(&u).y;
    let records = [Record::new(5e-4, u, y).unwrap()];
    let found = of_structure(&records, Structure::Auto);
    assert!(found.model.feedback().is_none());
    assert!(found.reasons.iter().any(|reason| reason.starts_with("structure: hysteresis first")));
    assert_eq!(of_structure(&records, Structure::Hammerstein).reasons.len() + 1, found.reasons.len());
}

/// A bender whose vibration acts on its hysteresis, whose first mode softens, and whose sensor is curved and inverted.
#[test]
fn auto_finds_vibration_that_drives_the_hysteresis() {
    let ts = 5e-4;
    let plant = Plant::named("pl140-nonlinear", ts).unwrap();
    let record = |hz: f64, amplitude: f64, n: usize| {
        let u = RisingSine { amplitude, frequency: hz, ..RisingSine::default() }.samples(ts, n).unwrap();
        let y = plant.run(&u).y.iter().map(|y| -y).collect();
        Record::new(ts, u, y).unwrap()
    };
    let training = [record(5.0, 25.0, 1600), record(60.0, 20.0, 800), record(150.0, 4.0, 1200)];
    let u = Prbs::default().samples(ts, 2047).unwrap();
    let y = plant.run(&u).y.iter().map(|y| -y).collect();
    let small = [Record::new(ts, u, y).unwrap()];
    let driver = DriverModel::new(1e-4, Some(0.5 / 8.2e-6)).unwrap();
    let options = JointOptions {
        effort: Effort::Quick,
        operator: "preisach".into(),
        driver: Some(driver),
        ..JointOptions::default()
    };
    let blocks = identify_joint(&small, &training, &options, &mut Stage::ignore).unwrap();
    let records = small.iter().chain(&training);
    let found = identify_structure(blocks, records, Structure::Auto, Some(driver), &mut Stage::ignore).unwrap();
    assert_kept("feedback-vibration", &text(&found));
    let feedback = found.model.feedback().unwrap();
    assert!(feedback.dynamics().modes[0].sensed > 0.0 && feedback.dynamics().modes[0].softening > 0.0);
    let test = record(165.0, 6.0, 1500);
    let error = |model: &Model| {
        let run = model.follow(&mut model.initial(), test.u());
        scatter(&test.y().iter().zip(run).map(|(y, run)| y - run).collect::<Vec<_>>()).sqrt()
    };
    let [with, without] = [&found.model, &found.model.without_feedback()].map(error);
    assert!(5.0 * with < without, "{with} {without}");
}
