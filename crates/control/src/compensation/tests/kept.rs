//! Inverses that give the same numbers as before.

use super::*;
use piezoid_testing::assert_kept;
use serde_json::Value;

const SETTINGS: FeedForwardSettings = FeedForwardSettings { limits: LIMITS, clip: true, iterations: 0 };

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
    let models = OPERATORS.iter().flat_map(|o| [None, Some(slow)].map(|driver| (o.name, model(o.name, driver))));
    let read = |(name, document): (&'static str, Value)| (name, Model::from_json(&document.to_string()).unwrap());
    let models = models.chain(in_feedback().into_iter().map(read));
    for (name, model) in models {
        let inverse = FeedForward::new(&model, FeedForwardSettings { iterations: 2, ..SETTINGS });
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
    let inverse = FeedForward::new(&model(PLAYS, None), SETTINGS).unwrap();
    let stronger = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.5 * 1.2, 3.2 * 1.2]).unwrap();
    let plant = model(PLAYS, None).with_linear(stronger).unwrap();
    let r: Vec<f64> = (0..100).map(|t| 5.0 + 300.0 * (TAU * f64::from(t) / 100.0).sin()).collect();
    let mut x = plant.initial();
    let mut trial = |u: &[f64]| (0..6).map(|_| plant.resume(&mut x, u)).last().unwrap();
    let learned = Learning { trials: 6, ..Learning::default() }.run(&mut trial, &inverse, &r).unwrap();
    assert_kept("learning", &format!("{:?} {:?}", learned.rms, learned.u));
}
