use super::*;
use piezoid_records::formats::unpacked;
use piezoid_testing::noise;
use serde_json::json;
use std::f64::consts::TAU;

/// A record of this input [V] at 1 kHz, at rest for the first tenth, with a lag, in these units.
fn file(name: &str, header: &str, u: impl Fn(f64) -> f64) -> File {
    let (mut text, mut y) = (format!("{header}\n"), 0.0);
    for k in 0..2000 {
        let t = 1e-3 * f64::from(k);
        let u = if t < 0.2 { 0.0 } else { u(t - 0.2) };
        y += 0.2 * (2.0 * u - y);
        text += &format!("{t:.3},{u:.6},{y:.6}\n");
    }
    File::new(name, text)
}

fn sine(name: &str, hz: f64) -> File {
    file(name, "t_s,u_V,y_um", move |t| 25.0 * (TAU * hz * t).sin())
}

/// A large sine, another one, and steps within their range.
fn three() -> Vec<File> {
    let levels = noise(8, 60);
    let steps = |t: f64| (8.0 * levels[(t / 0.03) as usize % 60]).clamp(-24.0, 24.0);
    vec![sine("lab/a.csv", 5.0), sine("b.csv", 20.0), file("c.csv", "t_s,u_V,y_um", steps)]
}

fn stated() -> ContributeOptions {
    let text = |text: &str| Some(text.to_string());
    ContributeOptions {
        licence: Some(Licence::Attribution),
        actuator: text("a stack"),
        driver: text("an amplifier"),
        sensor: text("a capacitive sensor"),
        who: text("A. Name"),
        conditions: None,
    }
}

fn packed(files: Vec<File>) -> Result<Contributed, String> {
    stated().run(Source::all(files, &ColumnSelection::default())).map_err(|error| error.to_string())
}

fn checked(members: Vec<(String, Vec<u8>)>) -> Result<Contributed, String> {
    let archive = formats::archive(members.into_iter()).unwrap();
    Contributed::check(&File::new("in/c.zip", archive)).map_err(|error| error.to_string())
}

/// The members of the archive of [`three`].
fn members() -> Vec<(String, Vec<u8>)> {
    unpacked(&packed(three()).unwrap().archive().unwrap()).unwrap()
}

#[test]
fn an_archive_has_the_files_as_they_are_and_is_always_the_same() {
    let (files, found) = (three(), packed(three()).unwrap());
    let archive = found.archive().unwrap();
    assert_eq!(archive, packed(three()).unwrap().archive().unwrap());
    let members = unpacked(&archive).unwrap();
    let names: Vec<&str> = members.iter().map(|(name, _)| &**name).collect();
    assert_eq!(names, ["contribution.json", "SOURCE.md", "a.csv", "b.csv", "c.csv"]);
    for (file, (_, bytes)) in files.iter().zip(&members[2..]) {
        assert_eq!(&file.bytes, bytes);
    }
    let document: Value = serde_json::from_slice(&members[0].1).unwrap();
    assert_eq!(document, found.to_json());
    assert_eq!(document["statement"]["licence"], "CC-BY-4.0");
    let first = &document["files"][0];
    assert_eq!((&first["samples"], &first["ts"], &first["units"]["y"]), (&json!(2000), &json!(1e-3), &json!("um")));
    assert_eq!(first["sha256"], sha256(&files[0].bytes));
    let source = String::from_utf8(members[1].1.clone()).unwrap();
    for part in
        ["# a stack", "- Measured by: A. Name", "- Conditions: not stated", "CC BY 4.0", "`c.csv`: 2000 samples"]
    {
        assert!(source.contains(part), "{part}: {source}");
    }
    assert!(source.contains(&sha256(&files[2].bytes)));
}

#[test]
fn an_archive_that_was_received_is_read_as_it_was_packed() {
    let received = checked(members()).unwrap();
    assert_eq!(received.to_json(), packed(three()).unwrap().to_json());
    assert_eq!(received.archive().unwrap(), packed(three()).unwrap().archive().unwrap());
    // With columns and scales that only the one who measured knows.
    let columns = ColumnSelection {
        input_col: Some("CH1 (V)".into()),
        output_col: Some("CH2 (V)".into()),
        output_scale: Some("5um/V".into()),
        ..ColumnSelection::default()
    };
    let scope = file("scope.csv", "TIME (s),CH1 (V),CH2 (V)", |t| 20.0 * (30.0 * t).sin());
    let found = stated().run(Source::all(vec![scope], &columns)).unwrap();
    let received = Contributed::check(&File::new("c.zip", found.archive().unwrap())).unwrap();
    assert_eq!((received.to_json(), &*received.files()[0].units.y), (found.to_json(), "um"));
}

