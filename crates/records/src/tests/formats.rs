//! Every format, on files of others (`golden/formats.py` writes them), whole and damaged, and on our own.

use crate::formats::{ColumnSelection, FORMATS, Table};
use crate::record::Record;
use piezoid_numerics::error::Error;

/// A file that `golden/formats.py` of piezoid-testing wrote.
macro_rules! golden {
    ($name:literal) => {
        include_bytes!(concat!("../../../testing/golden/formats/", $name))
    };
}

/// Files of one record: what reads them, and what each leaves out.
pub(super) const FILES: &[(&str, &str, &[u8], &str)] = &[
    ("csv", "record.csv", b"t_s,u_V,y_um\n0,0,0\n0.0005,1,20\n0.001,1.5,33\n0.0015,-2,-40\n", ""),
    (
        "gcs",
        "array.gcs",
        b"# REM E-709\n# SEPARATOR = 32\n# DIM = 2\n# SAMPLE_TIME = 0.0005\n# NDATA = 4\n# NAME0 = u_V\n# NAME1 = y_um\n\
          # END_HEADER\n0 0 \n1 20 \n1.5 33 \n-2 -40 \n",
        "",
    ),
    (
        "igor",
        "waves.itx",
        b"IGOR\rWAVES/D\tDrive\tGauge\rBEGIN\r\t0\t0\r\t1\t20\r\t1.5\t33\r\t-2\t-40\rEND\rX SetScale/P x 0,0.0005,\
          \"s\", Drive; SetScale y 0,0,\"V\", Drive\rX SetScale y 0,0,\"\xb5m\", Gauge\r",
        "",
    ),
    ("numpy", "fields.npy", golden!("fields.npy"), "corner (of shape 2 a row)"),
    ("numpy", "stored.npz", golden!("stored.npz"), NUMPY),
    ("numpy", "deflated.npz", golden!("deflated.npz"), NUMPY),
    ("matlab", "v4.mat", golden!("v4.mat"), "map (of shape 2 x 2)"),
    ("matlab", "v4_big.mat", golden!("v4_big.mat"), ""),
    ("matlab", "v5.mat", golden!("v5.mat"), MATLAB),
    ("matlab", "v5_big.mat", golden!("v5_big.mat"), ""),
    ("matlab", "v7.mat", golden!("v7.mat"), MATLAB),
    ("hdf5", "v73.mat", golden!("v73.mat"), HDF5),
    ("hdf5", "links.h5", golden!("links.h5"), "impedance (complex numbers)"),
    ("hdf5", "fields.h5", golden!("fields.h5"), ""),
    ("hdf5", "packed.h5", golden!("packed.h5"), ""),
    ("tdms", "log.tdms", golden!("log.tdms"), "note (text)"),
    ("tdms", "instants.tdms", golden!("instants.tdms"), SCALES),
    ("wav", "log.wav", golden!("log.wav"), ""),
];

const NUMPY: &str = "map (of shape 2 x 2), names (text), impedance (of type `<c16`), short (of 3 samples, not 4)";
const MATLAB: &str = "lines (text), map (of shape 2 x 2), impedance (complex numbers), sparse (a sparse matrix), \
                      nothing (empty), runs (structures, 1 x 2), twice (structures, 1 x 2), short (of 3 samples, not 4)";
const HDF5: &str = "cells (of class cell), empty (empty), map (of shape 2 x 2), sparse (a sparse matrix)";
const SCALES: &str = "branch (with scales that branch), heat (in counts with a scale of the kind Thermocouple)";

fn record(table: &Table) -> Result<Record, Error> {
    // The channels of a WAV file have no names.
    let wav = table.names().next() == Some("channel 1");
    let sentence = |text: &str| wav.then(|| text.to_string());
    table.record(&ColumnSelection {
        input_col: sentence("1"),
        output_col: sentence("channel 2"),
        input_unit: sentence("V"),
        output_unit: sentence("um"),
        ..ColumnSelection::default()
    })
}

/// What an error says of a channel that there is not.
fn missing(table: &Table) -> String {
    let requested = ColumnSelection { output_col: Some("no such channel".into()), ..ColumnSelection::default() };
    table.record(&requested).expect_err("there is no such channel").to_string()
}

