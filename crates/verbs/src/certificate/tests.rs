use super::*;
use crate::DataFile;
use crate::identification::IdentifyOptions;
use piezoid_models::hysteresis::Proportional;
use piezoid_models::linear::Arx;
use piezoid_numerics::progress::Stage;
use piezoid_numerics::series::mean;
use piezoid_records::formats::ColumnSelection;
use piezoid_testing::{assert_close, noise};
use piezoid_validation::ValidateOptions;
use std::f64::consts::TAU;
use std::sync::Arc;

const TS: f64 = 1e-3;
const N: usize = 4000;

/// A gain of 2 um/V.
fn model() -> Model {
    let gain = Proportional::new(TS, 2.0).unwrap();
    Model::new(Arc::new(gain), Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap()
}

fn wave(hz: f64) -> Vec<f64> {
    (0..N).map(|t| 10.0 * (TAU * hz * t as f64 * TS).sin()).collect()
}

/// A record of this frequency, with an error of the gain, an offset and noise.
fn record(hz: f64, gain: f64, offset: f64, sigma: f64) -> (String, Record, Origin) {
    let u = wave(hz);
    let y = u.iter().zip(noise(hz as u64, N)).map(|(u, e)| gain * u + offset + sigma * e).collect();
    (format!("{hz}Hz.csv"), Record::new(TS, u, y).unwrap(), Origin::of("r.csv", format!("{hz}")))
}

fn certified(options: &CertificateOptions, records: Vec<(String, Record, Origin)>) -> Certificate {
    options.on(&model(), "", records).unwrap()
}

fn row<'a>(budget: &'a Budget, source: &str) -> &'a Contribution {
    budget.rows.iter().find(|row| row.source == source).unwrap_or_else(|| panic!("{source} in {budget:?}"))
}

#[test]
fn the_error_of_the_model_the_noise_and_the_mean_error_are_apart_and_each_counts_once() {
    let found = certified(&CertificateOptions::default(), vec![record(5.0, 2.02, 0.1, 0.05)]);
    let budget = &found.records[0].budget;
    // 0.02 x 10 / sqrt(2), the noise, and the offset.
    let expected = [0.2 / 2f64.sqrt(), 0.05, 0.1];
    let rows = ["error of the model", "noise", "mean error"].map(|source| row(budget, source).contribution);
    assert_close(&rows, &expected, 0.05, 0.0);
    assert_close(&[budget.standard], &[found.records[0].compared.validation.metrics.rmse], 1e-6, 0.0);
    assert_close(&[found.records[0].independent], &[2.0], 0.4, 0.0);
    assert!(budget.k > 2.5, "an error that is one sine has little information: {}", budget.k);
    assert_eq!(found.within_percent(), 100.0);
}

#[test]
fn the_uncertainty_is_that_of_the_worst_record_and_not_an_average() {
    let options = CertificateOptions { noise: NoiseOrigin::Sensor, ..CertificateOptions::default() };
    let (good, bad) = (record(5.0, 2.001, 0.0, 0.01), record(80.0, 2.05, 0.0, 0.01));
    let both = certified(&options, vec![good.clone(), bad.clone()]);
    let [one, other] = [good, bad].map(|record| certified(&options, vec![record]));
    assert!(one.expanded < 0.1 * other.expanded);
    assert!(both.expanded >= other.expanded, "{} {}", both.expanded, other.expanded);
    assert!(both.remarks.iter().any(|remark| remark.contains("probability of 1/3")), "{:?}", both.remarks);
}

#[test]
fn an_error_at_one_frequency_of_a_record_is_not_averaged_away() {
    // 3.6 s of 5 Hz, then 0.4 s of 50 Hz, where the gain is wrong.
    let hz = |t: usize| if t < 3600 { 5.0 } else { 50.0 };
    let u: Vec<f64> = (0..N).map(|t| 10.0 * (TAU * hz(t) * t as f64 * TS).sin()).collect();
    let gain = |t: usize| if t < 3600 { 2.0 } else { 2.1 };
    let y: Vec<f64> = (0..N).zip(noise(1, N)).map(|(t, e)| gain(t) * u[t] + 0.01 * e).collect();
    let record = Record::new(TS, u, y).unwrap();
    let found = certified(&CertificateOptions::default(), vec![("steps.csv".into(), record, Origin::default())]);
    let (worst, _) = found.worst();
    assert_eq!((found.bands.len(), worst.as_str()), (2, "44.67 to 56.23 Hz"));
    assert!(found.expanded > 2.0 * found.records[0].compared.validation.metrics.rmse, "{}", found.expanded);
}

