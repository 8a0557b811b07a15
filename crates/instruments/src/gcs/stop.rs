//! The end of a measurement that failed or was cancelled: the generator is stopped, and the controller states where the
//! axis is. If the line is lost, the client connects again.
//!
//! ```text
//! WGO 1 0      stops the generator; sent before anything is read
//! CSV?         its answer ends those that were still to come
//! #9           the generator is off; otherwise #24 stops all axes
//! VOL? 1, SVO? 1
//! ```

use crate::Left;
use crate::gcs::controller::RUNNING;
use crate::gcs::run::Run;
use piezoid::Error;
use std::time::{Duration, Instant};

/// Time to connect again.
const AGAIN: Duration = Duration::from_secs(3);

/// Time of one attempt to reach the controller.
const ATTEMPT: Duration = Duration::from_secs(1);

/// Pause between two attempts, and between two questions whether the generator still runs.
const PAUSE: Duration = Duration::from_millis(30);

/// How often it is asked.
const QUERIES: usize = 10;

/// The command that stops all axes.
const STOP_ALL: u8 = 24;

impl Run<'_> {
    /// Where the axis is.
    pub(crate) fn left(&mut self) -> Result<Left, Error> {
        let servo = self.line.value(&format!("SVO? {}", self.axis.name))?.map(|servo| servo != 0.0);
        Ok(Left { voltage: self.measured()?, servo })
    }

    /// Stops the generator whatever the line and the user do. Where the axis is left, also as text.
    pub(crate) fn stop(&mut self) -> (Left, String) {
        let (k, stop) = (self.channel, format!("WGO {} 0", self.channel));
        self.line.watch.ignore();
        self.line.limit(ATTEMPT);
        let mut outcome = self.line.urgent(&stop).and_then(|()| self.stopped());
        let begin = Instant::now();
        while outcome.is_err() && begin.elapsed() < AGAIN {
            self.line.limit(ATTEMPT);
            outcome = self.line.again(&stop).and_then(|()| self.stopped());
            if outcome.is_err() {
                // It is not heeded that the work was cancelled.
                drop(self.line.watch.pause(PAUSE));
            }
        }
        match outcome {
            Ok(left) => (left, format!("{}, and wave generator {k} is stopped", left.text(&self.axis.name))),
            Err(error) => {
                let text = format!(
                    "wave generator {k} could not be stopped, and may run on: {error}; axis {} may be at any voltage: \
                     switch the controller off if that is a danger",
                    self.axis.name
                );
                (Left::default(), text)
            }
        }
    }

    /// Checks that the generator is stopped. Where the axis is.
    fn stopped(&mut self) -> Result<Left, Error> {
        self.line.pending()?;
        for k in 0..2 * QUERIES {
            if !self.line.runs(self.channel)? {
                return self.left();
            }
            if k == QUERIES {
                self.line.send(&[STOP_ALL])?;
                self.line.pending()?;
            }
            self.line.watch.pause(PAUSE)?;
        }
        Err(Error::Content(format!("the answer to #{RUNNING} is that it still runs")))
    }
}
