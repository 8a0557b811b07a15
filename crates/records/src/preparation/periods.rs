//! The mean of the periods of a record.
//!
//! ```text
//! m_j = sum over periods k of y_kj / K
//! s^2 = sum over k and j of (y_kj - m_j)^2 / (p (K - 1)),   s_m = s / sqrt(K)
//! ```
//! with p samples in each of K periods. s is the standard deviation of the noise of one period, s_m that of the mean:
//! the noise floor of the result. What repeats with the input is kept. The last K whole periods are averaged, because a
//! record often begins with a transient.
//!
//! Reference: Pintelon & Schoukens 2012, System Identification: A Frequency Domain Approach, doi:10.1002/9781118287422.

use crate::record::Record;
use crate::waveform;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::series::{range, scatter};

/// Largest rms difference between the periods of an input, relative to its rms about its mean.
const SAME: f64 = 0.1;

/// A given period is a whole number of samples up to this rounding.
const WHOLE: f64 = 1e-3;

/// The first period holds a transient if it differs from the others by this multiple of what their scatter explains,
/// and by this share of the range of y.
const TRANSIENT: (f64, f64) = (2.0, 1e-3);

/// The mean period. Without `period` [s], it is that of the input.
pub(super) fn averaged(record: &Record, period: Option<f64>) -> Result<Record, Error> {
    let (n, ts) = (record.len(), record.ts());
    let p = match period {
        Some(seconds) => samples(seconds, record)?,
        None => waveform::period(record.u()).ok_or_else(|| {
            let error = "the input does not repeat to 0.1 %, so no period was found: if it repeats apart from noise, ";
            Error::Content(error.into()).advised(vec![("period", serde_json::Value::Null)])
        })?,
    };
    let (count, start, period) = (n / p, n % p, round(p as f64 * ts));
    let u = Periods::of(&record.u()[start..], p);
    let y = Periods::of(&record.y()[start..], p);
    let rms = (scatter(record.u()) / n as f64).sqrt();
    if u.deviation > SAME * rms {
        let percent = round(100.0 * u.deviation / rms);
        let rule = format!("the input does not repeat with this period: its periods differ by {percent} % of its rms");
        return Err(Error::parameter("period", format!("{period} s"), rule));
    }
    let unit = &record.units().y;
    let [noise, of_mean] = [y.deviation, y.deviation / (count as f64).sqrt()].map(short);
    let transient = transient(&record.y()[start..], p, unit);
    let step = format!(
        "averaged {count} periods of {period} s, the last of the record; standard deviation of the output's noise \
         {noise} {unit}, of the mean {of_mean} {unit}{transient}"
    );
    Ok(record.with_samples(ts, u.mean, y.mean)?.with_step(step))
}

/// A period [s] in samples, of which the record has at least two.
fn samples(seconds: f64, record: &Record) -> Result<usize, Error> {
    let (n, ts) = (record.len(), record.ts());
    let exact = piezoid_numerics::error::positive("period", seconds, "seconds")? / ts;
    let refused = |rule: String| Err(Error::parameter("period", format!("{seconds} s"), rule));
    if exact > n as f64 / 2.0 + WHOLE {
        return refused(format!("the record of {} s has no two periods", round(record.duration())));
    }
    if exact.round() < 1.0 || (exact - exact.round()).abs() > WHOLE {
        let rule = "must be a multiple of the sampling period of";
        return refused(format!("{rule} {ts} s: resample the record first, or give several periods as one"));
    }
    Ok(exact.round() as usize)
}

/// The mean period of a series, and the standard deviation of one period from it.
struct Periods {
    mean: Vec<f64>,
    deviation: f64,
}

impl Periods {
    /// `x` has two or more periods of `p` samples.
    fn of(x: &[f64], p: usize) -> Self {
        let count = (x.len() / p) as f64;
        let mean: Vec<f64> = (0..p).map(|j| x[j..].iter().step_by(p).sum::<f64>() / count).collect();
        let squares: f64 = x.iter().zip(mean.iter().cycle()).map(|(x, m)| (x - m) * (x - m)).sum();
        Periods { mean, deviation: (squares / (p as f64 * (count - 1.0))).sqrt() }
    }
}

/// In words, by how much the first of three or more periods differs from the others, if noise does not explain it.
fn transient(y: &[f64], p: usize, unit: &str) -> String {
    let others = Periods::of(&y[p..], p);
    let count = (y.len() / p - 1) as f64;
    let squares: f64 = y[..p].iter().zip(&others.mean).map(|(y, m)| (y - m) * (y - m)).sum();
    let differs = (squares / p as f64).sqrt();
    let noise = others.deviation * (1.0 + 1.0 / count).sqrt();
    if count > 1.0 && differs > TRANSIENT.0 * noise && differs > TRANSIENT.1 * range(y) {
        let (differs, noise) = (short(differs), short(others.deviation));
        format!(
            "; the first of them differs from the others, like a transient, by {differs} {unit}, and without it the noise \
             is {noise} {unit}"
        )
    } else {
        String::new()
    }
}
