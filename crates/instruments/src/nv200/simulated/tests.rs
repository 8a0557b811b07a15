//! The controller without its line, with a virtual clock: each answer takes 0.01 s.

use crate::simulated::{Model, Simulated, Simulation, locked};
use piezoid::plant::PLANTS;

fn simulation() -> Simulation {
    Simulation { plant: "paper".into(), model: Model::Nv200, virtual_time: Some(0.01), ..Simulation::default() }
}

fn device() -> Simulated {
    simulation().controller().unwrap()
}

/// The texts of the answers to lines, without those that are empty.
fn ask(device: &Simulated, lines: &str) -> String {
    let mut device = locked(&*device.device);
    let answers: Vec<String> = lines
        .split('\n')
        .map(|line| {
            let bytes = device.answer(line);
            assert!(bytes.starts_with(b"\x13") && bytes.ends_with(b"\x11"), "{line}");
            let text: String = bytes[1..bytes.len() - 1].iter().copied().map(char::from).collect();
            assert!(text.is_empty() || text.ends_with("\r\n"), "{line}");
            text.trim_end().to_string()
        })
        .filter(|text| !text.is_empty())
        .collect();
    answers.join("\n")
}

fn numbers(answer: &str) -> Vec<f64> {
    answer.split(',').skip(1).map(|word| word.parse().unwrap()).collect()
}

fn number(device: &Simulated, query: &str) -> f64 {
    *numbers(&ask(device, query)).last().unwrap()
}

fn wait(device: &Simulated, time: f64) {
    (0..(100.0 * time).round() as usize).for_each(|_| drop(ask(device, "temp")));
}

#[test]
fn every_plant_goes_to_its_limits_in_both_loops() {
    for preset in PLANTS {
        let device = Simulation { plant: preset.name.into(), ..simulation() }.controller().unwrap();
        assert_eq!(ask(&device, "\ncl\nmodsrc\nset\nunitol"), "NV200/D_NET>\ncl,0\nmodsrc,0\nset,0.000\nunitol,V");
        for limit in ["avmax", "avmin"] {
            let volts = number(&device, limit);
            assert_eq!(ask(&device, &format!("set,{volts}\nset")), format!("set,{volts:.3}"), "{}", preset.name);
            ask(&device, "recsrc,0,2\nrecast,0\nreclen,1\nrecrun,1");
            assert_eq!(number(&device, "recout,0,0,1"), volts, "{}", preset.name);
        }
        assert_eq!(ask(&device, "set,0\ncl,1\ncl"), "cl,1");
        let travel = number(&device, "posmax") - number(&device, "posmin");
        for limit in ["posmax", "posmin"] {
            let place = number(&device, limit);
            assert_eq!(ask(&device, &format!("set,{place}")), "", "{}", preset.name);
            wait(&device, 3.0);
            let error = (number(&device, "meas") - place).abs();
            assert!(error < 2e-2 * travel, "{}: {error} of {travel} um at {limit}", preset.name);
        }
    }
}

#[test]
fn a_wave_is_played_and_recorded_with_the_clock_and_its_last_value_stays() {
    let device = device();
    let (low, high) = (number(&device, "avmin"), number(&device, "avmax"));
    let shares: Vec<f64> = (0..100).map(|k| 50.0 + 25.0 * libm::sin(0.1 * f64::from(k))).collect();
    let buffer: Vec<String> = shares.iter().enumerate().map(|(k, share)| format!("gbarb,{k},{share:.3}")).collect();
    ask(&device, &buffer.join("\n"));
    assert_eq!(ask(&device, "gbarb,3"), format!("gbarb,3,{:.3}", shares[3]));
    ask(&device, "goarb,0\ngsarb,0\ngearb,99\ngcarb,1\ngtarb,20");
    ask(&device, "recsrc,0,0\nrecsrc,1,2\nrecstr,20\nreclen,100\nrecast,2\nrecrun,1");
    assert_eq!(ask(&device, "modsrc,3\nrecrun\nrecidx\ngrun,1\ngrun\nrecrun"), "recrun,1\nrecidx,0\ngrun,1\nrecrun,1");
    wait(&device, 0.12);
    assert_eq!(ask(&device, "grun\nrecrun\ngiarb"), "grun,0\nrecrun,0\ngiarb,99");
    let (voltage, position) = (numbers(&ask(&device, "recoutf,1")), numbers(&ask(&device, "recoutf,0")));
    assert_eq!((voltage.len(), position.len(), voltage[0]), (101, 101, 1.0));
    for (volts, share) in voltage[1..].iter().zip(&shares) {
        assert!((volts - (low + 0.01 * share * (high - low))).abs() < 2e-3, "{volts} V");
    }
    assert!(position[1..].iter().fold(0.0, |most: f64, y| most.max(y.abs())) > 1.0);
    assert_eq!(
        ask(&device, "recout,1,2,3"),
        format!("recout,1,2,{:.3},{:.3},{:.3}", voltage[3], voltage[4], voltage[5])
    );
    // Without another source, `set` is kept and moves nothing.
    ask(&device, "set,0\nrecast,0\nreclen,1\nrecrun,1");
    assert!((number(&device, "recout,1,0,1") - voltage[100]).abs() < 1e-9);
    ask(&device, "modsrc,0\nrecrun,1");
    assert_eq!(number(&device, "recout,1,0,1"), 0.0);
}

