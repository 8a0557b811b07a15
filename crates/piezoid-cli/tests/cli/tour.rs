//! The commands of the README's section "From records to a model", one after the other in an empty folder.

use crate::bench::{Bench, number};

const README: &str = include_str!("../../../../README.md");

#[test]
fn the_tour_works_as_printed_and_ends_twenty_times_better_than_a_straight_line() {
    let (_, rest) = README.split_once("## From records to a model").unwrap();
    let (tour, _) = rest.split_once("\n## ").unwrap();
    let lines: Vec<&str> = tour.lines().filter_map(|line| line.strip_prefix("piezoid ")).collect();
    assert!(lines.len() >= 17, "{lines:?}");
    let bench = Bench::new();
    for line in lines {
        let run = bench.run(line).ok();
        if line.starts_with("identify") {
            run.prints(&["preisach, gain 22.", "Good to 0.01", "unproven: large signals above 80 Hz"]);
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
