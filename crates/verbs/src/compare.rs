//! Several models on the same records, and methods that are identified from one split of them.

use super::methods::{Fitted, MethodOptions};
use super::split::Split;
use super::validate::{ValidateRecords, records};
use super::{File, Source, Validated, short};
use crate::identification::Records;
use piezoid_identification::Clock;
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::progress::Progress;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use piezoid_validation::ValidateOptions;
use serde_json::{Value, json};

options! {
    /// How to compare models.
    pub struct CompareOptions {
        /// The record whose loops and residuals are drawn; by default the first.
        record: Option<String> = None, OptionRow::new(OptionKind::Text("FILE"));
    } with validation: ValidateOptions with methods: MethodOptions
}

/// What is compared on one split.
#[derive(Debug, Clone, Default)]
pub struct Contest {
    /// Records to identify from, by their names; without `data`, their ends are held out for the comparison.
    pub training: Vec<(String, Record)>,
    /// Small-signal records, which are training data alone.
    pub small_signal: Vec<(String, Record)>,
    /// Other records to compare on.
    pub data: Vec<(String, Record)>,
    /// Models that exist.
    pub models: Vec<(String, Model)>,
    /// Free runs of other simulators.
    pub others: Vec<Other>,
}

/// A method outside piezoid, fitted to the training records of a [`Split`].
#[derive(Debug, Clone, PartialEq)]
pub struct Other {
    /// Its name.
    pub name: String,
    /// Its free runs over the whole records of the tests, or the reason why there are none.
    pub runs: Result<Vec<Vec<f64>>, String>,
    /// Number of its parameters, if it is known.
    pub parameters: Option<usize>,
    /// The times of its fit [s] and of a step of its free run [ns].
    pub times: Times,
}

/// Measured times: they differ from run to run, so no document and no figure holds them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Times {
    /// The fit, with a search that is shared with other methods [s].
    pub fit_s: Option<f64>,
    /// One sample of a free run [ns].
    pub step_ns: Option<f64>,
}

/// A method without free runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Failed {
    /// Its name.
    pub name: String,
    /// Why there are none.
    pub reason: String,
}

/// A model and its free runs.
#[derive(Debug, Clone)]
pub struct ComparedModel {
    /// Its name: that of its file, if it is one.
    pub name: String,
    /// The model; `None` for a simulator outside piezoid.
    pub model: Option<Model>,
    /// Number of all parameters of hysteresis, creep, linear block and offset, or of mechanics with hysteresis in
    /// feedback; of a simulator outside piezoid what it states.
    pub all_parameters: Option<usize>,
    /// Its free runs on the records.
    pub validated: Validated,
    /// Measured times.
    pub times: Times,
}

/// Models and their free runs on the same records.
#[derive(Debug, Clone)]
pub struct ModelComparison {
    /// The models, in the order given; with a split, by rising error.
    pub models: Vec<ComparedModel>,
    /// Number of the record whose loops and residuals are drawn.
    pub record: usize,
    /// The methods without free runs.
    pub failed: Vec<Failed>,
    /// What was fitted and what was compared, if methods were identified.
    pub split: Option<Split>,
    /// The [`Error::Cancelled`] that ended the work, if it was cancelled: the other methods were compared before.
    pub cancelled: Option<Error>,
}

impl CompareOptions {
    /// Compares models with the records in files, each record in the unit of the first.
    ///
    /// # Errors
    /// Returns an error for files without a model or a record. The errors of [`CompareOptions::on`].
    pub fn run(&self, models: &[File], data: Vec<Source>) -> Result<ModelComparison, Error> {
        self.on(named(models)?, &records(data)?)
    }

