//! The search: which structure, operator and initial conditions the model has.
//!
//! The first candidate has a linear block and a coarse hysteresis ([`start`]). Then each of the [`moves`] may replace
//! the candidate by a better one. The thresholds of all decisions are in [`policy`]; the fits are the work of `fit`.

mod candidate;
mod creep_order;
mod each;
mod extensions;
mod initial_conditions;
mod mode_evidence;
mod moves;
mod operators;
mod policy;
mod promises;
mod shape_search;
mod start;
mod structure;
mod structure_search;
mod trials;

pub(super) use candidate::Candidate;
pub use trials::OperatorTrial;
pub(crate) use trials::SELECTED;
pub(super) use trials::{reason_for_operator, suitable_operators};

use super::records::Records;
use super::{Effort, JointOptions, fit};
use fit::{Estimate, Fitted, Parts, TrainingRecord};
use moves::MOVES;
use piezoid_models::creep::Lag;
use piezoid_models::driver::DriverModel;
use piezoid_models::hysteresis::{BasisDesign, Operator, is_auto};
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_numerics::series::ends;
use piezoid_records::record::{Record, Units};
use piezoid_records::waveform::dominant_frequency;
use policy::POLICY;
use structure_search::StructureSearch;
use tracing::trace_span;
use trials::Trial;

/// A search: its records, what may be selected, and what was found so far.
pub(super) struct Search<'a> {
    settings: &'a JointOptions,
    records: &'a Records,
    /// The records.
    whole: &'a [TrainingRecord<'a>],
    /// The parts of them in the present fits. Each move changes their initial conditions.
    pub(super) runs: Vec<TrainingRecord<'a>>,
    /// The records with unusable samples interpolated.
    bridged: Vec<Record>,
    operators: Vec<&'static Operator>,
    lags: Vec<Lag>,
    /// How a basis is made.
    design: BasisDesign,
    structures: StructureSearch,
    /// The operators that were compared.
    trials: Vec<Trial>,
    /// For each move that was made, its name, and the held-out error before and after it.
    history: Vec<(&'static str, f64, f64)>,
    /// What the user should know.
    pub(super) notes: Vec<String>,
    /// The error with which the search was cancelled.
    pub(super) cancelled: Option<Error>,
    reporter: Reporter<'a>,
}

