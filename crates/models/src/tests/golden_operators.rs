//! Hysteresis operators compared with their definitions in numpy and scipy; `golden/operators.py` writes the numbers.

use crate::driver::DriverModel;
use crate::hammerstein::Model;
use crate::hysteresis::{OPERATORS, Operator};
use crate::linear::Arx;
use piezoid_numerics::system::System;
use piezoid_testing::assert_named_close;
use piezoid_testing::golden::{number, numbers, rows, text};
use piezoid_testing::random::largest;
use serde_json::Value;

/// Sampling period of the rows [s].
const TS: f64 = 5e-4;

/// z of a row, from its operator.
fn simulated(row: &Value, u: &[f64]) -> Vec<f64> {
    let load = Operator::find(text(row, "operator")).expect("an operator there is").load;
    let block = |ts: f64| load(row["params"].clone(), ts).expect("parameters that make sense");
    let Some(driver) = row.get("driver") else { return block(TS).simulate(u) };
    let driver = DriverModel::new(number(driver, "lag_s"), Some(number(driver, "slew"))).expect("a driver");
    let block = block(TS / DriverModel::SUBSTEPS as f64);
    let gain = Arx::gain(TS, 1.0).expect("a gain");
    Model::from_blocks(Some(driver), block, gain, 0.0).expect("blocks of one sampling period").simulate(u)
}

#[test]
fn operators_are_their_definitions() {
    for row in &rows("operators") {
        let (u, z) = (numbers(row, "u"), numbers(row, "z"));
        let name = text(row, "operator");
        assert_named_close(name, &simulated(row, &u), &z, 0.0, number(row, "tolerance") * largest(&z));
    }
}

#[test]
fn every_operator_with_a_memory_has_a_definition_and_one_is_behind_a_driver() {
    let rows = rows("operators");
    for operator in OPERATORS.iter().filter(|operator| operator.name != "proportional") {
        assert!(rows.iter().any(|row| text(row, "operator") == operator.name), "{}", operator.name);
    }
    assert!(rows.iter().any(|row| row.get("driver").is_some()));
    // A row that allows more than a ten-thousandth compares nothing.
    assert!(rows.iter().all(|row| number(row, "tolerance") <= 1e-4));
}