#[test]
fn what_is_stated_is_in_the_budget_with_its_sensitivity_and_what_is_not_is_listed() {
    let text = |text: &str| Some(text.to_string());
    let options = CertificateOptions {
        sensor_calibration: Some(0.5),
        sensor_linearity: text("30nm"),
        resolution: text("0.01"),
        temperature_coefficient: text("0.1%"),
        temperature_half_width: Some(3.0),
        voltage_gain: Some(0.2),
        voltage_offset: Some(0.05),
        ..CertificateOptions::default()
    };
    let found = certified(&options, vec![record(5.0, 2.02, 0.0, 0.05)]);
    let budget = &found.records[0].budget;
    let of = |source: &str| row(budget, source).contribution;
    // 20 um at most, of the model.
    assert_close(&[of("calibration of the sensor")], &[20.0 * 0.0025], 1e-6, 0.0);
    assert_close(&[of("linearity of the sensor")], &[0.03 / 3f64.sqrt()], 1e-12, 0.0);
    assert_close(&[of("temperature")], &[20.0 * 0.001 * 3.0 / 3f64.sqrt()], 1e-6, 0.0);
    assert_close(&[of("gain of the voltage")], &[20.0 * 0.001], 1e-6, 0.0);
    assert_close(&[of("offset of the voltage")], &[2.0 * 0.05 / 3f64.sqrt()], 1e-6, 0.0);
    assert_eq!((of("resolution"), row(budget, "resolution").sensitivity), (0.0, 0.0), "the noise contains it");
    assert_eq!(found.not_stated, ["drift after the records"]);
}

#[test]
fn noise_of_the_sensor_alone_is_listed_and_does_not_count() {
    let options = CertificateOptions { noise: NoiseOrigin::Sensor, ..CertificateOptions::default() };
    let found = certified(&options, vec![record(5.0, 2.02, 0.0, 0.05)]);
    let noise = row(&found.records[0].budget, "noise");
    assert_close(&[noise.value], &[0.05], 0.05, 0.0);
    assert_eq!((noise.contribution, noise.share_percent), (0.0, 0.0));
}

#[test]
fn a_correction_takes_the_mean_error_and_leaves_its_spread() {
    let options = CertificateOptions { mean_error: MeanError::Corrected, ..CertificateOptions::default() };
    let records = || [0.9, 1.0, 1.1].iter().zip([5.0, 8.0, 12.0]).map(|(b, hz)| record(hz, 2.0, *b, 0.05)).collect();
    let corrected = certified(&options, records());
    assert_close(&[corrected.correction.unwrap()], &[1.0], 0.01, 0.0);
    let spread = row(&corrected.records[0].budget, "correction of the mean error");
    assert_close(&[spread.contribution], &[0.1 * (4.0f64 / 3.0).sqrt()], 0.03, 0.0);
    assert_eq!(spread.degrees_of_freedom, Some(2.0));
    let included = certified(&CertificateOptions::default(), records());
    assert!(included.expanded > 3.0 * corrected.expanded && included.correction.is_none());
    let free = ValidateOptions { offset: Offset::Free, ..ValidateOptions::default() };
    let free = certified(&CertificateOptions { validation: free, ..CertificateOptions::default() }, records());
    assert!(free.expanded < corrected.expanded && free.measurand().contains("a constant offset is not a part"));
    assert!(free.records[0].budget.rows.iter().all(|row| row.source != "mean error"));
}

#[test]
fn the_stated_uncertainty_covers_the_true_displacement_of_further_records() {
    // The error of a gain and of a cubic term, of amplitudes and frequencies that differ from record to record.
    let options = CertificateOptions { noise: NoiseOrigin::Sensor, ..CertificateOptions::default() };
    let truth = |u: f64| 2.01 * u + 2e-4 * u.powi(3);
    let records = [5.0, 9.0, 17.0].map(|hz| {
        let u = wave(hz);
        let y = u.iter().zip(noise(hz as u64, N)).map(|(u, e)| truth(*u) + 0.05 * e).collect();
        (format!("{hz}.csv"), Record::new(TS, u, y).unwrap(), Origin::default())
    });
    let found = certified(&options, records.into());
    let others = [(4.0, 7.0), (30.0, 10.0), (11.0, 3.0)];
    let within = others.map(|(hz, amplitude)| {
        let u = wave(hz).iter().map(|u| 0.1 * amplitude * u).collect::<Vec<_>>();
        let inside = |u: &f64| f64::from((truth(*u) - 2.0 * u).abs() <= found.expanded);
        mean(&u.iter().map(inside).collect::<Vec<_>>())
    });
    assert!(within.iter().all(|share| *share >= 0.9545), "{within:?} {}", found.expanded);
}

