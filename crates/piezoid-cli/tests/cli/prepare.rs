//! `prepare`: steps in order, stated and kept.

use crate::bench::{Bench, number};

/// The columns of a record in CSV, below its history.
fn columns(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let rows: Vec<Vec<f64>> = rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    (0..3).map(|k| rows.iter().map(|row| row[k]).collect()).collect()
}

#[test]
fn each_step_is_told_written_and_stored_in_the_model() {
    let bench = Bench::stocked();
    let line = "prepare sine5.csv --from 0.2 --output-offset 3 --average --decimate 4 -o period.csv";
    let message = [
        "note: cut from 0.2 s\n",
        "note: 3 um added to the output\n",
        "note: averaged 4 periods of 0.2 s, the last of the record; standard deviation of the output's noise 1.",
        "like a transient, by 3.",
        ", and without it the noise is 0.1",
        "note: decimated by 4, to 0.002 s, with an anti-alias filter that keeps up to 200 Hz",
    ];
    bench.run(line).ok().says(&message);
    let text = bench.text("period.csv");
    assert!(text.starts_with("# piezoid: cut from 0.2 s\n# piezoid: 3 um added to the output\n"), "{text:.200}");
    let [t, u, _] = &columns(&text)[..] else { panic!() };
    assert_eq!((t.len(), t[1]), (100, 0.002));
    assert!((u.iter().fold(0.0, |m: f64, u| m.max(*u)) - 30.0).abs() < 1e-3);
    // The same steps, however it is written.
    for name in ["period.npz", "period.mat"] {
        bench.run(&line.replace("period.csv", name)).ok();
        let observed = bench.run(&format!("inspect {name} --json -")).ok().out_json();
        assert_eq!(observed[0]["history"].as_array().unwrap().len(), 4, "{observed}");
    }
    bench
        .run("identify period.csv --operator proportional --order 1 --from 0.02 -o new.json")
        .ok()
        .says(&["period.csv: 3 um added to the output"]);
    let steps = &bench.json("new.json")["fit"]["files"][0]["steps"];
    let steps: Vec<&str> = steps.as_array().unwrap().iter().map(|step| step.as_str().unwrap()).collect();
    assert_eq!((steps.len(), steps[0], steps[4]), (5, "cut from 0.2 s", "cut from 0.02 s"));
    // And again: the history grows.
    bench.run("prepare period.csv --detrend mean -o again.csv").ok();
    assert_eq!(bench.text("again.csv").matches("# piezoid: ").count(), 5);
}

#[test]
fn times_may_have_units_and_a_profile_says_how_the_file_is_read() {
    let bench = Bench::stocked();
    bench.write("rig.toml", "output_scale = \"2nm/um\"\n");
    let run = bench.run("prepare sine20.csv --profile rig.toml --delay=-0.75ms --resample 1ms -o - --to 200ms").ok();
    run.says(&[
        "note: output scaled by 2nm/um",
        "note: output shifted later by 0.00075 s (1.5 samples); the first 2 samples, without output, cut",
        "note: resampled from 5e-4 s to 0.001 s",
    ]);
    let run = bench.run("prepare sine20.csv --resample 1ms -o -").ok();
    assert!(run.out.contains("\nt_s,u_V,y_um\n0.000,"), "{:.200}", run.out);
    assert_eq!(columns(&run.out)[0].len(), 1000);
}

#[test]
fn a_file_is_only_converted_without_options() {
    let bench = Bench::stocked();
    bench.run("prepare sine5.csv -o sine5.npz").ok();
    assert_eq!(bench.run("prepare sine5.npz -o -").ok().out, bench.text("sine5.csv"));
}

#[test]
fn spikes_are_replaced_and_counted() {
    let bench = Bench::stocked();
    let spiked = |(k, line): (usize, &str)| match k {
        301 | 1200 => format!("{}9", line.rsplit_once('.').unwrap().0.rsplit_once(',').unwrap().0.to_string() + ",55."),
        _ => line.into(),
    };
    let rows: Vec<String> = bench.text("sine5.csv").lines().enumerate().map(spiked).collect();
    bench.write("spiked.csv", rows.join("\n"));
    bench
        .run("prepare spiked.csv --outliers -o clean.csv")
        .ok()
        .says(&["replaced by interpolation: 2 samples in 2 places (the first at 0.15 s, the last at 0.5995 s)"]);
    let (clean, whole) = (columns(&bench.text("clean.csv")), columns(&bench.text("sine5.csv")));
    let worst = clean[2].iter().zip(&whole[2]).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    assert!(worst < 0.5, "{worst}");
    let observed = bench.run("inspect clean.csv --json -").ok().out_json();
    assert_eq!(
        (number(&observed[0]["record"]["samples"]), observed[0]["problems"].as_array().unwrap().len()),
        (2000.0, 0)
    );
}

#[test]
fn what_cannot_be_done_is_refused_before_anything_is_written() {
    let bench = Bench::stocked();
    for (options, says) in [
        ("--decimate 0", "must be a whole number, 1 or more"),
        ("--decimate 5000", "error: --decimate 5000: the record has only 2000 samples"),
        ("--resample 2", "error: --resample 2 s: fewer than two samples would remain"),
        ("--resample 1ms --decimate 2", "give either decimate or resample"),
        ("--resample 2V", "must be a positive number [s]"),
        ("--delay 5", "error: --delay 5 s: the record is only 1 s long"),
        ("--detrend cubic", "line"),
        ("--period 0.2", "--average"),
        ("--average --period 0.3", "the input does not repeat with this period"),
    ] {
        let run = bench.run(&format!("prepare sine5.csv {options} -o out.csv"));
        assert_eq!(run.code, Some(2), "{run:?}");
        run.says(&[says]);
    }
    bench.refused("prepare sine5.csv --from 7 -o out.csv").says(&["sine5.csv: no sample lies from 7 s on"]);
    bench
        .refused("prepare prbs.csv --average --to 1 -o out.csv")
        .says(&["no period was found", "give --period SECONDS"]);
    bench.refused("prepare drive5.csv --outliers -o out.csv").says(&["drive5.csv", "no output column"]);
    bench.run("prepare sine5.csv -o out.h5").exits(2).says(&["read, but not written"]);
    bench.misused("prepare sine5.csv -o sine5.csv").says(&["would be overwritten"]);
    assert!(!bench.names().contains(&"out.csv".to_string()));
}
