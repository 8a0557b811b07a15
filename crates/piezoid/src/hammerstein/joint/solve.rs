//! One step: regularised, sign-constrained least squares in all parameters at once.
//!
//! ```text
//! min |error|^2 + S lambda |D w|^2 + mu |steps of the others|^2,   w_k >= 0 where physics asks for it,  g_i >= 0
//! ```
//! D takes second differences of neighbouring weights; S is the mean size of the weights' columns, so lambda has no unit.
//! A factor may stand in G or in w alike: the static gain of G is held, and w carries it.

use super::equations::Normal;
use super::estimate::Estimate;
use super::layout::Layout;
use crate::optimize::non_negative;
use nalgebra::{DMatrix, DVector};

/// Ridge on the weights, against ties between them.
const RIDGE: f64 = 1e-12;

/// Which parameters move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Freed {
    /// The weights.
    Weights,
    /// The weights and the gains of creep.
    Creep,
    /// All.
    All,
}

/// What is known of the parameters beside the data.
#[derive(Debug)]
pub(super) struct Prior {
    layout: Layout,
    /// Where all parameters stand.
    now: DVector<f64>,
    /// D'D.
    smooth: DMatrix<f64>,
    /// Which must not be negative.
    signed: Vec<bool>,
    /// The derivative of ln(static gain of G).
    gain: DVector<f64>,
}

impl Prior {
    pub(super) fn of(estimate: &Estimate) -> Self {
        let layout = Layout::of(estimate);
        let (a, b) = (estimate.linear.a(), estimate.linear.b());
        let gains = estimate.lags.iter().map(|lag| lag.gain);
        let shape = estimate.basis.shape().into_iter().map(|shape| shape.value);
        let now = estimate.weights.iter().copied().chain(gains).chain(shape).chain(a.iter().copied());
        let now = now.chain(b[estimate.linear.delay()..].iter().copied());

        let mut smooth = DMatrix::zeros(layout.weights.len(), layout.weights.len());
        for row in estimate.basis.roughness() {
            for &(i, p) in &row {
                row.iter().for_each(|&(j, q)| smooth[(i, j)] += p * q);
            }
        }
        let mut signed = estimate.basis.non_negative();
        signed.resize(layout.gains.end, true);
        signed.resize(layout.parameters(), false);

        let (fed_back, fed_forward) = (1.0 - a.iter().sum::<f64>(), b.iter().sum::<f64>());
        let mut gain = DVector::zeros(layout.parameters());
        gain.rows_range_mut(layout.a.clone()).fill(1.0 / fed_back);
        gain.rows_range_mut(layout.b.clone()).fill(1.0 / fed_forward);
        Prior { now: DVector::from_iterator(layout.parameters(), now), layout, smooth, signed, gain }
    }

    /// Where all parameters stand.
    pub(super) fn now(&self) -> &DVector<f64> {
        &self.now
    }

    /// `x` as the equations take it: the weights, and the steps of the others.
    pub(super) fn steps(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut steps = x - &self.now;
        steps.rows_range_mut(self.layout.weights.clone()).copy_from(&x.rows_range(self.layout.weights.clone()));
        steps
    }

    /// What roughness costs at `x`.
    pub(super) fn penalty(&self, normal: &Normal, lambda: f64, x: &DVector<f64>) -> f64 {
        let w = x.rows_range(self.layout.weights.clone());
        self.size(normal) * (lambda * w.dot(&(&self.smooth * w)) + RIDGE * w.norm_squared())
    }

    /// The parameters that solve `normal`, only the `freed` ones moving; `damping` holds the steps of the others than
    /// weights short. `positive` says which are guessed to be positive, and is left as found. `None` where the equations have
    /// no solution.
    pub(super) fn solve(
        &self,
        normal: &Normal,
        lambda: f64,
        damping: f64,
        freed: Freed,
        positive: &mut [bool],
    ) -> Option<DVector<f64>> {
        let (layout, size) = (&self.layout, self.size(normal));
        let weights = layout.weights.len();
        let mut h = normal.h.clone();
        // The others enter by their steps, x - now.
        let mut others = self.now.clone();
        others.rows_range_mut(layout.weights.clone()).fill(0.0);
        let mut g = &normal.g + &h * others;

        let mut w = h.view_mut((0, 0), (weights, weights));
        w += &self.smooth * (size * lambda);
        for k in 0..layout.parameters() {
            let stiff = if k < weights { size * RIDGE + 1e-14 * h[(k, k)] } else { damping * h[(k, k)] };
            let stiff = stiff + f64::MIN_POSITIVE;
            h[(k, k)] += stiff;
            g[k] += if k < weights { 0.0 } else { stiff * self.now[k] };
        }
        let firm = 1e6 * normal.yy.max(f64::MIN_POSITIVE);
        h.ger(firm, &self.gain, &self.gain, 1.0);
        g.axpy(firm * self.gain.dot(&self.now), &self.gain, 1.0);

        let moving = match freed {
            Freed::Weights => weights,
            Freed::Creep => layout.gains.end,
            Freed::All => layout.parameters(),
        };
        for k in moving..layout.parameters() {
            g.axpy(-self.now[k], &h.column(k), 1.0);
        }
        // Columns of equal size, for the sake of the factorisation.
        let unit: Vec<f64> = (0..moving).map(|k| h[(k, k)].sqrt().recip()).collect();
        let scaled: Vec<f64> = (0..moving).flat_map(|i| (0..moving).map(move |j| (i, j))).map(|(i, j)| h[(i, j)] * unit[i] * unit[j]).collect();
        let target: Vec<f64> = (0..moving).map(|k| g[k] * unit[k]).collect();
        let solved = non_negative(&scaled, &target, &self.signed[..moving], &mut positive[..moving])?;
        let mut x = self.now.clone();
        (0..moving).for_each(|k| x[k] = solved[k] * unit[k]);
        Some(x)
    }

    /// The mean size of the weights' columns.
    fn size(&self, normal: &Normal) -> f64 {
        self.layout.weights.clone().map(|k| normal.h[(k, k)]).sum::<f64>() / self.layout.weights.len() as f64
    }
}
