//! The joint method on plants with known coefficients.

mod kept;
mod progress;

use super::*;
use libm::expm1;
use piezoid_models::creep::{Creep, Lag};
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::Operator;
use piezoid_models::linear::Arx;
use piezoid_numerics::progress::Stage;
use piezoid_numerics::series::{ends, scatter};
use piezoid_numerics::system::System;
use piezoid_records::excitation::{Prbs, RisingSine};
use piezoid_testing::{assert_close, assert_kept, noise};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Prandtl-Ishlinskii operator with a resonance at 60 Hz, sampled every `ts` [s] and delayed by `delay` samples.
fn plant(ts: f64, delay: usize) -> Model {
    let (radius, angle) = ((-0.1 * TAU * 60.0 * ts).exp(), TAU * 60.0 * ts * 0.99f64.sqrt());
    let a = vec![2.0 * radius * angle.cos(), -radius * radius];
    let half = 0.5 * (1.0 - a[0] - a[1]);
    let b = [vec![0.0; delay], vec![1.1 * half, 0.9 * half]].concat();
    let block = (Operator::find("prandtl-ishlinskii").unwrap().example)(ts).unwrap();
    Model::new(block, Arx::new(ts, a, b).unwrap(), 0.3).unwrap()
}

/// A record of the plant with this additional offset.
fn record(plant: &Model, u: Vec<f64>, offset: f64) -> Record {
    let y = plant.simulate(&u).iter().map(|y| y + offset).collect();
    Record::new(plant.ts(), u, y).unwrap()
}

fn prbs(plant: &Model) -> Record {
    let u = Prbs { order: 10, amplitude: 1.0, ..Prbs::default() }.samples(plant.ts(), 1023).unwrap();
    record(plant, u, 0.0)
}

/// Rising sines of these frequencies [Hz] over `seconds`, each with its own offset.
fn large_signal(plant: &Model, seconds: f64, hz_and_offset: &[(f64, f64)]) -> Vec<Record> {
    let of = |&(frequency, offset): &(f64, f64)| {
        let sine = RisingSine { amplitude: 30.0, frequency, ..RisingSine::default() };
        record(plant, sine.samples(plant.ts(), (seconds / plant.ts()) as usize).unwrap(), offset)
    };
    hz_and_offset.iter().map(of).collect()
}

/// The records with noise, 0.03 % of the largest peak-to-peak.
fn noisy(records: Vec<Record>) -> Vec<Record> {
    let with_noise = |(k, record): (u64, Record)| {
        let y = record.y().iter().zip(noise(k, record.len())).map(|(y, e)| y + 0.02 * e).collect();
        Record::new(record.ts(), record.u().to_vec(), y).unwrap()
    };
    (1..).zip(records).map(with_noise).collect()
}

fn named(operator: &str) -> JointOptions {
    JointOptions { operator: operator.into(), ..JointOptions::default() }
}

fn identified(small: &[Record], large_signal: &[Record], settings: &JointOptions) -> Identified {
    identify_joint(small, large_signal, settings, &mut Stage::ignore).unwrap()
}

/// Range of the error on validation data, over the peak-to-peak.
fn error(model: &Model, plant: &Model) -> f64 {
    let n = (0.4 / plant.ts()) as usize;
    let u: Vec<f64> =
        (0..n).map(|t| t as f64 * plant.ts()).map(|s| 27.0 * (TAU * 7.0 * s).sin() * (TAU * 1.7 * s).cos()).collect();
    let (y, found) = (plant.simulate(&u), model.simulate(&u));
    let errors: Vec<f64> = y.iter().zip(&found).map(|(y, found)| y - found).collect();
    let ((low, high), (least, most)) = (ends(y), ends(errors));
    (most - least) / (high - low)
}

