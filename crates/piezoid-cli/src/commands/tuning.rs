//! What controllers are tuned to.

use crate::values::positive;
use clap::Args;
use piezoid::control::{ControlLoop, MarginTarget};

/// Lateness and margins.
#[derive(Args)]
pub(crate) struct Tuning {
    /// Samples by which readings come late; controllers are tuned for it.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = late)]
    pub(crate) late: usize,
    /// Gain margin to tune to [dB].
    #[arg(long, value_name = "DB", default_value_t = MarginTarget::default().gain_db, value_parser = positive)]
    #[arg(allow_negative_numbers = true)]
    gain_margin: f64,
    /// Phase margin to tune to [degrees].
    #[arg(long, value_name = "DEGREES", default_value_t = MarginTarget::default().phase_deg, value_parser = positive)]
    #[arg(allow_negative_numbers = true)]
    phase_margin: f64,
}

impl Tuning {
    /// Whether anything but the usual is asked for.
    pub(crate) fn any(&self) -> bool {
        self.late != 0 || self.target() != MarginTarget::default()
    }

    /// The target, detuned as usual.
    pub(crate) fn target(&self) -> MarginTarget {
        MarginTarget { gain_db: self.gain_margin, phase_deg: self.phase_margin, ..MarginTarget::default() }
    }
}

/// Samples that controllers can be tuned for.
fn late(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|n| *n <= ControlLoop::LATEST)
        .ok_or_else(|| format!("it must be a whole number from 0 to {}", ControlLoop::LATEST))
}
