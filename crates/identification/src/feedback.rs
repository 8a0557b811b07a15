//! Hysteresis in feedback: all parameters of a feedback model by its free-run error, with exact derivatives.
//!
//! ```text
//! min sum over records of |y - model|^2 / (peak-to-peak of y)^2
//! ```
//! Unknowns are the parameters of the model, and the state of the modes at the start of each record, unless the record
//! is one period of a longer one. An oscillator is found from its records alone: first without hysteresis, then from
//! several starts with it, of which the best goes on to the minimum.
//!
//! Reference: L. Ljung, System Identification (1999), section 10.2 (output error, Gauss-Newton).

use crate::fit::FittedParameter;
use nalgebra::{DMatrix, DVector};
use piezoid_models::feedback::{FeedbackDynamics, FeedbackMode, FeedbackModel, FeedbackParameter, Intersample};
use piezoid_models::hysteresis::{BasisDesign, Operator};
use piezoid_models::linear::{Orders, OutputError, Refinement};
use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::levenberg_marquardt::{NormalEquations, SearchSettings, SumOfSquares, minimise};
use piezoid_numerics::optimize::{Minimum, Reason};
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_numerics::series::ends;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use rayon::prelude::*;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::Range;

/// Steps of the search from each start, and from the best one.
const FIRST_STEPS: usize = 8;
const MOST_STEPS: usize = 100;

/// Relative decrease of the sum of squares, predicted for another step, below which the search ends.
const TOLERANCE: f64 = 1e-9;

/// Starts: the stiffness of the hysteresis over that of the mode, and its bend over the range.
const STARTS: [(f64, f64); 4] = [(0.3, 0.3), (0.3, 2.0), (1.0, 0.3), (1.0, 2.0)];

/// Periods of the slowest mode in a window, and the largest number of windows.
const WINDOW: f64 = 10.0;
const MAX_WINDOWS: usize = 64;

/// Time constants of a mode that are simulated before a record in motion: what is left is 1e-5. And the largest number
/// of periods.
const REMEMBERED: f64 = 12.0;
const MAX_PERIODS: usize = 10;

/// Its name in progress and errors.
const STAGE: &str = "hysteresis in feedback";

/// The initial condition of a record.
#[derive(Debug, Clone, PartialEq)]
enum Initial {
    /// Unknown: p and step times p' of each mode at its start. The hysteresis was at rest.
    States(Vec<[f64; 2]>),
    /// In motion: the record came before it too, this number of times.
    Periodic(usize),
}

/// A record with what its free run needs.
#[derive(Debug, Clone)]
struct Run<'a> {
    record: Cow<'a, Record>,
    initial: Initial,
    /// Weight of its squared errors: 1 / (peak-to-peak of y)^2.
    weight: f64,
}

/// A fitted feedback model.
#[derive(Debug, Clone)]
pub struct FeedbackFit {
    /// The model.
    pub model: FeedbackModel,
    /// Its parameters, with standard errors for white residuals; infinite for one without effect.
    pub parameters: Vec<FittedParameter>,
    /// The rms error of the free run along each record [output unit].
    pub rms: Vec<f64>,
    /// For each record, true if it is taken for one period of a longer one.
    pub periodic: Vec<bool>,
    /// How the search ended.
    pub minimum: Minimum,
}

