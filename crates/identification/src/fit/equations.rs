//! Normal equations, with the coefficients of single records eliminated.
//!
//! A record's own coefficients v (initial state of creep, initial state of G, constant) are optimal for any parameters
//! x:
//!
//! ```text
//! | Hxx Hxv | |x|   |gx|
//! | Hvx Hvv | |v| = |gv|    =>    (Hxx - Hxv Hvv^-1 Hvx) x = gx - Hxv Hvv^-1 gv
//! ```
//! Golub & Pereyra 2003, DOI 10.1088/0266-5611/19/2/201.

use super::estimate::Estimate;
use super::layout::ColumnLayout;
use super::products::Segment;
use libm::log;
use nalgebra::{DMatrix, DVector};
use piezoid_models::linear::Arx;
use rayon::prelude::*;
use tracing::trace_span;

/// Expected distance of creep from settled at the start, over the peak-to-peak of y, and the error it is weighted
/// against.
const EXPECTED_CREEP: f64 = 0.01;
const EXPECTED_ERROR: f64 = 0.003;

/// Expected drift over a record, over the peak-to-peak of y: of any, and of one whose output drifts.
const EXPECTED_DRIFT: f64 = 0.01;
const DETECTED_DRIFT: f64 = 1.0;

/// Expected distance of G from its state at the start, over the peak-to-peak of y.
const EXPECTED_RINGING: f64 = 0.03;

/// Samples for one independent error of a record: those of a model are alike from sample to sample.
pub(crate) const SAMPLES_PER_ERROR: f64 = 100.0;

/// The weight that draws each of a run's own coefficients to zero: what is expected of them. `own` are their products.
fn expected(
    estimate: &Estimate,
    layout: &ColumnLayout,
    own: &DMatrix<f64>,
    samples: f64,
    drifts: bool,
) -> DVector<f64> {
    let p = layout.parameters();
    // The square of one sample of the constant's column.
    let one = own[(layout.constant - p, layout.constant - p)] / samples.max(1.0);
    let error = EXPECTED_ERROR.powi(2) * (samples / SAMPLES_PER_ERROR).max(1.0);
    let creep = one * error * (estimate.linear.dc_gain() / EXPECTED_CREEP).powi(2);
    let drift = one * error / if drifts { DETECTED_DRIFT } else { EXPECTED_DRIFT }.powi(2);
    // The state of G rings for as long as its slowest pole.
    let rings = error / EXPECTED_RINGING.powi(2) / longest_decay(&estimate.linear).clamp(1.0, samples.max(1.0));
    DVector::from_fn(own.nrows(), |k, _| {
        let weight = match p + k {
            column if layout.crept.contains(&column) => creep,
            column if layout.state.contains(&column) => rings * own[(k, k)],
            column if layout.trend == column => drift,
            _ => 0.0,
        };
        weight + 1e-10 * own[(k, k)] + f64::MIN_POSITIVE
    })
}

/// The time constant of the slowest pole [samples].
fn longest_decay(linear: &Arx) -> f64 {
    linear.poles().iter().map(|pole| -1.0 / log(pole.z.modulus())).fold(0.0, f64::max)
}

/// Sums of squares as functions of the weights and of the steps of the other parameters.
#[derive(Debug, Clone)]
pub(crate) struct ReducedEquations {
    pub(crate) h: DMatrix<f64>,
    pub(crate) g: DVector<f64>,
    pub(crate) yy: f64,
    pub(crate) samples: f64,
}

impl ReducedEquations {
    /// The sum of squares at `x`.
    pub(crate) fn residual(&self, x: &DVector<f64>) -> f64 {
        (self.yy + x.dot(&(&self.h * x - &self.g * 2.0))).max(0.0)
    }

    fn sum<'a>(n: usize, parts: impl Iterator<Item = &'a ReducedEquations>) -> Self {
        let zero = ReducedEquations { h: DMatrix::zeros(n, n), g: DVector::zeros(n), yy: 0.0, samples: 0.0 };
        parts.fold(zero, |mut sum, part| {
            sum.h += &part.h;
            sum.g += &part.g;
            sum.yy += part.yy;
            sum.samples += part.samples;
            sum
        })
    }
}

