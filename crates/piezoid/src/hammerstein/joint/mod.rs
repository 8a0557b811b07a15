//! The joint method: identification of all parts together, without inverting any.
//!
//! ```text
//! y = G(q) C(q) sum_k w_k phi_k[u; p] + c
//! ```
//! For given G, creep C and shape p, the weights w are the solution of a convex least-squares problem on the filtered
//! responses, with smoothness and physical signs. Then all parameters are refined by Gauss-Newton on the free-run
//! error, with exact derivatives. Each record has an offset, a trend, initial states of G and creep, and a past; errors
//! are relative to the peak-to-peak of their record, so all records count. Held-out parts determine the smoothness, the
//! structure of G if there are no small-signal records, and the operator: the simplest that predicts as well as the
//! best.
//!
//! In order: the linear block and the pasts of the records with a coarse hysteresis (`structure`, `growth`,
//! `beginnings`); the operators (`operators`, `trials`); the structure again with the operator taken.
//!
//! Separable least squares: Golub & Pereyra 2003, DOI 10.1088/0266-5611/19/2/201. Hammerstein models by
//! over-parametrised and iterated least squares: Bai 1998, DOI 10.1016/S0005-1098(97)00198-2; Schoukens & Tiels 2017,
//! DOI 10.1016/j.automatica.2017.06.044 (a survey). Not here: hysteresis inside the feedback of the dynamics.
//!
//! Why: docs/decisions/identification.md, "The joint method never inverts a block".
//! Why: docs/decisions/identification.md, "Creep lags are half a decade apart".

mod beginnings;
mod check;
mod dynamics;
mod equations;
mod estimate;
mod extend;
mod folds;
mod gram;
mod growth;
mod held_out;
mod hidden;
mod layout;
mod operators;
mod optimality;
mod products;
mod refine;
mod runs;
mod search;
mod signals;
mod solve;
mod spread;
mod structure;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod trials;
mod uncertainty;

pub(crate) use check::FEW;
pub use trials::OperatorTrial;
pub use uncertainty::FittedParameter;

use super::large_signal::LinearPart;
use super::paper::{Identified, common_units, unexcited_resonance};
use super::{Domain, Model};
use crate::creep::Lag;
use crate::driver::DriverModel;
use crate::error::Error;
use crate::hysteresis::BasisDesign;
use crate::number::short;
use crate::progress::{Progress, Stage};
use crate::record::Record;
use crate::series::{dot, ends, mean, scatter};
use crate::system::System;
use beginnings::{begin_all, coarse, reconsider};
use dynamics::{creep_pole, slowest_observable};
use estimate::{Estimate, Responses};
use growth::{Chosen, Growth};
use layout::ColumnLayout;
use refine::Fitted;
use runs::TrainingRecord;
use solve::CREEPS;

/// Shortest time constant of creep [samples], and longest over the duration of the longest record.
const QUICKEST: f64 = 10.0;
const SLOWEST: f64 = 10.0;

/// Maximum number of thresholds, levels or knots.
const MOST: usize = 1000;

/// Options of the joint method.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct JointOptions {
    /// Name of the hysteresis operator. Of several (separated by commas), or of all (`auto`), the simplest is selected
    /// that predicts held-out data as well as the best.
    pub operator: String,
    /// Order of the linear block; `None` selects it.
    pub order: Option<usize>,
    /// Thresholds, levels or knots of the operator; `None` is the operator's default.
    pub elements: Option<usize>,
    /// True to identify creep.
    pub creep: bool,
    /// The driver; `None` if it is unknown.
    pub driver: Option<DriverModel>,
    /// Seed of the swarm that searches the shape of operators.
    pub seed: u64,
}

impl Default for JointOptions {
    fn default() -> Self {
        JointOptions { operator: "auto".into(), order: None, elements: None, creep: true, driver: None, seed: 0 }
    }
}

