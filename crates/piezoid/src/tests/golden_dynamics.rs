//! Output error and modes against the numbers of scipy; `golden/*.py` write them.

use super::close::assert_close;
use super::golden::{numbers, rows, text};
use crate::Record;
use crate::linear::{ModalFit, Orders, OutputError, Refinement};
use crate::progress::silent;
use serde_json::Value;

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().expect("a number")
}

#[test]
fn the_least_output_error_is_that_of_scipys_least_squares_with_free_pasts_and_offsets() {
    let rows = rows(include_str!("../../tests/golden/output_error.json"));
    assert_eq!(rows.len(), 4);
    for row in &rows {
        let name = text(row, "name");
        let given = row["records"].as_array().expect("records");
        let record = |r: &Value| Record::new(1.0, numbers(r, "u"), numbers(r, "y")).expect("a record");
        let records: Vec<Record> = given.iter().map(record).collect();
        let how = Refinement { weights: given.iter().map(|r| number(r, "weight")).collect(), ..Refinement::default() };
        let (a, b) = (numbers(row, "a"), numbers(row, "b"));
        let orders = Orders { na: a.len(), nb: b.len(), delay: number(row, "delay") as usize };
        let found = OutputError::fit(&records, orders, &how, &mut silent).expect("a block that scipy finds");
        // Both end where a step would gain less than 1e-12 of the cost: the parameters there are good to its root.
        assert_close(name, &[found.minimum.cost], &[number(row, "cost")], 1e-9, 0.0);
        assert_close(name, found.arx.a(), &a, 1e-6, 1e-6);
        assert_close(name, &found.arx.b()[orders.delay..], &b, 1e-6, 1e-6);
        assert_close(name, &found.offsets, &numbers(row, "offsets"), 0.0, 1e-6);
        // The noise is white, which scipy's inverse of J'J takes for granted and ours has to find out.
        let variance = number(row, "cost") / found.freedom as f64;
        let theirs: Vec<f64> = numbers(row, "inverse_of_jj").iter().map(|c| (c * variance).sqrt()).collect();
        let d = orders.parameters();
        let ours: Vec<f64> = (0..d).map(|k| found.covariance[k * (d + 1)].sqrt()).collect();
        assert_close(name, &ours, &theirs, 0.4, 0.0);
    }
}

#[test]
fn modes_that_scipy_runs_late_are_found_again() {
    let rows = rows(include_str!("../../tests/golden/modes.json"));
    assert_eq!(rows.len(), 5);
    for row in &rows {
        let name = text(row, "name");
        let record = Record::new(number(row, "ts"), numbers(row, "u"), numbers(row, "y")).expect("a record");
        let hz = numbers(row, "hz");
        let found = ModalFit::fit(&[record], hz.len(), 3, &Refinement::default(), &mut silent).expect("modes");
        let of = |what: fn(&crate::linear::FittedMode) -> f64| found.modes.iter().map(what).collect::<Vec<f64>>();
        assert_close(name, &of(|m| m.hz.value), &hz, 1e-7, 0.0);
        assert_close(name, &of(|m| m.damping.value), &numbers(row, "damping"), 1e-6, 0.0);
        assert_close(name, &of(|m| m.share.value), &numbers(row, "share"), 1e-6, 0.0);
        assert_close(name, &[found.gain.value], &[number(row, "gain")], 1e-7, 0.0);
        assert_close(name, &[found.delay.value], &[number(row, "delay")], 0.0, 1e-10);
    }
}