#[test]
fn a_file_that_was_changed_added_or_lost_is_named() {
    let mut changed = members();
    changed[3].1[40] ^= 1;
    let message = checked(changed).unwrap_err();
    assert!(message.starts_with("in/c.zip: b.csv: was changed: its SHA-256 is "), "{message}");
    let mut archive = packed(three()).unwrap().archive().unwrap();
    let at = archive.len() - 2000;
    archive[at] ^= 1;
    let message = Contributed::check(&File::new("c.zip", archive)).unwrap_err().to_string();
    assert!(message.contains("the checksum of \"c.csv\" is wrong"), "{message}");
    let mut lost = members();
    lost.remove(4);
    assert!(checked(lost).unwrap_err().starts_with("in/c.zip: c.csv: contribution.json states this file, but"));
    let mut added = members();
    added.push(("../d.csv".into(), b"t_s,u_V,y_um\n".to_vec()));
    assert!(
        checked(added)
            .unwrap_err()
            .contains("../d.csv: is in the archive twice, or contribution.json does not state it")
    );
    let mut twice = members();
    twice.push(twice[2].clone());
    assert!(checked(twice).unwrap_err().contains("c.zip: a.csv: is in the archive twice"));
    let other = Contributed::check(&File::new("x.csv", "t_s,u_V,y_um\n")).unwrap_err().to_string();
    assert!(other.contains("x.csv: this is no contribution: it has no contribution.json"), "{other}");
}

#[test]
fn no_damage_of_an_archive_is_accepted_or_panics() {
    let rows =
        (0..40).map(|k| format!("{},{},{}\n", 1e-3 * f64::from(k), f64::from(k * 7 % 40), f64::from(k * 7 % 40)));
    let small = File::new("s.csv", format!("t_s,u_V,y_um\n{}", rows.collect::<String>()));
    let archive = packed(vec![small]).unwrap().archive().unwrap();
    let check = |bytes: Vec<u8>| Contributed::check(&File::new("c.zip", bytes));
    let whole = check(archive.clone()).unwrap().to_json();
    let records = archive.windows(12).position(|window| window == b"t_s,u_V,y_um").unwrap();
    for end in (0..archive.len()).step_by(7) {
        assert!(check(archive[..end].to_vec()).is_err(), "the first {end} bytes");
    }
    for at in (0..archive.len()).step_by(5) {
        let mut bytes = archive.clone();
        bytes[at] ^= 0x10;
        // A date or a text for people may differ, the record not.
        let found = check(bytes).map(|found| found.to_json());
        assert!(found.as_ref().map_or(true, |found| *found == whole), "byte {at}");
        assert!(!(records..records + 200).contains(&at) || found.is_err(), "byte {at}");
    }
}

#[test]
fn what_the_document_states_must_hold() {
    let with = |change: &dyn Fn(&mut Value)| {
        let mut members = members();
        let mut document: Value = serde_json::from_slice(&members[0].1).unwrap();
        change(&mut document);
        members[0].1 = document.to_string().into();
        checked(members).unwrap_err()
    };
    let samples = with(&|document| document["files"][1]["samples"] = json!(1999));
    assert!(samples.contains("b.csv: is read as") && samples.contains("2000 samples every 0.001 s"), "{samples}");
    let units = with(&|document| document["files"][0]["units"]["y"] = json!("nm"));
    assert!(units.contains("states") && units.contains("y in nm"), "{units}");
    let column = with(&|document| document["files"][0]["columns"]["output_col"] = json!("z"));
    assert!(column.contains("a.csv"), "{column}");
    let licence = with(&|document| document["statement"]["licence"] = json!("MIT"));
    assert!(licence.contains("licence = MIT: must be CC-BY-4.0 or CC0-1.0"), "{licence}");
    let none = with(&|document| document["statement"]["who"] = json!(" "));
    assert!(none.contains("`who`"), "{none}");
    let schema = with(&|document| document["piezoid_contribution"] = json!(2));
    assert!(schema.contains("its schema number is 2, and this version reads 1"), "{schema}");
}

