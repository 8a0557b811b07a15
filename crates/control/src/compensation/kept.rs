//! Inverses that give the same numbers as before.

use super::{FeedForward, FeedForwardSettings, Learning};
use piezoid_models::creep::Creep;
use piezoid_models::driver::DriverModel;
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::{OPERATORS, Operator};
use piezoid_models::linear::Arx;
use piezoid_numerics::system::System;
use piezoid_records::excitation::Limits;
use piezoid_testing::{assert_kept, in_feedback};
use serde_json::Value;
use std::f64::consts::TAU;

const TS: f64 = 5e-4;

/// A beam with hysteresis, creep and possibly a driver, with `share` of the nominal gain.
fn model(operator: &str, driver: Option<DriverModel>, share: f64) -> Model {
    let ts = TS / if driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 };
    let hysteresis = (Operator::find(operator).unwrap().example)(ts).unwrap();
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.5 * share, 3.2 * share]).unwrap();
    let creep = Creep::logarithmic(TS, 0.01, 0.05, 5.0).unwrap();
    Model::from_blocks(driver, hysteresis, block, 5.0).unwrap().with_creep(creep).unwrap()
}

fn settings() -> FeedForwardSettings {
    let limits = Limits { low: Some(-30.0), high: Some(30.0), slew: Some(2e4), ..Limits::default() };
    FeedForwardSettings { limits, clip: true, iterations: 0 }
}

fn path(height: f64, n: usize) -> Vec<f64> {
    let at = |t: f64| (t / 0.05).min(1.0).powi(2) * (TAU * 20.0 * t).sin();
    (0..n).map(|t| 5.0 + height * at((t as f64 - 40.0).max(0.0) * TS)).collect()
}

fn some(x: &[f64]) -> String {
    x.iter().skip(37).step_by(61).map(f64::to_string).collect::<Vec<_>>().join(" ")
}

#[test]
fn voltages_for_a_reference_are_those_that_were_found() {
    let mut lines = Vec::new();
    let slow = DriverModel::new(1e-4, Some(6e4)).unwrap();
    let models = OPERATORS.iter().flat_map(|o| [None, Some(slow)].map(|driver| (o.name, model(o.name, driver, 1.0))));
    let read = |(name, document): (&'static str, Value)| (name, Model::from_json(&document.to_string()).unwrap());
    let models = models.chain(in_feedback().into_iter().map(read));
    for (name, model) in models {
        let inverse = FeedForward::new(&model, FeedForwardSettings { iterations: 2, ..settings() });
        let inverse = match inverse {
            Ok(inverse) => inverse,
            Err(error) => {
                lines.push(format!("{name}: {error}"));
                continue;
            }
        };
        let (low, high) = inverse.reach();
        let r = path(0.3 * (high - low), 400).iter().map(|r| r + 0.5 * (low + high)).collect::<Vec<_>>();
        let found = inverse.whole(&r).unwrap();
        lines.push(format!("{name} {low} {high} {}", some(&found.u)));
        lines.push(format!("{} {} {:?} {:?}", some(&found.reached), found.clipped, found.usage, found.notes));
    }
    assert_kept("inverses", &lines.join("\n"));
}

#[test]
fn learning_takes_the_steps_that_it_took() {
    let inverse = FeedForward::new(&model("prandtl-ishlinskii", None, 1.0), settings()).unwrap();
    let plant = model("prandtl-ishlinskii", None, 1.2);
    let r: Vec<f64> = (0..100).map(|t| 5.0 + 300.0 * (TAU * f64::from(t) / 100.0).sin()).collect();
    let mut x = plant.initial();
    let mut trial = |u: &[f64]| (0..6).map(|_| plant.resume(&mut x, u)).last().unwrap();
    let learned = Learning { trials: 6, ..Learning::default() }.run(&mut trial, &inverse, &r).unwrap();
    assert_kept("learning", &format!("{:?} {:?}", learned.rms, learned.u));
}
