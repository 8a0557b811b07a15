//! The first commands of other programs, as their public sources send them: what each must have an answer, and what is
//! refused without harm because the program expects that of some models.
//!
//! Sources: EPICS motorPIGCS2 (PIasynController, PIGCSController, PIGCSPiezoController, PIE727Controller), BLISS
//! PI_E727 and PI_E753, Micro-Manager PI_GCS_2 (PIController, PIZStage), PyMoDAQ pi_wrapper.

use super::tests::{ask, device, number, wait};
use crate::simulated::{Model, Simulated, Simulation};

fn of(model: Model) -> Simulated {
    device(Simulation { model, ..Simulation::default() })
}

/// Every query has one answer with this sign, and no command an error.
fn converse(device: &Simulated, lines: &str) {
    for line in lines.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let answer = ask(device, line);
        assert_eq!(ask(device, "ERR?"), "0", "{line}: {answer}");
        assert_eq!(line.contains('?') || line.len() == 1, !answer.is_empty(), "{line}: {answer}");
    }
}

/// These are refused as unknown, and the line stays clean.
fn refused(device: &Simulated, lines: &str) {
    for line in lines.lines().map(str::trim).filter(|line| !line.is_empty()) {
        assert_eq!(ask(device, &format!("{line}\nERR?\nCSV?")), "2\n2.0", "{line}");
    }
}

#[test]
fn epics_finds_its_controller_starts_and_polls() {
    for (model, name) in [(Model::E727, "E-727"), (Model::E754, "E-754"), (Model::E709, "E-709")] {
        let device = of(model);
        assert!(ask(&device, "*IDN?").to_uppercase().contains(name));
        converse(&device, "VEL?\nSAI?");
        // It asks for these once, and does without.
        refused(&device, "TRS? 1\nFRF? 1\nSRG? 1 1");
        converse(&device, "SVO 1 1\nVEL? 1\nPOS? 1\nTMN? 1\nTMX? 1\nSVO? 1\n\x05\nONT? 1\nOVF? 1");
        // The parameters of the closed loop, in decimal.
        for parameter in [0x0700_0300, 0x0700_0301, 0x0703_0600, 0x0800_0100, 0x0700_0200, 0x0800_0300, 0x0600_0500] {
            converse(&device, &format!("SPA? 1 {parameter}"));
        }
        // It writes them without asking for errors, which its next move would find.
        ask(&device, "CCL 1 advanced\nSPA 1 117441280 0.01\nSPA 1 134217984 300\nSPA 1 117638656 1\nSPA 1 100664576 5");
        converse(&device, "SPA 1 117441281 2.5\nCCL 0\nVEL 1 500.000000\nMOV 1 100.000000");
        assert_eq!(ask(&device, "\x05"), "1");
        wait(&device, 2.0);
        assert_eq!(ask(&device, "\x05"), "0");
        assert!((number(&device, "POS? 1") - 100.0).abs() < 5.0);
        assert_eq!(ask(&device, "STP\nERR?"), "10");
    }
}

#[test]
fn bliss_starts_an_e_727_and_reads_its_information() {
    let device = of(Model::E727);
    converse(
        &device,
        "IDN?\nSVO 1 1\nSVO? 1\nMOV? 1\nONT? 1\nVEL? 1\nSVA? 1\nVOL? 1\nPOS? 1\nATZ? 1\nAOS? 1\nTAD? 1\nTSP? 1
         SPA? 1 0x7000A00\nSPA? 1 0x7000A01\nSPA? 1 0x7000000\nSPA? 1 0x7000001\nSPA? 1 0x7000900\nSPA? 1 0X7000901",
    );
    // Its answers are checked for what was sent.
    assert!(ask(&device, "SPA? 1 0x7000900").starts_with("1 0x7000900="));
    converse(&device, "VEL 1 200.000000\nMOV 1 50");
    assert_eq!(ask(&device, "ONT? 1"), "1=0");
    // It sets the number of tables, and arms all of them at once.
    converse(&device, "SPA 1 0x16000300 2\nSPA? 1 0x16000200\nDRC 1 1 2\nDRC 2 1 3\nRTR 100\nDRT 1 1 0 2 1 0");
    assert_eq!(ask(&device, "SPA? 1 0x16000200\nDRT? 1 2"), "1 0x16000200=65536\n1=1 0\n2=1 0");
    // Points that are not there yet are an empty line.
    assert_eq!(ask(&device, "MOV 1 40\nDRR? 1 500 1 2\nERR?"), "17");
    assert_eq!(ask(&device, "HLT 1\nERR?"), "10");
}

