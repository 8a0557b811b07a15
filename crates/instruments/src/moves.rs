//! What all clients do in time: slow moves from one voltage to another along a half cosine, and waiting. Meanwhile they
//! report what the actuator does.

use crate::watch::Watch;
use piezoid::Error;
use std::f64::consts::{FRAC_PI_2, PI};
use std::time::{Duration, Instant};

/// Time between two values of a slow move [s].
const STEP: f64 = 0.02;

/// Largest step of a slow move, as a share of the range.
pub(crate) const LARGEST_STEP: f64 = 0.05;

/// Pause between two looks while the axis settles.
const PAUSE: Duration = Duration::from_millis(50);

/// Time between two reports of what the actuator does [s].
const REPORT: f64 = 0.08;

/// The way whose mean change is the fastest one of a half cosine: that is pi / 2 of the mean.
pub(crate) fn way(from: f64, to: f64) -> f64 {
    FRAC_PI_2 * (to - from).abs()
}

/// A half cosine after its first value, in so many steps.
pub(crate) fn half_cosine(from: f64, to: f64, steps: usize) -> impl Iterator<Item = f64> {
    let value = move |k: usize| {
        let share = 0.5 - 0.5 * libm::cos(PI * k as f64 / steps as f64);
        if k == steps { to } else { from + share * (to - from) }
    };
    (1..=steps).map(value)
}

/// The voltages of a move of this duration [s], and the pause after each; longer if the largest slew rate [V/s] needs
/// it. No step is more than a twentieth of the range.
fn slow_move(from: f64, to: f64, time: f64, fastest: f64, range: (f64, f64)) -> (Vec<f64>, Duration) {
    let way = way(from, to);
    let time = time.max(way / fastest);
    let few = way / (LARGEST_STEP * (range.1 - range.0));
    let steps = (time / STEP).max(few).ceil().max(1.0) as usize;
    (half_cosine(from, to, steps).collect(), Duration::from_secs_f64(time / steps as f64))
}

/// A client that moves the voltage of an axis.
pub(crate) trait Moves<'a> {
    fn watch(&mut self) -> &mut Watch<'a>;

    /// Requests a voltage [V].
    fn set(&mut self, volts: f64) -> Result<(), Error>;

    /// Largest slew rate [V/s], infinite without a limit; lowest and highest voltage [V].
    fn bounds(&self) -> (f64, (f64, f64));

    /// What the actuator does now, by the names of columns of a record, such as `u_V` and `y_um`, as far as it is
    /// measured; `requested` is the voltage, if it is known [V].
    fn present(&mut self, requested: Option<f64>) -> Result<Vec<(String, f64)>, Error>;

    /// Reports what the actuator does, every [`REPORT`] of a work that has taken so long [s]; `last` counts.
    fn report(&mut self, time: f64, last: &mut usize, requested: Option<f64>) -> Result<(), Error> {
        let count = (time / REPORT) as usize;
        if count <= *last {
            return Ok(());
        }
        *last = count;
        let state = self.present(requested)?;
        self.watch().report(&state)
    }

    /// Moves slowly from one voltage to another, in this time [s].
    fn ramp(&mut self, from: f64, to: f64, time: f64) -> Result<(), Error> {
        let (fastest, range) = self.bounds();
        let (values, pause) = slow_move(from, to, time, fastest, range);
        let (begin, mut reports) = (Instant::now(), 0);
        for (k, value) in values.iter().enumerate() {
            self.watch().stage("slow move", k + 1, values.len())?;
            self.set(*value)?;
            let moved = Instant::now();
            self.report(begin.elapsed().as_secs_f64(), &mut reports, Some(*value))?;
            self.watch().pause(pause.saturating_sub(moved.elapsed()))?;
        }
        Ok(())
    }

    /// States that a drive of this length [s] is played, for so long [s] by now.
    fn played(&mut self, time: f64, length: f64) -> Result<(), Error> {
        let [passed, all] = [time.min(length), length].map(|time| (1e3 * time) as usize);
        self.watch().stage("the drive is played [ms]", passed, all)
    }

    /// Waits until a drive of this length [s] has ended. `is_over` asks all the time, so that a lost line is noticed;
    /// it is called with true once that length has passed.
    fn until_played(
        &mut self,
        length: f64,
        pause: Duration,
        mut is_over: impl FnMut(&mut Self, bool) -> Result<bool, Error>,
    ) -> Result<(), Error> {
        let (begin, mut reports) = (Instant::now(), 0);
        loop {
            let time = begin.elapsed().as_secs_f64();
            self.played(time, length)?;
            self.report(time.min(length), &mut reports, None)?;
            if is_over(self, time >= length)? {
                return Ok(());
            }
            if time > 1.5 * length + 10.0 {
                return Err(Error::Content(format!(
                    "the controller has not ended a drive of {length} s after {time:.0} s"
                )));
            }
            self.watch().pause(pause)?;
        }
    }

    /// Waits at a voltage [V] for so long [s].
    fn settle(&mut self, at: f64, time: f64) -> Result<(), Error> {
        let (begin, mut reports) = (Instant::now(), 0);
        loop {
            let passed = begin.elapsed().as_secs_f64();
            if passed >= time {
                return Ok(());
            }
            self.watch().stage("settling [ms]", (1e3 * passed) as usize, (1e3 * time) as usize)?;
            self.report(passed, &mut reports, Some(at))?;
            self.watch().pause(PAUSE.min(Duration::from_secs_f64(time - passed)))?;
        }
    }
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
