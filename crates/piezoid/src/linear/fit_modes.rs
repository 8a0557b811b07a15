//! A block fitted in the numbers of mechanics: modes, what follows at once, and a delay that need not be whole samples.
//!
//! ```text
//! G(s) = exp(-tau s) (r + sum_i k_i w_i^2 / (s^2 + 2 zeta_i w_i s + w_i^2))            input held over each sample
//! mode:  2 Re R (g1 q^-L + g2 q^-L-1) w,   w = u / (1 - z q^-1),   z = exp(s Ts),   R = k w / (2 i sqrt(1 - zeta^2))
//! tau = (L - 1 + mu) Ts:  g1 = (exp(s (1 - mu) Ts) - 1) / s,   g2 = (z - exp(s (1 - mu) Ts)) / s,   0 <= mu <= 1
//! ```
//! s is the pole of positive imaginary part. That is exact for a held input: Åström & Wittenmark 1997, Computer-Controlled
//! Systems, 2.3. The unknowns are ln w and ln zeta of each mode, k_i, r and tau; the output error is searched by
//! Levenberg-Marquardt with exact slopes, each record with a free past and offset, which are projected out as in
//! `free_run.rs`. What follows at once jumps where the delay passes whole samples, so the fit is made for each L and the
//! best is kept. An output that is logged after its input acted has a delay of -Ts.
//!
//! It begins at the modes of a block by output error. A mode above half the sampling rate is seen there as its image
//! below; what follows from it is not the same, so for all but the mode that carries most the two nearest frequencies of
//! that image are tried as well, and taken where they leave clearly less. A lag that is no mode, such as an amplifier's, is taken for delay.

use super::free_run::{Past, dot};
use super::output_error::{Refinement, checked, output_error};
use super::uncertainty::{Evidence, Uncertain, sandwich, spread};
use super::{Arx, Orders};
use crate::error::Error;
use crate::optimize::Minimum;
use crate::optimize::levenberg_marquardt::{self, Normal as Sums, SumOfSquares};
use crate::progress::{Progress, Stage, unwatched};
use crate::record::Record;
use nalgebra::{Cholesky, Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// One mode as far as it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// Natural frequency [Hz].
    pub hz: Uncertain,
    /// Damping ratio.
    pub damping: Uncertain,
    /// What it carries of the static displacement, 1 being all.
    pub share: Uncertain,
}

/// A block in the numbers of mechanics.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    /// Output for a constant input of 1 [output unit over input unit].
    pub gain: Uncertain,
    /// The modes, by rising frequency.
    pub modes: Vec<Mode>,
    /// The share that follows the input at once.
    pub residual: Uncertain,
    /// Input delay [s]; negative where an output was logged after its input acted.
    pub delay: Uncertain,
    /// The same block as a difference equation.
    pub arx: Arx,
    /// For each record, the constant in its output [output unit].
    pub offsets: Vec<f64>,
    /// For each record, the rms of what the free run leaves [output unit].
    pub rms: Vec<f64>,
    /// The search: ln w, ln zeta and k of each mode, r, and the delay [samples].
    pub minimum: Minimum,
}