#[test]
fn order_and_delay_are_those_of_the_plant() {
    for delay in [0, 2] {
        let plant = plant(5e-4, delay);
        let large_signal = large_signal(&plant, 0.5, &[(11.0, 0.0), (29.0, 0.0), (61.0, 0.0)]);
        let found = identified(&[prbs(&plant)], &large_signal, &named("prandtl-ishlinskii"));
        let (linear, reason) = (found.model.linear(), &found.linear.reason);
        assert_eq!((linear.a().len(), linear.delay()), (2, delay), "{reason}");
        assert_close(linear.a(), plant.linear().a(), 1e-4, 0.0);
        assert!(error(&found.model, &plant) < 1e-4, "{}", error(&found.model, &plant));
    }
}

#[test]
fn only_named_operators_are_tried_and_the_better_one_is_selected() {
    let plant = plant(5e-4, 1);
    let large_signal = large_signal(&plant, 0.4, &[(11.0, 0.0), (29.0, 0.0), (61.0, 0.0)]);
    let found = identified(&[prbs(&plant)], &large_signal, &named("bouc-wen, prandtl-ishlinskii"));
    let tried: Vec<_> = found.trials.iter().map(|trial| (trial.operator, trial.verdict)).collect();
    assert_eq!(tried, [("bouc-wen", ""), ("prandtl-ishlinskii", "taken")]);
    assert_eq!(found.model.hysteresis().operator().name, "prandtl-ishlinskii");
    let error =
        identify_joint(&[], &large_signal, &named("bouc-wen,prandl"), &mut Stage::ignore).unwrap_err().to_string();
    assert!(error.contains("no operator called `prandl`"), "{error}");
}

#[test]
fn a_specified_order_that_is_too_low_is_noted() {
    let plant = plant(5e-4, 1);
    let large_signal = large_signal(&plant, 0.8, &[(11.0, 0.0), (29.0, 0.0)]);
    for (order, is_noted) in [(1, true), (2, false)] {
        let settings = JointOptions { order: Some(order), ..named("prandtl-ishlinskii") };
        let notes = identified(&[prbs(&plant)], &large_signal, &settings).notes;
        assert_eq!(notes.iter().any(|note| note.contains("is too low")), is_noted, "{notes:?}");
    }
}

#[test]
fn the_linear_block_has_the_specified_order_and_is_as_good_as_one_that_is_found() {
    let plant = plant(1e-3, 0);
    let records = noisy(large_signal(&plant, 2.0, &[(1.5, 0.0), (2.5, 0.0), (4.0, 0.0)]));
    let fitted = |order| identified(&[], &records, &JointOptions { order, ..named("prandtl-ishlinskii") }).model;
    let orders = (1..=3).map(|order| fitted(Some(order)).linear().a().len());
    assert_eq!(orders.collect::<Vec<_>>(), [1, 2, 3]);
    assert!(error(&fitted(Some(2)), &plant) < 1.1 * error(&fitted(None), &plant));
}

#[test]
fn each_record_has_its_own_offset_and_the_model_the_median() {
    let plant = plant(5e-4, 1);
    let large_signal = large_signal(&plant, 0.4, &[(11.0, -1e6), (29.0, 5.0), (61.0, 1e9)]);
    let found = identified(&[prbs(&plant)], &large_signal, &named("prandtl-ishlinskii"));
    assert!(error(&found.model, &plant) < 1e-4, "{}", error(&found.model, &plant));
    // Median of 0, -1e6, 5 and 1e9, plus the plant's own.
    assert!((found.model.offset() - 5.3).abs() < 1e-2, "{}", found.model.offset());
    assert!(found.notes.iter().any(|note| note.contains("offsets of the records differ")), "{:?}", found.notes);
}

