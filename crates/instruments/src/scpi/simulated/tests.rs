//! The instruments without their lines, with a virtual clock: each answer takes 0.01 s.

use crate::simulated::{Model, Simulated, Simulation, locked};

fn device() -> Simulated {
    let model = Model::Scpi;
    Simulation { plant: "paper".into(), model, gain: 4.0, virtual_time: Some(0.01), ..Simulation::default() }
        .controller()
        .unwrap()
}

/// The answers to lines at a port.
fn ask(device: &Simulated, port: usize, lines: &str) -> String {
    let mut device = locked(&*device.device);
    let answers = lines.split('\n').map(|line| device.answer_at(port, line));
    answers.flatten().map(char::from).collect::<String>().trim_end().to_string()
}

fn volts(device: &Simulated) -> f64 {
    ask(device, 0, "*ESR?");
    locked(&*device.device).state().0
}

fn wait(device: &Simulated) {
    (0..20).for_each(|_| drop(ask(device, 0, "*ESR?")));
}

#[test]
fn a_burst_holds_its_first_sample_before_and_after_it() {
    let device = device();
    ask(&device, 0, "SOUR1:DATA:ARB up, 0.5,0,0,0,0,0,0,0,0,-1;:FUNC:ARB UP;:FUNC:ARB:SRAT 100");
    ask(&device, 0, "FUNC ARB;BURS:STAT ON;BURS:NCYC 1;TRIG1:SOUR BUS;VOLT 4;VOLT:OFFS 1");
    assert_eq!(ask(&device, 0, "SYST:ERR?"), "+0,\"No error\"");
    assert_eq!(volts(&device), 8.0);
    ask(&device, 0, "*TRG;*TRG");
    assert_eq!(ask(&device, 0, "SYST:ERR?"), "-211,\"Trigger ignored\"");
    assert_eq!(volts(&device), 4.0);
    wait(&device);
    assert_eq!(volts(&device), 8.0);
    // The amplitude leaves room for an offset of 2 V.
    ask(&device, 0, "VOLT:OFFS 2;VOLT 18");
    assert_eq!(ask(&device, 0, "VOLT:OFFS?;SYST:ERR?"), "+1.000001000000E0;-221,\"Settings conflict\"");
}

#[test]
fn a_block_is_a_wave_in_both_orders_and_the_memory_keeps_names() {
    let device = device();
    let block = |low: u8| format!("DATA:ARB:DAC \"A{low}\",#216{}", format!("\u{7f}{}", char::from(low)).repeat(8));
    ask(&device, 0, &block(255));
    ask(&device, 0, "FORM:BORD SWAP");
    ask(&device, 0, &block(127));
    assert_eq!(ask(&device, 0, "FUNC:ARB \"A127\";FUNC ARB;VOLT 2;BURS:STAT ON;SYST:ERR?"), "+0,\"No error\"");
    assert!((volts(&device) - 4.0 * 32639.0 / 32767.0).abs() < 1e-6);
    ask(&device, 0, "FUNC:ARB \"A255\"");
    assert_eq!(volts(&device), 4.0);
    ask(&device, 0, &block(127));
    assert_eq!(ask(&device, 0, "SYST:ERR?"), "+786,\"Specified arb waveform already exists\"");
    assert_eq!(
        ask(&device, 0, "DATA:VOL:CLE;FUNC:ARB A255;SYST:ERR?"),
        "+785,\"Specified arb waveform does not exist\""
    );
    ask(&device, 0, &format!("DATA:ARB:DAC LARGE,#72097136{}", "\0".repeat(2097136)));
    assert_eq!(ask(&device, 0, "DATA:ARB A,0,0,0,0,0,0,0,0;SYST:ERR?"), "+0,\"No error\"");
    assert_eq!(
        ask(&device, 0, "DATA:ARB B,0,0,0,0,0,0,0,0;SYST:ERR?"),
        "+781,\"Not enough memory to store new arb waveform\""
    );
    assert_eq!(ask(&device, 0, "DATA:ARB ABCDEFGHIJKLM,0,0,0,0,0,0,0,0;SYST:ERR?"), "-224,\"Illegal parameter value\"");
}

