//! The end of a measurement that failed or was cancelled: the generator is stopped, and the controller states where the
//! axis is. If the line is lost, the client connects again.
//!
//! ```text
//! grun,0        stops the generator; sent before anything is read
//! (empty line)  its answer ends those that were still to come
//! grun          0: it has stopped
//! ```
//! The source of the setpoint stays: the generator at rest holds its voltage.

use super::look::AXIS;
use super::run::Run;
use crate::Left;
use crate::stop::{ATTEMPT, insist};
use piezoid::Error;
use std::time::Duration;

/// Pause between two questions whether the generator still runs, and how often it is asked.
const PAUSE: Duration = Duration::from_millis(30);
const QUERIES: usize = 10;

/// The command that stops the generator.
const STOP: &str = "grun,0";

impl Run<'_> {
    /// Where the axis is.
    pub(crate) fn left(&mut self) -> Result<Left, Error> {
        let servo = self.line.number("cl")? != 0.0;
        Ok(Left { voltage: Some(self.measured()?), servo: Some(servo) })
    }

    /// Stops the generator whatever the line and the user do. Where the axis is left, also as text.
    pub(crate) fn stop(&mut self) -> (Left, String) {
        self.line.wire.watch.ignore();
        insist(AXIS, AXIS, |again| {
            self.line.wire.limit(ATTEMPT);
            if again { self.line.again(STOP) } else { self.line.urgent(STOP) }?;
            self.stopped()
        })
    }

    /// Checks that the generator is stopped. Where the axis is.
    fn stopped(&mut self) -> Result<Left, Error> {
        for _ in 0..QUERIES {
            if self.line.number("grun")? == 0.0 {
                return self.left();
            }
            self.line.wire.watch.pause(PAUSE)?;
        }
        Err(Error::Content("the answer to `grun` is that it still runs".into()))
    }
}
