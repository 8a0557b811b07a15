//! The client against the simulated controller, over TCP.

use crate::faulty::assert_response_of_the_plant;
use crate::measuring::{self, drive, refused, served, sine, text};
use crate::{AcquireOptions, Acquired, ConnectOptions, InstrumentOptions, Model, Rest, Simulation};
use piezoid::Error;
use piezoid::excitation::LimitOptions;
use piezoid::formats::ColumnSelection;
use piezoid::progress::{Progress, Stage};
use piezoid_numerics::options::Options;
use piezoid_verbs::DataFile;
use serde_json::json;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::ops::ControlFlow;

/// A simulated controller on a port of its own. Each answer takes a virtual time of 0.05 s.
pub(crate) fn simulated(simulation: &Simulation) -> u16 {
    served(&Simulation { virtual_time: Some(0.05), ..simulation.clone() })
}

/// Lets an axis come to rest: the answers take 2 s.
pub(crate) fn at_rest(lines: &str) -> String {
    format!("{lines}{}", "ONT?\n".repeat(40))
}

/// A server that answers every client with these bytes and no more.
fn strange(answer: &'static [u8]) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for mut client in listener.incoming().flatten() {
            client.write_all(answer).unwrap();
            drop(client.read(&mut [0; 64]));
        }
    });
    port
}

fn controller(port: u16) -> InstrumentOptions {
    let connection = ConnectOptions { port, ..ConnectOptions::default() };
    InstrumentOptions { connection, ramp: 0.1, ..InstrumentOptions::default() }
}

fn on(instrument: InstrumentOptions) -> AcquireOptions {
    AcquireOptions { instrument, settle: 0.0, ..AcquireOptions::default() }
}

fn at(port: u16) -> AcquireOptions {
    on(controller(port))
}

fn limits(values: serde_json::Value) -> LimitOptions {
    LimitOptions::from_json(values).unwrap()
}

fn run(options: &AcquireOptions, drive: &DataFile, progress: &mut Progress) -> Result<Acquired, Error> {
    measuring::run(options, drive, progress).0
}

#[test]
fn a_record_is_the_drive_and_what_the_plant_makes_of_it() {
    let port = simulated(&Simulation { plant: "paper".into(), ..Simulation::default() });
    let u = sine(400);
    let acquired = run(&at(port), &drive(1e-3, &u), &mut Stage::ignore).unwrap();
    let record = &acquired.record;
    assert!(acquired.notes.is_empty(), "{:?}", acquired.notes);
    assert_eq!((record.len(), record.ts(), &*record.units().u, &*record.units().y), (400, 1e-3, "V", "um"));
    assert!(u.iter().zip(record.u()).all(|(requested, had)| (requested - had).abs() < 1e-5));
    // The same drive on the plant alone, held for twenty servo cycles a sample. Its past differs by the check of the
    // gain, which hysteresis remembers.
    assert_response_of_the_plant(record, &u);
}

#[test]
fn every_model_is_measured_with_the_clock_and_without() {
    for model in [Model::E727, Model::E754, Model::E709, Model::OpenLoop] {
        for virtual_time in [None, Some(0.05)] {
            let port =
                served(&Simulation { model, axes: 2, virtual_time, plant: "paper".into(), ..Simulation::default() });
            let second = on(InstrumentOptions { axis: Some("2".into()), ..controller(port) });
            let u = sine(100);
            let acquired = run(&second, &drive(1e-3, &u), &mut Stage::ignore).unwrap();
            assert_eq!((acquired.unfinished, &*acquired.axis), (None, "2"), "{model:?}");
            assert!(u.iter().zip(acquired.record.u()).all(|(requested, had)| (requested - had).abs() < 1e-5));
            assert!(acquired.record.y().iter().any(|y| y.abs() > 100.0), "{model:?}");
            assert!(text(port, "VOL? 1\n").starts_with("1=0.000000"), "{model:?}");
        }
    }
}

