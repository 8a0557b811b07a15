//! Moves in time.

use crate::bench::{Bench, number};

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
