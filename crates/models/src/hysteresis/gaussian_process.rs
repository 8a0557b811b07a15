//! A sparse Gaussian process over the input and some plays: a smooth correction of Prandtl-Ishlinskii.
//!
//! ```text
//! z = w_0 u + sum_k w_k p_k + half sum_m a_m (k(x, x_m) - k(rest, x_m))         w_k >= 0
//! x = (v(u), v(q_1), ..., v(q_F)),    v(p) = (p - middle) / half,    p_k and q_f plays of the thresholds r_k and s_f
//! k(x, y) = exp(-|x - y|^2 / 2), each difference over its length: `length_input` of u, `length_plays` of each q_f
//! ```
//! `middle` and `half` describe the input range, and the lengths are in `half`; at rest u and all plays are 0.
//! The process is that of the inducing points x_m (subset of regressors). Its mean is linear in a, and the penalty a' K
//! a is its prior, K_mn = k(x_m, x_n): the fit of the weights is Gaussian process regression, whose noise follows from
//! the held-out errors. The points are states of nested loops over the range, each as far as possible from those before
//! it; no random numbers.
//!
//! The file alone gives the standard deviation of z that the points leave, [`Hysteresis::deviation`]:
//! ```text
//! var z = s^2 (1 - k' K^-1 k),   s^2 = half^2 a' K a / M
//! ```
//! It is near zero at the inducing points, and s far from them. The uncertainty of a, which the noise of the records
//! leaves, is not in it.
//!
//! References: C. E. Rasmussen & C. K. I. Williams, "Gaussian Processes for Machine Learning", MIT Press (2006),
//! section 8.3; J. Quinonero-Candela & C. E. Rasmussen, J. Mach. Learn. Res. 6, 1939 (2005). It does not do: rate.
//!
//! Inverse: Newton's method on the step. Where z decreases, one of several inputs is found. Far outside the range the
//! correction is constant, and z is that of the plays.

use super::basis::{BasisDesign, ShapeParameter, counted_within, curvature};
use super::law::{Input, Law, Weighted, require};
use super::real::Real;
use super::thresholds;
use super::{Class, Operator};
use crate::elementary;
use crate::program::Block;
use piezoid_numerics::error::{Error, finite};
use serde::{Deserialize, Serialize};

/// Weights: w_0, w_1, ... of input and plays, then a_1, a_2, ... of the points.
///
/// State: the plays p_k, then the plays q_f.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct GaussianProcess {
    /// r_1 < r_2 < ... [input unit]
    thresholds: Vec<f64>,
    /// s_1 < s_2 < ... [input unit]
    memory: Vec<f64>,
    /// x_1, x_2, ..., each v(u), v(q_1), ...
    points: Vec<Vec<f64>>,
    length_input: f64,
    length_plays: f64,
}

/// Number of the inducing points and its maximum, of the plays that they see, and thresholds of these over half the
/// range.
const POINTS: usize = 40;
const MAX_POINTS: usize = 400;
const MAX_MEMORY: usize = 16;
const MEMORY: [f64; 4] = [0.1, 0.25, 0.5, 0.75];

/// Bounds of the lengths [halves of the range].
const LENGTH: (f64, f64) = (0.2, 5.0);

/// Turns of the nested loops, and samples from one to the next.
const TURNS: usize = 60;
const PIECES: usize = 20;

/// Added to the diagonal of K: less is rounding.
const NUGGET: f64 = 1e-9;

