//! The move to rest: slowly to a voltage, which is then measured.

use crate::gcs::run::Run;
use crate::gcs::start::NOISE;
use crate::moves::Moves;
use crate::{Left, Rest};
use piezoid::Error;
use std::time::{Duration, Instant};

/// Error of a voltage at rest, as a share of the range; [`NOISE`] is added.
const ERROR: f64 = 1e-3;

/// Time in which the voltage must be reached, and in which a closed loop must hold it.
const TIME: Duration = Duration::from_secs(1);
const HOLD: Duration = Duration::from_millis(200);

/// Largest change of the voltage by closing the loop, as a share of the range.
const CHANGE: f64 = 0.05;

const PAUSE: Duration = Duration::from_millis(20);

/// The axis before the measurement.
pub(crate) struct Before {
    /// Voltage that was requested in open loop [V]; in closed loop the target [unit of the axis].
    pub(crate) start: f64,
    /// Voltage that was measured, if it was [V].
    pub(crate) first: Option<f64>,
}

impl Before {
    /// The voltage of rest, and what is then measured, if the axis moves [V].
    fn target(&self, rest: Rest) -> Option<(f64, f64)> {
        match rest {
            Rest::Start => Some((self.start, self.first.unwrap_or(self.start))),
            Rest::Zero => Some((0.0, 0.0)),
            Rest::Stay => None,
        }
    }
}

impl Run<'_> {
    /// Moves the axis from the last voltage of a drive to its rest in this time [s], and checks that it is there.
    pub(crate) fn reach(&mut self, rest: Rest, before: &Before, last: f64, time: f64) -> Result<Left, Error> {
        let Some((target, expected)) = before.target(rest) else { return self.left() };
        let (low, high) = self.range;
        let from = self.measured()?.unwrap_or(last).max(low).min(high);
        self.ramp(from, target, time)?;
        let (begin, allowed) = (Instant::now(), NOISE + ERROR * (high - low));
        loop {
            let voltage = self.measured()?.map_or_else(|| self.requested(), Ok)?;
            if (voltage - expected).abs() <= allowed {
                break;
            }
            if begin.elapsed() > TIME {
                return Err(Error::Content(format!("the voltage is {voltage:.3} V after the move to {expected:.3} V")));
            }
            self.line.watch.pause(PAUSE)?;
        }
        if rest == Rest::Start && self.axis.servo == Some(true) {
            close(self, expected)?;
        }
        self.left()
    }
}

/// Closes the loop again. A controller then holds the position where the axis is. If the voltage changes instead, the
/// loop is opened.
fn close(run: &mut Run, voltage: f64) -> Result<(), Error> {
    let name = run.axis.name.clone();
    run.line.command(&format!("SVO {name} 1"))?;
    let (begin, allowed) = (Instant::now(), CHANGE * (run.range.1 - run.range.0));
    while begin.elapsed() < HOLD {
        let now = run.measured()?.unwrap_or(voltage);
        if (now - voltage).abs() > allowed {
            run.line.command(&format!("SVO {name} 0"))?;
            return Err(Error::Content(format!(
                "the servo moved the voltage from {voltage:.3} to {now:.3} V as it was switched on, and is off again"
            )));
        }
        run.line.watch.pause(PAUSE)?;
    }
    Ok(())
}
