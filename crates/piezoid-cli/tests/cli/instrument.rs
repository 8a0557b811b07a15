//! `acquire` and PI's own client PIPython on the controller of `instrument`.

use crate::bench::Bench;
use piezoid_testing::skipped;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A running controller, which ends with the test.
struct Controller(Child, String);

impl Controller {
    fn new() -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_piezoid"));
        let mut child =
            command.args(["instrument", "--plant", "paper", "--port", "0"]).stdout(Stdio::piped()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let port = line.trim().rsplit(' ').next().unwrap().to_string();
        Controller(child, port)
    }
}

impl Drop for Controller {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
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
    assert!(record.starts_with("# piezoid: measured by the controller piezoid, paper"), "{record:.99}");
    assert_eq!(record.lines().count(), 1002);
    bench.run("identify r.csv --operator pi -o m.json").ok();

    bench.refused(&format!("acquire u.csv --port {port} --range 0 5 -o none.csv")).says(&["outside 0 to 5 V"]);
    drop(controller);
    bench.refused(&format!("acquire --port {port} --timeout 1")).says(&["no controller answers at 127.0.0.1"]);
}

#[test]
fn the_client_of_the_maker_measures_too() {
    let there = Command::new("python3").args(["-c", "import pipython, numpy"]).output();
    if !there.is_ok_and(|message| message.status.success()) {
        return skipped("no PIPython");
    }
    let controller = Controller::new();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/instrument.py");
    let message = Command::new("python3").arg(script).arg(&controller.1).output().unwrap();
    let text = String::from_utf8_lossy(&message.stderr);
    assert!(message.status.success() && message.stdout.ends_with(b"all well\n"), "{text}");
}