/// The equations of a run, and its own coefficients: v = v0 - V x.
#[derive(Debug, Clone)]
pub(crate) struct RecordEquations {
    pub(crate) run: usize,
    pub(crate) normal: ReducedEquations,
    carried: DMatrix<f64>,
    carried_y: DVector<f64>,
    /// The weight that draws each own coefficient to zero.
    expected: DVector<f64>,
}

impl RecordEquations {
    /// The equations of some segments of one run, with the priors of its own coefficients as in `like`.
    fn of(estimate: &Estimate, layout: &ColumnLayout, parts: &[&Segment], like: Option<&RecordEquations>) -> Self {
        let (p, m, y) = (layout.parameters(), layout.own(), layout.columns());
        let gram = parts[1..].iter().fold(parts[0].gram.clone(), |sum, part| sum + &part.gram);
        let samples = parts.iter().map(|part| part.samples).sum();
        let mut own = gram.view((p, p), (m, m)).into_owned();
        let expected = match like {
            Some(like) => like.expected.clone(),
            None => expected(estimate, layout, &own, samples, parts[0].drifts),
        };
        expected.iter().enumerate().for_each(|(k, weight)| own[(k, k)] += weight);
        let crossed = gram.view((p, 0), (m, p)).into_owned();
        let crossed_y = gram.view((p, y), (m, 1)).column(0).into_owned();
        let (carried, carried_y) = match own.cholesky() {
            Some(own) => (own.solve(&crossed), own.solve(&crossed_y)),
            None => (DMatrix::zeros(m, p), DVector::zeros(m)),
        };
        let normal = ReducedEquations {
            h: gram.view((0, 0), (p, p)) - crossed.tr_mul(&carried),
            g: gram.view((0, y), (p, 1)).column(0) - crossed.tr_mul(&carried_y),
            yy: gram[(y, y)] - crossed_y.dot(&carried_y),
            samples,
        };
        RecordEquations { run: parts[0].run, normal, carried, carried_y, expected }
    }

    /// The run's own coefficients for the parameters `x`.
    pub(crate) fn own(&self, x: &DVector<f64>) -> Vec<f64> {
        (&self.carried_y - &self.carried * x).iter().copied().collect()
    }
}

