//! The shapes of `WAV`. With the length n of a line and the length s of its beginning and end at changing speed,
//!
//! ```text
//! t <= s:        t^2 / (2 s (n - s))
//! t <= n - s:    (t - s / 2) / (n - s)
//! otherwise:     1 - (n - t)^2 / (2 s (n - s))
//! ```
//! `SIN_P` is 1 - cos, with its maximum at a point; `RAMP` is a line up and a line down. It does not do: `TAN`,
//! `NOISE`.

use super::errors::{COUNT, RANGE, SYNTAX, WAVE_TOO_LARGE, refused};
use super::generators::POINTS;
use super::words::real;
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
            refused(&[(!(1.0..=*wave).contains(centre), RANGE)])?;
            let shorter = if centre < wave { centre.min(wave - centre) } else { *wave };
            refused(&[(!(0.0..=0.5 * shorter).contains(speed), RANGE)])?;
            let (n, s, c) = (*wave, *speed, *centre);
            Box::new(move |t| if t <= c { line(t, c, s) } else { 1.0 - line(t - c, n - c, s) })
        }
        ("PNT" | "LIN" | "SIN_P" | "RAMP", _) => return Err(COUNT),
        _ => return Err(SYNTAX),
    };
    // Length of the segment, height, offset, length of the curve, its first point. A segment that is longer than the
    // curve goes on with its end, a shorter one cuts it.
    let [length, height, offset, wave, start] = [0, 1, 2, 3, 4].map(|k| numbers[k]);
    let is_count = |n: f64| n >= 1.0 && n.fract() == 0.0;
    refused(&[(!is_count(length) || !is_count(wave), RANGE), (length > POINTS as f64, WAVE_TOO_LARGE)])?;
    refused(&[(!(0.0..length).contains(&start), RANGE)])?;
    let value = |k: usize| offset + height * curve((k as f64 - start).max(0.0).min(wave));
    Ok((0..length as usize).map(value).collect())
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

#[cfg(test)]
mod tests {
    use super::*;

    fn points(line: &str) -> Result<Vec<f64>, i32> {
        let words: Vec<&str> = line.split(' ').collect();
        segment(words[0], &words[1..])
    }

    #[test]
    fn a_line_goes_from_its_offset_to_its_height_with_soft_ends() {
        let straight = points("LIN 5 20 -10 5 0 0").unwrap();
        assert_eq!(straight, [-10.0, -5.0, 0.0, 5.0, 10.0]);
        let soft = points("LIN 1201 1 0 1001 100 200").unwrap();
        assert!(soft[..=100].iter().all(|y| *y == 0.0) && soft[1100..].iter().all(|y| (y - 1.0).abs() < 1e-12));
        // At constant speed in the middle, which soft ends raise by n / (n - s); the speed changes nowhere by a jump.
        let slope = |k: usize| soft[k + 1] - soft[k];
        assert!((slope(600) - 1.001 / (1001.0 - 200.0)).abs() < 1e-6 && (slope(600) - slope(400)).abs() < 1e-12);
        assert!((100..1100).all(|k| (slope(k + 1) - slope(k)).abs() < 1.1 * slope(600) / 200.0));
    }

    #[test]
    fn a_ramp_has_its_peak_at_the_centre_and_a_sine_too() {
        for (line, peak) in
            [("RAMP 100 8 1 100 0 10 30", 30), ("SIN_P 100 8 1 100 0 30", 30), ("RAMP 100 8 1 150.0 0 0 150", 99)]
        {
            let all = points(line).unwrap();
            let top = all.iter().fold(0.0, |a: f64, b| a.max(*b));
            assert_eq!((all.len(), all[0], all[peak]), (100, 1.0, top), "{line}");
        }
    }

    #[test]
    fn wrong_shapes_have_the_errors_of_gcs() {
        for (line, error) in [
            ("TAN 1 2 3 4 5 6", SYNTAX),
            ("LIN 5 20 -10 5 0", COUNT),
            ("LIN 5 20 -10 5 0 3", RANGE),
            ("LIN 0 20 -10 5 0 0", RANGE),
            ("LIN 5.5 20 -10 5 0 0", RANGE),
            ("RAMP 10 1 0 10 0 3 5", RANGE),
            ("SIN_P 10 1 0 10 10 5", RANGE),
            ("SIN_P 999999999999 1 0 10 0 5", WAVE_TOO_LARGE),
            ("LIN 5 x -10 5 0 0", super::super::errors::NUMBER),
        ] {
            assert_eq!(points(line), Err(error), "{line}");
        }
    }
}
