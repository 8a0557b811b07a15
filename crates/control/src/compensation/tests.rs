mod kept;

use super::settings::BEYOND;
use super::*;
use piezoid_identification::{JointOptions, identify_joint};
use piezoid_models::creep::Creep;
use piezoid_models::driver::DriverModel;
use piezoid_models::hammerstein::Domain;
use piezoid_models::hysteresis::{OPERATORS, Operator};
use piezoid_models::linear::Arx;
use piezoid_numerics::progress::Stage;
use piezoid_numerics::stepper::Stepper;
use piezoid_records::excitation::{LimitOptions, Prbs, RisingSine, Triangle};
use piezoid_records::record::{Record, Units};
use piezoid_testing::golden::numbers;
use piezoid_testing::random::bits;
use piezoid_testing::{assert_close, in_feedback, noise, vectors};
use piezoid_twins::Plant;
use std::f64::consts::TAU;
use std::sync::Arc;

const TS: f64 = 5e-4;

const PLAYS: &str = "prandtl-ishlinskii";

/// A beam with hysteresis, creep and possibly a driver; +-30 V hold about +-1 mm.
fn model(operator: &str, driver: Option<DriverModel>) -> Model {
    let ts = TS / if driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 };
    let hysteresis = (Operator::find(operator).unwrap().example)(ts).unwrap();
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.5, 3.2]).unwrap();
    let creep = Creep::logarithmic(TS, 0.01, 0.05, 5.0).unwrap();
    Model::from_blocks(driver, hysteresis, block, 5.0).unwrap().with_creep(creep).unwrap()
}

fn inverse_of(model: &Model) -> FeedForward {
    inverse_with(model, FeedForwardSettings::default())
}

fn inverse_with(model: &Model, settings: FeedForwardSettings) -> FeedForward {
    FeedForward::new(model, settings).unwrap()
}

/// A sine about `bias`, constant at first, which starts without a corner.
fn sine(bias: f64, height: f64, hz: f64, n: usize) -> Vec<f64> {
    let begins = |t: f64| (t / 0.05).min(1.0).powi(2);
    let at = |t: f64| bias + if t > 0.0 { height * begins(t) * (TAU * hz * t).sin() } else { 0.0 };
    (0..n).map(|t| at((t as f64 - 80.0) * TS)).collect()
}

#[test]
fn the_free_run_follows_the_reference_for_every_operator_without_jumps_and_with_a_driver() {
    for o in OPERATORS.iter().filter(|o| o.minor_loops && o.wipes_out) {
        for driver in [None, Some(DriverModel::new(1e-4, Some(6e4)).unwrap())] {
            let model = model(o.name, driver);
            let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Default::default() };
            let inverse = inverse_with(&model, FeedForwardSettings { limits, ..Default::default() });
            let (low, high) = inverse.reach();
            let r = sine(0.5 * (low + high), 0.3 * (high - low), 20.0, 600);
            let result = inverse.whole(&r).unwrap();
            assert_close(&model.resume(&mut model.settled(result.u[0]), &result.u), &result.reached, 0.0, 1e-6);
            let error = rms_error(&r, &result.reached) / (high - low);
            assert!(error < 3e-4 && result.clipped == 0, "{}: {error:e}", o.name);
        }
    }
}

#[test]
fn if_the_hysteresis_jumps_over_the_reference_the_nearest_value_is_used_and_noted() {
    let inverse = inverse_of(&model("maxwell-slip", None));
    let (low, high) = inverse.reach();
    let result = inverse.whole(&sine(0.5 * (low + high), 0.3 * (high - low), 5.0, 1200)).unwrap();
    let noted = result.notes.iter().any(|n| n.contains("(it jumps)"));
    assert!(result.clipped == 0 && noted, "{:?}", result.notes);
}

#[test]
fn the_preview_covers_a_long_delay_of_the_block() {
    let error = |delay: usize| {
        let plays = (Operator::find(PLAYS).unwrap().example)(TS).unwrap();
        let b = [vec![0.0; delay], vec![3.5, 3.2]].concat();
        let model = Model::new(plays, Arx::new(TS, vec![1.7424, -0.9453], b).unwrap(), 0.0).unwrap();
        let r = sine(0.0, 300.0, 10.0, 1200);
        rms_error(&r[200..], &inverse_of(&model).whole(&r).unwrap().reached[200..])
    };
    assert!(error(1) < 0.01 && error(100) < 0.1, "{} {}", error(1), error(100));
}

