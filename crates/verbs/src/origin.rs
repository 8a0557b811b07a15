//! The origin of a model, as its file states it in `fit`, and the repetition of its identification:
//!
//! ```json
//! {
//!   "command": "piezoid identify",
//!   "version": "0.1.0",
//!   "options": {"operator": "preisach"},
//!   "files": [
//!     {"role": "small_signal", "file": "prbs.csv", "sha256": "9f86..."},
//!     {"role": "large_signal", "file": "log.mat", "sha256": "5e88...", "columns": {"input_scale": "20"},
//!      "preparation": [{"prepare": {"decimate": 4}}], "steps": ["input scaled by 20", "decimated by 4 ..."]}
//!   ],
//!   "seed": 1
//! }
//! ```
//! A report thus needs only the model and the records. A reader of `fit` uses the members that it knows and ignores all
//! others. `options`, `columns` and `preparation` hold what differs from the defaults. `steps` are the history of the
//! record for people. The `command` is the front end, the only member in which front ends differ.

use super::{DataFile, Identification, Source, Step, short};
use crate::identification::{IdentifyOptions, Records};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::options::{Options, by_name};
use piezoid_numerics::progress::Progress;
use piezoid_numerics::system::System;
use piezoid_records::formats::ColumnSelection;
use piezoid_records::record::Record;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Where a record comes from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Origin {
    /// Name of its file, without folders; empty if it was in none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub file: String,
    /// Hash of the bytes of its file; empty if it was in none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sha256: String,
    /// How its columns are read.
    #[serde(with = "by_name", skip_serializing_if = "is_usual")]
    pub columns: ColumnSelection,
    /// Steps of its preparation, in their order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub preparation: Vec<Step>,
}

/// What a record of an identification is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Role {
    SmallSignal,
    LargeSignal,
}

/// A record of an identification, as its model states it.
#[derive(Serialize, Deserialize)]
pub(super) struct Training {
    role: Role,
    #[serde(flatten)]
    origin: Origin,
    /// The history of the record.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    steps: Vec<String>,
}

impl Training {
    /// Where the record comes from.
    pub(super) fn origin(&self) -> &Origin {
        &self.origin
    }

    /// The records of an identification in their order, with their origins as far as they are known.
    pub(super) fn all(records: Records, origins: &[Origin]) -> Vec<Training> {
        let roles = [(Role::SmallSignal, records.small_signal), (Role::LargeSignal, records.large_signal)];
        let records = roles.into_iter().flat_map(|(role, records)| records.iter().map(move |record| (role, record)));
        let one = |(k, (role, record)): (usize, (Role, &Record))| {
            let origin = origins.get(k).cloned().unwrap_or_default();
            Training { role, origin, steps: record.history().to_vec() }
        };
        records.enumerate().map(one).collect()
    }
}

fn is_usual(columns: &ColumnSelection) -> bool {
    *columns == ColumnSelection::default()
}

impl Origin {
    /// The origin of a record in a file of this name, whose bytes have this SHA-256.
    pub fn of(name: &str, sha256: String) -> Self {
        Origin { file: short(name).into(), sha256, ..Origin::default() }
    }

    /// The times of its file that the record has, from the first to the second [s].
    pub(super) fn times(&self) -> [f64; 2] {
        let whole = [self.columns.from.unwrap_or(0.0), self.columns.to.unwrap_or(f64::INFINITY)];
        let part = |[from, to]: [f64; 2], step: &Step| match step {
            Step::Part(a, b) => [from + a, b.map_or(to, |b| to.min(from + b))],
            _ => [from, to],
        };
        self.preparation.iter().fold(whole, part)
    }
}

/// The records that a model states to be identified from; `None` if it states none.
pub(super) fn training(model: &Model) -> Option<Vec<Training>> {
    Some(Recipe::of(model).ok()?.files)
}

/// What a model states of its identification.
#[derive(Deserialize)]
pub(super) struct Recipe {
    command: String,
    version: String,
    options: Value,
    files: Vec<Training>,
}

