use super::*;
use crate::measuring::{served, text};
use crate::{ConnectOptions, Function, Simulation};
use piezoid::excitation::{Prbs, RisingSine};
use piezoid::hammerstein::Domain;
use piezoid::hysteresis::Proportional;
use piezoid::linear::Arx;
use piezoid::plant::{Plant, Preset};
use piezoid::progress::Stage;
use piezoid::{IdentifyOptions, Record, Records, identify};
use piezoid_numerics::options::Options;
use piezoid_testing::assert_close;
use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Sampling period of all tests [s].
const TS: f64 = 5e-4;

fn options(values: serde_json::Value) -> MeasuredTimingOptions {
    let mut options = MeasuredTimingOptions::from_json(values).unwrap();
    (options.wait, options.instrument.ramp) = (0.2, 0.1);
    options
}

fn at(port: u16, options: &MeasuredTimingOptions) -> MeasuredTimingOptions {
    let connection = ConnectOptions { port, ..ConnectOptions::default() };
    let instrument = InstrumentOptions { connection, ..options.instrument.clone() };
    MeasuredTimingOptions { instrument, ..options.clone() }
}

/// A gain of 20 um/V, identified between -28 and 28 V.
fn gain() -> Model {
    let model = Model::new(Arc::new(Proportional::new(TS, 1.0).unwrap()), Arx::gain(TS, 20.0).unwrap(), 0.0).unwrap();
    model.with_identified(Domain::of_input(&[-28.0, 28.0], TS))
}

/// A model that is identified from records of the plant `pl140`.
fn of_bender() -> Model {
    let plant = Plant::named("pl140", TS).unwrap();
    let record = |u: Vec<f64>| Record::new(TS, u.clone(), plant.run(&u).y).unwrap();
    let rising = |frequency: f64, n| {
        record(RisingSine { amplitude: 28.0, frequency, ..RisingSine::default() }.samples(TS, n).unwrap())
    };
    let small_signal = [record(Prbs::default().samples(TS, 4094).unwrap())];
    let large_signal = [rising(2.0, 6000), rising(40.0, 3000)];
    let options = IdentifyOptions { operator: "preisach".into(), order: Some(5), ..IdentifyOptions::default() };
    identify(Records { small_signal: &small_signal, large_signal: &large_signal }, &options).unwrap().model
}

/// Held values, 0.3 s each.
fn held(values: &[f64]) -> Vec<f64> {
    values.iter().flat_map(|v| vec![*v; 600]).collect()
}

fn yes(_: &str) -> Result<(), Error> {
    Ok(())
}

/// The timing by a function around the plant `pl140` whose sensor has an offset [um], and the voltages it was given.
fn on_a_function(
    model: &Model,
    offset: f64,
    agree: &mut Agree,
    progress: &mut Progress,
) -> (Result<MeasuredTiming, Error>, Vec<String>, usize) {
    let (played, mut notes) = (Cell::new(0), Vec::new());
    let plant = Plant::named("pl140", TS).unwrap();
    let mut x = plant.initial();
    let call = |u: &[f64]| {
        played.set(played.get() + u.len());
        Ok(plant.resume(&mut x, u).into_iter().map(|y| y + offset).collect())
    };
    let options = options(json!({"tolerance": "5um", "driver": "pl140", "smooth": 0.012}));
    let path = Some(held(&[-100.0, 100.0]));
    let mut function = Function::new((-30.0, 30.0), TS, Box::new(call), progress).unwrap();
    let found = options.on(&mut function, (model, path), &Players::default(), agree, &mut notes, &mut Stage::ignore);
    drop(function);
    (found, notes, played.get())
}

/// Moves of 12 ms settle on a simulated controller when they do on the plant that is in it, after a demagnetisation.
#[test]
fn a_compensated_path_settles_on_a_controller_as_on_its_plant() {
    let (model, spec) = (of_bender(), Preset::find("pl140").unwrap().spec());
    let port = served(&Simulation { virtual_time: Some(0.05), ..Simulation::default() });
    let options = at(port, &options(json!({"tolerance": "5um", "driver": "pl140", "smooth": 0.012})));
    let (mut notes, mut announced) = (Vec::new(), String::new());
    let mut agree = |text: &str| {
        announced = text.into();
        Ok(())
    };
    let players = Players { plant: Some(("pl140", &spec.into())), measured: None };
    let path = Some(held(&[-100.0, 100.0, 300.0, -200.0]));
    let found = options.run((&model, path), &players, &mut agree, &mut notes, &mut Stage::ignore).unwrap();
    assert!(announced.contains("axis 1 is to move between -2") && announced.ends_with(" s or more."), "{announced}");
    let names: Vec<&str> = found.timing.runs.iter().skip(2).map(|run| &*run.name).collect();
    let expected =
        ["pl140, compensated", "pl140, straight line", "controller, compensated", "controller, straight line"];
    assert_eq!(names, expected);
    for k in 0..3 {
        let step = |run: usize| found.timing.runs[run].steps[k];
        println!("{:?}", [0, 2, 4, 1, 3, 5].map(|run| (step(run).settling_s, step(run).overshoot)));
        assert_close(&[step(4).settling_s.unwrap()], &[step(2).settling_s.unwrap()], 0.0, 2.0 * TS);
        assert_close(&[step(4).overshoot], &[step(2).overshoot], 0.0, found.timing.tolerance);
    }
    // The straight line misses the goals by the hysteresis, on both alike.
    for (of_plant, of_controller) in [(2, 4), (3, 5)] {
        let displacements = &found.timing.displacements;
        assert_close(&displacements[of_controller], &displacements[of_plant], 0.0, found.timing.tolerance);
    }
    assert_eq!((found.left.voltage, found.unfinished.clone()), (Some(0.0), None));
    assert!(text(port, "VOL?\n").starts_with("1=0.000000") && text(port, "\x09") == "0x0\n");
    assert_eq!(found.to_json()["controller"]["state"], "axis 1 is at 0.000 V, in open loop");
}

