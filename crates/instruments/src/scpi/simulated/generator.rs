//! The generator: a function, an offset, bursts. Without a burst, an arbitrary wave runs again and again.

use super::commands::{CONFLICT, EXISTS, FULL, IGNORED, MISSING_WAVE, RANGE, UNKNOWN_WORD};
use crate::simulated::CYCLE;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Highest voltage into a high impedance, least amplitude [V], samples of the memory, characters of a name in it.
const HIGHEST: f64 = 10.0;
const LEAST: f64 = 2e-3;
const MEMORY: usize = 1 << 20;
const NAME: usize = 12;

/// Load that means a high impedance, and the output's own resistance [Ohm].
pub(super) const INFINITE: f64 = 9.9e37;
const OWN: f64 = 50.0;

/// The wave that is always there, and to which a cleared memory returns.
const BUILT_IN: &str = "EXP_RISE";

#[derive(Debug)]
pub(super) struct Generator {
    pub(super) function: &'static str,
    pub(super) is_on: bool,
    pub(super) is_inverted: bool,
    pub(super) load: f64,
    pub(super) amplitude: f64,
    pub(super) offset: f64,
    pub(super) frequency: f64,
    pub(super) rate: f64,
    pub(super) is_burst: bool,
    pub(super) cycles: f64,
    pub(super) by_bus: bool,
    pub(super) is_swapped: bool,
    pub(super) selected: String,
    waves: BTreeMap<String, Vec<f64>>,
    /// Time since the wave began [s]; none while a burst waits.
    time: Option<f64>,
}

impl Default for Generator {
    fn default() -> Self {
        let rise = (0..1000).map(|k| 2.0 * (1.0 - libm::exp(-0.005 * f64::from(k))) - 1.0).collect();
        Generator {
            function: "DC",
            is_on: true,
            is_inverted: false,
            load: INFINITE,
            amplitude: 0.2,
            offset: 0.0,
            frequency: 1e3,
            rate: 4e4,
            is_burst: false,
            cycles: 1.0,
            by_bus: false,
            is_swapped: false,
            selected: BUILT_IN.into(),
            waves: BTreeMap::from([(BUILT_IN.to_string(), rise)]),
            time: Some(0.0),
        }
    }
}

impl Generator {
    pub(super) fn is_bursting(&self) -> bool {
        self.function != "DC" && self.is_burst && self.time.is_some()
    }

    pub(super) fn is_moving(&self) -> bool {
        self.function != "DC" && self.time.is_some()
    }

    /// The output after one more servo cycle [V].
    pub(super) fn step(&mut self) -> f64 {
        let output = self.output();
        let length = self.period();
        if let Some(time) = &mut self.time {
            *time += CYCLE;
            // Half a cycle is the error of a sum of cycles.
            if self.is_burst && *time + 0.5 * CYCLE >= self.cycles * length {
                self.time = None;
            }
        }
        output
    }

    /// Time of one period of the function [s].
    fn period(&self) -> f64 {
        if self.function == "ARB" { self.wave().len() as f64 / self.rate } else { 1.0 / self.frequency }
    }

    fn wave(&self) -> &[f64] {
        self.waves.get(&self.selected).map_or(&[0.0], |wave| wave)
    }

    /// The output now [V].
    pub(super) fn output(&self) -> f64 {
        if !self.is_on {
            return 0.0;
        }
        let phase = (self.time.unwrap_or_default() / self.period()).fract();
        let value = match self.function {
            "DC" => 0.0,
            "SIN" => libm::sin(TAU * phase),
            "SQU" => 1.0 - 2.0 * f64::from(phase >= 0.5),
            "RAMP" => 2.0 * phase - 1.0,
            _ => {
                let wave = self.wave();
                // A sample begins at its time, but for the error of a sum.
                let place = self.time.unwrap_or_default() * self.rate + 1e-6;
                wave.get(place as usize % wave.len()).copied().unwrap_or_default()
            }
        };
        let level = self.offset + 0.5 * self.amplitude * value;
        // The settings are those of a load.
        let load = if self.load >= INFINITE { 1.0 } else { (self.load + OWN) / self.load };
        load * if self.is_inverted { -level } else { level }
    }

