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
use crate::stop::{ATTEMPT, insist};
use piezoid::Error;
use std::time::Duration;

/// Pause between two questions whether the generator still runs.
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
        let (k, axis) = (self.channel.to_string(), self.axis.name.clone());
        let stop = format!("WGO {k} 0");
        self.line.watch.ignore();
        insist(&axis, &k, |again| {
            self.line.limit(ATTEMPT);
            if again { self.line.again(&stop) } else { self.line.urgent(&stop) }?;
            self.stopped()
        })
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