/// Fits `n` modes to `records`, with a delay from -1 to `longest` samples.
///
/// ```
/// use piezoid::{Record, linear::{Refinement, fit_modes}, plant::{Plant, find}, excitation::Prbs};
/// let plant = Plant::new(&(find("paper")?.spec)(), 5e-4)?;
/// let u = Prbs::default().samples(5e-4, 2047)?;
/// let record = Record::new(5e-4, u.clone(), plant.run(&u).y.iter().map(|y| 1e6 * y).collect())?;
/// let found = fit_modes(&[record], 1, 1.0, &Refinement::default(), &mut piezoid::progress::unwatched)?;
/// assert!((found.modes[0].hz.value - 146.7).abs() < 0.1);
/// assert!((found.delay.value + 5e-4).abs() < 1e-5); // it logs after the input acted
/// # Ok::<(), piezoid::Error>(())
/// ```
///
/// # Errors
/// What [`output_error`] refuses of order 2 n; [`Error::Unidentifiable`] when it finds fewer than `n` modes;
/// [`Error::Cancelled`].
pub fn fit_modes(
    records: &[Record],
    n: usize,
    longest: f64,
    how: &Refinement,
    progress: &mut Progress,
) -> Result<Modes, Error> {
    if !(1..=64).contains(&n) {
        return Err(Error::parameter("modes", n, "must be from 1 to 64"));
    }
    if !(-1.0..=500.0).contains(&longest) {
        return Err(Error::parameter("longest delay", longest, "must be from -1 to 500 samples"));
    }
    let most = (longest.ceil() as usize).max(1);
    let weights = checked(records, Orders { delay: most, ..Orders::of(2 * n) }, how)?;
    let starts = starts(records, n, how)?;
    let mut best: Option<(ModalError, Minimum)> = None;
    for (i, start) in starts.iter().enumerate() {
        let stage = Stage { what: "modes", done: i, total: starts.len() };
        if progress(stage).is_break() {
            return Err(Error::Cancelled { what: "the fit of modes".into(), done: i, total: starts.len() });
        }
        // Images explain a mode nearly as well as it does itself.
        let clearly = if i == 0 { 1.0 } else { 0.9 };
        let bar = best.as_ref().map_or(f64::INFINITY, |(_, b)| clearly * b.cost);
        let problem = |whole| ModalError { records, weights: &weights, modes: n, whole };
        let mut laid: Vec<_> = (0..=most).map(|whole| (whole, problem(whole).laid_out(start))).collect();
        laid.sort_by(|(_, p), (_, q)| p.1.total_cmp(&q.1));
        for (whole, (x, _)) in laid.into_iter().take(TRIED) {
            let problem = problem(whole);
            let minimum = levenberg_marquardt::minimise(&problem, &x, &ROUGH, &mut unwatched)?;
            if minimum.cost < bar && best.as_ref().is_none_or(|(_, b)| minimum.cost < b.cost) {
                best = Some((problem, minimum));
            }
        }
    }
    let Some((problem, rough)) = best else {
        return Err(Error::Unidentifiable { what: "a mode".into(), because: "no delay was allowed".into() });
    };
    problem.told(levenberg_marquardt::minimise(&problem, &rough.x, &how.search, &mut unwatched)?)
}

/// Steps and tolerance that tell starts apart.
const ROUGH: levenberg_marquardt::Settings =
    levenberg_marquardt::Settings { iterations: 100, tolerance: 1e-6, damping: 1e-3 };

/// Whole delays that are searched, of those that begin best.
const TRIED: usize = 2;

/// Delays within a sample that a search may begin at.
const PARTS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// ln w, ln zeta and k = 0 of each mode, and r = 0: of the modes that carry most in a block by output error, and with each
/// but the first of them at the other frequencies that look the same to the samples.
fn starts(records: &[Record], n: usize, how: &Refinement) -> Result<Vec<Vec<f64>>, Error> {
    let blocks = [0, 1].map(|delay| output_error(records, Orders { delay, ..Orders::of(2 * n) }, how, &mut unwatched));
    let mut blocks: Vec<_> = blocks.into_iter().collect::<Result<_, _>>()?;
    blocks.sort_by(|p, q| p.minimum.cost.total_cmp(&q.minimum.cost));
    let mut found: Vec<(f64, f64)> = Vec::new();
    for block in &blocks {
        let mut modes = block.arx.reading().poles;
        modes.retain(|p| p.pole.z.im > 0.0 && p.pole.damping < 0.9);
        modes.sort_by(|p, q| q.share.abs().total_cmp(&p.share.abs()));
        if modes.len() >= n {
            found = modes[..n].iter().map(|p| (p.pole.hz, p.pole.damping)).collect();
            break;
        }
    }
    if found.is_empty() {
        let because = format!(
            "a block of order {} has fewer modes than that: its other poles do not oscillate; ask for fewer modes, or excite \
             higher frequencies",
            2 * n
        );
        return Err(Error::Unidentifiable { what: format!("{n} modes"), because });
    }
    let vector = |modes: &[(f64, f64)]| {
        let each = modes.iter().flat_map(|(hz, damping)| [(TAU * hz).ln(), damping.clamp(1e-4, 0.9).ln(), 0.0]);
        each.chain([0.0]).collect::<Vec<f64>>()
    };
    let mut starts = vec![vector(&found)];
    let rate = 1.0 / records[0].ts();
    for i in 1..n {
        let (hz, damping) = found[i];
        let rings = hz * (1.0 - damping * damping).sqrt();
        for image in [rate - rings, rate + rings] {
            // The same decay a sample.
            let there = image.hypot(hz * damping);
            let mut others = found.clone();
            others[i] = (there, hz * damping / there);
            starts.push(vector(&others));
        }
    }
    Ok(starts)
}

