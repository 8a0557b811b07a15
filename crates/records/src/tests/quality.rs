//! Inspection of measured records, with and without defects.

use crate::formats::{ColumnSelection, Table};
use crate::quality::inspect;
use crate::record::Record;

fn record(name: &str) -> Option<Record> {
    let bytes = piezoid_testing::measured(name)?;
    let whole = Table::parse(&bytes).and_then(|t| t.record(&ColumnSelection::default())).expect("a record");
    Some(whole.part(1.5, f64::INFINITY).expect("what follows the transient"))
}

#[test]
fn the_measured_records_pass() {
    for name in ["picma-p885/model_1Hz.csv", "picma-p885/test_am_1Hz.csv"] {
        let Some(record) = record(name) else { return };
        assert_eq!(inspect(&record).findings, [], "{name}");
    }
}

#[test]
fn a_spike_a_stuck_sensor_and_a_limit_in_a_measured_record_are_found() {
    let Some(sound) = record("picma-p885/model_1Hz.csv") else { return };
    let with = |change: &dyn Fn(usize, f64) -> f64| {
        let y = sound.y().iter().enumerate().map(|(t, y)| change(t, *y)).collect();
        inspect(&Record::new(sound.ts(), sound.u().to_vec(), y).expect("a record"))
    };
    let spiked = with(&|t, y| if t == 1234 { y + 10.0 } else { y });
    assert_eq!(
        (
            spiked.findings[0].detector.name,
            spiked.usable.iter().filter(|usable| !**usable).count(),
            spiked.usable[1234]
        ),
        ("outliers", 1, false)
    );
    let stuck = with(&|t, y| if (2000..2050).contains(&t) { sound.y()[2000] } else { y });
    assert!(stuck.findings.iter().any(|f| f.detector.name == "frozen-output"), "{:?}", stuck.findings);
    assert!(!stuck.usable[2001..2050].contains(&true));
    let high = sound.y().iter().fold(f64::MIN, |m, y| m.max(*y));
    let limited = with(&|_, y| y.min(high - 12.0));
    assert!(limited.findings.iter().any(|f| f.detector.name == "saturated-output"), "{:?}", limited.findings);
}
