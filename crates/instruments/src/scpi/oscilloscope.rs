//! The oscilloscope: one acquisition of the drive, started by the Sync output of the generator.
//!
//! ```text
//! :TIM:MODE MAIN; :TIM:REF LEFT; :TIM:RANG ...; :TIM:POS ...   the drive and two of its periods on either side
//! :CHAN2:DISP ON; :CHAN2:COUP DC; :CHAN2:RANG ...; :CHAN2:OFFS ...
//! :TRIG:MODE EDGE; :TRIG:SWE NORM; :TRIG:EDGE:SOUR EXT; :TRIG:EDGE:SLOP POS; :TRIG:EDGE:LEV 1
//! :SING; :AER?                                                 waits for its trigger
//! :OPER:COND?                                                  bit 3: it still runs
//! :WAV:SOUR CHAN2; :WAV:PRE?; :WAV:DATA?                       words of 16 bits, the high byte first
//! volts = (word - yreference) yincrement + yorigin,   time = (k - xreference) xincrement + xorigin
//! ```
//! A left reference is a tenth of the range from the left end of the screen.

use super::line::Line;
use super::trace::Trace;
use super::wave::Wave;
use crate::Drive;
use piezoid::Error;
use std::time::{Duration, Instant};

/// A time over which the memory limits the sampling rate [s].
const LONG: f64 = 100.0;

/// Sampling periods of the drive on either side of it.
const MARGIN: f64 = 2.0;

/// Share of the range on the left of the reference.
const LEFT: f64 = 0.1;

/// The range of a channel over the voltages that are expected in it.
const SPARE: f64 = 1.2;

/// Level of the trigger: Sync is a signal of TTL [V].
const LEVEL: f64 = 1.0;

/// Bit of `:OPER:COND?` while an acquisition runs.
const RUN: u32 = 8;

/// More samples than any memory holds: all there are.
const ALL: usize = 8_000_000;

/// Time in which it must be ready for its trigger, or have ended, beyond that of what it records.
const SOON: Duration = Duration::from_secs(3);

/// Pause between two questions.
const PAUSE: Duration = Duration::from_millis(20);

/// A channel with what one of its volts means.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Probe {
    pub(crate) channel: usize,
    pub(crate) scale: f64,
}

pub(crate) struct Oscilloscope<'a> {
    pub(crate) line: Line<'a>,
    /// Voltage at the actuator, if it is measured.
    pub(crate) monitor: Option<Probe>,
    /// Displacement.
    pub(crate) sensor: Probe,
    /// Lowest and highest voltage of the sensor [V].
    pub(crate) span: (f64, f64),
}

