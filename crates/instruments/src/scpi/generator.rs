//! The generator: slow moves by its offset, and one burst of a wave.
//!
//! ```text
//! DATA:VOL:CLE; FORM:BORD NORM; DATA:ARB:DAC PIEZOID,#...     the wave, while the function is DC
//! FUNC:ARB "PIEZOID"; FUNC:ARB:SRAT ...; FUNC:ARB:FILT OFF
//! BURS:MODE TRIG; BURS:NCYC 1; BURS:PHAS 0; TRIG1:SOUR BUS; OUTP:SYNC ON
//! FUNC DC; VOLT:OFFS ...                                      slowly to the offset of the wave
//! VOLT 0.002; FUNC ARB; BURS:STAT ON; VOLT ...; *TRG; *OPC?   the burst
//! ```
//! All voltages here are at the actuator: those of the generator times the gain of the amplifier.

use super::line::Line;
use super::wave::{LEAST, Wave};
use crate::moves::Moves;
use crate::watch::Watch;
use piezoid::Error;
use std::time::Duration;

/// Name of the wave in the memory of the generator.
const NAME: &str = "PIEZOID";

/// Error of a voltage that is read back [V], and as a share of it.
const SMALL: f64 = 1e-3;
const SHARE: f64 = 1e-3;

/// Least load that counts as a high impedance [Ohm].
const HIGH_IMPEDANCE: f64 = 1e5;

/// Pause between two questions while a burst runs.
const PAUSE: Duration = Duration::from_millis(20);

/// A generator with an amplifier behind it.
pub(crate) struct Generator<'a> {
    pub(crate) line: Line<'a>,
    pub(crate) channel: usize,
    /// Gain of the amplifier.
    pub(crate) gain: f64,
    /// Lowest and highest voltage [V].
    pub(crate) range: (f64, f64),
    /// Largest slew rate [V/s]; infinite without a limit.
    pub(crate) fastest: f64,
}

