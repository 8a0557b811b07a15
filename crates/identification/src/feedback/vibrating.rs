//! Hysteresis first and mechanics after, in which the vibration drives the hysteresis too, a mode softens and the
//! sensor is curved: from the blocks in series, whose optimum is the start.

use super::free_run::{Counted, FreeRun, Initial, Run, Whole, peak_to_peak, runs};
use super::oscillator::kinds;
use super::weights::Weights;
use super::{FeedbackFit, Found, STAGE, search};
use crate::fit::roughness;
use nalgebra::{DMatrix, DVector};
use piezoid_models::creep::Lag;
use piezoid_models::driver::DriverModel;
use piezoid_models::feedback::{FeedbackDynamics, FeedbackMode, FeedbackModel, Intersample, Unknown};
use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_models::hysteresis::{Basis, BasisDesign, Operator};
use piezoid_models::linear::PoleShare;
use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::non_negative;
use piezoid_numerics::progress::Progress;
use piezoid_numerics::series::{ends, scatter};
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use std::sync::Arc;

/// Steps of the integration in a sample.
const SUBSTEPS: usize = 8;

/// Gains of the observer, one after the other, until the loop is nearly known. From the start of another gain the
/// search ends in other minima.
const GAINS: [f64; 3] = [0.5, 0.2, 0.05];

/// Steps of the searches: of each start, of the dynamics with each gain, and of all parameters.
const START_STEPS: usize = 5;
const GAIN_STEPS: usize = 8;
const ALL_STEPS: usize = 4;

/// Static shares at the start: of the second mode, in that of the first, and of what follows z directly. Damping of the
/// second mode, and least damping of the first.
const SECOND: f64 = 0.08;
const DIRECT: f64 = 0.03;
const DAMPING: f64 = 0.03;
const LEAST_DAMPING: f64 = 1e-3;

/// Least share of a pole that is a second mode. If there is none: its frequency over that of the first, of which one is
/// that of a cantilever.
const LEAST_SHARE: f64 = 0.02;
const SECONDS: [f64; 3] = [2.5, 4.0, 6.27];

/// The sum of squares with a second mode, over that without, from which it is taken.
const SECOND_WORTH: f64 = 0.9;

/// Creep: periods of the first mode in its shortest time constant, the longest [s], and lags in a decade.
const SHORTEST_LAG: f64 = 8.0;
const LONGEST_LAG: f64 = 5.0;
const LAGS_IN_DECADE: f64 = 2.0;
const LAG_GAIN: f64 = 0.005;

/// What is to be found from nothing begins at this share of what would matter.
const NEARLY_NONE: f64 = 1e-6;

/// Share by which the vibration takes the input of the hysteresis beyond the range of the input, on either side, and
/// rows of the operator's levels.
const BEYOND: f64 = 0.15;
const ROWS: usize = 36;

/// Most samples: their derivatives by all weights are in memory.
const MOST_SAMPLES: usize = 300_000;

/// Samples to which the operator is fitted at the start, and the factor of its roughness.
const OPERATOR_SAMPLES: usize = 6000;
const SMOOTHNESS: f64 = 1e-4;
const REGULAR: f64 = 1e-9;

/// Most rounds of searches of all parameters, and the relative decrease of the sum of squares from which another
/// follows.
const ROUNDS: usize = 6;
const WORTHWHILE: f64 = 0.03;

impl FeedbackFit {
    /// Hysteresis first and mechanics after, in which the vibration drives the hysteresis too, the first mode softens
    /// and the sensor is curved. The search begins with the `blocks` in series; the input is of the likeliest of these
    /// kinds.
    ///
    /// # Errors
    /// Returns an error if the blocks have no resonance, or the records more than 300 000 samples, or another sampling
    /// period than the blocks; [`Error::Cancelled`].
    pub fn vibrating(
        blocks: &Model,
        records: &[Record],
        inputs: &[Intersample],
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        FeedbackFit::vibrating_of(blocks, (records, Counted::All), inputs, progress)
    }

