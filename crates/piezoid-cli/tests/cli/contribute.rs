//! `contribute`: records that are packed, and archives that are checked.

use crate::bench::{Bench, Run, number};

/// Runs `contribute` with these words and with texts that have spaces.
fn contribute(bench: &Bench, words: &str) -> Run {
    let mut command = bench.command("contribute");
    command.args(["--actuator", "P-885.91 stack", "--driver", "an amplifier, gain 10"]);
    command.args(["--sensor", "capacitive", "--who", "A. Name, Lab"]).args(words.split_whitespace());
    Run::of(words, &command.output().unwrap())
}

#[test]
fn records_are_packed_byte_for_byte_and_read_again() {
    let bench = Bench::stocked();
    let words = "sine5.csv sine20.csv prbs.csv --licence CC-BY-4.0 --json a.json -o";
    let packed = contribute(&bench, &format!("{words} a.zip")).ok();
    packed.prints(&["small-signal", "wrote a.zip, sent nothing:\ndocs/contributing-records.md says"]);
    let archive = bench.bytes("a.zip");
    contribute(&bench, &format!("{words} b.zip")).ok();
    assert_eq!(archive, bench.bytes("b.zip"), "the same files give the same bytes");
    for name in ["sine5.csv", "sine20.csv", "prbs.csv"] {
        let bytes = bench.bytes(name);
        assert!(archive.windows(bytes.len()).any(|window| window == bytes), "{name}");
    }
    let stated = bench.json("a.json");
    assert_eq!(stated["statement"]["who"], "A. Name, Lab");
    assert_eq!((stated["files"].as_array().unwrap().len(), number(&stated["files"][2]["samples"])), (3, 4095.0));
    let received = bench.run("contribute --check a.zip --json -").ok();
    assert_eq!(received.out_json(), stated);
    bench.run("contribute --check a.zip").ok().prints(&["sine20.csv", "3 records of P-885.91 stack", "as piezoid"]);
    // Without a file to write it only checks, and no folder stands in the names.
    let before = bench.names();
    contribute(&bench, "sine5.csv --licence CC0-1.0").ok().prints(&["give -o"]).says(&["there is one record"]);
    assert_eq!(bench.names(), before);
}

#[test]
fn a_changed_archive_is_refused_by_the_name_of_the_file() {
    let bench = Bench::stocked();
    contribute(&bench, "sine5.csv sine20.csv --licence CC-BY-4.0 -o a.zip").ok();
    let mut archive = bench.bytes("a.zip");
    let row = bench.bytes("sine20.csv")[900..940].to_vec();
    let at = archive.windows(row.len()).rposition(|window| window == row).unwrap();
    archive[at] ^= 1;
    bench.write("changed.zip", archive);
    bench.refused("contribute --check changed.zip").says(&["changed.zip: ", "sine20.csv"]);
    bench.refused("contribute --check sine5.csv").says(&["sine5.csv: this is no contribution"]);
    bench.misused("contribute --check a.zip --input-col u_V").says(&["leave out all other options"]);
    bench.run("contribute sine5.csv --check a.zip").exits(2);
}

#[test]
fn what_is_missing_is_an_error_in_the_words_of_the_command_line() {
    let bench = Bench::stocked();
    let run = contribute(&bench, "sine5.csv -o a.zip").exits(2);
    run.says(&["a contribution has a licence", "give --licence \"CC-BY-4.0\" or --licence \"CC0-1.0\""]);
    contribute(&bench, "sine5.csv --licence CC-BY-3.0 -o a.zip").exits(2).says(&["tip", "CC-BY-4.0"]);
    bench.misused("contribute sine5.csv --licence CC0-1.0 --who me").says(&["give --actuator --driver --sensor"]);
    bench.run("contribute").exits(2);
    std::fs::create_dir(bench.path("more")).unwrap();
    bench.write("more/sine5.csv", bench.text("sine20.csv"));
    let run = contribute(&bench, "sine5.csv more/sine5.csv --licence CC0-1.0 -o a.zip").exits(1);
    run.says(&["more/sine5.csv: two files are called sine5.csv"]);
    bench.write("volts.csv", bench.text("sine5.csv").replacen("y_um", "y_V", 1));
    let run = contribute(&bench, "volts.csv --licence CC0-1.0 -o a.zip").exits(1);
    run.says(&["volts.csv: the output is in V, which is no displacement", "--output-scale \"5um/V\""]);
    assert!(!bench.names().contains(&"a.zip".to_string()));
    contribute(&bench, "volts.csv --licence CC0-1.0 --output-scale 5um/V -o a.zip").ok();
    bench.run("contribute --check a.zip").ok().prints(&["um"]);
}