#[test]
fn a_controller_tells_its_axis_limits_and_tables() {
    let port = simulated(&Simulation::default());
    let connect = ConnectOptions { port, ..ConnectOptions::default() };
    let controller = connect.connect(&mut Stage::ignore).unwrap();
    let axis = &controller.axes[0];
    assert_eq!((controller.axes.len(), &*axis.name, &*axis.unit, axis.servo), (1, "1", "um", Some(false)));
    assert_eq!((axis.range, controller.cycle), (Some((-30.0, 30.0)), Some(5e-5)));
    assert_eq!((controller.table, controller.recorder), (Some(262_144), Some(32_768)));
}

#[test]
fn a_gain_that_is_not_that_of_the_controller_is_refused_before_the_drive() {
    let port = simulated(&Simulation { gain: 2.5, ..Simulation::default() });
    let message = refused(&at(port), &drive(1e-3, &sine(100)));
    let expected = "gain = 1: the controller gives about 2.5000 V for an open-loop value of 1: give this gain; axis 1";
    assert!(message.starts_with(expected), "{message}");
    assert!(text(port, "VOL?\n").starts_with("1=0.000000"), "the axis is back where it was");
    let with = on(InstrumentOptions { gain: Some(2.5), ..controller(port) });
    let record = run(&with, &drive(1e-3, &sine(100)), &mut Stage::ignore).unwrap().record;
    assert!(sine(100).iter().zip(record.u()).all(|(requested, had)| (requested - had).abs() < 1e-5));
    // A gain that is far too small would make the first move a large one: it is seen in its first step.
    let far = on(InstrumentOptions { gain: Some(0.1), ..controller(port) });
    let message = refused(&far, &drive(1e-3, &sine(100)));
    assert!(message.contains("the controller gives about 2.5"), "{message}");
}

#[test]
fn an_offset_of_the_generator_and_other_programs_settings_do_not_move_the_drive() {
    let port = simulated(&Simulation::default());
    text(port, "WOS 1 20\nWGC 1 7\nRTR 3\n");
    let u = sine(50);
    let record = run(&at(port), &drive(1e-3, &u), &mut Stage::ignore).unwrap().record;
    assert!(u.iter().zip(record.u()).all(|(requested, had)| (requested - had).abs() < 1e-5));
}

#[test]
fn a_generator_that_runs_already_is_left_alone() {
    let port = simulated(&Simulation::default());
    text(port, "WAV 1 X PNT 1 2 0 1\nWSL 1 1\nWTR 1 100 0\nWGC 1 0\nWGO 1 1\n");
    assert!(refused(&at(port), &drive(1e-3, &sine(50))).contains("wave generator 1 runs already"));
    assert_eq!(text(port, "\x09"), "0x1\n");
}

#[test]
fn an_output_that_does_not_follow_its_axis_is_told() {
    let gain = Simulation { gain: 1e-3, ..Simulation::default() };
    let message = refused(&at(simulated(&gain)), &drive(1e-3, &sine(50)));
    assert!(message.contains("output channel 1 does not follow axis 1"), "{message}");
}