#[test]
fn records_that_start_in_motion_or_drift_are_as_good() {
    let plant = plant(5e-4, 1);
    let moving = |hz: f64| {
        let u: Vec<f64> = (0..2000).map(|t| 30.0 * (TAU * hz * 5e-4 * f64::from(t)).sin()).collect();
        let y = plant.simulate(&u);
        Record::new(5e-4, u[1030..].to_vec(), y[1030..].to_vec()).unwrap()
    };
    let drifting = |r: &Record| {
        let y = r.y().iter().enumerate().map(|(t, y)| y + 0.005 * t as f64).collect();
        Record::new(5e-4, r.u().to_vec(), y).unwrap()
    };
    let still = large_signal(&plant, 0.8, &[(11.0, 0.0), (29.0, 0.0), (61.0, 0.0)]);
    let moved = [&still[..], &[moving(10.0), moving(40.0)]].concat();
    for (large_signal, says) in [(moved, None), (still.iter().map(drifting).collect(), Some("drifts by"))] {
        let found = identified(&[prbs(&plant)], &large_signal, &named("prandtl-ishlinskii"));
        assert!(error(&found.model, &plant) < 1e-3, "{says:?}: {}", error(&found.model, &plant));
        assert!(says.is_none_or(|says| found.notes.iter().any(|note| note.contains(says))), "{:?}", found.notes);
    }
}

#[test]
fn the_result_does_not_depend_on_the_sampling_period() {
    for (ts, seconds) in [(2e-3, 1.2), (5e-4, 0.4), (1e-4, 0.2)] {
        let plant = plant(ts, 1);
        let large_signal = large_signal(&plant, seconds, &[(11.0, 0.0), (29.0, 0.0), (61.0, 0.0)]);
        let found = identified(&[prbs(&plant)], &large_signal, &named("prandtl-ishlinskii"));
        let resonance = found.model.linear().resonance().unwrap();
        assert_close(&[resonance.hz, resonance.damping], &[60.0, 0.1], 1e-3, 0.0);
        assert!(error(&found.model, &plant) < 1e-4, "{ts} s: {}", error(&found.model, &plant));
    }
}

