//! Estimators of the linear block: the list, and the fit with its offset and residuals.
//!
//! Every estimator finds theta of equation (1). Every fit first estimates the constant that the sensor adds to y, by
//! least squares with one constant per record: without it, the fit has a pole at 0 Hz. Estimators of the free run
//! estimate it again together with theta.

use super::Arx;
use super::absolute_error::AbsoluteError;
use super::instrumental::{self, Iterations};
use super::output_error::{OutputError, Refinement};
use super::regression::{Orders, Regression};
use nalgebra::{DMatrix, DVector};
use piezoid_numerics::error::{Error, row};
#[cfg(feature = "clarabel")]
use piezoid_numerics::optimize::least_absolute;
use piezoid_numerics::optimize::{Minimum, Reason, swarm};
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_numerics::series::scatter;
use piezoid_records::record::Record;
use serde::Serialize;

/// A method to estimate theta: a row of [`ESTIMATORS`].
#[derive(Debug, Serialize)]
pub struct Estimator {
    /// As users write it.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Its source.
    pub reference: &'static str,
    #[serde(skip)]
    estimate: fn(&EstimatorInput, &swarm::SwarmSettings, &mut Progress) -> Result<Solution, Error>,
}

/// Input of an estimator.
struct EstimatorInput<'a> {
    records: &'a [Record],
    /// The rows without offsets.
    regression: Regression,
    /// Theta by least squares.
    start: Vec<f64>,
}

/// Theta, and the best cost and theta of each iteration if the estimator iterates.
struct Solution {
    theta: Vec<f64>,
    /// One per record, if the estimator finds its own.
    offsets: Option<Vec<f64>>,
    history: Vec<f64>,
    courses: Vec<Vec<f64>>,
}

impl From<Vec<f64>> for Solution {
    fn from(theta: Vec<f64>) -> Self {
        Solution { theta, offsets: None, history: Vec::new(), courses: Vec::new() }
    }
}

/// All estimators.
pub static ESTIMATORS: &[Estimator] = &[
    Estimator {
        name: "swarm",
        summary: "sum of absolute errors, by particle swarm (the paper's method)",
        reference: "paper, equations (2)-(7); Shi & Eberhart 1998, doi:10.1109/ICEC.1998.699146",
        estimate: |input, settings, progress| {
            let cost = AbsoluteError::from(&input.regression);
            let search_box = input.regression.search_box(&input.start)?;
            let minimum = settings.clone().minimise(&cost, search_box, progress)?;
            if minimum.reason == Reason::Cancelled {
                let (done, total) = (minimum.history.len() - 1, settings.iterations);
                return Err(Error::Cancelled { what: "the swarm".into(), done, total });
            }
            let Minimum { x, history, courses, .. } = minimum;
            Ok(Solution { theta: x, offsets: None, history, courses })
        },
    },
    Estimator {
        name: "least-squares",
        summary: "sum of squared errors, exactly, by QR",
        reference: "Ljung 1998, System Identification: Theory for the User",
        estimate: |input, _, _| Ok(input.start.clone().into()),
    },
    #[cfg(feature = "clarabel")]
    Estimator {
        name: "least-absolute",
        summary: "exact minimum of the sum of absolute errors, by linear programming: for comparison with the swarm",
        reference: "Charnes, Cooper & Ferguson 1955, doi:10.1287/mnsc.1.2.138",
        estimate: |EstimatorInput { regression, .. }, _, _| {
            Ok(least_absolute(&regression.rows, regression.orders.parameters())?.x.into())
        },
    },
    Estimator {
        name: "output-error",
        summary: "sum of squared free-run errors, by Levenberg-Marquardt: not biased by noise in y",
        reference: "Ljung 1998, System Identification; Marquardt 1963, doi:10.1137/0111030",
        estimate: |input, _, progress| {
            let found = OutputError::fit(input.records, input.regression.orders, &Refinement::default(), progress)?;
            let Minimum { x, history, courses, .. } = found.minimum;
            Ok(Solution { theta: x, offsets: Some(found.offsets), history, courses })
        },
    },
    Estimator {
        name: "instrumental",
        summary: "refined instrumental variables: not biased by noise in y, robust to poor starting values",
        reference: "Young & Jakeman 1979, doi:10.1080/00207177908922676; Söderström & Stoica 1983, \
                    doi:10.1007/BFb0009019",
        estimate: |input, _, _| {
            let orders = input.regression.orders;
            let found = instrumental::estimate(input.records, orders, &input.start[..orders.na])?;
            let Iterations { theta, offsets, history, courses, .. } = found;
            Ok(Solution { theta, offsets: Some(offsets), history, courses })
        },
    },
];

