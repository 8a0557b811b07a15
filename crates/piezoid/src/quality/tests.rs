use super::*;
use crate::excitation::{EXCITATIONS, Prbs, Sine};
use crate::plant::{PLANTS, Plant};

const TS: f64 = 5e-4;

fn drive(excitation: &crate::excitation::Excitation, amplitude: f64) -> Vec<f64> {
    let value = |row: crate::OptionRow| match row.name {
        "amplitude" => Some(("amplitude", amplitude)),
        "frequency_start" | "frequency_low" => Some((row.name, 3.0)),
        "frequency_end" | "frequency_high" => Some((row.name, 200.0)),
        name if row.required => Some((name, 7.0)),
        _ => None,
    };
    excitation.samples(TS, 2.0, (excitation.rows)().into_iter().filter_map(value).collect()).unwrap()
}

fn run(plant: &str, u: &[f64]) -> crate::plant::PlantRun {
    Plant::named(plant, TS).unwrap().run(u)
}

fn measured(plant: &str, u: Vec<f64>) -> Record {
    let y = run(plant, &u).y.iter().map(|y| 1e6 * y).collect();
    Record::new(TS, u, y).unwrap()
}

fn sine(amplitude: f64, hz: f64, n: usize) -> Vec<f64> {
    Sine { amplitude, frequency: hz, ..Sine::default() }.samples(TS, n).unwrap()
}

fn with(record: &Record, change: impl Fn(usize, f64) -> f64) -> Record {
    let y = record.y().iter().enumerate().map(|(t, y)| change(t, *y)).collect();
    Record::new(TS, record.u().to_vec(), y).unwrap()
}

fn found(record: &Record) -> Vec<Defect> {
    inspect(record, &Need::default()).findings.iter().map(|f| f.defect).collect()
}

/// Valid records of several plants and excitations.
fn sound() -> Vec<(String, Record)> {
    let excitations = [("prbs", 1.0), ("sine", 28.0), ("rising-sine", 28.0), ("staircase", 28.0), ("triangle", 28.0)];
    let record = |plant: &str, (name, amplitude): (&str, f64)| {
        let u = drive(crate::excitation::Excitation::find(name).unwrap(), amplitude);
        (format!("{plant} {name}"), measured(plant, u))
    };
    ["paper", "pl140", "pl112"].iter().flat_map(|plant| excitations.map(|e| record(plant, e))).collect()
}

#[test]
fn only_a_clipped_sensor_is_reported_for_all_excitations_and_plants() {
    let mut alarms = Vec::new();
    for plant in PLANTS {
        for excitation in EXCITATIONS {
            for amplitude in [1.0, 28.0] {
                let u = drive(excitation, amplitude);
                let clipped = run(plant.name, &u).saturation.sensor_clipped;
                let defects = found(&measured(plant.name, u));
                let right = if clipped > 0 { defects == [Defect::SaturatedOutput] } else { defects.is_empty() };
                if !right {
                    let record = format!("{} {} {amplitude} V", plant.name, excitation.name);
                    alarms.push(format!("{record}: {defects:?}, {clipped} clipped"));
                }
            }
        }
    }
    assert_eq!(alarms, Vec::<String>::new());
}

#[test]
fn exactly_the_spikes_are_masked() {
    for (name, record) in sound() {
        let (low, high) = ends(record.y().iter().copied());
        let spiked = |t: usize| [700, 1111, 2503].contains(&t);
        // With a PRBS and a fast plant every sample jumps by half of the range.
        let size = if name == "pl112 prbs" { 0.9 } else { 0.15 } * (high - low);
        let bad = with(&record, |t, y| if spiked(t) { y + size } else { y });
        let seen = inspect(&bad, &Need::default());
        assert_eq!(seen.findings.iter().map(|f| f.defect).collect::<Vec<_>>(), [Defect::Outliers], "{name}");
        let masked: Vec<usize> = (0..bad.len()).filter(|t| !seen.usable[*t]).collect();
        assert_eq!(masked, [700, 1111, 2503], "{name}");
        assert!(seen.findings[0].text.contains("3 samples in 3 places (the first at 0.35 s"), "{:?}", seen.findings);
    }
}

#[test]
fn a_saturated_output_is_masked_at_its_limit_with_noise_and_without() {
    for plant in ["paper", "pl140"] {
        let record = measured(plant, sine(28.0, 7.0, 4000));
        let clean = with(&record, |_, y| y.clamp(-700.0, 600.0));
        let noisy = with(&record, |t, y| y.clamp(-700.0, 600.0) + 0.5 * ((t * t) as f64).sin());
        for bad in [clean, noisy] {
            let seen = inspect(&bad, &Need::default());
            assert_eq!(found(&bad), [Defect::SaturatedOutput], "{plant}: {:?}", seen.findings);
            let wrong = (0..bad.len()).filter(|&t| {
                let inside = (-690.0..590.0).contains(&record.y()[t]);
                let beyond = !(-710.0..610.0).contains(&record.y()[t]);
                (inside && !seen.usable[t]) || (beyond && seen.usable[t])
            });
            assert!(wrong.count() < 20, "{plant}");
        }
    }
}

