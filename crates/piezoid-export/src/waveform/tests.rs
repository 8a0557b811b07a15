//! The files, read back as a controller reads them.

use super::*;
use crate::Model;
use piezoid::compensation::FeedForwardSettings;
use piezoid::creep::Creep;
use piezoid::excitation::Limits;
use piezoid::hysteresis::Operator;
use piezoid::linear::Arx;
use piezoid::record::Units;
use piezoid_testing::assert_close;
use std::f64::consts::TAU;

const TS: f64 = 5e-4;

/// A model with creep and a resonance; its unit of displacement is `micrometres` long.
fn model(name: &str, unit: &str, micrometres: f64) -> Model {
    let b = [0.0, 3.0, 2.8].map(|b| b / micrometres).to_vec();
    let block = Arx::new(TS, vec![1.7424, -0.9453], b).unwrap();
    let model = Model::new((Operator::find(name).unwrap().example)(TS).unwrap(), block, 2.0 / micrometres).unwrap();
    let creeping = model.with_creep(Creep::logarithmic(TS, 0.01, 0.1, 10.0).unwrap()).unwrap();
    creeping.with_units(Units { u: "V".into(), y: unit.into() })
}

fn sine(n: usize, height: f64) -> Vec<f64> {
    (0..n).map(|t| height * (TAU * t as f64 / n as f64).sin()).collect()
}

fn limits() -> FeedForwardSettings {
    let limits = Limits { low: Some(-25.0), high: Some(25.0), ..Default::default() };
    FeedForwardSettings { limits, ..Default::default() }
}

fn result(model: &Model, r: &[f64]) -> Exported {
    make(&ExportRequest { reference: Some(r), settings: limits(), ..ranged(model) }).unwrap()
}

fn ranged(model: &Model) -> ExportRequest<'_> {
    let options = ExportOptions { name: "scan".into(), range: Some((-30.0, 120.0)), ..Default::default() };
    ExportRequest { options, ..ExportRequest::new(model, "scan") }
}

fn text<'m>(result: &'m Exported, path: &str) -> &'m str {
    std::str::from_utf8(&result.files.iter().find(|f| f.name == path).unwrap().bytes).unwrap()
}

fn column(csv: &str, number: usize) -> Vec<f64> {
    csv.lines().skip(1).map(|line| line.split(',').nth(number).unwrap().parse().unwrap()).collect()
}

/// Points [V] and the time for which each is held [s], as the controller reads the commands.
fn played(commands: &str) -> (Vec<f64>, f64) {
    let (mut points, mut cycles) = (Vec::new(), 0.0);
    for line in commands.lines() {
        let words: Vec<&str> = line.split([' ', ',']).collect();
        match words[..] {
            ["WAV", "1", settings, "PNT", first, count, ..] => {
                assert_eq!(settings == "X", points.is_empty());
                assert_eq!((first.parse(), count.parse()), (Ok(points.len() + 1), Ok(words.len() - 6)));
                points.extend(words[6..].iter().map(|v| v.parse::<f64>().unwrap()));
            }
            ["gbarb", index, percent] => {
                assert_eq!(index.parse(), Ok(points.len()));
                points.push(-30.0 + 1.5 * percent.parse::<f64>().unwrap());
            }
            ["WTR", "1", k, "0"] | ["gtarb", k] => cycles = k.parse().unwrap(),
            ["gearb", last] => assert_eq!(last.parse(), Ok(points.len() - 1)),
            _ => {}
        }
    }
    (points, cycles * 5e-5)
}

/// The errors of a file by the page: period, u rms and largest, y rms and largest, all in percent.
fn stated(result: &Exported, file: &str) -> Vec<f64> {
    let row = text(result, "scan.md").lines().find(|l| l.starts_with(&format!("| `{file}`"))).unwrap().to_string();
    row.split('|').skip(5).filter_map(|cell| cell.trim().parse().ok()).collect()
}