impl Generator<'_> {
    /// Gives a command of the channel.
    pub(crate) fn source(&mut self, command: &str) -> Result<(), Error> {
        self.line.command(&format!("SOUR{}:{command}", self.channel))
    }

    fn text(&mut self, query: &str) -> Result<String, Error> {
        self.line.query(&format!("SOUR{}:{query}", self.channel))
    }

    pub(crate) fn number(&mut self, query: &str) -> Result<f64, Error> {
        self.line.number(&format!("SOUR{}:{query}", self.channel))
    }

    pub(crate) fn is_dc(&mut self) -> Result<bool, Error> {
        Ok(self.text("FUNC?")? == "DC")
    }

    pub(crate) fn is_on(&mut self) -> Result<bool, Error> {
        Ok(self.line.number(&format!("OUTP{}?", self.channel))? != 0.0)
    }

    /// Voltage at the actuator while no burst runs: the offset, or 0 V if the output is off.
    pub(crate) fn voltage(&mut self) -> Result<f64, Error> {
        if self.is_on()? { Ok(self.gain * self.number("VOLT:OFFS?")?) } else { Ok(0.0) }
    }

    /// Returns an error if the output does not stand still at its offset, or is not what its settings say.
    pub(crate) fn check(&mut self) -> Result<(), Error> {
        let unready = |what: &str, advice: &str| {
            Err(Error::Content(format!("the generator {what}; nothing has moved: {advice}, then try again")))
        };
        let channel = self.channel;
        if self.line.number(&format!("OUTP{channel}:LOAD?"))? < HIGH_IMPEDANCE {
            return unready("counts its voltage for a load of 50 Ohm", "set `OUTP:LOAD INF` at an output of 0 V");
        }
        if !self.line.query(&format!("OUTP{channel}:POL?"))?.starts_with("NORM") {
            return unready("inverts its output", "set `OUTP:POL NORM` at an output of 0 V");
        }
        if !self.is_on()? || self.is_dc()? {
            return Ok(());
        }
        let function = self.text("FUNC?")?;
        let is_at_rest = function.starts_with("ARB") && self.number("BURS:STAT?")? != 0.0;
        if is_at_rest && self.number("VOLT?")? <= 1.01 * LEAST {
            return Ok(());
        }
        unready(&format!("plays {function}"), "choose DC (`FUNC DC`), or switch its output off")
    }

    /// Leaves the wave for a constant voltage: the same, because the wave at rest is at its offset. An output that is
    /// off gets the offset 0.
    pub(crate) fn base(&mut self) -> Result<(), Error> {
        if !self.is_dc()? {
            self.source(&format!("VOLT {LEAST}"))?;
            self.source("BURS:STAT OFF")?;
            self.source("FUNC DC")?;
        }
        if self.is_on()? { Ok(()) } else { self.source("VOLT:OFFS 0") }
    }

    /// The wave to the memory, while the output is at a constant voltage.
    pub(crate) fn upload(&mut self, wave: &Wave) -> Result<(), Error> {
        self.line.wire.watch.stage("upload of the drive", 0, 1)?;
        self.base()?;
        self.source("DATA:VOL:CLE")?;
        self.line.command("FORM:BORD NORM")?;
        self.line.command_bytes(&format!("SOUR{}:DATA:ARB:DAC {NAME},", self.channel), &wave.block())?;
        self.source(&format!("FUNC:ARB \"{NAME}\""))?;
        self.source(&format!("FUNC:ARB:SRAT {}", 1.0 / wave.period))?;
        for command in ["FUNC:ARB:FILT OFF", "VOLT:UNIT VPP", "BURS:MODE TRIG", "BURS:NCYC 1", "BURS:PHAS 0"] {
            self.source(command)?;
        }
        self.line.command(&format!("TRIG{}:SOUR BUS", self.channel))?;
        self.line.command("OUTP:SYNC ON")
    }

    /// Switches the output on, at 0 V if it was off.
    pub(crate) fn switch_on(&mut self) -> Result<(), Error> {
        self.line.command(&format!("OUTP{} ON", self.channel))
    }

    /// Returns an error if a setting [V at the generator] is another one.
    fn kept(&mut self, query: &str, volts: f64, when: &str) -> Result<(), Error> {
        let kept = self.number(query)?;
        if (kept - volts).abs() <= SMALL + SHARE * volts.abs() {
            return Ok(());
        }
        Err(Error::Content(format!("the generator answers {kept} V to `{query}`, not {volts:.4} V, {when}")))
    }

    /// Returns an error if the offset is not this voltage at the actuator [V].
    pub(crate) fn expect(&mut self, voltage: f64, when: &str) -> Result<(), Error> {
        self.kept("VOLT:OFFS?", voltage / self.gain, when)
    }

    /// Waits for the trigger of a burst, at the offset of the wave with its whole amplitude.
    pub(crate) fn arm(&mut self, wave: &Wave) -> Result<(), Error> {
        self.source(&format!("VOLT {LEAST}"))?;
        self.kept("VOLT?", LEAST, "before the wave is chosen")?;
        self.source("FUNC ARB")?;
        self.source("BURS:STAT ON")?;
        let amplitude = (1e6 * wave.amplitude).round() / 1e6;
        self.source(&format!("VOLT {amplitude}"))?;
        self.kept("VOLT?", amplitude, "before the burst")?;
        self.kept("VOLT:OFFS?", wave.offset, "before the burst")
    }

    /// Plays the wave once, and waits until it is at its offset again.
    pub(crate) fn play(&mut self, wave: &Wave) -> Result<(), Error> {
        self.played(0.0, wave.time())?;
        self.line.command("*TRG")?;
        self.until_played(wave.time(), PAUSE, |generator, passed| {
            // Its answer comes once the burst has ended.
            let query = if passed { "*OPC?" } else { "*ESR?" };
            generator.line.number(query).map(|_| passed)
        })?;
        self.base()
    }
}

impl<'a> Moves<'a> for Generator<'a> {
    fn watch(&mut self) -> &mut Watch<'a> {
        &mut self.line.wire.watch
    }

    fn set(&mut self, volts: f64) -> Result<(), Error> {
        let offset = volts / self.gain;
        self.source(&format!("VOLT:OFFS {offset:.6}"))
    }

    /// The oscilloscope waits for its trigger: nothing is measured.
    fn present(&mut self, requested: Option<f64>) -> Result<Vec<(String, f64)>, Error> {
        Ok(requested.map(|volts| ("u_V".to_string(), volts)).into_iter().collect())
    }

    fn bounds(&self) -> (f64, (f64, f64)) {
        (self.fastest, self.range)
    }
}