    /// The same of the samples that count.
    pub(super) fn vibrating_of(
        blocks: &Model,
        (records, counted): (&[Record], Counted),
        inputs: &[Intersample],
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        for record in records {
            Record::same_sampling("the record", record.ts(), "the model", blocks.ts())?;
        }
        let samples: usize = records.iter().map(Record::len).sum();
        if samples > MOST_SAMPLES {
            let because = format!("the records have {samples} samples, more than {MOST_SAMPLES}: decimate them");
            return Err(Error::Unidentifiable { what: STAGE.into(), because });
        }
        let (dynamics, seconds) = modes(blocks, records)?;
        let runs = runs(records, counted, |record| Initial::After(before(blocks, record)));
        let (ts, unknown_driver) = (blocks.ts(), has_unknown_driver(inputs));
        let mut search =
            Search { runs: &runs, operator: operator(ts, &paths(blocks, records))?, ts, unknown_driver, progress };
        let some_lag = unknown_driver.then(|| DriverModel::new(ts, None).map(Intersample::Driven)).transpose()?;
        let inputs: Vec<Intersample> = inputs.iter().copied().chain(some_lag).collect();
        let of_kind = |(intersample, delay)| FeedbackDynamics { intersample, delay, ..dynamics.clone() };
        let (one, _) = search.best(kinds(&inputs).map(of_kind).collect(), GAINS[0], START_STEPS)?;
        // As many steps again without a second mode: a fair comparison.
        let two = seconds.iter().map(|hz| with_second(one.clone(), *hz)).collect();
        let (one, cost) = search.best(vec![one], GAINS[0], START_STEPS)?;
        let (two, with_two) = search.best(two, GAINS[0], START_STEPS)?;
        let mut found = if with_two < SECOND_WORTH * cost { two } else { one };
        for gain in GAINS {
            found = search.best(vec![found], gain, GAIN_STEPS)?.0;
        }
        let [.., gain] = GAINS;
        // The image of the second mode shows when the hysteresis is known.
        let second = found.modes.get(1).map(|mode| mode.hz);
        let images = second.map_or(vec![], |hz| images_of(hz, ts).to_vec()).into_iter();
        let others = images.filter(|hz| second.is_some_and(|second| (hz - second).abs() > 1e-3 * second));
        let others = others.map(|hz| with_second(found.clone(), hz));
        let (by_vibration, _) = search.all(std::iter::once(found.clone()).chain(others).collect(), gain)?;
        let operator = search.operator.clone();
        let found = match search.by_displacement(&by_vibration, gain) {
            Ok(found) if found.minimum.cost < by_vibration.minimum.cost => found,
            Err(cancelled @ Error::Cancelled { .. }) => return Err(cancelled),
            _ => {
                search.operator = operator;
                by_vibration
            }
        };
        search.search_to_minimum(found.model.dynamics().clone())
    }

    /// The same fit to other records of the same actuator, which begins with what was found from the first.
    ///
    /// # Errors
    /// Returns an error if the weights of the model are unknown; [`Error::Cancelled`].
    pub(super) fn vibrating_from(
        found: &FeedbackModel,
        blocks: &Model,
        records: &[Record],
        inputs: &[Intersample],
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        let unknown = || Error::Unidentifiable { what: STAGE.into(), because: "its weights are unknown".into() };
        let operator = found.weights().ok_or_else(unknown)?;
        let runs = runs(records, Counted::All, |record| Initial::After(before(blocks, record)));
        let unknown_driver = has_unknown_driver(inputs);
        let mut search = Search { runs: &runs, operator, ts: blocks.ts(), unknown_driver, progress };
        search.search_to_minimum(found.dynamics().clone())
    }
}

