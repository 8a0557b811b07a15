//! The free-run error of a block as a function of its modes, its feed-through and its delay.
//!
//! ```text
//! G(s) = exp(-tau s) (r + sum_i k_i w_i^2 / (s^2 + 2 zeta_i w_i s + w_i^2))            input held over each sample
//! mode:  2 Re R (g1 q^-L + g2 q^-L-1) w,   w = u / (1 - z q^-1),   z = exp(s Ts),   R = k w / (2 i sqrt(1 - zeta^2))
//! tau = (L - 1 + mu) Ts:  g1 = (exp(s (1 - mu) Ts) - 1) / s,   g2 = (z - exp(s (1 - mu) Ts)) / s,   0 <= mu <= 1
//! ```
//! s is the pole with positive imaginary part. The law is exact: Åström & Wittenmark 1997, Computer-Controlled Systems,
//! 2.3. An output logged after its input acted has a delay of -Ts. The unknowns are ln w, ln zeta and k of each mode,
//! r, and the delay in samples, with analytic derivatives. Past and offset of each record are free and projected out as
//! in `free_run.rs`.
//!
//! The feed-through jumps where the delay passes whole samples, so L is fixed, and the delay is clamped to its sample.

use super::Arx;
use super::free_run::{Past, centred, dot};
use libm::{exp, log};
use nalgebra::{Cholesky, Complex, DMatrix, DVector};
use piezoid_numerics::complex;
use piezoid_numerics::error::Error;
pub(super) use piezoid_numerics::optimize::levenberg_marquardt::{NormalEquations, SumOfSquares};
use piezoid_records::record::Record;
use std::f64::consts::TAU;

/// Starting values of the delay within a sample.
const PARTS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// The weighted squared free-run errors as a function of modes, feed-through and delay, for one L.
#[derive(Debug)]
pub(super) struct ModalError<'a> {
    pub(super) records: &'a [Record],
    pub(super) weights: &'a [f64],
    pub(super) modes: usize,
    /// L: the delay lies between L - 1 and L samples.
    pub(super) whole: usize,
}

/// A mode under a held input, with its derivatives by ln w, ln zeta and mu.
struct HeldMode {
    z: Complex<f64>,
    /// R g1 and R g2 for k = 1.
    c: [Complex<f64>; 2],
    k: f64,
    /// Derivatives of z, R g1 and R g2.
    slopes: [[Complex<f64>; 3]; 3],
}

impl HeldMode {
    /// The mode of the unknowns `x` = [ln w, ln zeta, k], delayed by the fraction `mu` of a sample.
    fn new(x: &[f64], mu: f64, ts: f64) -> Self {
        let (w, zeta) = (exp(x[0]), exp(x[1]));
        let root = (1.0 - zeta * zeta).sqrt();
        let s = w * Complex::new(-zeta, root);
        let (z, rest) = (complex::exp(s * ts), complex::exp(s * (1.0 - mu) * ts));
        let (g1, g2) = ((rest - 1.0) / s, (z - rest) / s);
        let r = Complex::new(0.0, -0.5 * w / root);
        let by_s = [z * ts, r * (rest * (1.0 - mu) * ts - g1) / s, r * (z * ts - rest * (1.0 - mu) * ts - g2) / s];
        // ds / d ln zeta = zeta w (-1 - i zeta / root); d R / d ln w = R, d R / d ln zeta = R zeta^2 / root^2
        let along = |ds: Complex<f64>, dr: f64| [by_s[0] * ds, by_s[1] * ds + r * g1 * dr, by_s[2] * ds + r * g2 * dr];
        let delay = r * ts * rest;
        HeldMode {
            z,
            c: [r * g1, r * g2],
            k: x[2],
            slopes: [
                along(s, 1.0),
                along(zeta * w * Complex::new(-1.0, -zeta / root), zeta * zeta / (root * root)),
                [Complex::new(0.0, 0.0), -delay, delay],
            ],
        }
    }

