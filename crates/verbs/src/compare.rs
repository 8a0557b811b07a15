//! Several models on the same records.

use super::validate::{ValidateRecords, records};
use super::{File, Source, Validated, short};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::system::System;
use piezoid_records::record::Record;
use piezoid_validation::ValidateOptions;
use serde_json::{Value, json};

options! {
    /// How to compare models.
    pub struct CompareOptions {
        /// The record whose loops and residuals are drawn; by default the first.
        record: Option<String> = None, OptionRow::new(OptionKind::Text("FILE"));
    } with validation: ValidateOptions
}

/// A model and its free runs.
#[derive(Debug, Clone)]
pub struct ComparedModel {
    /// Its name: that of its file, if it is one.
    pub name: String,
    /// The model.
    pub model: Model,
    /// Its free runs on the records.
    pub validated: Validated,
}

/// Models and their free runs on the same records.
#[derive(Debug, Clone)]
pub struct ModelComparison {
    /// The models, in the order given.
    pub models: Vec<ComparedModel>,
    /// Number of the record whose loops and residuals are drawn.
    pub record: usize,
}

impl CompareOptions {
    /// Compares models with the records in files, each record in the unit of the first.
    ///
    /// # Errors
    /// Returns an error for files without a model or a record. The errors of [`CompareOptions::on`].
    pub fn run(&self, models: &[File], data: Vec<Source>) -> Result<ModelComparison, Error> {
        // Names without folders, if these tell the files apart.
        let alone = |file: &File| models.iter().filter(|other| other.short() == file.short()).count() == 1;
        let named = |file: &File| {
            let name = if alone(file) { short(&file.name) } else { &file.name };
            Ok((name.to_string(), file.model()?))
        };
        self.on(models.iter().map(named).collect::<Result<_, Error>>()?, &records(data)?)
    }

    /// Compares named models with named records, each record in the unit of the first.
    ///
    /// # Errors
    /// Returns an error for an unknown record, and the errors of [`ValidateOptions::on`].
    pub fn on(&self, models: Vec<(String, Model)>, records: &[(String, Record)]) -> Result<ModelComparison, Error> {
        let record = match &self.record {
            None => 0,
            Some(expected) => {
                let known = || Error::unknown("record", expected, records.iter().map(|(name, _)| &**name));
                records.iter().position(|(name, _)| name == expected || short(name) == expected).ok_or_else(known)?
            }
        };
        let compare = |(name, model): (String, Model)| {
            let validated = self.validation.on(&model, records).map_err(|e| e.of(&name))?;
            Ok(ComparedModel { name, model, validated })
        };
        Ok(ModelComparison { models: models.into_iter().map(compare).collect::<Result<_, Error>>()?, record })
    }
}

impl ComparedModel {
    /// Numbers that describe its hysteresis block.
    pub fn parameters(&self) -> usize {
        fn numbers(value: &Value) -> usize {
            match value {
                Value::Number(_) => 1,
                Value::Array(values) => values.iter().map(numbers).sum(),
                Value::Object(members) => members.values().map(numbers).sum(),
                _ => 0,
            }
        }
        self.model.hysteresis().params().iter().filter(|(name, _)| *name != "range").map(|(_, v)| numbers(v)).sum()
    }
}

impl ModelComparison {
    /// The model with the smallest error over all records; `None` if all errors are undefined.
    pub fn best(&self) -> Option<&ComparedModel> {
        let error = |one: &ComparedModel| one.validated.total().rms_pp_percent;
        let finite = self.models.iter().filter(|one| error(one).is_finite());
        finite.min_by(|a, b| error(a).total_cmp(&error(b)))
    }

    /// The comparison in one sentence; `None` if all errors are undefined.
    pub fn summary(&self) -> Option<String> {
        let best = self.best()?;
        let error = |one: &ComparedModel| piezoid_validation::rough(one.validated.total().rms_pp_percent);
        let others = self.models.iter().filter(|one| one.name != best.name);
        let others: Vec<String> = others.map(|one| format!("{} {} %", one.name, error(one))).collect();
        let than = if others.is_empty() { String::new() } else { format!("; {}", others.join(", ")) };
        Some(format!("smallest error in free run: {}, {} % of stroke{than}", best.name, error(best)))
    }

    /// All results as a document.
    pub fn to_json(&self) -> Value {
        let one = |one: &ComparedModel| {
            let mut object = one.validated.to_json();
            object["model"] = json!(one.name);
            object["operator"] = json!(one.model.hysteresis().operator().name);
            object["parameters"] = json!(one.parameters());
            object["order"] = json!(one.model.linear().a().len());
            object["ts"] = json!(one.model.ts());
            object["verdict"] = json!(one.validated.verdict(&one.model));
            object
        };
        let models: Vec<Value> = self.models.iter().map(one).collect();
        json!({"models": models, "best": self.best().map(|best| &best.name), "summary": self.summary()})
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
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
}
