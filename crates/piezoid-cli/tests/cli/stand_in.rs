//! A stand-in for the actuator of a model, in place of a twin.

use crate::bench::{Bench, number};
use crate::instrument::Controller;
use std::sync::OnceLock;

/// A bench with a model of the paper's plant that lies in a folder without its records.
fn bench() -> Bench {
    static MODEL: OnceLock<Vec<u8>> = OnceLock::new();
    let bench = Bench::stocked();
    let identify =
        "identify sine5.csv sine20.csv --small-signal prbs.csv --operator prandtl-ishlinskii --no-creep -o model.json";
    let identified = || {
        bench.run(identify).ok();
        bench.bytes("model.json")
    };
    let model = MODEL.get_or_init(identified);
    bench.write("model.json", model);
    let wave = |t: i32| 800.0 * (std::f64::consts::TAU * f64::from(t % 400) / 400.0).sin();
    let path = (0..1600).map(|t| format!("{},{}\n", 5e-4 * f64::from(t), wave(t))).collect::<String>();
    bench.write("r.csv", format!("t_s,r_um\n{path}"));
    bench
}

#[test]
fn a_stand_in_is_made_of_the_records_that_the_model_names_and_serves_as_a_plant() {
    let bench = bench();
    let line = "compensate r.csv --model model.json -o u.csv --json found.json --plant";
    let run = bench.run(&format!("{line} records")).ok();
    run.prints(&["on stand-in, constant gain", "on stand-in, compensated ("])
        .says(&["The stand-in is the model and ", " % of its difference from a model with "]);
    let found = bench.json("found.json");
    let on_plant = &found["on_plant"];
    let [gain, compensated] = ["gain", "compensated"].map(|how| number(&on_plant[how]["rmse"]));
    let [low, high] = [0, 1].map(|k| number(&on_plant["spread"][k]));
    assert!(compensated < gain && low <= high && low > 0.0, "{on_plant}");

    bench.run("stand-in model.json --records sine5.csv sine20.csv prbs.csv -o . --json kept.json").ok();
    let kept = bench.json("kept.json");
    assert!(number(&kept["share"]) > 0.0 && kept["operator"] != "prandtl-ishlinskii", "{kept}");
    // The file is the same actuator.
    bench.run(&format!("{line} stand-in.json")).ok();
    assert_eq!(bench.json("found.json")["on_plant"]["compensated"], on_plant["compensated"]);
    bench.run("simulate u.csv --plant stand-in.json -o y.csv --begin settled").ok();
    assert!(bench.text("y.csv").starts_with("t_s,u_V,y_um\n"));
    bench.run("timing --model model.json --path r.csv --plant stand-in.json").ok().prints(&["stand-in.json"]);
    let control = "control --model model.json --plant stand-in.json --reference sine:5 --controller feed-forward pi";
    bench.run(&format!("{control} --amplitude 800 --tolerance 0 --draws 4")).ok().prints(&["0 of 4"]);
}

/// A column of a record in CSV.
fn column(bench: &Bench, name: &str, column: usize) -> Vec<f64> {
    let text = bench.text(name);
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|row| row.split(',').nth(column).unwrap().parse().unwrap()).collect()
}

/// The same drive, measured over TCP and simulated without a controller.
#[test]
fn a_controller_around_the_records_measures_what_the_stand_in_does() {
    let bench = bench();
    bench.run("stand-in model.json --records sine5.csv sine20.csv prbs.csv -o .").ok();
    bench.run("excite sine --ts 5e-4 --duration 0.6 --frequency 5 --amplitude 20 -o u.csv").ok();
    bench.run("simulate u.csv --plant stand-in.json -o y.csv").ok();
    let of = |name: &str| bench.path(name).display().to_string();
    let records = ["sine5.csv", "sine20.csv", "prbs.csv"].map(of).join(" ");
    let around = [
        ("stand-in", format!("{} --plant records --records {records}", of("model.json"))),
        ("stand-in.json", format!("--plant {}", of("stand-in.json"))),
    ];
    for (name, options) in around {
        let controller = Controller::with(&options);
        bench.run(&format!("acquire u.csv --port {} --ramp 0.1 -o {name}.csv", controller.port())).ok();
        assert!(controller.text("*IDN?\n").contains(&format!("simulated controller with {name}, ")), "{name}");
        let (measured, expected) = (column(&bench, &format!("{name}.csv"), 2), column(&bench, "y.csv", 2));
        assert_eq!(measured.len(), expected.len());
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let aside = mean(&measured) - mean(&expected);
        let squares = measured.iter().zip(&expected).map(|(y, r)| (y - aside - r).powi(2));
        let (rms, (low, high)) = (
            mean(&squares.collect::<Vec<_>>()).sqrt(),
            expected.iter().fold((0.0_f64, 0.0_f64), |(low, high), y| (low.min(*y), high.max(*y))),
        );
        // The slew rate of the amplifier, and the noise.
        assert!(rms < 5e-3 * (high - low), "{name}: {rms} um of {} um", high - low);
        // Its voltages are those of the model, a twentieth beyond the records.
        let (least, most) = (column(&bench, "sine5.csv", 1), number(&bench.json("model.json")["identified"]["u"][1]));
        assert!(least.iter().all(|u| *u <= most), "{most}");
        let reported: f64 = controller.text("VMA? 1\n").trim().rsplit('=').next().unwrap().parse().unwrap();
        assert!(most < reported && reported < 1.11 * most, "{reported} V, records to {most} V");
    }
}