#[test]
fn one_record_is_the_same_in_every_format_whatever_the_file_is_called() {
    let expected = Record::new(5e-4, vec![0.0, 1.0, 1.5, -2.0], vec![0.0, 20.0, 33.0, -40.0]).expect("a record");
    for (_, name, bytes, left) in FILES {
        for called in [name, "record", "record.csv", "record.mat"] {
            let table = Table::read(called, bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(record(&table).as_ref(), Ok(&expected), "{name}");
            let message = missing(&table);
            let left_out = message.split_once("; left out: ").map_or("", |(_, left)| left);
            assert_eq!(left_out, *left, "{name}");
        }
    }
}

#[test]
fn every_row_is_complete_and_knows_its_files() {
    for format in FORMATS {
        let own: Vec<_> = FILES.iter().filter(|(row, ..)| *row == format.name).collect();
        assert!(!own.is_empty(), "no file in golden/formats is of {}", format.name);
        assert!(own.iter().all(|(.., bytes, _)| (format.matches)(bytes)), "{}", format.name);
        for text in [format.name, format.summary, format.reference] {
            assert!(!text.is_empty() && !text.contains('\n'), "{}", format.name);
        }
        if let Some(write) = format.write {
            let bytes = write(5e-4, &[("u_V", &[0.0, 1.0]), ("y_um", &[2.0, -0.0])], &[]).expect("a file");
            let own = FORMATS.iter().rfind(|row| (row.matches)(&bytes)).expect("a row");
            let record = (own.read)(&bytes).and_then(|table| record(&table)).expect("a record");
            assert_eq!((own.name, record.u(), record.ts()), (format.name, &[0.0, 1.0][..], 5e-4));
        }
        for extension in format.extensions {
            let rows = FORMATS.iter().filter(|row| row.extensions.contains(extension)).count();
            assert!(rows == 1 && *extension == extension.to_lowercase(), "{}: {extension}", format.name);
        }
    }
    for (row, name, bytes, _) in FILES {
        let last = FORMATS.iter().rfind(|format| (format.matches)(bytes)).map(|format| format.name);
        assert_eq!(last, Some(*row), "{name}");
    }
}

#[test]
fn other_types_and_names_are_there_to_choose() {
    for (name, channel, expected) in [
        ("stored.npz", "counts", [-300.0, 0.0, 1.0, 300.0]),
        ("stored.npz", "armed", [0.0, 1.0, 1.0, 0.0]),
        ("fields.npy", "armed", [0.0, 1.0, 1.0, 0.0]),
        ("v4.mat", "counts", [-300.0, 0.0, 1.0, 300.0]),
        ("v7.mat", "counts", [-300.0, 0.0, 1.0, 300.0]),
        ("v5.mat", "armed", [0.0, 1.0, 1.0, 0.0]),
        ("v5.mat", "single", [0.0, 1.0, 1.5, -2.0]),
        ("v5.mat", "cells", [1.0, 2.0, 3.0, 4.0]),
        ("v7.mat", "large", [1.0, 2.0, 3.0, 9_223_372_036_854_775_808.0]),
        ("v73.mat", "armed", [0.0, 1.0, 1.0, 0.0]),
        ("links.h5", "armed", [0.0, 1.0, 1.0, 0.0]),
        ("instants.tdms", "wide", [6.0, 8.0, 9.0, 2.0]),
    ] {
        let (_, _, bytes, _) = FILES.iter().find(|(_, file, ..)| *file == name).expect("a file of the list");
        let table = Table::read(name, bytes).expect("a file that is read");
        let selection = ColumnSelection { output_col: Some(channel.into()), ..ColumnSelection::default() };
        assert_eq!(table.record(&selection).expect("a record").y(), expected, "{name}: {channel}");
    }
}

#[test]
fn a_sample_that_is_missing_in_a_packed_series_is_no_number() {
    let table = Table::read("packed.h5", golden!("packed.h5")).expect("a file that is read");
    let gaps = ColumnSelection { output_col: Some("gaps".into()), ..ColumnSelection::default() };
    let refused = table.record(&gaps).expect_err("a sample is missing").to_string();
    assert!(refused.contains("gaps"), "{refused}");
    let before = table.record(&ColumnSelection { to: Some(1.5e-3), ..gaps }).expect("a record");
    assert_eq!(before.y(), [-299.0, 1.0, 2.0]);
}

#[test]
fn what_cannot_be_read_is_told_by_what_it_should_be() {
    let message = |name: &str, bytes: &[u8]| Table::read(name, bytes).expect_err(name).to_string();
    assert_eq!(
        message("r.mat", b"nothing of the kind"),
        "cannot be read: a .mat file should hold variables of MATLAB, but this one does not start with the signature of that format: it is damaged, or has another format"
    );
    assert!(message("r.NPZ", b"PK\x03\x04").contains("a .NPZ file should hold named arrays"));
    assert!(message("r.csv", b"nothing").starts_with("there are no rows of numbers"));
    assert!(message("r.tdms", b"TDSh\x0e\0\0\0").contains("give the .tdms file beside it"));
    assert!(message("r.xlsx", b"PK\x03\x04\x14\0\x06\0").contains("a zip archive or an Excel workbook"));
    assert!(message("r.mat", b"# Created by Octave 7.3.0\n# name: t_s\n").contains("`save -v7`"));
    let plain = b"\x93NUMPY\x01\x00\x3a\x00{'descr': '<f8', 'fortran_order': False, 'shape': (0,), }\n";
    assert!(message("r.npy", plain).starts_with("the file holds one array without column names"));
}

#[test]
fn a_damaged_file_is_read_or_refused_wherever_it_is_cut_or_changed() {
    for (_, name, bytes, _) in FILES.iter().filter(|(row, ..)| *row != "csv") {
        for end in 0..bytes.len() {
            drop(Table::read(name, &bytes[..end]).map(|table| record(&table)));
        }
        let mut changed = bytes.to_vec();
        for at in 0..bytes.len() {
            for flip in [0x01, 0x80, 0xff] {
                changed[at] ^= flip;
                drop(Table::read(name, &changed).map(|table| record(&table)));
                changed[at] ^= flip;
            }
        }
        for at in 0..bytes.len().saturating_sub(8) {
            // A length, place or count that is as large as can be.
            changed[at..at + 8].fill(0xff);
            drop(Table::read(name, &changed).map(|table| record(&table)));
            changed[at..at + 8].copy_from_slice(&bytes[at..at + 8]);
        }
        let half = Table::read(name, &bytes[..bytes.len() / 2]).and_then(|table| record(&table));
        assert!(half.is_err(), "{name}");
    }
}
