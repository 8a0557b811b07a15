//! `acquire`, the makers' own clients, PIPython and nv200, and pymeasure, on the controllers of `instrument`.

use crate::bench::{Bench, Run};
use piezoid_testing::skipped;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// So long must nothing take, even on a machine that is busy.
const GENEROUS: Duration = Duration::from_secs(30);

/// A running controller, which ends with the test, and its port.
pub(crate) struct Controller(Child, pub(crate) String);

impl Controller {
    fn new() -> Self {
        Controller::with("--plant paper")
    }

    pub(crate) fn with(options: &str) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_piezoid"));
        let options = options.split(' ');
        let mut child =
            command.args(["instrument", "--port", "0"]).args(options).stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let port = line.trim().rsplit(' ').next().unwrap().to_string();
        Controller(child, port)
    }

    pub(crate) fn port(&self) -> u16 {
        self.1.parse().unwrap()
    }

    pub(crate) fn id(&self) -> u32 {
        self.0.id()
    }

    /// Its answers, as a terminal shows them.
    pub(crate) fn text(&self, lines: &str) -> String {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port())).unwrap();
        stream.write_all(lines.as_bytes()).unwrap();
        stream.shutdown(Shutdown::Write).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    pub(crate) fn voltage(&self) -> f64 {
        self.text("VOL?\n").trim().strip_prefix("1=").unwrap().parse().unwrap()
    }
}

