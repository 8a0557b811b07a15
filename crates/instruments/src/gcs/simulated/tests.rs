//! The controller without its line, with a virtual clock: each answer takes 0.01 s.

use crate::simulated::{Model, Simulated, Simulation, locked};
use piezoid::plant::PLANTS;

pub(super) fn device(simulation: Simulation) -> Simulated {
    Simulation { virtual_time: Some(0.01), ..simulation }.controller().unwrap()
}

/// The answers to lines, as a terminal shows them.
pub(super) fn ask(device: &Simulated, lines: &str) -> String {
    let mut device = locked(&*device.device);
    let answers = lines.split('\n').filter(|line| !line.is_empty()).map(|line| {
        let answer = match line.as_bytes() {
            [byte] if *byte < 32 => device.answer_byte(*byte),
            _ => device.answer(line),
        };
        String::from_utf8_lossy(&answer).trim().to_string()
    });
    answers.filter(|answer| !answer.is_empty()).collect::<Vec<_>>().join("\n").replace(" \n", "\n")
}

/// The number after the last equals sign.
pub(super) fn number(device: &Simulated, query: &str) -> f64 {
    let answer = ask(device, query);
    answer.rsplit('=').next().unwrap().parse().unwrap_or_else(|_| panic!("{query}: {answer}"))
}

/// Lets a time pass [s].
pub(super) fn wait(device: &Simulated, time: f64) {
    (0..(100.0 * time).round() as usize).for_each(|_| drop(ask(device, "CSV?")));
}

#[test]
fn every_plant_reaches_its_limits() {
    for preset in PLANTS {
        let device = device(Simulation { plant: preset.name.into(), ..Simulation::default() });
        ask(&device, "SVO 1 1");
        for query in ["TMX? 1", "TMN? 1", "TMX? 1"] {
            let limit = number(&device, query);
            ask(&device, &format!("MOV 1 {limit:.6}"));
            assert_eq!(ask(&device, "ERR?\nONT?"), "0\n1=0", "{}: {query}", preset.name);
            assert_eq!(ask(&device, "\x05"), "1");
            wait(&device, 3.0);
            let (position, state) = (number(&device, "POS? 1"), ask(&device, "ONT? 1\n\x05\nOVF? 1\nVOL?"));
            assert!(state.starts_with("1=1\n0\n1=0"), "{}: {query} {limit}: {position} {state}", preset.name);
        }
    }
}

/// A ramp of 0 to 20 V in 1 s.
const RAMP: &str = "WAV 1 X PNT 1 5 0 5 10 15 20\nWSL 1 1\nWGC 1 1\nWTR 1 5000 1\n";

#[test]
fn while_a_wave_runs_everything_is_that_of_the_moment_and_a_stop_leaves_it_there() {
    for (stop, error) in [("WGO 1 0", 0), ("STP", 10), ("\x18", 10), ("HLT 1", 10), ("SVO 1 1", 0)] {
        let device = device(Simulation::default());
        ask(&device, RAMP);
        assert_eq!(ask(&device, "WGO 1 1\n\x09\n\x05\nWGO?"), "0x1\n1\n1=1");
        // Three answers of 0.01 s; the last servo cycle is one before.
        for k in 4..50 {
            let (volts, demand) = (number(&device, "VOL? 1"), number(&device, "SVA? 1"));
            let expected = 20.0 * (0.01 * f64::from(2 * k - 4) - 5e-5);
            assert!((volts - expected).abs() < 1e-5 && demand > volts, "{k}: {volts} {expected}");
        }
        let before = number(&device, "VOL?");
        ask(&device, stop);
        assert_eq!(ask(&device, "ERR?\n\x09"), format!("{error}\n0x0"), "{stop}");
        wait(&device, 3.0);
        let drift = if stop == "SVO 1 1" { 1.0 } else { 0.0 };
        assert!((number(&device, "VOL?") - before).abs() <= drift, "{stop}");
        assert!((number(&device, "SVA?") - before).abs() <= drift, "{stop}");
    }
}

#[test]
fn between_commands_creep_goes_on() {
    let device = device(Simulation::default());
    ask(&device, "SVA 1 20");
    wait(&device, 1.0);
    let first = number(&device, "POS?");
    wait(&device, 20.0);
    let second = number(&device, "POS?");
    // The creep of the plant from 1 to 21 s.
    assert!(second > first * 1.005 && second < first * 1.05, "{first} {second}");
}