#[test]
fn the_offset_of_a_sensor_is_no_error_of_a_path() {
    let model = gain();
    let [without, with] = [0.0, 70.0].map(|offset| on_a_function(&model, offset, &mut yes, &mut Stage::ignore).0);
    let [without, with] = [without, with].map(|found| found.unwrap().timing);
    assert_eq!(without.runs.len(), 4);
    for (a, b) in without.displacements.iter().zip(&with.displacements) {
        assert_close(b, a, 0.0, 1e-9);
    }
    // At rest before the path the plant is where the model is, but for the error of a gain without hysteresis.
    assert!((without.displacements[2][0] - without.path[0]).abs() < 40.0, "{}", without.displacements[2][0]);
}

#[test]
fn a_refusal_moves_nothing() {
    let no = &mut |text: &str| Err(Error::Content(format!("not agreed: {text}")));
    let (found, notes, played) = on_a_function(&gain(), 0.0, no, &mut Stage::ignore);
    let message = found.unwrap_err().to_string();
    assert!(message.starts_with("not agreed: a function: axis 1 is to move between -2"), "{message}");
    assert!(played == 0 && notes.is_empty(), "{played} {notes:?}");
    // A path beyond the limits is not even announced, and nor is one that the controller cannot play.
    let port = served(&Simulation { virtual_time: Some(0.05), ..Simulation::default() });
    let refused = |values: serde_json::Value, path: Vec<f64>| {
        let options = at(port, &options(values));
        let agree = &mut |text: &str| panic!("{text}");
        let run = options.run((&gain(), Some(path)), &Players::default(), agree, &mut Vec::new(), &mut Stage::ignore);
        run.unwrap_err().to_string()
    };
    assert!(refused(json!({"low": -5, "high": 5}), held(&[0.0, 200.0])).contains("cannot be"));
    assert!(refused(json!({"tolerance": "3V"}), held(&[0.0, 200.0])).contains("tolerance"));
    let long = [vec![0.0; 40_000], vec![10.0; 100]].concat();
    let message = refused(json!({"slew": 1e4}), long);
    assert!(message.contains("compensated") && message.contains("recorder of the controller holds"), "{message}");
    let message = refused(json!({}), held(&[-500.0, 500.0]));
    assert!(message.contains("jumps by") && message.contains("`driver` or `slew`"), "{message}");
    assert!(text(port, "VOL?\n").starts_with("1=0.000000"));
}

#[test]
fn a_path_that_is_cancelled_leaves_the_axis_at_rest_and_states_where() {
    let port = served(&Simulation { virtual_time: Some(0.05), ..Simulation::default() });
    let options = at(port, &options(json!({"tolerance": "5um", "driver": "pl140", "smooth": 0.012})));
    let mut stop = |stage: Stage| match stage.what == "compensated: the drive is played [ms]" && stage.done > 300 {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let (model, mut notes) = (gain(), Vec::new());
    let path = Some(held(&[-100.0, 100.0, -100.0]));
    let found = options.run((&model, path), &Players::default(), &mut yes, &mut notes, &mut stop);
    assert!(matches!(found, Err(Error::Cancelled { .. })), "{found:?}");
    assert_eq!(text(port, "\x09"), "0x0\n", "the wave generator is stopped");
    let voltage = text(port, "VOL?\n");
    let voltage: f64 = voltage.trim().strip_prefix("1=").unwrap().parse().unwrap();
    let stated = format!("axis 1 is at {voltage:.3} V");
    assert!(notes.iter().any(|note| note.contains(&stated)), "{stated}: {notes:?}");
    assert_eq!(text(port, "VOL?\n"), format!("1={voltage:.6}\n"));
}