#[test]
fn a_wave_that_is_stopped_leaves_its_voltage_and_the_slew_rate_limits_every_setpoint() {
    let device = device();
    ask(&device, &(0..100).map(|k| format!("gbarb,{k},{k}")).collect::<Vec<_>>().join("\n"));
    ask(&device, "set,-30\ngearb,99\ngtarb,200\nrecsrc,0,2\nreclen,1\ngcarb,1\nmodsrc,3\ngrun,1");
    wait(&device, 0.3);
    let index = number(&device, "grun,0\ngiarb");
    assert!((25.0..40.0).contains(&index), "{index}");
    wait(&device, 0.5);
    ask(&device, "recrun,1");
    assert!((number(&device, "recout,0,0,1") - (-30.0 + 0.6 * index)).abs() < 1e-9);

    // 0.1 %/ms of 60 V: 60 V/s.
    ask(&device, "modsrc,0\nset,-30\nsr,0.1\nrecast,1\nrecstr,200\nreclen,50\nset,0");
    wait(&device, 0.6);
    let voltage = numbers(&ask(&device, "recoutf,0"));
    assert!((voltage[1] + 30.0).abs() < 0.01 && (voltage[26] - -15.0).abs() < 0.1 && voltage[50] > -0.7, "{voltage:?}");
}

#[test]
fn the_loop_is_switched_without_a_move() {
    let device = device();
    ask(&device, "set,12\nrecsrc,0,2\nreclen,1");
    wait(&device, 1.0);
    let before = number(&device, "meas");
    assert!((number(&device, "cl,1\nset") - before).abs() < 2.0);
    wait(&device, 0.3);
    assert!((number(&device, "recrun,1\nrecout,0,0,1") - 12.0).abs() < 0.5);
    let volts = number(&device, "cl,0\nset");
    assert!((volts - 12.0).abs() < 0.5 && (number(&device, "recrun,1\nrecout,0,0,1") - volts).abs() < 1e-3);
    assert_eq!(ask(&device, "stat\ncl,1\nstat"), "stat,3\nstat,11");
}

#[test]
fn what_is_wrong_has_its_error_and_changes_nothing() {
    let device = device();
    for (line, code) in [
        ("nonsense", 2),
        ("nonsense,1", 2),
        ("iwc,1,1,1", 2),
        ("set,31", 4),
        ("set,-31", 4),
        ("set,x", 4),
        ("set,nan", 4),
        ("set,inf", 4),
        ("set,1,2", 5),
        ("meas,1", 6),
        ("avmax,200", 6),
        ("cl,2", 4),
        ("cl,0.5", 4),
        ("modsrc,4", 4),
        ("gbarb", 3),
        ("gbarb,1024", 4),
        ("gbarb,0,100.1", 4),
        ("gbarb,0,1,2", 5),
        ("gtarb,0", 4),
        ("gearb,1024", 4),
        ("reclen,6145", 4),
        ("recsrc,2,0", 4),
        ("recsrc,0,8", 4),
        ("recout,0", 3),
        ("recout,0,6143,2", 4),
        ("recoutf", 3),
        ("recoutf,2", 4),
        ("sr,0", 4),
        ("pcf,1", 3),
        ("pcf,1,2,3,4", 5),
        ("kp,-1", 4),
    ] {
        assert_eq!(ask(&device, line), format!("error,{code}"), "{line}");
    }
    assert_eq!(ask(&device, "set\ncl\nmodsrc\ngbarb,0\ngtarb"), "set,0.000\ncl,0\nmodsrc,0\ngbarb,0,0.000\ngtarb,1");
    // An offset after the end cannot be played.
    assert_eq!(ask(&device, "gearb,5\ngoarb,6\ngrun,1\ngrun"), "error,4\ngrun,0");
    let other = Simulation { axes: 2, ..simulation() }.controller().unwrap_err().to_string();
    assert!(other.contains("axes") && other.contains("NV200/D_NET"), "{other}");
    assert!(Simulation { gain: 2.0, ..simulation() }.controller().is_err());
}

#[test]
fn no_line_makes_it_panic_and_the_voltage_stays_within_its_limits() {
    let device = device();
    let names: Vec<&str> = super::list::COMMANDS.split(',').collect();
    let words = ["0", "1", "2", "3", "1023", "1024", "65535", "65536", "-1", "1e300", "nan", "", "x", "99.9", "5.0"];
    let mut state = 1_u64;
    let mut random = |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    for _ in 0..20_000 {
        let name = names[random(names.len())];
        let line = (0..random(5)).fold(name.to_string(), |line, _| line + "," + words[random(words.len())]);
        ask(&device, &line);
    }
    ask(&device, "recsrc,0,2\nrecast,0\nrecstr,1\nreclen,10\nrecrun,1");
    wait(&device, 0.1);
    let volts = numbers(&ask(&device, "recoutf,0"));
    assert!(volts[1..].iter().all(|volts| volts.abs() <= 30.0), "{volts:?}");
}
