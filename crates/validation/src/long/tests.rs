use super::*;
use crate::Validate;
use piezoid_models::hysteresis::OPERATORS;
use piezoid_models::linear::Arx;
use piezoid_numerics::system::System;
use piezoid_records::excitation::Prbs;
use piezoid_records::formats::{ColumnSelection, Opened, Table};
use piezoid_records::record::Units;
use piezoid_testing::{assert_alike, assert_close, noise};
use std::f64::consts::TAU;
use std::io::{Cursor, Read};
use std::sync::Arc;

const TS: f64 = 5e-4;
const N: usize = 6000;
/// Most samples that are held.
const HELD: usize = 2600;

/// A sine that rises from cycle to cycle.
fn sine() -> Vec<f64> {
    (0..N).map(|t| (8.0 + 3e-3 * t as f64) * (TAU * 12.0 * t as f64 * TS).sin()).collect()
}

fn prbs() -> Vec<f64> {
    Prbs { order: 13, amplitude: 3.0, ..Prbs::default() }.samples(TS, N).unwrap()
}

fn model(operator: &str) -> Model {
    let operator = OPERATORS.iter().find(|row| row.name == operator).unwrap();
    let beam = Arx::new(TS, vec![1.7424, -0.9453], vec![3.4, 3.3]).unwrap();
    let model = Model::new((operator.example)(TS).unwrap(), beam, 0.0).unwrap();
    model.with_identified(Domain::of_input(&sine()[..2000], TS))
}

/// The output of a model for an input, with another gain, noise and a drift.
fn output(model: &Model, u: &[f64]) -> Vec<f64> {
    let samples = model.simulate(u).into_iter().zip(noise(4, N)).enumerate();
    samples.map(|(t, (y, e))| 1.03 * y + 0.5 * e + 4.0 + 3e-4 * t as f64).collect()
}

/// The results on a file, and what is known of its record from reading it in pieces.
fn both(
    model: &Model,
    (u, y, unit): (&[f64], &[f64], &str),
    options: &ValidateOptions,
) -> (Validation, (Validation, Domain, Record)) {
    let factor = Units::factor("um", unit).unwrap();
    let y: Vec<f64> = y.iter().map(|y| factor * y).collect();
    let bytes: Arc<[u8]> = Table::write("r.csv", TS, &[("u_V", u), (&format!("y_{unit}"), &y)]).unwrap().into();
    let record = Table::parse(&bytes).unwrap().record(&ColumnSelection::default()).unwrap();
    let open = || Ok(Box::new(Cursor::new(bytes.clone())) as Box<dyn Read>);
    let Opened::Long(long) = LongRecord::open("r.csv", &open, &ColumnSelection::default(), HELD).unwrap() else {
        panic!("it is held")
    };
    (model.validate_with(&record, options).unwrap(), Validation::of_long(model, &long, options).unwrap())
}

/// A result without what each section has for itself: noise, and the spectra of an input without cycles.
fn without_sections(validation: &Validation, has_cycles: bool) -> Validation {
    let bins = |bins: &[Bin]| bins.iter().map(|bin| bin.above(None)).collect();
    Validation {
        simulated: Vec::new(),
        floor: None,
        summary: None,
        advice: None,
        by_frequency: if has_cycles { bins(&validation.by_frequency) } else { Vec::new() },
        by_amplitude: bins(&validation.by_amplitude),
        ..validation.clone()
    }
}

#[test]
fn a_record_in_sections_has_the_figures_of_the_whole() {
    let model = model("prandtl-ishlinskii");
    for (u, has_cycles) in [(sine(), true), (prbs(), false)] {
        let y = output(&model, &u);
        for offset in [Offset::Kept, Offset::Free, Offset::Drift] {
            for (skip, unit) in [(0.0, "um"), (0.2, "mm")] {
                let options = ValidateOptions { skip, offset };
                let (mut whole, (sections, domain, first)) = both(&model, (&u, &y, unit), &options);
                assert!(sections.simulated.is_empty());
                let [a, b] = [&whole, &sections].map(|validation| validation.floor.unwrap().rms);
                assert_close(&[b], &[a], 0.1, 0.0);
                assert!(!sections.by_frequency.is_empty() && sections.summary.is_some());
                assert_eq!(sections.by_amplitude.is_empty(), !has_cycles);
                // The band of a PRBS is that of a section.
                let band = |remark: &String| !remark.starts_with("the input has power");
                whole.remarks.retain(band);
                let sections =
                    Validation { remarks: sections.remarks.clone().into_iter().filter(band).collect(), ..sections };
                let [expected, found] = [&whole, &sections].map(|v| format!("{:?}", without_sections(v, has_cycles)));
                assert_alike(&found, &expected, 1e-9, 5e-10);
                let start = (skip / TS) as usize;
                let of_input = Domain::of_input(&u[start..], TS);
                assert_close(&domain.u, &of_input.u, 0.0, 0.0);
                assert_close(&[domain.slew, domain.mean[0]], &[of_input.slew, of_input.mean[0]], 1e-9, 1e-12);
                assert_eq!((first.u(), first.ts(), &*first.units().y), (&u[..1000], TS, unit));
            }
        }
    }
}

#[test]
fn a_section_that_oscillates_faster_than_the_model_knows_is_remarked() {
    let model = model("rate-scheduled");
    // From 12 Hz to 120 Hz, of which the last two of five sections lie beyond the 80 Hz of its branches.
    let phase = |t: f64| TAU * (12.0 * t + 18.0 * t * t);
    let u: Vec<f64> = (0..N).map(|t| 20.0 * phase(t as f64 * TS).sin()).collect();
    let (whole, (sections, ..)) = both(&model, (&u, &output(&model, &u), "um"), &ValidateOptions::default());
    let oscillates = |validation: &Validation, at: &str| validation.remarks.iter().any(|r| r.starts_with(at));
    let at = "the input oscillates at ";
    // The cycles of the whole have 65 Hz in the mean.
    assert!(!oscillates(&whole, at) && oscillates(&sections, &format!("{at}89.")), "{:?}", sections.remarks);
}

#[test]
fn a_defect_of_a_section_is_remarked_with_its_section() {
    let (model, u) = (model("prandtl-ishlinskii"), sine());
    let mut y = model.simulate(&u);
    y[3000] += 900.0;
    let (_, (found, ..)) = both(&model, (&u, &y, "um"), &ValidateOptions::default());
    let place = "the output has outliers: 1 sample (at 0.3 s)";
    let section = "(in the section from 1.2 s to 1.8 s, with times from its start)";
    assert!(found.remarks.iter().any(|r| r.starts_with(place) && r.ends_with(section)), "{:?}", found.remarks);
}