impl Recipe {
    /// # Errors
    /// Returns an error if the model does not state how it was identified.
    pub(super) fn of(model: &Model) -> Result<Self, Error> {
        Recipe::deserialize(model.provenance()).map_err(|e| {
            let why = "an older version wrote it, or another program than `identify`: identify it again";
            Error::Content(format!("the model does not state how it was identified ({e}): {why}"))
        })
    }

    /// # Errors
    /// Returns an error for options that are unknown.
    pub(super) fn options(&self) -> Result<IdentifyOptions, Error> {
        IdentifyOptions::from_json(self.options.clone())
    }
}

/// The names of the files that a model was identified from.
///
/// # Errors
/// Returns an error if the model does not state how it was identified, or if one of its records was in no file.
pub fn files_of(model: &Model) -> Result<Vec<String>, Error> {
    let origins = Recipe::of(model)?.files.into_iter().map(|one| one.origin);
    origins.map(|origin| if origin.sha256.is_empty() { Err(in_no_file()) } else { Ok(origin.file) }).collect()
}

fn in_no_file() -> Error {
    let why = "was identified from a record that was in no file";
    Error::Content(format!("the model {why}: repeat it in the program that has this record"))
}

/// The small-signal and the large-signal sources of a model, from its files in any order and under any names. A file
/// with an origin was derived from that one, and is used as it is.
///
/// # Errors
/// Returns an error if the model does not state how it was identified, or if one of its records was in no file, and if
/// a file is missing, differs, or was prepared in another way.
pub(super) fn sources_of(model: &Model, files: &[Source]) -> Result<(Vec<Source>, Vec<Source>), Error> {
    let training = Recipe::of(model)?.files;
    let origins: Vec<&Origin> = training.iter().map(|one| &one.origin).collect();
    let (mut small, mut large) = (Vec::new(), Vec::new());
    for (one, source) in training.iter().zip(sources(&origins, files)?) {
        if one.role == Role::SmallSignal { &mut small } else { &mut large }.push(source);
    }
    Ok((small, large))
}

/// Two models are the same but for rounding if their free runs differ by less [of the stroke].
const ROUNDING: f64 = 1e-6;

/// Identifies this model again, from its files in any order and under any names, with its own options. If it is not the
/// same to the bit, the notes of the result say how far the two are apart.
///
/// # Errors
/// Returns an error if the model does not state how it was identified, or if one of its records was in no file; if a
/// file is missing or differs; and if the result is another model. The errors of [`identify`](crate::identify).
pub fn identify_again(model: &Model, files: &[DataFile], progress: &mut Progress) -> Result<Identification, Error> {
    let recipe = Recipe::of(model)?;
    let files = &Source::all(files.to_vec(), &ColumnSelection::default());
    let mut again = recipe.options()?.run(sources_of(model, files)?, &recipe.command, progress)?;
    again.found = again.found.finished()?;
    if again.found.model != *model {
        let (small, large) = sources_of(model, files)?;
        let mut apart = small.iter().chain(&large).map(|source| apart(model, &again.found.model, &source.record()?));
        let apart = apart.try_fold(0.0, |most, one: Result<f64, Error>| Ok(f64::max(most, one?)))?;
        let this = env!("CARGO_PKG_VERSION");
        let versions = format!("identified by version {}; this is version {this}", recipe.version);
        if apart > ROUNDING {
            let percent = piezoid_numerics::number::short(100.0 * apart);
            let why = "it was changed since, or another version or machine identified it";
            return Err(Error::Content(format!(
                "the repeated identification gives another model: free runs on the training records differ by up \
                 to {percent} % of stroke ({versions}): {why}"
            )));
        }
        again.found.notes.push(format!(
            "the model is not the same to the bit ({versions}): free runs on the training records differ by up to \
             {apart:.1e} of stroke"
        ));
    }
    Ok(again)
}

/// The largest difference of the free runs of two models on a record, over the stroke.
fn apart(model: &Model, other: &Model, record: &Record) -> Result<f64, Error> {
    Record::same_sampling("the model", model.ts(), "the model identified again", other.ts())?;
    let (own, others) = (model.simulate(record.u()), other.simulate(record.u()));
    let (low, high) = piezoid_numerics::series::ends(own.iter().copied());
    let worst = own.iter().zip(&others).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // Where nothing moves, any difference is one.
    Ok(if worst == 0.0 { 0.0 } else { worst / (high - low) })
}

