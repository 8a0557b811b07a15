//! A wave table for controllers: from the command line to the commands of the controller.

use crate::bench::Bench;
use std::f64::consts::TAU;

const MAKE: &str = "export --model model.json --target waveform --reference r.csv --driver pl140 --name scan";

/// A bench with three periods of a sine of 5 Hz and this amplitude [mm].
fn bench(height: f64) -> Bench {
    let bench = Bench::stocked();
    let row = |t: i32| format!("{},{}\n", f64::from(t) * 5e-4, height * (TAU * f64::from(t) / 400.0).sin());
    bench.write("r.csv", "t_s,r_mm\n".to_string() + &(0..1200).map(row).collect::<String>());
    bench
}

#[test]
fn what_the_table_holds_makes_the_model_follow() {
    let bench = bench(0.4);
    bench
        .run(&format!("{MAKE} --range -30 120 -o scan"))
        .ok()
        .says(&["scan_nv200.txt: 400 points of 5e-4 s", "only this period is exported"]);
    let commands = bench.text("scan/scan_nv200.txt");
    let percent = commands.lines().filter_map(|line| line.strip_prefix("gbarb,")?.split_once(',')?.1.parse().ok());
    let volts: Vec<f64> = percent.map(|percent: f64| 1.5 * percent - 30.0).collect();
    assert_eq!(volts.len(), 400);
    // The model has no creep: two periods are enough.
    let row = |t: usize| format!("{},{}\n", t as f64 * 5e-4, volts[t % 400]);
    bench.write("u.csv", "t_s,u_V\n".to_string() + &(0..1200).map(row).collect::<String>());
    bench.run("simulate --model model.json --input u.csv -o y.csv").ok();
    let y = bench.text("y.csv");
    assert!(y.starts_with("t_s,u_V,y_um\n"), "{y:.20}");
    let off = y.lines().skip(801).enumerate().map(|(t, line)| {
        let y: f64 = line.rsplit(',').next().unwrap().parse().unwrap();
        (y - 400.0 * (TAU * t as f64 / 400.0).sin()).abs() / 800.0
    });
    assert!(off.fold(0.0, f64::max) < 1e-3);
    assert!(bench.text("scan/scan_gcs.txt").contains("\nWTR 1 10 0\n"));
    bench.run(&format!("{MAKE} --servo-cycle 1e-4 -o other")).ok().says(&["no NV200 file is written"]);
    assert!(bench.text("other/scan_gcs.txt").contains("\nWTR 1 5 0\n"));
}

#[test]
fn what_cannot_be_made_leaves_nothing_behind() {
    let far = bench(4.0);
    far.refused(&format!("{MAKE} -o scan")).says(&["r.csv: the reference cannot be reached", "--clip"]);
    let bench = bench(0.4);
    bench.misused(&format!("{MAKE} --range 0 120 -o scan")).says(&["--range 0 to 120 V: must contain the drive"]);
    bench.misused("export --model model.json --target waveform -o scan").says(&["--reference", "must be given"]);
    bench.misused("export --model model.json --target c --reference r.csv -o scan").says(&["--reference", "waveform"]);
    bench
        .misused("export --model model.json --target fixed --float -o scan")
        .says(&["--float: does not apply to", "only to c,"]);
    bench
        .misused("export --model model.json --target c --controller predictive -o scan")
        .says(&["--controller predictive", "cannot be exported: choose another feedback"]);
}