impl Estimator {
    /// The estimator called `name`.
    ///
    /// # Errors
    /// [`Error::Unknown`] with all names.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        row("estimator", ESTIMATORS.iter(), |row| row.name, name)
    }

    /// Fits a block of `orders` to one or more records.
    ///
    /// ```
    /// use piezoid::{Record, System, linear::{self, Arx, Orders}, optimize::swarm::SwarmSettings, progress::Stage};
    /// let truth = Arx::new(5e-4, vec![1.6, -0.8], vec![1.0, 0.5, 0.2])?;
    /// let u: Vec<f64> = (0..400).map(|t| f64::from((t * t % 13) as u8) - 6.0).collect();
    /// let y = truth.simulate(&u).iter().map(|y| y + 7.0).collect();
    /// let least_squares = linear::Estimator::find("least-squares")?;
    /// let record = Record::new(5e-4, u, y)?;
    /// let settings = SwarmSettings::default();
    /// let fit = least_squares.fit(&[record], Orders::of(2), &settings, &mut Stage::ignore)?;
    /// assert!((fit.arx.a()[0] - 1.6).abs() < 1e-9 && (fit.offsets[0] - 7.0).abs() < 1e-9);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Regression::new`]; [`Error::Unidentifiable`] if the columns of the regression are linearly
    /// dependent; [`Error::Cancelled`].
    pub fn fit(
        &self,
        records: &[Record],
        orders: Orders,
        settings: &swarm::SwarmSettings,
        progress: &mut Progress,
    ) -> Result<Fit, Error> {
        let regression = Regression::new(records, orders)?;
        let (start, offsets) = least_squares(&regression)?;
        let centred = regression.centred(&offsets);
        let least_squares_sum_abs = residuals(&centred, &start).sum_abs;
        let input = EstimatorInput { records, regression: centred, start };
        let named = &mut |stage: Stage| progress(Stage { what: "linear block", ..stage });
        let Solution { theta, offsets: own, history, courses } = (self.estimate)(&input, settings, named)?;
        let offsets = own.unwrap_or(offsets);
        let (a, b) = theta.split_at(orders.na);
        let b = std::iter::repeat_n(0.0, orders.delay).chain(b.iter().copied()).collect();
        let arx = Arx::new(regression.ts, a.to_vec(), b)?;
        Ok(Fit {
            estimator: self.name,
            arx,
            residuals: residuals(&regression.centred(&offsets), &theta),
            offsets,
            least_squares_sum_abs,
            history,
            courses,
        })
    }
}

/// A fitted block.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Name of the estimator.
    pub estimator: &'static str,
    /// The block.
    pub arx: Arx,
    /// Output offset of each record [output unit].
    pub offsets: Vec<f64>,
    /// Residuals of one-step prediction. Estimators of the free run do not minimise them.
    pub residuals: Residuals,
    /// Sum of absolute residuals of least squares: a search that ends above it has failed.
    pub least_squares_sum_abs: f64,
    /// Best cost at the start and after each iteration; empty for estimators that do not iterate.
    pub history: Vec<f64>,
    /// Best theta at the start and after each iteration; empty for estimators that do not iterate.
    pub courses: Vec<Vec<f64>>,
}

impl Fit {
    /// A note, beginning with "; ", if the order is too low: the prediction error exceeds 2 % of the records' rms, and
    /// a block of twice the order has less than half of it.
    pub fn order_too_low(&self, records: &[Record]) -> Option<String> {
        let n = self.arx.a().len();
        let samples: usize = records.iter().map(Record::len).sum();
        let share = self.residuals.rms / (records.iter().map(|r| scatter(r.y())).sum::<f64>() / samples as f64).sqrt();
        if n == 0 || share.is_nan() || share <= 0.02 {
            return None;
        }
        let least_squares = Estimator::find("least-squares").ok()?;
        let doubled =
            least_squares.fit(records, Orders::of(2 * n), &swarm::SwarmSettings::default(), &mut Stage::ignore).ok()?;
        let times = match self.residuals.rms / doubled.residuals.rms {
            t if t > 1000.0 => "more than 1000".into(),
            t if t > 2.0 => format!("{t:.0}"),
            _ => return None,
        };
        let poles = doubled.arx.poles();
        let rings = poles.iter().filter(|p| p.z.im > 0.0 && p.damping > 0.0);
        let resonance = rings.min_by(|p, q| p.damping.total_cmp(&q.damping)).map_or(String::new(), |p| {
            format!(" and has its resonance at {:.1} Hz with damping {:.3}", p.hz, p.damping)
        });
        Some(format!(
            "; its prediction error is {:.0} % of the records' rms, that of order {} is {times} times \
             smaller{resonance}: order {n} is too low",
            100.0 * share,
            2 * n
        ))
    }
}

