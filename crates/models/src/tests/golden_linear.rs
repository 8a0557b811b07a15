//! The linear block and its fits compared with scipy and numpy; `golden/*.py` write the numbers.

use crate::linear::{self, Arx, Orders};
use piezoid_numerics::optimize::{least_absolute, swarm};
use piezoid_numerics::progress::Stage;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use piezoid_testing::assert_named_close;
use piezoid_testing::golden::{number, numbers, rows, text};
use piezoid_testing::random::largest;
use serde_json::Value;

const RTOL: f64 = 1e-12;

/// Asserts `|a - b| <= rtol max |b|`, for series that pass through zero: their rounding error is relative to the terms,
/// not to the sum.
#[track_caller]
fn assert_close_in_norm(what: &str, a: &[f64], b: &[f64], rtol: f64) {
    assert_named_close(what, a, b, 0.0, rtol * largest(b));
}

/// The block of scipy's `a` and `b`. scipy writes a[0] y_t + a[1] y_{t-1} + ... = ...; equation (1) has the feedback on
/// the other side.
fn block(row: &Value, ts: f64) -> Arx {
    let a = numbers(row, "a");
    assert_eq!(a[0], 1.0);
    Arx::new(ts, a[1..].iter().map(|a| -a).collect(), numbers(row, "b")).expect("a block that scipy runs")
}

#[test]
fn a_free_run_is_scipys_lfilter() {
    let rows = rows("lfilter");
    assert_eq!(rows.len(), 13);
    for row in &rows {
        let (arx, u) = (block(row, 5e-4), numbers(row, "u"));
        assert_close_in_norm(text(row, "name"), &arx.simulate(&u), &numbers(row, "y"), RTOL);
    }
}

#[test]
fn a_state_is_the_past_outputs_then_the_past_inputs_newest_first() {
    for row in &rows("lfilter") {
        let (arx, u) = (block(row, 5e-4), numbers(row, "u"));
        let mut x = [numbers(row, "past_y_newest_first"), numbers(row, "past_u_newest_first")].concat();
        let resumed = arx.resume(&mut x, &u);
        assert_close_in_norm(text(row, "name"), &resumed, &numbers(row, "resumed"), RTOL);
        let last = |of: &[f64], n: usize| of.iter().rev().take(n).copied().collect::<Vec<_>>();
        assert_eq!(x, [last(&resumed, arx.a().len()), last(&u, arx.b().len() - 1)].concat(), "{}", row["name"]);
    }
}

#[test]
fn a_prediction_is_two_moving_averages_of_scipys() {
    for row in &rows("lfilter") {
        let predicted = block(row, 5e-4).predict(&numbers(row, "u"), &numbers(row, "measured"));
        assert_close_in_norm(text(row, "name"), &predicted, &numbers(row, "predicted"), RTOL);
    }
}

#[test]
fn the_inverse_is_scipys_lfilter_with_a_and_b_exchanged() {
    let rows = rows("lfilter");
    assert_eq!(rows.iter().filter(|row| row["inverse"].is_array()).count(), 9);
    for row in &rows {
        match (block(row, 5e-4).inverse(), row["inverse"].is_array()) {
            (Ok(inverse), true) => {
                let z = inverse.simulate(&numbers(row, "measured"));
                assert_close_in_norm(text(row, "name"), &z, &numbers(row, "inverse"), RTOL);
            }
            (Err(_), false) => {}
            (inverse, _) => panic!("{}: scipy disagrees with {inverse:?}", row["name"]),
        }
    }
}

#[test]
fn the_frequency_response_is_scipys_freqz() {
    let rows = rows("freqz");
    assert_eq!(rows.len(), 10);
    for row in &rows {
        let (arx, name) = (block(row, number(row, "ts")), text(row, "name"));
        let ours: Vec<_> = numbers(row, "hz").into_iter().map(|hz| arx.response(hz)).collect();
        let gain: Vec<f64> = ours.iter().map(|r| r.gain).collect();
        assert_named_close(name, &gain, &numbers(row, "gain"), RTOL, 0.0);
        // Angles are compared modulo 2 pi.
        let phase = numbers(row, "phase");
        let apart: Vec<f64> = ours.iter().zip(&phase).map(|(r, phase)| 2.0 * ((r.phase - phase) / 2.0).sin()).collect();
        assert_named_close(name, &apart, &vec![0.0; apart.len()], 0.0, RTOL);
    }
}

#[test]
fn poles_and_zeros_are_numpys_roots() {
    for row in rows("freqz").iter().filter(|row| row["name"] != EVEN) {
        compare_poles_and_zeros(row);
    }
}

/// The characteristic polynomial is z^4 - 0.1 z^2 + 0.6; its roots are pairs z, -z of equal modulus.
const EVEN: &str = "only even powers";

