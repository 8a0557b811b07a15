//! Identification of all parts together, without inverting any.
//!
//! ```text
//! y = G(q) C(q) sum_k w_k phi_k[u; p] + c
//! ```
//! For given G, creep C and shape p the weights w come from a convex least squares on the filtered responses, with
//! smoothness and signs as physics has them; all together are then refined by Gauss-Newton on the free-run error, with exact
//! derivatives. Each record has an offset, a state its G and its creep began in, and a past; errors count over the
//! peak-to-peak of their record, so that all are heard. Parts that are held out in turn choose the smoothness, the
//! structure of G where small-signal records do not, and, among operators, the simplest that foretells as well as the best.
//!
//! Separable least squares: Golub & Pereyra 2003, DOI 10.1088/0266-5611/19/2/201. Hammerstein models by over-parametrised and
//! iterated least squares: Bai 1998, DOI 10.1016/S0005-1098(97)00198-2; Schoukens & Tiels 2017, DOI
//! 10.1016/j.automatica.2017.06.044 (a survey). It does not do: hysteresis inside the loop of the dynamics.

mod check;
mod dynamics;
mod equations;
mod estimate;
mod held_out;
mod layout;
mod products;
mod refine;
mod runs;
mod search;
mod signals;
mod solve;
mod structure;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod trials;
mod uncertainty;

pub use trials::OperatorTrial;
pub use uncertainty::FittedParameter;

use super::large_signal::LinearPart;
use super::paper::{Identified, common_units, unexcited_resonance};
use super::{Domain, InitialCondition, Model};
use crate::creep::Lag;
use crate::driver::DriverModel;
use crate::error::Error;
use crate::hysteresis::{BasisDesign, Operator};
use crate::number::short;
use crate::progress::{Progress, Stage};
use crate::record::Record;
use crate::series::{dot, ends, mean, scatter};
use crate::system::System;
use dynamics::{creep_pole, slowest_observable};
use estimate::{Estimate, Responses};
use layout::ColumnLayout;
use refine::{Fitted, refine};
use runs::TrainingRecord;
use solve::FreeParameters;

/// The shortest time constant of creep [samples], and the longest over the longest record.
const QUICKEST: f64 = 10.0;
const SLOWEST: f64 = 1.0;

/// The most thresholds, levels or knots.
const MOST: usize = 1000;

/// The most that a lag of creep adds in ceramics, as a share.
const CREEPS: f64 = 0.1;

/// How to identify jointly.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JointOptions {
    /// Name of the hysteresis operator. Of several, which commas separate, and of all (`auto`) the simplest is taken that
    /// foretells held-out parts as well as the best.
    pub operator: String,
    /// Order of the linear block; none has it chosen.
    pub order: Option<usize>,
    /// Thresholds, levels or knots of the operator; none takes its own number.
    pub elements: Option<usize>,
    /// Whether creep is looked for.
    pub creep: bool,
    /// The driver, where it is known.
    pub driver: Option<DriverModel>,
    /// Seed of the swarm that looks for the shape of operators.
    pub seed: u64,
}

impl Default for JointOptions {
    fn default() -> Self {
        JointOptions { operator: "auto".into(), order: None, elements: None, creep: true, driver: None, seed: 0 }
    }
}

