//! CSV files: measured, written, and arbitrary bytes.

use crate::formats::{ColumnSelection, Table};
use crate::record::Record;
use piezoid_numerics::error::Error;
use piezoid_testing::random::{bits, config};
use proptest::prelude::*;

fn record(bytes: &[u8]) -> Result<Record, Error> {
    Table::parse(bytes)?.record(&ColumnSelection::default())
}

#[test]
fn the_measured_model_file_is_read_completely() {
    let Some(bytes) = piezoid_testing::measured("picma-p885/model_1Hz.csv") else { return };
    let record = record(&bytes).unwrap();
    assert_eq!((record.len(), record.ts()), (8027, 0.005));
    assert_eq!((record.units().u.as_str(), record.units().y.as_str()), ("cmdV", "um"));
    assert_eq!((record.u()[1], record.y()[1]), (1.856539, -120.154262));
    assert_eq!(self::record(&record.written("r.csv").unwrap()).unwrap(), record);
}

#[test]
fn the_reference_of_the_measured_test_file_is_not_its_output() {
    let Some(bytes) = piezoid_testing::measured("picma-p885/test_am_1Hz.csv") else { return };
    let record = record(&bytes).unwrap();
    assert_eq!((record.len(), record.ts(), record.y()[1]), (14155, 0.005, -119.527853));
    let reference = ColumnSelection { output_col: Some("yref_um".into()), ..ColumnSelection::default() };
    let reference = Table::parse(&bytes).unwrap().record(&reference).unwrap();
    assert_eq!((reference.y()[1], reference.units().y.as_str()), (0.628215, "um"));
}

/// All queries of a table: none may panic, and every error has a message.
fn query_all(bytes: &[u8]) {
    let table = match Table::parse(bytes) {
        Ok(table) => table,
        Err(error) => return assert!(error.to_string().len() > 20),
    };
    let first = table.names().next().map(String::from);
    let selections = [
        ColumnSelection::default(),
        ColumnSelection { ts: Some(1e-3), ..ColumnSelection::default() },
        ColumnSelection { input_col: first.clone(), time_col: first.clone(), ..ColumnSelection::default() },
        ColumnSelection { output_col: first, ts: Some(f64::NAN), ..ColumnSelection::default() },
    ];
    for selection in &selections {
        for error in [table.record(selection).err(), table.input(selection).err()].into_iter().flatten() {
            let message = error.to_string();
            assert!((20..2000).contains(&message.len()), "{message}");
        }
    }
}

const VALID: &str = "# rig\nt_s,u_V,y_um,note\n0.000,1.5,-2e-3,\"a, b\"\n0.005,2.5,1e2,\n0.010,-3,0.25,x\n";

/// An optional header, then typical characters of files in any order.
const SOUP: &str = "(t_s,u_V,y_um\n|t;u_V;y_m\r\n|u_V\ty_\r)?[-+0-9.,;\t\n\r\"#einaf _tuVyms\u{b5}]{0,120}";

/// Replaces, inserts or deletes bytes at these places.
fn mutated(valid: &[u8], edits: &[(u8, usize, u8)]) -> Vec<u8> {
    let mut bytes = valid.to_vec();
    for (kind, place, byte) in edits {
        let at = place % (bytes.len() + 1);
        match kind % 4 {
            0 => bytes.insert(at, *byte),
            1 if at < bytes.len() => bytes[at] = *byte,
            2 if at < bytes.len() => drop(bytes.remove(at)),
            _ => bytes.insert(at, b",;\t\"\r\n#.-0"[usize::from(*byte) % 10]),
        }
    }
    bytes
}

fn finite() -> impl Strategy<Value = f64> {
    any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |v| v.is_finite())
}

proptest! {
    #![proptest_config(config(2000))]

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        query_all(&bytes);
    }

    #[test]
    fn text_that_resembles_a_csv_never_panics(text in SOUP) {
        query_all(text.as_bytes());
    }

    #[test]
    fn a_damaged_file_never_panics(edits in prop::collection::vec((any::<u8>(), any::<usize>(), any::<u8>()), 1..8)) {
        query_all(&mutated(VALID.as_bytes(), &edits));
        query_all(&mutated(VALID.replace(',', ";").replace('.', ",").replace('\n', "\r\n").as_bytes(), &edits));
    }

    #[test]
    fn a_written_file_is_read_back_bit_identically(
        samples in prop::collection::vec((finite(), finite()), 2..60),
        ts in prop_oneof![1e-9..1e6f64, (1u32..100_000, 0i32..9).prop_map(|(m, e)| f64::from(m) / 10f64.powi(e))],
    ) {
        let (u, y): (Vec<f64>, Vec<f64>) = samples.into_iter().unzip();
        for name in ["r.csv", "r.npz", "r.mat"] {
            let bytes = Table::write(name, ts, &[("u_V", &u), ("y_um", &y)]).unwrap();
            let back = Table::read(name, &bytes).unwrap().record(&ColumnSelection::default()).unwrap();
            prop_assert_eq!(back.ts().to_bits(), ts.to_bits());
            prop_assert_eq!((bits(back.u()), bits(back.y())), (bits(&u), bits(&y)));
        }
    }

    #[test]
    fn the_csv_crate_reads_what_is_written(samples in prop::collection::vec(finite(), 1..30)) {
        let text = Table::write("r.csv", 5e-4, &[("u \"V\", 1", &samples)]).unwrap();
        let mut reader = csv::Reader::from_reader(&text[..]);
        prop_assert_eq!(reader.headers().unwrap(), vec!["t_s", "u \"V\", 1"]);
        let read: Vec<f64> = reader.records().map(|row| row.unwrap()[1].parse().unwrap()).collect();
        prop_assert_eq!(read, samples);
    }
}