/// True if no driver is known: a lag in front of the hysteresis is then tried too.
fn has_unknown_driver(inputs: &[Intersample]) -> bool {
    !inputs.iter().any(|input| matches!(input, Intersample::Driven(_)))
}

/// An operator: its basis and its weights.
type WeightedOperator = (Arc<dyn Basis>, Vec<f64>);

/// The searches along the same records.
struct Search<'r, 'p> {
    runs: &'r [Run<'r>],
    /// The operator and its weights.
    operator: WeightedOperator,
    ts: f64,
    unknown_driver: bool,
    progress: &'r mut Progress<'p>,
}

impl<'r> Search<'r, '_> {
    fn model(&self, dynamics: FeedbackDynamics, hysteresis: bool) -> Result<FeedbackModel, Error> {
        let (basis, weights) = &self.operator;
        let model = FeedbackModel::weighted(self.ts, dynamics, basis.clone(), weights.clone())?;
        Ok(model.with_unknown(Unknown { hysteresis, driver: self.unknown_driver }))
    }

    /// The dynamics that come nearest to the records from these starts, and their cost; the hysteresis is known.
    fn best(
        &mut self,
        starts: Vec<FeedbackDynamics>,
        gain: f64,
        steps: usize,
    ) -> Result<(FeedbackDynamics, f64), Error> {
        let models: Vec<_> = starts.into_iter().map(|dynamics| self.model(dynamics, false)).collect();
        let mut from = |model: Result<FeedbackModel, Error>| {
            let model = model?;
            search(&FreeRun { gain, ..FreeRun::of(&model, self.runs) }, steps, self.progress)
        };
        let found = super::best(models.into_iter().map(&mut from))?;
        Ok((found.model.dynamics().clone(), found.minimum.cost))
    }

    /// All parameters from the best of these starts, with weights that the operator then has, and the derivatives by
    /// the weights, which are those at the first start.
    fn all(&mut self, starts: Vec<FeedbackDynamics>, gain: f64) -> Result<(Found<'r>, Weights), Error> {
        let least = NEARLY_NONE * self.operator.1.iter().fold(0.0f64, |most, weight| most.max(*weight));
        self.operator.1.iter_mut().for_each(|weight| *weight = weight.max(least));
        // What is 0 would stay.
        let creep = |lag: &Lag| Lag { gain: lag.gain.max(NEARLY_NONE), ..*lag };
        let nearly = |dynamics: FeedbackDynamics| FeedbackDynamics {
            creep: dynamics.creep.iter().map(creep).collect(),
            ..dynamics
        };
        let models: Vec<_> =
            starts.into_iter().map(|dynamics| self.model(nearly(dynamics), true)).collect::<Result<_, _>>()?;
        let free_run = |model| FreeRun { gain, ..FreeRun::of(model, self.runs) };
        let weights = Weights::at_start(&free_run(&models[0]), &*self.operator.0)?;
        let problem = |model| FreeRun { weights: Some(&weights), ..free_run(model) };
        let found = super::best(models.iter().map(|model| search(&problem(model), ALL_STEPS, self.progress)))?;
        self.operator.1 = found.minimum.x[found.minimum.x.len() - weights.len()..].to_vec();
        Ok((found, weights))
    }

    /// The fit after rounds of searches of all parameters, while they are worth it.
    fn search_to_minimum(&mut self, dynamics: FeedbackDynamics) -> Result<FeedbackFit, Error> {
        let (mut found, mut weights) = self.all(vec![dynamics], 0.0)?;
        for _ in 1..ROUNDS {
            let before = found.minimum.history[0];
            if found.minimum.cost > (1.0 - WORTHWHILE) * before {
                break;
            }
            (found, weights) = self.all(vec![found.model.dynamics().clone()], 0.0)?;
        }
        let problem = FreeRun { weights: Some(&weights), ..FreeRun::of(&found.model, self.runs) };
        let mut errors = problem.errors(&found.minimum);
        errors.truncate(errors.len() - weights.len());
        // The constant that suits all records.
        let constant = |run: &Run| {
            let whole = Whole::of(run, 0.0);
            let y = found.model.follow_run(whole.run());
            run.record.y().iter().zip(&y[whole.inside]).map(|(y, m)| y - m).sum::<f64>()
        };
        let samples: usize = self.runs.iter().map(|run| run.record.len()).sum();
        let offset = self.runs.iter().map(constant).sum::<f64>() / samples as f64;
        let mut parameters = found.model.parameters();
        parameters.iter_mut().filter(|p| p.name.starts_with("offset")).for_each(|p| p.value += offset);
        let model = found.model.with_parameters(&parameters.iter().map(|p| p.value).collect::<Vec<_>>())?;
        let mut fit = FeedbackFit::of(Found { model, ..found }, errors);
        // It has no error of its own, because each record has its constant; nor has what is at its limit.
        fit.parameters.retain(|p| p.error.is_finite() && p.value != 0.0);
        Ok(fit)
    }

    /// All parameters of the same dynamics, of which the displacement drives the hysteresis in place of the vibration;
    /// the search begins with an operator that then responds as before.
    fn by_displacement(&mut self, found: &Found, gain: f64) -> Result<Found<'r>, Error> {
        let dynamics = found.model.dynamics();
        let through = |u: f64, z: f64| -> f64 {
            dynamics.modes.iter().map(|mode| mode.sensed * (mode.input * u + mode.hysteretic * z)).sum()
        };
        let of = |run: &Run| {
            let before = if let Initial::After(before) = &run.initial { before } else { &Vec::new() };
            let u = [before, run.record.u()].concat();
            let trace = found.model.trace(&u).into_iter().zip(&u);
            trace.map(|([s, h, z], u)| (s + through(*u, z), h)).unzip()
        };
        let paths: Vec<(Vec<f64>, Vec<f64>)> = self.runs.iter().map(of).collect();
        let dynamics = FeedbackDynamics { senses_vibration: false, ..dynamics.clone() };
        self.operator = operator(self.ts, &paths)?;
        Ok(self.all(vec![dynamics], gain)?.0)
    }
}