/// The sources of a model among these files, in the order of its origins.
fn sources(origins: &[&Origin], files: &[Source]) -> Result<Vec<Source>, Error> {
    let hash = |source: &Source| match &source.origin {
        Some(origin) => Ok(origin.sha256.clone()),
        None => source.file.sha256(),
    };
    let hashes = files.iter().map(hash).collect::<Result<Vec<String>, Error>>()?;
    let found = |origin: &&Origin| {
        if origin.sha256.is_empty() {
            return Err(in_no_file());
        }
        if let Some((source, _)) = files.iter().zip(&hashes).find(|(_, hash)| **hash == origin.sha256) {
            let file = source.file.clone().named(&origin.file);
            let Some(own) = &source.origin else {
                return Ok(Source::new(file, origin.columns.clone(), origin.preparation.clone()));
            };
            if (&own.columns, &own.preparation) != (&origin.columns, &origin.preparation) {
                let how = "is read or prepared in another way than when the model was identified from it";
                return Err(Error::Content(format!("{} {how}: identify the model again", origin.file)));
            }
            return Ok(Source { file, ..source.clone() });
        }
        let (name, hash) = (&origin.file, &origin.sha256);
        let named = files.iter().zip(&hashes).find(|(source, _)| short(&source.file.name) == name);
        Err(Error::Content(match named {
            Some((Source { file: DataFile { name, .. }, .. }, other)) => format!(
                "{name} is not the file that the model was identified from: its SHA-256 is {other}, but was {hash}: \
                 give the file as it was"
            ),
            None => format!("the model was identified from {name} (SHA-256 {hash}): give this file as well"),
        }))
    };
    let sources = origins.iter().map(found).collect::<Result<_, _>>()?;
    match files.iter().zip(&hashes).find(|(_, hash)| origins.iter().all(|origin| origin.sha256 != **hash)) {
        Some((Source { file: DataFile { name, .. }, .. }, _)) => {
            let names: Vec<&str> = origins.iter().map(|origin| &*origin.file).collect();
            let known = piezoid_numerics::number::join(&names);
            let why = format!("is none of the files that the model was identified from ({known}): leave it out");
            Err(Error::Content(format!("{name} {why}")))
        }
        None => Ok(sources),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::File;
    use piezoid_numerics::progress::Stage;
    use piezoid_records::preparation::PrepareOptions;
    use serde_json::json;

    /// A record of 4 Hz at 1 kHz, of a plant of this gain.
    fn file(name: &str, gain: f64) -> DataFile {
        let row = |k: i32| {
            let u = 20.0 * (0.025 * f64::from(k)).sin();
            format!("{},{u},{}\n", 1e-3 * f64::from(k), gain * u)
        };
        File::new(name, format!("t_s,u_V,y_um\n{}", (0..1000).map(row).collect::<String>())).into()
    }

    /// A model of `lab/a.csv`, scaled and decimated, and of `b.csv`.
    fn identified() -> Model {
        let scale = ColumnSelection { input_scale: Some("2".into()), ..ColumnSelection::default() };
        let decimate = PrepareOptions { decimate: Some(2), ..PrepareOptions::default() };
        let source = |file, columns| Source::new(file, columns, vec![Step::Prepare(decimate.clone())]);
        let data = [source(file("lab/a.csv", 0.5), scale), source(file("b.csv", 0.25), ColumnSelection::default())];
        let options = IdentifyOptions { operator: "proportional".into(), order: Some(1), ..IdentifyOptions::default() };
        options.run((Vec::new(), data.into()), "a program", &mut Stage::ignore).unwrap().found.model
    }

    fn again(model: &Model, files: &[DataFile]) -> Result<Identification, String> {
        identify_again(model, files, &mut Stage::ignore).map_err(|e| e.to_string())
    }

    #[test]
    fn a_model_states_what_repeats_it() {
        let model = identified();
        let fit = model.provenance();
        assert_eq!(fit["command"], "a program");
        assert_eq!(fit["options"], json!({"operator": "proportional", "order": 1}));
        let [a, b] = [0, 1].map(|k| &fit["files"][k]);
        assert_eq!((&a["file"], &a["role"]), (&json!("a.csv"), &json!("large_signal")));
        assert_eq!((&a["columns"], b.get("columns")), (&json!({"input_scale": "2"}), None));
        assert_eq!(b["preparation"], json!([{"prepare": {"decimate": 2}}]));
        assert_eq!(b["sha256"], file("", 0.25).sha256().unwrap());
        let steps = a["steps"].as_array().unwrap();
        assert!(steps.iter().any(|step| step.as_str().unwrap().contains("decimated")), "{steps:?}");
    }

    #[test]
    fn a_model_is_identified_again_to_the_bit() {
        let model = identified();
        let result = again(&model, &[file("renamed.csv", 0.25), file("a.csv", 0.5)]).unwrap();
        assert_eq!(result.found.model.to_json(), model.to_json());
        assert!(result.found.notes.iter().all(|note| !note.contains("to the bit")), "{:?}", result.found.notes);
    }

    #[test]
    fn the_file_that_differs_is_named() {
        let model = identified();
        let [a, b] = [file("a.csv", 0.5), file("b.csv", 0.25)];
        let text = |files: &[DataFile]| again(&model, files).unwrap_err();
        assert!(text(std::slice::from_ref(&a)).contains("identified from b.csv (SHA-256 "));
        let changed = text(&[a.clone(), file("lab/b.csv", 0.26)]);
        assert!(changed.starts_with("lab/b.csv is not the file"), "{changed}");
        let extra = text(&[a, b, file("c.csv", 1.0)]);
        assert!(extra.starts_with("c.csv is none of the files that the model was identified from (a.csv"), "{extra}");
    }

    #[test]
    fn a_file_that_was_derived_as_the_model_states_is_used_as_it_is() {
        let model = identified();
        let all = Recipe::of(&model).unwrap().files;
        let derived = |origin: Origin| {
            let part = Source::new(file("prepared.csv", 0.1), ColumnSelection::default(), Vec::new());
            let b = Source::new(file("b.csv", 0.25), ColumnSelection::default(), Vec::new());
            sources_of(&model, &[Source { origin: Some(origin), ..part }, b])
        };
        let (_, large) = derived(all[0].origin.clone()).unwrap();
        assert_eq!((large[0].file.name.as_str(), large[0].columns == ColumnSelection::default()), ("a.csv", true));
        assert_eq!(large[0].record().unwrap().len(), 1000, "not decimated again");
        let refused = derived(Origin { preparation: Vec::new(), ..all[0].origin.clone() }).unwrap_err().to_string();
        assert!(refused.starts_with("a.csv is read or prepared in another way"), "{refused}");
    }

    #[test]
    fn a_model_that_was_changed_is_not_repeated() {
        let files = [file("a.csv", 0.5), file("b.csv", 0.25)];
        let changed = |gain: f64| {
            let mut document: Value = serde_json::from_str(&identified().to_json()).unwrap();
            let b = document["linear"]["b"].as_array_mut().unwrap();
            b.iter_mut().for_each(|b| *b = json!(gain * b.as_f64().unwrap()));
            again(&Model::from_json(&document.to_string()).unwrap(), &files)
        };
        let refused = changed(1.1).unwrap_err();
        assert!(refused.contains("gives another model") && refused.contains("up to 4.545 %"), "{refused}");
        let notes = changed(1.0 + 1e-9).unwrap().found.notes;
        assert!(notes.iter().any(|note| note.starts_with("the model is not the same to the bit")), "{notes:?}");
    }

    #[test]
    fn models_that_do_not_state_their_files_are_refused() {
        let mut fit = identified().provenance().clone();
        fit["files"][1].as_object_mut().unwrap().remove("sha256");
        let of = |fit: Value| again(&identified().with_provenance(fit), &[file("a.csv", 0.5)]).unwrap_err();
        assert!(of(fit).contains("a record that was in no file"));
        assert!(of(Value::Null).contains("does not state how it was identified"));
        assert!(
            of(json!({"command": "piezoid identify a.csv", "version": "0.1.0", "files": []})).contains("`options`")
        );
    }
}
