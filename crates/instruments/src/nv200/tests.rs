//! The client against the simulated controller, over TCP.

use crate::faulty::assert_response_of_the_plant;
use crate::measuring::{self, but, drive, refused, run, served, sine};
use crate::{AcquireOptions, ConnectOptions, InstrumentOptions, Model, Protocol, Rest, Simulation};
use piezoid::excitation::LimitOptions;
use piezoid::progress::Stage;
use piezoid_numerics::options::Options;
use serde_json::json;
use std::io::{Read, Write};
use std::net::TcpListener;

pub(super) fn simulation() -> Simulation {
    Simulation { plant: "paper".into(), model: Model::Nv200, virtual_time: Some(0.02), ..Simulation::default() }
}

pub(super) fn at(port: u16) -> AcquireOptions {
    let connection = ConnectOptions { protocol: Protocol::Nv200, port, ..ConnectOptions::default() };
    let instrument = InstrumentOptions { connection, ramp: 0.1, ..InstrumentOptions::default() };
    AcquireOptions { instrument, settle: 0.0, ..AcquireOptions::default() }
}

/// The answers of a controller to lines, without XON and XOFF.
fn text(port: u16, lines: &str) -> String {
    measuring::text(port, lines).chars().filter(|c| *c == '\n' || !c.is_control()).collect()
}

#[test]
fn a_record_is_the_drive_and_what_the_plant_makes_of_it() {
    for virtual_time in [Some(0.02), None] {
        let port = served(&Simulation { virtual_time, ..simulation() });
        let u = sine(400);
        let (outcome, text, _) = run(&at(port), &drive(1e-3, &u), &mut Stage::ignore);
        let acquired = outcome.unwrap();
        let record = &acquired.record;
        assert!(acquired.notes.is_empty() && acquired.unfinished.is_none(), "{text}");
        assert_eq!((record.len(), record.ts(), &*record.units().u, &*record.units().y), (400, 1e-3, "V", "um"));
        // The generator counts in 0.00001 % of 60 V, the recorder in mV.
        assert!(u.iter().zip(record.u()).all(|(requested, had)| (requested - had).abs() < 6e-4));
        assert_response_of_the_plant(record, &u);
        assert_eq!((acquired.voltage, acquired.servo), (Some(0.0), Some(false)));
    }
}

#[test]
fn the_axis_rests_where_it_is_to() {
    let port = served(&simulation());
    text(port, "set,4\r\n");
    for (rest, expected) in [(Rest::Start, 4.0), (Rest::Stay, 12.0), (Rest::Zero, 0.0)] {
        let options = but(at(port), |options| options.rest = rest);
        let (outcome, text_now, _) = run(&options, &drive(0.01, &[0.0, 5.0, 10.0, 12.0]), &mut Stage::ignore);
        assert_eq!(outcome.unwrap().voltage, Some(expected), "{text_now}");
        assert_eq!(text(port, "set\r\nmodsrc\r\ngrun\r\n"), format!("set,{expected:.3}\nmodsrc,0\ngrun,0\n"));
    }
}

#[test]
fn a_controller_reports_its_limits_and_its_memory_and_nothing_changes() {
    let port = served(&simulation());
    let controller = at(port).instrument.connection.connect(&mut Stage::ignore).unwrap();
    let axis = &controller.axes[0];
    assert_eq!(controller.identity, "NV200/D_NET, PAPER #000001");
    assert_eq!((&*axis.unit, axis.servo, axis.range), ("um", Some(false), Some((-30.0, 30.0))));
    assert_eq!((controller.cycle, controller.table, controller.recorder), (Some(5e-5), Some(1024), Some(6144)));
    assert_eq!(controller.in_use(), None);
    assert_eq!(text(port, "recrun\r\nrecidx\r\nset\r\n"), "recrun,0\nrecidx,0\nset,0.000\n");
}