    /// Numerator (by powers of q^-1, after q^-L) and denominator of the mode.
    fn fraction(&self) -> ([f64; 3], [f64; 3]) {
        let ([c1, c2], z) = (self.c.map(|c| self.k * c), self.z);
        let numerator = [2.0 * c1.re, 2.0 * (c2.re - (c1 * z.conj()).re), -2.0 * (c2 * z.conj()).re];
        (numerator, [1.0, -2.0 * z.re, z.norm_sqr()])
    }
}

/// One record's errors, and what the derivatives of its free run need.
#[derive(Debug)]
pub(super) struct ModalRun {
    pub(super) e: Vec<f64>,
    /// The constant in the output.
    pub(super) offset: f64,
    /// The response to the past, C / A d.
    free: Vec<f64>,
    /// The input without its mean.
    u: Vec<f64>,
    past: Past,
}

impl ModalError<'_> {
    fn held(&self, x: &[f64]) -> Vec<HeldMode> {
        let mu = (x[3 * self.modes + 1] - self.whole as f64 + 1.0).clamp(0.0, 1.0);
        x[..3 * self.modes].chunks_exact(3).map(|x| HeldMode::new(x, mu, self.records[0].ts())).collect()
    }

    /// The unknowns with these poles, the best starting delay, and the best k and r, which are linear; and their cost.
    pub(super) fn with_best_gains(&self, poles: &[f64]) -> (Vec<f64>, f64) {
        let linear: Vec<usize> = (0..self.modes).map(|i| 3 * i + 2).chain([3 * self.modes]).collect();
        let with = |part: f64| {
            let mut x = [poles, &[self.whole as f64 - 1.0 + part]].concat();
            let (NormalEquations { gradient, hessian, .. }, d) = (self.normal(&x), self.dimension());
            let right = DVector::from_fn(linear.len(), |i, _| -gradient[linear[i]]);
            let left = DMatrix::from_fn(linear.len(), linear.len(), |i, j| hessian[linear[i] * d + linear[j]]);
            if let Some(root) = Cholesky::new(left) {
                linear.iter().zip(root.solve(&right).iter()).for_each(|(&k, value)| x[k] = *value);
            }
            let cost = self.cost(&x);
            (x, cost)
        };
        let all = PARTS.map(with).into_iter();
        all.min_by(|p, q| p.1.total_cmp(&q.1)).unwrap_or_else(|| with(0.5))
    }

    /// True if the unknowns describe damped modes of limited frequency.
    fn possible(&self, x: &[f64]) -> bool {
        let fastest = log(2.0 * TAU / self.records[0].ts());
        x.iter().all(|x| x.is_finite()) && x[..3 * self.modes].chunks_exact(3).all(|m| m[0] < fastest && m[1] < 0.0)
    }

    pub(super) fn run(&self, record: &Record, x: &[f64]) -> ModalRun {
        let (held, lag, n) = (self.held(x), self.whole, record.len());
        let (middle, u) = centred(record.u());
        let feed_through = x[3 * self.modes];
        let mut forced: Vec<f64> = shifted(&u, lag).map(|u| feed_through * u).collect();
        for mode in &held {
            let w = one_pole(mode.z, u.iter().map(|&u| Complex::new(u, 0.0)));
            for (t, y) in forced.iter_mut().enumerate() {
                *y += 2.0 * mode.k * (mode.c[0] * delayed(&w, t, lag) + mode.c[1] * delayed(&w, t, lag + 1)).re;
            }
        }
        let a: Vec<f64> = self.denominator(&held).iter().skip(1).map(|c| -c).collect();
        let past = Past::new(&a, 2 * self.modes + lag, n);
        let mut e: Vec<f64> = record.y().iter().zip(&forced).map(|(y, f)| y - f).collect();
        let level = past.remove(&mut e);
        let free = record.y().iter().zip(&e).zip(&forced).map(|((y, e), forced)| y - e - level - forced).collect();
        let gain = feed_through + held.iter().map(|mode| mode.k).sum::<f64>();
        ModalRun { e, offset: level - gain * middle, free, u, past }
    }

    /// The derivatives of the free run by each unknown, past and offset projected out.
    pub(super) fn jacobian(&self, run: &ModalRun, x: &[f64]) -> Vec<Vec<f64>> {
        let (lag, n, last) = (self.whole, run.u.len(), 3 * self.modes);
        let mut columns = vec![vec![0.0; n]; last + 2];
        for (i, mode) in self.held(x).iter().enumerate() {
            let w = one_pole(mode.z, run.u.iter().map(|&u| Complex::new(u, 0.0)));
            let dw = one_pole(mode.z, (0..n).map(|t| delayed(&w, t, 1)));
            // C / A d with C fixed: its derivative by z is q^-1 / (1 - z q^-1) times itself.
            let past = one_pole(mode.z, run.free.iter().map(|&y| Complex::new(y, 0.0)));
            let held = |w: &[Complex<f64>], t| mode.c[0] * delayed(w, t, lag) + mode.c[1] * delayed(w, t, lag + 1);
            let slope = |[dz, d1, d2]: [Complex<f64>; 3], t: usize| {
                let by_z = mode.k * held(&dw, t) + delayed(&past, t, 1);
                2.0 * (by_z * dz + mode.k * (d1 * delayed(&w, t, lag) + d2 * delayed(&w, t, lag + 1))).re
            };
            let [by_w, by_zeta, by_mu] = mode.slopes;
            columns[3 * i] = (0..n).map(|t| slope(by_w, t)).collect();
            columns[3 * i + 1] = (0..n).map(|t| slope(by_zeta, t)).collect();
            columns[3 * i + 2] = (0..n).map(|t| 2.0 * held(&w, t).re).collect();
            columns[last + 1].iter_mut().enumerate().for_each(|(t, sum)| *sum += slope(by_mu, t));
        }
        columns[last] = shifted(&run.u, lag).collect();
        // Outside its sample the delay is clamped: no derivative.
        if !(self.whole as f64 - 1.0..=self.whole as f64).contains(&x[last + 1]) {
            columns[last + 1].fill(0.0);
        }
        for column in &mut columns {
            run.past.remove(column);
        }
        columns
    }

    fn denominator(&self, held: &[HeldMode]) -> Vec<f64> {
        held.iter().fold(vec![1.0], |product, mode| multiply(&product, &mode.fraction().1))
    }

    /// The difference equation of the unknowns.
    pub(super) fn arx(&self, x: &[f64]) -> Result<Arx, Error> {
        let held = self.held(x);
        let a = self.denominator(&held);
        let mut b: Vec<f64> = a.iter().map(|a| x[3 * self.modes] * a).collect();
        for (i, mode) in held.iter().enumerate() {
            let others = held.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other.fraction().1);
            let term = others.fold(mode.fraction().0.to_vec(), |product, other| multiply(&product, &other));
            b.iter_mut().zip(term).for_each(|(b, term)| *b += term);
        }
        b.splice(0..0, std::iter::repeat_n(0.0, self.whole));
        Arx::new(self.records[0].ts(), a[1..].iter().map(|a| -a).collect(), b)
    }
}

