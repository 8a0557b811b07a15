//! The free run of a block against a record with free initial state and offset, and its exact derivatives.
//!
//! ```text
//! A(q) y^_t = B(q) u_t + c_0 d_t + ... + c_{m-1} d_{t-m+1},  y_t = y^_t + k + e_t,  A = 1 - a1 q^-1 - ...,  d impulse
//! dy^/da_i = q^-i v,   dy^/db_j = q^-j w,   v = y^ / A,   w = u / A
//! ```
//! All signals count as zero before the record, and c accounts for the actual initial state: the responses of an ARX to
//! any inputs and outputs before the record are spanned by the m = max(na, last lag of b) first shifts of the impulse
//! response of 1/A. These and the constant k are linear in y^, so they are projected out (variable projection; Golub &
//! Pereyra 1973, doi:10.1137/0710036) with orthonormal columns Q that end where 1/A has decayed. The response to a
//! constant input also lies in Q, so the mean of u is subtracted first to avoid cancellation in the sums of squares.
//! With the best c for every theta, v computed from the whole y^ gives the derivatives at fixed c. Their part outside Q
//! is what no change of c and k can compensate.
//!
//! The columns of the derivatives are shifts of two signals, so the sums of their products follow from each other: sum
//! x_{t-i-1} y_{t-j-1} = sum x_{t-i} y_{t-j} - x_{n-1-i} y_{n-1-j}. J'J is therefore as cheap as a few simulations.

use super::regression::Orders;
use nalgebra::DMatrix;
pub(super) use piezoid_numerics::optimize::levenberg_marquardt::{NormalEquations, SumOfSquares};
use piezoid_numerics::series::{dot_wide, mean};
use piezoid_records::record::Record;
use std::ops::RangeInclusive;

/// Impulse responses end where they have fallen below this share of their largest sample.
const DECAYED: f64 = 1e-14;

/// A column is linearly dependent on others if less than this share of it lies outside their span.
const DEPENDENT: f64 = 1e-9;

/// The sum over records of weighted squared free-run errors, as a function of theta = [a, b].
#[derive(Debug)]
pub(super) struct FreeRunError<'a> {
    pub(super) records: &'a [Record],
    /// One per record.
    pub(super) weights: &'a [f64],
    pub(super) orders: Orders,
}

impl FreeRunError<'_> {
    /// Each record's free run and its weight.
    pub(super) fn runs<'t>(&'t self, theta: &'t [f64]) -> impl Iterator<Item = (FreeRun, f64)> + 't {
        let weighted = self.records.iter().zip(self.weights);
        weighted.map(|(record, &weight)| (FreeRun::new(record, self.orders, theta), weight))
    }
}

impl SumOfSquares for FreeRunError<'_> {
    fn dimension(&self) -> usize {
        self.orders.parameters()
    }

    fn cost(&self, theta: &[f64]) -> f64 {
        if !decays(&theta[..self.orders.na]) {
            return f64::INFINITY;
        }
        self.runs(theta).map(|(run, weight)| weight * dot(&run.e, &run.e)).sum()
    }

    fn normal(&self, theta: &[f64]) -> NormalEquations {
        let mut sums = NormalEquations::empty(self.dimension());
        if !decays(&theta[..self.orders.na]) {
            return NormalEquations { cost: f64::INFINITY, ..sums };
        }
        for (run, weight) in self.runs(theta) {
            sums.add(weight, &run.normal());
        }
        sums
    }
}

/// A series with zeros before it.
#[derive(Debug)]
pub(super) struct PaddedSeries {
    before: usize,
    values: Vec<f64>,
}

impl PaddedSeries {
    /// x_{t-lag} for every t of the record.
    pub(super) fn delayed(&self, lag: usize) -> &[f64] {
        &self.values[self.before - lag..self.values.len() - lag]
    }
}

/// Some shifts of a signal: columns of a matrix.
pub(super) type Shifts<'s> = (&'s PaddedSeries, RangeInclusive<usize>);

/// One record under one theta.
#[derive(Debug)]
pub(super) struct FreeRun {
    orders: Orders,
    a: Vec<f64>,
    /// w = u / A, with the mean of u subtracted.
    w: PaddedSeries,
    /// y^ for the same u, without its constant.
    pub(super) model: Vec<f64>,
    /// e.
    pub(super) e: Vec<f64>,
    /// The constant: y = model + level + e.
    pub(super) level: f64,
    /// k, the constant for u itself [output unit].
    pub(super) offset: f64,
    /// Q.
    past: Past,
}