#[test]
fn drives_that_it_cannot_play_are_refused_before_anything_moves() {
    let port = served(&simulation());
    for (ts, n, expected) in [
        (1e-3, 1025, "the drive has 1025 samples, but the generator of the controller holds 1024: make it 1.024 s"),
        (7e-5, 100, "plays multiples of its servo cycle of 0.00005 s"),
        (3.3, 3, "the drive is sampled every 3.3 s, more than 3.27675 s"),
    ] {
        let message = refused(&at(port), &drive(ts, &sine(n)));
        assert!(message.contains(expected), "{message}");
    }
    let message = refused(&at(port), &drive(1e-3, &[0.0, 31.0]));
    assert!(message.contains("the drive is 31.0000 V at 0.001000 s, outside -30 to 30 V"), "{message}");
    let limits = LimitOptions::from_json(json!({"slew": 100.0})).unwrap();
    let message = refused(&but(at(port), |options| options.limits = limits), &drive(1e-3, &sine(100)));
    assert!(message.contains("the drive exceeds its limits"), "{message}");
    let message = refused(&AcquireOptions { join: true, ..at(port) }, &drive(1e-3, &sine(9)));
    assert!(message.contains("without --join"), "{message}");
    let message = refused(&at(port), &drive(1e-3, &[-20.0, 20.0]));
    assert!(message.contains("the drive jumps by 40 V"), "{message}");
    for (options, expected) in [
        (but(at(port), |options| options.axis = Some("2".into())), "axis"),
        (but(at(port), |options| options.gain = Some(2.0)), "gain"),
        (but(at(port), |options| options.channel = Some(2)), "channel"),
        (but(at(port), |options| options.cycle = Some(1e-4)), "cycle"),
    ] {
        let message = refused(&options, &drive(1e-3, &sine(9)));
        assert!(message.starts_with(expected) && message.contains("on an NV200"), "{message}");
    }
    assert_eq!(text(port, "set\r\ngbarb,1\r\nmodsrc\r\nrecidx\r\n"), "set,0.000\ngbarb,1,0.000\nmodsrc,0\nrecidx,0\n");
}

#[test]
fn a_controller_that_is_in_use_or_not_ready_is_left_alone() {
    for (lines, expected) in [
        ("gcarb,0\r\ngrun,1\r\n", "wave generator 1 runs already"),
        ("reclen,0\r\nrecrun,1\r\n", "its recorder runs"),
        ("cl,1\r\n", "the axis is in closed loop"),
        ("modsrc,1\r\n", "analogue input or SPI"),
        ("ctrlmode,1\r\n", "ILC"),
    ] {
        let port = served(&simulation());
        text(port, lines);
        let before = text(port, "cl\r\nmodsrc\r\ngrun\r\nrecrun\r\n");
        let message = refused(&at(port), &drive(1e-3, &sine(9)));
        assert!(message.contains(expected) && message.contains("nothing has moved"), "{message}");
        assert_eq!(text(port, "cl\r\nmodsrc\r\ngrun\r\nrecrun\r\n"), before);
    }
}

/// A measurement that was killed before its drive leaves the recorder so: nothing would ever end its wait.
#[test]
fn a_recorder_that_waits_for_a_generator_at_rest_is_stopped() {
    for (changed, is_refused) in [("", false), ("recsrc,1,1\r\n", true), ("recast,1\r\n", true)] {
        let port = served(&simulation());
        text(port, &format!("recsrc,0,2\r\nrecsrc,1,0\r\nrecast,2\r\n{changed}reclen,9\r\nrecrun,1\r\n"));
        let (outcome, ..) = run(&at(port), &drive(1e-3, &sine(9)), &mut Stage::ignore);
        let error = outcome.err().map(|error| error.to_string()).unwrap_or_default();
        assert_eq!(error.contains("its recorder runs; nothing has moved"), is_refused, "{error}");
        assert!(is_refused || error.is_empty(), "{error}");
    }
}

#[test]
fn a_slow_slew_rate_of_the_controller_is_noticed_before_the_drive() {
    let port = served(&Simulation { virtual_time: Some(1e-3), ..simulation() });
    text(port, "sr,0.00001\r\n");
    let message = refused(&at(port), &drive(1e-3, &sine(9).iter().map(|u| u + 15.0).collect::<Vec<_>>()));
    assert!(message.contains("not 15.000 V, after the move to the first voltage of the drive"), "{message}");
}

#[test]
fn what_is_no_nv200_is_named() {
    let gcs = served(&Simulation { model: Model::E727, ..simulation() });
    let quick = |port| but(at(port), |options| options.connection.timeout = 0.5);
    let message = refused(&quick(gcs), &drive(1e-3, &sine(9)));
    assert!(message.contains("there was no whole answer within 0.5 s"), "{message}");
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for mut client in listener.incoming().flatten() {
            client.write_all(b"login:\r\n").unwrap();
            drop(client.read(&mut [0; 64]));
        }
    });
    let message = refused(&quick(port), &drive(1e-3, &sine(9)));
    assert!(message.contains("answers \"login:\", which is not the name of an NV200"), "{message}");
}