#[test]
fn nothing_is_packed_without_a_licence_and_the_equipment() {
    let of = |options: ContributeOptions| options.stated().unwrap_err().to_string();
    let licence = of(ContributeOptions { licence: None, ..stated() });
    assert!(licence.contains("`licence` = \"CC-BY-4.0\" or `licence` = \"CC0-1.0\""), "{licence}");
    let missing = of(ContributeOptions { sensor: None, actuator: Some("  ".into()), ..stated() });
    assert!(missing.ends_with("give `actuator`, `sensor`"), "{missing}");
    let lines = of(ContributeOptions { conditions: Some("hot\n# x".into()), ..stated() });
    assert!(lines.contains("conditions") && lines.contains("one line"), "{lines}");
    let unknown = ContributeOptions::default();
    assert!(unknown.run(Source::all(three(), &ColumnSelection::default())).is_err());
}

#[test]
fn files_that_cannot_be_used_are_refused_by_name() {
    let with = |other: File| packed(vec![sine("a.csv", 5.0), other]).unwrap_err();
    let volts = with(file("v.csv", "t_s,u_V,y_V", |t| 20.0 * (30.0 * t).sin()));
    assert!(volts.starts_with("v.csv: the output is in V, which is no displacement"), "{volts}");
    let amperes = with(file("i.csv", "t_s,u_A,y_um", |t| 20.0 * (30.0 * t).sin()));
    assert!(amperes.starts_with("i.csv: the input is in A, which is no voltage"), "{amperes}");
    let undecided = with(file("n.csv", "A,B,C", |t| 20.0 * (30.0 * t).sin()));
    assert!(undecided.starts_with("n.csv: ") && undecided.contains("`input_col`"), "{undecided}");
    assert!(with(File::new("x.csv", [0u8, 1, 2, 255])).starts_with("x.csv: "));
    assert!(with(sine("other/A.csv", 6.0)).contains("two files are called A.csv"));
    assert!(with(sine("source.md", 6.0)).contains("the archive has a file source.md of its own"));
    assert!(with(sine("again.csv", 5.0)).contains("has the same bytes as a.csv"));
    let mut prepared = Source::all(vec![sine("a.csv", 5.0)], &ColumnSelection::default());
    prepared[0].preparation = vec![crate::Step::OutputIn("nm".into())];
    assert!(stated().run(prepared).unwrap_err().to_string().contains("as they were measured"));
}

#[test]
fn what_makes_records_less_useful_is_found() {
    let all = packed(three()).unwrap();
    assert_eq!(all.files()[2].proposed["use"], "validation");
    let found = all.findings();
    assert!(found.len() == 1 && found[0].contains("no small-signal record"), "{found:?}");
    assert!(all.files().iter().all(|file| file.findings.is_empty()), "{:?}", all.files());
    let one = packed(vec![sine("a.csv", 5.0)]).unwrap();
    assert!(one.findings()[0].starts_with("there is one record"), "{:?}", one.findings());
    assert!(one.findings().iter().any(|text| text.contains("all cycles have about 5 Hz")), "{:?}", one.findings());
    let alike = packed(vec![sine("a.csv", 5.0), sine("b.csv", 5.5)]).unwrap();
    assert!(alike.findings()[0].contains("no record is of another kind"), "{:?}", alike.findings());
    let cut: String = "t_s,u_V,y_um\n".to_string()
        + &(0..2000)
            .map(|k| format!("{},{},{}\n", 1e-3 * f64::from(k), 25.0 * (0.03 * f64::from(k) + 1.0).sin(), k % 7))
            .collect::<String>();
    let moving = packed(vec![File::new("m.csv", cut)]).unwrap();
    assert!(moving.files()[0].findings.iter().any(|text| text.contains("starts in motion")), "{:?}", moving.files());
    let text = String::from_utf8(sine("clipped.csv", 5.0).bytes).unwrap();
    let clip = |line: &str| match line.rsplit_once(',') {
        Some((head, y)) if y.parse::<f64>().is_ok_and(|y| y > 35.0) => format!("{head},35\n"),
        _ => format!("{line}\n"),
    };
    let clipped = packed(vec![File::new("clipped.csv", text.lines().map(clip).collect::<String>())]).unwrap();
    assert!(clipped.files()[0].findings.iter().any(|text| text.contains("constant")), "{:?}", clipped.files());
    assert!(source::text(&clipped.document).contains("constant"));
}
