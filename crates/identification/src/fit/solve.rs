//! One step: regularised, sign-constrained least squares in all parameters.
//!
//! ```text
//! min |error|^2 + S lambda |D w|^2 + mu |steps|^2,   w_k >= 0 if physics requires it,
//! 0 <= g_i <= 0.1,   low <= p_j <= high
//! ```
//! D takes second differences of neighbouring weights. S is the mean size of the weights' columns at the start of the
//! fit, so lambda has no unit. What goes beyond a limit of its gain or shape is held there until the next step. A
//! penalty keeps the gain of a creep lag near that of the next faster lag, and that of the fastest near a usual value.
//! Creep of one order has gains in a fixed ratio, by a penalty that is as good as a constraint.
//! The static gain of G is fixed, because G and w can share any factor.
//!
//! Why: docs/decisions/identification.md, "Creep lags are half a decade apart".

use super::equations::ReducedEquations;
use super::estimate::{Estimate, of_differences};
use super::layout::ColumnLayout;
use nalgebra::{DMatrix, DVector};
use piezoid_models::hysteresis::Basis;
use piezoid_numerics::optimize::non_negative;
use std::ops::Range;
use tracing::trace_span;

/// Weight that keeps undetermined weights at their values.
const WEIGHT_RIDGE: f64 = 1e-12;

/// Weight that draws the gain of a lag to that of the next faster one, over the mean size of their columns, up to the
/// usual gain: by the logarithmic law they are equal, and records are too short for the slowest.
const EQUAL_GAIN_WEIGHT: f64 = 0.03;
const USUAL_CREEP_GAIN: f64 = 0.015;

/// The same for creep of one order: the gains have their ratio to about a thousandth of what the data leave open.
const ONE_ORDER_WEIGHT: f64 = 1e6;

/// Largest gain of a creep lag in ceramics.
pub(crate) const MAX_CREEP_GAIN: f64 = 0.1;

/// The free parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FreeParameters {
    /// The weights.
    Weights,
    /// The weights and the gains of creep.
    Creep,
    /// These, the shape of the hysteresis and the lag of the driver.
    Shape,
    /// All.
    All,
}

/// What a gain of creep is drawn to.
enum Target {
    None,
    /// The gain of the next faster lag times this ratio.
    Faster(f64),
    Usual,
}

/// The scales of the penalties, per sample. Along a fit they are those of its start: the cost is one function of the
/// parameters.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Scales {
    /// S: the mean size of the weights' columns.
    weights: f64,
    /// The mean size of the columns of the gains of creep.
    gains: f64,
}

impl Scales {
    pub(crate) fn of(estimate: &Estimate, normal: &ReducedEquations) -> Self {
        let layout = ColumnLayout::of(estimate);
        let mean = |columns: Range<usize>| {
            let count = columns.len().max(1) as f64;
            columns.map(|k| normal.h[(k, k)]).sum::<f64>() / count / normal.samples.max(1.0)
        };
        Scales { weights: mean(layout.weights), gains: mean(layout.gains) }
    }
}

/// Knowledge about the parameters in addition to the data.
#[derive(Debug)]
pub(crate) struct Prior {
    layout: ColumnLayout,
    pub(crate) scales: Scales,
    /// The current parameters.
    current: DVector<f64>,
    /// D'D.
    smooth: DMatrix<f64>,
    /// True for parameters that must not be negative.
    signed: Vec<bool>,
    /// The other limits of the parameters.
    limits: Vec<(f64, f64)>,
    /// The derivative of ln(static gain of G).
    gain: DVector<f64>,
    /// The ratio of the gains of neighbouring lags of creep, if it has one order.
    ratio: Option<f64>,
}

