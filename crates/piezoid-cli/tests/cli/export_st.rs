//! Structured text, read strictly and run, for every operator in both precisions.

use crate::bench::{Bench, skipped};
use crate::export_rust::models;
use crate::structured_text::{Library, Value};
use piezoid::export::{Wanted, target};
use std::process::Command;

#[test]
fn programs_of_the_vectors_find_no_sample_that_differs() {
    let mut tried = 0;
    for (name, model) in models() {
        for single in [false, true] {
            let made = (target("st").unwrap().make)(&Wanted { single, ..Wanted::new(&model, &name) }).unwrap();
            let texts = made.files[..2].iter().map(|file| String::from_utf8(file.bytes.clone()).unwrap());
            let library = Library::read(&texts.collect::<String>(), single);
            let mut program = library.instance(&format!("{name}_test"));
            (0..401).for_each(|_| library.cycle(&mut program));
            let Value::Struct(_, room) = program else { panic!("{name}") };
            assert_eq!(
                [&room["differs"], &room["sample"]],
                [&Value::Whole(0), &Value::Whole(400)],
                "{name}, single {single}"
            );
            tried += 1;
        }
    }
    assert!(tried >= 4, "{tried}");
}

#[test]
fn a_sample_that_differs_is_found() {
    let (name, model) = models().swap_remove(0);
    let made = (target("st").unwrap().make)(&Wanted::new(&model, &name)).unwrap();
    let texts = made.files[..2].iter().map(|file| String::from_utf8(file.bytes.clone()).unwrap());
    let text = texts.collect::<String>().replace("offset : LREAL := 2.0", "offset : LREAL := 2.0000001");
    let library = Library::read(&text, false);
    let mut program = library.instance(&format!("{name}_test"));
    (0..10).for_each(|_| library.cycle(&mut program));
    let Value::Struct(_, room) = program else { panic!("{name}") };
    assert_eq!(room["differs"], Value::Whole(10));
}

#[test]
fn the_grammar_of_twincat_takes_the_library() {
    if Command::new("blark").arg("--version").output().is_err() {
        return skipped("no blark: pip install blark");
    }
    let bench = Bench::new();
    for (name, model) in models() {
        let made = (target("st").unwrap().make)(&Wanted::new(&model, &name)).unwrap();
        bench.write("library.st", &made.files[0].bytes);
        let output = Command::new("blark").args(["parse", "library.st"]).current_dir(bench.path("")).output().unwrap();
        let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        assert!(output.status.success() && !said.contains("Failed"), "{name}\n{said}");
    }
}
