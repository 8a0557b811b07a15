//! A stand-in for the actuator of a model, in place of a twin.

use crate::bench::{Bench, number};
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