    /// Compares models in files with records in files: training records, small-signal records and records to compare
    /// on. Without methods to identify and without training records, it is [`CompareOptions::run`].
    ///
    /// # Errors
    /// Returns an error for files without a model or a record, if no model or no record is given, and the errors of
    /// [`CompareOptions::contest`].
    pub fn run_all(
        &self,
        (models, [training, small_signal, data]): (Vec<File>, [Vec<Source>; 3]),
        clock: Option<Clock>,
        progress: &mut Progress,
    ) -> Result<ModelComparison, Error> {
        if !self.methods.is_any() && training.is_empty() && small_signal.is_empty() {
            for (what, is_missing) in [("model", models.is_empty()), ("data", data.is_empty())] {
                if is_missing {
                    return Err(Error::Content(format!(
                        "compare takes 1 or more of the files `{what}`, but 0 are given"
                    )));
                }
            }
            return self.run(&models, data);
        }
        self.methods.check()?;
        let models = named(&models)?;
        let [training, small_signal, data] = [training, small_signal, data].map(records);
        let contest = Contest { training: training?, small_signal: small_signal?, data: data?, models, others: vec![] };
        self.contest(contest, clock, progress)
    }

    /// Compares named models with named records, each record in the unit of the first.
    ///
    /// # Errors
    /// Returns an error for an unknown record, and the errors of [`ValidateOptions::on`].
    pub fn on(&self, models: Vec<(String, Model)>, records: &[(String, Record)]) -> Result<ModelComparison, Error> {
        let record = self.drawn(records.iter().map(|(name, _)| &**name))?;
        let compare = |(name, model): (String, Model)| {
            let validated = self.validation.on(&model, records).map_err(|e| e.of(&name))?;
            Ok(ComparedModel::of(name, model, validated))
        };
        let models = models.into_iter().map(compare).collect::<Result<_, Error>>()?;
        Ok(ModelComparison { models, record, failed: Vec::new(), split: None, cancelled: None })
    }

    /// The number of the record that is drawn.
    fn drawn<'n>(&self, names: impl Iterator<Item = &'n str> + Clone) -> Result<usize, Error> {
        let Some(expected) = &self.record else { return Ok(0) };
        let known = || Error::unknown("record", expected, names.clone());
        names.clone().position(|name| name == expected || short(name) == expected).ok_or_else(known)
    }

    /// The split of the records of a contest. All that can be refused before the work is refused here.
    ///
    /// # Errors
    /// The errors of [`CompareOptions::contest`].
    pub fn split(&self, contest: &Contest) -> Result<Split, Error> {
        Ok(self.begin(contest)?.0)
    }

    /// The split, the number of the record that is drawn, and the names of the methods to identify.
    fn begin(&self, contest: &Contest) -> Result<(Split, usize, Vec<String>), Error> {
        self.methods.check()?;
        let split = Split::of(contest.training.clone(), contest.data.clone(), self.methods.held_out)?;
        split.check(&self.validation)?;
        let record = self.drawn(split.tests.iter().map(|test| &*test.name))?;
        let identified = self.methods.names()?;
        let models = contest.models.iter().map(|(name, _)| name);
        let names = models.chain(contest.others.iter().map(|other| &other.name));
        let names: Vec<&String> = names.chain(&identified).collect();
        if names.is_empty() {
            return Err(Error::Content("there is nothing to compare: give operators, structures or models".into()));
        }
        if let Some(twice) = names.iter().find(|name| names.iter().filter(|other| other == name).count() > 1) {
            return Err(Error::Content(format!("two methods are called {twice}: give one of them another name")));
        }
        if !identified.is_empty() && split.training.is_empty() && contest.small_signal.is_empty() {
            let remedy = "give records to identify from; those of `data` are only compared".into();
            return Err(Error::TooShort { what: "the list of training records".into(), have: 0, need: 1, remedy });
        }
        Ok((split, record, identified))
    }

    /// Identifies the methods of the options on one split, and compares them with models and free runs that exist. A
    /// method that fails has a reason in the result. If the work is cancelled, the result has what was compared until
    /// then. Without a `clock`, there are no times.
    ///
    /// # Errors
    /// Returns an error for unknown names and for two methods of one name, and the errors of [`Split::of`].
    pub fn contest(
        &self,
        contest: Contest,
        clock: Option<Clock>,
        progress: &mut Progress,
    ) -> Result<ModelComparison, Error> {
        let (split, record, identified) = self.begin(&contest)?;
        let Contest { small_signal, models, others, .. } = contest;
        let mut board =
            ModelComparison { models: Vec::new(), record, failed: Vec::new(), split: None, cancelled: None };
        for (name, model) in models {
            board.add(name, self.run_model(&split, model, None, clock));
        }
        for Other { name, runs, parameters: all_parameters, times } in others {
            let validated = runs.map_err(Error::Content).and_then(|runs| split.compared(runs, &self.validation));
            let row = |validated| ComparedModel { name: name.clone(), model: None, all_parameters, validated, times };
            board.add(name.clone(), validated.map(row));
        }
        if !identified.is_empty() {
            let own = |records: &[(String, Record)]| records.iter().map(|(_, one)| one.clone()).collect::<Vec<_>>();
            let (small, large) = (own(&small_signal), own(&split.training));
            let records = Records { small_signal: &small, large_signal: &large };
            let still = || 0.0;
            let mut finished = |Fitted { name, model, seconds }: Fitted| {
                board.add(name, model.and_then(|model| self.run_model(&split, model, Some(seconds), clock)));
            };
            match self.methods.identify(records, clock.unwrap_or(&still), progress, &mut finished) {
                Err(cancelled @ Error::Cancelled { .. }) => board.cancelled = Some(cancelled),
                other => other?,
            }
        }
        if let Some(cancelled) = &board.cancelled {
            let missing = identified.into_iter().filter(|name| !board.has(name));
            let reason = cancelled.to_string();
            board.failed.extend(missing.map(|name| Failed { name, reason: reason.clone() }).collect::<Vec<_>>());
        }
        let rank = |one: &ComparedModel| (one.error().is_nan(), one.error().abs());
        board.models.sort_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        Ok(ModelComparison { split: Some(split), ..board })
    }

    /// The free runs of a model on the tests of a split; its name is still empty.
    fn run_model(
        &self,
        split: &Split,
        model: Model,
        fit_s: Option<f64>,
        clock: Option<Clock>,
    ) -> Result<ComparedModel, Error> {
        let validated = split.validated(&model, &self.validation)?;
        let step_ns = clock.map(|clock| step_ns(&model, split.tests[0].record.u(), clock));
        let times = Times { fit_s: fit_s.filter(|_| clock.is_some()), step_ns };
        Ok(ComparedModel { times, ..ComparedModel::of(String::new(), model, validated) })
    }
}

