//! The oscilloscope: two channels, a converter of 8 bits, or of 12 by averaging, 100 thousand samples, an external
//! trigger.

use crate::simulated::CYCLE;
use std::collections::VecDeque;

/// Samples of the memory.
const MEMORY: usize = 100_000;

/// Codes of the noise, peak to peak, in each type.
const NOISE: f64 = 2.0;

#[derive(Debug, Clone, Copy)]
pub(super) struct Channel {
    /// Voltage of the whole screen, and in its middle [V].
    pub(super) range: f64,
    pub(super) offset: f64,
}

#[derive(Debug)]
pub(super) struct Oscilloscope {
    pub(super) channels: [Channel; 2],
    /// Time of the screen, and of its reference after the trigger [s].
    pub(super) range: f64,
    pub(super) position: f64,
    /// Place of the reference, as a share of the screen.
    pub(super) reference: f64,
    pub(super) is_fine: bool,
    pub(super) is_external: bool,
    pub(super) source: usize,
    pub(super) format: &'static str,
    pub(super) points: usize,
    /// True once it is ready for its trigger, until that is read.
    pub(super) is_ready: bool,
    /// Settings that are kept and change nothing.
    pub(super) kept: std::collections::BTreeMap<String, String>,
    state: State,
    /// Samples before the trigger, one a servo cycle.
    before: VecDeque<[f64; 2]>,
    samples: Vec<[u16; 2]>,
    /// Type and times of what is in the memory [s].
    had: (bool, f64, f64),
    cycles: u64,
    noise: u64,
}

#[derive(Debug, PartialEq)]
enum State {
    Stopped,
    Armed,
    /// Servo cycles since the trigger.
    Running(u64),
}

impl Oscilloscope {
    pub(super) fn new(seed: u64) -> Self {
        Oscilloscope {
            channels: [Channel { range: 40.0, offset: 0.0 }; 2],
            range: 1e-3,
            position: 0.0,
            reference: 0.5,
            is_fine: false,
            is_external: false,
            source: 0,
            format: "BYTE",
            points: MEMORY,
            is_ready: false,
            kept: Default::default(),
            state: State::Stopped,
            before: VecDeque::new(),
            samples: Vec::new(),
            had: (false, 0.0, CYCLE),
            cycles: 0,
            noise: seed,
        }
    }

    pub(super) fn is_running(&self) -> bool {
        self.state != State::Stopped
    }

    /// Servo cycles between samples, and samples of a screen.
    fn grid(&self) -> (u64, usize) {
        let cycles = (self.range / CYCLE).ceil().clamp(2.0, 1e9);
        let stride = (cycles / MEMORY as f64).ceil();
        (stride as u64, (cycles / stride) as usize)
    }

    /// Time between samples [s].
    pub(super) fn step_time(&self) -> f64 {
        self.grid().0 as f64 * CYCLE
    }

    /// The left end of the screen in servo cycles after the trigger, negative before it.
    fn start(&self) -> i64 {
        ((self.position - self.reference * self.range) / CYCLE).round().clamp(-1e6, 1e9) as i64
    }

    /// `:SING`.
    pub(super) fn arm(&mut self) {
        (self.state, self.is_ready) = (State::Armed, false);
        self.before.clear();
        self.samples.clear();
    }

    pub(super) fn stop(&mut self) {
        self.state = State::Stopped;
    }

    /// The rising edge of Sync.
    pub(super) fn trigger(&mut self) {
        if self.state == State::Armed && self.is_external && self.before.len() as i64 >= -self.start() {
            let (stride, count) = self.grid();
            self.had = (self.is_fine, self.start() as f64 * CYCLE, stride as f64 * CYCLE);
            (self.state, self.cycles) = (State::Running(0), 0);
            let before: Vec<[f64; 2]> = self.before.drain(..).collect();
            before.into_iter().for_each(|volts| self.keep(volts, stride, count));
        }
    }

    /// One servo cycle.
    pub(super) fn step(&mut self, volts: [f64; 2]) {
        let (start, (stride, count)) = (self.start(), self.grid());
        match self.state {
            State::Stopped => (),
            State::Armed => {
                self.before.push_back(volts);
                if self.before.len() as i64 > (-start).max(0) {
                    self.before.pop_front();
                }
                self.is_ready |= self.before.len() as i64 >= -start;
            }
            State::Running(time) => {
                self.state = State::Running(time + 1);
                if time as i64 >= start {
                    self.keep(volts, stride, count);
                }
                if self.samples.len() >= count {
                    self.state = State::Stopped;
                }
            }
        }
    }

    /// Keeps a sample, if this servo cycle has one.
    fn keep(&mut self, volts: [f64; 2], stride: u64, count: usize) {
        if self.cycles.is_multiple_of(stride) && self.samples.len() < count {
            let [first, second] = volts;
            let sample = [self.code(0, first), self.code(1, second)];
            self.samples.push(sample);
        }
        self.cycles += 1;
    }

    /// The code of a voltage, shifted to 16 bits. The lowest code is 1: 0 is a sample that is missing.
    fn code(&mut self, channel: usize, volts: f64) -> u16 {
        self.noise = self.noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let noise = NOISE * ((self.noise >> 40) as f64 / (1_u64 << 24) as f64 - 0.5);
        let (codes, shift, least) = if self.is_fine { (4096.0, 4, 16.0) } else { (256.0, 8, 1.0) };
        let Channel { range, offset } = self.channels[channel];
        let code = ((volts - offset) / range * codes + 0.5 * codes + noise).round();
        (code.max(least).min(codes - 1.0) as u16) << shift
    }

    /// Samples, and how many of those in the memory one of them stands for.
    fn chosen(&self) -> (usize, usize) {
        let every = self.samples.len().div_ceil(self.points.max(1)).max(1);
        (self.samples.len().div_ceil(every), every)
    }

    /// `:WAV:PRE?`.
    pub(super) fn preamble(&self) -> String {
        let ((points, every), Channel { range, offset }) = (self.chosen(), self.channels[self.source]);
        let (format, codes) = match self.format {
            "WORD" => (1, 65536.0),
            "BYTE" => (0, 256.0),
            _ => (4, 65536.0),
        };
        let (kind, (_, start, step)) = (if self.had.0 { 3 } else { 0 }, self.had);
        let (step, volts, middle) = (every as f64 * step, range / codes, 0.5 * codes);
        format!("{format:+},{kind:+},{points:+},+1,{step:+.8E},{start:+.8E},+0,{volts:+.8E},{offset:+.8E},{middle:+}")
    }

    /// `:WAV:DATA?`.
    pub(super) fn data(&self) -> Vec<u8> {
        let (_, every) = self.chosen();
        let codes = self.samples.iter().step_by(every).map(|sample| sample[self.source]);
        let Channel { range, offset } = self.channels[self.source];
        let bytes: Vec<u8> = match self.format {
            "WORD" => codes.flat_map(u16::to_be_bytes).collect(),
            "BYTE" => codes.map(|code| (code >> 8) as u8).collect(),
            _ => {
                let volts = codes.map(|code| (f64::from(code) / 65536.0 - 0.5) * range + offset);
                volts.map(|volts| format!("{volts:+.5E}")).collect::<Vec<_>>().join(",").into_bytes()
            }
        };
        [format!("#8{:08}", bytes.len()).as_bytes(), &bytes].concat()
    }
}
