//! Certificates: the files that the verb writes, and other programs that compute and read them; see `certificate.py`.

use crate::bench::Bench;
use piezoid_testing::skipped;
use std::process::Command;

/// What is stated in all tests.
const STATED: &str = "--sensor-calibration 0.5% --sensor-linearity 200nm --resolution 10nm --drift 0.1um \
     --temperature-coefficient 0.05% --temperature-half-width 2 --voltage-gain 0.1% --voltage-offset 5mV \
     --date 2026-11-30 --country CZ --issuer Lab --customer Works --item pl140 --serial 7 --sensor laser \
     --temperature 22";

/// A bench with a record that the model was not identified from.
fn bench() -> Bench {
    let bench = Bench::stocked();
    bench.run("excite sine --amplitude 20V --frequency 9Hz --ts 0.5ms --duration 1s -o u9.csv").ok();
    bench.run("simulate u9.csv --plant paper -o sine9.csv").ok();
    bench
}

/// Runs `certificate.py` with these words; what it printed, or `None` if the package is missing.
fn python(bench: &Bench, package: &str, words: &[&str]) -> Option<String> {
    let found = |words: &[&str]| Command::new("python3").args(words).output().ok();
    if !found(&["-c", &format!("import {package}")]).is_some_and(|output| output.status.success()) {
        skipped(&format!("no {package}"));
        return None;
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/certificate.py");
    let file = bench.path(words[1]);
    let output = found(&[script, words[0], file.to_str().unwrap()]).unwrap();
    let [printed, wrong] = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    assert!(output.status.success(), "{printed}{wrong}");
    Some(printed)
}

#[test]
fn the_page_the_xml_and_the_numbers_are_of_one_certificate_and_always_the_same() {
    let bench = bench();
    let command = format!("certificate sine9.csv --model model.json {STATED} --dcc a.xml --json a.json -o");
    let printed = bench.run(&format!("{command} a.html")).ok().out;
    let first = bench.files();
    bench.run(&format!("{command} a.html")).ok();
    assert_eq!(bench.files(), first);
    bench.run(&format!("certificate sine9.csv --model model.json {STATED} -o b.XML")).ok();
    assert_eq!(bench.bytes("b.XML"), bench.bytes("a.xml"));
    let (page, xml, found) = (bench.text("a.html"), bench.text("a.xml"), bench.json("a.json"));
    let number = found["number"].as_str().unwrap();
    assert!(page.contains(number) && xml.contains(number));
    for hash in [&found["model_sha256"], &found["records"][0]["sha256"]] {
        let hash = hash.as_str().unwrap();
        assert!(hash.len() == 64 && page.contains(hash) && xml.contains(hash), "{hash}");
    }
    assert!(found["not_stated"].as_array().unwrap().is_empty());
    assert!(printed.contains("calibration of the sensor") && printed.contains("wrote a.html"), "{printed}");
    assert!(page.contains("not issued by an accredited laboratory"));
}

#[test]
fn budgets_are_those_of_gtc() {
    let bench = bench();
    bench.run(&format!("certificate sine9.csv --model model.json {STATED} --json a.json")).ok();
    bench.run("certificate sine9.csv --model model.json --coverage 99 --offset free --noise sensor --json b.json").ok();
    for file in ["a.json", "b.json"] {
        let Some(printed) = python(&bench, "GTC", &["budget", file]) else { return };
        assert!(printed.contains("budgets agree"), "{printed}");
    }
}

#[test]
fn the_xml_is_valid_in_dcclib() {
    let bench = bench();
    bench.run(&format!("certificate sine9.csv --model model.json {STATED} -o a.xml")).ok();
    bench
        .run("certificate sine9.csv --model model.json --date 2026-11-30 --country CZ --mean-error corrected -o b.xml")
        .ok();
    for file in ["a.xml", "b.xml"] {
        let Some(printed) = python(&bench, "dcclib", &["dcc", file]) else { return };
        assert!(printed.contains("Schematron: valid"), "{printed}");
        // CI may be without a network.
        if !printed.contains("schema: valid") && std::env::var_os("CI").is_none() {
            skipped(&format!("no schema of the PTB, and PIEZOID_DCC_SCHEMA names none: {printed}"));
        }
    }
}

#[test]
fn what_is_wrong_is_said_in_the_words_of_the_command_line() {
    let bench = bench();
    let refused = |words: &str| {
        let run = bench.run(&format!("certificate {words} --model model.json"));
        assert!(run.code != Some(0), "{run:?}");
        run.err
    };
    let training = refused("sine5.csv");
    assert!(training.contains("sine5.csv: the model was identified from this record"), "{training}");
    let volts = refused("sine9.csv --sensor-linearity 5mV");
    assert!(volts.contains("--sensor-linearity 5mV: must be a positive length, in um"), "{volts}");
    let xml = refused("sine9.csv -o a.xml");
    assert!(xml.contains("has a date and a country: give --date --country"), "{xml}");
    let kelvin = refused("sine9.csv --temperature-half-width 2");
    assert!(kelvin.contains("give --temperature-coefficient"), "{kelvin}");
    for words in ["sine9.csv --coverage 100", "sine9.csv --sensor-calibration -1%", "sine9.csv --date 30.11.2026"] {
        assert!(refused(words).contains("must be"), "{words}");
    }
    assert!(!bench.names().iter().any(|name| name.starts_with("a.")));
}