impl Prior {
    pub(crate) fn of(estimate: &Estimate, scales: Scales) -> Self {
        let layout = ColumnLayout::of(estimate);
        let (a, b) = (estimate.linear.a(), estimate.linear.b());
        let gains = estimate.lags.iter().map(|lag| lag.gain);
        let shape = estimate.basis.shape().into_iter().map(|shape| shape.value);
        let lag = estimate.driver.filter(|_| estimate.seeks_lag).map(|driver| driver.lag_s);
        let now = estimate.weights.iter().copied().chain(gains).chain(shape).chain(lag).chain(of_differences(a));
        let now = now.chain(of_differences(&b[estimate.linear.delay()..]));

        let smooth = roughness(&*estimate.basis);
        let mut signed = estimate.basis.non_negative();
        signed.resize(layout.gains.end, true);
        signed.resize(layout.parameters(), false);
        let mut limits = vec![(f64::NEG_INFINITY, f64::INFINITY); layout.parameters()];
        // Lags with more than creep of ceramics have the largest gain of creep: they are something else.
        let most = if estimate.creep_order.is_some() { f64::INFINITY } else { MAX_CREEP_GAIN };
        limits[layout.gains.clone()].fill((f64::NEG_INFINITY, most));
        let of_shape = limits[layout.shape.clone()].iter_mut().zip(estimate.shape_limits());
        of_shape.for_each(|(limits, shape)| *limits = shape);

        let (fed_back, fed_forward) = (1.0 - a.iter().sum::<f64>(), b.iter().sum::<f64>());
        let mut gain = DVector::zeros(layout.parameters());
        // Differences of a constant are zero: only the coefficients of order 0 enter.
        gain.rows_range_mut(layout.a.clone()).iter_mut().take(1).for_each(|g| *g = 1.0 / fed_back);
        gain.rows_range_mut(layout.b.clone()).iter_mut().take(1).for_each(|g| *g = 1.0 / fed_forward);
        Prior {
            current: DVector::from_iterator(layout.parameters(), now),
            layout,
            scales,
            smooth,
            signed,
            limits,
            gain,
            ratio: estimate.gain_ratio(),
        }
    }

    /// The current parameters.
    pub(crate) fn current(&self) -> &DVector<f64> {
        &self.current
    }

    /// A guess which parameters are positive: those that are, or all if no weight is known yet.
    pub(crate) fn positive(&self) -> Vec<bool> {
        let is_known = self.current.rows_range(self.layout.weights.clone()).iter().any(|weight| *weight > 0.0);
        self.current.iter().map(|value| !is_known || *value > 0.0).collect()
    }

    /// The current values that must not be negative.
    pub(crate) fn signed(&self) -> impl Iterator<Item = f64> {
        self.current.iter().zip(&self.signed).filter(|(_, signed)| **signed).map(|(value, _)| *value)
    }

    /// `x` as unknowns of the equations: the weights, and the steps of the others.
    pub(crate) fn steps(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut steps = x - &self.current;
        steps.rows_range_mut(self.layout.weights.clone()).copy_from(&x.rows_range(self.layout.weights.clone()));
        steps
    }

    /// The penalties of roughness and of unlike gains of creep at `x`.
    pub(crate) fn penalty(&self, normal: &ReducedEquations, lambda: f64, x: &DVector<f64>) -> f64 {
        let w = x.rows_range(self.layout.weights.clone());
        let unlike = |k: usize| match self.target(k, x) {
            Target::Faster(ratio) => (x[k] - ratio * x[k - 1]).powi(2),
            Target::Usual => (x[k] - USUAL_CREEP_GAIN).powi(2),
            Target::None => 0.0,
        };
        let unlike: f64 = self.layout.gains.clone().map(unlike).sum();
        self.scales.weights * normal.samples * lambda * w.dot(&(&self.smooth * w)) + self.alike(normal) * unlike
    }

    /// What the gain `k` is drawn to at `x`.
    fn target(&self, k: usize, x: &DVector<f64>) -> Target {
        match (k > self.layout.gains.start, self.ratio) {
            (true, Some(ratio)) => Target::Faster(ratio),
            (false, Some(_)) => Target::None,
            (true, None) if x[k - 1] < USUAL_CREEP_GAIN => Target::Faster(1.0),
            (false, None) if x[k] < USUAL_CREEP_GAIN => Target::None,
            _ => Target::Usual,
        }
    }

    /// The weight of the penalty of unlike gains.
    fn alike(&self, normal: &ReducedEquations) -> f64 {
        let weight = if self.ratio.is_some() { ONE_ORDER_WEIGHT } else { EQUAL_GAIN_WEIGHT };
        weight * self.scales.gains * normal.samples
    }

