//! Fits of linear blocks, and bases of operators, that give the same numbers as before.

use crate::hysteresis::{BasisDesign, OPERATORS, ShapeParameter};
use crate::linear::{
    Arx, Bootstrap, ESTIMATORS, ModalFit, OrderSearch, Orders, OutputError, Refinement, free_decay_modes, select,
    select_beside_tones,
};
use piezoid_numerics::optimize::swarm::SwarmSettings;
use piezoid_numerics::progress::Stage;
use piezoid_numerics::system::System;
use piezoid_records::excitation::{Chirp, Prbs};
use piezoid_records::record::Record;
use piezoid_testing::{assert_kept, noise};
use std::f64::consts::TAU;

const TS: f64 = 5e-4;

/// Two blocks side by side, with noise and an offset.
fn record(seed: u64, u: Vec<f64>) -> Record {
    let plant = Arx::new(TS, vec![1.62, -0.93], vec![0.0, 2.0, 1.1]).unwrap();
    let stiff = Arx::new(TS, vec![-0.5, -0.8, 0.2], vec![0.4, 0.1]).unwrap();
    let y = plant.simulate(&u).into_iter().zip(stiff.simulate(&u)).zip(noise(seed, u.len()));
    let y = y.map(|((slow, fast), e)| 40.0 + slow + fast + 0.05 * e).collect();
    Record::new(TS, u, y).unwrap()
}

fn prbs(n: usize) -> Vec<f64> {
    Prbs::default().samples(TS, n).unwrap()
}

#[test]
fn fits_of_linear_blocks_are_those_that_were_found() {
    let records = [record(1, prbs(1500)), record(2, prbs(700))];
    let (settings, mut lines) = (Refinement::default(), Vec::new());
    let progress = &mut Stage::ignore;
    for estimator in ESTIMATORS {
        let fit = estimator.fit(&records, Orders::of(3), &SwarmSettings::default(), progress).unwrap();
        let history = [fit.history.first(), fit.history.last()];
        lines.push(format!("{} {:?} {:?} {:?} {history:?}", estimator.name, fit.arx, fit.offsets, fit.residuals));
    }
    let limits = OrderSearch { order: 5, delay: 2, parallel: false };
    for selection in [select(&records, &limits).unwrap(), select_beside_tones(&records, &limits, 0.002).unwrap()] {
        lines.push(selection.reason);
        for row in &selection.candidates {
            lines
                .push(format!("{:?} {} {} {} {}", row.orders, row.held_out, row.excess, row.excess_error, row.as_good));
        }
        let fit = selection.fit;
        lines.push(format!("{:?} {:?} {:?} {:?} {:?}", fit.arx, fit.offsets, fit.rms, fit.poles(), fit.dc_gain()));
        let form = fit.arx.modal_form();
        lines.extend(form.rows().iter().map(|row| row.join(" | ")));
        lines.push(format!("{:?} {:?} {:?}", form.images(), fit.arx.poles(), fit.arx.zeros()));
    }
    let chirp = Chirp { amplitude: 1.0, ..Chirp::default() }.samples(TS, 2000).unwrap();
    let sweep = select(&[record(3, chirp)], &limits).unwrap();
    lines.push(format!("{} {:?} {:?}", sweep.reason, sweep.fit.arx, sweep.fit.rms));
    let modes = ModalFit::fit(&records, 2, 3, &settings, progress).unwrap();
    lines.push(format!("{:?} {:?} {:?} {:?}", modes.gain, modes.modes, modes.feed_through, modes.delay));
    let fit = OutputError::fit(&records, Orders { delay: 1, ..Orders::of(4) }, &settings, progress).unwrap();
    let draws = Bootstrap { replicates: 4, ..Bootstrap::default() };
    lines.push(format!("{:?}", fit.bootstrap(&records, &settings, &draws, progress).unwrap()));
    assert_kept("linear-fits", &lines.join("\n"));
}

#[test]
fn what_a_step_shows_is_what_it_showed() {
    let u: Vec<f64> = (0..3000).map(|t| if t % 1000 < 400 { 0.0 } else { 10.0 }).collect();
    let plant = Arx::new(1e-3, vec![1.7, -0.95], vec![0.2]).unwrap();
    let y = plant.simulate(&u).into_iter().zip(noise(4, 3000)).enumerate();
    let hum = |t: usize| 0.02 * (TAU * 0.05 * t as f64).sin();
    let y = y.map(|(t, (y, e))| y + hum(t) + 0.01 * e).collect();
    assert_kept("free-decay", &format!("{:?}", free_decay_modes(&[Record::new(1e-3, u, y).unwrap()])));
}

#[test]
fn bases_of_operators_respond_as_they_did() {
    let mut lines = Vec::new();
    for operator in OPERATORS {
        for (range, elements) in [((-30.0, 30.0), None), ((20.0, 60.0), Some(5))] {
            let design = BasisDesign { ts: TS, range, elements, frequencies: vec![5.0, 20.0, 80.0] };
            let basis = (operator.basis)(&design).unwrap();
            let shape = |s: ShapeParameter| format!("{} {} {} {}", s.name, s.value, s.low, s.high);
            let shapes: Vec<String> = basis.shape().into_iter().map(shape).collect();
            let weights: Vec<f64> = (0..basis.len()).map(|k| 1.0 + 0.5 * (1.7 * k as f64).sin()).collect();
            let roughness: f64 = basis
                .roughness()
                .iter()
                .map(|row| row.iter().map(|(k, factor)| factor * weights[*k]).sum::<f64>().powi(2))
                .sum();
            let at = |t: f64| 0.6 * (0.05 * t).sin() + 0.4 * (0.173 * t).sin();
            let middle = 0.5 * (range.0 + range.1);
            let u: Vec<f64> = (0..400).map(|t| middle + (range.1 - middle) * at(f64::from(t))).collect();
            let z = basis.output(&weights, &u).unwrap();
            let some = |x: &[f64]| x.iter().skip(19).step_by(76).map(f64::to_string).collect::<Vec<_>>().join(" ");
            let slopes: Vec<String> = basis.slopes(&weights, &u).iter().map(|slope| some(slope)).collect();
            let (name, n, order) = (operator.name, basis.len(), basis.order());
            lines.push(format!("{name} {n} {order} {roughness} {}", shapes.join(" ")));
            lines.push(format!("{} {}", some(&z), slopes.join(" ")));
            let negative = basis.non_negative().iter().filter(|must| **must).count();
            let z = z[399];
            let block = basis.operator(&weights).unwrap();
            let x = block.settled(middle);
            let inverted = block.invert(&x, z, (range.0, range.1));
            lines.push(format!("{negative} {inverted:?} {:?}", block.falling_input(range.0, range.1)));
        }
    }
    assert_kept("bases", &lines.join("\n"));
}
