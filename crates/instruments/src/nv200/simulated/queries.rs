//! Queries: what they answer is the state of the moment.

use super::Device;
use super::commands::{MISSING, RANGE, TOO_MANY, UNKNOWN, whole};
use super::generator::VALUES;
use super::list::{COMMANDS, GAINS, KEPT};
use super::recorder;

/// The bits of `stat`.
const CONNECTED: u16 = 1;
const STRAIN_GAUGE: u16 = 1 << 1;
const CLOSED: u16 = 1 << 3;
const LOW_PASS: u16 = 1 << 4;
const NOTCH: u16 = 1 << 5;
const AT_LOWEST: u16 = 1 << 14;
const AT_HIGHEST: u16 = 1 << 15;

impl Device {
    pub(super) fn tell(&self, name: &str, arguments: &[&str]) -> Result<String, u8> {
        let (axis, generator, recorder) = (&self.axis, &self.generator, &self.recorder);
        let real = |value: f64| Ok(format!("{name},{value:.3}"));
        let count = |value: u16| Ok(format!("{name},{value}"));
        let text = |value: &str| Ok(format!("{name},{value}"));
        match name {
            "" => Ok("NV200/D_NET>".into()),
            "s" => Ok(COMMANDS.into()),
            "recsrc" | "gbarb" | "gparb" | "imeas" | "recout" | "recoutf" => self.numbered(name, arguments),
            "set" => real(self.set),
            "meas" => real(axis.position),
            "temp" => real(35.0),
            "stat" => count(self.status()),
            "posmin" => real(axis.travel.0),
            "posmax" => real(axis.travel.1),
            "avmin" => real(axis.range.0),
            "avmax" => real(axis.range.1),
            "unitcl" => text("\u{b5}m"),
            "unitol" => text("V"),
            "desc" => text(&self.plant),
            "acserno" => text("000001"),
            "acmeasure" => count(1),
            "modsrc" => count(self.source),
            "cl" => count(axis.servo.into()),
            "sr" => Ok(format!("sr,{:.7}", self.kept.get("sr").copied().unwrap_or(super::UNLIMITED))),
            "grun" => count(generator.is_running().into()),
            "gsarb" => count(generator.start),
            "gearb" => count(generator.end),
            "goarb" => count(generator.offset),
            "giarb" => count(generator.index),
            "gcarb" => count(generator.cycles),
            "gtarb" => count(generator.rate),
            "recast" => count(recorder.start),
            "recstr" => count(recorder.stride),
            "reclen" => count(recorder.length),
            "recrun" => count(recorder.is_running().into()),
            "recidx" => count(recorder.index as u16),
            "pcf" => Ok(GAINS.iter().fold("pcf".into(), |all, gain| {
                format!("{all},{:.3}", self.kept.get(gain).copied().unwrap_or_default())
            })),
            _ => {
                let (name, _, _, first, is_whole) = *KEPT.iter().find(|row| row.0 == name).ok_or(UNKNOWN)?;
                let value = self.kept.get(name).copied().unwrap_or(first);
                if is_whole { Ok(format!("{name},{value}")) } else { real(value) }
            }
        }
    }

    fn status(&self) -> u16 {
        let axis = &self.axis;
        let is_on = |name: &str| self.kept.get(name).is_some_and(|value| *value > 0.0);
        let flags = [
            (axis.servo, CLOSED),
            (is_on("setlpon"), LOW_PASS),
            (is_on("notchon"), NOTCH),
            (axis.voltage <= axis.range.0, AT_LOWEST),
            (axis.voltage >= axis.range.1, AT_HIGHEST),
        ];
        flags.iter().filter(|(is_set, _)| *is_set).fold(CONNECTED | STRAIN_GAUGE, |all, (_, flag)| all | flag)
    }

    /// What has a number: a channel, or an index of the buffer.
    fn numbered(&self, name: &str, arguments: &[&str]) -> Result<String, u8> {
        let (number, rest) = arguments.split_first().ok_or(MISSING)?;
        let last = if name.starts_with('g') { (VALUES - 1) as u16 } else { 1 };
        let number = whole(number, 0, last)?;
        let k = usize::from(number);
        let listed =
            |values: &[f64], head: String| values.iter().fold(head, |all, value| all + &format!(",{value:.3}"));
        match (name, rest) {
            ("recout", [first, count]) => {
                let (from, count) = (whole(first, 0, recorder::VALUES as u16 - 1)?, whole(count, 1, u16::MAX)?);
                let values = self.recorder.part(k, usize::from(from), usize::from(count)).ok_or(RANGE)?;
                Ok(listed(values, format!("{name},{number},{from}")))
            }
            ("recout", [] | [_]) => Err(MISSING),
            (_, [_, ..]) => Err(TOO_MANY),
            ("recoutf", []) => Ok(listed(self.recorder.all(k).ok_or(RANGE)?, format!("{name},{number}"))),
            ("recsrc", []) => Ok(format!("{name},{number},{}", self.recorder.sources[k])),
            ("gbarb", []) => Ok(format!("{name},{number},{:.3}", self.generator.buffer[k])),
            ("gparb", []) => {
                let (low, high) = self.axis.travel;
                Ok(format!("{name},{number},{:.3}", low + 0.01 * self.generator.buffer[k] * (high - low)))
            }
            // No current is simulated.
            _ => Ok(format!("{name},{number},0.000")),
        }
    }
}
