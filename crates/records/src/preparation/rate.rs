//! Another sampling period, and a shift of the output in time: both channels pass the same filter without phase, so
//! that u and y keep their places relative to each other.

use super::kernel::{Ends, KEPT, Kernel};
use crate::record::Record;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{exact, round};

/// A multiple of a sample, up to this rounding.
const ROUNDED: f64 = 1e-6;

/// Maximum number of samples of a result.
const MAX_SAMPLES: f64 = 1e8;

/// One of `factor` samples.
pub(super) fn decimated(record: &Record, factor: usize, ends: Ends) -> Result<Record, Error> {
    let n = record.len();
    let refused = |rule: String| Err(Error::parameter("decimate", factor, rule));
    match factor {
        0 => return refused("must be a whole number, 1 or more".into()),
        1 => return Ok(record.clone()),
        _ if factor >= n => return refused(format!("the record has only {n} samples: choose a smaller factor")),
        _ if ends == Ends::Periodic && !n.is_multiple_of(factor) => {
            return refused(format!("the period of {n} samples is no multiple of it: choose a divisor of {n}"));
        }
        _ => {}
    }
    // Without this, 3 x 1e-4 would be 0.00030000000000000003.
    let ts = format!("{:.14e}", record.ts() * factor as f64).parse().unwrap_or(record.ts() * factor as f64);
    let step = format!("decimated by {factor}, to {} s, {}", round(ts), filter(ts));
    sampled(record, ts, (factor as f64, n.div_ceil(factor)), ends, step)
}

/// The record with the sampling period `ts` [s].
pub(super) fn resampled(record: &Record, ts: f64, ends: Ends) -> Result<Record, Error> {
    piezoid_numerics::error::positive("resample", ts, "seconds")?;
    let (n, ratio) = (record.len() as f64, ts / record.ts());
    let refused = |rule: String| Err(Error::parameter("resample", format!("{ts} s"), rule));
    if (ratio - 1.0).abs() < 1e-9 {
        return Ok(record.clone());
    }
    let count = match ends {
        Ends::Periodic => n / ratio,
        Ends::Turned => ((n - 1.0) / ratio + ROUNDED).floor() + 1.0,
    };
    if count < 2.0 {
        let rule = "fewer than two samples would remain of the record of";
        return refused(format!("{rule} {} s: choose a shorter sampling period", round(record.duration())));
    }
    if count > MAX_SAMPLES {
        let least = round(n * record.ts() / MAX_SAMPLES);
        return refused(format!("the record would have {} samples: choose {least} s or more", exact(count.round())));
    }
    if (count - count.round()).abs() > ROUNDED * count {
        let period = round(record.duration());
        return refused(format!("the period of {period} s is no multiple of it: choose a divisor of {period} s"));
    }
    let band = match ratio > 1.0 {
        true => filter(ts),
        false => format!("by band-limited interpolation; nothing is added above {} Hz", round(0.5 / record.ts())),
    };
    let step = format!("resampled from {} s to {} s, {band}", round(record.ts()), round(ts));
    sampled(record, ts, (ratio, count.round() as usize), ends, step)
}

/// The filter for a longer sampling period, in words.
fn filter(ts: f64) -> String {
    let nyquist = 0.5 / ts;
    let kept = round(KEPT * nyquist);
    format!("with an anti-alias filter that keeps up to {kept} Hz, 0.8 of the new Nyquist frequency")
}

/// Both channels at `count` multiples of `ratio` samples.
fn sampled(record: &Record, ts: f64, (ratio, count): (f64, usize), ends: Ends, step: String) -> Result<Record, Error> {
    let kernel = if ratio > 1.0 { Kernel::anti_alias() } else { Kernel::between() };
    let at = |x: &[f64]| (0..count).map(|k| kernel.at(x, k as f64 * ratio, ratio.max(1.0), ends)).collect();
    Ok(record.with_samples(ts, at(record.u()), at(record.y()))?.with_step(step))
}

/// The record with its output earlier by `delay` [s], later if it is negative. Samples whose output would come from
/// outside the record are cut.
pub(super) fn shifted(record: &Record, delay: f64, ends: Ends) -> Result<Record, Error> {
    let n = record.len();
    let exact = delay / record.ts();
    let samples = if (exact - exact.round()).abs() < 1e-9 * exact.abs() { exact.round() } else { exact };
    if samples == 0.0 {
        return Ok(record.clone());
    }
    if samples.is_nan() || samples.abs() > n as f64 - 2.0 {
        let seconds = round(record.duration());
        let rule = format!("the record is only {seconds} s long, and at least two samples must remain");
        return Err(Error::parameter("delay", format!("{delay} s"), rule));
    }
    let kept = match ends {
        Ends::Periodic => 0..n,
        Ends::Turned => (-samples).max(0.0).ceil() as usize..n - samples.max(0.0).ceil() as usize,
    };
    let kernel = Kernel::between();
    let y = kept.clone().map(|k| kernel.at(record.y(), k as f64 + samples, 1.0, ends)).collect();
    let way = if delay > 0.0 { "earlier" } else { "later" };
    let cut = match (n - kept.len(), delay > 0.0) {
        (0, _) => String::new(),
        (cut, true) => format!("; the last {}, without output, cut", counted(cut)),
        (cut, false) => format!("; the first {}, without output, cut", counted(cut)),
    };
    let amount = format!("{} s ({} samples)", delay.abs(), round(samples.abs()));
    let step = format!("output shifted {way} by {amount}{cut}");
    Ok(record.with_samples(record.ts(), record.u()[kept].to_vec(), y)?.with_step(step))
}

fn counted(n: usize) -> String {
    if n == 1 { "sample".into() } else { format!("{n} samples") }
}
