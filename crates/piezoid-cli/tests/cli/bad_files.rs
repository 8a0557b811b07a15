//! Damaged and unsuitable files: each gives one message, and nothing is written.

use crate::bench::Bench;
use std::path::Path;

/// A data file, and texts that the message on it must contain. `input`: true if the input is bad too.
struct Bad {
    name: &'static str,
    bytes: &'static [u8],
    says: &'static [&'static str],
    input: bool,
}

const fn bad(name: &'static str, bytes: &'static [u8], says: &'static [&'static str]) -> Bad {
    Bad { name, bytes, says, input: true }
}

/// A file that is bad only for verbs that need the output.
const fn bad_output(name: &'static str, bytes: &'static [u8], says: &'static [&'static str]) -> Bad {
    Bad { name, bytes, says, input: false }
}

const BAD: &[Bad] = &[
    bad("short.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,1\n1e-3,1,2\n", &["line 3", "2 fields", "3 columns", "complete"]),
    bad("long.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,1,2,3\n", &["line 3", "4 fields", "3 columns", "remove"]),
    bad("cut.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,1,1\n1e-3,2", &["line 4", "cut short", "delete"]),
    bad("word.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,abc,2\n", &["line 3", "column u_V", "`abc`"]),
    bad("hole.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,,2\n", &["line 3", "column u_V"]),
    bad("nan.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,NaN,2\n", &["line 3", "column u_V", "`NaN`", "repair"]),
    bad("inf.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,1,2\n1e-3,-inf,2\n", &["line 4", "column u_V", "`-inf`"]),
    bad("overflow.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,1e999,2\n", &["line 3", "column u_V", "`1e999`"]),
    bad_output("y-word.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,1,none\n1e-3,1,1\n", &["line 3", "column y_um", "`none`"]),
    bad_output("y-nan.csv", b"t_s,u_V,y_um\n0,0,nan\n5e-4,1,2\n", &["line 2", "column y_um", "`nan`"]),
    bad(
        "gap.csv",
        b"t_s,u_V,y_um\n0,0,0\n5e-4,1,1\n1e-3,1,1\n2e-3,1,1\n2.5e-3,1,1\n3e-3,1,1\n",
        &["line 5", "column t_s", "0.001 s", "0.0005 s", "1 row seems to be missing", "split"],
    ),
    bad("back.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,1,1\n2e-4,1,1\n", &["line 4", "column t_s", "goes back", "0.0002 s"]),
    bad(
        "still.csv",
        b"t_s,u_V,y_um\n0,0,0\n5e-4,1,1\n5e-4,1,1\n",
        &["line 4", "column t_s", "two rows have the time 0.0005 s", "--ts"],
    ),
    bad("slow.csv", b"time,u_V,y_um\n0,0,0\n1,1,1\n2,2,2\n", &["line 1", "column time", "steps are 1", "--time-unit"]),
    bad("one.csv", b"t_s,u_V,y_um\n0,0,0\n", &["line 2", "column t_s", "--ts"]),
    bad("no-time.csv", b"u_V,y_um\n0,0\n1,2\n", &["line 1", "no time column", "--ts"]),
    bad("no-input.csv", b"t_s,aux,y_um\n0,0,0\n5e-4,1,1\n", &["line 1", "no input column", "--input-col \"aux\""]),
    bad_output(
        "no-output.csv",
        b"t_s,u_V,aux\n0,0,0\n5e-4,1,1\n",
        &["line 1", "no output column", "--output-col \"aux\""],
    ),
    bad(
        "twice.csv",
        b"t_s,u_V,u_V,y_um\n0,0,0,0\n5e-4,1,1,1\n",
        &["line 1", "column 3", "`u_V`", "by its number", "--input-col"],
    ),
    bad_output(
        "two-outputs.csv",
        b"t_s,u_V,y_um,y_mm\n0,0,0,0\n5e-4,1,1,1\n",
        &["line 1", "`y_um`, `y_mm`", "--output-col"],
    ),
    bad("two-inputs.csv", b"t_s,u_a,u_b,y_um\n0,0,0,0\n5e-4,1,1,1\n", &["line 1", "`u_a`, `u_b`", "--input-col"]),
    bad("empty.csv", b"", &["empty", "header"]),
    bad("bare.csv", b"t_s,u_V,y_um\n", &["no rows of numbers", "t_s,u_V,y_um"]),
    bad("headless.csv", b"0,0,0\n5e-4,1,1\n", &["line 1", "no names", "numbers from 1 to 3", "--input-col"]),
    bad("thousands.csv", b"t_s,u_V,y_um\n0,0,5,1,2,0\n", &["line 2", "6 fields", "decimal commas", "semicolons"]),
    bad("mixed.csv", b"t_s;u_V;y_um\n0,0;0.5;0,0\n0,0005;1.5;1,0\n", &["line 2", "decimal comma", "decimal point"]),
    bad("quote.csv", b"t_s,u_V,y_um\n0,\"0,0\n5e-4,1,1\n", &["line 2"]),
    bad("nul.csv", b"t_s,u_V,y_um\n0,0,0\n5e-4,1,\x001\n", &["line 3", "NUL"]),
    bad("elf.csv", b"\x7fELF\x02\x01\x01\x00\x00\xff\xfe\x80", &["not text with columns"]),
    bad("book.csv", b"PK\x03\x04\x14\x00", &["zip archive", "as CSV"]),
    bad("model.csv", b"{\"piezoid\": 1}", &["JSON"]),
    bad("page.csv", b"<html></html>", &["web page"]),
];

