//! The end of a measurement that failed or was cancelled: attempts to stop, and what became of them as text.

use crate::Left;
use piezoid::Error;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time to connect again.
const AGAIN: Duration = Duration::from_secs(3);

/// Time of one attempt to reach the controller.
pub(crate) const ATTEMPT: Duration = Duration::from_secs(1);

/// Pause between two attempts.
const PAUSE: Duration = Duration::from_millis(30);

/// Stops a wave generator of an axis, by `attempt`, which connects again if its argument is true. Where the axis is
/// left, also as text.
pub(crate) fn insist(
    axis: &str,
    generator: &str,
    mut attempt: impl FnMut(bool) -> Result<Left, Error>,
) -> (Left, String) {
    let mut outcome = attempt(false);
    let begin = Instant::now();
    while outcome.is_err() && begin.elapsed() < AGAIN {
        outcome = attempt(true);
        if outcome.is_err() {
            sleep(PAUSE);
        }
    }
    match outcome {
        Ok(left) => (left, format!("{}, and wave generator {generator} is stopped", left.text(axis))),
        Err(error) => {
            let text = format!(
                "wave generator {generator} could not be stopped, and may run on: {error}; axis {axis} may be at any \
                 voltage: switch the controller off if that is a danger"
            );
            (Left::default(), text)
        }
    }
}