impl FeedbackFit {
    /// An oscillator (one mode driven by the input) with Bouc-Wen hysteresis that its displacement drives.
    ///
    /// ```
    /// use piezoid::feedback::{FeedbackFit, Intersample};
    /// use piezoid::{PrepareOptions, Record, excitation::Multisine, plant::Plant, progress::Stage};
    /// let ts = 1.0 / 15_000.0;
    /// let drive = Multisine { amplitude: 100.0, frequency_low: 5.0, frequency_high: 150.0, ..Multisine::default() };
    /// let u = drive.samples(ts, 20_480)?;
    /// let y = Plant::named("bouc-wen-benchmark", ts)?.run(&u).y;
    /// let slower = PrepareOptions { decimate: Some(20), ..PrepareOptions::default() };
    /// let record = slower.run(&Record::new(ts, u, y)?)?;
    /// let fit = FeedbackFit::oscillator(&[record], Intersample::BandLimited, &mut Stage::ignore)?;
    /// assert!((fit.model.dynamics().modes[0].hz - 25.2).abs() < 1.0);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error if the records show no resonance, or have different sampling periods; [`Error::Cancelled`].
    pub fn oscillator(records: &[Record], between: Intersample, progress: &mut Progress) -> Result<Self, Error> {
        let linear = linear(records, between, progress)?;
        let FeedbackDynamics { ref modes, offset, .. } = *linear.model.dynamics();
        let mode = modes[0];
        let half = records.iter().flat_map(Record::y).fold(0.0f64, |half, y| half.max((y - offset).abs()));
        let runs: Vec<Run> = records.iter().zip(&linear.initial).map(|(r, initial)| run(r, initial.clone())).collect();
        let mut first = |(stiffness, bend): (f64, f64)| {
            let softer = (1.0 + stiffness).sqrt();
            // Together they have the frequency and the gain without hysteresis.
            let (hz, damping, input) = (mode.hz / softer, mode.damping * softer, mode.input * (1.0 + stiffness));
            let mode = FeedbackMode { hz, damping, input, hysteretic: 1.0, sensed: 1.0, softening: 0.0 };
            let dynamics = FeedbackDynamics { modes: vec![mode], ..linear.model.dynamics().clone() };
            let start = oscillator(linear.model.ts(), dynamics, (stiffness, bend / half), half)?;
            search(&start, &runs, FIRST_STEPS, progress)
        };
        let best = best(STARTS.map(&mut first).into_iter())?;
        FeedbackFit::from(&best.model, records, progress)
    }

    /// The fit of all parameters of `start`.
    ///
    /// # Errors
    /// Returns an error if there is no record, the operator has no derivatives, the records have another sampling
    /// period, or the free run from the start is not finite; [`Error::Cancelled`].
    pub fn from(start: &FeedbackModel, records: &[Record], progress: &mut Progress) -> Result<Self, Error> {
        let [first, ..] = records else {
            let because = "there is no record".into();
            return Err(Error::Unidentifiable { what: STAGE.into(), because });
        };
        start.sensitivities(&[], &first.u()[..first.len().min(1)])?;
        for record in records {
            Record::same_sampling("the record", record.ts(), "the model", start.ts())?;
        }
        let start = &windowed(start, records, progress)?;
        let mut first = |of: fn(&FeedbackModel, &Record) -> Initial| {
            let runs: Vec<Run> = records.iter().map(|record| run(record, of(start, record))).collect();
            search(start, &runs, FIRST_STEPS, progress)
        };
        let Found { model, initial, .. } = best([first(states), first(periodic)].into_iter())?;
        let likelier = |(record, initial): (_, Initial)| run(record, likelier(&model, initial, record));
        let runs: Vec<Run> = records.iter().zip(initial).map(likelier).collect();
        let Found { model, initial, minimum } = search(&model, &runs, MOST_STEPS, progress)?;
        let rms = runs.iter().zip(&initial).map(|(run, initial)| square(&model, initial, &run.record).sqrt()).collect();
        let errors = FreeRun { start: &model, runs: &runs }.errors(&minimum);
        let of = |(p, error): (FeedbackParameter, f64)| FittedParameter { name: p.name, value: p.value, error };
        let parameters = model.parameters().into_iter().zip(errors).map(of).collect();
        let periodic = initial.iter().map(|initial| matches!(initial, Initial::Periodic(_))).collect();
        Ok(FeedbackFit { parameters, rms, periodic, model, minimum })
    }
}

/// The end of one search.
struct Found {
    model: FeedbackModel,
    initial: Vec<Initial>,
    minimum: Minimum,
}