/// The first mode of the blocks in series, and frequencies that the second may have.
fn modes(blocks: &Model, records: &[Record]) -> Result<(FeedbackDynamics, Vec<f64>), Error> {
    let form = blocks.linear().modal_form();
    let modes = form.modes();
    let Some(first) = modes.iter().max_by(|p, q| p.share.total_cmp(&q.share)) else {
        let because = "no resonance shows in the records: excite it".into();
        return Err(Error::Unidentifiable { what: STAGE.into(), because });
    };
    let is_second =
        |p: &&PoleShare| p.pole.damping < 1.0 && p.pole.hz > 2.0 * first.pole.hz && p.share.abs() > LEAST_SHARE;
    let second = form.poles.iter().filter(is_second).max_by(|p, q| p.pole.hz.total_cmp(&q.pole.hz));
    let seconds = match second {
        Some(second) => images_of(second.pole.hz, blocks.ts()).to_vec(),
        None => SECONDS.map(|factor| factor * first.pole.hz).to_vec(),
    };
    let stroke = records.iter().map(peak_to_peak).fold(0.0, f64::max);
    let (low, high) = ends(records.iter().flat_map(|record| record.u().iter().copied()));
    let sign = blocks.linear().dc_gain().signum();
    let first = FeedbackMode {
        hz: first.pole.hz,
        damping: first.pole.damping.max(LEAST_DAMPING),
        input: 0.0,
        hysteretic: sign * (1.0 - DIRECT),
        sensed: NEARLY_NONE * (high - low) / stroke,
        softening: NEARLY_NONE / stroke,
    };
    let shortest = SHORTEST_LAG / first.hz;
    let longest = records.iter().map(|record| record.ts() * record.len() as f64).fold(0.0, f64::max).min(LONGEST_LAG);
    let lags =
        (0..).map(|k| shortest * libm::pow(10.0, f64::from(k) / LAGS_IN_DECADE)).take_while(|tau_s| *tau_s < longest);
    let dynamics = FeedbackDynamics {
        substeps: SUBSTEPS,
        modes: vec![first],
        senses_vibration: true,
        direct: [0.0, sign * DIRECT],
        creep: lags.map(|tau_s| Lag { tau_s, gain: LAG_GAIN }).collect(),
        curve: NEARLY_NONE / stroke,
        offset: blocks.offset(),
        ..FeedbackDynamics::default()
    };
    Ok((dynamics, seconds))
}

