//! Commands of both instruments: all of a command is refused or obeyed.

use super::Device;
use super::generator::INFINITE;
use super::words::{Words, commands, short};
use crate::simulated::head;

/// Errors, as `SYST:ERR?` states them.
pub(super) const UNKNOWN: i32 = -113;
const MISSING: i32 = -109;
pub(super) const IGNORED: i32 = -211;
pub(super) const CONFLICT: i32 = -221;
pub(super) const RANGE: i32 = -222;
pub(super) const TOO_LONG: i32 = -223;
pub(super) const UNKNOWN_WORD: i32 = -224;
pub(super) const FULL: i32 = 781;
pub(super) const MISSING_WAVE: i32 = 785;
pub(super) const EXISTS: i32 = 786;

/// What an error means.
fn meaning(code: i32) -> &'static str {
    match code {
        0 => "No error",
        UNKNOWN => "Undefined header",
        MISSING => "Missing parameter",
        IGNORED => "Trigger ignored",
        CONFLICT => "Settings conflict",
        RANGE => "Data out of range",
        TOO_LONG => "Too much data",
        UNKNOWN_WORD => "Illegal parameter value",
        FULL => "Not enough memory to store new arb waveform",
        MISSING_WAVE => "Specified arb waveform does not exist",
        EXISTS => "Specified arb waveform already exists",
        _ => "Error",
    }
}

/// An answer: bytes, or an error.
type Answer = Result<Vec<u8>, i32>;

impl Device {
    /// Obeys a line at the port of the generator, 0, or of the oscilloscope, 1. What is answered.
    pub(super) fn obey(&mut self, port: usize, line: &str) -> Vec<u8> {
        let mut answers: Vec<Vec<u8>> = Vec::new();
        for command in commands(line) {
            match self.one(port, &Words::of(command)) {
                Ok(answer) if answer.is_empty() => (),
                Ok(answer) => answers.push(answer),
                Err(code) => self.error(port, code),
            }
        }
        let mut bytes = answers.join(&b';');
        if !bytes.is_empty() {
            bytes.push(b'\n');
        }
        bytes
    }

    fn one(&mut self, port: usize, words: &Words) -> Answer {
        let text = |text: &str| Ok(text.as_bytes().to_vec());
        match (&*words.header, words.is_query) {
            ("*IDN", true) => {
                let model = ["33500B", "DSO-X 2000"][port];
                text(&format!("piezoid,{model},simulated with {} and a sensor of {} um/V,0", self.plant, self.sensor))
            }
            ("*CLS", false) => {
                self.errors[port].clear();
                Ok(Vec::new())
            }
            ("*ESR", true) => text("+0"),
            ("*OPC", true) => text("1"),
            ("SYST:ERR", true) => {
                let code = self.errors[port].pop_front().unwrap_or_default();
                text(&format!("{code:+},\"{}\"", meaning(code)))
            }
            (_, is_query) if words.channel > 2 - usize::from(port == 0) || words.channel == 0 => {
                Err(if is_query { UNKNOWN } else { RANGE })
            }
            (_, true) if port == 0 => self.generator_tells(words).map(String::into_bytes),
            (_, true) => self.oscilloscope_tells(words),
            _ if port == 0 => self.set_generator(words).map(|()| Vec::new()),
            _ => self.set_oscilloscope(words).map(|()| Vec::new()),
        }
    }

    fn generator_tells(&self, words: &Words) -> Result<String, i32> {
        let g = &self.generator;
        let real = |value: f64| Ok(format!("{value:+.12E}"));
        let bit = |is_set: bool| Ok(u8::from(is_set).to_string());
        match &*words.header {
            "FUNC" => Ok(g.function.into()),
            "FUNC:ARB" => Ok(format!("\"{}\"", g.selected)),
            "FUNC:ARB:SRAT" => real(g.rate),
            "VOLT" => real(g.amplitude),
            "VOLT:OFFS" => real(g.offset),
            "VOLT:UNIT" => Ok("VPP".into()),
            "FREQ" => real(g.frequency),
            "OUTP" => bit(g.is_on),
            "OUTP:LOAD" => real(g.load),
            "OUTP:POL" => Ok(if g.is_inverted { "INV".into() } else { "NORM".into() }),
            "BURS:STAT" => bit(g.is_burst),
            "BURS:MODE" => Ok("TRIG".into()),
            "BURS:NCYC" => real(g.cycles),
            "BURS:PHAS" => real(0.0),
            "TRIG:SOUR" => Ok(if g.by_bus { "BUS".into() } else { "IMM".into() }),
            _ => Err(UNKNOWN),
        }
    }