impl FreeRun {
    /// `theta` must be stable, and the record longer than its orders' history.
    pub(super) fn new(record: &Record, orders: Orders, theta: &[f64]) -> Self {
        let (a, b) = theta.split_at(orders.na);
        let (middle, u) = centred(record.u());
        let w = all_pole(a, &u, orders.reach());
        let mut e = record.y().to_vec();
        for (j, &b) in b.iter().enumerate() {
            e.iter_mut().zip(w.delayed(orders.delay + j)).for_each(|(e, w)| *e -= b * w);
        }
        let past = Past::new(a, orders.history(), record.len());
        let level = past.remove(&mut e);
        let model = record.y().iter().zip(&e).map(|(y, e)| y - e - level).collect();
        let offset = level - middle * b.iter().sum::<f64>() / (1.0 - a.iter().sum::<f64>());
        FreeRun { orders, a: a.to_vec(), w, model, e, level, offset, past }
    }

    /// x / A, from rest.
    pub(super) fn filtered(&self, x: &[f64]) -> PaddedSeries {
        all_pole(&self.a, x, self.orders.reach())
    }

    /// The derivatives of y^ by theta: shifts of v and of w.
    pub(super) fn slopes<'s>(&'s self, v: &'s PaddedSeries) -> [Shifts<'s>; 2] {
        let Orders { na, nb, delay } = self.orders;
        [(v, 1..=na), (&self.w, delay..=delay + nb - 1)]
    }

    /// Sums of the products of the left and the right columns, projected outside Q.
    pub(super) fn products(&self, left: &[Shifts; 2], right: &[Shifts; 2]) -> DMatrix<f64> {
        let size = |columns: &[Shifts; 2]| columns.iter().map(|(_, lags)| lags.clone().count()).sum();
        let mut sums = DMatrix::zeros(size(left), size(right));
        let mut at = (0, 0);
        for (x, lags) in left {
            at.1 = 0;
            for (y, others) in right {
                let shape = (lags.clone().count(), others.clone().count());
                let mut block = sums.view_mut(at, shape);
                for (i, lag) in lags.clone().enumerate() {
                    for (j, other) in others.clone().enumerate() {
                        block[(i, j)] = if i == 0 || j == 0 {
                            dot(x.delayed(lag), y.delayed(other))
                        } else {
                            block[(i - 1, j - 1)] - last(x, lag - 1) * last(y, other - 1)
                        };
                    }
                }
                at.1 += shape.1;
            }
            at.0 += lags.clone().count();
        }
        sums - self.past.shares(left).transpose() * self.past.shares(right)
    }

    /// The normal equations of e.
    fn normal(&self) -> NormalEquations {
        let v = self.filtered(&self.model);
        let slopes = self.slopes(&v);
        let hessian = self.products(&slopes, &slopes);
        NormalEquations {
            cost: dot(&self.e, &self.e),
            // e = y - y^ - k falls as y^ rises.
            gradient: self.along(&slopes).iter().map(|g| -g).collect(),
            hessian: hessian.iter().copied().collect(), // symmetric, so the order does not matter
        }
    }

    /// The sum of the products of each column with e, which is outside Q.
    pub(super) fn along(&self, columns: &[Shifts; 2]) -> Vec<f64> {
        columns.iter().flat_map(|(x, lags)| lags.clone().map(|lag| dot(x.delayed(lag), &self.e))).collect()
    }

    /// The derivatives projected outside Q: one series per entry of theta.
    pub(super) fn jacobian(&self) -> Vec<Vec<f64>> {
        let v = self.filtered(&self.model);
        let columns = self.slopes(&v).into_iter().flat_map(|(x, lags)| lags.map(|lag| x.delayed(lag).to_vec()));
        let outside = |mut column: Vec<f64>| {
            self.past.remove(&mut column);
            column
        };
        columns.map(outside).collect()
    }
}

/// x_{n-1-lag}, the last of the shifted series.
fn last(x: &PaddedSeries, lag: usize) -> f64 {
    x.values[x.values.len() - 1 - lag]
}

/// Q: the responses to a record's past and its offset, as orthonormal columns.
#[derive(Debug)]
pub(super) struct Past {
    /// Responses to the past; they end where they have decayed.
    early: Vec<Vec<f64>>,
    /// The part of a constant outside them, normalised, and its length before that; `None` if it is zero.
    constant: Option<(Vec<f64>, f64)>,
}

impl Past {
    /// For `m` past samples of a block with this `a`, over `n` samples.
    pub(super) fn new(a: &[f64], m: usize, n: usize) -> Self {
        let impulse = impulse_response(a, n);
        let ends = (impulse.len() + m).min(n);
        let mut past = Past { early: Vec::new(), constant: None };
        for lag in 0..m.min(n) {
            let mut column = vec![0.0; lag];
            column.extend(impulse.iter().take(ends - lag));
            column.resize(ends, 0.0);
            if let Some((column, _)) = past.outside(column) {
                past.early.push(column);
            }
        }
        past.constant = past.outside(vec![1.0; n]);
        past
    }