#[test]
fn the_oscilloscope_records_around_its_trigger_and_clips() {
    let device = device();
    ask(&device, 1, ":timebase:reference LEFT;:TIMebase:RANGe 0.1;:TIM:POS 0;:ACQ:TYPE HRES;:TRIG:EDGE:SOUR EXT");
    ask(&device, 1, ":CHAN1:RANG 1;:CHAN1:OFFS 0;:SING");
    assert_eq!(ask(&device, 1, ":AER?;:OPER:COND?;SYST:ERR?"), "1;+8;+0,\"No error\"");
    assert_eq!(ask(&device, 1, ":AER?\n:AER?"), "1\n1");
    ask(
        &device,
        0,
        "DATA:ARB UP,0,0.5,1,1,1,1,1,1;FUNC:ARB UP;FUNC:ARB:SRAT 50;TRIG:SOUR BUS;FUNC ARB;VOLT 6;BURS:STAT ON;*TRG",
    );
    wait(&device);
    assert_eq!(ask(&device, 1, ":OPER:COND?"), "+0");
    ask(&device, 1, ":WAV:SOUR CHAN1;:WAV:FORM ASC;:WAV:POIN 8000000");
    let preamble = ask(&device, 1, ":WAV:PRE?");
    assert!(preamble.starts_with("+4,+3,+2000,+1,+5.00000000E-5,-1.00000000E-2,+0,"), "{preamble}");
    let data = ask(&device, 1, ":WAV:DATA?");
    let volts: Vec<f64> = data[10..].split(',').map(|word| word.parse().unwrap()).collect();
    assert_eq!(volts.len(), 2000);
    // 20 ms after the trigger the wave steps to 6 V, 0.6 V at the monitor: above the screen.
    assert!(volts[..590].iter().all(|v| v.abs() < 1e-3) && volts[605..].iter().all(|v| *v > 0.49), "{volts:?}");
}

#[test]
fn what_is_wrong_has_its_error_and_changes_nothing() {
    let device = device();
    for (port, line, code) in [
        (0, "NONSENSE 1", -113),
        (0, "NONSENSE?", -113),
        (0, ":WAV:DATA?", -113),
        (1, "VOLT 1", -113),
        (0, "VOLT", -109),
        (0, "VOLT x", -224),
        (0, "VOLT nan", -222),
        (0, "VOLT 30", -222),
        (0, "FUNC NOIS", -224),
        (0, "BURS:STAT ON", -221),
        (0, "*TRG", -211),
        (0, "DATA:ARB A,1,2,3,4,5,6,7,8", -222),
        (0, "DATA:ARB:DAC A,#9", -223),
        (0, "DATA:ARB:DAC A,#", -224),
        (0, "SOUR2:VOLT 1", -222),
        (1, ":CHAN3:RANG 1", -222),
        (1, ":CHAN0:RANG 1", -222),
        (1, ":TIM:RANG 1e9", -222),
        (1, ":WAV:SOUR CHAN9", -224),
    ] {
        ask(&device, port, line);
        let answer = ask(&device, port, "SYST:ERR?\nSYST:ERR?");
        assert!(answer.starts_with(&format!("{code},")) && answer.ends_with("+0,\"No error\""), "{line}: {answer}");
    }
    assert_eq!(ask(&device, 0, "FUNC?;BURS:STAT?"), "DC;0");
}

#[test]
fn no_line_makes_it_panic() {
    let device = device();
    let names = "VOLT,VOLT:OFFS,FUNC,FUNC:ARB,FUNC:ARB:SRAT,FREQ,OUTP,OUTP:LOAD,BURS:STAT,BURS:NCYC,TRIG:SOUR,*TRG,ABOR,\
                 DATA:VOL:CLE,DATA:ARB A,DATA:ARB:DAC B,:TIM:RANG,:TIM:POS,:TIM:REF,:CHAN1:RANG,:CHAN2:OFFS,:SING,:STOP,\
                 :WAV:PRE?,:WAV:DATA?,:WAV:POIN,:WAV:FORM,:WAV:SOUR,:ACQ:SRAT?,:AER?,:TRIG:SOUR,*IDN?,SYST:ERR?";
    let names: Vec<&str> = names.split(',').collect();
    let words = [
        "0", "1", "-1", "1e300", "1e-9", "nan", "", "ON", "DC", "ARB", "SIN", "BUS", "EXT", "#14abcd", "#9", "ASC",
        "\u{e9}",
    ];
    let mut state = 1_u64;
    let mut random = |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    for _ in 0..3000 {
        let line =
            format!("{} {},{}", names[random(names.len())], words[random(words.len())], words[random(words.len())]);
        ask(&device, random(2), &line);
    }
    assert!(volts(&device).abs() <= 30.0);
}
