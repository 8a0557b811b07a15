//! The end of a measurement that failed or was cancelled: what plays fades to its offset, then the output is constant.
//!
//! ```text
//! VOLT ...                            31 parts of a half cosine from the amplitude to the least one, 10 ms each
//! ABOR; BURS:STAT OFF; FUNC DC        at the offset
//! FUNC?; OUTP1?; VOLT:OFFS?           where the output is
//! ```
//! If the line is lost, or an answer may still come on it, the client connects again before.

use super::generator::Generator;
use super::session::AXIS;
use super::wave::LEAST;
use crate::Left;
use crate::moves::half_cosine;
use crate::stop::{ATTEMPT, insist};
use piezoid::Error;
use std::time::Duration;

/// Steps of a fade: each is at most a twentieth of the amplitude. The pause after each.
const STEPS: usize = 32;
const PAUSE: Duration = Duration::from_millis(10);

/// Time of a fade with its answers.
const FADE: Duration = Duration::from_secs(2);

impl Generator<'_> {
    /// Where the axis is.
    pub(crate) fn left(&mut self) -> Result<Left, Error> {
        Ok(Left { voltage: Some(self.voltage()?), servo: None })
    }

    /// Stops the burst whatever the line and the user do. Where the axis is left, also as text.
    pub(crate) fn stop(&mut self) -> (Left, String) {
        self.line.wire.watch.ignore();
        let channel = self.channel.to_string();
        insist(AXIS, &channel, |again| {
            self.line.wire.limit(ATTEMPT + FADE);
            self.line.clear(again)?;
            self.fade()?;
            if self.is_dc()? { self.left() } else { Err(Error::Content("the function is not DC".into())) }
        })
    }

    /// Lowers the amplitude of what plays, then ends it.
    fn fade(&mut self) -> Result<(), Error> {
        if self.is_dc()? {
            return Ok(());
        }
        let amplitude = self.number("VOLT?")?;
        if amplitude > LEAST {
            for value in half_cosine(amplitude, LEAST, STEPS) {
                self.source(&format!("VOLT {value:.6}"))?;
                self.line.wire.watch.pause(PAUSE)?;
            }
        }
        self.line.command("ABOR")?;
        self.base()
    }
}