#[test]
fn a_bad_data_file_is_refused_by_every_verb_that_reads_it() {
    let bench = Bench::stocked();
    for file in BAD {
        bench.write(file.name, file.bytes);
    }
    for Bad { name, says, input, .. } in BAD {
        let says: Vec<&str> = [&[*name], *says].concat();
        bench.refused(&format!("validate --model model.json --data {name} --json figures.json")).says(&says);
        bench.refused(&format!("report --model model.json --data {name} -o page.html")).says(&says);
        bench.refused(&format!("identify --data {name} -o new.json --json found.json")).says(&says);
        bench
            .refused(&format!("identify --small-signal prbs.csv --large-signal sine5.csv {name} -o new.json"))
            .says(&says);
        if *input {
            bench.refused(&format!("simulate --plant paper --input {name} -o y.csv")).says(&says);
            bench.refused(&format!("simulate --model model.json --input {name} -o y.csv")).says(&says);
        }
    }
}

#[test]
fn a_column_that_is_not_needed_may_hold_anything() {
    let bench = Bench::stocked();
    for file in BAD.iter().filter(|file| !file.input) {
        bench.write(file.name, file.bytes);
        bench.run(&format!("simulate --plant paper --input {} -o y.csv", file.name)).ok();
    }
}

#[test]
fn the_same_record_in_another_dress_gives_the_same_figures() {
    let bench = Bench::stocked();
    let plain = bench.text("sine5.csv");
    let european = plain.replace(',', ";").replace('.', ",");
    let bom = format!("\u{feff}{plain}");
    let more = plain.replace('\n', ",x\n").replacen(",x", ",remark", 1);
    let remarks = format!("# measured on a Monday\n\n{plain}\n\n");
    let dresses = [
        ("crlf.csv", plain.replace('\n', "\r\n")),
        ("tab.tsv", plain.replace(',', "\t")),
        ("excel.csv", bom.replace('\n', "\r\n").replace(',', ";").replace('.', ",")),
        ("semicolon.csv", european),
        ("bom.csv", bom),
        ("mac.csv", plain.replace('\n', "\r")),
        ("extra.csv", more),
        ("quoted.csv", plain.replacen("t_s,u_V,y_um", "\"t_s\", \"u_V\", \"y_um\"", 1)),
        ("comments.txt", remarks),
        ("units.csv", plain.replacen("t_s,u_V,y_um", "Time,Drive voltage,Position\ns,V,um", 1)),
        ("words.txt", plain.replacen("t_s,u_V,y_um", "# Time (s)  Voltage (V)  Position (um)", 1).replace(',', "   ")),
        ("gaps.csv", plain.replacen('\n', "\n\n", 3) + "\nend of the record\n"),
    ];
    let figures = |name: &str| {
        let mut json = bench.run(&format!("validate --model model.json --data {name} --json -")).ok().out_json();
        json["files"][0]["file"].take();
        json
    };
    let encoded = plain.replacen("y_um", "Weg [\u{b5}m]", 1);
    let utf16: Vec<u8> = encoded.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let latin: Vec<u8> = encoded.chars().map(|c| c as u8).collect();
    let dresses = dresses.map(|(name, text)| (name, text.into_bytes()));
    for (name, bytes) in dresses.into_iter().chain([("utf16.csv", utf16), ("latin.csv", latin)]) {
        bench.write(name, bytes);
        assert_eq!(figures(name), figures("sine5.csv"), "{name}");
    }
}

#[test]
fn files_of_other_programs_are_read_like_csv_and_refused_by_name() {
    let bench = Bench::new();
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../piezoid/tests/golden/formats");
    bench.write("plain.csv", "t_s,u_V,y_um\n0,0,0\n0.0005,1,20\n0.001,1.5,33\n0.0015,-2,-40\n");
    bench.run("simulate --plant paper --input plain.csv -o wanted.csv").ok();
    for name in ["fields.npy", "deflated.npz", "v4.mat", "v7.mat", "v73.mat", "links.h5"] {
        let whole = std::fs::read(golden.join(name)).unwrap();
        bench.write(name, &whole);
        bench.run(&format!("simulate --plant paper --input {name} -o y.csv")).ok();
        assert_eq!(bench.text("y.csv"), bench.text("wanted.csv"), "{name}");
        bench.write(name, &whole[..whole.len() / 2]);
        bench.refused(&format!("simulate --plant paper --input {name} -o half.csv")).says(&[name, "damaged"]);
    }
    bench.write("log.mat", "nothing of the kind");
    bench.refused("simulate --plant paper --input log.mat -o y.csv").says(&["log.mat", "variables of MATLAB"]);
}

#[test]
fn what_cannot_be_opened_is_named_with_what_to_do() {
    let bench = Bench::stocked();
    std::fs::create_dir(bench.path("folder")).unwrap();
    for (name, says) in [("none.csv", "no such file"), ("folder", "this is a folder"), ("log.mat", "no such file")] {
        bench.refused(&format!("validate --model model.json --data {name} --json f.json")).says(&[name, says]);
        bench.refused(&format!("identify --data {name} -o new.json")).says(&[name, says]);
        bench.refused(&format!("simulate --plant paper --input {name} -o y.csv")).says(&[name, says]);
    }
    for (name, says) in [("none.json", "no such file"), ("folder", "this is a folder")] {
        bench.refused(&format!("validate --model {name} --data sine5.csv")).says(&[name, says]);
        bench.refused(&format!("simulate --model {name} --input sine5.csv -o y.csv")).says(&[name, says]);
    }
    bench.refused("simulate --plant none.json --input sine5.csv -o y.csv").says(&["none.json", "no such file"]);
}