/// The weighted squared free-run errors as a function of the numbers of mechanics, for one L.
struct ModalError<'a> {
    records: &'a [Record],
    weights: &'a [f64],
    modes: usize,
    /// L: the delay lies between L - 1 and L samples.
    whole: usize,
}

/// One mode's numbers and their derivatives by ln w, ln zeta and mu.
struct Held {
    z: Complex<f64>,
    /// R g1 and R g2 for k = 1.
    c: [Complex<f64>; 2],
    k: f64,
    /// Derivatives of z, R g1 and R g2.
    slopes: [[Complex<f64>; 3]; 3],
}

impl Held {
    /// The mode of the unknowns `x` = [ln w, ln zeta, k], `mu` samples late.
    fn new(x: &[f64], mu: f64, ts: f64) -> Self {
        let (w, zeta) = (x[0].exp(), x[1].exp());
        let root = (1.0 - zeta * zeta).sqrt();
        let s = w * Complex::new(-zeta, root);
        let (z, rest) = ((s * ts).exp(), (s * (1.0 - mu) * ts).exp());
        let (g1, g2) = ((rest - 1.0) / s, (z - rest) / s);
        let r = Complex::new(0.0, -0.5 * w / root);
        let by_s = [z * ts, r * (rest * (1.0 - mu) * ts - g1) / s, r * (z * ts - rest * (1.0 - mu) * ts - g2) / s];
        // ds / d ln zeta = zeta w (-1 - i zeta / root); d R / d ln w = R, d R / d ln zeta = R zeta^2 / root^2
        let along = |ds: Complex<f64>, dr: f64| [by_s[0] * ds, by_s[1] * ds + r * g1 * dr, by_s[2] * ds + r * g2 * dr];
        let late = r * ts * rest;
        Held {
            z,
            c: [r * g1, r * g2],
            k: x[2],
            slopes: [
                along(s, 1.0),
                along(zeta * w * Complex::new(-1.0, -zeta / root), zeta * zeta / (root * root)),
                [Complex::new(0.0, 0.0), -late, late],
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

/// One record's errors, and the slopes of its free run.
struct ModalRun {
    e: Vec<f64>,
    offset: f64,
    model: Vec<f64>,
    forced: Vec<f64>,
    past: Past,
}

impl ModalError<'_> {
    fn held(&self, x: &[f64]) -> Vec<Held> {
        let mu = (x[3 * self.modes + 1] - self.whole as f64 + 1.0).clamp(0.0, 1.0);
        x[..3 * self.modes].chunks_exact(3).map(|x| Held::new(x, mu, self.records[0].ts())).collect()
    }

    /// The unknowns with these poles, the part of a sample that suits them best, and the k and r that do, which are linear;
    /// and their cost.
    fn laid_out(&self, poles: &[f64]) -> (Vec<f64>, f64) {
        let linear: Vec<usize> = (0..self.modes).map(|i| 3 * i + 2).chain([3 * self.modes]).collect();
        let with = |part: f64| {
            let mut x = [poles, &[self.whole as f64 - 1.0 + part]].concat();
            let (Sums { gradient, hessian, .. }, d) = (self.normal(&x), self.dimension());
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

    /// Whether the unknowns are those of modes: damped, and not so fast that they are numbers only.
    fn possible(&self, x: &[f64]) -> bool {
        let fastest = (2.0 * TAU / self.records[0].ts()).ln();
        x.iter().all(|x| x.is_finite()) && x[..3 * self.modes].chunks_exact(3).all(|m| m[0] < fastest && m[1] < 0.0)
    }

    fn run(&self, record: &Record, x: &[f64]) -> ModalRun {
        let (held, lag, n) = (self.held(x), self.whole, record.len());
        let mut forced: Vec<f64> = shifted(record.u(), lag).map(|u| x[3 * self.modes] * u).collect();
        for mode in &held {
            let w = one_pole(mode.z, record.u().iter().map(|&u| Complex::new(u, 0.0)));
            for (t, y) in forced.iter_mut().enumerate() {
                *y += 2.0 * mode.k * (mode.c[0] * late(&w, t, lag) + mode.c[1] * late(&w, t, lag + 1)).re;
            }
        }
        let a: Vec<f64> = self.denominator(&held).iter().skip(1).map(|c| -c).collect();
        let past = Past::new(&a, 2 * self.modes + lag, n);
        let mut e: Vec<f64> = record.y().iter().zip(&forced).map(|(y, f)| y - f).collect();
        let offset = past.remove(&mut e);
        let model = record.y().iter().zip(&e).map(|(y, e)| y - e - offset).collect();
        ModalRun { e, offset, model, forced, past }
    }

    /// The slopes of the free run by each unknown, past and offset projected out.
    fn jacobian(&self, record: &Record, run: &ModalRun, x: &[f64]) -> Vec<Vec<f64>> {
        let (lag, n, last) = (self.whole, record.len(), 3 * self.modes);
        let free: Vec<f64> = run.model.iter().zip(&run.forced).map(|(y, f)| y - f).collect();
        let mut columns = vec![vec![0.0; n]; last + 2];
        for (i, mode) in self.held(x).iter().enumerate() {
            let w = one_pole(mode.z, record.u().iter().map(|&u| Complex::new(u, 0.0)));
            let dw = one_pole(mode.z, (0..n).map(|t| late(&w, t, 1)));
            // C / A d with C fixed: its slope by z is q^-1 / (1 - z q^-1) of itself.
            let past = one_pole(mode.z, free.iter().map(|&y| Complex::new(y, 0.0)));
            let held = |w: &[Complex<f64>], t| mode.c[0] * late(w, t, lag) + mode.c[1] * late(w, t, lag + 1);
            let slope = |[dz, d1, d2]: [Complex<f64>; 3], t: usize| {
                let by_z = mode.k * held(&dw, t) + late(&past, t, 1);
                2.0 * (by_z * dz + mode.k * (d1 * late(&w, t, lag) + d2 * late(&w, t, lag + 1))).re
            };
            let [by_w, by_zeta, by_mu] = mode.slopes;
            columns[3 * i] = (0..n).map(|t| slope(by_w, t)).collect();
            columns[3 * i + 1] = (0..n).map(|t| slope(by_zeta, t)).collect();
            columns[3 * i + 2] = (0..n).map(|t| 2.0 * held(&w, t).re).collect();
            columns[last + 1].iter_mut().enumerate().for_each(|(t, sum)| *sum += slope(by_mu, t));
        }
        columns[last] = shifted(record.u(), lag).collect();
        // Beyond whole samples the delay is held, and has no slope.
        if !(self.whole as f64 - 1.0..=self.whole as f64).contains(&x[last + 1]) {
            columns[last + 1].fill(0.0);
        }
        for column in &mut columns {
            run.past.remove(column);
        }
        columns
    }

    fn denominator(&self, held: &[Held]) -> Vec<f64> {
        held.iter().fold(vec![1.0], |product, mode| multiply(&product, &mode.fraction().1))
    }

    /// The difference equation of the unknowns.
    fn arx(&self, x: &[f64]) -> Result<Arx, Error> {
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

    /// The minimum in the numbers of mechanics, with their uncertainty.
    fn told(&self, mut minimum: Minimum) -> Result<Modes, Error> {
        let (m, ts) = (self.modes, self.records[0].ts());
        let x = &mut minimum.x;
        x[3 * m + 1] = x[3 * m + 1].clamp(self.whole as f64 - 1.0, self.whole as f64);
        let x = &minimum.x;
        let runs: Vec<ModalRun> = self.records.iter().map(|r| self.run(r, x)).collect();
        let samples: usize = self.records.iter().map(Record::len).sum();
        let fitted = self.dimension() + self.records.len() * (2 * m + self.whole + 1);
        let evidence = self.records.iter().zip(&runs).zip(self.weights).map(|((record, run), &weight)| Evidence {
            weight,
            e: run.e.clone(),
            jacobian: self.jacobian(record, run, x),
        });
        let covariance = sandwich(evidence, x.len(), samples as f64 / (samples - fitted) as f64);
        let number = |value: f64, slopes: &[(usize, f64)]| {
            let mut dense = vec![0.0; x.len()];
            slopes.iter().for_each(|&(k, slope)| dense[k] += slope);
            spread(value, &dense, &covariance, x.len())
        };
        let carriers: Vec<usize> = (0..m).map(|i| 3 * i + 2).chain([3 * m]).collect();
        let gain: f64 = carriers.iter().map(|&k| x[k]).sum();
        let share = |k: usize| {
            let slopes = carriers.iter().map(|&j| (j, (if j == k { 1.0 } else { 0.0 } - x[k] / gain) / gain));
            number(x[k] / gain, &slopes.collect::<Vec<_>>())
        };
        let mode = |i: usize| {
            let (hz, damping) = (x[3 * i].exp() / TAU, x[3 * i + 1].exp());
            Mode {
                hz: number(hz, &[(3 * i, hz)]),
                damping: number(damping, &[(3 * i + 1, damping)]),
                share: share(3 * i + 2),
            }
        };
        let mut modes: Vec<Mode> = (0..m).map(mode).collect();
        modes.sort_by(|p, q| p.hz.value.total_cmp(&q.hz.value));
        Ok(Modes {
            gain: number(gain, &carriers.iter().map(|&k| (k, 1.0)).collect::<Vec<_>>()),
            modes,
            residual: share(3 * m),
            delay: number(ts * x[3 * m + 1], &[(3 * m + 1, ts)]),
            arx: self.arx(x)?,
            offsets: runs.iter().map(|run| run.offset).collect(),
            rms: runs.iter().map(|run| (dot(&run.e, &run.e) / run.e.len() as f64).sqrt()).collect(),
            minimum,
        })
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

    fn normal(&self, x: &[f64]) -> Sums {
        let mut sums = Sums::empty(self.dimension());
        if !self.possible(x) {
            return Sums { cost: f64::INFINITY, ..sums };
        }
        for (record, &weight) in self.records.iter().zip(self.weights) {
            let run = self.run(record, x);
            let columns = self.jacobian(record, &run, x);
            let hessian = columns.iter().flat_map(|p| columns.iter().map(|q| dot(p, q))).collect();
            let gradient = columns.iter().map(|column| -dot(column, &run.e)).collect();
            sums.add(weight, &Sums { cost: dot(&run.e, &run.e), gradient, hessian });
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
fn late(x: &[Complex<f64>], t: usize, lag: usize) -> Complex<f64> {
    t.checked_sub(lag).map_or(Complex::new(0.0, 0.0), |at| x[at])
}

/// The whole series `lag` samples late.
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
    use crate::excitation::Prbs;
    use crate::plant::{Plant, find};
    use crate::system::System;
    use crate::testing::assert_close;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    const TS: f64 = 5e-4;

    /// The block of `modes` (frequency [Hz], damping, k), with `r` at once and a `delay` [s], at 5e-4 s.
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
                let once = f64::from(u8::from(at > 1e-12));
                let exact = 27.0 * step_response(166.3, 0.03, at) + 2.0 * step_response(900.0, 0.2, at) + once;
                assert_close(&[*y], &[exact], 0.0, 1e-10);
            }
        }
    }

    #[test]
    fn slopes_are_those_of_the_cost() {
        let arx = held(&[(166.3, 0.03, 27.0), (700.0, 0.1, 2.0)], 1.0, 2e-4);
        let u = Prbs::default().samples(TS, 500).unwrap();
        let y = arx.simulate(&u);
        let record = [Record::new(TS, u[100..].to_vec(), y[100..].to_vec()).unwrap()];
        let problem = ModalError { records: &record, weights: &[0.5], modes: 2, whole: 1 };
        let x = [1050f64.ln(), 0.04f64.ln(), 25.0, 4300f64.ln(), 0.2f64.ln(), 3.0, 0.5, 0.6];
        let normal = problem.normal(&x);
        for k in 0..8 {
            let at = |h: f64| {
                let mut moved = x;
                moved[k] += h;
                problem.cost(&moved)
            };
            let by_differences = (at(1e-6) - at(-1e-6)) / 2e-6;
            assert_close(&[2.0 * normal.gradient[k]], &[by_differences], 1e-5, 1e-3);
        }
    }

    #[test]
    fn modes_without_noise_are_found_to_rounding_from_any_past() {
        let arx = held(&[(166.3, 0.03, 27.0), (700.0, 0.1, 2.0)], 1.0, 2.3e-4);
        let u = Prbs::default().samples(TS, 1500).unwrap();
        let y = arx.simulate(&u).iter().map(|y| y + 5.0).collect::<Vec<_>>();
        let record = Record::new(TS, u[200..].to_vec(), y[200..].to_vec()).unwrap();
        let found = fit_modes(&[record], 2, 3.0, &Refinement::default(), &mut unwatched).unwrap();
        let [first, second] = [found.modes[0], found.modes[1]];
        assert_close(&[first.hz.value, first.damping.value, first.share.value], &[166.3, 0.03, 0.9], 1e-6, 0.0);
        assert_close(&[second.hz.value, second.damping.value], &[700.0, 0.1], 1e-6, 0.0);
        assert_close(&[found.residual.value, found.delay.value], &[1.0 / 30.0, 2.3e-4], 1e-5, 0.0);
        assert_close(&[found.gain.value, found.offsets[0]], &[30.0, 5.0], 1e-6, 0.0);
        assert_close(found.arx.a(), arx.a(), 1e-6, 0.0);
    }

    #[test]
    fn the_truth_lies_within_its_uncertainty() {
        let truth = held(&[(166.3, 0.03, 27.0), (700.0, 0.1, 2.0)], 1.0, 2.3e-4);
        let u = Prbs::default().samples(TS, 1500).unwrap();
        let mut outside = [0; 8];
        for seed in 0..40 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let noise = Normal::new(0.0, 1.0).unwrap();
            let y = truth.simulate(&u).iter().map(|y| y + noise.sample(&mut random)).collect();
            let record = Record::new(TS, u.clone(), y).unwrap();
            let found = fit_modes(&[record], 2, 1.0, &Refinement::default(), &mut unwatched).unwrap();
            let [first, second] = [found.modes[0], found.modes[1]];
            let pairs = [
                (first.hz, 166.3),
                (first.damping, 0.03),
                (first.share, 0.9),
                (second.hz, 700.0),
                (second.damping, 0.1),
                (found.residual, 1.0 / 30.0),
                (found.delay, 2.3e-4),
                (found.gain, 30.0),
            ];
            for (outside, (number, truth)) in outside.iter_mut().zip(pairs) {
                *outside += usize::from((number.value - truth).abs() > 2.0 * number.error);
            }
        }
        // Two of 40 are to be expected.
        assert!(outside.iter().all(|&n| n <= 6) && outside.iter().sum::<usize>() >= 3, "{outside:?} of 40");
    }

    #[test]
    fn the_pl140_is_read_from_its_noisy_record() {
        let u = Prbs::default().samples(TS, 3 * 2047).unwrap();
        let plant = Plant::new(&(find("pl140").unwrap().spec)(), TS).unwrap().with_seed(1);
        let y = plant.run(&u).y.iter().map(|y| 1e6 * y).collect();
        let record = [Record::new(TS, u, y).unwrap()];
        let found = fit_modes(&record, 2, 2.0, &Refinement::default(), &mut unwatched).unwrap();
        let [first, second] = [found.modes[0], found.modes[1]];
        assert_close(&[first.hz.value, first.damping.value], &[166.3, 0.03], 5e-4, 0.0);
        // Creep adds to the gain and the amplifier's lag takes from the first mode: 1 % together.
        assert_close(&[first.share.value], &[0.891], 0.0, 0.01);
        // The second mode lies above half the sampling rate, and is not taken for its image at 958 Hz.
        assert_close(&[second.hz.value], &[1042.0], 3e-3, 0.0);
        // The lag of 0.1 ms is a delay to modes this slow.
        assert_close(&[found.delay.value], &[1e-4], 0.02, 0.0);
    }

    #[test]
    fn more_modes_than_there_are_is_said() {
        let z = (-TS / 0.02f64).exp();
        let lag = Arx::new(TS, vec![z], vec![0.0, 1.0 - z]).unwrap();
        let u = Prbs::default().samples(TS, 1500).unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let noise = Normal::new(0.0, 1e-3).unwrap();
        let y = lag.simulate(&u).iter().map(|y| y + noise.sample(&mut random)).collect();
        let record = [Record::new(TS, u, y).unwrap()];
        let message = |n| fit_modes(&record, n, 1.0, &Refinement::default(), &mut unwatched).unwrap_err().to_string();
        assert!(message(1).contains("do not oscillate"), "{}", message(1));
        assert!(message(0).starts_with("modes = 0"));
    }
}