    /// The solution of `normal`, with only the `free` parameters moving. `damping` limits the steps of all but the
    /// weights. `positive` guesses which parameters are positive, and is updated. `None` if the equations have no
    /// solution.
    pub(crate) fn solve(
        &self,
        normal: &ReducedEquations,
        lambda: f64,
        damping: f64,
        free: FreeParameters,
        positive: &mut [bool],
    ) -> Option<DVector<f64>> {
        let _span = trace_span!("solutions").entered();
        let (layout, size) = (&self.layout, self.scales.weights * normal.samples);
        let weights = layout.weights.len();
        let (mut h, mut g) = (normal.h.clone(), normal.g.clone());
        let mut w = h.view_mut((0, 0), (weights, weights));
        w += &self.smooth * (size * lambda);
        for k in 0..layout.parameters() {
            let stiff = if k < weights { size * WEIGHT_RIDGE + 1e-14 * h[(k, k)] } else { damping * h[(k, k)] };
            h[(k, k)] += stiff + f64::MIN_POSITIVE;
            // Unknowns are the weights themselves and the steps of the others.
            g[k] += if k < weights { stiff * self.current[k] } else { 0.0 };
        }
        // Gains enter by their steps, but must not be negative: solve for the gains themselves.
        for k in layout.gains.clone() {
            g.axpy(self.current[k], &normal.h.column(k), 1.0);
            g[k] += (h[(k, k)] - normal.h[(k, k)]) * self.current[k];
        }
        let alike = self.alike(normal);
        for k in layout.gains.clone() {
            match self.target(k, &self.current) {
                Target::None => continue,
                Target::Usual => g[k] += alike * USUAL_CREEP_GAIN,
                Target::Faster(ratio) => {
                    h[(k - 1, k - 1)] += ratio * ratio * alike;
                    h[(k - 1, k)] -= ratio * alike;
                    h[(k, k - 1)] -= ratio * alike;
                }
            }
            h[(k, k)] += alike;
        }
        let held = self.hold_static_gain(&mut h, &mut g);

        let end = match free {
            FreeParameters::Weights => weights,
            FreeParameters::Creep => layout.gains.end,
            FreeParameters::Shape => layout.shape.end,
            FreeParameters::All => layout.parameters(),
        };
        if free == FreeParameters::Weights {
            layout.gains.clone().for_each(|k| g.axpy(-self.current[k], &h.column(k), 1.0));
        }
        let moving: Vec<usize> = (0..end).filter(|k| held.as_ref().is_none_or(|held| held.0 != *k)).collect();
        // Columns of equal size, for the factorisation.
        let unit: Vec<f64> = moving.iter().map(|&k| h[(k, k)].sqrt().recip()).collect();
        let n = moving.len();
        let scaled = DMatrix::from_fn(n, n, |i, j| h[(moving[i], moving[j])] * unit[i] * unit[j]);
        let target = DVector::from_fn(n, |i, _| g[moving[i]] * unit[i]);
        let signed: Vec<bool> = moving.iter().map(|&k| self.signed[k]).collect();
        let mut solved = non_negative(&scaled, &target, &signed, &mut positive[..n])?;
        // Weights and gains are unknown themselves, and of the others the steps.
        let from = |k: usize| if k < layout.gains.end { 0.0 } else { self.current[k] };
        let value = |j: usize, solved: f64| from(moving[j]) + solved * unit[j];
        // Those that were beyond a limit, at this limit; they are free again in the next step.
        let mut held_at: Vec<(usize, f64)> = Vec::new();
        let is_held = |held_at: &[(usize, f64)], j: usize| held_at.iter().any(|held| held.0 == j);
        let beyond = |solved: &DVector<f64>, held_at: &[(usize, f64)]| {
            let limited = |j: usize| {
                let (value, (low, high)) = (value(j, solved[j]), self.limits[moving[j]]);
                (value < low || value > high).then(|| (j, value.clamp(low, high)))
            };
            (0..n).filter(|&j| !is_held(held_at, j)).find_map(limited)
        };
        while let Some(held) = beyond(&solved, &held_at) {
            held_at.push(held);
            let known =
                DVector::from_iterator(held_at.len(), held_at.iter().map(|&(j, at)| (at - from(moving[j])) / unit[j]));
            let columns: Vec<usize> = held_at.iter().map(|held| held.0).collect();
            let rest: Vec<usize> = (0..n).filter(|&j| !is_held(&held_at, j)).collect();
            let h = scaled.select_rows(&rest);
            let g = target.select_rows(&rest) - h.select_columns(&columns) * known;
            let signed: Vec<bool> = rest.iter().map(|&i| signed[i]).collect();
            let mut free: Vec<bool> = rest.iter().map(|&i| positive[i]).collect();
            let found = non_negative(&h.select_columns(&rest), &g, &signed, &mut free)?;
            rest.iter().zip(&found).for_each(|(&i, x)| solved[i] = *x);
            rest.iter().zip(&free).for_each(|(&i, free)| positive[i] = *free);
        }

        let mut x = self.current.clone();
        moving.iter().enumerate().for_each(|(j, &k)| x[k] = value(j, solved[j]));
        held_at.iter().for_each(|&(j, at)| x[moving[j]] = at);
        if let Some((held, ratios)) = held {
            let steps: f64 = (layout.shape.end..end).map(|k| ratios[k] * (x[k] - self.current[k])).sum();
            x[held] = self.current[held] - steps;
        }
        Some(x)
    }

