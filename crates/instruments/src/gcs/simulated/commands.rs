//! Commands that act: they have no answer, and all of a command is refused or obeyed.

use super::errors::{
    AWAITED, COUNT, GENERATOR_RUNS, POSITION, RANGE, RECORDER_OPTION, RECORDER_SOURCE, SERVO_IS_OFF, SERVO_IS_ON,
    UNKNOWN, VELOCITY, VOLTAGE, refused,
};
use super::recorder::{source, tables};
use super::words::{code, flag, positive, real, triples};
use super::{Behaviour, Device, Model};

/// Servo cycles of an impulse.
const IMPULSE: u64 = 200;

/// Largest velocity, as a multiple of the travel a second.
const FASTEST: f64 = 1000.0;

impl Device {
    /// The answer to a byte that is a command; none if it is unknown.
    pub(super) fn at_once(&mut self, byte: u8) -> Vec<u8> {
        if !matches!(byte, 5 | 7..=9 | 24) {
            return Vec::new();
        }
        if byte != 24 {
            self.time.clock.wait();
        }
        self.update();
        self.log(&format!("#{byte}"));
        match byte {
            5 => format!("{:x}\n", self.moving()).into_bytes(),
            // Ready.
            7 => b"\xb1\n".into(),
            // No macro runs.
            8 => b"0\n".into(),
            9 if self.model == Model::E754 => format!("{:x}\n", self.running()).into_bytes(),
            9 => format!("{:#x}\n", self.running()).into_bytes(),
            _ => {
                let all: Vec<usize> = (0..self.axes.len()).collect();
                self.stop(&all);
                self.time.calm = 0;
                Vec::new()
            }
        }
    }

    /// The lines of the answer to a line: none for a command, and for what is refused.
    pub(super) fn lines(&mut self, line: &str) -> Vec<String> {
        let mut words = line.split_whitespace();
        let Some(name) = words.next() else { return Vec::new() };
        let (name, arguments): (_, Vec<&str>) = (name.to_uppercase(), words.collect());
        let query = name.strip_suffix('?');
        if query.is_some() {
            self.time.clock.wait();
        }
        self.update();
        self.log(line);
        self.recorder.command();
        let outcome = match query {
            _ if !self.model.knows(&name) => Err(UNKNOWN),
            Some("ERR") => Ok(vec![std::mem::take(&mut self.error).to_string()]),
            Some(query) => self.tell(query, &arguments),
            None => {
                self.time.calm = 0;
                self.act(&name, &arguments).map(|()| Vec::new())
            }
        };
        outcome.unwrap_or_else(|error| {
            // Points that are still to be recorded are answered by an empty line.
            self.error = if error == AWAITED { RANGE } else { error };
            vec![String::new(); usize::from(error == AWAITED)]
        })
    }

    fn act(&mut self, name: &str, arguments: &[&str]) -> Result<(), i32> {
        match name {
            "MOV" | "MVR" | "SVA" | "SVR" => {
                let goals = self.goals(name, &self.of_axes(arguments)?)?;
                self.go(&goals);
                Ok(())
            }
            "STE" | "IMP" => {
                let values = self.of_axes(arguments)?;
                let is_closed = values.iter().all(|(k, _)| self.axes[*k].servo);
                let goals = self.goals(if is_closed { "MVR" } else { "SVR" }, &values)?;
                self.recorder.plays();
                let back = (name == "IMP").then_some(IMPULSE);
                goals.into_iter().for_each(|(k, goal)| self.axes[k].kick(goal, back));
                Ok(())
            }
            "GOH" => {
                let home: Vec<(usize, f64)> = self.axes_of(arguments)?.into_iter().map(|k| (k, 0.0)).collect();
                let goals = self.goals("MOV", &home)?;
                self.go(&goals);
                Ok(())
            }
            "STP" | "HLT" => {
                let axes = self.axes_of(if name == "STP" { &[] } else { arguments })?;
                self.stop(&axes);
                Ok(())
            }
            "SVO" => self.close(arguments),
            "VEL" => {
                let speeds = self.of_axes(arguments)?;
                for (k, speed) in &speeds {
                    let (bottom, top) = self.axes[*k].travel;
                    refused(&[(!(*speed > 0.0 && *speed <= FASTEST * (top - bottom)), VELOCITY)])?;
                }
                speeds.into_iter().for_each(|(k, speed)| self.axes[k].velocity = speed);
                Ok(())
            }
            "ATZ" => self.zero(arguments),
            "CCL" => self.set_level(arguments),
            "SPA" => self.set_parameters(arguments, false),
            "SEP" => self.save_parameters(arguments),
            "DRC" => self.set_sources(arguments),
            "DRT" => {
                let of = |table: &str, trigger: &str| {
                    Ok((if table == "0" { tables(&[])? } else { tables(&[table])? }, code(trigger)?))
                };
                let triggers = match arguments {
                    [table, trigger] => vec![of(table, trigger)?],
                    _ => triples(arguments)?.map(|triple| of(triple[0], triple[1])).collect::<Result<_, i32>>()?,
                };
                self.recorder.arm(&triggers)
            }
            "RTR" => match arguments {
                [rate] => {
                    self.recorder.rate = positive(rate)?;
                    Ok(())
                }
                _ => Err(COUNT),
            },
            "WAV" => self.write_wave(arguments),
            "WCL" => self.clear_waves(arguments),
            "WSL" => self.select_waves(arguments),
            "WGC" => self.set_times(arguments),
            "WOS" => self.set_offsets(arguments),
            "WTR" => self.set_rates(arguments),
            "WGO" => self.run_waves(arguments),
            "WGR" => {
                refused(&[(self.running() == 0, super::errors::NO_WAVE)])?;
                self.recorder.plays();
                Ok(())
            }
            _ => Err(UNKNOWN),
        }
    }