#[test]
fn drives_that_a_controller_cannot_play_are_refused_with_what_to_do() {
    let port = simulated(&Simulation::default());
    for (options, ts, u, message) in [
        (at(port), 1e-3, vec![0.0, 31.0], "the drive is 31.0000 V at 0.001000 s, outside -30 to 30 V: make it smaller"),
        (
            on(InstrumentOptions { limits: limits(json!({"low": 0, "high": 5})), ..controller(port) }),
            1e-3,
            vec![0.0, -1.0],
            "outside 0 to 5 V",
        ),
        (at(port), 3.3e-4, vec![0.0, 1.0], "servo cycle of 0.00005 s: sample the drive every 0.00035 s"),
        (at(port), 1e-3, vec![0.0; 40_000], "a table of the recorder of the controller holds 32768: make it 32.768 s"),
        (
            on(InstrumentOptions { axis: Some("X".into()), ..controller(port) }),
            1e-3,
            vec![0.0, 1.0],
            "no axis called `X`: known are 1",
        ),
    ] {
        let error = refused(&options, &drive(ts, &u));
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn a_measurement_that_is_cancelled_stops_the_generator() {
    let port = simulated(&Simulation::default());
    let mut stop =
        |stage: Stage| if stage.what.contains("played") { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let error = run(&at(port), &drive(1e-3, &sine(20_000)), &mut stop).unwrap_err();
    assert!(matches!(error, Error::Cancelled { .. }), "{error}");
    assert_eq!(text(port, "\x09"), "0x0\n");
}

#[test]
fn the_servo_is_opened_and_that_is_told() {
    let port = simulated(&Simulation::default());
    text(port, &at_rest("SVO 1 1\nMOV 1 100\n"));
    let stay = on(InstrumentOptions { rest: Rest::Stay, ..controller(port) });
    let acquired = run(&stay, &drive(1e-3, &sine(50)), &mut Stage::ignore).unwrap();
    assert_eq!(
        (&*acquired.notes, acquired.servo),
        (&["the servo of axis 1 was on; it is off now".into()][..], Some(false))
    );
    assert!(text(port, "SVO?\n").starts_with("1=0"));
}

#[test]
fn the_loop_is_closed_again_where_the_axis_was() {
    let port = simulated(&Simulation::default());
    text(port, &at_rest("SVO 1 1\nMOV 1 100\n"));
    let before = text(port, "VOL?\n");
    let acquired = run(&at(port), &drive(1e-3, &sine(50)), &mut Stage::ignore).unwrap();
    assert_eq!(
        (&*acquired.notes, acquired.unfinished),
        (&["the servo of axis 1 was on; it is on again".into()][..], None)
    );
    let voltage = |text: &str| text.trim().strip_prefix("1=").unwrap().parse::<f64>().unwrap();
    assert!((voltage(&text(port, "VOL?\n")) - voltage(&before)).abs() < 3.0);
    assert!(text(port, "SVO?\n").starts_with("1=1"));
}

#[test]
fn a_refused_drive_leaves_the_servo_on() {
    let port = simulated(&Simulation::default());
    text(port, &at_rest("SVO 1 1\nMOV 1 600\n"));
    let narrow = on(InstrumentOptions { limits: limits(json!({"low": -5, "high": 5})), ..controller(port) });
    let message = refused(&narrow, &drive(1e-3, &[0.0, 1.0]));
    assert!(message.contains("outside -5 to 5 V: move it there first"), "{message}");
    assert!(text(port, "SVO?\n").starts_with("1=1"));
}

#[test]
fn the_axis_rests_where_it_is_to() {
    let mut u = sine(100);
    u.extend([-10.0, 0.0, 12.5]);
    for (rest, expected) in [(Rest::Start, 4.0), (Rest::Zero, 0.0), (Rest::Stay, 12.5)] {
        let port = simulated(&Simulation::default());
        text(port, "SVA 1 4\n");
        let acquired =
            run(&on(InstrumentOptions { rest, ..controller(port) }), &drive(1e-3, &u), &mut Stage::ignore).unwrap();
        assert_eq!((acquired.voltage, acquired.servo, acquired.unfinished), (Some(expected), Some(false), None));
        assert_eq!(text(port, "VOL?\n").trim(), format!("1={expected:.6}"));
    }
}

#[test]
fn a_record_that_cannot_be_kept_is_an_error_after_the_move_to_the_rest() {
    let port = simulated(&Simulation::default());
    let mut notes = Vec::new();
    let mut keep = |_: &Acquired| Err(Error::Content("the disk is full".into()));
    let rest = on(InstrumentOptions { rest: Rest::Zero, ..controller(port) });
    text(port, "SVA 1 4\n");
    let columns = ColumnSelection::default();
    let outcome = rest.run(&drive(1e-3, &sine(50)), &columns, &mut notes, &mut keep, &mut Stage::ignore);
    assert_eq!(outcome.unwrap_err().to_string(), "the disk is full");
    assert_eq!(notes, ["axis 1 is at 0.000 V, in open loop"]);
    assert!(text(port, "VOL?\n").starts_with("1=0.000000"));
}

#[test]
fn limits_of_slew_and_current_are_checked_before_anything_moves() {
    let port = simulated(&Simulation::default());
    let square: Vec<f64> = (0..100).map(|k| if k < 50 { 0.0 } else { 29.0 }).collect();
    let saw: Vec<f64> = (0..100).map(|k| if k < 50 { -16.0 } else { 16.0 }).collect();
    for (values, u, expected) in [
        (json!({"slew": 1000}), &square, "slew 29000 V/s at 0.05 s, limit 1000 V/s; make it slower or smaller"),
        (json!({"driver": "pl140", "current": 0.1}), &square, "current 0.2378 A at 0.05 s, limit 0.1 A"),
        (json!({}), &saw, "jumps by 32 V at 0.05 s, over half of -30 to 30 V: to check it, give `driver` or `slew`"),
    ] {
        let message = refused(&on(InstrumentOptions { limits: limits(values), ..controller(port) }), &drive(1e-3, u));
        assert!(message.contains(expected), "{message}");
    }
    assert!(text(port, "VOL?\n").starts_with("1=0.000000"));
    let allowed = on(InstrumentOptions { limits: limits(json!({"slew": 4e4})), ..controller(port) });
    run(&allowed, &drive(1e-3, &saw), &mut Stage::ignore).unwrap();
}

#[test]
fn a_controller_that_another_program_uses_is_left_alone() {
    for (before, expected) in [
        ("FLY\n", "the controller is in use: error 2 of another program was pending (it does not know this command)"),
        ("WAV 1 X PNT 1 2 0 1\nWSL 1 1\nWTR 1 100 0\nWGC 1 0\nWGO 1 1\n", "wave generator 1 runs already"),
    ] {
        let port = simulated(&Simulation::default());
        text(port, before);
        let message = refused(&at(port), &drive(1e-3, &sine(50)));
        assert!(message.contains(expected) && message.contains("nothing has moved"), "{message}");
    }
    // One that takes connections, and answers another program.
    let other = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = other.local_addr().unwrap().port();
    let connection = ConnectOptions { port, timeout: 0.5, ..ConnectOptions::default() };
    let message = refused(&on(InstrumentOptions { connection, ..controller(port) }), &drive(1e-3, &sine(50)));
    assert!(message.contains("no whole answer within 0.5 s") && message.contains("one program at a time"), "{message}");
    drop(other);
    // One that says so.
    let port = simulated(&Simulation { model: Model::E709, ..Simulation::default() });
    let mut other = TcpStream::connect(("127.0.0.1", port)).unwrap();
    other.write_all(b"CSV?\n").unwrap();
    assert_eq!(other.read(&mut [0; 64]).unwrap(), 4);
    let message = refused(&at(port), &drive(1e-3, &sine(50)));
    assert!(message.contains("serves 1 at a time"), "{message}");
}

#[test]
fn the_servo_moves_to_its_target() {
    let port = simulated(&Simulation { plant: "paper".into(), ..Simulation::default() });
    text(port, &at_rest("SVO 1 1\nMOV 1 500\n"));
    let message = text(port, "POS? 1\nONT?\nMOV 1 5000\nERR?\nSVA 1 3\nERR?\n");
    let lines: Vec<&str> = message.lines().collect();
    let position: f64 = lines[0].strip_prefix("1=").unwrap().parse().unwrap();
    assert!((position - 500.0).abs() < 5.0, "{position}");
    assert_eq!(lines[1..], ["1=1", "7", "79"]);
}

#[test]
fn commands_that_are_wrong_have_the_errors_of_gcs() {
    let port = simulated(&Simulation::default());
    for (command, code) in [
        ("FLY 1", 2),
        ("FLY?", 2),
        ("POS? 2", 15),
        ("SVO 2 1", 15),
        ("SVA 1 x", 25),
        ("SVA 1 nan", 25),
        ("SVA 1", 24),
        ("SVA 1 99", 66),
        ("MOV 1 0", 5),
        ("SPA? 1 0x1", 54),
        ("DRC 9 1 2", 57),
        ("DRC 1 1 99", 58),
        ("WGO 1 1", 75),
        ("DRR? 1 5 1", 77),
        ("DRR? 0 5 1", 17),
        ("WAV 1 X PNT 1 2 5", 24),
        ("WAV 1 Y PNT 1 1 5", 1),
        ("WAV 1 X SIN_P 99999999 1 0 10 0 5", 67),
        ("WTR 1 0 0", 17),
        ("STP", 10),
    ] {
        assert_eq!(text(port, &format!("{command}\nERR?\nERR?\n")), format!("{code}\n0\n"), "{command}");
    }
}

#[test]
fn what_is_no_controller_is_told() {
    let quick = |port| {
        let connection = ConnectOptions { port, timeout: 0.3, ..ConnectOptions::default() };
        connection.connect(&mut Stage::ignore).unwrap_err().to_string()
    };
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    assert!(quick(closed).contains("no controller answers at 127.0.0.1"), "{}", quick(closed));
    assert!(quick(strange(b"HTTP/1.1 400 Bad Request\r\n")).contains("check that it speaks GCS 2.0"));
    assert!(quick(strange(b"")).contains("does not answer"));
    let nowhere = ConnectOptions { host: "no.such.host.invalid".into(), ..ConnectOptions::default() };
    assert!(
        nowhere
            .connect(&mut Stage::ignore)
            .unwrap_err()
            .to_string()
            .contains("no controller answers at no.such.host.invalid:50000")
    );
}

#[test]
fn what_the_actuator_does_is_reported_while_it_moves_waits_and_plays() {
    let options = but_settled(at(served(&Simulation::default())));
    let mut moments: Vec<(String, f64, f64, f64)> = Vec::new();
    let acquired = run(&options, &drive(0.01, &sine(100)), &mut |stage: Stage| {
        let figure = |name: &str| stage.figures.iter().find(|(one, _)| *one == name).map(|(_, value)| *value);
        if let (Some(t), Some(u), Some(y)) = (figure("t_s"), figure("u_V"), figure("y_um")) {
            moments.push((stage.what.into(), t, u, y));
        }
        ControlFlow::Continue(())
    });
    let record = acquired.unwrap().record;
    for what in ["slow move", "settling [ms]", "the drive is played [ms]"] {
        assert!(moments.iter().any(|(stage, ..)| stage == what), "{what}: {moments:?}");
    }
    // About twelve a second, each once.
    assert!(moments.windows(2).all(|two| two[1].1 > two[0].1 + 0.02), "{moments:?}");
    let played: Vec<_> = moments.iter().filter(|(stage, ..)| stage.starts_with("the drive")).collect();
    assert!(played.len() <= 13, "{} in a second", played.len());
    // What they say is what is recorded: near every moment the record has its voltage with its displacement.
    let near =
        |u: f64, y: f64| record.u().iter().zip(record.y()).any(|(v, x)| (u - v).abs() < 1.1 && (y - x).abs() < 40.0);
    assert!(played.iter().all(|(_, _, u, y)| near(*u, *y)), "{played:?}");
}

fn but_settled(options: AcquireOptions) -> AcquireOptions {
    let instrument = InstrumentOptions { ramp: 0.3, ..options.instrument };
    AcquireOptions { settle: 0.3, instrument, ..options }
}

#[test]
fn an_error_that_comes_while_the_actuator_is_observed_is_not_lost() {
    let port = served(&Simulation::default());
    let mut is_disturbed = false;
    let error = run(&at(port), &drive(0.01, &sine(200)), &mut |stage: Stage| {
        if stage.what.starts_with("the drive is played") && stage.done > 300 && !is_disturbed {
            is_disturbed = true;
            text(port, "FLY 1\n");
        }
        ControlFlow::Continue(())
    });
    let message = error.unwrap_err().to_string();
    assert!(message.contains("refuses `VOL? 1") && message.contains("generator 1 is stopped"), "{message}");
}