#[test]
fn a_clipped_input_is_reported_if_the_output_still_moves() {
    let whole = sine(28.0, 7.0, 4000);
    let record = measured("pl140", whole.clone());
    let clipped = Record::new(TS, whole.iter().map(|u| u.min(24.0)).collect(), record.y().to_vec()).unwrap();
    assert_eq!(found(&clipped), [Defect::ClippedInput]);
    // If the actuator itself is driven by the clipped input, the record is valid.
    assert_eq!(found(&measured("pl140", whole.iter().map(|u| u.min(24.0)).collect())), []);
}

#[test]
fn a_frozen_output_and_missing_rows_are_reported_with_their_times() {
    let record = measured("pl140", sine(28.0, 7.0, 4000));
    let frozen = with(&record, |t, y| if (1000..1050).contains(&t) { record.y()[1000] } else { y });
    let seen = inspect(&frozen, &Need::default());
    assert_eq!(seen.findings[0].defect, Defect::FrozenOutput, "{:?}", seen.findings);
    assert!(seen.findings[0].text.contains("50 samples (from 0.5 s to 0.5245 s)"), "{:?}", seen.findings);
    assert_eq!((seen.findings.len(), seen.masked()), (1, 50));

    let cut = |x: &[f64]| [&x[..1500], &x[1560..]].concat();
    let missing = Record::new(TS, cut(record.u()), cut(record.y())).unwrap();
    assert_eq!(found(&missing), [Defect::MissingRows]);
    assert!(!inspect(&missing, &Need::default()).usable[1500]);
}

#[test]
fn a_drift_is_reported_and_creep_is_not() {
    for (name, record) in sound() {
        let (low, high) = ends(record.y().iter().copied());
        let n = record.len() as f64;
        let drifts = with(&record, |t, y| y + 0.08 * (high - low) * t as f64 / n);
        let seen = inspect(&drifts, &Need::default());
        assert_eq!(found(&drifts), [Defect::Drift], "{name}: {:?}", seen.findings);
        assert!(seen.findings[0].text.contains("does not slow down"), "{name}: {:?}", seen.findings);
        assert_eq!(seen.masked(), 0);
        let creeps = with(&record, |t, y| y + 0.01 * (high - low) * (1.0 + t as f64).log10());
        assert_eq!(found(&creeps), [], "{name}: {:?}", inspect(&creeps, &Need::default()).findings);
    }
}

#[test]
fn a_record_with_a_fatal_defect_is_an_error() {
    let refused = |u: Vec<f64>, y: Vec<f64>| {
        inspect(&Record::new(TS, u, y).unwrap(), &Need::default()).sound().unwrap_err().to_string()
    };
    let u = sine(28.0, 7.0, 100);
    assert!(refused(vec![2.0; 100], u.clone()).contains("the input is constant at 2 V over all 100 samples"));
    assert!(refused(u.clone(), vec![7.0; 100]).contains("the output is constant at 7 um over all 100 samples"));
    assert!(refused(u[..9].to_vec(), u[..9].to_vec()).contains("has 9 samples, but at least 16 are needed"));
    assert_eq!(inspect(&Record::new(TS, u.clone(), u).unwrap(), &Need::default()).sound(), Ok(()));
}

#[test]
fn a_band_without_power_is_reported() {
    let need = Need { band_hz: Some((100.0, 200.0)), ..Need::default() };
    let slow = inspect(&measured("pl140", sine(28.0, 7.0, 4000)), &need);
    assert_eq!(slow.findings[0].defect, Defect::PoorExcitation);
    assert!(slow.findings[0].text.contains("from 100 to 200 Hz"), "{:?}", slow.findings);
    assert!(slow.sound().is_ok());
    assert_eq!(inspect(&measured("pl140", Prbs::default().samples(TS, 4094).unwrap()), &need).findings, []);
}

#[test]
fn noise_has_no_outliers() {
    let mut state = 1u64;
    let mut uniform = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let u = sine(28.0, 7.0, 40_000);
    // Sums of twelve uniform numbers are nearly normal.
    let y = u.iter().map(|u| 33.0 * u + 30.0 * (0..12).map(|_| uniform()).sum::<f64>()).collect();
    assert_eq!(found(&Record::new(TS, u, y).unwrap()), []);
}

#[test]
fn a_jump_of_one_sample_is_masked() {
    let u: Vec<f64> = (0..800).map(|t| (f64::from(t) * 0.02).sin()).collect();
    let mut y: Vec<f64> = u.iter().map(|u| 33.0 * u).collect();
    y[300] += 20.0;
    let seen = inspect(&Record::new(5e-4, u, y).unwrap(), &Need::default());
    assert_eq!((seen.findings[0].defect, seen.masked(), seen.usable[300]), (Defect::Outliers, 1, false));
}
