//! Validations that say the same as before, in numbers and in words.

use crate::{Linearity, Offset, Validate, ValidateOptions, Validation};
use piezoid_models::creep::Creep;
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_models::hysteresis::Operator;
use piezoid_models::linear::Arx;
use piezoid_numerics::system::System;
use piezoid_records::excitation::Prbs;
use piezoid_records::record::Record;
use piezoid_testing::{assert_kept, noise};
use std::f64::consts::TAU;

const TS: f64 = 5e-4;
const N: usize = 4000;

fn model(operator: &str, damping: f64) -> Model {
    let operator = (Operator::find(operator).unwrap().example)(TS).unwrap();
    let (radius, angle) = ((-damping * TAU * 146.7 * TS).exp(), TAU * 146.7 * TS);
    let beam = Arx::new(TS, vec![2.0 * radius * angle.cos(), -radius * radius], vec![3.4, 3.3]).unwrap();
    let known: Vec<f64> = (0..N).map(|t| 20.0 * (TAU * 11.0 * t as f64 * TS).sin()).collect();
    Model::new(operator, beam, 2.0).unwrap().with_identified(Domain::of_input(&known, TS))
}

/// An input, and the output of this model with noise and what else is added to it.
fn record(of: &Model, seed: u64, u: Vec<f64>, more: impl Fn(f64) -> f64) -> Record {
    let y = of.simulate(&u).into_iter().zip(noise(seed, u.len())).enumerate();
    let y = y.map(|(t, (y, e))| y + 0.5 * e + more(t as f64 * TS)).collect();
    Record::new(TS, u, y).unwrap()
}

fn input(at: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..N).map(|t| at(t as f64 * TS)).collect()
}

/// A validation with the first of its loops.
fn text(validation: Validation) -> String {
    let loops = validation.loops.into_iter().take(1).collect();
    format!("{:?}", Validation { simulated: Vec::new(), loops, ..validation })
}

#[test]
fn validations_are_those_that_were_made() {
    let plays = model("prandtl-ishlinskii", 0.03);
    let creep = Creep::logarithmic(TS, 0.01, 0.05, 5.0).unwrap();
    let crept = plays.clone().with_creep(creep).unwrap();
    let other = model("prandtl-ishlinskii", 0.06);
    let rising = |hz: f64| input(|t| (4.0 + 10.0 * t) * (TAU * hz * t).sin());
    let prbs = Prbs { order: 10, amplitude: 3.0, ..Prbs::default() }.samples(TS, N).unwrap();
    let still = |_| 0.0;
    let mut spiked = record(&plays, 9, rising(11.0), still).y().to_vec();
    (spiked[700], spiked[2100]) = (900.0, -900.0);
    let records = [
        ("same", record(&plays, 1, rising(11.0), still)),
        ("drift", record(&plays, 2, rising(11.0), |t| 7.0 + 4.0 * t)),
        ("hum", record(&plays, 3, rising(11.0), |t| 3.0 * (TAU * 50.0 * t).sin())),
        ("creep", record(&crept, 4, input(|t| if t < 0.5 { 0.0 } else { 15.0 }), still)),
        ("damping", record(&other, 5, prbs.clone(), still)),
        ("resonance", record(&other, 6, rising(140.0), still)),
        ("wide", record(&plays, 7, input(|t| 29.0 * (TAU * 60.0 * t).sin()), still)),
        ("slow", record(&plays, 8, input(|t| 12.0 + 9.0 * (TAU * 0.7 * t).sin()), still)),
        ("spikes", Record::new(TS, rising(11.0), spiked).unwrap()),
    ];
    let mut lines = Vec::new();
    for (name, record) in &records {
        let all = [(Offset::Kept, 0.0), (Offset::Free, 0.25), (Offset::Drift, 0.0)];
        for (offset, skip) in all.into_iter().take(if *name == "drift" { 3 } else { 1 }) {
            lines.push(
                name.to_string() + &text(plays.validate_with(record, &ValidateOptions { offset, skip }).unwrap()),
            );
        }
    }
    lines.push(text(model("rate-scheduled", 0.03).validate(&records[5].1).unwrap()));
    assert_kept("validations", &lines.join("\n"));
}

#[test]
fn linearity_is_what_it_was() {
    let (plays, beam) = (model("prandtl-ishlinskii", 0.03), model("proportional", 0.03));
    let prbs = Prbs { order: 9, amplitude: 1.0, ..Prbs::default() };
    let periods = prbs.samples(TS, 4 * 511).unwrap();
    let large = Prbs { amplitude: 20.0, ..prbs }.samples(TS, 4 * 511).unwrap();
    let sweep = input(|t| (TAU * (5.0 + 60.0 * t) * t).sin());
    let mut lines = Vec::new();
    for (k, (model, u)) in (0..).zip([(&beam, &periods), (&plays, &periods), (&plays, &large), (&beam, &sweep)]) {
        lines.push(format!("{:?}", Linearity::of(&record(model, k, u.clone(), |_| 0.0)).unwrap()));
    }
    assert_kept("linearity", &lines.join("\n"));
}