    /// Where axes go by positions or open-loop values, absolute or relative: micrometres or volts.
    fn goals(&self, name: &str, values: &[(usize, f64)]) -> Result<Vec<(usize, f64)>, i32> {
        let (is_closed, is_relative) = (name.starts_with('M'), name.ends_with('R'));
        let mut goals = Vec::new();
        for (k, value) in values {
            let axis = &self.axes[*k];
            let unit = if is_closed { 1.0 } else { axis.gain };
            let goal = value * unit + if is_relative { axis.goal } else { 0.0 };
            let (low, high) = if is_closed { axis.travel } else { axis.range };
            refused(&[(is_closed && !axis.servo, SERVO_IS_OFF), (!is_closed && axis.servo, SERVO_IS_ON)])?;
            refused(&[(self.generators[*k].is_running(), GENERATOR_RUNS)])?;
            refused(&[(!(low..=high).contains(&goal), if is_closed { POSITION } else { VOLTAGE })])?;
            goals.push((*k, goal));
        }
        Ok(goals)
    }

    fn go(&mut self, goals: &[(usize, f64)]) {
        self.recorder.moves();
        goals.iter().for_each(|(k, goal)| self.axes[*k].go(*goal));
    }

    /// `SVO`. A wave ends where the servo is switched.
    fn close(&mut self, arguments: &[&str]) -> Result<(), i32> {
        let states = self.with_axes(arguments)?.into_iter().map(|(k, on)| Ok((k, flag(on)?)));
        for (k, servo) in states.collect::<Result<Vec<_>, i32>>()? {
            if self.axes[k].servo != servo {
                self.generators[k].stop();
            }
            self.axes[k].close(servo);
        }
        Ok(())
    }

    /// `ATZ`: in open loop to the voltage, or to 0 V if that is `NaN`. The zero of the sensor is right already.
    fn zero(&mut self, arguments: &[&str]) -> Result<(), i32> {
        let read = |(k, volts): (usize, &str)| {
            let volts = if volts.eq_ignore_ascii_case("nan") { 0.0 } else { real(volts)? };
            let (low, high) = self.axes[k].range;
            refused(&[(self.axes[k].servo, SERVO_IS_ON), (self.generators[k].is_running(), GENERATOR_RUNS)])?;
            refused(&[(!(low..=high).contains(&volts), VOLTAGE)])?;
            Ok((k, volts))
        };
        let all = (0..self.axes.len()).map(|k| (k, "NaN")).collect();
        let requested = if arguments.is_empty() { all } else { self.with_axes(arguments)? };
        let goals = requested.into_iter().map(read).collect::<Result<Vec<_>, i32>>()?;
        for (k, volts) in goals {
            self.axes[k].go(volts);
            self.axes[k].is_zeroed = true;
        }
        Ok(())
    }

    /// `DRC`: table, source, option, and so on.
    fn set_sources(&mut self, arguments: &[&str]) -> Result<(), i32> {
        let mut changes = Vec::new();
        for triple in triples(arguments)? {
            let (table, option) = (tables(&triple[..1])?[0], code(triple[2])?);
            let axis = self.axis(triple[1]).map_err(|_| RECORDER_SOURCE)?;
            refused(&[(source(option).is_none(), RECORDER_OPTION)])?;
            changes.push((table, axis, option));
        }
        for (table, axis, option) in changes {
            let table = &mut self.recorder.tables[table - 1];
            (table.source, table.option) = (axis, option);
        }
        Ok(())
    }
}
