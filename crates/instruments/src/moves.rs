//! Slow moves: from one voltage to another along a half cosine.

use crate::watch::Watch;
use piezoid::Error;
use std::f64::consts::FRAC_PI_2;
use std::time::{Duration, Instant};

/// Time between two values of a slow move [s].
const STEP: f64 = 0.02;

/// Largest step of a slow move, as a share of the range.
const LARGEST_STEP: f64 = 0.05;

/// Pause between two looks while the axis settles.
const PAUSE: Duration = Duration::from_millis(50);

/// The voltages of a move of this duration [s], and the pause after each; longer if the largest slew rate [V/s] needs
/// it. No step is more than a twentieth of the range.
pub(crate) fn slow_move(from: f64, to: f64, time: f64, fastest: f64, range: (f64, f64)) -> (Vec<f64>, Duration) {
    // The fastest change of a half cosine is pi / 2 of the mean.
    let way = FRAC_PI_2 * (to - from).abs();
    let time = time.max(way / fastest);
    let few = way / (LARGEST_STEP * (range.1 - range.0));
    let steps = (time / STEP).max(few).ceil().max(1.0) as usize;
    let value = |k: usize| {
        let share = 0.5 - 0.5 * libm::cos(2.0 * FRAC_PI_2 * k as f64 / steps as f64);
        if k == steps { to } else { from + share * (to - from) }
    };
    ((1..=steps).map(value).collect(), Duration::from_secs_f64(time / steps as f64))
}

/// Waits for so long [s].
pub(crate) fn settle(watch: &mut Watch, time: f64) -> Result<(), Error> {
    let begin = Instant::now();
    while begin.elapsed().as_secs_f64() < time {
        let passed = (1e3 * begin.elapsed().as_secs_f64()) as usize;
        watch.stage("settling [ms]", passed, (1e3 * time) as usize)?;
        watch.pause(PAUSE.min(Duration::from_secs_f64(time)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slow_move_keeps_the_slew_rate_and_the_largest_step_and_ends_at_its_goal() {
        for (from, to, time, fastest) in
            [(0.0, 100.0, 0.0, 50.0), (100.0, -20.0, 1.0, f64::INFINITY), (5.0, 5.0, 0.0, 1.0), (0.0, 1e-3, 0.1, 1e9)]
        {
            let (values, pause) = slow_move(from, to, time, fastest, (-20.0, 130.0));
            assert_eq!(values.last(), Some(&to));
            assert!(values.len() as f64 * pause.as_secs_f64() >= time - 1e-6);
            let mut last = from;
            for value in values {
                let step = (value - last).abs();
                assert!(step <= 0.05 * 150.0 + 1e-9 && step <= fastest * pause.as_secs_f64() * 1.001 + 1e-9, "{step}");
                last = value;
            }
        }
    }
}
