//! Output error and modes compared with scipy; `golden/*.py` write the numbers.

use crate::linear::{ModalFit, Orders, OutputError, Refinement};
use piezoid_numerics::progress::Stage;
use piezoid_records::record::Record;
use piezoid_testing::assert_named_close;
use piezoid_testing::golden::{number, numbers, rows, text};
use serde_json::Value;

#[test]
fn the_output_error_is_that_of_scipy_with_free_pasts_and_offsets() {
    let rows = rows("output_error");
    assert_eq!(rows.len(), 4);
    for row in &rows {
        let name = text(row, "name");
        let list = row["records"].as_array().expect("records");
        let record = |r: &Value| Record::new(1.0, numbers(r, "u"), numbers(r, "y")).expect("a record");
        let records: Vec<Record> = list.iter().map(record).collect();
        let settings =
            Refinement { weights: list.iter().map(|r| number(r, "weight")).collect(), ..Refinement::default() };
        let (a, b) = (numbers(row, "a"), numbers(row, "b"));
        let orders = Orders { na: a.len(), nb: b.len(), delay: number(row, "delay") as usize };
        let found =
            OutputError::fit(&records, orders, &settings, &mut Stage::ignore).expect("a block that scipy finds");
        // Both end when a step changes the cost by less than 1e-12; the parameters are accurate to its square root.
        assert_named_close(name, &[found.minimum.cost], &[number(row, "cost")], 1e-9, 0.0);
        assert_named_close(name, found.arx.a(), &a, 1e-6, 1e-6);
        assert_named_close(name, &found.arx.b()[orders.delay..], &b, 1e-6, 1e-6);
        assert_named_close(name, &found.offsets, &numbers(row, "offsets"), 0.0, 1e-6);
        // The noise is white: scipy's inverse of J'J assumes it, our covariance estimates it.
        let variance = number(row, "cost") / found.freedom as f64;
        let theirs: Vec<f64> = numbers(row, "inverse_of_jj").iter().map(|c| (c * variance).sqrt()).collect();
        let d = orders.parameters();
        let ours: Vec<f64> = (0..d).map(|k| found.covariance[k * (d + 1)].sqrt()).collect();
        assert_named_close(name, &ours, &theirs, 0.4, 0.0);
    }
}

#[test]
fn modes_and_delay_simulated_by_scipy_are_found() {
    let rows = rows("modes");
    assert_eq!(rows.len(), 5);
    for row in &rows {
        let name = text(row, "name");
        let record = Record::new(number(row, "ts"), numbers(row, "u"), numbers(row, "y")).expect("a record");
        let hz = numbers(row, "hz");
        let found = ModalFit::fit(&[record], hz.len(), 3, &Refinement::default(), &mut Stage::ignore).expect("modes");
        let of = |what: fn(&crate::linear::FittedMode) -> f64| found.modes.iter().map(what).collect::<Vec<f64>>();
        assert_named_close(name, &of(|m| m.hz.value), &hz, 1e-7, 0.0);
        assert_named_close(name, &of(|m| m.damping.value), &numbers(row, "damping"), 1e-6, 0.0);
        assert_named_close(name, &of(|m| m.share.value), &numbers(row, "share"), 1e-6, 0.0);
        assert_named_close(name, &[found.gain.value], &[number(row, "gain")], 1e-7, 0.0);
        assert_named_close(name, &[found.delay.value], &[number(row, "delay")], 0.0, 1e-10);
    }
}
