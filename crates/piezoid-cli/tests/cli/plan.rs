//! `plan`: the drives, the page, and the model that its commands make.

use crate::bench::{Bench, number};

#[test]
fn a_planned_identification_of_a_simulated_stack_is_good_to_1_percent_and_advised_further() {
    let bench = Bench::new();
    let request = "plan --range 0 120 --bandwidth 20Hz --driver e-610 --capacitance 1.5uF";
    bench.run(&format!("{request} -o .")).ok().prints(&["small_u.csv", "% of limits", "Next: measure each drive"]);
    for name in ["small", "rise1", "rise2", "rise3", "creep", "path"] {
        bench.run(&format!("simulate {name}_u.csv --plant p885 --begin settled -o {name}.csv")).ok();
    }
    let page = bench.text("plan.md");
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("piezoid ")).collect();
    let [identify, validate] = commands[..] else { panic!("{page}") };
    bench.run(&format!("{identify} --operator PI")).ok();
    let error = bench.run(&format!("{validate} --json -")).ok().out_json()["total"]["rms_pp_percent"].clone();
    assert!(number(&error) < 1.0, "{error}");
    let message = "to the error of prediction";
    bench.run(&format!("{request} --model model.json -o next")).ok().prints(&[message]);
    assert!(bench.text("next/plan.md").contains(message));
}

#[test]
fn an_impossible_plan_leaves_nothing() {
    let bench = Bench::new();
    let driver = "--driver kpz101 --capacitance 1uF";
    for (options, says) in [
        ("--range 0 160 --bandwidth 5", "--range 0 160: driver `kpz101` gives 0 to 150 V"),
        ("--range 0 150 --bandwidth 500", "lower the bandwidth or the range, or take a driver with more current"),
        ("--range 0 150 --bandwidth 500 --ts 1ms", "must be below 100 Hz"),
        ("--bandwidth 500", "give the lowest and highest voltage, or the actuator"),
    ] {
        bench.misused(&format!("plan {options} {driver} -o plan")).says(&[says]);
    }
}
