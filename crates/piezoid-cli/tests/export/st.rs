//! Structured text, read strictly and executed, for every operator in both precisions.

use crate::structured_text::{Library, Value};
use crate::{exported, models, there};
use piezoid_export::{ExportRequest, ExportTarget};
use std::process::Command;

#[test]
fn programs_of_the_vectors_find_no_sample_that_differs() {
    let mut tried = 0;
    for (name, model) in models() {
        for single in [false, true] {
            let result =
                (ExportTarget::find("st").unwrap().make)(&ExportRequest::new(&model, &name).single(single)).unwrap();
            let texts = result.files[..2].iter().map(|file| String::from_utf8(file.bytes.clone()).unwrap());
            let library = Library::read(&texts.collect::<String>(), single);
            let mut program = library.instance(&format!("{name}_test"));
            (0..401).for_each(|_| library.cycle(&mut program));
            let Value::Struct(_, room) = program else { panic!("{name}") };
            assert_eq!(
                [&room["differs"], &room["sample"]],
                [&Value::ExportedProgram(0), &Value::ExportedProgram(400)],
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
    let result = (ExportTarget::find("st").unwrap().make)(&ExportRequest::new(&model, &name)).unwrap();
    let texts = result.files[..2].iter().map(|file| String::from_utf8(file.bytes.clone()).unwrap());
    let text = texts.collect::<String>().replace("offset : LREAL := 2.0", "offset : LREAL := 2.0000001");
    let library = Library::read(&text, false);
    let mut program = library.instance(&format!("{name}_test"));
    (0..10).for_each(|_| library.cycle(&mut program));
    let Value::Struct(_, room) = program else { panic!("{name}") };
    assert_eq!(room["differs"], Value::ExportedProgram(10));
}

#[test]
fn the_grammar_of_twincat_takes_the_library() {
    if !there("blark") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    // For long tables, blark takes minutes and gigabytes.
    let brief = ["proportional", "prandtl_ishlinskii", "bouc_wen", "duhem", "driven_plays"];
    for (name, model) in models().into_iter().filter(|(name, _)| brief.contains(&name.as_str())) {
        exported("st", &ExportRequest::new(&model, &name), folder.path());
        let file = format!("{name}.st");
        let output = Command::new("blark").args(["parse", &file]).current_dir(folder.path()).output().unwrap();
        let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        // blark exits with success whatever it finds.
        assert!(output.status.success() && !text.contains("Failed"), "{name}\n{text}");
    }
}