#[test]
fn a_constant_displacement_is_held_exactly() {
    let result = inverse_of(&model(PLAYS, None)).whole(&[321.0; 500]).unwrap();
    assert_close(&result.reached, &[321.0; 500], 1e-9, 0.0);
    assert_close(&result.u, &[result.u[0]; 500], 1e-9, 0.0);
}

#[test]
fn a_reference_that_ends_in_motion_is_followed_to_its_end() {
    let r = sine(0.0, 700.0, 40.0, 1000);
    let result = inverse_of(&model(PLAYS, None)).whole(&r).unwrap();
    assert!((r[999] - r[998]).abs() > 50.0, "it moves at its end");
    assert_close(&result.reached[900..], &r[900..], 0.0, 0.5);
}

#[test]
fn for_a_reference_that_starts_too_fast_the_error_asks_for_a_constant_start() {
    let r: Vec<f64> = (0..400).map(|t| 700.0 * (TAU * 200.0 * TS * f64::from(t)).sin()).collect();
    let message = inverse_of(&model(PLAYS, None)).whole(&r).unwrap_err().to_string();
    assert!(
        message.contains("at sample 0 (0 s)") && message.contains("begin the reference with some milliseconds"),
        "{message}"
    );
}

#[test]
fn iterations_reduce_the_error_of_the_free_run_and_are_noted() {
    let model = model("preisach", None);
    let r: Vec<f64> = sine(0.0, 400.0, 40.0, 800).iter().map(|r| 50.0 * (r / 50.0).round()).collect();
    let smooth = Fir::smooth(TS, 0.004).unwrap().whole(&r);
    let corrected = |iterations| {
        let settings = FeedForwardSettings { iterations, clip: true, ..Default::default() };
        let result = inverse_with(&model, settings).whole(&smooth).unwrap();
        (rms_error(&smooth, &result.reached), result.notes.iter().any(|note| note.contains("correction iterations")))
    };
    let (none, some) = (corrected(0), corrected(10));
    assert!(some.0 < 0.7 * none.0 && some.1 && !none.1, "{none:?} {some:?}");
}

#[test]
fn values_out_of_reach_are_errors_or_clipped_and_counted() {
    let model = model(PLAYS, None);
    let r = sine(0.0, 3000.0, 5.0, 1000);
    let message = |r: &[f64]| inverse_of(&model).whole(r).unwrap_err().to_string();
    assert!(
        message(&r).contains("the reference cannot be reached") && message(&r).contains("reduce its amplitude"),
        "{}",
        message(&r)
    );
    let clip = FeedForwardSettings { clip: true, ..Default::default() };
    let result = inverse_with(&model, clip).whole(&r).unwrap();
    assert!(result.clipped > 300 && result.notes[0].contains("of 1000 samples are clipped"), "{:?}", result.notes);
    assert!(result.u.iter().all(|u| u.abs() <= 30.0 * (1.0 + 2.0 * BEYOND) + 1e-9));
    let step = [vec![0.0; 80], vec![600.0; 400]].concat();
    assert!(message(&step).contains("slow it down or smooth it"), "{}", message(&step));
}

#[test]
fn limits_of_slew_and_current_are_errors_or_kept() {
    let model = model(PLAYS, None);
    let limits = Limits { current: Some(0.02), capacitance: Some(8.2e-6), ..Default::default() };
    let r = sine(0.0, 700.0, 20.0, 1000);
    let whole = |clip| {
        let settings = FeedForwardSettings { limits, clip, ..Default::default() };
        inverse_with(&model, settings).whole(&r)
    };
    let message = whole(false).unwrap_err().to_string();
    assert!(message.contains("current") && message.contains("limit 0.02 A"), "{message}");
    let result = whole(true).unwrap();
    assert!(limits.refuse(&result.u, TS).is_ok() && result.clipped > 100);
    assert!(result.usage.current.is_some_and(|peak| peak.share.is_some_and(|share| share > 0.99)));
}