/// Searches from `start` for at most so many `steps`.
fn search(start: &FeedbackModel, runs: &[Run], steps: usize, progress: &mut Progress) -> Result<Found, Error> {
    let problem = FreeRun { start, runs };
    let mut x: Vec<f64> = start.parameters().iter().map(|p| p.value).collect();
    for run in runs {
        let Initial::States(modes) = &run.initial else { continue };
        x.extend(modes.as_flattened());
    }
    let settings = SearchSettings { iterations: steps, tolerance: TOLERANCE, ..SearchSettings::default() };
    let named = &mut |stage: Stage| progress(Stage { what: STAGE, ..stage });
    let minimum = minimise(&problem, &x, &settings, named)?;
    if minimum.reason == Reason::Cancelled {
        return Err(Error::Cancelled { what: STAGE.into(), done: minimum.history.len() - 1, total: steps });
    }
    let (model, initial) = problem.at(&minimum.x)?;
    Ok(Found { model, initial, minimum })
}

/// The search with the lowest cost; the first error if there is none, or if one was cancelled.
fn best(searches: impl Iterator<Item = Result<Found, Error>>) -> Result<Found, Error> {
    let better = |best: Result<Found, Error>, next: Result<Found, Error>| match (best, next) {
        (Err(cancelled @ Error::Cancelled { .. }), _) | (_, Err(cancelled @ Error::Cancelled { .. })) => Err(cancelled),
        (Ok(best), Ok(next)) if next.minimum.cost < best.minimum.cost => Ok(next),
        (Err(_), Ok(next)) => Ok(next),
        (best, _) => best,
    };
    let none = || Err(Error::Unidentifiable { what: STAGE.into(), because: "there is no start".into() });
    searches.reduce(better).unwrap_or_else(none)
}

fn run<'a>(record: &'a Record, initial: Initial) -> Run<'a> {
    let (low, high) = ends(record.y().iter().copied());
    let weight = if low < high { (high - low).powi(-2) } else { 1.0 };
    Run { record: Cow::Borrowed(record), initial, weight }
}

/// The fit of `start` in windows with states of their own: a frequency that is far off then has no other minimum. What
/// the hysteresis remembers at the start of a window is missing.
fn windowed(start: &FeedbackModel, records: &[Record], progress: &mut Progress) -> Result<FeedbackModel, Error> {
    let slowest = start.dynamics().modes.iter().map(|mode| mode.hz).fold(f64::INFINITY, f64::min);
    let all: usize = records.iter().map(Record::len).sum();
    let samples = ((WINDOW / slowest / start.ts()).ceil() as usize).max(all.div_ceil(MAX_WINDOWS));
    let mut windows = Vec::new();
    for record in records {
        for (u, y) in record.u().chunks(samples).zip(record.y().chunks(samples)).filter(|(u, _)| u.len() == samples) {
            let window = record.with_samples(record.ts(), u.to_vec(), y.to_vec())?;
            let initial = states(start, &window);
            windows.push(Run { record: Cow::Owned(window), ..run(record, initial) });
        }
    }
    Ok(search(start, &windows, FIRST_STEPS, progress)?.model)
}

/// An oscillator with Bouc-Wen hysteresis of this stiffness and beta, for displacements of +-`half`.
fn oscillator(
    ts: f64,
    dynamics: FeedbackDynamics,
    (stiffness, beta): (f64, f64),
    half: f64,
) -> Result<FeedbackModel, Error> {
    let ts_of_step = ts / dynamics.substeps as f64;
    let design = BasisDesign { ts: ts_of_step, range: (-half, half), elements: None, frequencies: vec![] };
    let basis = (Operator::find("bouc-wen")?.basis)(&design)?.reshaped(&[beta, 0.0])?;
    FeedbackModel::weighted(ts, dynamics, basis.into(), vec![0.0, stiffness])
}