#[test]
fn a_campaign_is_rehearsed_on_a_stand_in_and_a_plan_says_what_its_drives_do_to_it() {
    let bench = Bench::new();
    for (name, signal) in [
        ("prbs", "prbs --duration 2.0475 --amplitude 0.5 --order 11"),
        ("rise4", "rising-sine --duration 2 --amplitude 28 --frequency 4"),
        ("rise12", "rising-sine --duration 2 --amplitude 28 --frequency 12"),
    ] {
        bench.run(&format!("excite {signal} --ts 1e-3 -o u.csv")).ok();
        bench.run(&format!("simulate u.csv --plant pl140 -o {name}.csv")).ok();
    }
    bench.run("identify rise4.csv rise12.csv --small-signal prbs.csv --operator preisach -o model.json").ok();
    let line = "campaign --bandwidth 12 --wait 2 --operator preisach --model model.json --plant records -o rehearsal";
    let run = bench.run(line).ok();
    run.prints(&["times smaller than with a straight line", "The page is"]).says(&["The stand-in is the model and "]);
    let found = bench.json("rehearsal/campaign.json");
    // 286 were measured.
    assert!(number(&found["better"]) > 100.0, "{}", found["better"]);
    let identity = found["identity"].as_str().unwrap();
    assert!(identity.starts_with("stand-in, simulated. The stand-in is the model and "), "{identity}");

    let plan = "plan --bandwidth 12 --model model.json --plant records -o next --json plan.json";
    let run = bench.run(plan).ok();
    run.prints(&["displacement [um]", "vibration [um]", "On stand-in, the slowest sine moves by "]);
    let rehearsal = &bench.json("plan.json")["rehearsal"];
    let resonance = number(&rehearsal["resonance_hz"]);
    // The mode of the twin is at 166 Hz.
    assert!((160.0..172.0).contains(&resonance) && rehearsal["drives"].as_array().unwrap().len() == 6, "{rehearsal}");
    assert!(bench.text("next/plan.md").contains("## Rehearsal"));
}

#[test]
fn a_plant_that_does_not_fit_the_other_options_is_refused_by_its_flag() {
    let bench = bench();
    for (line, says) in [
        ("instrument --port 0 --plant records", "--plant records needs the model"),
        ("instrument model.json --port 0", "model.json has no effect without --plant records"),
        ("instrument --port 0 --records sine5.csv", "--records has no effect without --plant records"),
        ("plan --bandwidth 20 --plant records -o next", "--plant records needs the model"),
        ("plan --bandwidth 20 --range 0 9 --records sine5.csv -o next", "--records has no effect without"),
        ("campaign --bandwidth 20 -o c --plant records", "--plant records needs the model"),
        ("campaign --bandwidth 20 -o c --plant paper --model model.json", "has no effect without --plant records"),
        ("campaign --bandwidth 20 -o c --plant paper --host 10.0.0.1", "--host 10.0.0.1: has no effect on a simulated"),
    ] {
        bench.misused(line).says(&[says]);
    }
    bench.run("campaign --bandwidth 20 -o c --model model.json").exits(2).says(&["--plant <NAME|FILE|records>"]);
}

#[test]
fn what_a_stand_in_cannot_be_made_of_is_an_error() {
    let bench = bench();
    let line = "compensate r.csv --model model.json -o u.csv --plant records";
    bench
        .refused(&format!("{line} --records sine5.csv sine20.csv"))
        .says(&["the model was identified from prbs.csv", "give this file as well"]);
    let line = "control --model model.json --reference sine:5 --plant";
    bench.misused(&format!("{line} paper --records sine5.csv")).says(&["--records has no effect without"]);
    bench.write("stand-in.json", r#"{"stand_in": {"share": 1}}"#);
    bench.refused(&format!("{line} stand-in.json")).says(&["stand-in.json", "no stand-in"]);
    bench.refused("instrument --port 0 --plant stand-in.json").says(&["stand-in"]);
}