#[test]
fn invalid_references_and_models_are_errors() {
    let inverse = inverse_of(&model(PLAYS, None));
    assert!(inverse.whole(&[0.0, f64::NAN]).unwrap_err().to_string().starts_with("reference[1] is NaN"));
    assert!(inverse.whole(&[]).unwrap_err().to_string().contains("the reference has 0 samples"));
    let refused = |model: Model, settings| FeedForward::new(&model, settings).unwrap_err().to_string();
    let proportional = |k: f64| Arc::new(piezoid_models::hysteresis::Proportional::new(TS, k).unwrap());
    let plain = |k: f64| Model::new(proportional(k), Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap();
    assert!(refused(plain(1.0), FeedForwardSettings::default()).contains("driver = none"));
    let volts = Limits { low: Some(-30.0), high: Some(30.0), ..Default::default() };
    let within = FeedForwardSettings { limits: volts, ..Default::default() };
    assert!(refused(plain(0.0), within).contains("no inverse of its hysteresis"));
    let units = Units { u: "counts".into(), y: "um".into() };
    assert!(refused(plain(1.0).with_units(units), within).contains("counts"));
    let limits = Limits { low: Some(50.0), high: Some(60.0), ..Default::default() };
    let high = FeedForwardSettings { limits, ..Default::default() };
    assert!(refused(model("preisach", None), high).contains("must overlap"));
    let differences = Arx::new(TS, vec![], vec![1.0, -1.0]).unwrap();
    let no_gain = Model::new(proportional(1.0), differences, 0.0).unwrap();
    assert!(refused(no_gain, within).contains("no bounded inverse"));
}

#[test]
fn sample_by_sample_the_displacement_has_the_given_delay() {
    let model = model("generalised-prandtl-ishlinskii", Some(DriverModel::new(1e-4, None).unwrap()));
    let (low, high) = inverse_of(&model).reach();
    let r = sine(0.5 * (low + high), 0.25 * (high - low), 10.0, 1200);
    for delay_samples in [1, 4, 16] {
        let causal = Causal::new(&model, FeedForwardSettings::default(), delay_samples).unwrap();
        let u = causal.resume(&mut causal.settled(r[0]), &r);
        let y = model.resume(&mut model.settled(u[0]), &u);
        let error = rms_error(&r[..r.len() - delay_samples], &y[delay_samples..]) / (high - low);
        assert!(causal.delay_samples() == delay_samples && error < 2e-3, "{delay_samples}: {error:e}");
    }
    let causal = Causal::new(&model, FeedForwardSettings::default(), 2).unwrap();
    let rest = model.simulate(&[0.0; 4000])[3999];
    assert!(causal.simulate(&[rest; 50]).iter().all(|u| u.abs() < 1e-9));
}

#[test]
fn sample_by_sample_invalid_values_are_replaced_by_the_previous_and_others_clipped() {
    let model = model("preisach", None);
    let causal = Causal::new(&model, FeedForwardSettings::default(), 2).unwrap();
    let r: Vec<f64> = sine(0.0, 400.0, 10.0, 300);
    let with = |at: &[(usize, f64)]| {
        let mut r = r.clone();
        at.iter().for_each(|(t, value)| r[*t] = *value);
        causal.resume(&mut causal.settled(0.0), &r)
    };
    assert_eq!(with(&[(150, f64::NAN), (151, f64::INFINITY)]), with(&[(150, r[149]), (151, r[149])]));
    let high = inverse_of(&model).ends.1;
    let far = with(&[(150, 1e6)]);
    assert!(far.iter().all(|u| u.is_finite()) && far[150..155].contains(&high));
}

/// The twin of a bender and a model identified on records of it.
fn identified() -> (Plant, Model) {
    let plant = Plant::named("pl140", TS).unwrap();
    let record = |u: Vec<f64>| {
        let y = plant.run(&u).y;
        Record::new(TS, u, y).unwrap()
    };
    let small_signal = [record(Prbs::default().samples(TS, 4094).unwrap())];
    let rising = |frequency: f64, n| {
        record(RisingSine { amplitude: 28.0, frequency, ..Default::default() }.samples(TS, n).unwrap())
    };
    let large_signal = [rising(2.0, 6000), rising(40.0, 3000)];
    let operator = "generalised-prandtl-ishlinskii".into();
    let options = JointOptions { operator, order: Some(5), ..Default::default() };
    let model = identify_joint(&small_signal, &large_signal, &options, &mut Stage::ignore).unwrap().model;
    (plant, model)
}

#[test]
fn on_the_twin_the_inverse_is_ten_times_better_than_a_gain_and_learning_is_better_still() {
    let (plant, model) = identified();
    let inverse = inverse_of(&model);
    let answer = |u: &[f64]| plant.run(u).y;
    let (low, high) = inverse.reach();
    let gain = (high - low) / (inverse.ends.1 - inverse.ends.0);
    for hz in [5.0, 40.0] {
        let r = sine(0.0, 800.0, hz, 1500);
        let none = rms_error(&r, &answer(&r.iter().map(|r| r / gain).collect::<Vec<_>>()));
        let result = rms_error(&r, &answer(&inverse.whole(&r).unwrap().u));
        assert!(10.0 * result < none, "{hz} Hz: {result} um instead of {none} um");
    }
    // 40 Hz; for the triangle a tenth of a percent of the stroke.
    let sine: Vec<f64> = (0..50).map(|t| 800.0 * (TAU * f64::from(t) / 50.0).sin()).collect();
    let triangle = Triangle { amplitude: 800.0, frequency: 40.0, ..Default::default() }.samples(TS, 50).unwrap();
    for (period, most) in [(sine, 0.5), (triangle, 1.6)] {
        let mut x = plant.initial();
        let mut trial = |u: &[f64]| (0..4).map(|_| plant.resume(&mut x, u)).last().unwrap();
        let learned = Learning::default().run(&mut trial, &inverse, &period).unwrap();
        let best = rms_error(&period, &learned.y);
        assert!(best < most && best < 0.5 * learned.rms[0], "{:?}", learned.rms);
    }
}

#[test]
fn learning_adapts_to_a_resonance_at_another_frequency() {
    // 166 Hz in the model, 135 Hz on the plant, both with a damping of 0.03: at 140 Hz the response has the opposite
    // sign.
    let beam = |hz: f64| {
        let (decay, angle) = (0.03 * TAU * hz * 5e-4, TAU * hz * 5e-4);
        let a = vec![2.0 * (-decay).exp() * angle.cos(), -(-2.0 * decay).exp()];
        let b = 30.0 * (1.0 - a.iter().sum::<f64>());
        Arx::new(5e-4, a, vec![0.0, b]).unwrap()
    };
    let plays = (Operator::find(PLAYS).unwrap().example)(5e-4).unwrap();
    let of = |hz| Model::new(plays.clone(), beam(hz), 0.0).unwrap();
    let inverse = inverse_of(&of(166.0));
    let r = Triangle { amplitude: 300.0, frequency: 20.0, ..Default::default() }.samples(5e-4, 100).unwrap();
    let (truth, mut x) = (of(135.0), of(135.0).initial());
    let mut trial = |u: &[f64]| {
        (0..8).for_each(|_| drop(truth.resume(&mut x, u)));
        truth.resume(&mut x, u)
    };
    let learned = (Learning { trials: 31, ..Default::default() }).run(&mut trial, &inverse, &r).unwrap();
    let least = learned.rms.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least < 0.05 * learned.rms[0], "{:?}", learned.rms);
}