/// Identifies all parts together. `small` are small-signal records (a PRBS) and may be empty; `large_signal` exercise
/// the hysteresis.
///
/// # Errors
/// Returns an error if sampling periods differ, units cannot be converted, there is no usable record, or an operator is
/// unknown; [`Error::Cancelled`].
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
    let Some(any) = large_signal.first().or(small.first()) else {
        let remedy = "give small-signal records, large-signal records, or both".into();
        return Err(Error::TooShort { what: "the list of records".into(), have: 0, need: 1, remedy });
    };
    let (ts, mut notes) = (any.ts(), Vec::new());
    // Without large-signal records, the hysteresis is identified from the small-signal records.
    let (small_beside, large_signal) =
        if large_signal.is_empty() { (&[][..], small.clone()) } else { (&small[..], large_signal) };
    let candidates = trials::candidates(&settings.operator, &large_signal, small.is_empty(), &mut notes)?;
    let mut runs = runs::of(small_beside, &large_signal, &mut notes)?;
    let longest = runs.iter().map(|run| run.record.duration()).fold(0.0, f64::max);
    let lags = if settings.creep { ladder(QUICKEST * ts, SLOWEST * longest) } else { Vec::new() };
    let faster = if settings.driver.is_some() { ts / DriverModel::SUBSTEPS as f64 } else { ts };
    let frequencies = large_signal.iter().filter_map(|r| crate::waveform::dominant_frequency(r.u(), ts)).collect();
    let range = ends(runs.iter().flat_map(|run| run.record.u()).copied());
    let design = BasisDesign { ts: faster, range, elements: settings.elements, frequencies };

    let total = 2 * candidates.len() + 1;
    let mut report = |stage: Stage| -> Result<(), Error> {
        match progress(Stage { total, ..stage }).is_break() {
            true => Err(Error::Cancelled { what: stage.what.into(), done: stage.done, total }),
            false => Ok(()),
        }
    };
    let mut watch = |_| report(Stage::new("linear block", 0, total));
    watch(0)?;
    let bridged = |run: &TrainingRecord| match run.usable.contains(&false) {
        true => Ok(Record::new(ts, run.record.u().to_vec(), run.bridged())?.with_units(units.clone())),
        false => Ok(run.record.clone()),
    };
    let bridged = runs.iter().map(bridged).collect::<Result<Vec<_>, Error>>()?;
    let growth = Growth::new(&bridged, settings, &lags, &design);
    let (first, mut reason, simpler) = match small.is_empty() {
        false => {
            let (linear, reason) =
                structure::from_small_signal(&bridged[..small.len()], &bridged[small_beside.len()..], settings, &lags)?;
            let start = || coarse(linear.clone(), settings, &design, &lags);
            (begin_all(&start, &mut runs, range, &mut watch)?.estimate, reason, Vec::new())
        }
        true => {
            let tried =
                structure::from_large_signal(&bridged, &mut runs, settings, &design, &lags, &growth, &mut watch)?;
            let Chosen { fitted, reason, simpler, .. } = growth.choose(tried);
            fitted.begin_again(&mut runs, range);
            (fitted.estimate, reason, simpler)
        }
    };
    let faster = if first.driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 };
    let design = BasisDesign { ts: ts / faster, ..design };

    let mut trials = operators::compare(&candidates, &design, &first, settings.seed, &mut runs, &mut report)?;
    let (taken, mut fitted) = trials::choose(&mut trials)?;
    fitted.begin_again(&mut runs, range);
    let row = candidates[taken];
    let mut watch = |_| report(Stage::new(row.name, total - 1, total));
    fitted = reconsider(fitted, &mut runs, range, &mut watch)?;
    // Small-signal records show the specified order best.
    if settings.order.is_none() || small.is_empty() {
        let before = fitted.held_out.rms_pp();
        let settled = growth.settle(fitted, simpler, row, &mut runs, &mut watch)?;
        fitted = settled.fitted;
        fitted.begin_again(&mut runs, range);
        if settled.of_several {
            reason = settled.reason;
        }
        if operators::compare_again(&mut trials, taken, before, &fitted, &design, &mut runs, &mut watch)? {
            let after = 100.0 * fitted.held_out.rms_pp();
            trials[taken] = (operators::trial_of(row, &fitted, &mut runs, range), Some(fitted));
            fitted = trials::choose(&mut trials)?.1;
            fitted.begin_again(&mut runs, range);
            notes.push(format!(
                "operators: the last linear block lowered the held-out error of {} from {} to {} % rms/pp, so those close \
                 to it were compared again with this block",
                row.name,
                short(100.0 * before),
                short(after)
            ));
        }
    }
    let trials: Vec<OperatorTrial> = trials.into_iter().map(|(trial, _)| trial).collect();
    let mut reasons = Vec::new();
    // Of a stated order it says if it is too low.
    if settings.order.is_some() { &mut notes } else { &mut reasons }.push(format!("linear block: {reason}"));
    let mut left_percent = None;
    if let Some(end) = optimality::optimality(&fitted, &runs) {
        left_percent = end.left_percent;
        if left_percent.is_none() { &mut reasons } else { &mut notes }.push(end.note);
    }
    notes.extend(check::check_fit(&fitted, &runs)?);
    reasons.extend(trials::why(&trials).map(|why| format!("operator: {why}")));
    let offset = offset(&fitted, &runs, &mut notes, &units.y);
    let model = fitted.estimate.model(offset)?.with_units(units);
    let model = match Domain::of(small.iter().chain(&large_signal)) {
        Some(domain) => model.with_identified(domain),
        None => model,
    };
    let parameters = uncertainty::parameters(&fitted);
    let unknown = parameters.iter().filter(|p| p.is_unknown());
    let unknown = unknown.map(|p| format!("{} = {} (standard error {})", p.name, short(p.value), short(p.error)));
    let unknown = unknown.collect::<Vec<_>>().join(", ");
    if !unknown.is_empty() {
        notes.push(format!("these records do not determine {unknown}: ignore these values, or add records"));
    }
    notes.extend(model.creep().lags().iter().filter(|lag| lag.gain >= CREEPS).map(|lag| {
        let (tau, percent) = (short(lag.tau_s), short(100.0 * lag.gain));
        format!(
            "creep of {tau} s adds {percent} %, more than creep of ceramics: it may represent a lag of driver, \
             mechanics or sensor that is missing in the linear block"
        )
    }));
    notes.extend(check::long_delay(model.linear()));
    let is_seen = model.linear().resonance().is_some_and(|mode| growth.is_seen(mode.hz));
    notes.extend(unexcited_resonance(model.linear(), small.iter().chain(&large_signal)).filter(|_| !is_seen));
    let linear = LinearPart { arx: model.linear().clone(), offset, fit: None, reason };
    Ok(Identified { model, linear, loops: Vec::new(), trials, parameters, left_percent, reasons, notes })
}