#[test]
fn bliss_starts_an_e_754_and_plays_a_wave() {
    let device = of(Model::E754);
    converse(
        &device,
        "*IDN?\nSVO? 1\nSVA? 1\nVOL? 1\nVEL? 1\nCCL?\nPOS? 1\nMOV? 1\nONT? 1\nATZ? 1\nAOS? 1
         SPA? 1 0X07000000\nSPA? 1 0X07000001\nSPA? 1 0X07000900\nSPA? 1 0X07000901\nSPA? 1 0X02000200
         SPA? 1 0X02000300\nSPA? 1 0X07000A00\nSPA? 1 0X07000A01\nIFC? IPADR MACADR IPSTART\nTSP?\nTAD?
         SPA? 1 0xe000200\nSPA? 1 0x13000004\nWSL 1 1\nWAV 1 X LIN 1000 20 0 1000 0 2\nWTR 0 1 1\nWGC 1 2\nWGO 1 1",
    );
    // Only the E-727 drops a zero before the number of a parameter.
    assert!(ask(&device, "SPA? 1 0X07000000").starts_with("1 0x07000000="));
    assert!(ask(&device, "SPA? 1 0xe000200").starts_with("1 0xe000200="));
    // It reads so many lines, in this order.
    let lines = ["IFC?", "TSP?", "TAD?", "IFC? IPADR MACADR IPSTART"].map(|query| ask(&device, query));
    assert_eq!(lines.each_ref().map(|lines| lines.lines().count()), [5, 3, 3, 3]);
    assert!(lines[3].starts_with("IPADR=127.0.0.1\nMACADR="), "{}", lines[3]);
    // At rest it expects a bare 0.
    assert_eq!(ask(&device, "\x09"), "1");
    wait(&device, 0.2);
    assert_eq!(ask(&device, "\x09"), "0");
    assert!((number(&device, "VOL? 1") - 20.0).abs() < 1e-6);
    converse(&device, "WAV 1 X SIN_P 1000 20.000000 -10.000000 1000 0 500\nWGO 1 1\nWGO 1 0");
    assert_eq!(ask(&device, "STP\nERR?"), "10");
}

#[test]
fn micro_manager_starts_and_moves() {
    for model in [Model::E727, Model::E754, Model::E709] {
        let device = of(model);
        converse(&device, "*IDN?\nCSV?\nTPC?");
        refused(&device, "ONL 1 1\nEAX 1 1\nHIN? 1");
        converse(&device, "SVO 1 1\nSVO? 1\nVEL? 1\nVEL 1 300\nMOV 1 50.0\nPOS? 1");
        // It waits until nothing moves.
        let polls = (0..1000).take_while(|_| ask(&device, "\x05") != "0").count();
        assert!((10..500).contains(&polls), "{polls}");
    }
}

#[test]
fn pymodaq_starts_moves_and_plays_a_ramp() {
    let device = of(Model::E727);
    converse(&device, "*IDN?\nSAI?\nHLP?\nSPA? 1 0x7000601\nTMN? 1\nTMX? 1\nSVO? 1\nSVO 1 1\nPOS? 1\nONT? 1");
    assert_eq!(ask(&device, "SPA? 1 0x7000601"), "1 0x7000601=um");
    converse(&device, "MOV 1 10\nMVR 1 5\nGOH 1\nSPA? 1 0xE000200\nWCL 1\nWAV 1 X RAMP 1000 10 0 1500.0 0 0 1500.0");
    converse(&device, "WSL 1 1\nWTR 0 1 1\nWGC 1 1\nWGO 1 1\nWGO 1 0");
}