    /// Begins anew: runs, or waits if it is a burst.
    fn restart(&mut self) {
        self.time = (!self.is_burst).then_some(0.0);
    }

    pub(super) fn choose(&mut self, word: &str) -> Result<(), i32> {
        let known = ["DC", "ARB", "SIN", "SQU", "RAMP"];
        let function = known.into_iter().find(|known| *known == word).ok_or(UNKNOWN_WORD)?;
        self.function = function;
        let was_burst = self.is_burst;
        self.is_burst &= function != "DC";
        self.restart();
        self.adjust()?;
        if was_burst && !self.is_burst { Err(CONFLICT) } else { Ok(()) }
    }

    /// The offset that the amplitude leaves room for.
    fn adjust(&mut self) -> Result<(), i32> {
        let half = if self.function == "DC" { 0.0 } else { 0.5 * self.amplitude };
        // Settings are rounded to a microvolt.
        let most = HIGHEST - half + 1e-6;
        let offset = self.offset.max(-most).min(most);
        let is_same = offset == self.offset;
        self.offset = offset;
        if is_same { Ok(()) } else { Err(CONFLICT) }
    }

    pub(super) fn set_amplitude(&mut self, volts: f64) -> Result<(), i32> {
        if !(LEAST..=2.0 * HIGHEST).contains(&volts) {
            return Err(RANGE);
        }
        self.amplitude = volts;
        self.adjust()
    }

    pub(super) fn set_offset(&mut self, volts: f64) -> Result<(), i32> {
        self.offset = volts;
        self.adjust()
    }

    pub(super) fn set_burst(&mut self, is_burst: bool) -> Result<(), i32> {
        if is_burst && self.function == "DC" {
            return Err(CONFLICT);
        }
        self.is_burst = is_burst;
        self.restart();
        Ok(())
    }

    /// `*TRG`.
    pub(super) fn trigger(&mut self) -> Result<(), i32> {
        if !(self.is_burst && self.by_bus && self.time.is_none()) {
            return Err(IGNORED);
        }
        self.time = Some(0.0);
        Ok(())
    }

    /// `ABOR`.
    pub(super) fn abort(&mut self) {
        if self.is_burst {
            self.time = None;
        }
    }

    pub(super) fn clear(&mut self) {
        self.waves.retain(|name, _| name == BUILT_IN);
        self.select(BUILT_IN).unwrap_or_default();
    }

    pub(super) fn select(&mut self, name: &str) -> Result<(), i32> {
        let name = name.trim_matches('"').to_ascii_uppercase();
        if !self.waves.contains_key(&name) {
            return Err(MISSING_WAVE);
        }
        self.selected = name;
        self.restart();
        Ok(())
    }

    /// A wave to the memory, with values from -1 to 1.
    pub(super) fn keep(&mut self, name: &str, values: Vec<f64>) -> Result<(), i32> {
        let name = name.trim_matches('"').to_ascii_uppercase();
        if values.len() < 8
            || values.len() > MEMORY
            || values.iter().any(|value| value.abs() > 1.0 || !value.is_finite())
        {
            return Err(RANGE);
        }
        if name.len() > NAME {
            return Err(UNKNOWN_WORD);
        }
        if self.waves.contains_key(&name) {
            return Err(EXISTS);
        }
        let held = self.waves.iter().filter(|(name, _)| *name != BUILT_IN).map(|(_, wave)| wave.len()).sum::<usize>();
        if held + values.len() > MEMORY {
            return Err(FULL);
        }
        self.waves.insert(name, values);
        Ok(())
    }
}
