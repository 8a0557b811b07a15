//! The tour of the README, one command after the other in an empty folder.

use crate::bench::{Bench, number};

const README: &str = include_str!("../../../../README.md");
const FIRST_HOUR: &str = include_str!("../../../../docs/first-hour.md");

/// The commands in the blocks of a page.
fn commands(page: &str) -> Vec<&str> {
    let blocks = page.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    blocks.flat_map(str::lines).filter_map(|line| line.strip_prefix("piezoid ")).collect()
}

/// `cargo xtask book` runs the first hour too, and compares what it prints.
#[test]
fn the_first_hour_explains_each_command_of_the_tour() {
    let (explained, tour) = (commands(FIRST_HOUR), commands(README));
    assert!(tour.len() >= 16, "{tour:?}");
    let mut rest = explained.iter();
    for line in tour {
        assert!(rest.any(|explained| *explained == line), "docs/first-hour.md has no `{line}` at this place");
    }
}

#[test]
fn the_tour_works_and_ends_twenty_times_better_than_a_straight_line() {
    let bench = Bench::new();
    for line in commands(README) {
        let run = bench.run(line).ok();
        if line.starts_with("identify") {
            run.prints(&["preisach, gain 22.", "Good to 0.013 %", "unproven: large signals above 80 Hz"]);
        } else if line.starts_with("validate") {
            run.prints(&["Good to 0.017 %"]);
        } else if line.starts_with("compensate") {
            run.prints(&["expected on the actuator"]).says(&["unproven: large signals above 80 Hz"]);
        }
    }
    bench.run("control --plant pl140 --model model.json --reference path.csv --controller gain feed-forward --json c.json").ok();
    let compared = bench.json("c.json");
    let error = |k: usize| number(&compared["schemes"][k]["tracking"][0]["rms"]);
    let ratio = error(0) / error(1);
    assert!(ratio >= 20.0, "{ratio}: {compared}");

    // The voltage that was written does the same: from the second period on, when the start is over.
    bench.run("simulate u.csv --plant pl140 -o tracked.csv").ok();
    let column = |name: &str, file: &str| {
        let text = bench.text(file);
        let k = text.lines().next().unwrap().split(',').position(|head| head == name).unwrap();
        text.lines().skip(201).map(|row| row.split(',').nth(k).unwrap().parse::<f64>().unwrap()).collect::<Vec<_>>()
    };
    let (y, r) = (column("y_um", "tracked.csv"), column("r_um", "path.csv"));
    let rms = (y.iter().zip(&r).map(|(y, r)| (y - r) * (y - r)).sum::<f64>() / y.len() as f64).sqrt();
    assert!(rms < error(0) / 20.0, "{rms}");
}