#[test]
fn learning_checks_the_responses_and_discards_bad_trials() {
    let inverse = inverse_of(&model(PLAYS, None));
    let r: Vec<f64> = (0..100).map(|t| 500.0 * (TAU * f64::from(t) / 100.0).sin()).collect();
    let learnt = |plant: &mut dyn FnMut(&[f64]) -> Vec<f64>| Learning::default().run(plant, &inverse, &r);
    assert!(learnt(&mut |_| vec![0.0; 3]).unwrap_err().to_string().contains("has 3 samples"));
    assert!(learnt(&mut |_| vec![f64::NAN; 100]).unwrap_err().to_string().contains("NaN"));
    // An actuator with the opposite sign: every correction increases the error.
    let first = learnt(&mut |u| u.iter().map(|u| -20.0 * u).collect()).unwrap();
    let best = first.rms.iter().copied().fold(f64::INFINITY, f64::min);
    assert_close(&[rms_error(&r, &first.y)], &[best], 1e-12, 0.0);
    let idle = Learning { trials: 0, ..Default::default() }.run(&mut |u| u.to_vec(), &inverse, &r).unwrap_err();
    let empty = Learning::default().run(&mut |u| u.to_vec(), &inverse, &[]).unwrap_err();
    assert!(idle.to_string().starts_with("trials = 0") && empty.to_string().contains("for a non-empty reference"));
    let none = Learning { gain: 0.0, ..Default::default() };
    assert!(none.run(&mut |u| u.to_vec(), &inverse, &r).unwrap_err().to_string().starts_with("gain = 0"));
}