    /// The part of `column` outside Q, normalised, and its length before that.
    fn outside(&self, mut column: Vec<f64>) -> Option<(Vec<f64>, f64)> {
        let whole = dot(&column, &column).sqrt();
        // Twice is enough (Giraud, Langou & Rozloznik 2005, doi:10.1016/j.camwa.2005.08.009).
        self.remove(&mut column);
        self.remove(&mut column);
        let left = dot(&column, &column).sqrt();
        column.iter_mut().for_each(|v| *v /= left);
        (left > DEPENDENT * whole).then_some((column, left))
    }

    /// Subtracts from `x` its part in Q; returns the constant of that part.
    pub(super) fn remove(&self, x: &mut [f64]) -> f64 {
        for q in &self.early {
            let share = dot(q, &x[..q.len()]);
            x.iter_mut().zip(q).for_each(|(x, q)| *x -= share * q);
        }
        let Some((q, length)) = &self.constant else { return 0.0 };
        let share = dot(q, x);
        x.iter_mut().zip(q).for_each(|(x, q)| *x -= share * q);
        share / length
    }

    /// Q' times the columns.
    fn shares(&self, columns: &[Shifts; 2]) -> DMatrix<f64> {
        let q: Vec<&[f64]> = self.early.iter().chain(self.constant.iter().map(|(q, _)| q)).map(Vec::as_slice).collect();
        let x: Vec<&[f64]> = columns.iter().flat_map(|(x, lags)| lags.clone().map(|lag| x.delayed(lag))).collect();
        DMatrix::from_fn(q.len(), x.len(), |i, j| dot(q[i], &x[j][..q[i].len()]))
    }
}

impl Orders {
    /// The longest lag of any column.
    fn reach(&self) -> usize {
        self.history().max(1)
    }
}

/// The scalar product as eight parallel sums.
pub(super) fn dot(x: &[f64], y: &[f64]) -> f64 {
    dot_wide::<8>(x, y)
}

/// The mean of a series, and the series without it.
pub(super) fn centred(x: &[f64]) -> (f64, Vec<f64>) {
    let middle = mean(x);
    (middle, x.iter().map(|x| x - middle).collect())
}

/// x / A from rest, with at least `a.len()` zeros before it.
fn all_pole(a: &[f64], x: &[f64], before: usize) -> PaddedSeries {
    let oldest_first: Vec<f64> = a.iter().rev().copied().collect();
    let mut values = vec![0.0; before + x.len()];
    for (t, &x) in (before..).zip(x) {
        let past = &values[t - a.len()..t];
        values[t] = oldest_first.iter().zip(past).fold(x, |sum, (a, y)| sum + a * y);
    }
    PaddedSeries { before, values }
}

/// The impulse response of 1/A until it has decayed, over at most `n` samples.
fn impulse_response(a: &[f64], n: usize) -> Vec<f64> {
    let (mut values, mut largest, mut quiet) = (vec![1.0], 1.0f64, 0);
    while values.len() < n && quiet < a.len().max(1) {
        let next: f64 = a.iter().zip(values.iter().rev()).map(|(a, y)| a * y).sum();
        largest = largest.max(next.abs());
        quiet = if next.abs() > DECAYED * largest { 0 } else { quiet + 1 };
        values.push(next);
    }
    values
}

/// True if 1 - a1 q^-1 - ... has all poles inside the unit circle. False for NaN.
pub(super) fn decays(a: &[f64]) -> bool {
    decays_within(&mut a.to_vec(), 1.0)
}