/// The mode without hysteresis: from an output-error block of second order.
fn linear(records: &[Record], between: Intersample, progress: &mut Progress) -> Result<Found, Error> {
    let block = OutputError::fit(records, Orders::of(2), &Refinement::default(), progress)?.arx;
    let Some(pole) = block.resonance() else {
        let because = "no resonance shows in the records: excite it".into();
        return Err(Error::Unidentifiable { what: "an oscillator".into(), because });
    };
    let (hz, damping, input) = (pole.hz, pole.damping.max(1e-3), block.dc_gain());
    let mode = FeedbackMode { hz, damping, input, hysteretic: 1.0, sensed: 1.0, softening: 0.0 };
    let dynamics =
        FeedbackDynamics { intersample: between, modes: vec![mode], sensed: 0.0, ..FeedbackDynamics::default() };
    let start = oscillator(block.ts(), dynamics, (0.0, 1.0), 1.0)?;
    let runs: Vec<Run> = records.iter().map(|record| run(record, states(&start, record))).collect();
    search(&start, &runs, FIRST_STEPS, progress)
}

/// The first mode alone is at the first sample.
fn states(model: &FeedbackModel, record: &Record) -> Initial {
    let mut modes = model.at_rest();
    if let (Some(first), Some(y)) = (modes.first_mut(), record.y().first()) {
        first[0] = y - model.dynamics().offset;
    }
    Initial::States(modes)
}

/// Whole periods, as far as the modes remember.
fn periodic(model: &FeedbackModel, record: &Record) -> Initial {
    let slowest =
        model.dynamics().modes.iter().map(|mode| mode.damping.min(1.0) * TAU * mode.hz).fold(f64::INFINITY, f64::min);
    let remembered = REMEMBERED / slowest / (record.ts() * record.len() as f64);
    Initial::Periodic((remembered.ceil() as usize).clamp(1, MAX_PERIODS))
}

/// The initial condition with which the free run of the model is nearest to the record: this one, at its first sample,
/// or periodic.
fn likelier(model: &FeedbackModel, initial: Initial, record: &Record) -> Initial {
    let square = |initial: &Initial| square(model, initial, record);
    let others = [states(model, record), periodic(model, record)].into_iter();
    others.fold(initial, |best, one| if square(&one) < square(&best) { one } else { best })
}

/// What a free run along a record needs.
struct Whole<'a> {
    /// The input with what was before the record, and after it as far as the interpolation needs.
    u: Cow<'a, [f64]>,
    /// The samples that count.
    inside: Range<usize>,
    /// The modes at the start; empty at rest.
    start: &'a [[f64; 2]],
}

impl<'a> Whole<'a> {
    fn of(initial: &'a Initial, record: &'a Record) -> Self {
        let u = record.u();
        match initial {
            Initial::States(modes) => Whole { u: u.into(), inside: 0..u.len(), start: modes },
            Initial::Periodic(n) => {
                let after = &u[..u.len().min(Intersample::REACH)];
                let all = [&u.repeat(n + 1), after].concat();
                Whole { u: all.into(), inside: n * u.len()..(n + 1) * u.len(), start: &[] }
            }
        }
    }
}

/// The mean squared error of the free run.
fn square(model: &FeedbackModel, initial: &Initial, record: &Record) -> f64 {
    let Whole { u, inside, start } = Whole::of(initial, record);
    let run = model.simulate_from(start, &u);
    let squares = record.y().iter().zip(&run[inside]).map(|(y, m)| (y - m).powi(2));
    squares.sum::<f64>() / record.len() as f64
}

/// The weighted free-run errors.
struct FreeRun<'a> {
    start: &'a FeedbackModel,
    runs: &'a [Run<'a>],
}

