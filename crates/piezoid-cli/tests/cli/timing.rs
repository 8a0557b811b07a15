//! Moves in time.

use crate::bench::{Bench, number};
use crate::instrument::{Controller, ended, signal, witness};
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

#[test]
fn steps_scans_and_measured_paths_are_timed_in_tables_json_and_files() {
    let bench = Bench::stocked();
    let run = bench.run("timing --model model.json --tolerance 2um --driver pl140 --json t.json -o t.csv").ok();
    run.prints(&["steps that settle", "model, straight line", "minimum jerk", "flyback", "(shortest)"]);
    let figures = bench.json("t.json");
    assert_eq!((number(&figures["tolerance"]), figures["runs"].as_array().map_or(0, Vec::len)), (2.0, 2));
    let shortest = number(&figures["step"]["shortest"]["settling_s"]);
    assert!(shortest > 0.0 && shortest < 0.05, "{figures}");
    assert!(bench.text("t.csv").starts_with("t_s,u_V,r_um,model_compensated_um,model_straight_line_um\n"));

    let row = |t: i32| format!("{},{}\n", f64::from(t) * 5e-4, 200.0 * f64::from((t / 400) % 2));
    bench.write("r.csv", "t_s,r_um\n".to_string() + &(0..1600).map(row).collect::<String>());
    let path = "timing --model model.json --path r.csv --smooth 20ms --tolerance 3000nm";
    bench.run(&format!("{path} --plant pl140 --json p.json")).ok().prints(&["pl140, compensated", "on plant [ms]"]);
    let figures = bench.json("p.json");
    let steps = figures["runs"][0]["steps"].as_array().unwrap().clone();
    // Moves of 20 ms settle on the model when they end.
    assert!(steps.len() == 3 && steps.iter().all(|step| number(&step["settling_s"]) < 0.021), "{steps:?}");
    bench.run(&format!("{path} --measured r.csv --json m.json")).ok().prints(&["measured"]);
    bench.run("timing --model model.json --measured r.csv").exits(2).says(&["--path"]);
    bench.misused("timing --model model.json --step 3V").says(&["--step", "length"]);
    bench.misused(&format!("{path} --step 3um")).says(&["--step", "leave it out"]);
    bench.misused(&format!("{path} --plant nothing")).says(&["nothing", "pl140"]);
}

#[test]
fn a_path_is_timed_on_a_controller_once_its_user_agrees() {
    let (bench, controller) = (Bench::new(), Controller::with("--plant pl140"));
    for drive in
        ["prbs --duration 2.0475 --amplitude 1 --order 12", "rising-sine --duration 2 --amplitude 28 --frequency 5"]
    {
        let name = &drive[..4];
        bench.run(&format!("excite {drive} --ts 5e-4 -o {name}.csv")).ok();
        bench.run(&format!("simulate --plant pl140 --input {name}.csv -o y_{name}.csv")).ok();
    }
    bench.run("identify y_risi.csv --small-signal y_prbs.csv --operator preisach --order 5 -o model.json").ok();
    let row = |t: i32| format!("{},{}\n", f64::from(t) * 5e-4, 200.0 * f64::from((t / 400) % 2));
    bench.write("r.csv", "t_s,r_um\n".to_string() + &(0..1200).map(row).collect::<String>());
    let line = "timing --model model.json --path r.csv --smooth 20ms --tolerance 5um --driver pl140";
    // What names a controller without meaning one would be forgotten silently.
    bench.misused(&format!("{line} --host 192.0.2.1")).says(&["--host has no effect without --controller"]);
    bench.misused(&format!("{line} --wait 1")).says(&["--wait has no effect without --controller"]);
    bench.run(&format!("{line} --yes")).exits(2).says(&["--controller"]);
    let line = format!("{line} --plant pl140 --controller --port {} --ramp 0.1", controller.1);
    let refusal = ["axis 1 is to move between -2", "Add --yes to agree to it; nothing has moved"];
    bench.run(&format!("{line} -o none.csv")).exits(1).says(&refusal);
    assert!(controller.voltage() == 0.0 && !bench.path("none.csv").exists());

    let run = bench.run(&format!("{line} --wait 0.2 --yes --json c.json -o c.csv")).ok();
    run.prints(&["controller, compensated", "controller, straight line", "axis 1 is at 0.000 V, in open loop."]);
    let figures = bench.json("c.json");
    assert_eq!(figures["controller"]["unfinished"], serde_json::Value::Null);
    for k in 0..2 {
        let of = |run: usize| number(&figures["runs"][run]["steps"][k]["settling_s"]);
        assert!((of(4) - of(2)).abs() <= 1.01e-3, "controller {}, plant {}", of(4), of(2));
    }
    let head = bench.text("c.csv").lines().next().unwrap().to_string();
    assert!(head.ends_with("controller_compensated_um,controller_straight_line_um"), "{head}");
    assert_eq!((bench.text("c.csv").lines().count(), controller.voltage()), (1201, 0.0));
}

#[test]
#[cfg(unix)]
fn ctrl_c_ends_a_timed_path_with_the_axis_at_rest() {
    let (bench, controller) = (Bench::stocked(), Controller::with("--plant pl140"));
    let line = format!(
        "timing --model model.json --tolerance 5um --smooth 20ms --driver pl140 --controller --yes --port {} --wait 60 -o none.csv",
        controller.1
    );
    let child = bench.command(&line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // The demagnetisation goes on for 1.5 s; then it waits.
    while controller.voltage() == 0.0 {
        sleep(Duration::from_millis(50));
    }
    signal(&child, "-INT");
    let run = ended(&line, child).exits(130).says(&["nothing was written"]);
    witness(&controller, &run);
    assert!(!bench.path("none.csv").exists());
}