#[test]
fn the_roots_of_polynomials_in_even_powers_are_found() {
    let rows = rows("freqz");
    compare_poles_and_zeros(rows.iter().find(|row| row["name"] == EVEN).expect("the row"));
    let unstable = Arx::new(1.0, vec![0.0, 0.0, 0.0, -2.0], vec![1.0]).expect("a block");
    assert!(!unstable.is_stable(), "y_t = -2 y_(t-4) + u_t grows without bound");
    let comb = Arx::new(1.0, vec![], vec![1.0, 0.0, 0.0, 0.0, 2.0]).expect("a block");
    assert!(comb.inverse().is_err(), "z_t = y_t - 2 z_(t-4) grows without bound");
}

#[track_caller]
fn compare_poles_and_zeros(row: &Value) {
    let (arx, name) = (block(row, number(row, "ts")), text(row, "name"));
    let poles = arx.poles();
    let of = |what: &dyn Fn(&linear::Pole) -> f64| poles.iter().map(what).collect::<Vec<f64>>();
    assert_named_close(name, &of(&|p| p.hz), &numbers(row, "pole_hz"), RTOL, 0.0);
    // A damping ratio passes through zero: its rounding error is relative to 1.
    assert_named_close(name, &of(&|p| p.damping), &numbers(row, "pole_damping"), 0.0, RTOL);
    let zeros: Vec<[f64; 2]> = arx.zeros().iter().map(|z| [z.re, z.im]).collect();
    let moduli = |of: &[[f64; 2]]| of.iter().map(|z| z[0].hypot(z[1])).collect::<Vec<f64>>();
    let mut theirs = pairs(&row["zeros"]);
    assert_named_close(name, &moduli(&zeros), &moduli(&theirs), RTOL, 0.0);
    // Rounding determines the order of zeros of equal modulus, so each one is searched, within a tolerance relative to
    // the modulus.
    for [re, im] in zeros {
        let near = |z: &[f64; 2]| (z[0] - re).hypot(z[1] - im) <= RTOL * re.hypot(im);
        let found = theirs.iter().position(near);
        let found = found.unwrap_or_else(|| panic!("{name}: {re} {im:+}i is none of {theirs:?}"));
        theirs.swap_remove(found);
    }
}

#[test]
fn least_squares_is_scipys_lstsq_with_one_constant_per_record() {
    let rows = rows("lstsq");
    assert_eq!(rows.len(), 9);
    for row in &rows {
        let name = text(row, "name");
        let records: Vec<Record> = row["records"].as_array().expect("records").iter().map(record).collect();
        let integer = |key: &str| row[key].as_u64().expect("an integer") as usize;
        let orders = Orders { na: integer("na"), nb: integer("nb"), delay: integer("delay") };
        let estimator = linear::Estimator::find("least-squares").expect("it is in the list");
        let settings = swarm::SwarmSettings::default();
        let fit = estimator.fit(&records, orders, &settings, &mut Stage::ignore).expect("a fit that scipy makes");
        // Each group is compared in its own norm: units change b and offsets, not a. The condition is below 100, so
        // both solvers are accurate to a few 1e-14.
        assert_close_in_norm(name, fit.arx.a(), &numbers(row, "a"), RTOL);
        assert_close_in_norm(name, &fit.arx.b()[orders.delay..], &numbers(row, "b"), RTOL);
        assert_eq!(fit.arx.delay(), orders.delay, "{name}");
        // An offset is a difference of outputs, so the tolerance is relative to the outputs.
        let largest = records.iter().flat_map(|r| r.y()).fold(0.0f64, |m, y| m.max(y.abs()));
        assert_named_close(name, &fit.offsets, &numbers(row, "offsets"), 0.0, RTOL * largest);
    }
}

#[test]
fn the_least_absolute_cost_is_that_of_scipys_linear_program() {
    let rows = rows("linprog");
    assert_eq!(rows.len(), 5);
    for row in &rows {
        let dimension = row["dimension"].as_u64().expect("dimension") as usize;
        let cost = number(row, "cost");
        let fit = least_absolute(&numbers(row, "rows"), dimension).expect("an optimum that scipy finds");
        // The interior-point method ends near the vertex of the simplex method: 1e-8, not 1e-12.
        assert_named_close(text(row, "name"), &[fit.cost, fit.bound], &[cost, cost], 1e-8, 0.0);
        // Only rounding may be below the optimum.
        assert!(fit.cost >= cost * (1.0 - RTOL), "{}: {} is below {cost}", row["name"], fit.cost);
    }
}

fn record(value: &Value) -> Record {
    Record::new(5e-4, numbers(value, "u"), numbers(value, "y")).expect("a record")
}

fn pairs(list: &Value) -> Vec<[f64; 2]> {
    let number = |v: &Value| v.as_f64().expect("a number");
    list.as_array().expect("pairs").iter().map(|pair| [number(&pair[0]), number(&pair[1])]).collect()
}