pub(super) static OPERATOR: Operator = Operator {
    name: "gaussian-process",
    aliases: &["GP"],
    summary: "a sparse Gaussian process over the input and some plays, which corrects Prandtl-Ishlinskii, with a \
              standard deviation",
    reference: "Rasmussen & Williams 2006, section 8.3; Quinonero-Candela & Rasmussen 2005, J. Mach. Learn. Res. 6",
    minor_loops: true,
    needs_minor_loops: true,
    rate_independent: true,
    wipes_out: true,
    class: Class::Learned,
    load: Weighted::<GaussianProcess>::load,
    basis: |design| Weighted::basis(design.ts, design.range, GaussianProcess::even(design)),
    example: |ts| {
        let design = BasisDesign { ts, range: (-30.0, 30.0), elements: None, frequencies: Vec::new() };
        let mut law = GaussianProcess { thresholds: thresholds::example(), ..GaussianProcess::even(&design) };
        law.points.truncate(10);
        let of_points = (0..10).map(|m| 0.06 * libm::sin(1.9 * f64::from(m)));
        Weighted::example(ts, law, thresholds::example_weights(0.7).into_iter().chain(of_points).collect())
    },
};

impl GaussianProcess {
    /// Equidistant thresholds, and the points that are farthest from each other on nested loops.
    fn even(design: &BasisDesign) -> Self {
        let memory: Vec<f64> = MEMORY.iter().map(|share| share * design.half()).collect();
        let states = states(design.range, &memory);
        let thresholds = thresholds::even(design);
        GaussianProcess { thresholds, memory, points: spread(&states), length_input: 1.0, length_plays: 1.0 }
    }

    /// Number of the weights of input and plays.
    fn plays(&self) -> usize {
        1 + self.thresholds.len()
    }

    fn lengths(&self) -> [(&'static str, f64); 2] {
        [("length_input", self.length_input), ("length_plays", self.length_plays)]
    }

    /// k between two states.
    fn kernel(&self, x: &[f64], y: &[f64]) -> f64 {
        let away = |(f, (x, y)): (usize, (&f64, &f64))| {
            let off = (x - y) / if f == 0 { self.length_input } else { self.length_plays };
            off * off
        };
        elementary::exp(-0.5 * x.iter().zip(y).enumerate().map(away).sum::<f64>())
    }

    /// The lower Cholesky factor of K, row by row.
    fn factor(&self) -> Vec<Vec<f64>> {
        let mut factor: Vec<Vec<f64>> = Vec::new();
        for (m, x) in self.points.iter().enumerate() {
            let row = self.points[..m].iter().map(|y| self.kernel(x, y)).collect();
            let row = solved(&factor, row);
            let left = 1.0 + NUGGET - row.iter().map(|l| l * l).sum::<f64>();
            factor.push([&row[..], &[left.max(NUGGET).sqrt()]].concat());
        }
        factor
    }
}

/// L^-1 of `right`.
fn solved(factor: &[Vec<f64>], mut right: Vec<f64>) -> Vec<f64> {
    for (i, row) in factor.iter().enumerate().take(right.len()) {
        let known: f64 = row[..i].iter().zip(&right).map(|(l, x)| l * x).sum();
        right[i] = (right[i] - known) / row[i];
    }
    right
}

/// The states x along nested loops over the range, from rest.
fn states((low, high): (f64, f64), memory: &[f64]) -> Vec<Vec<f64>> {
    let (half, middle) = (0.5 * (high - low), 0.5 * (low + high));
    // Spread evenly, the sequence of van der Corput.
    let share = |k: usize| (0..6).map(|bit| ((k >> bit) & 1) as f64 / (2 << bit) as f64).sum::<f64>();
    let turns = [0.0, high, low].into_iter().chain((1..TURNS).map(|k| low + (high - low) * share(k)));
    let (turns, mut q) = (turns.collect::<Vec<_>>(), vec![0.0f64; memory.len()]);
    let mut states = Vec::new();
    for w in turns.windows(2) {
        for piece in 1..=PIECES {
            let u = w[0] + (w[1] - w[0]) * piece as f64 / PIECES as f64;
            q.iter_mut().zip(memory).for_each(|(q, s)| *q = Real::clamp(*q, u - s, u + s));
            states.push([u].iter().chain(&q).map(|p| (p - middle) / half).collect());
        }
    }
    states
}

/// States, each the farthest from those before it.
fn spread(states: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let distance = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
    let mut points = vec![states[0].clone()];
    let mut near: Vec<f64> = states.iter().map(|x| distance(x, &states[0])).collect();
    while points.len() < POINTS {
        let farthest = (0..near.len()).fold(0, |best, k| if near[k] > near[best] { k } else { best });
        let point = states[farthest].clone();
        near.iter_mut().zip(states).for_each(|(near, x)| *near = near.min(distance(x, &point)));
        points.push(point);
    }
    points
}

impl Law for GaussianProcess {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        thresholds::check(&self.thresholds)?;
        thresholds::check_named("memory", &self.memory)?;
        counted_within("memory", self.memory.len(), 1, MAX_MEMORY)?;
        counted_within("points", self.points.len(), 1, MAX_POINTS)?;
        for point in &self.points {
            finite("points", point)?;
            counted_within("points", point.len(), 1 + self.memory.len(), 1 + self.memory.len())?;
        }
        let (low, high) = LENGTH;
        let rule = format!("must be from {low} to {high} halves of the range");
        self.lengths()
            .into_iter()
            .try_for_each(|(name, value)| require((low..=high).contains(&value), name, value, &rule))
    }

    fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    fn responses(&self) -> usize {
        self.plays() + self.points.len()
    }

    fn order(&self) -> usize {
        self.thresholds.len() + self.memory.len()
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let (half, middle, n) = (R::from(input.half()), R::from(input.middle()), self.plays());
        let (plays, memory) = x.split_at_mut(n - 1);
        phi(0, input.u);
        for (k, (p, &r)) in plays.iter_mut().zip(&self.thresholds).enumerate() {
            *p = p.clamp(input.u - r.into(), input.u + r.into());
            phi(k + 1, *p);
        }
        let v = |p: R| (p - middle) / half;
        for (q, &s) in memory.iter_mut().zip(&self.memory) {
            *q = q.clamp(input.u - s.into(), input.u + s.into());
        }
        let (now, rest) = (v(input.u), v(0.0.into()));
        for (m, point) in self.points.iter().enumerate() {
            let off = |v: R, f: usize| (v - point[f].into()) / shape[usize::from(f > 0)];
            let first = off(now, 0);
            let (mut away, mut at_rest) = (first * first, off(rest, 0) * off(rest, 0));
            for (f, &q) in memory.iter().enumerate() {
                let (here, there) = (off(v(q), f + 1), off(rest, f + 1));
                away = away + here * here;
                at_rest = at_rest + there * there;
            }
            let k = |away: R| (R::from(-0.5) * away).exp();
            phi(n + m, half * (k(away) - k(at_rest)));
        }
    }

    fn block(&self, block: Block, input: Input) -> Block {
        let rest = vec![(0.0 - input.middle()) / input.half(); 1 + self.memory.len()];
        let resting: Vec<f64> = self.points.iter().map(|point| self.kernel(&rest, point)).collect();
        let (n, dimensions) = (self.plays(), 1 + self.memory.len());
        let block = block.numbers("play", vec![0.0; n - 1]).numbers("memory", vec![0.0; self.memory.len()]);
        let block = block.table("r", &self.thresholds).table("s", &self.memory).count("n", n);
        let block = block.constant("half", input.half()).constant("middle", input.middle());
        let block = block.table("points", &self.points.concat()).table("resting", &resting);
        block.count("dimensions", dimensions).count("inducing", self.points.len()).text(STEP)
    }

    /// The weights of the points may have either sign.
    fn non_negative(&self, k: usize) -> bool {
        k < self.plays()
    }

