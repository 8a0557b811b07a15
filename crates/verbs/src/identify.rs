//! Identification of a model from records in files.

use super::named::Named;
use super::origin::{Origin, Training};
use super::verdict::StatedVerdict;
use super::{Compared, Source, Verdict};
use crate::identification::{IdentifyOptions, Method, Records};
use piezoid_identification::Identified;
use piezoid_models::hammerstein::HiddenLoop;
use piezoid_models::linear::{Arx, PoleShare};
use piezoid_numerics::error::Error;
use piezoid_numerics::options::Options;
use piezoid_numerics::progress::Progress;
use piezoid_records::record::Record;
use piezoid_validation::{Linearity, Offset, Validate, ValidateOptions};
use serde_json::{Value, json};

/// A model, the other results of its identification, and its errors on the training data.
#[derive(Debug, Clone)]
pub struct Identification {
    /// The results of the identification; the model has its provenance.
    pub found: Identified,
    /// Its free runs on the large-signal records.
    pub training: Vec<Compared>,
    /// Linearity of each small-signal record; `None` if the record does not determine it.
    pub linearity: Vec<Option<Linearity>>,
}

impl IdentifyOptions {
    /// Identifies a model from the records of small-signal and of large-signal files, which are dropped once they are
    /// read. `command` is the name of the front end, for the model's file.
    ///
    /// # Errors
    /// Returns an error for files without records. The errors of [`identify`](crate::identify).
    pub fn run(
        &self,
        (small, large): (Vec<Source>, Vec<Source>),
        command: &str,
        progress: &mut Progress,
    ) -> Result<Identification, Error> {
        self.check()?;
        let (mut names, mut origins) = (Vec::new(), Vec::new());
        let mut read = |source: Source| {
            let (record, origin) = source.read()?;
            origins.push(origin);
            names.push(source.file.name);
            Ok(record)
        };
        let small_signal = small.into_iter().map(&mut read).collect::<Result<Vec<_>, Error>>()?;
        let large_signal = large.into_iter().map(&mut read).collect::<Result<Vec<_>, Error>>()?;
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let records = Records { small_signal: &small_signal, large_signal: &large_signal };
        let mut result = self.identify_and_validate(records, &names, (command, &origins), progress)?;
        let histories = names.iter().zip(small_signal.iter().chain(&large_signal));
        let steps =
            histories.flat_map(|(name, record)| record.history().iter().map(move |step| format!("{name}: {step}")));
        result.found.notes.splice(0..0, steps);
        Ok(result)
    }

    /// Identifies a model from records and tests it on them. `names` are those of the small-signal records, then of the
    /// large-signal records; the front end and the origins of the records, in this order, are for the model's file.
    ///
    /// # Errors
    /// The errors of [`identify`](crate::identify).
    pub fn identify_and_validate(
        &self,
        records: Records,
        names: &[&str],
        (command, origins): (&str, &[Origin]),
        progress: &mut Progress,
    ) -> Result<Identification, Error> {
        let named = Named { records, names };
        let mut found = records.identify(self, progress).map_err(|error| named.error(error))?;
        found.notes = found.notes.into_iter().map(|note| named.note(note)).collect();
        // The joint method fits a separate offset for each record.
        let offset = if self.method == Method::Joint { Offset::Free } else { Offset::Kept };
        let options = ValidateOptions { offset, ..ValidateOptions::default() };
        let compare = |(record, name): (&Record, &&str)| {
            let record = record.output_in(&found.model.units().y)?;
            let validation = found.model.validate_with(&record, &options)?;
            Ok(Compared::new((*name).into(), record, validation))
        };
        let Records { small_signal, large_signal } = records;
        let names = || names.iter().chain(std::iter::repeat(&"record"));
        let training: Vec<_> =
            large_signal.iter().zip(names().skip(small_signal.len())).map(compare).collect::<Result<_, Error>>()?;
        let verdict = match &training[..] {
            [] => {
                let small: Vec<_> = small_signal.iter().zip(names()).map(compare).collect::<Result<_, Error>>()?;
                Verdict::of_identified(&found, &small, &[])
            }
            large => Verdict::of_identified(&found, large, small_signal),
        };
        let linearity = small_signal.iter().map(|record| Linearity::of(record).ok()).collect();
        let fit = self.fit(&found, command, &Training::all(records, origins), verdict.as_ref());
        found.model = found.model.with_provenance(fit);
        Ok(Identification { found, training, linearity })
    }

    /// How a model was identified, for its file: what repeats it (see [`identify_again`](crate::identify_again)), the
    /// operators that were tried, the parameters with their errors, notes and verdict. A report needs these, and the
    /// blocks do not contain them.
    fn fit(&self, found: &Identified, command: &str, files: &[Training], verdict: Option<&Verdict>) -> Value {
        let version = env!("CARGO_PKG_VERSION");
        let options = self.to_json();
        let mut fit =
            json!({"command": command, "version": version, "options": options, "files": files, "seed": self.seed});
        let results = [
            ("trials", json!(found.trials)),
            ("parameters", json!(found.parameters)),
            ("notes", json!(found.remarks())),
            ("verdict", json!(verdict)),
        ];
        for (name, result) in results {
            if result != json!([]) && !result.is_null() {
                fit[name] = result;
            }
        }
        fit
    }
}

impl Identification {
    /// The results as a document.
    pub fn to_json(&self) -> Value {
        let (found, arx) = (&self.found, self.found.model.linear());
        json!({
            "linear": {
                "a": arx.a(),
                "b": arx.b(),
                "poles": arx.poles(),
                "zeros": arx.zeros(),
                "modal_form": modal_form(arx),
                "noise_gain": arx.noise_gain(),
                "reason": found.linear.reason,
                "residuals": found.linear.fit.as_ref().map(|f| f.residuals),
                "offsets": found.linear.fit.as_ref().map(|f| &f.offsets),
                "convergence": found.linear.fit.as_ref().map(|f| &f.history),
            },
            "operator": found.model.hysteresis().operator().name,
            "loops": found.loops.iter().map(HiddenLoop::to_json).collect::<Vec<_>>(),
            "trials": found.trials,
            "parameters": found.parameters,
            "creep": found.model.creep().lags(),
            "training": self.training.iter().map(Compared::to_json).collect::<Vec<_>>(),
            "notes": found.remarks(),
            "linearity": self.linearity,
            "verdict": self.found.model.verdict(),
        })
    }
}

/// The modal form of the linear block; null if it has no poles.
fn modal_form(arx: &Arx) -> Value {
    let form = arx.modal_form();
    let pole = |p: &PoleShare| {
        let unit = p.oscillator(1.0);
        json!({
            "kind": p.kind(),
            "hz": p.pole.hz,
            "damping": p.pole.damping,
            "share_percent": 100.0 * p.share,
            "mass_per_stiffness": unit.map(|o| o.mass),
            "damper_per_stiffness": unit.map(|o| o.damper),
        })
    };
    match form.poles.is_empty() {
        true => Value::Null,
        false => json!({
            "gain": form.gain,
            "delay_s": form.delay,
            "poles": form.poles.iter().map(pole).collect::<Vec<_>>(),
            "feed_through_percent": 100.0 * form.feed_through,
        }),
    }
}