const LIMITS: Limits = Limits { low: Some(-30.0), high: Some(30.0), slew: Some(2e4), current: None, capacitance: None };

/// A compensator of every operator, with and without a driver, and of mechanics with hysteresis in feedback.
fn compensators() -> Vec<(String, Causal)> {
    let driver = DriverModel::new(1e-4, Some(6e4)).unwrap();
    let mut models: Vec<(String, Model)> = OPERATORS.iter().map(|o| (o.name.into(), model(o.name, None))).collect();
    models.push(("driven".into(), model(PLAYS, Some(driver))));
    let read = |(name, document): (&str, serde_json::Value)| {
        (name.to_string(), Model::from_json(&document.to_string()).unwrap())
    };
    models.extend(in_feedback().into_iter().map(read));
    let of = |(name, model): (String, Model)| {
        let settings = FeedForwardSettings { limits: LIMITS, ..FeedForwardSettings::default() };
        let delay = *Causal::delays(&model).start() + 2;
        (name, Causal::new(&model, settings, delay).unwrap())
    };
    models.into_iter().map(of).collect()
}

#[test]
fn a_run_of_which_samples_are_refused_is_that_of_the_acknowledged_samples_and_continues_from_its_saved_state() {
    for (k, (name, causal)) in compensators().into_iter().enumerate() {
        let draws = noise(k as u64 + 1, 600);
        let top = if causal.inverse.model().feedback().is_some() { 12.0 } else { 400.0 };
        let mut compensator = Stepper::new(causal.clone());
        let (mut acknowledged, mut voltages, mut refusals) = (Vec::new(), Vec::new(), 0);
        for (t, draw) in draws.iter().enumerate() {
            let r = if t == 77 { f64::NAN } else { top * (0.05 * t as f64).sin() + 0.1 * top * draw };
            let u = compensator.plan(r);
            // A third of a normal distribution lies above 0.43 of its deviation.
            if *draw > 0.43 {
                refusals += 1;
            } else {
                compensator.commit().unwrap();
                acknowledged.push(r);
                voltages.push(u);
            }
            if t == 300 {
                let text = serde_json::to_string(&compensator.save()).unwrap();
                compensator = Stepper::new(causal.clone());
                compensator.restore(&serde_json::from_str(&text).unwrap()).unwrap();
            }
        }
        let alone = Stepper::new(causal).resume(&acknowledged);
        assert_eq!(bits(&alone), bits(&voltages), "{name}");
        assert!((150..250).contains(&refusals), "{refusals}");
    }
}

#[test]
fn a_state_of_another_model_or_delay_is_refused_and_one_with_any_finite_numbers_is_no_danger() {
    let all = compensators();
    for (k, (name, causal)) in all.iter().enumerate() {
        let other = Stepper::new(all[(k + 1) % all.len()].1.clone()).save();
        let mut compensator = Stepper::new(causal.clone());
        let error = compensator.restore(&other).unwrap_err().to_string();
        assert!(error.contains("state of another model"), "{name}: {error}");
        let settings = FeedForwardSettings { limits: LIMITS, ..FeedForwardSettings::default() };
        let longer = Causal::new(causal.inverse.model(), settings, causal.delay_samples() + 1).unwrap();
        assert!(compensator.restore(&Stepper::new(longer).save()).is_err(), "{name}");
        for wild in [1e300, -1e300, 5e-324, 1e18, -7.0] {
            let mut saved = compensator.save();
            saved.numbers.fill(wild);
            compensator.restore(&saved).unwrap();
            compensator.resume(&[10.0, -20.0, 1e9]);
            let mut model = Stepper::new(causal.inverse.model().clone());
            let mut saved = model.save();
            saved.numbers.fill(wild);
            model.restore(&saved).unwrap();
            model.resume(&[1.0, -20.0, 0.0]);
            compensator.set_state(causal.initial()).unwrap();
        }
    }
}

#[test]
fn the_causal_inverses_give_the_numbers_that_they_gave_in_every_version() {
    for (path, file) in vectors().iter().filter(|(_, file)| !file["ff_step"].is_null()) {
        let model = Model::from_json(&file["model"].to_string()).unwrap();
        let of = |key| numbers(&file["ff_step"], key);
        let causal = Causal::new(&model, FeedForwardSettings::default(), 0).unwrap();
        assert_eq!(causal.simulate(&of("inputs")), of("outputs"), "{}", path.display());
    }
}