    /// Second differences of the weights of the plays, and the prior of the process, a' K a.
    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        let (n, factor) = (self.plays(), self.factor());
        let column = |i: usize| (i..factor.len()).map(|m| (n + m, factor[m][i])).filter(|(_, l)| *l != 0.0).collect();
        curvature(1, n).into_iter().chain((0..factor.len()).map(column)).collect()
    }

    fn shape(&self, _: f64, _: f64) -> Vec<ShapeParameter> {
        let (low, high) = LENGTH;
        self.lengths().map(|(name, value)| ShapeParameter { name, value, low, high }).into()
    }

    fn deviation(&self, weights: &[f64], x: &[f64], last: Input) -> Option<f64> {
        let v = |p: &f64| (p - last.middle()) / last.half();
        let state: Vec<f64> = [last.u].iter().chain(&x[self.thresholds.len()..]).map(v).collect();
        let factor = self.factor();
        let a = &weights[self.plays()..];
        // a' K a = |L' a|^2
        let of_column = |i: usize| (i..a.len()).map(|m| factor[m][i] * a[m]).sum::<f64>();
        let energy: f64 = (0..a.len()).map(|i| of_column(i).powi(2)).sum();
        let known = solved(&factor, self.points.iter().map(|point| self.kernel(&state, point)).collect());
        let left = 1.0 - known.iter().map(|k| k * k).sum::<f64>();
        Some(last.half() * (energy / a.len() as f64 * left.max(0.0)).sqrt())
    }
}

/// [`Law::step`], weighted.
const STEP: &str = "
fn hysteresis(x: hysteresis, u) {
    let z = w[0] * u;
    for k in 1..n {
        x.play[k - 1] = clamp(x.play[k - 1], u - r[k - 1], u + r[k - 1]);
        z += w[k] * x.play[k - 1];
    }
    for f in 1..dimensions { x.memory[f - 1] = clamp(x.memory[f - 1], u - s[f - 1], u + s[f - 1]); }
    let now = (u - middle) / half;
    for m in 0..inducing {
        // The squared distance from the inducing point.
        let first = (now - points[m * dimensions]) / length_input;
        let away = first * first;
        for f in 1..dimensions {
            let off = ((x.memory[f - 1] - middle) / half - points[m * dimensions + f]) / length_plays;
            away += off * off;
        }
        z += w[n + m] * (half * (exponential(-0.5 * away) - resting[m]));
    }
    x.last = u;
    return z;
}
";

#[cfg(test)]
mod tests {
    use super::super::{Hysteresis, load, save};
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use piezoid_testing::assert_close;
    use serde_json::json;
    use std::sync::Arc;

    fn example() -> Arc<dyn Hysteresis> {
        (OPERATOR.example)(5e-4).unwrap()
    }

    fn law() -> GaussianProcess {
        let document = save(&*example());
        let field = |name: &str| serde_json::from_value(document[name].clone()).unwrap();
        let points = serde_json::from_value(document["points"].clone()).unwrap();
        GaussianProcess {
            thresholds: field("thresholds"),
            memory: field("memory"),
            points,
            length_input: 1.3,
            length_plays: 0.8,
        }
    }

    fn wander(n: u32) -> Vec<f64> {
        (0..n).map(|t| 28.0 * (f64::from(t) * 0.1).sin() * (f64::from(t) * 0.013).cos()).collect()
    }

    #[test]
    fn without_points_it_is_prandtl_ishlinskii() {
        let mut document = save(&*example());
        let plays = json!({"operator": "prandtl-ishlinskii", "range": document["range"],
                           "thresholds": document["thresholds"], "weights": thresholds::example_weights(0.7)});
        document["weights"].as_array_mut().unwrap()[9..].iter_mut().for_each(|a| *a = json!(0.0));
        let [process, plays] = [document, plays].map(|document| load(&document, 5e-4).unwrap());
        assert_close(&process.simulate(&wander(400)), &plays.simulate(&wander(400)), 1e-14, 1e-13);
    }