/// The frequencies up to the rate and a half that are the same at the samples.
fn images_of(hz: f64, ts: f64) -> [f64; 3] {
    let rate = 1.0 / ts;
    let lowest = (hz / rate - (hz / rate).round()).abs() * rate;
    [lowest, rate - lowest, rate + lowest]
}

/// The same dynamics with a second mode at this frequency, which takes its share from the first if it is new.
fn with_second(mut dynamics: FeedbackDynamics, hz: f64) -> FeedbackDynamics {
    if let [first] = &mut dynamics.modes[..] {
        let share = SECOND * first.hysteretic;
        first.hysteretic -= share;
        let second = FeedbackMode { damping: DAMPING, hysteretic: share, softening: 0.0, ..*first };
        dynamics.modes.push(second);
    }
    dynamics.modes.iter_mut().skip(1).for_each(|mode| mode.hz = hz);
    dynamics
}

/// The inputs before a record with which the blocks in series come nearest to it.
fn before(blocks: &Model, record: &Record) -> Vec<f64> {
    let u = record.u();
    let error = |initial: &InitialCondition| {
        let run = blocks.follow(&mut blocks.before(u, *initial), u);
        scatter(&record.y().iter().zip(run).map(|(y, run)| y - run).collect::<Vec<_>>())
    };
    let range = blocks.known_inputs().unwrap_or_else(|| ends(u.iter().copied()));
    let each = InitialCondition::of(u).into_iter().map(|initial| (error(&initial), initial));
    let likeliest = each.min_by(|p, q| p.0.total_cmp(&q.0));
    likeliest.map_or_else(Vec::new, |(_, initial)| initial.inputs_before(u, range))
}

/// The hysteresis of the blocks in series along the records, times the amount of the gain after it: inputs and outputs.
fn paths(blocks: &Model, records: &[Record]) -> Vec<(Vec<f64>, Vec<f64>)> {
    let (hysteresis, gain) = (blocks.hysteresis(), blocks.linear().dc_gain().abs());
    let at_rest = hysteresis.simulate(&[0.0])[0];
    let z = |u: &[f64]| hysteresis.simulate(u).iter().map(|z| gain * (z - at_rest)).collect();
    records.iter().map(|record| (record.u().to_vec(), z(record.u()))).collect()
}