/// Rms and largest error of `x` in percent of the stroke of `of`.
fn share(x: &[f64], of: &[f64]) -> [f64; 2] {
    let (low, high) = ends(of.iter().copied());
    let off = x.iter().zip(of).map(|(x, of)| x - of);
    let rms = (off.clone().map(|e| e * e).sum::<f64>() / x.len() as f64).sqrt();
    [rms, off.map(f64::abs).fold(0.0, f64::max)].map(|e| 100.0 * e / (high - low))
}

#[test]
fn the_stated_errors_are_those_of_the_files_when_played() {
    for (name, n) in [("prandtl-ishlinskii", 120), ("preisach", 2200), ("prandtl-ishlinskii", 1999)] {
        let (model, r) = (model(name, "um", 1.0), sine(n, 400.0));
        let result = result(&model, &r);
        // The voltage with 0.1 mV, forty times per cycle of 50 us.
        let u = column(text(&result, "scan.csv"), 1);
        let fine =
            |t: usize, of: f64, points: &[f64]| points[((t as f64 + 0.5) * 1.25e-6 / of) as usize % points.len()];
        for file in ["scan_gcs.txt", "scan_nv200.txt"] {
            let (points, held) = played(text(&result, file));
            let says = stated(&result, file);
            let period = points.len() as f64 * held;
            assert_close(&[says[0]], &[100.0 * (period / (n as f64 * TS) - 1.0)], 1e-3, 1e-9);
            // Compared at equal phase.
            let samples = n * 400;
            let slower = period / (n as f64 * TS);
            let both: (Vec<f64>, Vec<f64>) =
                (0..samples).map(|t| (fine(t, held / slower, &points), fine(t, TS, &u))).unzip();
            let lost = share(&both.0, &both.1);
            assert_close(&says[1..3], &lost, 0.02, 1e-3);
            // The response of the model, after creep of 10 s has settled.
            let observed: Vec<f64> = both.0.chunks(400).map(|sample| sample.iter().sum::<f64>() / 400.0).collect();
            let mut x = model.settled(observed[0]);
            (0..400_000 / n).for_each(|_| drop(model.resume(&mut x, &observed)));
            assert_close(&says[3..5], &share(&model.resume(&mut x, &observed), &r), 0.05, 2e-4);
        }
    }
}

#[test]
fn nothing_is_lost_if_samples_are_whole_cycles() {
    let result = result(&model("preisach", "um", 1.0), &sine(200, 400.0));
    for file in ["scan.csv", "scan_gcs.txt", "scan_nv200.txt"] {
        let says = stated(&result, file);
        // Rounding to 0.1 mV in 40 V.
        assert!(says[0] == 0.0 && says[2] < 1e-3 && says[4] < 0.01, "{file}: {says:?}");
    }
    let csv = text(&result, "scan.csv");
    assert!(csv.starts_with("t_s,u_V,r_um,y_um\n0.0000,"));
    assert!(share(&column(csv, 3), &column(csv, 2))[1] < 0.01);
    assert_eq!(played(text(&result, "scan_gcs.txt")).0, column(csv, 1));
}

#[test]
fn a_model_in_metres_gives_the_same_voltages() {
    let micrometres = result(&model("prandtl-ishlinskii", "um", 1.0), &sine(100, 400.0));
    let r: Vec<f64> = sine(100, 400.0).iter().map(|r| r * 1e-6).collect();
    let metres = result(&model("prandtl-ishlinskii", "m", 1e6), &r);
    let [um, m] = [&micrometres, &metres].map(|result| text(result, "scan.csv"));
    assert!(m.starts_with("t_s,u_V,r_m,y_m\n"));
    assert_close(&column(m, 1), &column(um, 1), 0.0, 1.01e-4);
    let scaled: Vec<f64> = column(um, 3).iter().map(|y| y * 1e-6).collect();
    assert_close(&column(m, 3), &scaled, 0.0, 3e-9);
}