    /// Eliminates one b from the equations, because the static gain of G is fixed: its index, and its decrease per
    /// increase of each other parameter. `None` if G has no parameters.
    fn hold_static_gain(&self, h: &mut DMatrix<f64>, g: &mut DVector<f64>) -> Option<(usize, DVector<f64>)> {
        let held = self.layout.b.clone().max_by(|&j, &k| self.gain[j].abs().total_cmp(&self.gain[k].abs()))?;
        let mut ratios = &self.gain / self.gain[held];
        ratios[held] = 0.0;
        let (column, pivot) = (h.column(held).into_owned(), h[(held, held)]);
        h.ger(-1.0, &ratios, &column, 1.0);
        h.ger(-1.0, &column, &ratios, 1.0);
        h.ger(pivot, &ratios, &ratios, 1.0);
        g.axpy(-g[held], &ratios, 1.0);
        Some((held, ratios))
    }
}

/// The matrix of the sum of squares of the roughness.
pub(crate) fn roughness(basis: &dyn Basis) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(basis.len(), basis.len());
    for row in basis.roughness() {
        for &(i, p) in &row {
            row.iter().for_each(|&(j, q)| matrix[(i, j)] += p * q);
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::super::equations::equations;
    use super::super::estimate::CreepOrder;
    use super::super::testing::{estimate, full_estimate, segment};
    use super::*;
    use piezoid_models::creep::Lag;
    use piezoid_models::hysteresis::Operator;
    use piezoid_testing::assert_close;

    #[test]
    fn the_weights_satisfy_the_optimality_conditions() {
        let estimate = estimate("prandtl-ishlinskii", 12);
        let layout = ColumnLayout::of(&estimate);
        let mut held = 0;
        for (seed, lambda) in [(1, 0.0), (2, 1e-6), (3, 1e-3), (4, 0.1)] {
            let (normal, _) = equations(&estimate, &[segment(&layout, 0, None, seed)], |_| true, &[]);
            let prior = Prior::of(&estimate, Scales::of(&estimate, &normal));
            let mut positive = vec![true; layout.parameters()];
            let x = prior.solve(&normal, lambda, 1e-6, FreeParameters::Weights, &mut positive).unwrap();
            // Only the weights move.
            assert_eq!(x.rows_range(layout.weights.end..), prior.current().rows_range(layout.weights.end..));
            let w = x.rows_range(layout.weights.clone()).into_owned();
            let n = w.len();
            let smooth = &prior.smooth * (lambda * prior.scales.weights * normal.samples);
            let gradient = (normal.h.view((0, 0), (n, n)) + smooth) * &w - normal.g.rows(0, n);
            for (k, (w, slope)) in w.iter().zip(&gradient).enumerate() {
                let slope = slope / normal.g.amax();
                held += usize::from(*w == 0.0);
                match (prior.signed[k], *w) {
                    (true, 0.0) => assert!(slope > -1e-7, "weight {k} at zero falls: {slope}"),
                    (signed, w) => {
                        assert!(slope.abs() < 1e-7 && (w > 0.0 || !signed), "weight {k} = {w}: slope {slope}");
                    }
                }
            }
        }
        assert!(held > 0, "no weight was held at zero");
    }

    #[test]
    fn shape_parameters_end_at_their_limits_and_the_others_are_best_there() {
        let estimate = estimate("generalised-prandtl-ishlinskii", 4);
        let layout = ColumnLayout::of(&estimate);
        let (normal, _) = equations(&estimate, &[segment(&layout, 0, None, 7)], |_| true, &[]);
        // The optimum is as far away as 200 samples of noise allow; here farther.
        let normal = ReducedEquations { g: &normal.g * 30.0, ..normal };
        let prior = Prior::of(&estimate, Scales::of(&estimate, &normal));
        let mut positive = vec![true; layout.parameters()];
        let x = prior.solve(&normal, 0.0, 0.0, FreeParameters::Shape, &mut positive).unwrap();
        let shape = || layout.shape.clone().zip(estimate.shape_limits());
        assert!(shape().all(|(k, (low, high))| (low..=high).contains(&x[k])), "{x}");
        assert!(shape().any(|(k, (low, high))| x[k] == low || x[k] == high), "{x}");
        let slope = &normal.h * prior.steps(&x) - &normal.g;
        let inside = shape().filter(|(k, (low, high))| x[*k] > *low && x[*k] < *high).map(|(k, _)| k);
        let weights = layout.weights.clone().filter(|k| x[*k] != 0.0);
        assert!(inside.chain(weights).all(|k| slope[k].abs() < 1e-6 * normal.g.amax()), "{x} {slope}");
    }

    #[test]
    fn the_static_gain_of_the_linear_block_is_fixed() {
        let estimate = estimate("prandtl-ishlinskii", 4);
        let layout = ColumnLayout::of(&estimate);
        let (normal, _) = equations(&estimate, &[segment(&layout, 0, None, 5)], |_| true, &[]);
        let prior = Prior::of(&estimate, Scales::of(&estimate, &normal));
        let mut positive = vec![true; layout.parameters()];
        let x = prior.solve(&normal, 0.0, 1e-3, FreeParameters::All, &mut positive).unwrap();
        let steps = &x - prior.current();
        let moved = steps.rows_range(layout.a.start..layout.b.end).amax();
        assert!(moved > 1e-9 && prior.gain.dot(&steps).abs() < 1e-9 * moved.max(1.0), "{steps}");
    }

    const ONE_ORDER: Option<CreepOrder> = Some(CreepOrder { value: 0.5, error: 0.0 });

    /// Lags with these gains, each four times as slow as the one before: their gains have the ratio 2 in [`ONE_ORDER`].
    fn lags(gains: [f64; 3]) -> Vec<Lag> {
        [0.01, 0.04, 0.16].into_iter().zip(gains).map(|(tau_s, gain)| Lag { tau_s, gain }).collect()
    }

    #[test]
    fn roughness_and_unlike_gains_are_penalised() {
        for (gains, creep_order, weight, unlike) in [
            // Each gain is drawn to the next faster one, and to the usual one where that is larger.
            ([0.01, 0.02, 0.03], None, 0.03, 0.01f64.powi(2) + 0.015f64.powi(2)),
            ([0.02, 0.01, 0.03], None, 0.03, 2.0 * 0.005f64.powi(2) + 0.02f64.powi(2)),
            ([0.01, 0.03, 0.05], ONE_ORDER, 1e6, 2.0 * 0.01f64.powi(2)),
        ] {
            let weights = vec![5.0, 1.0, 3.0, 2.0, 2.0];
            let estimate = Estimate { weights, lags: lags(gains), creep_order, ..estimate("prandtl-ishlinskii", 4) };
            // The columns of weights and gains have the mean sizes 0.6 and 0.2 per sample.
            let sizes = [2.0, 4.0, 6.0, 8.0, 10.0, 1.0, 2.0, 3.0, 50.0, 50.0];
            let h = DMatrix::from_diagonal(&DVector::from_row_slice(&sizes));
            let normal = ReducedEquations { h, g: DVector::zeros(10), yy: 0.0, samples: 10.0 };
            let prior = Prior::of(&estimate, Scales::of(&estimate, &normal));
            let penalty = |lambda: f64| prior.penalty(&normal, lambda, prior.current());
            let [smooth, rough] = [0.0, 0.5].map(penalty);
            // The weights of plays bend by -3 and 1: 0.6 x 10 x 0.5 x (9 + 1).
            assert_close(&[smooth, rough - smooth], &[weight * 0.2 * 10.0 * unlike, 30.0], 1e-9, 0.0);
        }
    }

    #[test]
    fn a_step_is_best_for_squares_penalties_and_damping_together() {
        let kinds = [FreeParameters::Weights, FreeParameters::Creep, FreeParameters::Shape, FreeParameters::All];
        for (free, creep_order) in kinds.into_iter().flat_map(|free| [(free, None), (free, ONE_ORDER)]) {
            let row = Operator::find("generalised-prandtl-ishlinskii").unwrap();
            let estimate = Estimate { lags: lags([0.01, 0.02, 0.04]), creep_order, ..full_estimate(row, None) };
            let layout = ColumnLayout::of(&estimate);
            let (normal, _) = equations(&estimate, &[segment(&layout, 0, None, 9)], |_| true, &[]);
            let prior = Prior::of(&estimate, Scales::of(&estimate, &normal));
            // The best parameters are near the present ones, within all limits.
            let near = prior.steps(&prior.current().map(|value| value + 1e-3));
            let normal = ReducedEquations { g: &normal.h * near, yy: 1e4, ..normal };
            let (lambda, damping) = (1e-3, 0.3);
            let mut positive = vec![true; layout.parameters()];
            let x = prior.solve(&normal, lambda, damping, free, &mut positive).unwrap();
            let cost = |x: &DVector<f64>| {
                let others = layout.weights.end..x.len();
                let damped = others.map(|k| normal.h[(k, k)] * (x[k] - prior.current()[k]).powi(2)).sum::<f64>();
                normal.residual(&prior.steps(x)) + prior.penalty(&normal, lambda, x) + damping * damped
            };
            let slope = |k: usize| {
                let at = |by: f64| {
                    let mut x = x.clone();
                    x[k] += by;
                    cost(&x)
                };
                (at(1e-4) - at(-1e-4)) / 2e-4
            };
            let (end, first_b) = match free {
                FreeParameters::Weights => (layout.weights.end, None),
                FreeParameters::Creep => (layout.gains.end, None),
                FreeParameters::Shape => (layout.shape.end, None),
                FreeParameters::All => (layout.parameters(), Some(layout.b.start)),
            };
            // With a fixed static gain, the slope is along its own.
            let along_gain = first_b.map_or(0.0, |k| slope(k) / prior.gain[k]);
            for k in 0..end {
                let off = slope(k) - along_gain * prior.gain[k];
                assert!(off.abs() < 1e-5 * normal.g.amax(), "{free:?} {creep_order:?}: {off:e} of parameter {k}");
            }
            assert_eq!(x.rows_range(end..), prior.current().rows_range(end..));
            let steps = &x - prior.current();
            let static_gain = |share: f64| {
                let moved = prior.current() + &steps * share;
                estimate.moved(moved.as_slice()).unwrap().linear.dc_gain()
            };
            assert!((static_gain(0.1) / static_gain(-0.1) - 1.0).abs() < 1e-8, "{free:?}: {steps}");
        }
    }

    #[test]
    fn a_weight_without_data_keeps_its_value() {
        let weights = vec![5.0, 1.0, 3.0, 2.0, 2.0];
        let estimate = Estimate { weights, ..estimate("prandtl-ishlinskii", 4) };
        let h = DMatrix::from_diagonal(&DVector::from_row_slice(&[2.0, 4.0, 0.0, 8.0, 10.0, 1.0, 1.0]));
        let g = DVector::from_row_slice(&[2.0, 8.0, 0.0, 8.0, 5.0, 0.0, 0.0]);
        let normal = ReducedEquations { h, g, yy: 0.0, samples: 10.0 };
        let prior = Prior::of(&estimate, Scales::of(&estimate, &normal));
        let x = prior.solve(&normal, 0.0, 1e-7, FreeParameters::Weights, &mut [true; 7]).unwrap();
        assert_close(x.as_slice(), &[1.0, 2.0, 3.0, 1.0, 0.5, 0.6, 1.3], 1e-9, 0.0);
    }

    #[test]
    fn all_parameters_are_guessed_positive_until_a_weight_is_known() {
        let of = |weights: [f64; 5]| {
            let estimate = Estimate { weights: weights.into(), ..estimate("prandtl-ishlinskii", 4) };
            Prior::of(&estimate, Scales::default()).positive()
        };
        assert_eq!(of([0.0; 5]), [true; 7]);
        assert_eq!(of([0.0, 1.0, 0.0, 2.0, -1.0]), [false, true, false, true, false, true, true]);
    }
}
