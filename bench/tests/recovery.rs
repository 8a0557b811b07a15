//! Joint identification recovers each operator's example from records that a user could take.

#![allow(clippy::expect_used, clippy::panic)] // a failing test panics

use piezoid::hysteresis::{OPERATORS, Operator};
use piezoid_bench::operators::{error, laws};
use piezoid_bench::page::{cells, same};

/// A millionth of peak-to-peak, in percent.
const RECOVERED: f64 = 1e-4;

const PAGE: &str = include_str!("../../docs/operators.md");

/// The table of docs/operators.md: errors by truth and model.
fn kept() -> Vec<(String, Vec<String>)> {
    let rows =
        PAGE.lines().skip_while(|line| !line.starts_with("| true operator")).skip(2).take_while(|l| l.starts_with('|'));
    rows.map(|line| {
        let mut cells = cells(line).into_iter();
        let name = cells.next().and_then(|name| Some(name.split_once(' ')?.1.trim_matches('`').to_string()));
        (name.expect("a number and a name"), cells.collect())
    })
    .collect()
}

#[track_caller]
fn is_recovered(names: &[&str]) {
    for name in names {
        let row = Operator::find(name).expect("an operator");
        let percent = error(row, row).expect("a model");
        assert!(percent <= RECOVERED, "{name}: {percent} % of peak-to-peak");
    }
}

/// The two grids, the longest search and the learned operators. Each takes seconds; all others together take less.
const SLOW: [&str; 6] =
    ["preisach", "krasnoselskii-pokrovskii", "bouc-wen-baber-noori", "narx", "neural", "gaussian-process"];

#[test]
fn every_operator_of_few_parameters_is_recovered_to_a_millionth_of_peak_to_peak() {
    let fast: Vec<&str> = OPERATORS.iter().map(|o| o.name).filter(|name| !SLOW.contains(name)).collect();
    assert_eq!(fast.len() + SLOW.len(), OPERATORS.len());
    is_recovered(&fast);
}

#[test]
fn a_preisach_grid_is_recovered() {
    is_recovered(&SLOW[..1]);
}

#[test]
fn a_grid_of_kernels_is_recovered() {
    is_recovered(&SLOW[1..2]);
}

#[test]
fn wear_and_pinching_are_recovered() {
    is_recovered(&SLOW[2..3]);
}

#[test]
fn polynomials_whose_terms_are_selected_are_recovered() {
    is_recovered(&SLOW[3..4]);
}

#[test]
fn a_network_is_recovered() {
    is_recovered(&SLOW[4..5]);
}

#[test]
fn a_gaussian_process_is_recovered() {
    is_recovered(&SLOW[5..]);
}

#[test]
fn the_page_of_operators_has_a_section_for_each_and_a_row_for_each_law() {
    let rows = kept();
    assert!(rows.iter().map(|(name, _)| name.as_str()).eq(laws().map(|o| o.name)), "{rows:?}");
    for (k, (name, cells)) in rows.iter().enumerate() {
        assert_eq!(cells.len(), rows.len(), "{name}");
        assert_eq!(cells[k], "0", "{name} is recovered");
    }
    for name in OPERATORS.iter().map(|o| o.name) {
        assert!(PAGE.contains(&format!("\n### `{name}`\n")), "{name} has no section");
    }
}

#[test]
fn the_matrix_in_the_documentation_is_reproduced() {
    let rows = kept();
    let laws: Vec<_> = laws().collect();
    let place = |name: &str| laws.iter().position(|o| o.name == name).expect("a law");
    for (truth, model) in [
        ("prandtl-ishlinskii", "proportional"),
        ("bouc-wen", "prandtl-ishlinskii"),
        ("prandtl-ishlinskii", "bouc-wen"),
        ("asymmetric-bouc-wen", "bouc-wen"),
        ("dahl", "bouc-wen"),
        ("bouc-wen", "duhem"),
    ] {
        let (i, j) = (place(truth), place(model));
        let now = error(laws[i], laws[j]).expect("a model");
        same(now, &rows[i].1[j]).unwrap_or_else(|e| panic!("{truth} as {model}: {e}"));
    }
}
