//! The normal equations of the search against differences of the errors.

use super::*;
use crate::feedback::free_run::Whole;
use crate::feedback::weights::Weights;
use crate::fit::roughness;
use nalgebra::{DMatrix, DVector};
use piezoid_models::feedback::{FeedbackDynamics, FeedbackMode, FeedbackModel, Unknown};
use piezoid_models::hysteresis::{BasisDesign, Operator};
use piezoid_numerics::optimize::levenberg_marquardt::SumOfSquares;

const TS: f64 = 1e-3;

/// Two modes, whose displacement drives an operator of this name, with these weights and this shape.
fn model(operator: &str, shape: &[f64], weights: impl Fn(usize) -> f64) -> FeedbackModel {
    let mode = FeedbackMode { hz: 24.0, damping: 0.05, input: 1.3, hysteretic: 0.7, sensed: 1.0, softening: 1e-3 };
    let second = FeedbackMode { hz: 130.0, damping: 0.03, input: 0.2, hysteretic: 0.1, sensed: 0.8, softening: 2e-3 };
    let (modes, substeps) = (vec![mode, second], 4);
    let dynamics =
        FeedbackDynamics { substeps, modes, direct: [0.05, 0.02], offset: 0.4, ..FeedbackDynamics::default() };
    let (elements, frequencies) = (Some(24), vec![]);
    let design = BasisDesign { ts: TS / substeps as f64, range: (-9.0, 9.0), elements, frequencies };
    let basis = (Operator::find(operator).unwrap().basis)(&design).unwrap();
    let basis = if shape.is_empty() { basis } else { basis.reshaped(shape).unwrap() };
    let weights = (0..basis.len()).map(weights).collect();
    let model = FeedbackModel::weighted(TS, dynamics, basis.into(), weights).unwrap();
    model.with_unknown(Unknown { hysteresis: true, driver: false })
}

/// Records of these lengths, whose outputs are not those of the model.
fn records(lengths: &[usize]) -> Vec<Record> {
    let of = |(k, n): (usize, &usize)| {
        let u: Vec<f64> = (0..*n).map(|t| 4.0 * (0.21 * (t + 5 * k) as f64).sin() + (0.05 * t as f64).cos()).collect();
        let y = (0..*n).map(|t| 5.0 * (0.2 * (t + 5 * k) as f64).sin() - 0.3 * k as f64).collect();
        Record::new(TS, u, y).unwrap()
    };
    lengths.iter().enumerate().map(of).collect()
}

/// One record that begins with known states, one after known inputs and one in motion, of which six eighths count.
fn in_all_conditions<'r>(model: &FeedbackModel, records: &'r [Record]) -> Vec<Run<'r>> {
    let mut runs = runs(records, Counted::Most, |_| Initial::States(vec![[1.0, 0.2], [-0.3, 0.1]]));
    runs[1].initial = Initial::After(vec![0.5, 1.0, -2.0]);
    runs[2].initial = periodic(model, &records[2]);
    runs
}

/// The weighted errors of all records.
fn errors(problem: &FreeRun, x: &[f64]) -> DVector<f64> {
    let (model, runs) = problem.at(x).unwrap();
    let of = |run: &Run| {
        let whole = Whole::of(run, problem.gain);
        let y = model.follow_run(whole.run());
        (run.errors(&y[whole.inside]) * run.weight.sqrt()).as_slice().to_vec()
    };
    DVector::from(runs.iter().flat_map(of).collect::<Vec<_>>())
}

#[test]
fn the_normal_equations_are_the_derivatives_of_the_errors_in_each_initial_condition() {
    let model = model("bouc-wen", &[0.2, 0.1], |k| 0.3 + 0.4 * k as f64);
    let records = records(&[80, 64, 72, 40]);
    let runs = in_all_conditions(&model, &records);
    for gain in [0.0, 0.3] {
        let problem = FreeRun { gain, ..FreeRun::of(&model, &runs) };
        let x = problem.unknowns();
        assert_eq!(x.len(), model.parameters().len() + 8);
        assert_eq!(problem.lowest().len(), x.len());
        let normal = problem.normal(&x);
        let error = errors(&problem, &x);
        assert_close(&[normal.cost, problem.cost(&x)], &[error.norm_squared(); 2], 1e-12, 0.0);
        let slope = |k: usize| {
            let step = 1e-5 * x[k].abs().max(1e-2);
            let at = |by: f64| errors(&problem, &[&x[..k], &[x[k] + by], &x[k + 1..]].concat());
            (at(step) - at(-step)) / (2.0 * step)
        };
        let slopes = DMatrix::from_columns(&(0..x.len()).map(slope).collect::<Vec<_>>());
        let (gradient, hessian) = (slopes.transpose() * &error, slopes.transpose() * &slopes);
        let size = |k: usize| hessian[(k, k)].sqrt();
        for i in 0..x.len() {
            assert!(size(i) > 0.0, "{i}");
            assert_close(&[normal.gradient[i] / size(i)], &[gradient[i] / size(i)], 0.0, 1e-5 * error.norm());
            for j in 0..x.len() {
                let [found, expected] =
                    [normal.hessian[i * x.len() + j], hessian[(i, j)]].map(|h| h / (size(i) * size(j)));
                assert_close(&[found], &[expected], 0.0, 1e-5);
            }
        }
        // The standard errors from the inverse of the same matrix, the errors taken for white.
        let minimum =
            Minimum { x: x.clone(), cost: normal.cost, history: vec![], courses: vec![], reason: Reason::Iterations };
        let variance = error.norm_squared() / (256 - x.len()) as f64;
        let scaled = DMatrix::from_fn(x.len(), x.len(), |i, j| normal.hessian[i * x.len() + j] / (size(i) * size(j)));
        let inverse = scaled.try_inverse().unwrap();
        let expected = |k: usize| (inverse[(k, k)] * variance).sqrt() / size(k);
        let expected: Vec<f64> = (0..model.parameters().len()).map(expected).collect();
        assert_close(&problem.errors(&minimum), &expected, 1e-3, 0.0);
    }
}