/// One-step prediction errors e_t = y_t - psi_t' theta, in the output unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Residuals {
    /// Number of errors.
    pub n: usize,
    /// Sum of absolute values: the paper's fitness f.
    pub sum_abs: f64,
    /// Root mean square.
    pub rms: f64,
    /// Largest absolute value.
    pub max_abs: f64,
    /// Autocorrelation at lag 1; above 2 / sqrt(n) the errors are not white.
    pub lag_one: f64,
}

/// Theta and the output offset of each record, by QR of the rows with one constant per record.
pub(super) fn least_squares(regression: &Regression) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let (stride, d) = (regression.stride(), regression.orders.parameters());
    let columns = d + regression.lengths.len();
    let record_of_row: Vec<usize> =
        regression.lengths.iter().enumerate().flat_map(|(k, &n)| std::iter::repeat_n(k, n)).collect();
    let mut matrix = DMatrix::from_fn(regression.len(), columns, |i, j| match j {
        j if j < d => regression.rows[i * stride + 1 + j],
        j => f64::from(u8::from(record_of_row[i] == j - d)),
    });
    let size: Vec<f64> = matrix.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    for (mut column, size) in matrix.column_iter_mut().zip(&size) {
        column /= *size;
    }
    let mut y = DVector::from_iterator(regression.len(), regression.rows.iter().step_by(stride).copied());
    let qr = matrix.qr();
    let r = qr.r();
    qr.q_tr_mul(&mut y);
    // Columns have length 1: a diagonal entry near rounding is a column that depends on the others.
    let smallest = (0..columns).map(|k| r[(k, k)].abs()).fold(f64::INFINITY, f64::min);
    let solution = if smallest > 1e-13 { r.solve_upper_triangular(&y.rows(0, columns)) } else { None };
    let Some(solution) = solution else {
        return Err(Error::Unidentifiable {
            what: format!("a linear block of {} a and {} b", regression.orders.na, regression.orders.nb),
            because: "the rows of the regression are linearly dependent: the input does not excite enough frequencies \
                      (use a PRBS), or the order is too high"
                .into(),
        });
    };
    let theta: Vec<f64> = (0..d).map(|k| solution[k] / size[k]).collect();
    let still = 1.0 - theta[..regression.orders.na].iter().sum::<f64>();
    let offsets = (d..columns).map(|k| solution[k] / size[k] / still).collect::<Vec<f64>>();
    if still.abs() < 1e-12 || !offsets.iter().all(|c| c.is_finite()) {
        return Err(Error::Unidentifiable {
            what: "the output offset".into(),
            because: "the fit has a pole at 0 Hz, an integrator: remove the drift from the record".into(),
        });
    }
    Ok((theta, offsets))
}

impl Residuals {
    /// True if the lag-1 autocorrelation is that of white noise, within two standard deviations.
    pub fn are_white(&self) -> bool {
        self.lag_one.abs() <= 2.0 / (self.n as f64).sqrt()
    }
}

