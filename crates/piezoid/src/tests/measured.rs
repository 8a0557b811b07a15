//! Both methods of identification on measured data: a P-885.91 stack at 1 Hz (Aye & Ang, ICSTSD 2018).

use crate::IdentifyOptions;
use crate::Method;
use crate::identify;
use piezoid_identification::Identified;
use piezoid_records::formats::{ColumnSelection, Table};
use piezoid_records::record::Record;
use piezoid_validation::Validate;
use piezoid_validation::{Offset, ValidateOptions};

/// The transient at the start of every file [s]: 300 samples.
const START: f64 = 1.5;

/// The middle of the model file [s].
const HALF: f64 = 20.0;

fn record(name: &str) -> Option<Record> {
    let bytes = piezoid_testing::measured(name)?;
    Some(Table::parse(&bytes).and_then(|t| t.record(&ColumnSelection::default())).expect("a record"))
}

fn paper() -> IdentifyOptions {
    IdentifyOptions { method: Method::Paper, ..IdentifyOptions::default() }
}

fn joint() -> IdentifyOptions {
    IdentifyOptions { seed: 0, ..IdentifyOptions::default() }
}

/// The model of the paper's method from the first half of the model file, and the whole file.
fn identified() -> Option<(Identified, Record)> {
    let whole = record("picma-p885/model_1Hz.csv")?;
    let first = whole.part(START, HALF).expect("a first half");
    assert_eq!(first.len(), 3700);
    let found = identify(&[first], &paper()).expect("a model");
    Some((found, whole))
}

#[test]
fn two_branches_from_half_a_record_predict_the_other_half_within_4_percent() {
    let Some((found, whole)) = identified() else { return };
    assert_eq!(found.model.hysteresis().operator().name, "two-branch");
    let second = whole.part(HALF, f64::INFINITY).expect("a second half");
    let validation = found.model.validate(&second).expect("figures");
    assert_eq!(validation.metrics.n, second.len());
    assert!(validation.metrics.nrmse_percent <= 4.0, "{:?}", validation.metrics);
    // The baseline: without the two branches, the error of a gain and an offset is 21 %.
    let plain = IdentifyOptions { operator: "proportional".into(), ..paper() };
    let first = whole.part(START, HALF).expect("a first half");
    let plain = identify(&[first], &plain).expect("a model");
    let floor = plain.model.validate(&second).expect("figures").metrics.nrmse_percent;
    assert!((19.0..23.0).contains(&floor), "{floor} %");
}

#[test]
fn one_frequency_gives_a_pure_gain_and_the_reason() {
    let Some((found, _)) = identified() else { return };
    let linear = found.model.linear();
    assert_eq!((linear.a().len(), linear.b().len()), (0, 1));
    let reason = &found.linear.reason;
    assert!(reason.contains("a pure gain") && reason.contains("one frequency (1"), "{reason}");
    assert!(found.notes.iter().any(|n| n.contains(reason)), "{:?}", found.notes);
}

#[test]
fn a_rising_amplitude_exceeds_two_branches_and_gives_a_remark() {
    let Some((found, whole)) = identified() else { return };
    let Some(growing) = record("picma-p885/test_am_1Hz.csv") else { return };
    let growing = growing.part(START, f64::INFINITY).expect("what follows the transient");
    let free = ValidateOptions { offset: Offset::Free, ..ValidateOptions::default() };
    let validation = found.model.validate_with(&growing, &free).expect("figures");
    assert!(validation.metrics.nrmse_percent > 10.0, "{:?}", validation.metrics);
    assert!(validation.remarks.iter().any(|r| r.contains("minor loops")), "{:?}", validation.remarks);
    // There is no remark for the identified loop.
    let second = whole.part(HALF, f64::INFINITY).expect("a second half");
    let same = found.model.validate(&second).expect("figures");
    assert_eq!(same.remarks, Vec::<String>::new());
}

#[test]
fn a_joint_model_predicts_the_other_half_of_a_varying_amplitude_within_1_4_percent() {
    let Some(whole) = record("picma-p885/model_1Hz.csv") else { return };
    let Some(growing) = record("picma-p885/test_am_1Hz.csv") else { return };
    let half = 0.5 * growing.duration();
    let [steady, first] =
        [whole.part(START, f64::INFINITY), growing.part(START, half)].map(|part| part.expect("a part"));
    let found = identify(&[steady, first], &joint()).expect("a model");
    let second = growing.part(half, f64::INFINITY).expect("a second half");
    // Cut in motion: the second half does not contain the history of the ceramic.
    let free = ValidateOptions { skip: START, offset: Offset::Free };
    let nrmse = found.model.validate_with(&second, &free).expect("figures").metrics.nrmse_percent;
    assert!(nrmse <= 1.4, "{nrmse} % with {}", found.model.hysteresis().operator().name);
}

#[test]
fn an_operator_with_long_memory_is_judged_by_its_free_run() {
    // With seeds 0 and 4 the swarm found a bouc-wen with a memory of 40 periods: as good on held-out data, 15 % in free
    // run.
    let Some(whole) = record("picma-p885/model_1Hz.csv") else { return };
    let first = whole.part(START, HALF).expect("a first half");
    for seed in [0, 4] {
        let options = IdentifyOptions { operator: "bouc-wen".into(), seed, ..IdentifyOptions::default() };
        let found = identify(std::slice::from_ref(&first), &options).expect("a model");
        let options = ValidateOptions { offset: Offset::Free, ..ValidateOptions::default() };
        let nrmse = found.model.validate_with(&first, &options).expect("figures").metrics.nrmse_percent;
        assert!(nrmse < 4.0, "seed {seed}: {nrmse} %");
    }
}