impl SumOfSquares for ModalError<'_> {
    fn dimension(&self) -> usize {
        3 * self.modes + 2
    }

    fn cost(&self, x: &[f64]) -> f64 {
        if !self.possible(x) {
            return f64::INFINITY;
        }
        let squares = |(record, weight): (&Record, &f64)| {
            let e = self.run(record, x).e;
            weight * dot(&e, &e)
        };
        self.records.iter().zip(self.weights).map(squares).sum()
    }

    fn normal(&self, x: &[f64]) -> NormalEquations {
        let mut sums = NormalEquations::empty(self.dimension());
        if !self.possible(x) {
            return NormalEquations { cost: f64::INFINITY, ..sums };
        }
        for (record, &weight) in self.records.iter().zip(self.weights) {
            let run = self.run(record, x);
            let columns = self.jacobian(&run, x);
            let hessian = columns.iter().flat_map(|p| columns.iter().map(|q| dot(p, q))).collect();
            let gradient = columns.iter().map(|column| -dot(column, &run.e)).collect();
            sums.add(weight, &NormalEquations { cost: dot(&run.e, &run.e), gradient, hessian });
        }
        sums
    }
}

/// x / (1 - z q^-1), from rest.
fn one_pole(z: Complex<f64>, x: impl Iterator<Item = Complex<f64>>) -> Vec<Complex<f64>> {
    let mut y = Complex::new(0.0, 0.0);
    x.map(|x| {
        y = x + z * y;
        y
    })
    .collect()
}