/// The models in files, with names without folders if these tell the files apart.
fn named(models: &[File]) -> Result<Vec<(String, Model)>, Error> {
    let alone = |file: &File| models.iter().filter(|other| other.short() == file.short()).count() == 1;
    let named = |file: &File| {
        let name = if alone(file) { short(&file.name) } else { &file.name };
        Ok((name.to_string(), file.model()?))
    };
    models.iter().map(named).collect()
}

/// Number of models beside the best that a sentence names.
const MAX_NAMED: usize = 4;

/// Repetitions of a free run whose shortest time counts, and their smallest number of samples.
const REPETITIONS: usize = 3;
const TIMED_SAMPLES: usize = 10_000;

/// The time of a step of a free run [ns].
fn step_ns(model: &Model, u: &[f64], clock: Clock) -> f64 {
    let runs = TIMED_SAMPLES.div_ceil(u.len());
    let time = |_| {
        let start = clock();
        (0..runs).for_each(|_| drop(std::hint::black_box(model.simulate(u))));
        clock() - start
    };
    let least = (0..REPETITIONS).map(time).fold(f64::INFINITY, f64::min);
    1e9 * least / (runs * u.len()) as f64
}

impl ComparedModel {
    fn of(name: String, model: Model, validated: Validated) -> Self {
        let linear = model.linear();
        let creep = model.creep().lags().iter().filter(|lag| lag.gain != 0.0).count();
        let blocks = parameters(&model) + creep + linear.a().len() + linear.b().len();
        let all = 1 + model.feedback().map_or(blocks, |feedback| feedback.parameters().len());
        ComparedModel { name, model: Some(model), all_parameters: Some(all), validated, times: Times::default() }
    }

    /// Rms error of the free runs on all records [% of peak-to-peak].
    pub fn error(&self) -> f64 {
        self.validated.total().rms_pp_percent
    }

    /// Numbers that describe its hysteresis block; `None` without a model.
    pub fn parameters(&self) -> Option<usize> {
        self.model.as_ref().map(parameters)
    }

