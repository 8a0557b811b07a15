//! The arbitrary waveform generator: a buffer of 1024 values, played from an index on, perhaps several times.
//!
//! The first cycle goes from `goarb` to `gearb`, all others from `gsarb` to `gearb`. Each value lasts `gtarb` servo
//! cycles. At rest the index stays where it is, and with it the value.

/// Values of the buffer.
pub(crate) const VALUES: usize = 1024;

#[derive(Debug)]
pub(super) struct Generator {
    /// Shares of the range [%].
    pub(super) buffer: Vec<f64>,
    /// What `gsave` keeps.
    pub(super) saved: Vec<f64>,
    /// Index of the first value, of the first value of further cycles, and of the last one.
    pub(super) offset: u16,
    pub(super) start: u16,
    pub(super) end: u16,
    /// Number of cycles; 0 is endless.
    pub(super) cycles: u16,
    /// Servo cycles a value.
    pub(super) rate: u16,
    /// Where it is.
    pub(super) index: u16,
    /// Servo cycles of this value, and cycles of the wave, that were played, while it runs.
    run: Option<(u16, u16)>,
}

impl Default for Generator {
    fn default() -> Self {
        let buffer = vec![0.0; VALUES];
        let end = (VALUES - 1) as u16;
        Generator { saved: buffer.clone(), buffer, offset: 0, start: 0, end, cycles: 0, rate: 1, index: 0, run: None }
    }
}

impl Generator {
    pub(super) fn is_running(&self) -> bool {
        self.run.is_some()
    }

    pub(super) fn run(&mut self) {
        (self.index, self.run) = (self.offset, Some((0, 0)));
    }

    /// Ends where it is.
    pub(super) fn stop(&mut self) {
        self.run = None;
    }

    /// The value of this servo cycle [%].
    pub(super) fn next(&mut self) -> f64 {
        if let Some((ticks, cycles)) = self.run {
            if ticks < self.rate {
                self.run = Some((ticks + 1, cycles));
            } else if self.index < self.end {
                (self.index, self.run) = (self.index + 1, Some((1, cycles)));
            } else {
                let cycles = cycles.saturating_add(1);
                let is_over = self.cycles > 0 && cycles >= self.cycles;
                self.run = (!is_over).then_some((1, cycles));
                if !is_over {
                    self.index = self.start;
                }
            }
        }
        self.buffer.get(usize::from(self.index)).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn played(generator: &mut Generator, count: usize) -> Vec<f64> {
        (0..count).map(|_| generator.next()).collect()
    }

    #[test]
    fn the_first_cycle_begins_at_the_offset_and_all_others_at_the_start() {
        let buffer = (0..VALUES).map(|k| k as f64).collect();
        let mut generator =
            Generator { buffer, offset: 3, start: 1, end: 4, cycles: 2, rate: 2, ..Generator::default() };
        generator.run();
        assert_eq!(played(&mut generator, 12), [3.0, 3.0, 4.0, 4.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0]);
        assert!(generator.is_running());
        assert_eq!((generator.next(), generator.is_running(), generator.index), (4.0, false, 4));
    }
}