fn residuals(regression: &Regression, theta: &[f64]) -> Residuals {
    let e: Vec<f64> = regression
        .rows
        .chunks_exact(regression.stride())
        .map(|row| row[0] - row[1..].iter().zip(theta).map(|(psi, theta)| psi * theta).sum::<f64>())
        .collect();
    let energy: f64 = e.iter().map(|e| e * e).sum();
    let neighbours: f64 = e.windows(2).map(|w| w[0] * w[1]).sum();
    Residuals {
        n: e.len(),
        sum_abs: e.iter().map(|e| e.abs()).sum(),
        rms: (energy / e.len() as f64).sqrt(),
        max_abs: e.iter().fold(0.0, |m, e| m.max(e.abs())),
        lag_one: if energy > 0.0 { neighbours / energy } else { 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::assert_close;

    #[test]
    fn every_estimator_finds_block_and_offsets_of_records_without_noise() {
        let truth = Arx::new(5e-4, vec![1.7, -0.9], vec![0.0, 3.0, 2.5]).unwrap();
        let u = Prbs::default().samples(5e-4, 900).unwrap();
        let record = |offset: f64, n: usize| {
            let y = truth.simulate(&u[..n]).iter().map(|y| y + offset).collect();
            Record::new(5e-4, u[..n].to_vec(), y).unwrap()
        };
        let records = [record(40.0, 900), record(-7.0, 500)];
        for estimator in ESTIMATORS {
            let orders = Orders { na: 2, nb: 2, delay: 1 };
            let found = estimator.fit(&records, orders, &swarm::SwarmSettings::default(), &mut Stage::ignore).unwrap();
            let name = estimator.name;
            assert_close(found.arx.a(), truth.a(), 1e-5, 0.0);
            assert_close(found.arx.b(), truth.b(), 1e-4, 0.0);
            assert_close(&found.offsets, &[40.0, -7.0], 1e-6, 0.0);
            assert!(found.residuals.rms < 1e-3, "{name}: {}", found.residuals.rms);
            assert_eq!((found.estimator, found.history.len()), (name, found.courses.len()));
            assert!(found.history.windows(2).all(|w| w[1] <= w[0]), "{name}");
        }
    }

    #[test]
    fn the_offset_of_an_integrator_is_refused() {
        let u: Vec<f64> = Prbs::default().samples(5e-4, 900).unwrap().iter().map(|u| u.signum()).collect();
        let y = Arx::new(5e-4, vec![1.0], vec![0.5]).unwrap().simulate(&u);
        let records = [Record::new(5e-4, u, y).unwrap()];
        let estimator = Estimator::find("least-squares").unwrap();
        let fit = estimator.fit(&records, Orders::of(1), &swarm::SwarmSettings::default(), &mut Stage::ignore);
        let error = fit.unwrap_err().to_string();
        assert!(error.contains("the output offset") && error.contains("a pole at 0 Hz"), "{error}");
    }

    #[test]
    fn an_order_that_is_too_low_is_noted_with_the_resonance() {
        let truth = Arx::new(5e-4, vec![1.7, -0.9], vec![0.0, 3.0, 2.5]).unwrap();
        let u = Prbs::default().samples(5e-4, 900).unwrap();
        let records = [Record::new(5e-4, u.clone(), truth.simulate(&u)).unwrap()];
        let estimator = Estimator::find("least-squares").unwrap();
        let fit = |n| {
            let orders = Orders::of(n);
            estimator.fit(&records, orders, &swarm::SwarmSettings::default(), &mut Stage::ignore).unwrap()
        };
        let (low, right) = (fit(1), fit(2));
        let note = low.order_too_low(&records).unwrap();
        let share = 100.0 * low.residuals.rms / (scatter(records[0].y()) / 900.0).sqrt();
        assert!(note.contains(&format!("{share:.0} % of the records' rms")), "{note}");
        assert!(note.contains("that of order 2 is more than 1000 times smaller"), "{note}");
        let pole = truth.poles()[0];
        assert!(note.contains(&format!("at {:.1} Hz with damping {:.3}", pole.hz, pole.damping)), "{note}");
        assert!(note.ends_with("order 1 is too low"), "{note}");
        assert_eq!(right.order_too_low(&records), None);
        // Noise, which no order explains.
        let noise = piezoid_testing::noise(1, 900);
        let noisy = [Record::new(5e-4, u, noise).unwrap()];
        let fit = estimator.fit(&noisy, Orders::of(1), &swarm::SwarmSettings::default(), &mut Stage::ignore).unwrap();
        assert_eq!(fit.order_too_low(&noisy), None);
    }

    #[test]
    fn residuals_are_those_of_their_definitions() {
        let of = |u: &[f64], y: &[f64]| {
            let records = [Record::new(1.0, u.to_vec(), y.to_vec()).unwrap()];
            residuals(&Regression::new(&records, Orders::of(0)).unwrap(), &[2.0])
        };
        // y - 2 u = 0, -2, 3, 0.
        let found = of(&[1.0, 2.0, 0.0, 4.0], &[2.0, 2.0, 3.0, 8.0]);
        assert_eq!((found.n, found.sum_abs, found.max_abs), (4, 5.0, 3.0));
        assert_close(&[found.rms, found.lag_one], &[(13.0f64 / 4.0).sqrt(), -6.0 / 13.0], 1e-15, 0.0);
        assert_eq!(of(&[1.0, 2.0], &[2.0, 4.0]).lag_one, 0.0);
    }

    #[test]
    fn residuals_are_white_if_neighbours_are_not_correlated() {
        let residuals = |lag_one| Residuals { n: 100, sum_abs: 1.0, rms: 1.0, max_abs: 1.0, lag_one };
        assert!(residuals(0.2).are_white() && residuals(-0.2).are_white());
        assert!(!residuals(0.21).are_white() && !residuals(-0.21).are_white());
    }
}