/// The equations of each run over the `selected` segments, and their sum. The priors of own coefficients are those of
/// the same run in `like`, if it is there: along a fit they must not change with the parameters.
pub(crate) fn equations(
    estimate: &Estimate,
    segments: &[Segment],
    selected: impl Fn(&Segment) -> bool + Sync,
    like: &[RecordEquations],
) -> (ReducedEquations, Vec<RecordEquations>) {
    let _span = trace_span!("equations").entered();
    let layout = ColumnLayout::of(estimate);
    let runs = segments.chunk_by(|p, q| p.run == q.run).collect::<Vec<_>>();
    let of = |run: &&[Segment]| {
        let parts: Vec<&Segment> = run.iter().filter(|s| s.samples > 0.0 && selected(s)).collect();
        let like = parts.first().and_then(|part| like.iter().find(|like| like.run == part.run));
        (!parts.is_empty()).then(|| RecordEquations::of(estimate, &layout, &parts, like))
    };
    let each: Vec<RecordEquations> = runs.par_iter().filter_map(of).collect();
    (ReducedEquations::sum(layout.parameters(), each.iter().map(|run| &run.normal)), each)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{estimate, segment};
    use super::*;
    use piezoid_models::creep::Lag;
    use piezoid_testing::assert_close;
    use std::f64::consts::LN_2;

    #[test]
    fn elimination_gives_the_solution_of_all_equations() {
        let estimate = estimate("prandtl-ishlinskii", 3);
        let layout = ColumnLayout::of(&estimate);
        let (p, m) = (layout.parameters(), layout.own());
        let segments = [segment(&layout, 0, None, 1), segment(&layout, 0, None, 2), segment(&layout, 1, None, 3)];
        let (normal, each) = equations(&estimate, &segments, |_| true, &[]);
        let x = normal.h.clone().cholesky().unwrap().solve(&normal.g);

        // All unknowns: the parameters, then the coefficients of the first run, then of the second.
        let (mut h, mut g) = (DMatrix::<f64>::zeros(p + 2 * m, p + 2 * m), DVector::<f64>::zeros(p + 2 * m));
        for part in &segments {
            let place = |k: usize| if k < p { k } else { k + part.run * m };
            for i in 0..p + m {
                g[place(i)] += part.gram[(i, p + m)];
                (0..p + m).for_each(|j| h[(place(i), place(j))] += part.gram[(i, j)]);
            }
        }
        for (run, samples) in [(0, 400.0), (1, 200.0)] {
            let own = h.view((p + run * m, p + run * m), (m, m)).into_owned();
            let expected = expected(&estimate, &layout, &own, samples, false);
            assert!(expected.iter().all(|weight| *weight > 0.0));
            (0..m).for_each(|k| h[(p + run * m + k, p + run * m + k)] += expected[k]);
        }
        let all = h.lu().solve(&g).unwrap();
        assert_close(x.as_slice(), &all.as_slice()[..p], 1e-6, 1e-7);
        for (k, run) in each.iter().enumerate() {
            assert_close(&run.own(&x), &all.as_slice()[p + k * m..][..m], 1e-6, 1e-7);
        }
        let yy: f64 = segments.iter().map(|part| part.gram[(p + m, p + m)]).sum();
        assert_close(&[normal.residual(&x)], &[yy - g.dot(&all)], 1e-6, 0.0);
    }

    #[test]
    fn only_the_selected_segments_count() {
        let estimate = estimate("prandtl-ishlinskii", 3);
        let layout = ColumnLayout::of(&estimate);
        let [one, other] = [segment(&layout, 0, Some(0), 1), segment(&layout, 0, Some(1), 2)];
        let (selected, _) = equations(&estimate, &[one.clone(), other], |part| part.fold == Some(0), &[]);
        let (alone, _) = equations(&estimate, &[one], |_| true, &[]);
        assert_eq!((selected.h, selected.g, selected.samples), (alone.h, alone.g, alone.samples));
    }

    #[test]
    fn own_coefficients_are_drawn_to_zero_by_what_is_expected_of_them() {
        let of = |a: f64, samples: f64, drifts: bool| {
            let lags = vec![Lag { tau_s: 0.02, gain: 0.0 }];
            let linear = Arx::new(5e-4, vec![a], vec![1.0]).unwrap();
            let estimate = Estimate { lags, ..estimate("prandtl-ishlinskii", 3).with_linear(linear) };
            // Creep, the state of G, the constant and the trend.
            let own = DMatrix::from_diagonal(&DVector::from_row_slice(&[5.0, 3.0, 8.0, 2.0]));
            expected(&estimate, &ColumnLayout::of(&estimate), &own, samples, drifts)
        };
        // A static gain of 2, ten independent errors, and 0.008 for the constant of a sample.
        let found = of(0.5, 1000.0, false);
        assert_close(found.as_slice(), &[0.0288, 0.3 * LN_2, 8e-10, 7.2e-3], 1e-5, 0.0);
        assert_close(&[of(0.5, 1000.0, true)[3]], &[7.2e-7 + 2e-10], 1e-5, 0.0);
        // A record of less than one independent error has one.
        let found = of(0.5, 50.0, false);
        assert_close(found.as_slice(), &[0.0576, 0.03 * LN_2, 8e-10, 0.0144], 1e-5, 0.0);
        // A state rings at most as long as the record.
        assert_close(&[of(0.9999, 1000.0, false)[1]], &[3e-4], 1e-5, 0.0);
    }
}