#[test]
fn inputs_beyond_those_of_the_identification_are_noted() {
    let wave = |height: f64, hz: f64| -> Vec<f64> {
        (0..2000).map(|t| height * (TAU * hz * TS * f64::from(t)).sin()).collect()
    };
    let known = Domain::of_input(&wave(10.0, 5.0), TS);
    let inverse = inverse_of(&model(PLAYS, None).with_identified(known));
    assert_eq!(inverse.beyond(&wave(10.0, 5.0)), Vec::<String>::new());
    let wide = inverse.beyond(&wave(20.0, 1.0));
    assert!(wide.len() == 1 && wide[0].starts_with("inputs from -20"), "{wide:?}");
    assert!(wide[0].contains(" to 20") && wide[0].contains("identified from -10"), "{wide:?}");
    let fast = inverse.beyond(&wave(10.0, 15.0));
    assert!(fast.len() == 1 && fast[0].starts_with("the input changes by 94"), "{fast:?}");
    assert!(fast[0].contains("at most by 314"), "{fast:?}");
    assert_eq!(inverse_of(&model(PLAYS, None)).beyond(&wave(99.0, 99.0)), Vec::<String>::new());
}

#[test]
fn a_model_compensates_a_whole_reference_by_its_inverse_without_settings() {
    let (model, r) = (model(PLAYS, None), sine(0.0, 300.0, 10.0, 600));
    assert_eq!(model.compensate(&r).unwrap(), inverse_of(&model).whole(&r).unwrap());
    assert!(model.compensate(&[1e6; 9]).is_err());
}

#[test]
fn settings_take_the_limits_of_a_driver_and_its_options() {
    let limits = Limits { low: Some(-5.0), high: Some(7.0), ..Limits::default() };
    let options = LimitOptions { driver: None, own: limits };
    let settings = FeedForwardSettings::within(&options, true).unwrap();
    assert_eq!(settings, FeedForwardSettings { limits, clip: true, iterations: 0 });
    let none = FeedForwardSettings::within(&LimitOptions::default(), false).unwrap();
    assert_eq!(none, FeedForwardSettings::default());
}

#[test]
fn the_ends_of_the_reach_are_held_and_a_reference_beyond_them_from_its_start_is_clipped() {
    let model = model(PLAYS, None);
    let (low, high) = inverse_of(&model).reach();
    for r in [low, high] {
        let result = inverse_of(&model).whole(&[r; 50]).unwrap();
        assert_eq!(result.clipped, 0);
        assert_close(&result.reached, &[r; 50], 1e-8, 0.0);
    }
    let inverse = inverse_with(&model, FeedForwardSettings { clip: true, ..Default::default() });
    for (r, end) in [(-1e6, inverse.ends.0), (1e6, inverse.ends.1)] {
        let far = inverse.whole(&[r; 50]).unwrap();
        assert_eq!((far.u, far.clipped), (vec![end; 50], 50));
    }
}

#[test]
fn corrections_are_taken_while_they_keep_the_limits_and_reduce_the_error_by_more_than_a_fiftieth() {
    let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Default::default() };
    let inverses = [false, true]
        .map(|clip| inverse_with(&model(PLAYS, None), FeedForwardSettings { limits, clip, ..Default::default() }));
    // The errors of the runs, and of all but the first the voltage and the sample that is limited.
    let ended = |clip: bool, errors: &[f64], u: f64, missed: Option<usize>| {
        let runs = std::cell::Cell::new(0);
        let invert = |_: &[f64]| {
            let run = runs.replace(runs.get() + 1);
            let (u, missed) = if run > 0 { (u, missed) } else { (0.0, None) };
            InverseRun { u: vec![u], reached: vec![errors[run]], missed, ..Default::default() }
        };
        let most = errors.len() - 1;
        let ended = inverses[usize::from(clip)].corrected(&[0.0], vec![0.0], most, invert, <[f64]>::to_vec);
        ended.map(|(best, corrections, first)| (best.rms, corrections, first)).unwrap()
    };
    assert_eq!(ended(false, &[1.0, 0.5, 0.2], 0.0, None), (0.2, 2, 1.0));
    assert_eq!(ended(false, &[1.0, 0.97, 0.96], 0.0, None), (0.97, 1, 1.0));
    assert_eq!(ended(false, &[1.0, 0.98], 0.0, None), (1.0, 0, 1.0));
    for (u, missed) in [(0.0, Some(0)), (40.0, None)] {
        assert_eq!(ended(false, &[1.0, 0.5], u, missed), (1.0, 0, 1.0));
        assert_eq!(ended(true, &[1.0, 0.5], u, missed), (0.5, 1, 1.0));
    }
}

