//! The plant of a verb: a twin by name, a file, or a stand-in for the actuator of the model.

use super::lists;
use super::prelude::*;
use crate::values::Ended::Misused;
use piezoid::control::SimulatedActuator;
use piezoid::formats::ColumnSelection;
use piezoid_verbs::{Source, files_of, stand_in_from};

/// The name that stands for a stand-in.
const RECORDS: &str = "records";

/// The records of the model, for a stand-in.
#[derive(Args)]
pub(super) struct RecordsOfModel {
    /// The records that the model was identified from, for --plant records [default: those that the model names, in
    /// this folder or in that of the model].
    #[arg(long, value_name = "FILE", num_args = 1..)]
    records: Vec<PathBuf>,
}

impl RecordsOfModel {
    /// The plant called `name` and its name without folders: `records` is a stand-in, made of the records of the model
    /// at `path`.
    ///
    /// # Errors
    /// Returns an error for an unknown name, records that are missing or differ, and a second model that cannot be
    /// identified.
    pub(super) fn plant(&self, name: &str, path: &Path, console: &Console) -> Result<(String, SimulatedActuator)> {
        if name != RECORDS {
            if !self.records.is_empty() {
                bail!(Misused("--records has no effect without --plant records".into()));
            }
            let short = Path::new(name).file_name().and_then(|name| name.to_str()).unwrap_or(name);
            return Ok((short.into(), lists::plant(name)?));
        }
        let model = files::read(path)?.model().map_err(failed)?;
        let named = || -> Result<Vec<PathBuf>> {
            let place = |name: String| {
                let beside = path.with_file_name(&name);
                if Path::new(&name).exists() { PathBuf::from(name) } else { beside }
            };
            Ok(files_of(&model).map_err(|e| failed(e.of(&path.to_string_lossy())))?.into_iter().map(place).collect())
        };
        let records = if self.records.is_empty() { named()? } else { self.records.clone() };
        let records = Source::all(files::all(&records, files::data)?, &ColumnSelection::default());
        let found = console.work(|progress| stand_in_from(&model, &records, progress))?;
        console.remarks([found.to_string()]);
        Ok(("stand-in".into(), found.into()))
    }

    /// The same where only a stand-in needs the model.
    ///
    /// # Errors
    /// Returns an error for a stand-in without a model, and those of [`plant`](Self::plant).
    pub(super) fn plant_of(
        &self,
        name: &str,
        model: Option<&Path>,
        console: &Console,
    ) -> Result<(String, SimulatedActuator)> {
        match model {
            None if name == RECORDS => bail!(Misused(format!("--plant {RECORDS} needs the model of the actuator"))),
            model => self.plant(name, model.unwrap_or(Path::new("")), console),
        }
    }

    /// Returns an error for a model that nothing but a stand-in could need, if the plant is another one.
    pub(super) fn needed(name: &str, model: Option<&Path>) -> Result<()> {
        match model {
            Some(model) if name != RECORDS => {
                let model = model.display();
                bail!(Misused(format!("the model {model} has no effect without --plant {RECORDS}")))
            }
            _ => Ok(()),
        }
    }

    /// The same for a plant that may be left out.
    pub(super) fn some_plant(
        &self,
        name: Option<&str>,
        model: Option<&Path>,
        console: &Console,
    ) -> Result<Option<(String, SimulatedActuator)>> {
        match name {
            None if self.records.is_empty() => Ok(None),
            None => bail!(Misused("--records has no effect without --plant records".into())),
            Some(name) => self.plant_of(name, model, console).map(Some),
        }
    }
}
