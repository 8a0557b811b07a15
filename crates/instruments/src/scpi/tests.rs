//! The client against the simulated instruments, over TCP.

use crate::faulty::assert_response_of_the_plant;
use crate::measuring::{but, drive, refused, run, sine, text};
use crate::{AcquireOptions, ConnectOptions, InstrumentOptions, Model, Protocol, Rest, ScpiOptions, Simulation};
use piezoid::excitation::LimitOptions;
use piezoid::progress::Stage;
use piezoid_numerics::options::Options;
use serde_json::json;
use std::net::TcpListener;
use std::sync::Arc;

/// The amplifier of all tests.
const GAIN: f64 = 4.0;

/// The sensor of the plant `paper` [um/V].
const SENSOR: f64 = 200.0;

pub(super) fn simulation() -> Simulation {
    let model = Model::Scpi;
    Simulation { plant: "paper".into(), model, gain: GAIN, virtual_time: Some(0.02), ..Simulation::default() }
}

/// Ports of a generator and an oscilloscope.
fn served(simulation: &Simulation) -> (u16, u16) {
    let [first, second] = [0; 2].map(|_| TcpListener::bind("127.0.0.1:0").unwrap());
    let [port, other] = [&first, &second].map(|listener| listener.local_addr().unwrap().port());
    let controller = Arc::new(simulation.controller().unwrap());
    let beside = controller.clone();
    std::thread::spawn(move || controller.serve(&first));
    std::thread::spawn(move || beside.serve_oscilloscope(&second));
    (port, other)
}

pub(super) fn at((port, oscilloscope): (u16, u16)) -> AcquireOptions {
    let connection = ConnectOptions { protocol: Protocol::Scpi, port, ..ConnectOptions::default() };
    let scpi = ScpiOptions {
        oscilloscope: Some(format!("127.0.0.1:{oscilloscope}")),
        monitor_channel: Some(1),
        monitor_gain: Some(10.0),
        sensitivity: Some(SENSOR),
        ..ScpiOptions::default()
    };
    let limits = LimitOptions::from_json(json!({"low": -30.0, "high": 30.0})).unwrap();
    let instrument =
        InstrumentOptions { connection, ramp: 0.1, gain: Some(GAIN), scpi, limits, ..InstrumentOptions::default() };
    AcquireOptions { instrument, settle: 0.0, ..AcquireOptions::default() }
}

/// The output, as the generator reports it [V at the actuator].
fn output(port: u16) -> f64 {
    GAIN * text(port, "VOLT:OFFS?\n").trim().parse::<f64>().unwrap()
}

#[test]
fn a_record_is_the_drive_and_what_the_plant_makes_of_it() {
    for virtual_time in [Some(0.02), None] {
        let ports = served(&Simulation { virtual_time, ..simulation() });
        let u = sine(400);
        let (outcome, text_now, _) = run(&at(ports), &drive(1e-3, &u), &mut Stage::ignore);
        let acquired = outcome.unwrap_or_else(|error| panic!("{error}"));
        let record = &acquired.record;
        assert!(acquired.notes.is_empty() && acquired.unfinished.is_none(), "{text_now}");
        assert_eq!((record.len(), record.ts(), &*record.units().u, &*record.units().y), (400, 1e-3, "V", "um"));
        // A code of the converter is 1.2 * 40 V / 4096.
        let error = u.iter().zip(record.u()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 0.02, "{error} V");
        assert_response_of_the_plant(record, &u);
        assert_eq!((acquired.voltage, acquired.servo), (Some(0.0), None));
        assert_eq!(text(ports.0, "FUNC?\nSYST:ERR?\n"), "DC\n+0,\"No error\"\n");
    }
}

