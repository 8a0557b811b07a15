//! The error of the free run of a model on a record.

use super::runs::TrainingRecord;
use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_numerics::series::{mean, scatter};
use tracing::trace_span;

/// Mean of the free-run error of a record, and its rms about that mean.
pub(crate) fn free_run_residual(run: &TrainingRecord, model: &Model) -> (f64, f64) {
    let errors: Vec<f64> = errors(run, model, run.initial).map(|(_, error)| error).collect();
    (mean(&errors), (scatter(&errors) / errors.len() as f64).sqrt())
}

/// Sum of squares of the free-run error from an initial condition, about a line through the errors.
pub(crate) fn free_run_squares(run: &TrainingRecord, model: &Model, initial: InitialCondition) -> f64 {
    squares_about_line(errors(run, model, initial).map(|(t, error)| (t as f64, error)))
}

/// The samples that are usable, with their free-run errors; of a part, those of its record.
fn errors(run: &TrainingRecord, model: &Model, initial: InitialCondition) -> impl Iterator<Item = (usize, f64)> {
    let _span = trace_span!("free run").entered();
    let TrainingRecord { record, usable, .. } = run.whole.unwrap_or(run);
    let simulated = model.follow(&mut model.before(record.u(), initial), record.u());
    let errors = record.y().iter().zip(simulated).zip(usable).enumerate();
    errors.filter(|(_, (_, usable))| **usable).map(|(t, ((y, simulated), _))| (t, y - simulated))
}

/// The sum of squares of points (t, e) about the line of least squares.
fn squares_about_line(points: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut n, mut mt, mut me, mut tt, mut te, mut ee) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (t, e) in points {
        n += 1.0;
        let (dt, de) = (t - mt, e - me);
        mt += dt / n;
        me += de / n;
        tt += dt * (t - mt);
        te += dt * (e - me);
        ee += de * (e - me);
    }
    if tt > 0.0 { ee - te * te / tt } else { ee }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn squares_are_about_the_line_of_least_squares() {
        let line = (0..50).map(|t| (f64::from(t), 3.0 - 0.2 * f64::from(t)));
        // Slope^2 times n (n^2 - 1) / 12 cancels, up to a rounding error in each of n sums.
        let cancelled = 0.2f64.powi(2) * 50.0 * (50.0 * 50.0 - 1.0) / 12.0;
        assert_close(&[squares_about_line(line.clone())], &[0.0], 0.0, 50.0 * f64::EPSILON * cancelled);
        // Alternating errors of one have next to no line.
        let rough = line.map(|(t, e)| (t, e + if t % 2.0 == 0.0 { 1.0 } else { -1.0 }));
        assert_close(&[squares_about_line(rough)], &[50.0], 0.01, 0.0);
    }
}