/// A record of a gain of 2 um/V as a file.
fn file(name: &str, hz: f64) -> DataFile {
    let row = |t: i32| {
        let u = 10.0 * (TAU * hz * f64::from(t) * TS).sin();
        format!("{},{u},{}\n", TS * f64::from(t), 2.0 * u + 0.01 * f64::from(t * 7919 % 13 - 6))
    };
    File::new(name, format!("t_s,u_V,y_um\n{}", (0..2000).map(row).collect::<String>())).into()
}

fn from_file(name: &str, hz: f64, from: Option<f64>, to: Option<f64>) -> Vec<Source> {
    Source::all(vec![file(name, hz)], &ColumnSelection { from, to, ..ColumnSelection::default() })
}

/// The file of a model of the first second of a record.
fn identified() -> File {
    let options = IdentifyOptions { operator: "proportional".into(), order: Some(0), ..IdentifyOptions::default() };
    let data = (Vec::new(), from_file("a.csv", 4.0, None, Some(1.0)));
    let found = options.run(data, "a program", &mut Stage::ignore).unwrap().found.model;
    File::new("model.json", found.to_json())
}

#[test]
fn training_records_are_refused_and_other_parts_of_their_files_are_remarked() {
    let model = identified();
    let run = |data| CertificateOptions::default().run(&model, data);
    for (from, to) in [(None, None), (Some(0.5), None), (None, Some(0.2))] {
        let error = run(from_file("renamed.csv", 4.0, from, to)).unwrap_err().to_string();
        assert!(error.starts_with("renamed.csv: the model was identified from this record"), "{error}");
    }
    let rest = run(from_file("a.csv", 4.0, Some(1.0), None)).unwrap();
    assert!(rest.remarks.iter().any(|remark| remark.contains("another part of a file")), "{:?}", rest.remarks);
    let other = run(from_file("b.csv", 9.0, None, None)).unwrap();
    assert!(other.remarks.iter().all(|remark| !remark.contains("its issuer")), "{:?}", other.remarks);
    assert_eq!(other.model_sha256, sha256(&model.bytes));
    assert_eq!(other.records[0].origin.sha256, file("b.csv", 9.0).sha256().unwrap());
}

#[test]
fn the_same_input_gives_the_same_number_and_another_record_another_one() {
    let model = identified();
    let run = |hz| CertificateOptions::default().run(&model, from_file("b.csv", hz, None, None)).unwrap();
    assert_eq!((run(9.0).number(), run(9.0).to_json()), (run(9.0).number(), run(9.0).to_json()));
    assert_ne!(run(9.0).number(), run(8.0).number());
    let stated = CertificateOptions { number: Some("7".into()), ..CertificateOptions::default() };
    assert_eq!(stated.run(&model, from_file("b.csv", 9.0, None, None)).unwrap().number(), "7");
}

#[test]
fn units_that_do_not_fit_are_refused() {
    let units = |u: &str, y: &str| Units { u: u.into(), y: y.into() };
    let of = |own: Units, units: Units| {
        let (name, record, origin) = record(5.0, 2.0, 0.0, 0.05);
        let records = vec![(name, record.with_units(units), origin)];
        CertificateOptions::default().on(&model().with_units(own), "", records).unwrap_err().to_string()
    };
    let other = of(units("V", "um"), units("V", "counts"));
    assert!(other.contains("the output of the record is in counts, but um is needed"), "{other}");
    let input = of(units("V", "um"), units("A", "um"));
    assert!(input.contains("the input of the record is in A"), "{input}");
    let no_length = of(units("V", "counts"), units("V", "counts"));
    assert!(no_length.contains("a certificate states a displacement; the output is in counts"), "{no_length}");
    let none = CertificateOptions::default().on(&model(), "", Vec::new()).unwrap_err().to_string();
    assert!(none.contains("needs one or more records"), "{none}");
}

#[test]
fn records_that_are_too_short_or_too_large_are_refused() {
    let of = |n: usize, scale: f64| {
        let u: Vec<f64> = wave(5.0)[..n].to_vec();
        let y = u.iter().map(|u| scale * u).collect();
        let records = vec![("a.csv".into(), Record::new(TS, u, y).unwrap(), Origin::default())];
        CertificateOptions::default().on(&model(), "", records).unwrap_err().to_string()
    };
    let short = of(99, 2.0);
    assert!(short.starts_with("a.csv: the record has 99 samples, but at least 100 are needed"), "{short}");
    let large = of(1000, 1e200);
    assert!(large.contains("the squares of the errors are not finite"), "{large}");
}