#[test]
fn a_drive_without_a_monitor_or_joined_by_lines_is_recorded_too() {
    let ports = served(&simulation());
    let u: Vec<f64> = sine(400).into_iter().step_by(10).collect();
    let options = but(at(ports), |options| options.scpi.monitor_channel = None);
    let record = run(&options, &drive(0.01, &u), &mut Stage::ignore).0.unwrap().record;
    assert_eq!(record.u(), u);
    let joined = AcquireOptions { join: true, ..at(ports) };
    let record = run(&joined, &drive(0.01, &u), &mut Stage::ignore).0.unwrap().record;
    let error = u.iter().zip(record.u()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // A period of the wave, a sixteenth of 10 V/s * 0.01 s, and the mean about a corner.
    assert!(error < 0.7, "{error} V");
}

#[test]
fn the_axis_rests_where_it_is_to_and_begins_anywhere() {
    let ports = served(&simulation());
    text(ports.0, "VOLT:OFFS 1\n");
    for (rest, expected) in [(Rest::Start, 4.0), (Rest::Stay, 12.0), (Rest::Zero, 0.0)] {
        let options = but(at(ports), |options| options.rest = rest);
        let (outcome, text_now, _) = run(&options, &drive(0.01, &[0.0, 5.0, 10.0, 12.0]), &mut Stage::ignore);
        assert_eq!(outcome.unwrap().voltage, Some(expected), "{text_now}");
        assert_eq!(output(ports.0), expected);
    }
    // From the end of the range to the other end there is no room about the first voltage.
    let ports = served(&Simulation { gain: 3.0, ..simulation() });
    let u: Vec<f64> = (0..50).map(|k| 30.0 * libm::cos(0.05 * f64::from(k))).collect();
    let options = but(at(ports), |options| (options.gain, options.ramp) = (Some(3.0), 0.3));
    let record = run(&options, &drive(0.01, &u), &mut Stage::ignore).0.unwrap().record;
    let error = u.iter().zip(record.u()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(error < 0.03, "{error} V");
}

#[test]
fn an_output_that_is_off_is_switched_on_at_zero() {
    let ports = served(&simulation());
    text(ports.0, "OUTP OFF\nFUNC SIN\nVOLT 3\nVOLT:OFFS 2\n");
    let (outcome, text_now, _) = run(&at(ports), &drive(0.01, &sine(20)), &mut Stage::ignore);
    assert_eq!(outcome.unwrap().voltage, Some(0.0), "{text_now}");
    assert_eq!(text(ports.0, "OUTP?\nFUNC?\n"), "1\nDC\n");
}

#[test]
fn what_it_cannot_play_is_refused_before_anything_moves() {
    let ports = served(&simulation());
    let message = refused(&at(ports), &drive(1e-3, &[0.0, 31.0]));
    assert!(message.contains("the drive is 31.0000 V at 0.001000 s, outside -30 to 30 V"), "{message}");
    let message = refused(&at(ports), &drive(1e-3, &[-20.0, 20.0]));
    assert!(message.contains("the drive jumps by 40 V"), "{message}");
    // 100 thousand samples are three for each of a third of them.
    let message = refused(&at(ports), &drive(1e-4, &vec![0.0; 100_000]));
    assert!(message.contains("has 100000 samples, but the oscilloscope of the controller holds 33333"), "{message}");
    for (options, expected) in [
        (but(at(ports), |options| options.gain = None), "a generator does not know the amplifier: give `gain`"),
        (but(at(ports), |options| options.scpi.sensitivity = None), "does not know the sensor: give `sensitivity`"),
        (but(at(ports), |options| options.limits = LimitOptions::default()), "reports no limits of its voltage"),
        (but(at(ports), |options| options.scpi.sensor_channel = 1), "is that of the sensor"),
        (but(at(ports), |options| options.scpi.sensor_range = Some((1.0, 1.0))), "from the lowest to the highest"),
        (but(at(ports), |options| options.axis = Some("2".into())), "can only be 1 with SCPI"),
    ] {
        let message = refused(&options, &drive(1e-3, &sine(9)));
        assert!(message.contains(expected), "{message}");
    }
    assert_eq!(text(ports.0, "FUNC?\nVOLT:OFFS?\n"), "DC\n+0.000000000000E0\n");
}

#[test]
fn an_output_that_plays_or_is_not_what_it_says_is_left_alone() {
    for (lines, expected) in [
        ("FUNC SIN\n", "plays SIN"),
        ("FUNC ARB\n", "plays ARB"),
        ("OUTP:LOAD 50\n", "for a load of 50 Ohm"),
        ("OUTP:POL INV\n", "inverts its output"),
    ] {
        let ports = served(&simulation());
        text(ports.0, lines);
        let before = text(ports.0, "FUNC?\nVOLT?\nVOLT:OFFS?\nBURS:STAT?\n");
        let message = refused(&at(ports), &drive(1e-3, &sine(9)));
        assert!(message.contains(expected) && message.contains("nothing has moved"), "{message}");
        assert_eq!(text(ports.0, "FUNC?\nVOLT?\nVOLT:OFFS?\nBURS:STAT?\n"), before);
    }
}

#[test]
fn a_clipped_channel_and_a_missing_trigger_are_noticed() {
    let ports = served(&simulation());
    let options = but(at(ports), |options| options.scpi.sensor_range = Some((-0.1, 0.1)));
    let message = refused(&options, &drive(1e-3, &sine(400)));
    assert!(
        message.contains("channel 2 of the oscilloscope is at the") && message.contains("--sensor-range"),
        "{message}"
    );
    assert!(message.contains("axis 1 is at 0.000 V, in open loop"), "{message}");
    let options = but(at(ports), |options| options.scpi.monitor_gain = Some(20.0));
    let message = refused(&options, &drive(1e-3, &sine(400)));
    assert!(message.contains("channel 1") && message.contains("--monitor-gain"), "{message}");
    let options = but(at(ports), |options| options.gain = Some(2.0));
    let (outcome, notes, _) =
        run(&options, &drive(0.01, &sine(20).iter().map(|u| 0.4 * u).collect::<Vec<_>>()), &mut Stage::ignore);
    assert!(outcome.is_err() || notes.contains("differs from the drive"), "{notes}");
}

#[test]
fn what_speaks_no_scpi_is_named() {
    let nv200 = Simulation { model: Model::Nv200, gain: 1.0, ..simulation() };
    let ports = served(&nv200);
    let message = refused(&but(at(ports), |options| options.connection.timeout = 0.5), &drive(1e-3, &sine(9)));
    assert!(message.contains("check that it speaks SCPI"), "{message}");
}