#[test]
fn a_long_time_at_rest_is_the_same_in_coarse_steps() {
    for (plant, commands) in [("pl140", "SVA 1 20"), ("p885", "SVA 1 50"), ("pl140", "SVO 1 1\nMOV 1 700")] {
        // Answers of 1.9 s are computed in fine steps, as long as others come in between.
        let [fine, coarse] = [0.01, 9.0].map(|time| {
            let simulation = Simulation { plant: plant.into(), virtual_time: Some(time), ..Simulation::default() };
            let device = simulation.controller().unwrap();
            ask(&device, commands);
            let mut times = 0.0;
            while times < 18.0 - 1e-9 {
                // Any command is a moment at which nothing is coarse.
                ask(&device, "RTR 1\nCSV?");
                times += time;
            }
            [number(&device, "POS?"), number(&device, "VOL?")]
        });
        let close = |a: f64, b: f64| (a - b).abs() < 2e-3 * a.abs() + 1.0;
        assert!(close(fine[0], coarse[0]) && (fine[1] - coarse[1]).abs() < 0.3, "{plant}: {fine:?} {coarse:?}");
    }
}

/// The test gives the commands itself: a client also asks, by the clock of the machine, what the actuator does, and
/// each answer lets time pass.
#[test]
fn the_same_commands_and_seed_give_the_same_record_and_another_seed_another() {
    let record = |seed: u64| {
        let device = device(Simulation { seed, ..Simulation::default() });
        ask(&device, &format!("{RAMP}DRC 1 1 16\nDRC 2 1 2\nRTR 100\nWGO 1 1\n"));
        wait(&device, 1.1);
        ask(&device, "DRR? 1 200 1 2")
    };
    let first = record(1);
    assert!(first.lines().count() > 200, "{first}");
    assert_eq!(first, record(1));
    assert_ne!(first, record(2));
}

#[test]
fn moves_take_time_and_the_velocity_is_kept() {
    let device = device(Simulation { plant: "paper".into(), ..Simulation::default() });
    ask(&device, "SVO 1 1\nVEL 1 200\nMOV 1 300\n");
    wait(&device, 1.0);
    let (position, state) = (number(&device, "POS?"), ask(&device, "ONT?\n\x05\nMOV?\nVEL?"));
    assert!((position - 200.0).abs() < 40.0, "{position}");
    assert_eq!(state, "1=0\n1\n1=300.000000\n1=200.000000");
    wait(&device, 2.0);
    assert_eq!(ask(&device, "ONT?\n\x05"), "1=1\n0");
    // The loop is opened where it is, and holds its voltage.
    let before = number(&device, "VOL?");
    ask(&device, "SVO 1 0");
    assert!((number(&device, "VOL?") - before).abs() < 0.05);
}

#[test]
fn long_and_many_commands_are_answered_at_once() {
    let device = device(Simulation { virtual_time: None, ..Simulation::default() });
    let begin = std::time::Instant::now();
    ask(&device, "WAV 1 X PNT 1 2 0 1\nWSL 1 1\nWTR 1 1000000 0\nRTR 200\nWGC 1 0\nWGO 1 1");
    assert_eq!(ask(&device, "\x09\nERR?"), "0x1\n0");
    ask(&device, "WGO 1 0\nWGC 1 12000000\nWTR 1 1 0\nWGO 1 1");
    assert_eq!(ask(&device, "\x09\nERR?\n\x18\n\x09"), "0x1\n0\n0x0");
    ask(&device, &format!("SVO 1 1\n{}", "MOV 1 100\nMOV 1 0\n".repeat(100)));
    assert!(begin.elapsed().as_secs_f64() < 5.0);
}

