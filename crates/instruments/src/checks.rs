//! What a drive must keep before anything is changed or moves.

use crate::{Drive, Setup};
use piezoid::Error;
use piezoid::excitation::Limits;
use piezoid_numerics::number::round;
use serde_json::Value;

/// Share of the range by which a drive may jump from sample to sample without a limit of slew.
const JUMP: f64 = 0.5;

/// Lowest and highest voltage: the limits, within what the instrument reports.
pub(crate) fn range(limits: &Limits, reported: Option<(f64, f64)>) -> Result<(f64, f64), Error> {
    let (lowest, highest) = reported.unzip();
    let narrower = |a: Option<f64>, b: Option<f64>, narrow: fn(f64, f64) -> f64| match (a, b) {
        (Some(a), Some(b)) => Some(narrow(a, b)),
        (a, b) => a.or(b),
    };
    match (narrower(limits.low, lowest, f64::max), narrower(limits.high, highest, f64::min)) {
        (Some(low), Some(high)) if low < high => Ok((low, high)),
        (Some(low), Some(high)) => Err(Error::Content(format!(
            "the limits and those of the controller leave no voltage, from {low} to {high} V: correct the limits"
        ))),
        _ => Err(Error::Content("the controller reports no limits of its voltage: ".into())
            .needing(vec![("low", Value::Null), ("high", Value::Null)])),
    }
}

impl Setup {
    /// Returns an error if the instrument cannot play the drive within the limits.
    pub(crate) fn check(&self, drive: &Drive) -> Result<(), Error> {
        cycles(drive.ts, self.cycle)?;
        self.reaches(drive)?;
        self.fits(drive)?;
        self.follows(drive)
    }

    /// Most samples of a drive, if that is limited.
    pub fn most_samples(&self) -> Option<usize> {
        self.holds.iter().map(|(_, samples)| *samples).min()
    }

    /// Returns an error if the drive has more samples than the instrument holds.
    fn fits(&self, drive: &Drive) -> Result<(), Error> {
        let n = drive.u.len();
        let Some((what, points)) = self.holds.iter().find(|(_, points)| *points < n) else { return Ok(()) };
        let longest = *points as f64 * drive.ts;
        Err(Error::Content(format!(
            "the drive has {n} samples, but {what} of the controller holds {points}: make it {longest} s or shorter, \
             or sample it less often"
        )))
    }

    /// Returns an error if the drive leaves the range.
    fn reaches(&self, drive: &Drive) -> Result<(), Error> {
        let ((low, high), unit) = (self.range, &self.unit);
        let outside = drive.u.iter().enumerate().find(|(_, u)| !(low..=high).contains(*u));
        let Some((k, value)) = outside else { return Ok(()) };
        let time = k as f64 * drive.ts;
        let message = format!("the drive is {value:.4} {unit} at {time:.6} s, outside {low} to {high} {unit}");
        let advice = if self.is_closed() { "make it smaller" } else { "make it smaller, or give other limits" };
        Err(Error::Content(format!("{message}: {advice}")))
    }

    /// Returns an error if the drive changes faster than the limits allow; without such limits, if it jumps over half
    /// the range.
    fn follows(&self, drive: &Drive) -> Result<(), Error> {
        let Setup { limits, range: (low, high), unit, .. } = self;
        let usage = limits.check(drive.u, drive.ts)?;
        let time = |sample: usize| round(sample as f64 * drive.ts);
        let over: Vec<String> = [Some(usage.slew), usage.current]
            .into_iter()
            .flatten()
            .filter(|peak| peak.exceeds())
            .map(|peak| {
                let (limit, unit) = (round(peak.limit.unwrap_or(f64::INFINITY)), peak.unit.replace('V', unit));
                format!(
                    "{} {} {unit} at {} s, limit {limit} {unit}",
                    peak.quantity,
                    round(peak.value),
                    time(peak.sample)
                )
            })
            .collect();
        if !over.is_empty() {
            let over = over.join("; ");
            return Err(Error::Content(format!("the drive exceeds its limits: {over}; make it slower or smaller")));
        }
        let jump = usage.slew.value * drive.ts;
        if limits.fastest().is_finite() || jump <= JUMP * (high - low) {
            return Ok(());
        }
        let (jump, at) = (round(jump), time(usage.slew.sample));
        let message = format!("the drive jumps by {jump} {unit} at {at} s, over half of {low} to {high} {unit}: ");
        if self.is_closed() {
            return Err(Error::Content(message + "smooth it"));
        }
        Err(Error::Content(message + "to check it, ").advised(vec![("driver", Value::Null), ("slew", Value::Null)]))
    }

    /// True if drives are positions.
    fn is_closed(&self) -> bool {
        self.unit != "V"
    }
}

/// Returns an error if an axis is not within the range [V], but for an error of its voltage.
pub(crate) fn at_place(axis: &str, place: f64, (low, high): (f64, f64), error: f64) -> Result<(), Error> {
    if (low - error..=high + error).contains(&place) {
        return Ok(());
    }
    Err(Error::Content(format!(
        "axis {axis} is at {place:.3} V, outside {low} to {high} V: move it there first, or give other limits"
    )))
}

/// The servo cycles in a sampling period [s].
pub(crate) fn cycles(ts: f64, cycle: f64) -> Result<u64, Error> {
    let cycles = (ts / cycle).round().max(1.0);
    if (ts / cycle / cycles - 1.0).abs() < 1e-6 {
        return Ok(cycles as u64);
    }
    let nearest = cycles * cycle;
    Err(Error::Content(format!(
        "the drive is sampled every {ts} s, but the controller plays multiples of its servo cycle of {cycle} s: sample \
         the drive every {nearest} s"
    )))
}
