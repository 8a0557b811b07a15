//! Hysteresis operators compared with their definitions in numpy and scipy; `golden/operators.py` writes the numbers.

use super::golden::{numbers, rows, text};
use piezoid_models::hysteresis::Operator;
use piezoid_testing::assert_named_close;

#[test]
fn operators_are_their_definitions() {
    let rows = rows(include_str!("../../tests/golden/operators.json"));
    assert_eq!(rows.len(), 12);
    for row in &rows {
        let name = text(row, "operator");
        let load = Operator::find(name).expect("an operator there is").load;
        let block = load(row["params"].clone(), 5e-4).expect("parameters that make sense");
        let (u, z) = (numbers(row, "u"), numbers(row, "z"));
        let largest = z.iter().fold(0.0f64, |m, z| m.max(z.abs()));
        // Sums are exact except for rounding, equations except for scipy's solver; Tellinen's integrals are tabulated.
        let tolerance = match name {
            "prandtl-ishlinskii" | "stop" | "krasnoselskii-pokrovskii" => 1e-13,
            "tellinen" => 3e-6,
            _ => 1e-9,
        };
        assert_named_close(name, &block.simulate(&u), &z, 0.0, tolerance * largest);
    }
}