impl FreeRun<'_> {
    /// The model and the initial conditions of the records.
    fn at(&self, x: &[f64]) -> Result<(FeedbackModel, Vec<Initial>), Error> {
        let (parameters, states) = x.split_at(self.start.parameters().len());
        let mut states = states.chunks_exact(2).map(|pair| [pair[0], pair[1]]);
        let of = |run: &Run| match &run.initial {
            Initial::States(modes) => Initial::States(states.by_ref().take(modes.len()).collect()),
            periodic => periodic.clone(),
        };
        Ok((self.start.with_parameters(parameters)?, self.runs.iter().map(of).collect()))
    }

    /// Standard errors of the parameters of the model.
    fn errors(&self, minimum: &Minimum) -> Vec<f64> {
        let (normal, d) = (self.normal(&minimum.x), minimum.x.len());
        let samples: usize = self.runs.iter().map(|run| run.record.len()).sum();
        let variance = normal.cost / samples.saturating_sub(d).max(1) as f64;
        let size = |k: usize| normal.hessian[k * d + k].sqrt();
        let shown: Vec<usize> = (0..d).filter(|k| size(*k) > 0.0).collect();
        let of = |i: usize, j: usize| normal.hessian[shown[i] * d + shown[j]] / (size(shown[i]) * size(shown[j]));
        let inverse = DMatrix::from_fn(shown.len(), shown.len(), of).try_inverse();
        let error = |k: usize| {
            let place = shown.iter().position(|shown| *shown == k)?;
            Some((inverse.as_ref()?[(place, place)] * variance).sqrt() / size(k)).filter(|error| error.is_finite())
        };
        (0..self.start.parameters().len()).map(|k| error(k).unwrap_or(f64::INFINITY)).collect()
    }
}