impl<'a> Search<'a> {
    /// The search for the best of these operators.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; the error of a record without usable samples.
    pub(crate) fn new(
        settings: &'a JointOptions,
        records: &'a Records,
        whole: &'a [TrainingRecord<'a>],
        parts: &'a Parts,
        operators: Vec<&'static Operator>,
        notes: Vec<String>,
        progress: &'a mut Progress<'a>,
    ) -> Result<Self, Error> {
        let (ts, total) = (records.ts(), 3 * operators.len() + 1);
        let range = ends(whole.iter().flat_map(|run| run.record.u()).copied());
        let runs = parts.runs(whole, range);
        let mut reporter =
            Reporter { progress, total, last: (LINEAR_BLOCK.into(), 0), best: None, range, units: &records.units };
        let lags = if settings.creep { creep_lags(&runs) } else { Vec::new() };
        let large_signal = records.large_signal.iter();
        let design = BasisDesign {
            ts: basis_ts(ts, settings.driver.is_some()),
            range,
            elements: settings.elements,
            frequencies: large_signal.filter_map(|record| dominant_frequency(record.u(), ts)).collect(),
        };
        reporter.report(Stage::new(LINEAR_BLOCK, 0, total))?;
        let bridged = whole.iter().map(|run| records.bridged(run)).collect::<Result<Vec<_>, _>>()?;
        let structures = StructureSearch::new(&bridged, settings, &lags, design.range);
        let (trials, history) = (Vec::new(), Vec::new());
        Ok(Search {
            settings,
            records,
            whole,
            runs,
            bridged,
            operators,
            lags,
            design,
            structures,
            trials,
            history,
            notes,
            cancelled: None,
            reporter,
        })
    }

    /// The best candidate that the moves find; if the search is cancelled, the best until then.
    ///
    /// # Errors
    /// [`Error::Cancelled`] if there is none; an error if no operator can be fitted.
    pub(crate) fn run(&mut self) -> Result<Candidate, Error> {
        match (self.moves(), self.reporter.best.take()) {
            (Err(cancelled @ Error::Cancelled { .. }), Some(best)) => {
                self.cancelled = Some(cancelled);
                Ok(self.end_with(best))
            }
            (found, _) => found.map(|found| self.end_with(found)),
        }
    }

    fn moves(&mut self) -> Result<Candidate, Error> {
        let mut candidate =
            trace_span!(target: "stage", "first structure").in_scope(|| start::first_candidate(self))?;
        self.reporter.keep(candidate.clone(), &self.runs)?;
        for step in MOVES {
            self.apply_to(&candidate);
            if !(step.applies)(self) {
                continue;
            }
            let before = candidate.error();
            if let Some(next) = (step.run)(&candidate, self)? {
                candidate = next;
                self.reporter.keep(candidate.clone(), &self.runs)?;
            }
            self.history.push((step.name, before, candidate.error()));
        }
        Ok(candidate)
    }

    /// True for a quick search.
    fn is_quick(&self) -> bool {
        self.settings.effort == Effort::Quick
    }

    /// True if the operators are compared: a quick search of the best of all has only the coarse one.
    fn compares_operators(&self) -> bool {
        !self.is_quick() || !is_auto(&self.settings.operator)
    }

    /// The operators that were compared, with their errors.
    pub(super) fn operator_trials(&self) -> Vec<OperatorTrial> {
        self.trials.iter().map(|trial| trial.result.clone()).collect()
    }

    /// True if free decays in the records show a mode of this frequency [Hz].
    pub(super) fn is_in_free_decays(&self, hz: f64) -> bool {
        self.structures.evidence.is_in_free_decays(hz)
    }

    /// Sets the trial of the operator of the candidate that the search ends with: later moves may have lowered its
    /// error, or the operators were not compared. The records start as in the candidate then.
    fn end_with(&mut self, best: Candidate) -> Candidate {
        let result = operators::trial_of(best.operator, &best.fitted, &mut self.runs, self.design.range);
        let trial = Trial::selected(result, best.fitted.clone());
        match self.trials.iter_mut().find(|trial| trial.result.is_selected()) {
            Some(selected) => *selected = trial,
            None => self.trials = vec![trial],
        }
        best
    }

    /// True if the search is in parts of the records.
    fn is_in_parts(&self) -> bool {
        self.runs.iter().map(|run| run.record.len()).ne(self.whole.iter().map(|run| run.record.len()))
    }

    /// Sets the initial conditions of the records to those of a candidate.
    fn apply_to(&mut self, candidate: &Candidate) {
        candidate.fitted.apply_to(&mut self.runs, self.design.range);
    }

    /// The held-out errors before and after the last move of this name; `None` if it was not made.
    fn errors_of(&self, name: &str) -> Option<(f64, f64)> {
        self.history.iter().rfind(|(move_name, ..)| *move_name == name).map(|(_, before, after)| (*before, *after))
    }

    /// How the basis of an operator is made for the driver of an estimate.
    fn design_for(&self, estimate: &Estimate) -> BasisDesign {
        BasisDesign { ts: basis_ts(estimate.ts(), estimate.driver.is_some()), ..self.design.clone() }
    }
}

/// The sampling period of the hysteresis [s]: behind a driver it is shorter.
fn basis_ts(ts: f64, has_driver: bool) -> f64 {
    if has_driver { ts / DriverModel::SUBSTEPS as f64 } else { ts }
}

/// Name of the first stage in progress.
const LINEAR_BLOCK: &str = "linear block";

/// Reports progress; the caller may cancel. It keeps the best candidate so far.
struct Reporter<'a> {
    progress: &'a mut Progress<'a>,
    /// Number of stages.
    total: usize,
    /// The last stage, and the number of those before it.
    last: (String, usize),
    best: Option<Candidate>,
    /// The lowest and the highest input.
    range: (f64, f64),
    units: &'a Units,
}