impl Oscilloscope<'_> {
    /// Samples of a drive of which the memory holds three or more for each: two are needed, and rates are rounded.
    pub(crate) fn holds(&mut self) -> Result<usize, Error> {
        for command in [":TIM:MODE MAIN".into(), ":ACQ:TYPE HRES".into(), format!(":TIM:RANG {LONG}")] {
            self.line.command(&command)?;
        }
        Ok((LONG * self.line.number(":ACQ:SRAT?")? / 3.0).clamp(1.0, 1e9) as usize)
    }

    /// Sets ranges, time and trigger for a drive.
    pub(crate) fn configure(&mut self, drive: &Drive, wave: &Wave) -> Result<(), Error> {
        let margin = MARGIN * drive.ts;
        let range = wave.length + 2.0 * margin;
        let position = wave.lead - margin + LEFT * range;
        for command in [
            ":TIM:MODE MAIN".into(),
            ":TIM:REF LEFT".into(),
            format!(":TIM:RANG {range:.9}"),
            format!(":TIM:POS {position:.9}"),
            ":ACQ:TYPE HRES".into(),
            ":TRIG:MODE EDGE".into(),
            ":TRIG:SWE NORM".into(),
            ":TRIG:EDGE:SOUR EXT".into(),
            ":TRIG:EDGE:SLOP POS".into(),
            format!(":TRIG:EDGE:LEV {LEVEL}"),
        ] {
            self.line.command(&command)?;
        }
        if let Some(Probe { channel, scale }) = self.monitor {
            let (low, high) =
                drive.u.iter().fold((f64::MAX, f64::MIN), |(low, high), u| (low.min(u / scale), high.max(u / scale)));
            self.channel(channel, (low, high))?;
        }
        self.channel(self.sensor.channel, self.span)?;
        let step = 1.0 / self.line.number(":ACQ:SRAT?")?;
        if step <= 0.5 * drive.ts * 1.001 {
            return Ok(());
        }
        let (ts, length) = (drive.ts, wave.length);
        Err(Error::Content(format!(
            "the memory of the oscilloscope holds a sample every {step:.3e} s over {length:.3} s, not two in the {ts} s \
             between those of the drive: make the drive shorter, or sample it less often"
        )))
    }

    /// Sets a channel for voltages from `low` to `high`.
    fn channel(&mut self, channel: usize, (low, high): (f64, f64)) -> Result<(), Error> {
        let (range, offset) = ((SPARE * (high - low)).max(0.02), 0.5 * (low + high));
        for command in ["DISP ON".into(), "COUP DC".into(), format!("RANG {range:.6}"), format!("OFFS {offset:.6}")] {
            self.line.command(&format!(":CHAN{channel}:{command}"))?;
        }
        Ok(())
    }

    /// Starts an acquisition, which then waits for its trigger.
    pub(crate) fn arm(&mut self, wave: &Wave) -> Result<(), Error> {
        // What was armed before is forgotten as it is read.
        self.line.number(":AER?")?;
        self.line.command(":SING")?;
        let begin = Instant::now();
        let patience = SOON + Duration::from_secs_f64(wave.length.min(1e6));
        while self.line.number(":AER?")? == 0.0 {
            if begin.elapsed() > patience {
                return Err(Error::Content("the oscilloscope is not ready for its trigger (`:AER?`)".into()));
            }
            self.line.wire.watch.pause(PAUSE)?;
        }
        Ok(())
    }

    /// Waits until the acquisition has ended.
    fn ended(&mut self) -> Result<(), Error> {
        let begin = Instant::now();
        while self.line.number(":OPER:COND?")? as u32 & RUN != 0 {
            if begin.elapsed() > SOON {
                return Err(Error::Content(
                    "the oscilloscope has not ended its acquisition: connect Sync of the generator to its external \
                     trigger (EXT TRIG)"
                        .into(),
                ));
            }
            self.line.wire.watch.pause(PAUSE)?;
        }
        Ok(())
    }

    /// Voltages, if they are measured, and displacements of a drive.
    pub(crate) fn read(&mut self, drive: &Drive, wave: &Wave) -> Result<(Option<Vec<f64>>, Vec<f64>), Error> {
        self.ended()?;
        self.line.wire.watch.stage("the record is read", 0, 1)?;
        let (ts, count, lead) = (drive.ts, drive.u.len(), wave.lead);
        let scaled = |values: Vec<f64>, scale: f64| values.into_iter().map(|v| scale * v).collect();
        let u = match self.monitor {
            None => None,
            Some(probe) => {
                let middle = if drive.joined { 0.0 } else { 0.5 * ts };
                let trace = self.trace(probe.channel, "give another --monitor-gain", drive, wave)?;
                Some(scaled(trace.every(ts, lead + middle, count)?, probe.scale))
            }
        };
        let trace = self.trace(self.sensor.channel, "give a wider --sensor-range", drive, wave)?;
        Ok((u, scaled(trace.every(ts, lead, count)?, self.sensor.scale)))
    }

    /// What a channel recorded [V].
    fn trace(&mut self, channel: usize, advice: &str, drive: &Drive, wave: &Wave) -> Result<Trace, Error> {
        for command in [
            format!(":WAV:SOUR CHAN{channel}"),
            ":WAV:FORM WORD".into(),
            ":WAV:BYT MSBF".into(),
            ":WAV:UNS ON".into(),
            ":WAV:POIN:MODE RAW".into(),
            format!(":WAV:POIN {ALL}"),
        ] {
            self.line.command(&command)?;
        }
        let text = self.line.query(":WAV:PRE?")?;
        let words: Vec<f64> = text.split(',').filter_map(|word| word.trim().parse().ok()).collect();
        let &[_, _, _, _, step, x_origin, x_reference, volts, y_origin, y_reference] = &words[..] else {
            return Err(self.line.strange(&text, "a preamble of ten numbers"));
        };
        if !(step > 0.0 && words.iter().all(|word| word.is_finite())) {
            return Err(self.line.strange(&text, "a preamble of ten numbers"));
        }
        let block = self.line.block(":WAV:DATA?")?;
        let words: Vec<u16> = block.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect();
        let start = x_origin - x_reference * step;
        let time = |k: usize| start + k as f64 * step;
        let is_in_drive = |k: usize| time(k) >= wave.lead && time(k) <= wave.lead + drive.u.len() as f64 * drive.ts;
        // The codes at both ends of a channel, and those of samples that are missing.
        let is_clipped = |word: u16| matches!(word >> 8, 0 | 1 | 255);
        if let Some((k, word)) = words.iter().enumerate().find(|(k, word)| is_in_drive(*k) && is_clipped(**word)) {
            let (end, at) = (if *word >= 1 << 15 { "upper" } else { "lower" }, time(k) - wave.lead);
            return Err(Error::Content(format!(
                "channel {channel} of the oscilloscope is at the {end} end of its range, {at:.6} s into the drive: {advice}"
            )));
        }
        let values = words.iter().map(|word| (f64::from(*word) - y_reference) * volts + y_origin).collect();
        Ok(Trace { start, step, values })
    }
}
