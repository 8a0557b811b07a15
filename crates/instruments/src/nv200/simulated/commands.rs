//! Commands: all of a command is refused or obeyed.

use super::generator::VALUES;
use super::list::{GAINS, KEPT};
use super::{Device, GENERATOR, SET, recorder, speeds};

/// Errors, as `error,N` states them.
pub(super) const UNKNOWN: u8 = 2;
pub(super) const MISSING: u8 = 3;
pub(super) const RANGE: u8 = 4;
pub(super) const TOO_MANY: u8 = 5;
pub(super) const READ_ONLY: u8 = 6;

/// Names of values that only the controller changes.
const MEASURED: [&str; 15] = [
    "meas",
    "temp",
    "stat",
    "posmin",
    "posmax",
    "avmin",
    "avmax",
    "unitcl",
    "unitol",
    "desc",
    "acserno",
    "acmeasure",
    "giarb",
    "recidx",
    "imeas",
];

impl Device {
    /// Obeys a line. What is answered.
    pub(super) fn obey(&mut self, line: &str) -> Result<String, u8> {
        let mut words = line.split(',').map(str::trim);
        let (name, arguments): (_, Vec<&str>) = (words.next().unwrap_or_default().to_lowercase(), words.collect());
        // Of what is numbered, the number comes before the value.
        let numbered = usize::from(matches!(&*name, "recsrc" | "gbarb" | "gparb" | "imeas"));
        let is_query = matches!(&*name, "" | "s" | "recout" | "recoutf") || arguments.len() <= numbered;
        match &*name {
            "gsave" => self.generator.saved = self.generator.buffer.clone(),
            "gload" => self.generator.buffer = self.generator.saved.clone(),
            _ if is_query => return self.tell(&name, &arguments),
            "pcf" => self.set_gains(&arguments)?,
            "recsrc" | "gbarb" | "gparb" => self.set_numbered(&name, &arguments)?,
            _ if MEASURED.contains(&&*name) => return Err(READ_ONLY),
            _ => match arguments[..] {
                [word] => self.assign(&name, word)?,
                _ => return Err(if self.tell(&name, &[]).is_ok() { TOO_MANY } else { UNKNOWN }),
            },
        }
        Ok(String::new())
    }

    /// Sets a parameter.
    fn assign(&mut self, name: &str, word: &str) -> Result<(), u8> {
        let number = |least: u16, most: u16| whole(word, least, most);
        let last = (VALUES - 1) as u16;
        match name {
            "set" => {
                let (low, high) = self.limits();
                self.set = real(word, low, high)?;
                self.recorder.sets();
                self.follow();
            }
            "cl" => self.close(number(0, 1)? == 1),
            "modsrc" => {
                self.source = number(0, 3)?;
                self.follow();
            }
            "sr" => {
                let rate = real(word, 8e-7, 2000.0)?;
                (self.axis.slew, self.axis.velocity) = speeds(&self.axis, rate);
                self.kept.insert("sr", rate);
            }
            "grun" => {
                if number(0, 1)? == 0 {
                    self.generator.stop();
                } else if self.generator.offset.max(self.generator.start) > self.generator.end {
                    return Err(RANGE);
                } else {
                    self.generator.run();
                    self.recorder.plays();
                }
            }
            "gsarb" => self.generator.start = number(0, last)?,
            "gearb" => self.generator.end = number(0, last)?,
            "goarb" => self.generator.offset = number(0, last)?,
            "gcarb" => self.generator.cycles = number(0, u16::MAX)?,
            "gtarb" => self.generator.rate = number(1, u16::MAX)?,
            "recast" => self.recorder.start = number(0, 2)?,
            "recstr" => self.recorder.stride = number(1, u16::MAX)?,
            "reclen" => self.recorder.length = number(0, recorder::VALUES as u16)?,
            "recrun" => {
                if number(0, 1)? == 0 {
                    self.recorder.stop();
                } else {
                    self.recorder.run();
                }
            }
            _ => {
                let row = KEPT.iter().find(|row| row.0 == name).ok_or(UNKNOWN)?;
                let (name, least, most, _, is_whole) = *row;
                let value = real(word, least, most)?;
                if is_whole && value.fract() != 0.0 {
                    return Err(RANGE);
                }
                self.kept.insert(name, value);
            }
        }
        Ok(())
    }

    /// Goes where the source of the setpoint says. What analogue input and SPI give does not change.
    fn follow(&mut self) {
        if self.source == SET {
            self.axis.go(self.set);
        } else if self.source == GENERATOR {
            let index = usize::from(self.generator.index);
            let share = self.generator.buffer.get(index).copied().unwrap_or_default();
            self.axis.go(self.value(share));
        }
    }

    /// Opens or closes the loop. The setpoint is then where the axis is, and the generator stops.
    fn close(&mut self, servo: bool) {
        if servo != self.axis.servo {
            self.generator.stop();
            self.axis.close(servo);
            let (low, high) = self.limits();
            (self.set, self.source) = (self.axis.goal.max(low).min(high), SET);
        }
    }

    /// `pcf`: three gains.
    fn set_gains(&mut self, arguments: &[&str]) -> Result<(), u8> {
        let words: [&str; 3] =
            arguments.try_into().map_err(|_| if arguments.len() < 3 { MISSING } else { TOO_MANY })?;
        let mut values = [0.0; 3];
        for (value, word) in values.iter_mut().zip(words) {
            *value = real(word, -1e6, 1e6)?;
        }
        self.kept.extend(GAINS.into_iter().zip(values));
        Ok(())
    }

    /// The source of a channel, or a value of the buffer.
    fn set_numbered(&mut self, name: &str, arguments: &[&str]) -> Result<(), u8> {
        let [number, word] = arguments else { return Err(TOO_MANY) };
        if name == "recsrc" {
            self.recorder.sources[usize::from(whole(number, 0, 1)?)] = whole(word, 0, 7)?;
            return Ok(());
        }
        let index = usize::from(whole(number, 0, (VALUES - 1) as u16)?);
        let (low, high) = if name == "gbarb" { (0.0, 100.0) } else { self.axis.travel };
        self.generator.buffer[index] = 100.0 * (real(word, low, high)? - low) / (high - low);
        Ok(())
    }
}

pub(super) fn real(word: &str, least: f64, most: f64) -> Result<f64, u8> {
    let number = word.parse().ok().filter(|number: &f64| number.is_finite()).ok_or(RANGE)?;
    if (least..=most).contains(&number) { Ok(number) } else { Err(RANGE) }
}

/// A whole number; it may be written as a real one, such as `5.0`.
pub(super) fn whole(word: &str, least: u16, most: u16) -> Result<u16, u8> {
    let number: f64 = word.parse().map_err(|_| RANGE)?;
    let is_valid = number.fract() == 0.0 && (f64::from(least)..=f64::from(most)).contains(&number);
    if is_valid { Ok(number as u16) } else { Err(RANGE) }
}