#[test]
fn the_error_for_a_reference_out_of_reach_states_what_helps() {
    let limits = Limits { low: Some(-10.0), high: Some(10.0), ..Default::default() };
    let rises = Arc::new(piezoid_models::hysteresis::Proportional::new(TS, 1.0).unwrap());
    let plain = Model::new(rises, Arx::gain(TS, 2.0).unwrap(), 0.0).unwrap();
    let inverse = inverse_with(&plain, FeedForwardSettings { limits, ..Default::default() });
    let message = |r: &[f64], sample| inverse.unreachable(r, sample).to_string();
    for (r, helps) in [
        ([-100.0, 200.0], "this is 7.500 times the stroke: check the unit"),
        ([-100.0, 100.0], "reduce its amplitude"),
        ([-20.0, 30.0], "reduce its amplitude"),
        ([0.0, 40.0], "shift it into this range"),
        ([-40.0, 0.0], "shift it into this range"),
    ] {
        let message = message(&r, 0);
        assert!(message.contains(helps) && message.contains("only -20 to 20 um can be held"), "{message}");
    }
    // The preview of a whole reference is 64 samples.
    let (before, after) = (message(&[5.0; 70], 63), message(&[5.0; 70], 64));
    assert!(before.contains("5 um at sample 63 (0.0315 s)") && before.contains("begin the reference"), "{before}");
    assert!(after.contains("5 um at sample 64 (0.032 s)") && after.contains("changes too fast there"), "{after}");
}

#[test]
fn learning_refuses_a_first_voltage_beyond_the_limits_and_states_where() {
    let model = model(PLAYS, None);
    let learnt = |inverse: &FeedForward, r: &[f64]| {
        Learning::default().run(&mut |u| u.to_vec(), inverse, r).unwrap_err().to_string()
    };
    let wave = |height: f64| (0..100).map(|t| height * (TAU * f64::from(t) / 100.0).sin()).collect::<Vec<f64>>();
    let far = learnt(&inverse_of(&model), &wave(3000.0));
    assert!(far.contains("reduce its amplitude"), "{far}");
    let limits = Limits { slew: Some(100.0), ..Default::default() };
    let slow = learnt(&inverse_with(&model, FeedForwardSettings { limits, ..Default::default() }), &wave(300.0));
    assert!(slow.contains("limit 100 V/s"), "{slow}");
    // A jump in the middle of the period, long after the one before.
    let jumps = learnt(&inverse_of(&model), &[[0.0; 100], [600.0; 100], [0.0; 100]].concat());
    let sample = jumps.split("at sample ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    assert!((60..=105).contains(&sample.parse().unwrap()), "{jumps}");
}

#[test]
fn the_longest_delay_is_allowed_and_each_delay_marks_the_fingerprint_of_the_model_alike() {
    let limits = Limits { low: Some(-10.0), high: Some(10.0), ..Default::default() };
    let of = |gain: f64, delay| {
        let rises = Arc::new(piezoid_models::hysteresis::Proportional::new(TS, 1.0).unwrap());
        let plain = Model::new(rises, Arx::gain(TS, gain).unwrap(), 0.0).unwrap();
        Causal::new(&plain, FeedForwardSettings { limits, ..Default::default() }, delay)
    };
    assert_eq!(of(2.0, 488).unwrap().delay_samples(), 488);
    assert!(of(2.0, 489).unwrap_err().to_string().starts_with("delay_samples = 489: must be at most 488"));
    let mark = |gain, delay| {
        let causal = of(gain, delay).unwrap();
        causal.fingerprint() ^ causal.inverse.model().fingerprint()
    };
    let marks = [0, 1, 2].map(|delay| mark(2.0, delay));
    assert_eq!([0, 1, 2].map(|delay| mark(5.0, delay)), marks);
    assert!(marks.iter().all(|mark| *mark != 0) && marks[0] != marks[1] && marks[1] != marks[2]);
}
