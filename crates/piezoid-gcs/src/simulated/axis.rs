//! The axis: a plant, its voltage, and a servo that integrates.

use super::CYCLE;
use piezoid::System;
use piezoid::plant::Plant;

/// Time that a command to move takes [s].
pub(super) const MOVE: f64 = 0.02;

/// Time that a move in closed loop takes [s].
const CLOSED_MOVE: f64 = 1.0;

/// Bandwidth of the servo [Hz]: far below every resonance.
const BANDWIDTH: f64 = 3.0;

#[derive(Debug)]
pub(super) struct SimulatedAxis {
    plant: Plant,
    /// State of the plant.
    x: Vec<f64>,
    /// Lowest and highest voltage [V].
    pub(super) range: (f64, f64),
    /// Voltage of an open-loop value of 1 [V].
    pub(super) gain: f64,
    /// Voltage of the output [V].
    pub(super) voltage: f64,
    /// Last reading of the sensor [um].
    pub(super) position: f64,
    pub(super) servo: bool,
    /// Target in closed loop [um].
    pub(super) target: f64,
    /// Lowest and highest position [um].
    pub(super) travel: (f64, f64),
}

impl SimulatedAxis {
    pub(super) fn new(plant: Plant, range: (f64, f64), gain: f64) -> Self {
        let ends = |v: f64| plant.tip(&plant.settled(v));
        let travel = (ends(range.0), ends(range.1));
        let x = plant.initial();
        let mut axis =
            SimulatedAxis { plant, x, range, gain, voltage: 0.0, position: 0.0, servo: false, target: 0.0, travel };
        axis.hold(MOVE);
        axis
    }

    /// One servo cycle with the present voltage.
    fn cycle(&mut self) {
        self.position = self.plant.step(&mut self.x, self.voltage);
    }

    /// One servo cycle with an open-loop value, or with a target in closed loop.
    pub(super) fn follow(&mut self, value: f64) {
        if self.servo {
            self.target = value;
            let ((low, high), (bottom, top)) = (self.range, self.travel);
            let per_micrometre = (high - low) / (top - bottom);
            let step = std::f64::consts::TAU * BANDWIDTH * CYCLE * per_micrometre * (value - self.position);
            self.voltage = (self.voltage + step).clamp(low, high);
        } else {
            self.voltage = (value * self.gain).clamp(self.range.0, self.range.1);
        }
        self.cycle();
    }

    /// Holds the voltage.
    pub(super) fn hold(&mut self, time: f64) {
        (0..(time / CYCLE) as usize).for_each(|_| self.cycle());
    }

    /// Moves to a value, and lets time pass.
    pub(super) fn go(&mut self, value: f64) {
        let time = if self.servo { CLOSED_MOVE } else { MOVE };
        (0..(time / CYCLE) as usize).for_each(|_| self.follow(value));
    }

    /// What the recorder reads with this option of `HDR?`.
    pub(super) fn reading(&self, option: u32) -> f64 {
        let target = if self.servo { self.target } else { self.position };
        match option {
            1 => target,
            3 => target - self.position,
            16 => self.voltage,
            _ => self.position,
        }
    }

    /// Opens or closes the loop, without a move.
    pub(super) fn close(&mut self, servo: bool) {
        self.servo = servo;
        self.target = self.position;
    }
}
