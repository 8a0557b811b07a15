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
use piezoid::Error;
use std::time::{Duration, Instant};

/// Time to connect again.
const AGAIN: Duration = Duration::from_secs(3);

/// Time of one attempt to reach the controller.
const ATTEMPT: Duration = Duration::from_secs(1);

/// Pause between two attempts, and between two questions whether the generator still runs; how often it is asked.
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
        self.line.wire.limit(ATTEMPT);
        let mut outcome = self.line.urgent(STOP).and_then(|()| self.stopped());
        let begin = Instant::now();
        while outcome.is_err() && begin.elapsed() < AGAIN {
            self.line.wire.limit(ATTEMPT);
            outcome = self.line.again(STOP).and_then(|()| self.stopped());
            if outcome.is_err() {
                // It is not heeded that the work was cancelled.
                drop(self.line.wire.watch.pause(PAUSE));
            }
        }
        match outcome {
            Ok(left) => (left, format!("{}, and the wave generator is stopped", left.text(AXIS))),
            Err(error) => {
                let text = format!(
                    "the wave generator could not be stopped, and may run on: {error}; axis {AXIS} may be at any \
                     voltage: switch the controller off if that is a danger"
                );
                (Left::default(), text)
            }
        }
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
