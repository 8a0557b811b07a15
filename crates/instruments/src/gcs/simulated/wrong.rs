//! Commands that are wrong, and what each model knows.

use super::tests::{ask, device, number};
use crate::simulated::{Model, Simulation};

#[test]
fn wrong_names_numbers_and_counts_have_the_errors_of_gcs_and_change_nothing() {
    let device = device(Simulation { axes: 2, ..Simulation::default() });
    ask(&device, "SVO 1 1\nWAV 1 X PNT 1 2 0 1");
    let state = |()| {
        ask(
            &device,
            "MOV?\nSVO?\nWAV? 1 1\nWSL?\nWGC?\nWTR?\nWOS?\nDRC?\nDRT?\nRTR?\nVEL?\nCCL?\nSPA? 1 0x07000900\nERR?",
        )
    };
    let before = state(());
    for (command, code) in [
        ("MOV 3 1", 15),
        ("MOV 1 1 3 1", 15),
        ("MOV 1 1 1 2", 22),
        ("MOV 1 1 2 2", 5),
        ("MOV 1 1 2", 24),
        ("MOV", 24),
        ("MOV 1 nan", 25),
        ("MOV 1 1e99", 7),
        ("SVA 1 1", 79),
        ("SVA 2 1 1 1", 79),
        ("SVA 2 30.001", 66),
        ("SVO 1 7", 17),
        ("SVO 2 1 1 7", 17),
        ("POS? 1 3", 15),
        ("POS? 1 1", 22),
        ("VOL? 3", 23),
        ("VOL? x", 25),
        ("VMI? 0", 23),
        ("WGO 3 1", 23),
        ("WGO 1 7", 17),
        ("WGO 1 1", 75),
        ("WSL 1 17", 17),
        ("WGC 1 -1", 17),
        ("WTR 1 5", 24),
        ("WTR 1 5 7", 17),
        ("WOS 1 5000", 17),
        ("WAV 1 X PNT 1 2 0 5000", 17),
        ("WAV 1 & PNT 1 1 -5000", 17),
        ("WAV 1 + PNT 1 1 0", 70),
        ("WAV 17 X PNT 1 1 0", 17),
        ("WAV? 1 2", 17),
        ("WAV", 24),
        ("WCL", 24),
        ("WGR", 75),
        ("GWD? 1 5 1", 77),
        ("GWD? 1 5 2", 75),
        ("DRR? 1 1 1 01", 22),
        ("GWD? 1 2 1 01", 22),
        ("GWD? 1 300000 1 2", 17),
        ("DRC 1 3 2", 59),
        ("DRC 5 1 2", 57),
        ("DRC 1 1 99", 58),
        ("DRT 0 3 0", 17),
        ("DRT 0", 24),
        ("RTR 0", 17),
        ("RTR", 24),
        ("VEL 1 0", 8),
        ("VEL 1 1e12", 8),
        ("CCL 1 wrong", 56),
        ("CCL 1", 56),
        ("CCL 9", 17),
        ("SPA 1 0x07000900 5", 60),
        ("SPA? 1 0x5", 54),
        ("SPA? 1", 24),
        ("SPA? 3 0x07000900", 15),
        ("SEP 99 1 0x07000900 5", 56),
        ("GOH 3", 15),
        ("ATZ 1 NaN", 79),
        ("IMP 1 9999", 7),
        ("STE 2 9999", 66),
        ("HLT 3", 15),
        ("FRF? 1", 2),
        ("\u{1b}FLY", 2),
    ] {
        assert_eq!(ask(&device, &format!("{command}\nERR?\nERR?")), format!("{code}\n0"), "{command}");
        assert_eq!(state(()), before, "{command}");
    }
}

#[test]
fn a_wave_beyond_the_range_of_its_mode_does_not_start() {
    let device = device(Simulation::default());
    // 500 is a position, and no voltage.
    ask(&device, "WAV 1 X PNT 1 2 0 500\nWSL 1 1\nWGO 1 1");
    assert_eq!(ask(&device, "ERR?\n\x09\nVOL?"), "17\n0x0\n1=0.000000");
    assert_eq!(ask(&device, "SVO 1 1\nWGO 1 1\nERR?\n\x09"), "0\n0x1");
    ask(&device, "SVO 1 0\nWAV 1 X PNT 1 2 0 25\nWOS 1 6\nWGO 1 1");
    assert_eq!(ask(&device, "ERR?\nWOS 1 5\nWGO 1 1\nERR?\nWGO? 1"), "17\n0\n1=1");
    assert_eq!(ask(&device, "WOS 1 0\nERR?\nSVA 1 1\nERR?\nWAV 1 X PNT 1 1 0\nERR?\nWGO 1 1\nERR?"), "73\n73\n73\n73");
}