    /// Name of its operator; `None` without a model.
    pub fn operator(&self) -> Option<&'static str> {
        self.model.as_ref().map(|model| model.hysteresis().operator().name)
    }
}

/// Numbers that describe the hysteresis block of a model.
fn parameters(model: &Model) -> usize {
    fn numbers(value: &Value) -> usize {
        match value {
            Value::Number(_) => 1,
            Value::Array(values) => values.iter().map(numbers).sum(),
            Value::Object(members) => members.values().map(numbers).sum(),
            _ => 0,
        }
    }
    model.hysteresis().params().iter().filter(|(name, _)| *name != "range").map(|(_, v)| numbers(v)).sum()
}

impl ModelComparison {
    /// Adds the free runs of a method, or the reason why there are none.
    fn add(&mut self, name: String, compared: Result<ComparedModel, Error>) {
        match compared {
            Ok(compared) => self.models.push(ComparedModel { name, ..compared }),
            Err(why) => self.failed.push(Failed { name, reason: why.to_string() }),
        }
    }

    fn has(&self, name: &str) -> bool {
        self.models.iter().any(|one| one.name == name) || self.failed.iter().any(|one| one.name == name)
    }

    /// The model with the smallest error over all records; `None` if all errors are undefined.
    pub fn best(&self) -> Option<&ComparedModel> {
        let finite = self.models.iter().filter(|one| one.error().is_finite());
        finite.min_by(|a, b| a.error().total_cmp(&b.error()))
    }

    /// The comparison in one sentence; `None` if all errors are undefined.
    pub fn summary(&self) -> Option<String> {
        let best = self.best()?;
        let error = |one: &ComparedModel| piezoid_validation::rough(one.error());
        let others = self.models.iter().filter(|one| one.name != best.name);
        let mut others: Vec<String> = others.map(|one| format!("{} {} %", one.name, error(one))).collect();
        if others.len() > MAX_NAMED {
            let more = others.len() - MAX_NAMED + 1;
            others.truncate(MAX_NAMED - 1);
            others.push(format!("{more} others"));
        }
        let than = if others.is_empty() { String::new() } else { format!("; {}", others.join(", ")) };
        Some(format!("smallest error in free run: {}, {} % of stroke{than}", best.name, error(best)))
    }