impl SumOfSquares for FreeRun<'_> {
    fn dimension(&self) -> usize {
        let of = |run: &Run| if let Initial::States(modes) = &run.initial { 2 * modes.len() } else { 0 };
        self.start.parameters().len() + self.runs.iter().map(of).sum::<usize>()
    }

    fn cost(&self, x: &[f64]) -> f64 {
        let Ok((model, initial)) = self.at(x) else { return f64::INFINITY };
        let of = |(run, initial): (&Run, &Initial)| {
            run.weight * run.record.len() as f64 * square(&model, initial, &run.record)
        };
        let each: Vec<f64> = self.runs.par_iter().zip(&initial).map(of).collect();
        each.iter().sum()
    }

    fn normal(&self, x: &[f64]) -> NormalEquations {
        let (d, parameters) = (self.dimension(), self.start.parameters().len());
        let mut sums = NormalEquations::empty(d);
        let failed = NormalEquations { cost: f64::INFINITY, ..sums.clone() };
        let Ok((model, initial)) = self.at(x) else { return failed };
        let mut own = parameters;
        for (run, initial) in self.runs.iter().zip(&initial) {
            let Whole { u, inside, start } = Whole::of(initial, &run.record);
            let Ok((y, slopes)) = model.sensitivities(start, &u) else { return failed };
            let errors = y[inside.clone()].iter().zip(run.record.y()).map(|(m, y)| m - y);
            let error = DVector::from_iterator(inside.len(), errors);
            let columns: Vec<_> =
                slopes.iter().map(|slope| DVector::from_column_slice(&slope[inside.clone()])).collect();
            let place = |j: usize| if j < parameters { j } else { j - parameters + own };
            sums.cost += run.weight * error.norm_squared();
            for (i, column) in columns.iter().enumerate() {
                sums.gradient[place(i)] += run.weight * column.dot(&error);
                for (j, other) in columns.iter().enumerate() {
                    sums.hessian[place(i) * d + place(j)] += run.weight * column.dot(other);
                }
            }
            own += columns.len() - parameters;
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::PrepareOptions;
    use piezoid::excitation::Multisine;
    use piezoid::plant::Plant;
    use piezoid_models::linear::Arx;
    use piezoid_testing::assert_close;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};
    use std::ops::ControlFlow;

    /// The rate of the benchmark, and that at which it is integrated.
    const FS: f64 = 750.0;
    const FASTER: usize = 20;

    /// Samples of a period.
    const N: usize = 2048;

    /// The benchmark's record along two periods of a multisine, without its first `skip` samples, with noise of this
    /// rms [um].
    fn benchmark(seed: u32, skip: usize, noise: f64) -> Record {
        let ts = 1.0 / (FS * FASTER as f64);
        let (period, amplitude) = (N as f64 / FS, 100.0);
        let multisine =
            Multisine { amplitude, frequency_low: 5.0, frequency_high: 150.0, period, seed, ..Multisine::default() };
        let u = multisine.samples(ts, 2 * N * FASTER).unwrap();
        let y = Plant::named("bouc-wen-benchmark", ts).unwrap().run(&u).y;
        let options = PrepareOptions { decimate: Some(FASTER), ..PrepareOptions::default() };
        let record = options.run(&Record::new(ts, u, y).unwrap()).unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let noise = Normal::new(0.0, noise).unwrap();
        let y = record.y()[skip..].iter().map(|y| y + noise.sample(&mut random)).collect();
        Record::new(1.0 / FS, record.u()[skip..].to_vec(), y).unwrap()
    }

    fn training() -> (FeedbackFit, [Record; 1]) {
        let records = [benchmark(1, N, 8.0)];
        (FeedbackFit::oscillator(&records, Intersample::BandLimited, &mut Stage::ignore).unwrap(), records)
    }

    #[test]
    fn the_benchmark_is_found_from_a_noisy_period() {
        let (fit, _) = training();
        assert_eq!(fit.periodic, [true]);
        assert_close(&fit.rms, &[8.0], 0.02, 0.0);
        // Newmark's step of 1/15000 s lowers the frequency by 2e-5, far less than its error.
        let known = [2.5e4f64.sqrt() / TAU, 10.0 / (4.0 * 2.5e4f64.sqrt()), 20.0, 0.0, 1.0, 8e-4, -1.375];
        assert_eq!(fit.parameters.len(), known.len());
        for (FittedParameter { name, value, error }, known) in fit.parameters.iter().zip(known) {
            let most = if known == 0.0 { 0.4 } else { 0.0 };
            let is_known = (value - known).abs() < 4.0 * error && *error < f64::max(0.02 * known.abs(), most);
            assert!(is_known, "{name}: {value} +- {error}, not {known}");
        }
        // A free run from rest, without noise [um]; black boxes leave 7.5 um.
        let test = benchmark(2, 0, 0.0);
        let run = fit.model.simulate_from(&[], test.u());
        let second_period: f64 = test.y()[N..].iter().zip(&run[N..]).map(|(y, m)| (y - m).powi(2)).sum();
        let rms = (second_period / N as f64).sqrt();
        assert!(rms < 1.0, "{rms}");
    }

    #[test]
    fn a_start_that_is_thirty_percent_off_ends_at_the_same_minimum() {
        let (fit, records) = training();
        let off = |(k, p): (usize, FeedbackParameter)| p.value * if k % 2 == 0 { 1.3 } else { 0.7 };
        let x: Vec<f64> = fit.model.parameters().into_iter().enumerate().map(off).collect();
        let start = fit.model.with_parameters(&x).unwrap();
        let again = FeedbackFit::from(&start, &records, &mut Stage::ignore).unwrap();
        assert_close(&again.rms, &fit.rms, 1e-6, 0.0);
    }

    #[test]
    fn a_record_without_a_resonance_is_an_error_and_a_cancelled_search_says_so() {
        let u: Vec<f64> = (0..400).map(|t| f64::from(t * t % 13) - 6.0).collect();
        let y = Arx::new(1e-3, vec![0.8], vec![0.3]).unwrap().simulate(&u);
        let y = y.iter().zip(u.iter().rev()).map(|(y, noise)| y + 0.01 * noise).collect();
        let record = Record::new(1e-3, u, y).unwrap();
        let refused = |records: &[Record]| {
            FeedbackFit::oscillator(records, Intersample::Held, &mut Stage::ignore).unwrap_err().to_string()
        };
        assert!(refused(&[record]).contains("no resonance shows"));
        assert!(!refused(&[]).is_empty());
        let records = [benchmark(1, N, 8.0)];
        let mut cancelled = |stage: Stage| match stage.what {
            STAGE => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let error = FeedbackFit::oscillator(&records, Intersample::BandLimited, &mut cancelled).unwrap_err();
        assert!(error.to_string().contains("hysteresis in feedback"), "{error}");
    }
}