    fn set_generator(&mut self, words: &Words) -> Result<(), i32> {
        let g = &mut self.generator;
        let word = || words.arguments.first().map(|word| short(word.trim_matches('"'))).ok_or(MISSING);
        let real = |least: f64, most: f64| number(&words.arguments, least, most);
        match &*words.header {
            "FUNC" => return g.choose(&word()?),
            "FUNC:ARB" => return g.select(words.arguments.first().ok_or(MISSING)?),
            "FUNC:ARB:SRAT" => g.rate = real(1e-6, 2.5e8)?,
            "FUNC:ARB:FILT" => return one_of(&word()?, &["NORM", "STEP", "OFF"]),
            "VOLT" => return g.set_amplitude(real(0.0, 100.0)?),
            "VOLT:OFFS" => return g.set_offset(real(-100.0, 100.0)?),
            "VOLT:UNIT" => return one_of(&word()?, &["VPP"]),
            "FREQ" => g.frequency = real(1e-6, 3e7)?,
            "OUTP" => g.is_on = switch(&word()?)?,
            "OUTP:LOAD" => g.load = if word()? == "INF" { INFINITE } else { real(1.0, 1e4)? },
            "OUTP:POL" => g.is_inverted = word()? == "INV",
            "OUTP:SYNC" => return switch(&word()?).map(|_| ()),
            "BURS:STAT" => return g.set_burst(switch(&word()?)?),
            "BURS:MODE" => return one_of(&word()?, &["TRIG"]),
            "BURS:NCYC" => g.cycles = real(1.0, 1e8)?.round(),
            "BURS:PHAS" => return real(0.0, 0.0).map(|_| ()),
            "TRIG:SOUR" => {
                one_of(&word()?, &["BUS", "IMM", "EXT"])?;
                g.by_bus = word()? == "BUS";
            }
            "FORM:BORD" => {
                one_of(&word()?, &["NORM", "SWAP"])?;
                g.is_swapped = word()? == "SWAP";
            }
            "DATA:VOL:CLE" => g.clear(),
            "DATA:ARB" | "DATA:ARB:DAC" => {
                let (name, data) = words.arguments.split_first().ok_or(MISSING)?;
                let is_dac = words.header.ends_with("DAC");
                let values = values(data, is_dac, g.is_swapped)?;
                return g.keep(name, values);
            }
            "*TRG" => {
                g.trigger()?;
                self.oscilloscope.trigger();
            }
            "ABOR" => g.abort(),
            _ => return Err(UNKNOWN),
        }
        Ok(())
    }

    fn oscilloscope_tells(&mut self, words: &Words) -> Answer {
        let o = &mut self.oscilloscope;
        let real = |value: f64| Ok(format!("{value:+.6E}").into_bytes());
        let k = words.channel - 1;
        match &*words.header {
            "TIM:RANG" => real(o.range),
            "TIM:POS" => real(o.position),
            "CHAN:RANG" => real(o.channels[k].range),
            "CHAN:OFFS" => real(o.channels[k].offset),
            "ACQ:TYPE" => Ok(if o.is_fine { b"HRES".to_vec() } else { b"NORM".to_vec() }),
            "ACQ:SRAT" => real(1.0 / o.step_time()),
            "AER" => Ok(vec![b'0' + u8::from(std::mem::take(&mut o.is_ready))]),
            "OPER:COND" => Ok(if o.is_running() { b"+8".to_vec() } else { b"+0".to_vec() }),
            "WAV:FORM" => Ok(o.format.into()),
            "WAV:PRE" => Ok(o.preamble().into_bytes()),
            "WAV:DATA" => Ok(o.data()),
            header => o.kept.get(header).map(|word| word.clone().into_bytes()).ok_or(UNKNOWN),
        }
    }

