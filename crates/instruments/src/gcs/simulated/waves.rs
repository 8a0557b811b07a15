//! The commands of wave tables and generators.

use super::Device;
use super::errors::{COUNT, GENERATOR_RUNS, LENGTHS, NO_WAVE, RANGE, SYNTAX, WAVE_TOO_LARGE, refused};
use super::generators::{Generator, POINTS, WAVES};
use super::segments::segment;
use super::words::{flag, positive, real, triples, whole};

impl Device {
    /// `WAV table mode shape numbers`. Points that no axis can have are refused.
    pub(super) fn write_wave(&mut self, arguments: &[&str]) -> Result<(), i32> {
        let [table, mode, shape, numbers @ ..] = arguments else { return Err(COUNT) };
        refused(&[(self.running() != 0, GENERATOR_RUNS)])?;
        let table = wave_table(table)?;
        let segment = segment(shape, numbers)?;
        let (low, high) = self.widest();
        refused(&[(segment.iter().any(|value| !(low..=high).contains(value)), RANGE)])?;
        let before = self.tables.get(&table).map_or(&[][..], Vec::as_slice);
        let points = match *mode {
            "X" => segment,
            "&" => [before, &segment].concat(),
            "+" => {
                refused(&[(before.len() != segment.len(), LENGTHS)])?;
                before.iter().zip(segment).map(|(a, b)| a + b).collect()
            }
            _ => return Err(SYNTAX),
        };
        refused(&[(points.len() > POINTS, WAVE_TOO_LARGE)])?;
        refused(&[(points.iter().any(|value| !(low..=high).contains(value)), RANGE)])?;
        self.tables.insert(table, points);
        Ok(())
    }

    /// Lowest and highest value that any axis can have in any mode.
    fn widest(&self) -> (f64, f64) {
        let all = self.axes.iter().flat_map(|axis| [axis.values(), axis.travel]);
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (l, h)| (low.min(l), high.max(h)))
    }

    /// `WCL tables`.
    pub(super) fn clear_waves(&mut self, arguments: &[&str]) -> Result<(), i32> {
        refused(&[(self.running() != 0, GENERATOR_RUNS), (arguments.is_empty(), COUNT)])?;
        let tables = arguments.iter().map(|word| wave_table(word)).collect::<Result<Vec<_>, _>>()?;
        tables.iter().for_each(|table| drop(self.tables.remove(table)));
        Ok(())
    }

    /// Sets generators that do not run: each a number and an argument.
    fn set_generators<T>(
        &mut self,
        arguments: &[&str],
        read: impl Fn(&str) -> Result<T, i32>,
        set: impl Fn(&mut Generator, T),
    ) -> Result<(), i32> {
        let pairs = self.of_channels(arguments)?;
        let changes: Vec<(usize, T)> =
            pairs.into_iter().map(|(k, word)| Ok((k, read(word)?))).collect::<Result<_, i32>>()?;
        refused(&[(changes.iter().any(|(k, _)| self.generators[*k].is_running()), GENERATOR_RUNS)])?;
        changes.into_iter().for_each(|(k, value)| set(&mut self.generators[k], value));
        Ok(())
    }

    /// `WSL`, where table 0 is none.
    pub(super) fn select_waves(&mut self, arguments: &[&str]) -> Result<(), i32> {
        let read = |word: &str| if word == "0" { Ok(0) } else { wave_table(word) };
        self.set_generators(arguments, read, |one, table| one.table = table)
    }

    /// `WGC`.
    pub(super) fn set_times(&mut self, arguments: &[&str]) -> Result<(), i32> {
        self.set_generators(arguments, whole, |one, times| one.times = times as u64)
    }

    /// `WOS`.
    pub(super) fn set_offsets(&mut self, arguments: &[&str]) -> Result<(), i32> {
        let (low, high) = self.widest();
        let read = |word: &str| real(word).and_then(|x| if (low..=high).contains(&x) { Ok(x) } else { Err(RANGE) });
        self.set_generators(arguments, read, |one, offset| one.offset = offset)
    }

    /// `WTR`: generator, rate, interpolation; generator 0 means all.
    pub(super) fn set_rates(&mut self, arguments: &[&str]) -> Result<(), i32> {
        let mut changes = Vec::new();
        for triple in triples(arguments)? {
            let these = if triple[0] == "0" { self.channels(&[])? } else { vec![self.channel(triple[0])?] };
            let (rate, is_linear) = (positive(triple[1])?, flag(triple[2])?);
            refused(&[(these.iter().any(|k| self.generators[*k].is_running()), GENERATOR_RUNS)])?;
            changes.extend(these.into_iter().map(|k| (k, rate, is_linear)));
        }
        for (k, rate, is_linear) in changes {
            (self.generators[k].rate, self.generators[k].is_linear) = (rate, is_linear);
        }
        Ok(())
    }

    /// `WGO`: starts (1) or stops (0) generators, all at the same moment.
    pub(super) fn run_waves(&mut self, arguments: &[&str]) -> Result<(), i32> {
        let pairs = self.of_channels(arguments)?;
        let pairs: Vec<(usize, usize)> =
            pairs.into_iter().map(|(k, mode)| Ok((k, whole(mode)?))).collect::<Result<_, i32>>()?;
        for (k, mode) in &pairs {
            let (generator, (low, high)) = (&self.generators[*k], self.axes[*k].limits());
            refused(&[(*mode > 1, RANGE)])?;
            if *mode == 1 {
                refused(&[(generator.is_running(), GENERATOR_RUNS)])?;
                let points = generator.points(&self.tables).ok_or(NO_WAVE)?;
                let is_outside = |value: &f64| !(low..=high).contains(&(value + generator.offset));
                refused(&[(points.iter().any(is_outside), RANGE)])?;
            }
        }
        if pairs.iter().any(|(_, mode)| *mode == 1) {
            self.recorder.plays();
        }
        for (k, mode) in pairs {
            let generator = &mut self.generators[k];
            if mode == 1 { generator.start(&self.tables) } else { generator.stop() }
        }
        Ok(())
    }
}

/// The number of a wave table.
pub(super) fn wave_table(word: &str) -> Result<usize, i32> {
    let table = whole(word)?;
    if (1..=WAVES).contains(&table) { Ok(table) } else { Err(RANGE) }
}