/// The Preisach operator, for wider inputs, whose outputs are the nearest along these paths from rest.
fn operator(ts: f64, paths: &[(Vec<f64>, Vec<f64>)]) -> Result<WeightedOperator, Error> {
    let (low, high) = ends(paths.iter().flat_map(|path| path.0.iter().copied()));
    let beyond = BEYOND * (high - low);
    let range = (low - beyond, high + beyond);
    let design = BasisDesign { ts, range, elements: Some(ROWS), frequencies: vec![] };
    let basis: Arc<dyn Basis> = (Operator::find("preisach")?.basis)(&design)?.into();
    let stride = paths.iter().map(|path| path.0.len()).sum::<usize>().div_ceil(OPERATOR_SAMPLES);
    let (mut rows, mut z) = (Vec::new(), Vec::new());
    for (inputs, outputs) in paths {
        let (mut x, mut phi) = (basis.initial(), vec![0.0; basis.len()]);
        for (t, (input, output)) in inputs.iter().zip(outputs).enumerate() {
            basis.step(&mut x, *input, &mut phi);
            if t % stride == 0 {
                rows.extend_from_slice(&phi);
                z.push(*output);
            }
        }
    }
    let n = basis.len();
    let phi = DMatrix::from_column_slice(n, z.len(), &rows);
    let mut normal = &phi * phi.transpose();
    let smoothness = SMOOTHNESS * normal.trace() / n as f64;
    normal += roughness(&*basis) * smoothness;
    (0..n).for_each(|k| normal[(k, k)] += REGULAR * smoothness);
    let weights = non_negative(&normal, &(phi * DVector::from(z)), &basis.non_negative(), &mut vec![true; n]);
    let because = || "no Preisach operator with positive weights is near to the hysteresis".into();
    let weights = weights.filter(|weights| weights.amax() > 0.0);
    let weights = weights.ok_or_else(|| Error::Unidentifiable { what: STAGE.into(), because: because() })?;
    Ok((basis, weights.as_slice().to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    #[test]
    fn images_are_the_same_at_the_samples() {
        let ts = 5e-4;
        for hz in [300.0, 700.0, 1300.0, 2300.0] {
            let images = images_of(hz, ts);
            for image in images {
                let at = |hz: f64| (0..40).map(|t| libm::cos(TAU * hz * ts * f64::from(t))).collect::<Vec<_>>();
                assert_close(&at(image), &at(hz), 0.0, 1e-9);
            }
            assert!(images[0] <= 1000.0 && images[0] < images[1] && images[1] < images[2] && images[2] <= 3000.0);
        }
    }

    #[test]
    fn a_second_mode_takes_its_share_from_the_first_once() {
        let mode = FeedbackMode { hz: 100.0, damping: 0.01, input: 0.0, hysteretic: 1.5, sensed: 0.1, softening: 0.2 };
        let one = FeedbackDynamics { modes: vec![mode], ..FeedbackDynamics::default() };
        let two = with_second(one, 400.0);
        let [first, second] = &two.modes[..] else { panic!("{two:?}") };
        assert_close(&[first.hysteretic, second.hysteretic], &[0.92 * 1.5, 0.08 * 1.5], 1e-12, 0.0);
        assert_eq!((first.hz, second.hz, second.softening), (100.0, 400.0, 0.0));
        let again = with_second(two.clone(), 500.0);
        assert_eq!(again.modes[1], FeedbackMode { hz: 500.0, ..two.modes[1] });
    }

    /// Along the path of an operator of another kind.
    #[test]
    fn the_operator_is_the_nearest_along_the_paths_for_wider_inputs() {
        let ts = 1e-3;
        let u: Vec<f64> = (0..9000).map(|t| f64::from(t) / 9000.0 * 10.0 * libm::sin(0.01 * f64::from(t))).collect();
        let plays = (Operator::find("prandtl-ishlinskii").unwrap().example)(ts).unwrap();
        let z = plays.simulate(&u);
        let (basis, weights) = operator(ts, &[(u.clone(), z.clone())]).unwrap();
        assert!(weights.iter().all(|weight| *weight >= 0.0));
        let run = basis.output(&weights, &u).unwrap();
        let error = z.iter().zip(&run).map(|(z, run)| z - run).collect::<Vec<_>>();
        let share = (scatter(&error) / scatter(&z)).sqrt();
        assert!(share < 0.02, "{share}");
        let (low, high) = ends(u.iter().copied());
        // What is beyond the range still moves the elements.
        let at = |u: f64| {
            let mut phi = vec![0.0; basis.len()];
            basis.step(&mut basis.initial(), u, &mut phi);
            phi
        };
        assert_ne!(at(high), at(high + 0.14 * (high - low)));
    }
}