#[test]
fn a_quick_search_finds_a_coarse_model_in_the_ends_of_long_records() {
    let plant = plant(5e-4, 1);
    let large_signal = large_signal(&plant, 8.0, &[(3.0, 0.0), (7.0, 0.0), (17.0, 0.0)]);
    let quick = JointOptions { effort: Effort::Quick, ..JointOptions::default() };
    let found = identified(&[], &large_signal, &quick);
    assert_eq!(found.trials.iter().map(|trial| trial.verdict).collect::<Vec<_>>(), ["taken"]);
    assert!(found.model.linear().a().len() <= 2 && error(&found.model, &plant) < 0.05, "{:?}", found.linear);
    // Another search reports a model long before its end.
    let mut count = 0;
    let found = identify_joint(&[], &large_signal, &named("pi"), &mut |stage| {
        count += usize::from(stage.model.is_some());
        if count > 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(found.unwrap().cancelled.is_some());
}

#[test]
fn the_result_is_bit_identical_for_one_and_two_threads() {
    let plant = plant(5e-4, 1);
    let large_signal = large_signal(&plant, 0.3, &[(11.0, 0.0), (29.0, 0.0), (61.0, 0.0)]);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| identified(&[prbs(&plant)], &large_signal, &named("bouc-wen")).model.to_json())
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn unsuitable_records_are_errors_or_noted() {
    let plant = plant(5e-4, 1);
    let good = large_signal(&plant, 0.4, &[(11.0, 0.0), (29.0, 0.0), (61.0, 0.0)]);
    let with = |r: &Record, of: &dyn Fn(usize, f64) -> f64| {
        let y = r.y().iter().enumerate().map(|(t, y)| of(t, *y)).collect();
        Record::new(r.ts(), r.u().to_vec(), y).unwrap()
    };
    let small = [prbs(&plant)];
    let settings = named("prandtl-ishlinskii");
    // Numbers unrelated to the input.
    let unrelated: Vec<Record> = good.iter().map(|r| with(r, &|t, _| ((t * t) as f64 * 0.618_034).fract())).collect();
    let message = identify_joint(&small, &unrelated, &settings, &mut Stage::ignore).unwrap_err().to_string();
    assert!(
        message.contains("no better than a constant does") && message.contains("large-signal record 2"),
        "{message}"
    );

    let noisy = with(&small[0], &|t, _| ((t * t) as f64 * 0.618_034).fract());
    let twins = [&good[..], &good[..1]].concat();
    for (small, large_signal, says) in [
        (vec![noisy], good.clone(), "small-signal record: the residual is"),
        (small.to_vec(), twins, "large-signal record 1 and large-signal record 4 are the same"),
        (small.to_vec(), cut(&good[..1], 30), "few for"),
        (small.to_vec(), cut(&good[..1], 30), "has a reversal"),
    ] {
        let notes = identified(&small, &large_signal, &settings).notes;
        assert!(notes.iter().any(|note| note.contains(says)), "{says}: {notes:?}");
    }
    let Identified { reasons, notes, .. } = identified(&small, &good, &settings);
    assert!(
        reasons[0].starts_with("linear block: ") && reasons[1].starts_with("search: the fit is at its minimum"),
        "{reasons:?}"
    );
    assert!(reasons.len() == 2 && notes.is_empty(), "{reasons:?} {notes:?}");
}

/// The first samples of each record.
fn cut(records: &[Record], n: usize) -> Vec<Record> {
    records.iter().map(|r| r.slice(0..n).unwrap()).collect()
}

/// Rising sines after a step that rings down, slower than the mode of the plant.
fn after_a_step(plant: &Model, noise: f64) -> Vec<Record> {
    let of = |(k, hz): (usize, f64)| {
        let sine = RisingSine { amplitude: 25.0, frequency: hz, ..RisingSine::default() }.samples(plant.ts(), 2000);
        let u: Vec<f64> = [vec![0.0; 100], vec![5.0; 500]].concat().into_iter().chain(sine.unwrap()).collect();
        let rough = |t: usize| noise * (((t * t + 7 * k) as f64 * 0.618_034).fract() - 0.5);
        let y = plant.simulate(&u).iter().enumerate().map(|(t, y)| y + rough(t)).collect();
        Record::new(plant.ts(), u, y).unwrap()
    };
    [3.0, 7.0].into_iter().enumerate().map(of).collect()
}

#[test]
fn a_mode_that_only_ringing_shows_is_found_and_the_note_says_how() {
    let plant = plant(5e-4, 1);
    let found = identified(&[], &after_a_step(&plant, 0.02), &named("prandtl-ishlinskii"));
    let resonance = found.model.linear().resonance().unwrap();
    assert_close(&[resonance.hz], &[60.0], 0.01, 0.0);
    assert_close(&[resonance.damping], &[0.1], 0.15, 0.0);
    assert!(found.linear.reason.contains("mode"), "{}", found.linear.reason);
    assert!(!found.notes.iter().any(|note| note.contains("no record has power near")), "{:?}", found.notes);
    assert!(error(&found.model, &plant) < 5e-3, "{}", error(&found.model, &plant));
}

/// Alone, it would have a lag of seconds in place of creep.
#[test]
fn the_linear_block_of_a_small_signal_record_that_creeps_is_found_behind_creep() {
    let lags = vec![Lag { tau_s: 0.16, gain: 0.03 }, Lag { tau_s: 1.6, gain: 0.06 }];
    let plant = plant(5e-4, 0).with_creep(Creep::new(5e-4, lags).unwrap()).unwrap();
    let chirp = |t: u32| 5.0 + (TAU * 2.0 * 3.0 / 4.6 * expm1(4.6 * 5e-4 / 3.0 * f64::from(t))).sin();
    let small = record(&plant, (0..6000).map(chirp).collect(), 0.0);
    let settings = named("prandtl-ishlinskii");
    let found =
        identified(&noisy(vec![small]), &noisy(large_signal(&plant, 2.0, &[(2.0, 0.0), (7.0, 0.0)])), &settings);
    assert!(found.linear.reason.ends_with("behind creep"), "{}", found.linear.reason);
    let resonance = found.model.linear().resonance().unwrap();
    assert_close(&[resonance.hz, resonance.damping], &[60.0, 0.1], 0.05, 0.0);
    assert!(error(&found.model, &plant) < 0.02, "{} {:?}", error(&found.model, &plant), found.model);
}

/// Creep as a sum over the whole past of z, which shares no code with lags: after a step of z it is 0.03 t^order.
#[test]
fn the_order_of_fractional_creep_is_found_to_a_hundredth() {
    for order in [0.12, 0.4] {
        let plant = plant(5e-3, 0);
        let crept = |u: Vec<f64>| {
            let z = plant.hysteresis().simulate(&u);
            let after: Vec<f64> = (0..z.len()).map(|t| 0.03 * (5e-3 * t as f64).powf(order)).collect();
            let steps: Vec<f64> = std::iter::once(z[0]).chain(z.windows(2).map(|z| z[1] - z[0])).collect();
            let creep = |t: usize| steps[..=t].iter().zip(after[..=t].iter().rev()).map(|(dz, c)| dz * c).sum::<f64>();
            let moved: Vec<f64> = (0..z.len()).map(|t| z[t] + creep(t)).collect();
            let y = plant.linear().simulate(&moved).iter().map(|y| y + 0.3).collect();
            Record::new(5e-3, u, y).unwrap()
        };
        let sine = |t: f64, hz: f64| (TAU * hz * 5e-3 * t).sin();
        let levels = |t: u32| [0.0, 20.0, -15.0, 25.0, -25.0, 5.0][(t / 1000) as usize];
        let path = |t: u32| 15.0 * (sine(f64::from(t), 0.06) + sine(f64::from(t), 1.3));
        let records = vec![crept((0..6000).map(levels).collect()), crept((0..6000).map(path).collect())];
        let settings = JointOptions { fractional_creep: true, ..named("prandtl-ishlinskii") };
        let of = |found: &Identified| found.parameters.iter().find(|p| p.name == "creep order [-]").unwrap().clone();
        let exact = of(&identified(&[], &records, &settings));
        let found = identified(&[], &noisy(records), &settings);
        assert_kept(&format!("search-creep-order-{order}"), &kept::text(&found));
        let of_noise = of(&found);
        assert!((exact.value - order).abs() < 0.01, "{exact:?}");
        assert!((of_noise.value - order).abs() < 2.0 * of_noise.error && of_noise.error < 0.1, "{of_noise:?}");
    }
}

#[test]
fn fractional_creep_without_creep_is_an_error() {
    let settings = JointOptions { fractional_creep: true, creep: false, ..named("prandtl-ishlinskii") };
    let record = record(&plant(5e-4, 0), vec![0.0; 100], 0.0);
    let error = identify_joint(&[], &[record], &settings, &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert!(error.to_string().starts_with("fractional_creep = true: needs creep"), "{error}");
}

#[test]
fn a_lag_before_the_hysteresis_is_found_and_belongs_to_the_driver() {
    let lag = 2e-3;
    let driver = piezoid_models::driver::DriverModel::new(lag, None).unwrap();
    let block = (Operator::find("prandtl-ishlinskii").unwrap().example)(5e-4 / 4.0).unwrap();
    let with_driver = Model::from_blocks(Some(driver), block, Arx::gain(5e-4, 1.2).unwrap(), 0.3).unwrap();
    let large_signal = large_signal(&with_driver, 0.8, &[(5.0, 0.0), (20.0, 0.0), (60.0, 0.0)]);
    let found = identified(&[], &large_signal, &named("prandtl-ishlinskii"));
    let observed = found.model.driver().map_or(f64::NAN, |driver| driver.lag_s);
    assert_close(&[observed], &[lag], 0.05, 0.0);
    assert!(
        found.parameters.iter().any(|p| p.name == "driver lag [s]" && p.value == observed),
        "{:?}",
        found.parameters
    );
    assert!(found.linear.reason.contains("driver lag 0.00"), "{}", found.linear.reason);
}

/// Rising sines after two cycles over the whole range, which end at zero from below, and a pause.
fn after_cycles(plant: &Model) -> Vec<Record> {
    let cycled = |hz: f64| {
        let cycle = |t: i32| -30.0 * (TAU * f64::from(t) / 400.0).sin();
        let sine = RisingSine { amplitude: 30.0, frequency: hz, ..RisingSine::default() }.samples(5e-4, 1600).unwrap();
        let u: Vec<f64> = (0..800).map(cycle).chain(vec![0.0; 400]).chain(sine).collect();
        let y = plant.simulate(&u);
        Record::new(5e-4, u[1200..].to_vec(), y[1200..].to_vec()).unwrap()
    };
    [5.0, 23.0, 47.0].map(cycled).into()
}

#[test]
fn records_after_cycles_over_the_whole_range_give_the_same_weights_as_records_from_rest() {
    let plant = plant(5e-4, 1);
    let found = identified(&[prbs(&plant)], &after_cycles(&plant), &named("prandtl-ishlinskii"));
    assert!(error(&found.model, &plant) < 1e-3, "{}", error(&found.model, &plant));
}

/// The search is in parts, which do not show the slow lag of creep.
#[test]
fn records_that_are_long_are_searched_in_parts_and_fitted_whole() {
    let plant = plant(5e-4, 0);
    let lags = vec![Lag { tau_s: 0.05, gain: 0.03 }, Lag { tau_s: 15.8, gain: 0.05 }];
    let plant = plant.clone().with_creep(Creep::new(5e-4, lags).unwrap()).unwrap();
    let sine = |t: f64, hz: f64| (TAU * hz * 5e-4 * t).sin();
    let path = |t: f64| sine(t, 0.02) + sine(t, 0.31) + sine(t, 3.7) * sine(t, 0.011);
    let u = |t: u32| 9.0 * path(f64::from(t));
    let records = noisy(vec![record(&plant, (0..160_000).map(u).collect(), 0.0)]);
    let found = identified(&[], &records, &named("prandtl-ishlinskii"));
    assert!(found.left_percent.is_none(), "{:?}", found.notes);
    assert_kept("search-parts", &kept::text(&found));
    let slow: f64 =
        found.model.creep().lags().iter().filter(|lag| (1.0..100.0).contains(&lag.tau_s)).map(|lag| lag.gain).sum();
    assert!((slow - 0.05).abs() < 0.01, "{:?}", found.model.creep().lags());
    let rms = |model: &Model| {
        let simulated = model.simulate(records[0].u());
        let errors: Vec<f64> = records[0].y().iter().zip(simulated).map(|(y, simulated)| y - simulated).collect();
        (scatter(&errors) / errors.len() as f64).sqrt()
    };
    // The state of slow creep before a record and the trend of its sensor look alike.
    assert!(rms(&found.model) < 2.0 * rms(&plant), "{} {}", rms(&found.model), rms(&plant));
}

#[test]
fn every_operator_gets_the_blocks_of_the_search_and_the_true_one_the_smallest_error() {
    let plant = plant(1e-3, 1);
    let records = noisy(large_signal(&plant, 4.0, &[(2.0, 0.0), (20.0, 0.0), (45.0, 0.0)]));
    let settings = named("prandtl-ishlinskii,bouc-wen");
    let rows = Operator::list("bouc-wen,dahl,prandtl-ishlinskii,proportional").unwrap();
    let each = identify_each((&[], &records), &settings, &rows, &|| 0.0, &mut Stage::ignore).unwrap();
    let alone = identify_joint(&[], &records, &settings, &mut Stage::ignore).unwrap();
    assert_eq!((&each.selected.model, each.cancelled.is_none()), (&alone.model, true));
    let of = |k: usize| each.operators[k].found.as_ref().unwrap();
    let names: Vec<&str> = (0..4).map(|k| of(k).model.hysteresis().operator().name).collect();
    assert_eq!(names, rows.iter().map(|row| row.name).collect::<Vec<_>>());
    assert_eq!(of(2).model, alone.model, "the selected operator");
    let error = |k: usize| {
        let y = of(k).model.simulate(records[1].u());
        let square: f64 = y.iter().zip(records[1].y()).map(|(m, y)| (y - m).powi(2)).sum();
        (square / scatter(records[1].y())).sqrt()
    };
    assert!(error(2) < 0.005 && (0..4).all(|k| k == 2 || error(k) > 2.0 * error(2)), "{:?}", [0, 1, 2, 3].map(error));
    assert!((0..4).all(|k| of(k).trials.len() == 1 && of(k).trials[0].operator == names[k]));
}
