//! Tests of exported programs under stress: inputs that no sensor gives, and inputs that take the most operations.

use crate::ExportRequest;
use crate::exported::ExportedProgram;
use crate::guard::farthest;
use piezoid::creep::Creep;
use piezoid::driver::DriverModel;
use piezoid::hysteresis::{OPERATORS, Operator};
use piezoid::linear::Arx;
use piezoid::{Model, System};
use piezoid_models::program::Machine;
use piezoid_testing::in_feedback;

const TS: f64 = 5e-4;

fn model(name: &str, driver: Option<DriverModel>) -> Model {
    let faster = if driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 };
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8]).unwrap();
    let law = (Operator::find(name).unwrap().example)(TS / faster).unwrap();
    let model = Model::from_blocks(driver, law, block, 2.0).unwrap();
    model.with_creep(Creep::logarithmic(TS, 0.01, 0.1, 1.0).unwrap()).unwrap()
}

/// A model of every operator, one behind a driver, and those with hysteresis in feedback.
fn models() -> Vec<(String, Model)> {
    let mut models: Vec<(String, Model)> = OPERATORS.iter().map(|o| (o.name.into(), model(o.name, None))).collect();
    let driver = DriverModel::new(1e-4, Some(2e4)).unwrap();
    models.push(("driven".into(), model("prandtl-ishlinskii", Some(driver))));
    let read = |document: serde_json::Value| Model::from_json(&document.to_string()).unwrap();
    models.extend(in_feedback().into_iter().map(|(name, document)| (name.into(), read(document))));
    models
}

/// Numbers from 0 to 1, the same on every machine.
fn drawn(seed: &mut u32) -> f64 {
    *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    f64::from(*seed >> 8) / f64::from(1 << 24)
}

/// Inputs that fill and empty memories: they die away with each reversal within the one before, jump, cross the range
/// at once or in small steps, and stand still; up to `most` either way.
fn adverse(most: f64, n: usize) -> Vec<f64> {
    let mut seed = 7;
    let mut u = Vec::with_capacity(n);
    while u.len() < n {
        let scale = most * [0.1, 0.1, 0.1, 0.3, 1.0][(5.0 * drawn(&mut seed)) as usize];
        let length = 8 + (60.0 * drawn(&mut seed)) as usize;
        let last = u.last().copied().unwrap_or(0.0);
        let kind = (5.0 * drawn(&mut seed)) as usize;
        for k in 0..length {
            let share = k as f64 / length as f64;
            u.push(match kind {
                0 => scale * (1.0 - share) * if k % 2 == 0 { 1.0 } else { -1.0 },
                1 => scale * (2.0 * drawn(&mut seed) - 1.0),
                2 => last + (scale - last) * share,
                3 => last * (1.0 - share) - scale * share,
                _ => {
                    if k == 0 {
                        -scale
                    } else {
                        last
                    }
                }
            });
        }
    }
    u.truncate(n);
    u
}

#[test]
fn what_is_no_number_counts_as_the_input_before_it_and_the_rest_is_as_the_library_has_it() {
    for (name, model) in models() {
        let (most, n) = (farthest(&model), 1500);
        let others =
            [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -1e300, 1.0001 * most, 1e-310, -5e-324, -0.0];
        let (mut seed, mut last) = (3, 0.0);
        let mut inputs = adverse(most, n);
        inputs.iter_mut().for_each(|u| {
            let k = (40.0 * drawn(&mut seed)) as usize;
            *u = others.get(k).copied().unwrap_or(*u);
        });
        let held: Vec<f64> = inputs
            .iter()
            .map(|u| {
                last = if u.abs() <= most { *u } else { last };
                last
            })
            .collect();
        for single in [false, true] {
            let request = ExportRequest::new(&model, "m").single(single);
            let whole = ExportedProgram::new(&request).unwrap();
            let run = |u: &[f64]| {
                let mut machine = Machine::new(&whole.program, "state", single);
                u.iter().map(|u| machine.call("step", &[*u]).unwrap()[0]).collect::<Vec<f64>>()
            };
            let (found, expected) = (run(&inputs), if single { run(&held) } else { model.simulate(&held) });
            for t in 0..n {
                assert!(found[t].is_finite(), "{name}, single {single}, at {t}: {} for {}", found[t], inputs[t]);
                let same = found[t].to_bits() == expected[t].to_bits() || model.interpolates();
                assert!(same, "{name}, single {single}, at {t}: {} not {}", found[t], expected[t]);
            }
        }
    }
}

#[test]
fn no_inputs_take_more_operations_than_the_bound_and_some_take_half_of_it() {
    // Series of exponentials and searches end far before their longest, whatever the input.
    let far = [
        "rate-scheduled",
        "rate-dependent-prandtl-ishlinskii",
        "bouc-wen",
        "asymmetric-bouc-wen",
        "bouc-wen-baber-noori",
        "dahl",
        "guided",
        "bender",
        "filtered",
    ];
    println!("| model | mean | most | bound |\n|---|--:|--:|--:|");
    for (name, model) in models() {
        let request = ExportRequest::new(&model, "m").single(true);
        let whole = ExportedProgram::new(&request).unwrap();
        let bound = whole.entries[0].vectors.bound;
        let mut machine = Machine::new(&whole.program, "state", true);
        let mut most = 0;
        let u = adverse(farthest(&model), 3000);
        for (t, u) in u.iter().enumerate() {
            let before = machine.counts.total();
            machine.call("step", &[if t % 97 == 0 { f64::NAN } else { *u }]).unwrap();
            most = most.max(machine.counts.total() - before);
        }
        println!("| {name} | {} | {most} | {bound} |", machine.counts.total() / u.len());
        assert!(most <= bound, "{name}: {most} of {bound}");
        assert!(2 * most >= bound || far.contains(&&*name), "{name}: {most} of {bound}");
    }
}
