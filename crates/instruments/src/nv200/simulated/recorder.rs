//! The recorder: two channels of 6144 values, written side by side.

use crate::simulated::axis::Axis;

/// Values of a channel.
pub(crate) const VALUES: usize = 6144;

/// Values of `recast`.
const AT_SET: u16 = 1;
const AT_WAVE: u16 = 2;

#[derive(Debug)]
pub(super) struct Recorder {
    /// What each channel records.
    pub(super) sources: [u16; 2],
    channels: [Vec<f64>; 2],
    /// What starts it.
    pub(super) start: u16,
    /// Servo cycles a value.
    pub(super) stride: u16,
    /// Values; 0 is endless, over the whole buffer again and again.
    pub(super) length: u16,
    /// Where the next value goes.
    pub(super) index: usize,
    /// Servo cycles until the next value, while it records.
    wait: Option<u16>,
    /// True while its start is awaited.
    is_armed: bool,
}

impl Default for Recorder {
    fn default() -> Self {
        let channels = [vec![0.0; VALUES], vec![0.0; VALUES]];
        let length = VALUES as u16;
        Recorder { sources: [0, 2], channels, start: 0, stride: 1, length, index: 0, wait: None, is_armed: false }
    }
}

impl Recorder {
    pub(super) fn is_recording(&self) -> bool {
        self.wait.is_some()
    }

    /// What `recrun` answers.
    pub(super) fn is_running(&self) -> bool {
        self.is_recording() || self.is_armed
    }

    /// Starts, at once or as soon as what starts it comes.
    pub(super) fn run(&mut self) {
        self.is_armed = true;
        if self.start == 0 {
            self.begin();
        }
    }

    pub(super) fn stop(&mut self) {
        (self.wait, self.is_armed) = (None, false);
    }

    fn begin(&mut self) {
        (self.index, self.wait, self.is_armed) = (0, Some(0), false);
    }

    /// A setpoint is set.
    pub(super) fn sets(&mut self) {
        if self.start == AT_SET {
            self.begin();
        }
    }

    /// The generator starts.
    pub(super) fn plays(&mut self) {
        if self.start == AT_WAVE {
            self.begin();
        }
    }

    /// Records this servo cycle.
    pub(super) fn cycle(&mut self, axis: &Axis) {
        let Some(wait) = self.wait else { return };
        if wait > 0 {
            self.wait = Some(wait - 1);
            return;
        }
        for (source, channel) in self.sources.iter().zip(&mut self.channels) {
            channel[self.index] = reading(axis, *source);
        }
        let length = usize::from(self.length);
        self.index += 1;
        self.wait = (length == 0 || self.index < length).then_some(self.stride - 1);
        if self.index == VALUES {
            self.index = 0;
        }
    }

    /// So many values of a channel from an index on, within the length.
    pub(super) fn part(&self, channel: usize, first: usize, count: usize) -> Option<&[f64]> {
        let length = if self.length == 0 { VALUES } else { usize::from(self.length) };
        self.channels.get(channel)?.get(..length)?.get(first..first.checked_add(count)?)
    }

    /// All values of a channel.
    pub(super) fn all(&self, channel: usize) -> Option<&[f64]> {
        let length = if self.length == 0 { VALUES } else { usize::from(self.length) };
        self.part(channel, 0, length)
    }
}

/// What a channel reads. No current is simulated.
pub(super) fn reading(axis: &Axis, source: u16) -> f64 {
    let setpoint = if axis.servo { axis.target } else { axis.demand() };
    // There is no error of the position in open loop.
    let error = if axis.servo { axis.target - axis.position } else { 0.0 };
    match source {
        0 | 5 => axis.position,
        1 => setpoint,
        2 => axis.voltage,
        3 => error,
        4 => error.abs(),
        _ => 0.0,
    }
}