    fn set_oscilloscope(&mut self, words: &Words) -> Result<(), i32> {
        let o = &mut self.oscilloscope;
        let word = || words.arguments.first().map(|word| short(word)).ok_or(MISSING);
        let real = |least: f64, most: f64| number(&words.arguments, least, most);
        let k = words.channel - 1;
        match &*words.header {
            "TIM:RANG" => o.range = real(1e-8, 500.0)?,
            "TIM:POS" => o.position = real(-500.0, 500.0)?,
            "TIM:REF" => {
                let places = [("LEFT", 0.1), ("CENT", 0.5), ("RIGH", 0.9)];
                o.reference =
                    places.iter().find(|(name, _)| word().is_ok_and(|word| word == *name)).ok_or(UNKNOWN_WORD)?.1;
            }
            "CHAN:RANG" => o.channels[k].range = real(8e-3, 80.0)?,
            "CHAN:OFFS" => o.channels[k].offset = real(-40.0, 40.0)?,
            "ACQ:TYPE" => {
                one_of(&word()?, &["NORM", "HRES"])?;
                o.is_fine = word()? == "HRES";
            }
            "TRIG:SOUR" | "TRIG:EDGE:SOUR" => o.is_external = word()? == "EXT",
            "SING" | "DIG" => o.arm(),
            "STOP" => o.stop(),
            "WAV:SOUR" => {
                let source = words.arguments.first().ok_or(MISSING)?;
                let digit = source.chars().last().and_then(|c| c.to_digit(10));
                o.source = match (&*short(source.trim_end_matches(|c: char| c.is_ascii_digit())), digit) {
                    ("CHAN", Some(channel @ 1..=2)) => channel as usize - 1,
                    _ => return Err(UNKNOWN_WORD),
                };
            }
            "WAV:FORM" => {
                let format = word()?;
                o.format = ["WORD", "BYTE", "ASC"].into_iter().find(|one| *one == format).ok_or(UNKNOWN_WORD)?;
            }
            "WAV:POIN" => o.points = real(100.0, 8e6)? as usize,
            "WAV:BYT" => return one_of(&word()?, &["MSBF"]),
            "TIM:MODE" | "WAV:UNS" | "WAV:POIN:MODE" | "TRIG:MODE" | "TRIG:SWE" | "TRIG:EDGE:SLOP"
            | "TRIG:EDGE:LEV" | "CHAN:DISP" | "CHAN:COUP" => {
                o.kept.insert(words.header.clone(), word()?);
            }
            _ => return Err(UNKNOWN),
        }
        Ok(())
    }
}

fn number(arguments: &[&str], least: f64, most: f64) -> Result<f64, i32> {
    let word = arguments.first().ok_or(MISSING)?;
    let value: f64 = word.parse().map_err(|_| UNKNOWN_WORD)?;
    if (least..=most).contains(&value) { Ok(value) } else { Err(RANGE) }
}

fn switch(word: &str) -> Result<bool, i32> {
    match word {
        "ON" | "1" => Ok(true),
        "OFF" | "0" => Ok(false),
        _ => Err(UNKNOWN_WORD),
    }
}

fn one_of(word: &str, known: &[&str]) -> Result<(), i32> {
    if known.contains(&word) { Ok(()) } else { Err(UNKNOWN_WORD) }
}

/// The values of a wave, as numbers or as a block of words of 16 bits.
fn values(data: &[&str], is_dac: bool, is_swapped: bool) -> Result<Vec<f64>, i32> {
    let full = if is_dac { 32767.0 } else { 1.0 };
    let block = data.first().map(|first| first.trim_start()).filter(|first| is_dac && first.starts_with('#'));
    let Some(block) = block else {
        return data
            .iter()
            .map(|word| word.parse::<f64>().map(|value| value / full).map_err(|_| UNKNOWN_WORD))
            .collect();
    };
    // The line is text of one byte a character.
    let bytes: Vec<u8> = block.chars().filter_map(|c| u8::try_from(c).ok()).collect();
    if !bytes.get(1).is_some_and(u8::is_ascii_digit) {
        return Err(UNKNOWN_WORD);
    }
    let words = head(&bytes).and_then(|(head, length)| bytes.get(head..)?.get(..length)).ok_or(TOO_LONG)?;
    let word = |pair: &[u8]| if is_swapped { [pair[0], pair[1]] } else { [pair[1], pair[0]] };
    Ok(words.chunks_exact(2).map(|pair| f64::from(i16::from_le_bytes(word(pair))) / full).collect())
}