    #[test]
    fn the_penalty_is_the_prior_of_the_process() {
        let law = law();
        let (n, points) = (law.plays(), law.points.len());
        let a: Vec<f64> = (0..points).map(|m| (1.7 * m as f64).cos()).collect();
        let of_row = |row: &Vec<(usize, f64)>| row.iter().map(|(k, l)| l * a[k - n]).sum::<f64>().powi(2);
        let rows = law.roughness();
        let penalty: f64 = rows.iter().filter(|row| row.iter().all(|(k, _)| *k >= n)).map(of_row).sum();
        let k = DMatrix::from_fn(points, points, |i, j| law.kernel(&law.points[i], &law.points[j]));
        let a = DVector::from(a);
        assert_close(&[penalty], &[a.dot(&(k * &a))], 1e-6, 0.0);
    }

    #[test]
    fn the_deviation_is_that_of_the_conditional_process() {
        let process = example();
        let document = save(&*process);
        let weights: Vec<f64> = serde_json::from_value(document["weights"].clone()).unwrap();
        let law = GaussianProcess { length_input: 1.0, length_plays: 1.0, ..law() };
        let (a, points) = (DVector::from(weights[9..].to_vec()), law.points.len());
        let k = DMatrix::from_fn(points, points, |i, j| law.kernel(&law.points[i], &law.points[j]));
        let size = 30.0 * (a.dot(&(&k * &a)) / points as f64).sqrt();
        let (inverse, mut x) = (k.try_inverse().unwrap(), process.settled(0.0));
        for u in wander(200) {
            process.step(&mut x, u);
            let state: Vec<f64> = [x[0]].iter().chain(&x[9..]).map(|p| p / 30.0).collect();
            let k = DVector::from_fn(points, |m, _| law.kernel(&state, &law.points[m]));
            let known = size * (1.0 - k.dot(&(&inverse * &k))).max(0.0).sqrt();
            assert_close(&[process.deviation(&x).unwrap()], &[known], 1e-4, 1e-3 * size);
        }
        // At an inducing point it is known, far from all it is not.
        let at = |point: &[f64]| {
            let x: Vec<f64> =
                [30.0 * point[0]].into_iter().chain([0.0; 8]).chain(point[1..].iter().map(|v| 30.0 * v)).collect();
            process.deviation(&x).unwrap() / size
        };
        assert!(at(&law.points[3]) < 1e-3 && at(&[9.0; 5]) > 0.999, "{} {}", at(&law.points[3]), at(&[9.0; 5]));
        assert_eq!((super::super::play::OPERATOR.example)(5e-4).unwrap().deviation(&[0.0; 9]), None);
    }

    #[test]
    fn points_of_another_dimension_than_the_memory_are_an_error() {
        let mut document = save(&*example());
        document["points"][2] = json!([0.0, 1.0]);
        assert!(load(&document, 5e-4).unwrap_err().to_string().starts_with("points = 2 numbers: must be 5 to 5"));
    }

    #[test]
    fn the_factor_is_that_of_the_kernel_between_the_points() {
        let law = law();
        let factor = law.factor();
        for (i, x) in law.points.iter().enumerate() {
            assert_eq!(factor[i].len(), i + 1);
            for (j, y) in law.points[..=i].iter().enumerate() {
                let product: f64 = factor[i].iter().zip(&factor[j]).map(|(l, m)| l * m).sum();
                let nugget = if i == j { NUGGET } else { 0.0 };
                assert_close(&[product], &[law.kernel(x, y) + nugget], 0.0, 1e-14);
            }
        }
    }

    #[test]
    fn the_deviation_moves_with_the_range() {
        let (process, mut document) = (example(), save(&*example()));
        document["range"] = json!([-10.0, 50.0]);
        let moved = load(&document, 5e-4).unwrap();
        let mut x = process.settled(0.0);
        for u in wander(50) {
            process.step(&mut x, u);
            let there: Vec<f64> =
                x.iter().enumerate().map(|(k, x)| if k == 0 || k > 8 { x + 20.0 } else { *x }).collect();
            let known = process.deviation(&x).unwrap();
            assert_close(&[moved.deviation(&there).unwrap()], &[known], 1e-4, 1e-3);
        }
    }
}