/// Identifies all parts together: `small` are small-signal records (a PRBS), `large_signal` those that exercise the hysteresis. The
/// first list may be empty.
///
/// # Errors
/// Records of different sampling periods, or of units that cannot be converted; no rich record, or one nothing can be
/// identified from; an operator that is not known; [`Error::Cancelled`].
pub(crate) fn identify_joint(
    small: &[Record],
    large_signal: &[Record],
    settings: &JointOptions,
    progress: &mut Progress,
) -> Result<Identified, Error> {
    if let Some(elements) = settings.elements.filter(|n| *n > MOST) {
        return Err(Error::parameter("elements", elements, format!("must be at most {MOST}")));
    }
    let units = common_units(small.iter().chain(large_signal))?;
    let convert = |records: &[Record]| records.iter().map(|r| r.output_in(&units.y)).collect::<Result<Vec<_>, _>>();
    let (small, large_signal) = (convert(small)?, convert(large_signal)?);
    let Some(first) = large_signal.first().or(small.first()) else {
        let remedy = "give a small-signal record, a rich one, or both".into();
        return Err(Error::TooShort { what: "the list of records".into(), have: 0, need: 1, remedy });
    };
    let (ts, mut notes) = (first.ts(), Vec::new());
    // Without any other, small-signal records are all there is to find hysteresis from.
    let (beside, large_signal) =
        if large_signal.is_empty() { (&[][..], small.clone()) } else { (&small[..], large_signal) };
    let candidates = trials::candidates(&settings.operator, &large_signal, small.is_empty(), &mut notes)?;
    let mut runs = runs::of(beside, &large_signal, &mut notes)?;
    let longest = runs.iter().map(|run| run.record.duration()).fold(0.0, f64::max);
    let lags = if settings.creep { ladder(QUICKEST * ts, SLOWEST * longest) } else { Vec::new() };
    let faster = if settings.driver.is_some() { ts / DriverModel::SUBSTEPS as f64 } else { ts };
    let frequencies = large_signal.iter().filter_map(|r| crate::waveform::dominant_frequency(r.u(), ts)).collect();
    let range = ends(runs.iter().flat_map(|run| run.record.u()).copied());
    let design = BasisDesign { ts: faster, range, elements: settings.elements, frequencies };

    let total = candidates.len() + 1;
    let mut watch_at = |done: usize, what: &str| -> Result<(), Error> {
        match progress(Stage { what, done, total }).is_break() {
            true => Err(Error::Cancelled { what: what.into(), done, total }),
            false => Ok(()),
        }
    };
    let mut watch = |_| watch_at(0, "linear block");
    watch(0)?;
    let bridged =
        |run: &TrainingRecord| Ok(Record::new(ts, run.record.u().to_vec(), run.bridged())?.with_units(units.clone()));
    let bridged = runs.iter().map(bridged).collect::<Result<Vec<_>, Error>>()?;
    let (linear, reason) = match small.is_empty() {
        false => structure::from_small_signal(&bridged[..small.len()], &bridged[beside.len()..], settings, &lags)?,
        true => structure::from_large_signal(&bridged, &mut runs, settings, &design, &lags, &mut watch)?,
    };
    notes.push(format!("linear block: {reason}"));

    let mut trials: Vec<(OperatorTrial, Option<Fitted>)> = Vec::new();
    for (done, row) in candidates.iter().enumerate() {
        let mut watch = |_| watch_at(done + 1, row.name);
        let fitted = fit(row, &design, &linear, &lags, settings, &mut runs, &mut watch);
        let trial = match fitted {
            Err(cancelled @ Error::Cancelled { .. }) => return Err(cancelled),
            Err(why) if candidates.len() == 1 => return Err(why),
            Err(why) => (OperatorTrial::refused(row, why.to_string()), None),
            Ok(fitted) => (OperatorTrial::of(row, &fitted), Some(fitted)),
        };
        trials.push(trial);
    }
    let (fitted, trials) = trials::choose(trials)?;
    notes.extend(check::check_fit(&fitted, &runs)?);
    notes.extend(trials::why(&trials).map(|why| format!("operator: {why}")));
    let offset = offset(&fitted, &runs, &mut notes, &units.y);
    let model = fitted.estimate.model(offset)?.with_units(units);
    let model = match Domain::of(small.iter().chain(&large_signal)) {
        Some(domain) => model.with_identified(domain),
        None => model,
    };
    let parameters = uncertainty::parameters(&fitted);
    notes.extend(parameters.iter().filter(|p| p.is_unknown()).map(|p| {
        let (value, error) = (short(p.value), short(p.error));
        format!("{} is {value} with a standard error of {error}: these records do not tell it", p.name)
    }));
    notes.extend(model.creep().lags().iter().filter(|lag| lag.gain > CREEPS).map(|lag| {
        let (tau, percent) = (short(lag.tau_s), short(100.0 * lag.gain));
        format!(
            "creep of {tau} s adds {percent} %, more than ceramics creep: it stands for a lag of driver, mechanics or sensor that the \
             linear block does not have"
        )
    }));
    notes.extend(unexcited_resonance(model.linear(), small.iter().chain(&large_signal)));
    let linear = LinearPart { arx: model.linear().clone(), offset, fit: None, reason };
    Ok(Identified { model, linear, loops: Vec::new(), trials, parameters, notes })
}

