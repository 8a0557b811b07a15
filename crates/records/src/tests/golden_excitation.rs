//! Excitations compared with scipy; `golden/*.py` write the numbers.

use crate::excitation::{Chirp, Prbs};
use piezoid_testing::assert_named_close;
use piezoid_testing::golden::{number, numbers, rows, text};

/// The bits of a PRBS of 1 V, in the format of scipy's script.
fn bits(prbs: &Prbs, n: usize) -> String {
    let u = prbs.samples(1.0, n).expect("a sequence that scipy makes");
    u.iter().map(|v| if *v > 0.0 { '1' } else { '0' }).collect()
}

#[test]
fn prbs_is_scipys_max_len_seq() {
    let rows = rows("max_len_seq");
    assert_eq!(rows.len(), 30);
    for row in rows {
        let order = row["order"].as_u64().expect("order") as u32;
        let seed = row["seed"].as_u64().expect("seed") as u32;
        assert_eq!(bits(&Prbs { order, ..Prbs::default() }, 64), row["from_ones"], "order {order}");
        assert_eq!(bits(&Prbs { order, seed, ..Prbs::default() }, 64), row["from_seed"], "order {order}, seed {seed}");
        if let (Some(ones), Some(sum)) = (row["ones"].as_u64(), row["sum_of_positions"].as_u64()) {
            let prbs = Prbs { order, ..Prbs::default() };
            let period = bits(&prbs, prbs.period() as usize);
            let positions: Vec<u64> =
                (0..).zip(period.chars()).filter(|(_, bit)| *bit == '1').map(|(t, _)| t).collect();
            assert_eq!((positions.len() as u64, positions.iter().sum::<u64>()), (ones, sum), "order {order}");
        }
    }
}

#[test]
fn chirp_is_scipys_chirp() {
    for row in rows("chirp") {
        let expected = numbers(&row, "u");
        let chirp = Chirp {
            frequency_start: number(&row, "start"),
            frequency_end: number(&row, "end"),
            logarithmic: row["method"] != "linear",
            ..Chirp::default()
        };
        let u = chirp.samples(5e-4, expected.len()).expect("a sweep that scipy makes");
        assert_named_close(text(&row, "method"), &u, &expected, 0.0, 1e-10);
    }
}