#[test]
fn every_table_stays_within_the_limits() {
    // A triangle above the slew limit.
    let r: Vec<f64> = (0..1500).map(|t| 400.0 - 1.6 * (f64::from(t % 1500) - 750.0).abs()).map(|r| r * 0.6).collect();
    let limits = Limits { low: Some(-25.0), high: Some(25.0), slew: Some(45.0), ..Default::default() };
    let settings = FeedForwardSettings { limits, clip: true, ..Default::default() };
    let model = model("prandtl-ishlinskii", "um", 1.0);
    let result = make(&ExportRequest { reference: Some(&r), settings, ..ranged(&model) }).unwrap();
    for file in ["scan_gcs.txt", "scan_nv200.txt"] {
        let (points, held) = played(text(&result, file));
        // Rounding to 0.15 mV increases the slew.
        let usage = limits.check(&[points.as_slice(), &points[..1]].concat(), held).unwrap();
        assert!(usage.slew.value < 45.0 + 1.5e-4 / held && usage.slew.value > 40.0, "{file}: {usage:?}");
    }
    let strict = ExportRequest {
        reference: Some(&r),
        settings: FeedForwardSettings { limits, ..Default::default() },
        ..ExportRequest::new(&model, "scan")
    };
    assert!(make(&strict).unwrap_err().to_string().starts_with("the drive exceeds its limits: slew"));
}

#[test]
fn without_a_range_a_note_replaces_the_file_in_percent() {
    let (model, r) = (model("prandtl-ishlinskii", "um", 1.0), sine(100, 100.0));
    let result =
        make(&ExportRequest { reference: Some(&r), settings: limits(), ..ExportRequest::new(&model, "scan") }).unwrap();
    let paths: Vec<&str> = result.files.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(paths, ["scan.csv", "scan_gcs.txt", "scan.md"]);
    assert!(result.notes.iter().any(|note| note.contains("with the voltages of 0 % and 100 %")), "{:?}", result.notes);
    assert!(!text(&result, "scan.md").contains("nv200"));
}

#[test]
fn requests_without_a_table_are_errors() {
    let (model, r) = (model("prandtl-ishlinskii", "um", 1.0), sine(100, 100.0));
    let plain = || ExportRequest { reference: Some(&r), settings: limits(), ..ExportRequest::new(&model, "scan") };
    let text = |request: ExportRequest| make(&request).unwrap_err().to_string();
    assert!(text(ExportRequest { reference: None, ..plain() }).starts_with("reference = none: must be given"));
    let single = ExportOptions { float: true, ..Default::default() }.of("waveform", &model, Some(&r), None);
    assert!(
        single.unwrap_err().to_string().starts_with("float = true: does not apply to the target waveform, only to c,")
    );
    let c = ExportOptions::default().of("c", &model, Some(&r), None);
    assert!(c.unwrap_err().to_string().ends_with("does not apply to the target c, only to waveform"));
    let options = ExportOptions { name: "9".into(), ..Default::default() };
    assert!(text(ExportRequest { options, ..plain() }).starts_with("name = `9`"));
    let far = sine(100, 1e5);
    assert!(text(ExportRequest { reference: Some(&far), ..plain() }).starts_with("the reference cannot be reached"));
    assert!(
        text(ExportRequest { reference: Some(&r[..60]), ..plain() })
            .contains("the step from the last sample to the first must not exceed")
    );
    let options = ExportOptions { servo_cycle: 0.0, ..Default::default() };
    assert!(text(ExportRequest { options, ..plain() }).starts_with("servo_cycle = 0"));
    let millivolts = model.clone().with_units(Units { u: "mV".into(), y: "um".into() });
    let settings = FeedForwardSettings::default();
    assert!(text(ExportRequest { model: &millivolts, settings, ..plain() }).contains("the model's input is in mV"));
}

#[test]
fn the_same_model_and_reference_give_the_same_bytes() {
    let (model, r) = (model("preisach", "um", 1.0), sine(150, 300.0));
    assert_eq!(result(&model, &r), result(&model, &r));
}