/// Fits one operator, from where it stands and from where a swarm sends it.
fn fit(
    row: &Operator,
    design: &BasisDesign,
    linear: &crate::linear::Arx,
    lags: &[Lag],
    settings: &JointOptions,
    runs: &mut [TrainingRecord],
    watch: refine::StepCallback,
) -> Result<Fitted, Error> {
    let start = Estimate::new(settings.driver, (row.basis)(design)?, lags.to_vec(), linear.clone());
    watch(0)?;
    let elsewhere = search::search(&start, runs, settings.seed)?;
    let here = refine(start, runs, FreeParameters::All, watch)?;
    let Some(elsewhere) = elsewhere else { return Ok(here) };
    let there = refine(elsewhere, runs, FreeParameters::All, watch)?;
    Ok(better(here, there, runs))
}

/// How near each other two fits are in what was held out, for their free runs to decide.
const ALIKE: f64 = 0.95;

/// The fit that foretells held-out parts better; where both do so alike, the one that runs free better. An operator that hardly forgets
/// foretells what is held out, since what came before is known there, and is of no use to whoever does not know it.
fn better(here: Fitted, there: Fitted, runs: &[TrainingRecord]) -> Fitted {
    let [a, b] = [&here, &there].map(|fitted| fitted.held_out.rms_pp());
    let there_is = if a.min(b) < ALIKE * a.max(b) { b < a } else { free_run(&there, runs) < free_run(&here, runs) };
    if there_is { there } else { here }
}

/// Mean square, over the squared heights of the records, of what the model leaves of them in free run, each with a constant of its own.
fn free_run(fitted: &Fitted, runs: &[TrainingRecord]) -> f64 {
    let Ok(model) = fitted.estimate.model(0.0) else { return f64::INFINITY };
    runs.iter().map(|run| (run.scale * left_of(run, &model).1).powi(2)).sum()
}

/// What a free run of the model leaves of a record: its mean, and the rms about it.
fn left_of(run: &TrainingRecord, model: &Model) -> (f64, f64) {
    let (u, y) = (run.record.u(), run.record.y());
    let simulated = model.resume(&mut model.before(u, InitialCondition::of(u)[0]), u);
    let errors = y.iter().zip(simulated).zip(&run.usable).filter(|(_, usable)| **usable).map(|((y, s), _)| y - s);
    let errors: Vec<f64> = errors.collect();
    (mean(&errors), (scatter(&errors) / errors.len() as f64).sqrt())
}

/// Lags a decade apart.
fn ladder(from: f64, to: f64) -> Vec<Lag> {
    let rungs = std::iter::successors(Some(from), |tau| Some(10.0 * tau)).take_while(|tau| *tau <= to);
    rungs.map(|tau_s| Lag { tau_s, gain: 0.0 }).collect()
}

/// A lag is slow where the longest record is shorter than so many of its time constants.
const SLOW: f64 = 20.0;

/// The constant in the output of the model: the middle one of all records, whose sensors may have drifted. Where the fit cannot tell
/// constant and state of a slow lag apart, it is what the free run asks for.
fn offset(fitted: &Fitted, runs: &[TrainingRecord], notes: &mut Vec<String>, unit: &str) -> f64 {
    let estimate = &fitted.estimate;
    let layout = ColumnLayout::of(estimate);
    let constant = layout.constant - layout.parameters();
    let slow = creep_pole(&estimate.linear, SLOW * slowest_observable(runs.iter().map(|run| run.record))).is_some();
    let free = estimate.model(0.0).ok().filter(|_| slow);
    let creep: f64 = 1.0 + estimate.lags.iter().map(|lag| lag.gain).sum::<f64>();
    let of = |(run, own): (&TrainingRecord, &Vec<f64>)| {
        let first = dot(Responses::before(estimate, run).now(), &estimate.weights);
        let fits = run.level + own[constant] - estimate.linear.dc_gain() * creep * first;
        let Some((mean, rms)) = free.as_ref().map(|model| left_of(run, model)) else { return fits };
        if (mean - fits).abs() > rms { mean } else { fits }
    };
    let mut offsets: Vec<f64> = runs.iter().zip(&fitted.own).map(of).collect();
    offsets.sort_by(f64::total_cmp);
    let (low, high) = (offsets[0], offsets[offsets.len() - 1]);
    let height = runs.iter().map(|run| run.scale.recip()).fold(0.0, f64::max);
    if high - low > 0.02 * height {
        notes.push(format!(
            "the records stand off one another by up to {} {unit}, {} % of the largest height: sensors drift, or the past of a record was another; \
             the model has the middle offset",
            short(high - low),
            short(100.0 * (high - low) / height)
        ));
    }
    offsets[offsets.len() / 2]
}