#[test]
fn axes_have_plants_and_waves_of_their_own() {
    let device = device(Simulation { axes: 3, plant: "paper".into(), ..Simulation::default() });
    assert_eq!(ask(&device, "SAI?\nTWG?\nTPC?"), "1\n2\n3\n3\n3");
    ask(&device, "SVA 1 10 3 -5\nWAV 2 X PNT 1 2 0 8\nWSL 2 2\nWTR 0 2000 0\nWGC 2 0\nWGO 2 1");
    assert_eq!(ask(&device, "\x09\nWGO?"), "0x2\n1=0\n2=1\n3=0");
    super::tests::wait(&device, 0.12);
    assert_eq!(ask(&device, "VOL?"), "1=10.000000\n2=8.000000\n3=-5.000000");
    let positions = [1, 2, 3].map(|k| number(&device, &format!("POS? {k}")));
    assert!(positions[0] > 200.0 && positions[1] > 100.0 && positions[2] < -100.0, "{positions:?}");
    // Two axes are recorded together.
    ask(&device, "DRC 1 1 16 2 2 16 3 3 2\nRTR 100\nDRT 0 4");
    super::tests::wait(&device, 0.2);
    let rows = ask(&device, "DRR? 1 40 1 2");
    let column = |k: usize| {
        let rows = rows.lines().filter(|row| !row.starts_with('#'));
        rows.map(|row| row.split(' ').nth(k).unwrap().to_string()).collect::<std::collections::BTreeSet<_>>()
    };
    assert_eq!((column(0).len(), column(1).len()), (1, 2));
    assert_eq!(ask(&device, "HLT 2\nERR?\n\x09"), "10\n0x0");
}

#[test]
fn parameters_are_changed_at_the_command_level_of_advanced_users() {
    let device = device(Simulation::default());
    assert_eq!(ask(&device, "CCL?\nCCL 1 advanced\nCCL?\nERR?"), "0\n1\n0");
    // In decimal too; the answer is hexadecimal.
    assert_eq!(ask(&device, "SPA 1 117442816 7.5\nERR?\nSPA? 1 0x07000900"), "0\n1 0x7000900=7.5");
    assert_eq!(ask(&device, "SPA 1 0x07000000 7.5\nERR?\nSPA 1 0x07000900 0\nERR?"), "64\n17");
    assert_eq!(
        ask(&device, "SEP 100 1 0x07000900 3\nERR?\nSEP? 1 0x07000900\nSPA? 1 0x07000900"),
        "0\n1 0x7000900=3\n1 0x7000900=7.5"
    );
    assert_eq!(ask(&device, "CCL 0\nSPA 1 0x07000900 1\nERR?"), "60");
    let all = ask(&device, "SPA?");
    assert_eq!(all.lines().count(), ask(&device, "HPA?").lines().count() - 2);
}

#[test]
fn each_model_answers_what_it_knows_and_refuses_the_rest() {
    for (model, title, known, unknown) in [
        (Model::E727, "E-727", "IDN?\nHLT 1", "FRF? 1\nONL? 1\nEAX 1 1\nHIN? 1\nSRG? 1 1\nTRS? 1"),
        (Model::E754, "E-754", "TSP?\nIFC?", "IDN?\nHLT 1\nFRF? 1"),
        (Model::E709, "E-709", "OVF? 1\nVEL? 1", "IDN?\nHLT 1\nIFC?"),
        (Model::OpenLoop, "open-loop", "POS?\nSVR 1 1", "SVO? 1\nSVO 1 1\nMOV 1 0\nTMN? 1\nONT? 1\nSPA? 1 0x07000000"),
    ] {
        let device = device(Simulation { model, ..Simulation::default() });
        let identity = ask(&device, "*IDN?");
        assert!(identity.starts_with(&format!("piezoid, {title}, simulated controller with pl140")), "{identity}");
        let help = ask(&device, "HLP?");
        for (commands, code) in [(known, 0), (unknown, 2)] {
            for command in commands.lines() {
                let answer = ask(&device, &format!("{command}\nERR?"));
                let expected = if command == "HLT 1" && code == 0 { 10 } else { code };
                let is_right =
                    if command.starts_with("SPA?") { answer == "54" } else { answer.ends_with(&expected.to_string()) };
                assert!(is_right, "{title}: {command}: {answer}");
                let name = command.split(' ').next().unwrap();
                assert_eq!(help.lines().any(|line| line.starts_with(&format!("{name} "))), code == 0 || name == "SPA?");
            }
        }
        // Every command of the help is there: without arguments it has another error than 2.
        for line in help.lines().filter(|line| !line.starts_with('#') && line.contains(' ') && line.len() > 4) {
            let name = line.split(' ').next().unwrap();
            if name.len() <= 5 && name.to_uppercase() == name {
                assert_ne!(
                    ask(&device, &format!("{name}\nERR?")).lines().last().unwrap_or_default(),
                    "2",
                    "{title}: {name}"
                );
            }
        }
        let idle = if model == Model::E754 { "0" } else { "0x0" };
        assert_eq!(ask(&device, "\x09"), idle);
        // Bytes that it does not know are no part of a line.
        assert_eq!(ask(&device, "\x03\n\x04\nCSV?"), "2.0");
    }
}
