//! The shapes of `WAV`. With the length n of a line and the length s of its beginning and end at changing speed,
//!
//! ```text
//! t <= s:        t^2 / (2 s (n - s))
//! t <= n - s:    (t - s / 2) / (n - s)
//! otherwise:     1 - (n - t)^2 / (2 s (n - s))
//! ```
//! `SIN_P` is 1 - cos, with its maximum at a point; `RAMP` is a line up and a line down. It does not do: `TAN`, `NOISE`.

use super::errors::{COUNT, RANGE, SYNTAX, WAVE_TOO_LARGE, refused};
use super::generators::POINTS;
use super::words::{positive, real};
use std::f64::consts::TAU;

/// The points of a segment of a wave.
pub(super) fn segment(shape: &str, arguments: &[&str]) -> Result<Vec<f64>, i32> {
    let numbers: Vec<f64> = arguments.iter().map(|word| real(word)).collect::<Result<_, _>>()?;
    let curve: Curve = match (shape, &numbers[..]) {
        ("PNT", [_, count, points @ ..]) if *count == points.len() as f64 => return Ok(points.to_vec()),
        ("LIN", [_, _, _, wave, _, speed]) => {
            refused(&[(!(0.0..=0.5 * wave).contains(speed), RANGE)])?;
            let (n, speed) = (*wave, *speed);
            // The last point is the end.
            Box::new(move |t| if n > 1.0 { line(t * n / (n - 1.0), n, speed) } else { 1.0 })
        }
        ("SIN_P", [_, _, _, wave, _, centre]) => {
            refused(&[(!(1.0..*wave).contains(centre), RANGE)])?;
            let (n, c) = (*wave, *centre);
            Box::new(move |t| {
                let share = if t < c { 0.5 * t / c } else { (0.5 + 0.5 * (t - c) / (n - c)).min(1.0) };
                0.5 * (1.0 - libm::cos(TAU * share))
            })
        }
        ("RAMP", [_, _, _, wave, _, speed, centre]) => {
            refused(&[(!(1.0..*wave).contains(centre), RANGE)])?;
            refused(&[(!(0.0..=0.5 * centre.min(wave - centre)).contains(speed), RANGE)])?;
            let (n, s, c) = (*wave, *speed, *centre);
            Box::new(move |t| if t <= c { line(t, c, s) } else { 1.0 - line(t - c, n - c, s) })
        }
        ("PNT" | "LIN" | "SIN_P" | "RAMP", _) => return Err(COUNT),
        _ => return Err(SYNTAX),
    };
    // Length of the segment, height, offset, length of the curve, its first point.
    let (length, wave) = (positive(arguments[0])?, positive(arguments[3])?);
    let (height, offset, start) = (numbers[1], numbers[2], numbers[4]);
    refused(&[(length as usize > POINTS, WAVE_TOO_LARGE), (wave > length, RANGE)])?;
    refused(&[(!(0.0..length as f64).contains(&start), RANGE)])?;
    let value = |k: u64| offset + height * curve((k as f64 - start).max(0.0).min(wave as f64));
    Ok((0..length).map(value).collect())
}

/// From 0 to 1, over the points of a curve.
type Curve = Box<dyn Fn(f64) -> f64>;

/// A line of n points with soft ends of s points.
fn line(t: f64, n: f64, s: f64) -> f64 {
    match t {
        _ if t >= n => 1.0,
        _ if t <= s && s > 0.0 => t * t / (2.0 * s * (n - s)),
        _ if t <= n - s => (t - 0.5 * s) / (n - s),
        _ => 1.0 - (n - t) * (n - t) / (2.0 * s * (n - s)),
    }
}