/// A measurement of 1 s that has started.
fn started(bench: &Bench, port: &str, options: &str) -> (String, Child) {
    if !bench.path("u.csv").exists() {
        bench.run("excite sine --frequency 2 --amplitude 20 --ts 1e-2 --duration 1 -o u.csv").ok();
    }
    let line = format!("acquire u.csv --port {port} --settle 0 -o r.csv --json r.json {options}");
    let child = bench.command(&line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    (line, child)
}

pub(crate) fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

/// How the measurement ended, which must be soon.
pub(crate) fn ended(line: &str, child: Child) -> Run {
    let begin = Instant::now();
    let run = Run::of(line, &child.wait_with_output().unwrap());
    assert!(begin.elapsed() < GENEROUS, "{run:?}");
    run
}

/// Waits until a file is there.
fn awaited(bench: &Bench, name: &str) {
    let begin = Instant::now();
    while !bench.path(name).exists() && begin.elapsed() < GENEROUS {
        sleep(Duration::from_millis(5));
    }
}

/// Checks what the client says against the controller.
pub(crate) fn witness(controller: &Controller, run: &Run) {
    assert_eq!(controller.text("\x09"), "0x0\n", "{run:?}");
    let stated = format!("axis 1 is at {:.3} V, in open loop", controller.voltage());
    assert!(run.err.contains(&stated) || run.err.contains("nothing has moved"), "`{stated}`: {run:?}");
}

impl Drop for Controller {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

#[test]
fn positions_are_played_in_closed_loop_where_the_servo_is_on() {
    let (bench, controller) = (Bench::new(), Controller::new());
    let row = |k: usize| format!("{:.2},{:.3}\n", 0.01 * k as f64, 60.0 - 10.0 * (0.06 * k as f64).cos());
    bench.write("path.csv", "t_s,r_um\n".to_string() + &(0..100).map(row).collect::<String>());
    let line = format!("acquire path.csv --closed-loop --port {} --ramp 0.1 --settle 0 -o r.csv", controller.port());
    bench.run(&line).exits(2).says(&["--closed-loop: needs the servo, but that of axis 1 is off"]);
    assert!(!bench.path("r.csv").exists());
    controller.text("SVO 1 1\nMOV 1 50\n");
    sleep(Duration::from_secs(1));
    bench.run(&line).ok().says(&["the position differs from the drive by"]);
    assert_eq!((controller.text("MOV?\n"), controller.text("SVO?\n")), ("1=50.000000\n".into(), "1=1\n".into()));
    assert_eq!(bench.text("r.csv").lines().filter(|line| !line.starts_with('#')).count(), 101);
}

#[test]
fn a_drive_becomes_a_record_and_a_model() {
    let (bench, controller) = (Bench::new(), Controller::new());
    let port = controller.1.clone();
    let message = bench.run(&format!("acquire --port {port}")).ok().out;
    assert!(message.contains("simulated controller") && message.contains("-30 to 30 V"), "{message}");
    bench.run("excite rising-sine --frequency 8 --amplitude 25 --ts 1e-3 --duration 1 -o u.csv").ok();
    bench.run(&format!("acquire u.csv --port {port} --ramp 0.1 --settle 0 -o r.csv")).ok();
    let record = bench.text("r.csv");
    assert!(record.starts_with("# piezoid: measured by the controller piezoid, E-727"), "{record:.99}");
    assert_eq!(record.lines().count(), 1002);
    bench.run("identify r.csv --operator pi -o m.json").ok();

    bench.refused(&format!("acquire u.csv --port {port} --low 0 --high 5 -o none.csv")).says(&["outside 0 to 5 V"]);
    let jump = "t_s,u_V\n0,-20\n0.001,-20\n0.002,20\n0.003,0\n";
    bench.write("jump.csv", jump);
    let refused = bench.refused(&format!("acquire jump.csv --port {port} -o none.csv"));
    refused.says(&["jumps by 40 V at 0.002 s", "give --driver or --slew"]);
    let limited = bench.refused(&format!("acquire jump.csv --port {port} --slew 1V/s -o none.csv"));
    limited.says(&["slew 40000 V/s at 0.002 s, limit 1 V/s"]);
    drop(controller);
    bench.refused(&format!("acquire --port {port} --timeout 1")).says(&["no controller answers at 127.0.0.1"]);
}

#[test]
fn a_virtual_clock_gives_the_same_numbers_again() {
    let moves = format!("SAI?\nSVO 2 1\nMOV 2 300\n\x05{}", "POS? 2\n".repeat(50));
    let wave =
        format!("WAV 1 X LIN 100 20 0 100 0 0\nWSL 1 1\nWTR 1 50 0\nWGO 1 1\n{}\x18ERR?\nVOL?\n", "VOL? 1\n".repeat(9));
    let run = || Controller::with("--model e-754 --axes 2 --virtual-time 0.01").text(&format!("*IDN?\n{moves}{wave}"));
    let text = run();
    assert!(text.starts_with("piezoid, E-754, simulated controller with pl140"), "{text}");
    assert!(text.contains("\n1 \n2\n2\n2=") && text.contains("1=7.070707\n10\n1=7.070707 \n2="), "{text}");
    assert_eq!(text, run());
}

#[test]
fn the_client_of_the_maker_measures_too() {
    let there = Command::new("python3").args(["-c", "import pipython, numpy"]).output();
    if !there.is_ok_and(|message| message.status.success()) {
        return skipped("no PIPython");
    }
    all_well("python3", "instrument.py", &Controller::new());
}

#[test]
fn the_client_of_piezosystem_jena_measures_too() {
    let has = |python: &&str| {
        let there = Command::new(python).args(["-c", "import nv200.nv200_device"]).output();
        there.is_ok_and(|message| message.status.success())
    };
    // It needs Python 3.12.
    let Some(python) = ["python3", "python3.12", "python3.13"].into_iter().find(has) else {
        return skipped("no Python with the package nv200");
    };
    all_well(python, "jena.py", &Controller::with("--model nv200 --plant paper"));
}

/// Runs a script against a controller.
fn all_well(python: &str, script: &str, controller: &Controller) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli").join(script);
    let message = Command::new(python).arg(script).arg(&controller.1).output().unwrap();
    let text = String::from_utf8_lossy(&message.stderr);
    assert!(message.status.success() && message.stdout.ends_with(b"all well\n"), "{text}");
}

/// A generator and an oscilloscope, and both ports.
fn generator() -> (Controller, [String; 2]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_piezoid"));
    let line = "instrument --model scpi --plant paper --gain 4 --port 0 --oscilloscope-port 0";
    let mut child = command.args(line.split(' ')).stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let ports = [0; 2].map(|_| lines.next().unwrap().unwrap().rsplit(' ').next().unwrap().to_string());
    (Controller(child, ports[0].clone()), ports)
}

#[test]
fn pymeasure_drives_the_generator_and_the_oscilloscope() {
    let there = Command::new("python3").args(["-c", "import pymeasure, pyvisa_py"]).output();
    if !there.is_ok_and(|message| message.status.success()) {
        return skipped("no pymeasure with pyvisa-py");
    }
    let (_controller, ports) = generator();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/scpi.py");
    let message = Command::new("python3").arg(script).args(ports).output().unwrap();
    let text = String::from_utf8_lossy(&message.stderr);
    assert!(message.status.success() && message.stdout.ends_with(b"all well\n"), "{text}");
}

#[test]
fn a_drive_by_a_generator_and_an_oscilloscope_becomes_a_record() {
    let (bench, (_controller, [port, other])) = (Bench::new(), generator());
    let at = format!("--protocol scpi --port {port} --oscilloscope 127.0.0.1:{other}");
    let message = bench.run(&format!("acquire --protocol scpi --port {port}")).ok().out;
    assert!(message.contains("33500B,simulated with paper and a sensor of 200 um/V"), "{message}");
    bench.run("excite rising-sine --frequency 8 --amplitude 25 --ts 1e-3 --duration 1 -o u.csv").ok();
    let all = format!("{at} --gain 4 --low -30 --high 30 --monitor-channel 1 --monitor-gain 10 --sensitivity 200");
    let run = bench.run(&format!("acquire u.csv {all} --ramp 0.1 --settle 0 -o r.csv")).ok();
    assert_eq!(run.out, "axis 1 is at 0.000 V, in open loop.\n");
    let record = bench.text("r.csv");
    assert!(record.starts_with("# piezoid: measured by piezoid,33500B"), "{record:.99}");
    assert_eq!(record.lines().count(), 1002);
    let refused = bench.refused(&format!("acquire u.csv {at} --low -30 --high 30 -o none.csv"));
    refused.says(&["a generator does not know the amplifier: give --gain"]);
    let refused = bench.refused(&format!("acquire u.csv {all} --sensor-range 0 1 -o none.csv"));
    refused.says(&["channel 2 of the oscilloscope", "--sensor-range"]);
}

#[test]
fn a_drive_on_an_nv200_becomes_a_record() {
    let (bench, controller) = (Bench::new(), Controller::with("--model nv200 --plant paper"));
    let at = format!("--protocol nv200 --port {}", controller.1);
    let message = bench.run(&format!("acquire {at}")).ok().out;
    assert!(message.contains("NV200/D_NET, PAPER #000001") && message.contains("-30 to 30 V"), "{message}");
    bench.run("excite rising-sine --frequency 8 --amplitude 25 --ts 1e-3 --duration 1 -o u.csv").ok();
    let run = bench.run(&format!("acquire u.csv {at} --ramp 0.1 --settle 0 -o r.csv")).ok();
    assert_eq!(run.out, "axis 1 is at 0.000 V, in open loop.\n");
    let record = bench.text("r.csv");
    assert!(record.starts_with("# piezoid: measured by the controller NV200/D_NET"), "{record:.99}");
    assert_eq!(record.lines().count(), 1002);
    bench.run("excite sine --frequency 2 --amplitude 20 --ts 1e-3 --duration 2 -o long.csv").ok();
    bench.refused(&format!("acquire long.csv {at} -o none.csv")).says(&["the generator of the controller holds 1024"]);
    // Each protocol has its own words for what it does not understand.
    bench.refused(&format!("acquire --port {}", controller.1)).says(&["check that it speaks GCS 2.0"]);
}

#[test]
#[cfg(unix)]
fn a_signal_while_an_nv200_plays_stops_its_generator_and_states_the_voltage() {
    let (bench, controller) = (Bench::new(), Controller::with("--model nv200 --plant paper"));
    for wait in [300, 900, 1500, 2100] {
        let (line, child) = started(&bench, &controller.1, "--protocol nv200 --ramp 0.2");
        sleep(Duration::from_millis(wait));
        signal(&child, "-TERM");
        let run = ended(&line, child);
        if run.code == Some(0) {
            continue;
        }
        assert_eq!(run.code, Some(130), "{run:?}");
        let state = ["and wave generator 1 is stopped", "nothing has moved"];
        assert!(run.err.is_empty() || state.iter().any(|text| run.err.contains(text)), "{run:?}");
        assert!(controller.text("grun\r\n").contains("grun,0"), "{run:?}");
    }
}

#[test]
#[cfg(unix)]
fn signals_at_any_moment_stop_the_generator_and_state_the_voltage() {
    for (k, name) in (0..16).zip(["-INT", "-TERM"].into_iter().cycle()) {
        let (bench, controller) = (Bench::new(), Controller::new());
        let (line, child) = started(&bench, &controller.1, "--ramp 0.3");
        sleep(Duration::from_millis(60 + 137 * k));
        signal(&child, name);
        let run = ended(&line, child);
        let is_written = bench.path("r.csv").exists();
        match run.code {
            Some(0) => assert!(bench.json("r.json")["unfinished"].is_null() && is_written, "{run:?}"),
            // Before the work begins a signal ends the process at once.
            Some(130) if run.err.is_empty() => assert!(!is_written && controller.voltage() == 0.0),
            Some(130) => {
                assert_eq!(is_written, run.err.contains("the record is written"), "{run:?}");
                assert!(is_written || run.err.contains("nothing was written"), "{run:?}");
                assert!(!is_written || bench.json("r.json")["unfinished"].is_string(), "{run:?}");
                witness(&controller, &run);
            }
            _ => panic!("{run:?}"),
        }
    }
}

#[test]
#[cfg(unix)]
fn two_signals_on_the_way_to_the_rest_do_not_lose_the_record() {
    let (bench, controller) = (Bench::new(), Controller::new());
    let (line, child) = started(&bench, &controller.1, "--ramp 2 --rest zero");
    awaited(&bench, "r.json");
    sleep(Duration::from_millis(300));
    signal(&child, "-INT");
    signal(&child, "-INT");
    let run = ended(&line, child).exits(130).says(&["cancelled: slow move", "the record is written"]);
    assert_eq!(bench.text("r.csv").lines().count(), 102);
    let document = bench.json("r.json");
    let unfinished = document["unfinished"].as_str().unwrap();
    assert!(run.err.contains(unfinished), "{unfinished}");
    assert!((document["voltage"].as_f64().unwrap() - controller.voltage()).abs() < 1e-5);
    witness(&controller, &run);
}

#[test]
#[cfg(unix)]
fn a_client_that_is_killed_on_the_way_to_the_rest_has_written_the_record() {
    let (bench, controller) = (Bench::new(), Controller::new());
    let (_, mut child) = started(&bench, &controller.1, "--ramp 2");
    awaited(&bench, "r.json");
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(bench.text("r.csv").lines().count(), 102);
    assert_eq!(bench.json("r.json")["unfinished"], "the axis has not moved to its rest yet");
}

#[test]
fn a_controller_that_goes_on_the_way_to_the_rest_is_a_failure_with_a_record() {
    let (bench, controller) = (Bench::new(), Controller::new());
    let (line, child) = started(&bench, &controller.1, "--ramp 2");
    awaited(&bench, "r.json");
    drop(controller);
    ended(&line, child).exits(1).says(&["wave generator 1 could not be stopped", "the record is written"]);
    assert_eq!(bench.text("r.csv").lines().count(), 102);
    assert!(bench.json("r.json")["unfinished"].is_string());
}

#[test]
#[cfg(unix)]
fn ctrl_c_is_noticed_while_the_controller_is_silent() {
    let bench = Bench::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let (line, child) = started(&bench, &listener.local_addr().unwrap().port().to_string(), "--timeout 3000");
    let (client, _) = listener.accept().unwrap();
    sleep(Duration::from_millis(200));
    signal(&child, "-INT");
    ended(&line, child).exits(130).says(&["nothing has moved", "nothing was written"]);
    drop(client);
}

#[test]
fn the_axis_rests_where_the_option_says() {
    let (bench, controller) = (Bench::new(), Controller::new());
    bench.write("u.csv", "t_s,u_V\n0,0\n0.01,5\n0.02,10\n0.03,12\n");
    controller.text("SVA 1 4\n");
    for (rest, expected) in [("start", 4.0), ("stay", 12.0), ("zero", 0.0)] {
        let (line, child) = started(&bench, &controller.1, &format!("--ramp 0.1 --rest {rest}"));
        let run = ended(&line, child).ok();
        assert_eq!(run.out, format!("axis 1 is at {expected:.3} V, in open loop.\n"));
        assert_eq!((controller.voltage(), bench.json("r.json")["voltage"].as_f64()), (expected, Some(expected)));
    }
}

/// A period of 50 us makes a campaign short: 10 s of creep, which the table holds only sampled less often.
#[test]
fn one_command_measures_identifies_and_straightens_an_actuator() {
    let (bench, controller) = (Bench::new(), Controller::with("--plant pl140"));
    let line = format!(
        "campaign --port {} --bandwidth 50 --actuator pl140 --driver pl140 --period 5e-5 --wait 1 --operator preisach \
         -o all",
        controller.1
    );
    let refusal = ["axis 1 is to move between -28.5 and 28.5 V, for ", "Add --yes to agree to it; nothing has moved"];
    bench.run(&line).exits(1).says(&refusal);
    assert_eq!(controller.voltage(), 0.0);
    let line = format!("{line} --yes");
    let child = bench.command(&line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Broken off once the first record is there.
    awaited(&bench, "all/small.csv");
    signal(&child, "-INT");
    let run = ended(&line, child).exits(130).says(&["the records so far are in all"]);
    witness(&controller, &run);
    bench.run(&line).ok();
    let results = bench.json("all/campaign.json");
    assert_eq!(results["resumed"], serde_json::json!(["small"]));
    assert!(results["better"].as_f64().unwrap() > 20.0, "{}", results["better"]);
    assert!(bench.path("all/campaign.html").exists() && controller.voltage().abs() < 0.1);
}