/// 300 weights and 2100 samples: more than are multiplied at once.
#[test]
fn weights_with_derivatives_that_are_kept_add_only_their_penalty() {
    let model = model("preisach", &[], |k| 0.01 + 0.02 * f64::from(k as u32 % 7));
    let (basis, w) = model.weights().unwrap();
    let records = records(&[2100, 300, 200]);
    let runs = in_all_conditions(&model, &records);
    let runs = &runs[1..];
    let free_run = FreeRun::of(&model, runs);
    let weights = Weights::at_start(&free_run, &*basis).unwrap();
    let x = free_run.unknowns();
    let (d, n) = (x.len(), basis.len());
    let followed = d - n;
    let plain = free_run.normal(&x);
    let with = FreeRun { weights: Some(&weights), ..free_run };
    let found = with.normal(&x);
    let trace: f64 = (followed..d).map(|k| plain.hessian[k * d + k]).sum();
    let penalty = roughness(&*basis) * (1e-2 * trace / n as f64);
    let pull = &penalty * DVector::from(w.clone());
    let cost = plain.cost + pull.dot(&DVector::from(w));
    assert_close(&[found.cost, with.cost(&x)], &[cost; 2], 1e-6, 0.0);
    let size = |k: usize| plain.hessian[k * d + k].sqrt().max(1e-9);
    for i in 0..d {
        let own = if i < followed { 0.0 } else { pull[i - followed] };
        let [f, p] = [found.gradient[i], plain.gradient[i] + own].map(|g| g / size(i));
        assert_close(&[f], &[p], 1e-5, 1e-6 * plain.cost.sqrt());
        for j in 0..d {
            let own = if i.min(j) < followed { 0.0 } else { penalty[(i - followed, j - followed)] };
            let [f, p] = [found.hessian[i * d + j], plain.hessian[i * d + j] + own].map(|h| h / (size(i) * size(j)));
            assert_close(&[f], &[p], 1e-5, 1e-6);
        }
    }
}

#[test]
fn records_have_weights_starts_and_errors_by_their_sizes() {
    let model = model("bouc-wen", &[0.2, 0.1], |_| 0.5);
    let of = |y: &[f64]| Record::new(TS, vec![0.0; y.len()], y.to_vec()).unwrap();
    let records = [of(&[2.0, 5.0, 1.0, 3.0]), of(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 3.0])];
    assert_close(&records.each_ref().map(peak_to_peak), &[4.0, 3.0], 0.0, 0.0);
    assert_close(&[peak_to_peak(&of(&[2.0, 2.0]))], &[1.0], 0.0, 0.0);
    let runs = runs(&records, Counted::Most, |record| states(&model, record));
    let weights: Vec<f64> = runs.iter().map(|run| run.weight).collect();
    assert_close(&weights, &[1.0 / (16.36 * 2.0), 1.0 / (9.36 * 3.0)], 1e-12, 0.0);
    assert_eq!(runs[0].initial, Initial::States(vec![[2.0 - 0.4, 0.0], [0.0, 0.0]]));
    // 12 time constants of the first mode, of 0.05 2 pi 24 Hz, in periods of a tenth of a second.
    // 12 time constants of the first mode are 1.6 s; more than ten periods are never before a record.
    let before = [40, 100, 1000].map(|n| periodic(&model, &of(&vec![0.0; n])));
    assert_eq!(before, [10, 10, 2].map(Initial::Periodic));
    let counts: Vec<bool> = Counted::Most.of(16).collect();
    let left: Vec<usize> = (0..16).filter(|t| !counts[*t]).collect();
    assert_eq!(left, [4, 5, 10, 11]);
    let at_rest = Run { initial: Initial::States(vec![[0.0; 2]; 2]), counted: Counted::All, ..runs[0].clone() };
    let output = model.follow_run(Whole::of(&at_rest, 0.0).run());
    let mean = output.iter().zip(records[0].y()).map(|(m, y)| (m - y).powi(2)).sum::<f64>() / 4.0;
    assert_close(&[square(&model, &at_rest)], &[mean], 1e-12, 0.0);
}