/// Mean of the free-run error of a record, and its rms about that mean.
fn free_run_residual(run: &TrainingRecord, model: &Model) -> (f64, f64) {
    let (u, y) = (run.record.u(), run.record.y());
    let simulated = model.resume(&mut model.before(u, run.initial), u);
    let errors = y.iter().zip(simulated).zip(&run.usable).filter(|(_, usable)| **usable).map(|((y, s), _)| y - s);
    let errors: Vec<f64> = errors.collect();
    (mean(&errors), (scatter(&errors) / errors.len() as f64).sqrt())
}

/// Lags half a decade apart.
fn ladder(from: f64, to: f64) -> Vec<Lag> {
    let rungs = std::iter::successors(Some(from), |tau| Some(10f64.sqrt() * tau)).take_while(|tau| *tau <= to);
    rungs.map(|tau_s| Lag { tau_s, gain: 0.0 }).collect()
}

/// A lag is slow if the longest record is shorter than this number of its time constants.
const SLOW: f64 = 20.0;

/// The offset of the model: the median over all records, because sensors drift. If the fit cannot separate the offset
/// from the state of a slow lag, the free run determines it.
fn offset(fitted: &Fitted, runs: &[TrainingRecord], notes: &mut Vec<String>, unit: &str) -> f64 {
    let estimate = &fitted.estimate;
    let layout = ColumnLayout::of(estimate);
    let constant = layout.constant - layout.parameters();
    let slow = creep_pole(&estimate.linear, SLOW * slowest_observable(runs.iter().map(|run| run.record))).is_some();
    let free = estimate.model(0.0).ok().filter(|_| slow);
    let creep: f64 = 1.0 + estimate.lags.iter().map(|lag| lag.gain).sum::<f64>();
    let of = |(run, own): (&TrainingRecord, &Vec<f64>)| {
        let first = dot(&Responses::level(estimate, run), &estimate.weights);
        let fits = run.level + own[constant] - estimate.linear.dc_gain() * creep * first;
        let Some((mean, rms)) = free.as_ref().map(|model| free_run_residual(run, model)) else { return fits };
        if (mean - fits).abs() > rms { mean } else { fits }
    };
    let mut offsets: Vec<f64> = runs.iter().zip(&fitted.own).map(of).collect();
    offsets.sort_by(f64::total_cmp);
    let (low, high) = (offsets[0], offsets[offsets.len() - 1]);
    let height = runs.iter().map(|run| run.scale.recip()).fold(0.0, f64::max);
    if high - low > 0.02 * height {
        notes.push(format!(
            "the offsets of the records differ by up to {} {unit}, {} % of the largest height: the sensor drifts, or \
             the initial conditions differ; the model uses the median offset",
            short(high - low),
            short(100.0 * (high - low) / height)
        ));
    }
    offsets[offsets.len() / 2]
}