#[test]
fn the_recorder_fills_as_time_goes_from_its_trigger() {
    let device = device(Simulation { plant: "paper".into(), ..Simulation::default() });
    ask(&device, "SVO 1 1\nDRC 1 1 1 2 1 2\nRTR 10\nDRT 1 1 0\nDRT 2 1 0");
    assert_eq!(ask(&device, "DRT? 1\nDRT? 3\nDRL? 1\nDRR? 1 1 1\nERR?\nDRR?\nERR?"), "1=1 0\n3=0 0\n1=0\n77\n77");
    ask(&device, "MVR 1 200");
    let [first, second] = [0, 1].map(|_| number(&device, "DRL? 1"));
    assert_eq!((first, second), (20.0, 40.0));
    assert_eq!(locked(&*device.device).answer("DRR? 1 500 1"), b"\n", "they are awaited");
    assert_eq!(ask(&device, "ERR?"), "17");
    wait(&device, 2.0);
    let rows = ask(&device, "DRR? 1 4000 1 2");
    let rows: Vec<&str> = rows.lines().skip_while(|line| !line.contains("END_HEADER")).skip(1).collect();
    let targets: Vec<f64> = rows.iter().map(|row| row.split(' ').next().unwrap().parse().unwrap()).collect();
    let first: Vec<f64> = rows[0].split(' ').map(|word| word.parse().unwrap()).collect();
    assert!(first[0] < 1.0 && first[1] < 1.0 && targets[3999] == 200.0, "{first:?}");
    // Still armed: the next move is recorded anew. With a wave trigger it is not.
    ask(&device, "MVR 1 1");
    assert_eq!(number(&device, "DRL? 1"), 20.0);
    ask(&device, "DRT 0 0 0\nMVR 1 1");
    assert_eq!(number(&device, "DRL? 1"), 40.0);
    // The next command, then the default again; and at once.
    assert_eq!(ask(&device, "DRT 3 2 0\nCSV?\nDRL? 3\nDRT? 3"), "2.0\n3=20\n3=0 0");
    assert_eq!(ask(&device, "DRT 4 4 0\nDRL? 4\nDRT? 4\nDRT 4 9 0\nERR?"), "4=20\n4=0 0\n17");
    ask(&device, "STE 1 10");
    assert_eq!(ask(&device, "ERR?\nDRL? 4"), "0\n4=40");
}

#[test]
fn the_servo_follows_a_slow_sine() {
    let device = device(Simulation::default());
    ask(&device, "SVO 1 1\nWAV 1 X SIN_P 400 200 -100 400 0 200\nWSL 1 1\nWGC 1 0\nWTR 1 20 1\nMOV 1 -100");
    wait(&device, 2.0);
    // The position error of 2.5 Hz, +-100 um.
    ask(&device, "DRC 1 1 3\nRTR 100\nDRT 1 0\nWGO 1 1");
    wait(&device, 2.0);
    let rows = ask(&device, "DRR? 201 160 1");
    let errors = rows.lines().filter(|row| !row.starts_with('#')).map(|row| row.parse::<f64>().unwrap());
    let largest = errors.fold(0.0, |a: f64, b| a.max(b.abs()));
    assert!(largest > 0.1 && largest < 20.0, "{largest} um");
}

#[test]
fn no_line_makes_it_panic_and_none_takes_long() {
    let device = device(Simulation { axes: 3, plant: "paper".into(), ..Simulation::default() });
    let names: Vec<&str> = Model::E727.help().filter_map(|line| line.split(' ').next()).collect();
    let words = [
        "1",
        "2",
        "3",
        "0",
        "-1",
        "17",
        "1e300",
        "-1e300",
        "nan",
        "inf",
        "x",
        "",
        "X",
        "&",
        "+",
        "PNT",
        "LIN",
        "RAMP",
        "SIN_P",
        "0x07000301",
        "0x07000200",
        "18446744073709551615",
        "9223372036854775807",
        "262144",
        "1e-9",
        "1e9",
        "0.5",
        "advanced",
        "100",
        "4",
        "16",
        "\u{fc}",
    ];
    let mut state = 1u64;
    let mut random = |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    ask(&device, "CCL 1 advanced");
    for _ in 0..20_000 {
        let name = names[random(names.len())];
        let line = (0..random(9)).fold(name.to_string(), |line, _| line + " " + words[random(words.len())]);
        let begin = std::time::Instant::now();
        let volts = { locked(&*device.device).answer(&line) };
        assert!(begin.elapsed().as_secs_f64() < 5.0, "{line}: {}", volts.len());
    }
    assert_eq!(ask(&device, "\x18\nERR?\nCSV?"), "10\n2.0");
    let volts = ask(&device, "VOL?");
    assert!(volts.lines().all(|line| line.split('=').nth(1).unwrap().parse::<f64>().unwrap().abs() <= 30.0), "{volts}");
}
