//! Drive signals, the limits of drivers, and the response of plants.

use crate::bench::Bench;

#[test]
fn a_drive_beyond_its_driver_is_refused_or_clipped_on_request() {
    let bench = Bench::new();
    let sine = "excite sine --ts 5e-4 --duration 1 --frequency 40 -o u.csv";
    bench.refused(&format!("{sine} --amplitude 40 --driver pl140")).says(&[
        "pl140",
        "highest voltage 39.",
        "limit 30 V",
        "lowest voltage",
        "--clip",
    ]);
    bench.run(&format!("{sine} --amplitude 30 --driver pl140")).ok().says(&["note: current: 0.06", "% of the limit"]);
    bench.run(&format!("{sine} --amplitude 40 --driver pl140 --clip")).ok().says(&["samples clipped", "`pl140`"]);
    let clipped = bench.text("u.csv");
    let highest = clipped.lines().skip(1).map(|row| row.split_once(',').unwrap().1.parse::<f64>().unwrap());
    assert_eq!(highest.fold(0.0, f64::max), 30.0);
    let loaded = bench
        .refused(&format!("{} --amplitude 200 --driver bd300 --capacitance 8.2e-6", sine.replace("u.csv", "v.csv")));
    loaded.says(&["current", "limit 0.05 A"]);
}

#[test]
fn every_kind_of_drive_signal_drives_every_plant_of_the_list() {
    let bench = Bench::new();
    for (kind, flags) in [
        ("prbs", ""),
        ("multisine", "--frequency-low 5 --frequency-high 200 --seed 3"),
        ("chirp", "--frequency-start 1 --frequency-end 200 --logarithmic 1"),
        ("sine", "--frequency 5"),
        ("rising-sine", "--frequency 5"),
        ("triangle", "--frequency 5"),
        ("staircase", "--frequency 5"),
        ("stepped-sine", "--frequency 5 --steps 20"),
    ] {
        bench
            .run(&format!("excite {kind} --ts 5e-4 --duration 0.5 --amplitude 2 --offset -1 {flags} -o {kind}.csv"))
            .ok();
        let text = bench.text(&format!("{kind}.csv"));
        assert_eq!((text.lines().count(), text.lines().next()), (1001, Some("t_s,u_V")), "{kind}");
    }
    for plant in bench.run("plants --json -").ok().out_json().as_array().unwrap() {
        let name = plant["name"].as_str().unwrap();
        bench.run(&format!("simulate --plant {name} --input sine.csv -o {name}.csv")).ok();
        assert!(bench.text(&format!("{name}.csv")).starts_with("t_s,u_V,y_um\n"));
    }
}

#[test]
fn a_plant_is_shown_changed_and_given_back() {
    let bench = Bench::stocked();
    let shown = bench.run("plants --show paper").ok().out;
    bench.write("mine.json", &shown);
    assert_eq!(bench.run("simulate --plant mine.json --input drive5.csv -o -").ok().out, bench.text("sine5.csv"));
    bench.write("odd.json", shown.replacen("\"driver\"", "\"drivver\"", 1));
    bench.refused("simulate --plant odd.json --input drive5.csv -o y.csv").says(&["odd.json", "line", "`drivver`"]);
    bench.refused("simulate --plant model.json --input drive5.csv -o y.csv").says(&["model.json", "unknown field"]);
}

#[test]
fn limits_that_a_plant_reaches_are_told_even_when_quiet() {
    let bench = Bench::new();
    bench.run("excite sine --ts 5e-4 --duration 0.5 --amplitude 40 --frequency 5 -o hard.csv").ok();
    bench.run("simulate --plant pl140 --input hard.csv -o y.csv --quiet").ok().says(&["note:", "clamped"]);
}

#[test]
fn noise_depends_on_the_seed_alone() {
    let bench = Bench::stocked();
    let noisy = |seed: &str| bench.run(&format!("simulate --plant pl140 --input drive5.csv {seed} -o -")).ok().out;
    assert_eq!(noisy(""), noisy("--seed 1"));
    assert_ne!(noisy(""), noisy("--seed 2"));
}