/// The same for reflection coefficients below `most` (Schur-Cohn, by the step-down recursion, which uses `c` up): with
/// less than 1, poles keep a distance from the unit circle.
pub fn decays_within(c: &mut [f64], most: f64) -> bool {
    for j in (0..c.len()).rev() {
        let k = c[j];
        if !(k > -most && k < most) {
            return false;
        }
        // Reduces the order by one.
        let scale = 1.0 / (1.0 - k * k);
        for i in 0..j.div_ceil(2) {
            let (front, back) = (c[i], c[j - 1 - i]);
            c[i] = (front + k * back) * scale;
            c[j - 1 - i] = (back + k * front) * scale;
        }
    }
    true
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::linear::Arx;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;

    const ORDERS: Orders = Orders { na: 3, nb: 3, delay: 2 };
    const THETA: [f64; 6] = [1.9, -1.5, 0.5, 2.0, -0.7, 0.3];

    const NEAR: [f64; 6] = [1.85, -1.4, 0.45, 1.5, -0.4, 0.5];

    fn input(n: usize) -> Vec<f64> {
        (0..n).map(|t| f64::from((t * t % 23) as u8) - 5.0 + (t as f64 * 0.3).sin()).collect()
    }

    /// A record with an unknown past and an offset.
    fn record() -> Record {
        let (a, b) = THETA.split_at(3);
        let arx = Arx::new(1.0, a.to_vec(), [&[0.0, 0.0], b].concat()).unwrap();
        let (mut x, u) = (arx.initial(), input(340));
        arx.resume(&mut x, &u[..40]);
        let y = arx.resume(&mut x, &u[40..]).iter().map(|y| y + 7.0).collect();
        Record::new(1.0, u[40..].to_vec(), y).unwrap()
    }

    #[test]
    fn the_true_block_has_no_residual_for_any_past_and_finds_the_offset() {
        let run = FreeRun::new(&record(), ORDERS, &THETA);
        assert_close(&run.e, &[0.0; 300], 0.0, 1e-10);
        assert_close(&[run.offset], &[7.0], 1e-11, 0.0);
    }

    #[test]
    fn an_input_far_from_zero_changes_only_the_offset() {
        let near = record();
        let u: Vec<f64> = near.u().iter().map(|u| u + 1e6).collect();
        let far = [Record::new(1.0, u, near.y().to_vec()).unwrap()];
        let near = [near];
        let normal = |records| FreeRunError { records, weights: &[1.0], orders: ORDERS }.normal(&NEAR);
        assert_close(&normal(&far).hessian, &normal(&near).hessian, 1e-7, 1e-3);
        let offset = |record| FreeRun::new(record, ORDERS, &NEAR).offset;
        let gain = (1.5 - 0.4 + 0.5) / (1.0 - 1.85 + 1.4 - 0.45);
        assert_close(&[offset(&near[0]) - offset(&far[0])], &[1e6 * gain], 1e-9, 0.0);
    }

    #[test]
    fn the_gradient_is_that_of_the_cost() {
        let (records, weights) = ([record(), record().part(20.0, 150.0).unwrap()], [1.0, 0.4]);
        let problem = FreeRunError { records: &records, weights: &weights, orders: ORDERS };
        assert_close(&[problem.normal(&NEAR).cost], &[problem.cost(&NEAR)], 1e-14, 0.0);
        assert_gradient(&problem, &NEAR, 1e-6, 1e-4);
    }

    /// The gradient of `problem` at `x` is that of central differences of its cost.
    pub(in crate::linear) fn assert_gradient(problem: &dyn SumOfSquares, x: &[f64], rtol: f64, atol: f64) {
        let cost = |k: usize, h: f64| {
            let mut moved = x.to_vec();
            moved[k] += h;
            problem.cost(&moved)
        };
        let by_differences: Vec<f64> = (0..x.len()).map(|k| (cost(k, 1e-6) - cost(k, -1e-6)) / 2e-6).collect();
        let gradient: Vec<f64> = problem.normal(x).gradient.iter().map(|g| 2.0 * g).collect();
        assert_close(&gradient, &by_differences, rtol, atol);
    }

    #[test]
    fn recursive_sums_equal_the_sums_of_the_columns() {
        let (records, weights) = ([record()], [1.0]);
        let problem = FreeRunError { records: &records, weights: &weights, orders: ORDERS };
        let (hessian, columns) = (problem.normal(&NEAR).hessian, FreeRun::new(&records[0], ORDERS, &NEAR).jacobian());
        let direct: Vec<f64> = (0..36).map(|k| dot(&columns[k / 6], &columns[k % 6])).collect();
        assert_close(&hessian, &direct, 1e-9, 1e-6);
    }

    #[test]
    fn a_block_decays_when_its_poles_lie_inside_the_circle() {
        for a in [vec![1.7424, -0.9453], vec![1.9, -1.5, 0.5], vec![], vec![0.999999], vec![0.0, 0.0, 0.0, -0.9]] {
            assert!(decays(&a), "{a:?}");
        }
        for a in [vec![1.0], vec![2.0, -1.01], vec![0.0, 0.0, 0.0, -2.0], vec![f64::NAN, 0.1]] {
            assert!(!decays(&a), "{a:?}");
        }
    }

    #[test]
    fn a_pole_so_slow_that_its_decay_looks_like_an_offset_is_handled() {
        let u = input(200);
        let flat = Record::new(1.0, u.clone(), vec![3.0; 200]).unwrap();
        for pole in [0.9, 0.9999, 1.0 - 1e-12] {
            let run = FreeRun::new(&flat, Orders::of(1), &[pole, 0.0, 0.0]);
            assert_close(&run.e, &[0.0; 200], 0.0, 1e-9);
        }
    }
}
