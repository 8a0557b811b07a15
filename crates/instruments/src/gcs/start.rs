//! The beginning of a measurement: where the axis is, its loop is opened, and its gain is checked by a small move.

use crate::Drive;
use crate::checks::at_place;
use crate::gcs::run::Run;
use crate::moves::Moves;
use piezoid::Error;
use std::time::Duration;

/// Relative error at which the gain is said to be another one.
pub(crate) const GAIN_ERROR: f64 = 0.05;

/// Error of a voltage that says nothing [V].
pub(crate) const NOISE: f64 = 0.05;

/// Share of the way to the farthest voltage of the drive by which the gain is checked; the least voltage that shows it
/// [V]; number of steps.
const PROBE: f64 = 0.05;
const LEAST_PROBE: f64 = 0.5;
const PROBES: usize = 10;

/// Time of one of these steps [s].
const STEP: f64 = 0.02;

impl Run<'_> {
    /// The voltage of the axis before anything moves, or its position if the drive is positions, within the range.
    pub(crate) fn place(&mut self) -> Result<f64, Error> {
        if self.is_closed {
            return self.target();
        }
        let measured = if self.axis.servo == Some(true) { self.measured()? } else { None };
        let place = measured.map_or_else(|| self.requested(), Ok)?;
        at_place(&self.axis.name, place, self.range, NOISE).map(|()| place)
    }

    /// Opens the loop, if it is closed. The voltage then requested in open loop, and that measured at the output, if it
    /// is. If they differ, nothing moves, and the loop is closed again.
    pub(crate) fn open_loop(&mut self) -> Result<(f64, Option<f64>), Error> {
        let (name, is_closed) = (self.axis.name.clone(), self.axis.servo == Some(true));
        if is_closed {
            self.line.command(&format!("SVO {name} 0"))?;
        }
        let (start, first) = (self.requested()?, self.measured()?);
        let wrong = match first {
            None if self.gain.is_some() => None,
            None => {
                let rule = "must be given, because the controller does not report its voltage to check it";
                Some(Error::parameter("gain", "(not given)", rule))
            }
            Some(first) if (first - start).abs() > NOISE + GAIN_ERROR * start.abs() => {
                let rule = "is wrong, or the output has an offset: correct the gain, or set the offset to 0";
                let rule = format!("the output is at {first:.3} V, not {start:.3} V: the gain {rule}");
                Some(Error::parameter("gain", self.gain(), rule))
            }
            Some(_) => None,
        };
        let Some(error) = wrong else { return Ok((start, first)) };
        if is_closed {
            self.line.command(&format!("SVO {name} 1"))?;
        }
        Err(error)
    }

    /// Moves from `start` by a small part of the drive and back, and checks what the output does.
    pub(crate) fn check_gain(&mut self, drive: &Drive, start: f64, first: f64) -> Result<(), Error> {
        let farther = |far: f64, u: f64| if (u - start).abs() > (far - start).abs() { u } else { far };
        let way = drive.u.iter().copied().fold(start, farther) - start;
        let probe = way.signum() * (PROBE * way.abs()).max(LEAST_PROBE).min(way.abs());
        let step = STEP.max(probe.abs() / PROBES as f64 / self.fastest);
        let (mut wrong, mut moved) = (None, 0.0);
        for k in 1..=PROBES {
            self.line.watch.stage("check of the gain", k, PROBES)?;
            moved = probe * k as f64 / PROBES as f64;
            self.set(start + moved)?;
            self.line.watch.pause(Duration::from_secs_f64(step))?;
            let voltage = self.measured()?.unwrap_or(start + moved);
            if (voltage - start - moved).abs() > GAIN_ERROR * moved.abs() + NOISE {
                wrong = Some(voltage);
                break;
            }
        }
        self.ramp(start + moved, start, 0.0)?;
        wrong.map_or(Ok(()), |voltage| Err(self.wrong(first, moved, voltage)))
    }

    /// What is wrong if a move changes the output from `first` to `voltage` [V].
    fn wrong(&self, first: f64, moved: f64, voltage: f64) -> Error {
        let (name, channel) = (&self.axis.name, self.channel);
        let gain = self.gain() * (voltage - first) / moved;
        if gain < 0.1 * self.gain() {
            let follows = voltage - first;
            return Error::Content(format!(
                "output channel {channel} does not follow axis {name}: a move of {moved:.3} V gives {follows:.3} V; \
                 give the channel of the axis"
            ));
        }
        let rule = format!("the controller gives about {gain:.4} V for an open-loop value of 1: give this gain");
        Error::parameter("gain", self.gain(), rule)
    }
}