/// x_{t-lag}, 0 before the record.
fn delayed(x: &[Complex<f64>], t: usize, lag: usize) -> Complex<f64> {
    t.checked_sub(lag).map_or(Complex::new(0.0, 0.0), |at| x[at])
}

/// The whole series delayed by `lag` samples.
fn shifted(x: &[f64], lag: usize) -> impl Iterator<Item = f64> {
    std::iter::repeat_n(0.0, lag).chain(x.iter().copied()).take(x.len())
}

/// The product of two polynomials.
fn multiply(p: &[f64], q: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; p.len() + q.len() - 1];
    for (i, p) in p.iter().enumerate() {
        q.iter().zip(&mut product[i..]).for_each(|(q, sum)| *sum += p * q);
    }
    product
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::linear::free_run::tests::assert_gradient;
    use piezoid_numerics::system::System;
    use piezoid_records::excitation::Prbs;
    use piezoid_testing::assert_close;

    const TS: f64 = 5e-4;

    /// The block of `modes` (frequency [Hz], damping, k), with feed-through `r` and a `delay` [s], at 5e-4 s.
    pub(in crate::linear) fn held(modes: &[(f64, f64, f64)], r: f64, delay: f64) -> Arx {
        let records = [Record::new(TS, vec![0.0], vec![0.0]).unwrap()];
        let whole = (delay / TS).floor() as isize + 1;
        let problem = ModalError { records: &records, weights: &[1.0], modes: modes.len(), whole: whole as usize };
        let each = modes.iter().flat_map(|(hz, zeta, k)| [(TAU * hz).ln(), zeta.ln(), *k]);
        problem.arx(&each.chain([r, delay / TS]).collect::<Vec<_>>()).unwrap()
    }

    /// Step response of one mode of k = 1.
    fn step_response(hz: f64, zeta: f64, t: f64) -> f64 {
        let (w, root) = (TAU * hz, (1.0 - zeta * zeta).sqrt());
        let (sin, cos) = (w * root * t).sin_cos();
        if t < 0.0 { 0.0 } else { 1.0 - (-zeta * w * t).exp() * (cos + zeta / root * sin) }
    }

    #[test]
    fn the_difference_equation_is_the_held_response_at_the_samples() {
        for delay in [-TS, -0.7 * TS, 0.0, 0.25 * TS, 2.6 * TS] {
            let arx = held(&[(166.3, 0.03, 27.0), (900.0, 0.2, 2.0)], 1.0, delay);
            let y = arx.simulate(&[1.0; 60]);
            for (t, y) in y.iter().enumerate() {
                let at = t as f64 * TS - delay;
                let feed_through = f64::from(u8::from(at > 1e-12));
                let exact = 27.0 * step_response(166.3, 0.03, at) + 2.0 * step_response(900.0, 0.2, at) + feed_through;
                assert_close(&[*y], &[exact], 0.0, 1e-10);
            }
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_cost() {
        let arx = held(&[(166.3, 0.03, 27.0), (700.0, 0.1, 2.0)], 1.0, 2e-4);
        let u = Prbs::default().samples(TS, 500).unwrap();
        let y = arx.simulate(&u);
        let record = [Record::new(TS, u[100..].to_vec(), y[100..].to_vec()).unwrap()];
        let problem = ModalError { records: &record, weights: &[0.5], modes: 2, whole: 1 };
        let x = [1050f64.ln(), 0.04f64.ln(), 25.0, 4300f64.ln(), 0.2f64.ln(), 3.0, 0.5, 0.6];
        assert_gradient(&problem, &x, 1e-5, 1e-3);
    }

    /// Two records of two modes, with feed-through 1, a delay of 0.3 samples and offsets 7 and -2; and their unknowns.
    fn offset_records() -> ([Record; 2], [f64; 8]) {
        let arx = held(&[(166.3, 0.03, 27.0), (700.0, 0.1, 2.0)], 1.0, 0.3 * TS);
        let u: Vec<f64> = Prbs::default().samples(TS, 500).unwrap().iter().map(|u| u + 3.0).collect();
        let record = |offset: f64, from: usize| {
            let y: Vec<f64> = arx.simulate(&u).iter().map(|y| y + offset).collect();
            Record::new(TS, u[from..].to_vec(), y[from..].to_vec()).unwrap()
        };
        let x = [(TAU * 166.3).ln(), 0.03f64.ln(), 27.0, (TAU * 700.0).ln(), 0.1f64.ln(), 2.0, 1.0, 0.3];
        ([record(7.0, 100), record(-2.0, 200)], x)
    }

    #[test]
    fn gains_delay_and_offsets_of_records_without_noise_are_found() {
        let (records, truth) = offset_records();
        let problem = ModalError { records: &records, weights: &[0.5, 2.0], modes: 2, whole: 1 };
        let mut poles = truth[..7].to_vec();
        [2, 5, 6].into_iter().for_each(|k| poles[k] = 0.0);
        let (x, cost) = problem.with_best_gains(&poles);
        assert_close(&x, &truth, 1e-9, 0.0);
        assert!(cost < 1e-12, "{cost}");
        let offsets = records.each_ref().map(|record| problem.run(record, &x).offset);
        assert_close(&offsets, &[7.0, -2.0], 1e-6, 0.0);
    }

    #[test]
    fn a_cost_is_the_weighted_sum_over_records() {
        let (records, mut x) = offset_records();
        x[0] += 0.05;
        let cost = |records, weights| {
            let problem = ModalError { records, weights, modes: 2, whole: 1 };
            assert_close(&[problem.normal(&x).cost], &[problem.cost(&x)], 1e-12, 0.0);
            problem.cost(&x)
        };
        let sum = 0.5 * cost(&records[..1], &[1.0]) + 2.0 * cost(&records[1..], &[1.0]);
        assert_close(&[cost(&records, &[0.5, 2.0])], &[sum], 1e-12, 0.0);
    }

    #[test]
    fn a_delay_outside_its_sample_is_that_of_its_end() {
        let (records, mut x) = offset_records();
        let problem = ModalError { records: &records, weights: &[0.5, 2.0], modes: 2, whole: 1 };
        let mut at = |delay: f64| {
            x[7] = delay;
            (problem.cost(&x), problem.normal(&x).gradient[7])
        };
        for (outside, end) in [(-0.4, 0.0), (1.4, 1.0)] {
            assert_eq!(at(outside), (at(end).0, 0.0));
            assert_ne!(at(end).1, 0.0);
        }
    }

    #[test]
    fn only_damped_modes_of_limited_frequency_are_possible() {
        let records = [Record::new(TS, vec![0.0], vec![0.0]).unwrap()];
        let problem = ModalError { records: &records, weights: &[1.0], modes: 1, whole: 1 };
        let fastest = 2.0 * TAU / TS;
        let at = |w: f64, zeta: f64, r: f64| problem.possible(&[w.ln(), zeta.ln(), 25.0, r, 0.6]);
        assert!(at(0.9 * fastest, 0.9, 1.0));
        assert_eq!([at(1.1 * fastest, 0.9, 1.0), at(1000.0, 1.1, 1.0), at(1000.0, 0.9, f64::NAN)], [false; 3]);
    }
}