impl Reporter<'_> {
    /// # Errors
    /// [`Error::Cancelled`].
    fn report(&mut self, stage: Stage) -> Result<(), Error> {
        let Stage { what, done, .. } = stage;
        self.last = (what.into(), done);
        match (self.progress)(Stage { total: self.total, ..stage }).is_break() {
            true => Err(Error::Cancelled { what: what.into(), done, total: self.total }),
            false => Ok(()),
        }
    }

    /// Keeps a candidate as the best so far, and reports its model. Before the operators are compared, this is of no
    /// operator that is tried.
    ///
    /// # Errors
    /// [`Error::Cancelled`]; an error if the candidate is no model.
    fn keep(&mut self, candidate: Candidate, runs: &[TrainingRecord]) -> Result<(), Error> {
        let (runs, operator) = (&mut runs.to_vec(), candidate.operator);
        let model = self.model(&candidate.fitted, runs)?;
        let (last, done) = self.last.clone();
        let tried = last != LINEAR_BLOCK;
        let figures = tried.then(|| operators::trial_of(operator, &candidate.fitted, runs, self.range).figures());
        self.best = Some(candidate);
        let (what, figures) = if tried { (operator.name, figures.as_ref()) } else { (LINEAR_BLOCK, None) };
        let figures = figures.map_or(&[][..], |figures| figures);
        self.report(Stage { figures, model: Some(&model), best: true, ..Stage::new(what, done, 0) })
    }

    /// Reports a finished fit with its model, and keeps it if its held-out error is less than that of the best.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn tried(
        &mut self,
        (operator, fitted): (&'static Operator, &Fitted),
        figures: &[(&str, f64)],
        done: usize,
        runs: &[TrainingRecord],
    ) -> Result<(), Error> {
        // A fit that is no model cannot be the best.
        let model = self.model(fitted, &mut runs.to_vec()).ok();
        let before = self.best.as_ref().filter(|best| model.is_some() && fitted.held_out.rms_pp() < best.error());
        let better = before.map(|before| Candidate { operator, ..before.with_fit(fitted.clone()) });
        let best = better.is_some();
        self.best = better.or(self.best.take());
        self.report(Stage { figures, model: model.as_deref(), best, ..Stage::new(operator.name, done, 0) })
    }

    /// The same for a fit in other samples or of other work than those before: it is never kept.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    fn tried_apart(&mut self, trial: &Trial, done: usize, runs: &[TrainingRecord]) -> Result<(), Error> {
        let Some(fitted) = &trial.fitted else { return Ok(()) };
        let (figures, model) = (&trial.result.figures(), self.model(fitted, &mut runs.to_vec()).ok());
        self.report(Stage { figures, model: model.as_deref(), ..Stage::new(trial.result.operator, done, 0) })
    }

    /// The text of the file of a fit's model; these records start as in the fit then.
    fn model(&self, fitted: &Fitted, runs: &mut [TrainingRecord]) -> Result<String, Error> {
        fitted.apply_to(runs, self.range);
        let offset = fit::offset(fitted, runs, &mut Vec::new(), &self.units.y);
        Ok(fitted.estimate.model(offset)?.with_units(self.units.clone()).to_json())
    }

    /// A callback for the steps of a fit in the stage `what`, after `done` others.
    fn stage<'s>(&'s mut self, what: &'s str, done: usize) -> impl FnMut(usize) -> Result<(), Error> + 's {
        let total = self.total;
        move |_| self.report(Stage::new(what, done, total))
    }

    /// The same in the last stage.
    fn last_stage<'s>(&'s mut self, what: &'s str) -> impl FnMut(usize) -> Result<(), Error> + 's {
        self.stage(what, self.total - 1)
    }
}

/// Lags half a decade apart, for records as long as these.
fn creep_lags(runs: &[TrainingRecord]) -> Vec<Lag> {
    let (ts, longest) = (runs[0].record.ts(), runs.iter().map(|run| run.record.duration()).fold(0.0, f64::max));
    let (shortest, longest) = (POLICY.shortest_creep_lag * ts, POLICY.longest_creep_lag * longest);
    let steps = std::iter::successors(Some(shortest), |tau| Some(10f64.sqrt() * tau)).take_while(|tau| *tau <= longest);
    steps.map(|tau_s| Lag { tau_s, gain: 0.0 }).collect()
}