    /// All results as a document.
    pub fn to_json(&self) -> Value {
        let one = |one: &ComparedModel| {
            let mut object = one.validated.to_json();
            object["model"] = json!(one.name);
            let model = one.model.as_ref();
            object["operator"] = json!(one.operator());
            object["parameters"] = json!(one.parameters());
            object["all_parameters"] = json!(one.all_parameters);
            object["order"] = json!(model.map(|model| model.linear().a().len()));
            object["ts"] = json!(model.map(System::ts));
            object["verdict"] = json!(model.map(|model| one.validated.verdict(model)));
            if let (None, Some(files)) = (model, object["files"].as_array_mut()) {
                files.iter_mut().for_each(|file| file["initial_condition"] = Value::Null);
            }
            object
        };
        let models: Vec<Value> = self.models.iter().map(one).collect();
        let failed = |one: &Failed| json!({"model": one.name, "reason": one.reason});
        let mut document =
            json!({"models": models, "best": self.best().map(|best| &best.name), "summary": self.summary()});
        if let Some(split) = &self.split {
            document["split"] = split.to_json();
            document["failed"] = self.failed.iter().map(failed).collect();
        }
        document
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::progress::Stage;
    use piezoid_records::formats::ColumnSelection;
    use std::sync::Arc;

    fn model(name: &str, gain: f64) -> File {
        let hysteresis = Arc::new(Proportional::new(1e-3, 1.0).unwrap());
        File::new(name, Model::new(hysteresis, Arx::gain(1e-3, gain).unwrap(), 0.0).unwrap().to_json())
    }

    fn record(name: &str, gain: f64) -> File {
        let row = |k: i32| {
            let u = 5.0 * (0.05 * f64::from(k)).sin();
            format!("{},{u},{}\n", f64::from(k) * 1e-3, gain * u)
        };
        File::new(name, format!("t_s,u_V,y_um\n{}", (0..600).map(row).collect::<String>()))
    }

    fn run(options: &CompareOptions, models: &[File]) -> Result<ModelComparison, Error> {
        let data = vec![record("x/a.csv", 2.0), record("x/b.csv", 3.0)];
        options.run(models, Source::all(data, &ColumnSelection::default()))
    }

    #[test]
    fn the_model_with_the_smaller_error_is_named() {
        let result = run(&CompareOptions::default(), &[model("f/two.json", 2.4), model("f/ten.json", 10.0)]).unwrap();
        assert_eq!(result.best().unwrap().name, "two.json");
        let text = result.summary().unwrap();
        assert!(text.starts_with("smallest error in free run: two.json, ") && text.contains("; ten.json "), "{text}");
        let json = result.to_json();
        assert_eq!((&json["best"], json["models"][1]["files"].as_array().unwrap().len()), (&"two.json".into(), 2));
        assert_eq!((&json["models"][0]["parameters"], &json["models"][0]["order"]), (&1.into(), &0.into()));
        assert_eq!(json["models"][0]["all_parameters"], 3, "a gain of each block and the offset");
    }

    #[test]
    fn files_of_one_name_keep_their_folders() {
        let result = run(&CompareOptions::default(), &[model("f/m.json", 2.0), model("g/m.json", 3.0)]).unwrap();
        assert_eq!(result.models.iter().map(|one| &*one.name).collect::<Vec<_>>(), ["f/m.json", "g/m.json"]);
    }

    #[test]
    fn a_record_is_chosen_by_its_name_and_an_unknown_one_refused() {
        let of =
            |name: &str| run(&CompareOptions { record: Some(name.into()), ..Default::default() }, &[model("m", 2.0)]);
        assert_eq!((of("x/b.csv").unwrap().record, of("b.csv").unwrap().record), (1, 1));
        let text = of("c.csv").unwrap_err().to_string();
        assert!(text.contains("`c.csv`") && text.contains("x/a.csv"), "{text}");
    }

    /// A record of the twin `pl140`: a modulated sine, which reaches its largest amplitude early.
    fn twin(seconds: u32) -> (String, Record) {
        let u = |t: u32| 28.0 * (0.025 * f64::from(t)).sin() * (0.0067 * f64::from(t)).sin();
        let u: Vec<f64> = (0..1000 * seconds).map(u).collect();
        let y = piezoid_twins::Plant::named("pl140", 1e-3).unwrap().run(&u).y;
        ("twin".into(), Record::new(1e-3, u, y).unwrap())
    }

    fn methods(operators: &str, structures: &str) -> CompareOptions {
        let effort = piezoid_identification::Effort::Quick;
        let (operators, structures) = (Some(operators.into()), Some(structures.into()));
        let methods = MethodOptions { operators, structures, effort, ..MethodOptions::default() };
        CompareOptions { methods, ..CompareOptions::default() }
    }

    fn names(board: &ModelComparison) -> Vec<&str> {
        let mut names: Vec<&str> = board.models.iter().map(|one| &*one.name).collect();
        names.sort_unstable();
        names
    }

    #[test]
    fn each_operator_and_structure_has_a_row_and_the_selected_one_is_what_identify_finds() {
        let contest = Contest { training: vec![twin(3)], ..Contest::default() };
        let options = methods("stop,prandtl-ishlinskii,auto", "hammerstein,no-creep,order-1,linear");
        let clock = || 0.0;
        let run = || options.contest(contest.clone(), Some(&clock), &mut Stage::ignore).unwrap();
        let board = run();
        let all = ["auto", "linear", "no-creep", "order-1", "prandtl-ishlinskii", "stop"];
        assert_eq!(names(&board), all, "{:?}", board.failed);
        assert_eq!(board.to_json().to_string(), run().to_json().to_string(), "the same each time");
        let of = |name: &str| board.models.iter().find(|one| one.name == name).unwrap();
        assert_eq!(of("order-1").model.as_ref().unwrap().linear().a().len(), 1);
        assert!(of("no-creep").model.as_ref().unwrap().creep().lags().is_empty());
        let error = |name: &str| of(name).validated.total().rms_pp_percent;
        assert!(error("prandtl-ishlinskii") < 0.5 * error("linear"), "{}", error("prandtl-ishlinskii"));
        // The search is that of `identify` on the training part.
        let split = options.split(&contest).unwrap();
        let usual = crate::IdentifyOptions { effort: options.methods.effort, ..crate::IdentifyOptions::default() };
        let alone = crate::identify(&[split.training[0].1.clone()], &usual).unwrap().model;
        assert_eq!(of("auto").model.as_ref(), Some(&alone));
        assert_eq!((of("auto").validated.total().n, board.best().unwrap().name.is_empty()), (750, false));
    }

    #[test]
    fn a_method_that_fails_has_the_reason_and_the_others_are_compared() {
        let other = |name: &str, runs| Other { name: name.into(), runs, parameters: Some(3), times: Times::default() };
        let (name, record) = twin(2);
        let y = record.y().to_vec();
        let others = vec![
            other("true", Ok(vec![y.clone()])),
            other("short", Ok(vec![y[1..].to_vec()])),
            other("diverges", Ok(vec![vec![f64::NAN; y.len()]])),
            other("none", Err("it raised".into())),
        ];
        let contest = Contest { training: vec![(name, record)], others, ..Contest::default() };
        let board = methods("proportional", "hammerstein").contest(contest, None, &mut Stage::ignore);
        let board = board.unwrap();
        assert_eq!((names(&board), board.best().unwrap().name.as_str()), (vec!["proportional", "true"], "true"));
        let reasons = board.failed.iter().map(|one| format!("{}: {}", one.name, one.reason)).collect::<Vec<_>>();
        let starts = ["short: twin: the free run has 1999 samples", "diverges: twin: the free run is NaN at sample 0"];
        assert!(starts.iter().zip(&reasons).all(|(start, reason)| reason.starts_with(start)), "{reasons:?}");
        assert_eq!(reasons[2], "none: it raised");
        assert_eq!(
            (board.to_json()["failed"][2]["reason"].as_str(), board.models[0].times.step_ns),
            (Some("it raised"), None)
        );
    }

    #[test]
    fn a_cancelled_comparison_has_what_was_compared_until_then() {
        let contest = Contest { training: vec![twin(2)], ..Contest::default() };
        let options = methods("proportional,stop,prandtl-ishlinskii", "linear,hammerstein");
        let mut has_linear = false;
        let board = options.contest(contest, None, &mut |stage: Stage| {
            has_linear |= stage.what == "stop";
            if has_linear { std::ops::ControlFlow::Break(()) } else { std::ops::ControlFlow::Continue(()) }
        });
        let board = board.unwrap();
        assert!(board.cancelled.is_some());
        let all = board.models.len() + board.failed.len();
        assert_eq!((all, board.failed.iter().all(|one| one.reason.contains("cancelled"))), (4, true));
    }

    #[test]
    fn unknown_names_and_methods_of_one_name_are_refused_before_the_work() {
        let contest = || Contest { training: vec![twin(2)], ..Contest::default() };
        let refused = |options: CompareOptions, contest: Contest| {
            options.contest(contest, None, &mut |_| panic!("no work")).map(|_| ()).unwrap_err().to_string()
        };
        assert!(refused(methods("preisac", "hammerstein"), contest()).contains("did you mean `preisach`"));
        assert!(refused(methods("stop", "hammerstien"), contest()).contains("did you mean `hammerstein`"));
        assert!(refused(methods("stop", "order-13"), contest()).contains("from 0 to 12"));
        assert!(refused(methods("stop,-stop", "hammerstein"), contest()).contains("leaves no operator"));
        let runs = Ok(vec![vec![0.0; 2000]]);
        let others = vec![Other { name: "stop".into(), runs, parameters: None, times: Times::default() }];
        let twice = refused(methods("stop", "hammerstein"), Contest { others, ..contest() });
        assert!(twice.contains("two methods are called stop"), "{twice}");
        let none = Contest { data: vec![twin(2)], ..Contest::default() };
        assert!(refused(methods("stop", "hammerstein"), none).contains("the list of training records"));
    }
}
