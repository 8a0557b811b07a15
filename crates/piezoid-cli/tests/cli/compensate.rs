//! A voltage for a wanted displacement.

use crate::bench::{Bench, number};
use std::f64::consts::TAU;

/// A bench with a reference of 5 Hz and this height [um].
fn bench(height: f64) -> Bench {
    let bench = Bench::stocked();
    let row = |t: i32| format!("{},{}\n", f64::from(t) * 5e-4, height * (TAU * 5.0 * f64::from(t) * 5e-4).sin());
    bench.write("r.csv", "t_s,r_um\n".to_string() + &(0..800).map(row).collect::<String>());
    bench
}

const MAKE: &str = "compensate --model model.json --reference r.csv";

#[test]
fn the_voltage_makes_the_model_follow_and_the_table_says_how_near() {
    let bench = bench(400.0);
    let run = bench.run(&format!("{MAKE} --driver pl140 --json figures.json -o u.csv")).ok();
    run.prints(&["% of stroke", "foretold", "highest voltage [V]", "current [A]", "% of limit"]);
    assert!(bench.text("u.csv").starts_with("t_s,u_V,r_um\n"));
    let figures = bench.json("figures.json");
    assert!(number(&figures["rms_pp_percent"]) < 5.0 && number(&figures["clipped"]) == 0.0, "{figures}");
    bench.run("simulate --plant paper --input u.csv -o y.csv").ok();
    bench.run(&format!("{MAKE} --smooth 0.01 --zvd --notch --json - -o shaped.csv")).ok();
    assert_ne!(bench.text("u.csv"), bench.text("shaped.csv"));
}

#[test]
fn what_cannot_be_reached_is_refused_or_clipped_on_request() {
    let bench = bench(4000.0);
    bench.refused(&format!("{MAKE} --driver pl140 -o u.csv")).says(&["r.csv", "cannot be reached", "um", "--clip"]);
    bench.run(&format!("{MAKE} --driver pl140 --clip -o u.csv")).ok().says(&["samples are clipped"]);
    bench.misused(&format!("{MAKE} --driver bd300 -o u.csv")).says(&["--capacitance"]);
    bench.write("r.csv", "t_s,r_counts\n0,1\n0.0005,2\n");
    bench.refused(&format!("{MAKE} -o u.csv")).says(&["counts", "um", "convert"]);
}
