//! Records that can be read but have defects: the messages about them, from end to end.

use crate::bench::Bench;

/// Rewrites a record row by row from input and output, without its time column.
pub(crate) fn rewritten(bench: &Bench, from: &str, to: &str, change: impl Fn(usize, f64, f64) -> Option<(f64, f64)>) {
    let text = bench.text(from);
    let rows = text.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>());
    let kept = rows.enumerate().filter_map(|(t, row)| change(t, row[1], row[2]));
    bench.write(to, kept.fold("u_V,y_um\n".to_string(), |text, (u, y)| format!("{text}{u},{y}\n")));
}

/// A bench with a record of a plant with noise, at 5 Hz and 28 V.
fn stocked() -> Bench {
    let bench = Bench::stocked();
    bench.run("excite sine --ts 5e-4 --duration 2 --amplitude 28 --frequency 5 -o drive.csv").ok();
    bench.run("simulate --plant pl140 --input drive.csv -o sound.csv").ok();
    bench
}

#[test]
fn each_defect_is_named_with_its_place_by_identify_validate_and_the_report() {
    let bench = stocked();
    type Change = fn(usize, f64, f64) -> Option<(f64, f64)>;
    let defects: [(&str, Change, &[&str]); 6] = [
        (
            "spike",
            |t, u, y| Some((u, if t == 1234 { y + 300.0 } else { y })),
            &["outliers: 1 sample (at 0.617 s)", "300"],
        ),
        ("limit", |_, u, y| Some((u, y.min(700.0))), &["output is saturated", "700.0 um", "places"]),
        (
            "stuck",
            |t, u, y| Some((u, if (1000..1060).contains(&t) { 77.0 } else { y })),
            &["frozen", "60 samples (from 0.5 s"],
        ),
        ("drift", |t, u, y| Some((u, y + 0.05 * t as f64)), &["drifts by", "% of stroke", "does not slow down"]),
        ("clip", |_, u, y| Some((u.min(23.0), y)), &["recorded input is clipped", "places"]),
        (
            "gap",
            |t, u, y| (!(2210..2270).contains(&t)).then_some((u, y)),
            &["rows seem to be missing", "at 1.105 s", "split"],
        ),
    ];
    for (name, change, says) in defects {
        let file = format!("{name}.csv");
        rewritten(&bench, "sound.csv", &file, change);
        bench
            .run(&format!("validate --model model.json --data {file} --ts 5e-4"))
            .ok()
            .says(&[&["note:", &file], says].concat());
        bench
            .run(&format!("identify --data {file} --operator prandtl-ishlinskii --ts 5e-4 -o new.json"))
            .ok()
            .says(&[&["note: large-signal record: "], says].concat());
        bench.run(&format!("report --model model.json --data {file} --ts 5e-4 -o page.html")).ok();
        // Sentences on the page begin with a capital letter.
        assert!(bench.text("page.html").contains(&says[0][1..]), "{name}");
    }
    for file in ["sound.csv", "sine5.csv", "sine20.csv", "prbs.csv"] {
        let run = bench.run(&format!("validate --model model.json --data {file}")).ok();
        for word in ["outliers", "saturated", "frozen", "drifts", "clipped", "missing"] {
            assert!(!run.err.contains(word), "{run:?}");
        }
    }
}

#[test]
fn what_nothing_can_be_found_from_is_refused_by_identify() {
    let bench = stocked();
    rewritten(&bench, "sound.csv", "still.csv", |_, _, y| Some((3.0, y)));
    bench.refused("identify --data still.csv --ts 5e-4 -o new.json").says(&["input is constant at 3 V"]);
    rewritten(&bench, "sound.csv", "dead.csv", |_, u, _| Some((u, 7.0)));
    bench.refused("identify --data dead.csv --ts 5e-4 -o new.json").says(&["output is constant at 7 um", "sensor"]);
    bench.refused("identify --data sound.csv --to 0.004 -o new.json").says(&["samples", "at least"]);
    bench
        .refused("identify --small-signal sound.csv --large-signal sound.csv -o new.json")
        .says(&["one frequency (5 Hz)", "PRBS"]);
}
